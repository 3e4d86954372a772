//! Prices of one machine: what every action costs on it, and what standing there costs.

use crate::action::Action;

/// An energy table applied to the buffers and units of one machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prices {
    /// Picojoules per action, by [`Action::index`].
    pub per_action: [f64; Action::COUNT],
    /// Leakage of the chip, watts.
    pub leakage_w: f64,
    /// Background and refresh of the DRAM, watts.
    pub background_w: f64,
}
