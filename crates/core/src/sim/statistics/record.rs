//! The record of a run: what the catalogue says of it. Conclusions, pages and comparisons ask it
//! by [`Key`]; it is the same whether the frames were just simulated or are those of a report.

use super::{Aggregate, Key, Statistic, catalogue, shown};
use crate::sim::FrameReport;
use crate::stage::{From, Stall, hardware, stage};
use powergs_energy::action::StageId;

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

/// A part of the cycles of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UnitPart {
    /// With work.
    Busy,
    /// With work that could not proceed.
    Stalled(Stall),
    /// Without work.
    Idle,
}

impl UnitPart {
    /// All parts, in report order: with work, waits by cause, without.
    pub fn all() -> impl Iterator<Item = UnitPart> + Clone {
        let waits = Stall::all().iter().map(|cause| UnitPart::Stalled(*cause));
        [UnitPart::Busy].into_iter().chain(waits).chain([UnitPart::Idle])
    }

    /// The name in every output.
    pub fn name(self) -> &'static str {
        match self {
            UnitPart::Busy => "busy",
            UnitPart::Stalled(cause) => cause.name(),
            UnitPart::Idle => "idle",
        }
    }

    /// Its cycles, summed over the units of a kind; `None` for a cause that they do not have.
    pub fn key(self, unit: StageId) -> Option<Key> {
        match self {
            UnitPart::Busy => Some(Key::Busy(unit)),
            UnitPart::Stalled(cause) if stage(unit).stalls().any(|own| own == cause) => {
                Some(Key::Stalled(unit, cause))
            }
            UnitPart::Stalled(_) => None,
            UnitPart::Idle => Some(Key::Idle(unit)),
        }
    }
}

impl Record {
    /// The record of `frames` on a display at `display_fps` frames per second; `None` without
    /// frames.
    pub fn of(frames: &[FrameReport], display_fps: f64) -> Option<Record> {
        let aggregate = |s: &Statistic| {
            let value = |f| (s.of(f, display_fps), s.weight.of(f, display_fps));
            Aggregate::weighted(frames.iter().map(value))
        };
        let mut aggregates: Vec<_> = catalogue().iter().map(aggregate).collect();
        // What machines of this dataflow cannot have is not there, and not zero.
        let shown = shown(|i| aggregates[i].is_some());
        for (i, aggregate) in aggregates.iter_mut().enumerate() {
            *aggregate = aggregate.take().filter(|_| shown.binary_search(&i).is_ok());
        }
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

    /// Frames that took longer than the display period; `None` in a model without time, and of
    /// steps, which have no deadline.
    pub fn deadline_misses(&self) -> Option<u64> {
        let share = self.mean(Key::DeadlineMissed)?;
        Some((share * self.frames as f64).round() as u64)
    }

    /// Frames per second that the display gets: its rate, or what is reached of it.
    pub fn displayed_fps(&self) -> f64 {
        self.mean(Key::DisplayedFps).unwrap_or(self.display_fps)
    }

    /// Frames per second that are seen where pictures change between display periods alone; `None`
    /// of what no display shows.
    pub fn synchronised_fps(&self) -> Option<f64> {
        Some(self.display_fps / self.mean(Key::DisplayPeriods)?)
    }

    /// Whether the run falls short of the display rate.
    pub fn misses(&self) -> bool {
        let has_deadline = self.mean(Key::DeadlineMissed).is_some();
        has_deadline && self.displayed_fps() < self.display_fps * (1.0 - 1e-9)
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

    /// The kinds of units that the machine has.
    pub fn units(&self) -> impl Iterator<Item = StageId> + '_ {
        let units = hardware().units().map(|(id, _)| id);
        units.filter(|id| self.mean(Key::Instances(*id)).is_some())
    }

    /// Whether some unit of the machine may wait for a cause: the unit that brings it is there too.
    pub fn has_cause(&self, cause: Stall) -> bool {
        let is_brought = match cause.words().from {
            From::Stage(key) => self.units().any(|unit| stage(unit).key == key),
            From::Memory | From::Neighbour => true,
        };
        is_brought && self.units().any(|unit| stage(unit).stalls().any(|own| own == cause))
    }

    /// Shares of all cycles of the units of a kind, in the order of [`UnitPart::all`]; all zero if
    /// there are none.
    pub fn unit_shares(&self, unit: StageId) -> Vec<f64> {
        let cycles = |part: UnitPart| part.key(unit).map_or(0.0, |key| self.value(key));
        let cycles: Vec<f64> = UnitPart::all().map(cycles).collect();
        let total: f64 = cycles.iter().sum();
        cycles.into_iter().map(|c| if total == 0.0 { 0.0 } else { c / total }).collect()
    }
}
