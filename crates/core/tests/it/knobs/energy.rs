//! Every key of every energy table: the same frame, priced again.

use powergs_base::config::embedded::{ENERGY, Embedded};
use powergs_base::config::{key_docs, knob};
use powergs_core::machine::Machine;
use powergs_core::run::system::doubts;
use powergs_core::sim::{FrameReport, cost};
use powergs_core::stage::{EnergyTable, hardware};
use powergs_dram::{DramCommands, StageCommands};
use powergs_energy::Activity;
use powergs_energy::{Area, EnergyBreakdown, Prices};
use toml::{Table, Value};

use super::Verdict;
use super::inert::list;
use super::support::outcome;
use crate::energy::unlike;

/// Text for people, and names of rows.
const TEXT: [&str; 5] =
    ["name", "description", "numbers.formats[].numbers", "scope.area", "scope.power"];

#[derive(Debug, PartialEq)]
struct Costs {
    energy: EnergyBreakdown,
    area: Option<Area>,
    prices: Prices,
    doubts: Vec<String>,
}

/// What a frame costs on a machine that has everything.
fn costs(text: &str, machine: &Machine, frame: &FrameReport) -> Result<Costs, String> {
    let table = EnergyTable::parse(text).map_err(|e| e.to_string())?;
    let prices = cost::prices(&table, machine).map_err(|e| e.to_string())?;
    let work = StageCommands { reads: 1000, writes: 100, activates: 300 };
    let energy = prices.breakdown(&Activity {
        actions: &frame.actions,
        seconds: 1e-4,
        idle: &vec![0.3; hardware().units().count()],
        dram: Some(DramCommands { stages: [work; 3], refreshes: 7, ..DramCommands::default() }),
    });
    Ok(Costs { energy, area: prices.area.clone(), prices, doubts: doubts(machine, &table) })
}

fn named(name: &str) -> &'static Embedded {
    ENERGY.iter().find(|f| f.name == name).expect("a table that comes with the program")
}

/// Leaves of a table, lists with `[]`.
fn leaves(table: &Table, prefix: &str, found: &mut Vec<String>) {
    for (key, value) in table {
        let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            Value::Table(inner) => leaves(inner, &path, found),
            Value::Array(items) => {
                let first = items.first().and_then(Value::as_table);
                leaves(first.unwrap_or(&Table::new()), &format!("{path}[]"), found);
            }
            _ => found.push(path),
        }
    }
}

fn dead_keys(file: &Embedded) -> Vec<String> {
    let needs_commands = file.complete().contains("device = true");
    let model = if needs_commands { "banked" } else { "bandwidth" };
    let parsed = EnergyTable::parse(file.text).expect("a table that comes with the program");
    let on = |lift: &[String]| {
        let sets = [&[format!("dram.model={model}")], lift].concat();
        unlike(&parsed, &sets)
    };
    let machines = on(&[]);
    let frame = |machine: &Machine| outcome(machine).expect("prices").frames.swap_remove(0);
    let frames: Vec<FrameReport> = machines.iter().map(frame).collect();
    let table: Table = file.complete().parse().expect("TOML");
    let (docs, list) = (key_docs::<EnergyTable>(), list());
    let mut keys = Vec::new();
    leaves(&table, "", &mut keys);
    let is_dead_on = |key: &str, machine: &Machine, frame: &FrameReport| {
        let base = costs(file.text, machine, frame).expect("the table itself");
        let unit = docs.iter().find(|d| d.path == key).map_or("", |d| &d.unit);
        let value = knob::values(&table, key).swap_remove(0);
        let is_source = key.ends_with("source") || key.ends_with("fit");
        let tried = if is_source {
            vec!["nobody".into()]
        } else {
            knob::others(&value, &knob::choices(unit))
        };
        assert!(!tried.is_empty(), "{}: {key}: nothing to try", file.name);
        let verdict = |new: &Value| {
            let mut table = table.clone();
            knob::change(&mut table, key, &mut |old| {
                // A list is scaled item by item.
                if key.contains("[]") { knob::others(old, &[]).pop() } else { Some(new.clone()) }
            });
            match costs(&table.to_string(), machine, frame) {
                Ok(new) => Verdict::of(new != base),
                Err(e) => Verdict::of_error(&e, key, new),
            }
        };
        !Verdict::is_alive(&tried.iter().map(verdict).collect::<Vec<_>>(), false)
    };
    let is_dead = |key: &str, machines: &[Machine]| {
        machines.iter().zip(&frames).all(|(machine, frame)| is_dead_on(key, machine, frame))
    };
    let dead = |key: &String| {
        let inert = list.get("energy").and_then(|l| l.get(key));
        !TEXT.contains(&key.as_str())
            && is_dead(key, &machines)
            && inert.is_none_or(|inert| match &inert.lift_file {
                None => is_dead(key, &on(&inert.lift)),
                Some(other) => {
                    assert_ne!(other, file.name, "{key}: the condition is not lifted");
                    dead_keys(named(other)).iter().any(|dead| dead.ends_with(&format!(": {key}")))
                }
            })
    };
    keys.into_iter().filter(dead).map(|key| format!("{}: {key}", file.name)).collect()
}

#[test]
fn every_key_of_every_energy_table_moves_something() {
    let dead: Vec<String> = ENERGY.iter().flat_map(dead_keys).collect();
    assert!(dead.is_empty(), "nothing moved: {dead:#?}");
}
