//! Assumptions: what is assumed, why, the keys that vary it, and what every file has there.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::entries::Entry;
use powergs_base::config::Embedded;
use powergs_base::config::assumptions::{Assumption, Knob, KnobFile, assumptions};
use powergs_base::config::embedded::{DRAM, ENERGY, MACHINES};

/// What [`Entry::kind`] says.
pub const KIND: &str = "assumption";

/// The pages that have the whole text of assumptions.
const PAGES: [(&str, &str); 7] = [
    ("docs/model.md", include_str!("../../docs/model.md")),
    ("docs/model-accel.md", include_str!("../../docs/model-accel.md")),
    ("docs/model-resident.md", include_str!("../../docs/model-resident.md")),
    ("docs/model-gpu.md", include_str!("../../docs/model-gpu.md")),
    ("docs/elsewhere.md", include_str!("../../docs/elsewhere.md")),
    ("docs/dram.md", include_str!("../../docs/dram.md")),
    ("docs/energy.md", include_str!("../../docs/energy.md")),
];

/// All assumptions.
pub fn entries() -> impl Iterator<Item = Entry> {
    assumptions().iter().map(|(number, assumption)| {
        let name = format!("A{number}");
        let facts = facts(&name, assumption);
        Entry { facts, ..Entry::new(KIND, name, "", format!("{}.", assumption.text)) }
    })
}

fn facts(name: &str, assumption: &Assumption) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    if let Some((page, text)) =
        PAGES.iter().find_map(|(page, text)| Some((page, text_of(text, name)?)))
    {
        facts.push(("in full", text));
        facts.push(("page", (*page).to_owned()));
    }
    for knob in &assumption.knobs {
        for key in &knob.keys {
            facts.push(("knob", format!("`{key}` ({})", file_words(knob.file))));
            facts.extend(values(knob, key).map(|values| ("value", values)));
        }
    }
    facts.extend(assumption.none.iter().map(|none| ("no knob", none.clone())));
    if !assumption.knobs.is_empty() {
        let command = format!("powergs-sim sensitivity MACHINE TRACE --assumptions --only {name}");
        facts.push(("effect", format!("`{command}`")));
    }
    facts
}

const fn file_words(file: KnobFile) -> &'static str {
    match file {
        KnobFile::Machine => "machine file",
        KnobFile::Energy => "energy table",
        KnobFile::Dram => "DRAM device",
    }
}

/// The files that knobs are in: kind, name, content.
static FILES: LazyLock<Vec<(KnobFile, &str, toml::Value)>> = LazyLock::new(|| {
    let kinds: [(KnobFile, &[Embedded]); 3] =
        [(KnobFile::Machine, MACHINES), (KnobFile::Energy, ENERGY), (KnobFile::Dram, DRAM)];
    let read = |file: &Embedded| toml::Value::Table(file.complete().parse().unwrap_or_default());
    let files = kinds.into_iter().flat_map(|(kind, files)| files.iter().map(move |f| (kind, f)));
    files.map(|(kind, file)| (kind, file.name, read(file))).collect()
});

/// The values of a key and the files that have them: `1 in gscore, edge; 4 in neo`.
fn values(knob: &Knob, key: &str) -> Option<String> {
    let mut having: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for (_, name, table) in FILES.iter().filter(|(file, ..)| *file == knob.file) {
        if let Some(value) = key.split('.').try_fold(table, |at, part| at.get(part)) {
            let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            having.entry(value).or_default().push(name);
        }
    }
    let mut having: Vec<_> = having.into_iter().collect();
    having.sort_by_key(|(_, files)| std::cmp::Reverse(files.len()));
    let words = having.iter().map(|(value, files)| format!("{value} in {}", files.join(", ")));
    (!having.is_empty()).then(|| words.collect::<Vec<_>>().join("; "))
}

/// The paragraph about an assumption in a page: from `**A26. ` to the next blank line.
fn text_of(page: &str, name: &str) -> Option<String> {
    let start = page.find(&format!("**{name}. "))?;
    let paragraph = page[start..].split("\n\n").next()?;
    let plain = |(i, part): (usize, &str)| match i % 2 {
        0 => part.replace('*', ""),
        _ => format!("`{part}`"),
    };
    let text: String = paragraph.split('`').enumerate().map(plain).collect();
    let text = text.strip_prefix(&format!("{name}. ")).unwrap_or(&text);
    Some(text.split_whitespace().collect::<Vec<_>>().join(" "))
}
