//! Factors from the node of the prices to the node of the chip.

use super::{EnergyTable, Factor, Scaling};
use crate::hardware::Catalogue;
use crate::node::{self, Scaled};
use crate::supply::Supply;
use powergs_base::quantity::Nanometres;

/// Factors on the prices of a file; all 1 where it has no `[scaling]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Factors {
    pub(super) energy: f64,
    pub(super) leakage: f64,
    pub(super) area: f64,
    pub(super) sram_energy: f64,
    pub(super) sram_leakage: f64,
    pub(super) sram_area: f64,
}

impl Factors {
    /// The same at another voltage.
    pub(super) fn at(self, supply: Option<&Supply>) -> Factors {
        let Some(supply) = supply else { return self };
        Factors {
            energy: self.energy * supply.energy,
            leakage: self.leakage * supply.leakage,
            sram_energy: self.sram_energy * supply.energy,
            sram_leakage: self.sram_leakage * supply.leakage,
            ..self
        }
    }
}

impl Scaling {
    /// The factors with their keys, and what a fit gives for each.
    pub(super) fn all(&self) -> [(&'static str, &Factor, Scaled); 6] {
        [
            ("energy", &self.energy, Scaled::Energy),
            ("leakage", &self.leakage, Scaled::Energy),
            ("area", &self.area, Scaled::Area),
            ("sram-energy", &self.sram_energy, Scaled::Energy),
            ("sram-leakage", &self.sram_leakage, Scaled::Energy),
            ("sram-area", &self.sram_area, Scaled::Area),
        ]
    }
}

impl Factor {
    /// Its value between two nodes.
    pub(super) fn value(
        &self,
        what: Scaled,
        from: Nanometres,
        to: Nanometres,
    ) -> Result<f64, String> {
        match (&self.fit, self.factor) {
            (Some(fit), None) => node::factor(fit, what, from, to),
            (None, Some(factor)) => Ok(factor),
            _ => Err("needs exactly one of `fit` and `factor`".into()),
        }
    }
}

/// A step of technology that prices were scaled by.
#[derive(Debug, Clone, PartialEq)]
pub struct NodeStep {
    /// The node that the prices of the file are for.
    pub from: Nanometres,
    /// The node of the chip.
    pub to: Nanometres,
    /// Factor on the energy of an operation.
    pub energy: f64,
    /// What each fit of `nodes.toml` that knows the step says instead, the least first.
    pub others: Vec<(&'static str, f64)>,
}

impl<C: Catalogue> EnergyTable<C> {
    /// The step of technology from the prices of the file to the chip; `None` without `[scaling]`.
    pub fn node_step(&self) -> Option<NodeStep> {
        let (from, to) = (self.scaling.as_ref()?.from, self.node?);
        let others = node::energies(from, to);
        Some(NodeStep { from, to, energy: self.factors().energy, others })
    }

    pub(super) fn factors(&self) -> Factors {
        let [energy, leakage, area, sram_energy, sram_leakage, sram_area] =
            match self.scaling.as_ref().zip(self.node) {
                None => [1.0; 6],
                Some((scaling, node)) => scaling.all().map(|(_, factor, what)| {
                    factor.value(what, scaling.from, node).expect("checked: there is a factor")
                }),
            };
        Factors { energy, leakage, area, sram_energy, sram_leakage, sram_area }
    }
}
