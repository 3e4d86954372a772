//! What the names in the expressions of a sweep file stand for.
//!
//! Keys of files, names of axes of variants, and what is computed of a machine before anything is
//! simulated: `area_mm2`, `area_mm2.core`, `leakage_w`, `peak_w` by the first energy table
//! (`LABEL:area_mm2` by another one), `sram_capacity_bytes`.

use super::{AxisFound, DesignPriced, Energy, Machine, Space};
use crate::sweep::axis::no_name;
use crate::sweep::design::Design;
use crate::sweep::expr::{Expr, Value};
use crate::sweep::file::SweepFile;
use crate::sweep::key::{FileKind, Key};
use crate::sweep::table::{Facts, LAST};
use powergs_core::sim::cost::peak_w;
use powergs_core::sim::statistics::{Statistic, catalogue};
use powergs_energy::Prices;

/// What is computed once a machine is priced, by table.
const PRICED: [&str; 4] = ["area_mm2", "area_mm2.core", "leakage_w", "peak_w"];

/// Bytes of all buffers and the cache.
const SRAM: &str = "sram_capacity_bytes";

/// A machine with its prices.
pub(super) struct Computed<'a> {
    pub(super) machine: &'a Machine,
    pub(super) prices: &'a [DesignPriced],
}

/// Whether a name is computed of a priced machine.
pub(super) fn is_computed(name: &str, energy: &[Energy]) -> bool {
    match name.split_once(':') {
        None => name == SRAM || PRICED.contains(&name),
        Some((label, name)) => PRICED.contains(&name) && energy.iter().any(|e| e.label == label),
    }
}

/// What is known of a design under the energy table at `place`, in the order of the columns.
pub(crate) fn facts(design: &Design, place: usize) -> Facts {
    known(&design.machine, design.prices[place].prices.as_ref().ok())
}

/// What is known of a machine with its prices before it is simulated, in the order of the columns.
pub(crate) fn known(machine: &Machine, prices: Option<&Prices>) -> Facts {
    LAST.map(|(name, ..)| known_of(name, machine, prices))
}

pub(super) fn computed(name: &str, of: &Computed<'_>) -> Option<Value> {
    let (priced, name) = match name.split_once(':') {
        None => (of.prices.first()?, name),
        Some((label, name)) => (of.prices.iter().find(|p| p.label == label)?, name),
    };
    known_of(name, of.machine, priced.prices.as_ref().ok()).map(Value::Number)
}

fn known_of(name: &str, machine: &Machine, prices: Option<&Prices>) -> Option<f64> {
    let number = match name {
        "area_mm2" => prices?.area.as_ref()?.total().0,
        "area_mm2.core" => prices?.area.as_ref()?.core().0,
        "leakage_w" => prices?.leakage_w(),
        "peak_w" => peak_w(machine, prices?).iter().map(|(_, watts)| watts).sum(),
        SRAM => {
            let memories = machine.inventory().memories;
            let bytes = memories.iter().map(|m| m.bank.0 * u64::from(m.banks));
            bytes.sum::<u64>() as f64
        }
        _ => return None,
    };
    Some(number)
}

/// Problems with the names of all expressions.
pub(super) fn check(space: &Space, file: &SweepFile, found: &mut AxisFound<'_>) {
    let variants = space.axes.iter().filter(|a| a.has_names).map(|a| a.name.clone());
    let variants: Vec<String> = variants.collect();
    let mut computed: Vec<String> = PRICED.iter().chain(&[SRAM]).map(|n| (*n).to_owned()).collect();
    for energy in file.energy.iter().skip(1) {
        computed.extend(PRICED.iter().map(|name| format!("{}:{name}", energy.label)));
    }
    let known: Vec<String> = variants.iter().cloned().chain(computed).collect();
    for (i, text) in file.constraints.iter().enumerate() {
        let Ok(expr) = Expr::parse(text) else { continue };
        let place = format!("constraints.{i}");
        names_of(&expr, &place, &known, space, found);
        if expr.names().is_empty() {
            found.wrong(&place, "no name in it: it holds for all points, or for none");
        }
    }
    for derived in &space.derived {
        let place = format!("derived.{}", derived.name);
        names_of(&derived.expr, &place, &known, space, found);
        for name in derived.expr.names() {
            if is_computed(name, &space.energy) {
                let message = format!(
                    "`{name}` is known once the machine is complete: it can be in `constraints`, \
                     not in `derived`"
                );
                found.wrong(&place, message);
            }
        }
    }
    conditions(space, &known, found);
    for key in space.axes.iter().flat_map(|a| a.keys()).chain(space.derived.iter().map(|d| d.key)) {
        if key.file == FileKind::Display && space.display.is_none() {
            found.wrong("axes", format!("`{key}`: there is no display; add `display = \"...\"`"));
        }
    }
}

fn names_of(expr: &Expr, place: &str, known: &[String], space: &Space, found: &mut AxisFound<'_>) {
    for name in expr.names() {
        let is_known = Key::known(name).is_some()
            || known.iter().any(|k| k == name)
            || is_computed(name, &space.energy);
        if is_known {
            continue;
        }
        let message = match is_result(name) {
            true => format!(
                "`{name}` is a result: it is known after the simulation, for `pareto --where`"
            ),
            false => no_name(name, known),
        };
        found.wrong(place, expr.at_name(name, message).to_string());
    }
}

/// Whether a name is a column of the results that is computed from a simulation.
fn is_result(name: &str) -> bool {
    let column = name.rsplit_once('.').map_or(name, |(column, _)| column);
    let of = |s: &Statistic| s.name.split('.').next() == Some(column) || s.name == name;
    column == "fps" || catalogue().iter().any(of)
}

/// A condition sees the axes before its own.
fn conditions(space: &Space, known: &[String], found: &mut AxisFound<'_>) {
    for (i, axis) in space.axes.iter().enumerate() {
        let Some(when) = &axis.when else { continue };
        let place = format!("axes.{i}.when");
        names_of(when, &place, known, space, found);
        if axis.keys().iter().any(|key| key.is_machine()) {
            found.wrong(&place, "the base machine comes first: its axis has no condition");
        }
        for name in when.names() {
            let sets = |a: &super::Axis| {
                (a.has_names && a.name == name) || a.keys().iter().any(|k| k.to_string() == name)
            };
            let derived = space.derived.iter().any(|d| d.key.to_string() == name);
            if let Some(later) = space.axes[i..].iter().find(|a| sets(a)) {
                let message = format!(
                    "`{name}` is decided by the axis `{}`, which does not come before this one: \
                     change their order",
                    later.name
                );
                found.wrong(&place, when.at_name(name, message).to_string());
            } else if derived || is_computed(name, &space.energy) {
                let message = format!("`{name}` is known only after all axes: use a constraint");
                found.wrong(&place, when.at_name(name, message).to_string());
            }
        }
    }
}
