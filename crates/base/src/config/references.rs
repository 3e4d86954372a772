//! Where numbers come from: the keys of `references.toml`, and who cites them.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::embedded::REFERENCES;

/// One source.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Reference {
    /// Title.
    pub title: String,
    /// Where it was published.
    pub venue: String,
    /// Its DOI, where it has one.
    pub doi: Option<String>,
    /// Where it can be read.
    pub url: Option<String>,
    /// What is taken from it, and how far it can be trusted.
    pub note: Option<String>,
}

impl Reference {
    /// An address: the one that is given, or that of its DOI.
    pub fn link(&self) -> Option<String> {
        self.url.clone().or_else(|| self.doi.as_ref().map(|doi| format!("https://doi.org/{doi}")))
    }
}

/// All sources by key.
pub fn references() -> &'static BTreeMap<String, Reference> {
    static ALL: OnceLock<BTreeMap<String, Reference>> = OnceLock::new();
    ALL.get_or_init(|| {
        super::parse::<BTreeMap<String, Reference>>(REFERENCES, &[])
            .unwrap_or_else(|e| panic!("arch-configs/references.toml: {e}"))
            .value
    })
}

/// Whether `source` is a key of `references.toml` or an assumption number (`A11`).
pub fn is_source(source: &str) -> bool {
    is_assumption(source) || references().contains_key(source)
}

/// Whether `source` is an assumption number.
pub fn is_assumption(source: &str) -> bool {
    let digits = source.strip_prefix('A').unwrap_or("");
    !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit())
}

/// The sources that a configuration text cites: values of `source` keys, and `[key]` in comments.
pub fn cited(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for line in text.lines() {
        let keys = line.match_indices("source = \"").map(|(at, _)| at);
        // `feature-source` is another key.
        for at in keys.filter(|&at| !line[..at].ends_with('-')) {
            found.extend(line[at + 10..].split('"').next().map(str::to_owned));
        }
        let comment = line.split_once('#').map_or("", |(_, c)| c);
        for part in comment.split('[').skip(1) {
            let key = part.split(']').next().unwrap_or("");
            found.extend(is_source(key).then(|| key.to_owned()));
        }
    }
    found
}
