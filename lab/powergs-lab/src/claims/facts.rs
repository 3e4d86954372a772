//! What checks take out of results, or why they cannot.

use super::sentence::{Sentence, Unit, joined, say, signed};
use powergs_optimize::foveated::{LevelState, Method};
use powergs_optimize::results::{FovealRecord, ModelRecord, Reference, Results};
use powergs_optimize::role::Baseline;

/// A line about a run.
pub(super) fn about(r: &Results) -> String {
    let reference = match r.reference {
        Reference::Photos => "photos",
        Reference::Own => "the dense model's own renders",
    };
    let (w, h) = (r.width_px, r.height_px);
    let mut text = format!("{}, {w}x{h}, against {reference}, power: {}. ", r.scene, r.oracle);
    let names: Vec<&str> = r.variants.iter().map(|v| v.name.as_str()).collect();
    text += &format!("Variants: {}. ", names.join(", "));
    text += &r.regions_note().unwrap_or("Not foveated (optimize --foveated).".into());
    let baselines = r.models.iter().any(|m| m.baseline.is_some());
    if !baselines {
        text += " No baselines (optimize --baselines).";
    }
    text
}

/// The share that is saved.
pub(super) fn saved(ours_w: f64, other_w: f64) -> Result<f64, String> {
    if other_w > 0.0 { Ok(1.0 - ours_w / other_w) } else { Err("a model without power".into()) }
}

/// The high-quality variant: `H`, else that of the run.
pub(super) fn high(r: &Results) -> &str {
    let named = r.variants.iter().find(|v| v.name == "H").filter(|v| r.ours(&v.name).is_some());
    &named.unwrap_or(&r.variants[0]).name
}

/// The variant with the lowest target that has a model of ours.
pub(super) fn low(r: &Results) -> &str {
    let target = |name: &str| {
        let variant = r.variants.iter().find(|v| v.name == name);
        variant.and_then(|v| v.target_psnr_db).unwrap_or(f64::INFINITY)
    };
    let with_model = r.variants.iter().filter(|v| r.ours(&v.name).is_some());
    let names = with_model.map(|v| v.name.as_str());
    names.min_by(|a, b| target(a).total_cmp(&target(b))).unwrap_or(&r.variants[0].name)
}

/// The dense model.
pub(super) fn dense(r: &Results) -> Result<&ModelRecord, String> {
    r.dense().ok_or_else(|| "the dense model was not measured".into())
}

/// Our model of level 1.
pub(super) fn ours<'a>(r: &'a Results, variant: &str) -> Result<&'a ModelRecord, String> {
    r.ours(variant).ok_or_else(|| "no model of ours reached the target".into())
}

/// A comparison at level 1.
pub(super) fn baseline<'a>(
    r: &'a Results,
    baseline: Baseline,
    variant: &str,
) -> Result<&'a ModelRecord, String> {
    let missing = || format!("no {baseline} (optimize --baselines)");
    r.baseline(baseline, variant).ok_or_else(missing)
}

/// Our foveated model.
pub(super) fn foveated<'a>(r: &'a Results, variant: &str) -> Result<&'a FovealRecord, String> {
    match r.foveal(Method::PowerGs, variant) {
        Some(found) => Ok(found),
        None if r.screen.is_none() => Err("not foveated (optimize --foveated)".into()),
        None => Err("no model of ours reached the target".into()),
    }
}

/// A foveated comparison.
pub(super) fn compared<'a>(
    r: &'a Results,
    method: Method,
    variant: &str,
) -> Result<&'a FovealRecord, String> {
    match r.foveal(method, variant) {
        Some(found) => Ok(found),
        None if r.screen.is_none() => Err("not foveated (optimize --foveated)".into()),
        None => Err(format!("no {}-{variant} (optimize --baselines)", method.name())),
    }
}

/// The model of level 1 of a foveated model.
pub(super) fn first<'a>(r: &'a Results, f: &FovealRecord) -> Result<&'a ModelRecord, String> {
    r.model(&f.jobs[0]).ok_or_else(|| format!("{}: no level 1", f.label()))
}

/// Levels that show the model of the level before although views show them.
pub(super) fn fallbacks(f: &FovealRecord) -> Option<Sentence> {
    let is_fallback = |i: &usize| f.states[*i] == LevelState::Fallback;
    let levels: Vec<String> =
        (0..f.states.len()).filter(is_fallback).map(|i| format!("L{}", i + 1)).collect();
    let names = levels.join(", ");
    (!levels.is_empty()).then(|| format!("{} of {} missed the target", names, f.label()).into())
}

/// Quality that one model loses against another on the test views.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loss {
    /// Share of the other's PSNR; `None` where it says nothing: the dense model against its own
    /// renders.
    pub psnr: Option<f64>,
    /// Share of the other's SSIM.
    pub ssim: f64,
}

impl Loss {
    /// Whether neither is above `most`.
    pub fn is_within(self, most: f64) -> bool {
        self.psnr.is_none_or(|loss| loss <= most) && self.ssim <= most
    }
}

/// What our model loses on the test views.
pub(super) fn losses(r: &Results, ours: &ModelRecord, other: &ModelRecord) -> Result<Loss, String> {
    let share = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) if b > 0.0 => Some(1.0 - a / b),
        _ => None,
    };
    let is_perfect = r.reference == Reference::Own && other.baseline.is_none();
    let psnr = share(ours.test.psnr_db, other.test.psnr_db).filter(|_| !is_perfect);
    let ssim = share(ours.test.ssim, other.test.ssim);
    Ok(Loss { psnr, ssim: ssim.ok_or("no test views")? })
}

/// `PSNR 0.4 %, SSIM 0.1 %`.
pub(super) fn losses_text(loss: Loss) -> Sentence {
    let change = |loss: f64| [signed(-loss, Unit::Percent, 2)];
    let psnr = loss.psnr.map(|p| say("PSNR {} %", change(p)));
    joined(psnr.into_iter().chain([say("SSIM {} %", change(loss.ssim))]), ", ").unwrap_or_default()
}
