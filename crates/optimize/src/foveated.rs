//! Foveated models as a viewer sees them: four levels around a gaze, with their power, their speed
//! and the HVSQ of each region; ours and those of the published baselines.
//!
//! In view i the viewer looks at gaze i of the published cycle of nine. Power is the mean over the
//! power views, HVSQ the mean over the test views.

use serde::{Deserialize, Serialize};

use rayon::prelude::*;

use super::job::Place;
use super::oracle::{CycleOracle, OracleParts, OracleWatts, PowerOracle, RenderedFrame};
use super::outcome::Outcome;
use super::plan::{Plan, PlanLine};
use super::role::Baseline;
use super::setup::Setup;
use powergs_base::picture::Picture;
use powergs_core::run::frames::eyes;
use powergs_core::sim::{FrameReport, SimError};
use powergs_energy::Component;
use powergs_energy::action::Phase;
use powergs_frame::display::d22::{Filter, Gaze};
use powergs_frame::fovea::{
    GAZE_CYCLE, GazeError, LEVELS, POOLINGS, REGIONS, ScreenGaze, ScreenRule, TileLevels,
};
use powergs_frame::splat::TileGrid;
use powergs_quality::flip::{PIXELS_PER_DEGREE, flip};
use powergs_quality::hvsq::Measures;
use powergs_quality::likeness;
use powergs_raster::{Detail, Options, render, render_foveated};
use powergs_scene::{Camera, Foveated, Gaussians};

/// A foveated method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Method {
    /// Pruning and colours together: ours.
    #[serde(rename = "PowerGS")]
    PowerGs,
    /// Pruning alone, as MetaSapiens (RTGS).
    #[serde(rename = "FR-Render")]
    FrRender,
    /// Colours alone, without pruning.
    #[serde(rename = "FR-Display")]
    FrDisplay,
    /// [`Method::FrRender`], and the colour filter of Duinkharjav et al. on every frame.
    #[serde(rename = "RTGS+D22")]
    RtgsD22,
}

impl Method {
    /// All of them, ours first.
    pub const ALL: [Method; 4] =
        [Method::PowerGs, Method::FrRender, Method::FrDisplay, Method::RtgsD22];

    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Method::PowerGs => "PowerGS",
            Method::FrRender => "FR-Render",
            Method::FrDisplay => "FR-Display",
            Method::RtgsD22 => "RTGS+D22",
        }
    }

    /// The baseline whose models it shows; `None`: ours.
    pub const fn line(self) -> PlanLine {
        match self {
            Method::PowerGs => None,
            Method::FrRender | Method::RtgsD22 => Some(Baseline::RenderOnly),
            Method::FrDisplay => Some(Baseline::DisplayOnly),
        }
    }
}

/// The models of a run that are the four levels of a method.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Levels {
    /// The method.
    pub method: Method,
    /// Position in the variants of the plan.
    pub variant: u8,
    /// The job that made the model of each level. Where none passed, it is that of the level
    /// before.
    pub jobs: [String; LEVELS],
    /// The state of each level.
    pub state: [LevelState; LEVELS],
}

/// Where the model of a level comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LevelState {
    /// A model of its own that reaches its target.
    Passed,
    /// A model of its own that misses it: level 1 of a baseline.
    Missed,
    /// The model of the level before, because none passed.
    Fallback,
    /// The model of the level before: no view shows the level.
    NotShown,
}

impl LevelState {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            LevelState::Passed => "passed",
            LevelState::Missed => "missed",
            LevelState::Fallback => "fallback",
            LevelState::NotShown => "not_shown",
        }
    }
}

/// Where somebody looks in view `i`, that of `camera`.
pub(crate) fn looking(screens: ScreenRule, i: usize, camera: &Camera) -> ScreenGaze {
    ScreenGaze { point: GAZE_CYCLE[i % GAZE_CYCLE.len()], screen: screens.of(camera) }
}

/// Levels that some view shows, from 1.
pub(crate) fn levels_shown(screens: ScreenRule, views: &[Camera]) -> u8 {
    let of_view = |(camera, looking): (&Camera, ScreenGaze)| {
        let (width, height) = (camera.width, camera.height);
        let sight = looking.eccentricity_map([width, height]).ok()?;
        let tiles = TileLevels::new(&sight, TileGrid::new(width, height, 16)).tiles;
        tiles.iter().map(|t| t.first + u8::from(t.blends)).max()
    };
    1 + views.iter().zip(gazes(screens, views)).filter_map(of_view).max().unwrap_or(0)
}

/// Where somebody looks in each view. Both eyes of a pair look at the same point of their images,
/// that of an object far away.
fn gazes(screens: ScreenRule, views: &[Camera]) -> Vec<ScreenGaze> {
    let eyes = eyes(views);
    let of_view = |(i, camera): (usize, &Camera)| looking(screens, i / eyes, camera);
    views.iter().enumerate().map(of_view).collect()
}

/// The regions that no view shows: images that are too small for all four.
pub fn missing_regions(screens: ScreenRule, views: &[Camera]) -> Vec<&'static str> {
    let missing = powergs_scene::gaze::missing_regions(views, &gazes(screens, views));
    missing.into_iter().map(|region| REGIONS[usize::from(region)]).collect()
}

/// The foveated models of a run: variant by variant, in the order of [`Method::ALL`].
pub fn lines(plan: &Plan, done: &[Outcome]) -> Vec<Levels> {
    if plan.levels < 2 {
        return Vec::new();
    }
    let variants = 0..plan.variants.len() as u8;
    let all = variants.flat_map(|v| Method::ALL.map(|method| (v, method)));
    all.filter_map(|(variant, method)| {
        let of = |level: usize| {
            let place = Place { variant, level: level as u8 };
            let own = plan.model_at(done, method.line(), place)?;
            // Level 1 may be that of a higher quality.
            let is_own = own.place.level == place.level;
            let state = match (level < usize::from(plan.levels), is_own) {
                (false, _) => LevelState::NotShown,
                (true, false) => LevelState::Fallback,
                (true, true) if own.passed => LevelState::Passed,
                (true, true) => LevelState::Missed,
            };
            Some((own.name.clone(), state))
        };
        let [a, b, c, d] = std::array::from_fn(of);
        let all = [a?, b?, c?, d?];
        let state = all.each_ref().map(|(_, state)| *state);
        Some(Levels { method, variant, jobs: all.map(|(name, _)| name), state })
    })
    .collect()
}

/// What the colour filter costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterCost {
    /// Floating-point operations for a pixel outside of the fovea (A99).
    pub flops: f64,
    /// Price of one, picojoules.
    pub flop_pj: f64,
    /// Operations a cycle of the rendering units, which filter the finished frame (A99).
    pub flops_per_cycle: f64,
}

/// How like their references whole test views of level 1 are behind the colour filter, means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilteredLikeness {
    /// PSNR, decibels.
    pub psnr_db: f64,
    /// SSIM.
    pub ssim: f64,
    /// FLIP, at the viewing distance of its authors.
    pub flip: f64,
    /// LPIPS; `None` without weights.
    pub lpips: Option<f64>,
}

/// A foveated model, measured.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MeasuredFoveated {
    /// The models that it is composed of.
    pub levels: Levels,
    /// Gaussians of each level.
    pub counts: [usize; LEVELS],
    /// Power at the display rate; rendering includes the filter.
    pub watts: OracleWatts,
    /// The part of it that the filter takes.
    pub filter_w: f64,
    /// Frames a second of the machine at full rate.
    pub fps: f64,
    /// How like level 1 is behind the colour filter; `None` for methods without one.
    pub filtered: Option<FilteredLikeness>,
    /// HVSQ of each region of the shown frames at its pooling; `None` for regions that no test view
    /// has.
    pub hvsq: [Option<f64>; LEVELS],
    /// Tiles of each region, mean over the power views.
    pub tiles: [f64; LEVELS],
    /// Sorting and rendering of each region on the machine, joules a frame.
    pub region_j: [f64; LEVELS],
}

/// The method that a variant ends with: ours, or a comparison with fewer watts whose levels all
/// reach their targets; `None` where there is none of ours. RTGS+D22 is none: its quality is not
/// held to any target.
pub fn cheapest(measured: &[MeasuredFoveated], variant: u8) -> Option<Method> {
    let here = || measured.iter().filter(|f| f.levels.variant == variant);
    let ours = here().find(|f| f.levels.method == Method::PowerGs)?;
    let passes = |f: &&MeasuredFoveated| {
        let is_model = matches!(f.levels.method, Method::FrRender | Method::FrDisplay);
        is_model && !f.levels.state.contains(&LevelState::Missed)
    };
    let all = [ours].into_iter().chain(here().filter(passes));
    let least = all.min_by(|a, b| a.watts.total_w().total_cmp(&b.watts.total_w()))?;
    Some(least.levels.method)
}

/// What foveated models are measured with.
pub struct Viewer<'a> {
    /// The run.
    pub setup: &'a Setup<'a>,
    /// What decides the virtual screen of each view.
    pub screens: ScreenRule,
    /// The machine whose speed and regions are reported.
    pub clock: &'a CycleOracle,
    /// What the filter costs.
    pub cost: FilterCost,
}

/// A foveated model could not be measured.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FovealError {
    /// A defect of the simulator.
    #[error(transparent)]
    SimError(#[from] SimError),
    /// A screen that cannot be.
    #[error(transparent)]
    Gaze(#[from] GazeError),
}

/// One frame of the display, of a pair both eyes.
struct Shown {
    parts: OracleParts,
    display_w: f64,
    seconds: f64,
    tiles: [f64; LEVELS],
    joules: [f64; LEVELS],
}

impl Viewer<'_> {
    /// Measures the model of `levels`.
    ///
    /// # Errors
    /// [`FovealError`].
    pub fn measure(
        &self,
        levels: Levels,
        model: &Foveated,
    ) -> Result<MeasuredFoveated, FovealError> {
        let is_filtered = levels.method == Method::RtgsD22;
        let views = self.setup.power_views;
        let shown = views
            .par_chunks(eyes(views))
            .enumerate()
            .map(|(i, eyes)| self.show(model, eyes, i, is_filtered))
            .collect::<Result<Vec<Shown>, FovealError>>()?;
        let n = shown.len().max(1) as f64;
        let frames: Vec<(OracleParts, f64)> =
            shown.iter().map(|s| (s.parts, s.display_w)).collect();
        let mut watts = OracleWatts::mean(&frames);
        let mean = |of: fn(&Shown) -> [f64; LEVELS]| {
            std::array::from_fn(|k| shown.iter().map(|s| of(s)[k]).sum::<f64>() / n)
        };
        let filter_w = if is_filtered { self.filter_w() } else { 0.0 };
        // Among the parts, too, whose sum rendering power is.
        watts.parts.0[Phase::Rendering as usize][Component::Flop as usize] += filter_w;
        watts.render_w += filter_w;
        let filtered = is_filtered.then(|| self.filtered_likeness(&model.level(0))).transpose()?;
        Ok(MeasuredFoveated {
            levels,
            counts: model.counts(),
            watts,
            filter_w,
            filtered,
            fps: n / shown.iter().map(|s| s.seconds).sum::<f64>(),
            hvsq: self.hvsq(model, is_filtered)?,
            tiles: mean(|s| s.tiles),
            region_j: mean(|s| s.joules),
        })
    }

    /// Frames a second of a plain model on the machine, over the power views.
    ///
    /// # Errors
    /// [`FovealError`].
    pub(crate) fn plain_fps(&self, scene: &Gaussians) -> Result<f64, FovealError> {
        let setup = self.setup;
        let background = setup.background;
        let options = Options { background, ..Options::reference(Detail::Counters) };
        let of_view = |camera: &Camera| -> Result<f64, FovealError> {
            let shot = RenderedFrame::Plain(render(scene, camera, &options));
            let report = self.clock.report(shot, camera, background)?;
            Ok(report.frame_time_s().unwrap_or(f64::NAN))
        };
        let views = setup.power_views;
        let seconds: Vec<f64> = views.par_iter().map(of_view).collect::<Result<_, _>>()?;
        Ok((views.len() / eyes(views)) as f64 / seconds.iter().sum::<f64>())
    }

    fn show(
        &self,
        model: &Foveated,
        eyes: &[Camera],
        i: usize,
        is_filtered: bool,
    ) -> Result<Shown, FovealError> {
        let setup = self.setup;
        let background = setup.background;
        let options = Options { background, ..Options::reference(Detail::Counters) };
        // The machine that gives the time gives the power too, unless another oracle does.
        let is_paid_elsewhere = setup.oracle.id() != self.clock.id();
        let mut display_w = 0.0;
        let mut filter_s = 0.0;
        let mut elsewhere = Vec::new();
        let mut reports = Vec::new();
        for camera in eyes {
            let looking = looking(self.screens, i, camera);
            let frame = render_foveated(model, camera, &looking, &options)?;
            let linear = if is_filtered {
                let cycles = filtered_pixels(camera, &looking)? * self.cost.flops
                    / self.cost.flops_per_cycle;
                filter_s += cycles / self.clock.system.machine().clock.0;
                self.filtered(&frame.picture, &looking)?.mean_linear_rgb()
            } else {
                frame.picture.mean_linear_rgb()
            };
            display_w += setup.display.power(linear).0;
            if is_paid_elsewhere {
                elsewhere.push((RenderedFrame::Foveated(frame.clone()), camera));
            }
            reports.push(self.clock.report(RenderedFrame::Foveated(frame), camera, background)?);
        }
        let report = reports.into_iter().reduce(FrameReport::with_right);
        let report = report.expect("a frame has an eye");
        let parts = match is_paid_elsewhere {
            true => setup.oracle.views(elsewhere, background)?,
            false => self.clock.parts(&report),
        };
        let regions = report.regions().copied().unwrap_or_default();
        Ok(Shown {
            parts,
            display_w,
            seconds: report.frame_time_s().unwrap_or(f64::NAN) + filter_s,
            tiles: regions.map(|r| r.tiles as f64),
            joules: regions.map(|r| r.energy_pj * 1e-12),
        })
    }

    /// The picture as the colour filter shows it.
    ///
    /// # Errors
    /// A gaze or a screen that cannot be.
    pub fn filtered(&self, picture: &Picture, looking: &ScreenGaze) -> Result<Picture, GazeError> {
        let [x, y] = looking.point.map(f64::from);
        let gaze = Gaze::new(x, y, looking.screen.fov_deg)?;
        Ok(Filter::new(self.setup.display).apply(picture, &gaze))
    }

    /// How like their references whole test views of a model are behind the colour filter, with the
    /// gazes of the views.
    fn filtered_likeness(&self, scene: &Gaussians) -> Result<FilteredLikeness, FovealError> {
        let setup = self.setup;
        let views = &setup.split.test;
        let n = views.len().max(1) as f64;
        let mut reference = Picture::default();
        let mut mean = FilteredLikeness {
            psnr_db: 0.0,
            ssim: 0.0,
            flip: 0.0,
            lpips: setup.lpips.map(|_| 0.0),
        };
        for (i, &view) in views.iter().enumerate() {
            let looking = looking(self.screens, i, &setup.cameras[view]);
            let picture = self.filtered(&setup.look(scene, view), &looking)?;
            setup.references.write_to(view, &mut reference);
            let like = likeness(&picture, &reference);
            mean.psnr_db += like.psnr_db / n;
            mean.ssim += like.ssim / n;
            mean.flip += flip(&reference, &picture, PIXELS_PER_DEGREE) / n;
            // A view that is too small or too large has none, and so has the mean.
            let lpips = setup.lpips.and_then(|lpips| lpips.distance(&picture, &reference).ok());
            mean.lpips = mean.lpips.zip(lpips).map(|(sum, lpips)| sum + lpips / n);
        }
        Ok(mean)
    }

    /// Power of the filter at the display rate.
    fn filter_w(&self) -> f64 {
        let views = self.setup.power_views;
        let of_view = |(camera, looking): (&Camera, ScreenGaze)| {
            filtered_pixels(camera, &looking).unwrap_or(0.0)
        };
        let pixels: f64 = views.iter().zip(gazes(self.screens, views)).map(of_view).sum();
        let per_frame = pixels / (views.len() / eyes(views)).max(1) as f64;
        per_frame * self.cost.flops * self.cost.flop_pj * 1e-12 * self.clock.fps
    }

    /// HVSQ of each region, mean over the test views that have it.
    fn hvsq(
        &self,
        model: &Foveated,
        is_filtered: bool,
    ) -> Result<[Option<f64>; LEVELS], FovealError> {
        let setup = self.setup;
        let background = setup.background;
        let options = Options { background, ..Options::reference(Detail::Image) };
        let mut measures = Measures::default();
        let mut reference = Picture::default();
        let mut sums = [(0.0, 0u32); LEVELS];
        for (i, &view) in setup.split.test.iter().enumerate() {
            let camera = &setup.cameras[view];
            let looking = looking(self.screens, i, camera);
            let mut picture = render_foveated(model, camera, &looking, &options)?.picture;
            if is_filtered {
                picture = self.filtered(&picture, &looking)?;
            }
            setup.references.write_to(view, &mut reference);
            let regions = looking.eccentricity_map([camera.width, camera.height])?.regions();
            let Ok(measure) = measures.of(&picture, &POOLINGS) else { continue };
            let reference = measure.reference(&reference);
            let all = measure.regional(&picture, &reference, &regions);
            for ((sum, n), value) in sums.iter_mut().zip(all) {
                if let Some(value) = value {
                    *sum += value;
                    *n += 1;
                }
            }
        }
        Ok(sums.map(|(sum, n)| (n > 0).then(|| sum / f64::from(n))))
    }
}

/// Pixels that the filter changes.
fn filtered_pixels(camera: &Camera, looking: &ScreenGaze) -> Result<f64, GazeError> {
    let [x, y] = looking.point.map(f64::from);
    let gaze = Gaze::new(x, y, looking.screen.fov_deg)?;
    let size = Picture { width: camera.width, height: camera.height, pixels: Vec::new() };
    let all = (0..camera.height).flat_map(|y| (0..camera.width).map(move |x| (x, y)));
    Ok(all.filter(|&(x, y)| Filter::changes(gaze.eccentricity_deg(x, y, &size))).count() as f64)
}
