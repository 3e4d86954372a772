//! Energy tables: a price with its source for every action, as in `arch-configs/energy/*.toml`.
//!
//! A table becomes [`Prices`] once the machine's buffers and units are known, so that pricing
//! cannot fail later.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::action::{Action, Buffer, Inventory};
use crate::energy::area::Area;
use crate::energy::cacti::Bank;
use crate::energy::prices::{DramCosts, Prices};
use powergs_base::config::{self, ConfigError};
use powergs_base::quantity::{Bytes, Nanometres, SquareMillimetres};

mod check;
mod keys;
mod scale;
mod sram;

pub use keys::{
    ActionPrice, ActionPrices, AreaPrice, BytePrice, DramPrices, Factor, FlatDram, Overhead,
    PowerPrice, RestArea, Scaling, UnitArea, UnitLeakage,
};
pub use sram::{SramCacti, SramMacro, SramPrices, SramSize, SramTable};

use scale::Factors;

/// An energy table, checked: every price has a source, and none is zero by accident.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct EnergyTable {
    /// Name in reports.
    pub name: String,
    /// What it is, in one line.
    pub description: String,
    /// Technology node of the chip. Needed in a file; tables from Accelergy do not know it.
    pub node: Option<Nanometres>,
    /// The prices of the file are for another node.
    pub scaling: Option<Scaling>,
    /// Price of one floating-point operation, for actions that are given in `flops`.
    pub flop: Option<ActionPrice>,
    /// Prices of the arithmetic actions.
    pub actions: ActionPrices,
    /// Prices of buffer accesses, leakage and area of the buffers.
    pub sram: SramPrices,
    /// Prices of DRAM accesses, its background and refresh power.
    pub dram: DramPrices,
    /// Leakage of the units, each multiplied by how many the machine has.
    pub leakage: UnitLeakage,
    /// Area of the units; without it reports have no area.
    pub area: Option<UnitArea>,
}

/// A machine that the table has no price for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PriceError {
    /// A bank outside of the SRAM table.
    #[error(
        "the banks of buffer `{buffer}` have {bank}, and the SRAM table of `{table}` goes from \
         {least} to {most}: change `buffers.{buffer}`, or set `sram.table.allow-extrapolation = \
         true` in a copy of the energy table"
    )]
    OutsideTable {
        /// Key of the buffer.
        buffer: String,
        /// Size of one bank.
        bank: Bytes,
        /// Name of the energy table.
        table: String,
        /// Smallest size of the table.
        least: Bytes,
        /// Largest size of the table.
        most: Bytes,
    },
    /// A bank that the rows of CACTI do not reach.
    #[error(
        "the banks of buffer `{buffer}` have {bank} in words of {word}, and the rows of \
         `sram.cacti` in `{table}` have {reach}: change `capacity`, `banks` or `word` of \
         `buffers.{buffer}`, or set `sram.cacti.allow-extrapolation = true` in a copy of the table"
    )]
    OutsideCacti {
        /// Key of the buffer.
        buffer: String,
        /// Size of one bank.
        bank: Bytes,
        /// Bytes of one access.
        word: Bytes,
        /// Name of the energy table.
        table: String,
        /// What the rows have.
        reach: String,
    },
    /// A buffer without a macro.
    #[error(
        "the machine has a buffer `{buffer}`, and `sram.macros` of the energy table `{table}` has \
         no price for it: add one, or take the buffer out of the machine"
    )]
    NoMacro {
        /// Key of the buffer.
        buffer: String,
        /// Name of the energy table.
        table: String,
    },
    /// Prices of DRAM commands for a machine whose DRAM model counts none.
    #[error(
        "the energy table `{table}` prices the commands of a DRAM device (`dram.device = true`), \
         and the `bandwidth` model counts none: set `dram.model = \"banked\"` or \"window\" in the \
         machine, or `energy` to a table with flat DRAM prices"
    )]
    NoCommands {
        /// Name of the energy table.
        table: String,
    },
}

/// The properties of a machine that prices depend on.
#[derive(Debug, Clone, Copy)]
pub struct Built<'a> {
    /// Units and memories.
    pub inventory: &'a Inventory,
    /// Share of its leakage that a unit without work keeps: 1 without power gating.
    pub idle_leakage: f64,
    /// What the DRAM device costs; `None` where its commands are not counted.
    pub device: Option<DramCosts>,
}

impl EnergyTable {
    /// Reads and checks an energy table.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line: also prices that are zero without
    /// `free = true`, unknown sources, and technology nodes without scaling factors.
    pub fn parse(text: &str) -> Result<EnergyTable, ConfigError> {
        let config = config::parse::<EnergyTable>(text, &[])?;
        let problems = check::problems(&config.value);
        let problems = problems.into_iter().map(|(k, m)| config.problem(&k, m)).collect();
        config.checked(problems)
    }

    /// The prices on a machine that is built of these memories and units.
    ///
    /// # Errors
    /// A bank outside of the SRAM prices, unless the table allows extrapolation; prices of DRAM
    /// commands for a machine that counts none.
    pub fn prices(&self, built: &Built<'_>) -> Result<Prices, PriceError> {
        let factors = self.factors();
        let banks = self.banks(built.inventory, &factors)?;
        let leakage = &self.leakage;
        let per_unit = [&leakage.ccu, &leakage.qsu, &leakage.bsu, &leakage.vru];
        let unit_leakage_w = std::array::from_fn(|i| {
            let scale = f64::from(built.inventory.unit_percent[i]) / 100.0;
            per_unit[i].power.0 * f64::from(built.inventory.units[i]) * scale * factors.leakage
        });
        let memories = &built.inventory.memories;
        let sram_leakage_w =
            std::array::from_fn(|i| banks[i].leakage_w * f64::from(memories[i].banks));
        let dram = match &self.dram.flat {
            Some(flat) => DramCosts::Bytes {
                read_pj: flat.read.energy.0,
                write_pj: flat.write.energy.0,
                background_w: flat.background.power.0,
                refresh_w: flat.refresh.power.0,
            },
            None => {
                let name = || PriceError::NoCommands { table: self.name.clone() };
                built.device.ok_or_else(name)?
            }
        };
        let word = |b: Buffer| memories[b as usize].word.0.max(1) as f64;
        let per_action = Action::all().map(|action| match action {
            Action::SramRead(b) => banks[b as usize].read_pj / word(b),
            Action::SramWrite(b) => banks[b as usize].write_pj / word(b),
            Action::DramRead => dram.per_byte()[0],
            Action::DramWrite => dram.per_byte()[1],
            other => self.arithmetic(other).map_or(0.0, |p| self.energy_pj(p)) * factors.energy,
        });
        let idle_leakage = built.idle_leakage;
        let area = self.area_of(built.inventory, &banks, &factors);
        Ok(Prices { per_action, unit_leakage_w, sram_leakage_w, idle_leakage, dram, area })
    }

    fn area_of(&self, built: &Inventory, banks: &[Bank], factors: &Factors) -> Option<Area> {
        let area = self.area.as_ref()?;
        let per_unit = [&area.ccu, &area.qsu, &area.bsu, &area.vru];
        let units: [f64; 4] = std::array::from_fn(|i| {
            let scale = f64::from(built.unit_percent[i]) / 100.0;
            per_unit[i].area.0 * f64::from(built.units[i]) * scale * factors.area
        });
        let buffers: [f64; Buffer::ALL.len()] = std::array::from_fn(|i| {
            banks[i].area_mm2 * f64::from(built.memories[i].banks) * area.sram_overhead.factor
        });
        let parts = units.iter().sum::<f64>() + buffers.iter().sum::<f64>();
        Some(Area {
            units: units.map(SquareMillimetres),
            buffers: buffers.map(SquareMillimetres),
            rest: SquareMillimetres(parts * area.rest.share),
        })
    }

    /// The prices of one bank of each buffer at the table's node; zero for a buffer without banks.
    fn banks(&self, built: &Inventory, factors: &Factors) -> Result<Vec<Bank>, PriceError> {
        const NONE: Bank = Bank { read_pj: 0.0, write_pj: 0.0, leakage_w: 0.0, area_mm2: 0.0 };
        let source = self.sram.source();
        let one = |(buffer, memory): (Buffer, &crate::action::Memory)| {
            if memory.banks == 0 {
                return Ok(NONE);
            }
            let bank = source.bank(buffer, memory, self)?;
            Ok(Bank {
                read_pj: bank.read_pj * factors.sram_energy,
                write_pj: bank.write_pj * factors.sram_energy,
                leakage_w: bank.leakage_w * factors.sram_leakage,
                area_mm2: bank.area_mm2 * factors.sram_area,
            })
        };
        Buffer::ALL.into_iter().zip(&built.memories).map(one).collect()
    }

    /// Picojoules per FLOP, per byte of SRAM and per byte of DRAM read, for tables with one flat
    /// price each: what the closed-form `paper` model needs.
    pub fn flat_pj(&self) -> Option<[f64; 3]> {
        let flop = self.flop.as_ref()?.energy?;
        let (sram, dram) = (self.sram.flat.as_ref()?, self.dram.flat.as_ref()?);
        Some([flop.0, sram.energy.0, dram.read.energy.0])
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
            (None, Some(flops)) => flop * f64::from(flops),
            (None, None) => 0.0,
        }
    }
}
