//! Claims that need more than one run.

use super::facts::{dense, high};
use super::sentence::{count, fixed, say};
use super::{Answer, Asks, Check, Rule, Run, Unit, here};
use powergs_optimize::results::Results;
use powergs_optimize::role::RoleKind;

/// Optima as near as this are the same.
const NEAR: f64 = 0.1;
/// Samples of the published schedule, and of a short one.
const MANY: usize = 12;
const FEW: usize = 5;

pub(super) const CHECKS: &[Check] = &[
    Check {
        id: "5",
        what: "about five samples are enough",
        published: "about 5",
        expects: "5 and 12 samples of a scene put the optimum within 0.1 in ρ",
        rule: Rule::Most,
        asks: Asks::Together(samples),
    },
    Check {
        id: "9",
        what: "real scenes cost more to render than objects",
        published: "3.5 : 1",
        expects: "the scene with more Gaussians takes more, dense",
        rule: Rule::Most,
        asks: Asks::Together(scenes),
    },
];

fn samples_of(r: &Results) -> usize {
    let variant = high(r);
    let is = |m: &&powergs_optimize::results::ModelRecord| {
        m.role == RoleKind::Sample && m.level == 1 && m.variant == variant
    };
    r.models.iter().filter(is).count()
}

fn same_scene(a: &Results, b: &Results) -> bool {
    (&a.scene, a.width_px, a.height_px) == (&b.scene, b.width_px, b.height_px)
}

fn samples(runs: &[&Run]) -> Answer {
    let optimum = |r: &Results| r.fit(high(r), 1).and_then(|f| f.optimum_rho);
    for many in runs.iter().map(|r| &r.results).filter(|r| samples_of(r) >= MANY) {
        // One of fewer samples, or of none that passed, has no optimum to compare.
        let few = runs.iter().map(|r| &r.results);
        let few = few.filter(|r| samples_of(r) <= FEW && same_scene(r, many));
        let found = few.filter_map(|few| Some((few, optimum(few)?))).next();
        if let (Some((few, a)), Some(b)) = (found, optimum(many)) {
            let (n, m) = (samples_of(few), samples_of(many));
            let [rho, other] = [a, b].map(|rho| fixed(rho, Unit::One, 3));
            let values = [many.scene.clone().into(), rho, count(n), other, count(m)];
            let text = say("{}: ρ {} of {} samples, {} of {}", values);
            return here(text, (a - b).abs() <= NEAR);
        }
    }
    Err("needs a run of 12 samples (optimize --schedule published) beside one of 5".into())
}

fn scenes(runs: &[&Run]) -> Answer {
    let mut dense: Vec<_> = Vec::new();
    for run in runs {
        let r = &run.results;
        let is_new = dense.iter().all(|(other, _): &(&Results, _)| other.scene != r.scene);
        if is_new && let Ok(model) = self::dense(r) {
            dense.push((r, model));
        }
    }
    if dense.len() < 2 {
        return Err("needs runs of two scenes".into());
    }
    dense.sort_by_key(|(_, model)| model.gaussians);
    let ((small, a), (large, b)) = (dense[0], dense[dense.len() - 1]);
    if (&small.oracle, small.fps) != (&large.oracle, large.fps) {
        return Err("the runs count power differently (--oracle, --arch, --fps)".into());
    }
    if a.render_w <= 0.0 {
        return Err("a model without rendering power".into());
    }
    let ratio = b.render_w / a.render_w;
    let size = |r: &Results| format!("{}x{}", r.width_px, r.height_px);
    let [large_count, small_count] = [b, a].map(|m| count(m.gaussians as usize));
    let text = say(
        "{} ({} Gaussians, {}) : {} ({}, {}) = {} : 1 in rendering power",
        [
            large.scene.clone().into(),
            large_count,
            size(large).into(),
            small.scene.clone().into(),
            small_count,
            size(small).into(),
            fixed(ratio, Unit::One, 1),
        ],
    );
    here(text, ratio > 1.0)
}
