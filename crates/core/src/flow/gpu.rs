//! GPU: the kernels of the published rasteriser, one after the other, on a SIMT machine.
//!
//! Gaussians are converted by a thread each; a prefix sum over their numbers of tiles says where
//! the (tile, Gaussian) pairs of each begin, which the host reads to launch what is for them; a
//! thread for each Gaussian writes its pairs; a radix sort puts them in order by tile and depth; a
//! thread for each pair finds where tiles begin; and a block of threads for each tile blends its
//! list, a thread for each pixel, until all have stopped.
//!
//! A kernel takes as long as what takes longest of it: its warp instructions over the issue slots
//! of the multiprocessors (of the blending kernel block by block, [`blocks`]), what passes through
//! the L2 cache over its rate, and what passes through the memory. An array that one kernel writes
//! and the next reads stays in the L2 cache if everything that the kernel touches fits there
//! (A139).
//! Between two kernels passes `launch.gap`.
//!
//! A unit beside the GPU may blend in place of the last kernel (`attached`; [`attached`]), or the
//! raster operations of the graphics pipeline (`rops`; [`rops`]): then Gaussians are not paired
//! with tiles, and sorted once by their depth.
//!
//! Not all pixels need be rendered (`pixels`; [`reproject`]): the kernels in front of the others
//! move those of the frame before.
//!
//! A frame that is trained on (`training.sum`; A144) goes on: the loss of its picture, the lists in
//! reverse with the gradients of each pixel, which are added up for Gaussians, gradients by
//! parameters, and the update. What is added to memory pixel by pixel passes through the L2 cache
//! one number at a time.

pub mod attached;
pub mod blocks;
pub mod cache;
mod check;
pub mod reproject;
pub mod rops;
pub mod stages;
mod tables;
pub mod warps;

use std::ops::Range;
use std::sync::Arc;

use super::over::pixels::{self, SomePixels};
use super::steps::{self, SteppedGaussians};
use super::{
    Dataflow, FlowDecl, FlowOutcome, FrameTask, Handed, History, Incompatible, SimError,
    TablesDecl, Task, Work, WorkKey, lists,
};
use crate::kernel::blocks::{BlockStream, BlockUnit};
use crate::kernel::calibration::{CalibrationRecorder, Recording};
use crate::kernel::ledger::{Ledger, cycles};
use crate::kernel::memory::{Arrival, Memory, NEVER, Ranges, Request};
use crate::kernel::stream::Streams;
use crate::kernel::timeline::{Observer, State};
use crate::kernel::{self, Calibration, FrameTiming, Halt, Histogram, Memo, drive};
use crate::machine::check::Found;
use crate::machine::{Machine, Reference};
use crate::stage::{
    DRAM_READ, DRAM_WRITE, Measured, StageDecl, Stall, StatDecl, Value, sram_read, sram_write,
    streams,
};
use crate::workload::FrameWorkload;
use powergs_base::config::schema_of;
use powergs_base::quantity::{BytesPerSecond, Nanoseconds};
use powergs_dram::AddressRange;
use powergs_energy::action::{ActionCounts, Phase};
use powergs_frame::scene::Eye;

pub use stages::{ATTACHED_DECL, QUAD_BLENDED, ROP_DECL, SM_DECL};
pub use tables::*;

use attached::AttachedWork;
use blocks::ThreadBlock;
use cache::{FilterKey, Filtered, ListReads};
use reproject::MovedPixels;
use rops::{CORNERS, DrawKey, Drawn};
use stages::{
    ATTACHED, EXPONENTIAL, INSTRUCTION, L2, L2_HITS, L2_MISSES, LAUNCHING, LIVE, ROP, SLOTS, SM,
};
use warps::{FrameWarps, WarpShape};

const KEY: &str = "gpu";

/// Threads of a block of the kernels that have no tiles.
pub const BLOCK: u32 = 256;

/// Its stages.
pub const STAGES: &[&StageDecl] = &[&SM_DECL, &ATTACHED_DECL, &ROP_DECL];

/// The dataflow with its stages.
pub const FLOW: FlowDecl = FlowDecl { flow: &GpuFlow, stages: STAGES };

/// Their streams.
pub const STREAMS: Streams = streams(STAGES);

/// The dataflow.
pub struct GpuFlow;

impl Dataflow for GpuFlow {
    fn key(&self) -> &'static str {
        KEY
    }

    fn means(&self) -> &'static str {
        "the kernels of the published rasteriser, one after the other, on a SIMT machine"
    }

    fn example(&self) -> Option<&'static str> {
        Some("xavier-nx")
    }

    fn stages(&self) -> &'static [&'static StageDecl] {
        FLOW.stages
    }

    fn tables(&self) -> TablesDecl {
        let schema = || {
            let mut schema = schema_of::<Gpu>();
            pixels::leave_out(&mut schema, &reproject::OF_UNITS, &reproject::KEYS_OF_UNITS);
            schema
        };
        TablesDecl { schema, ..TablesDecl::of::<Gpu>() }
    }

    fn task(&self, machine: &Machine) -> Task {
        let m = machine.gpu();
        Task::new(m.training.trains().then_some(m.training.update), &m.pixels)
    }

    fn check(&self, machine: &Machine, found: &mut Found) {
        check::check(machine, found);
    }

    fn memory_rate(&self, machine: &Machine) -> Option<BytesPerSecond> {
        Some(machine.gpu().bus.rate())
    }

    /// Of 32 pins each: a wider bus has more of them.
    fn channels(&self, machine: &Machine) -> f64 {
        let wide = if machine.dram.has_device() { 32 } else { machine.gpu().bus.width };
        f64::from(machine.dram.channels) * f64::from(wide) / 32.0
    }

    fn tile(&self, machine: &Machine, _: [u32; 2]) -> [u32; 2] {
        [machine.gpu().blend.tile; 2]
    }

    /// An attached unit may blend while they work on the next frame.
    fn overlaps(&self, machine: &Machine) -> bool {
        let attached = &machine.gpu().attached;
        attached.is_there() && attached.overlap == AttachedOverlap::Frames
    }

    fn under_way(&self, machine: &Machine) -> u64 {
        if self.overlaps(machine) { 2 } else { 1 }
    }

    /// Lists of tiles, with their splats and pixels: that of tile-wise machines.
    fn work_key(&self, machine: &Machine) -> WorkKey {
        lists::work_key_for(machine.gpu().geometry(), machine.gpu().detail())
    }

    fn fits(&self, task: &FrameTask<'_>) -> Result<(), Incompatible> {
        let workload = workload(task)?;
        if workload.fovea.is_some() {
            let why = "it is foveated, and a GPU shows no levels here; extract the trace without a \
                       gaze, or take another machine (`gscore`)";
            return Err(Incompatible::Other {
                machine: task.machine.name.clone(),
                why: why.into(),
            });
        }
        task.machine.gpu().pixels.fits(&task.machine.name, [workload.width, workload.height])
    }

    fn takes_over(&self, machine: &Machine) -> Option<Vec<u32>> {
        Some(machine.gpu().pixel_filter()?.numbers())
    }

    fn hand_over(
        &self,
        machine: &Machine,
        work: &dyn Work,
        eye: Option<Eye>,
        history: &mut History,
    ) -> Option<Handed> {
        let filter = machine.gpu().pixel_filter()?;
        Some(Box::new(SomePixels::of(filter, work.of()?, eye, history, false)))
    }

    fn run(
        &self,
        task: &FrameTask<'_>,
        observer: Option<&mut dyn Observer>,
    ) -> Result<FlowOutcome, SimError> {
        let workload = workload(task)?;
        let some = task.before.and_then(|before| before.downcast_ref::<SomePixels>());
        // What others share is of the whole frame.
        let own = Memo::default();
        let made = some.and_then(|some| some.made.as_deref());
        let (workload, memo) = made.map_or((workload, task.memo), |made| (made, &own));
        let kernels = Kernels::new(task.machine, workload, some, memo);
        let calibration = calibration(task.machine, &kernels, memo);
        let calibration = calibration.as_deref();
        let mut outcome = match observer {
            None => through(task.machine, &kernels, calibration, task.halt, &mut ()).0,
            Some(mut observer) => {
                through(task.machine, &kernels, calibration, task.halt, &mut observer).0
            }
        };
        if let Some(some) = some {
            outcome.measured.extend(some.summary.moved());
        }
        Ok(outcome)
    }
}

/// The lists of a frame, with its splats and pixels.
fn workload<'a>(task: &FrameTask<'a>) -> Result<&'a FrameWorkload, Incompatible> {
    let (work, needed) = (task.work.key(), GpuFlow.work_key(task.machine));
    let found = task.work.of().filter(|_| work == needed);
    found.ok_or_else(|| Incompatible::Work {
        work: work.to_string(),
        machine: task.machine.name.clone(),
        needed: needed.to_string(),
    })
}

/// What a kernel is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KernelPart {
    /// Pixels of the frame before are moved.
    Reproject,
    /// Gaussians are converted.
    Convert,
    /// Pairs are made.
    Pairs,
    /// They are sorted, and tiles find theirs.
    Sort,
    /// Tiles are blended.
    Blend,
    /// The picture is compared with the photo.
    Loss,
    /// Lists are gone through in reverse: gradients by what was blended.
    Backward,
    /// Gradients by the parameters of Gaussians.
    Chain,
    /// Parameters are updated.
    Update,
}

impl KernelPart {
    /// All of them, in their order.
    pub const ALL: [KernelPart; 9] = [
        KernelPart::Reproject,
        KernelPart::Convert,
        KernelPart::Pairs,
        KernelPart::Sort,
        KernelPart::Blend,
        KernelPart::Loss,
        KernelPart::Backward,
        KernelPart::Chain,
        KernelPart::Update,
    ];

    /// The word for it in every output.
    pub const fn name(self) -> &'static str {
        match self {
            KernelPart::Reproject => "reproject",
            KernelPart::Convert => "convert",
            KernelPart::Pairs => "pairs",
            KernelPart::Sort => "sort",
            KernelPart::Blend => "blend",
            KernelPart::Loss => "loss",
            KernelPart::Backward => "backward",
            KernelPart::Chain => "chain",
            KernelPart::Update => "update",
        }
    }

    /// Its time.
    pub const fn time(self) -> &'static StatDecl {
        match self {
            KernelPart::Reproject => &stages::REPROJECTING,
            KernelPart::Convert => &stages::CONVERTING,
            KernelPart::Pairs => &stages::PAIRING,
            KernelPart::Sort => &stages::SORTING,
            KernelPart::Blend => &stages::BLENDING,
            KernelPart::Loss => &steps::LOSS,
            KernelPart::Backward => &steps::REVERSE,
            KernelPart::Chain => &steps::CHAIN,
            KernelPart::Update => &steps::UPDATE,
        }
    }

    /// Whether frames on a machine have it.
    pub fn is_of(self, m: &Gpu) -> bool {
        match self {
            KernelPart::Reproject => m.reprojects(),
            KernelPart::Convert | KernelPart::Pairs | KernelPart::Sort | KernelPart::Blend => true,
            KernelPart::Loss | KernelPart::Backward | KernelPart::Chain | KernelPart::Update => {
                m.training.trains()
            }
        }
    }

    /// The phase that its work and its energy are of.
    pub const fn phase(self) -> Phase {
        match self {
            KernelPart::Convert | KernelPart::Chain | KernelPart::Update => Phase::Preprocessing,
            KernelPart::Pairs | KernelPart::Sort => Phase::Sorting,
            KernelPart::Reproject | KernelPart::Blend | KernelPart::Loss | KernelPart::Backward => {
                Phase::Rendering
            }
        }
    }

    /// Its streams: what it reads, what it writes.
    const fn streams(self) -> [&'static str; 2] {
        match self {
            KernelPart::Reproject => ["known-in", "known-out"],
            KernelPart::Convert => ["scene", "results"],
            KernelPart::Pairs => ["counts", "pairs-out"],
            KernelPart::Sort => ["keys-in", "keys-out"],
            KernelPart::Blend => ["splats", "picture"],
            KernelPart::Loss | KernelPart::Backward => ["blended-in", "gradients-out"],
            KernelPart::Chain | KernelPart::Update => ["parameters-in", "parameters-out"],
        }
    }

    /// What multiprocessors wait for where its bytes take longest.
    const fn waits(self) -> Stall {
        match self {
            KernelPart::Sort => Stall::of("pass"),
            KernelPart::Reproject | KernelPart::Blend | KernelPart::Loss | KernelPart::Backward => {
                Stall::of("features")
            }
            _ => Stall::of("records"),
        }
    }
}

/// A kernel of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct GpuKernel {
    /// What it is for.
    pub part: KernelPart,
    /// Cycles between the kernel before and its first block.
    pub gap: u64,
    /// Warp instructions.
    pub instructions: u64,
    /// Exponentials, warp by warp.
    pub exponentials: u64,
    /// Bytes that it reads and writes through the L2 cache.
    pub l2: [u64; 2],
    /// Bytes that it reads from and writes to the memory.
    pub memory: [u64; 2],
    /// Numbers that the L2 cache adds to what is in memory.
    pub atomics: u64,
    /// Cycles in which the rasteriser finds its quads, and in which they are blended.
    pub raster: [u64; 2],
    /// Where these begin.
    place: [u64; 2],
    /// For how many cycles each multiprocessor computes.
    pub computes: Vec<u64>,
}

/// The kernels of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernels {
    /// In their order.
    pub all: Vec<GpuKernel>,
    /// What a unit beside them blends.
    pub attached: Option<AttachedWork>,
    /// What raster operations draw.
    pub drawn: Option<Arc<Drawn>>,
    /// Where what it reads and writes begins.
    places: [u64; 2],
    warps: Arc<FrameWarps>,
    filtered: Arc<Filtered>,
    /// (Pixel, Gaussian) pairs that are needed.
    live: u64,
    /// First byte behind everything.
    end: u64,
}

/// Instructions of a warp for a value of the prefix sum, and for a key whose tile is looked at.
const SCANNED: u64 = 10;

/// Bytes of a number of pairs, of where it begins, and of where the pairs of a tile do.
const COUNT: u64 = 4;
const RANGE: u64 = 8;

impl Kernels {
    /// Those of a frame on a machine, of which some pixels may not be rendered.
    pub fn new(
        machine: &Machine,
        workload: &FrameWorkload,
        some: Option<&SomePixels>,
        memo: &Memo,
    ) -> Kernels {
        let m = machine.gpu();
        let warps = memo.get(WarpShape::of(m), |shape| FrameWarps::new(workload, shape));
        let sectors = m.blend.feature.0.div_ceil(m.l2.sector.0.max(1)) * m.l2.sector.0;
        let attached = m.attached.is_there();
        let cache = if attached { m.attached.cache.capacity } else { m.l2.capacity };
        let key = FilterKey {
            capacity: cache.0,
            reads: match m.attached.implementation {
                AttachedImpl::Tile => ListReads::Whole,
                _ => ListReads::UntilStop,
            },
            entry: m.blend.entry.0,
            feature: sectors,
            geometry: workload.geometry,
        };
        let filtered = memo.get(key, |key| Filtered::new(workload, key));
        // The reverse pass goes through whole lists, from their ends.
        let reverse = m.training.trains().then(|| {
            let key = FilterKey { capacity: m.l2.capacity.0, reads: ListReads::Reverse, ..key };
            memo.get(key, |key| Filtered::new(workload, key))
        });
        let mut make = KernelMaker { machine, m, all: Vec::new() };
        let (points, tiles) = (workload.counters.points, workload.tiles.len() as u64);
        let draws = m.rops.is_there();
        let of_warps = |n: u64| n.div_ceil(u64::from(WARP));

        // Arrays lie one after the other: the scene, what is made of it, pairs twice, the image.
        let c = &m.convert;
        let [alive, seen] = warps.gaussians;
        let pairs = if draws { seen } else { workload.counters.tile_pairs };
        let degree = c.colour.0 * workload.sh_degree.coefficients() / 16;
        let scene = points * (c.position.0 + c.shape.0 + c.colour.0);
        let made = scene + points * (c.mark.0 + c.covariance.0 + c.result.0 + 2 * COUNT);
        let pair = m.pairs.key.0 + m.pairs.value.0;
        let sorted = made + pairs * pair;
        let image = sorted + pairs * pair + tiles * RANGE;

        let rendered: u64 = workload.tiles.iter().map(|tile| u64::from(tile.pixels)).sum();
        let whole = u64::from(workload.width) * u64::from(workload.height);
        let mut end = image + whole * m.pixel_bytes();
        if let Some(moved) = some.and_then(|some| MovedPixels::new(m, workload, some)) {
            end = make.reproject(&moved, [image, end]);
        }

        let [all, projected, shaded] = warps.converting;
        let read = points * c.position.0 + alive * c.shape.0 + seen * degree;
        let written = points * c.mark.0 + alive * c.covariance.0 + seen * c.result.0;
        let [test, project, shade] = [c.test, c.project, c.shade].map(u64::from);
        let instructions = all * test + projected * project + shaded * shade;
        let all_of_it = [read, written];
        make.even(KernelPart::Convert, instructions, all_of_it, ([0, scene], all_of_it));
        let counts = points * COUNT;
        let both = [counts, counts];
        let moved = make.kept(both);
        make.even(KernelPart::Pairs, of_warps(points) * SCANNED, moved, ([scene, made], both));
        let read = points * COUNT + seen * m.pairs.read.0;
        // What is drawn is one number of each Gaussian, and nothing is launched by how many.
        let steps = if draws { shaded } else { warps.pair_steps };
        let instructions = all * u64::from(m.pairs.gaussian) + steps * u64::from(m.pairs.pair);
        let both = [read, pairs * pair];
        let moved = make.kept(both);
        make.even(KernelPart::Pairs, instructions, moved, ([scene, made], both));
        // The host reads how many pairs there are before it can launch what sorts them.
        if !draws {
            make.last().gap += make_gap(machine, m.launch.readback);
        }

        let (keys, whole) = (pairs * m.pairs.key.0, pairs * pair);
        let of_keys = of_warps(pairs) * u64::from(m.radix.instructions);
        let count = |make: &mut KernelMaker| {
            let moved = make.kept([keys, 0]);
            make.even(
                KernelPart::Sort,
                of_warps(pairs) * SCANNED,
                moved,
                ([made, sorted], [keys, 0]),
            );
        };
        if m.radix.count == DigitCount::Once {
            count(&mut make);
        }
        for pass in 0..m.passes(tiles) {
            if m.radix.count == DigitCount::EachPass {
                count(&mut make);
            }
            // Passes go to and fro between two arrays.
            let place = if pass % 2 == 0 { [made, sorted] } else { [sorted, made] };
            let moved = make.kept([whole, whole]);
            make.even(KernelPart::Sort, of_keys, moved, (place, [whole, whole]));
        }
        if !draws {
            let both = [keys, tiles * RANGE];
            let moved = make.kept(both);
            let ranges = of_warps(pairs) * SCANNED;
            make.even(KernelPart::Sort, ranges, moved, ([sorted, image - tiles * RANGE], both));
        }

        let attached =
            attached.then(|| AttachedWork::new(workload, m, machine.clock, (&filtered, sectors)));
        let drawn = draws.then(|| memo.get(DrawKey::of(m), |key| Drawn::new(workload, key)));
        if let Some(drawn) = &drawn {
            make.draw(workload, drawn, (seen, sectors), [sorted, image]);
        } else if attached.is_none() {
            make.blend(workload, &warps, (&filtered, sectors, rendered), [sorted, image]);
        }
        if let Some(reverse) = &reverse {
            let met = filtered.misses;
            end = make.train(workload, &warps, (reverse, met, sectors), [0, sorted, image, end]);
        }
        let live = workload.counters.alpha_evaluations;
        let live = attached.as_ref().map_or(live, |work| work.reach[1]);
        let live = drawn.as_ref().map_or(live, |drawn| drawn.live);
        let places = [sorted, image];
        Kernels { all: make.all, attached, drawn, places, end, live, warps, filtered }
    }
}

/// Cycles of a time.
fn make_gap(machine: &Machine, time: Nanoseconds) -> u64 {
    (time.0 * 1e-9 * machine.clock.0).ceil() as u64
}

/// Makes kernels.
struct KernelMaker<'a> {
    machine: &'a Machine,
    m: &'a Gpu,
    all: Vec<GpuKernel>,
}

impl KernelMaker<'_> {
    fn last(&mut self) -> &mut GpuKernel {
        self.all.last_mut().expect("a kernel was made")
    }

    /// What of an array that the kernel before wrote, and of one that the next reads, goes through
    /// the memory.
    fn kept(&self, [read, written]: [u64; 2]) -> [u64; 2] {
        if read + written <= self.m.l2.capacity.0 { [0, 0] } else { [read, written] }
    }

    /// A kernel whose blocks are all alike: multiprocessors compute for the same time.
    fn even(
        &mut self,
        part: KernelPart,
        instructions: u64,
        memory: [u64; 2],
        (place, l2): ([u64; 2], [u64; 2]),
    ) {
        let sm = &self.m.sm;
        let registers = self.m.convert.registers;
        let warps = sm.resident(BLOCK, registers, 0) * BLOCK.div_ceil(WARP);
        // A warp issues once in `interval` cycles, so that few resident warps leave slots empty.
        let issue = sm.issue().min(f64::from(warps) / f64::from(sm.interval));
        let cycles = instructions as f64 / (issue * f64::from(sm.units));
        self.all.push(GpuKernel {
            part,
            gap: make_gap(self.machine, self.m.launch.gap),
            instructions,
            exponentials: 0,
            l2,
            memory,
            atomics: 0,
            raster: [0; 2],
            place,
            computes: vec![(cycles.ceil() as u64).max(1); sm.units as usize],
        });
    }

    /// Kernels that move the pixels of the frame before; `image` is where this one begins, and what
    /// is behind it. Returns where everything ends.
    fn reproject(&mut self, moved: &MovedPixels, [image, end]: [u64; 2]) -> u64 {
        let [before, nearest] = moved.arrays;
        let places = [[end, end + before], [end + before, image]];
        for (i, place) in places.into_iter().enumerate() {
            let [l2, memory] = [moved.l2[i], moved.memory[i]];
            self.even(KernelPart::Reproject, moved.instructions[i], memory, (place, l2));
        }
        end + before + nearest
    }

    /// Kernels behind a frame that is trained on; `place` is where the scene, the lists and the
    /// image begin, and what is behind it; Gaussians are read as `reverse` says, and the sums of
    /// `met` ones, in front of the stops, come and go. Returns where everything ends.
    fn train(
        &mut self,
        workload: &FrameWorkload,
        warps: &FrameWarps,
        (reverse_reads, met_sums, sectors): (&Filtered, u64, u64),
        [scene, lists, image, end]: [u64; 4],
    ) -> u64 {
        let (m, t) = (self.m, &self.m.training);
        let (points, [_, seen]) = (workload.counters.points, warps.gaussians);
        let pixels: u64 = workload.tiles.iter().map(|tile| u64::from(tile.pixels)).sum();
        let of_warps = |n: u64| n.div_ceil(u64::from(WARP));
        // Behind the image lie gradients by pixels, by Gaussians and by parameters, and moments.
        let c = &m.convert;
        let stored = c.position.0 + c.shape.0 + c.colour.0 * workload.sh_degree.coefficients() / 16;
        let whole = u64::from(workload.width) * u64::from(workload.height);
        let gaussians = end + whole * t.loss_bytes.0;
        let parameters = gaussians + points * t.record.0;
        let numbers = SteppedGaussians::numbers_of(workload.sh_degree);
        let [found, moments] = [t.widths.gradient.0, 2 * t.widths.moment.0].map(|n| n * numbers);
        let behind = parameters + points * (t.zeroed.0.max(found) + moments);

        let moved = [pixels * t.loss_bytes.0 / 2; 2];
        let instructions = of_warps(pixels) * u64::from(t.loss);
        self.even(KernelPart::Loss, instructions, moved, ([image, end], moved));

        // The entry that stops a pixel is counted with the blends, and has no gradient.
        let stopped: u64 = workload.tiles.iter().map(|tile| u64::from(tile.stopped)).sum();
        let words = t.record.0.div_ceil(4);
        let [evaluated, blended] = warps.pairs();
        // Five steps of a shuffle and an addition; a block adds sums of warps in shared memory.
        let summing = match t.sum {
            GradientSum::None | GradientSum::Pixel => 0,
            GradientSum::Warp => 10 * words,
            GradientSum::Block => 12 * words,
        };
        let met: u64 = warps.blocks.iter().map(|block| u64::from(block.met)).sum();
        let atomics = words
            * match t.sum {
                GradientSum::None => 0,
                GradientSum::Pixel => workload.counters.blends - stopped,
                GradientSum::Warp => blended,
                GradientSum::Block => met,
            };
        let added = u64::from(t.gradient) + summing;
        let reverse =
            BlendSpec { blend: u32::try_from(added).unwrap_or(u32::MAX), ..m.blend.clone() };
        let computes = self.blocks(&reverse, warps);
        let tiles = workload.tiles.len() as u64;
        // The published code goes through the whole list of a tile, from its end.
        let entries = workload.list.len() as u64;
        let read = entries * m.blend.entry.0 + tiles * RANGE + pixels * t.state.0;
        let record = t.record.0.div_ceil(m.l2.sector.0) * m.l2.sector.0;
        self.all.push(GpuKernel {
            part: KernelPart::Backward,
            gap: make_gap(self.machine, m.launch.gap),
            instructions: reverse.instructions([evaluated, blended]),
            exponentials: reverse.exponentials([evaluated, blended]),
            l2: [read + entries * sectors, atomics * m.l2.sector.0],
            memory: [read + reverse_reads.misses * sectors + met_sums * record, met_sums * record],
            atomics,
            raster: [0; 2],
            place: [lists, gaussians],
            computes,
        });

        let gaussians = SteppedGaussians {
            points,
            visible: seen,
            sums: seen,
            stored: [c.position.0 + c.shape.0, stored],
            numbers: SteppedGaussians::numbers_of(workload.sh_degree),
        };
        let [_, _, shaded] = warps.converting;
        // What is by the pose needs no colours, and is a few numbers.
        let (read, written) = match t.update {
            Updated::Pose => (c.position.0 + c.shape.0, 0),
            Updated::All | Updated::Visible | Updated::None => {
                (stored, gaussians.numbers * t.widths.gradient.0)
            }
        };
        let both = [seen * (read + t.record.0), points * t.zeroed.0 + seen * written];
        self.even(
            KernelPart::Chain,
            shaded * u64::from(t.chain),
            both,
            ([scene, parameters], both),
        );

        let densified = t.widths.densifying(t.densify, &gaussians);
        if densified.bytes > 0 {
            // A number is compared and moved.
            let instructions = of_warps(densified.numbers) * SCANNED;
            let both = [densified.bytes; 2];
            self.even(KernelPart::Update, instructions, both, ([parameters, parameters], both));
        }
        let updated = t.update.of(points, seen);
        if updated == 0 {
            return behind;
        }
        let both = t.widths.updated(&gaussians).map(|bytes| updated * bytes);
        let instructions = of_warps(updated * gaussians.numbers) * u64::from(t.step);
        self.even(KernelPart::Update, instructions, both, ([parameters, scene], both));
        behind
    }

    /// For how long multiprocessors compute in a kernel whose blocks are tiles.
    fn blocks(&self, b: &BlendSpec, warps: &FrameWarps) -> Vec<u64> {
        let sm = &self.m.sm;
        let special = f64::from(WARP) / f64::from(sm.special);
        let block = |block: &warps::BlockWarps| {
            let pairs = [block.evaluated, block.blended];
            let finish = if block.renders { u64::from(b.finish) } else { 0 };
            let all = b.instructions(pairs) + b.block_warps() * finish;
            let issued = all as f64 / sm.issue();
            let work = issued.max(b.exponentials(pairs) as f64 * special);
            let longest = b.instructions(block.longest.map(u64::from)) + finish;
            let batches = u64::from(block.loaded.div_ceil(b.batch));
            // Its slowest warp goes from one instruction to the next, and waits for every batch.
            let alone = longest * u64::from(sm.interval) + batches * u64::from(b.latency);
            ThreadBlock { work, alone: (alone as f64).max(work) }
        };
        let ends = blocks::ends(warps.blocks.iter().map(block), sm.units, self.m.blending());
        ends.into_iter().map(|cycles| (cycles.ceil() as u64).max(1)).collect()
    }

    /// The blending kernel.
    fn blend(
        &mut self,
        workload: &FrameWorkload,
        warps: &FrameWarps,
        (filtered, sectors, rendered): (&Filtered, u64, u64),
        place: [u64; 2],
    ) {
        let b = &self.m.blend;
        let finish = b.block_warps() * u64::from(b.finish);
        let pairs = warps.pairs();
        let tiles = workload.tiles.len() as u64;
        let loaded: u64 = workload.tiles.iter().map(|tile| u64::from(tile.loaded)).sum();
        let blocks = warps.blocks.iter().filter(|block| block.renders).count() as u64;
        let written = rendered * self.m.pixel_bytes();
        let lists = loaded * b.entry.0 + tiles * RANGE;
        self.all.push(GpuKernel {
            part: KernelPart::Blend,
            gap: make_gap(self.machine, self.m.launch.gap),
            instructions: b.instructions(pairs) + blocks * finish,
            exponentials: b.exponentials(pairs),
            l2: [lists + loaded * sectors, written],
            memory: [lists + filtered.misses * sectors, written],
            atomics: 0,
            raster: [0; 2],
            place,
            computes: self.blocks(b, warps),
        });
    }

    /// What the graphics pipeline draws of so many Gaussians.
    fn draw(
        &mut self,
        workload: &FrameWorkload,
        drawn: &Drawn,
        (gaussians, sectors): (u64, u64),
        place: [u64; 2],
    ) {
        let (b, r) = (&self.m.blend, &self.m.rops);
        let corners = (gaussians * CORNERS).div_ceil(u64::from(WARP)) * u64::from(r.corner);
        let instructions =
            corners + drawn.warps * u64::from(r.shade) + drawn.pair_warps * u64::from(r.pair);
        let read = gaussians * (b.entry.0 + sectors);
        let quad = rops::QUAD * b.pixel.0;
        let pixels = u64::from(workload.width) * u64::from(workload.height);
        let l2 = [read + drawn.places * quad, drawn.places * quad];
        // What came in leaves again, and at the end all of the picture.
        let memory = [read + drawn.missed * quad, drawn.missed * quad + pixels * b.pixel.0];
        let raster = [
            drawn.found.div_ceil(r.found_per_cycle.into()),
            drawn.blended.div_ceil(r.quads_per_cycle.into()),
        ];
        let special = drawn.warps * u64::from(WARP).div_ceil(self.m.sm.special.into())
            / u64::from(self.m.sm.units);
        self.even(KernelPart::Blend, instructions, memory, (place, l2));
        let last = self.last();
        (last.exponentials, last.raster) = (drawn.warps, raster);
        last.computes.iter_mut().for_each(|own| *own = special.max(*own));
    }
}

/// The kernels on their way.
struct Stream<'a, O> {
    m: &'a Gpu,
    kernels: &'a Kernels,
    memory: Memory<'a, Ranges>,
    /// The kernel at work, or the next one.
    at: usize,
    /// When it began, and what it has asked for; `None` before.
    running: Option<(u64, [Arrival; 2])>,
    /// When the kernel before ended.
    ended: u64,
    ledgers: Vec<Ledger>,
    rops: Option<Ledger>,
    /// When kernels of each part ended, and for how long they worked.
    parts: [u64; KernelPart::ALL.len()],
    converted: u64,
    launching: u64,
    attached: Option<BlockStream>,
    /// Whether all kernels have just ended.
    wakes: bool,
    halt: Halt<'a>,
    observer: &'a mut O,
}

impl<O: Observer> Stream<'_, O> {
    /// Says what multiprocessors did until now: in front of a kernel nothing; then they compute,
    /// have no block left, and wait for what the kernel moves.
    fn book(&mut self, kernel: &GpuKernel, began: u64, now: u64) {
        let computed = began + kernel.computes.iter().copied().max().unwrap_or(0);
        for (ledger, own) in self.ledgers.iter_mut().zip(&kernel.computes) {
            let observer = &mut *self.observer;
            ledger.book(State::Stalled(stages::LAUNCH), self.ended, began, observer);
            ledger.book(State::Busy(0), began, began + own, observer);
            ledger.book(State::Idle, began + own, computed, observer);
            let drawn = began + kernel.raster.into_iter().max().unwrap_or(0);
            let waits =
                if kernel.raster[0] > kernel.raster[1] { Stall::INPUT } else { Stall::OUTPUT };
            ledger.book(State::Stalled(waits), computed, drawn.max(computed), observer);
            ledger.book(State::Stalled(kernel.part.waits()), drawn.max(computed), now, observer);
        }
        if let Some(ledger) = self.rops.as_mut().filter(|_| kernel.raster != [0; 2]) {
            let observer = &mut *self.observer;
            let drawn = began + kernel.raster.into_iter().max().unwrap_or(0);
            let shaded = now.min(computed).max(drawn);
            ledger.book(State::Idle, 0, began, observer);
            ledger.book(State::Busy(0), began, drawn, observer);
            ledger.book(State::Stalled(Stall::INPUT), drawn, shaded, observer);
            ledger.book(State::Stalled(kernel.part.waits()), shaded, now, observer);
        }
        self.launching += began - self.ended;
        self.parts[kernel.part as usize] += now - began;
        if kernel.part == KernelPart::Convert {
            self.converted = now;
        }
    }
}

impl<O: Observer> Stream<'_, O> {
    /// Takes the unit beside the kernels on; returns when it acts next.
    fn blend_beside(&mut self, now: u64) -> u64 {
        let waits = self.m.attached.overlap == AttachedOverlap::None;
        if waits && self.at < self.kernels.all.len() {
            return NEVER;
        }
        let Some(attached) = &mut self.attached else { return NEVER };
        let place = |_, range: AddressRange| [range.address, range.bytes];
        attached.step(now, &mut self.memory, place, self.observer)
    }
}

impl<O: Observer> kernel::Agents for Stream<'_, O> {
    fn step(&mut self, agent: usize, now: u64) -> u64 {
        if agent > 0 {
            return self.blend_beside(now);
        }
        let kernels = self.kernels;
        while let Some(kernel) = kernels.all.get(self.at) {
            let Some((began, arrivals)) = self.running else {
                let begins = self.ended + kernel.gap;
                if begins > now {
                    return begins;
                }
                let mut ask = |i: usize| {
                    let bytes = kernel.memory[i];
                    let stream = STREAMS.id(kernel.part.streams()[i]);
                    let place = [kernel.place[i], bytes];
                    let request = Request { owner: 0, stream, bytes };
                    match bytes {
                        0 => Arrival::NOW,
                        _ => self.memory.issue(now, request, |_| place, self.observer),
                    }
                };
                let arrivals = [ask(0), ask(1)];
                self.running = Some((now, arrivals));
                continue;
            };
            let computes = kernel.computes.iter().copied().max().unwrap_or(0);
            let cached =
                kernel.l2.iter().sum::<u64>().div_ceil(u64::from(self.m.l2.bytes_per_cycle));
            let added = self.m.training.adding(kernel.atomics, self.m.l2.bytes_per_cycle);
            let moved = arrivals.map(|arrival| self.memory.at(arrival));
            let [found, blended] = kernel.raster;
            // Within a kernel all of this overlaps; the next one begins when the slowest part is
            // done.
            let least = computes.max(cached).max(added).max(found).max(blended);
            let ends = moved.into_iter().fold(began + least, u64::max);
            if ends > now {
                return ends;
            }
            self.book(kernel, began, now);
            (self.running, self.ended) = (None, now);
            self.at += 1;
            self.wakes |= self.at == kernels.all.len();
        }
        NEVER
    }

    /// What waits for the kernels goes on when they have ended.
    fn woken(&mut self) -> Option<Range<usize>> {
        std::mem::take(&mut self.wakes).then_some(1..2)
    }

    fn advance(&mut self, until: u64) -> Option<(u64, u32)> {
        self.memory.advance(until)
    }

    fn halt(&self) -> Halt<'_> {
        self.halt
    }
}

/// What a run on its device says of a machine's memory, where that is `calibrated`.
fn calibration(machine: &Machine, kernels: &Kernels, memo: &Memo) -> Option<Arc<Calibration>> {
    let run = |reference: &Machine, recorder: &mut CalibrationRecorder| {
        through(reference, kernels, None, Halt::NEVER, recorder).1
    };
    Reference::calibration(machine, memo, |_| {}, run, &STREAMS)
}

fn through<O: Observer>(
    machine: &Machine,
    kernels: &Kernels,
    calibration: Option<&Calibration>,
    halt: Halt<'_>,
    observer: &mut O,
) -> (FlowOutcome, Option<Recording>) {
    let m = machine.gpu();
    let unit = BlockUnit {
        stage: ATTACHED,
        owner: 1,
        rate: 1,
        streams: [STREAMS.id("attached-in"), STREAMS.id("attached-out")],
        places: kernels.places,
        waits: Stall::of("features"),
    };
    let mut stream = Stream {
        m,
        kernels,
        memory: Memory::new(Ranges { end: kernels.end }, &STREAMS, machine.memory(), calibration),
        at: 0,
        running: None,
        ended: 0,
        ledgers: (0..m.sm.units).map(|n| Ledger::new(SM, n)).collect(),
        rops: kernels.drawn.is_some().then(|| Ledger::new(ROP, 0)),
        parts: [0; KernelPart::ALL.len()],
        converted: 0,
        launching: 0,
        attached: kernels.attached.as_ref().map(|work| BlockStream::new(unit, &work.blocks)),
        wakes: false,
        halt,
        observer,
    };
    let agents = 1 + usize::from(kernels.attached.is_some());
    drive(&mut stream, 0..agents, 0);
    let end = stream.attached.as_ref().map_or(0, |unit| unit.end).max(stream.ended);
    let mut units = Vec::new();
    if let Some(attached) = &mut stream.attached {
        attached.account.up_to(end, stream.observer);
        units.push(cycles(ATTACHED, 1, [&attached.account.ledger].into_iter()));
        let begins = match m.attached.overlap {
            AttachedOverlap::None => stream.ended,
            AttachedOverlap::Frames => 0,
        };
        // The unit blends in place of a kernel, and its time is that of the part.
        stream.parts[KernelPart::Blend as usize] = attached.end.saturating_sub(begins);
    }
    for ledger in stream.ledgers.iter_mut().chain(&mut stream.rops) {
        ledger.book(State::Idle, stream.ended, end, stream.observer);
    }
    units.extend(stream.rops.iter().map(|ledger| cycles(ROP, 1, [ledger].into_iter())));
    units.insert(0, cycles(SM, 1, stream.ledgers.iter()));
    stream.memory.close(end);
    let timing = FrameTiming {
        frame: end,
        preprocessing_end: stream.converted,
        units,
        dram: stream.memory.usage(),
        buffers: Vec::new(),
        tile_cycles: Histogram::EMPTY,
    };
    let mut actions = ActionCounts::default();
    for kernel in &kernels.all {
        let phase = kernel.part.phase();
        let [read, written] = kernel.memory;
        let all = [
            (INSTRUCTION, kernel.instructions),
            (EXPONENTIAL, kernel.exponentials),
            (sram_read(L2), kernel.l2[0]),
            (sram_write(L2), kernel.l2[1]),
            (DRAM_READ, read),
            (DRAM_WRITE, written),
        ];
        all.into_iter().for_each(|(action, n)| actions.charge(phase, action, n));
    }
    if let Some(work) = &kernels.attached {
        work.charge(&mut actions);
        let [read, written] = BlockStream::bytes(&work.blocks);
        actions.charge(Phase::Rendering, DRAM_READ, read);
        actions.charge(Phase::Rendering, DRAM_WRITE, written);
    }
    if let Some(drawn) = &kernels.drawn {
        drawn.charge(&mut actions);
    }
    let [evaluated, _] = kernels.warps.pairs();
    let evaluated = kernels.drawn.as_ref().map_or(evaluated, |drawn| drawn.warps);
    let slots = evaluated * u64::from(WARP);
    let slots = kernels.attached.as_ref().map_or(slots, |work| work.reach[0]);
    // What is drawn reads each Gaussian once.
    let [hits, misses] = match kernels.drawn {
        Some(_) => [0, kernels.warps.gaussians[1]],
        None => [kernels.filtered.hits, kernels.filtered.misses],
    };
    let mut measured = Measured::of(&[
        (&LAUNCHING, stream.launching),
        (&L2_HITS, hits),
        (&L2_MISSES, misses),
        (&SLOTS, slots),
        (&LIVE, kernels.live),
    ]);
    for part in KernelPart::ALL.into_iter().filter(|part| part.is_of(m)) {
        measured.set(part.time(), Value::Count(stream.parts[part as usize]));
    }
    let outcome = FlowOutcome {
        live_evaluations: kernels.live,
        measured,
        ..FlowOutcome::plain(timing, actions, stream.memory.traffic(), slots)
    };
    (outcome, stream.memory.recording())
}
