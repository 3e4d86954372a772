//! What one step would buy: the frame time if one resource were doubled, as simulated elsewhere.

use std::fmt::Write;

use super::format::significant;

/// Time and energy of a frame, mean over the frames that were tried.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cost {
    /// Time of a frame, milliseconds.
    pub frame_time_ms: f64,
    /// Energy of a frame, picojoules.
    pub energy_pj: f64,
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

    /// Lines of a table for the terminal: the `most` best steps that change the time at all.
    pub fn lines(&self, most: usize) -> String {
        let frames = match self.frames.len() {
            1 => "1 frame".into(),
            n => format!("{n} frames"),
        };
        let head = format!("doubling ({frames})");
        let mut text = format!("{head:<28}{:>26}{:>26}\n", "ms per frame", "mJ per frame");
        let moves = |s: &&Step| self.time_change(s).abs() >= 0.005;
        let shown: Vec<&Step> = self.steps.iter().filter(moves).take(most).collect();
        for step in &shown {
            let time = pair(self.base.frame_time_ms, step.cost.frame_time_ms);
            let energy = pair(self.base.energy_pj * 1e-9, step.cost.energy_pj * 1e-9);
            let _ = writeln!(text, "{:<28}{time:>26}{energy:>26}", step.resource);
        }
        let others = self.steps.len() - shown.len();
        if others > 0 {
            let all = if shown.is_empty() { "all" } else { "the other" };
            let _ = writeln!(text, "{all} {others}: see summary.md");
        }
        text
    }
}

/// A relative change; none from nothing.
fn change(from: f64, to: f64) -> f64 {
    if from == 0.0 { 0.0 } else { to / from - 1.0 }
}

/// `2.77 -> 2.10  -24 %`.
fn pair(from: f64, to: f64) -> String {
    format!("{} -> {} {}", significant(from), significant(to), signed_percent(change(from, to)))
}

/// A relative change with its sign, padded: ` -24 %`.
pub fn signed_percent(change: f64) -> String {
    let p = change * 100.0;
    let text = if p.abs() < 0.05 {
        "0 %".to_owned()
    } else if p.abs() < 9.95 {
        format!("{p:+.1} %")
    } else {
        format!("{p:+.0} %")
    };
    format!("{text:>7}")
}
