//! What is true of every machine, and what is not although one might think so.

use std::ops::Range;

use powergs_base::quantity::{Bytes, Nanoseconds};
use powergs_core::flow::tile_wise::batch::Batch;
use powergs_core::flow::tile_wise::bsu::Sort;
use powergs_core::flow::tile_wise::colour::UNITS;
use powergs_core::flow::tile_wise::layout::{AccessPattern, Layout};
use powergs_core::flow::tile_wise::qsu::Keys;
use powergs_core::flow::tile_wise::schedule::{Plan, SortProgress};
use powergs_core::flow::tile_wise::vru::COLOURS;
use powergs_core::flow::tile_wise::{FeatureSource, Fetch, GsuImpl};
use powergs_core::flow::tile_wise::{
    FrameContext, FrameReplay, ResolvedUnits, replay, replay_with,
};
use powergs_core::kernel::Memo;
use powergs_core::kernel::Unit;
use powergs_core::kernel::timeline::{Observer, Span};
use powergs_core::machine::DramModel;
use powergs_core::machine::Machine;
use powergs_core::stage::{DRAM_READ, hardware, stage, work_id};
use powergs_core::workload::binning::ListWrites;
use powergs_core::workload::{FrameWorkload, bin};
use powergs_dram::AddressRange;
use powergs_energy::action::Phase;
use powergs_frame::scene::ShDegree;

use crate::workload::support::dense_frame;

use super::support::{Dice, TilePlan, gscore, set_rate, workload};

/// A change of one knob.
type Change = fn(&mut Machine);

const CASES: u64 = 1000;

fn case(seed: u64) -> (Machine, FrameWorkload) {
    let mut dice = Dice::new(seed);
    let machine = dice.machine();
    let workload = dice.workload(machine.tiles().geometry);
    (machine, workload)
}

#[test]
fn cycles_add_up_and_nothing_is_faster_than_its_parts() {
    for seed in 0..CASES {
        let (machine, workload) = case(seed);
        let replay = replay(&workload, &machine);
        let frame = replay.timing.frame;
        for unit in &replay.timing.units {
            let accounted = unit.busy + unit.stalls.iter().sum::<u64>() + unit.idle;
            assert_eq!(accounted, u64::from(unit.instances) * frame, "seed {seed} {unit:?}");
            assert!(unit.busy <= u64::from(unit.instances) * frame);
        }
        let dram = replay.timing.dram;
        assert_eq!(dram.requests_issued, dram.requests_served);
        assert!(dram.busy_cycles <= frame, "seed {seed}");
        let total = replay.served.total();
        assert_eq!((dram.read_bytes, dram.write_bytes), (total.read, total.write));
    }
}

/// Busy cycles are the costs of the work, each once.
#[test]
fn units_are_busy_for_exactly_their_work() {
    for seed in 0..CASES {
        let (mut machine, workload) = case(seed);
        machine.tiles_mut().vru.speculation = 0;
        let design = ResolvedUnits::new(&machine);
        let plan = Plan::new(&workload, &machine, &design, &FrameContext::default());
        let units = replay(&workload, &machine).timing.units;
        let busy = |key: &str| {
            units.iter().find(|unit| stage(unit.unit).key == key).map_or(0, |unit| unit.busy)
        };
        let mut sorts = 0;
        for job in &plan.jobs {
            let mut front = SortProgress::default();
            for &tile in plan.tiles_of(job) {
                let tile = &workload.tiles[tile as usize];
                for chunk in 0..tile.chunks {
                    let sort = front.next(&workload, job, tile, chunk);
                    let is_needed = !job.keys.merged || sort != Sort::default();
                    sorts += if is_needed { design.bsu.cycles(&sort) } else { 0 };
                }
            }
            let merges = job.keys.merged && job.keys.sorted > 0;
            sorts += if merges { design.bsu.cycles(&job.chunks()) } else { 0 };
        }
        assert_eq!(busy("bsu"), sorts * u64::from(machine.tiles().gsu.bsu_per_core), "seed {seed}");
        let jobs = plan.jobs.iter();
        let all = |keys: &Keys| -> u64 {
            (0..keys.passes).map(|pass| design.qsu.pass_cycles(keys, pass)).sum()
        };
        let passes: u64 = jobs.map(|j| all(&j.keys)).sum();
        assert_eq!(
            busy("qsu"),
            passes * u64::from(machine.tiles().gsu.qsu_per_core),
            "seed {seed}"
        );
    }
}

/// A batch takes as long as the slowest of the engines that work on it.
#[test]
fn engines_of_a_converter_work_side_by_side() {
    let batch = Batch { records: 64, survivors: 50, splats: 40, ..Batch::default() };
    let cycles = |engines: [u32; 3]| {
        let mut machine = gscore();
        let ccu = &mut machine.tiles_mut().ccu;
        ccu.fetch = Fetch::VisibleColour;
        [
            ccu.cull_operations_per_cycle,
            ccu.operations_per_cycle,
            ccu.colour_operations_per_cycle,
        ] = engines;
        let colour = u64::from(ccu.operations.sh_colour);
        assert_eq!((ccu.operations.cull, ccu.operations.project, colour), (47, 208, 133));
        ResolvedUnits::new(&machine).ccu.cycles(&batch)
    };
    let [cull, project, colour] = [64 * 47, 50 * 208, 40 * 133u64];
    assert_eq!(cycles([0, 100, 0]), (cull + project + colour).div_ceil(100));
    assert_eq!(cycles([10, 100, 0]), cull.div_ceil(10));
    assert_eq!(cycles([40, 100, 0]), (project + colour).div_ceil(100));
    assert_eq!(cycles([40, 100, 20]), colour.div_ceil(20));
    assert_eq!(cycles([40, 100, 60]), project.div_ceil(100));
    // A record a cycle at least.
    assert_eq!(cycles([4096, 4096, 4096]), 64);
}

/// Actions without those of dropped chunks.
fn needed(replay: &FrameReplay) -> Vec<u64> {
    let count = |stage, action| {
        replay.actions.count(stage, action) - replay.speculation.count(stage, action)
    };
    Phase::WORK
        .into_iter()
        .flat_map(|stage| {
            hardware().actions().map(|(action, _)| count(stage, action)).collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn what_enters_a_buffer_leaves_it() {
    let mut discarded = 0;
    for seed in 0..CASES {
        let (machine, workload) = case(seed);
        let replay = replay(&workload, &machine);
        for buffer in &replay.timing.buffers {
            assert_eq!(buffer.filled, buffer.consumed + buffer.discarded, "seed {seed} {buffer:?}");
            assert!(buffer.byte_cycles <= u128::from(buffer.peak * replay.timing.frame));
            discarded += buffer.discarded;
        }
        let in_vain = replay.speculation.count(Phase::Rendering, DRAM_READ);
        let discarded: u64 = replay.timing.buffers.iter().map(|b| b.discarded).sum();
        let spec = &machine.tiles().record;
        assert_eq!(in_vain, discarded, "seed {seed} {spec:?}");
    }
    assert!(discarded > 0);
}

#[test]
fn work_does_not_depend_on_timing() {
    for seed in 0..CASES {
        let (mut machine, workload) = case(seed);
        let before = replay(&workload, &machine);
        machine.tiles_mut().ccu.latency += 7;
        machine.tiles_mut().ccu.operations_per_cycle += 50;
        machine.tiles_mut().ccu.intersection_units += 1;
        machine.tiles_mut().ccu.units += 1;
        machine.tiles_mut().ccu.batch += 2;
        machine.tiles_mut().gsu.qsu_latency += 3;
        machine.tiles_mut().gsu.keys_per_cycle += 1;
        machine.tiles_mut().gsu.bsu_latency += 3;
        machine.tiles_mut().vru.latency += 5;
        machine.tiles_mut().vru.units_per_core *= 2;
        machine.tiles_mut().buffers.gaussian_in.capacity.0 *= 2;
        machine.tiles_mut().buffers.tile_list.capacity.0 /= 2;
        machine.tiles_mut().buffers.feature.capacity.0 /= 2;
        machine.tiles_mut().buffers.pixel_out.capacity.0 /= 3;
        machine.dram.latency = Nanoseconds(3.5);
        set_rate(&mut machine, 7e9);
        let after = replay(&workload, &machine);
        assert_eq!(needed(&before), needed(&after), "seed {seed}");
        if machine.tiles().vru.speculation == 0 {
            assert_eq!(before.actions, after.actions, "seed {seed}");
            assert_eq!(before.served, after.served, "seed {seed}");
        }
    }
}

type Knob = (&'static str, fn(&mut Machine));

/// Changes that ought to help.
const HELP: [Knob; 10] = [
    ("a larger tile-list buffer", |m| m.tiles_mut().buffers.tile_list.capacity.0 *= 2),
    ("a larger sorting buffer", |m| m.tiles_mut().buffers.sorting.capacity.0 *= 2),
    ("a larger feature buffer", |m| m.tiles_mut().buffers.feature.capacity.0 *= 2),
    ("a larger pixel buffer", |m| m.tiles_mut().buffers.pixel_out.capacity.0 *= 2),
    ("more arithmetic", |m| m.tiles_mut().ccu.operations_per_cycle = 1000),
    ("a shorter CCU", |m| m.tiles_mut().ccu.latency = 0),
    ("a shorter QSU", |m| m.tiles_mut().gsu.qsu_latency = 0),
    ("a shorter BSU", |m| m.tiles_mut().gsu.bsu_latency = 0),
    ("a shorter VRU", |m| m.tiles_mut().vru.latency = 0),
    ("more rendering units", |m| m.tiles_mut().vru.units_per_core *= 4),
];

fn help(name: &str) -> Change {
    HELP.iter().find(|knob| knob.0 == name).expect("a knob").1
}

/// Frame length before and after a change.
fn effect(seed: u64, prepare: fn(&mut Machine), change: fn(&mut Machine)) -> (u64, u64) {
    let (mut machine, workload) = case(seed);
    machine.dram.model = DramModel::Bandwidth;
    prepare(&mut machine);
    let before = replay(&workload, &machine).timing.frame;
    change(&mut machine);
    (before, replay(&workload, &machine).timing.frame)
}

fn alone(machine: &mut Machine) {
    machine.tiles_mut().ccu.units = 1;
    machine.tiles_mut().vru.cores = 1;
}

fn alone_with_fast_memory(machine: &mut Machine) {
    alone(machine);
    set_rate(machine, 1e18);
    machine.dram.latency = Nanoseconds(0.0);
}

#[test]
fn nothing_that_helps_one_core_without_contention_makes_it_slower() {
    for (name, change) in HELP {
        let (mut shorter, mut longer) = (0, 0);
        for seed in 0..CASES {
            let (machine, frame) = case(seed);
            // The chunks of a whole list that is merged may go before those that a tile looks for.
            if machine.tiles().gsu.implementation == GsuImpl::Merge && !frame.groups.is_empty() {
                continue;
            }
            let (before, after) = effect(seed, alone_with_fast_memory, change);
            // But for a cycle: requests of one cycle are served one after the other, and who comes
            // first depends on the others.
            assert!(after <= before + 1, "{name}, seed {seed}: {before} to {after} cycles");
            longer += u64::from(after > before);
            shorter += u64::from(after < before);
        }
        assert!(longer * 50 <= CASES, "{name} took {longer} cycles");
        // Pixels leave at once when the memory is fast, so their buffer never matters here.
        assert_eq!(shorter == 0, name == "a larger pixel buffer", "{name} helped {shorter} times");
    }
}

/// With a shared memory the law fails: who asks earlier is served earlier, and a unit that is
/// quicker or has more room may put a request that no unit waits for yet in front of one that
/// stalls a unit. With several cores, the tile that a core takes depends on who is free first, and
/// the last long tile may land behind another one. A larger input buffer holds larger batches, and
/// the first of them arrives later. These cases exist; when they vanish, the rules have changed.
#[test]
fn contention_and_scheduling_have_anomalies() {
    let faster: Change = |m| {
        let rate = m.dram_peak().0;
        set_rate(m, 1.5 * rate);
    };
    let shared: [(&str, Change, Change); 5] = [
        ("a larger input buffer, one core, fast memory", alone_with_fast_memory, |m| {
            m.tiles_mut().buffers.gaussian_in.capacity.0 *= 2;
        }),
        ("a faster memory, several cores", |_| (), faster),
        ("a larger feature buffer, one core", alone, help("a larger feature buffer")),
        ("a shorter CCU, one core", alone, help("a shorter CCU")),
        ("a shorter VRU, several cores", |_| (), help("a shorter VRU")),
    ];
    for (name, prepare, change) in shared {
        let effects: Vec<_> = (0..3 * CASES).map(|seed| effect(seed, prepare, change)).collect();
        let worse = effects.iter().filter(|(before, after)| after > before).count();
        let better = effects.iter().filter(|(before, after)| after < before).count();
        assert!(worse > 0, "no anomaly is left: {name}");
        assert!(worse * 3 < better, "{name}: {worse} worse, {better} better");
    }
}

/// Tiles of one chunk each.
fn even_tiles(n: usize, entries: u32, pairs: u32) -> Vec<TilePlan> {
    let tile = || TilePlan { chunks: vec![(entries, pairs)], unfetched: 0, pixels: 256 };
    std::iter::repeat_with(tile).take(n).collect()
}

#[test]
fn one_tile_has_a_closed_form() {
    let mut machine = gscore();
    machine.dram.latency = Nanoseconds(50.0);
    let frame = workload(machine.tiles().geometry, 0, &even_tiles(1, 200, 300));
    // At 51.2 GB/s and 1 GHz a byte takes 20 of the 1024 ticks of a cycle.
    let read = |from: f64, bytes: u32| (from + f64::from(bytes) * 20.0 / 1024.0 + 50.0).ceil();
    // There is nothing to convert, so the tile begins at once.
    let list = read(0.0, 200 * 4);
    // The BSU takes ceil(200 / 16) = 13 rows through one sort and four merges of 4 + 13 cycles.
    let sorted = list + 5.0 * 17.0;
    let features = read(list, 200 * 19 + 100 * 103);
    // 100 colours of 133 operations, 133 a cycle, and two cycles until the last one is there.
    let coloured = features + 100.0 + 2.0;
    // A cycle to open, 300 pairs of 4, 192 to drain, 256 pixels on 16 units.
    let rendered = sorted.max(coloured) + 1.0 + 300.0 * 4.0 + 192.0 + 16.0;
    let written = rendered + (256.0 * 3.0 * 20.0 / 1024.0f64).ceil();
    let timing = replay(&frame, &machine).timing;
    assert_eq!((timing.preprocessing_end, timing.frame), (0, written as u64));
}

#[test]
fn rendering_bounds_a_frame_with_fast_memory() {
    let mut machine = gscore();
    set_rate(&mut machine, 1e15);
    machine.dram.latency = Nanoseconds(0.0);
    let frame = workload(machine.tiles().geometry, 0, &even_tiles(400, 256, 500));
    // 100 tiles a core, each one cycle to open, 500 pairs of 4, 192 to drain, 16 to finish.
    let bound = 100 * (1 + 500 * 4 + 192 + 16);
    let timing = replay(&frame, &machine).timing;
    // Above the bound: the first list, its 128 colours in 130 cycles, the last write.
    assert!((bound..bound + 140).contains(&timing.frame), "{} for {bound}", timing.frame);
    assert_eq!(timing.units[3].busy, 4 * bound * 16);
    let colour = timing.unit(UNITS).expect("colour units");
    assert_eq!((colour.instances, colour.busy), (4, 400 * 128));
    let colours = replay(&frame, &machine).actions.count(Phase::Rendering, work_id("sh-colour"));
    assert_eq!(colours, 400 * 128);
    let waits = timing.units[3].stalls[COLOURS.index()];
    assert!(waits < 4 * 16 * 140, "{waits}");
}

/// With 7 operations a cycle the colours of a chunk take 2,432 cycles and hide its rendering.
#[test]
fn colours_bound_a_frame_whose_colour_units_are_slow() {
    let mut machine = gscore();
    set_rate(&mut machine, 1e15);
    machine.dram.latency = Nanoseconds(0.0);
    machine.tiles_mut().vru.colour_operations_per_cycle = 7;
    let frame = workload(machine.tiles().geometry, 0, &even_tiles(400, 256, 500));
    let of = |machine: &Machine, frame: &FrameWorkload| replay(frame, machine).timing;
    let timing = of(&machine, &frame);
    let chunk = (128 * 133_u64).div_ceil(7);
    // Behind the colours of the last chunk: its rendering, 500 pairs of 4 cycles and the rest.
    let bound = 100 * chunk + 500 * 4 + 192 + 16;
    assert!((bound..bound + 120).contains(&timing.frame), "{} for {bound}", timing.frame);
    assert_eq!(timing.unit(UNITS).expect("colour units").busy, 400 * chunk);
    assert!(timing.units[3].stalls[COLOURS.index()] > 0);
    // Colours of degree 0 take 6 operations of the 133.
    let flat = FrameWorkload { sh_degree: ShDegree::new(0).expect("a degree"), ..frame.clone() };
    let flat = of(&machine, &flat);
    assert_eq!(flat.unit(UNITS).expect("colour units").busy, 400 * (128 * 6_u64).div_ceil(7));
    // Colours that are there before sorting need no such unit.
    machine.tiles_mut().ccu.fetch = Fetch::VisibleColour;
    assert_eq!(of(&machine, &frame).unit(UNITS), None);
}

#[test]
fn bandwidth_bounds_a_frame_with_slow_memory() {
    let mut machine = gscore();
    set_rate(&mut machine, 1e9);
    machine.dram.efficiency = 0.8;
    let frame = workload(machine.tiles().geometry, 20_000, &even_tiles(400, 256, 10));
    let replay = replay(&frame, &machine);
    let total = replay.served.total();
    let bound = (total.read + total.write) as f64 / 0.8;
    let frame = replay.timing.frame as f64;
    // The memory idles only while the CCUs drain at the barrier and while the last tile renders.
    assert!(bound <= frame && frame < bound * 1.01, "{frame} for {bound}");
}

#[test]
fn more_ccus_and_wider_tests_help_when_they_are_the_limit() {
    let mut machine = gscore();
    set_rate(&mut machine, 1e15);
    machine.tiles_mut().buffers.gaussian_in.capacity = Bytes(1 << 20);
    machine.tiles_mut().buffers.tile_list.capacity = Bytes(1 << 20);
    machine.tiles_mut().ccu.latency = 0;
    let mut frame = workload(machine.tiles().geometry, 64_000, &[]);
    frame.counters.obb_prepared = 16_000;
    frame.counters.obb_tests = 96_000;
    let end = |units, tests| {
        let mut machine = machine.clone();
        (machine.tiles_mut().ccu.units, machine.tiles_mut().ccu.intersection_units) =
            (units, tests);
        replay(&frame, &machine).timing.preprocessing_end as f64
    };
    // 48,000 records without tests take a cycle each, 16,000 hold the entry for 6 tests.
    for (units, tests, cycles) in [(1, 1, 144_000.0), (4, 1, 36_000.0), (4, 3, 20_000.0)] {
        let end = end(units, tests);
        // The fill: two reads of 100 cycles latency.
        assert!((cycles..cycles + 250.0).contains(&end), "{end} for {cycles}");
    }
}

/// The pieces of all requests.
#[derive(Default)]
struct Requests(Vec<(bool, u64, u64)>);

impl Requests {
    /// Bytes read, as often as they are, that are neither in `uploaded` nor written by any request.
    fn orphans(&self, uploaded: &[Range<u64>]) -> u64 {
        let mut written: Vec<Range<u64>> = Vec::new();
        let mut writes: Vec<_> = self.0.iter().filter(|r| r.0).map(|r| r.1..r.1 + r.2).collect();
        writes.sort_unstable_by_key(|w| w.start);
        for write in uploaded.iter().cloned().chain(writes) {
            match written.last_mut() {
                Some(last) if last.start <= write.start && write.start <= last.end => {
                    last.end = last.end.max(write.end);
                }
                _ => written.push(write),
            }
        }
        let is_there = |from: u64, to: u64| written.iter().any(|w| w.start <= from && to <= w.end);
        let reads = self.0.iter().filter(|r| !r.0 && !is_there(r.1, r.1 + r.2));
        reads.map(|r| r.2).sum()
    }
}

impl Observer for Requests {
    fn wants_requests(&self) -> bool {
        true
    }

    fn span(&mut self, _: Span) {}

    fn request(&mut self, is_write: bool, address: u64, bytes: u64) {
        self.0.push((is_write, address, bytes));
    }
}

/// Every address that is read was uploaded with the scene or is written in the frame, and where the
/// machine says that nobody writes features, it is they and no others.
#[test]
fn every_byte_that_is_read_was_written_or_uploaded() {
    let (mut clean, mut orphaned) = (0, 0);
    for seed in 0..CASES / 10 {
        let mut machine = Dice::new(seed).machine();
        if machine.tiles().ccu.fetch != Fetch::LazyColour {
            machine.tiles_mut().record.projected = machine.tiles().record.feature;
            machine.tiles_mut().record.feature_source = FeatureSource::Ccu;
        }
        let workload = bin(&dense_frame(seed), machine.tiles().geometry);
        // Lists with pointers for every second machine that can have them.
        Dice::new(seed + CASES).lists(&mut workload.clone(), &mut machine, false);
        let lists = machine.tiles().list_shape().map(|shape| ListWrites::new(&workload, shape));
        let context = FrameContext { lists: lists.as_ref(), ..FrameContext::default() };
        let mut seen = Requests::default();
        let replay = replay_with(&workload, &machine, context, &Memo::default(), &mut seen);
        let units = ResolvedUnits::for_frame(&machine, &workload);
        let plan = Plan::new(&workload, &machine, &units, &context);
        let uploaded = Layout::new(&workload, &units, &plan, &context).uploaded();
        let orphans = seen.orphans(&uploaded);
        let expected = match machine.tiles().record.feature_source {
            FeatureSource::Ccu => 0,
            FeatureSource::Nobody => replay.unwritten,
        };
        if machine.tiles().vru.speculation == 0 {
            assert_eq!(orphans, expected, "seed {seed}");
        }
        // Chunks that are fetched and not needed are not in what a frame must read.
        assert!(orphans >= expected && (expected > 0 || orphans == 0), "seed {seed}");
        clean += u64::from(expected == 0);
        orphaned += u64::from(expected > 0);
    }
    assert!(clean > 10 && orphaned > 10, "{clean} {orphaned}");
}

/// A request of many bytes is one range in pieces of a mebibyte, one behind the other.
#[test]
fn pieces_of_a_request_follow_each_other() {
    let (machine, workload) = case(1);
    let (units, context) = (ResolvedUnits::new(&machine), FrameContext::default());
    let plan = Plan::new(&workload, &machine, &units, &context);
    let layout = Layout::new(&workload, &units, &plan, &context);
    let whole = AddressRange { address: 5 << 20, bytes: (3 << 20) + 7 };
    let (mut cursor, mut at) = (0, whole.address);
    while let Some(piece) = layout.piece(&AccessPattern::Run(whole), &mut cursor) {
        assert!(piece.address == at && (1..=1 << 20).contains(&piece.bytes), "{piece:?}");
        at += piece.bytes;
    }
    assert_eq!(at, whole.address + whole.bytes);
}
