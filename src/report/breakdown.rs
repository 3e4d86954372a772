//! The two pictures of a run that tables and charts share: where the energy goes, and where the
//! cycles go. Means over frames, taken from the record.

use super::{Run, Table};
use crate::accel::Stall;
use crate::action::Stage;
use crate::energy::Component;

/// A value for every stage and component.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breakdown {
    /// By stage (order of [`Stage::ALL`]) and component (order of [`Component::ALL`]).
    pub parts: [[f64; Component::ALL.len()]; Stage::ALL.len()],
}

impl Breakdown {
    /// Mean energy of a frame, joules. Standby parts are for the frame's own time.
    pub fn energy_j(table: &Table) -> Option<Breakdown> {
        Self::new(table, 1e-12, ["energy_pj.leakage", "energy_pj.background"], 1e-12)
    }

    /// Mean power at `fps` frames a second, watts. Standby parts are paid all the time.
    pub fn power_w(table: &Table, fps: f64) -> Option<Breakdown> {
        Self::new(table, 1e-12 * fps, ["power_w.leakage", "power_w.background"], 1.0)
    }

    fn new(table: &Table, work: f64, standby: [&str; 2], standby_scale: f64) -> Option<Breakdown> {
        let mut parts = [[0.0; Component::ALL.len()]; Stage::ALL.len()];
        for stage in Stage::WORK {
            for component in [Component::Dram, Component::Sram, Component::Flop] {
                let name = format!("energy_by_stage_pj.{}.{}", stage.name(), component.name());
                parts[stage as usize][component as usize] = table.mean(&name)? * work;
            }
        }
        let row = &mut parts[Stage::Standby as usize];
        row[Component::Leakage as usize] = table.mean(standby[0])? * standby_scale;
        row[Component::Background as usize] = table.mean(standby[1])? * standby_scale;
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
    pub cycles: [f64; 6],
}

impl CycleRow {
    /// What the parts are called: all waits for DRAM are one.
    pub const PARTS: [&'static str; 6] =
        ["busy", "stall dram", "stall bank", "stall input", "stall output", "idle"];

    /// The rows of `run`, in pipeline order; empty in a model without time.
    pub fn all(run: &Run, table: &Table) -> Vec<CycleRow> {
        let first = run.frames.first().and_then(|f| f.timing.as_ref());
        let units = first.map(|t| t.units.as_slice()).unwrap_or_default();
        let row = |unit: &'static str, instances| {
            let mean = |end: &str| table.mean(&format!("units.{unit}.{end}"));
            let stall = |s: Stall| mean(&format!("stall_{}_cycles", s.name()));
            let waits = Stall::ALL.into_iter().filter(|s| s.is_dram()).map(stall);
            let cycles = [
                mean("busy_cycles")?,
                waits.sum::<Option<f64>>()?,
                stall(Stall::Bank)?,
                stall(Stall::Input)?,
                stall(Stall::Output)?,
                mean("idle_cycles")?,
            ];
            Some(CycleRow { unit, instances, cycles })
        };
        units.iter().filter_map(|u| row(u.unit, u.instances)).collect()
    }

    /// All cycles.
    pub fn total(&self) -> f64 {
        self.cycles.iter().sum()
    }

    /// The parts as shares of all cycles; all zero if there are none.
    pub fn shares(&self) -> [f64; 6] {
        let total = self.total();
        self.cycles.map(|c| if total == 0.0 { 0.0 } else { c / total })
    }
}
