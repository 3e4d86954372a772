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
        toml::from_str(INERT).unwrap_or_else(|e| panic!("arch-configs/inert.toml: {e}"))
    })
}
