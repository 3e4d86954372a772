//! Turning a key of a configuration: finding its values by path, scaling them, replacing them.

use toml::{Table, Value};

/// Calls `change` on every value at `path` (`*` is any name, `[]` behind a name every item of the
/// list), and puts what it returns in its place. Returns how many were changed.
pub fn change(
    table: &mut Table,
    path: &str,
    change: &mut impl FnMut(&Value) -> Option<Value>,
) -> usize {
    let (first, rest) = path.split_once('.').map_or((path, None), |(a, b)| (a, Some(b)));
    let (name, is_list) = first.strip_suffix("[]").map_or((first, false), |name| (name, true));
    let mut changed = 0;
    for (key, value) in table.iter_mut() {
        if name != "*" && key != name {
            continue;
        }
        changed += match (value, is_list) {
            (Value::Array(items), true) => {
                items.iter_mut().map(|item| inside(item, rest, change)).sum()
            }
            (_, true) => 0,
            (value, false) => inside(value, rest, change),
        };
    }
    changed
}

/// Puts a value at `path`, making tables on the way; with `*` or `[]` in it, at every place that is
/// there. Returns whether there was a place for it.
pub fn set(table: &mut Table, path: &str, value: &Value) -> bool {
    if path.contains("[]") || path.contains('*') {
        return change(table, path, &mut |_| Some(value.clone())) > 0;
    }
    let Some((first, rest)) = path.split_once('.') else {
        match table.get_mut(path) {
            Some(place) => place.clone_from(value),
            None => {
                table.insert(path.to_owned(), value.clone());
            }
        }
        return true;
    };
    if !table.contains_key(first) {
        table.insert(first.to_owned(), Value::Table(Table::new()));
    }
    match table.get_mut(first) {
        Some(Value::Table(inner)) => set(inner, rest, value),
        _ => false,
    }
}

/// Takes away what is at a path without lists, if it is there.
pub fn remove(table: &mut Table, path: &str) {
    match path.split_once('.') {
        None => _ = table.remove(path),
        Some((first, rest)) => {
            if let Some(Value::Table(inner)) = table.get_mut(first) {
                remove(inner, rest);
            }
        }
    }
}

fn inside(
    value: &mut Value,
    rest: Option<&str>,
    with: &mut impl FnMut(&Value) -> Option<Value>,
) -> usize {
    match (rest, value) {
        (Some(rest), Value::Table(table)) => change(table, rest, with),
        (Some(_), _) => 0,
        (None, value) => {
            let Some(new) = with(value) else { return 0 };
            *value = new;
            1
        }
    }
}

/// The names behind `one of a, b, c`, the unit of a key that has names.
pub fn choices(unit: &str) -> Vec<String> {
    let names = unit.strip_prefix("one of ").unwrap_or("");
    names.split(", ").filter(|name| !name.is_empty()).map(str::to_owned).collect()
}

/// Values that are not the one that a key has, as they are written behind `--set key=`. `choices`
/// are the names that it may have.
pub fn others(value: &Value, choices: &[String]) -> Vec<Value> {
    if !choices.is_empty() {
        let names = choices.iter().filter(|c| Some(c.as_str()) != value.as_str());
        return names.map(|c| c.as_str().into()).collect();
    }
    match value {
        Value::Boolean(b) => return vec![Value::Boolean(!b)],
        Value::Integer(0) => return vec![Value::Integer(3), Value::Integer(1000)],
        Value::Float(x) if *x == 0.0 => return vec![Value::Float(0.5)],
        Value::String(text) if text.starts_with("0 ") => {
            return vec![match text.as_str() {
                "0 B" => "16 KiB".into(),
                "0 B/s" => "5 GB/s".into(),
                _ => text.replace("0 ", "50 ").into(),
            }];
        }
        _ => {}
    }
    [2.0, 0.5].into_iter().filter_map(|factor| scaled(value, factor)).collect()
}

/// Every value at `path`, in the order of the file.
pub fn values(table: &Table, path: &str) -> Vec<Value> {
    let mut found = Vec::new();
    change(&mut table.clone(), path, &mut |value| {
        found.push(value.clone());
        None
    });
    found
}

/// `value` times `factor`: whole numbers (and whole bytes) are rounded and change by at least one
/// step. `None` for values that are no number, for zero, and for results below zero.
pub fn scaled(value: &Value, factor: f64) -> Option<Value> {
    match value {
        Value::Integer(n) => Some(Value::Integer(step(*n, factor)?)),
        Value::Float(x) => (*x != 0.0).then(|| Value::Float(rounded(x * factor))),
        Value::String(text) => {
            let (number, unit) = text.split_once(' ')?;
            if unit == "B" {
                return Some(format!("{} B", step(number.parse().ok()?, factor)?).into());
            }
            let number: f64 = number.parse().ok()?;
            (number != 0.0).then(|| format!("{} {unit}", rounded(number * factor)).into())
        }
        Value::Boolean(_) | Value::Datetime(_) | Value::Array(_) | Value::Table(_) => None,
    }
}

/// Twelve digits: a product of decimal numbers as people would write it.
fn rounded(x: f64) -> f64 {
    format!("{x:.11e}").parse().unwrap_or(x)
}

/// `n` times `factor`, rounded, at least one step away.
fn step(n: i64, factor: f64) -> Option<i64> {
    if n == 0 {
        return None;
    }
    let scaled = (n as f64 * factor).round() as i64;
    let stepped = match factor < 1.0 {
        true => scaled.min(n - 1),
        false => scaled.max(n + 1),
    };
    (stepped >= 0).then_some(stepped)
}

/// A value as it is written behind `--set key=`: TOML, or else a text.
pub fn written(text: &str) -> Value {
    let parsed = format!("value = {text}").parse::<Table>().ok();
    parsed.and_then(|mut t| t.remove("value")).unwrap_or_else(|| text.into())
}

/// A value as people read it: texts without quotes.
pub fn shown(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}
