//! Makes the models of a space: pruned, with fewer coefficients, fine-tuned with the record that a
//! machine reads, and dimmed until the quality sits just above the target.

use std::num::NonZeroU32;

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::{xxh3_64, xxh3_128};

use powergs_core::run::identity::content_id;
use powergs_core::run::{RunError, Store};
use powergs_optimize::campaign::Campaign;
use powergs_optimize::checkpoint::Checkpoints;
use powergs_optimize::lambda::Control;
use powergs_optimize::prune::Score;
use powergs_optimize::setup::{Seen, Setup};
use powergs_optimize::target::Target;
use powergs_optimize::tune::{
    DisplayTerm, Keep, Model, Objective, Pace, Pruning, State, Trains, TuneConfig, Tuner,
};
use powergs_scene::Gaussians;

use super::error::CodesignError;
use super::model::ModelPoint;
use super::part::CodesignPart;
use super::watch::CodesignWatch;

/// Raised when models are made in another way, or what is kept of them changes.
const VERSION: u32 = 2;
/// The share of all Gaussians that goes in one step, as in a search of the ratio alone.
const STEP: f64 = 0.05;
/// The share of a fine-tune in which it prunes, and then the share in which it recovers, both with
/// the display term off.
const PRUNING: f64 = 0.25;
/// See [`PRUNING`].
const RECOVERY: f64 = 0.25;
/// What is kept of a model beside its parameters.
const FACTS: &str = "facts";
/// The job that checkpoints call the fine-tune.
const JOB: &str = "model";

/// What is known of a model when it is made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelFacts {
    /// Gaussians.
    pub points: usize,
    /// Iterations of its fine-tune; 0 for the dense model.
    pub iterations: u32,
    /// λ of the kept model, 1/W; `None` where no check passed with a display term.
    pub lambda: Option<f64>,
    /// Quality and display power over the gate views, as it is read.
    pub gate: Seen,
    /// The same over the test views.
    pub test: Seen,
    /// Whether it reaches the target over the gate views.
    pub passed: bool,
    /// Distance from the target over the gate views, dB; negative where it misses.
    pub margin_db: f64,
}

/// A model that is made.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// Which one.
    pub point: ModelPoint,
    /// Hash of everything that its parameters depend on.
    pub id: u128,
    /// What is known of it.
    pub facts: ModelFacts,
}

/// Makes models of a campaign and keeps them in a store.
pub struct Fitter<'a> {
    campaign: &'a Campaign,
    setup: Setup<'a>,
    store: &'a dyn Store,
    target: Target,
    /// One over the display power of the dense model, 1/W: the unit of λ.
    unit: f64,
    dense: Seen,
}

impl<'a> Fitter<'a> {
    /// The models of a campaign with its first quality, in the folder `models` of a store.
    pub fn new(campaign: &'a Campaign, store: &'a dyn Store) -> Fitter<'a> {
        let setup = campaign.setup();
        let dense = setup.see(&campaign.dense, setup.gate_views(), None);
        let target = campaign.plan.variants[0].rule.target(dense.quality);
        let unit = if dense.display_w > 0.0 { dense.display_w.recip() } else { 1.0 };
        Fitter { campaign, setup, store, target, unit, dense }
    }

    /// What models must reach.
    pub fn target(&self) -> Target {
        self.target
    }

    /// Hash of everything that a model depends on.
    fn id(&self, point: &ModelPoint, iterations: u32) -> u128 {
        let display = content_id(self.setup.display).expect("numbers and text");
        let parts = (VERSION, self.campaign.inputs(), display, point, iterations);
        xxh3_128(&postcard::to_stdvec(&parts).expect("numbers and text"))
    }

    /// Makes a model, or finds it in the store. `None`: it was cancelled, and goes on from there.
    ///
    /// # Errors
    /// [`CodesignError::Tune`]: numbers that are not finite; a store that fails.
    pub fn fit(
        &self,
        point: &ModelPoint,
        iterations: u32,
        watch: &dyn CodesignWatch,
    ) -> Result<Option<Fitted>, CodesignError> {
        let id = self.id(point, iterations);
        let fitted = |facts| Some(Fitted { point: point.clone(), id, facts });
        if point.is_dense {
            return Ok(fitted(self.facts(&self.campaign.dense, 0, None)));
        }
        let part = self.part(id);
        if let Some(facts) = read_facts(&part)? {
            watch.advanced(u64::from(iterations));
            return Ok(fitted(facts));
        }
        let checkpoints = Checkpoints::new(&part, id);
        let Some(tuned) = self.tune(point, iterations, &checkpoints, watch)? else {
            return Ok(None);
        };
        let (scene, done, lambda) = tuned;
        let facts = self.facts(&scene, done, lambda);
        // Facts are written last: where they are found the parameters are whole.
        checkpoints.save_scene(JOB, &scene)?;
        let bytes = postcard::to_stdvec(&facts).map_err(|e| RunError::Internal(e.to_string()))?;
        part.write(FACTS, &bytes)?;
        // The moments are not needed any more.
        checkpoints.save(&[], &[], None)?;
        Ok(fitted(facts))
    }

    /// The parameters of a model as a machine reads them.
    ///
    /// # Errors
    /// [`RunError::Input`]: the store does not have it, or it is damaged.
    pub fn scene(&self, model: &Fitted) -> Result<Gaussians, RunError> {
        if model.point.is_dense {
            return Ok(self.campaign.dense.clone());
        }
        let part = self.part(model.id);
        Ok(Checkpoints::new(&part, model.id).load_model(JOB)?.scene)
    }

    fn part(&self, id: u128) -> CodesignPart<'_> {
        CodesignPart::new(self.store, format!("models/{:016x}", id as u64))
    }

    fn facts(&self, read: &Gaussians, iterations: u32, lambda: Option<f64>) -> ModelFacts {
        let gate = self.setup.see(read, self.setup.gate_views(), None);
        let test = self.setup.see(read, &self.setup.split.test, None);
        ModelFacts {
            points: read.len(),
            iterations,
            lambda,
            gate,
            test,
            passed: self.target.passes(gate.quality),
            margin_db: self.target.margin_db(gate.quality),
        }
    }

    /// Trains; the parameters as they are read, iterations, and λ of the kept model.
    fn tune(
        &self,
        point: &ModelPoint,
        iterations: u32,
        checkpoints: &Checkpoints<'_>,
        watch: &dyn CodesignWatch,
    ) -> Result<Option<(Gaussians, u32, Option<f64>)>, CodesignError> {
        let config = self.config(point, iterations);
        let begin = || State::begin(Model::fresh(&point.start(&self.campaign.dense)));
        let current = checkpoints.load()?.and_then(|progress| progress.current);
        let state = current.map_or_else(begin, |(_, state)| state);
        watch.advanced(u64::from(state.iteration));
        let stream = xxh3_64(point.name().as_bytes());
        let tuner = Tuner::new(&self.setup, config, self.target, stream, state);
        let mut tuner = tuner.reading(point.formats);
        let every = self.campaign.settings.checkpoint_every;
        while !tuner.is_done() {
            let is_cancelled = watch.is_cancelled();
            let done = tuner.state().iteration;
            if is_cancelled || (done > 0 && done.is_multiple_of(every)) {
                checkpoints.save(&[], &[], Some((JOB, tuner.state())))?;
            }
            if is_cancelled {
                return Ok(None);
            }
            let failed = |error| CodesignError::Tune { model: point.name(), error };
            let iteration = tuner.step().map_err(failed)?;
            self.campaign.references.images().check()?;
            watch.iteration(point, &iteration);
            // Iterations of an extension were not announced.
            watch.advanced(u64::from(iteration.iteration < iterations));
        }
        let done = tuner.state().iteration;
        // It may have settled early.
        watch.advanced(u64::from(iterations.saturating_sub(done)));
        let (model, check, _) = tuner.finish();
        Ok(Some((model.scene, done, check.map(|check| check.lambda))))
    }

    /// Pruned step by step and recovered without the display term, then dimmed until all the slack
    /// is spent.
    fn config(&self, point: &ModelPoint, iterations: u32) -> TuneConfig {
        let settings = &self.campaign.settings;
        let points = self.campaign.dense.len();
        let goal = points - ((points as f64 * point.rho) as usize).min(points.saturating_sub(1));
        let share = |of: f64| ((f64::from(iterations) * of).round() as u32).max(1);
        let steps = ((point.rho / STEP).ceil() as u32).max(1);
        let every = (share(PRUNING) / steps).min(2 * settings.interval);
        let is_pruned = goal < points;
        let until_recovered = (every * steps + share(RECOVERY)).min(iterations.saturating_sub(1));
        // What is read may be far from what was trained: it recovers first, too.
        let has_changed = !point.formats.is_exact() || point.sh_degree < self.setup.dense.sh_degree;
        let from = match (is_pruned, has_changed) {
            (true, _) => until_recovered,
            (false, true) => share(RECOVERY).min(iterations.saturating_sub(1)),
            (false, false) => 0,
        };
        let pruning = match NonZeroU32::new(steps).filter(|_| is_pruned) {
            Some(steps) => Pruning::Steps { score: Score::Dominance, goal, steps, every },
            None => Pruning::Never,
        };
        let control = Control {
            rule: settings.dimming.rule(),
            start: settings.display_weight * self.unit,
            is_estimated: true,
            interval: settings.interval,
            adjust: ((f64::from(iterations - from) * settings.adjust_share).round() as u32).max(1),
            epsilon_db: settings.epsilon_db,
        };
        TuneConfig {
            iterations,
            pruning,
            display: DisplayTerm::Controlled { from, control },
            objective: Objective::Likeness,
            trains: Trains::All,
            keep: Keep::Dimmest,
            pace: Pace::RECOVERING,
        }
    }

    /// Quality and display power of the dense model over the gate views.
    pub fn dense(&self) -> Seen {
        self.dense
    }
}

fn read_facts(part: &CodesignPart<'_>) -> Result<Option<ModelFacts>, RunError> {
    let Some(bytes) = part.read(FACTS)? else { return Ok(None) };
    let damaged = |_| RunError::Input {
        place: part.place(FACTS),
        message: "is damaged; remove its folder, and the model is made again".into(),
    };
    postcard::from_bytes(&bytes).map(Some).map_err(damaged)
}
