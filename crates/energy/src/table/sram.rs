//! The `[sram]` table: what a bank costs.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::PriceError;
use super::keys::{BytePrice, is_false};
use crate::action::Memory;
use crate::cacti::{Bank, Cell, Macros};
use crate::hardware::BufferFacts;
use powergs_base::quantity::{
    Bytes, Nanometres, Picojoules, PicojoulesPerByte, SquareMillimetres, Watts,
};

/// The `[sram]` table: exactly one of `flat`, `table`, `cacti` and `macros`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SramPrices {
    /// One price for every size; no leakage, no area.
    pub flat: Option<BytePrice>,
    /// Prices per byte by the size of a bank, whatever its word and ports.
    pub table: Option<SramTable>,
    /// Prices per word by size, word, ports, cell and node: the rows of CACTI 7.
    pub cacti: Option<SramCacti>,
    /// Prices per word of the bank of each buffer, as a memory compiler gives them.
    pub macros: Option<Vec<SramMacro>>,
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
    /// Area of the bank; needed where the table has `[area]`.
    pub area: Option<SquareMillimetres>,
}

/// Rows of CACTI 7 (`arch-configs/sram/cacti-7.csv`), interpolated.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SramCacti {
    /// Node of the rows: `node` of the table, or `scaling.from` where there is one.
    pub node: Nanometres,
    /// Transistors of the cells.
    pub cell: Cell,
    /// Temperature of the leakage: 350, or 300 where there are such rows.
    #[schemars(range(min = 1, max = 1000), extend("x-unit" = "K"))]
    pub temperature: u32,
    /// Factor on every energy: CACTI is good to a factor of two.
    #[schemars(range(min = 0.01, max = 100.0), extend("x-unit" = "factor"))]
    pub energy_factor: f64,
    /// Factor on every leakage.
    #[schemars(range(min = 0.0001, max = 100.0), extend("x-unit" = "factor"))]
    pub leakage_factor: f64,
    /// Whether banks (up to four times smaller or larger than the rows) and words that the rows do
    /// not reach are priced by the nearest rows.
    #[serde(default, skip_serializing_if = "is_false")]
    pub allow_extrapolation: bool,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// The bank of one buffer.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct SramMacro {
    /// The buffer, as `arch show` lists them: `gaussian-in`, `feature`.
    pub buffer: String,
    /// Energy of reading one word.
    pub read: Picojoules,
    /// Energy of writing one word.
    pub write: Picojoules,
    /// Leakage of one bank.
    pub leakage: Watts,
    /// Area of one bank; needed where the table has `[area]`.
    pub area: Option<SquareMillimetres>,
    /// Key of `references.toml` or assumption number.
    pub source: String,
}

/// The SRAM prices of a table, ready for queries by buffer.
pub(super) enum Source<'a> {
    Flat(&'a BytePrice),
    Table(&'a SramTable),
    Cacti(&'a SramCacti, Macros),
    Macros(&'a [SramMacro]),
}

impl SramPrices {
    /// The one that is given. The table has been checked.
    pub(super) fn source(&self) -> Source<'_> {
        if let Some(flat) = &self.flat {
            return Source::Flat(flat);
        }
        if let Some(table) = &self.table {
            return Source::Table(table);
        }
        if let Some(cacti) = &self.cacti {
            return Source::Cacti(cacti, cacti.banks().expect("checked: there are rows"));
        }
        Source::Macros(self.macros.as_deref().expect("checked: one of the four is there"))
    }
}

impl SramCacti {
    /// Its rows.
    pub(super) fn banks(&self) -> Result<Macros, String> {
        Macros::new(self.node.0, self.cell, self.temperature)
    }
}

impl Source<'_> {
    /// The prices of one bank of a buffer; area 0 where the table has none.
    pub(super) fn bank(
        &self,
        buffer: &BufferFacts,
        memory: &Memory,
        table: &str,
    ) -> Result<Bank, PriceError> {
        let word = memory.word.0.max(1) as f64;
        match self {
            Source::Flat(flat) => {
                let pj = flat.energy.0 * word;
                Ok(Bank { read_pj: pj, write_pj: pj, leakage_w: 0.0, area_mm2: 0.0 })
            }
            Source::Table(sizes) => {
                let row = sizes.at(memory.bank).ok_or_else(|| PriceError::OutsideTable {
                    buffer: *buffer,
                    bank: memory.bank,
                    table: table.to_owned(),
                    least: sizes.sizes[0].capacity,
                    most: sizes.sizes[sizes.sizes.len() - 1].capacity,
                })?;
                Ok(Bank {
                    read_pj: row.read.0 * word,
                    write_pj: row.write.0 * word,
                    leakage_w: row.leakage.0,
                    area_mm2: row.area.map_or(0.0, |a| a.0),
                })
            }
            Source::Cacti(keys, rows) => {
                let beyond = keys.allow_extrapolation;
                let bank = rows.bank(memory.bank.0, memory.word.0, memory.two_ports, beyond);
                let bank = bank.map_err(|outside| PriceError::OutsideCacti {
                    buffer: *buffer,
                    bank: memory.bank,
                    word: memory.word,
                    table: table.to_owned(),
                    reach: reach(&outside),
                })?;
                Ok(Bank {
                    read_pj: bank.read_pj * keys.energy_factor,
                    write_pj: bank.write_pj * keys.energy_factor,
                    leakage_w: bank.leakage_w * keys.leakage_factor,
                    area_mm2: bank.area_mm2,
                })
            }
            Source::Macros(macros) => {
                let found = macros.iter().find(|m| m.buffer == buffer.key());
                let found = found.ok_or_else(|| PriceError::NoMacro {
                    buffer: buffer.key(),
                    table: table.to_owned(),
                })?;
                Ok(Bank {
                    read_pj: found.read.0,
                    write_pj: found.write.0,
                    leakage_w: found.leakage.0,
                    area_mm2: found.area.map_or(0.0, |a| a.0),
                })
            }
        }
    }
}

fn reach(outside: &crate::cacti::Outside) -> String {
    let (least, most) = outside.sizes;
    let sizes = format!("banks from {} to {}", Bytes(least), Bytes(most));
    match outside.words {
        Some((a, b)) => {
            format!("{sizes}, at this size with words from {} to {}", Bytes(a), Bytes(b))
        }
        None => sizes,
    }
}

impl SramTable {
    /// The row for a bank of this size, between the two rows around it.
    fn at(&self, bank: Bytes) -> Option<SramSize> {
        let (least, most) = (self.sizes[0].capacity, self.sizes[self.sizes.len() - 1].capacity);
        let inside = (least..=most).contains(&bank);
        if bank == Bytes(0) || !(inside || self.allow_extrapolation) {
            return None;
        }
        let above = self.sizes.partition_point(|s| s.capacity < bank);
        let high = above.clamp(1, self.sizes.len() - 1);
        let (a, b) = (&self.sizes[high - 1], &self.sizes[high]);
        if let Some(row) = [a, b].into_iter().find(|row| row.capacity == bank) {
            return Some(row.clone());
        }
        let log = |bytes: Bytes| (bytes.0 as f64).ln();
        let t = (log(bank) - log(a.capacity)) / (log(b.capacity) - log(a.capacity));
        let mix = |x: f64, y: f64| (x.ln() * (1.0 - t) + y.ln() * t).exp();
        let area = a.area.zip(b.area).map(|(x, y)| SquareMillimetres(mix(x.0, y.0)));
        Some(SramSize {
            capacity: bank,
            read: PicojoulesPerByte(mix(a.read.0, b.read.0)),
            write: PicojoulesPerByte(mix(a.write.0, b.write.0)),
            leakage: Watts(mix(a.leakage.0, b.leakage.0)),
            area,
        })
    }
}
