//! How what frames cost on two machines differs.

use crate::findings::cost::Cost;

/// Relative changes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Change {
    /// Of the frame rate.
    pub fps: f64,
    /// Of the energy of a frame.
    pub energy: f64,
    /// Of the area.
    pub area: f64,
}

impl Change {
    /// The largest of them, without sign.
    pub fn largest(&self) -> f64 {
        self.fps.abs().max(self.energy.abs()).max(self.area.abs())
    }
}

/// A number that keys are judged by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Measure {
    /// Frames per second.
    Fps,
    /// Energy of a frame.
    Energy,
    /// Power at the display rate.
    Power,
    /// Area of the chip.
    Area,
}

impl Measure {
    /// All, in the order of every output.
    pub const ALL: [Measure; 4] = [Measure::Fps, Measure::Energy, Measure::Power, Measure::Area];

    /// The name in tables and as a key.
    pub const fn name(self) -> &'static str {
        match self {
            Measure::Fps => "fps",
            Measure::Energy => "energy",
            Measure::Power => "power",
            Measure::Area => "area",
        }
    }

    /// The name in titles.
    pub const fn title(self) -> &'static str {
        match self {
            Measure::Fps => "frames per second",
            Measure::Energy => "energy per frame",
            Measure::Power => "power at the display rate",
            Measure::Area => "area",
        }
    }

    /// Its value; `None` where it is not known.
    pub fn of(self, outcome: &Cost) -> Option<f64> {
        match self {
            Measure::Fps => Some(outcome.fps()),
            Measure::Energy => Some(outcome.energy_pj),
            Measure::Power => Some(outcome.power_w),
            Measure::Area => outcome.area_mm2,
        }
    }

    /// Relative change from `base` to `new`, 0.1 for ten percent more; `None` where either is not
    /// known or `base` is 0.
    pub fn change(self, new: &Cost, base: &Cost) -> Option<f64> {
        let old = self.of(base).filter(|&old| old != 0.0)?;
        Some(self.of(new)? / old - 1.0)
    }
}

/// A trace that was simulated.
#[derive(Debug, Clone, PartialEq)]
pub struct Traced {
    /// Name of the trace.
    pub name: String,
    /// Frames that were simulated.
    pub frames: usize,
    /// Frames that were asked for.
    pub asked: usize,
    /// The machine as it is.
    pub base: Cost,
}

/// What is missing because it was interrupted, if so.
pub(super) fn incomplete_note(traces: &[Traced]) -> Option<String> {
    let trace = traces.iter().find(|t| t.frames < t.asked)?;
    Some(format!("INCOMPLETE: {} of {} frames of {}", trace.frames, trace.asked, trace.name))
}
