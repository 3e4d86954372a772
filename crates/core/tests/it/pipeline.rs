//! Does the pipeline keep its rules?

mod lanes;
mod laws;
mod memo;
pub mod modes;
mod oracle;
mod organisation;
mod rules;
pub mod support;
mod timelines;

use powergs_core::flow::History;
use powergs_core::flow::steps::StepCycles;
use powergs_core::flow::tile_wise::GsuImpl;
use powergs_core::flow::tile_wise::Overlap;
use powergs_core::flow::tile_wise::gradients::{FrameSums, SumKey};
use powergs_core::flow::tile_wise::measures::CacheKey;
use powergs_core::flow::tile_wise::{self, FrameContext, FrameReplay, replay_with};
use powergs_core::kernel::Memo;
use powergs_core::kernel::timeline::Timeline;
use powergs_core::machine::DramModel;
use powergs_core::machine::Machine;
use powergs_core::stage::{Stall, stage};
use powergs_core::workload::binning::ListWrites;
use powergs_core::workload::reuse::{ListReuse, Reuse};
use powergs_core::workload::{FrameWorkload, bin};
use rayon::prelude::*;

use self::oracle::UNITS;
use self::support::{Dice, set_rate};
use crate::workload::support::small_frames;

/// How many random machines step through random frames, and with `RUN_SLOW_TESTS=1`.
pub const CASES: [u64; 2] = [2500, 20_000];

/// A number of cases, or the larger one with `RUN_SLOW_TESTS=1`.
pub fn slow_or([cases, slow]: [u64; 2]) -> u64 {
    if std::env::var_os("RUN_SLOW_TESTS").is_some() { slow } else { cases }
}

/// Seeds of what came later than the rest of a random machine begin here.
const MORE: u64 = 1 << 40;

/// Symbols of states: busy, stalls by cause, idle.
const SYMBOLS: &str = "0rlsfciob.";

/// Cycles by unit and state, in the order of [`SYMBOLS`]; none of units that a machine does not
/// have.
pub type States = [[u64; SYMBOLS.len()]; UNITS.len()];

fn states_of(replay: &FrameReplay) -> States {
    std::array::from_fn(|unit| {
        let mut units = replay.timing.units.iter();
        let found = units.find(|found| stage(found.unit).key == UNITS[unit]);
        let Some(u) = found else { return [0; SYMBOLS.len()] };
        // Those of this dataflow, which come first.
        let causes = Stall::all().iter().filter(|cause| SYMBOLS.contains(cause.words().symbol));
        let stalls = causes.map(|cause| u.stalls[cause.index()]);
        let all: Vec<u64> = [u.busy].into_iter().chain(stalls).chain([u.idle]).collect();
        all.try_into().expect("a state for each symbol")
    })
}

/// The same, counted in the oracle's picture of every cycle.
fn states_seen(seen: &oracle::Seen, machine: &Machine) -> States {
    let (gsu, vru) = (&machine.tiles().gsu, &machine.tiles().vru);
    let [qsus, bsus] =
        [gsu.qsu_per_core, gsu.bsu_per_core].map(|n| if gsu.sorts() { n } else { 0 });
    let gangs = [1, qsus, bsus, vru.units_per_core, 1, 1, 1, 1];
    let is = |symbol: char, state: char| match state {
        '0' => symbol.is_ascii_digit(),
        other => symbol == other,
    };
    std::array::from_fn(|unit| {
        let cycles = |s| seen.cycles(unit, |c| is(c, s)) * u64::from(gangs[unit]);
        let all: Vec<u64> = SYMBOLS.chars().map(cycles).collect();
        all.try_into().expect("a state for each symbol")
    })
}

/// A random frame on a random machine.
pub struct Case {
    pub machine: Machine,
    pub workload: FrameWorkload,
    pub hits: Option<Vec<u32>>,
    pub reuse: Option<Vec<ListReuse>>,
    lists: Option<ListWrites>,
    other: Machine,
}

impl Case {
    /// With the machine as `changed`.
    pub fn new(seed: u64, changed: impl Fn(&mut Machine)) -> Case {
        let mut dice = Dice::new(seed);
        let mut machine = dice.machine();
        changed(&mut machine);
        let mut workload = dice.workload(machine.tiles().geometry);
        let (hits, reuse) = (dice.hits(&workload), dice.reuse(&workload));
        // After everything else, so that plain frames are those that they were.
        dice.foveate(&mut workload, &mut machine);
        dice.organise(&mut workload, &mut machine);
        // Of their own, for the same reason.
        let mut more = Dice::new(seed + MORE);
        more.clusters(&mut workload, &mut machine);
        let lists = dice.lists(&mut workload, &mut machine, reuse.is_some());
        dice.colour(&mut machine);
        dice.memory(&mut machine);
        let other = dice.another(&machine);
        Case { machine, workload, hits, reuse, lists, other }
    }
}

/// Compares a frame on a machine as `changed`; its states.
fn compare(seed: u64, changed: impl Fn(&mut Machine)) -> States {
    let Case { machine, workload, hits, reuse, lists, other } = Case::new(seed, changed);
    let given = FrameContext {
        hits: hits.as_deref(),
        reuse: reuse.as_deref(),
        lists: lists.as_ref(),
        ..FrameContext::default()
    };
    states_of(&compare_on(&workload, &machine, &other, given, seed))
}

/// Compares a frame on a machine, alone and with what `other`, which needs the same of the frame,
/// left in the memo.
fn compare_on(
    workload: &FrameWorkload,
    machine: &Machine,
    other: &Machine,
    given: FrameContext,
    seed: u64,
) -> FrameReplay {
    let mut timeline = Timeline::default();
    let memo = Memo::default();
    let sums = SumKey::of(machine.tiles()).map(|key| FrameSums::new(workload, &key));
    let summed = FrameContext { sums: sums.as_ref(), ..given };
    let calibration = tile_wise::calibration(workload, machine, &summed, &memo);
    let replay = replay_with(workload, machine, given, &Memo::default(), &mut timeline);
    let with = FrameContext { calibration: calibration.as_deref(), ..summed };
    let seen = oracle::run(workload, machine, with);
    let frame = FrameWorkload { list: Vec::new(), slot: Vec::new(), ..workload.clone() };
    let case = || format!("seed {seed}\n{machine:?}\n{frame:?}");
    if timeline.draw() != seen.draw() {
        let ends = [replay.timing.preprocessing_end, seen.preprocessing_end];
        let drawn = [timeline.draw(), seen.draw()];
        panic!("pipeline:\n{}\noracle:\n{}\n{}\n{ends:?}", drawn[0], drawn[1], case());
    }
    assert_eq!(replay.timing.frame, seen.frame, "{}", case());
    assert_eq!(replay.timing.preprocessing_end, seen.preprocessing_end, "{}", case());
    assert_eq!(replay.timing.dram.requests_served, seen.requests, "{}", case());
    assert_eq!(replay.served.stages.map(|s| s.read), seen.read, "{}", case());
    assert_eq!(replay.served.stages.map(|s| s.write), seen.write, "{}", case());
    assert_eq!(states_of(&replay), states_seen(&seen, machine), "{}", case());
    let parts = seen.step.map(|ends| StepCycles::between(seen.rendered, ends));
    assert_eq!(StepCycles::find(&replay.step), parts, "{}", case());
    let memo = Memo::default();
    let alone = replay_with(workload, other, given, &Memo::default(), &mut ());
    let first = replay_with(workload, other, given, &memo, &mut ());
    assert_eq!(first, alone, "the other one, {}", case());
    let shared = replay_with(workload, machine, given, &memo, &mut ());
    assert_eq!(shared, replay, "behind another one: {other:#?}\n{}", case());
    replay
}

/// The states that came up, by unit.
fn reached(all: &[States]) -> [String; UNITS.len()] {
    std::array::from_fn(|unit| {
        let came_up = |state: usize| all.iter().any(|states| states[unit][state] > 0);
        let states = SYMBOLS.chars().enumerate();
        states.filter(|(state, _)| came_up(*state)).map(|(_, symbol)| symbol).collect()
    })
}

#[test]
fn recurrences_equal_the_cycle_by_cycle_oracle() {
    let all = (0..slow_or(CASES)).into_par_iter().map(|seed| compare(seed, |_| ()));
    let all: Vec<States> = all.collect();
    // The cases reach every state that the rules know; others never come up.
    let expected = ["0rob.", "0lsiob.", "0lsiob.", "0lsfciob.", "", "", "0lsfi.", ""];
    assert_eq!(reached(&all), expected);
}

#[test]
fn batches_whose_entries_stay_on_chip_do_not_wait_for_the_writes_before_them() {
    // They have room in the tile-list buffer and nothing to write, behind slow writes.
    let changed = |machine: &mut Machine| {
        machine.dram.model = DramModel::Bandwidth;
        set_rate(machine, 1e9);
        machine.tiles_mut().buffers.tile_list.capacity.0 %= 50;
        machine.tiles_mut().schedule.overlap = Overlap::None;
    };
    (0..CASES[0]).into_par_iter().for_each(|seed| {
        compare(seed, changed);
    });
}

/// Frames of splats, with the hits that a cache has and the order that lists keep.
#[test]
fn caches_and_orders_of_real_frames_are_those_of_the_oracle() {
    let reached: Vec<[bool; 2]> = (0..slow_or(CASES) / 50)
        .into_par_iter()
        .map(|seed| {
            let mut dice = Dice::new(seed);
            let mut machine = dice.machine();
            dice.colour(&mut machine);
            dice.memory(&mut machine);
            let has_cache = dice.cache(&mut machine);
            let is_updated = dice.roll(0, 1) == 1;
            if is_updated {
                machine.tiles_mut().gsu.implementation = GsuImpl::Update;
            }
            let geometry = machine.tiles().geometry;
            let [before, workload] = small_frames(seed).map(|frame| bin(&frame, geometry));
            let mut history = History::default();
            let mut handed = None;
            for work in [&before, &workload] {
                handed = machine.flow().hand_over(&machine, work, None, &mut history);
            }
            let reuse = handed.as_ref().and_then(|handed| handed.downcast_ref::<Reuse>());
            let cache = CacheKey::of(&machine).map(|key| key.replay(&workload));
            let given = FrameContext {
                hits: cache.as_ref().map(|cache| cache.hits.as_slice()),
                reuse: reuse.map(|reuse| reuse.lists.as_slice()),
                ..FrameContext::default()
            };
            let other = dice.another(&machine);
            compare_on(&workload, &machine, &other, given, seed);
            [has_cache, reuse.is_some()]
        })
        .collect();
    let many = |of: usize| reached.iter().filter(|reached| reached[of]).count();
    assert!(many(0) > 10 && many(1) > 10, "{} caches, {} orders", many(0), many(1));
}
