//! `arch diff`: the keys in which two files differ.

use std::collections::BTreeSet;

use serde_json::{Map, Value as Json, json};
use toml::{Table, Value};

use super::{Kind, open};
use crate::cli::failure::ConfigUsage;
use crate::cli::{Context, Exit, Failure, out};
use powergs_base::config::knob::shown;
use powergs_core::machine::Machine;
use powergs_core::run::RunError;
use powergs_report::document::{Column, Document, Table as Rows};

/// A key with what two files have for it; `None` where one does not have it.
pub type DifferentKey = (String, [Option<String>; 2]);

/// The keys in which two files of one kind differ, without names and descriptions.
///
/// # Errors
/// Exit code 2: a file that cannot be read.
pub fn differences(a: &str, b: &str) -> Result<Vec<DifferentKey>, Failure> {
    let [(_, mine), (_, theirs)] = [read(a)?, read(b)?];
    let keys: BTreeSet<&String> = mine.keys().chain(theirs.keys()).collect();
    let keys = keys.into_iter().filter(|key| {
        mine.get(*key) != theirs.get(*key)
            && !["base", "name", "description"].contains(&key.as_str())
    });
    let text = |keys: &Map<String, Json>, key: &str| match keys.get(key) {
        Some(Json::String(text)) => Some(text.clone()),
        other => other.map(Json::to_string),
    };
    Ok(keys.map(|key| (key.clone(), [text(&mine, key), text(&theirs, key)])).collect())
}

/// Runs `arch diff`.
pub fn run(a: &str, b: &str, context: &Context) -> Result<Exit, Failure> {
    let [(kind, mine), (other, theirs)] = [read(a)?, read(b)?];
    if kind != other {
        let what = format!("{a} is a {} file, {b} is a {} file", kind.name(), other.name());
        return Err(Failure::new(Exit::Usage, format!("{what}: they have no keys in common")));
    }
    let mut keys: Vec<&String> = mine.keys().chain(theirs.keys()).collect();
    let mut seen = BTreeSet::new();
    keys.retain(|key| seen.insert(*key) && mine.get(*key) != theirs.get(*key));
    if context.global.json {
        let of = |key: &String| json!({ "key": key, "a": mine.get(key), "b": theirs.get(key) });
        out::json(&keys.into_iter().map(of).collect::<Vec<_>>())?;
    } else {
        let text = |value: Option<&Json>| match value {
            Some(Json::String(text)) => text.clone(),
            Some(other) => other.to_string(),
            None => "-".to_owned(),
        };
        let columns = [Column::text("key"), Column::text(a).wraps(), Column::text(b).wraps()];
        // Every file has one of its own, and it says what the other rows do.
        let shown = keys.into_iter().filter(|key| *key != "description");
        let rows = shown.map(|key| {
            [key.as_str().into(), text(mine.get(key)).into(), text(theirs.get(key)).into()]
        });
        let mut page = Document::new();
        page.table(Rows::new(columns).rows(rows));
        out::document(&page)?;
    }
    Ok(Exit::Done)
}

/// What a file is, and its keys with what they are set to, bases and all.
fn read(name: &str) -> Result<(Kind, Map<String, Json>), Failure> {
    let (file, kind) = open(name)?;
    let table: Table =
        file.text.parse().map_err(|e: toml::de::Error| RunError::config(&file.origin, e))?;
    let mut keys = Map::new();
    flatten(&Value::Table(table), String::new(), &mut keys);
    if kind == Kind::Machine {
        // What a base says of a part that the machine does not have is no difference.
        let machine = Machine::parse(&file.text).usage(&file.origin)?;
        keys.retain(|key, _| !machine.leaves_out(key));
    }
    Ok((kind, keys))
}

fn flatten(value: &Value, path: String, keys: &mut Map<String, Json>) {
    let Value::Table(table) = value else {
        keys.insert(path, Json::String(shown(value)));
        return;
    };
    for (key, value) in table {
        let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
        flatten(value, path, keys);
    }
}
