//! Where the energy of a run goes, by stage and component: means over frames.

use powergs_core::sim::statistics::{Key, Record};
use powergs_energy::action::Phase;
use powergs_energy::{Component, Standby};

/// A value for every stage and component.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Breakdown {
    /// By stage (order of [`Phase::ALL`]) and component (order of [`Component::ALL`]).
    pub parts: [[f64; Component::ALL.len()]; Phase::ALL.len()],
}

impl Breakdown {
    /// Mean energy of a frame, joules. Standby parts are for the frame's own time.
    pub fn energy_j(record: &Record) -> Breakdown {
        Self::new(record, 1e-12, |component| record.value(Key::EnergyOf(component)) * 1e-12)
    }

    /// Mean power at the display rate of the run, or at what is reached of it, watts. Standby parts
    /// are paid all the time.
    pub fn power_w(record: &Record) -> Breakdown {
        let work = 1e-12 * record.displayed_fps();
        Self::new(record, work, |component| record.value(Key::PowerOf(component)))
    }

    fn new(record: &Record, work: f64, standby: impl Fn(Component) -> f64) -> Self {
        let mut parts = [[0.0; Component::ALL.len()]; Phase::ALL.len()];
        for stage in Phase::WORK {
            for component in Key::COMPONENTS {
                let pj = record.value(Key::EnergyPart(stage, component));
                parts[stage as usize][component as usize] = pj * work;
            }
        }
        for component in Standby::COMPONENTS {
            parts[Phase::Standby as usize][component as usize] = standby(component);
        }
        Breakdown { parts }
    }

    /// One part.
    pub fn part(&self, stage: Phase, component: Component) -> f64 {
        self.parts[stage as usize][component as usize]
    }

    /// Sum over components.
    pub fn stage(&self, stage: Phase) -> f64 {
        self.parts[stage as usize].iter().sum()
    }

    /// Sum over stages.
    pub fn component(&self, component: Component) -> f64 {
        self.parts.iter().map(|row| row[component as usize]).sum()
    }

    /// Everything.
    pub fn total(&self) -> f64 {
        self.parts.iter().flatten().sum()
    }

    /// Stages to show: standby only where it costs anything (in the `paper` model it does not).
    pub fn shown(&self) -> Vec<Phase> {
        let shown = |s: &Phase| *s != Phase::Standby || self.stage(*s) != 0.0;
        Phase::ALL.into_iter().filter(shown).collect()
    }
}
