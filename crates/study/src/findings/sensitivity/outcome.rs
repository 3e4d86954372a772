//! What frames cost on a machine, and how two of these differ.

/// What the frames of one trace cost on one machine, means over the frames.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Outcome {
    /// Time of a frame, milliseconds.
    pub frame_time_ms: f64,
    /// Energy of a frame, picojoules.
    pub energy_pj: f64,
    /// Power at the display rate, watts.
    pub power_w: f64,
    /// Area of the chip, mm²; `None` where the energy table has none.
    pub area_mm2: Option<f64>,
}

impl Outcome {
    /// Frames per second; 0 without a time.
    pub fn fps(&self) -> f64 {
        if self.frame_time_ms > 0.0 { 1e3 / self.frame_time_ms } else { 0.0 }
    }

    /// Millijoules per frame.
    pub fn energy_mj(&self) -> f64 {
        self.energy_pj * 1e-9
    }

    /// Relative changes from `base` to this, each 0.1 for ten percent more.
    pub fn change(&self, base: &Outcome) -> Change {
        let of = |new: f64, old: f64| if old == 0.0 { 0.0 } else { new / old - 1.0 };
        let area = self.area_mm2.zip(base.area_mm2).map(|(new, old)| of(new, old));
        Change {
            fps: of(self.fps(), base.fps()),
            energy: of(self.energy_pj, base.energy_pj),
            area: area.unwrap_or(0.0),
        }
    }

    /// Means over traces, each trace with the same weight; of no traces nothing.
    pub fn mean(all: &[Outcome]) -> Outcome {
        let n = all.len().max(1) as f64;
        let mean = |of: fn(&Outcome) -> f64| all.iter().map(of).sum::<f64>() / n;
        Outcome {
            frame_time_ms: mean(|o| o.frame_time_ms),
            energy_pj: mean(|o| o.energy_pj),
            power_w: mean(|o| o.power_w),
            area_mm2: all.first().and_then(|o| o.area_mm2),
        }
    }
}

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
    pub fn of(self, outcome: &Outcome) -> Option<f64> {
        match self {
            Measure::Fps => Some(outcome.fps()),
            Measure::Energy => Some(outcome.energy_pj),
            Measure::Power => Some(outcome.power_w),
            Measure::Area => outcome.area_mm2,
        }
    }

    /// Relative change from `base` to `new`, 0.1 for ten percent more; `None` where either is not
    /// known or `base` is 0.
    pub fn change(self, new: &Outcome, base: &Outcome) -> Option<f64> {
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
    pub base: Outcome,
}

/// What is missing because it was interrupted, if so.
pub(super) fn incomplete_note(traces: &[Traced]) -> Option<String> {
    let trace = traces.iter().find(|t| t.frames < t.asked)?;
    Some(format!("INCOMPLETE: {} of {} frames of {}", trace.frames, trace.asked, trace.name))
}
