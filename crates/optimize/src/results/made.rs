//! From a run to its results.

use super::{
    ChangeRecord, FORMAT, FilteredRecord, FitRecord, FovealRecord, LostRecord, ModelRecord,
    Reference, Results, ScreenRecord, SeenRecord, VERSION, VariantRecord,
};
use crate::campaign::{Campaign, FoveatedModels};
use crate::foveated::{MeasuredFoveated, cheapest, missing_regions};
use crate::history::HistoryRow;
use crate::job::Place;
use crate::outcome::Outcome;
use crate::plan::{Plan, Variant};
use crate::role::Role;
use crate::setup::{Seen, Setup};
use crate::target::Target;
use powergs_base::TOOL_VERSION;
use powergs_scene::Gaussians;

/// Where λ steered a model is read from this part of its iterations, the last one.
const LAST: u32 = 10;

impl Results {
    /// The results of a campaign: what was `done`, with the history of it. `stopped`: why it ended
    /// before its jobs were done.
    pub(crate) fn of(
        campaign: &Campaign,
        (done, history): (&[Outcome], &[HistoryRow]),
        stopped: Option<&str>,
        foveated: Option<&FoveatedModels>,
        (mean_change, lost): (Option<ChangeRecord>, Vec<LostRecord>),
    ) -> Results {
        let run = &ResultMade { plan: &campaign.plan, done, history };
        let dense = done.iter().find(|o| o.role == Role::Dense);
        let ratio = dense.map(|o| o.watts.display_w / o.watts.render_w);
        let screens = campaign.foveation.as_ref().map(|f| f.screens);
        let missing = screens.map_or(Vec::new(), |s| missing_regions(s, &campaign.power_views));
        let measured = foveated.map_or(&[][..], |f| &f.measured);
        Results {
            format: FORMAT.into(),
            version: VERSION,
            tool_version: TOOL_VERSION.into(),
            scene: campaign.name.clone(),
            reference: match campaign.references.is_own() {
                true => Reference::Own,
                false => Reference::Photos,
            },
            width_px: campaign.cameras[0].width,
            height_px: campaign.cameras[0].height,
            judged: Some(campaign.judged),
            priced: Some(campaign.priced.clone()),
            lost,
            screen: screens.map(|s| ScreenRecord::of(s, &campaign.power_views)),
            missing_regions: missing.into_iter().map(str::to_owned).collect(),
            oracle: campaign.oracle.name(),
            counted: Some(campaign.counted),
            fps: campaign.oracle.fps(),
            display: campaign.display.name.clone(),
            display_scale: campaign.display.scale,
            display_to_render: ratio.and_then(finite),
            stopped: stopped.map(str::to_owned),
            variants: variants(run, measured),
            levels: campaign.plan.levels,
            models: done.iter().enumerate().map(|(i, o)| model(run, i, o)).collect(),
            fits: fits(run),
            dense_fps: foveated.and_then(|f| finite(f.dense_fps)),
            foveated: measured.iter().map(|f| foveal(run, f)).collect(),
            mean_change,
        }
    }
}

/// Views that are named of those that lost.
const NAMED: usize = 5;

impl LostRecord {
    /// The views in which `scene` lost most against the dense model, of those that gate and test,
    /// first the worst. Views that were made are no views of the user.
    pub(crate) fn of(setup: &Setup<'_>, scene: &Gaussians, is_own: bool) -> Vec<LostRecord> {
        let gate = setup.gate_views();
        let gate = &gate[..gate.len().saturating_sub(setup.split.made)];
        let test = setup.split.test.iter().filter(|view| !gate.contains(view));
        let views: Vec<usize> = gate.iter().chain(test).copied().collect();
        let psnr = |scene: &Gaussians| {
            let seen = setup.see_each(scene, &views, None).into_iter();
            seen.map(|s| finite(s.quality.psnr_db)).collect::<Vec<Option<f64>>>()
        };
        let before = if is_own { vec![None; views.len()] } else { psnr(setup.dense) };
        let rows = views.iter().zip(psnr(scene)).zip(before);
        let mut lost: Vec<LostRecord> = rows
            .map(|((&view, psnr_db), dense_psnr_db)| LostRecord {
                view: setup.cameras[view].name.clone(),
                is_test: setup.split.test.contains(&view),
                psnr_db,
                dense_psnr_db,
            })
            .collect();
        lost.sort_by(|a, b| b.loss_db().total_cmp(&a.loss_db()));
        lost.truncate(NAMED);
        lost
    }
}

/// What was to be done, and what became of it.
struct ResultMade<'a> {
    plan: &'a Plan,
    done: &'a [Outcome],
    history: &'a [HistoryRow],
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn name_of(run: &ResultMade<'_>, variant: u8) -> String {
    run.plan.variants.get(usize::from(variant)).map_or(String::new(), |v| v.name.clone())
}

fn variants(run: &ResultMade<'_>, measured: &[MeasuredFoveated]) -> Vec<VariantRecord> {
    let record = |(i, v): (usize, &Variant)| {
        let target = run.plan.target(run.done, i as u8).and_then(|t| t.likeness_target());
        VariantRecord {
            name: v.name.clone(),
            target_psnr_db: target.and_then(|t| finite(t.psnr_db)),
            target_ssim: target.and_then(|t| finite(t.ssim)),
            result: run.plan.result(run.done, i as u8).map(|o| o.name.clone()),
            foveated_result: cheapest(measured, i as u8),
        }
    };
    run.plan.variants.iter().enumerate().map(record).collect()
}

fn seen(seen: &Seen) -> SeenRecord {
    let quality = seen.quality;
    SeenRecord {
        psnr_db: finite(quality.psnr_db),
        ssim: finite(quality.ssim),
        hvsq: quality.hvsq.and_then(finite),
        display_w: seen.display_w,
    }
}

fn model(run: &ResultMade<'_>, position: usize, o: &Outcome) -> ModelRecord {
    let target = match o.role {
        Role::Dense | Role::HeldOut => run.plan.target(run.done, 0),
        role => run.plan.target_at(run.done, role.baseline(), o.place),
    };
    ModelRecord {
        name: o.name.clone(),
        role: o.role.kind(),
        baseline: o.role.baseline(),
        sweep_lambda: if let Role::Sweep(lambda) = o.role { Some(lambda) } else { None },
        variant: name_of(run, o.place.variant),
        level: o.place.level + 1,
        rho: o.rho,
        gaussians: o.points as u64,
        iterations: o.iterations,
        kept_at: o.kept_at,
        lambda_per_w: o.lambda,
        gains: o.gains.map(|gains| gains.0),
        target_hvsq: target.and_then(|t| match t {
            Target::Hvsq(most) => finite(most),
            Target::Likeness(_) => None,
        }),
        margin_db: target.and_then(|t| finite(t.margin_db(o.gate.quality))),
        steered_db: target.and_then(|t| finite(steered_db(run, position, o, &t)?)),
        passed: match o.role {
            // They are judged by shares of their own when they are measured, which they always
            // reach.
            Role::Dense | Role::HeldOut => target.is_some_and(|t| t.passes(o.gate.quality)),
            Role::Sample
            | Role::Optimum
            | Role::Baseline(_)
            | Role::External(_)
            | Role::Sweep(_) => o.passed,
        },
        gate: seen(&o.gate),
        confirmation: o.confirmation.map(|c| seen(&c.seen)),
        luck_db: o.confirmation.and_then(|c| c.luck_db),
        gate_error_db: o.error_db[0],
        test_error_db: o.error_db[1],
        test: seen(&o.test),
        flip_test: finite(o.flip_test),
        lpips_test: o.lpips_test.and_then(finite),
        display_w: o.watts.display_w,
        render_w: o.watts.render_w,
    }
}

/// Mean distance from the target over the checks of the last tenth of the iterations of the job at
/// a position, where λ followed the quality.
fn steered_db(run: &ResultMade<'_>, position: usize, o: &Outcome, target: &Target) -> Option<f64> {
    if o.lambda.is_none() || matches!(o.role, Role::Sweep(_)) {
        return None;
    }
    let from = o.iterations - o.iterations.div_ceil(LAST);
    let rows = run.history.iter().filter(|row| row.job == position);
    let last = rows.map(|row| &row.iteration).filter(|i| i.iteration >= from && i.lambda > 0.0);
    let checks = last.filter_map(|i| i.check);
    let margins: Vec<f64> = checks.map(|check| target.margin_db(check.seen.quality)).collect();
    (!margins.is_empty()).then(|| margins.iter().sum::<f64>() / margins.len() as f64)
}

/// One for every place that has samples.
fn fits(run: &ResultMade<'_>) -> Vec<FitRecord> {
    let variants = 0..run.plan.variants.len() as u8;
    let places = variants.flat_map(|variant| (0..4).map(move |level| Place { variant, level }));
    let has_samples = |p: &Place| run.done.iter().any(|o| o.role == Role::Sample && o.place == *p);
    places.filter(has_samples).map(|place| fit(run, place)).collect()
}

fn fit(run: &ResultMade<'_>, place: Place) -> FitRecord {
    let conclusion = run.plan.conclusion(run.done, place);
    let best = match place.level {
        0 => run.plan.model_at(run.done, None, place).map(|o| o.name.clone()),
        _ => conclusion.best.clone(),
    };
    let realised = run.done.iter().find(|o| o.role == Role::Optimum && o.place == place);
    let fit = conclusion.fit.as_ref().ok();
    FitRecord {
        variant: name_of(run, place.variant),
        level: place.level + 1,
        passed: conclusion.passed,
        missed: conclusion.missed.len(),
        best,
        no_curve: conclusion.fit.as_ref().err().map(ToString::to_string),
        optimum_rho: conclusion.optimum.map(|o| o.rho),
        optimum_place: conclusion.optimum.map(|o| o.place),
        rho_range: fit.map(|f| [f.rho_min(), f.rho_max()]),
        chosen_rho: conclusion.rho,
        predicted_w: conclusion.predicted().map(|p| p.total_w()),
        realised_w: realised.map(|o| o.watts.total_w()),
        r2_display: fit.and_then(|f| f.display.r2),
        r2_render: fit.and_then(|f| f.render.r2),
        mre_display: fit.and_then(|f| f.display.mre),
        mre_render: fit.and_then(|f| f.render.mre),
    }
}

fn foveal(run: &ResultMade<'_>, f: &MeasuredFoveated) -> FovealRecord {
    FovealRecord {
        method: f.levels.method,
        variant: name_of(run, f.levels.variant),
        jobs: f.levels.jobs.clone(),
        states: f.levels.state,
        gaussians: f.counts.map(|n| n as u64),
        display_w: f.watts.display_w,
        render_w: f.watts.render_w,
        filter_w: f.filter_w,
        filtered: f.filtered.map(|like| FilteredRecord {
            psnr_db: finite(like.psnr_db),
            ssim: finite(like.ssim),
            flip: finite(like.flip),
            lpips: like.lpips.and_then(finite),
        }),
        fps: finite(f.fps),
        hvsq: f.hvsq.map(|v| v.and_then(finite)),
        tiles: f.tiles,
        region_j: f.region_j,
    }
}
