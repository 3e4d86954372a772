//! Replays of frames in memory: what they hold besides the frames is what replaying the changed
//! machines one by one gives.

use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::session::Target;
use powergs_core::run::{Change, Frames, PaperModel, Session, System, SystemSpec};
use powergs_core::sim::{FrameReport, Model};
use powergs_core::workload::paper::Padding;
use powergs_study::findings::WhatIf;
use powergs_study::findings::cost::Cost;
use powergs_study::findings::what_if::{Advice, Step};
use powergs_study::replay::{Replay, on_each};

use crate::frames;

fn replay(system: &System) -> Replay<'_> {
    let target = Target::System(system);
    Replay {
        target,
        display_fps: 60.0,
        what_if_frames: 0,
        calibrates_what_if: false,
        compares_window: false,
    }
}

fn what_if(system: &System, frames: usize) -> WhatIf {
    let replay = Replay { what_if_frames: frames, ..replay(system) };
    let run = replay.run(&mut crate::frames(3), &()).expect("a run");
    run.experiments.what_if.expect("an experiment")
}

/// A system by itself on all frames.
fn alone(system: &System) -> Vec<FrameReport> {
    let reports = Session::new(&mut frames(3), &()).reports(std::slice::from_ref(system));
    reports.expect("reports").remove(0)
}

#[test]
fn doubled_resources_cost_what_the_changed_machines_do() {
    let system = System::named("gscore").expect("a machine");
    let found = what_if(&system, 2);
    assert_eq!(found.frames, [0, 2], "spread over the list");
    let tried = |reports: Vec<FrameReport>| -> Vec<FrameReport> {
        reports.into_iter().filter(|report| found.frames.contains(&report.frame)).collect()
    };
    assert_eq!(found.base, Cost::of_frames(&tried(alone(&system)), 60.0));
    assert!(found.steps.len() >= 7, "{:?}", found.skipped);
    for step in &found.steps {
        let changes: Vec<Change> = step.sets.iter().map(|s| s.parse().expect("a change")).collect();
        let doubled = system.with(&changes).expect("a machine");
        assert_ne!(doubled.machine(), system.machine(), "{}", step.resource);
        assert_eq!(step.cost, Cost::of_frames(&tried(alone(&doubled)), 60.0), "{}", step.resource);
    }
    assert!(found.steps.is_sorted_by_key(|step| step.cost.frame_time_ms));
}

/// Steps of given time and area from a machine of 10 ms and 4 mm².
fn advised(steps: &[(f64, Option<f64>)], area_mm2: Option<f64>) -> WhatIf {
    let cost = |frame_time_ms, area_mm2| Cost { frame_time_ms, area_mm2, ..Cost::default() };
    let step = |&(ms, mm2): &(f64, Option<f64>)| Step {
        resource: "a resource",
        sets: vec![format!("time={ms}")],
        cost: cost(ms, mm2),
        assumptions: &[],
    };
    WhatIf::new(vec![0], cost(10.0, area_mm2), steps.iter().map(step).collect(), Vec::new())
}

#[test]
fn what_only_doubles_the_area_is_not_advised() {
    let of = |step: &Step| step.cost.frame_time_ms;
    // Half of the time for twice the area, and 7 % less for 1 % more.
    let found = advised(&[(5.0, Some(8.0)), (9.3, Some(4.04)), (10.0, Some(4.0))], Some(4.0));
    assert!(matches!(found.advice(), Advice::Take(step) if of(step) == 9.3));
    let found = advised(&[(5.0, Some(8.0)), (10.0, Some(4.0))], Some(4.0));
    assert!(matches!(found.advice(), Advice::AreaOnly(step) if of(step) == 5.0));
    let found = advised(&[(5.0, None)], None);
    assert!(matches!(found.advice(), Advice::Fastest(step) if of(step) == 5.0));
    let found = advised(&[(9.95, Some(1.0))], Some(4.0));
    assert_eq!(found.advice(), Advice::Nothing);
    // 4 % less time for 8 mm² of PHY: the die pays for it.
    let mut found = advised(&[(9.6, Some(4.0))], Some(4.0));
    assert!(matches!(found.advice(), Advice::Take(_)));
    found.steps[0].cost.area_mm2 = Some(12.0);
    assert!(matches!(found.advice(), Advice::AreaOnly(_)));
    assert_eq!(found.area_change(&found.steps[0]), Some(2.0));
}

#[test]
fn every_resource_of_every_machine_can_be_doubled_or_says_why_not() {
    for name in ["gscore", "gscore-16core", "edge"] {
        let found = what_if(&System::named(name).expect("a machine"), 1);
        assert!(found.steps.len() >= 7, "{name}: {:?}", found.skipped);
        for skipped in &found.skipped {
            assert!(skipped.reason.contains("sram.table"), "{name}: {skipped:?}");
        }
    }
}

#[test]
fn a_resource_that_cannot_be_doubled_names_the_reason() {
    let sets = vec!["gsu.bsu-per-core=65536".to_owned()];
    let spec = SystemSpec { sets, ..SystemSpec::named("gscore") };
    let found = what_if(&System::load(&spec, &EmbeddedFiles).expect("a machine"), 1);
    let skipped = found.skipped.iter().find(|s| s.resource == "gsu.bsu-per-core");
    assert!(skipped.is_some_and(|s| s.reason.contains("65536")), "{:?}", found.skipped);
    assert!(found.skipped.iter().all(|s| !s.reason.contains('\n')));
}

#[test]
fn doubling_is_tried_with_the_calibrated_model_where_the_machine_has_banked() {
    let named = System::named("gscore").expect("a machine");
    let with =
        |model: &str| named.with(&[Change::machine("dram.model", model)]).expect("a machine");
    let tried = |system: &System| {
        let asked = replay(system);
        let asked = Replay { what_if_frames: 1, calibrates_what_if: true, ..asked };
        asked.run(&mut crate::frames(1), &()).expect("a run")
    };
    let run = tried(&with("banked"));
    let found = run.experiments.what_if.expect("an experiment");
    assert!(found.is_calibrated);
    let alone = |system: &System| {
        let reports =
            Session::new(&mut crate::frames(1), &()).reports(std::slice::from_ref(system));
        Cost::of_frames(&reports.expect("reports").remove(0), 60.0)
    };
    assert_eq!(found.base, alone(&with("calibrated")));
    assert_eq!(Cost::of_frames(&run.frames, 60.0), alone(&with("banked")));
    let plain = tried(&with("bandwidth")).experiments.what_if.expect("an experiment");
    assert!(!plain.is_calibrated);
}

#[test]
fn two_dram_models_see_the_same_frames() {
    let change = |model: &str| {
        let system = System::named("gscore").expect("a machine");
        system.with(&[Change::machine("dram.model", model)]).expect("a machine")
    };
    let (banked, window) = (change("banked"), change("window"));
    let run = Replay { compares_window: true, ..replay(&banked) }.run(&mut frames(3), &());
    let run = run.expect("a run");
    let models = run.experiments.dram_models.expect("both models");
    let times: Vec<f64> =
        run.frames.iter().map(|frame| frame.timing().expect("a time").frame as f64).collect();
    let expected: Vec<f64> =
        alone(&banked).iter().map(|frame| frame.timing().expect("a time").frame as f64).collect();
    assert_eq!(times, expected);
    assert_eq!(models.banked_ms, Cost::of_frames(&alone(&banked), 60.0).frame_time_ms);
    assert_eq!(models.window_ms, Cost::of_frames(&alone(&window), 60.0).frame_time_ms);
    assert!(models.window_bytes > 0.0 && models.banked_bytes > 0.0);
}

#[test]
fn several_machines_get_the_runs_that_each_has_alone() {
    let systems = ["gscore", "neo"].map(|name| System::named(name).expect("a machine"));
    let runs = on_each(&systems, 60.0, &mut frames(3), &()).expect("runs");
    for (system, run) in systems.iter().zip(runs) {
        let mut alone = replay(system).run(&mut frames(3), &()).expect("a run");
        alone.tiles = None;
        assert_eq!(run, alone);
    }
}

#[test]
fn the_published_model_has_neither_machine_nor_experiment() {
    let model = PaperModel::new(Padding::TrueTiles).expect("the table");
    let system = System::named("gscore").expect("a machine");
    let replay = Replay { target: Target::Paper(&model), what_if_frames: 2, ..replay(&system) };
    let run = replay.run(&mut frames(2), &()).expect("a run");
    assert_eq!((run.facts.model, run.frames.len()), (Model::Paper, 2));
    assert_eq!(run.facts.trace.frames, frames(2).range().len());
    assert!(run.facts.machine.roofline.is_none() && run.experiments.what_if.is_none());
    assert!(run.tiles.is_some() && !run.incomplete());
}
