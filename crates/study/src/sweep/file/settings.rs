//! Tables of dotted keys, written with quotes, with dots or as tables within tables.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use toml::{Table, Value};

use super::RangeSpec;

/// How deep tables may nest.
const DEPTH_MAX: usize = 16;

/// A value as it was written.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(transparent)]
pub struct Raw(pub Value);

impl JsonSchema for Raw {
    fn schema_name() -> Cow<'static, str> {
        "Raw".into()
    }

    fn inline_schema() -> bool {
        true
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "x-unit": "as the key says" })
    }
}

/// Dotted keys with their values, in the order of the file. `"vru.cores" = 4`, `vru.cores = 4` and
/// `vru = { cores = 4 }` are the same.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Settings(pub Vec<(String, Value)>);

/// Dotted keys with their lists of values or rows of numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Zip(pub Vec<(String, ZipValues)>);

/// The values of one key.
#[derive(Debug, Clone, PartialEq)]
pub enum ZipValues {
    /// As they are.
    List(Vec<Value>),
    /// A row of numbers.
    Range(Box<RangeSpec>),
}

/// Puts the leaves of `table` behind `found`, with their dotted keys.
fn flatten(
    table: Table,
    prefix: &str,
    depth: usize,
    is_leaf: &dyn Fn(&Table) -> bool,
    found: &mut Vec<(String, Value)>,
) -> Result<(), String> {
    if depth > DEPTH_MAX {
        return Err(format!("`{prefix}` is more than {DEPTH_MAX} tables deep"));
    }
    for (key, value) in table {
        let key = if prefix.is_empty() { key } else { format!("{prefix}.{key}") };
        match value {
            Value::Table(inner) if !is_leaf(&inner) => {
                flatten(inner, &key, depth + 1, is_leaf, found)?;
            }
            value => found.push((key, value)),
        }
    }
    Ok(())
}

impl<'de> Deserialize<'de> for Settings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut found = Vec::new();
        flatten(Table::deserialize(deserializer)?, "", 0, &|_| false, &mut found)
            .map_err(serde::de::Error::custom)?;
        Ok(Settings(found))
    }
}

impl<'de> Deserialize<'de> for Zip {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let mut found = Vec::new();
        let is_range = |t: &Table| t.contains_key("from");
        flatten(Table::deserialize(deserializer)?, "", 0, &is_range, &mut found)
            .map_err(serde::de::Error::custom)?;
        let row = |(key, value): (String, Value)| {
            let row = match value {
                Value::Array(values) => ZipValues::List(values),
                table @ Value::Table(_) => {
                    let range = table.try_into();
                    ZipValues::Range(range.map_err(|e| format!("`{key}`: {}", first_line(&e)))?)
                }
                _ => return Err(format!("`{key}` must be a list or a range")),
            };
            Ok((key, row))
        };
        let rows = found.into_iter().map(row).collect::<Result<_, String>>();
        rows.map(Zip).map_err(serde::de::Error::custom)
    }
}

fn first_line(error: &toml::de::Error) -> String {
    error.message().lines().next().unwrap_or_default().to_owned()
}

impl Serialize for Settings {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.iter().cloned().collect::<Table>().serialize(serializer)
    }
}

impl Serialize for Zip {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let value = |row: &ZipValues| match row {
            ZipValues::List(values) => Value::Array(values.clone()),
            ZipValues::Range(range) => Value::try_from(range).unwrap_or(Value::Boolean(false)),
        };
        let table: Table = self.0.iter().map(|(key, row)| (key.clone(), value(row))).collect();
        table.serialize(serializer)
    }
}

macro_rules! open_table {
    ($t:ident, $unit:literal) => {
        impl JsonSchema for $t {
            fn schema_name() -> Cow<'static, str> {
                stringify!($t).into()
            }

            fn inline_schema() -> bool {
                true
            }

            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!({
                    "type": "object",
                    "additionalProperties": { "x-unit": $unit },
                })
            }
        }
    };
}
open_table!(Settings, "as the key says");
open_table!(Zip, "a list or a range");
