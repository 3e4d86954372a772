//! Metrics of a trace and of several.

use powergs_core::sim::statistics::catalogue;
use powergs_study::sweep::metric::{metrics, values};
use powergs_study::sweep::unit::Unit;
use proptest::prelude::*;

use super::outcome;

fn get(row: &[Option<f64>], name: &str) -> f64 {
    let place = metrics().iter().position(|m| m.name == name);
    row[place.unwrap_or_else(|| panic!("no metric {name}"))].unwrap()
}

#[test]
fn names_are_unique_and_defined() {
    let mut names: Vec<&str> = metrics().iter().map(|m| m.name.as_str()).collect();
    for metric in metrics() {
        assert!(!metric.definition.is_empty() && !metric.unit.is_empty(), "{metric:?}");
    }
    names.sort_unstable();
    let all = names.len();
    names.dedup();
    assert_eq!(names.len(), all);
    for wanted in ["energy_pj.mean", "area_mm2", "fps.mean", "frame_time_ms.p99", "power_w.mean"] {
        assert!(names.contains(&wanted), "{wanted}");
    }
}

/// The one table of endings says of every metric and statistic what the catalogue says.
#[test]
fn names_end_in_their_unit() {
    let metrics = metrics().iter().map(|m| (m.name.as_str(), m.unit));
    let statistics = catalogue().iter().map(|s| (s.name.as_str(), s.unit));
    for (name, unit) in metrics.chain(statistics) {
        match Unit::of_column(name) {
            Some(found) => assert_eq!(found.name(), unit, "{name}"),
            // A part that is only its unit says it in words.
            None => assert!(unit == "1" || name.ends_with(".cycles"), "{name}: {unit}"),
        }
    }
}

#[test]
fn one_trace() {
    let o = outcome(&[4.0, 1.0, 2.0, 1.0]);
    let row = values(&[(3.0, &o)]);
    assert_eq!(get(&row, "frames"), 4.0);
    assert_eq!(get(&row, "frame_time_ms.mean"), 2.0);
    assert_eq!(get(&row, "frame_time_ms.p50"), 1.0);
    assert_eq!(get(&row, "frame_time_ms.p99"), 4.0);
    assert_eq!(get(&row, "frame_time_ms.max"), 4.0);
    assert_eq!(get(&row, "fps.mean"), 500.0);
    assert_eq!(get(&row, "fps.min"), 250.0);
    assert_eq!(get(&row, "energy_pj.mean"), 20.0);
    assert_eq!(get(&row, "edp_pj_s"), 20.0 * 2e-3);
}

#[test]
fn the_mean_of_traces_is_weighted_and_its_rate_is_of_the_mean_time() {
    let (a, b) = (outcome(&[1.0]), outcome(&[3.0, 3.0, 3.0]));
    let row = values(&[(3.0, &a), (1.0, &b)]);
    assert_eq!(get(&row, "frames"), 4.0);
    assert_eq!(get(&row, "frame_time_ms.mean"), 1.5);
    assert!((get(&row, "fps.mean") - 1000.0 / 1.5).abs() < 1e-9);
    // The only frame of `a` has three quarters of the weight.
    assert_eq!(get(&row, "frame_time_ms.p50"), 1.0);
    assert_eq!(get(&row, "frame_time_ms.p95"), 3.0);
}

#[test]
fn what_a_trace_does_not_have_is_absent() {
    let (a, mut b) = (outcome(&[1.0]), outcome(&[1.0]));
    b.means.iter_mut().for_each(|m| *m = None);
    let row = values(&[(1.0, &a), (1.0, &b)]);
    let place = |name: &str| metrics().iter().position(|m| m.name == name).unwrap();
    assert_eq!(row[place("energy_pj.mean")], None);
    assert_eq!(row[place("edp_pj_s")], None);
    assert_eq!(row[place("energy_pj.p50")], Some(10.0));
}

proptest! {
    /// With equal weights per frame a quantile is the nearest rank of all frames together.
    #[test]
    fn quantiles_are_nearest_ranks(
        traces in proptest::collection::vec(proptest::collection::vec(1u32..50, 1..30), 1..4),
    ) {
        let times = |t: &[u32]| t.iter().map(|&x| f64::from(x)).collect::<Vec<_>>();
        let outcomes: Vec<_> =
            traces.iter().map(|t| (t.len() as f64, outcome(&times(t)))).collect();
        let weighted: Vec<_> = outcomes.iter().map(|(w, o)| (*w, o)).collect();
        let row = values(&weighted);
        let mut all: Vec<u32> = traces.concat();
        all.sort_unstable();
        for (ending, percent) in [("p50", 50), ("p95", 95), ("p99", 99), ("max", 100)] {
            let rank = (all.len() * percent).div_ceil(100).max(1) - 1;
            prop_assert_eq!(get(&row, &format!("frame_time_ms.{ending}")), f64::from(all[rank]));
        }
    }
}
