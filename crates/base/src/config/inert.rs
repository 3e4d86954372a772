//! Keys that move nothing under a condition: `arch-configs/inert.toml`.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use serde::Deserialize;

use super::embedded::INERT;

/// A condition, and what takes it away.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Inert {
    /// When the key moves nothing.
    pub when: String,
    /// `--set` values of a machine (of a device: of it) with which it moves something.
    #[serde(default)]
    pub lift: Vec<String>,
    /// A file of the same kind in which it moves something.
    pub lift_file: Option<String>,
}

/// The keys by kind of file: `machine`, `energy`, `dram`.
pub type List = BTreeMap<String, BTreeMap<String, Inert>>;

/// The whole list.
pub fn inert() -> &'static List {
    static ALL: OnceLock<List> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut all: List =
            toml::from_str(INERT).unwrap_or_else(|e| panic!("arch-configs/inert.toml: {e}"));
        all.values_mut().for_each(say_of_further_masters);
        all
    })
}

/// What is said of the second master of a memory holds for further ones.
fn say_of_further_masters(keys: &mut BTreeMap<String, Inert>) {
    const SECOND: &str = "dram.second-master";
    let second = keys.iter().filter(|(key, _)| key.starts_with(SECOND));
    let second: Vec<_> = second.map(|(key, inert)| (key.clone(), inert.clone())).collect();
    for further in ["dram.third-master", "dram.fourth-master"] {
        keys.extend(second.iter().map(|(key, inert)| {
            let lift = inert.lift.iter().map(|set| set.replace(SECOND, further));
            // Whoever has a second one already has no room for as much again.
            let alone = [format!("{SECOND}.rate=0 B/s")];
            let lift = alone.into_iter().chain(lift).collect();
            (key.replace(SECOND, further), Inert { lift, ..inert.clone() })
        }));
    }
}
