//! Axes: which keys take which values together.

use std::collections::BTreeSet;

use toml::Value;

use super::expr::Expr;
use super::file::place::Places;
use super::file::{AxisSpec, Raw, Settings, VariantSpec, Zip, ZipValues};
use super::key::Key;
use super::range;
use powergs_base::config::Problem;
use powergs_base::config::suggest::nearest;

/// More values on one axis are a typing error.
pub(crate) const VALUES_MAX: usize = 100_000;

/// One axis of a space, checked.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Its name in results: the key, that of the first key, or its own.
    pub name: String,
    /// The steps, in order.
    pub steps: Vec<AxisStep>,
    /// Whether neighbouring steps are alike: numbers, not names.
    pub ordered: bool,
    /// Where it counts.
    pub when: Option<Expr>,
    /// Whether its steps have names: its column has them, not the values of its keys.
    pub has_names: bool,
}

/// One step of an axis.
#[derive(Debug, Clone)]
pub struct AxisStep {
    /// Name of a variant; a value, or several, of the other axes.
    pub label: String,
    /// What is set.
    pub settings: Vec<(&'static Key, Value)>,
}

impl Axis {
    /// The keys that it sets in any step.
    pub fn keys(&self) -> BTreeSet<&'static Key> {
        self.steps.iter().flat_map(|s| s.settings.iter().map(|(key, _)| *key)).collect()
    }
}

/// Problems with their places.
pub(super) struct AxisFound<'a> {
    pub(super) places: Places<'a>,
    pub(super) problems: Vec<Problem>,
}

impl AxisFound<'_> {
    pub(super) fn wrong(&mut self, path: &str, message: impl Into<String>) {
        if self.problems.len() < powergs_base::config::error::PROBLEMS_MAX {
            self.problems.push(self.places.problem(path, message.into()));
        }
    }

    /// The result, or its error as a problem.
    pub(super) fn ok<T>(&mut self, path: &str, result: Result<T, impl ToString>) -> Option<T> {
        result.map_err(|e| self.wrong(path, e.to_string())).ok()
    }
}

/// A value as its key takes it, or a problem at `path`.
pub(super) fn value(
    key: &'static Key,
    value: &Value,
    path: &str,
    found: &mut AxisFound<'_>,
) -> Option<(&'static Key, Value)> {
    let read = key.domain().read(value).map_err(|message| about(key, &message));
    found.ok(path, read).map(|value| (key, value))
}

/// What is wrong with a value of a key: `must be ...` goes on from the key, all else stands alone.
pub(super) fn about(key: &Key, message: &str) -> String {
    let goes_on = ["must ", "is "].iter().any(|start| message.starts_with(start));
    format!("`{key}`{} {message}", if goes_on { "" } else { ":" })
}

/// All of `settings`, checked.
pub(super) fn settings(
    given: &Settings,
    path: &str,
    found: &mut AxisFound<'_>,
) -> Vec<(&'static Key, Value)> {
    let mut all: Vec<(&'static Key, Value)> = Vec::new();
    for (name, raw) in &given.0 {
        let path = format!("{path}.{name}");
        let Some(key) = found.ok(&path, Key::find(name)) else { continue };
        if all.iter().any(|(other, _)| *other == key) {
            found.wrong(&path, format!("`{key}` appears twice"));
        }
        all.extend(value(key, raw, &path, found));
    }
    all
}

/// Reads one axis; `None` if nothing can be made of it.
pub(super) fn axis(spec: &AxisSpec, number: usize, found: &mut AxisFound<'_>) -> Option<Axis> {
    let at = format!("axes.{number}");
    let before = found.problems.len();
    let forms =
        [spec.values.is_some(), spec.range.is_some(), spec.zip.is_some(), spec.variants.is_some()];
    if forms.into_iter().filter(|f| *f).count() != 1 {
        let message = "an axis has exactly one of `values`, `range`, `zip` and `variants`";
        found.wrong(&at, message);
        return None;
    }
    let is_plain = spec.values.is_some() || spec.range.is_some();
    match (&spec.key, &spec.name) {
        (None, _) if is_plain => found.wrong(&at, "an axis with `values` or `range` has a `key`"),
        (Some(_), _) if !is_plain => {
            found.wrong(&format!("{at}.key"), "`zip` and `variants` name their keys themselves");
        }
        (None, None) if spec.variants.is_some() => {
            found.wrong(&at, "an axis of variants has a `name`");
        }
        _ => {}
    }
    if found.problems.len() > before {
        return None;
    }
    let mut axis = match (&spec.zip, &spec.variants) {
        (Some(zip), _) => zipped(zip, spec, &at, found)?,
        (_, Some(variants)) => named(variants, spec, &at, found),
        _ => plain(spec, &at, found)?,
    };
    if let Some(when) = &spec.when {
        axis.when = Some(found.ok(&format!("{at}.when"), Expr::parse(when))?);
    }
    if axis.steps.is_empty() && found.problems.len() == before {
        found.wrong(&at, "an axis without a value: the space is empty");
    }
    if axis.steps.len() > VALUES_MAX {
        found.wrong(&at, format!("more than {VALUES_MAX} values on one axis: a typing error?"));
    }
    (found.problems.len() == before).then_some(axis)
}

/// The values of a list, each once.
fn list(key: &'static Key, values: &[Value], path: &str, found: &mut AxisFound<'_>) -> Vec<Value> {
    let mut all: Vec<Value> = Vec::new();
    let mut seen = BTreeSet::new();
    for (i, raw) in values.iter().enumerate() {
        let path = format!("{path}.{i}");
        let Some((_, value)) = value(key, raw, &path, found) else { continue };
        if !seen.insert(value.to_string()) {
            found.wrong(&path, format!("{raw} appears twice"));
        }
        all.push(value);
    }
    all
}

fn shown(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

fn plain(spec: &AxisSpec, at: &str, found: &mut AxisFound<'_>) -> Option<Axis> {
    let name = spec.key.as_deref().unwrap_or_default();
    let key = found.ok(&format!("{at}.key"), Key::find(name))?;
    let values = match (&spec.values, &spec.range) {
        (Some(values), _) => {
            let values: Vec<Value> = values.iter().map(|Raw(v)| v.clone()).collect();
            list(key, &values, &format!("{at}.values"), found)
        }
        (None, Some(range)) => found.ok(&format!("{at}.range"), range::values(key, range))?,
        (None, None) => return None,
    };
    let step = |value: Value| AxisStep { label: shown(&value), settings: vec![(key, value)] };
    Some(Axis {
        name: spec.name.clone().unwrap_or_else(|| key.to_string()),
        steps: values.into_iter().map(step).collect(),
        ordered: key.domain().is_ordered(),
        when: None,
        has_names: false,
    })
}

fn zipped(zip: &Zip, spec: &AxisSpec, at: &str, found: &mut AxisFound<'_>) -> Option<Axis> {
    let mut rows: Vec<(&'static Key, Vec<Value>)> = Vec::new();
    for (name, row) in &zip.0 {
        let path = format!("{at}.zip.{name}");
        let Some(key) = found.ok(&path, Key::find(name)) else { continue };
        let read = |v: &Value, i: usize, found: &mut AxisFound<'_>| {
            value(key, v, &format!("{path}.{i}"), found).map(|(_, value)| value)
        };
        let values = match row {
            ZipValues::List(values) => {
                values.iter().enumerate().filter_map(|(i, v)| read(v, i, found)).collect()
            }
            ZipValues::Range(range) => {
                found.ok(&path, range::values(key, range)).unwrap_or_default()
            }
        };
        rows.push((key, values));
    }
    let Some((first, values)) = rows.first() else {
        found.wrong(&format!("{at}.zip"), "`zip` names no key");
        return None;
    };
    let length = values.len();
    if let Some((other, values)) = rows.iter().find(|(_, values)| values.len() != length) {
        let message = format!(
            "`{first}` has {length} values and `{other}` has {}: zipped keys have as many each",
            values.len()
        );
        found.wrong(&format!("{at}.zip"), message);
        return None;
    }
    let step = |i: usize| {
        let settings: Vec<_> = rows.iter().map(|(key, values)| (*key, values[i].clone())).collect();
        let label: Vec<String> = settings.iter().map(|(_, value)| shown(value)).collect();
        AxisStep { label: label.join(", "), settings }
    };
    Some(Axis {
        name: spec.name.clone().unwrap_or_else(|| first.to_string()),
        steps: (0..length).map(step).collect(),
        ordered: rows.iter().any(|(key, _)| key.domain().is_ordered()),
        when: None,
        has_names: false,
    })
}

fn named(variants: &[VariantSpec], spec: &AxisSpec, at: &str, found: &mut AxisFound<'_>) -> Axis {
    let mut steps: Vec<AxisStep> = Vec::new();
    for (i, variant) in variants.iter().enumerate() {
        let path = format!("{at}.variants.{i}");
        let label = variant.name.clone();
        if label.trim().is_empty() {
            found.wrong(&format!("{path}.name"), "a variant has a name");
        }
        if steps.iter().any(|s| s.label == label) {
            found.wrong(&format!("{path}.name"), format!("a second variant `{label}`"));
        }
        let settings = settings(&variant.set, &format!("{path}.set"), found);
        steps.push(AxisStep { label, settings });
    }
    let name = spec.name.clone().unwrap_or_default();
    Axis { name, steps, ordered: false, when: None, has_names: true }
}

/// What is wrong between axes: names and keys that are there twice, and keys that are also set or
/// derived.
pub(super) fn between(
    axes: &[(usize, Axis)],
    taken: &[(String, &'static Key)],
    found: &mut AxisFound<'_>,
) {
    let mut names: Vec<&str> = Vec::new();
    let mut keys: Vec<(String, &'static Key)> = taken.to_vec();
    for (number, axis) in axes {
        let at = format!("axes.{number}");
        if names.contains(&axis.name.as_str()) {
            found.wrong(&at, format!("a second axis called `{}`: give it a `name`", axis.name));
        }
        if axis.has_names && Key::of(&axis.name).is_some_and(|key| !key.is_part()) {
            let message = format!("`{}` is a key: give the variants another name", axis.name);
            found.wrong(&format!("{at}.name"), message);
        }
        names.push(&axis.name);
        for key in axis.keys() {
            if let Some((other, _)) = keys.iter().find(|(_, k)| *k == key) {
                found.wrong(&at, format!("`{key}` is set here and by {other}: drop one"));
            }
        }
        keys.extend(axis.keys().into_iter().map(|key| (format!("axis `{}`", axis.name), key)));
    }
}

/// What to say about a name that nothing has.
pub(super) fn no_name(name: &str, known: &[String]) -> String {
    let own = nearest(name, known.iter().map(String::as_str));
    match own.or_else(|| nearest(name, Key::all())) {
        Some(near) => format!("nothing is called `{name}`; did you mean `{near}`?"),
        None if name.contains('-') => format!(
            "nothing is called `{name}`; a difference of two names is written with spaces around \
             the `-`"
        ),
        None => format!("nothing is called `{name}`; beside keys there are {}", known.join(", ")),
    }
}
