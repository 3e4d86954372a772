//! Technology nodes: scaling factors of energy and area between them, and the voltage-frequency
//! curve of each.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::supply::Curve;
use powergs_base::config::embedded::NODES;
use powergs_base::quantity::{Nanometres, Volts};

/// The file `arch-configs/nodes.toml`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Nodes {
    /// What a step of technology does, by the name of a fit.
    pub fits: BTreeMap<String, NodeFit>,
    /// How fast gates are at a voltage, one curve a node.
    pub curves: Vec<NodeCurve>,
}

/// The curve of a node.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct NodeCurve {
    /// The node.
    pub node: Nanometres,
    /// Effective threshold.
    pub threshold: Volts,
    /// Exponent of the overdrive.
    pub exponent: f64,
    /// Voltage that makes the leakage current e times as large.
    pub leakage_slope: Volts,
    /// Lowest voltage.
    pub lowest: Volts,
    /// Highest voltage.
    pub highest: Volts,
}

/// A fit of `arch-configs/nodes.toml`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct NodeFit {
    /// Key of `references.toml`.
    pub source: String,
    /// What it is, and how far it can be trusted.
    pub note: String,
    /// The steps that it knows.
    pub steps: Vec<CurveStep>,
}

/// One step.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CurveStep {
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

/// The file.
fn nodes() -> &'static Nodes {
    static ALL: OnceLock<Nodes> = OnceLock::new();
    ALL.get_or_init(|| {
        powergs_base::config::parse::<Nodes>(NODES, &[])
            .unwrap_or_else(|e| panic!("arch-configs/nodes.toml: {e}"))
            .value
    })
}

/// All fits by name.
pub(crate) fn fits() -> &'static BTreeMap<String, NodeFit> {
    &nodes().fits
}

/// The voltage-frequency curve of a node.
///
/// # Errors
/// The nodes that have one, in one line.
pub(crate) fn curve(node: Nanometres) -> Result<Curve, String> {
    let all = &nodes().curves;
    let found = all.iter().find(|c| c.node == node).ok_or_else(|| {
        let known = all.iter().map(|c| c.node.to_string()).collect::<Vec<_>>().join(", ");
        format!(
            "nodes.toml has no voltage-frequency curve for {node}: there are {known}; or give one \
             of your own (`threshold`, `exponent`, ...)"
        )
    })?;
    let NodeCurve { threshold, exponent, leakage_slope, lowest, highest, .. } = *found;
    Ok(Curve { threshold, exponent, leakage_slope, lowest, highest })
}

/// What every fit that knows a step says of the energy of an operation, the least first.
pub(crate) fn energies(from: Nanometres, to: Nanometres) -> Vec<(&'static str, f64)> {
    let of = |fit: &NodeFit| fit.steps.iter().find(|s| (s.from, s.to) == (from, to))?.energy;
    let found = fits().iter().filter_map(|(name, fit)| Some((name.as_str(), of(fit)?)));
    let mut found: Vec<_> = found.collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    found
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
    let value = |step: &CurveStep| match what {
        Scaled::Energy => step.energy,
        Scaled::Area => step.area.map(f64::recip),
    };
    let step = found.steps.iter().find(|s| (s.from, s.to) == (from, to));
    if let Some(factor) = step.and_then(value) {
        return Ok(factor);
    }
    let rows = |fit: &NodeFit| {
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
