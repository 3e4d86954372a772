//! The files that a run was made from: which of them are others now.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use powergs_core::run::Input;
use toml::{Table, Value};

/// What is known of one content of an input.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct RecordedContent {
    hash: String,
    bytes: i64,
}

/// The inputs of a run, by role and name: several may share both.
#[derive(Debug, Default)]
pub(super) struct RecordedInputs(BTreeMap<(String, String), BTreeSet<RecordedContent>>);

impl RecordedInputs {
    /// All inputs that a `run.toml` has, those of its sides too.
    pub(super) fn of(record: &Table) -> RecordedInputs {
        let mut found = RecordedInputs::default();
        record.values().for_each(|value| found.add(value));
        found
    }

    fn add(&mut self, value: &Value) {
        match value {
            Value::Array(items) => items.iter().for_each(|item| self.add(item)),
            Value::Table(table) => {
                let text = |key: &str| table.get(key).and_then(Value::as_str);
                let (Some(name), Some(hash)) = (text("name"), text("xxh3-128")) else {
                    return table.values().for_each(|value| self.add(value));
                };
                let bytes = table.get("bytes").and_then(Value::as_integer).unwrap_or(0);
                let content = RecordedContent { hash: hash.to_owned(), bytes };
                let key = (text("role").unwrap_or("input").to_owned(), name.to_owned());
                self.0.entry(key).or_default().insert(content);
            }
            Value::String(_)
            | Value::Integer(_)
            | Value::Float(_)
            | Value::Boolean(_)
            | Value::Datetime(_) => {}
        }
    }

    /// Files among `values`, which were typed in `place`, whose content is not that of then: a
    /// sentence each.
    pub(super) fn replaced(&self, values: &[String], place: &Path) -> Vec<String> {
        let mut said = BTreeSet::new();
        for value in values {
            let path = place.join(value);
            let Some(name) = path.file_name().map(|name| name.to_string_lossy().into_owned())
            else {
                continue;
            };
            let own: Vec<&RecordedContent> =
                self.0.iter().filter(|((_, n), _)| *n == name).flat_map(|(_, all)| all).collect();
            // A pipe is not opened: it may have no other end.
            if own.is_empty() || !path.is_file() {
                continue;
            }
            let Ok(file) = File::open(&path) else { continue };
            let Ok(now) = Input::hash("input", &name, &mut BufReader::new(file)) else { continue };
            let hash = format!("{:032x}", now.xxh3);
            if own.iter().all(|then| then.hash != hash) {
                said.insert(another(&name, own[0].bytes, i64::try_from(now.bytes).unwrap_or(0)));
            }
        }
        said.into_iter().collect()
    }

    /// How the inputs of another run differ, a sentence each.
    pub(super) fn differences(&self, now: &RecordedInputs) -> Vec<String> {
        let mut said = Vec::new();
        for ((role, name), then) in &self.0 {
            match now.0.get(&(role.clone(), name.clone())) {
                None => said.push(format!("{role} {name} is not read now")),
                Some(all) if all == then => {}
                Some(all) => {
                    said.push(another(&format!("{role} {name}"), bytes(then), bytes(all)));
                }
            }
        }
        let new = now.0.keys().filter(|key| !self.0.contains_key(*key));
        said.extend(new.map(|(role, name)| format!("{role} {name} was not read then")));
        said
    }
}

fn bytes(contents: &BTreeSet<RecordedContent>) -> i64 {
    contents.iter().map(|content| content.bytes).sum()
}

fn another(name: &str, then: i64, now: i64) -> String {
    match then == now {
        true => format!("{name} is another file: {now} bytes, with other contents"),
        false => format!("{name} is another file: {then} bytes then, {now} now"),
    }
}
