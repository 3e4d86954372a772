//! Silicon area of one machine, by block.

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
    /// Everything else: interconnect, control, interfaces.
    pub rest: SquareMillimetres,
}

impl Area {
    /// Names of the units, in the order of [`Area::units`].
    pub const UNITS: [&'static str; 4] =
        [UnitKind::Ccu.name(), UnitKind::Qsu.name(), UnitKind::Bsu.name(), UnitKind::Vru.name()];

    /// Number of [`Area::blocks`].
    pub const BLOCKS: usize = 4 + Buffer::ALL.len() + 1;

    /// Every block with its name: units, buffers, `rest`.
    pub fn blocks(&self) -> [(&'static str, SquareMillimetres); Area::BLOCKS] {
        std::array::from_fn(|i| match i {
            0..4 => (Area::UNITS[i], self.units[i]),
            i if i < Area::BLOCKS - 1 => (Buffer::ALL[i - 4].name(), self.buffers[i - 4]),
            _ => ("rest", self.rest),
        })
    }

    /// Area of the whole chip.
    pub fn total(&self) -> SquareMillimetres {
        self.blocks().into_iter().map(|(_, area)| area).sum()
    }
}
