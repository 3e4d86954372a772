//! Checks a parsed table against a schema: unknown and missing keys, types, choices, ranges.

use std::collections::BTreeMap;
use std::ops::Range;

use serde_json::Value;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::Source;
use crate::config::error::{PROBLEMS_MAX, Place, Problem};
use crate::config::layer;
use crate::config::schema::{self, choices, definition, join, list_item};
use crate::config::suggest::nearest;

/// Where the schema of a table says of what other files some keys are.
pub const ELSEWHERE: &str = "x-elsewhere";

/// The longest part of an unknown key that is shown, characters.
const NAME_MAX: usize = 60;

/// One pass over a table. Wrong values are replaced by valid ones, unknown keys removed, missing
/// keys filled in, so that what remains deserializes unless a quantity is wrong.
pub(super) struct Walk<'a> {
    source: &'a Source<'a>,
    root: &'a Value,
    pub(super) problems: Vec<Problem>,
    pub(super) places: BTreeMap<String, Place>,
    /// Whether nothing was put in the place of something: only unknown keys are gone.
    pub(super) is_whole: bool,
}

impl<'a> Walk<'a> {
    pub(super) fn new(source: &'a Source<'a>, root: &'a Value) -> Self {
        Self { source, root, problems: Vec::new(), places: BTreeMap::new(), is_whole: true }
    }

    /// Checks one table, found at `span` under `path`.
    pub(super) fn table(
        &mut self,
        table: &mut DeTable<'_>,
        span: Range<usize>,
        schema: &Value,
        path: &str,
    ) {
        let mut meant = Vec::new();
        for (key, value) in std::mem::take(table) {
            let full = join(path, key.get_ref());
            match schema::property(schema, key.get_ref()) {
                None => meant.extend(self.unknown(&key, schema, path)),
                // A table that need not be there: it is not.
                Some(sub)
                    if value.get_ref().as_str() == Some(layer::NONE)
                        && schema::is_table(sub)
                        && !schema::required(schema).any(|r| r == key.get_ref().as_ref()) =>
                {
                    let at = self.key_span(&key.span(), &value.span());
                    self.places.insert(full, self.source.place(at));
                }
                Some(sub) => {
                    let at = self.key_span(&key.span(), &value.span());
                    self.places.insert(full.clone(), self.source.place(at));
                    let mut value = value;
                    self.value(&mut value, sub, &full);
                    table.insert(key, value);
                }
            }
        }
        for key in schema::required(schema) {
            let Some(sub) = schema::property(schema, key).filter(|_| !table.contains_key(key))
            else {
                continue;
            };
            if !meant.iter().any(|m| m == key) {
                self.missing(key, sub, &span, path);
            }
            self.is_whole = false;
            let value = Spanned::new(span.clone(), placeholder(sub));
            table.insert(Spanned::new(span.clone(), key.to_owned().into()), value);
        }
    }

    /// From the key to the end of its value, where both are on one line.
    fn key_span(&self, key: &Range<usize>, value: &Range<usize>) -> Range<usize> {
        if self.source.is_set(value) {
            return value.clone();
        }
        let line = self.source.text.get(key.start..value.end).filter(|t| !t.contains('\n'));
        line.map_or(key.clone(), |_| key.start..value.end)
    }

    /// Whether enough was found.
    fn is_full(&self) -> bool {
        self.problems.len() >= PROBLEMS_MAX
    }

    fn report(&mut self, span: Range<usize>, key: &str, message: String) {
        if self.is_full() {
            return;
        }
        self.problems.push(self.source.problem(span, key, message));
    }

    /// Reports an unknown key; returns the sibling that was probably meant.
    fn unknown(
        &mut self,
        key: &Spanned<std::borrow::Cow<'_, str>>,
        schema: &Value,
        path: &str,
    ) -> Option<String> {
        let name = key.get_ref().as_ref();
        if self.is_full() {
            return None;
        }
        let siblings: Vec<&str> = schema::properties(schema).map(|(k, _)| k.as_str()).collect();
        let table = if path.is_empty() { String::new() } else { format!(" in [{path}]") };
        let near = nearest(name, siblings.iter().copied());
        let elsewhere = || {
            let docs = schema::all_keys(self.root);
            docs.into_iter().find(|d| d.rsplit('.').next() == Some(name))
        };
        let of_others = schema.get(ELSEWHERE).and_then(|tables| tables.get(name)?.as_str());
        let near = near.filter(|_| of_others.is_none());
        let hint = match (of_others, near) {
            (Some(why), _) => why.to_owned(),
            (None, Some(near)) => format!("did you mean `{near}`?"),
            (None, None) => match elsewhere() {
                Some(other) => format!("did you mean `{other}`?"),
                None => format!("known keys: {}", siblings.join(", ")),
            },
        };
        let near = near.map(str::to_owned);
        let shown: String = name.chars().take(NAME_MAX).collect();
        self.report(
            key.span(),
            &join(path, &shown),
            format!("unknown key `{shown}`{table}; {hint}"),
        );
        near
    }

    fn missing(&mut self, key: &str, sub: &Value, span: &Range<usize>, path: &str) {
        let table = if path.is_empty() { String::new() } else { format!(" in [{path}]") };
        let meaning = definition(sub);
        let first = meaning.split(". ").next().unwrap_or("").trim_end_matches('.');
        let advice = if schema::is_table(sub) {
            format!("add the table [{}]", join(path, key))
        } else if list_item(sub).is_some() {
            format!("add `{key} = [...]`")
        } else {
            format!("add e.g. `{key} = {}`", example(sub))
        };
        let message = format!("missing key `{key}`{table} ({first}); {advice}");
        self.report(span.clone(), &join(path, key), message);
    }

    fn value(&mut self, value: &mut Spanned<DeValue<'_>>, sub: &Value, path: &str) {
        let span = value.span();
        if schema::is_table(sub) {
            match value.get_mut() {
                DeValue::Table(table) => return self.table(table, span, sub, path),
                _ => self.report(span, path, format!("`{path}` is a table: write [{path}]")),
            }
        } else if let Some(item) = list_item(sub) {
            match value.get_mut() {
                DeValue::Array(items) => {
                    let path = format!("{path}[]");
                    return items.iter_mut().for_each(|i| self.value(i, item, &path));
                }
                _ => self.report(span, path, format!("`{path}` is a list: write [...]")),
            }
        } else {
            match leaf(value.get_ref(), sub) {
                Ok(()) => return,
                Err(message) => self.report(span, path, format!("`{path}` {message}")),
            }
        }
        self.is_whole = false;
        *value.get_mut() = placeholder(sub);
    }
}

/// Type, choice and range of a plain value. Quantities check themselves.
fn leaf(value: &DeValue<'_>, sub: &Value) -> Result<(), String> {
    let choices = choices(sub);
    if !choices.is_empty() {
        return match value.as_str() {
            Some(text) if choices.contains(&text) => Ok(()),
            given => {
                let given = given.unwrap_or("");
                let near = nearest(given, choices.iter().copied());
                let hint = near.map_or(String::new(), |n| format!("; did you mean \"{n}\"?"));
                let gone = sub.get("x-gone").and_then(|gone| gone.get(given)?.as_str());
                let hint = gone
                    .map_or(hint, |now| format!("; \"{given}\" is gone: \"{now}\" has its place"));
                Err(format!("must be one of \"{}\"{hint}", choices.join("\", \"")))
            }
        };
    }
    let kind = |name: &str| match sub.get("type") {
        Some(Value::String(kind)) => kind == name,
        Some(Value::Array(kinds)) => kinds.iter().any(|k| k.as_str() == Some(name)),
        _ => false,
    };
    match value {
        DeValue::Integer(n) if kind("integer") || kind("number") => {
            let parsed = i128::from_str_radix(n.as_str(), n.radix());
            in_range(parsed.map_or(f64::INFINITY, |n| n as f64), sub)
        }
        DeValue::Float(n) if kind("number") => {
            in_range(n.as_str().parse().unwrap_or(f64::NAN), sub)
        }
        _ if kind("integer") => Err(format!("must be a whole number, not {}", shown(value))),
        _ if kind("number") => Err(format!("must be a number, not {}", shown(value))),
        DeValue::Boolean(_) if kind("boolean") => Ok(()),
        _ if kind("boolean") => Err(format!("must be true or false, not {}", shown(value))),
        _ if sub.get("x-unit").is_some() => Ok(()),
        DeValue::String(_) => Ok(()),
        _ => Err(format!("must be a text in quotes, not {}", shown(value))),
    }
}

fn shown(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => {
            format!("the text \"{}\"", text.chars().take(40).collect::<String>())
        }
        DeValue::Integer(n) => n.to_string(),
        DeValue::Float(n) => n.to_string(),
        DeValue::Boolean(b) => b.to_string(),
        DeValue::Datetime(d) => d.to_string(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}

fn in_range(n: f64, sub: &Value) -> Result<(), String> {
    let bound = |key: &str| sub.get(key).and_then(Value::as_f64);
    if !n.is_finite() {
        return Err("must be a finite number".to_owned());
    }
    if let Some(low) = bound("minimum").filter(|low| n < *low) {
        return Err(format!("must be at least {low}, not {n}"));
    }
    if let Some(low) = bound("exclusiveMinimum").filter(|low| n <= *low) {
        return Err(format!("must be above {low}, not {n}"));
    }
    if let Some(high) = bound("maximum").filter(|high| n > *high) {
        return Err(format!("must be at most {high}, not {n}"));
    }
    Ok(())
}

/// A value that the schema allows, as TOML text.
fn example(sub: &Value) -> String {
    if let Some(example) = sub.get("examples").and_then(|e| e.get(0)) {
        return example.to_string();
    }
    if let Some(choice) = choices(sub).first() {
        return format!("\"{choice}\"");
    }
    match kind_of(sub) {
        Some("integer") => {
            sub.get("minimum").and_then(Value::as_u64).unwrap_or(1).max(1).to_string()
        }
        Some("number") => "0.5".to_owned(),
        Some("boolean") => "true".to_owned(),
        _ => "\"...\"".to_owned(),
    }
}

/// The type of a plain value; that beside null for an optional one.
fn kind_of(sub: &Value) -> Option<&str> {
    match sub.get("type")? {
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).find(|kind| *kind != "null"),
        kind => kind.as_str(),
    }
}

/// A value that deserializes.
fn placeholder(sub: &Value) -> DeValue<'static> {
    let sub = schema::non_null(sub);
    if schema::is_table(sub) {
        let mut table = DeTable::new();
        for key in schema::required(sub) {
            if let Some(inner) = schema::property(sub, key) {
                let key = Spanned::new(0..0, key.to_owned().into());
                table.insert(key, Spanned::new(0..0, placeholder(inner)));
            }
        }
        return DeValue::Table(table);
    }
    if list_item(sub).is_some() {
        return DeValue::Array(DeArray::new());
    }
    let number = |text: &'static str| DeValue::parse(text).map(Spanned::into_inner).ok();
    let value = match kind_of(sub) {
        Some("integer") => number("1"),
        Some("number") => number("0.5"),
        Some("boolean") => Some(DeValue::Boolean(true)),
        _ => None,
    };
    let text = || example(sub).trim_matches('"').to_owned();
    value.unwrap_or_else(|| DeValue::String(text().into()))
}

/// Replaces the innermost value whose span holds `span` by a valid one; returns its key.
pub(super) fn replace(
    table: &mut DeTable<'_>,
    span: &Range<usize>,
    schema: &Value,
    path: &str,
) -> Option<String> {
    for (key, value) in table.iter_mut() {
        let full = join(path, key.get_ref());
        let Some(sub) = schema::property(schema, key.get_ref()) else { continue };
        if let Some(found) = replace_value(value, span, sub, full) {
            return Some(found);
        }
    }
    None
}

fn replace_value(
    value: &mut Spanned<DeValue<'_>>,
    span: &Range<usize>,
    sub: &Value,
    path: String,
) -> Option<String> {
    let holds = value.span().start <= span.start && span.end <= value.span().end;
    match value.get_mut() {
        DeValue::Table(inner) => replace(inner, span, sub, &path),
        DeValue::Array(items) => {
            let item = list_item(sub)?;
            let path = format!("{path}[]");
            items.iter_mut().find_map(|i| replace_value(i, span, item, path.clone()))
        }
        _ if holds => {
            *value = Spanned::new(0..0, placeholder(sub));
            Some(path)
        }
        _ => None,
    }
}
