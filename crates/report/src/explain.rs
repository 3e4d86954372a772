//! Definitions of everything that has a name in a report, a table or a file: statistics, keys,
//! columns, assumptions, sources, words.

mod assumption;
mod entries;

use serde_json::{Map, Value, json};

use super::document::{Document, Text};
use powergs_base::config::suggest::nearest;
use powergs_core::sim::statistics;

pub use entries::{Entry, Keys, entries};

/// What is called `name`, all of it.
///
/// # Errors
/// Nothing is: the name that was probably meant, or where names are listed.
pub fn find<'a>(entries: &'a [Entry], name: &str) -> Result<Vec<&'a Entry>, String> {
    let found = matching(entries, name);
    if !found.is_empty() {
        return Ok(found);
    }
    let near = nearest(name, entries.iter().flat_map(|e| e.names()));
    let hint = near.map_or_else(
        || {
            "docs/results.md lists the statistics, arch-configs/README.md the keys, \
             docs/model.md the assumptions"
                .to_owned()
        },
        |n| format!("did you mean `{n}`?"),
    );
    Err(format!("nothing is called `{name}`; {hint}"))
}

/// What a name means: as a word of reports, and as a statistic or key. Heads of columns may have
/// their unit, their group and a remark with them: `rendering, mJ`, `elasticity: fps`,
/// `doubled (3 frames)`; a key has its number in a column of its own, `KEY.si`.
pub fn matching<'a>(entries: &'a [Entry], name: &str) -> Vec<&'a Entry> {
    let whole = name.trim();
    let mut tried = vec![whole];
    tried.extend(whole.split_once(" (").map(|(head, _)| head));
    tried.extend(whole.rsplit_once(", ").map(|(head, _)| head));
    tried.extend(whole.split_once(" over ").map(|(head, _)| head));
    let mut found = tried.iter().map(|name| of_name(entries, name));
    if let Some(found) = found.find(|found| !found.is_empty()) {
        return found;
    }
    let parts = match whole.strip_suffix(".si") {
        Some(key) => Some((key, ".si")),
        None => whole.split_once(": "),
    };
    let Some((group, head)) = parts else { return Vec::new() };
    let (group, head) = (matching(entries, group), matching(entries, head));
    let both = !group.is_empty() && !head.is_empty();
    if both { [group, head].concat() } else { Vec::new() }
}

/// The words of this name; then the statistic or key of this name, or all under it (`vru`:
/// `vru.cores`, ...), or of this last part.
fn of_name<'a>(entries: &'a [Entry], name: &str) -> Vec<&'a Entry> {
    let name = plain(name);
    let (words, keys): (Vec<&Entry>, Vec<&Entry>) = entries.iter().partition(|e| e.is_word());
    let mut found = words;
    found.retain(|e| e.names().any(|n| plain(n) == name));
    let keyed = statistics::name_in(&name).to_owned();
    let tests: [&dyn Fn(&str) -> bool; 3] =
        [&|n| n == name || n == keyed, &|n| n.starts_with(&format!("{name}.")), &|n| {
            n.ends_with(&format!(".{name}"))
        }];
    for (i, test) in tests.iter().enumerate() {
        if i == 2 && !found.is_empty() {
            break;
        }
        found.extend(keys.iter().filter(|e| test(&plain(&e.name))));
        if found.iter().any(|e| !e.is_word() && e.unit != "table") {
            break;
        }
    }
    found
}

/// As names are compared: any case, `-`, `_` and blanks alike, any display rate.
fn plain(name: &str) -> String {
    let name = name.trim().trim_end_matches(['↓', '↑']).trim().to_lowercase();
    let mut words: Vec<&str> = name.split_whitespace().collect();
    if let [.., "at", rate, "fps"] = words[..]
        && rate.parse::<f64>().is_ok()
    {
        words.truncate(words.len() - 3);
        words.extend(["at", "the", "display", "rate"]);
    }
    words.join("_").replace('-', "_").replace("[]", "")
}

impl Entry {
    /// The entry as JSON.
    pub fn json(&self) -> Value {
        // What is told several times is a list.
        let mut facts = Map::new();
        for (name, text) in &self.facts {
            let text = Value::from(text.as_str());
            match facts.get_mut(*name) {
                None => drop(facts.insert((*name).to_owned(), text)),
                Some(Value::Array(all)) => all.push(text),
                Some(one) => *one = Value::Array(vec![one.take(), text]),
            }
        }
        let mut value = json!({
            "kind": self.kind,
            "name": self.name,
            "unit": self.unit,
            "definition": self.definition,
            "value": self.value,
        });
        if let Value::Object(all) = &mut value {
            all.extend(facts);
        }
        value
    }
}

/// Entries as a page.
pub fn document(entries: &[&Entry]) -> Document {
    let mut page = Document::new();
    for entry in entries {
        page.heading(format!("{} ({})", entry.name, entry.kind));
        let mut facts = vec![("unit", entry.unit.as_str())];
        facts.extend(entry.value.iter().map(|value| ("value", value.as_str())));
        facts.push(("", &entry.definition));
        facts.extend(entry.facts.iter().map(|(name, text)| (*name, text.as_str())));
        facts.retain(|(_, text)| !text.is_empty());
        page.facts(facts.into_iter().map(|(name, text)| (name, Text::marked(text))));
    }
    page
}
