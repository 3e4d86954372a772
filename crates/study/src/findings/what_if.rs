//! What one step would buy: the frame time if one resource were doubled, as simulated elsewhere.

use super::cost::Cost;

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
    /// Whether `base` and `steps` have the `calibrated` model of the DRAM in place of `banked`.
    pub is_calibrated: bool,
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
        WhatIf { frames, base, steps, skipped, is_calibrated: false }
    }

    /// Relative change of the frame time: -0.25 is a quarter less.
    pub fn time_change(&self, step: &Step) -> f64 {
        change(self.base.frame_time_ms, step.cost.frame_time_ms)
    }

    /// Relative change of the energy of a frame.
    pub fn energy_change(&self, step: &Step) -> f64 {
        change(self.base.energy_pj, step.cost.energy_pj)
    }

    /// Relative change of the power at the display rate.
    pub fn power_change(&self, step: &Step) -> f64 {
        change(self.base.power_w, step.cost.power_w)
    }

    /// Relative change of the area of the die; `None` without an area.
    pub fn area_change(&self, step: &Step) -> Option<f64> {
        Some(change(self.base.area_mm2?, step.cost.area_mm2?))
    }

    /// Relative change of the frames per second and mm²; `None` without an area.
    pub fn merit_change(&self, step: &Step) -> Option<f64> {
        Some(change(self.base.fps_per_mm2()?, step.cost.fps_per_mm2()?))
    }

    /// What to do next.
    pub fn advice(&self) -> Advice<'_> {
        let faster = || self.steps.iter().filter(|s| self.time_change(s) <= -WORTH);
        let Some(fastest) = faster().next() else { return Advice::Nothing };
        if self.base.area_mm2.is_none() {
            return Advice::Fastest(fastest);
        }
        let merit = |s: &&Step| self.merit_change(s).unwrap_or(f64::NEG_INFINITY);
        let worth = faster().filter(|s| merit(s) >= WORTH);
        match worth.max_by(|a, b| merit(a).total_cmp(&merit(b))) {
            Some(step) => Advice::Take(step),
            None => Advice::AreaOnly(fastest),
        }
    }
}

/// What doubling resources suggests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Advice<'a> {
    /// The step that raises the frames per second and mm² most.
    Take(&'a Step),
    /// Steps save time, but none raises the frames per second and mm²: the one that saves most.
    AreaOnly(&'a Step),
    /// The step that saves most time; no area is known.
    Fastest(&'a Step),
    /// No step saves one per cent of the time.
    Nothing,
}

/// Relative changes below this are not worth a step.
const WORTH: f64 = 0.01;

/// The relative change from one number to another: -0.25 is a quarter less, from nothing none.
pub fn change(from: f64, to: f64) -> f64 {
    if from == 0.0 { 0.0 } else { to / from - 1.0 }
}
