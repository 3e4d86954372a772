//! Whether two machines cost the same.

use super::Prices;

/// Whether two machines cost the same: area, energy of every action and command, leakage,
/// background and refresh power. Where a key makes no difference here, it is free in the energy
/// table, and only time can decide its value.
pub fn same_costs(a: &Prices, b: &Prices) -> bool {
    a == b
}
