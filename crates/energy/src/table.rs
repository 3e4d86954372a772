//! Energy tables: a price with its source for every action, as in `arch-configs/energy/*.toml`.
//!
//! A table becomes [`Prices`] once the machine's buffers and units are known, so that pricing
//! cannot fail later.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::action::{Action, Buffer, Inventory, UnitKind};
use crate::area::Area;
use crate::cacti::Bank;
use crate::prices::{DramCosts, Prices};
use crate::supply::Supply;
use powergs_base::config::embedded::ENERGY;
use powergs_base::config::{self, ConfigError, layer};
use powergs_base::number::NumberFormat;
use powergs_base::quantity::{Bytes, Hertz, Nanometres, SquareMillimetres};

mod check;
mod keys;
mod parts;
mod scale;
mod sram;

pub use keys::{
    ActionPrice, ActionPrices, AreaPrice, BytePrice, CurveChoice, CyclePrice, DramPrices, Factor,
    FlatDram, FormatFactors, Overhead, PhyPrices, PowerPrice, RestArea, Scaling, SupplyPrices,
    UnitArea, UnitClock, UnitLeakage, UnitNumbers,
};
pub use parts::{BsuParts, CacheParts, CcuParts, PartShare, Parts, QsuParts, VruParts};
pub use sram::{SramCacti, SramMacro, SramPrices, SramSize, SramTable};

use parts::{Grown, unit_of};
use scale::Factors;
pub use scale::NodeStep;

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
    /// What units take in every cycle; nothing without.
    pub clock: Option<UnitClock>,
    /// What the number format of rendering units does to their prices.
    pub numbers: Option<UnitNumbers>,
    /// Prices of buffer accesses, leakage and area of the buffers.
    pub sram: SramPrices,
    /// Prices of DRAM accesses, its background and refresh power.
    pub dram: DramPrices,
    /// Leakage of the units, each multiplied by how many the machine has.
    pub leakage: UnitLeakage,
    /// Area of the units; without it reports have no area.
    pub area: Option<UnitArea>,
    /// What the units consist of. Needed where the table has area or leakage; tables from Accelergy
    /// are of units as they are built.
    pub parts: Option<Parts>,
    /// The chip's side of a memory channel. Needed where the table has area.
    pub phy: Option<PhyPrices>,
    /// Clock and voltage of the prices. Without it they are taken as given at any clock.
    pub supply: Option<SupplyPrices>,
}

/// The keys of a machine that make the banks of a buffer.
fn keys(buffer: &str) -> String {
    let (table, size) = match buffer {
        "codebook" => ("codebook", "entries"),
        "cache" => ("cache", "capacity"),
        "pointers" => ("binning.pointers", "capacity"),
        "combining" => ("binning.combining", "capacity"),
        _ => return format!("`capacity`, `banks` or `word` of `buffers.{buffer}`"),
    };
    format!("`{size}`, `banks` or `word` of `{table}`")
}

/// A machine that the table has no price for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PriceError {
    /// A bank outside of the SRAM table.
    #[error(
        "the banks of buffer `{buffer}` have {bank}, and the SRAM table of `{table}` goes from \
         {least} to {most}: change {}, or set `sram.table.allow-extrapolation = true` in a copy of \
         the energy table",
        keys(buffer)
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
         `sram.cacti` in `{table}` have {reach}: change {}, or set \
         `sram.cacti.allow-extrapolation = true` in a copy of the table",
        keys(buffer)
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
    /// A clock above the highest one.
    #[error(
        "`clock` = {clock} is above what {node} reaches: the units of `{table}` have {nominal} at \
         {voltage} V, and at most {highest} at {most} V, the highest voltage; set `clock` to that \
         or less, or `energy` to a table of a faster node"
    )]
    ClockTooHigh {
        /// Clock of the machine.
        clock: Hertz,
        /// Technology node.
        node: String,
        /// Name of the energy table.
        table: String,
        /// Clock that the prices are for.
        nominal: Hertz,
        /// Voltage that the prices are for.
        voltage: f64,
        /// The highest clock.
        highest: Hertz,
        /// The highest voltage.
        most: f64,
    },
    /// A number format without factors.
    #[error(
        "the energy table `{table}` has no prices for rendering units of `{numbers}`: it has \
         {known}; set `record.numbers` to one of these, or add a row to `numbers.formats` in a \
         copy of it"
    )]
    NoNumbers {
        /// Name of the energy table.
        table: String,
        /// Numbers of the machine.
        numbers: NumberFormat,
        /// Those that the table has.
        known: String,
    },
    /// Prices of DRAM commands for a machine whose DRAM model counts none.
    #[error(
        "the energy table `{table}` prices the commands of a DRAM device (`dram.device = true`), \
         and the `bandwidth` model counts none: set `dram.model = \"banked\"`, \
         \"calibrated\" or \"window\" in the machine, or `energy` to a table with flat DRAM prices"
    )]
    NoCommands {
        /// Name of the energy table.
        table: String,
    },
}

impl PriceError {
    /// The key of the machine file that is at fault.
    pub const fn key(&self) -> &'static str {
        match self {
            PriceError::ClockTooHigh { .. } => "clock",
            PriceError::NoNumbers { .. } => "record.numbers",
            PriceError::OutsideTable { .. }
            | PriceError::OutsideCacti { .. }
            | PriceError::NoMacro { .. }
            | PriceError::NoCommands { .. } => "energy",
        }
    }
}

/// The properties of a machine that prices depend on.
#[derive(Debug, Clone, Copy)]
pub struct Built<'a> {
    /// Units and memories.
    pub inventory: &'a Inventory,
    /// Share of its leakage that a unit without work keeps: 1 without power gating.
    pub idle_leakage: f64,
    /// Whether a unit without work is switched off, its clock too.
    pub gated: bool,
    /// Numbers of the rendering units; `None`: those of the prices.
    pub numbers: Option<NumberFormat>,
    /// What the DRAM device costs; `None` where its commands are not counted.
    pub device: Option<DramCosts>,
    /// Memory channels.
    pub channels: f64,
    /// Clock of all units.
    pub clock: Hertz,
}

impl EnergyTable {
    /// Reads and checks an energy table.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line: also prices that are zero without
    /// `free = true`, unknown sources, and technology nodes without scaling factors.
    pub fn parse(text: &str) -> Result<EnergyTable, ConfigError> {
        let text = &layer::on_embedded(text, ENERGY)?;
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
        let supply = self.supply_at(built.clock)?;
        let factors = self.factors().at(supply.as_ref());
        let grown = self.grown(built.inventory);
        let banks = self.banks(built.inventory, &factors, &grown)?;
        let numbers = self.numbers_of(built.numbers)?;
        let leakage = &self.leakage;
        let per_unit = [&leakage.ccu, &leakage.qsu, &leakage.bsu, &leakage.vru];
        let colours = self.colours_as_ccus(built.inventory) * leakage.ccu.power.0;
        let unit_leakage_w = std::array::from_fn(|i| {
            let units = f64::from(built.inventory.units[i]) * grown.units[i];
            let is_vru = i == UnitKind::Vru as usize;
            let (colours, narrow) = if is_vru { (colours, numbers.leakage) } else { (0.0, 1.0) };
            (per_unit[i].power.0 * units * narrow + colours) * factors.leakage
        });
        let memories = &built.inventory.memories;
        let sram_leakage_w =
            std::array::from_fn(|i| banks[i].leakage_w * f64::from(memories[i].banks));
        let dram = match (&self.dram.flat, built.device) {
            (_, Some(device)) if self.dram.device => device,
            (Some(flat), _) => DramCosts::Bytes {
                read_pj: flat.read.energy.0,
                write_pj: flat.write.energy.0,
                background_w: flat.background.power.0 * flat.part(built.channels),
                refresh_w: flat.refresh.power.0 * flat.part(built.channels),
            },
            (None, _) => return Err(PriceError::NoCommands { table: self.name.clone() }),
        };
        let word = |b: Buffer| memories[b as usize].word.0.max(1) as f64;
        let per_action = Action::all().map(|action| match action {
            Action::SramRead(b) => banks[b as usize].read_pj / word(b),
            Action::SramWrite(b) => banks[b as usize].write_pj / word(b),
            Action::DramRead => dram.per_byte()[0],
            Action::DramWrite => dram.per_byte()[1],
            Action::IdleClock(_) if built.gated => 0.0,
            Action::Clock(unit) | Action::IdleClock(unit) => {
                let narrow = if unit == UnitKind::Vru { numbers.clock.unwrap_or(1.0) } else { 1.0 };
                self.cycle_pj(unit) * grown.units[unit as usize] * narrow * factors.energy
            }
            other => {
                let grown = unit_of(other).map_or(1.0, |unit| grown.energy[unit as usize]);
                let narrow =
                    if unit_of(other) == Some(UnitKind::Vru) { numbers.energy } else { 1.0 };
                let pj = self.arithmetic(other).map_or(0.0, |p| self.energy_pj(p));
                pj * grown * narrow * factors.energy
            }
        });
        let idle_leakage = built.idle_leakage;
        let area = self.area_of(built.inventory, &banks, &factors, &grown, numbers.area);
        let of_channels = |per_channel: f64| SquareMillimetres(per_channel * built.channels);
        let area = area.map(|area| match &self.phy {
            Some(phy) => Area {
                phy: of_channels(phy.area.area.0),
                controllers: of_channels(phy.controller.area.0),
                ..area
            },
            None => area,
        });
        let phy_standby_w =
            self.phy.as_ref().map_or(0.0, |phy| phy.standby.power.0 * built.channels);
        Ok(Prices {
            per_action,
            unit_leakage_w,
            sram_leakage_w,
            idle_leakage,
            dram,
            area,
            phy_standby_w,
            supply,
        })
    }

    /// The supply voltage at a clock; `None` in a table without `[supply]`.
    fn supply_at(&self, clock: Hertz) -> Result<Option<Supply>, PriceError> {
        let Some(supply) = &self.supply else { return Ok(None) };
        let curve = supply.curve.curve().expect("checked: there is a curve");
        let found = curve.supply(clock, supply.clock, supply.voltage);
        let too_high = || PriceError::ClockTooHigh {
            clock,
            node: self.node.map_or("this node".into(), |n| n.to_string()),
            table: self.name.clone(),
            nominal: supply.clock,
            voltage: supply.voltage.0,
            highest: down_to_megahertz(curve.clock_at(
                curve.highest.0,
                supply.clock,
                supply.voltage,
            )),
            most: curve.highest.0,
        };
        found.map(Some).ok_or_else(too_high)
    }

    fn area_of(
        &self,
        built: &Inventory,
        banks: &[Bank],
        factors: &Factors,
        grown: &Grown,
        narrow: f64,
    ) -> Option<Area> {
        let area = self.area.as_ref()?;
        let per_unit = [&area.ccu, &area.qsu, &area.bsu, &area.vru];
        let colours = self.colours_as_ccus(built) * area.ccu.area.0;
        let units: [f64; 4] = std::array::from_fn(|i| {
            let units = per_unit[i].area.0 * f64::from(built.units[i]) * grown.units[i];
            let is_vru = i == UnitKind::Vru as usize;
            let (colours, narrow) = if is_vru { (colours, narrow) } else { (0.0, 1.0) };
            (units * narrow + colours) * factors.area
        });
        let buffers: [f64; Buffer::ALL.len()] = std::array::from_fn(|i| {
            banks[i].area_mm2 * f64::from(built.memories[i].banks) * area.sram_overhead.factor
        });
        let parts = units.iter().sum::<f64>() + buffers.iter().sum::<f64>();
        Some(Area {
            units: units.map(SquareMillimetres),
            buffers: buffers.map(SquareMillimetres),
            rest: SquareMillimetres(parts * area.rest.share),
            ..Area::default()
        })
    }

    /// The prices of one bank of each buffer at the table's node; zero for a buffer without banks.
    fn banks(
        &self,
        built: &Inventory,
        factors: &Factors,
        grown: &Grown,
    ) -> Result<Vec<Bank>, PriceError> {
        const NONE: Bank = Bank { read_pj: 0.0, write_pj: 0.0, leakage_w: 0.0, area_mm2: 0.0 };
        let source = self.sram.source();
        let one = |(buffer, memory): (Buffer, &crate::action::Memory)| {
            if memory.banks == 0 {
                return Ok(NONE);
            }
            let bank = source.bank(buffer, memory, self)?;
            let (size, energy) = match buffer {
                Buffer::Cache => (grown.cache, grown.cache_energy),
                Buffer::GaussianIn
                | Buffer::TileList
                | Buffer::Sorting
                | Buffer::Feature
                | Buffer::PixelOut
                | Buffer::Pointers
                | Buffer::Combining
                | Buffer::Codebook => (1.0, 1.0),
            };
            Ok(Bank {
                read_pj: bank.read_pj * energy * factors.sram_energy,
                write_pj: bank.write_pj * energy * factors.sram_energy,
                leakage_w: bank.leakage_w * size * factors.sram_leakage,
                area_mm2: bank.area_mm2 * size * factors.sram_area,
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
            Action::SortedRow => a.sorted_row.as_ref()?,
            Action::MergedRow => a.merged_row.as_ref()?,
            Action::Alpha => &a.alpha,
            Action::StoppedPixel => a.stopped_pixel.as_ref().unwrap_or(&a.alpha),
            Action::Blend => &a.blend,
            Action::PixelFinish => &a.pixel_finish,
            Action::QueueEntry => &a.queue_entry,
            Action::Clock(_)
            | Action::IdleClock(_)
            | Action::SramRead(_)
            | Action::SramWrite(_)
            | Action::DramRead
            | Action::DramWrite => return None,
        })
    }

    /// The factors of a number format on the prices of a rendering unit.
    fn numbers_of(&self, numbers: Option<NumberFormat>) -> Result<FormatFactors, PriceError> {
        let plain =
            |numbers| FormatFactors { numbers, energy: 1.0, clock: None, leakage: 1.0, area: 1.0 };
        let rows = self.numbers.as_ref().map_or(&[][..], |own| &own.formats);
        match numbers {
            None => Ok(plain(NumberFormat::FP16)),
            // Prices of tables that do not say otherwise are those of FP16.
            Some(NumberFormat::FP16) if rows.is_empty() => Ok(plain(NumberFormat::FP16)),
            Some(numbers) => {
                let found = rows.iter().find(|row| row.numbers == numbers);
                let known = || match rows {
                    [] => "those of e5m10 alone".to_owned(),
                    rows => {
                        rows.iter().map(|r| r.numbers.to_string()).collect::<Vec<_>>().join(", ")
                    }
                };
                let table = self.name.clone();
                found.cloned().ok_or_else(|| PriceError::NoNumbers {
                    table,
                    numbers,
                    known: known(),
                })
            }
        }
    }

    /// What one unit takes in a cycle.
    fn cycle_pj(&self, unit: UnitKind) -> f64 {
        self.clock.as_ref().map_or(0.0, |clock| clock.of(unit).energy.0)
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

impl UnitClock {
    /// The price of a unit's cycle.
    pub const fn of(&self, unit: UnitKind) -> &CyclePrice {
        match unit {
            UnitKind::Ccu => &self.ccu,
            UnitKind::Qsu => &self.qsu,
            UnitKind::Bsu => &self.bsu,
            UnitKind::Vru => &self.vru,
        }
    }
}

/// A clock rounded down to whole megahertz, where it has any: a limit that is printed must hold.
fn down_to_megahertz(hertz: f64) -> Hertz {
    Hertz(if hertz >= 1e6 { (hertz / 1e6).floor() * 1e6 } else { hertz })
}

impl FlatDram {
    /// `background` and `refresh` of so many channels, over those of the file; 1 in a table that
    /// does not know how many its own are for.
    fn part(&self, channels: f64) -> f64 {
        self.channels.map_or(1.0, |of| channels / f64::from(of))
    }
}
