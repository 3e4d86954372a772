//! The designs of a sweep as a page holds them: those of the front, and of the others as many as
//! there is room for.

use std::collections::BTreeMap;

use super::Provenance;
use super::measure::Measure;
use super::names;
use super::offers::Offers;
use crate::document::{DesignColumn, DesignValue, PageDesigns};
use powergs_study::analysis::Analysis;
use powergs_study::sweep::unit::Unit;

/// Columns besides those of the question, for conditions and the scatter.
const FURTHER: [&str; 8] = [
    "frame_time_ms.mean",
    "frame_time_ms.p99",
    "fps.mean",
    "power_w.mean",
    "energy_pj.mean",
    "area_mm2",
    "area_mm2.core",
    "dram_bytes",
];

/// Designs that a page has room for: half a megabyte of them.
const MOST: usize = 4000;

pub(super) fn of(analysis: &Analysis, provenance: &Provenance) -> PageDesigns {
    let table = &analysis.table;
    let mut measures = super::page::measures(analysis, false);
    let asked = measures.len();
    let others = FURTHER.into_iter().filter(|name| table.numbers(name).is_some());
    let others = others.filter(|name| measures.iter().all(|(known, _)| known != name));
    let others: Vec<_> = others.map(|name| (name.to_owned(), None)).collect();
    measures.extend(others);
    let mut columns: Vec<DesignColumn> = Vec::new();
    for (at, (name, _)) in measures.iter().enumerate() {
        let measure = Measure::of(name);
        let unit = Unit::of_column(name);
        columns.push(DesignColumn {
            name: name.clone(),
            short: measure.short(),
            title: measure.words.clone(),
            unit: unit.map(Unit::name).filter(|name| *name != "1").unwrap_or_default().to_owned(),
            si: unit.and_then(Unit::in_base),
            plot: at < asked,
            key: None,
        });
    }
    let keys: Vec<_> = table.axes.iter().chain(&table.followers).collect();
    let axes: Vec<&str> = keys.iter().map(|(name, _)| name.as_str()).collect();
    // Values of such an axis are names, and not those of a key.
    let is_named = |name: &str| {
        let hand_out = provenance.hand_out.as_ref();
        hand_out.is_some_and(|hand_out| hand_out.variants.contains_key(name))
    };
    for ((at, name), short) in axes.iter().enumerate().zip(names::short(&axes)) {
        columns.push(DesignColumn {
            name: (*name).to_owned(),
            short,
            title: (*name).to_owned(),
            key: (!is_named(name)).then(|| (*name).to_owned()),
            // Measures among them are in base units already.
            si: Some(1.0),
            plot: at < table.axes.len(),
            ..DesignColumn::default()
        });
    }
    let rows = rows(analysis);
    let mut written: BTreeMap<usize, BTreeMap<String, String>> = BTreeMap::new();
    let mut value = |at: usize, row: u32| {
        let Some((name, _)) = at.checked_sub(measures.len()).map(|axis| keys[axis]) else {
            return table.number(&measures[at].0, row).map(DesignValue::Number);
        };
        let all = table.axis(name).filter(|_| table.counts(name, row))?;
        let word = all.word(row);
        Some(match all.number(row) {
            Some(number) => {
                if word.parse() != Ok(number) {
                    written.entry(at).or_default().insert(number.to_string(), word.to_owned());
                }
                DesignValue::Number(number)
            }
            None => DesignValue::Text(word.to_owned()),
        })
    };
    let values = rows.iter().map(|&row| (0..columns.len()).map(|at| value(at, row)).collect());
    let values = values.collect();
    let front = |row: u32| analysis.front.contains(&row);
    let named = |row: u32| match row == analysis.knee {
        true => format!("{} {}", table.label(row), super::words::knee_name(analysis)),
        false => table.label(row),
    };
    let objectives = analysis.question.objectives.len();
    let Offers { base, trace, replays, offers, together } = match &provenance.hand_out {
        Some(hand_out) => Offers::of(analysis, hand_out, &rows),
        None => Offers::default(),
    };
    PageDesigns {
        base,
        trace,
        example: example(analysis, &measures[0].0),
        x: usize::from(objectives > 1),
        y: 0,
        colour: if axes.is_empty() { 0 } else { measures.len() },
        names: rows.iter().map(|&row| (named(row), front(row))).collect(),
        columns,
        rows: values,
        written,
        replays,
        offers,
        together,
    }
}

/// A condition that half of the front meets.
fn example(analysis: &Analysis, name: &str) -> String {
    let mut all: Vec<f64> =
        analysis.front.iter().filter_map(|&row| analysis.table.number(name, row)).collect();
    all.sort_by(f64::total_cmp);
    let middle = all.get(all.len() / 2).copied().unwrap_or(1.0);
    format!("{name} <= {}", crate::format::significant(middle))
}

/// The rows that are ranked, those of the front and the named one first.
fn rows(analysis: &Analysis) -> Vec<u32> {
    let mut rows: Vec<u32> = analysis.front.clone();
    rows.extend(analysis.named.as_ref().map(|named| named.row));
    rows.extend(analysis.baseline);
    rows.extend(&analysis.rows);
    let mut seen = std::collections::BTreeSet::new();
    rows.retain(|&row| seen.insert(row));
    rows.truncate(MOST);
    rows
}
