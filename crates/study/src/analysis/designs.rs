//! The designs that a question is about: one row per point of one energy table and scope.

use std::collections::{BTreeMap, HashSet};

use super::front::Costs;
use super::question::{AnalysisError, Named, Objective, Scope};
use super::table::{Over, Table, Values, Words};
use crate::sweep::expr::{Expr, Value};

/// The rows of one energy table and one scope, by point.
#[derive(Debug, Clone, PartialEq)]
pub struct DesignSlice {
    /// Rows of points, by the number of the point.
    pub rows: Vec<u32>,
    /// The row of the base machine.
    pub baseline: Option<u32>,
}

impl DesignSlice {
    /// The rows of the energy table with the code `energy_table` under `scope`. Of two rows of one
    /// point the first counts.
    pub fn of(table: &Table, energy_table: u32, scope: &Scope) -> DesignSlice {
        let trace = match scope {
            Scope::Trace(label) => table.traces.find(label),
            Scope::Mean | Scope::Worst => None,
        };
        let over = match scope {
            Scope::Mean => Over::Mean,
            Scope::Worst => Over::Worst,
            Scope::Trace(_) => Over::Trace,
        };
        let wanted = |row: &u32| {
            table.energy_tables.code(*row) == energy_table
                && table.over[*row as usize] == over
                && trace.is_none_or(|t| table.traces.code(*row) == t)
        };
        let mut rows: Vec<u32> = (0..table.len() as u32).filter(wanted).collect();
        let point = |row: &u32| table.points[*row as usize];
        rows.sort_by_key(point);
        rows.dedup_by_key(|row| point(row));
        // The base machine has the largest number.
        let baseline = rows.pop_if(|row| table.is_baseline(*row));
        DesignSlice { rows, baseline }
    }

    /// The row of a point.
    pub fn row(&self, table: &Table, point: u64) -> Option<u32> {
        let found = self.rows.binary_search_by_key(&point, |r| table.points[*r as usize]);
        found.ok().map(|i| self.rows[i])
    }

    /// The row of a named design.
    ///
    /// # Errors
    /// [`AnalysisError::Design`], [`AnalysisError::Ambiguous`].
    pub fn named(&self, table: &Table, name: &Named) -> Result<Option<u32>, AnalysisError> {
        match name {
            Named::Baseline => Ok(self.baseline),
            Named::Point(point) => match self.row(table, *point) {
                Some(row) => Ok(Some(row)),
                None => Err(AnalysisError::Design(point.to_string())),
            },
            Named::Id(digits) => {
                let begins = |row: &&u32| {
                    format!("{:032x}", table.ids[**row as usize]).starts_with(digits.as_str())
                };
                let mut found = self.rows.iter().filter(begins);
                let first = found.next();
                if found.next().is_some() {
                    return Err(AnalysisError::Ambiguous(digits.clone()));
                }
                let missing = || AnalysisError::Design(digits.clone());
                first.map(|row| Some(*row)).ok_or_else(missing)
            }
        }
    }
}

/// The value of every objective of a row; `None` if one of them was not measured.
pub fn values(table: &Table, objectives: &[Objective], row: u32) -> Option<Vec<f64>> {
    objectives.iter().map(|o| table.number(&o.name, row)).collect()
}

/// Rows with their costs, for those rows that have every objective.
pub(crate) fn with_costs(
    table: &Table,
    objectives: &[Objective],
    rows: &[u32],
) -> (Vec<u32>, Costs) {
    let columns: Vec<_> =
        objectives.iter().map(|o| (table.numbers(&o.name).unwrap_or(&[]), o.goal)).collect();
    let mut kept = Vec::new();
    let mut costs = Costs::new(objectives.len());
    let mut cost = Vec::with_capacity(objectives.len());
    for &row in rows {
        cost.clear();
        let one = |(column, goal): &(&[f64], super::Goal)| {
            column.get(row as usize).filter(|x| x.is_finite()).map(|x| goal.cost(*x))
        };
        cost.extend(columns.iter().map_while(one));
        if cost.len() == objectives.len() {
            kept.push(row);
            costs.push(&cost);
        }
    }
    (kept, costs)
}

/// Checks the names of an expression.
///
/// # Errors
/// [`AnalysisError::Column`] with the nearest name.
pub(crate) fn check_names(table: &Table, expr: &Expr) -> Result<(), AnalysisError> {
    let known: HashSet<&str> = names(table).collect();
    let is_known = |name: &str| known.contains(name) || of_table(table, name).is_some();
    match expr.names().into_iter().find(|name| !is_known(name)) {
        Some(name) => Err(AnalysisError::column(name, table)),
        None => Ok(()),
    }
}

/// All names that a condition may use.
pub fn names(table: &Table) -> impl Iterator<Item = &str> {
    let axes = table.axes.iter().chain(&table.followers).map(|(name, _)| name.as_str());
    table.metric_names.iter().map(String::as_str).chain(axes)
}

/// A condition over a table: what its names stand for in each row, and in which rows it has to
/// hold.
pub(crate) struct DesignHeld<'t, 'e> {
    condition: &'e Expr,
    columns: Vec<(&'e str, DesignSource<'t>)>,
    /// Of every point and energy table the row of the mean and those of the traces.
    over: BTreeMap<(u64, u32), (Option<u32>, Vec<u32>)>,
    table: &'t Table,
}

impl<'t, 'e> DesignHeld<'t, 'e> {
    /// Checks the names of a condition.
    ///
    /// # Errors
    /// [`AnalysisError::Column`] for a name that is none.
    pub(crate) fn new(
        table: &'t Table,
        condition: &'e Expr,
    ) -> Result<DesignHeld<'t, 'e>, AnalysisError> {
        check_names(table, condition)?;
        let mut columns: Vec<(&str, DesignSource)> = Vec::new();
        for name in condition.names() {
            columns.extend(DesignSource::of(table, name).map(|source| (name, source)));
        }
        let mut over: BTreeMap<_, (Option<u32>, Vec<u32>)> = BTreeMap::new();
        for row in 0..table.len() as u32 {
            let key = (table.points[row as usize], table.energy_tables.code(row));
            let (mean, traces) = over.entry(key).or_default();
            match table.over[row as usize] {
                Over::Mean => *mean = Some(row),
                Over::Trace => traces.push(row),
                Over::Worst => {}
            }
        }
        Ok(DesignHeld { condition, columns, over, table })
    }

    fn value(&self, name: &str, row: u32) -> Option<Value> {
        self.columns.iter().find(|(n, _)| *n == name).and_then(|(_, source)| source.value(row))
    }

    /// The rows that it has to hold in for that of a design: all of its traces, or the row itself
    /// where that is of one trace.
    fn rows(&self, row: u32) -> (u32, &[u32]) {
        let key = (self.table.points[row as usize], self.table.energy_tables.code(row));
        match (self.table.over[row as usize], self.over.get(&key)) {
            (Over::Trace, Some((mean, _))) => (mean.unwrap_or(row), &[]),
            (_, Some((mean, traces))) => (mean.unwrap_or(row), traces),
            (_, None) => (row, &[]),
        }
    }

    /// Whether it holds for a design. A row without a value that it needs does not.
    ///
    /// # Errors
    /// [`AnalysisError::Condition`] if it is no statement, or compares words with numbers.
    pub(crate) fn holds(&self, row: u32) -> Result<bool, AnalysisError> {
        let (mean, traces) = self.rows(row);
        let own = [row];
        let rows = if traces.is_empty() { &own[..] } else { traces };
        for &at in rows {
            let lookup = |name: &str| self.value(name, at);
            let of_mean = |name: &str| self.value(name, mean);
            match self.condition.holds_with(&lookup, &of_mean) {
                Ok(true) => {}
                Ok(false) => return Ok(false),
                // All names are columns: here the row has no value.
                Err(e) if e.unknown.is_some() => return Ok(false),
                Err(e) => return Err(AnalysisError::Condition(e.to_string())),
            }
        }
        Ok(true)
    }

    /// By which share a design misses it, and the row where that is most; see
    /// [`Expr::missed_by`].
    pub(crate) fn missed_by(&self, row: u32) -> Option<(f64, u32)> {
        let (mean, traces) = self.rows(row);
        let own = [row];
        let rows = if traces.is_empty() { &own[..] } else { traces };
        let of = |&at: &u32| {
            let lookup = |name: &str| self.value(name, at);
            let of_mean = |name: &str| self.value(name, mean);
            Some((self.condition.missed_by(&lookup, &of_mean).ok()?, at))
        };
        let all: Option<Vec<(f64, u32)>> = rows.iter().map(of).collect();
        all?.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// The rows that meet a condition on every trace. A row without a value that the condition needs
/// does not.
///
/// # Errors
/// [`AnalysisError::Column`] for a name that is none, [`AnalysisError::Condition`] if it is no
/// statement, or compares words with numbers.
pub(crate) fn meeting(
    table: &Table,
    condition: &Expr,
    rows: &[u32],
) -> Result<Vec<u32>, AnalysisError> {
    let held = DesignHeld::new(table, condition)?;
    let mut kept = Vec::new();
    for &row in rows {
        if held.holds(row)? {
            kept.push(row);
        }
    }
    Ok(kept)
}

/// The design that misses a condition least, and every part of it that it misses, by how much and
/// where; the worst first.
pub(crate) fn nearest(table: &Table, condition: &Expr, rows: &[u32]) -> Option<String> {
    let held = DesignHeld::new(table, condition).ok()?;
    let missed = |&row: &u32| Some((held.missed_by(row)?.0, row));
    let all = rows.iter().filter_map(missed).filter(|(share, _)| share.is_finite());
    let (_, row) = all.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let parts: Vec<Expr> =
        conjuncts(condition.text()).iter().filter_map(|text| Expr::parse(text).ok()).collect();
    let of_part = |part: &Expr| {
        let (share, at) = DesignHeld::new(table, part).ok()?.missed_by(row)?;
        (share > 0.0).then(|| (share, missed_part(table, part, share, at)))
    };
    let mut missed: Vec<(f64, String)> = parts.iter().filter_map(of_part).collect();
    missed.sort_by(|a, b| b.0.total_cmp(&a.0));
    let missed: Vec<String> = missed.into_iter().map(|(_, words)| words).collect();
    (!missed.is_empty()).then(|| format!("{} misses {}", table.label(row), missed.join(" and ")))
}

/// By which share of its limit a part of a condition is missed in the row `at`, and with which
/// values.
fn missed_part(table: &Table, part: &Expr, share: f64, at: u32) -> String {
    let value = |name: &str| Some(format!("{name} {}", significant(table.number(name, at)?)));
    let values: Vec<String> = part.names().into_iter().filter_map(value).collect();
    let trace = match table.traces.word(at) {
        "" => String::new(),
        trace => format!(" on {trace}"),
    };
    let values =
        if values.is_empty() { String::new() } else { format!(" ({})", values.join(", ")) };
    format!("`{}` by {}{trace}{values}", part.text(), percent(share))
}

/// Three digits.
fn significant(value: f64) -> String {
    powergs_base::format::significant(value)
}

/// `11 %`. What is equal to a strict limit misses it by nothing that can be written.
fn percent(share: f64) -> String {
    if share < 1e-5 {
        return "less than 0.001 %".to_owned();
    }
    format!("{} %", significant(share * 100.0))
}

/// The energy table and the column of `LABEL:area_mm2`.
fn of_table<'n>(table: &Table, name: &'n str) -> Option<(u32, &'n str)> {
    let (label, column) = name.split_once(':')?;
    let code = table.energy_tables.find(label)?;
    table.metric_names.iter().any(|known| known == column).then_some((code, column))
}

/// The value of an objective in every row; NaN where it has none.
///
/// # Errors
/// [`AnalysisError::Column`] for a name that is none, [`AnalysisError::Objectives`] for what is no
/// expression.
pub(super) fn computed(table: &Table, objective: &Objective) -> Result<Vec<f64>, AnalysisError> {
    let wrong = |e: &dyn std::fmt::Display| {
        AnalysisError::Objectives(format!("the objective `{}`: {e}", objective.name))
    };
    if let Some(words) = table.axis(&objective.name)
        && !words.is_numeric()
    {
        return Err(AnalysisError::Words(objective.name.clone()));
    }
    let expr = Expr::parse(&objective.name).map_err(|e| wrong(&e))?;
    check_names(table, &expr)?;
    let sources: Vec<(&str, DesignSource)> =
        expr.names().into_iter().filter_map(|n| Some((n, DesignSource::of(table, n)?))).collect();
    if sources.is_empty() {
        return Err(wrong(&"no column in it: it is the same for all designs"));
    }
    let value = |row: u32| {
        let lookup = |name: &str| sources.iter().find(|(n, _)| *n == name)?.1.value(row);
        objective.value(&lookup).unwrap_or(f64::NAN)
    };
    Ok((0..table.len() as u32).map(value).collect())
}

/// Where the values of a name come from.
enum DesignSource<'t> {
    Numbers(&'t [f64]),
    Words(&'t Words),
    /// A metric of another energy table: the row there of every row.
    Other(&'t [f64], Vec<Option<u32>>),
}

/// For every row the row of the same design, scope and trace under another energy table.
fn counterparts(table: &Table, energy_table: u32) -> Vec<Option<u32>> {
    let key = |row: u32| {
        let over = table.over[row as usize];
        let trace = (over == Over::Trace).then(|| table.traces.code(row));
        (table.points[row as usize], over, trace)
    };
    let rows = || 0..table.len() as u32;
    let there = rows().filter(|&row| table.energy_tables.code(row) == energy_table);
    let there: BTreeMap<_, u32> = there.map(|row| (key(row), row)).collect();
    rows().map(|row| there.get(&key(row)).copied()).collect()
}

impl<'t> DesignSource<'t> {
    fn of(table: &'t Table, name: &str) -> Option<DesignSource<'t>> {
        if let Some(words) = table.axis(name) {
            return Some(DesignSource::Words(words));
        }
        if let Some((code, column)) = of_table(table, name) {
            return Some(DesignSource::Other(table.numbers(column)?, counterparts(table, code)));
        }
        match &table.metrics.iter().find(|c| c.name == name)?.values {
            Values::Numbers(numbers) => Some(DesignSource::Numbers(numbers)),
            Values::Words(words) => Some(DesignSource::Words(words)),
        }
    }

    /// `64 KiB` is a number here, so that conditions on axes compare sizes.
    fn value(&self, row: u32) -> Option<Value> {
        match self {
            DesignSource::Numbers(numbers) => {
                Some(numbers[row as usize]).filter(|x| !x.is_nan()).map(Value::Number)
            }
            DesignSource::Other(numbers, rows) => {
                let number = numbers[rows[row as usize]? as usize];
                Some(number).filter(|x| !x.is_nan()).map(Value::Number)
            }
            DesignSource::Words(words) => {
                let text = || Value::Text(words.word(row).to_owned());
                Some(words.number(row).map_or_else(text, Value::Number))
            }
        }
    }
}

/// The parts of a condition that `&&` joins, each with the number of rows that meet it.
pub fn parts(table: &Table, condition: &Expr, rows: &[u32]) -> Vec<(String, usize)> {
    let part = |text: String| {
        let met = meeting(table, &Expr::parse(&text).ok()?, rows).ok()?.len();
        Some((text, met))
    };
    let all: Option<Vec<_>> = conjuncts(condition.text()).into_iter().map(part).collect();
    all.unwrap_or_default()
}

/// Cuts a condition at its outermost `&&`; whole where it has an outermost `||`.
fn conjuncts(text: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let (mut depth, mut quote) = (0_i32, None);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match (c, quote) {
            (_, Some(q)) if c == q => quote = None,
            ('\'' | '"', None) => quote = Some(c),
            ('(', None) => depth += 1,
            (')', None) => depth -= 1,
            ('|', None) if depth == 0 => return vec![text.trim().to_owned()],
            ('&', None) if depth == 0 && rest.next_if_eq(&'&').is_some() => {
                parts.push(String::new());
                continue;
            }
            (_, _) => {}
        }
        parts.last_mut().expect("one at least").push(c);
    }
    parts.iter().map(|p| p.trim().to_owned()).collect()
}
