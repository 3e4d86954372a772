//! From TOML text and `--set key=value` overlays to a value of a configuration type.
//!
//! The text is parsed with spans, the overlays are put on top, the table is checked against the
//! schema ([`super::schema`]), and what remains is deserialized. A wrong value is replaced by a
//! valid one after it was reported, so that one pass finds every problem.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde_json::Value;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{ConfigError, PROBLEMS_MAX, Place, Problem};
use super::schema::schema_once;
pub use walk::ELSEWHERE;
use walk::Walk;

mod walk;

/// The largest configuration text that is looked at, bytes.
pub const TEXT_MAX: usize = 1 << 20;

/// A configuration value that remembers where its keys were written.
#[derive(Debug, Clone)]
pub struct Config<T> {
    /// The value.
    pub value: T,
    places: BTreeMap<String, Place>,
}

impl<T> Config<T> {
    /// A problem with the value of `key`, placed where the key was written.
    pub fn problem(&self, key: &str, message: String) -> Problem {
        let start = Place::of("", 0..0);
        let place = self.places.get(key).cloned().unwrap_or(start);
        Problem { place, key: key.to_owned(), message }
    }

    /// The keys that were written, each with its place, sorted.
    pub fn stated(&self) -> impl Iterator<Item = (&str, &Place)> {
        self.places.iter().map(|(key, place)| (key.as_str(), place))
    }

    /// Whether a key was written.
    pub fn states(&self, key: &str) -> bool {
        self.places.contains_key(key)
    }

    /// The value, if there are no problems with it.
    ///
    /// # Errors
    /// All `problems`, in the order of the file.
    pub fn checked(self, problems: Vec<Problem>) -> Result<T, ConfigError> {
        if problems.is_empty() { Ok(self.value) } else { Err(ConfigError::new(problems)) }
    }
}

/// What is read from a table of TOML, as its schema says.
pub trait Document: Sized {
    /// The schema of such a table; it may depend on what the table says.
    ///
    /// # Errors
    /// The key of the table by which it cannot be told, and why.
    fn schema(table: &DeTable<'_>) -> Result<Arc<Value>, (&'static str, String)>;

    /// The value of a table that has been held against the schema.
    ///
    /// # Errors
    /// Whatever is wrong with it.
    fn read(table: Spanned<DeTable<'_>>) -> Result<Self, toml::de::Error>;
}

impl<T: DeserializeOwned + JsonSchema + 'static> Document for T {
    fn schema(_: &DeTable<'_>) -> Result<Arc<Value>, (&'static str, String)> {
        Ok(schema_once::<T>())
    }

    fn read(table: Spanned<DeTable<'_>>) -> Result<T, toml::de::Error> {
        T::deserialize(toml::Deserializer::from(table))
    }
}

/// Reads a `T` from TOML `text` with `sets` (`dotted.key=value`) on top.
///
/// # Errors
/// Everything that is wrong, each with its place: syntax (the first error only), unknown keys with
/// the nearest known one, missing keys, wrong types, values out of range, unknown units.
pub fn parse<T: Document>(text: &str, sets: &[String]) -> Result<Config<T>, ConfigError> {
    let (config, unknown) = parse_around(text, sets)?;
    if unknown.is_empty() { Ok(config) } else { Err(ConfigError::new(unknown)) }
}

/// As [`parse`], for a value that is looked at further: unknown keys whose absence leaves it whole
/// are told beside it.
///
/// # Errors
/// As [`parse`], but for unknown keys alone.
pub fn parse_around<T: Document>(
    text: &str,
    sets: &[String],
) -> Result<(Config<T>, Vec<Problem>), ConfigError> {
    let source = Source { text, sets };
    if text.len() > TEXT_MAX {
        let message = format!("longer than {TEXT_MAX} bytes: this is not a configuration file");
        return Err(source.fail(0..0, "", message));
    }
    let parsed = DeTable::parse(text).map_err(|e| source.syntax(&e))?;
    let root_span = parsed.span();
    let mut table = parsed.into_inner();
    for (index, set) in sets.iter().enumerate() {
        let span = source.set_span(index);
        overlay(&mut table, set, span.clone()).map_err(|m| source.fail(span, "", m))?;
    }
    let schema = T::schema(&table).map_err(|(key, message)| {
        let span = table.get_key_value(key).map_or(0..0, |(key, _)| key.span());
        source.fail(span, key, message)
    })?;
    let mut walk = Walk::new(&source, &schema);
    walk.table(&mut table, 0..0, &schema, "");
    let (is_whole, mut problems, places) = (walk.is_whole, walk.problems, walk.places);
    for _ in 0..PROBLEMS_MAX {
        let whole = Spanned::new(root_span.clone(), table.clone());
        let error = match T::read(whole) {
            Ok(value) => {
                let found = ConfigError::new(problems);
                return match is_whole {
                    true => Ok((Config { value, places }, found.problems)),
                    false => Err(found),
                };
            }
            Err(error) => error,
        };
        let span = error.span();
        let key = span.as_ref().and_then(|s| walk::replace(&mut table, s, &schema, ""));
        let (span, key) = (span.unwrap_or(0..0), key.unwrap_or_default());
        let message = match key.as_str() {
            "" => error.message().to_owned(),
            key => format!("`{key}`: {}", error.message()),
        };
        let unplaced = key.is_empty();
        let problem = source.problem(span, &key, message);
        // What was put in its place is refused as well: nothing more can be found.
        let again = problems.last() == Some(&problem);
        if !again {
            problems.push(problem);
        }
        if unplaced || again {
            break;
        }
    }
    Err(ConfigError::new(problems))
}

/// The text and the overlays. A span beyond the end of the text is the index of an overlay.
struct Source<'a> {
    text: &'a str,
    sets: &'a [String],
}

impl Source<'_> {
    fn set_span(&self, index: usize) -> Range<usize> {
        let start = self.text.len() + 1 + index;
        start..start
    }

    fn is_set(&self, span: &Range<usize>) -> bool {
        span.start > self.text.len()
    }

    fn place(&self, span: Range<usize>) -> Place {
        match span.start.checked_sub(self.text.len() + 1).and_then(|i| self.sets.get(i)) {
            Some(set) => Place::Set(set.clone()),
            None => Place::of(self.text, span),
        }
    }

    fn problem(&self, span: Range<usize>, key: &str, message: String) -> Problem {
        Problem { place: self.place(span), key: key.to_owned(), message }
    }

    fn fail(&self, span: Range<usize>, key: &str, message: String) -> ConfigError {
        ConfigError::new(vec![self.problem(span, key, message)])
    }

    fn syntax(&self, error: &toml::de::Error) -> ConfigError {
        let span = error.span().unwrap_or(0..0);
        let mut message = format!("not valid TOML: {}", error.message());
        if let Place::File { excerpt, .. } = self.place(span.clone()) {
            let value = excerpt.split_once('=').map_or("", |(_, v)| v);
            let value = value.split('#').next().unwrap_or("").trim();
            let number = value.starts_with(|c: char| c.is_ascii_digit());
            if number && value.ends_with(char::is_alphabetic) {
                message.push_str(&format!("; a value with a unit is a string: write \"{value}\""));
            }
        }
        self.fail(span, "", message)
    }
}

/// Puts `key=value` on `table`. The value is TOML; what is not TOML is a string.
fn overlay<'t>(table: &mut DeTable<'t>, set: &'t str, span: Range<usize>) -> Result<(), String> {
    const FORM: &str = "write --set key=value, e.g. --set vru.cores=8";
    let (key, value) = set.split_once('=').ok_or_else(|| FORM.to_owned())?;
    let path: Vec<&str> = key.split('.').map(str::trim).collect();
    let (Some((last, tables)), false) = (path.split_last(), path.contains(&"")) else {
        return Err(format!("`{key}` is not a dotted key; {FORM}"));
    };
    let mut at = table;
    for name in tables {
        let fresh = || Spanned::new(span.clone(), DeValue::Table(DeTable::new()));
        if !at.contains_key(*name) {
            at.insert(Spanned::new(span.clone(), (*name).into()), fresh());
        }
        match at.get_mut(*name).map(Spanned::get_mut) {
            Some(DeValue::Table(inner)) => at = inner,
            _ => return Err(format!("`{name}` in `{key}` is not a table")),
        }
    }
    let value = value.trim();
    let mut parsed = match DeValue::parse(value) {
        Ok(parsed) => parsed.into_inner(),
        Err(_) => DeValue::String(value.into()),
    };
    respan(&mut parsed, &span);
    at.insert(Spanned::new(span.clone(), (*last).into()), Spanned::new(span, parsed));
    Ok(())
}

/// Gives everything inside `value` the span of its overlay.
fn respan(value: &mut DeValue<'_>, span: &Range<usize>) {
    match value {
        DeValue::Array(items) => {
            for item in items.iter_mut() {
                respan(item.get_mut(), span);
                let inner = std::mem::replace(item.get_mut(), DeValue::Boolean(false));
                *item = Spanned::new(span.clone(), inner);
            }
        }
        DeValue::Table(table) => {
            let entries = std::mem::take(table);
            for (key, mut value) in entries {
                respan(value.get_mut(), span);
                let value = Spanned::new(span.clone(), value.into_inner());
                table.insert(Spanned::new(span.clone(), key.into_inner()), value);
            }
        }
        DeValue::String(_)
        | DeValue::Integer(_)
        | DeValue::Float(_)
        | DeValue::Boolean(_)
        | DeValue::Datetime(_) => {}
    }
}
