//! Silicon area of one machine, by block: of the die, and of its core.

use crate::hardware::Hardware;
use powergs_base::quantity::SquareMillimetres;

/// Area of a chip by block.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Area {
    /// All units of a kind together, in the order of [`Hardware::units`].
    pub units: Vec<SquareMillimetres>,
    /// By [`BufferId`](crate::action::BufferId), all shares and banks together.
    pub buffers: Vec<SquareMillimetres>,
    /// Everything else of the core: interconnect, control.
    pub rest: SquareMillimetres,
    /// The chip's side of the memory channels: drivers, receivers, delay lines.
    pub phy: SquareMillimetres,
    /// Memory controllers.
    pub controllers: SquareMillimetres,
}

/// A block of a chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    /// The name in every output.
    pub name: &'static str,
    /// Whether papers on these accelerators count it: they leave out what serves the memory.
    pub is_core: bool,
}

impl Area {
    /// The blocks that chips are made of: units, buffers, `rest`, then what serves the memory.
    pub fn blocks(hardware: &Hardware) -> Vec<Block> {
        let units = hardware.units().map(|(_, unit)| unit.key);
        let buffers = hardware.buffers().map(|(_, buffer)| buffer.name);
        let core = units.chain(buffers).chain(["rest"]);
        let core = core.map(|name| Block { name, is_core: true });
        let memory = ["phy", "controllers"].map(|name| Block { name, is_core: false });
        core.chain(memory).collect()
    }

    fn core_areas(&self) -> impl Iterator<Item = SquareMillimetres> {
        self.units.iter().chain(&self.buffers).copied().chain([self.rest])
    }

    /// Areas in the order of [`Area::blocks`].
    pub fn areas(&self) -> Vec<SquareMillimetres> {
        self.core_areas().chain([self.phy, self.controllers]).collect()
    }

    /// Area of the die.
    pub fn total(&self) -> SquareMillimetres {
        self.core_areas().chain([self.phy, self.controllers]).sum()
    }

    /// Without the PHY and the controllers of the memory: what papers on these accelerators print.
    pub fn core(&self) -> SquareMillimetres {
        self.core_areas().sum()
    }
}
