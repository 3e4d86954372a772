//! The files that a run was made from: which of them are others now.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::words::TypedValue;
use powergs_core::run::Input;
use toml::{Table, Value};

/// What is known of one content of an input.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::cli) struct RecordedContent {
    /// xxh3 of 128 bits, hexadecimal.
    pub hash: String,
    /// Its length.
    pub bytes: i64,
}

/// Keys under which records have hashes of contents.
const HASHES: [&str; 2] = ["xxh3-128", "xxh3"];

/// The inputs of a run, by role and name: several may share both.
#[derive(Debug, Default)]
pub(in crate::cli) struct RecordedInputs(BTreeMap<(String, String), BTreeSet<RecordedContent>>);

impl RecordedInputs {
    /// All inputs that a `run.toml` has, those of its sides too.
    pub(in crate::cli) fn of(record: &Table) -> RecordedInputs {
        let mut found = RecordedInputs::default();
        record.values().for_each(|value| found.add(value));
        found
    }

    fn add(&mut self, value: &Value) {
        match value {
            Value::Array(items) => items.iter().for_each(|item| self.add(item)),
            Value::Table(table) => {
                let text = |key: &str| table.get(key).and_then(Value::as_str);
                let hash = HASHES.into_iter().find_map(text);
                let (Some(name), Some(hash)) = (text("name"), hash) else {
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

    /// Every input: role, name and contents.
    pub(in crate::cli) fn all(
        &self,
    ) -> impl Iterator<Item = (&str, &str, &BTreeSet<RecordedContent>)> {
        self.0.iter().map(|((role, name), contents)| (role.as_str(), name.as_str(), contents))
    }

    /// Whether there is none.
    pub(in crate::cli) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether an input has this name.
    pub(in crate::cli) fn has_name(&self, name: &str) -> bool {
        self.0.keys().any(|(_, known)| known == name)
    }

    /// Files among `values`, which were typed in `place`, whose content is not that of then: a
    /// sentence each.
    pub(super) fn replaced(&self, values: &[TypedValue], place: &Path) -> Vec<String> {
        let mut said = BTreeSet::new();
        for value in values {
            let path = place.join(&value.text);
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

/// That a file is not the one of then.
pub(in crate::cli) fn another(name: &str, then: i64, now: i64) -> String {
    match then == now {
        true => format!("{name} is another file: {now} bytes, with other contents"),
        false => format!("{name} is another file: {then} bytes then, {now} now"),
    }
}
