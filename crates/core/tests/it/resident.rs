//! Machines with resident pixels: work against a count pixel by pixel, time against an oracle.

mod oracle;

use powergs_base::budget::Budget;
use powergs_base::quantity::Bytes;
use powergs_core::flow::resident::work::{RegionEntry, RegionShape, ResidentFrame};
use powergs_core::flow::resident::{self, Cut, TakenRegions};
use powergs_core::flow::steps::{StepCycles, StepPart};
use powergs_core::flow::{FlowOutcome, FrameTask, Handed, History};
use powergs_core::kernel::Memo;
use powergs_core::kernel::timeline::Timeline;
use powergs_core::machine::Machine;
use powergs_core::sim::contract::{Trial, broken};
use powergs_core::workload::demand::Unbinnable;
use powergs_frame::splat::Ellipse;
use powergs_frame::trace::Frame;
use rand::RngExt;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::pipeline::slow_or;
use crate::workload::support::{dense_frame, moved_frame, small_frame};

/// A machine that has everything, small.
const MACHINE: &str = r#"
name = "resident"
description = "for tests"
dataflow = "resident"
clock = "1 GHz"
energy = "resident-28nm"

[region]
width = 64
height = 64
cut = "box"

[gaussian]
position = "12 B"
shape = "32 B"
colour = "48 B"
colour-pitch = "64 B"
feature = "36 B"
feature-pitch = "64 B"
entry = "8 B"
pixel = "3 B"

[front]
units = 2
operations-per-cycle = 426
cull = 47
project = 208
shade = 133
entries-per-cycle = 1
latency = 30
batch = 64
queue = 4

[order]
units = 2
ways = 16
keys-per-cycle = 1
latency = 4

[raster]
engines = 2
lanes = 16
latency = 3
chunk = 32
pixel-state = "16 B"

[stores]
records = { capacity = "32 KiB", word = "32 B", banks = 2, ports = "1rw" }
results = { capacity = "16 KiB", word = "16 B", banks = 2, ports = "1rw" }
keys = { capacity = "8 KiB", word = "16 B", banks = 8, ports = "1rw" }
gaussians = { capacity = "8 KiB", word = "64 B", banks = 2, ports = "1rw" }
pixels = { capacity = "256 KiB", word = "16 B", banks = 16, ports = "1r1w" }

[dram]
model = "bandwidth"
efficiency = 0.8
latency = "100 ns"
device = "lpddr4-3200-x16x2"
channels = 2
mapping = "RoBaCoCh"
controller-latency = "40 ns"
"#;

fn machine(sets: &[String]) -> Result<Machine, String> {
    Machine::parse_with(MACHINE, sets).map_err(|e| e.to_string())
}

/// Cycles of some pixels, lane by lane: a step ends when the words of the pixels in it are through
/// the banks.
fn stepped(pixels: u32, shape: RegionShape) -> u32 {
    let (mut left, mut cycles) = (pixels, 0);
    while left > 0 {
        let step = left.min(shape.lanes);
        left -= step;
        let mut words = step * shape.words;
        cycles += 1;
        while words > shape.banks {
            words -= shape.banks;
            cycles += 1;
        }
    }
    cycles
}

/// Entries of a frame, pixel by pixel: region, rank, cycles, pixels, live ones, rows.
fn naive(frame: &Frame, shape: RegionShape) -> Vec<[u32; 6]> {
    let camera = &frame.facts.camera;
    let of = |own: u32, image: u32| if own == 0 { image } else { own };
    let [w, h] = [of(shape.width, camera.width), of(shape.height, camera.height)];
    let mut all = Vec::new();
    let columns = camera.width.div_ceil(w);
    for region in 0..columns * camera.height.div_ceil(h) {
        let (left, top) = (region % columns * w, region / columns * h);
        for (splat, rank) in frame.splats.iter().zip(0..) {
            let Some(conic) = splat.conic() else { continue };
            let radius = splat.radius();
            let ellipse = Ellipse::new(splat, conic);
            let is_covered = |x: u32, y: u32| {
                let [dx, dy] = [x as f32 - splat.mean[0], y as f32 - splat.mean[1]];
                let row = ellipse.as_ref().and_then(|e| e.columns(y.into(), i64::from(y) + 1));
                let in_row = row.is_some_and(|(a, b)| (a..b).contains(&x.into()));
                dx.abs() <= radius && dy.abs() <= radius && (shape.cut != Cut::Exact || in_row)
            };
            let (mut pixels, mut live, mut cycles, mut rows) = (0, 0, 0, 0);
            for y in top..(top + h).min(camera.height) {
                let row = (left..(left + w).min(camera.width)).filter(|&x| is_covered(x, y));
                let row: Vec<u32> = row.collect();
                pixels += row.len() as u32;
                cycles += stepped(row.len() as u32, shape);
                rows += u32::from(!row.is_empty() && shape.cut == Cut::Exact);
                let stop = |x: u32| frame.pixels.stop_rank[(y * camera.width + x) as usize];
                live += row.iter().filter(|&&x| rank <= stop(x)).count() as u32;
            }
            if shape.cut == Cut::Box {
                cycles = stepped(pixels, shape);
            }
            if pixels > 0 {
                all.push([region, rank, cycles, pixels, live, rows]);
            }
        }
    }
    all
}

/// What cutting a frame takes is known before: no less than what is left of it, and not many times
/// as much. What is counted are entries of bounding squares.
#[test]
fn the_memory_of_regions_is_known_before_they_are_cut() {
    for (seed, cut) in (0..12).zip(Cut::ALL.into_iter().cycle()) {
        let frame = small_frame(seed);
        let shape =
            RegionShape { width: 16, height: 8, cut, lanes: 4, words: 0, banks: 1, depths: false };
        let bytes = shape.key().demand(&frame, Budget::DEFAULT).expect("a small frame");
        let work = shape.key().prepare(&frame);
        let held = work.bytes() as u64;
        assert!((held..8 * held + 100_000).contains(&bytes), "seed {seed}: {bytes} {held}");
        let squares = RegionShape { cut: Cut::Box, ..shape };
        let entries = ResidentFrame::new(&frame, squares).entries.len() as u64;
        match shape.key().demand(&frame, Budget(Bytes(bytes - 1))).expect_err("too little") {
            Unbinnable::Memory { pairs, over } => {
                assert_eq!((pairs, over.needed), (entries, bytes), "seed {seed}");
            }
            Unbinnable::Pairs(pairs) => panic!("{pairs} fit into 32 bits"),
        }
    }
}

#[test]
fn regions_are_those_of_a_count_pixel_by_pixel() {
    // Width, height, lanes, words, banks.
    let shapes = [
        (16, 16, 4, 0, 1),
        (64, 64, 16, 2, 16),
        (0, 0, 16, 1, 5),
        (0, 8, 3, 0, 1),
        (25, 64, 7, 3, 2),
        (70, 20, 64, 1, 8),
    ];
    (0..4_u64).into_par_iter().for_each(|seed| {
        let frame = small_frame(seed);
        for (width, height, lanes, words, banks) in shapes {
            for cut in Cut::ALL {
                let shape = RegionShape { width, height, cut, lanes, words, banks, depths: false };
                let ours = ResidentFrame::new(&frame, shape);
                let entries = (0..).zip(&ours.regions).flat_map(|(region, facts)| {
                    let of =
                        move |e: &RegionEntry| [region, e.rank, e.cycles, e.pixels, e.live, e.rows];
                    ours.of(facts).iter().map(of)
                });
                let expected = naive(&frame, shape);
                assert_eq!(entries.collect::<Vec<_>>(), expected, "seed {seed}, {shape:?}");
                for (region, facts) in (0..).zip(&ours.regions) {
                    let own = expected.iter().filter(|entry| entry[0] == region);
                    let last =
                        own.clone().zip(1..).filter(|(e, _)| e[4] > 0).map(|(_, n)| n).last();
                    assert!(facts.saturated >= last.unwrap_or(0), "nothing live is left out");
                    assert_eq!(facts.entries as usize, own.count());
                }
                assert_eq!(RegionShape::of(&shape.key().numbers), shape);
            }
        }
    });
}

/// How many random machines step through random frames, and with `RUN_SLOW_TESTS=1`.
pub const CASES: [u64; 2] = [500, 5000];

/// A setting of a random machine: its key, and the values that it may have.
type Choice = (&'static str, &'static [&'static str]);

/// What all machines may differ in.
const CHOICES: [Choice; 34] = [
    ("region.cut", &["box", "rows", "exact"]),
    ("region.width", &["0", "16", "64"]),
    ("region.height", &["0", "16", "64"]),
    ("gaussian.colour", &["0 B", "48 B", "180 B"]),
    ("gaussian.colour-pitch", &["192 B"]),
    ("gaussian.pixel", &["0 B", "3 B"]),
    ("front.units", &["1", "3"]),
    ("front.operations-per-cycle", &["1", "400", "20000"]),
    ("front.entries-per-cycle", &["1", "4"]),
    ("front.latency", &["0", "9"]),
    ("front.batch", &["32", "64", "256"]),
    ("front.queue", &["1", "2", "16"]),
    ("order.units", &["1", "2", "5"]),
    ("order.ways", &["2", "16"]),
    ("order.keys-per-cycle", &["1", "4"]),
    ("order.latency", &["0", "4"]),
    ("raster.engines", &["1", "2", "3", "6"]),
    ("raster.lanes", &["1", "4", "16", "256"]),
    ("raster.latency", &["0", "3"]),
    ("raster.chunk", &["1", "7", "64"]),
    ("raster.saturation", &["false", "false", "true"]),
    ("stores.records.capacity", &["1 KiB", "64 KiB"]),
    ("stores.results.capacity", &["1 KiB", "16 KiB"]),
    ("stores.keys.capacity", &["0 B", "1 KiB", "64 KiB"]),
    ("stores.gaussians.capacity", &["0 B", "1 KiB", "64 KiB"]),
    ("stores.pixels.capacity", &["192 KiB", "384 KiB", "1 MiB", "4 MiB"]),
    ("stores.pixels.ports", &["1rw", "1r1w"]),
    ("stores.pixels.banks", &["1", "16"]),
    ("dram.model", &["bandwidth", "banked", "calibrated"]),
    ("dram.channels", &["1", "2"]),
    ("dram.latency", &["0 ns", "100 ns"]),
    ("dram.second-master.rate", &["0 B/s", "0 B/s", "300 MB/s", "2 GB/s"]),
    ("front.overlap", &["none", "none", "frames"]),
    ("front.lazy", &["false", "false", "false", "true"]),
];

/// What those that look for the ends of rows may differ in as well.
const ROWS: [Choice; 2] = [("raster.row-cycles", &["1", "1", "5"]), ("front.row", &["0", "13"])];

/// A buffer for a tail unit.
const TAIL_STORE: &str =
    r#"stores.tail={ capacity = "32 KiB", word = "64 B", banks = 1, ports = "1rw" }"#;

/// What those with tail units may differ in besides.
const TAIL: [Choice; 4] = [
    ("tail.share", &["0.1", "0.5", "1.0"]),
    ("tail.lanes", &["1", "4"]),
    ("tail.latency", &["0", "3"]),
    (
        "stores.tail",
        &[
            r#"{ capacity = "64 B", word = "64 B", banks = 1, ports = "1rw" }"#,
            r#"{ capacity = "1 KiB", word = "64 B", banks = 2, ports = "1rw" }"#,
            r#"{ capacity = "64 KiB", word = "64 B", banks = 2, ports = "1rw" }"#,
        ],
    ),
];

/// What those with depth slices may differ in besides.
const SLICES: [Choice; 6] = [
    ("region.slices", &["2", "3"]),
    ("compose.lanes", &["1", "4", "64"]),
    ("compose.through", &["dram", "stores", "stores"]),
    // Small regions in small buffers, so that slices that stay are in the way.
    ("region.width", &["16", "16", "64"]),
    ("region.height", &["16", "16", "0"]),
    ("stores.pixels.capacity", &["12 KiB", "24 KiB", "4 MiB"]),
];

/// What those with levels of detail may differ in besides.
const LEVELS: [Choice; 6] = [
    ("levels.gaussians", &["1", "16", "512"]),
    ("levels.children", &["2", "8"]),
    ("levels.period", &["1", "3"]),
    ("levels.operations", &["5", "48"]),
    ("levels.operations-per-cycle", &["1", "48"]),
    ("levels.entry", &["1 B", "40 B"]),
];

/// What those that move pixels may differ in besides.
const PIXELS: [Choice; 6] = [
    ("pixels.impl", &["warped"]),
    ("pixels.holes", &["0.0", "0.1", "0.6"]),
    ("pixels.depth", &["1 B", "2 B"]),
    ("pixels.per-cycle", &["1", "16"]),
    ("front.overlap", &["none"]),
    // Regions of which some are rendered and others are not.
    ("region.width", &["16", "32", "0"]),
];

fn draw((key, values): &Choice, dice: &mut Pcg64Mcg) -> String {
    format!("{key}={}", values[dice.random_range(0..values.len())])
}

/// The settings of a random machine.
fn settings(dice: &mut Pcg64Mcg) -> Vec<String> {
    let more: &[Choice] = match dice.random_range(0..4) {
        0 => &TAIL,
        1 => &SLICES,
        2 => &PIXELS,
        _ => &[],
    };
    let mut all: Vec<String> =
        CHOICES.iter().chain(more).map(|choice| draw(choice, dice)).collect();
    if dice.random_range(0..3) == 0 {
        all.extend(LEVELS.iter().map(|choice| draw(choice, dice)));
    }
    if all.iter().any(|set| set == "region.cut=exact") {
        all.extend(ROWS.iter().map(|choice| draw(choice, dice)));
    }
    all
}

/// A machine that differs in one key, and needs the same of a frame.
fn another(than: &Machine, sets: &[String], dice: &mut Pcg64Mcg) -> Machine {
    loop {
        let one = draw(&CHOICES[dice.random_range(0..CHOICES.len())], dice);
        if let Ok(other) = machine(&[sets, &[one]].concat())
            && other.flow().work_key(&other) == than.flow().work_key(than)
        {
            return other;
        }
    }
}

fn run(case: &ResidentCase, machine: &Machine, memo: &Memo) -> Option<FlowOutcome> {
    machine.flow().run(&case.task(machine, memo), None).ok()
}

/// A random machine, its frame, and what it takes over from the one before.
struct ResidentCase {
    machine: Machine,
    work: ResidentFrame,
    before: Option<Handed>,
}

impl ResidentCase {
    /// What was drawn may contradict itself, or not fit.
    fn new(seed: u64, sets: &[String]) -> Option<ResidentCase> {
        let machine = machine(sets).ok()?;
        let shape = RegionShape::of(&machine.flow().work_key(&machine).numbers);
        let frame = small_frame(seed % 50);
        // Another frame from a little further on the side: only its pixels count.
        let earlier = moved_frame(seed % 7, 0.05);
        let [earlier, work] = [earlier, frame].map(|frame| ResidentFrame::new(&frame, shape));
        let mut history = History::default();
        let mut over = |work| machine.flow().hand_over(&machine, work, None, &mut history);
        let before = (over(&earlier), over(&work)).1;
        let case = ResidentCase { machine, work, before };
        let memo = Memo::default();
        case.machine.flow().fits(&case.task(&case.machine, &memo)).ok()?;
        Some(case)
    }

    fn task<'a>(&'a self, machine: &'a Machine, memo: &'a Memo) -> FrameTask<'a> {
        FrameTask { before: self.before.as_ref(), ..FrameTask::first(machine, &self.work, memo) }
    }

    fn taken(&self) -> Option<&TakenRegions> {
        self.before.as_ref().and_then(|before| before.downcast_ref())
    }
}

/// The machine that the oracle steps through with this seed, if there is one.
pub fn stepped_machine(seed: u64) -> Option<Machine> {
    let sets = settings(&mut Pcg64Mcg::seed_from_u64(seed));
    ResidentCase::new(seed, &sets).map(|case| case.machine)
}

/// Compares a frame on a machine with the oracle, alone and with what another machine left in the
/// memo; the symbols of states that came up.
fn compare(seed: u64) -> Option<String> {
    let mut dice = Pcg64Mcg::seed_from_u64(seed);
    let sets = settings(&mut dice);
    let drawn = ResidentCase::new(seed, &sets)?;
    let ResidentCase { machine, work, .. } = &drawn;
    let memo = Memo::default();
    let task = drawn.task(machine, &memo);
    let mut timeline = Timeline::default();
    let observer = Some(&mut timeline as &mut dyn powergs_core::kernel::timeline::Observer);
    let alone = machine.flow().run(&task, observer).expect("it fits");
    let taken = drawn.taken();
    let made = taken.and_then(|taken| taken.made.as_ref()).unwrap_or(work);
    let some = taken.map(|taken| &taken.some);
    let calibration = resident::calibration(machine, made, some, &Memo::default());
    let seen = oracle::run(machine, made, some, calibration.as_deref());
    let (own, expected) = (timeline.draw(), seen.draw());
    let case = || format!("seed {seed}\n{machine:#?}");
    if own != expected {
        let at = own.lines().zip(expected.lines()).map(|(a, b)| {
            a.bytes().zip(b.bytes()).position(|(a, b)| a != b).unwrap_or(a.len().min(b.len()))
        });
        let at = at.min().unwrap_or(0).saturating_sub(60);
        let part = |text: &str| -> String {
            let line = |line: &str| -> String {
                let name = line.split('|').next().unwrap_or("");
                format!("{name:<10}{}\n", line.chars().skip(at).take(120).collect::<String>())
            };
            text.lines().map(line).collect()
        };
        panic!("from {at}, flow:\n{}\noracle:\n{}\n{}", part(&own), part(&expected), case());
    }
    assert_eq!(alone.timing.frame, seen.frame, "{}", case());
    assert_eq!(alone.timing.preprocessing_end, seen.preprocessing_end, "{}", case());
    assert_eq!(alone.timing.dram.requests_served, seen.requests, "{}", case());
    assert_eq!(alone.served.stages.map(|stage| stage.read), seen.read, "{}", case());
    assert_eq!(alone.served.stages.map(|stage| stage.write), seen.write, "{}", case());
    let cycles: u64 =
        alone.timing.units.iter().map(|unit| seen.frame * u64::from(unit.instances)).sum();
    let spans: u64 = timeline.spans.iter().map(|span| span.to - span.from).sum();
    assert_eq!(spans, cycles, "every cycle of every unit is one of its states, {}", case());
    let memo = Memo::default();
    let other = another(machine, &sets, &mut dice);
    let first = run(&drawn, &other, &memo);
    assert_eq!(first, run(&drawn, &other, &Memo::default()), "the other one, {}", case());
    let shared = run(&drawn, machine, &memo);
    assert_eq!(shared.as_ref(), Some(&alone), "behind another one: {other:#?}\n{}", case());
    let mut symbols: Vec<(&str, char)> = (own.lines())
        .filter_map(|line| line.split_once('|'))
        .flat_map(|(unit, row)| row.chars().map(move |symbol| (unit, symbol)))
        .map(|(unit, symbol)| (unit.trim_end_matches([' ', '0', '1', '2', '3', '4', '5']), symbol))
        .map(|(unit, symbol)| (unit, if symbol.is_ascii_digit() { '0' } else { symbol }))
        .collect();
    symbols.sort_unstable();
    symbols.dedup();
    Some(symbols.iter().map(|(unit, symbol)| format!("{unit}:{symbol} ")).collect())
}

#[test]
fn machines_equal_the_cycle_by_cycle_oracle() {
    let all = (0..slow_or(CASES)).into_par_iter().filter_map(compare);
    let all: Vec<String> = all.collect();
    assert!(all.len() as u64 > slow_or(CASES) / 4, "{} of them", all.len());
    // The cases reach every state that the rules know; others never come up.
    let mut reached: Vec<&str> = all.iter().flat_map(|one| one.split_whitespace()).collect();
    reached.sort_unstable();
    reached.dedup();
    let expected = "compose:. compose:0 compose:z front:. front:0 front:o front:r ltu:. ltu:0 \
                    ltu:o ltu:r order:. order:0 order:l order:o order:s pxu:. pxu:0 pxu:f pxu:o \
                    raster:. raster:0 raster:f raster:i raster:k raster:o raster:t raster:v \
                    raster:y tail:. tail:0 tail:f";
    assert_eq!(reached, expected.split(' ').collect::<Vec<_>>());
}

/// A step of training takes what its frame takes, and parts behind it that follow from its lists.
#[test]
fn a_step_goes_once_more_through_the_lists() {
    let frame = dense_frame(1);
    let run = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        let machine = Machine::parse_with(MACHINE, &sets).expect("a machine");
        let flow = machine.flow();
        let work = flow.work_key(&machine).prepare(&frame);
        let memo = Memo::default();
        let outcome = flow.run(&FrameTask::first(&machine, &*work, &memo), None).expect("it runs");
        let cut: ResidentFrame = work.of::<ResidentFrame>().expect("of this dataflow").clone();
        (outcome, cut)
    };
    // A memory that takes no time to speak of: what is left is arithmetic.
    let fast =
        ["dram.device=none", "dram.channels=1", "dram.bandwidth=100 TB/s", "dram.latency=0 ns"];
    let rest = ["training.interval=3", "training.loss=500", "training.chain=300"];
    let (plain, cut) = run(&fast);
    let (step, _) = run(&[&fast[..], &rest].concat());
    let after = StepCycles::find(&step.measured).expect("it trains");
    assert_eq!(step.timing.frame, plain.timing.frame + after.all());
    assert!(StepCycles::find(&plain.measured).is_none());
    // Regions are dealt round over two engines, a step of 16 pixels is three cycles in reverse.
    let mut engines = [0_u64; 2];
    for (i, region) in cut.regions.iter().enumerate() {
        let list = &cut.entries[region.start as usize..][..region.entries as usize];
        let cycles: u64 = list.iter().map(|entry| u64::from(entry.cycles)).sum();
        engines[i % 2] += (3 * cycles).max(1);
    }
    let most = engines.into_iter().max().expect("two");
    let reverse = after.of(StepPart::Reverse);
    assert!((most..most + 200).contains(&reverse), "{reverse} {most}");
    let pixels = 150 * 90;
    let least = pixels * 500 / 426 / 2;
    let loss = after.of(StepPart::Loss);
    assert!((least..2 * least).contains(&loss), "{loss} {least}");
    // Bytes: lists, Gaussians and pixels once more; sums out and in; values, gradients and two
    // moments of all numbers, 4 B each, and the records, which have other widths.
    let (entries, splats) = (cut.entries.len() as u64, cut.index.len() as u64);
    let coefficients = cut.sh_degree.coefficients();
    let (stored, points) = (12 + 32 + (48 * coefficients).div_ceil(16), cut.counters.points);
    let numbers = 11 + 3 * coefficients;
    let more = |stage: usize| {
        let [a, b] = [&step, &plain].map(|outcome| outcome.served.stages[stage]);
        [a.read - b.read, a.write - b.write]
    };
    assert_eq!(
        more(2),
        [2 * 3 * pixels + entries * (8 + 36) + 28 * pixels, 28 * pixels + 36 * entries]
    );
    assert_eq!(
        more(0),
        [
            36 * entries + stored * splats + 16 * numbers * points,
            4 * numbers * splats + (12 * numbers + stored) * points
        ]
    );
    assert_eq!(more(1), [0, 0]);
}

#[test]
fn it_keeps_the_laws() {
    let frames = [small_frame(0), moved_frame(1, 0.05), moved_frame(2, 0.1), dense_frame(1)];
    let trial = Trial {
        machine: MACHINE,
        files: &[],
        variants: &[
            &[],
            &["region.slices=2", "compose.lanes=4", "stores.pixels.capacity=512 KiB"],
            &["tail.share=0.3", "tail.latency=9", TAIL_STORE],
            &["front.lazy=true", "raster.engines=1", "raster.saturation=true", "region.width=16"],
            &["dram.model=banked", "front.overlap=frames", "region.cut=exact"],
            &["training.interval=2", "training.densify=7"],
            &["training.interval=3", "training.update=visible", "dram.model=banked"],
            &["pixels.impl=warped", "pixels.holes=0.1", "region.width=16", "region.height=16"],
            &["levels.gaussians=4", "levels.operations-per-cycle=1"],
            &["pixels.impl=warped", "pixels.holes=0.6", "pixels.period=2", "region.width=16"],
        ],
        frames: &frames,
        settled: &["raster.saturation=false"],
        // A front that asks for more at once is in the way of the engines.
        slack: 0.1,
        idle_keys: &[],
    };
    // Colours of scenes of degree 0, as these, lie as near as their alignment lets them.
    assert_eq!(broken(&trial), ["`gaussian.colour-pitch` moves nothing"]);
}
