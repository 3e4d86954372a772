//! `explain`: definitions of everything that has a name in a report, a table or a file: statistics,
//! keys, columns, assumptions, sources, words.

mod assumption;
mod entries;

use serde_json::{Map, Value, json};

use super::{Context, Exit, Failure, out};
use powergs_base::config::suggest::nearest;
use powergs_core::sim::statistics;
use powergs_report::document::{Document, Text};

use entries::{Entry, entries};

/// Shown under `explain --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim explain vru.cores
  powergs-sim explain frame_time_ms.p99
  powergs-sim explain A26
  powergs-sim explain gscore
  powergs-sim explain 'FPS per W'
  powergs-sim explain dram";

/// Arguments of `explain`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// A statistic (`power_w.total`), a key (`vru.cores`), the start of several (`dram`), a
    /// column of a table (`busy`), an assumption (`A26`), a source (`powergs`), a term (`knee`)
    pub name: String,
}

/// Prints what is known about a name.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let entries = entries();
    let found = matching(&entries, &args.name);
    if found.is_empty() {
        let near = nearest(&args.name, entries.iter().flat_map(|e| e.names()));
        let hint = near.map_or_else(
            || {
                "docs/results.md lists the statistics, arch-configs/README.md the keys, \
                 docs/model.md the assumptions"
                    .to_owned()
            },
            |n| format!("did you mean `{n}`?"),
        );
        let message = format!("nothing is called `{}`; {hint}", args.name);
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

/// Those of `names` that mean nothing here.
pub fn unknown<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let entries = entries();
    names.into_iter().filter(|name| matching(&entries, name).is_empty()).collect()
}

/// What a name means: as a word of reports, and as a statistic or key. Heads of columns may have
/// their unit, their group and a remark with them: `rendering, mJ`, `elasticity: fps`,
/// `doubled (3 frames)`; a key has its number in a column of its own, `KEY.si`.
fn matching<'a>(entries: &'a [Entry], name: &str) -> Vec<&'a Entry> {
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

fn as_json(entry: &Entry) -> Value {
    let facts: Map<String, Value> =
        entry.facts.iter().map(|(name, text)| ((*name).to_owned(), text.as_str().into())).collect();
    let mut value = json!({
        "kind": entry.kind,
        "name": entry.name,
        "unit": entry.unit,
        "definition": entry.definition,
        "value": entry.value,
    });
    if let Value::Object(all) = &mut value {
        all.extend(facts);
    }
    value
}

fn document(entries: &[&Entry]) -> Document {
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
