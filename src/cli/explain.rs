//! `explain`: unit and definition of any statistic or configuration key.

use serde_json::{Value, json};

use super::{Context, Exit, Failure, out};
use powergs_base::config::Embedded;
use powergs_base::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES};
use powergs_base::config::suggest::nearest;
use powergs_base::config::{KeyDoc, key_docs};
use powergs_core::accel::Machine;
use powergs_core::dram::Device;
use powergs_core::energy::EnergyTable;
use powergs_core::sim::statistics;
use powergs_frame::display::Display;
use powergs_report::document::Document;

/// Shown under `explain --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim explain vru.cores
  powergs-sim explain frame_time_ms
  powergs-sim explain dram";

/// Arguments of `explain`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A statistic (`power_w.total`), a configuration key (`vru.cores`), or the start of several
    /// (`dram`)
    pub name: String,
}

/// Something that has a name, a unit and a definition.
struct Entry {
    kind: &'static str,
    name: String,
    unit: String,
    definition: String,
    default: Option<String>,
}

/// Prints what is known about a name.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let entries = entries();
    let found = matching(&entries, statistics::name_in(&args.name));
    if found.is_empty() {
        let near = nearest(&args.name, entries.iter().map(|e| e.name.as_str()));
        let hint = near.map_or_else(
            || "docs/results.md lists the statistics, arch-configs/README.md the keys".to_owned(),
            |n| format!("did you mean `{n}`?"),
        );
        let message = format!("no statistic or configuration key `{}`; {hint}", args.name);
        return Err(Failure::new(Exit::Usage, message));
    }
    if context.global.json {
        return out::json(&found.iter().map(|e| as_json(e)).collect::<Vec<_>>())
            .map(|()| Exit::Done);
    }
    out::document(&document(&found)).map(|()| Exit::Done)
}

/// Every name with its definition.
pub fn names() -> Vec<(String, String)> {
    entries().into_iter().map(|e| (e.name, e.definition)).collect()
}

/// The entry of this name, or all under it (`vru`: `vru.cores`, ...), or of this last part.
fn matching<'a>(entries: &'a [Entry], name: &str) -> Vec<&'a Entry> {
    let plain = |s: &str| s.to_lowercase().replace('-', "_").replace("[]", "");
    let name = plain(name.trim());
    let tests: [&dyn Fn(&str) -> bool; 3] =
        [&|n| n == name, &|n| n.starts_with(&format!("{name}.")), &|n| {
            n.ends_with(&format!(".{name}"))
        }];
    let mut found: Vec<&Entry> = Vec::new();
    for test in tests {
        found.extend(entries.iter().filter(|e| test(&plain(&e.name))));
        if found.iter().any(|e| e.unit != "table") {
            break;
        }
    }
    found
}

fn entries() -> Vec<Entry> {
    let mut all: Vec<Entry> = statistics::catalogue()
        .iter()
        .map(|s| Entry {
            kind: "statistic",
            name: s.name.clone(),
            unit: s.unit.to_owned(),
            definition: s.definition.clone(),
            default: None,
        })
        .collect();
    keys("key of machine files", key_docs::<Machine>(), &MACHINES[0], &mut all);
    keys("key of energy tables", key_docs::<EnergyTable>(), &ENERGY[0], &mut all);
    keys("key of DRAM devices", key_docs::<Device>(), &DRAM[0], &mut all);
    keys("key of display presets", key_docs::<Display>(), &DISPLAYS[0], &mut all);
    all
}

fn keys(kind: &'static str, docs: Vec<KeyDoc>, example: &Embedded, all: &mut Vec<Entry>) {
    let values: toml::Table = example.text.parse().unwrap_or_default();
    let values = toml::Value::Table(values);
    all.extend(docs.into_iter().map(|doc| {
        let value = doc.path.split('.').try_fold(&values, |at, key| at.get(key));
        let default = value.filter(|v| !(v.is_table() || v.is_array()));
        let default = default.map(|v| format!("{} in {}", v, example.name));
        Entry { kind, name: doc.path, unit: doc.unit, definition: doc.definition, default }
    }));
}

fn as_json(entry: &Entry) -> Value {
    json!({
        "kind": entry.kind,
        "name": entry.name,
        "unit": entry.unit,
        "definition": entry.definition,
        "value": entry.default,
    })
}

fn document(entries: &[&Entry]) -> Document {
    let mut page = Document::new();
    for entry in entries {
        page.heading(format!("{}  ({})", entry.name, entry.kind));
        let facts = [("unit", Some(&entry.unit)), ("value", entry.default.as_ref())];
        let facts = facts.into_iter().filter_map(|(name, value)| Some((name, value?.as_str())));
        page.facts(facts.chain([("", entry.definition.as_str())]).filter(|f| !f.1.is_empty()));
    }
    page
}
