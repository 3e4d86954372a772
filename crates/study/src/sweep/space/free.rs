//! Axes that cost nothing: no value of them changes a price, an area, leakage or the standby power
//! of the memory in any energy table of the sweep.

use rand::RngExt;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use serde::{Deserialize, Serialize};

use super::{FileKind, Key, Space};
use powergs_energy::same_costs;

/// Surroundings in which an axis is tried.
const TRIES: usize = 6;
/// Values of an axis that are tried in each.
const VALUES_MAX: u32 = 32;

/// An axis that costs nothing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FreeAxis {
    /// Its name.
    pub axis: String,
    /// Whether it is a choice of how to work, as the order of tiles: that costs nothing in itself.
    /// Otherwise more of it would cost something in a chip, and the energy table has no price.
    pub is_policy: bool,
}

impl Space {
    /// The axes that cost nothing, in order. An axis of which no two values could be compared is
    /// not among them.
    pub fn free_axes(&self) -> Vec<FreeAxis> {
        let mut random = Pcg64::seed_from_u64(3);
        let points = self.lattice.points();
        let mut around: Vec<u64> = vec![0, points - 1];
        around.extend((2..TRIES).map(|_| random.random_range(0..points)));
        let is_free = |number: &usize| self.costs_nothing(*number, &around);
        let free = (0..self.axes.len()).filter(is_free).map(|number| {
            let axis = &self.axes[number];
            let is_policy = axis.keys().into_iter().all(is_policy);
            FreeAxis { axis: axis.name.clone(), is_policy }
        });
        free.collect()
    }

    fn costs_nothing(&self, number: usize, around: &[u64]) -> bool {
        let len = self.lattice.sides()[number].len;
        let tried = len.min(VALUES_MAX);
        let mut compared = false;
        for &index in around.iter().filter(|_| len > 1) {
            let mut digits = self.lattice.digits(index);
            let mut first: Option<Vec<_>> = None;
            for i in 0..tried {
                digits[number] = (u64::from(i) * u64::from(len - 1) / u64::from(tried - 1)) as u32;
                let Ok(design) = self.built(self.lattice.index(&digits), false) else { continue };
                let prices: Vec<_> =
                    design.prices.iter().filter_map(|p| p.prices.clone().ok()).collect();
                match &first {
                    None => first = Some(prices),
                    Some(first) => {
                        compared = true;
                        if !first.iter().zip(&prices).all(|(a, b)| same_costs(a, b)) {
                            return false;
                        }
                    }
                }
            }
        }
        compared
    }
}

/// Whether a key says how a machine works, not how much of something it has: names out of a list,
/// truths, and the numbers of the geometry and the schedule.
fn is_policy(key: &Key) -> bool {
    let table = key.path.split('.').next().unwrap_or_default();
    let is_rule = key.file == FileKind::Machine && ["geometry", "schedule"].contains(&table);
    is_rule || key.file == FileKind::Display || !key.domain().is_ordered()
}
