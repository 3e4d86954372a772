//! The two pictures of a run that tables and charts share: where the energy goes, and where the
//! cycles go. Means over frames, taken from the record.

use super::Means;
use powergs_core::accel::Stall;
use powergs_core::action::Stage;
use powergs_core::energy::{Component, Standby};

/// A value for every stage and component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breakdown {
    /// By stage (order of [`Stage::ALL`]) and component (order of [`Component::ALL`]).
    pub parts: [[f64; Component::ALL.len()]; Stage::ALL.len()],
}

impl Breakdown {
    /// Mean energy of a frame, joules. Standby parts are for the frame's own time.
    pub fn energy_j(means: &Means) -> Option<Breakdown> {
        Self::new(means, 1e-12, "energy_pj", 1e-12)
    }

    /// Mean power at `fps` frames a second, watts. Standby parts are paid all the time.
    pub fn power_w(means: &Means, fps: f64) -> Option<Breakdown> {
        Self::new(means, 1e-12 * fps, "power_w", 1.0)
    }

    fn new(means: &Means, work: f64, standby: &str, standby_scale: f64) -> Option<Breakdown> {
        let mut parts = [[0.0; Component::ALL.len()]; Stage::ALL.len()];
        for stage in Stage::WORK {
            for component in [Component::Dram, Component::Sram, Component::Flop] {
                let name = format!("energy_by_stage_pj.{}.{}", stage.name(), component.name());
                parts[stage as usize][component as usize] = means.get(&name)? * work;
            }
        }
        let row = &mut parts[Stage::Standby as usize];
        for component in Standby::COMPONENTS {
            let name = format!("{standby}.{}", component.name());
            row[component as usize] = means.get(&name)? * standby_scale;
        }
        Some(Breakdown { parts })
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

/// Where the cycles of one kind of unit went.
#[derive(Debug, Clone, PartialEq)]
pub struct CycleRow {
    /// Name of the unit.
    pub unit: &'static str,
    /// How many there are.
    pub instances: u32,
    /// Mean cycles of a frame summed over instances, in the order of [`CycleRow::PARTS`].
    pub cycles: [f64; CycleRow::PARTS.len()],
}

impl CycleRow {
    /// What the parts are called: busy, stalls by cause, idle.
    pub const PARTS: [&'static str; Stall::ALL.len() + 2] = {
        let mut parts = ["busy"; Stall::ALL.len() + 2];
        let mut i = 0;
        while i < Stall::ALL.len() {
            parts[i + 1] = Stall::ALL[i].name();
            i += 1;
        }
        parts[Stall::ALL.len() + 1] = "idle";
        parts
    };

    /// The rows of a run, in pipeline order; empty in a model without time.
    pub fn all(means: &Means) -> Vec<CycleRow> {
        let row = |unit: &'static str| {
            let mean = |end: &str| means.get(&format!("units.{unit}.{end}"));
            let mut cycles = [0.0; CycleRow::PARTS.len()];
            cycles[0] = mean("busy_cycles")?;
            for (cell, cause) in cycles[1..].iter_mut().zip(Stall::ALL) {
                *cell = mean(&format!("stall_{}_cycles", cause.name()))?;
            }
            cycles[Self::PARTS.len() - 1] = mean("idle_cycles")?;
            Some(CycleRow { unit, instances: mean("instances")? as u32, cycles })
        };
        ["ccu", "qsu", "bsu", "vru"].into_iter().filter_map(row).collect()
    }

    /// All cycles.
    pub fn total(&self) -> f64 {
        self.cycles.iter().sum()
    }

    /// The parts as shares of all cycles; all zero if there are none.
    pub fn shares(&self) -> [f64; CycleRow::PARTS.len()] {
        let total = self.total();
        self.cycles.map(|c| if total == 0.0 { 0.0 } else { c / total })
    }
}
