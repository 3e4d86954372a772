//! Sensitivity experiments on frames in memory: every outcome is what replaying the changed machine
//! by itself gives.

use powergs_base::config::knob;
use powergs_core::run::{Change, FileKind, Frames, MemoryFrames, RunError, Session, System, Watch};
use powergs_core::sim::FrameReport;
use powergs_study::findings::cost::Cost;
use powergs_study::findings::sensitivity::interactions::Results;
use powergs_study::sensitivity::{
    AssumptionStudy, InteractionStudy, KeySelection, KeyStudy, Method,
};

use crate::frames;

const FPS: f64 = 60.0;

/// With the memory that is simulated fastest: what is compared is the way, not the model.
fn machine() -> System {
    let flat = "dram.model=bandwidth".parse().expect("a change");
    System::named("gscore").and_then(|system| system.with(&[flat])).expect("a machine")
}

/// Two lists of different length, so that means over frames and over lists differ.
fn lists() -> Vec<MemoryFrames> {
    vec![frames(2), frames(1)]
}

fn changed(base: &System, file: &str, key: &str, value: &str) -> System {
    let file = FileKind::ALL.into_iter().find(|kind| kind.role() == file).expect("a kind of file");
    let change = Change { file, path: key.to_owned(), value: knob::written(value) };
    base.with(&[change]).unwrap_or_else(|e| panic!("{key}={value}: {e}"))
}

/// What a machine costs by itself, by list.
fn alone(system: &System) -> Vec<Cost> {
    let outcome = |mut list: MemoryFrames| {
        let reports = Session::new(&mut list, &()).reports(std::slice::from_ref(system));
        let reports: Vec<FrameReport> = reports.expect("reports").remove(0);
        Cost::of_frames(&reports, FPS)
    };
    lists().into_iter().map(outcome).collect()
}

fn selection(text: &str) -> KeySelection {
    text.parse().expect("a selection")
}

#[test]
fn assumptions_move_what_the_changed_machines_do() {
    let system = machine();
    let study = AssumptionStudy { system: &system, only: &[1, 4, 14, 27], display_fps: FPS };
    let found = study.run(&mut lists(), &()).expect("no error").expect("frames");
    assert_eq!(
        found.traces.iter().map(|t| (t.frames, t.asked)).collect::<Vec<_>>(),
        [(2, 2), (1, 1)]
    );
    assert_eq!(found.traces.iter().map(|t| t.base).collect::<Vec<_>>(), alone(&system));
    let mut compared = 0;
    for row in &found.rows {
        let [key] = &row.keys[..] else { continue };
        if row.on.is_some() || !row.with.is_empty() {
            continue;
        }
        assert_eq!(row.base, alone(&system), "{}", row.number);
        for side in [&row.low, &row.high].into_iter().flatten() {
            let Ok(outcomes) = &side.outcomes else { continue };
            assert_eq!(*outcomes, alone(&changed(&system, row.file, key, &side.value)), "{key}");
            compared += 1;
        }
    }
    assert!(compared >= 4, "{:?}", found.rows);
    assert!(found.rows.is_sorted_by(|a, b| a.effect() >= b.effect()));
    assert!(found.fixed.iter().any(|fixed| fixed.number == "A14"), "{:?}", found.fixed);
}

#[test]
fn keys_move_what_the_changed_machines_do() {
    let system = machine();
    let keys = [selection("vru.*"), selection("clock")];
    let study =
        KeyStudy { system: &system, keys: &keys, step: 0.1, display_fps: FPS, interactions: None };
    let found = study.run(&mut lists(), &()).expect("no error").expect("frames");
    assert!(found.interactions.is_none());
    let rows = &found.keys.rows;
    assert!(rows.iter().any(|row| row.key == "clock") && rows.len() > 2);
    let mut compared = 0;
    for row in rows {
        assert_eq!(row.base, alone(&system));
        for perturbed in &row.perturbations {
            let Ok(outcomes) = &perturbed.outcomes else { continue };
            assert_eq!(*outcomes, alone(&changed(&system, row.file, &row.key, &perturbed.value)));
            compared += 1;
        }
    }
    assert!(compared > 8, "{compared}");
}

#[test]
fn points_of_a_morris_sample_are_the_machines_that_they_name() {
    let system = machine();
    let keys = ["vru.cores=2..8", "gsu.bsu-per-core=1|2", "clock"].map(selection);
    let interactions = Some(InteractionStudy { method: Method::Morris, samples: Some(3), seed: 7 });
    let study =
        KeyStudy { system: &system, keys: &keys, step: 0.1, display_fps: FPS, interactions };
    let found = study.run(&mut lists(), &()).expect("no error").expect("frames");
    let found = found.interactions.expect("keys together");
    assert_eq!((found.samples, found.factors.len()), (3, 3));
    for point in &found.points {
        let set = found.factors.iter().zip(&point.levels);
        let system = set.fold(system.clone(), |system, (factor, &level)| {
            changed(&system, factor.file, &factor.key, &factor.levels[level])
        });
        assert_eq!(point.outcome, Cost::mean(&alone(&system)), "{:?}", point.levels);
    }
    let Results::Morris(effects) = &found.results else { panic!("another method") };
    assert!(effects.iter().all(|(_, effects)| effects.len() == 3));
}

#[test]
fn what_no_key_is_and_what_no_machine_is_is_refused() {
    let system = machine();
    let refused = |keys: &[&str], interactions| {
        let keys: Vec<KeySelection> = keys.iter().map(|text| selection(text)).collect();
        let study =
            KeyStudy { system: &system, keys: &keys, step: 0.1, display_fps: FPS, interactions };
        match study.run(&mut [frames(1)], &()) {
            Err(RunError::Request(message)) => message,
            other => panic!("{other:?}"),
        }
    };
    assert!(refused(&["vru.coers"], None).contains("`vru.cores`"));
    let together = Some(InteractionStudy { method: Method::Sobol, samples: Some(4), seed: 1 });
    assert!(refused(&["vru.cores=0|2"], together).contains("invalid configuration"));
    let many = InteractionStudy { method: Method::Sobol, samples: Some(1_000_000), seed: 1 };
    assert!(refused(&["vru.cores=2|4"], Some(many)).contains("100000"));
    assert!("=3".parse::<KeySelection>().is_err());
}

/// Cancels at once.
struct Cancelled;

impl Watch for Cancelled {
    fn is_cancelled(&self) -> bool {
        true
    }
}

#[test]
fn a_cancelled_experiment_has_no_results() {
    let system = machine();
    let study = AssumptionStudy { system: &system, only: &[1], display_fps: FPS };
    let lists: Vec<&mut dyn Frames> = Vec::new();
    let mut lists = lists;
    let mut one = frames(1);
    lists.push(&mut one);
    assert!(study.run(&mut lists, &Cancelled).expect("no error").is_none());
}
