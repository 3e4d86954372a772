//! What comes out of a frame on a machine of any dataflow, before prices.

use crate::kernel::FrameTiming;
use crate::kernel::traffic::Traffic;
use crate::stage::Measured;
use crate::workload::FrameWorkload;
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
    /// What its stages measured besides.
    pub measured: Measured,
    /// Results of foveated frames.
    pub fovea: Option<Foveal<RegionWork>>,
}

impl FlowOutcome {
    /// Of a plain frame of which nothing else is measured, whose pixels all need `evaluations`.
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
            measured: Measured::default(),
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

/// Results of a foveated frame on a machine; `R` holds those of a region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foveal<R> {
    /// Of the whole frame.
    pub summary: FoveaSummary,
    /// R1 to R4.
    pub regions: [R; LEVELS],
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
