//! `results.json`: what an optimisation found, for programs: its models, fits and foveated models
//! with everything that tables, charts and the check of the published claims need.
//!
//! Names end in their unit. A value that was not measured, or is not finite, is `null`. The file
//! has a version; new names do not raise it, names that go away or change do.

mod made;
mod read;

pub use read::ResultsError;

use serde::{Deserialize, Serialize};

use crate::counted::PowerCounted;
use crate::fit::OptimumPlace;
use crate::foveated::{LevelState, Method};
use crate::judged::JudgedSize;
use crate::role::{Baseline, RoleKind};
use crate::views::Priced;
use powergs_frame::fovea::{LEVELS, REGIONS, ScreenRule, ScreenWidth};
use powergs_scene::Camera;

/// What the file is.
pub const FORMAT: &str = "powergs-sim-results";
/// Version of its shape.
pub const VERSION: u32 = 1;
/// Its name in a run folder.
pub const FILE: &str = "results.json";

/// A finished optimisation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// [`FORMAT`].
    pub format: String,
    /// [`VERSION`].
    pub version: u32,
    /// Version of the program that wrote it.
    pub tool_version: String,
    /// Name of the scene.
    pub scene: String,
    /// What models are compared with.
    pub reference: Reference,
    /// Width of the views that train, pixels.
    pub width_px: u32,
    /// Height of the views that train, pixels.
    pub height_px: u32,
    /// The sizes of what trains and of what gates and tests; `None` in files of before, where both
    /// were the same, whatever power was counted at.
    #[serde(default)]
    pub judged: Option<JudgedSize>,
    /// What power was counted over; `None` in files of before, where it was all views at their own
    /// size.
    #[serde(default)]
    pub priced: Option<Priced>,
    /// The views in which the result lost most against the dense model, first the worst: gate and
    /// test views.
    #[serde(default)]
    pub lost: Vec<LostRecord>,
    /// The virtual screens of a foveated run.
    pub screen: Option<ScreenRecord>,
    /// Regions that no view shows.
    pub missing_regions: Vec<String>,
    /// What counted the power: a machine, or `paper`.
    pub oracle: String,
    /// By which counts, whether standby is in them, and how the panel was scaled; `None` in files
    /// of before.
    #[serde(default)]
    pub counted: Option<PowerCounted>,
    /// Frames shown per second.
    pub fps: f64,
    /// The panel.
    pub display: String,
    /// Factor on its power.
    pub display_scale: f64,
    /// Display power over rendering power of the dense model.
    pub display_to_render: Option<f64>,
    /// Why the run ended before its jobs were done.
    pub stopped: Option<String>,
    /// The qualities; first that of the run.
    pub variants: Vec<VariantRecord>,
    /// Levels that were made.
    pub levels: u8,
    /// All models, in the order in which they were made.
    pub models: Vec<ModelRecord>,
    /// What the samples of each level of each variant say.
    pub fits: Vec<FitRecord>,
    /// Speed of the dense model on the machine, frames a second; foveated runs only.
    pub dense_fps: Option<f64>,
    /// The foveated models.
    pub foveated: Vec<FovealRecord>,
    /// How much the colours changed.
    pub mean_change: Option<ChangeRecord>,
}

/// A view, and what the result lost in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LostRecord {
    /// The view.
    pub view: String,
    /// Whether it is a test view; else it gates.
    pub is_test: bool,
    /// PSNR of the result, decibels.
    pub psnr_db: Option<f64>,
    /// PSNR of the dense model; `None` where it is the reference.
    pub dense_psnr_db: Option<f64>,
}

impl LostRecord {
    /// What it lost, decibels: against the dense model, or where that is the reference, against
    /// nothing.
    fn loss_db(&self) -> f64 {
        self.dense_psnr_db.unwrap_or(0.0) - self.psnr_db.unwrap_or(f64::INFINITY)
    }
}

/// What models are compared with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reference {
    /// Photos.
    Photos,
    /// Renders of the dense model.
    #[serde(rename = "self")]
    Own,
}

/// The virtual screens.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ScreenRecord {
    /// Its width, degrees; the least where each is as wide as the camera of its view sees.
    pub fov_deg: f64,
    /// The largest width where each is as wide as the camera of its view sees, degrees; `None`
    /// where one was given for all, as in files of before.
    #[serde(default)]
    pub widest_deg: Option<f64>,
    /// Pooling angle per squared eccentricity, 1/rad.
    pub pooling_rate: f64,
}

impl ScreenRecord {
    /// The screens of some views.
    pub(crate) fn of(screens: ScreenRule, views: &[Camera]) -> ScreenRecord {
        let widths = || views.iter().map(|camera| screens.of(camera).fov_deg);
        let (fov_deg, widest_deg) = match screens.width {
            ScreenWidth::OfCamera => {
                (widths().fold(f64::INFINITY, f64::min), Some(widths().fold(0.0, f64::max)))
            }
            ScreenWidth::Degrees(degrees) => (degrees, None),
        };
        ScreenRecord { fov_deg, widest_deg, pooling_rate: screens.pooling_rate }
    }

    /// How wide they are, in words.
    fn words(&self) -> String {
        let Some(widest) = self.widest_deg else {
            return format!("a screen of {} degrees", self.fov_deg);
        };
        let (least, most) = (format!("{:.1}", self.fov_deg), format!("{widest:.1}"));
        if least == most {
            format!("a screen of {most} degrees, as the cameras see")
        } else {
            format!("screens of {least} to {most} degrees, as the cameras see")
        }
    }
}

/// A quality that models were made for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct VariantRecord {
    /// `H`, `M`, `L`, or what the user asked for.
    pub name: String,
    /// PSNR that level 1 had to reach, decibels.
    pub target_psnr_db: Option<f64>,
    /// SSIM that it had to reach.
    pub target_ssim: Option<f64>,
    /// The model of level 1 that the run ends with: ours ([`FitRecord::best`]), or a comparison
    /// that passed with fewer watts.
    #[serde(default)]
    pub result: Option<String>,
    /// The foveated method that the run ends with.
    #[serde(default)]
    pub foveated_result: Option<Method>,
}

/// Quality and display power over some views, means.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SeenRecord {
    /// PSNR, decibels.
    pub psnr_db: Option<f64>,
    /// SSIM.
    pub ssim: Option<f64>,
    /// HVSQ at the pooling of the level.
    pub hvsq: Option<f64>,
    /// Display power, watts.
    pub display_w: f64,
}

/// A model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelRecord {
    /// Its job.
    pub name: String,
    /// What it was made for.
    pub role: RoleKind,
    /// The comparison, if it is one.
    pub baseline: Option<Baseline>,
    /// Weight of the display term in the study of λ, without unit: λ times the display power of the
    /// dense model.
    pub sweep_lambda: Option<f64>,
    /// The variant.
    pub variant: String,
    /// The level, from 1.
    pub level: u8,
    /// Share of the Gaussians that were pruned: of the dense model, or beyond level 1 of the model
    /// of the level before.
    pub rho: f64,
    /// Gaussians.
    pub gaussians: u64,
    /// Iterations done.
    pub iterations: u32,
    /// The iteration whose model was kept.
    pub kept_at: Option<u32>,
    /// λ of the kept model, 1/W.
    pub lambda_per_w: Option<f64>,
    /// What the red, green and blue of the model were scaled by, to spend what it had above its
    /// target on the display; `None` where they were not.
    #[serde(default)]
    pub gains: Option<[f32; 3]>,
    /// HVSQ that it had to reach, in the periphery.
    pub target_hvsq: Option<f64>,
    /// Distance from the target over the gate views, decibels; negative: missed.
    pub margin_db: Option<f64>,
    /// Where λ steered it: mean distance from the target, as the checks of the last tenth of its
    /// iterations estimated it, decibels. `None` where λ did not follow the quality.
    #[serde(default)]
    pub steered_db: Option<f64>,
    /// Whether it reached the target.
    pub passed: bool,
    /// Over the gate views.
    pub gate: SeenRecord,
    /// Over the gate views that did not choose; `None` where all of them do.
    #[serde(default)]
    pub confirmation: Option<SeenRecord>,
    /// How much more above the target the model was when it was chosen than all gate views found,
    /// decibels.
    #[serde(default)]
    pub luck_db: Option<f64>,
    /// Standard error of the mean PSNR over the gate views, decibels.
    #[serde(default)]
    pub gate_error_db: Option<f64>,
    /// Standard error of the mean PSNR over the test views, decibels.
    #[serde(default)]
    pub test_error_db: Option<f64>,
    /// Over the test views.
    pub test: SeenRecord,
    /// FLIP of the test views.
    pub flip_test: Option<f64>,
    /// LPIPS of the test views.
    pub lpips_test: Option<f64>,
    /// Display power over the power views, watts.
    pub display_w: f64,
    /// Rendering power over the power views, watts.
    pub render_w: f64,
}

impl ModelRecord {
    /// Display and rendering power, watts.
    pub fn total_w(&self) -> f64 {
        self.display_w + self.render_w
    }
}

/// What the samples of a level say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FitRecord {
    /// The variant.
    pub variant: String,
    /// The level, from 1.
    pub level: u8,
    /// Samples that reached the target.
    pub passed: usize,
    /// Samples that missed it.
    pub missed: usize,
    /// The model of the search with the least power that reached it.
    pub best: Option<String>,
    /// Why there is no curve.
    pub no_curve: Option<String>,
    /// ρ of the fitted minimum.
    pub optimum_rho: Option<f64>,
    /// Where it lies.
    pub optimum_place: Option<OptimumPlace>,
    /// The least and the largest ρ that were fitted.
    pub rho_range: Option<[f64; 2]>,
    /// ρ of the model that was made for the optimum.
    pub chosen_rho: Option<f64>,
    /// Total power that the fit predicts there, watts.
    pub predicted_w: Option<f64>,
    /// Total power of the model that was made there, watts.
    pub realised_w: Option<f64>,
    /// Share of the variance of the display power that the curve explains.
    pub r2_display: Option<f64>,
    /// The same of the rendering power.
    pub r2_render: Option<f64>,
    /// Mean relative error of the display curve.
    pub mre_display: Option<f64>,
    /// The same of the rendering curve.
    pub mre_render: Option<f64>,
}

/// A foveated model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FovealRecord {
    /// The method.
    pub method: Method,
    /// The variant.
    pub variant: String,
    /// Models of its levels.
    pub jobs: [String; LEVELS],
    /// The state of each level.
    pub states: [LevelState; LEVELS],
    /// Gaussians of each level.
    pub gaussians: [u64; LEVELS],
    /// Display power, watts.
    pub display_w: f64,
    /// Rendering power with the filter, watts.
    pub render_w: f64,
    /// The part of it that the colour filter takes, watts.
    pub filter_w: f64,
    /// PSNR, SSIM, FLIP and LPIPS of level 1 on whole test views behind the colour filter; `null`
    /// for methods without one.
    #[serde(default)]
    pub filtered: Option<FilteredRecord>,
    /// Frames a second of the simulated machine at full rate.
    pub fps: Option<f64>,
    /// HVSQ of each region of the shown frames; `null` for regions that no test view has.
    pub hvsq: [Option<f64>; LEVELS],
    /// Tiles of each region, mean over the power views.
    pub tiles: [f64; LEVELS],
    /// Sorting and rendering of each region on the machine, joules a frame.
    pub region_j: [f64; LEVELS],
}

/// How like their references views are, means.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FilteredRecord {
    /// PSNR, decibels.
    pub psnr_db: Option<f64>,
    /// SSIM.
    pub ssim: Option<f64>,
    /// FLIP.
    pub flip: Option<f64>,
    /// LPIPS.
    pub lpips: Option<f64>,
}

impl FovealRecord {
    /// Whether its frames are shown through the colour filter, so that its models are judged by
    /// nothing that is said of them.
    fn is_filtered(&self) -> bool {
        self.method == Method::RtgsD22
    }

    /// PSNR, SSIM, FLIP and LPIPS of level 1 on whole test views, as they are shown.
    pub fn likeness(&self, results: &Results) -> FilteredRecord {
        let nothing = FilteredRecord { psnr_db: None, ssim: None, flip: None, lpips: None };
        match (self.is_filtered(), results.model(&self.jobs[0])) {
            (true, _) => self.filtered.unwrap_or(nothing),
            (false, Some(model)) => FilteredRecord {
                psnr_db: model.test.psnr_db,
                ssim: model.test.ssim,
                flip: model.flip_test,
                lpips: model.lpips_test,
            },
            (false, None) => nothing,
        }
    }

    /// The state of each level; `None` where a target was reached or missed without the filter
    /// that is shown.
    pub fn shown_states(&self) -> [Option<LevelState>; LEVELS] {
        self.states.map(|state| match state {
            LevelState::Passed | LevelState::Missed => Some(state).filter(|_| !self.is_filtered()),
            LevelState::Fallback | LevelState::NotShown => Some(state),
        })
    }

    /// Levels of the periphery, from 1, whose search found nothing to prune: they have the
    /// Gaussians of the level before, and a model of their own. Colours alone are never pruned.
    pub fn unpruned(&self) -> Vec<usize> {
        let is_pruned = !matches!(self.method, Method::FrDisplay);
        let stays = |i: &usize| {
            let is_own = self.states[*i] == LevelState::Passed;
            is_own && is_pruned && self.gaussians[*i] == self.gaussians[*i - 1]
        };
        (1..LEVELS).filter(stays).map(|i| i + 1).collect()
    }

    /// Display and rendering power, watts.
    pub fn total_w(&self) -> f64 {
        self.display_w + self.render_w
    }

    /// HVSQ of the model of each level over whole test views, at the pooling of the level: what
    /// the publication reports for the regions. `None` where a level has no model of its own, and
    /// for RTGS+D22, whose models are shown filtered.
    pub fn level_hvsq(&self, results: &Results) -> [Option<f64>; LEVELS] {
        std::array::from_fn(|i| {
            let is_own = matches!(self.states[i], LevelState::Passed | LevelState::Missed);
            let is_shown = self.filter_w == 0.0 && !self.is_filtered();
            let model = results.model(&self.jobs[i]).filter(|_| is_own && is_shown)?;
            model.test.hvsq
        })
    }

    /// `PowerGS-H`.
    pub fn label(&self) -> String {
        format!("{}-{}", self.method.name(), self.variant)
    }

    /// The largest HVSQ of a region, and which one.
    pub fn worst(&self) -> Option<(f64, usize)> {
        let regions = (0..LEVELS).filter_map(|i| Some((self.hvsq[i]?, i)));
        regions.reduce(|a, b| if b.0 > a.0 { b } else { a })
    }
}

/// How much our colours changed against the dense model: mean change of red, green and blue in one
/// test view, codes of 8 bits.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ChangeRecord {
    /// The view.
    pub view: String,
    /// Of the whole picture of level 1.
    pub level_1: [f64; 3],
    /// Mean red, green and blue of the dense model's picture.
    pub dense: Option<[f64; 3]>,
    /// Of each region of the foveated frame; `null` for regions that it does not have.
    pub regions: Option<[Option<[f64; 3]>; LEVELS]>,
}

impl Results {
    /// The dense model.
    pub fn dense(&self) -> Option<&ModelRecord> {
        self.models.iter().find(|m| m.role == RoleKind::Dense)
    }

    /// A model by its name.
    pub fn model(&self, name: &str) -> Option<&ModelRecord> {
        self.models.iter().find(|m| m.name == name)
    }

    /// A comparison at level 1 of a variant.
    pub fn baseline(&self, baseline: Baseline, variant: &str) -> Option<&ModelRecord> {
        let is =
            |m: &&ModelRecord| m.baseline == Some(baseline) && m.level == 1 && m.variant == variant;
        self.models.iter().find(is)
    }

    /// What the samples of a level of a variant say.
    pub fn fit(&self, variant: &str, level: u8) -> Option<&FitRecord> {
        self.fits.iter().find(|f| f.variant == variant && f.level == level)
    }

    /// Our model of level 1 of a variant.
    pub fn ours(&self, variant: &str) -> Option<&ModelRecord> {
        self.model(self.fit(variant, 1)?.best.as_deref()?)
    }

    /// The model of level 1 that the run ends with for a variant.
    pub fn result(&self, variant: &str) -> Option<&ModelRecord> {
        let record = self.variants.iter().find(|v| v.name == variant)?;
        self.model(record.result.as_deref()?)
    }

    /// A foveated model.
    pub fn foveal(&self, method: Method, variant: &str) -> Option<&FovealRecord> {
        self.foveated.iter().find(|f| f.method == method && f.variant == variant)
    }

    /// Regions that some test view of some foveated model shows.
    fn counted_regions(&self) -> Vec<&'static str> {
        let counts = |i: &usize| self.foveated.iter().any(|f| f.hvsq[*i].is_some());
        (0..LEVELS).filter(counts).map(|i| REGIONS[i]).collect()
    }

    /// A sentence on the regions that count.
    pub fn regions_note(&self) -> Option<String> {
        let screen = self.screen?;
        let counted = self.counted_regions();
        let size = format!(
            "views of {}x{} on {}, pooling rate {} per rad",
            self.width_px,
            self.height_px,
            screen.words(),
            screen.pooling_rate
        );
        Some(match (counted.is_empty(), self.missing_regions.is_empty()) {
            (true, _) => format!("No region was measured ({size})."),
            (false, true) => format!("Regions that count: {} ({size}).", counted.join(", ")),
            (false, false) => format!(
                "Regions that count: {}; no view shows {} ({size}).",
                counted.join(", "),
                self.missing_regions.join(", ")
            ),
        })
    }
}

/// Share of the power that a foveated model saves over another on a panel that takes `ratio` times
/// the rendering power of the dense model. `ours` and `other` are display and rendering power,
/// watts; the models are not trained anew.
///
/// # Errors
/// Why there is no number: powers of 0.
pub fn saving_at(
    dense: &ModelRecord,
    ours: (f64, f64),
    other: (f64, f64),
    ratio: f64,
) -> Result<f64, String> {
    if dense.display_w <= 0.0 {
        return Err("the dense model shows black: no display power".into());
    }
    let scale = ratio * dense.render_w / dense.display_w;
    let total = |(display_w, render_w): (f64, f64)| scale * display_w + render_w;
    let other = total(other);
    if other > 0.0 { Ok(1.0 - total(ours) / other) } else { Err("a model without power".into()) }
}
