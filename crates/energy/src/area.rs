//! Silicon area of one machine, by block: of the die, and of its core.

use crate::action::{Buffer, UnitKind};
use powergs_base::quantity::SquareMillimetres;

/// Area of a chip by block.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Area {
    /// CCUs, QSUs, BSUs and rendering units, all of a kind together; colour units are a part of
    /// the rendering units.
    pub units: [SquareMillimetres; 4],
    /// In the order of [`Buffer::ALL`], all shares and banks together.
    pub buffers: [SquareMillimetres; Buffer::ALL.len()],
    /// Everything else of the core: interconnect, control.
    pub rest: SquareMillimetres,
    /// The chip's side of the memory channels: drivers, receivers, delay lines.
    pub phy: SquareMillimetres,
    /// Memory controllers.
    pub controllers: SquareMillimetres,
}

impl Area {
    /// Names of the units, in the order of [`Area::units`].
    pub const UNITS: [&'static str; 4] =
        [UnitKind::Ccu.name(), UnitKind::Qsu.name(), UnitKind::Bsu.name(), UnitKind::Vru.name()];

    /// Number of [`Area::blocks`].
    pub const BLOCKS: usize = Area::CORE + 2;
    /// Those of them that papers on these accelerators count.
    const CORE: usize = 4 + Buffer::ALL.len() + 1;

    /// Every block with its name: units, buffers, `rest`, then what serves the memory.
    pub fn blocks(&self) -> [(&'static str, SquareMillimetres); Area::BLOCKS] {
        std::array::from_fn(|i| match i {
            0..4 => (Area::UNITS[i], self.units[i]),
            i if i < Area::CORE - 1 => (Buffer::ALL[i - 4].name(), self.buffers[i - 4]),
            i if i < Area::CORE => ("rest", self.rest),
            i if i == Area::CORE => ("phy", self.phy),
            _ => ("controllers", self.controllers),
        })
    }

    /// Area of the die.
    pub fn total(&self) -> SquareMillimetres {
        self.blocks().into_iter().map(|(_, area)| area).sum()
    }

    /// Without the PHY and the controllers of the memory: what papers on these accelerators print.
    pub fn core(&self) -> SquareMillimetres {
        self.blocks().into_iter().take(Area::CORE).map(|(_, area)| area).sum()
    }
}
