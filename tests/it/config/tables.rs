//! The tables of keys in `arch-configs/README.md`: written from what the program knows about keys.
//! Of a machine's key alone the last cell, what the key moves, is written by hand and kept.

use std::collections::BTreeMap;
use std::path::Path;

use expect_test::expect_file;
use powergs_sim::config::embedded::{DISPLAYS, MACHINES, SYNTH};
use powergs_sim::config::inert::inert;
use powergs_sim::config::schema::leaves;
use powergs_sim::config::{Embedded, KeyDoc, key_docs_of, schema_of};
use powergs_sim::display::Display;
use powergs_sim::dram::Device;
use powergs_sim::flow::{self, Dataflow};
use powergs_sim::machine::Machine;
use powergs_sim::scene::synth::Preset;
use powergs_sim::stage::EnergyTable;
use serde_json::Value;

/// What stands around a table, the first with its name.
const BEGIN: &str = "<!-- Keys, from their doc comments (UPDATE_EXPECT=1 cargo test tables): ";
const END: &str = "<!-- end of keys -->";

/// Keys that a price consists of.
const OF_PRICE: [&str; 10] =
    ["energy", "flops", "power", "free", "source", "area", "fit", "factor", "share", "at"];

#[test]
fn the_readme_has_the_tables_of_all_keys() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("arch-configs/README.md");
    let readme = std::fs::read_to_string(&path).expect("the README");
    let mut tables = tables();
    let mut text = String::new();
    let mut rest = readme.as_str();
    while let Some((before, after)) = rest.split_once(BEGIN) {
        let (name, after) = after.split_once(" -->\n").expect("the end of the comment");
        let (old, after) = after.split_once(END).expect("the end of the table");
        let table = tables.remove(name).unwrap_or_else(|| panic!("no table {name}, or twice"));
        text += &format!("{before}{BEGIN}{name} -->\n\n{}\n{END}", table(old));
        rest = after;
    }
    text += rest;
    expect_file![path].assert_eq(&text);
    assert!(tables.is_empty(), "arch-configs/README.md lacks {:?}", tables.into_keys());
    let silent = text.lines().filter(|row| row.starts_with("| `") && row.ends_with("|  |"));
    assert_eq!(silent.collect::<Vec<&str>>(), [""; 0], "say in the last cell what the key moves");
}

/// All tables by their names, each a function of the one that is there.
type Tables = BTreeMap<String, Box<dyn Fn(&str) -> String>>;

fn tables() -> Tables {
    let mut all = Tables::new();
    let mut add = |name: &str, table: String| {
        all.insert(name.to_owned(), Box::new(move |_: &str| table.clone()));
    };
    add("display presets", Keys::of(&schema_of::<Display>()).with_values(&DISPLAYS[0]));
    add("synthetic scenes", Keys::of(&schema_of::<Preset>()).with_values(&SYNTH[0]));
    add("DRAM devices", Keys::of(&schema_of::<Device>()).without_values());
    let energy = Keys::of(&schema_of::<EnergyTable>());
    add("prices", energy.prices());
    add("energy tables", energy.without_values());
    add("that move nothing", inert_table());
    for flow in flow::all() {
        let table = move |old: &str| Keys::of_machine(flow).with_values_and_moves(flow, old);
        all.insert(format!("of {} machines", flow.key()), Box::new(table));
    }
    all
}

/// The keys of a file.
struct Keys {
    docs: Vec<KeyDoc>,
    /// Schemas of those that have a value.
    leaves: BTreeMap<String, Value>,
}

impl Keys {
    fn of(schema: &Value) -> Keys {
        Keys { docs: key_docs_of(schema), leaves: leaves(schema).into_iter().collect() }
    }

    /// Those of a dataflow, and with the first one, where they are in files, those that all
    /// machines have.
    fn of_machine(flow: &dyn Dataflow) -> Keys {
        let mut own = Keys::of(&(flow.tables().schema)());
        own.docs.retain(|doc| !doc.table);
        let first = flow::all().next().expect("a dataflow");
        if flow.key() != first.key() {
            return own;
        }
        let mut all = Keys::of(&schema_of::<Machine>());
        let flow_of = |doc: &KeyDoc| flow::of_table(doc.path.split('.').next().expect("a key"));
        let at = all.docs.iter().position(|doc| flow_of(doc).is_some()).expect("its tables");
        all.docs.retain(|doc| !doc.table && flow_of(doc).is_none());
        all.docs.splice(at..at, own.docs);
        all.leaves.extend(own.leaves);
        all
    }

    fn leaf(&self, path: &str) -> Option<&Value> {
        self.leaves.get(path.strip_suffix("[]").unwrap_or(path))
    }

    /// What a price consists of; nothing where a key is no price.
    fn of_price(&self, path: &str) -> Vec<&KeyDoc> {
        let inner = |doc: &&KeyDoc| doc.path.rsplit_once('.').is_some_and(|(of, _)| of == path);
        let inner: Vec<&KeyDoc> = self.docs.iter().filter(inner).collect();
        let is_price = inner.iter().all(|doc| OF_PRICE.contains(&last(doc)));
        if is_price { inner } else { Vec::new() }
    }

    /// Those that are not inside of a price.
    fn rows(&self) -> impl Iterator<Item = &KeyDoc> {
        let is_inner = |doc: &KeyDoc| {
            doc.path.rsplit_once('.').is_some_and(|(of, _)| !self.of_price(of).is_empty())
        };
        self.docs.iter().filter(move |doc| !is_inner(doc))
    }

    /// The unit with the range, names in quotes, or the keys of a price.
    fn unit(&self, doc: &KeyDoc) -> String {
        let price = self.of_price(&doc.path);
        if !price.is_empty() {
            let keys = price.iter().map(|doc| format!("`{}`", last(doc)));
            return keys.collect::<Vec<String>>().join(", ");
        }
        let choices = doc.choices();
        if !choices.is_empty() {
            let names = choices.iter().map(|name| format!("`\"{name}\"`"));
            return names.collect::<Vec<String>>().join(", ");
        }
        // The page says once how quantities are written.
        let unit = doc.unit.split(" (").next().expect("a first part");
        let unit = unit.strip_prefix("a ").or(unit.strip_prefix("an ")).unwrap_or(unit);
        let leaf = self.leaf(&doc.path);
        let limit = |key: &str| leaf.and_then(|leaf| leaf.get(key)?.as_f64());
        let least = limit("minimum").unwrap_or(0.0);
        match limit("maximum") {
            Some(most) => format!("{unit}, {least} to {most}"),
            None if least > 0.0 => format!("{unit}, from {least}"),
            None => unit.to_owned(),
        }
    }

    /// The value in `example`, or the default.
    fn value(&self, doc: &KeyDoc, example: &toml::Value) -> String {
        let value = doc.path.split('.').try_fold(example, |at, key| at.get(key));
        let default = self.leaf(&doc.path).and_then(|leaf| leaf.get("default"));
        match (value, default) {
            _ if doc.table => String::new(),
            (Some(value), _) => format!("`{value}`"),
            (None, Some(default)) if !default.is_null() => format!("not there: `{default}`"),
            (None, _) => "not there".to_owned(),
        }
    }

    fn without_values(&self) -> String {
        let rows = self.rows().map(|doc| row(&[&key(doc), &self.unit(doc), &doc.definition]));
        head(&["key", "unit", "meaning"]) + &rows.collect::<String>()
    }

    fn with_values(&self, example: &Embedded) -> String {
        let values = values(example);
        let cells = |doc| [key(doc), self.unit(doc), self.value(doc, &values)];
        let rows = self.rows().map(|doc| {
            let [key, unit, value] = cells(doc);
            row(&[&key, &unit, &value, &doc.definition])
        });
        let value = format!("in {}", example.name);
        head(&["key", "unit", &value, "meaning"]) + &rows.collect::<String>()
    }

    /// What the keys of prices say, each as often as it says something else.
    fn prices(&self) -> String {
        let inner = self.docs.iter().flat_map(|doc| self.of_price(&doc.path));
        let cells = |doc: &KeyDoc| (format!("`*.{}`", last(doc)), self.unit(doc));
        let mut rows: Vec<String> = Vec::new();
        for doc in inner {
            let (key, unit) = cells(doc);
            let row = row(&[&key, &unit, &doc.definition]);
            if !rows.contains(&row) {
                rows.push(row);
            }
        }
        rows.sort_by_key(|row| OF_PRICE.iter().position(|key| row.contains(&format!(".{key}`"))));
        head(&["key", "unit", "meaning"]) + &rows.concat()
    }

    /// With what the rows of the `old` table say in their last cells.
    fn with_values_and_moves(&self, flow: &dyn Dataflow, old: &str) -> String {
        let moves: BTreeMap<&str, &str> = old.lines().filter_map(first_and_last).collect();
        let example = flow::example(flow);
        let values = values(example.unwrap_or(&MACHINES[0]));
        let rows = self.docs.iter().map(|doc| {
            let key = key(doc);
            let moves = moves.get(key.as_str()).unwrap_or(&"");
            row(&[&key, &self.unit(doc), &self.value(doc, &values), &doc.definition, moves])
        });
        let value = format!("in {}", example.map_or("a file", |file| file.name));
        head(&["key", "unit", &value, "meaning", "what it moves"]) + &rows.collect::<String>()
    }
}

fn inert_table() -> String {
    let rows = inert().iter().flat_map(|(kind, keys)| {
        keys.iter().map(move |(key, inert)| row(&[kind, &format!("`{key}`"), &inert.when]))
    });
    head(&["file", "key", "nothing moves where"]) + &rows.collect::<String>()
}

fn values(example: &Embedded) -> toml::Value {
    toml::Value::Table(example.complete().parse().expect(example.name))
}

fn last(doc: &KeyDoc) -> &str {
    doc.path.rsplit('.').next().expect("a last part")
}

fn key(doc: &KeyDoc) -> String {
    format!("`{}`", doc.path)
}

fn head(cells: &[&str]) -> String {
    format!("{}|{}\n", row(cells), "---|".repeat(cells.len()))
}

fn row(cells: &[&str]) -> String {
    // A bar would end a cell.
    let cells = cells.iter().map(|cell| cell.replace('|', "\\|"));
    format!("| {} |\n", cells.collect::<Vec<String>>().join(" | "))
}

/// The first cell of a row and the last one.
fn first_and_last(row: &str) -> Option<(&str, &str)> {
    let row = row.strip_prefix("| ")?.strip_suffix(" |")?;
    Some((row.split_once(" | ")?.0, row.rsplit_once(" | ")?.1))
}
