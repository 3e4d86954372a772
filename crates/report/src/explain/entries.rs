//! Everything that has a definition.

use std::collections::BTreeMap;

use powergs_base::config::Embedded;
use powergs_base::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES, SWEEPS, SYNTH};
use powergs_base::config::references::{cited, references};
use powergs_base::config::{KeyDoc, key_docs};
use powergs_core::flow;
use powergs_core::machine::Machine;
use powergs_core::sim::statistics;
use powergs_core::stage::{EnergyTable, Stall, hardware, stage};
use powergs_dram::Device;
use powergs_frame::display::Display;
use powergs_study::sweep::metric::metrics;
use powergs_study::sweep::table::{FIRST, LAST};

use super::assumption;
use crate::terms::terms;

/// Something that has a name, a unit and a definition.
pub struct Entry {
    /// What it is: `statistic`, `assumption`, ...
    pub kind: &'static str,
    /// Its name.
    pub name: String,
    /// Further names.
    pub others: Vec<String>,
    /// Unit; empty where it has none.
    pub unit: String,
    /// What it means.
    pub definition: String,
    /// What it has in the default file.
    pub value: Option<String>,
    /// What else is known.
    pub facts: Vec<(&'static str, String)>,
}

impl Entry {
    /// An entry with a name and a definition.
    pub fn new(
        kind: &'static str,
        name: impl Into<String>,
        unit: impl Into<String>,
        definition: impl Into<String>,
    ) -> Entry {
        Entry {
            kind,
            name: name.into(),
            others: Vec::new(),
            unit: unit.into(),
            definition: definition.into(),
            value: None,
            facts: Vec::new(),
        }
    }

    /// All names.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        [self.name.as_str()].into_iter().chain(self.others.iter().map(String::as_str))
    }

    /// Whether it is found by its whole name only.
    pub fn is_word(&self) -> bool {
        [WORD, assumption::KIND, SOURCE, FILE].contains(&self.kind)
    }
}

const WORD: &str = "term";
const SOURCE: &str = "source of numbers";
const FILE: &str = "file that comes with the program";

/// Keys of a kind of file.
pub struct Keys {
    /// What they are: `key of machine files`.
    pub kind: &'static str,
    /// The keys.
    pub docs: Vec<KeyDoc>,
    /// A file that has them.
    pub example: &'static Embedded,
}

/// All of them, and the keys of `further` kinds of files.
pub fn entries(further: impl IntoIterator<Item = Keys>) -> Vec<Entry> {
    let mut all: Vec<Entry> = terms()
        .map(|term| Entry {
            others: term.names[1..].iter().map(|name| (*name).to_owned()).collect(),
            ..Entry::new(WORD, term.names[0], term.unit, term.meaning)
        })
        .collect();
    all.extend(declared());
    all.extend(assumption::entries());
    all.extend(sources());
    let statistic = |s: &statistics::Statistic| {
        Entry::new("statistic", s.name.clone(), s.unit, s.definition.clone())
    };
    all.extend(statistics::catalogue().iter().map(statistic));
    all.extend(columns(&all));
    keys_of_machines(&mut all);
    let first = all.len();
    keys("key of energy tables", key_docs::<EnergyTable>(), &ENERGY[0], &mut all);
    for entry in &mut all[first..] {
        entry.facts.extend(prices(&entry.name).into_iter().map(|text| ("price", text)));
    }
    keys("key of DRAM devices", key_docs::<Device>(), &DRAM[0], &mut all);
    keys("key of display presets", key_docs::<Display>(), &DISPLAYS[0], &mut all);
    further.into_iter().for_each(|k| keys(k.kind, k.docs, k.example, &mut all));
    all
}

/// What stages declare: units, and what they wait for.
fn declared() -> Vec<Entry> {
    let mut all = Vec::new();
    let mut busy = Vec::new();
    for (id, unit) in hardware().units() {
        let entry = Entry::new(WORD, unit.key.to_uppercase(), "", stage(id).means);
        all.push(Entry { others: vec![unit.words.to_owned()], ..entry });
        busy.push(format!("{} busy", unit.key));
    }
    let share = "Share of the frame in which the unit works.";
    all.push(Entry { others: busy, ..Entry::new(WORD, "busy", "%", share) });
    for cause in Stall::all() {
        let words = cause.words();
        let why = format!("The unit waits because {}.", words.because);
        let others = vec![words.what.to_owned()];
        all.push(Entry { others, ..Entry::new(WORD, words.name, "%", why) });
    }
    all
}

/// What the tables that come with the program have for a price, with the source that each names.
fn prices(path: &str) -> Vec<String> {
    let mut tables: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for file in ENERGY {
        let table: toml::Table = file.complete().parse().unwrap_or_default();
        let table = toml::Value::Table(table);
        let price = path.split('.').try_fold(&table, |at, key| at.get(key));
        let price = price.and_then(toml::Value::as_table);
        let Some(source) = price.and_then(|price| price.get("source")?.as_str()) else { continue };
        let parts = price
            .into_iter()
            .flatten()
            .filter(|(key, value)| *key != "source" && !(value.is_table() || value.is_array()));
        let parts = parts.map(|(key, value)| match value.as_str() {
            Some(text) if key == "energy" => text.to_owned(),
            Some(text) => format!("{key} {text}"),
            None => format!("{key} = {value}"),
        });
        let parts: Vec<String> = parts.collect();
        let text = format!("{} (source: {source})", parts.join(", "));
        tables.entry(text).or_default().push(file.name);
    }
    tables.into_iter().map(|(text, names)| format!("{text} in {}", names.join(", "))).collect()
}

/// Columns of the results of sweeps that are not statistics themselves.
fn columns(known: &[Entry]) -> Vec<Entry> {
    let kind = "column of results.csv of a sweep";
    let first = FIRST.iter().map(|(name, _, what)| Entry::new(kind, *name, "", *what));
    let metrics =
        metrics().iter().map(|m| Entry::new(kind, m.name.clone(), m.unit, m.definition.clone()));
    let last = LAST.iter().map(|(name, unit, what)| Entry::new(kind, *name, *unit, *what));
    first
        .chain(metrics)
        .chain(last)
        .filter(|e| known.iter().all(|k| k.is_word() || k.name != e.name))
        .collect()
}

/// The sources of `references.toml`, and the files that cite them.
fn sources() -> Vec<Entry> {
    let all = [MACHINES, ENERGY, DISPLAYS, DRAM].concat();
    let all: Vec<_> = all.iter().map(|file| (file.name, cited(&file.complete()))).collect();
    let entry = |(key, source): (&String, &powergs_base::config::references::Reference)| {
        let citing = all.iter().filter(|(_, cited)| cited.contains(key)).map(|(name, _)| *name);
        let mut facts = vec![("venue", source.venue.clone())];
        facts.extend(source.doi.clone().map(|doi| ("DOI", doi)));
        facts.extend(source.link().map(|link| ("link", link)));
        facts.extend(source.note.clone().map(|note| ("taken", note)));
        facts.push(("cited by", citing.collect::<Vec<_>>().join(", ")));
        Entry { facts, ..Entry::new(SOURCE, key.clone(), "", source.title.clone()) }
    };
    let files = [MACHINES, ENERGY, DISPLAYS, DRAM, SWEEPS, SYNTH].concat();
    let described = files.into_iter().map(|file| {
        let table: toml::Table = file.text.parse().unwrap_or_default();
        let text = table.get("description").or_else(|| table.get("question"));
        let text = text.and_then(toml::Value::as_str).unwrap_or_default();
        Entry::new(FILE, file.name, "", text)
    });
    references().iter().map(entry).chain(described).collect()
}

/// Keys of machine files, each with its value in the first file that has such a key.
fn keys_of_machines(all: &mut Vec<Entry>) {
    let mut docs = key_docs::<Machine>();
    let flow_of = |doc: &KeyDoc| flow::of_table(doc.path.split(['.', '[']).next().unwrap_or(""));
    while !docs.is_empty() {
        let flow = flow_of(&docs[0]).map(|flow| flow.key());
        let is_same = |doc: &KeyDoc| flow_of(doc).map(|flow| flow.key()) == flow;
        let count = docs.iter().take_while(|doc| is_same(doc)).count();
        let example = flow.and_then(|key| flow::example(flow::named(key).ok()?));
        let own = docs.drain(..count).collect();
        keys("key of machine files", own, example.unwrap_or(&MACHINES[0]), all);
    }
}

fn keys(kind: &'static str, docs: Vec<KeyDoc>, example: &Embedded, all: &mut Vec<Entry>) {
    let values: toml::Table = example.complete().parse().unwrap_or_default();
    let values = toml::Value::Table(values);
    all.extend(docs.into_iter().map(|doc| {
        let value = doc.path.split('.').try_fold(&values, |at, key| at.get(key));
        let value = value.filter(|v| !(v.is_table() || v.is_array()));
        let value = value.map(|v| format!("{} in {}", v, example.name));
        Entry { value, ..Entry::new(kind, doc.path, doc.unit, doc.definition) }
    }));
}
