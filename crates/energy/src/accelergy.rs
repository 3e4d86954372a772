//! Energy and area reference tables of Accelergy (ERT and ART, version 0.4) as an energy table.
//!
//! A component is found by the last part of its name, without a range: `system.chip.ccu[0..3]` is
//! `ccu`. Energies are in pJ, areas in um². `docs/energy.md` lists components and actions, and what
//! each is mapped to.

use std::collections::BTreeMap;

use yaml::YamlNode;

use super::table::{
    ActionPrice, AreaPrice, BytePrice, DramPrices, EnergyTable, FlatDram, Overhead, PowerPrice,
    RestArea, SramMacro, SramPrices, UnitArea,
};
use crate::action::StageId;
use crate::hardware::{Catalogue, Does, StageFacts, Unpriced};
use powergs_base::quantity::{Hertz, Picojoules, PicojoulesPerByte, SquareMillimetres, Watts};

mod yaml;

/// The longest text that is looked at, bytes.
pub const TEXT_MAX: usize = 1 << 20;

/// The component that must be there. Which others a machine needs is known when it is priced.
const DRAM: &str = "dram";

/// Units that have a component: those with prices of their own.
fn units<C: Catalogue>() -> impl Iterator<Item = (StageId, &'static StageFacts)> {
    C::hardware().units().filter(|(_, unit)| unit.counted_in.is_none())
}

/// Components that are looked at: units, buffers, the DRAM.
fn components<C: Catalogue>() -> Vec<&'static str> {
    let units = units::<C>().map(|(_, unit)| unit.key);
    let buffers = C::hardware().buffers().map(|(_, buffer)| buffer.name);
    units.chain(buffers).chain([DRAM]).collect()
}

/// The source of every price of such a table.
const SOURCE: &str = "accelergy";

/// A reference table that cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AccelergyError {
    /// Too long to be one.
    #[error("longer than {TEXT_MAX} bytes: this is not a reference table")]
    TooLong,
    /// Not YAML, or of another shape.
    #[error("not a reference table of Accelergy (`{root}: {{version, tables: [...]}}`): {what}")]
    Shape {
        /// `ERT` or `ART`.
        root: &'static str,
        /// What the parser says, with line and column.
        what: String,
    },
    /// A version with another meaning.
    #[error("`{root}.version` is {version}: versions 0.3 and 0.4 are understood")]
    Version {
        /// `ERT` or `ART`.
        root: &'static str,
        /// The version.
        version: String,
    },
    /// Components without which nothing can be priced.
    #[error(
        "`{root}.tables` has no {missing}: name the components of the design after them, or add \
         them (docs/energy.md lists all)"
    )]
    Components {
        /// `ERT` or `ART`.
        root: &'static str,
        /// Their names.
        missing: String,
    },
    /// Two components with the same last part of the name.
    #[error("`{root}.tables` has two components `{component}`: {first} and {second}")]
    Twice {
        /// `ERT` or `ART`.
        root: &'static str,
        /// Last part of the name.
        component: String,
        /// The whole name of one.
        first: String,
        /// The whole name of the other.
        second: String,
    },
    /// Actions without which nothing can be priced.
    #[error(
        "the component {component} has no action {missing}: give {it} one, with energy 0 if it \
         costs nothing"
    )]
    Actions {
        /// The whole name.
        component: String,
        /// The actions.
        missing: String,
        /// How the sentence refers to the component.
        it: &'static str,
    },
    /// An action that is listed with several energies.
    #[error(
        "the component {component} has the action `{action}` {times} times: leave one, with the \
         energy that is meant; arguments other than `bytes` have no meaning here"
    )]
    ActionTwice {
        /// The whole name of the component.
        component: String,
        /// The action.
        action: String,
        /// How often.
        times: usize,
    },
    /// A number that is no energy or area.
    #[error(
        "{component}: {what} = {value:?} must be zero or more, and at most 1e15: a typing error?"
    )]
    Number {
        /// The whole name of the component.
        component: String,
        /// What it is.
        what: String,
        /// The number.
        value: f64,
    },
}

/// The part of a file that says what components cost.
struct AccelergyTables<T> {
    version: String,
    tables: Vec<T>,
}

struct ErtTable {
    name: String,
    actions: Vec<ErtAction>,
}

struct ErtAction {
    name: String,
    energy: f64,
    /// The only argument with a meaning here; the others are of Accelergy's own.
    bytes: Option<f64>,
}

struct ArtTable {
    name: String,
    area: f64,
}

impl ErtTable {
    fn read(node: &YamlNode) -> Result<Self, String> {
        let name = node.get("name")?.text()?.to_owned();
        let actions = node.get("actions")?.list()?.iter().map(ErtAction::read);
        Ok(ErtTable { name, actions: actions.collect::<Result<_, _>>()? })
    }
}

impl ErtAction {
    fn read(node: &YamlNode) -> Result<Self, String> {
        let name = node.get("name")?.text()?.to_owned();
        let energy = node.get("energy")?.number()?;
        let there = |node: &&YamlNode| !node.is_null();
        let bytes = match node.find("arguments")?.filter(there) {
            Some(arguments) => arguments.find("bytes")?.filter(there).map(YamlNode::number),
            None => None,
        };
        Ok(ErtAction { name, energy, bytes: bytes.transpose()? })
    }
}

impl ArtTable {
    fn read(node: &YamlNode) -> Result<Self, String> {
        Ok(ArtTable {
            name: node.get("name")?.text()?.to_owned(),
            area: node.get("area")?.number()?,
        })
    }
}

/// The last part of a component's name, without its range: `chip.ccu[0..3]` is `ccu`.
fn short(name: &str) -> String {
    let last = name.rsplit('.').find(|part| part.starts_with(|c: char| c.is_ascii_alphabetic()));
    let last = last.unwrap_or(name);
    last.split('[').next().unwrap_or(last).replace('-', "_").to_ascii_lowercase()
}

fn read<T>(
    text: &str,
    root: &'static str,
    table: impl Fn(&YamlNode) -> Result<T, String>,
) -> Result<AccelergyTables<T>, AccelergyError> {
    if text.len() > TEXT_MAX {
        return Err(AccelergyError::TooLong);
    }
    let tables = || {
        let file = yaml::parse(text)?;
        let body = file.get(root)?;
        let version = body.get("version")?.label()?;
        let tables =
            body.get("tables")?.list()?.iter().map(&table).collect::<Result<_, String>>()?;
        Ok(AccelergyTables { version, tables })
    };
    tables().map_err(|what| AccelergyError::Shape { root, what })
}

/// Tables by the last part of their name; those whose name is not wanted are left out.
fn by_name<T>(
    root: &'static str,
    file: AccelergyTables<T>,
    known: &[&str],
    name: impl Fn(&T) -> &str,
) -> Result<BTreeMap<String, T>, AccelergyError> {
    let version = file.version;
    if !["0.3", "0.4"].contains(&version.as_str()) {
        return Err(AccelergyError::Version { root, version });
    }
    let mut found: BTreeMap<String, T> = BTreeMap::new();
    for table in file.tables {
        let component = short(name(&table));
        if !known.contains(&component.as_str()) {
            continue;
        }
        if let Some(first) = found.get(&component) {
            let (first, second) = (name(first).to_owned(), name(&table).to_owned());
            return Err(AccelergyError::Twice { root, component, first, second });
        }
        found.insert(component, table);
    }
    Ok(found)
}

fn missing<T>(
    root: &'static str,
    found: &BTreeMap<String, T>,
    needed: &[&str],
) -> Result<(), AccelergyError> {
    let missing: Vec<String> =
        needed.iter().filter(|n| !found.contains_key(**n)).map(|n| format!("`{n}`")).collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(AccelergyError::Components { root, missing: missing.join(", ") })
}

impl ErtTable {
    /// The energies of these actions, per byte where an action says for how many bytes it is.
    fn energies(&self, actions: &[&str]) -> Result<Vec<f64>, AccelergyError> {
        let find = |wanted: &str| self.actions.iter().find(|a| same(&a.name, wanted));
        for &wanted in actions {
            let times = self.actions.iter().filter(|a| same(&a.name, wanted)).count();
            if times > 1 {
                let (component, action) = (self.name.clone(), words(wanted));
                return Err(AccelergyError::ActionTwice { component, action, times });
            }
        }
        let missing: Vec<String> = actions
            .iter()
            .filter(|wanted| find(wanted).is_none())
            .map(|wanted| format!("`{}`", words(wanted)))
            .collect();
        if !missing.is_empty() {
            let (component, missing) = (self.name.clone(), missing.join(", "));
            return Err(AccelergyError::Actions { component, missing, it: "it" });
        }
        let energy = |&wanted: &&str| {
            let action = find(wanted).expect("nothing is missing");
            let what = format!("energy of `{}`", words(wanted));
            let energy = number(&self.name, &what, action.energy)?;
            let Some(bytes) = action.bytes else { return Ok(energy) };
            let bytes = number(&self.name, "argument `bytes`", bytes)?;
            number(&self.name, "energy per byte", energy / bytes)
        };
        actions.iter().map(energy).collect()
    }
}

/// A key of ours as reference tables write it.
fn words(key: &str) -> String {
    key.replace('-', "_")
}

fn same(name: &str, wanted: &str) -> bool {
    words(name).eq_ignore_ascii_case(&words(wanted))
}

/// The largest number that is believed, pJ or square micrometres: sums stay finite.
const MOST: f64 = 1e15;

fn number(component: &str, what: &str, value: f64) -> Result<f64, AccelergyError> {
    if (0.0..=MOST).contains(&value) {
        return Ok(value);
    }
    let (component, what) = (component.to_owned(), what.to_owned());
    Err(AccelergyError::Number { component, what, value })
}

fn action(pj: f64) -> ActionPrice {
    let energy = (pj > 0.0).then_some(Picojoules(pj));
    ActionPrice { energy, flops: None, free: pj == 0.0, source: SOURCE.into() }
}

fn byte(pj: f64) -> BytePrice {
    BytePrice { energy: PicojoulesPerByte(pj), free: pj == 0.0, source: SOURCE.into() }
}

fn power(watts: f64) -> PowerPrice {
    PowerPrice { power: Watts(watts), free: watts == 0.0, source: SOURCE.into() }
}

/// No DRAM costs more, pJ a byte: LPDDR4 takes some 40 to 75.
const DRAM_MOST: f64 = 100.0;

/// No DRAM costs less, pJ a byte, unless it is free: stacked ones take some 4.
const DRAM_LEAST: f64 = 0.1;

/// What is odd about a table: a price of a byte of DRAM that is none. In a reference table the
/// price of a word may be taken for it; in any table a price may be in joules.
pub fn doubt<C>(table: &EnergyTable<C>) -> Option<String> {
    let flat = table.dram.flat.as_ref()?;
    let name = &table.name;
    let prices = || [&flat.read, &flat.write].into_iter().filter(|price| price.energy.0 > 0.0);
    let order = |a: &&BytePrice, b: &&BytePrice| a.energy.0.total_cmp(&b.energy.0);
    let (cheapest, dearest) = (prices().min_by(order)?, prices().max_by(order)?);
    if cheapest.energy.0 < DRAM_LEAST {
        return Some(format!(
            "energy table `{name}`: a byte of DRAM costs {:e} pJ, where LPDDR4 takes 40 to 75; if \
             its prices are in joules, multiply them by 1e12: here they are in pJ",
            cheapest.energy.0
        ));
    }
    let is_odd = dearest.source == SOURCE && dearest.energy.0 > DRAM_MOST;
    is_odd.then(|| {
        format!(
            "energy table `{name}`: a byte of `dram` costs {} pJ, where LPDDR4 takes 40 to 75; if \
             that is the price of a 64-bit word, say so: `arguments: {{bytes: 8}}` at `read` and \
             `write`",
            dearest.energy.0
        )
    })
}

/// Reads the text of an ERT, and of an ART if there is one, for a machine with this clock:
/// Accelergy gives leakage as energy per cycle.
///
/// # Errors
/// An [`AccelergyError`] says which component or action is missing or wrong.
pub fn table<C: Catalogue>(
    name: &str,
    ert: &str,
    art: Option<&str>,
    clock: Hertz,
) -> Result<EnergyTable<C>, AccelergyError> {
    let known = components::<C>();
    let found = by_name("ERT", read(ert, "ERT", ErtTable::read)?, &known, |t| &t.name)?;
    missing("ERT", &found, &[DRAM])?;
    let areas =
        art.map(|text| areas(text, &known, found.keys().map(String::as_str))).transpose()?;
    let watts = |pj_per_cycle: f64| pj_per_cycle * 1e-12 * clock.0;
    let (mut actions, mut leakage) = (BTreeMap::new(), BTreeMap::new());
    for (id, unit) in units::<C>() {
        let Some(component) = found.get(unit.key) else { continue };
        let own = C::hardware().actions().filter_map(|(_, does)| match does {
            Does::Work(stage, work) if stage == id && work.unpriced == Unpriced::Never => {
                Some(work.key)
            }
            _ => None,
        });
        let own: Vec<&str> = own.chain(["leak"]).collect();
        for (key, pj) in own.iter().zip(component.energies(&own)?) {
            match *key {
                "leak" => _ = leakage.insert(unit.key.to_owned(), power(watts(pj))),
                key => _ = actions.insert(key.to_owned(), action(pj)),
            }
        }
    }
    let dram = found[DRAM].energies(&["read", "write", "leak", "refresh"])?;
    let flat = FlatDram {
        read: byte(dram[0]),
        write: byte(dram[1]),
        background: power(watts(dram[2])),
        refresh: power(watts(dram[3])),
        channels: None,
    };
    Ok(EnergyTable {
        name: name.to_owned(),
        description: "read from an energy reference table of Accelergy".into(),
        node: None,
        scaling: None,
        scope: None,
        flop: None,
        actions: actions.into(),
        clock: None,
        numbers: None,
        sram: SramPrices {
            flat: None,
            table: None,
            cacti: None,
            macros: Some(macros::<C>(&found, areas.as_ref(), clock)?),
        },
        dram: DramPrices { flat: Some(flat), device: false, row_hits: None },
        leakage: leakage.into(),
        area: areas.as_ref().map(unit_area::<C>),
        parts: None,
        phy: None,
        supply: None,
        idle: None,
    })
}

/// The banks of the buffers.
fn macros<C: Catalogue>(
    found: &BTreeMap<String, ErtTable>,
    areas: Option<&BTreeMap<String, SquareMillimetres>>,
    clock: Hertz,
) -> Result<Vec<SramMacro>, AccelergyError> {
    let mut macros = Vec::new();
    for (_, buffer) in C::hardware().buffers() {
        let Some(component) = found.get(buffer.name) else { continue };
        let energies = component.energies(&["read", "write", "leak"])?;
        macros.push(SramMacro {
            buffer: buffer.key(),
            read: Picojoules(energies[0]),
            write: Picojoules(energies[1]),
            leakage: Watts(energies[2] * 1e-12 * clock.0),
            area: areas.map(|a| a[buffer.name]),
            source: SOURCE.into(),
        });
    }
    Ok(macros)
}

/// The areas of what is on the chip, of all components that have energies.
fn areas<'a>(
    text: &str,
    known: &[&str],
    has: impl Iterator<Item = &'a str>,
) -> Result<BTreeMap<String, SquareMillimetres>, AccelergyError> {
    let found = by_name("ART", read(text, "ART", ArtTable::read)?, known, |t| &t.name)?;
    missing("ART", &found, &has.filter(|name| *name != DRAM).collect::<Vec<_>>())?;
    let area = |(name, table): (String, ArtTable)| {
        Ok((name, SquareMillimetres(number(&table.name, "area", table.area)? * 1e-6)))
    };
    found.into_iter().map(area).collect()
}

/// Areas of the units. Accelergy gives those of whole macros, and no area for the rest of the chip.
fn unit_area<C: Catalogue>(areas: &BTreeMap<String, SquareMillimetres>) -> UnitArea<C> {
    let price = |area: &SquareMillimetres| AreaPrice { area: *area, source: SOURCE.into() };
    let of = |(_, unit): (StageId, &StageFacts)| {
        Some((unit.key.to_owned(), price(areas.get(unit.key)?)))
    };
    UnitArea {
        units: units::<C>().filter_map(of).collect(),
        sram_overhead: Overhead { factor: 1.0, source: SOURCE.into() },
        rest: RestArea { share: 0.0, source: SOURCE.into() },
    }
}
