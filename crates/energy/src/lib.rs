//! What hardware does, and what that costs: actions with their FLOPs, prices, area, and the
//! breakdown of one frame. Never sees a tile.

pub mod accelergy;
pub mod action;
mod area;
pub mod cacti;
mod costs;
pub mod flops;
pub mod hardware;
mod node;
pub mod prices;
pub mod supply;
pub mod table;

use crate::action::Phase;
use powergs_base::quantity::Picojoules;

pub use area::{Area, Block};
pub use costs::same_costs;
pub use prices::{Activity, DramCosts, IdleShares, Prices, Standby};
pub use supply::Supply;
pub use table::{Built, EnergyTable};

/// Where energy is spent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Component {
    /// DRAM accesses.
    Dram,
    /// Buffer accesses.
    Sram,
    /// Arithmetic and control of the units.
    Flop,
    /// Leakage of the chip.
    Leakage,
    /// Background power of the DRAM.
    Background,
    /// Refresh of the DRAM.
    Refresh,
}

impl Component {
    /// All components, in report order.
    pub const ALL: [Component; 6] = [
        Component::Dram,
        Component::Sram,
        Component::Flop,
        Component::Leakage,
        Component::Background,
        Component::Refresh,
    ];

    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Component::Dram => "dram",
            Component::Sram => "sram",
            Component::Flop => "flop",
            Component::Leakage => "leakage",
            Component::Background => "background",
            Component::Refresh => "refresh",
        }
    }
}

/// Energy of one frame by stage and component. `Leakage`, `Background` and
/// `Refresh` belong to [`Phase::Standby`], the others to the stages that work.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EnergyBreakdown {
    parts: [[f64; Component::ALL.len()]; Phase::ALL.len()],
}

impl EnergyBreakdown {
    /// Adds energy to one part.
    pub fn add(&mut self, stage: Phase, component: Component, energy: Picojoules) {
        self.parts[stage as usize][component as usize] += energy.0;
    }

    /// Adds all parts of another.
    pub fn add_all(&mut self, other: &EnergyBreakdown) {
        for (mine, theirs) in self.parts.iter_mut().zip(&other.parts) {
            mine.iter_mut().zip(theirs).for_each(|(a, b)| *a += b);
        }
    }

    /// Energy of one component in one stage.
    pub fn part(&self, stage: Phase, component: Component) -> Picojoules {
        Picojoules(self.parts[stage as usize][component as usize])
    }

    /// Energy of a stage, all components.
    pub fn stage(&self, stage: Phase) -> Picojoules {
        Picojoules(self.parts[stage as usize].iter().sum())
    }

    /// Energy of a component, all stages.
    pub fn component(&self, component: Component) -> Picojoules {
        Picojoules(self.parts.iter().map(|row| row[component as usize]).sum())
    }

    /// Energy of all stages and components.
    pub fn total(&self) -> Picojoules {
        Phase::ALL.iter().map(|&s| self.stage(s)).sum()
    }

    /// Dynamic energy: all stages except standby.
    pub fn dynamic(&self) -> Picojoules {
        Phase::WORK.iter().map(|&s| self.stage(s)).sum()
    }
}
