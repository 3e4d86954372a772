//! The columns of the axes: what kind they are, and what each design has in them.

use toml::{Table, Value};

use crate::sweep::design::Design;
use crate::sweep::expr::{self, Expr};
use crate::sweep::key::Key;
use crate::sweep::measure::Measure;
use crate::sweep::metric::{metrics, nearest_column};
use crate::sweep::objective::Objective;
use crate::sweep::space::Space;
use crate::sweep::table::{Cell, Column, ColumnKind, LAST};
use powergs_core::run::RunError;

/// Steps of each axis that decide the kind of its column.
const LOOKED_AT: u32 = 4096;

/// Ending of the column that has a measure as a number in SI units.
const SI: &str = ".si";

/// The columns of the axes: whole numbers, numbers, truths and texts as they are; behind a column
/// of measures (`64 KiB`) one with the same in SI units (bytes, hertz, seconds, joules).
pub fn kinds(space: &Space) -> Vec<Column> {
    let names = space.columns();
    let mut found: Vec<Option<ColumnKind>> = vec![None; names.len()];
    let mut measures = vec![true; names.len()];
    for index in looked_at(space) {
        let Ok(point) = space.point(index) else { continue };
        for (i, setting) in point.settings.iter().enumerate() {
            let kind = kind(&setting.value);
            found[i] = Some(found[i].map_or(kind, |before| joined(before, kind)));
            measures[i] &= si(&setting.value).is_some();
        }
    }
    let mut columns = Vec::new();
    for (i, name) in names.into_iter().enumerate() {
        let kind = found[i].unwrap_or(ColumnKind::Text);
        let is_measure = kind == ColumnKind::Text && measures[i];
        columns.push(Column { name: name.clone(), kind });
        if is_measure && found[i].is_some() {
            columns.push(Column { name: name + SI, kind: ColumnKind::Real });
        }
    }
    columns
}

/// The columns of settings that are in no space, and what each machine has in them.
pub(crate) fn settings_columns(machines: &[&[(String, Value)]]) -> (Vec<Column>, Vec<Vec<Cell>>) {
    let mut columns: Vec<Column> = Vec::new();
    for (name, value) in machines.iter().flat_map(|settings| settings.iter()) {
        match columns.iter_mut().find(|column| column.name == *name) {
            Some(column) => column.kind = joined(column.kind, kind(value)),
            None => columns.push(Column { name: name.clone(), kind: kind(value) }),
        }
    }
    let measures: Vec<String> =
        columns.iter().filter(|c| c.kind == ColumnKind::Text).map(|c| c.name.clone()).collect();
    for name in measures {
        let mut values = machines.iter().flat_map(|s| s.iter()).filter(|(own, _)| *own == name);
        if values.all(|(_, value)| si(value).is_some()) {
            let place = columns.iter().position(|c| c.name == name).map_or(0, |i| i + 1);
            columns.insert(place, Column { name: name + SI, kind: ColumnKind::Real });
        }
    }
    let cells = |settings: &&[(String, Value)]| {
        let find =
            |name: &str| settings.iter().find(|(own, _)| own == name).map(|(_, value)| value);
        columns.iter().map(|column| cell(column, find)).collect()
    };
    let cells = machines.iter().map(cells).collect();
    (columns, cells)
}

/// Points in which every step of every axis occurs, up to that many.
fn looked_at(space: &Space) -> impl Iterator<Item = u64> {
    let lattice = space.lattice();
    let sides = lattice.sides().to_vec();
    let most = sides.iter().map(|s| s.len.min(LOOKED_AT)).max().unwrap_or(1);
    (0..most).map(move |k| {
        let digits: Vec<u32> = sides.iter().map(|s| k.min(s.len - 1)).collect();
        space.lattice().index(&digits)
    })
}

fn kind(value: &Value) -> ColumnKind {
    match value {
        Value::Integer(_) => ColumnKind::Integer,
        Value::Float(_) => ColumnKind::Real,
        Value::Boolean(_) => ColumnKind::Truth,
        _ => ColumnKind::Text,
    }
}

fn joined(a: ColumnKind, b: ColumnKind) -> ColumnKind {
    match (a, b) {
        (a, b) if a == b => a,
        (ColumnKind::Integer, ColumnKind::Real) | (ColumnKind::Real, ColumnKind::Integer) => {
            ColumnKind::Real
        }
        _ => ColumnKind::Text,
    }
}

/// A measure in SI units.
fn si(value: &Value) -> Option<f64> {
    let (_, unit) = value.as_str()?.split_once(' ')?;
    Measure::with_unit(unit)?.read(value.as_str()?).ok()
}

/// What a point has in the columns; empty where it has no value.
pub fn cells(space: &Space, point: u64, columns: &[Column]) -> Vec<Cell> {
    let settings = space.point(point).map(|p| p.settings).unwrap_or_default();
    let find = |name: &str| settings.iter().find(|s| s.name == name).map(|s| &s.value);
    columns.iter().map(|c| cell(c, find)).collect()
}

/// What the base machine has in the columns.
pub fn baseline_cells(base: &Design, columns: &[Column]) -> Vec<Cell> {
    let machine: Table = base.resolved_machine_toml().parse().unwrap_or_default();
    let files: Vec<(String, Table)> = base
        .files()
        .into_iter()
        .map(|(what, text)| (what, text.parse().unwrap_or_default()))
        .collect();
    let find = |name: &str| -> Option<Value> {
        if name == crate::sweep::key::MACHINE {
            return Some(base.machine.name.clone().into());
        }
        let (table, path) = match name.split_once(':') {
            None => (&machine, name),
            Some((file, path)) => {
                let begins = |what: &str| what.split(' ').next() == Some(file);
                (&files.iter().find(|(what, _)| begins(what))?.1, path)
            }
        };
        path.split('.')
            .try_fold(Value::Table(table.clone()), |value, key| value.as_table()?.get(key).cloned())
    };
    columns
        .iter()
        .map(|c| {
            let value = find(c.name.strip_suffix(SI).unwrap_or(&c.name));
            cell(c, |_| value.as_ref())
        })
        .collect()
}

fn cell<'v>(column: &Column, find: impl Fn(&str) -> Option<&'v Value>) -> Cell {
    if let Some(name) = column.name.strip_suffix(SI) {
        return find(name).and_then(si).map_or(Cell::Empty, Cell::Real);
    }
    match (column.kind, find(&column.name)) {
        (_, None) => Cell::Empty,
        (ColumnKind::Integer, Some(Value::Integer(n))) => Cell::Integer(*n),
        (ColumnKind::Real, Some(Value::Integer(n))) => Cell::Real(*n as f64),
        (ColumnKind::Real, Some(Value::Float(x))) => Cell::Real(*x),
        (ColumnKind::Truth, Some(Value::Boolean(yes))) => Cell::Truth(*yes),
        (ColumnKind::Text, Some(value)) => Cell::Text(powergs_base::config::knob::shown(value)),
        // A later step has another kind of value.
        (_, Some(_)) => Cell::Empty,
    }
}

/// What a cell of an axis is in an expression: a measure counts in SI units.
pub fn value(cell: &Cell) -> Option<expr::Value> {
    Some(match cell {
        Cell::Empty => return None,
        Cell::Integer(n) => expr::Value::Number(*n as f64),
        Cell::Real(x) => expr::Value::Number(*x),
        Cell::Truth(yes) => expr::Value::Truth(*yes),
        Cell::Text(text) => match si(&Value::String(text.clone())) {
            Some(x) => expr::Value::Number(x),
            None => expr::Value::Text(text.clone()),
        },
    })
}

/// Refuses objectives that cannot be made of the columns of the table.
///
/// # Errors
/// [`RunError::Config`]: such an objective, with the nearest column.
pub fn check_objectives(
    objectives: &[Objective],
    space: &Space,
    origin: &str,
) -> Result<(), RunError> {
    let axes = kinds(space);
    let metrics = metrics().iter().map(|m| m.name.as_str());
    let own = axes.iter().map(|c| c.name.as_str());
    let names: Vec<&str> = metrics.chain(LAST.iter().map(|f| f.0)).chain(own).collect();
    let wrong = |what: String| Err(RunError::config(origin, what));
    for objective in objectives {
        if !names.contains(&objective.name.as_str())
            && let Err(error) = Expr::parse(&objective.name)
        {
            return wrong(format!("the objective `{}`: {error}", objective.name));
        }
        let columns = objective.columns();
        if let Some(column) = columns.iter().find(|c| !names.contains(&c.as_str())) {
            let hint = column_hint(column, &names, axes.iter().map(|c| c.name.as_str()));
            return wrong(format!("no column `{column}` to optimise{hint}"));
        }
        if columns.is_empty() {
            let what = "no column in it: it is the same for all designs";
            return wrong(format!("the objective `{}`: {what}", objective.name));
        }
        if let [only] = axes.iter().filter(|c| c.name == objective.name).collect::<Vec<_>>()[..]
            && only.kind == ColumnKind::Text
            && !names.contains(&format!("{}{SI}", only.name).as_str())
        {
            return wrong(format!("column `{}` has words: an objective needs numbers", only.name));
        }
    }
    Ok(())
}

/// What to write in place of a name that no column has.
pub(crate) fn column_hint<'a>(
    name: &str,
    columns: &[&str],
    axes: impl Iterator<Item = &'a str>,
) -> String {
    if let Some(near) = nearest_column(name, columns.iter().copied()) {
        return format!("; did you mean `{near}`?");
    }
    let fixed = match Key::known(name) {
        Some(_) => format!("; `{name}` is the same for all designs of this sweep. "),
        None => "; ".to_owned(),
    };
    let axes: Vec<String> = axes.filter(|a| !a.ends_with(SI)).map(|a| format!("`{a}`")).collect();
    let axes = match axes.is_empty() {
        true => String::new(),
        false => format!(" and {} of this sweep", axes.join(", ")),
    };
    format!(
        "{fixed}there are `power_w.mean`, `energy_pj.mean`, `area_mm2`, `fps.mean`, \
         `frame_time_ms.p99`, `sram_capacity_bytes`{axes}; all of them are in docs/results.md"
    )
}
