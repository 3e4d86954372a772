//! What is asked of an optimisation: inputs, targets, and what is made for comparison.

use powergs_core::flow::tile_wise::{FoveaSpec, VruSpec};
use powergs_core::run::{PaperModel, RunError};
use powergs_core::workload::paper::Padding;
use powergs_frame::display::Display;
use powergs_frame::fovea::ScreenRule;
use powergs_quality::Lpips;
use powergs_scene::{Camera, Gaussians};

use super::foveated::FilterCost;
use super::invalid::{Invalid, in_range};
use super::oracle::{CycleOracle, PowerOracle};
use super::plan::{Plan, Variant};
use super::references::ReferenceImages;
use super::renderer::{Processor, Renderer};
use super::role::{Baseline, Role};
use super::schedule::Schedule;
use super::settings::{Gate, Settings};
use super::target::{Level, Quality, TargetRule};
use super::views::{PowerCameras, PowerViews};

/// Weights of the display term, without unit, for the study of λ.
const SWEEP: [f64; 8] = [0.0, 0.005, 0.01, 0.02, 0.03, 0.05, 0.1, 0.3];
/// Gate views where a view more costs a render.
pub const LEAST_GATE: usize = 24;
/// Operations of a pixel in a rendering unit and cycle: the published costs of an α and of a blend.
const OPERATIONS: f64 = 13.0 + 11.0;

/// Everything that a campaign is made from. [`Campaign::open`](crate::campaign::Campaign::open)
/// checks it.
pub struct Request {
    /// Name of the scene, for people.
    pub name: String,
    /// The model to optimise.
    pub dense: Gaussians,
    /// Further trained models of the scene under their names, to compare with.
    pub externals: Vec<(String, Gaussians)>,
    /// All views.
    pub cameras: Vec<Camera>,
    /// What they should look like.
    pub references: ReferenceImages,
    /// Behind everything, sRGB from 0 to 1.
    pub background: [f32; 3],
    /// Of the training views, every so many-th validates; 0: as many as there are test views.
    pub validation_every: usize,
    /// Where the references are the dense model's own renders: so many views gate at least. Those
    /// that are missing are made between the others; with levels for the periphery, which look at
    /// gate views for long, none are.
    pub least_gate: usize,
    /// The cameras that power is counted with.
    pub power_cameras: PowerCameras,
    /// Which of them power is a mean over.
    pub power_views: PowerViews,
    /// Width and height of the photos or the camera file, pixels, where there are any: where power
    /// is counted at less, reports say so.
    pub full_size: Option<[u32; 2]>,
    /// What is to be made.
    pub goals: Goals,
    /// What trains and looks.
    pub renderer: Box<dyn Renderer>,
    /// What rendering costs.
    pub oracle: Box<dyn PowerOracle>,
    /// The panel.
    pub display: Display,
    /// The panel is scaled so that the dense model's display power is so many times its rendering
    /// power; `None` leaves it as it is.
    pub display_ratio: Option<f64>,
    /// How it is searched.
    pub settings: Settings,
    /// Levels for the periphery of sight; `None`: level 1 alone.
    pub foveation: Option<Foveation>,
    /// What LPIPS of the test views is measured with, and the hash of its file; `None`: it is not
    /// measured.
    pub lpips: Option<(Lpips, u128)>,
    /// Every model is kept with its moments, for those who look into a run. It changes no number.
    pub keep_all: bool,
}

impl Request {
    /// A model against its own renders in these views, with what the program takes where it is not
    /// told otherwise.
    pub fn new(
        name: &str,
        dense: Gaussians,
        cameras: Vec<Camera>,
        oracle: impl PowerOracle + 'static,
        display: Display,
    ) -> Request {
        Request {
            name: name.to_owned(),
            dense,
            externals: Vec::new(),
            cameras,
            references: ReferenceImages::own(),
            background: [0.0; 3],
            validation_every: 0,
            least_gate: LEAST_GATE,
            power_cameras: PowerCameras::Same,
            power_views: PowerViews::Usual,
            full_size: None,
            goals: Goals::default(),
            renderer: Box::new(Processor),
            oracle: Box::new(oracle),
            display,
            display_ratio: None,
            settings: Settings::DEFAULT,
            foveation: None,
            lpips: None,
            keep_all: false,
        }
    }
}

/// How good the result must be.
#[derive(Debug, Clone, PartialEq)]
pub enum Goal {
    /// Named steps, one or several: they are made from the highest to the lowest, each from what
    /// was made for those before it.
    Levels(Vec<Level>),
    /// This share of the PSNR and SSIM of the dense model.
    Share(f64),
    /// These numbers.
    Absolute {
        /// PSNR, decibels.
        psnr_db: f64,
        /// SSIM; 0 for none.
        ssim: f64,
    },
}

/// What is to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct Goals {
    /// How good the result must be; `None`: medium.
    pub goal: Option<Goal>,
    /// The samples.
    pub schedule: Schedule,
    /// Comparisons that are trained, in order.
    pub baselines: Vec<Baseline>,
    /// Whether savings are also computed over display-to-render ratios.
    pub ratio_study: bool,
    /// Whether fixed values of λ are tried without pruning.
    pub lambda_study: bool,
    /// Whether the validation views train too. With photos, the gate then sees what it trains on.
    pub train_on_validation: bool,
}

impl Default for Goals {
    fn default() -> Goals {
        Goals {
            goal: None,
            schedule: Schedule::FIVE,
            baselines: Vec::new(),
            ratio_study: false,
            lambda_study: false,
            train_on_validation: false,
        }
    }
}

impl Goals {
    /// The jobs that follow. `is_own`: the references are the dense model's own renders.
    /// `externals`: names of the user's other models. `levels`: those that the views show, from 1.
    ///
    /// # Errors
    /// [`Invalid`]: a target that says nothing or cannot be, a name that is taken.
    pub fn plan(
        &self,
        gate: Gate,
        is_own: bool,
        externals: &[String],
        levels: u8,
    ) -> Result<Plan, Invalid> {
        let mut baselines = self.baselines.clone();
        // The study compares with these two.
        for needed in [Baseline::DisplayOnly, Baseline::RenderOnly] {
            if self.ratio_study && !baselines.contains(&needed) {
                baselines.push(needed);
            }
        }
        for (i, name) in externals.iter().enumerate() {
            if Role::reserves(name) || externals[..i].contains(name) {
                return Err(Invalid::NameTaken(name.clone()));
            }
        }
        let variants = self.variants(is_own)?;
        for variant in variants.iter().skip(1) {
            if externals.iter().any(|name| name.starts_with(&format!("{}-", variant.name))) {
                return Err(Invalid::VariantName(variant.name.clone()));
            }
        }
        // Its own renders it has never been trained on, and a given number is no share.
        let is_share = matches!(variants[0].rule, TargetRule::Share(_));
        let holds_out = is_share && gate == Gate::Validation && !self.train_on_validation;
        Ok(Plan {
            schedule: self.schedule.clone(),
            baselines,
            externals: externals.to_vec(),
            sweep_weights: if self.lambda_study { SWEEP.to_vec() } else { Vec::new() },
            variants,
            holds_out,
            reference: None,
            given: None,
            levels,
        })
    }

    /// The qualities of the run, the highest first, each under its name if it is a named one.
    fn variants(&self, is_own: bool) -> Result<Vec<Variant>, Invalid> {
        if let Some(Goal::Levels(levels)) = &self.goal
            && !levels.is_empty()
        {
            let named =
                |level: &Level| Variant { name: level.name().to_owned(), rule: level.rule(is_own) };
            return Ok(Level::ALL.iter().filter(|l| levels.contains(l)).map(named).collect());
        }
        let (rule, name) = match self.goal {
            None => (Level::Medium.rule(is_own), Level::Medium.name().to_owned()),
            Some(_) => {
                let rule = self.rule(is_own)?;
                (rule, rule.asked())
            }
        };
        Ok(vec![Variant { name, rule }])
    }

    /// The rule of a goal that is not named.
    fn rule(&self, is_own: bool) -> Result<TargetRule, Invalid> {
        match self.goal {
            None | Some(Goal::Levels(_)) => Ok(Level::Medium.rule(is_own)),
            Some(Goal::Share(_)) if is_own => Err(Invalid::ShareOfPerfect),
            Some(Goal::Share(share)) if (0.01..=1.5).contains(&share) => {
                Ok(TargetRule::Share(share))
            }
            Some(Goal::Share(share)) => Err(Invalid::Share(share)),
            Some(Goal::Absolute { psnr_db, ssim })
                if (1.0..=120.0).contains(&psnr_db) && (0.0..=1.0).contains(&ssim) =>
            {
                Ok(TargetRule::Absolute(Quality::likeness(psnr_db, ssim)))
            }
            Some(Goal::Absolute { .. }) => Err(Invalid::Likeness),
        }
    }
}

/// What levels for the periphery of sight are made and measured for.
#[derive(Debug, Clone)]
pub struct Foveation {
    /// What decides the virtual screen of each view.
    pub screens: ScreenRule,
    /// The machine whose speed and regions are reported, whatever counts power.
    pub clock: CycleOracle,
    /// What the colour filter of the comparison costs on it.
    pub filter: FilterCost,
}

/// Why there is no foveation.
#[derive(Debug, thiserror::Error)]
pub enum FoveationError {
    /// A number or a machine that cannot be.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The price of an operation is not known.
    #[error(transparent)]
    Run(#[from] RunError),
}

impl Foveation {
    /// Checks the operations of the colour filter for a pixel.
    ///
    /// # Errors
    /// [`Invalid::Range`].
    pub fn check_filter(flops: f64) -> Result<(), Invalid> {
        in_range("filter_flops", flops, 0.0, 1e6)
    }

    /// A foveation on screens and a machine. `filter_flops`: operations of the colour filter for a
    /// pixel outside of the fovea (A99), at the published price.
    ///
    /// # Errors
    /// A screen that cannot be, a number out of its range, a machine that shows no foveated frames;
    /// [`RunError::Internal`]: the published prices are damaged.
    pub fn new(
        screens: ScreenRule,
        clock: CycleOracle,
        filter_flops: f64,
    ) -> Result<Foveation, FoveationError> {
        screens.check().map_err(Invalid::from)?;
        Foveation::check_filter(filter_flops)?;
        let machine = clock.system.machine();
        let (fovea, vru) = (machine.tables.get::<FoveaSpec>(), machine.tables.get::<VruSpec>());
        let (Some(fovea), Some(vru)) = (fovea, vru) else {
            let (machine, flow) = (machine.name.clone(), machine.flow().key());
            return Err(Invalid::NoLevels { machine, flow }.into());
        };
        if fovea.accumulators == 0 {
            return Err(Invalid::NoFovea(machine.name.clone()).into());
        }
        let lanes = f64::from(vru.cores) * f64::from(vru.units_per_core);
        let filter = FilterCost {
            flops: filter_flops,
            flop_pj: PaperModel::new(Padding::TrueTiles)?.prices.flop_pj,
            flops_per_cycle: lanes * OPERATIONS,
        };
        Ok(Foveation { screens, clock, filter })
    }
}
