//! From a run to its results.

use super::{
    FORMAT, FitRecord, FovealRecord, ModelRecord, Reference, Results, ScreenRecord, SeenRecord,
    VERSION, VariantRecord,
};
use crate::foveated::Foveal;
use crate::plan::{Campaign, Outcome, Place, Role};
use crate::setup::Seen;
use crate::target::Target;
use powergs_base::TOOL_VERSION;
use powergs_frame::fovea::{REGIONS, Screen};

/// What results are made from.
#[derive(Debug, Clone, Copy)]
pub struct Sources<'a> {
    /// Name of the scene.
    pub scene: &'a str,
    /// Whether renders of the dense model are the references.
    pub is_self: bool,
    /// Size of the views, pixels.
    pub size: [u32; 2],
    /// The virtual screen of a foveated run.
    pub screen: Option<Screen>,
    /// Regions that no view shows, 0 for R1.
    pub missing: &'a [u8],
    /// What counted the power.
    pub oracle: &'a str,
    /// Frames shown per second.
    pub fps: f64,
    /// The panel, and the factor on its power.
    pub display: (&'a str, f64),
    /// Why the run ended before its jobs were done.
    pub stopped: Option<&'a str>,
    /// What was to be done.
    pub campaign: &'a Campaign,
    /// What became of it.
    pub done: &'a [Outcome],
    /// Foveated models.
    pub measured: &'a [Foveal],
    /// Speed of the dense model on the machine, frames a second.
    pub dense_fps: Option<f64>,
}

impl Results {
    /// The results of a run, without its colours.
    pub fn of(run: &Sources<'_>) -> Results {
        let dense = run.done.iter().find(|o| o.role == Role::Dense);
        let ratio = dense.map(|o| o.watts.display_w / o.watts.render_w);
        let screen = |s: Screen| ScreenRecord { fov_deg: s.fov_deg, pooling_rate: s.pooling_rate };
        let names = run.missing.iter().filter_map(|&r| REGIONS.get(usize::from(r)));
        Results {
            format: FORMAT.into(),
            version: VERSION,
            tool_version: TOOL_VERSION.into(),
            scene: run.scene.into(),
            reference: if run.is_self { Reference::Own } else { Reference::Photos },
            width_px: run.size[0],
            height_px: run.size[1],
            screen: run.screen.map(screen),
            missing_regions: names.map(|r| (*r).to_owned()).collect(),
            oracle: run.oracle.into(),
            fps: run.fps,
            display: run.display.0.into(),
            display_scale: run.display.1,
            display_to_render: ratio.and_then(finite),
            stopped: run.stopped.map(str::to_owned),
            variants: variants(run),
            levels: run.campaign.levels,
            models: run.done.iter().map(|o| model(run, o)).collect(),
            fits: fits(run),
            dense_fps: run.dense_fps.and_then(finite),
            foveated: run.measured.iter().map(|f| foveal(run, f)).collect(),
            mean_change: None,
        }
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn name_of(run: &Sources<'_>, variant: u8) -> String {
    run.campaign.variants.get(usize::from(variant)).map_or(String::new(), |v| v.name.clone())
}

fn variants(run: &Sources<'_>) -> Vec<VariantRecord> {
    let record = |(i, v): (usize, &crate::plan::Variant)| {
        let target = run.campaign.target(run.done, i as u8).and_then(|t| t.likeness_target());
        VariantRecord {
            name: v.name.clone(),
            target_psnr_db: target.and_then(|t| finite(t.psnr_db)),
            target_ssim: target.and_then(|t| finite(t.ssim)),
        }
    };
    run.campaign.variants.iter().enumerate().map(record).collect()
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

fn model(run: &Sources<'_>, o: &Outcome) -> ModelRecord {
    let target = match o.role {
        Role::Dense | Role::HeldOut => run.campaign.target(run.done, 0),
        role => run.campaign.target_at(run.done, role.line(), o.place),
    };
    ModelRecord {
        name: o.name.clone(),
        role: o.role.kind(),
        baseline: o.role.line().map(|b| b.name()),
        sweep_lambda: if let Role::Sweep(lambda) = o.role { Some(lambda) } else { None },
        variant: name_of(run, o.place.variant),
        level: o.place.level + 1,
        rho: o.rho,
        gaussians: o.points as u64,
        iterations: o.iterations,
        kept_at: o.kept_at,
        lambda_per_w: o.lambda,
        target_hvsq: target.and_then(|t| match t {
            Target::Hvsq(most) => finite(most),
            Target::Likeness(_) => None,
        }),
        margin_db: target.and_then(|t| finite(t.margin_db(o.gate.quality))),
        passed: o.passed,
        gate: seen(&o.gate),
        test: seen(&o.test),
        flip_test: finite(o.flip_test),
        lpips_test: o.lpips_test.and_then(finite),
        display_w: o.watts.display_w,
        render_w: o.watts.render_w,
    }
}

/// One for every place that has samples.
fn fits(run: &Sources<'_>) -> Vec<FitRecord> {
    let variants = 0..run.campaign.variants.len() as u8;
    let places = variants.flat_map(|variant| (0..4).map(move |level| Place { variant, level }));
    let has_samples = |p: &Place| run.done.iter().any(|o| o.role == Role::Sample && o.place == *p);
    places.filter(has_samples).map(|place| fit(run, place)).collect()
}

fn fit(run: &Sources<'_>, place: Place) -> FitRecord {
    let conclusion = run.campaign.conclusion(run.done, place);
    let realised = run.done.iter().find(|o| o.role == Role::Final && o.place == place);
    let fit = conclusion.fit.as_ref().ok();
    FitRecord {
        variant: name_of(run, place.variant),
        level: place.level + 1,
        passed: conclusion.passed,
        missed: conclusion.missed.len(),
        best: conclusion.best.clone(),
        no_curve: conclusion.fit.as_ref().err().map(ToString::to_string),
        optimum_rho: conclusion.optimum.map(|o| o.rho),
        optimum_place: conclusion.optimum.map(|o| o.place.name().to_owned()),
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

fn foveal(run: &Sources<'_>, f: &Foveal) -> FovealRecord {
    FovealRecord {
        method: f.levels.method,
        variant: name_of(run, f.levels.variant),
        jobs: f.levels.jobs.clone(),
        states: f.levels.state,
        gaussians: f.counts.map(|n| n as u64),
        display_w: f.watts.display_w,
        render_w: f.watts.render_w,
        filter_w: f.filter_w,
        fps: finite(f.fps),
        hvsq: f.hvsq.map(|v| v.and_then(finite)),
        tiles: f.tiles,
        region_j: f.region_j,
    }
}
