//! The list of keys that move nothing under a condition.

pub use powergs_base::config::inert::{Inert, inert as list};
use powergs_core::machine::Optional;

/// The README has a row for every part that a machine may not have.
#[test]
fn the_readme_says_which_parts_a_machine_may_not_have() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../arch-configs/README.md");
    let readme = std::fs::read_to_string(path).expect("the README");
    let (_, section) = readme.split_once("## Parts that a machine may not have").expect("its part");
    for part in Optional::all() {
        let row = section.lines().find(|row| row.contains(&format!("`{}", part.switch)));
        assert!(row.is_some_and(|row| row.starts_with("| `")), "no row with {}", part.switch);
    }
}
