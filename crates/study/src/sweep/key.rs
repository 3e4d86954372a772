//! Keys that can be varied, and what values they take: those of machine files, and behind
//! `energy:`, `dram:` and `display:` those of the other files.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::LazyLock;

use serde_json::Value as Schema;
use toml::{Table, Value};

use super::expr;
use super::measure::{Measure, twelve_digits};
use powergs_base::config::layer::NONE;
use powergs_base::config::schema::{self, schema_of};
use powergs_base::config::suggest::nearest;
use powergs_core::machine::Machine;
use powergs_core::stage::EnergyTable;
use powergs_dram::Device;
use powergs_frame::display::Display;

pub use powergs_core::run::FileKind;

/// A key of a file.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key {
    /// Which file has it.
    pub file: FileKind,
    /// Dotted path; `[]` behind a list stands for each of its items. In the machine file, `machine`
    /// is the base machine itself.
    pub path: String,
}

/// The key that stands for the base machine.
pub const MACHINE: &str = "machine";

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.file.prefix(), self.path)
    }
}

/// What values a key takes.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Domain {
    /// Whole numbers from and to.
    Integer(f64, f64),
    /// Numbers from and to; the first itself is out where the last is true.
    Number(f64, f64, bool),
    Truth,
    Choice(Vec<String>),
    Measure(Measure),
    Text,
    /// A list, as it is written.
    List,
    /// A table that may be absent: `"none"` takes it away, its keys are keys of their own.
    Part,
}

/// All keys of all files.
static CATALOGUE: LazyLock<BTreeMap<String, (Key, Domain)>> = LazyLock::new(|| {
    let mut all = BTreeMap::new();
    for kind in FileKind::ALL {
        let root = match kind {
            FileKind::Machine => schema_of::<Machine>(),
            FileKind::Energy => schema_of::<EnergyTable>(),
            FileKind::Dram => schema_of::<Device>(),
            FileKind::Display => schema_of::<Display>(),
        };
        for (path, leaf) in schema::leaves(&root) {
            let key = Key { file: kind, path };
            all.insert(key.to_string(), (key, domain(&leaf)));
        }
        let parts = match kind {
            FileKind::Machine => Machine::optional_tables(),
            FileKind::Energy | FileKind::Dram | FileKind::Display => schema::optional_tables(&root),
        };
        for path in parts {
            let key = Key { file: kind, path };
            all.entry(key.to_string()).or_insert((key, Domain::Part));
        }
    }
    let machine = Key { file: FileKind::Machine, path: MACHINE.to_owned() };
    all.insert(MACHINE.to_owned(), (machine, Domain::Text));
    all
});

fn domain(leaf: &Schema) -> Domain {
    let choices = schema::choices(leaf);
    if !choices.is_empty() {
        return Domain::Choice(choices.into_iter().map(str::to_owned).collect());
    }
    let kind = match leaf.get("type") {
        Some(Schema::Array(kinds)) => kinds.first().and_then(Schema::as_str).unwrap_or(""),
        Some(kind) => kind.as_str().unwrap_or(""),
        None => "",
    };
    let bound = |key: &str, other: f64| leaf.get(key).and_then(Schema::as_f64).unwrap_or(other);
    let most = bound("maximum", f64::MAX);
    let above = leaf.get("exclusiveMinimum").is_some();
    let least = bound(if above { "exclusiveMinimum" } else { "minimum" }, -f64::MAX);
    match kind {
        "integer" => Domain::Integer(least, most),
        "number" => Domain::Number(least, most, above),
        "boolean" => Domain::Truth,
        "array" => Domain::List,
        _ => match leaf.get("x-unit").and_then(Schema::as_str) {
            Some(unit) => Measure::ALL
                .into_iter()
                .find(|m| unit.starts_with(&format!("{} (", m.name())))
                .map_or(Domain::Text, Domain::Measure),
            None => Domain::Text,
        },
    }
}

impl Key {
    /// Finds a key; no suggestion if there is none.
    pub(super) fn known(name: &str) -> Option<(&'static Key, &'static Domain)> {
        CATALOGUE.get(name).map(|(key, domain)| (key, domain))
    }

    /// Finds a key.
    ///
    /// # Errors
    /// That there is none, with the nearest one.
    pub fn find(name: &str) -> Result<&'static Key, String> {
        if let Some((key, _)) = Key::known(name) {
            return Ok(key);
        }
        Err(format!("unknown key `{}`; {}", name.chars().take(80).collect::<String>(), hint(name)))
    }

    /// The key of this name, if there is one.
    pub fn of(name: &str) -> Option<&'static Key> {
        Key::known(name).map(|(key, _)| key)
    }

    /// The names of all keys; tables that may be absent are not among them.
    pub fn all() -> impl Iterator<Item = &'static str> {
        let keys = CATALOGUE.iter().filter(|(_, (_, domain))| *domain != Domain::Part);
        keys.map(|(name, _)| name.as_str())
    }

    /// What its values measure; `None` for plain numbers and words.
    pub fn measure(&self) -> Option<Measure> {
        match self.domain() {
            Domain::Measure(measure) => Some(*measure),
            _ => None,
        }
    }

    pub(super) fn domain(&self) -> &'static Domain {
        let key = self.to_string();
        &CATALOGUE.get(&key).expect("keys come from the catalogue").1
    }

    /// Whether it is a table that may be absent.
    pub(super) fn is_part(&self) -> bool {
        *self.domain() == Domain::Part
    }

    /// Whether it is the base machine itself.
    pub(crate) fn is_machine(&self) -> bool {
        self.file == FileKind::Machine && self.path == MACHINE
    }
}

fn hint(name: &str) -> String {
    if let Some(near) = nearest(name, Key::all()) {
        return format!("did you mean `{near}`?");
    }
    let last = name.rsplit(['.', ':']).next().unwrap_or(name);
    let same = Key::all().find(|k| k.rsplit(['.', ':']).next() == Some(last));
    let same = same.or_else(|| {
        let lasts = Key::all().filter_map(|k| k.rsplit(['.', ':']).next());
        let near = nearest(last, lasts)?;
        Key::all().find(|k| k.rsplit(['.', ':']).next() == Some(near))
    });
    match same {
        Some(other) => format!("did you mean `{other}`?"),
        None => "`explain` lists all keys; those of other files begin with `energy:`, `dram:` or \
                 `display:`"
            .to_owned(),
    }
}

impl Domain {
    /// A value as the key takes it, written the one way that files are written.
    pub(super) fn read(&self, value: &Value) -> Result<Value, String> {
        match (self, value) {
            (Domain::Integer(least, most), Value::Integer(n)) => {
                within(*n as f64, *least, *most, false).map(|()| value.clone())
            }
            (Domain::Integer(..), Value::Float(n)) if n.fract() == 0.0 && n.abs() < 1e15 => {
                self.read(&Value::Integer(*n as i64))
            }
            (Domain::Integer(..), other) => Err(format!("must be a whole number, not {other}")),
            (Domain::Number(..), Value::Integer(n)) => self.read(&Value::Float(*n as f64)),
            (Domain::Number(least, most, above), Value::Float(n)) => {
                within(*n, *least, *most, *above).map(|()| value.clone())
            }
            (Domain::Number(..), other) => Err(format!("must be a number, not {other}")),
            (Domain::Truth, Value::Boolean(_)) => Ok(value.clone()),
            (Domain::Truth, other) => Err(format!("must be true or false, not {other}")),
            (Domain::Choice(all), Value::String(text)) if all.contains(text) => Ok(value.clone()),
            (Domain::Choice(all), other) => {
                let given = other.as_str().unwrap_or("");
                let near = nearest(given, all.iter().map(String::as_str));
                let near = near.map_or(String::new(), |n| format!("; did you mean \"{n}\"?"));
                Err(format!("must be one of \"{}\"{near}", all.join("\", \"")))
            }
            (Domain::Measure(measure), Value::String(text)) => {
                measure.write(measure.read(text)?).map(Value::String)
            }
            (Domain::Measure(measure), other) => {
                let units = measure.unit_names();
                let name = measure.name();
                Err(format!("is {name}: write \"{other} UNIT\" with one of {units}"))
            }
            (Domain::Text, Value::String(_)) => Ok(value.clone()),
            (Domain::Text, other) => Err(format!("must be a text in quotes, not {other}")),
            (Domain::List, Value::Array(_)) => Ok(value.clone()),
            (Domain::List, other) => Err(format!("must be a list, not {other}")),
            (Domain::Part, Value::String(text)) if text == NONE => Ok(value.clone()),
            (Domain::Part, other) => Err(format!(
                "is a table: \"{NONE}\" takes it away, its keys are set one by one, and {other} is \
                 neither"
            )),
        }
    }

    /// What came out of an expression, as the key takes it.
    pub(super) fn write(&self, value: &expr::Value) -> Result<Value, String> {
        let value = match (self, value) {
            (Domain::Measure(measure), expr::Value::Number(n)) => {
                return measure.write(*n).map(Value::String);
            }
            (Domain::Integer(..), expr::Value::Number(n)) => {
                // Rounding must not make a fraction of what is whole in decimals.
                let n = twelve_digits(*n);
                if n.fract() != 0.0 || n.abs() >= 1e15 {
                    return Err(format!("is {n}, which is not a whole number: use ceil or floor"));
                }
                Value::Integer(n as i64)
            }
            (_, expr::Value::Number(n)) => Value::Float(*n),
            (_, expr::Value::Text(text)) => Value::String(text.clone()),
            (_, expr::Value::Truth(truth)) => Value::Boolean(*truth),
        };
        self.read(&value)
    }

    /// A value of a file in an expression; `None` for lists.
    pub(super) fn value(&self, value: &Value) -> Option<expr::Value> {
        Some(match (self, value) {
            (_, Value::Integer(n)) => expr::Value::Number(*n as f64),
            (_, Value::Float(n)) => expr::Value::Number(*n),
            (_, Value::Boolean(truth)) => expr::Value::Truth(*truth),
            (Domain::Measure(measure), Value::String(text)) => {
                expr::Value::Number(measure.read(text).ok()?)
            }
            (_, Value::String(text)) => expr::Value::Text(text.clone()),
            _ => return None,
        })
    }

    /// Whether its values have an order.
    pub(super) fn is_ordered(&self) -> bool {
        matches!(self, Domain::Integer(..) | Domain::Number(..) | Domain::Measure(_))
    }
}

fn within(n: f64, least: f64, most: f64, above: bool) -> Result<(), String> {
    if !n.is_finite() {
        return Err("must be a finite number".to_owned());
    }
    if above && n <= least {
        return Err(format!("must be above {least}, not {n}"));
    }
    if n < least {
        return Err(format!("must be at least {least}, not {n}"));
    }
    if n > most {
        return Err(format!("must be at most {most}, not {n}"));
    }
    Ok(())
}

/// The value at a dotted path without lists.
pub(super) fn get<'t>(table: &'t Table, path: &str) -> Option<&'t Value> {
    match path.split_once('.') {
        None => table.get(path),
        Some((first, rest)) => get(table.get(first)?.as_table()?, rest),
    }
}
