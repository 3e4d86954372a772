//! Replays of frames in memory: what they hold besides the frames is what replaying the changed
//! machines one by one gives.

use powergs_core::run::files::EmbeddedFiles;
use powergs_core::run::session::Target;
use powergs_core::run::{Change, FileKind, Frames, PaperModel, Session, System, SystemSpec};
use powergs_core::sim::{FrameReport, Model};
use powergs_core::workload::paper::Padding;
use powergs_study::findings::cost::Cost;
use powergs_study::findings::prices::{PriceBar, PriceBars};
use powergs_study::findings::what_if::{Advice, Step};
use powergs_study::findings::{Bottleneck, Limit, WhatIf, bottleneck, limits};
use powergs_study::replay::{Replay, on_each};

use crate::frames;

fn replay(system: &System) -> Replay<'_> {
    let target = Target::System(system);
    Replay {
        latency_ms: None,
        target,
        display_fps: 60.0,
        what_if_frames: 0,
        calibrates_what_if: false,
        compares_models: false,
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
    let (banked, calibrated) = (change("banked"), change("calibrated"));
    let run = Replay { compares_models: true, ..replay(&banked) }.run(&mut frames(3), &());
    let run = run.expect("a run");
    let models = run.experiments.dram_models.expect("both models");
    let times: Vec<f64> =
        run.frames.iter().map(|frame| frame.timing().expect("a time").frame as f64).collect();
    let expected: Vec<f64> =
        alone(&banked).iter().map(|frame| frame.timing().expect("a time").frame as f64).collect();
    assert_eq!(times, expected);
    assert_eq!(models.banked_ms, Cost::of_frames(&alone(&banked), 60.0).frame_time_ms);
    assert_eq!(models.calibrated_ms, Cost::of_frames(&alone(&calibrated), 60.0).frame_time_ms);
    assert!(models.calibrated_bytes > 0.0 && models.banked_bytes > 0.0);
}

#[test]
fn several_machines_get_the_runs_that_each_has_alone() {
    let systems = ["gscore", "neo"].map(|name| System::named(name).expect("a machine"));
    let runs = on_each(&systems, 60.0, &mut frames(3), None, &()).expect("runs");
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

/// The price assumptions in use on a machine with these `--set` values.
fn prices(sets: &[&str]) -> PriceBars {
    let sets = sets.iter().map(|s| (*s).to_owned()).collect();
    let spec = SystemSpec { sets, ..SystemSpec::named("gscore") };
    let system = System::load(&spec, &EmbeddedFiles).expect("a machine");
    let run = replay(&system).run(&mut frames(2), &()).expect("a run");
    run.experiments.prices.expect("prices")
}

fn bar<'a>(prices: &'a PriceBars, assumption: &str) -> Option<&'a PriceBar> {
    prices.bars.iter().find(|bar| bar.assumption == assumption)
}

/// The bar of an assumption is what runs with its prices draw.
#[test]
fn a_price_bar_is_what_the_turned_machine_draws() {
    let found = prices(&[]);
    let power = |scale: f64| {
        let change =
            Change { file: FileKind::Dram, path: "energy.scale".to_owned(), value: scale.into() };
        let system = System::named("gscore").and_then(|s| s.with(&[change])).expect("a machine");
        let mut frames = frames(2);
        let reports = Session::new(&mut frames, &()).reports(&[system]).expect("reports");
        let watts: f64 = reports[0].iter().map(|r| r.power_display_rate_w(60.0)).sum();
        watts / 2.0
    };
    let a40 = bar(&found, "A40").expect("LPDDR4");
    for (found, scale) in [(a40.low_w, 0.25), (found.power_w, 0.5), (a40.high_w, 1.0)] {
        assert!((found / power(scale) - 1.0).abs() < 1e-9, "{found} at {scale}");
    }
    assert!(found.bars.is_sorted_by(|a, b| a.spread_w() >= b.spread_w()));
    assert!(found.bars.iter().all(|b| b.low_w <= found.power_w && found.power_w <= b.high_w));
}

/// Prices that the machine does not have move nothing, and are not named.
#[test]
fn only_prices_at_work_have_bars() {
    const DEVICES: [(&str, &str, &str); 5] = [
        ("lpddr4-3200-x16x8", "RoBaCoCh", ""),
        ("lpddr5-6400-x16x8", "bg64", "A43"),
        ("lpddr5x-8533-x16x8", "bg64", "A46"),
        ("lpddr6-10667-x12x8", "bg64", "A48"),
        ("hbm2-8ch", "bg64", "A44"),
    ];
    for (device, mapping, own) in DEVICES {
        let sets = [format!("dram.device={device}"), format!("dram.mapping={mapping}")];
        let found = prices(&sets.each_ref().map(String::as_str));
        for number in ["A43", "A44", "A46", "A48"] {
            assert_eq!(bar(&found, number).is_some(), number == own, "{device}: {number}");
        }
        assert_eq!(bar(&found, "A40").is_some(), device != "hbm2-8ch", "{device}");
        assert_eq!(bar(&found, "A11"), None, "{device}: its commands are counted");
    }
    // Also where none are counted: the range of the cruder model is no narrower.
    let spread = |found: &PriceBars| bar(found, "A40").expect("LPDDR4").spread_w();
    let (banked, bandwidth) = (prices(&[]), prices(&["dram.model=bandwidth"]));
    assert!(spread(&bandwidth) > 0.5 * spread(&banked), "{bandwidth:?} {banked:?}");
    assert!(bar(&bandwidth, "A150").is_some() && bar(&banked, "A150").is_none());
    assert_eq!(bar(&bandwidth, "A11"), None, "its device stands by");
    let flat = prices(&["energy=gscore-28nm-flat"]);
    assert!(bar(&flat, "A11").is_some() && bar(&flat, "A40").is_none(), "{flat:?}");
    // The exponent of the table's node, at a clock that is not that of its prices.
    let at = |energy: &str| prices(&["clock=500 MHz", &format!("energy={energy}")]);
    assert!(bar(&at("gscore-28nm"), "A68").is_some());
    assert_eq!(bar(&at("gscore-7nm"), "A68"), None, "0.8 to 1.0 V are voltages of 28 nm");
}

/// Efficiency and latency are of `bandwidth` alone; without a device bytes have the price of the
/// table.
#[test]
fn assumptions_that_move_nothing_do_not_matter() {
    let of = |sets: &[&str]| {
        let sets = sets.iter().map(|s| (*s).to_owned()).collect();
        let spec = SystemSpec { sets, ..SystemSpec::named("gscore") };
        let system = System::load(&spec, &EmbeddedFiles).expect("a machine");
        let run = replay(&system).run(&mut frames(1), &()).expect("a run");
        let record = run.statistics().expect("frames");
        let limit = Limit::Dram;
        let dram = bottleneck::of(&record).map(|found| Bottleneck { limit, ..found });
        let machine = &run.facts.machine;
        let all = limits::mattered(&record, machine, dram.as_ref(), &run.experiments);
        all.into_iter().map(|m| m.assumption).collect::<Vec<_>>()
    };
    let has = |all: &[String], name: &str| all.iter().any(|one| one == name);
    let banked = of(&["ccu.units=4"]);
    assert!(has(&banked, "A40") && has(&banked, "A41"), "{banked:?}");
    assert!(!["A4", "A5", "accelergy"].iter().any(|name| has(&banked, name)), "{banked:?}");
    let flat = of(&["dram.model=bandwidth"]);
    assert!(["A4", "A5", "A40"].iter().all(|name| has(&flat, name)), "{flat:?}");
    assert!(!has(&flat, "accelergy") && !has(&flat, "A41"), "{flat:?}");
    let rate = of(&["dram.model=bandwidth", "dram.device=none", "dram.bandwidth=51.2 GB/s"]);
    assert!(["A4", "A5", "accelergy"].iter().all(|name| has(&rate, name)), "{rate:?}");
    assert!(!has(&rate, "A40") && !has(&rate, "A41"), "{rate:?}");
}

#[test]
fn of_several_knobs_the_widest_counts_and_narrow_bars_are_none() {
    let bar = |assumption: &str, low_w, high_w| PriceBar {
        assumption: assumption.to_owned(),
        keys: Vec::new(),
        low_w,
        high_w,
    };
    let all =
        [bar("A1", 0.9, 1.0), bar("A2", 0.999, 1.001), bar("A1", 0.8, 1.3), bar("A3", 1.0, 1.2)];
    let found = PriceBars::new(1.0, all);
    let shown: Vec<_> = found.bars.iter().map(|b| (b.assumption.as_str(), b.high_w)).collect();
    assert_eq!(shown, [("A1", 1.3), ("A3", 1.2)]);
}
