//! What one step would buy: the frame time if one resource were doubled, as simulated elsewhere.

use powergs_core::sim::FrameReport;

/// Time and energy of a frame, mean over the frames that were tried.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    /// Time of a frame, milliseconds.
    pub frame_time_ms: f64,
    /// Energy of a frame, picojoules.
    pub energy_pj: f64,
}

impl Cost {
    /// What one frame costs.
    pub fn of(report: &FrameReport) -> Cost {
        Cost {
            frame_time_ms: report.frame_time_s().unwrap_or(0.0) * 1e3,
            energy_pj: report.energy.total().0,
        }
    }

    /// The mean over some frames; of none nothing.
    pub fn mean<'a>(reports: impl IntoIterator<Item = &'a FrameReport>) -> Cost {
        let (mut sum, mut n) = (Cost::default(), 0_u32);
        for cost in reports.into_iter().map(Cost::of) {
            sum.frame_time_ms += cost.frame_time_ms;
            sum.energy_pj += cost.energy_pj;
            n += 1;
        }
        let n = f64::from(n.max(1));
        Cost { frame_time_ms: sum.frame_time_ms / n, energy_pj: sum.energy_pj / n }
    }
}

/// One resource, doubled.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// What was doubled, in the words of the machine file.
    pub resource: &'static str,
    /// The `--set` values that double it.
    pub sets: Vec<String>,
    /// What a frame then costs.
    pub cost: Cost,
    /// Assumptions that decide how fast the resource is.
    pub assumptions: &'static [&'static str],
}

/// A resource that could not be doubled.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skipped {
    /// What was to be doubled.
    pub resource: &'static str,
    /// Why that is no machine.
    pub reason: String,
}

/// The whole experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct WhatIf {
    /// Positions in the trace of the frames that were tried.
    pub frames: Vec<usize>,
    /// What these frames cost on the machine as it is.
    pub base: Cost,
    /// Resources by the time that doubling them saves, most first.
    pub steps: Vec<Step>,
    /// Resources that could not be doubled.
    pub skipped: Vec<Skipped>,
}

impl WhatIf {
    /// The experiment with its steps in order. Equal gains keep the order in which they came.
    pub fn new(
        frames: Vec<usize>,
        base: Cost,
        mut steps: Vec<Step>,
        skipped: Vec<Skipped>,
    ) -> WhatIf {
        steps.sort_by(|a, b| a.cost.frame_time_ms.total_cmp(&b.cost.frame_time_ms));
        WhatIf { frames, base, steps, skipped }
    }

    /// Relative change of the frame time: -0.25 is a quarter less.
    pub fn time_change(&self, step: &Step) -> f64 {
        change(self.base.frame_time_ms, step.cost.frame_time_ms)
    }

    /// Relative change of the energy of a frame.
    pub fn energy_change(&self, step: &Step) -> f64 {
        change(self.base.energy_pj, step.cost.energy_pj)
    }

    /// The step that saves most, if any saves at least one per cent.
    pub fn best(&self) -> Option<&Step> {
        self.steps.first().filter(|s| self.time_change(s) <= -0.01)
    }
}

/// The relative change from one number to another: -0.25 is a quarter less, from nothing none.
pub fn change(from: f64, to: f64) -> f64 {
    if from == 0.0 { 0.0 } else { to / from - 1.0 }
}
