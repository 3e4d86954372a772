//! The tables of a machine file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use super::attached::{AttachedImpl, AttachedOverlap, AttachedSpec};
pub use super::reproject::ReprojectSpec;
pub use super::rops::{RopImpl, RopSpec};
use crate::flow::over::pixels::{PixelFilter, PixelSource, PixelsSpec};
use crate::flow::steps::StepWidths;
pub use crate::flow::steps::Updated;
use crate::machine::Machine;
use crate::workload::{Cull, FrameDetail, Geometry};
use powergs_base::quantity::{Bytes, BytesPerSecond, Nanoseconds};
use powergs_frame::splat::Intersection;

/// Threads of a warp.
pub const WARP: u32 = 32;

/// The tables of a GPU.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Gpu {
    /// Streaming multiprocessors.
    pub sm: SmSpec,
    /// The cache in front of the memory.
    pub l2: L2Spec,
    /// The interface of the memory.
    pub bus: BusSpec,
    /// What passes between kernels.
    pub launch: LaunchSpec,
    /// The kernel that converts Gaussians.
    pub convert: ConvertSpec,
    /// Kernels that make (tile, Gaussian) pairs of them.
    pub pairs: PairSpec,
    /// Kernels that sort the pairs.
    pub radix: RadixSpec,
    /// The kernel that blends.
    pub blend: BlendSpec,
    /// Kernels that train.
    #[serde(default)]
    pub training: TrainSpec,
    /// Which pixels of a frame are rendered.
    #[serde(default)]
    pub pixels: PixelsSpec,
    /// Kernels that move those of the frame before.
    #[serde(default)]
    pub reproject: ReprojectSpec,
    /// A unit that blends in place of a kernel.
    #[serde(default)]
    pub attached: AttachedSpec,
    /// Raster operations that blend in place of a kernel.
    #[serde(default)]
    pub rops: RopSpec,
}

crate::flow::flow_tables!(
    Gpu,
    super::GpuFlow,
    [
        sm, l2, bus, launch, convert, pairs, radix, blend, training, pixels, reproject, attached,
        rops
    ],
    super::reproject::KEYS_OF_UNITS
);

impl Machine {
    /// The tables of a GPU.
    ///
    /// # Panics
    /// On a machine of another dataflow.
    pub fn gpu(&self) -> &Gpu {
        self.of_type()
    }
}

/// The `[sm]` table: streaming multiprocessors.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SmSpec {
    /// Multiprocessors.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "multiprocessors"))]
    pub units: u32,
    /// Lanes of one, of single precision: an instruction that needs them takes 32 for a cycle.
    #[schemars(range(min = 16, max = 1024), extend("x-unit" = "lanes"))]
    pub lanes: u32,
    /// Lanes of one for exponentials and the like.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "lanes"))]
    pub special: u32,
    /// Warp instructions that one issues in a cycle, of any kind.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "instructions/cycle"))]
    pub schedulers: u32,
    /// Share of the instructions that need lanes of single precision; the others are integers,
    /// comparisons, branches, loads.
    #[schemars(range(min = 0.01, max = 1.0), extend("x-unit" = "fraction"))]
    pub float: f64,
    /// Warps that one has at a time at most.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "warps"))]
    pub warps: u32,
    /// Blocks of threads that one has at a time at most.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "blocks"))]
    pub blocks: u32,
    /// Registers of one, of 32 bits.
    #[schemars(range(min = 1024, max = 4194304), extend("x-unit" = "registers"))]
    pub registers: u32,
    /// Shared memory of one.
    pub shared: Bytes,
    /// Cycles from an instruction of a warp to its next one, in the mean.
    #[schemars(range(min = 1, max = 1000), extend("x-unit" = "cycles"))]
    pub interval: u32,
}

/// The `[l2]` table: the cache that all multiprocessors share.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct L2Spec {
    /// Size.
    pub capacity: Bytes,
    /// Bytes that it moves in a cycle.
    #[schemars(range(min = 1, max = 1048576), extend("x-unit" = "B/cycle"))]
    pub bytes_per_cycle: u32,
    /// What it reads at least.
    pub sector: Bytes,
}

/// The `[bus]` table: the interface of the memory as data sheets have it. `dram.bandwidth` can be
/// left out, or must agree.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BusSpec {
    /// Data pins.
    #[schemars(range(min = 8, max = 65536), extend("x-unit" = "bits"))]
    pub width: u32,
    /// Rate of a pin.
    #[schemars(range(min = 0.01, max = 1000.0), extend("x-unit" = "Gbit/s"))]
    pub gigabits: f64,
}

/// The `[launch]` table: what passes between kernels.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct LaunchSpec {
    /// From the end of a kernel to the first block of the next one.
    pub gap: Nanoseconds,
    /// The host reads how many pairs there are, and launches what is for them.
    pub readback: Nanoseconds,
}

/// The `[convert]` table: the kernel that culls, projects and shades, a thread for each Gaussian.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ConvertSpec {
    /// Position, as stored.
    pub position: Bytes,
    /// Scale, rotation and opacity, as stored.
    pub shape: Bytes,
    /// Spherical harmonics, as stored, of degree 3; fewer with the degree of the scene.
    pub colour: Bytes,
    /// Written for every Gaussian: radius, number of tiles.
    pub mark: Bytes,
    /// Written for one that is not culled: its covariance.
    pub covariance: Bytes,
    /// Written for one with a tile: depth, mean, conic, opacity, colour.
    pub result: Bytes,
    /// Which Gaussians are projected.
    pub cull: Cull,
    /// Instructions of the cull.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "instructions"))]
    pub test: u32,
    /// Instructions of the projection of what is not culled.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "instructions"))]
    pub project: u32,
    /// Instructions of the colour of one with a tile.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "instructions"))]
    pub shade: u32,
    /// Registers of a thread.
    #[schemars(range(min = 16, max = 255), extend("x-unit" = "registers"))]
    pub registers: u32,
}

/// The `[pairs]` table: a prefix sum over the Gaussians, and a thread for each of them that writes
/// its pairs.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PairSpec {
    /// Which tiles a Gaussian is paired with.
    pub test: Intersection,
    /// Key of a pair: tile and depth.
    pub key: Bytes,
    /// Value of a pair: the number of the Gaussian.
    pub value: Bytes,
    /// Read of a Gaussian.
    pub read: Bytes,
    /// Instructions of a Gaussian.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "instructions"))]
    pub gaussian: u32,
    /// Instructions of a pair: a warp goes on until the last of its threads has no more.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "instructions"))]
    pub pair: u32,
}

/// What a radix sort counts its digits by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DigitCount {
    /// One pass over all keys, in front of the others.
    Once,
    /// A pass over the keys in front of each pass.
    EachPass,
}

/// The `[radix]` table: a radix sort by tile and depth.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RadixSpec {
    /// Bits of a digit: passes are as many as the bits of a depth and of a tile take.
    #[schemars(range(min = 1, max = 16), extend("x-unit" = "bits"))]
    pub digit: u32,
    /// Bits of a depth.
    #[schemars(range(min = 0, max = 32), extend("x-unit" = "bits"))]
    pub depth: u32,
    /// What digits are counted by.
    pub count: DigitCount,
    /// Instructions of a pair in a pass.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "instructions"))]
    pub instructions: u32,
}

/// The `[blend]` table: a block of threads for each tile, a thread for each pixel.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BlendSpec {
    /// Side of a tile, a power of two.
    #[schemars(range(min = 8, max = 32), extend("x-unit" = "pixels"))]
    pub tile: u32,
    /// Width of the pixels of a warp, a power of two.
    #[schemars(range(min = 4, max = 32), extend("x-unit" = "pixels"))]
    pub warp_width: u32,
    /// Gaussians that a block reads together.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "Gaussians"))]
    pub batch: u32,
    /// Cycles in which a block waits for a batch.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "cycles"))]
    pub latency: u32,
    /// An entry of a list.
    pub entry: Bytes,
    /// What is read of its Gaussian, in whole sectors.
    pub feature: Bytes,
    /// What shared memory holds of it.
    pub shared: Bytes,
    /// A finished pixel.
    pub pixel: Bytes,
    /// Instructions of a test whether a Gaussian meets the pixels of a warp; 0 for no such test:
    /// each is evaluated until the last pixel of the warp has stopped.
    #[schemars(range(min = 0, max = 10000), extend("x-unit" = "instructions"))]
    pub test: u32,
    /// Instructions of an α, its exponential besides.
    #[schemars(range(min = 1, max = 10000), extend("x-unit" = "instructions"))]
    pub alpha: u32,
    /// Instructions where a pixel of the warp blends.
    #[schemars(range(min = 1, max = 10000), extend("x-unit" = "instructions"))]
    pub blend: u32,
    /// Instructions of a pixel besides: its address, background, results.
    #[schemars(range(min = 1, max = 10000), extend("x-unit" = "instructions"))]
    pub finish: u32,
    /// Registers of a thread.
    #[schemars(range(min = 16, max = 255), extend("x-unit" = "registers"))]
    pub registers: u32,
}

/// Bytes that a slice of the L2 cache moves in a cycle.
const SLICE: f64 = 64.0;

/// The `[training]` table of a GPU: a frame is a step of training, with the loss, the gradients and
/// the update behind it.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct TrainSpec {
    /// What gradients are added up by.
    pub sum: GradientSum,
    /// Which Gaussians are updated.
    pub update: Updated,
    /// Instructions of the loss of a pixel, its gradient included.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "instructions"))]
    pub loss: u32,
    /// Read and written for the loss of a pixel, half and half: pictures, maps, its gradient.
    pub loss_bytes: Bytes,
    /// Read of a pixel where the list is gone through in reverse: gradient, transmittance, number
    /// of entries.
    pub state: Bytes,
    /// Instructions where a pixel of the warp has blended, in reverse.
    #[schemars(range(min = 1, max = 10000), extend("x-unit" = "instructions"))]
    pub gradient: u32,
    /// What is added up for a Gaussian: gradients by mean, conic, opacity and colour, 4 B each.
    pub record: Bytes,
    /// Additions to memory that a slice of the L2 cache, of 64 B a cycle, makes in a cycle.
    #[schemars(range(min = 0.001, max = 64.0), extend("x-unit" = "additions/cycle"))]
    pub atomics: f64,
    /// Written of every Gaussian before anything is added up.
    pub zeroed: Bytes,
    /// Instructions of one with a tile: from these gradients to those by its parameters.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "instructions"))]
    pub chain: u32,
    /// Bytes of the numbers that the update takes through the memory.
    pub widths: StepWidths,
    /// Instructions of the update of a number.
    #[schemars(range(min = 1, max = 10000), extend("x-unit" = "instructions"))]
    pub step: u32,
    /// Steps from one densification to the next, 0 for none: gradients by the screen are added up
    /// in each, and all arrays move once in so many.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "steps"))]
    pub densify: u32,
}

impl Default for TrainSpec {
    /// No training; what there is where the file says only how gradients are added up (A144).
    fn default() -> TrainSpec {
        TrainSpec {
            sum: GradientSum::None,
            update: Updated::All,
            loss: 900,
            loss_bytes: Bytes(120),
            state: Bytes(20),
            gradient: 110,
            record: Bytes(36),
            atomics: 1.0,
            zeroed: Bytes(300),
            chain: 700,
            widths: StepWidths::default(),
            step: 16,
            densify: 0,
        }
    }
}

/// What gradients of pixels are added up by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GradientSum {
    /// Frames are rendered, and nothing is trained.
    None,
    /// Each pixel adds its own to memory.
    Pixel,
    /// A warp adds up those of its pixels first.
    Warp,
    /// A block adds up those of its warps first.
    Block,
}

impl TrainSpec {
    /// Cycles in which a cache of so many bytes a cycle makes so many additions.
    pub fn adding(&self, additions: u64, bytes_per_cycle: u32) -> u64 {
        let rate = self.atomics * f64::from(bytes_per_cycle) / SLICE;
        (additions as f64 / rate).ceil() as u64
    }

    /// Whether frames are trained on.
    pub fn trains(&self) -> bool {
        self.sum != GradientSum::None
    }
}

impl BusSpec {
    /// What all pins carry.
    pub fn rate(&self) -> BytesPerSecond {
        BytesPerSecond(f64::from(self.width) / 8.0 * self.gigabits * 1e9)
    }
}

impl SmSpec {
    /// Warp instructions that one issues in a cycle: as many as it has schedulers, or as its lanes
    /// take.
    pub fn issue(&self) -> f64 {
        let by_lanes = f64::from(self.lanes) / f64::from(WARP) / self.float;
        by_lanes.min(f64::from(self.schedulers))
    }

    /// Blocks that one has at a time: of `threads` threads with so many registers, and so much
    /// shared memory.
    pub fn resident(&self, threads: u32, registers: u32, shared: u64) -> u32 {
        let by_warps = self.warps / threads.div_ceil(WARP).max(1);
        let by_registers = self.registers / (threads * registers).max(1);
        let by_shared = self.shared.0.checked_div(shared).unwrap_or(u64::MAX);
        let by_shared = u32::try_from(by_shared).unwrap_or(u32::MAX);
        self.blocks.min(by_warps).min(by_registers).min(by_shared)
    }
}

impl Gpu {
    /// How frames are binned for it.
    pub fn geometry(&self) -> Geometry {
        Geometry {
            tile: self.blend.tile,
            subtile: self.blend.tile.min(8),
            sort_group: self.blend.tile,
            chunk: self.blend.batch,
            test: self.pairs.test,
            cull: self.convert.cull,
        }
    }

    /// Which pixels are rendered; `None` where all are.
    pub fn pixel_filter(&self) -> Option<PixelFilter<'_>> {
        self.pixels.filter(self.blend.pixel)
    }

    /// Whether it moves pixels of the frame before.
    pub fn reprojects(&self) -> bool {
        self.pixels.source == PixelSource::Warped
    }

    /// What of a frame it needs besides lists.
    pub fn detail(&self) -> FrameDetail {
        FrameDetail { pixels: true, whole: false }
    }

    /// Blocks of the blending kernel that a multiprocessor has at a time.
    pub fn blending(&self) -> u32 {
        let BlendSpec { tile, registers, batch, shared, .. } = self.blend;
        self.sm.resident(tile * tile, registers, u64::from(batch) * shared.0)
    }

    /// Passes of the sort: by depth, and by tile where Gaussians are paired with tiles.
    pub fn passes(&self, tiles: u64) -> u64 {
        let of_tiles = tiles.max(2).next_power_of_two().ilog2();
        let bits = self.radix.depth + if self.rops.is_there() { 0 } else { of_tiles };
        u64::from(bits.div_ceil(self.radix.digit))
    }
}
