//! What is written about configuration is complete and true: keys, sources, assumptions, schemas.

use std::collections::BTreeSet;
use std::path::Path;

use powergs_sim::cli::arch::Kind;
use powergs_sim::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES, SYNTH};
use powergs_sim::config::references::{cited, is_assumption, is_source, references};
use powergs_sim::config::{Embedded, key_docs};
use powergs_sim::display::Display;
use powergs_sim::dram::Device;
use powergs_sim::machine::Machine;
use powergs_sim::scene::synth::Preset;
use powergs_sim::stage::EnergyTable;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn all_files() -> impl Iterator<Item = &'static Embedded> {
    MACHINES.iter().chain(ENERGY).chain(DISPLAYS).chain(DRAM).chain(SYNTH)
}

#[test]
fn every_key_has_a_definition_and_numbers_have_units() {
    let docs = [key_docs::<Machine>(), key_docs::<EnergyTable>(), key_docs::<Display>()];
    let docs = [docs.concat(), key_docs::<Device>(), key_docs::<Preset>()].concat();
    assert!(docs.len() > 100);
    for doc in docs {
        assert!(doc.definition.len() > 3, "{}: no definition", doc.path);
        assert!(!["count", "number", "value"].contains(&doc.unit.as_str()), "{doc:?}");
    }
}

#[test]
fn every_source_resolves_and_every_reference_is_used() {
    let pages = [
        "model.md",
        "model-accel.md",
        "model-resident.md",
        "model-gpu.md",
        "elsewhere.md",
        "dram.md",
    ];
    let pages = pages.map(|page| format!("docs/{page}"));
    let model = pages.map(|page| read(&page)).concat();
    let mut used = BTreeSet::new();
    for file in all_files() {
        for source in cited(file.text) {
            assert!(is_source(&source), "{}: nobody knows `{source}`", file.name);
            if is_assumption(&source) {
                let heading = format!("**{source}. ");
                assert!(model.contains(&heading), "{}: docs/model.md lacks {source}", file.name);
            }
            used.insert(source);
        }
    }
    // Energy tables and texts cite these in prose.
    let prose: String = all_files().map(|f| f.text).chain([model.as_str()]).collect();
    for key in references().keys() {
        let named = prose.contains(&format!("[{key}]")) || prose.contains(&format!("`{key}`"));
        assert!(used.contains(key) || named, "references.toml: nobody cites {key}");
    }
}

#[test]
fn every_number_of_a_machine_file_has_a_source() {
    for file in MACHINES {
        for line in file.text.lines().filter(|l| l.contains(" = ") && !l.starts_with('#')) {
            let (key, value) = line.split_once(" = ").expect("a key and a value");
            let value = value.split('#').next().unwrap_or("");
            let number = value.chars().any(|c| c.is_ascii_digit()) || value.trim() == "true";
            if number && !["name", "description", "energy"].contains(&key) {
                let sources = cited(line);
                assert!(!sources.is_empty(), "{}: no source: {line}", file.name);
            }
        }
    }
}

/// A source in brackets that nobody knows would silently count as prose.
#[test]
fn brackets_in_comments_of_machine_files_are_sources() {
    for file in MACHINES {
        for comment in file.text.lines().filter_map(|l| Some(l.split_once('#')?.1)) {
            for part in comment.split('[').skip(1) {
                let key = part.split(']').next().unwrap_or("");
                assert!(is_source(key) || ["KEY", "A.."].contains(&key), "{}: [{key}]", file.name);
            }
        }
    }
}

#[test]
fn assumptions_are_numbered_once_and_in_order() {
    let model = read("docs/model.md");
    let number = |l: &str| l.strip_prefix("**A")?.split('.').next()?.parse::<u32>().ok();
    let numbers: Vec<u32> = model.lines().filter_map(number).collect();
    assert!(numbers.len() >= 13);
    assert!(numbers.windows(2).all(|w| w[0] < w[1]), "{numbers:?}");
}

/// Where editors look for the schema: docs/configuration.md says how it comes there.
#[test]
fn files_name_the_schema_of_their_kind() {
    for kind in Kind::ALL {
        let line = format!("#:schema ../schema/{}.json\n", kind.name());
        for file in kind.files() {
            assert!(file.text.starts_with(&line), "{}", file.name);
        }
    }
}
