//! The catalogue of statistics and the aggregates.

use std::collections::BTreeSet;

use powergs_core::flow;
use powergs_core::sim::statistics::{
    Aggregate, Key, Kind, Value, catalogue, find, name_in, values,
};
use powergs_core::stage::{hardware, stage, stage_id};
use powergs_energy::action::Phase;
use powergs_energy::{Area, Component};
use powergs_frame::fovea::REGIONS;

use crate::builder;

fn value(name: &str) -> f64 {
    let frame = builder::frame(3, 8.0);
    find(name).expect(name).of(&frame, 60.0).expect(name).as_f64()
}

/// One rounding per term of a short sum.
const ROUNDING: f64 = 1e-12;

#[track_caller]
fn same(a: f64, b: f64) {
    assert!((a - b).abs() <= ROUNDING * a.abs().max(b.abs()), "{a} is not {b}");
}

#[test]
fn names_are_unique_snake_case_and_no_name_is_inside_another() {
    let names: Vec<&str> = catalogue().iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len());
    for name in &names {
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "._".contains(c);
        assert!(name.chars().all(plain), "{name}");
        let inside = format!("{name}.");
        assert!(!names.iter().any(|other| other.starts_with(&inside)), "{name} is a group too");
    }
}

#[test]
fn promised_names_exist() {
    let mut names = vec!["frame_time_ms", "dram_read_bytes", "dram_write_bytes"];
    let text = "points survivors tile_pairs intersecting_points fetched_points obb_tests \
                tile_loads alpha_evaluations blends alpha_evaluations_executed";
    let counters: Vec<String> = text.split(' ').map(|n| format!("counters.{n}")).collect();
    names.extend(counters.iter().map(String::as_str));
    let parts = "total dram sram flop leakage background refresh preprocessing sorting rendering \
                 standby";
    let powers: Vec<String> =
        parts.split(' ').flat_map(|p| [format!("power_w.{p}"), format!("energy_pj.{p}")]).collect();
    names.extend(powers.iter().map(String::as_str));
    for name in names {
        assert!(find(name).is_some(), "{name}");
    }
}

/// Every key names a statistic, and no two the same.
#[test]
fn keys_are_in_the_catalogue() {
    let mut keys = vec![
        Key::FrameTime,
        Key::DisplayedFps,
        Key::DeadlineMissed,
        Key::FrameCycles,
        Key::PreprocessingCycles,
        Key::Power,
        Key::DisplayPower,
        Key::PowerWithDisplay,
        Key::Energy,
        Key::Area,
        Key::AreaCore,
        Key::ReadBytes,
        Key::WriteBytes,
        Key::SramBytes,
        Key::LaneUtilisation(stage_id("vru")),
        Key::DramBusy,
        Key::DramRate,
        Key::UnwrittenBytes,
        Key::MasterRate(0),
        Key::MovedPerRequested,
        Key::RowHits,
    ];
    keys.extend(Component::ALL.into_iter().flat_map(|c| [Key::PowerOf(c), Key::EnergyOf(c)]));
    keys.extend(Phase::ALL.map(Key::EnergyIn));
    for stage in Phase::WORK {
        keys.extend(Key::COMPONENTS.map(|component| Key::EnergyPart(stage, component)));
        let bytes = [Key::StageRead, Key::StageWrite, Key::StageSram];
        let bursts = [Key::BurstsRead, Key::BurstsWritten, Key::RowsOpened];
        keys.extend(bytes.into_iter().chain(bursts).map(|of| of(stage)));
    }
    let stages = flow::named(flow::DEFAULT).expect("the default").stages();
    let own = |id| stages.iter().any(|known| known.key == stage(id).key);
    let has_cycles = |id| own(id) && stage(id).within.is_none();
    for (kind, _) in hardware().units().filter(|(id, _)| has_cycles(*id)) {
        keys.extend([Key::Instances, Key::Busy, Key::Idle].map(|of| of(kind)));
        keys.extend(stage(kind).stalls().map(|cause| Key::Stalled(kind, cause)));
    }
    let filled = hardware().buffers().filter(|(_, facts)| facts.fills);
    for (buffer, _) in filled.filter(|(id, _)| own(hardware().stage_of(*id))) {
        let held = [Key::Capacity, Key::Peak, Key::Held];
        let moved = [Key::Filled, Key::Consumed, Key::Discarded];
        keys.extend(held.into_iter().chain(moved).map(|of| of(buffer)));
    }
    for k in 0..REGIONS.len() {
        let of = [Key::RegionTiles, Key::RegionEntries, Key::RegionCycles, Key::RegionEnergy];
        keys.extend(of.map(|of| of(k)));
    }
    let record = builder::garden().statistics().expect("frames");
    let mut names = BTreeSet::new();
    for key in keys {
        assert!(record.mean(key).is_some(), "{key:?}");
        assert!(names.insert(key.name()), "{key:?}");
    }
}

#[test]
fn every_entry_has_a_definition_and_its_kind() {
    let (frame, reusing) = (builder::frame(0, 5.0), builder::reusing_frame(0, 5.0));
    for s in catalogue() {
        assert!(s.definition.len() > 15 && s.definition.ends_with('.'), "{}", s.name);
        assert!(!s.unit.is_empty() && !s.definition.contains('|'), "{}", s.name);
        match s.of(&frame, 60.0).or(s.of(&reusing, 60.0)) {
            Some(Value::Count(_)) => assert_eq!(s.kind, Kind::Count, "{}", s.name),
            Some(Value::Real(x)) => {
                assert!(x.is_finite());
                assert_eq!(s.kind, Kind::Real, "{}", s.name);
            }
            // FLOPs belong to the other model.
            None => {
                let is_of_others = !s.flows.is_empty() && !s.flows.contains(&flow::DEFAULT);
                assert!(is_of_others || s.name.ends_with("flops"), "{}", s.name);
            }
        }
    }
}

#[test]
fn three_powers() {
    let energy = value("energy_pj.total") * 1e-12;
    let standby = value("energy_pj.standby") * 1e-12;
    same(value("power_full_rate_w.total"), energy / (value("frame_time_ms") * 1e-3));
    same(value("power_w.total"), (energy - standby) * 60.0 + 0.06 + 0.025 + 0.005);
    same(value("rendering_plus_display_w"), value("power_w.total") + value("display_power_w"));
    same(value("achieved_fps"), 125.0);
}

#[test]
fn parts_sum_to_totals() {
    for group in ["power_w", "energy_pj"] {
        let sum = |parts: &str| parts.split(' ').map(|p| value(&format!("{group}.{p}"))).sum();
        let total = value(&format!("{group}.total"));
        same(sum("dram sram flop leakage background refresh"), total);
        same(sum("preprocessing sorting rendering standby"), total);
    }
    let blocks = Area::blocks(hardware());
    let sum = blocks.iter().map(|block| value(&format!("area_mm2.{}", block.name))).sum();
    same(sum, value("area_mm2.total"));
    for column in ["dram_read_bytes", "dram_write_bytes", "sram_bytes"] {
        let stages = ["preprocessing", "sorting", "rendering"];
        let sum: f64 = stages.iter().map(|s| value(&format!("stages.{s}.{column}"))).sum();
        assert_eq!(sum, value(column));
    }
}

#[test]
fn deadline_is_the_display_period() {
    let missed = |millions, fps| {
        let frame = builder::frame(0, millions);
        find("deadline_missed").expect("it").of(&frame, fps)
    };
    assert_eq!(missed(10.0, 100.0), Some(Value::Count(0)), "exactly on time is on time");
    assert_eq!(missed(10.0, 101.0), Some(Value::Count(1)));
}

#[test]
fn paper_model_has_no_time_and_no_cycles() {
    let frame = builder::paper_frame(0, 5.0);
    for (s, v) in catalogue().iter().zip(values(&frame, 60.0)) {
        let timed = ["frame_", "achieved", "deadline", "preprocessing_c", "units.", "dram.", "act"];
        if timed.iter().any(|t| s.name.starts_with(t)) || s.name == "power_full_rate_w.total" {
            assert_eq!(v, None, "{}", s.name);
        }
    }
    assert_eq!(find("flops").expect("it").of(&frame, 60.0), Some(Value::Count(3_000_000)));
}

/// The definition, word by word: the smallest value with at least p % of all at or below it.
fn naive_quantile(values: &[u64], percent: usize) -> u64 {
    let enough =
        |v: &u64| 100 * values.iter().filter(|w| *w <= v).count() >= percent * values.len();
    values.iter().copied().filter(enough).min().expect("the maximum is enough")
}

#[test]
fn quantiles_equal_the_definition() {
    let mut state = 1u64;
    for n in (1..130).chain([999, 1000, 1001]) {
        let values: Vec<u64> = (0..n)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 33) % 50
            })
            .collect();
        let a = Aggregate::of(values.iter().map(|&v| Some(Value::Count(v)))).expect("values");
        for (percent, got) in [(50, a.p50), (95, a.p95), (99, a.p99), (100, a.max)] {
            let expected = Value::Count(naive_quantile(&values, percent));
            assert_eq!(got, expected, "p{percent} of {n}");
        }
        same(a.mean, values.iter().sum::<u64>() as f64 / n as f64);
    }
}

#[test]
fn an_aggregate_needs_every_frame() {
    assert_eq!(Aggregate::of([]), None);
    assert_eq!(Aggregate::of([Some(Value::Count(1)), None]), None);
}

#[test]
fn the_rate_of_a_run_is_frames_over_time() {
    // 10 ms and 30 ms: 50 frames a second, although the mean of 100 and 33.3 is 66.7.
    let run = builder::run(&[10.0, 30.0]);
    let record = run.statistics().expect("frames");
    same(record.throughput_fps().expect("time"), 50.0);
    let energy = run.frames.iter().map(|f| f.energy.total().0).sum::<f64>() * 1e-12;
    same(record.throughput_power_w().expect("time"), energy / 40e-3);
    assert_eq!(record.deadline_misses(), Some(1));
    // At 60 FPS the first is shown for 16.7 ms and the second for 30 ms.
    let shown = 1.0 / 60.0 + 30e-3;
    same(record.displayed_fps(), 2.0 / shown);
    assert!(record.misses());
    let power_w = record.value(Key::Power);
    same(record.displayed_energy_j() * 2.0, power_w * shown);
    let watts = |i: usize| run.frames[i].power_display_rate_w(60.0);
    same(power_w, (watts(0) / 60.0 + watts(1) * 30e-3) / shown);
    let full_rate = record.named("power_full_rate_w.total").expect("frames").mean;
    same(full_rate, record.throughput_power_w().expect("time"));
}

#[test]
fn names_are_found_in_paths() {
    for path in ["power_w.total", "aggregate.power_w.total.p99", "frames[3].power_w.total"] {
        assert_eq!(name_in(path), "power_w.total");
    }
    assert_eq!(name_in("aggregate.power_w"), "power_w");
    assert_eq!(name_in("vru.cores"), "vru.cores");
}
