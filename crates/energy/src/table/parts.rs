//! The `[parts]` table: published areas, leakages and energies of units, divided over what a unit
//! consists of.
//!
//! `share` of a unit's area and leakage belongs to the part at the amount `at`; with another amount
//! it is in proportion. What no part takes is fixed. So a unit with the amounts `at` is exactly the
//! published one.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{EnergyTable, Parts, PriceError};
use crate::action::{Inventory, StageId};
use crate::hardware::Catalogue;

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

/// Factors on the prices of what has parts; 1 for a machine with the amounts `at`.
#[derive(Debug, Clone)]
pub(super) struct Grown {
    /// On area and leakage, by stage: of one unit, or of buffers that grow.
    pub(super) size: Vec<f64>,
    /// On the energy of an action, or of the words of such buffers.
    pub(super) energy: Vec<f64>,
}

/// Shares of the same unit together.
const WHOLE: f64 = 1.0 + 1e-9;

impl<C: Catalogue> Parts<C> {
    /// The sums of shares that are above 1: key of the unit, sum.
    pub(super) fn too_much(&self) -> Vec<(String, f64)> {
        let most = |(stage, shares): (&String, &BTreeMap<String, PartShare>)| {
            let of = |share: fn(&PartShare) -> f64| shares.values().map(share).sum::<f64>();
            (format!("parts.{stage}"), of(|p| p.share).max(of(|p| p.energy.unwrap_or(0.0))))
        };
        self.shares.iter().map(most).filter(|(_, sum)| *sum > WHOLE).collect()
    }

    /// The share of a part; `None` where the table has none.
    pub(super) fn of(&self, stage: &str, part: &str) -> Option<&PartShare> {
        self.shares.get(stage)?.get(part)
    }
}

impl<C: Catalogue> EnergyTable<C> {
    /// How much larger the units of a machine are than those that the prices are for; all 1 in a
    /// table without `[parts]`.
    ///
    /// # Errors
    /// A part that the machine has and the table does not know.
    pub(super) fn grown(&self, built: &Inventory) -> Result<Grown, PriceError> {
        let hardware = C::hardware();
        let ones = || vec![1.0; hardware.stages().count()];
        let mut grown = Grown { size: ones(), energy: ones() };
        let Some(parts) = &self.parts else { return Ok(grown) };
        for (id, stage, part) in hardware.parts() {
            let is_there = match hardware.stage(stage).is_units {
                true => built.units[stage.index()] > 0,
                false => built.has_buffer_of(hardware, stage),
            };
            let facts = hardware.stage(stage);
            if facts.counted_in.is_some() || !is_there {
                continue;
            }
            let share = parts.of(facts.key, part.key).ok_or_else(|| PriceError::NoPrice {
                table: self.name.clone(),
                key: format!("parts.{}.{}", facts.key, part.key),
                stage: facts.words,
            })?;
            let more = built.parts[id.index()] / share.at - 1.0;
            grown.size[stage.index()] += share.share * more;
            grown.energy[stage.index()] += share.energy.unwrap_or(0.0) * more;
        }
        Ok(grown)
    }

    /// How many units of another stage have as much area and leakage as all units of this one,
    /// which is counted in a part of those: an amount of its first part takes `parts.STAGE.factor`
    /// times that of the other part. `None` for a stage with prices of its own; 0 in a table
    /// without `[parts]`.
    pub(super) fn counted_as(&self, stage: StageId, built: &Inventory) -> Option<(StageId, f64)> {
        let hardware = C::hardware();
        let facts = hardware.stage(stage);
        let (other, part) = facts.counted_in?;
        let id = hardware.stage_called(other)?;
        let own = hardware.parts().find(|(_, of, _)| *of == stage).map_or(0.0, |(id, ..)| {
            built.parts[id.index()] * f64::from(built.units[stage.index()])
        });
        let as_many = self.parts.as_ref().and_then(|parts| {
            let (one, factor) = (parts.of(other, part)?, parts.factors.get(facts.key)?);
            Some(factor.factor * one.share / one.at * own)
        });
        Some((id, as_many.unwrap_or(0.0)))
    }

    /// Whether the table says what a stage that is counted in another one takes.
    pub(super) fn has_factor(&self, stage: StageId) -> Result<(), PriceError> {
        let facts = C::hardware().stage(stage);
        match (&self.parts, facts.counted_in) {
            (Some(parts), Some(_)) if !parts.factors.contains_key(facts.key) => {
                Err(PriceError::NoPrice {
                    table: self.name.clone(),
                    key: format!("parts.{}", facts.key),
                    stage: facts.words,
                })
            }
            _ => Ok(()),
        }
    }
}
