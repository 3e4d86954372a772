//! Prices of one machine: picojoules per action, watts for time. Made from an energy table.

use super::{Component, EnergyBreakdown};
use crate::action::{Action, ActionCounts, Stage};
use crate::quantity::Picojoules;

/// What everything costs on one machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prices {
    /// Picojoules per action, by [`Action::index`]; per byte for SRAM and DRAM.
    pub per_action: [f64; Action::COUNT],
    /// Leakage of the chip, watts, paid all the time.
    pub leakage_w: f64,
    /// Background and refresh of the DRAM, watts, paid all the time.
    pub background_w: f64,
}

/// Where an action's energy is spent.
pub const fn component_of(action: Action) -> Component {
    match action {
        Action::DramRead | Action::DramWrite => Component::Dram,
        Action::SramRead(_) | Action::SramWrite(_) => Component::Sram,
        Action::Cull
        | Action::Project
        | Action::ObbPrepare
        | Action::ObbTest
        | Action::ShColour
        | Action::PivotKey
        | Action::CompareExchange
        | Action::Alpha
        | Action::Blend
        | Action::PixelFinish => Component::Flop,
    }
}

impl Prices {
    /// The price of one action.
    pub fn of(&self, action: Action) -> Picojoules {
        Picojoules(self.per_action[action.index()])
    }

    /// Energy of `actions` that took `seconds`.
    pub fn breakdown(&self, actions: &ActionCounts, seconds: f64) -> EnergyBreakdown {
        let mut energy = EnergyBreakdown::default();
        for stage in Stage::WORK {
            for action in Action::all() {
                let count = actions.count(stage, action) as f64;
                energy.add(stage, component_of(action), self.of(action) * count);
            }
        }
        let standby =
            [(Component::Leakage, self.leakage_w), (Component::Background, self.background_w)];
        for (component, watts) in standby {
            energy.add(Stage::Standby, component, Picojoules(watts * seconds * 1e12));
        }
        energy
    }
}
