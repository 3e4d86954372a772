//! Every assumption is in `arch-configs/assumptions.toml`, and everything there is explained.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use powergs_base::config::assumptions::{KnobFile, assumptions};
use powergs_base::config::embedded::{DRAM, ENERGY, MACHINES, find};
use powergs_base::config::{Embedded, KeyDoc, key_docs, knob};
use powergs_core::machine::Machine;
use powergs_core::stage::EnergyTable;
use powergs_dram::Device;
use toml::Table;

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let ends = path.extension().is_some_and(|e| ["md", "toml", "rs"].iter().any(|x| e == *x));
        if path.is_dir() {
            files(&path, found);
        } else if ends {
            found.push(path);
        }
    }
}

/// Numbers like A12 and A100, as words of their own.
fn mentioned(text: &str) -> BTreeSet<u32> {
    let mut found = BTreeSet::new();
    for (at, _) in text.match_indices('A') {
        let before = text[..at].chars().next_back();
        let digits: String = text[at + 1..].chars().take_while(char::is_ascii_digit).collect();
        let after = text[at + 1 + digits.len()..].chars().next();
        let alone = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric() && c != '_');
        if !digits.is_empty() && digits.len() <= 3 && alone(before) && alone(after) {
            found.extend(digits.parse::<u32>());
        }
    }
    found
}

#[test]
fn every_assumption_that_is_named_is_in_the_table_and_the_other_way_round() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut all = Vec::new();
    ["docs", "src", "arch-configs"].into_iter().for_each(|f| files(&root.join(f), &mut all));
    for entry in std::fs::read_dir(root.join("crates")).expect("the crates") {
        files(&entry.expect("a crate").path().join("src"), &mut all);
    }
    let known: BTreeSet<u32> = assumptions().keys().copied().collect();
    let mut named = BTreeSet::new();
    for path in all {
        if path.ends_with("assumptions.toml") || path.ends_with("sensitivity.md") {
            continue;
        }
        let text = std::fs::read_to_string(&path).expect("text");
        let numbers = mentioned(&text);
        let unknown: Vec<_> = numbers.difference(&known).collect();
        assert!(
            unknown.is_empty(),
            "{}: arch-configs/assumptions.toml lacks {unknown:?}",
            path.display()
        );
        named.extend(numbers);
    }
    let unnamed: Vec<_> = known.difference(&named).collect();
    assert!(unnamed.is_empty(), "arch-configs/assumptions.toml: nobody names {unnamed:?}");
    assert_eq!(mentioned("A4, (A12) BA3 A1000 A1b `A7`."), BTreeSet::from([4, 7, 12]));
}

#[test]
fn every_assumption_has_a_knob_or_says_why_it_has_none() {
    for (number, assumption) in assumptions() {
        assert_eq!(assumption.knobs.is_empty(), assumption.none.is_some(), "A{number}");
        assert!(
            assumption.text.len() <= 52,
            "A{number}: a few words, not {}",
            assumption.text.len()
        );
    }
}

#[test]
fn the_measured_table_has_a_row_for_every_assumption() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../evidence/sensitivity.md");
    let page = std::fs::read_to_string(path).expect("evidence/sensitivity.md");
    for number in assumptions().keys() {
        assert!(
            page.contains(&format!("\n| A{number} | ")),
            "evidence/sensitivity.md lacks A{number}"
        );
    }
}

fn complete(files: &[Embedded], name: &str) -> String {
    files.iter().find(|file| file.name == name).expect("a file").complete()
}

/// A knob names keys that exist: in the schema, and in the files of the machine that it is varied
/// on.
#[test]
fn every_knob_has_keys() {
    let names = |docs: Vec<KeyDoc>| docs.into_iter().map(|d| d.path).collect::<BTreeSet<String>>();
    let schemas = [
        names(key_docs::<Machine>()),
        names(key_docs::<EnergyTable>()),
        names(key_docs::<Device>()),
    ];
    for (number, assumption) in assumptions() {
        for k in &assumption.knobs {
            let on = k.on.as_deref().unwrap_or(MACHINES[0].name);
            let machine = Machine::parse(find(MACHINES, on).expect("a machine"));
            let mut table = Table::try_from(machine.expect("a good machine")).expect("TOML");
            for set in &k.with {
                let (key, value) = set.split_once('=').expect("KEY=VALUE");
                let kept = !key.contains(':') && knob::set(&mut table, key, &knob::written(value));
                assert!(kept || key.contains(':'), "A{number}: no key `{key}`");
            }
            let machine = Machine::from_table(table, None);
            let machine = machine.unwrap_or_else(|e| panic!("A{number}: {e}"));
            let text = match k.file {
                KnobFile::Machine => Table::try_from(&machine).expect("TOML").to_string(),
                KnobFile::Energy => complete(ENERGY, &machine.energy),
                KnobFile::Dram => complete(DRAM, &machine.dram.device),
            };
            let table: Table = text.parse().expect("TOML");
            for key in &k.keys {
                assert!(!knob::values(&table, key).is_empty(), "A{number}: nobody has `{key}`");
                let schema = &schemas[k.file as usize];
                assert!(key.contains('*') || schema.contains(key), "A{number}: no key `{key}`");
            }
        }
    }
}
