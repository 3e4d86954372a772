//! The spelling of roles.

use powergs_optimize::role::{Baseline, Role, RoleKind};

#[test]
fn every_role_is_read_as_it_is_written() {
    let plain = [Role::Dense, Role::HeldOut, Role::Sample, Role::Optimum];
    let others =
        [Role::External(3), Role::Sweep(0.005), Role::Baseline(Baseline::LightGaussian(7))];
    for role in plain.into_iter().chain(others).chain(Baseline::ALL.map(Role::Baseline)) {
        assert_eq!(role.name().parse(), Ok(role));
        assert_eq!(role.kind().name().parse(), Ok(role.kind()));
        let json = serde_json::to_string(&role).unwrap();
        assert_eq!(json, format!("\"{role}\""));
        assert_eq!(serde_json::from_str::<Role>(&json).unwrap(), role);
    }
    // As older results have it.
    assert_eq!("held_out".parse(), Ok(RoleKind::HeldOut));
    let unknown = "rendr-only".parse::<Role>().unwrap_err();
    assert_eq!(unknown.to_string(), "`rendr-only` is not a role of a model");
}

#[test]
fn names_of_jobs_are_reserved() {
    for name in ["dense", "optimum", "held-out", "sample-01", "lambda-x", "lightgs-66", "two-stage"]
    {
        assert!(Role::reserves(name), "{name}");
    }
    for name in ["mini", "sample", "external-1", "lightgs-65", "denser"] {
        assert!(!Role::reserves(name), "{name}");
    }
}
