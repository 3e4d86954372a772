//! A whole frame of a GPU, cycle by cycle, from the module documentation of `flow::gpu`: kernels
//! one after the other, blocks of threads in turn, the memory tick by tick, and a unit beside them.
//! What a kernel has to do (instructions, bytes, additions) is shared, and so are the blocks of a
//! unit.

use std::collections::BTreeMap;

use powergs_base::config::embedded::MACHINES;
use powergs_core::flow::gpu::stages::LAUNCHING;
use powergs_core::flow::gpu::warps::{FrameWarps, WarpShape};
use powergs_core::flow::gpu::{
    AttachedOverlap, BlendSpec, Gpu, GpuKernel, GradientSum, KernelPart, Kernels, STREAMS, WARP,
};
use powergs_core::flow::over::pixels::SomePixels;
use powergs_core::flow::{FlowOutcome, FrameTask, History};
use powergs_core::kernel::Memo;
use powergs_core::kernel::dram::Dram;
use powergs_core::kernel::memory::Ranges;
use powergs_core::kernel::timeline::{Observer, Timeline};
use powergs_core::machine::Machine;
use powergs_core::workload::FrameWorkload;
use powergs_frame::trace::Frame;
use powergs_testkit::scenes::{front_camera, random_scene};
use rayon::prelude::*;

use super::workload;
use crate::oracle_blocks::{Block, Mover};
use crate::oracle_memory::{Memory, Ticket};
use crate::pipeline::slow_or;
use crate::pipeline::support::Dice;
use crate::workload::support::rendered;

/// How many random machines are drawn, and with `RUN_SLOW_TESTS=1`. Some contradict themselves.
pub const CASES: [u64; 2] = [400, 4000];

const FRAMES: u64 = 20;

/// No frame takes so many cycles.
const LONGEST: u64 = 1 << 22;

type Choice = (&'static str, &'static [&'static str]);

const CHOICES: [Choice; 18] = [
    ("clock", &["500 MHz", "1 GHz", "1.7 GHz"]),
    ("sm.units", &["1", "2", "5"]),
    ("sm.interval", &["1", "7", "20"]),
    ("sm.blocks", &["1", "2", "16"]),
    ("l2.capacity", &["0 B", "4 KiB", "64 KiB", "1 GiB"]),
    ("l2.bytes-per-cycle", &["64", "384"]),
    ("launch.gap", &["0 ns", "30 ns", "300 ns"]),
    ("launch.readback", &["0 ns", "700 ns"]),
    ("blend.tile", &["8", "16"]),
    ("blend.batch", &["7", "32"]),
    ("blend.warp-width", &["4", "8"]),
    ("blend.latency", &["0", "300"]),
    ("blend.test", &["0", "4"]),
    ("convert.cull", &["depth", "frustum"]),
    ("radix.count", &["once", "each-pass"]),
    ("dram.latency", &["0 ns", "400 ns"]),
    (
        "dram.model",
        &[
            "bandwidth",
            "bandwidth",
            "banked\ndram.device=lpddr4-3200-x16x8",
            "banked\ndram.device=lpddr4-3200-x16x8\ndram.second-master.rate=2 GB/s",
        ],
    ),
    ("pairs.test", &["aabb", "obb", "ellipse"]),
];

const TRAINING: [Choice; 4] = [
    ("training.sum", &["pixel", "warp", "block"]),
    ("training.update", &["all", "visible", "none", "pose"]),
    ("training.densify", &["0", "9"]),
    ("training.atomics", &["0.5", "8"]),
];

const ATTACHED: [Choice; 4] = [
    ("attached.impl", &["rows", "pixels", "box", "tile"]),
    ("attached.lanes", &["3", "16"]),
    ("attached.clock", &["300 MHz", "1 GHz"]),
    ("attached.overlap", &["none", "frames"]),
];

const ROPS: [Choice; 5] = [
    // Behind the other one, which it replaces.
    ("pairs.test", &["obb"]),
    ("rops.impl", &["boxes"]),
    ("rops.found-per-cycle", &["1", "16"]),
    ("rops.quads-per-cycle", &["1", "16"]),
    ("rops.merge", &["false", "true"]),
];

const PIXELS: [Choice; 1] = [(
    "pixels.impl",
    &[
        "warped\npixels.holes=0.05\nreproject.place=500",
        "warped\npixels.holes=0.6\npixels.period=2\nreproject.fill=300",
        "warped\npixels.holes=0.3\npixels.depth=2 B",
        "sampled\npixels.stride=2",
        "sampled\npixels.stride=4\npixels.pattern=unseen\npixels.period=2",
        "sampled\npixels.stride=9\ntraining.sum=warp",
    ],
)];

/// The machine of a case, where it does not contradict itself.
pub fn machine(seed: u64) -> Option<Machine> {
    let mut dice = Dice::new(seed);
    let more: &[Choice] = match dice.roll(0, 4) {
        0 => &TRAINING,
        1 => &ATTACHED,
        2 => &ROPS,
        3 => &PIXELS,
        _ => &[],
    };
    let mut set = |(key, values): &Choice| -> Vec<String> {
        format!("{key}={}", dice.pick(values)).lines().map(str::to_owned).collect()
    };
    let sets: Vec<String> = CHOICES.iter().chain(more).flat_map(&mut set).collect();
    let file = MACHINES.iter().find(|file| file.name == "xavier-nx").expect("a machine").complete();
    // As wide as a device of the same rate, so that it can be `banked`.
    let file = file.replace("channels = 1", "channels = 8");
    Machine::parse_with(&file, &sets).ok()
}

/// A frame of a hundred splats, and the one before it.
fn frames(seed: u64) -> [Frame; 2] {
    let mut scene = random_scene(seed, 100, [0, 1, 3][seed as usize % 3]);
    scene.logit_opacities.iter_mut().for_each(|o| *o += 2.0);
    [0.0, 0.04].map(|step| {
        let mut camera = front_camera(35, 28);
        camera.centre.x += step;
        camera.world_to_camera *= glam::DMat3::from_rotation_y(step);
        rendered(&scene, &camera).1
    })
}

/// What was seen.
#[derive(Default)]
struct Seen {
    rows: BTreeMap<(usize, usize), String>,
    frame: u64,
    converted: u64,
    launching: u64,
    parts: [u64; KernelPart::ALL.len()],
    requests: u64,
    read: [u64; 3],
    written: [u64; 3],
}

const UNITS: [&str; 3] = ["sm", "attached", "rop"];

impl Seen {
    fn draw(&self) -> String {
        let rows = self.rows.iter();
        rows.map(|((unit, i), row)| format!("{}{i} |{row}\n", UNITS[*unit])).collect()
    }

    fn put(&mut self, unit: usize, instance: usize, symbol: char) {
        self.rows.entry((unit, instance)).or_default().push(symbol);
    }
}

/// A kernel at work.
struct Running<'a> {
    kernel: &'a GpuKernel,
    /// Cycles since it began.
    passed: u64,
    /// Bytes that the cache has not moved, and cycles in which it adds numbers up.
    cached: u64,
    added: u64,
    asked: Vec<Ticket>,
}

impl Running<'_> {
    fn is_over(&self, now: u64, memory: &Memory<Ranges>) -> bool {
        let worked = self.kernel.computes.iter().chain(&self.kernel.raster);
        worked.into_iter().all(|&cycles| cycles <= self.passed)
            && self.cached == 0
            && self.added == 0
            && self.asked.iter().all(|&ticket| memory.is_done(ticket, now))
    }

    fn waits(&self) -> char {
        match self.kernel.part {
            KernelPart::Sort => 'p',
            KernelPart::Reproject | KernelPart::Blend | KernelPart::Loss | KernelPart::Backward => {
                'f'
            }
            _ => 'r',
        }
    }

    /// A multiprocessor: it computes, has no block left, waits for what is drawn, then for what is
    /// moved.
    fn symbol(&self, unit: usize) -> char {
        let all = self.kernel.computes.iter().max().copied().unwrap_or(0);
        let [found, blended] = self.kernel.raster;
        match self.passed {
            passed if passed < self.kernel.computes[unit] => '0',
            passed if passed < all => '.',
            passed if passed < found.max(blended) => {
                if found > blended {
                    'i'
                } else {
                    'o'
                }
            }
            _ => self.waits(),
        }
    }

    /// Raster operations: they draw, and wait for the multiprocessors that shade.
    fn raster(&self) -> char {
        let all = self.kernel.computes.iter().max().copied().unwrap_or(0);
        let [found, blended] = self.kernel.raster;
        match self.passed {
            _ if found + blended == 0 => '.',
            passed if passed < found.max(blended) => '0',
            passed if passed < all => 'i',
            _ => self.waits(),
        }
    }
}

/// Where kernels read and write: the scene, what is made of it, pairs twice, where those of tiles
/// begin, the image, and behind it the frame before and what comes to the places of this one,
/// gradients and moments. And where all of it ends.
fn places(
    gpu: &Gpu,
    work: &FrameWorkload,
    kernels: &Kernels,
    warps: &FrameWarps,
) -> (Vec<[u64; 2]>, [u64; 2], u64) {
    let (c, points) = (&gpu.convert, work.counters.points);
    let draws = kernels.drawn.is_some();
    let scene = points * (c.position.0 + c.shape.0 + c.colour.0);
    let made = scene + points * (c.mark.0 + c.covariance.0 + c.result.0 + 8);
    let pairs = if draws { warps.gaussians[1] } else { work.counters.tile_pairs };
    let array = pairs * (gpu.pairs.key.0 + gpu.pairs.value.0);
    let (sorted, ranges) = (made + array, made + 2 * array);
    let image = ranges + 8 * work.tiles.len() as u64;
    let pixels = u64::from(work.width) * u64::from(work.height);
    let moves = kernels.all.iter().any(|kernel| kernel.part == KernelPart::Reproject);
    let kept = gpu.blend.pixel.0 + if gpu.reprojects() { gpu.pixels.depth.0 } else { 0 };
    let before = image + pixels * kept;
    let nearest = before + pixels * kept;
    let end = if moves { nearest + pixels * 8 } else { before };
    let t = &gpu.training;
    let gaussians = end + pixels * t.loss_bytes.0;
    let parameters = gaussians + points * t.record.0;
    let numbers = 11 + 3 * (u64::from(work.sh_degree.get()) + 1).pow(2);
    let found = t.zeroed.0.max(numbers * t.widths.gradient.0);
    let behind = parameters + points * (found + 2 * numbers * t.widths.moment.0);
    let last_sort = kernels.all.iter().rposition(|kernel| kernel.part == KernelPart::Sort);
    let (mut passes, mut updates, mut moved) = (0, 0, 0);
    let densifies = t.densify > 0;
    let of = |(i, kernel): (usize, &GpuKernel)| match kernel.part {
        KernelPart::Reproject => {
            moved += 1;
            if moved == 1 { [before, nearest] } else { [nearest, image] }
        }
        KernelPart::Convert => [0, scene],
        KernelPart::Pairs => [scene, made],
        KernelPart::Sort if !draws && Some(i) == last_sort => [sorted, ranges],
        // Digits are counted, and nothing is written.
        KernelPart::Sort if kernel.l2[1] == 0 => [made, sorted],
        KernelPart::Sort => {
            passes += 1;
            if passes % 2 == 1 { [made, sorted] } else { [sorted, made] }
        }
        KernelPart::Blend => [sorted, image],
        KernelPart::Loss => [image, end],
        KernelPart::Backward => [sorted, gaussians],
        KernelPart::Chain => [0, parameters],
        KernelPart::Update => {
            updates += 1;
            if densifies && updates == 1 { [parameters; 2] } else { [parameters, 0] }
        }
    };
    let all = kernels.all.iter().enumerate().map(of).collect();
    (all, [sorted, image], if t.sum == GradientSum::None { end } else { behind })
}

/// Steps through a frame.
fn stepped(
    machine: &Machine,
    work: &FrameWorkload,
    kernels: &Kernels,
    warps: &FrameWarps,
    flat: Dram,
) -> Seen {
    let gpu = machine.gpu();
    let (places, beside, end) = places(gpu, work, kernels, warps);
    let mut memory = Memory::new(Ranges { end }, &STREAMS, machine, flat);
    let mut attached = kernels.attached.as_ref().map(|work| {
        let mut unit = Mover::new(["attached-in", "attached-out"], 1);
        let mut at = beside;
        for block in &work.blocks {
            let [read, write] = [(0, block.read), (1, block.write)].map(|(way, bytes)| {
                let address: u64 = at[way];
                at[way] += bytes;
                (bytes, [address, bytes])
            });
            unit.push(Block { items: block.items, read, write });
        }
        unit
    });
    let waits = gpu.attached.overlap == AttachedOverlap::None;
    let mut seen = Seen::default();
    let (mut next, mut running, mut gap) = (0, None::<Running>, 0);
    let (mut now, mut kernels_end) = (0, None);
    loop {
        // Kernels end and begin.
        loop {
            if let Some(own) = running.take_if(|own| own.is_over(now, &memory)) {
                seen.parts[own.kernel.part as usize] += own.passed;
                if own.kernel.part == KernelPart::Convert {
                    seen.converted = now;
                }
                (next, gap) = (next + 1, 0);
            }
            let Some(kernel) = kernels.all.get(next).filter(|_| running.is_none()) else { break };
            if gap < kernel.gap {
                break;
            }
            let streams = match kernel.part {
                KernelPart::Reproject => ["known-in", "known-out"],
                KernelPart::Convert => ["scene", "results"],
                KernelPart::Pairs => ["counts", "pairs-out"],
                KernelPart::Sort => ["keys-in", "keys-out"],
                KernelPart::Blend => ["splats", "picture"],
                KernelPart::Loss | KernelPart::Backward => ["blended-in", "gradients-out"],
                KernelPart::Chain | KernelPart::Update => ["parameters-in", "parameters-out"],
            };
            let mut asked = Vec::new();
            let [read, written] = kernel.memory;
            let [from, to] = places[next];
            if read > 0 {
                asked.push(memory.read(now, streams[0], read, [from, read]));
            }
            if written > 0 {
                asked.push(memory.write(now, streams[1], written, [to, written]));
            }
            let rate = gpu.l2.bytes_per_cycle;
            running = Some(Running {
                kernel,
                passed: 0,
                cached: kernel.l2.iter().sum(),
                added: gpu.training.adding(kernel.atomics, rate),
                asked,
            });
        }
        let are_over = next == kernels.all.len();
        if are_over {
            kernels_end.get_or_insert(now);
        }
        if let Some(unit) = attached.as_mut().filter(|_| are_over || !waits) {
            unit.step(now, &mut memory);
            if unit.is_done() && seen.parts[KernelPart::Blend as usize] == 0 {
                let begins = if waits { kernels_end.unwrap_or(now) } else { 0 };
                seen.parts[KernelPart::Blend as usize] = now - begins;
            }
        }
        if are_over && attached.as_ref().is_none_or(Mover::is_done) {
            break;
        }
        for unit in 0..gpu.sm.units as usize {
            let symbol = match &running {
                Some(own) => own.symbol(unit),
                None if are_over => '.',
                None => 'g',
            };
            seen.put(0, unit, symbol);
        }
        if let Some(unit) = &mut attached {
            seen.put(1, 0, unit.symbol());
            unit.tick();
        }
        if kernels.drawn.is_some() {
            seen.put(2, 0, running.as_ref().map_or('.', Running::raster));
        }
        match &mut running {
            Some(own) => {
                own.passed += 1;
                own.cached = own.cached.saturating_sub(gpu.l2.bytes_per_cycle.into());
                own.added = own.added.saturating_sub(1);
            }
            None if are_over => {}
            None => (gap, seen.launching) = (gap + 1, seen.launching + 1),
        }
        memory.tick(now);
        now += 1;
        assert!(now < LONGEST, "kernel {next} of {} does not end", kernels.all.len());
    }
    seen.frame = now;
    (seen.requests, seen.read, seen.written) = (memory.requests, memory.read, memory.written);
    seen
}

/// When multiprocessors have ended their last blocks of a kernel whose blocks are tiles: from one
/// end of a block to the next one, with all shares dealt out anew.
fn in_turn(gpu: &Gpu, blend: &BlendSpec, warps: &FrameWarps) -> Vec<f64> {
    let (units, resident) = (gpu.sm.units as usize, gpu.blending() as usize);
    // Work that is left, and cycles that it takes alone.
    let block = |b: &powergs_core::flow::gpu::warps::BlockWarps| {
        let pairs = [b.evaluated, b.blended];
        // A tile of which nothing is rendered leaves at once.
        let last = if b.renders { u64::from(blend.finish) } else { 0 };
        let finish = blend.block_warps() * last;
        let issued = (blend.instructions(pairs) + finish) as f64 / gpu.sm.issue();
        let special = blend.exponentials(pairs) as f64 * f64::from(WARP);
        let work = issued.max(special / f64::from(gpu.sm.special));
        let longest = blend.instructions(b.longest.map(u64::from)) + last;
        let batches = u64::from(b.loaded).div_ceil(blend.batch.into());
        let alone = longest * u64::from(gpu.sm.interval) + batches * u64::from(blend.latency);
        (work.max(1e-3), work.max(1e-3).max(alone as f64))
    };
    let mut blocks: Vec<(f64, f64)> = warps.blocks.iter().map(block).collect();
    blocks.reverse();
    let mut at_work: Vec<Vec<(f64, f64)>> = vec![Vec::new(); units];
    let take = |(work, alone): (f64, f64)| (work, work / alone);
    for _ in 0..resident {
        at_work.iter_mut().for_each(|unit| unit.extend(blocks.pop().map(take)));
    }
    let (mut now, mut ends) = (0.0, vec![0.0; units]);
    loop {
        // Nobody is faster than alone; what he leaves is for the others, evenly.
        let shares: Vec<Vec<f64>> = at_work
            .iter()
            .map(|own| {
                let mut share = vec![0.0; own.len()];
                let (mut room, mut open): (f64, Vec<usize>) = (1.0, (0..own.len()).collect());
                while !open.is_empty() {
                    let each = room / open.len() as f64;
                    let full: Vec<usize> =
                        open.iter().copied().filter(|&i| own[i].1 <= each).collect();
                    if full.is_empty() {
                        open.iter().for_each(|&i| share[i] = each);
                        break;
                    }
                    for i in full {
                        (share[i], room) = (own[i].1, room - own[i].1);
                        open.retain(|&other| other != i);
                    }
                }
                share
            })
            .collect();
        let first = at_work.iter().zip(&shares).flat_map(|(own, shares)| {
            own.iter().zip(shares).map(|((left, _), share)| left / share)
        });
        let passes = first.fold(f64::INFINITY, f64::min);
        if passes == f64::INFINITY {
            return ends;
        }
        now += passes;
        for ((own, shares), end) in at_work.iter_mut().zip(&shares).zip(&mut ends) {
            own.iter_mut().zip(shares).for_each(|(block, share)| block.0 -= share * passes);
            let before = own.len();
            own.retain(|block| block.0 > 1e-7);
            if own.len() < before {
                *end = now;
            }
            while own.len() < resident
                && let Some(block) = blocks.pop()
            {
                own.push(take(block));
            }
        }
    }
}

/// Compares a frame; the symbols of states that came up, and how many kernels had multiprocessors
/// that ended otherwise than here, and as here.
fn compare(seed: u64, frames: &[[Frame; 2]]) -> Option<(String, [usize; 2])> {
    let machine = machine(seed)?;
    let pair = &frames[seed as usize % frames.len()];
    let [earlier, work] = [0, 1].map(|i| workload(&pair[i], machine.gpu()));
    let memo = Memo::default();
    let mut history = History::default();
    let mut over = |work| machine.flow().hand_over(&machine, work, None, &mut history);
    let before = (over(&earlier), over(&work)).1;
    let task = FrameTask { before: before.as_ref(), ..FrameTask::first(&machine, &work, &memo) };
    machine.flow().fits(&task).ok()?;
    let mut timeline = Timeline::default();
    let observer = Some(&mut timeline as &mut dyn Observer);
    let outcome: FlowOutcome = machine.flow().run(&task, observer).expect("it runs");
    let some = before.as_ref().and_then(|before| before.downcast_ref::<SomePixels>());
    let made = some.and_then(|some| some.made.as_deref());
    let (work, own) = (made.unwrap_or(&work), Memo::default());
    let kernels = Kernels::new(&machine, work, some, &own);
    let warps = FrameWarps::new(work, &WarpShape::of(machine.gpu()));
    let flat = Dram::new(&machine.dram, machine.dram_peak(), machine.clock, &STREAMS);
    if let Some(made) = made.filter(|_| machine.gpu().reprojects()) {
        // Each pixel is written once: by the second kernel that moves them, or by blending.
        let writes =
            |kernel: &&GpuKernel| matches!(kernel.part, KernelPart::Reproject | KernelPart::Blend);
        let written: u64 = kernels.all.iter().filter(writes).skip(1).map(|k| k.memory[1]).sum();
        let kept = machine.gpu().blend.pixel.0 + machine.gpu().pixels.depth.0;
        assert_eq!(written, u64::from(made.width * made.height) * kept, "{seed}");
    }
    let case = || format!("seed {seed}\n{:#?}", machine.gpu());
    let seen = stepped(&machine, work, &kernels, &warps, flat);
    let (drawn, expected) = (timeline.draw(), seen.draw());
    for (ours, theirs) in drawn.lines().zip(expected.lines()) {
        let at = ours.bytes().zip(theirs.bytes()).position(|(a, b)| a != b);
        let part = |row: &str, at: usize| -> String {
            row.chars().skip(at.saturating_sub(60)).take(120).collect()
        };
        if let Some(at) = at {
            panic!("{at}\n{}\n{}\n{}", part(ours, at), part(theirs, at), case());
        }
    }
    assert_eq!(drawn.len(), expected.len(), "{}", case());
    assert_eq!(outcome.timing.frame, seen.frame, "{}", case());
    assert_eq!(outcome.timing.preprocessing_end, seen.converted, "{}", case());
    assert_eq!(outcome.timing.dram.requests_served, seen.requests, "{}", case());
    assert_eq!(outcome.served.stages.map(|s| s.read), seen.read, "{}", case());
    assert_eq!(outcome.served.stages.map(|s| s.write), seen.written, "{}", case());
    for (part, cycles) in KernelPart::ALL.into_iter().zip(seen.parts) {
        let expected = part.is_of(machine.gpu()).then_some(cycles);
        assert_eq!(outcome.measured.count(part.time()), expected, "{}", case());
    }
    assert_eq!(outcome.measured.count(&LAUNCHING), Some(seen.launching), "{}", case());
    let mut turns = [0; 2];
    // Where a kernel has a block for each tile, multiprocessors take them in turn.
    let ends = |own: &[f64]| -> Vec<u64> {
        own.iter().map(|end| ((end - 1e-6).ceil() as u64).max(1)).collect()
    };
    for kernel in &kernels.all {
        let blend = match kernel.part {
            KernelPart::Blend if kernels.drawn.is_none() => machine.gpu().blend.clone(),
            KernelPart::Backward => {
                let (t, words) = (&machine.gpu().training, machine.gpu().training.record.0);
                let words = words.div_ceil(4) as u32;
                let summing = match t.sum {
                    GradientSum::None | GradientSum::Pixel => 0,
                    GradientSum::Warp => 10 * words,
                    GradientSum::Block => 12 * words,
                };
                BlendSpec { blend: t.gradient + summing, ..machine.gpu().blend.clone() }
            }
            _ => continue,
        };
        let own = ends(&in_turn(machine.gpu(), &blend, &warps));
        let exact = own.iter().zip(&kernel.computes).all(|(a, &b)| a.abs_diff(b) <= 1);
        turns[usize::from(exact)] += 1;
        // What ends at the same time on two of them may be rounded to another order, in which
        // blocks go to others.
        let sum = |all: &[u64]| all.iter().sum::<u64>() as f64;
        let ratio = sum(&own) / sum(&kernel.computes);
        assert!((0.8..1.25).contains(&ratio), "{own:?} {:?} {}", kernel.computes, case());
    }
    let mut symbols: Vec<String> = (timeline.draw().lines())
        .filter_map(|line| line.split_once('|'))
        .flat_map(|(unit, row)| row.chars().map(move |symbol| (unit, symbol)))
        .map(|(unit, symbol)| (unit.trim_end_matches([' ', '0', '1', '2', '3', '4']), symbol))
        .map(|(unit, symbol)| (unit, if symbol.is_ascii_digit() { '0' } else { symbol }))
        .map(|(unit, symbol)| format!("{unit}:{symbol}"))
        .collect();
    symbols.sort_unstable();
    symbols.dedup();
    Some((symbols.join(" "), turns))
}

#[test]
fn frames_are_those_of_kernels_one_after_the_other() {
    let frames: Vec<[Frame; 2]> = (0..FRAMES).into_par_iter().map(frames).collect();
    let all = (0..slow_or(CASES)).into_par_iter().filter_map(|seed| compare(seed, &frames));
    let all: Vec<(String, [usize; 2])> = all.collect();
    assert!(all.len() as u64 > slow_or(CASES) / 2, "{} of them", all.len());
    let [other, same] = [0, 1].map(|i| all.iter().map(|(_, turns)| turns[i]).sum::<usize>());
    assert!(same > 100 && 20 * other < same, "{other} in another order, {same} in the same");
    let mut reached: Vec<&str> = all.iter().flat_map(|one| one.0.split_whitespace()).collect();
    reached.sort_unstable();
    reached.dedup();
    let expected = "attached:. attached:0 attached:f attached:o rop:. rop:0 rop:f rop:i sm:. sm:0 \
                    sm:f sm:g sm:i sm:o sm:p sm:r";
    assert_eq!(reached, expected.split(' ').collect::<Vec<_>>());
}
