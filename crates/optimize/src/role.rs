//! What a model of a run is made for: one type, and one spelling of it in job names, checkpoints,
//! results and messages.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// What our models are compared with; trained with the budget of the final model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Baseline {
    /// Pruned while the quality passes; colours are left alone.
    RenderOnly,
    /// Not pruned; the display term takes all the slack.
    DisplayOnly,
    /// So many percent of the Gaussians pruned at once by LightGaussian's score, then fine-tuned.
    LightGaussian(u8),
    /// `render-only`, then its colours with the display term.
    TwoStage,
}

/// What stands before the percentage in the name of [`Baseline::LightGaussian`].
const LIGHT_GAUSSIAN: &str = "lightgs-";
/// What stands before the number of a level beyond the first in the names of its jobs. Letters
/// alone are qualities: `M-sample-01` is a sample of medium quality, `level2-sample-01` one of the
/// second level.
pub(crate) const LEVEL: &str = "level";
/// What stands before the weight in the name of [`Role::Sweep`].
const SWEEP: &str = "lambda-";
/// What stands before the position in the name of [`Role::External`].
const EXTERNAL: &str = "external-";

/// What the realised optimum of a run is called where its models are priced anew, and it is a
/// sample beside others.
pub(crate) const FORMER_OPTIMUM: &str = "former-optimum";

/// A name that no role has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a role of a model")]
pub struct UnknownRole(String);

impl Baseline {
    /// All of them, in the order in which they are made.
    pub const ALL: [Baseline; 6] = [
        Baseline::DisplayOnly,
        Baseline::RenderOnly,
        Baseline::TwoStage,
        Baseline::LightGaussian(66),
        Baseline::LightGaussian(76),
        Baseline::LightGaussian(86),
    ];

    /// Whether it gets levels for the periphery of sight, as the foveated methods of the
    /// publication: FR-Render and FR-Display.
    pub fn has_levels(self) -> bool {
        matches!(self, Baseline::RenderOnly | Baseline::DisplayOnly)
    }

    /// The name in every output.
    pub fn name(self) -> String {
        match self {
            Baseline::RenderOnly => "render-only".into(),
            Baseline::DisplayOnly => "display-only".into(),
            Baseline::LightGaussian(percent) => format!("{LIGHT_GAUSSIAN}{percent}"),
            Baseline::TwoStage => "two-stage".into(),
        }
    }
}

impl FromStr for Baseline {
    type Err = UnknownRole;

    fn from_str(name: &str) -> Result<Baseline, UnknownRole> {
        let named = Baseline::ALL.into_iter().find(|b| b.name() == name);
        let pruned =
            || Some(Baseline::LightGaussian(name.strip_prefix(LIGHT_GAUSSIAN)?.parse().ok()?));
        named.or_else(pruned).ok_or_else(|| UnknownRole(name.to_owned()))
    }
}

/// What a model is made for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum Role {
    /// The model that the user brought.
    Dense,
    /// The dense model, trained further without the gate views, which it may have been trained on:
    /// targets that are shares are shares of its quality.
    HeldOut,
    /// A sample of the curve of power over the pruning ratio.
    Sample,
    /// A model at the ratio of the fitted optimum; it is not always the result.
    Optimum,
    /// A comparison that we train.
    Baseline(Baseline),
    /// Another model of the user, measured only; position in their list.
    External(usize),
    /// A fixed weight of the display term, without unit, and no pruning: λ, in 1/W, is this over
    /// the display power of the dense model.
    Sweep(f64),
}

impl Role {
    /// Its name, with all particulars. Jobs are named after it: samples get a number, models of the
    /// user keep the name that they have.
    pub fn name(self) -> String {
        match self {
            Role::Baseline(baseline) => baseline.name(),
            Role::External(position) => format!("{EXTERNAL}{position}"),
            Role::Sweep(weight) => format!("{SWEEP}{weight}"),
            Role::Dense | Role::HeldOut | Role::Sample | Role::Optimum => self.kind().name().into(),
        }
    }

    /// Whether a job of a run may have this name, so that no model of the user can.
    pub fn reserves(name: &str) -> bool {
        let numbered = format!("{}-", Role::Sample.name());
        let is_job = match name.parse() {
            Ok(Role::Dense | Role::HeldOut | Role::Optimum) => true,
            Ok(Role::Baseline(baseline)) => Baseline::ALL.contains(&baseline),
            Ok(Role::Sample | Role::External(_) | Role::Sweep(_)) | Err(_) => false,
        };
        let prefixes = [numbered.as_str(), SWEEP, LEVEL, FORMER_OPTIMUM];
        is_job || prefixes.iter().any(|prefix| name.starts_with(prefix))
    }

    /// What the model was made for, without the particulars.
    pub const fn kind(self) -> RoleKind {
        match self {
            Role::Dense => RoleKind::Dense,
            Role::HeldOut => RoleKind::HeldOut,
            Role::Sample => RoleKind::Sample,
            Role::Optimum => RoleKind::Optimum,
            Role::Baseline(_) => RoleKind::Baseline,
            Role::External(_) => RoleKind::External,
            Role::Sweep(_) => RoleKind::Sweep,
        }
    }

    /// Which comparison it is.
    pub const fn baseline(self) -> Option<Baseline> {
        match self {
            Role::Baseline(baseline) => Some(baseline),
            Role::Dense
            | Role::HeldOut
            | Role::Sample
            | Role::Optimum
            | Role::External(_)
            | Role::Sweep(_) => None,
        }
    }
}

impl FromStr for Role {
    type Err = UnknownRole;

    fn from_str(name: &str) -> Result<Role, UnknownRole> {
        let after = |prefix: &str| name.strip_prefix(prefix);
        let plain = [Role::Dense, Role::HeldOut, Role::Sample, Role::Optimum];
        let plain = plain.into_iter().find(|role| role.kind().name() == name);
        plain
            .or_else(|| Some(Role::External(after(EXTERNAL)?.parse().ok()?)))
            .or_else(|| Some(Role::Sweep(after(SWEEP)?.parse().ok()?)))
            .map_or_else(|| name.parse().map(Role::Baseline), Ok)
    }
}

/// What a model was made for, without the particulars.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub enum RoleKind {
    /// The model that the user brought.
    Dense,
    /// The dense model, trained further without the gate views.
    HeldOut,
    /// A sample of the curve of power over the pruning ratio.
    Sample,
    /// A model at the ratio of the fitted optimum; it is not always the result.
    Optimum,
    /// A comparison that was trained.
    Baseline,
    /// Another model of the user.
    External,
    /// A fixed λ without pruning.
    Sweep,
}

impl RoleKind {
    /// All of them.
    const ALL: [RoleKind; 7] = [
        RoleKind::Dense,
        RoleKind::HeldOut,
        RoleKind::Sample,
        RoleKind::Optimum,
        RoleKind::Baseline,
        RoleKind::External,
        RoleKind::Sweep,
    ];

    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            RoleKind::Dense => "dense",
            RoleKind::HeldOut => "held-out",
            RoleKind::Sample => "sample",
            RoleKind::Optimum => "optimum",
            RoleKind::Baseline => "baseline",
            RoleKind::External => "external",
            RoleKind::Sweep => "sweep",
        }
    }
}

impl FromStr for RoleKind {
    type Err = UnknownRole;

    fn from_str(name: &str) -> Result<RoleKind, UnknownRole> {
        // Results of older versions write it with an underscore, and called the optimum final.
        let name = match name {
            "final" => RoleKind::Optimum.name().into(),
            name => name.replace('_', "-"),
        };
        RoleKind::ALL.into_iter().find(|k| k.name() == name).ok_or(UnknownRole(name))
    }
}

/// Serde by name, both ways.
macro_rules! by_name {
    ($($role:ty),*) => {$(
        impl fmt::Display for $role {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name().as_ref())
            }
        }

        impl From<$role> for String {
            fn from(role: $role) -> String {
                role.name().into()
            }
        }

        impl TryFrom<String> for $role {
            type Error = UnknownRole;

            fn try_from(name: String) -> Result<$role, UnknownRole> {
                name.parse()
            }
        }
    )*};
}

by_name!(Baseline, Role, RoleKind);
