//! What frames cost on a machine.

use powergs_core::sim::FrameReport;
use powergs_core::sim::statistics::Weight;

use super::sensitivity::Change;

/// What frames cost on one machine: means over the frames, power as energy over time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    /// Time of a frame, milliseconds.
    pub frame_time_ms: f64,
    /// Energy of a frame, picojoules.
    pub energy_pj: f64,
    /// Power at the display rate, watts.
    pub power_w: f64,
    /// Area of the die, mm²; `None` where the energy table has none.
    pub area_mm2: Option<f64>,
}

impl Cost {
    /// Frames per second; 0 without a time.
    pub fn fps(&self) -> f64 {
        if self.frame_time_ms > 0.0 { 1e3 / self.frame_time_ms } else { 0.0 }
    }

    /// Millijoules per frame.
    pub fn energy_mj(&self) -> f64 {
        self.energy_pj * 1e-9
    }

    /// Relative changes from `base` to this, each 0.1 for ten percent more.
    pub fn change(&self, base: &Cost) -> Change {
        let of = |new: f64, old: f64| if old == 0.0 { 0.0 } else { new / old - 1.0 };
        let area = self.area_mm2.zip(base.area_mm2).map(|(new, old)| of(new, old));
        Change {
            fps: of(self.fps(), base.fps()),
            energy: of(self.energy_pj, base.energy_pj),
            area: area.unwrap_or(0.0),
        }
    }

    /// Means over traces, each trace with the same weight; of no traces nothing.
    pub fn mean(all: &[Cost]) -> Cost {
        let n = all.len().max(1) as f64;
        let mean = |of: fn(&Cost) -> f64| all.iter().map(of).sum::<f64>() / n;
        Cost {
            frame_time_ms: mean(|o| o.frame_time_ms),
            energy_pj: mean(|o| o.energy_pj),
            power_w: mean(|o| o.power_w),
            area_mm2: all.first().and_then(|o| o.area_mm2),
        }
    }
}

/// Adds up what frames cost.
#[derive(Debug, Clone, Copy, Default)]
pub struct CostSum {
    sum: Cost,
    frames: u32,
    shown: f64,
}

impl CostSum {
    /// Adds a frame, shown on a display at `fps` frames per second.
    pub fn add(&mut self, report: &FrameReport, fps: f64) {
        let shown = Weight::Displayed.of(report, fps);
        self.sum.frame_time_ms += report.frame_time_s().unwrap_or(0.0) * 1e3;
        self.sum.energy_pj += report.energy.total().0;
        self.sum.power_w += report.power_display_rate_w(fps) * shown;
        self.sum.area_mm2 = report.area.as_ref().map(|area| area.total().0);
        self.frames += 1;
        self.shown += shown;
    }

    /// The means; of no frames nothing.
    pub fn mean(&self) -> Cost {
        let n = f64::from(self.frames.max(1));
        let shown = if self.frames == 0 { 1.0 } else { self.shown };
        Cost {
            frame_time_ms: self.sum.frame_time_ms / n,
            energy_pj: self.sum.energy_pj / n,
            power_w: self.sum.power_w / shown,
            area_mm2: self.sum.area_mm2,
        }
    }
}

impl Cost {
    /// What some frames cost that are shown on a display at `fps` frames per second.
    pub fn of_frames<'a>(reports: impl IntoIterator<Item = &'a FrameReport>, fps: f64) -> Cost {
        let mut sum = CostSum::default();
        reports.into_iter().for_each(|report| sum.add(report, fps));
        sum.mean()
    }

    /// Frames per second and mm² of die; `None` without an area.
    pub fn fps_per_mm2(&self) -> Option<f64> {
        self.area_mm2.filter(|&area| area > 0.0).map(|area| self.fps() / area)
    }
}
