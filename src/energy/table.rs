//! Energy tables: a price with its source for every action, as in `arch-configs/energy/*.toml`.
//!
//! A table becomes [`Prices`] once the machine's buffers and units are known, so that pricing
//! cannot fail later. Interpolation in the SRAM table is linear in the logarithms of size and
//! price.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::action::{Action, Buffer, Inventory};
use crate::config::{self, ConfigError};
use crate::energy::prices::Prices;
use crate::quantity::{Bytes, Nanometres, Picojoules, PicojoulesPerByte, Watts};

mod check;

/// An energy table, checked: every price has a source, and none is zero by accident.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct EnergyTable {
    /// Name in reports.
    pub name: String,
    /// What it is, in one line.
    pub description: String,
    /// Technology node that the prices of the chip are for.
    pub node: Nanometres,
    /// Price of one floating-point operation, for actions that are given in `flops`.
    pub flop: Option<ActionPrice>,
    /// Prices of the arithmetic actions.
    pub actions: ActionPrices,
    /// Prices of buffer accesses, and leakage of the buffers.
    pub sram: SramPrices,
    /// Prices of DRAM accesses, and its background power.
    pub dram: DramPrices,
    /// Leakage of the units, each multiplied by how many the machine has.
    pub leakage: UnitLeakage,
}

/// The price of one action: exactly one of `energy`, `flops` and `free`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ActionPrice {
    /// Energy of one action.
    pub energy: Option<Picojoules>,
    /// Floating-point operations of one action, each at the price of `flop`.
    #[schemars(range(min = 1, max = 1000000), extend("x-unit" = "FLOPs"))]
    pub flops: Option<u32>,
    /// Costs nothing, on purpose.
    #[serde(default, skip_serializing_if = "is_false")]
    pub free: bool,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// The price of moving one byte.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BytePrice {
    /// Energy of one byte.
    pub energy: PicojoulesPerByte,
    /// Costs nothing, on purpose: `energy` is then zero.
    #[serde(default, skip_serializing_if = "is_false")]
    pub free: bool,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// Power that is paid for time.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct PowerPrice {
    /// Power, all the time.
    pub power: Watts,
    /// Costs nothing, on purpose: `power` is then zero.
    #[serde(default, skip_serializing_if = "is_false")]
    pub free: bool,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

fn is_false(flag: &bool) -> bool {
    !flag
}

/// The `[actions]` table: one price for each arithmetic action.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ActionPrices {
    /// One Gaussian taken through cull and the part of projection that the cull needs.
    pub cull: ActionPrice,
    /// One survivor projected to a 2D covariance, with its bounding box.
    pub project: ActionPrice,
    /// Axes of the oriented box of one splat that needs box tests.
    pub obb_prepare: ActionPrice,
    /// One oriented-box-against-tile test.
    pub obb_test: ActionPrice,
    /// One view-dependent colour from spherical harmonics.
    pub sh_colour: ActionPrice,
    /// One key moved through the pivots of a QSU in one pass.
    pub pivot_key: ActionPrice,
    /// One compare-exchange of a BSU.
    pub compare_exchange: ActionPrice,
    /// One α evaluated for one pixel.
    pub alpha: ActionPrice,
    /// One blend of a splat into one pixel.
    pub blend: ActionPrice,
    /// One pixel finished.
    pub pixel_finish: ActionPrice,
}

/// The `[sram]` table: exactly one of `flat` and `table`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SramPrices {
    /// One price for every size; no leakage.
    pub flat: Option<BytePrice>,
    /// Prices by the size of a bank.
    pub table: Option<SramTable>,
}

/// Prices by the size of a bank, interpolated.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SramTable {
    /// Key of `references.toml` or assumption number.
    pub source: String,
    /// Whether banks smaller or larger than the table are priced by its first or last two rows.
    #[serde(default, skip_serializing_if = "is_false")]
    pub allow_extrapolation: bool,
    /// At least two sizes, ascending.
    pub sizes: Vec<SramSize>,
}

/// One row of the SRAM table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SramSize {
    /// Size of the bank.
    pub capacity: Bytes,
    /// Energy of one byte read.
    pub read: PicojoulesPerByte,
    /// Energy of one byte written.
    pub write: PicojoulesPerByte,
    /// Leakage of the bank.
    pub leakage: Watts,
}

/// The `[dram]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DramPrices {
    /// One byte read.
    pub read: BytePrice,
    /// One byte written.
    pub write: BytePrice,
    /// Standby and refresh of the whole memory.
    pub background: PowerPrice,
}

/// The `[leakage]` table, per unit.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct UnitLeakage {
    /// One culling and conversion unit.
    pub ccu: PowerPrice,
    /// One quick sorting unit.
    pub qsu: PowerPrice,
    /// One bitonic sorting unit.
    pub bsu: PowerPrice,
    /// One rendering unit.
    pub vru: PowerPrice,
}

/// A machine that the table has no price for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PriceError {
    /// A bank outside of the SRAM table.
    #[error(
        "the banks of buffer `{buffer}` have {bank}, and the SRAM table of `{table}` goes from \
         {least} to {most}: change the buffer, or set `sram.table.allow-extrapolation = true` \
         in a copy of the energy table"
    )]
    OutsideTable {
        /// Name of the buffer.
        buffer: &'static str,
        /// Size of one bank.
        bank: Bytes,
        /// Name of the energy table.
        table: String,
        /// Smallest size of the table.
        least: Bytes,
        /// Largest size of the table.
        most: Bytes,
    },
}

impl EnergyTable {
    /// Reads and checks an energy table.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line: also prices that are zero without
    /// `free = true`, and sources that nobody knows.
    pub fn parse(text: &str) -> Result<EnergyTable, ConfigError> {
        let config = config::parse::<EnergyTable>(text, &[])?;
        let problems = check::problems(&config.value);
        let problems = problems.into_iter().map(|(k, m)| config.problem(&k, m)).collect();
        config.checked(problems)
    }

    /// The prices on a machine that is built of these memories and units.
    ///
    /// # Errors
    /// A bank outside of the SRAM table, unless the table allows extrapolation.
    pub fn prices(&self, inventory: &Inventory) -> Result<Prices, PriceError> {
        let mut sram = [(0.0, 0.0); Buffer::ALL.len()];
        let leakage = &self.leakage;
        let per_unit = [&leakage.ccu, &leakage.qsu, &leakage.bsu, &leakage.vru];
        let units = per_unit.iter().zip(inventory.units);
        let mut leakage_w: f64 = units.map(|(price, n)| price.power.0 * f64::from(n)).sum();
        for (buffer, memory) in Buffer::ALL.into_iter().zip(&inventory.memories) {
            if memory.banks == 0 {
                continue;
            }
            let size = self.bank(buffer, memory.bank)?;
            sram[buffer as usize] = (size.read.0, size.write.0);
            leakage_w += size.leakage.0 * f64::from(memory.banks);
        }
        let mut per_action = [0.0; Action::COUNT];
        for action in Action::all() {
            per_action[action.index()] = match action {
                Action::SramRead(b) => sram[b as usize].0,
                Action::SramWrite(b) => sram[b as usize].1,
                Action::DramRead => self.dram.read.energy.0,
                Action::DramWrite => self.dram.write.energy.0,
                arithmetic => self.arithmetic(arithmetic).map_or(0.0, |p| self.energy_pj(p)),
            };
        }
        Ok(Prices { per_action, leakage_w, background_w: self.dram.background.power.0 })
    }

    /// FLOPs of an action, where the table counts them.
    pub fn flops(&self, action: Action) -> Option<u32> {
        self.arithmetic(action)?.flops
    }

    /// Picojoules per FLOP, per byte of SRAM and per byte of DRAM read, for tables with one flat
    /// price each: what the closed-form `paper` model needs.
    pub fn flat_pj(&self) -> Option<[f64; 3]> {
        let flop = self.flop.as_ref()?.energy?;
        let sram = self.sram.flat.as_ref()?;
        Some([flop.0, sram.energy.0, self.dram.read.energy.0])
    }

    fn arithmetic(&self, action: Action) -> Option<&ActionPrice> {
        let a = &self.actions;
        Some(match action {
            Action::Cull => &a.cull,
            Action::Project => &a.project,
            Action::ObbPrepare => &a.obb_prepare,
            Action::ObbTest => &a.obb_test,
            Action::ShColour => &a.sh_colour,
            Action::PivotKey => &a.pivot_key,
            Action::CompareExchange => &a.compare_exchange,
            Action::Alpha => &a.alpha,
            Action::Blend => &a.blend,
            Action::PixelFinish => &a.pixel_finish,
            Action::SramRead(_) | Action::SramWrite(_) | Action::DramRead | Action::DramWrite => {
                return None;
            }
        })
    }

    fn energy_pj(&self, price: &ActionPrice) -> f64 {
        let flop = self.flop.as_ref().and_then(|p| p.energy).map_or(0.0, |e| e.0);
        match (price.energy, price.flops) {
            (Some(energy), _) => energy.0,
            (None, Some(flops)) => f64::from(flops) * flop,
            (None, None) => 0.0,
        }
    }

    fn bank(&self, buffer: Buffer, bank: Bytes) -> Result<SramSize, PriceError> {
        if let Some(flat) = &self.sram.flat {
            let (read, write) = (flat.energy, flat.energy);
            return Ok(SramSize { capacity: bank, read, write, leakage: Watts(0.0) });
        }
        let table = self.sram.table.as_ref().expect("checked: flat or table");
        let (least, most) = (&table.sizes[0], &table.sizes[table.sizes.len() - 1]);
        let inside = (least.capacity..=most.capacity).contains(&bank);
        if bank == Bytes(0) || !(inside || table.allow_extrapolation) {
            return Err(PriceError::OutsideTable {
                buffer: buffer.name(),
                bank,
                table: self.name.clone(),
                least: least.capacity,
                most: most.capacity,
            });
        }
        Ok(table.at(bank))
    }
}

impl SramTable {
    /// The row for a bank of this size, between the two rows around it.
    fn at(&self, bank: Bytes) -> SramSize {
        let above = self.sizes.partition_point(|s| s.capacity < bank);
        let high = above.clamp(1, self.sizes.len() - 1);
        let (a, b) = (&self.sizes[high - 1], &self.sizes[high]);
        let log = |bytes: Bytes| (bytes.0 as f64).ln();
        let t = (log(bank) - log(a.capacity)) / (log(b.capacity) - log(a.capacity));
        let mix = |x: f64, y: f64| (x.ln() * (1.0 - t) + y.ln() * t).exp();
        SramSize {
            capacity: bank,
            read: PicojoulesPerByte(mix(a.read.0, b.read.0)),
            write: PicojoulesPerByte(mix(a.write.0, b.write.0)),
            leakage: Watts(mix(a.leakage.0, b.leakage.0)),
        }
    }
}
