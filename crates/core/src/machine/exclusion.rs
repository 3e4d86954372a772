//! Choices that exclude values of other keys: said as data beside the choice, worded here.

use toml::{Table, Value};

use super::Machine;
use super::check::{Contradiction, Found};

/// Values of one key.
#[derive(Debug, Clone, Copy)]
pub enum KeyValues {
    /// One of these, as a machine file writes them without quotes.
    Is(&'static str, &'static [&'static str]),
    /// None of these.
    Not(&'static str, &'static [&'static str]),
    /// Another value than a second key has.
    Unlike(&'static str, &'static str),
}

/// A choice that excludes values of another key.
#[derive(Debug, Clone, Copy)]
pub struct Exclusion {
    /// The choice.
    pub choice: KeyValues,
    /// The value of its key without it; empty where the other key is to be changed.
    pub off: &'static str,
    /// What it excludes.
    pub other: KeyValues,
    /// The value that this key should have; of [`KeyValues::Unlike`] it is that of the second key.
    pub instead: &'static str,
    /// Why.
    pub because: &'static str,
}

/// The value at a path of keys; `None` where a table lacks it.
fn at<'t>(table: &'t Table, key: &str) -> Option<&'t Value> {
    let (tables, last) = key.rsplit_once('.').unwrap_or(("", key));
    let mut tables = tables.split('.').filter(|name| !name.is_empty());
    tables.try_fold(table, |at, name| at.get(name)?.as_table())?.get(last)
}

/// A value as `--set` takes it.
fn plain(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

impl KeyValues {
    /// The key.
    pub const fn key(self) -> &'static str {
        match self {
            KeyValues::Is(key, _) | KeyValues::Not(key, _) | KeyValues::Unlike(key, _) => key,
        }
    }

    /// The value of its key, where a machine has one of these.
    fn holds(self, table: &Table) -> Option<&Value> {
        let value = at(table, self.key())?;
        let holds = match self {
            KeyValues::Is(_, values) => values.contains(&plain(value).as_str()),
            KeyValues::Not(_, values) => !values.contains(&plain(value).as_str()),
            KeyValues::Unlike(_, second) => at(table, second) != Some(value),
        };
        holds.then_some(value)
    }
}

impl Exclusion {
    /// What is wrong with a machine of this table; `None` where nothing is.
    fn broken(&self, table: &Table) -> Option<Contradiction> {
        let (choice, other) = (self.choice.holds(table)?, self.other.holds(table)?);
        let (key, with) = (self.choice.key(), self.other.key());
        let instead = match self.other {
            KeyValues::Unlike(_, second) => at(table, second)?.clone(),
            KeyValues::Is(..) | KeyValues::Not(..) => written(self.instead, other),
        };
        let mut message = format!(
            "`{key}` = {choice} contradicts `{with}` = {other}: {}; set `{with}` = {instead}",
            self.because
        );
        let remedy = (with, plain(&instead));
        if self.off.is_empty() {
            return Some(Contradiction { key: with, message, remedies: vec![remedy] });
        }
        message += &format!(", or `{key}` = {}", written(self.off, choice));
        Some(Contradiction { key, message, remedies: vec![(key, self.off.to_owned()), remedy] })
    }
}

/// A value as a machine file writes it: of the type that the key has now.
fn written(text: &str, like: &Value) -> Value {
    match like {
        Value::String(_) => Value::String(text.to_owned()),
        _ => text.parse().unwrap_or_else(|_| Value::String(text.to_owned())),
    }
}

/// Adds what the stages of a machine exclude.
pub(super) fn check(machine: &Machine, found: &mut Found) {
    let table = machine.table();
    let stages = machine.flow().stages().iter();
    let all = stages.flat_map(|stage| stage.excludes);
    found.extend(all.filter_map(|exclusion| exclusion.broken(&table)));
}
