//! Where the energy of a run goes, by stage and component: means over frames.

use super::summary::{EnergyMeans, RunSummary};
use powergs_energy::action::Stage;
use powergs_energy::{Component, Standby};

/// A value for every stage and component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breakdown {
    /// By stage (order of [`Stage::ALL`]) and component (order of [`Component::ALL`]).
    pub parts: [[f64; Component::ALL.len()]; Stage::ALL.len()],
}

impl Breakdown {
    /// Mean energy of a frame, joules. Standby parts are for the frame's own time.
    pub fn energy_j(summary: &RunSummary) -> Breakdown {
        let energy = &summary.energy;
        let standby = Standby::COMPONENTS.map(|component| energy.component(component) * 1e-12);
        Self::new(summary, 1e-12, standby)
    }

    /// Mean power at the display rate of the summary, or at what is reached of it, watts. Standby
    /// parts are paid all the time.
    pub fn power_w(summary: &RunSummary) -> Breakdown {
        Self::new(summary, 1e-12 * summary.displayed_fps, summary.standby_w)
    }

    fn new(summary: &RunSummary, work: f64, standby: [f64; Standby::COMPONENTS.len()]) -> Self {
        let mut parts = [[0.0; Component::ALL.len()]; Stage::ALL.len()];
        for (stage, of_stage) in Stage::WORK.into_iter().zip(&summary.energy.work_pj) {
            for (component, pj) in EnergyMeans::WORK.into_iter().zip(of_stage) {
                parts[stage as usize][component as usize] = pj * work;
            }
        }
        for (component, part) in Standby::COMPONENTS.into_iter().zip(standby) {
            parts[Stage::Standby as usize][component as usize] = part;
        }
        Breakdown { parts }
    }

    /// One part.
    pub fn part(&self, stage: Stage, component: Component) -> f64 {
        self.parts[stage as usize][component as usize]
    }

    /// Sum over components.
    pub fn stage(&self, stage: Stage) -> f64 {
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
    pub fn shown(&self) -> Vec<Stage> {
        let shown = |s: &Stage| *s != Stage::Standby || self.stage(*s) != 0.0;
        Stage::ALL.into_iter().filter(shown).collect()
    }
}
