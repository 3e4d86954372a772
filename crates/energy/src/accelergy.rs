//! Energy and area reference tables of Accelergy (ERT and ART, version 0.4) as an energy table.
//!
//! A component is found by the last part of its name, without a range: `system.chip.ccu[0..3]` is
//! `ccu`. Energies are in pJ, areas in um². `docs/energy.md` lists components and actions, and what
//! each is mapped to.

use std::collections::BTreeMap;

use yaml::YamlNode;

use super::table::{
    ActionPrice, ActionPrices, AreaPrice, BytePrice, DramPrices, EnergyTable, FlatDram, Overhead,
    PowerPrice, RestArea, SramMacro, SramPrices, UnitArea, UnitLeakage,
};
use crate::action::Buffer;
use powergs_base::quantity::{Hertz, Picojoules, PicojoulesPerByte, SquareMillimetres, Watts};

mod yaml;

/// The longest text that is looked at, bytes.
pub const TEXT_MAX: usize = 1 << 20;

/// Components that a machine may do without.
const OPTIONAL: [&str; 4] = ["cache", "pointers", "combining", "codebook"];
/// Components that must be there.
const NEEDED: [&str; 10] = [
    "ccu",
    "qsu",
    "bsu",
    "vru",
    "gaussian_in",
    "tile_list",
    "sorting",
    "feature",
    "pixel_out",
    "dram",
];

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
    name: impl Fn(&T) -> &str,
) -> Result<BTreeMap<String, T>, AccelergyError> {
    let version = file.version;
    if !["0.3", "0.4"].contains(&version.as_str()) {
        return Err(AccelergyError::Version { root, version });
    }
    let mut found: BTreeMap<String, T> = BTreeMap::new();
    for table in file.tables {
        let component = short(name(&table));
        if !NEEDED.contains(&component.as_str()) && !OPTIONAL.contains(&component.as_str()) {
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
    fn energies<const N: usize>(&self, actions: [&str; N]) -> Result<[f64; N], AccelergyError> {
        let find = |wanted: &str| self.actions.iter().find(|a| same(&a.name, wanted));
        for wanted in actions {
            let times = self.actions.iter().filter(|a| same(&a.name, wanted)).count();
            if times > 1 {
                let (component, action) = (self.name.clone(), wanted.to_owned());
                return Err(AccelergyError::ActionTwice { component, action, times });
            }
        }
        let missing: Vec<String> = actions
            .iter()
            .filter(|wanted| find(wanted).is_none())
            .map(|wanted| format!("`{wanted}`"))
            .collect();
        if !missing.is_empty() {
            let (component, missing) = (self.name.clone(), missing.join(", "));
            return Err(AccelergyError::Actions { component, missing, it: "it" });
        }
        let mut values = [0.0; N];
        for (value, wanted) in values.iter_mut().zip(actions) {
            let action = find(wanted).expect("nothing is missing");
            *value = number(&self.name, &format!("energy of `{wanted}`"), action.energy)?;
            if let Some(bytes) = action.bytes {
                let bytes = number(&self.name, "argument `bytes`", bytes)?;
                *value = number(&self.name, "energy per byte", *value / bytes)?;
            }
        }
        Ok(values)
    }
}

fn same(name: &str, wanted: &str) -> bool {
    name.replace('-', "_").eq_ignore_ascii_case(wanted)
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

/// What is odd about a table that was read from a reference table: a price of a word of DRAM that
/// is taken for that of a byte.
pub fn doubt(table: &EnergyTable) -> Option<String> {
    let flat = table.dram.flat.as_ref()?;
    let dearest = [&flat.read, &flat.write].into_iter().max_by(|a, b| {
        let [a, b] = [a, b].map(|price| price.energy.0);
        a.total_cmp(&b)
    })?;
    let is_odd = dearest.source == SOURCE && dearest.energy.0 > DRAM_MOST;
    is_odd.then(|| {
        format!(
            "energy table `{}`: a byte of `dram` costs {} pJ, where LPDDR4 takes 40 to 75; if that \
             is the price of a 64-bit word, say so: `arguments: {{bytes: 8}}` at `read` and \
             `write`",
            table.name, dearest.energy.0
        )
    })
}

/// Reads the text of an ERT, and of an ART if there is one, for a machine with this clock:
/// Accelergy gives leakage as energy per cycle.
///
/// # Errors
/// An [`AccelergyError`] says which component or action is missing or wrong.
pub fn table(
    name: &str,
    ert: &str,
    art: Option<&str>,
    clock: Hertz,
) -> Result<EnergyTable, AccelergyError> {
    let found = by_name("ERT", read(ert, "ERT", ErtTable::read)?, |t| &t.name)?;
    missing("ERT", &found, &NEEDED)?;
    let areas = match art {
        Some(text) => {
            let has = OPTIONAL.into_iter().filter(|component| found.contains_key(*component));
            Some(areas(text, has)?)
        }
        None => None,
    };
    let watts = |pj_per_cycle: f64| pj_per_cycle * 1e-12 * clock.0;
    let [cull, project, obb_prepare, obb_test, sh_colour, ccu] = found["ccu"].energies([
        "cull",
        "project",
        "obb_prepare",
        "obb_test",
        "sh_colour",
        "leak",
    ])?;
    let [pivot_key, qsu] = found["qsu"].energies(["pivot_key", "leak"])?;
    let [compare_exchange, bsu] = found["bsu"].energies(["compare_exchange", "leak"])?;
    let [alpha, blend, pixel_finish, queue_entry, vru] =
        found["vru"].energies(["alpha", "blend", "pixel_finish", "queue_entry", "leak"])?;
    let [read, write, background, refresh] =
        found["dram"].energies(["read", "write", "leak", "refresh"])?;
    let actions = ActionPrices {
        cull: action(cull),
        project: action(project),
        obb_prepare: action(obb_prepare),
        obb_test: action(obb_test),
        sh_colour: action(sh_colour),
        pivot_key: action(pivot_key),
        compare_exchange: action(compare_exchange),
        sorted_row: None,
        merged_row: None,
        alpha: action(alpha),
        stopped_pixel: None,
        blend: action(blend),
        pixel_finish: action(pixel_finish),
        queue_entry: action(queue_entry),
    };
    let flat = FlatDram {
        read: byte(read),
        write: byte(write),
        background: power(watts(background)),
        refresh: power(watts(refresh)),
        channels: None,
    };
    let [ccu, qsu, bsu, vru] = [ccu, qsu, bsu, vru].map(|leak| power(watts(leak)));
    Ok(EnergyTable {
        name: name.to_owned(),
        description: "read from an energy reference table of Accelergy".into(),
        node: None,
        scaling: None,
        flop: None,
        actions,
        clock: None,
        numbers: None,
        sram: SramPrices {
            flat: None,
            table: None,
            cacti: None,
            macros: Some(macros(&found, areas.as_ref(), clock)?),
        },
        dram: DramPrices { flat: Some(flat), device: false },
        leakage: UnitLeakage { ccu, qsu, bsu, vru },
        area: areas.as_ref().map(unit_area),
        parts: None,
        phy: None,
        supply: None,
    })
}

/// The banks of the buffers.
fn macros(
    found: &BTreeMap<String, ErtTable>,
    areas: Option<&BTreeMap<String, SquareMillimetres>>,
    clock: Hertz,
) -> Result<Vec<SramMacro>, AccelergyError> {
    let mut macros = Vec::new();
    for buffer in Buffer::ALL {
        let Some(component) = found.get(buffer.name()) else { continue };
        let [read, write, leak] = component.energies(["read", "write", "leak"])?;
        macros.push(SramMacro {
            buffer: buffer.name().replace('_', "-"),
            read: Picojoules(read),
            write: Picojoules(write),
            leakage: Watts(leak * 1e-12 * clock.0),
            area: areas.map(|a| a[buffer.name()]),
            source: SOURCE.into(),
        });
    }
    Ok(macros)
}

fn areas(
    text: &str,
    optional: impl Iterator<Item = &'static str>,
) -> Result<BTreeMap<String, SquareMillimetres>, AccelergyError> {
    let found = by_name("ART", read(text, "ART", ArtTable::read)?, |t| &t.name)?;
    let on_chip = NEEDED.into_iter().filter(|n| *n != "dram").chain(optional);
    missing("ART", &found, &on_chip.collect::<Vec<_>>())?;
    let area = |(name, table): (String, ArtTable)| {
        Ok((name, SquareMillimetres(number(&table.name, "area", table.area)? * 1e-6)))
    };
    found.into_iter().map(area).collect()
}

/// Areas of the units. Accelergy gives those of whole macros, and no area for the rest of the chip.
fn unit_area(areas: &BTreeMap<String, SquareMillimetres>) -> UnitArea {
    let of = |unit: &str| AreaPrice { area: areas[unit], source: SOURCE.into() };
    UnitArea {
        ccu: of("ccu"),
        qsu: of("qsu"),
        bsu: of("bsu"),
        vru: of("vru"),
        sram_overhead: Overhead { factor: 1.0, source: SOURCE.into() },
        rest: RestArea { share: 0.0, source: SOURCE.into() },
    }
}
