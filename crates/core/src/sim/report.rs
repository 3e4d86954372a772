//! The report of one simulated frame.

use super::RegionReport;
use crate::flow::{FoveaSummary, Foveal, Task};
use crate::kernel::FrameTiming;
use crate::stage::Measured;
use powergs_base::quantity::Hertz;
use powergs_energy::action::ActionCounts;
use powergs_energy::{Area, EnergyBreakdown, Standby};
use powergs_frame::fovea::LEVELS;
use powergs_frame::scene::{Eye, ShDegree};
use powergs_frame::splat::Counters;

/// One frame of the display, simulated: one view, or the pair of views that both eyes see in one
/// period, one after the other. Times, counts, bytes and joules are those of all its views.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameReport {
    /// Position in the trace; of a pair, that of its left eye.
    pub frame: usize,
    /// Name of the view; of a pair, without that of an eye.
    pub name: String,
    /// The eye that sees it, where it is half of a pair.
    pub eye: Option<Eye>,
    /// Views: 2 for a pair, else 1.
    pub eyes: u32,
    /// Degree of the scene's spherical harmonics; `None` where the trace does not say, which counts
    /// as 3.
    pub sh_degree: Option<ShDegree>,
    /// Workload counters under the machine's geometry.
    pub counters: Counters,
    /// Bytes and FLOPs by stage, order of `Phase::WORK`.
    pub stages: [StageBytes; 3],
    /// Action counts; empty in the `paper` model.
    pub actions: ActionCounts,
    /// Energy of the frame. Standby parts are for the frame's own time.
    pub energy: EnergyBreakdown,
    /// Power that is paid for time.
    pub standby: Standby,
    /// Area of the die by block, where the energy table knows it.
    pub area: Option<Area>,
    /// Standby of the chip's side of the memory channels (PHY), watts: a part of the background.
    pub phy_standby_w: f64,
    /// Display power of the frame's image, watts, where the trace carries the image means; of a
    /// pair, both panels'.
    pub display_w: Option<f64>,
    /// Results of one model only.
    pub model: ModelReport,
}

/// Results that only one of the models gives.
#[derive(Debug, Clone, PartialEq)]
pub enum ModelReport {
    /// Closed-form counts, without time.
    Paper(PaperReport),
    /// The simulated machine. Boxed: it is many times the size of the other.
    Cycle(Box<CycleReport>),
}

/// Results of the `paper` model besides counts and energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaperReport {
    /// Results of foveated frames.
    pub fovea: Option<FoveaSummary>,
}

/// Results of the `cycle` model besides counts and energy.
#[derive(Debug, Clone, PartialEq)]
pub struct CycleReport {
    /// When everything happened.
    pub timing: FrameTiming,
    /// Clock of the machine.
    pub clock: Hertz,
    /// What the frame is.
    pub task: Task,
    /// Cycles from its first read to its last write: more than `timing.frame`, the distance of two
    /// frames, where several are under way at a time.
    pub latency: u64,
    /// α evaluations that the machine executes: every pixel of every live sub-tile.
    pub executed_evaluations: u64,
    /// Those of them whose pixel has not stopped.
    pub live_evaluations: u64,
    /// DRAM bytes read that nobody wrote (`record.feature-source = "nobody"`).
    pub unwritten_bytes: u64,
    /// What its stages measured besides.
    pub measured: Measured,
    /// Results of foveated frames.
    pub fovea: Option<Foveal<RegionReport>>,
}

impl CycleReport {
    /// Time of the frame, seconds.
    pub fn frame_time_s(&self) -> f64 {
        self.timing.frame as f64 / self.clock.0
    }

    /// DRAM bytes that were asked for over the time of the frame, 10⁹ bytes per second; not finite
    /// where the frame takes no time.
    pub fn dram_bandwidth_gb_s(&self) -> f64 {
        self.timing.dram.requested_bytes() as f64 * 1e-9 / self.frame_time_s()
    }
}

impl FrameReport {
    /// The SH degree that the frame counts as: 3 where the trace does not say.
    pub fn colour_degree(&self) -> ShDegree {
        self.sh_degree.unwrap_or(ShDegree::MAX)
    }

    /// The results of the `cycle` model; `None` for the `paper` model.
    pub fn cycle(&self) -> Option<&CycleReport> {
        match &self.model {
            ModelReport::Paper(_) => None,
            ModelReport::Cycle(cycle) => Some(cycle),
        }
    }

    /// When everything happened; `None` in the `paper` model.
    pub fn timing(&self) -> Option<&FrameTiming> {
        self.cycle().map(|cycle| &cycle.timing)
    }

    /// The summary of a foveated frame, in either model.
    pub fn fovea(&self) -> Option<&FoveaSummary> {
        match &self.model {
            ModelReport::Paper(paper) => paper.fovea.as_ref(),
            ModelReport::Cycle(cycle) => cycle.fovea.as_ref().map(|fovea| &fovea.summary),
        }
    }

    /// R1 to R4 of a foveated frame; `None` in the `paper` model.
    pub fn regions(&self) -> Option<&[RegionReport; LEVELS]> {
        self.cycle()?.fovea.as_ref().map(|fovea| &fovea.regions)
    }

    /// What the frame is; in the `paper` model it is rendered.
    pub fn task(&self) -> Task {
        self.cycle().map_or(Task::RENDER, |cycle| cycle.task)
    }

    /// Time from the first read of the frame to its last write, seconds; `None` in the `paper`
    /// model.
    pub fn latency_s(&self) -> Option<f64> {
        self.cycle().map(|cycle| cycle.latency as f64 / cycle.clock.0)
    }

    /// Distance of two frames that run back to back, seconds; `None` in the `paper` model.
    pub fn frame_time_s(&self) -> Option<f64> {
        self.cycle().map(CycleReport::frame_time_s)
    }

    /// Frames per second when frames run back to back; `None` without a time.
    pub fn achieved_fps(&self) -> Option<f64> {
        self.frame_time_s().filter(|&s| s > 0.0).map(f64::recip)
    }

    /// Energy of the frame x achieved frames per second, watts.
    pub fn power_full_rate_w(&self) -> Option<f64> {
        Some(self.energy.total().0 * 1e-12 * self.achieved_fps()?)
    }

    /// Frames per second that a display at `fps` gets: that rate, or what the machine achieves
    /// where that is less. Steps wait for no display: they run back to back.
    pub fn displayed_fps(&self, fps: f64) -> f64 {
        let runs_on = !self.task().is_shown() || self.misses_deadline(fps);
        if runs_on { self.achieved_fps().unwrap_or(fps) } else { fps }
    }

    /// Display periods for which a frame is shown where pictures change between periods alone;
    /// `None` for what nobody shows, and in the `paper` model.
    pub fn display_periods(&self, fps: f64) -> Option<u64> {
        let seconds = self.frame_time_s().filter(|_| self.task().is_shown())?;
        Some(((seconds * fps).ceil() as u64).max(1))
    }

    /// Power at a display rate, watts: energy over the longer of the frame time and the period of
    /// the display, what is paid for time included. A machine that misses the rate draws what it
    /// draws at full rate, and no more.
    pub fn power_display_rate_w(&self, fps: f64) -> f64 {
        let work = self.energy.dynamic().0 * 1e-12 * self.displayed_fps(fps);
        work + self.standby_w(fps).iter().sum::<f64>()
    }

    /// Power that is paid for time at a display rate, watts: leakage, DRAM background, DRAM
    /// refresh.
    pub fn standby_w(&self, fps: f64) -> [f64; 3] {
        self.standby.at_rate(self.frame_time_s().unwrap_or(0.0), self.displayed_fps(fps))
    }

    /// Whether the frame takes longer than a period of the display that shows it.
    pub fn misses_deadline(&self, fps: f64) -> bool {
        let is_late = self.frame_time_s().is_some_and(|seconds| seconds > fps.recip());
        is_late && self.task().is_shown()
    }
}

/// Facts about a frame that its report repeats: no result of simulation.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Label {
    /// Position in the trace.
    pub frame: usize,
    /// Name of the view.
    pub name: String,
    /// The eye that sees it, where it is half of a pair.
    pub eye: Option<Eye>,
    /// Degree of the scene's spherical harmonics, where the trace says it.
    pub sh_degree: Option<ShDegree>,
    /// Display power of the frame's image, watts, where it is known.
    pub display_w: Option<f64>,
}

/// DRAM bytes of one stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StageBytes {
    /// Read.
    pub read: u64,
    /// Written.
    pub write: u64,
    /// Moved in or out of on-chip buffers.
    pub sram: u64,
    /// Floating-point operations (`paper` model; zero in `cycle`, which counts actions).
    pub flops: u64,
}
