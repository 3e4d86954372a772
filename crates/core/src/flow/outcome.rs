//! What comes out of a frame on a machine of any dataflow, before prices.

use super::steps::StepEnds;
use crate::kernel::FrameTiming;
use crate::kernel::traffic::Traffic;
use crate::workload::FrameWorkload;
use crate::workload::reuse::ReuseSummary;
use powergs_energy::action::ActionCounts;
use powergs_frame::fovea::LEVELS;
use powergs_frame::splat::FoveaCounters;

/// One frame on one machine: counts and times, and no cost.
#[derive(Debug, Clone, PartialEq)]
pub struct FlowOutcome {
    /// When everything happened.
    pub timing: FrameTiming,
    /// How often everything happened, the cycles of clocks left out.
    pub actions: ActionCounts,
    /// DRAM bytes served.
    pub served: Traffic,
    /// DRAM bytes read that nobody wrote.
    pub unwritten_bytes: u64,
    /// α evaluations that the machine executes.
    pub executed_evaluations: u64,
    /// Those of them whose pixel has not stopped.
    pub live_evaluations: u64,
    /// Order of the sorted lists; `None` where it was not measured.
    pub lists: Option<ListOrder>,
    /// The feature cache, where the machine has one.
    pub cache: Option<CacheSummary>,
    /// The second view of a pair, where it is made of the first one.
    pub stereo: Option<StereoSummary>,
    /// The kernels, where the machine is a GPU.
    pub kernels: Option<KernelSummary>,
    /// Where pixels come from, where not all are rendered.
    pub pixels: Option<PixelSummary>,
    /// What follows the frame, where it is trained on.
    pub step: Option<StepSummary>,
    /// Results of foveated frames.
    pub fovea: Option<Foveal<RegionWork>>,
}

impl FlowOutcome {
    /// Of a plain frame on a machine without a cache, whose pixels all need `evaluations`.
    pub fn plain(
        timing: FrameTiming,
        actions: ActionCounts,
        served: Traffic,
        evaluations: u64,
    ) -> FlowOutcome {
        FlowOutcome {
            timing,
            actions,
            served,
            unwritten_bytes: 0,
            executed_evaluations: evaluations,
            live_evaluations: evaluations,
            lists: None,
            cache: None,
            stereo: None,
            kernels: None,
            pixels: None,
            step: None,
            fovea: None,
        }
    }
}

/// The work of one region of a foveated frame.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RegionWork {
    /// Tiles.
    pub tiles: u64,
    /// Entries that they load.
    pub entries: u64,
    /// Cycles for which the rendering units of a core work on them, without draining.
    pub cycles: u64,
    /// How often everything happened for them.
    pub actions: ActionCounts,
}

/// Order of the sorted lists of a frame: a frame either sorts its lists from scratch,
/// or takes over the order of the frame before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ListOrder {
    /// Sorted from scratch, and checked with the machine's keys.
    Sorted(OrderSummary),
    /// Taken over from the frame before, and updated.
    Reused(ReuseSummary),
}

/// Results of a foveated frame on a machine; `R` holds those of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foveal<R> {
    /// Of the whole frame.
    pub summary: FoveaSummary,
    /// R1 to R4.
    pub regions: [R; LEVELS],
}

/// How well the lists of a frame are sorted, measured with the machine's keys.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OrderSummary {
    /// Pairs of neighbours in all sorted lists.
    pub neighbours: u64,
    /// Neighbours in the wrong order of depth.
    pub out_of_order: u64,
    /// Neighbours with equal keys and different depths.
    pub equal_keys: u64,
    /// Pairs of one list, neighbours or not, in the wrong order.
    pub inversions: u64,
}

/// Hits and misses of the feature cache in a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CacheSummary {
    /// Feature records found.
    pub hits: u64,
    /// Feature records read from DRAM.
    pub misses: u64,
}

/// The kernels of a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct KernelSummary {
    /// Cycles of those of each [part](super::gpu::KernelPart).
    pub parts: [u64; super::gpu::KernelPart::ALL.len()],
    /// Cycles between them.
    pub launching: u64,
    /// Gaussians that blocks read and find in the L2 cache.
    pub hits: u64,
    /// Those that they read from the memory.
    pub misses: u64,
    /// Lanes of warps that evaluate an entry.
    pub slots: u64,
    /// Those of them whose pixel has not stopped.
    pub live: u64,
}

/// What follows a frame that is trained on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StepSummary {
    /// Cycles in which its picture is compared with the photo.
    pub loss: u64,
    /// Cycles in which lists are gone through in reverse.
    pub reverse: u64,
    /// Cycles in which gradients by parameters are found.
    pub chain: u64,
    /// Cycles in which parameters are updated.
    pub update: u64,
    /// Additions to sums of Gaussians in a cache, and those whose sum it has; 0 where machines have
    /// none.
    pub sums: [u64; 2],
}

impl StepSummary {
    /// Of the parts behind a frame that ended when they did.
    pub fn between(frame: u64, ends: StepEnds) -> StepSummary {
        let [loss, reverse, chain, update] = ends;
        StepSummary {
            loss: loss - frame,
            reverse: reverse - loss,
            chain: chain - reverse,
            update: update - chain,
            sums: [0; 2],
        }
    }

    /// All of them.
    pub fn cycles(&self) -> u64 {
        self.loss + self.reverse + self.chain + self.update
    }

    /// Adds that of another view.
    pub fn add(&mut self, other: &StepSummary) {
        self.loss += other.loss;
        self.reverse += other.reverse;
        self.chain += other.chain;
        self.update += other.update;
        self.sums = [0, 1].map(|i| self.sums[i] + other.sums[i]);
    }
}

/// Where the pixels of a frame come from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PixelSummary {
    /// Pixels of the image.
    pub pixels: u64,
    /// Those that are rendered.
    pub rendered: u64,
    /// Those that are moved from the frame before.
    pub taken: u64,
    /// Those that are filled in from their neighbours.
    pub filled: u64,
    /// Pixels that look up their first Gaussians.
    pub lookups: u64,
    /// Those whose colour is known by them.
    pub hits: u64,
}

impl PixelSummary {
    /// Adds another frame.
    pub fn add(&mut self, other: &PixelSummary) {
        self.pixels += other.pixels;
        self.rendered += other.rendered;
        self.taken += other.taken;
        self.filled += other.filled;
        self.lookups += other.lookups;
        self.hits += other.hits;
    }
}

/// What a second view that is made of the first one has of its own lists.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct StereoSummary {
    /// (Splat, tile) pairs that the first view handed on.
    pub handed_on: u64,
    /// Entries that the lists of the second view would have.
    pub entries: u64,
    /// Those that they have.
    pub kept: u64,
    /// Blends of the second view.
    pub blends: u64,
    /// Those that it loses, because their splats were not handed on.
    pub lost_blends: u64,
    /// Pixels of the second view.
    pub pixels: u64,
    /// Those whose colour may be another one by a step of eight bits or more: the weights of what
    /// is lost add up to 1/255.
    pub changed_pixels: u64,
    /// The same for what is lost because its disparity is beyond the largest.
    pub cut_off_pixels: u64,
    /// The largest disparity of a splat that was handed on, pixels.
    pub largest_disparity: f32,
}

impl StereoSummary {
    /// Adds a part of a view, or another pair.
    pub fn add(&mut self, other: &StereoSummary) {
        self.handed_on += other.handed_on;
        self.entries += other.entries;
        self.kept += other.kept;
        self.blends += other.blends;
        self.lost_blends += other.lost_blends;
        self.pixels += other.pixels;
        self.changed_pixels += other.changed_pixels;
        self.cut_off_pixels += other.cut_off_pixels;
        self.largest_disparity = self.largest_disparity.max(other.largest_disparity);
    }
}

/// Counters of a foveated frame.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FoveaSummary {
    /// Gaze, shares of width and height.
    pub gaze: [f32; 2],
    /// Tiles.
    pub tiles: u64,
    /// Tiles that blend two levels.
    pub blending_tiles: u64,
    /// Further counters.
    pub counters: FoveaCounters,
}

impl FoveaSummary {
    /// Of a binned frame; `None` for plain ones.
    pub(crate) fn of(workload: &FrameWorkload) -> Option<FoveaSummary> {
        let fovea = workload.fovea.as_ref()?;
        Some(FoveaSummary {
            gaze: fovea.gaze.point,
            tiles: workload.tiles.len() as u64,
            blending_tiles: fovea.blending_tiles,
            counters: fovea.counters,
        })
    }
}
