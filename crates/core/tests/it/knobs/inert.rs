//! The list of keys that move nothing under a condition.

pub use powergs_base::config::inert::{Inert, inert as list};

/// What stands in the README: a row for every key of the list.
#[test]
fn the_readme_says_which_keys_are_inert_and_when() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../arch-configs/README.md");
    let readme = std::fs::read_to_string(path).expect("the README");
    for (kind, keys) in list() {
        for (key, inert) in keys {
            let row = format!("| {kind} | `{key}` | {} |", inert.when);
            assert!(readme.contains(&row), "arch-configs/README.md lacks the row\n{row}");
        }
    }
}
