//! Energy tables: a price with its source for every action, as in `arch-configs/energy/*.toml`.
//!
//! A table becomes [`Prices`] once the machine's buffers and units are known, so that pricing
//! cannot fail later.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::action::{BufferId, Inventory, Memory, StageId};
use crate::area::Area;
use crate::cacti::Bank;
use crate::hardware::{BufferFacts, Catalogue, Does, Unpriced, WorkFacts};
use crate::prices::{DramCosts, IdleShares, Prices};
use crate::supply::Supply;
use powergs_base::config::embedded::ENERGY;
use powergs_base::config::{self, ConfigError, layer};
use powergs_base::number::NumberFormat;
use powergs_base::quantity::{Bytes, Hertz, Nanometres, SquareMillimetres, Volts};

mod check;
mod keys;
mod named;
mod parts;
mod scale;
mod sram;

pub use keys::{
    ActionPrice, AreaPrice, AreaScope, BytePrice, CurveChoice, CyclePrice, DramPrices, Factor,
    FlatDram, FormatFactors, IdlePrices, Overhead, PhyPrices, PowerPrice, PowerScope, PriceScope,
    RestArea, RowHitShare, Scaling, SupplyPrices, UnitNumbers,
};
pub use named::{Named, Names, Parts, UnitArea, Units, Works};
pub use parts::PartShare;
pub use sram::{SramCacti, SramMacro, SramPrices, SramSize, SramTable};

use parts::Grown;
use scale::Factors;
pub use scale::NodeStep;

/// An energy table, checked: every price has a source, and none is zero by accident. `C` declares
/// what there is to be priced.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", bound = "C: Catalogue")]
#[schemars(rename = "EnergyTable", bound = "C: Catalogue")]
pub struct EnergyTable<C> {
    /// Name in reports.
    pub name: String,
    /// What it is, in one line.
    pub description: String,
    /// Technology node of the chip. Needed in a file; tables from Accelergy do not know it.
    pub node: Option<Nanometres>,
    /// What areas and powers are of. Without it they are of the block that renders, and of its
    /// memory.
    pub scope: Option<PriceScope>,
    /// The prices of the file are for another node.
    pub scaling: Option<Scaling>,
    /// Price of one floating-point operation, for actions that are given in `flops`.
    pub flop: Option<ActionPrice>,
    /// The `[actions]` table: one price for each arithmetic action.
    pub actions: Named<Works<C>, ActionPrice>,
    /// The `[clock]` table: what one unit takes in every cycle, whether or not it has something to
    /// do; nothing without. A unit without work takes nothing where `gating.units` switches it off.
    /// Nothing runs between frames (A111).
    pub clock: Option<Named<Units<C>, CyclePrice>>,
    /// What the number format of rendering units does to their prices.
    pub numbers: Option<UnitNumbers>,
    /// Prices of buffer accesses, leakage and area of the buffers.
    pub sram: SramPrices,
    /// Prices of DRAM accesses, its background and refresh power.
    pub dram: DramPrices,
    /// Leakage of the units, each multiplied by how many the machine has.
    pub leakage: Named<Units<C>, PowerPrice>,
    /// Area of the units; without it reports have no area.
    pub area: Option<UnitArea<C>>,
    /// What the units consist of. Needed where the table has area or leakage; tables from Accelergy
    /// are of units as they are built.
    pub parts: Option<Parts<C>>,
    /// The chip's side of a memory channel. Needed where the table has area.
    pub phy: Option<PhyPrices>,
    /// Clock and voltage of the prices. Without it they are taken as given at any clock.
    pub supply: Option<SupplyPrices>,
    /// What stays between frames. Without it everything does.
    pub idle: Option<IdlePrices>,
}

/// The keys of a machine that make the banks of a buffer.
fn keys(buffer: &BufferFacts) -> String {
    format!("`{}`, `banks` or `word` of `{}`", buffer.size, buffer.table)
}

/// A machine that the table has no price for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PriceError {
    /// A bank outside of the SRAM table.
    #[error(
        "the banks of buffer `{}` have {bank}, and the SRAM table of `{table}` goes from \
         {least} to {most}: change {}, or set `sram.table.allow-extrapolation = true` in a copy of \
         the energy table",
        buffer.key(), keys(buffer)
    )]
    OutsideTable {
        /// The buffer.
        buffer: BufferFacts,
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
        "the banks of buffer `{}` have {bank} in words of {word}, and the rows of \
         `sram.cacti` in `{table}` have {reach}: change {}, or set \
         `sram.cacti.allow-extrapolation = true` in a copy of the table",
        buffer.key(), keys(buffer)
    )]
    OutsideCacti {
        /// The buffer.
        buffer: BufferFacts,
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
    /// A stage of the machine whose work, cycles, leakage or area have no price.
    #[error(
        "the energy table `{table}` has no price of `{key}`, which the {stage} of the machine \
         need: add it, or name another table in `energy`"
    )]
    NoPrice {
        /// Name of the energy table.
        table: String,
        /// The key that is missing.
        key: String,
        /// What the stage is called.
        stage: &'static str,
    },
    /// Prices of a DRAM device for a machine without one.
    #[error(
        "the energy table `{table}` has the prices of a DRAM device alone (`dram.device = true`), \
         and the machine has a mere rate: name a device in `dram.device` of the machine, or set \
         `energy` to a table with [dram.flat]"
    )]
    NoDevice {
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
            | PriceError::NoPrice { .. }
            | PriceError::NoDevice { .. } => "energy",
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
    /// What the DRAM device costs; `None` where the machine has a mere rate.
    pub device: Option<DramCosts>,
    /// Memory channels.
    pub channels: f64,
    /// Those of them whose PHY and controllers are on the chip.
    pub phy_channels: f64,
    /// The share of the memory's background and refresh that is paid, 0 to 1.
    pub standby_share: f64,
    /// Clock of all units.
    pub clock: Hertz,
}

impl<C: Catalogue> EnergyTable<C> {
    /// Reads and checks an energy table.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line: also prices that are zero without
    /// `free = true`, unknown sources, and technology nodes without scaling factors.
    pub fn parse(text: &str) -> Result<EnergyTable<C>, ConfigError> {
        let text = &layer::on_embedded(text, ENERGY)?;
        let config = config::parse::<EnergyTable<C>>(text, &[])?;
        let problems = check::problems(&config.value);
        let problems = problems.into_iter().map(|(k, m)| config.problem(&k, m)).collect();
        config.checked(problems)
    }

    /// The prices on a machine that is built of these memories and units.
    ///
    /// # Errors
    /// A bank outside of the SRAM prices, unless the table allows extrapolation; prices of a DRAM
    /// device for a machine without one.
    pub fn prices(&self, built: &Built<'_>) -> Result<Prices, PriceError> {
        let hardware = C::hardware();
        let supply = self.supply_at(built.clock)?;
        let factors = self.factors().at(supply.as_ref());
        let grown = self.grown(built.inventory)?;
        let banks = self.banks(built.inventory, &factors, &grown)?;
        let numbers = self.numbers_of(built.numbers)?;
        let narrow = |stage: StageId, factor: f64| {
            if hardware.stage(stage).has_numbers { factor } else { 1.0 }
        };
        let leakage = |stage: StageId| Ok(self.priced("leakage", &self.leakage, stage)?.power.0);
        let unit_leakage_w = self.of_units(built.inventory, &grown, leakage)?;
        let units = hardware.units().zip(unit_leakage_w);
        let unit_leakage_w = units
            .map(|((id, _), watts)| watts * narrow(id, numbers.leakage) * factors.leakage)
            .collect();
        let memories = &built.inventory.memories;
        let leaks = |(bank, memory): (&Bank, &Memory)| bank.leakage_w * f64::from(memory.banks);
        let sram_leakage_w = banks.iter().zip(memories).map(leaks).collect();
        let dram = match (&self.dram.flat, built.device) {
            (_, Some(device)) if self.dram.device => device,
            (Some(flat), _) => DramCosts::Bytes {
                read_pj: flat.read.energy.0,
                write_pj: flat.write.energy.0,
                background_w: flat.background.power.0 * flat.part(built.channels),
                refresh_w: flat.refresh.power.0 * flat.part(built.channels),
            },
            (None, _) => return Err(PriceError::NoDevice { table: self.name.clone() }),
        };
        let word = |b: BufferId| memories[b.index()].word.0.max(1) as f64;
        let has = |stage: StageId| built.inventory.units[stage.index()] > 0;
        let one = |does| {
            Ok(match does {
                Does::SramRead(b) => banks[b.index()].read_pj / word(b),
                Does::SramWrite(b) => banks[b.index()].write_pj / word(b),
                Does::DramRead => dram.per_byte()[0],
                Does::DramWrite => dram.per_byte()[1],
                Does::IdleClock(_) if built.gated => 0.0,
                Does::Clock(stage) | Does::IdleClock(stage) if has(stage) => {
                    let narrow = narrow(stage, numbers.clock.unwrap_or(1.0));
                    self.cycle_pj(stage)? * grown.size[stage.index()] * narrow * factors.energy
                }
                // At the size of the first stage of the machine that does it.
                Does::Work(declares, work) => {
                    match hardware.doers(declares, work.key).find(|stage| has(*stage)) {
                        Some(stage) => {
                            let pj = self.work(stage, work)?.map_or(0.0, |p| self.energy_pj(p));
                            let narrow = narrow(stage, numbers.energy);
                            pj * grown.energy[stage.index()] * narrow * factors.energy
                        }
                        None => 0.0,
                    }
                }
                Does::Clock(_) | Does::IdleClock(_) => 0.0,
            })
        };
        let per_action = hardware.actions().map(|(_, does)| one(does)).collect::<Result<_, _>>()?;
        let idle_leakage = built.idle_leakage;
        let area = self.area_of(built.inventory, &banks, &factors, &grown, numbers.area)?;
        let of_channels = |per_channel: f64| SquareMillimetres(per_channel * built.phy_channels);
        let area = area.map(|area| match &self.phy {
            Some(phy) => Area {
                phy: of_channels(phy.area.area.0),
                controllers: of_channels(phy.controller.area.0),
                ..area
            },
            None => area,
        });
        let phy_standby_w =
            self.phy.as_ref().map_or(0.0, |phy| phy.standby.power.0 * built.phy_channels);
        Ok(Prices {
            hardware,
            per_action,
            unit_leakage_w,
            sram_leakage_w,
            idle_leakage,
            standby_share: built.standby_share,
            dram,
            area,
            phy_standby_w,
            supply,
            kept: self.idle.as_ref().map_or(IdleShares::ALL, |idle| IdleShares {
                leakage: idle.leakage,
                background: idle.background,
            }),
        })
    }

    /// What of the kind `of_one` all units of each kind have together, in the order of
    /// [`Hardware::units`](crate::hardware::Hardware::units); those without a price of their own
    /// as much as the units that they are counted in.
    fn of_units(
        &self,
        built: &Inventory,
        grown: &Grown,
        of_one: impl Fn(StageId) -> Result<f64, PriceError>,
    ) -> Result<Vec<f64>, PriceError> {
        let all = |(id, _)| match (built.units[StageId::index(id)], self.counted_as(id, built)) {
            (0, _) => Ok(0.0),
            (_, Some((_, 0.0))) => self.has_factor(id).map(|()| 0.0),
            (_, Some((other, as_many))) => Ok(of_one(other)? * as_many),
            (n, None) => Ok(of_one(id)? * f64::from(n) * grown.size[id.index()]),
        };
        C::hardware().units().map(all).collect()
    }

    /// The price of a unit of a stage in the table `key`.
    fn priced<'a, V>(
        &self,
        key: &str,
        prices: &'a Named<Units<C>, V>,
        stage: StageId,
    ) -> Result<&'a V, PriceError> {
        let facts = C::hardware().stage(stage);
        prices.get(facts.key).ok_or_else(|| PriceError::NoPrice {
            table: self.name.clone(),
            key: format!("{key}.{}", facts.key),
            stage: facts.words,
        })
    }

    /// The clock that the prices are for, where they are as given at any other one: the table has
    /// no voltage-frequency curve. `None` also where it does not say its clock.
    pub fn fixed_clock(&self) -> Option<Hertz> {
        self.supply.as_ref().filter(|supply| supply.curve.is_none()).map(|supply| supply.clock)
    }

    /// That a machine of this clock has prices for another one, in a sentence without its end.
    pub fn clock_doubt(&self, clock: Hertz) -> Option<String> {
        let own = self.fixed_clock().filter(|own| *own != clock)?;
        Some(format!(
            "energy table `{}`: its prices are for {own}, and the machine has {clock}; there is no \
             voltage-frequency curve (`supply.curve`), so prices are as given at any clock: real \
             ones fall with the voltage at a lower clock and rise at a higher one, and leakage is \
             paid for as long as a frame takes",
            self.name
        ))
    }

    /// The supply voltage at a clock; `None` in a table without a curve.
    fn supply_at(&self, clock: Hertz) -> Result<Option<Supply>, PriceError> {
        let Some((supply, choice, voltage)) = self.curve() else { return Ok(None) };
        let curve = choice.curve().expect("checked: there is a curve");
        let found = curve.supply(clock, supply.clock, voltage);
        let too_high = || PriceError::ClockTooHigh {
            clock,
            node: self.node.map_or("this node".into(), |n| n.to_string()),
            table: self.name.clone(),
            nominal: supply.clock,
            voltage: voltage.0,
            highest: down_to_megahertz(curve.clock_at(curve.highest.0, supply.clock, voltage)),
            most: curve.highest.0,
        };
        found.map(Some).ok_or_else(too_high)
    }

    /// The supply with its curve and the voltage that belongs to it.
    fn curve(&self) -> Option<(&SupplyPrices, &CurveChoice, Volts)> {
        let supply = self.supply.as_ref()?;
        Some((supply, supply.curve.as_ref()?, supply.voltage?))
    }

    fn area_of(
        &self,
        built: &Inventory,
        banks: &[Bank],
        factors: &Factors,
        grown: &Grown,
        narrow: f64,
    ) -> Result<Option<Area>, PriceError> {
        let Some(area) = &self.area else { return Ok(None) };
        let of_one = |stage: StageId| Ok(self.priced("area", &area.units, stage)?.area.0);
        let units = self.of_units(built, grown, of_one)?;
        let narrow = |has_numbers: bool| if has_numbers { narrow } else { 1.0 };
        let units: Vec<f64> = C::hardware()
            .units()
            .zip(units)
            .map(|((_, unit), mm2)| mm2 * narrow(unit.has_numbers) * factors.area)
            .collect();
        let buffer = |(bank, memory): (&Bank, &Memory)| {
            bank.area_mm2 * f64::from(memory.banks) * area.sram_overhead.factor
        };
        let buffers: Vec<f64> = banks.iter().zip(&built.memories).map(buffer).collect();
        let parts = units.iter().sum::<f64>() + buffers.iter().sum::<f64>();
        let mm2 = |areas: Vec<f64>| areas.into_iter().map(SquareMillimetres).collect();
        Ok(Some(Area {
            units: mm2(units),
            buffers: mm2(buffers),
            rest: SquareMillimetres(parts * area.rest.share),
            ..Area::default()
        }))
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
        let hardware = C::hardware();
        let one = |((id, buffer), memory): ((BufferId, &BufferFacts), &Memory)| {
            if memory.banks == 0 {
                return Ok(NONE);
            }
            let bank = source.bank(buffer, memory, &self.name)?;
            let stage = hardware.stage_of(id).index();
            let (size, energy) = match buffer.grows {
                true => (grown.size[stage], grown.energy[stage]),
                false => (1.0, 1.0),
            };
            Ok(Bank {
                read_pj: bank.read_pj * energy * factors.sram_energy,
                write_pj: bank.write_pj * energy * factors.sram_energy,
                leakage_w: bank.leakage_w * size * factors.sram_leakage,
                area_mm2: bank.area_mm2 * size * factors.sram_area,
            })
        };
        hardware.buffers().zip(&built.memories).map(one).collect()
    }

    /// Picojoules per FLOP, per byte of SRAM and per byte of DRAM read, for tables with one flat
    /// price each: what the closed-form `paper` model needs.
    pub fn flat_pj(&self) -> Option<[f64; 3]> {
        let flop = self.flop.as_ref()?.energy?;
        let (sram, dram) = (self.sram.flat.as_ref()?, self.dram.flat.as_ref()?);
        Some([flop.0, sram.energy.0, dram.read.energy.0])
    }

    /// The price of an action; `None` where it is free as a part of another one.
    fn work(&self, stage: StageId, work: WorkFacts) -> Result<Option<&ActionPrice>, PriceError> {
        let missing = |key: &str| PriceError::NoPrice {
            table: self.name.clone(),
            key: format!("actions.{key}"),
            stage: C::hardware().stage(stage).words,
        };
        match (self.actions.get(work.key), work.unpriced) {
            (Some(own), _) => Ok(Some(own)),
            (None, Unpriced::Never) => Err(missing(work.key)),
            (None, Unpriced::As(other)) => {
                self.actions.get(other).map(Some).ok_or_else(|| missing(other))
            }
            (None, Unpriced::MadeOf(_)) => Ok(None),
        }
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

    /// What one unit takes in a cycle; nothing where it is counted in others.
    fn cycle_pj(&self, stage: StageId) -> Result<f64, PriceError> {
        match &self.clock {
            Some(clock) if C::hardware().stage(stage).counted_in.is_none() => {
                Ok(self.priced("clock", clock, stage)?.energy.0)
            }
            _ => Ok(0.0),
        }
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
