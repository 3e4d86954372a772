//! Derived keys, each after those that it needs.

use super::{AxisFound, Key};
use crate::sweep::expr::Expr;
use crate::sweep::file::Settings;

/// A key with its expression.
pub(super) struct Derived {
    /// As it is written.
    pub(super) name: String,
    pub(super) key: &'static Key,
    pub(super) expr: Expr,
    /// Whether it follows an axis by default: the file does not name it.
    pub(super) is_carried: bool,
}

pub(super) fn read(settings: &Settings, found: &mut AxisFound<'_>) -> Vec<Derived> {
    let mut all: Vec<Derived> = Vec::new();
    for (name, value) in &settings.0 {
        let path = format!("derived.{name}");
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let key = found.ok(&path, Key::find(name));
        let expr = found.ok(&path, Expr::parse(&text));
        let (Some(key), Some(expr)) = (key, expr) else { continue };
        if key.is_machine() {
            found.wrong(&path, "the base machine comes first and cannot be derived");
        }
        if all.iter().any(|d| d.key == key) {
            found.wrong(&path, format!("`{key}` is derived twice"));
        }
        all.push(Derived { name: name.clone(), key, expr, is_carried: false });
    }
    all
}

/// Puts every key behind those that it needs; a circle is a problem.
pub(super) fn order(all: &mut Vec<Derived>, found: &mut AxisFound<'_>) {
    let mut rest = std::mem::take(all);
    while !rest.is_empty() {
        let waits = |d: &Derived| {
            let names = d.expr.names();
            // With its own name among them: a key that needs itself is a circle, too.
            rest.iter().any(|other| names.contains(other.key.to_string().as_str()))
        };
        let Some(next) = rest.iter().position(|d| !waits(d)) else {
            let names: Vec<String> = rest.iter().map(|d| format!("`{}`", d.key)).collect();
            let place = format!("derived.{}", rest[0].name);
            found.wrong(&place, format!("{} need each other: a circle", names.join(", ")));
            return;
        };
        all.push(rest.remove(next));
    }
}
