//! The result of a job.

use serde::{Deserialize, Serialize};

use super::job::{Job, Place};
use super::oracle::OracleWatts;
use super::pooled::Pooled;
use super::role::Role;
use super::setup::{Seen, Setup};
use super::target::{Quality, Target};
use super::tune::{Check, Gains, Model, Spent, confirms};
use powergs_core::sim::SimError;
use powergs_frame::fovea::POOLINGS;
use powergs_scene::Gaussians;

/// The result of a job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Its name.
    pub name: String,
    /// What it was for.
    pub role: Role,
    /// Where it belongs.
    pub place: Place,
    /// Share of the Gaussians that were pruned: of the dense model, or beyond level 1 of the model
    /// of the level before.
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
    /// What the colours of its model were scaled by, to spend what it had above the target on the
    /// display; `None` where they were not.
    pub gains: Option<Gains>,
    /// Whether it is the end of a curve: pruned without a display term for as long as the target
    /// was reached.
    pub is_end: bool,
    /// Quality and display power over all gate views.
    pub gate: Seen,
    /// What the gate views say that did not choose; `None` where all of them do.
    pub confirmation: Option<Confirmation>,
    /// Standard errors of the mean PSNR over the gate and the test views, as samples of all views
    /// that there could be, dB; `None` with a single view, or an infinite PSNR.
    pub error_db: [Option<f64>; 2],
    /// Whether the gate was passed.
    pub passed: bool,
    /// Quality and display power over the test views.
    pub test: Seen,
    /// FLIP, mean over the test views, at the viewing distance of its authors; NaN beyond level 1,
    /// because nobody looks straight at the periphery.
    pub flip_test: f64,
    /// LPIPS, mean over the test views; `None` without weights.
    pub lpips_test: Option<f64>,
    /// Power over the power views.
    pub watts: OracleWatts,
}

/// What the gate views say of a model that did not choose it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Confirmation {
    /// Quality and display power over them.
    pub seen: Seen,
    /// How much more above the target the model was when it was chosen than all gate views found,
    /// decibels; `None` where it was not trained, or has no target.
    pub luck_db: Option<f64>,
}

/// What is known of a job when its training is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Training {
    /// Iterations done.
    pub iterations: u32,
    /// The check of the kept model.
    pub check: Option<Check>,
    /// The last λ that passed.
    pub passing_lambda: Option<f64>,
    /// What the kept model has spent on the display by gains.
    pub spent: Option<Spent>,
}

/// What views say of a model.
struct OutcomeSeen {
    gate: Seen,
    test: Seen,
    /// The gate views that did not choose it; `None` where all of them do.
    others: Option<Seen>,
    error_db: [Option<f64>; 2],
    flip_test: f64,
    lpips_test: Option<f64>,
}

impl OutcomeSeen {
    /// Of a model that was made for a place.
    fn of(setup: &Setup<'_>, scene: &Gaussians, place: Place) -> OutcomeSeen {
        let pooling = setup.screens.map(|_| POOLINGS[usize::from(place.level)]);
        let mut pooled = pooling.map(Pooled::new);
        let each_gate = setup.see_each(scene, setup.gate_views(), pooled.as_mut());
        let each_test = setup.see_each(scene, &setup.split.test, pooled.as_mut());
        let others = (0..).zip(&each_gate).filter(|(i, _)| confirms(*i));
        let others: Vec<Seen> = others.map(|(_, seen)| *seen).collect();
        let is_whole = place.level == 0;
        OutcomeSeen {
            gate: Seen::mean(&each_gate),
            test: Seen::mean(&each_test),
            others: (!others.is_empty()).then(|| Seen::mean(&others)),
            error_db: [standard_error_db(&each_gate), standard_error_db(&each_test)],
            flip_test: if is_whole { setup.flip_test(scene) } else { f64::NAN },
            lpips_test: setup.lpips_test(scene).filter(|_| is_whole),
        }
    }
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
        training: Option<Training>,
        judge: impl FnOnce(Quality) -> Option<Target>,
    ) -> Result<Outcome, SimError> {
        let scene = &model.scene;
        let seen = OutcomeSeen::of(setup, scene, job.place);
        let gate = seen.gate;
        let target = judge(gate.quality);
        let base = job.base.unwrap_or(setup.dense.len());
        let check = training.and_then(|e| e.check);
        let spent = training.and_then(|e| e.spent);
        let luck = |target: Target, promised: Quality| {
            let luck = target.margin_db(promised) - target.margin_db(gate.quality);
            luck.is_finite().then_some(luck)
        };
        let confirmation = seen.others.map(|others| Confirmation {
            seen: others,
            // Where all gate views say how far it is dimmed, what was promised before that counts.
            luck_db: spent
                .map(|spent| spent.luck_db)
                .or_else(|| target.zip(check).and_then(|(target, c)| luck(target, c.seen.quality))),
        });
        let has_term = job.config.is_some_and(|config| config.display.is_term());
        Ok(Outcome {
            name: job.name.clone(),
            role: job.role,
            place: job.place,
            rho: 1.0 - scene.len() as f64 / base.max(1) as f64,
            points: scene.len(),
            iterations: training.map_or(0, |e| e.iterations),
            kept_at: check.map(|c| c.iteration),
            lambda: check.filter(|_| has_term).map(|c| c.lambda),
            passing_lambda: training.and_then(|e| e.passing_lambda),
            gains: spent.map(|spent| spent.gains),
            is_end: job.is_end,
            gate,
            confirmation,
            error_db: seen.error_db,
            passed: target.is_some_and(|t| t.passes(gate.quality)),
            test: seen.test,
            flip_test: seen.flip_test,
            lpips_test: seen.lpips_test,
            watts: setup.watts(scene)?,
        })
    }

    /// The same model, `scene`, as views of another size judge it. What it promised when it was
    /// chosen was of those before.
    pub(crate) fn judged_anew(
        self,
        setup: &Setup<'_>,
        scene: &Gaussians,
        judge: impl FnOnce(Quality) -> Option<Target>,
    ) -> Outcome {
        let seen = OutcomeSeen::of(setup, scene, self.place);
        let gate = seen.gate;
        Outcome {
            gate,
            confirmation: seen.others.map(|seen| Confirmation { seen, luck_db: None }),
            error_db: seen.error_db,
            passed: judge(gate.quality).is_some_and(|t| t.passes(gate.quality)),
            test: seen.test,
            flip_test: seen.flip_test,
            lpips_test: seen.lpips_test,
            ..self
        }
    }
}

/// The standard error of a mean PSNR.
fn standard_error_db(seen: &[Seen]) -> Option<f64> {
    let n = seen.len() as f64;
    let psnr = || seen.iter().map(|s| s.quality.psnr_db);
    let mean = psnr().sum::<f64>() / n;
    let spread = psnr().map(|db| (db - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let error = (spread / n).sqrt();
    error.is_finite().then_some(error)
}

/// The outcomes at a place, in order.
pub fn at(done: &[Outcome], place: Place) -> Vec<Outcome> {
    done.iter().filter(|o| o.place == place).cloned().collect()
}
