//! Does energy add up? What do banks and reference tables cost? Prices are 1, 2, 3, ... so that no
//! two actions can be confused.

use powergs_base::config::embedded::{ENERGY, MACHINES, find};
use powergs_base::quantity::Hertz;
use powergs_core::flow;
use powergs_core::flow::FrameTask;
use powergs_core::flow::tile_wise::replay;
use powergs_core::flow::tile_wise::{BinningImpl, FeatureSource};
use powergs_core::kernel::FrameTiming;
use powergs_core::kernel::Memo;
use powergs_core::machine::Machine;
use powergs_core::machine::{DramModel, GatingSpec};
use powergs_core::sim::statistics;
use powergs_core::sim::{
    FrameReport, InvariantViolated, Label, check, cost, priced, simulate, time,
};
use powergs_core::stage::EnergyTable;
use powergs_core::stage::{DRAM_READ, DRAM_WRITE, hardware, stages};
use powergs_core::workload::FrameWorkload;
use powergs_dram::{CommandPrices, DramCommands, StageCommands};
use powergs_energy::action::{ActionCounts, Phase};
use powergs_energy::{Activity, Component, DramCosts, IdleShares, Prices};

mod accelergy;
mod alive;
mod resources;
mod sram;
mod supply;

use crate::pipeline::support::{Dice, TilePlan, gscore, workload};

fn prices() -> Prices {
    let per_action: Vec<f64> = (1..=hardware().actions().count()).map(|i| i as f64).collect();
    let [read_pj, write_pj] = [DRAM_READ, DRAM_WRITE].map(|a| per_action[a.index()]);
    Prices {
        hardware: hardware(),
        per_action,
        unit_leakage_w: vec![0.0625, 0.03125, 0.03125, 0.0625, 0.0],
        sram_leakage_w: vec![0.0625, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        idle_leakage: 1.0,
        dram: DramCosts::Bytes { read_pj, write_pj, background_w: 0.375, refresh_w: 0.125 },
        area: None,
        phy_standby_w: 0.0,
        standby_share: 1.0,
        supply: None,
        kept: IdleShares::ALL,
    }
}

/// A machine that has another amount of everything than the one that prices are for: every share
/// and every curve shows.
pub const UNLIKE: [&str; 19] = [
    "clock=800 MHz",
    "cache.capacity=32 KiB",
    "cache.ways=8",
    "ccu.operations-per-cycle=213",
    "ccu.intersection-units=2",
    "ccu.queue=32",
    "fovea.accumulators=2",
    "fovea.level-tests=2",
    "gsu.pivots=15",
    "gsu.keys-per-cycle=2",
    "gsu.bsu-width=32",
    "gsu.queue=2",
    "vru.recurrence=2",
    "vru.subtile-queue=4",
    "vru.pixels-per-unit=8",
    "dram.channels=2",
    "ccu.fetch=lazy-colour",
    "record.feature-source=nobody",
    "vru.colour-operations-per-cycle=133",
];

/// The same of a machine with resident pixels, which has everything.
const UNLIKE_RESIDENT: [&str; 13] = [
    "region.cut=exact",
    "raster.row-cycles=2",
    "clock=500 MHz",
    "dram.channels=1",
    "region.slices=1",
    "tail.share=0.25",
    "tail.lanes=2",
    r#"stores.tail={ capacity = "32 KiB", word = "64 B", banks = 1, ports = "1rw" }"#,
    "compose.lanes=8",
    "front.operations-per-cycle=32",
    "order.ways=4",
    "raster.lanes=8",
    "raster.engines=2",
];

/// The same of a GPU.
const UNLIKE_GPU: [&str; 5] =
    ["clock=500 MHz", "dram.channels=2", "sm.units=5", "sm.lanes=48", "l2.capacity=1 MiB"];

/// A GPU with a unit beside it.
const UNLIKE_ATTACHED: &[&str] = &["attached.lanes=4", "sm.lanes=64", "dram.channels=2"];

/// One whose raster operations blend.
const UNLIKE_ROPS: &[&str] = &[
    "rops.quads-per-cycle=4",
    "rops.found-per-cycle=8",
    "rops.bins=64",
    "sm.lanes=32",
    "dram.channels=2",
];

/// Machines with test units, with a unit between two eyes, with one that knows pixels, and with
/// gradient units, which one with everything else cannot have.
const UNLIKE_PARTS: [&[&str]; 5] = [
    &["levels.gaussians=16", "levels.operations-per-cycle=7"],
    &["vru.impl=leaders", "geometry.subtile=4", "vru.leaders-per-cycle=16", "fovea.accumulators=0"],
    &["stereo.impl=derived", "stereo.lag=8", "fovea.accumulators=0"],
    &["pixels.impl=warped", "pixels.per-cycle=4", "fovea.accumulators=0"],
    &[
        "training.interval=2",
        "gradients.sum-cycles=2",
        "gradients.ways=8",
        "gradients.misses=8",
        "gradients.operations-per-cycle=32",
        "fovea.accumulators=0",
    ],
];

/// Machines of every dataflow that have another amount of everything than the one that prices are
/// for, on the flat memory, and `more` where they have such keys; those that a table has the prices
/// for.
pub fn unlike(table: &EnergyTable, more: &[String]) -> Vec<Machine> {
    let all =
        [("gscore", &UNLIKE[..]), ("vorion", &UNLIKE_RESIDENT[..]), ("xavier-nx", &UNLIKE_GPU[..])];
    let with_machines = flow::all().filter(|flow| flow.example().is_some());
    assert_eq!(all.len(), with_machines.count(), "one of each dataflow");
    let mut parts = UNLIKE_PARTS.map(|sets| ("gscore", sets)).to_vec();
    parts.push(("orin-nx-gbu", UNLIKE_ATTACHED));
    parts.push(("agx-orin-vrpipe", UNLIKE_ROPS));
    let all = all.iter().chain(&parts).map(|(name, sets)| {
        let mut sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        sets.push("dram.model=bandwidth".to_owned());
        if table.name.contains("rtl") {
            // Its netlists reach that above the lowest voltage.
            sets.push(format!("clock={} MHz", if table.name.contains("45") { 120 } else { 300 }));
        }
        let text = find(MACHINES, name).unwrap();
        Machine::parse_with(text, &sets).unwrap();
        sets.extend_from_slice(more);
        Machine::parse_with(text, &sets).ok()
    });
    let known = |machine: &Machine| {
        let priced = stages().iter().filter(|stage| stage.count(machine) > 0);
        priced
            .filter(|s| s.units.is_some() && s.counted_in.is_none())
            .all(|stage| table.leakage.contains_key(stage.key))
    };
    all.flatten().filter(known).collect()
}

/// Prices of commands, no two of them alike.
fn commands() -> Prices {
    let mut prices = prices();
    prices.per_action[DRAM_READ.index()] = 0.0;
    prices.per_action[DRAM_WRITE.index()] = 0.0;
    prices.dram = DramCosts::Commands(CommandPrices {
        activate_pj: 101.0,
        read_pj: 200.0,
        read_io_pj: 11.0,
        write_pj: 300.0,
        write_io_pj: 7.0,
        refresh_pj: 401.0,
        banks: 8.0,
        refresh_w: 0.03125,
        background_w: [0.125, 0.0625, 0.015625, 0.0078125],
        channels: 4.0,
    });
    prices
}

fn activity(actions: &ActionCounts, seconds: f64) -> Activity<'_> {
    Activity { actions, seconds, idle: &[0.0; 5], dram: None }
}

fn small() -> (Machine, FrameWorkload) {
    let machine = gscore();
    let tile = || TilePlan { chunks: vec![(256, 500), (30, 60)], unfetched: 100, pixels: 256 };
    let frame = workload(machine.tiles().geometry, 5000, &[tile(), tile(), tile()]);
    (machine, frame)
}

fn report() -> FrameReport {
    let (machine, frame) = small();
    simulate(Label::default(), &frame, &machine, &prices()).unwrap()
}

#[test]
fn every_action_is_priced_once_in_its_component() {
    for (i, (action, does)) in hardware().actions().enumerate() {
        let mut actions = ActionCounts::default();
        actions.charge(Phase::Sorting, action, 10);
        let energy = prices().breakdown(&activity(&actions, 0.0));
        assert_eq!(action.index(), i);
        assert_eq!(energy.part(Phase::Sorting, does.component()).0, 10.0 * (i + 1) as f64);
        assert_eq!(energy.total().0, 10.0 * (i + 1) as f64, "{action:?}");
    }
}

#[test]
fn standby_is_paid_for_time() {
    let energy = prices().breakdown(&activity(&ActionCounts::default(), 2e-3));
    assert_eq!(energy.part(Phase::Standby, Component::Leakage).0, 0.25 * 2e-3 * 1e12);
    assert_eq!(energy.part(Phase::Standby, Component::Background).0, 0.375 * 2e-3 * 1e12);
    assert_eq!(energy.part(Phase::Standby, Component::Refresh).0, 0.125 * 2e-3 * 1e12);
    assert_eq!(energy.dynamic().0, 0.0);
}

#[test]
fn commands_cost_what_they_are_and_bytes_nothing() {
    let mut actions = ActionCounts::default();
    actions.charge(Phase::Rendering, DRAM_READ, 1_000_000);
    let mut work = DramCommands { refreshes: 7, ..DramCommands::default() };
    work.stages[1] = StageCommands { reads: 2, writes: 3, activates: 5 };
    let done = Activity { dram: Some(work), ..activity(&actions, 1e-3) };
    let energy = commands().breakdown(&done);
    assert_eq!(energy.part(Phase::Sorting, Component::Dram).0, 2.0 * 211.0 + 3.0 * 307.0 + 505.0);
    assert_eq!(energy.part(Phase::Rendering, Component::Dram).0, 0.0);
    let refresh = energy.part(Phase::Standby, Component::Refresh).0;
    // From energy to power and back: a few roundings.
    assert!((refresh - 7.0 * 401.0).abs() < 1e-9 * refresh, "{refresh}");
    // Eight refreshes of one bank cost as much as one of all banks.
    let both = DramCommands { refreshes: 6, bank_refreshes: 8, ..work };
    let both = commands().breakdown(&Activity { dram: Some(both), ..done });
    assert_eq!(both.part(Phase::Standby, Component::Refresh).0, refresh);
    let standby = commands().standby(&done);
    assert_eq!(standby.running_w[1..], [0.5, 7.0 * 401.0 * 1e-12 / 1e-3]);
    assert_eq!(standby.idle_w[1..], [0.0625, 0.03125]);
}

#[test]
fn gated_units_leak_while_they_work_and_keep_a_share_while_idle() {
    let actions = ActionCounts::default();
    let done = Activity { idle: &[0.5, 1.0, 0.0, 0.25, 0.0], ..activity(&actions, 1e-3) };
    let mut gated = prices();
    gated.idle_leakage = 0.25;
    let standby = gated.standby(&done);
    let units = 0.0625 * 0.625 + 0.03125 * 0.25 + 0.03125 + 0.0625 * 0.8125;
    assert_eq!(standby.running_w[0], units + 0.0625);
    assert_eq!(standby.idle_w[0], 0.1875 * 0.25 + 0.0625, "buffers keep their contents");
    assert_eq!(prices().standby(&done).running_w[0], 0.25, "not gated");
    // Half of the time is rest at 500 frames a second, none at 2000.
    let mean = (standby.running_w[0] + standby.idle_w[0]) / 2.0;
    assert!((standby.at_rate(1e-3, 500.0)[0] - mean).abs() < 1e-15);
    assert_eq!(standby.at_rate(1e-3, 2000.0)[0], standby.running_w[0]);
    assert_eq!(standby.at_rate(0.0, 60.0)[0], standby.idle_w[0]);
}

#[test]
fn an_idle_state_keeps_a_share_between_frames_alone() {
    let mut prices = prices();
    prices.kept = IdleShares { leakage: 0.5, background: 0.25 };
    let actions = ActionCounts::default();
    let standby = prices.standby(&activity(&actions, 1e-3));
    assert_eq!(standby.running_w, [0.25, 0.375, 0.125]);
    assert_eq!(standby.idle_w, [0.125, 0.09375, 0.125]);
}

/// The preset: its buffers have prices.
fn preset() -> (Machine, FrameWorkload) {
    // Nobody knows where pixels of made-up frames stop.
    let sets = ["vru.impl=serial", "vru.stop-latency=0"].map(str::to_owned);
    let machine = Machine::parse_with(find(MACHINES, "gscore").unwrap(), &sets).unwrap();
    let tile = || TilePlan { chunks: vec![(256, 500), (30, 60)], unfetched: 100, pixels: 256 };
    let frame = workload(machine.tiles().geometry, 5000, &[tile(), tile(), tile()]);
    (machine, frame)
}

#[test]
fn gating_saves_leakage_and_nothing_else() {
    let (mut machine, frame) = preset();
    let table = EnergyTable::parse(find(ENERGY, "gscore-28nm").unwrap()).unwrap();
    let run = |machine: &Machine| {
        let prices = cost::prices(&table, machine).unwrap();
        simulate(Label::default(), &frame, machine, &prices).unwrap()
    };
    let open = run(&machine);
    machine.gating = GatingSpec { units: true, residual: 0.1 };
    let gated = run(&machine);
    assert_eq!(gated.model, open.model);
    assert_eq!(gated.energy.dynamic(), open.energy.dynamic());
    let leakage = |r: &FrameReport| r.energy.component(Component::Leakage).0;
    assert!(leakage(&gated) < leakage(&open) && leakage(&gated) > 0.1 * leakage(&open));
    assert!(gated.power_display_rate_w(60.0) < open.power_display_rate_w(60.0));
    machine.gating.residual = 1.0;
    let none = run(&machine);
    assert!((leakage(&none) - leakage(&open)).abs() <= 1e-12 * leakage(&open));
}

#[test]
fn commands_of_a_banked_machine_are_priced_by_its_device() {
    let (mut machine, _) = preset();
    let table = EnergyTable::parse(find(ENERGY, "gscore-28nm").unwrap()).unwrap();
    machine.dram.model = DramModel::Bandwidth;
    let device = machine.device.take();
    let bytes = cost::prices(&table, &machine).unwrap();
    assert_eq!([DRAM_READ, DRAM_WRITE].map(|a| bytes.of(a).0), [64.0; 2], "a mere rate");
    let device_only = {
        let mut table = table.clone();
        table.dram.flat = None;
        table
    };
    let refused = cost::prices(&device_only, &machine).unwrap_err().to_string();
    assert!(refused.contains("dram.device = true") && refused.contains("mere rate"), "{refused}");
    machine.device = device;
    assert!(cost::prices(&device_only, &machine).is_ok(), "by the byte");
    machine.dram.model = DramModel::Banked;
    // Loads and lists of such frames are made up.
    machine.tiles_mut().binning.implementation = BinningImpl::Free;
    machine.tiles_mut().record.feature_source = FeatureSource::Nobody;
    let frame = Dice::new(7).workload(machine.tiles().geometry);
    let prices = cost::prices(&table, &machine).unwrap();
    let report = simulate(Label::default(), &frame, &machine, &prices).unwrap();
    let commands = report.timing().unwrap().dram.commands.unwrap();
    for (stage, used) in Phase::WORK.into_iter().zip(commands.stages) {
        // Half of the published prices (A40): activate 1205, read 1348 + 821, write 990 + 298 pJ.
        let pj =
            used.activates as f64 * 602.5 + used.reads as f64 * 1084.5 + used.writes as f64 * 644.0;
        let dram = report.energy.part(stage, Component::Dram).0;
        assert!((dram - pj).abs() <= 1e-12 * pj, "{dram} for {pj}");
        assert!(dram > 0.0);
    }
    // Eight channels with open rows, and powered down between frames; their PHYs stand by.
    let phy = 8.0 * 3e-3;
    assert!((report.phy_standby_w - phy).abs() < 1e-12);
    assert!((report.standby.running_w[1] - 8.0 * 37.9e-3 * 0.5 - phy).abs() < 1e-12);
    assert!((report.standby.idle_w[1] - 8.0 * 6.3e-3 * 0.5 - phy).abs() < 1e-12);
}

/// Prices of the gates know what becomes of an evaluated pixel: a slot that blends takes more than
/// one that is dropped.
#[test]
fn frames_that_evaluate_as_much_and_blend_more_take_more() {
    let (mut machine, few) = preset();
    machine.clock = Hertz(380e6);
    let table = EnergyTable::parse(find(ENERGY, "gscore-rtl-28nm").unwrap()).unwrap();
    let prices = cost::prices(&table, &machine).unwrap();
    let mut many = few.clone();
    let blended = few.counters.alpha_evaluations / 2 / few.tiles.len() as u64;
    many.tiles.iter_mut().for_each(|tile| tile.blends = blended);
    many.counters.blends = many.tiles.iter().map(|tile| tile.blends).sum();
    let [few, many] =
        [few, many].map(|frame| simulate(Label::default(), &frame, &machine, &prices).unwrap());
    assert_eq!(many.timing().unwrap().frame, few.timing().unwrap().frame);
    assert_eq!(many.counters.alpha_evaluations, few.counters.alpha_evaluations);
    let rendering = |r: &FrameReport| r.energy.stage(Phase::Rendering).0;
    assert!(rendering(&many) > 1.1 * rendering(&few), "{:?}", [&few, &many].map(rendering));
}

#[test]
fn parts_sum_to_totals() {
    let energy = report().energy;
    let by_stage: f64 = Phase::ALL.iter().map(|&s| energy.stage(s).0).sum();
    let by_component: f64 = Component::ALL.iter().map(|&c| energy.component(c).0).sum();
    let total = energy.total().0;
    // Sums of some twenty terms in different orders.
    assert!((by_stage - total).abs() <= 1e-12 * total);
    assert!((by_component - total).abs() <= 1e-12 * total);
    assert_eq!(energy.stage(Phase::Standby) + energy.dynamic(), energy.total());
}

#[test]
fn three_powers_are_three_numbers() {
    let report = report();
    let cycles = report.timing().unwrap().frame;
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
fn power_at_a_rate_that_is_missed_is_power_at_full_rate() {
    let report = report();
    let full_rate = report.power_full_rate_w().unwrap();
    let achieved = report.achieved_fps().unwrap();
    for share in [0.01, 0.5, 0.999, 1.001, 2.0, 1e3, 1e9] {
        let fps = achieved * share;
        let (shown, power) = (report.displayed_fps(fps), report.power_display_rate_w(fps));
        assert_eq!(shown, fps.min(achieved));
        // Rounding of a few products.
        assert!(power <= full_rate * (1.0 + 1e-12), "{power} W at {fps} FPS");
        if share > 1.0 {
            assert!((power / full_rate - 1.0).abs() < 1e-12, "{power} for {full_rate}");
        }
        let parts: f64 = ["power_w.dram", "power_w.sram", "power_w.flop", "power_w.standby"]
            .map(|name| statistics::find(name).unwrap().of(&report, fps).unwrap().as_f64())
            .iter()
            .sum();
        assert!((parts / power - 1.0).abs() < 1e-12, "{parts} for {power}");
    }
}

#[test]
fn reports_repeat_the_charges_by_stage() {
    let report = report();
    for (stage, bytes) in Phase::WORK.into_iter().zip(report.stages) {
        assert_eq!(bytes.read, report.actions.count(stage, DRAM_READ));
        assert_eq!(bytes.write, report.actions.count(stage, DRAM_WRITE));
        assert!(bytes.sram > 0);
    }
    assert_eq!(report.cycle().unwrap().executed_evaluations, 3 * 560 * 64);
    let dram = report.timing().unwrap().dram;
    assert_eq!(dram.read_bytes, report.stages.iter().map(|s| s.read).sum::<u64>());
}

#[test]
fn accounts_close_on_random_machines() {
    for seed in 0..300 {
        let mut dice = Dice::new(seed);
        let machine = dice.machine();
        let frame = dice.workload(machine.tiles().geometry);
        if let Err(breach) = simulate(Label::default(), &frame, &machine, &prices()) {
            panic!("seed {seed}: {breach}");
        }
    }
}

#[test]
fn breaches_are_found_and_named() {
    let (machine, frame) = small();
    let good = replay(&frame, &machine);
    let timing = |change: fn(&mut FrameTiming)| {
        let mut bad = good.timing.clone();
        change(&mut bad);
        check::timing(0, &bad, &machine).unwrap_err().to_string()
    };
    let lost = timing(|t| t.units[3].idle += 1);
    assert!(lost.contains("vru accounts for"), "{lost}");
    let lost = timing(|t| t.dram.requests_served -= 1);
    assert!(lost.contains("DRAM requests issued"), "{lost}");
    let fast = timing(|t| t.dram.read_bytes *= 1000);
    assert!(fast.contains("more than its 5.120e10 B/s"), "{fast}");
    let memo = Memo::default();
    let mut bytes = machine.flow().run(&FrameTask::first(&machine, &frame, &memo), None).unwrap();
    bytes.served.stages[1].read += 1;
    let bytes = check::traffic(0, &bytes).unwrap_err().to_string();
    assert!(bytes.contains("sorting needs"), "{bytes}");
    let mut bad = report();
    bad.energy.add(Phase::Rendering, Component::Flop, bad.energy.total() * 2e-9);
    assert!(matches!(check::energy(&bad, &prices()), Err(InvariantViolated::Energy { .. })));
    let mut other = machine.clone();
    other.tiles_mut().geometry.chunk = 128;
    let refused = simulate(Label::default(), &frame, &other, &prices()).unwrap_err();
    assert!(refused.to_string().contains("bin it again"), "{refused}");
}

#[test]
fn one_timing_is_priced_by_several_tables() {
    let (machine, frame) = small();
    let label = Label { frame: 7, ..Label::default() };
    let memo = Memo::default();
    let timed = time(&FrameTask { frame: 7, ..FrameTask::first(&machine, &frame, &memo) }).unwrap();
    let one = priced(label.clone(), &timed, &prices()).unwrap();
    assert_eq!(one, simulate(label.clone(), &frame, &machine, &prices()).unwrap());
    let mut dearer = prices();
    dearer.per_action[DRAM_READ.index()] *= 2.0;
    let other = priced(label.clone(), &timed, &dearer).unwrap();
    assert!(other.energy.total().0 > one.energy.total().0);
    assert_eq!(other, simulate(label, &frame, &machine, &dearer).unwrap());
}
