//! The comparison for programs: JSON, CSV, and what it was made from.

use serde_json::{Map, Value as Json, json};
use toml::Value;

use super::note;
use crate::ReportError;
use crate::document::{Cell, Column, Table};
use powergs_base::TOOL_VERSION;
use powergs_core::sim::statistics::{catalogue, shown};
use powergs_core::sim::{MODEL_VERSION, made_by};
use powergs_study::findings::bottleneck;
use powergs_study::findings::compare::{Better, Comparison, Decision, DecisionRow, Side};
use powergs_study::run_record::SCHEMA_VERSION;
use powergs_study::speedup::SpeedUp;

/// The comparison as one object: sides, measures with ratios and differences to the first side,
/// means of all statistics.
pub fn json(comparison: &Comparison) -> Json {
    let sides: Vec<Json> = comparison
        .sides
        .iter()
        .map(|s| {
            json!({
                "label": s.label,
                "machine": s.machine,
                "task": s.task.name(),
                "area_scope": if s.is_block { "block" } else { "chip" },
                "power_scope": s.power_scope,
                "energy_table": s.energy_table,
                "node_nm": s.node_nm,
                "model": s.model,
                "trace": s.trace,
                "trace_xxh3_128": s.trace_hash,
                "tool_version": s.tool_version,
                "model_version": s.model_version,
                "fps": s.display_fps,
                "frames": s.frames,
                "eyes": s.shown.eyes,
                "incomplete": s.incomplete,
                "bottleneck": crate::json::bottleneck_json(bottleneck::of(&s.statistics).as_ref()),
            })
        })
        .collect();
    let n = comparison.sides.len();
    let measures: Vec<Json> = comparison
        .rows
        .iter()
        .map(|m| {
            json!({
                "name": m.measure.name(),
                "better": match m.measure.better() {
                    Better::Less => Some("less"),
                    Better::More => Some("more"),
                    Better::Neither => None,
                },
                "values": m.values,
                "ratios": (0..n).map(|i| m.ratio(i)).collect::<Vec<_>>(),
                "differences": (0..n).map(|i| m.difference(i)).collect::<Vec<_>>(),
            })
        })
        .collect();
    let basis = comparison.basis();
    let basis = basis.iter().map(|(part, values)| json!({ "name": part.name(), "values": values }));
    let mut statistics = Map::new();
    for i in shown_of(comparison) {
        statistics.insert(catalogue()[i].name.clone(), json!(means(comparison, i)));
    }
    json!({
        "schema_version": SCHEMA_VERSION,
        "tool_version": TOOL_VERSION,
        "model_version": MODEL_VERSION,
        "sides": sides,
        "basis": basis.collect::<Vec<_>>(),
        "notes": comparison.notes.iter().map(note).collect::<Vec<_>>(),
        "measures": measures,
        "means": statistics,
    })
}

/// What `compare --json` prints: of one trace its comparison, of several the speed-ups and the
/// comparison of each; with both who meets what.
pub fn json_of(all: &[Comparison], decision: &Decision, speedup: Option<&SpeedUp>) -> Json {
    match speedup {
        Some(speedup) => json!({
            "decision": decision_json(all, decision, &speedup.traces),
            "speedup": crate::speedup::json(speedup),
            "traces": all.iter().map(json).collect::<Vec<_>>(),
        }),
        None => {
            let trace = std::slice::from_ref(&all[0].sides[0].trace);
            let mut found = json(&all[0]);
            found["decision"] = decision_json(all, decision, trace);
            found
        }
    }
}

/// Who meets what, as a list: a row a trace and machine.
pub fn decision_json(all: &[Comparison], decision: &Decision, traces: &[String]) -> Json {
    let row = |row: &DecisionRow| {
        let side = &all[row.trace].sides[row.side];
        json!({
            "trace": traces[row.trace],
            "machine": side.label,
            "task": side.task.name(),
            "fps": row.fps,
            "slowest_ms": row.slowest_ms,
            "latency_ms": row.latency_ms,
            "missed": row.missed,
            "frames": row.frames,
            "power_w": row.power_w,
            "area_mm2": row.area_mm2,
            "is_met": row.is_met(),
            "verdict": super::decision::verdict(row, side, decision.has_limits),
            "node_nm": side.node_nm,
            "power_scope": side.power_scope,
        })
    };
    Json::Array(decision.rows.iter().map(row).collect())
}

/// Frames or steps a second at which its power is drawn: the display rate or what is reached of it.
fn at_fps(row: &DecisionRow, side: &Side) -> Option<f64> {
    if !side.task.is_shown() {
        return row.fps;
    }
    row.fps.map(|_| side.statistics.displayed_fps())
}

/// `decision.csv`: the same.
pub fn decision_csv(all: &[Comparison], decision: &Decision, traces: &[String]) -> Vec<u8> {
    let mut table = Table::record(
        "trace machine task fps slowest_ms latency_ms missed frames power_w power_at_fps area_mm2 \
         node_nm power_scope is_met verdict",
    );
    for row in &decision.rows {
        let side = &all[row.trace].sides[row.side];
        table.row([
            traces[row.trace].as_str().into(),
            side.label.as_str().into(),
            side.task.name().into(),
            row.fps.into(),
            row.slowest_ms.into(),
            row.latency_ms.into(),
            row.missed.map(|n| n as f64).into(),
            Cell::from(Some(row.frames as f64)),
            row.power_w.into(),
            at_fps(row, side).into(),
            row.area_mm2.into(),
            side.node_nm.into(),
            side.power_scope.as_str().into(),
            row.is_met().to_string().into(),
            super::decision::verdict(row, side, decision.has_limits).unwrap_or_default().into(),
        ]);
    }
    table.csv()
}

/// `compare.csv`: a row per measure and per statistic (means); a column per side, then per ratio
/// to the first.
pub fn compare_csv(comparison: &Comparison) -> Vec<u8> {
    let mut table = csv_head(comparison, &["kind", "name"]);
    csv_rows(&mut table, comparison, &[]);
    table.csv()
}

/// As [`compare_csv`], of machines on several traces, whose names are the first column.
pub fn compare_csv_of(all: &[Comparison], traces: &[String]) -> Vec<u8> {
    let mut table = csv_head(&all[0], &["trace", "kind", "name"]);
    for (comparison, trace) in all.iter().zip(traces) {
        csv_rows(&mut table, comparison, &[trace.as_str().into()]);
    }
    table.csv()
}

fn csv_head(comparison: &Comparison, names: &[&str]) -> Table {
    let labels = comparison.labels();
    let ratios = labels[1..].iter().map(|l| format!("{l}/{}", labels[0]));
    let names = names.iter().chain(&labels).map(|name| (*name).to_owned());
    Table::new(names.chain(ratios).map(Column::text))
}

fn csv_rows(table: &mut Table, comparison: &Comparison, first: &[Cell]) {
    let n = comparison.sides.len();
    let mut row =
        |kind: &str, name: &str, values: &[Option<f64>], ratio: &dyn Fn(usize) -> Option<f64>| {
            let numbers = values.iter().copied().chain((1..n).map(ratio)).map(Cell::from);
            let names = first.iter().cloned().chain([kind.into(), name.into()]);
            table.row(names.chain(numbers));
        };
    for m in &comparison.rows {
        row("measure", m.measure.name(), &m.values, &|i| m.ratio(i));
    }
    for i in shown_of(comparison) {
        let name = &catalogue()[i].name;
        row("mean", name, &means(comparison, i), &|i| comparison.ratio_of(name, i));
    }
}

/// What one of the sides may have, by places in the catalogue.
fn shown_of(comparison: &Comparison) -> Vec<usize> {
    shown(|i| comparison.sides.iter().any(|side| side.statistics.aggregates[i].is_some()))
}

/// Means of a statistic, by its place in the catalogue; one a side.
fn means(comparison: &Comparison, at: usize) -> Vec<Option<f64>> {
    let mean = |side: &Side| Some(side.statistics.aggregates[at]?.mean);
    comparison.sides.iter().map(mean).collect()
}

/// `run.toml`: versions, and the record of every side.
///
/// # Errors
/// [`ReportError::Toml`], which would be a mistake of ours.
pub fn run_toml(comparison: &Comparison) -> Result<String, ReportError> {
    run_toml_of(std::slice::from_ref(comparison))
}

/// As [`run_toml`], of machines on several traces.
///
/// # Errors
/// As [`run_toml`].
pub fn run_toml_of(all: &[Comparison]) -> Result<String, ReportError> {
    let mut root = toml::Table::new();
    root.insert("schema-version".into(), i64::from(SCHEMA_VERSION).into());
    made_by(&mut root);
    let side = |s: &Side| {
        let mut table = toml::Table::new();
        table.insert("label".into(), s.label.clone().into());
        table.insert("record".into(), Value::Table(s.record.clone()));
        Value::Table(table)
    };
    root.insert(
        "sides".into(),
        Value::Array(all.iter().flat_map(|c| &c.sides).map(side).collect()),
    );
    let head = "# What was compared: the record of every side. What was typed: invocation.toml.\n";
    Ok(format!("{head}{}", toml::to_string_pretty(&root)?))
}
