//! Technology nodes: scaling factors of energy and area between them.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use powergs_base::config::embedded::NODES;
use powergs_base::quantity::Nanometres;

/// A fit of `arch-configs/nodes.toml`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Fit {
    /// Key of `references.toml`.
    pub source: String,
    /// What it is, and how far it can be trusted.
    pub note: String,
    /// The steps that it knows.
    pub steps: Vec<Step>,
}

/// One step.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Step {
    /// From this node.
    pub from: Nanometres,
    /// To this one.
    pub to: Nanometres,
    /// Factor on the energy of an operation.
    #[schemars(range(min = 0.0001, max = 10000.0), extend("x-unit" = "factor"))]
    pub energy: Option<f64>,
    /// How many times smaller the same logic becomes.
    #[schemars(range(min = 0.0001, max = 10000.0), extend("x-unit" = "factor"))]
    pub area: Option<f64>,
}

/// The scaled quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scaled {
    /// Energy of an operation.
    Energy,
    /// Area.
    Area,
}

impl Scaled {
    const fn word(self) -> &'static str {
        match self {
            Scaled::Energy => "energy",
            Scaled::Area => "area",
        }
    }
}

/// All fits by name.
pub(crate) fn fits() -> &'static BTreeMap<String, Fit> {
    static ALL: OnceLock<BTreeMap<String, Fit>> = OnceLock::new();
    ALL.get_or_init(|| {
        powergs_base::config::parse::<BTreeMap<String, Fit>>(NODES, &[])
            .unwrap_or_else(|e| panic!("arch-configs/nodes.toml: {e}"))
            .value
    })
}

/// The factor of a step.
///
/// # Errors
/// What there is instead, in one line: an unknown fit, or a step that the fit has no row for.
pub(crate) fn factor(
    fit: &str,
    what: Scaled,
    from: Nanometres,
    to: Nanometres,
) -> Result<f64, String> {
    let Some(found) = fits().get(fit) else {
        let known = fits().keys().cloned().collect::<Vec<_>>().join(", ");
        return Err(format!("no fit `{fit}`; there are {known}"));
    };
    let value = |step: &Step| match what {
        Scaled::Energy => step.energy,
        Scaled::Area => step.area.map(f64::recip),
    };
    let step = found.steps.iter().find(|s| (s.from, s.to) == (from, to));
    if let Some(factor) = step.and_then(value) {
        return Ok(factor);
    }
    let rows = |fit: &Fit| {
        let rows = fit.steps.iter().filter(|s| value(s).is_some());
        rows.map(|s| format!("{} to {}", s.from, s.to)).collect::<Vec<_>>().join(", ")
    };
    let known: Vec<String> = fits()
        .iter()
        .map(|(name, fit)| (name, rows(fit)))
        .filter(|(_, rows)| !rows.is_empty())
        .map(|(name, rows)| format!("`{name}` has {rows}"))
        .collect();
    let (word, known) = (what.word(), known.join("; "));
    Err(format!(
        "`{fit}` has no {word} for {from} (`from`) to {to} (`node`): {known}; or give `factor` and \
         `source`"
    ))
}
