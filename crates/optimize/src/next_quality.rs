//! What the next lower named quality would buy, as far as the models of a run know.

use super::outcome::Outcome;
use super::plan::Plan;
use super::role::Role;
use super::target::{Level, Quality, TargetRule};

/// The next lower named quality.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct NextQuality {
    /// Which one.
    pub level: Level,
    /// What it asks for over the gate views.
    pub target: Quality,
    /// The cheapest of our models that reaches it, and its total power, watts: at most so much is
    /// needed. Those of a search for that quality would need less.
    pub model: Option<(String, f64)>,
}

/// The next lower named quality below that of a variant; `None` at the lowest, and for numbers of
/// the user's own against photos, which are no named quality. `is_own`: the references are renders
/// of the dense model.
pub fn next_quality(
    plan: &Plan,
    done: &[Outcome],
    variant: u8,
    is_own: bool,
) -> Option<NextQuality> {
    let rule = plan.variants.get(usize::from(variant))?.rule;
    let is_below = |level: &Level| match (rule, level.rule(is_own)) {
        (TargetRule::Share(asked), TargetRule::Share(share)) => share < asked,
        (TargetRule::Absolute(asked), TargetRule::Absolute(named)) => named.psnr_db < asked.psnr_db,
        (TargetRule::Share(_), TargetRule::Absolute(_))
        | (TargetRule::Absolute(_), TargetRule::Share(_)) => false,
    };
    let level = Level::ALL.into_iter().find(is_below)?;
    let (gate, _) = plan.reference(done)?;
    let target = level.rule(is_own).target(gate);
    let reaches = |o: &&Outcome| is_ours(o) && target.passes(o.gate.quality);
    let least = |a: &&Outcome, b: &&Outcome| a.watts.total_w().total_cmp(&b.watts.total_w());
    let model = done.iter().filter(reaches).min_by(least);
    Some(NextQuality {
        level,
        target: target.likeness_target()?,
        model: model.map(|o| (o.name.clone(), o.watts.total_w())),
    })
}

/// Models of level 1 that the method makes.
fn is_ours(o: &Outcome) -> bool {
    matches!(o.role, Role::Sample | Role::Optimum) && o.place.level == 0
}
