//! The example of a unit of one's own: it replays, its accounts close, and its rule counts.

use std::path::Path;

use powergs_sim::flow::tile_wise::{UnitRule, register};
use powergs_sim::kernel::Unit;
use powergs_sim::run::files::DiskFiles;
use powergs_sim::run::{RunError, Session, Subject, System, SystemSpec, TraceFile};
use powergs_sim::sim::FrameReport;
use powergs_sim::stage::{Does, hardware, stage_id};

use crate::example_unit as example;
use crate::registered;

const DEMO: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");

#[test]
fn another_vru_rule_is_replayed_beside_the_built_in_one() {
    registered();
    let both = example::replay_both(Path::new(DEMO), "gscore-powergs");
    let [built_in, own] = both.expect("it replays");
    assert!(!own.is_empty() && own.len() == built_in.len());
    for (built_in, own) in built_in.iter().zip(&own) {
        let busy = |report: &FrameReport| {
            report.timing().expect("a simulated machine").unit(stage_id("vru")).map(|u| u.busy)
        };
        assert!(busy(own) < busy(built_in), "two pairs together");
        assert!(own.frame_time_s() <= built_in.frame_time_s());
        for (action, does) in hardware().actions() {
            // Who is done sooner is clocked for fewer cycles.
            let (own, built_in) = (own.actions.total(action), built_in.actions.total(action));
            let clock = matches!(does, Does::Clock(_) | Does::IdleClock(_));
            assert!(clock || own == built_in, "{does:?}: it does the same work");
        }
    }
}

/// The built-in rule of every unit, by the way that a user's rule takes.
struct Same;

impl<U: Unit> UnitRule<U> for Same {
    fn name(&self) -> &str {
        "same"
    }
}

/// A rule that takes no time.
struct Nothing;

impl<U: Unit> UnitRule<U> for Nothing {
    fn name(&self) -> &str {
        "nothing"
    }

    fn cycles(&self, _: &U, _: &U::Work) -> u64 {
        0
    }
}

/// Registers the rules of these tests.
pub fn register_rules() {
    use powergs_sim::flow::tile_wise::{bsu::Bsu, ccu::Ccu, qsu::Qsu, vru::Vru};
    register(example::DualIssue).expect("nobody has it");
    register::<Ccu>(Same).expect("nobody has it");
    register::<Qsu>(Same).expect("nobody has it");
    register::<Bsu>(Same).expect("nobody has it");
    register::<Vru>(Same).expect("nobody has it");
    register::<Vru>(Nothing).expect("nobody has it");
    assert!(register::<Vru>(Same).is_err(), "it is there");
}

fn with(machine: &str, sets: &[&str]) -> Result<System, RunError> {
    let sets = sets.iter().map(|set| (*set).to_owned()).collect();
    System::load(&SystemSpec { sets, ..SystemSpec::named(machine) }, &DiskFiles)
}

fn replay(systems: &[&System]) -> Result<Vec<Vec<FrameReport>>, RunError> {
    let mut trace = TraceFile::open(Path::new(DEMO))?;
    let subjects: Vec<Subject> = systems.iter().map(|system| Subject::of(system)).collect();
    let push = |reports: &mut Vec<FrameReport>, view: powergs_sim::run::FrameView<'_>| {
        reports.push(view.report);
    };
    Ok(Session::new(&mut trace, &()).fold(&subjects, |_| Vec::new(), push)?.states)
}

#[test]
fn rules_that_equal_the_built_in_ones_give_the_same_reports() {
    registered();
    for machine in ["gscore", "neo"] {
        let built_in = System::named(machine).expect("it comes with the program");
        let all = ["rules.ccu=same", "rules.qsu=same", "rules.bsu=same", "rules.vru=same"];
        let own = with(machine, &all).expect("they are registered");
        assert_ne!(own.timing_id(), built_in.timing_id(), "another rule by name");
        assert_ne!(own.id(), built_in.id());
        let same = replay(&[&built_in, &own]).expect("it replays");
        assert_eq!(same[0], same[1], "{machine}");
        let changed = own.with(&[powergs_sim::run::Change::machine("vru.cores", 2)]);
        let changed = changed.expect("two cores are fine");
        assert_eq!(
            changed.machine().tiles().rules.names().len(),
            4,
            "changes of keys keep the rules"
        );
    }
}

#[test]
fn a_rule_that_breaks_its_contract_is_no_internal_error() {
    registered();
    let unknown = with("gscore", &["rules.vru=nothin"]).expect_err("no such rule").message();
    assert!(unknown.contains("did you mean \"nothing\"?"), "{unknown}");
    let nothing = with("gscore", &["rules.vru=nothing"]).expect("it is registered");
    let error = replay(&[&nothing]).expect_err("a refusal");
    assert!(matches!(error, RunError::Incompatible { .. }), "{error}");
    assert!(error.message().contains("rule `nothing` of the vru returns 0 cycles"), "{error}");
}
