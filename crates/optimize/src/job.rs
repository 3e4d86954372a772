//! A job of a run, and what became of it.

use serde::{Deserialize, Serialize};

use super::oracle::Watts;
use super::setup::{Seen, Setup};
use super::target::{Quality, Target};
use super::tune::{Check, DisplayTerm, Model, Orders};
use powergs_core::sim::SimError;
use powergs_frame::fovea::POOLINGS;

/// What else is made for comparison, with the budget of the final model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Baseline {
    /// Pruned while the quality passes; colours are left alone.
    RenderOnly,
    /// Not pruned; the display term takes all the slack.
    DisplayOnly,
    /// The share of Gaussians that LightGaussian's score prunes at once, then fine-tuned.
    LightGaussian(f64),
    /// `render-only`, then its colours with the display term.
    TwoStage,
}

impl Baseline {
    /// All of them, in the order in which they are made.
    pub const ALL: [Baseline; 6] = [
        Baseline::DisplayOnly,
        Baseline::RenderOnly,
        Baseline::TwoStage,
        Baseline::LightGaussian(0.66),
        Baseline::LightGaussian(0.76),
        Baseline::LightGaussian(0.86),
    ];

    /// The name in every output.
    pub fn name(self) -> String {
        match self {
            Baseline::RenderOnly => "render-only".into(),
            Baseline::DisplayOnly => "display-only".into(),
            Baseline::LightGaussian(share) => format!("lightgs-{:.0}", share * 100.0),
            Baseline::TwoStage => "two-stage".into(),
        }
    }
}

impl Baseline {
    /// Whether it gets levels for the periphery of sight, as the foveated methods of the
    /// publication: FR-Render and FR-Display.
    pub fn has_levels(self) -> bool {
        matches!(self, Baseline::RenderOnly | Baseline::DisplayOnly)
    }
}

/// For which quality and which level of the eye a model is made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Place {
    /// Position in the variants of the campaign.
    pub variant: u8,
    /// 0 for level 1, the whole picture and the fovea, to 3 for level 4.
    pub level: u8,
}

/// The outcomes at a place, in order.
pub fn at(done: &[Outcome], place: Place) -> Vec<Outcome> {
    done.iter().filter(|o| o.place == place).cloned().collect()
}

/// What a job is for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Role {
    /// The model that the user brought.
    Dense,
    /// The dense model, trained on without the views that gate: what a share of its quality is
    /// measured on, where it may have been trained on them.
    HeldOut,
    /// A sample of the iso-quality curve.
    Sample,
    /// The predicted optimum, made real.
    Final,
    /// A comparison that we train.
    Baseline(Baseline),
    /// Another model of the user, measured only; position in their list.
    External(usize),
    /// A fixed λ without pruning; in units of one over the dense model's display power.
    Sweep(f64),
}

/// What a model was made for, without the particulars: the one spelling of every output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RoleKind {
    /// The model that the user brought.
    Dense,
    /// The dense model, trained on without the views that gate.
    #[serde(alias = "held_out")]
    HeldOut,
    /// A sample of the iso-quality curve.
    Sample,
    /// The predicted optimum, made real.
    Final,
    /// A comparison that was trained.
    Baseline,
    /// Another model of the user.
    External,
    /// A fixed λ without pruning.
    Sweep,
}

impl RoleKind {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            RoleKind::Dense => "dense",
            RoleKind::HeldOut => "held-out",
            RoleKind::Sample => "sample",
            RoleKind::Final => "final",
            RoleKind::Baseline => "baseline",
            RoleKind::External => "external",
            RoleKind::Sweep => "sweep",
        }
    }
}

impl Role {
    /// What the model was made for, without the particulars.
    pub const fn kind(self) -> RoleKind {
        match self {
            Role::Dense => RoleKind::Dense,
            Role::HeldOut => RoleKind::HeldOut,
            Role::Sample => RoleKind::Sample,
            Role::Final => RoleKind::Final,
            Role::Baseline(_) => RoleKind::Baseline,
            Role::External(_) => RoleKind::External,
            Role::Sweep(_) => RoleKind::Sweep,
        }
    }

    /// The kind of models that it belongs to: a baseline, or ours.
    pub fn line(self) -> Option<Baseline> {
        match self {
            Role::Baseline(b) => Some(b),
            Role::Dense
            | Role::HeldOut
            | Role::Sample
            | Role::Final
            | Role::External(_)
            | Role::Sweep(_) => None,
        }
    }
}

/// One model to make or to measure.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Unique in the run; also the name of its files.
    pub name: String,
    /// What it is for.
    pub role: Role,
    /// Where it belongs.
    pub place: Place,
    /// The share of its base that it prunes; of what it is to become.
    pub rho: f64,
    /// Gaussians that `rho` is a share of; `None`: those of the dense model.
    pub base: Option<usize>,
    /// The job whose model it starts from; `None`: the dense (or the user's other) model.
    pub from: Option<String>,
    /// How it is trained; `None`: it is measured only.
    pub orders: Option<Orders>,
}

impl Job {
    /// Whether a later job may start from its model, or a report shows it.
    pub fn is_kept(&self) -> bool {
        match self.role {
            Role::HeldOut | Role::Sample | Role::Final => true,
            Role::Baseline(b) => b.has_levels(),
            Role::Dense | Role::External(_) | Role::Sweep(_) => false,
        }
    }
}

/// What became of a job.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Its name.
    pub name: String,
    /// What it was for.
    pub role: Role,
    /// Where it belongs.
    pub place: Place,
    /// The share of the dense model that is gone, in the periphery of the level before.
    pub rho: f64,
    /// Gaussians left.
    pub points: usize,
    /// Iterations done.
    pub iterations: u32,
    /// The iteration whose model was kept, counted from 0; `None` without training.
    pub kept_at: Option<u32>,
    /// λ of the kept model, 1/W; `None` without a display term.
    pub lambda: Option<f64>,
    /// The last λ that passed, 1/W: where the next sample begins.
    pub passing_lambda: Option<f64>,
    /// Quality and display power over the gate views.
    pub gate: Seen,
    /// Whether the gate was passed.
    pub passed: bool,
    /// Quality and display power over the test views.
    pub test: Seen,
    /// FLIP, mean over the test views, at the viewing distance of its authors. Not a number in the
    /// periphery, which is not looked at.
    pub flip_test: f64,
    /// LPIPS, mean over the test views; `None` without weights.
    pub lpips_test: Option<f64>,
    /// Power over the power views.
    pub watts: Watts,
}

/// What is known of a job when its training has ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ended {
    /// Iterations done.
    pub iterations: u32,
    /// The check of the kept model.
    pub check: Option<Check>,
    /// The last λ that passed.
    pub passing_lambda: Option<f64>,
}

impl Outcome {
    /// The outcome of `job`: `model` measured in every respect. `judge` says what a model of this
    /// quality must reach; without an answer it fails.
    ///
    /// # Errors
    /// [`SimError`]: a machine that cannot run the frame, or a defect of the simulator.
    pub fn measured(
        setup: &Setup<'_>,
        job: &Job,
        model: &Model,
        ended: Option<Ended>,
        judge: impl FnOnce(Quality) -> Option<Target>,
    ) -> Result<Outcome, SimError> {
        let scene = &model.scene;
        let pooling = setup.screen.map(|_| POOLINGS[usize::from(job.place.level)]);
        let gate = setup.see(scene, setup.gate_views(), pooling);
        let test = setup.see(scene, &setup.split.test, pooling);
        let target = judge(gate.quality);
        let base = job.base.unwrap_or(setup.dense.len());
        let is_whole = job.place.level == 0;
        let check = ended.and_then(|e| e.check);
        let has_term = job.orders.is_some_and(|o| o.display != DisplayTerm::Off);
        Ok(Outcome {
            name: job.name.clone(),
            role: job.role,
            place: job.place,
            rho: 1.0 - scene.len() as f64 / base.max(1) as f64,
            points: scene.len(),
            iterations: ended.map_or(0, |e| e.iterations),
            kept_at: check.map(|c| c.iteration),
            lambda: check.filter(|_| has_term).map(|c| c.lambda),
            passing_lambda: ended.and_then(|e| e.passing_lambda),
            gate,
            passed: target.is_some_and(|t| t.passes(gate.quality)),
            test,
            flip_test: if is_whole { setup.flip_test(scene) } else { f64::NAN },
            lpips_test: setup.lpips_test(scene).filter(|_| is_whole),
            watts: setup.watts(scene)?,
        })
    }
}
