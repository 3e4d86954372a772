//! Floating-point operations of each action, for rooflines: `arch-configs/flops.toml`, after the
//! operation counts of the reference renderer (`powergs`).

use std::collections::BTreeMap;
use std::sync::OnceLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::action::Action;
use powergs_base::config::embedded::FLOPS;
use powergs_frame::scene::ShDegree;

/// The file: operations by stage and action.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct Counts {
    source: String,
    sh_colour: [u32; ShDegree::ALL.len()],
    preprocessing: BTreeMap<String, u32>,
    sorting: BTreeMap<String, u32>,
    rendering: BTreeMap<String, u32>,
}

fn counts() -> &'static Counts {
    static ALL: OnceLock<Counts> = OnceLock::new();
    ALL.get_or_init(|| {
        powergs_base::config::parse::<Counts>(FLOPS, &[])
            .unwrap_or_else(|e| panic!("arch-configs/flops.toml: {e}"))
            .value
    })
}

/// Floating-point operations of one colour from spherical harmonics of this degree (`powergs`; A17
/// for degrees below 3).
fn sh_colour(degree: ShDegree) -> u32 {
    counts().sh_colour[usize::from(degree.get())]
}

/// Floating-point operations of one action (source: `powergs`); actions that move bytes have none.
/// A colour is one of degree 3.
pub fn flops(action: Action) -> u32 {
    if action == Action::ShColour {
        return sh_colour(ShDegree::MAX);
    }
    let key = action.key();
    let file = counts();
    let tables = [&file.preprocessing, &file.sorting, &file.rendering];
    tables.into_iter().find_map(|table| table.get(&key)).copied().unwrap_or(0)
}

/// [`flops`] of all actions, by [`Action::index`].
pub fn per_action() -> [u32; Action::COUNT] {
    Action::all().map(flops)
}

/// Operations of a colour of this SH degree over those of degree 3.
pub fn colour_share(degree: ShDegree) -> f64 {
    f64::from(sh_colour(degree)) / f64::from(sh_colour(ShDegree::MAX))
}
