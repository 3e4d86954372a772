//! The `[parts]` table: published areas, leakages and energies of units, divided over what a unit
//! consists of.
//!
//! `share` of a unit's area and leakage belongs to the part at the amount `at`; with another amount
//! it is in proportion. What no part takes is fixed. So a unit with the amounts `at` is exactly the
//! published one.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{EnergyTable, Overhead};
use crate::action::{Action, Inventory, Part, UnitKind};

/// The share of one part.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PartShare {
    /// Share of the area and the leakage of the unit.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "fraction"))]
    pub share: f64,
    /// Share of the energy of an action of the unit that grows with the part; absent: none.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "fraction"))]
    pub energy: Option<f64>,
    /// Amount of the part in the unit that prices are for.
    #[schemars(range(min = 0.001, max = 1000000.0), extend("x-unit" = "amount of the part"))]
    pub at: f64,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// The `[parts]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Parts {
    /// Area and leakage of an operation a cycle of a colour unit, over those of one of a CCU.
    pub colour: Overhead,
    /// Of a culling and conversion unit.
    pub ccu: CcuParts,
    /// Of a quick sorting unit.
    pub qsu: QsuParts,
    /// Of a bitonic sorting unit.
    pub bsu: BsuParts,
    /// Of a rendering unit.
    pub vru: VruParts,
    /// Of the feature cache.
    pub cache: CacheParts,
}

/// The `[parts.ccu]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CcuParts {
    /// Arithmetic of conversion; amount: operations a cycle.
    pub operations: PartShare,
    /// Box tests a cycle.
    pub intersection_units: PartShare,
    /// Look-ups of tile levels a cycle.
    pub level_tests: PartShare,
    /// Bits of the batches that are asked for: 64 and one for each record, `ccu.queue` times.
    pub batches: PartShare,
}

/// The `[parts.qsu]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct QsuParts {
    /// Pivots: a key is compared with all of them.
    pub pivots: PartShare,
    /// Comparators: pivots x keys a cycle.
    pub comparators: PartShare,
}

/// The `[parts.bsu]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BsuParts {
    /// Compare-exchanges of the network: w/4 log2 w (log2 w + 1).
    pub network: PartShare,
    /// Bits of what a core has asked for: 128 for each of `gsu.queue` lists, 64 for each of
    /// `vru.speculation` chunks, over the BSUs of the core.
    pub queue: PartShare,
}

/// The `[parts.vru]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct VruParts {
    /// Blends a cycle: accumulators / (1 + `vru.blend-stall`).
    pub blend: PartShare,
    /// Bits of the pixels that are held: `vru.pixel-state` each, for every accumulator, twice where
    /// tiles overlap, and twice where pixels are swapped.
    pub pixels: PartShare,
    /// Inverse of `vru.recurrence`: a shorter loop through the transmittance.
    pub recurrence: PartShare,
    /// Bits of feature records: 152 of the one of a unit, and its share of the core's queues.
    pub queue: PartShare,
}

/// The `[parts.cache]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CacheParts {
    /// Ways: tags that are read and compared at a time.
    pub ways: PartShare,
}

/// Factors on the prices of what has parts; 1 for a machine with the amounts `at`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grown {
    /// On area and leakage of one unit.
    pub(super) units: [f64; UnitKind::ALL.len()],
    /// On the energy of an action of it.
    pub(super) energy: [f64; UnitKind::ALL.len()],
    /// On area and leakage of the feature cache.
    pub(super) cache: f64,
    /// On the energy of its words.
    pub(super) cache_energy: f64,
}

impl Parts {
    /// The share of a part.
    pub fn of(&self, part: Part) -> &PartShare {
        match part {
            Part::CcuOperations => &self.ccu.operations,
            Part::CcuIntersectionUnits => &self.ccu.intersection_units,
            Part::CcuLevelTests => &self.ccu.level_tests,
            Part::CcuBatches => &self.ccu.batches,
            Part::QsuPivots => &self.qsu.pivots,
            Part::QsuComparators => &self.qsu.comparators,
            Part::BsuNetwork => &self.bsu.network,
            Part::BsuQueue => &self.bsu.queue,
            Part::VruBlend => &self.vru.blend,
            Part::VruPixels => &self.vru.pixels,
            Part::VruRecurrence => &self.vru.recurrence,
            Part::VruQueue => &self.vru.queue,
            Part::CacheWays => &self.cache.ways,
        }
    }

    /// The key of a part in an energy table.
    pub(super) const fn key(part: Part) -> &'static str {
        match part {
            Part::CcuOperations => "parts.ccu.operations",
            Part::CcuIntersectionUnits => "parts.ccu.intersection-units",
            Part::CcuLevelTests => "parts.ccu.level-tests",
            Part::CcuBatches => "parts.ccu.batches",
            Part::QsuPivots => "parts.qsu.pivots",
            Part::QsuComparators => "parts.qsu.comparators",
            Part::BsuNetwork => "parts.bsu.network",
            Part::BsuQueue => "parts.bsu.queue",
            Part::VruBlend => "parts.vru.blend",
            Part::VruPixels => "parts.vru.pixels",
            Part::VruRecurrence => "parts.vru.recurrence",
            Part::VruQueue => "parts.vru.queue",
            Part::CacheWays => "parts.cache.ways",
        }
    }

    /// The sums of shares that are above 1: key of the unit, sum.
    pub(super) fn too_much(&self) -> Vec<(&'static str, f64)> {
        let owner = |part: Part| {
            part.unit().map_or("parts.cache", |unit| match unit {
                UnitKind::Ccu => "parts.ccu",
                UnitKind::Qsu => "parts.qsu",
                UnitKind::Bsu => "parts.bsu",
                UnitKind::Vru => "parts.vru",
            })
        };
        let owners = ["parts.ccu", "parts.qsu", "parts.bsu", "parts.vru", "parts.cache"];
        let sum = |of: fn(&PartShare) -> f64, key: &str| -> f64 {
            Part::ALL.into_iter().filter(|&p| owner(p) == key).map(|p| of(self.of(p))).sum()
        };
        let most = |key: &'static str| {
            let energy = |p: &PartShare| p.energy.unwrap_or(0.0);
            (key, sum(|p| p.share, key).max(sum(energy, key)))
        };
        owners.into_iter().map(most).filter(|(_, sum)| *sum > 1.0 + 1e-9).collect()
    }
}

impl EnergyTable {
    /// How much larger the units of a machine are than those that the prices are for; all 1 in a
    /// table without `[parts]`.
    pub(super) fn grown(&self, built: &Inventory) -> Grown {
        let mut grown = Grown { units: [1.0; 4], energy: [1.0; 4], cache: 1.0, cache_energy: 1.0 };
        let Some(parts) = &self.parts else { return grown };
        for (part, amount) in Part::ALL.into_iter().zip(built.parts) {
            let share = parts.of(part);
            let more = amount / share.at - 1.0;
            let (size, energy) = match part.unit() {
                Some(unit) => (&mut grown.units[unit as usize], &mut grown.energy[unit as usize]),
                None => (&mut grown.cache, &mut grown.cache_energy),
            };
            *size += share.share * more;
            *energy += share.energy.unwrap_or(0.0) * more;
        }
        grown
    }

    /// CCUs that have as much area and leakage as the colour units of a machine: an operation a
    /// cycle of theirs takes `parts.colour` times that of a CCU. 0 in a table without `[parts]`.
    pub(super) fn colours_as_ccus(&self, built: &Inventory) -> f64 {
        self.parts.as_ref().map_or(0.0, |parts| {
            let one = &parts.ccu.operations;
            parts.colour.factor * one.share / one.at * built.colour_operations
        })
    }
}

/// The unit that does an action of arithmetic.
pub(super) const fn unit_of(action: Action) -> Option<UnitKind> {
    match action {
        Action::Cull
        | Action::Project
        | Action::ObbPrepare
        | Action::ObbTest
        | Action::ShColour => Some(UnitKind::Ccu),
        Action::PivotKey => Some(UnitKind::Qsu),
        Action::CompareExchange | Action::SortedRow | Action::MergedRow => Some(UnitKind::Bsu),
        Action::Alpha
        | Action::StoppedPixel
        | Action::Blend
        | Action::PixelFinish
        | Action::QueueEntry => Some(UnitKind::Vru),
        Action::Clock(unit) | Action::IdleClock(unit) => Some(unit),
        Action::SramRead(_) | Action::SramWrite(_) | Action::DramRead | Action::DramWrite => None,
    }
}
