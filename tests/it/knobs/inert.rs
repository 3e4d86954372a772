//! The list of keys that move nothing under a condition.

use std::collections::BTreeMap;

use serde::Deserialize;

/// A condition, and what takes it away.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Inert {
    pub when: String,
    #[serde(default)]
    pub lift: Vec<String>,
    pub lift_file: Option<String>,
}

/// Keys by kind of file.
pub type List = BTreeMap<String, BTreeMap<String, Inert>>;

pub fn list() -> List {
    toml::from_str(include_str!("../../../arch-configs/inert.toml"))
        .expect("arch-configs/inert.toml")
}

/// What stands in the README: a row for every key of the list.
#[test]
fn the_readme_says_which_keys_are_inert_and_when() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/arch-configs/README.md");
    let readme = std::fs::read_to_string(path).expect("the README");
    for (kind, keys) in list() {
        for (key, inert) in keys {
            let row = format!("| {kind} | `{key}` | {} |", inert.when);
            assert!(readme.contains(&row), "arch-configs/README.md lacks the row\n{row}");
        }
    }
}
