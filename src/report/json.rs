//! `--json`: the whole run as one object. `docs/report.schema.json` describes it.

use serde_json::{Map, Value as Json, json};

use super::{MODEL_VERSION, Run, SCHEMA_VERSION, TOOL_VERSION, Table};
use crate::sim::statistics::{Aggregate, Value, catalogue};

/// The run as JSON. Statistics are nested by the dots of their names; what was not measured is
/// null.
pub fn report(run: &Run, table: &Table) -> Json {
    let facts = &run.facts;
    let frames: Vec<Json> =
        run.frames.iter().zip(&table.rows).map(|(frame, row)| self::frame(frame, row)).collect();
    json!({
        "schema_version": SCHEMA_VERSION,
        "tool_version": TOOL_VERSION,
        "model_version": MODEL_VERSION,
        "model": facts.model.name(),
        "machine": {
            "name": facts.machine.name,
            "energy_table": facts.machine.energy_table,
            "clock_hz": facts.machine.clock_hz,
            "dram_peak_gb_s": facts.machine.dram_peak_gb_s,
        },
        "trace": {
            "name": facts.trace.name,
            "frames": facts.trace.frames,
            "width_px": facts.trace.width,
            "height_px": facts.trace.height,
        },
        "inputs": facts.inputs.iter().map(|input| json!({
            "role": input.role,
            "name": input.name,
            "bytes": input.bytes,
            "xxh3_128": format!("{:032x}", input.xxh3),
        })).collect::<Vec<_>>(),
        "fps": facts.display_fps,
        "incomplete": run.incomplete(),
        "throughput_fps": table.throughput_fps,
        "throughput_power_w": table.throughput_power_w,
        "deadline_misses": table.deadline_misses,
        "aggregate": aggregates(table),
        "frames": frames,
    })
}

fn frame(frame: &crate::sim::FrameReport, row: &[Option<Value>]) -> Json {
    let mut map = Map::new();
    map.insert("frame".into(), frame.frame.into());
    map.insert("name".into(), frame.name.clone().into());
    for (statistic, value) in catalogue().iter().zip(row) {
        nest(&mut map, &statistic.name, value.map_or(Json::Null, number));
    }
    Json::Object(map)
}

fn aggregates(table: &Table) -> Json {
    let mut map = Map::new();
    for (statistic, aggregate) in catalogue().iter().zip(&table.aggregates) {
        let value = aggregate.as_ref().map_or(Json::Null, |a| {
            let parts = Aggregate::PARTS.iter().zip(a.parts());
            Json::Object(parts.map(|(name, v)| ((*name).to_owned(), number(v))).collect())
        });
        nest(&mut map, &statistic.name, value);
    }
    Json::Object(map)
}

fn number(value: Value) -> Json {
    match value {
        Value::Count(n) => n.into(),
        Value::Real(x) => x.into(),
    }
}

/// Puts `value` at a dotted path, making the objects on the way.
pub(super) fn nest(map: &mut Map<String, Json>, path: &str, value: Json) {
    match path.split_once('.') {
        None => {
            map.insert(path.to_owned(), value);
        }
        Some((head, rest)) => {
            let inner = map.entry(head).or_insert_with(|| Json::Object(Map::new()));
            let inner = inner.as_object_mut().expect("no statistic is the parent of another");
            nest(inner, rest, value);
        }
    }
}
