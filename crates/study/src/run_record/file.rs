//! The record of a run, the contents of `run.toml`: what the numbers of a report folder depend on,
//! and nothing else: no time, no place, so that the same inputs give the same bytes.

use toml::{Table, Value};

use super::{Run, SCHEMA_VERSION, hash_text};
use powergs_core::sim::made_by;

/// Versions, run, inputs with checksums, configuration as resolved.
pub fn record(run: &Run) -> Table {
    let facts = &run.facts;
    let mut root = Table::new();
    root.insert("schema-version".into(), i64::from(SCHEMA_VERSION).into());
    made_by(&mut root);
    root.insert("model".into(), facts.model.name().into());
    root.insert("display-fps".into(), facts.display_fps.into());
    if let Some(ms) = facts.latency_ms {
        root.insert("latency-ms".into(), ms.into());
    }
    root.insert("incomplete".into(), run.incomplete().into());
    root.insert("frames-asked-for".into(), count(facts.trace.frames as u64));
    root.insert("frames-reported".into(), count(run.frames.len() as u64));
    let inputs = facts.inputs.iter().map(|input| {
        let mut table = Table::new();
        table.insert("role".into(), input.role.into());
        table.insert("name".into(), input.name.clone().into());
        table.insert("bytes".into(), count(input.bytes));
        table.insert("xxh3-128".into(), hash_text(input).into());
        Value::Table(table)
    });
    let (trace, machine) = (&facts.trace, &facts.machine);
    let mut table = Table::new();
    table.insert("trace".into(), trace.name.clone().into());
    table.insert("eyes".into(), count(trace.shown.eyes as u64));
    table.insert("width-px".into(), i64::from(trace.shown.width).into());
    table.insert("height-px".into(), i64::from(trace.shown.height).into());
    table.insert("machine".into(), machine.name.clone().into());
    table.insert("task".into(), machine.task.name().into());
    table.insert("energy-table".into(), machine.energy_table.clone().into());
    let left_out = machine.left_out.iter().map(|effect| Value::from(effect.what));
    table.insert("left-out".into(), Value::Array(left_out.collect()));
    let measures = [
        ("node-nm", machine.node_nm),
        ("clock-hz", machine.clock_hz),
        ("dram-peak-gb-s", machine.dram_peak_gb_s),
    ];
    for (key, value) in measures {
        if let Some(value) = value {
            table.insert(key.into(), value.into());
        }
    }
    root.insert("facts".into(), Value::Table(table));
    root.insert("inputs".into(), Value::Array(inputs.collect()));
    root.insert("configuration".into(), Value::Table(facts.configuration.clone()));
    root
}

/// TOML integers are signed; nothing that we count comes near 2⁶³.
fn count(n: u64) -> Value {
    Value::Integer(i64::try_from(n).unwrap_or(i64::MAX))
}
