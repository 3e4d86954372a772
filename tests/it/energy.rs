//! Does energy add up? Prices are 1, 2, 3, ... so that no two actions can be confused.

use powergs_sim::accel::{Machine, Traffic, replay};
use powergs_sim::action::{Action, ActionCounts, Stage};
use powergs_sim::energy::prices::component_of;
use powergs_sim::energy::{Component, Prices};
use powergs_sim::sim::{Breach, FrameReport, Label, check, frames, simulate};
use powergs_sim::workload::FrameWorkload;

use crate::pipeline::support::{Dice, TilePlan, gscore, workload};

fn prices() -> Prices {
    let per_action = std::array::from_fn(|i| (i + 1) as f64);
    Prices { per_action, leakage_w: 0.25, background_w: 0.5 }
}

fn small() -> (Machine, FrameWorkload) {
    let machine = gscore();
    let tile = || TilePlan { chunks: vec![(256, 500), (30, 60)], unfetched: 100, pixels: 256 };
    let frame = workload(machine.geometry, 5000, &[tile(), tile(), tile()]);
    (machine, frame)
}

fn report() -> FrameReport {
    let (machine, frame) = small();
    simulate(Label::default(), &frame, &machine, &prices()).unwrap()
}

#[test]
fn every_action_is_priced_once_in_its_component() {
    for (i, action) in Action::all().into_iter().enumerate() {
        let mut actions = ActionCounts::default();
        actions.charge(Stage::Sorting, action, 10);
        let energy = prices().breakdown(&actions, 0.0);
        assert_eq!(action.index(), i);
        assert_eq!(energy.part(Stage::Sorting, component_of(action)).0, 10.0 * (i + 1) as f64);
        assert_eq!(energy.total().0, 10.0 * (i + 1) as f64, "{action:?}");
    }
}

#[test]
fn standby_is_paid_for_time() {
    let energy = prices().breakdown(&ActionCounts::default(), 2e-3);
    assert_eq!(energy.part(Stage::Standby, Component::Leakage).0, 0.25 * 2e-3 * 1e12);
    assert_eq!(energy.part(Stage::Standby, Component::Background).0, 0.5 * 2e-3 * 1e12);
    assert_eq!(energy.dynamic().0, 0.0);
}

#[test]
fn parts_sum_to_totals() {
    let energy = report().energy;
    let by_stage: f64 = Stage::ALL.iter().map(|&s| energy.stage(s).0).sum();
    let by_component: f64 = Component::ALL.iter().map(|&c| energy.component(c).0).sum();
    let total = energy.total().0;
    // Sums of some twenty terms in different orders.
    assert!((by_stage - total).abs() <= 1e-12 * total);
    assert!((by_component - total).abs() <= 1e-12 * total);
    assert_eq!(energy.stage(Stage::Standby) + energy.dynamic(), energy.total());
}

#[test]
fn three_powers_are_three_numbers() {
    let report = report();
    let cycles = report.timing.as_ref().unwrap().frame;
    let seconds = cycles as f64 * 1e-9;
    assert!((report.frame_time_s().unwrap() - seconds).abs() < 1e-15);
    assert_eq!(report.achieved_fps().unwrap(), 1.0 / report.frame_time_s().unwrap());
    let (total, work) = (report.energy.total().0 * 1e-12, report.energy.dynamic().0 * 1e-12);
    // Rounding of a few products.
    let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} for {b}");
    close(report.power_full_rate_w().unwrap(), total / seconds);
    close(report.power_full_rate_w().unwrap(), work / seconds + 0.75);
    close(report.power_display_rate_w(60.0), work * 60.0 + 0.75);
    assert!(!report.misses_deadline(0.999 / seconds));
    assert!(report.misses_deadline(1.001 / seconds));
}

#[test]
fn reports_repeat_the_charges_by_stage() {
    let report = report();
    for (stage, bytes) in Stage::WORK.into_iter().zip(report.stages) {
        assert_eq!(bytes.read, report.actions.count(stage, Action::DramRead));
        assert_eq!(bytes.write, report.actions.count(stage, Action::DramWrite));
        assert!(bytes.sram > 0);
    }
    assert_eq!(report.alpha_evaluations_executed, Some(3 * 560 * 64));
    let dram = report.timing.unwrap().dram;
    assert_eq!(dram.read_bytes, report.stages.iter().map(|s| s.read).sum::<u64>());
}

#[test]
fn accounts_close_on_random_machines() {
    for seed in 0..300 {
        let mut dice = Dice::new(seed);
        let machine = dice.machine();
        let frame = dice.workload(machine.geometry);
        if let Err(breach) = simulate(Label::default(), &frame, &machine, &prices()) {
            panic!("seed {seed}: {breach}");
        }
    }
}

#[test]
fn breaches_are_found_and_named() {
    let (machine, frame) = small();
    let served = replay(&frame, &machine).served;
    let good = report();
    let timing = |change: fn(&mut FrameReport)| {
        let mut bad = good.clone();
        change(&mut bad);
        check::timing(&bad, &machine).unwrap_err().to_string()
    };
    let lost = timing(|r| r.timing.as_mut().unwrap().units[3].idle += 1);
    assert!(lost.contains("vru accounts for"), "{lost}");
    let lost = timing(|r| r.timing.as_mut().unwrap().dram.requests_served -= 1);
    assert!(lost.contains("DRAM requests issued"), "{lost}");
    let fast = timing(|r| r.timing.as_mut().unwrap().dram.read_bytes *= 1000);
    assert!(fast.contains("more than its 5.120e10 B/s"), "{fast}");
    let mut bytes: Traffic = served;
    bytes.stages[1].read += 1;
    let bytes = check::traffic(&good, &bytes).unwrap_err().to_string();
    assert!(bytes.contains("sorting needs"), "{bytes}");
    let mut bad = good.clone();
    bad.energy.add(Stage::Rendering, Component::Flop, good.energy.total() * 2e-9);
    assert!(matches!(check::energy(&bad, &prices()), Err(Breach::Energy { .. })));
    let mut other = machine.clone();
    other.geometry.chunk = 128;
    let refused = simulate(Label::default(), &frame, &other, &prices()).unwrap_err();
    assert!(refused.to_string().contains("bin it again"), "{refused}");
}

#[test]
fn frames_come_back_in_order_and_stop_at_the_first_error() {
    let run = |bad: usize| {
        let mut seen = Vec::new();
        let items = (0..20).map(|i| if i == bad { Err(i) } else { Ok(i) });
        let result = frames::in_order(
            items,
            |i| if i == 13 { Err(i) } else { Ok(i * 10) },
            |x| {
                seen.push(x);
                Ok(())
            },
        );
        (result, seen)
    };
    assert_eq!(run(99), (Err(13), (0..13).map(|i| i * 10).collect()));
    assert_eq!(run(4), (Err(4), vec![0, 10, 20, 30]));
}
