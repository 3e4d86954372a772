//! The record of a run: what the catalogue says of it. Conclusions, pages and comparisons ask it
//! by [`Key`]; it is the same whether the frames were just simulated or are those of a report.

use super::{Aggregate, Key, Statistic, catalogue};
use crate::accel::Stall;
use crate::sim::FrameReport;
use powergs_energy::action::UnitKind;

/// Every statistic over the frames of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Record {
    /// Display rate, frames per second.
    pub display_fps: f64,
    /// Frames of the run, at least one.
    pub frames: u64,
    /// In the order of the catalogue; `None` where a frame has no value.
    pub aggregates: Vec<Option<Aggregate>>,
}

/// Parts of the cycles of a unit: those with work, waits by cause, those without work.
const PARTS: usize = Stall::ALL.len() + 2;

impl Record {
    /// What the parts of the cycles of a unit are called: busy, stalls by cause, idle.
    pub const UNIT_PARTS: [&'static str; PARTS] = {
        let mut parts = ["busy"; PARTS];
        let mut i = 0;
        while i < Stall::ALL.len() {
            parts[i + 1] = Stall::ALL[i].name();
            i += 1;
        }
        parts[PARTS - 1] = "idle";
        parts
    };

    /// The record of `frames` on a display at `display_fps` frames per second; `None` without
    /// frames.
    pub fn of(frames: &[FrameReport], display_fps: f64) -> Option<Record> {
        let aggregate = |s: &Statistic| {
            let value = |f| (s.of(f, display_fps), s.weight.of(f, display_fps));
            Aggregate::weighted(frames.iter().map(value))
        };
        let aggregates = catalogue().iter().map(aggregate).collect();
        let record = Record { display_fps, frames: frames.len() as u64, aggregates };
        (!frames.is_empty()).then_some(record)
    }

    /// The aggregate of the statistic called `name`; `None` where a frame has no value of it, or no
    /// statistic has this name.
    pub fn named(&self, name: &str) -> Option<Aggregate> {
        self.aggregates[catalogue().iter().position(|s| s.name == name)?]
    }

    /// The aggregate of a statistic; `None` where a frame has no value of it.
    pub fn aggregate(&self, key: Key) -> Option<Aggregate> {
        self.named(&key.name())
    }

    /// The mean of a statistic; `None` where a frame has no value of it.
    pub fn mean(&self, key: Key) -> Option<f64> {
        self.aggregate(key).map(|all| all.mean)
    }

    /// The mean of a statistic that every run has, but older reports may not: not a number there.
    pub fn value(&self, key: Key) -> f64 {
        self.mean(key).unwrap_or(f64::NAN)
    }

    /// Whether frames take time, as they do in the `cycle` model.
    pub fn has_time(&self) -> bool {
        self.mean(Key::FrameTime).is_some()
    }

    /// Frames that took longer than the display period; `None` in a model without time.
    pub fn deadline_misses(&self) -> Option<u64> {
        let share = self.mean(Key::DeadlineMissed)?;
        Some((share * self.frames as f64).round() as u64)
    }

    /// Frames per second that the display gets: its rate, or what is reached of it.
    pub fn displayed_fps(&self) -> f64 {
        self.mean(Key::DisplayedFps).unwrap_or(self.display_fps)
    }

    /// Whether the run falls short of the display rate.
    pub fn misses(&self) -> bool {
        self.displayed_fps() < self.display_fps * (1.0 - 1e-9)
    }

    /// Energy of a frame at the display rate, standby until the next one included, joules.
    pub fn displayed_energy_j(&self) -> f64 {
        self.value(Key::Power) / self.displayed_fps()
    }

    /// Frames over the simulated time of all of them, per second: the rate of the run.
    pub fn throughput_fps(&self) -> Option<f64> {
        Some(1.0 / self.mean_s()?)
    }

    /// Energy of all frames over the simulated time of all of them, watts: power at full rate.
    pub fn throughput_power_w(&self) -> Option<f64> {
        Some(self.value(Key::Energy) * 1e-12 / self.mean_s()?)
    }

    /// Mean time of a frame, seconds; above zero.
    fn mean_s(&self) -> Option<f64> {
        self.mean(Key::FrameTime).map(|ms| ms * 1e-3).filter(|s| *s > 0.0)
    }

    /// Shares of all cycles of the units of a kind, in the order of [`Record::UNIT_PARTS`]; all
    /// zero if there are none.
    pub fn unit_shares(&self, kind: UnitKind) -> [f64; PARTS] {
        let mut cycles = [self.value(Key::Busy(kind)); PARTS];
        for (part, cause) in cycles[1..].iter_mut().zip(Stall::ALL) {
            *part = self.value(Key::Stalled(kind, cause));
        }
        cycles[PARTS - 1] = self.value(Key::Idle(kind));
        let total: f64 = cycles.iter().sum();
        cycles.map(|c| if total == 0.0 { 0.0 } else { c / total })
    }
}
