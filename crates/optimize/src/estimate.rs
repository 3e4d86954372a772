//! What a campaign will take, before it is begun: its jobs, gone through without training, and
//! times of the dense model.

use super::campaign::{Campaign, CampaignError};
use super::checkpoint::model_bytes;
use super::job::Job;
use super::oracle::OracleWatts;
use super::outcome::Outcome;
use super::prune::Score;
use super::settings::Settings;
use super::setup::{Seen, Setup};
use super::target::{Quality, Target};
use super::times::Times;
use super::tune::{
    DisplayTerm, Gauge, Keep, LOOKS, Model, Objective, Pruning, State, TuneConfig, Tuner,
};
use super::watch::CampaignWatch;

/// Iterations are timed for at least so long, seconds, but for the first, which takes memory.
const TIMED: f64 = 2.0;
/// No more are timed than this.
const MOST_TIMED: u32 = 20;
/// Memory of a fine-tune at most, times the parameters of the dense model: that model, the one in
/// training with its moments, its mean, the best so far, the same with gains and one with more to
/// spare, and what a view needs of every Gaussian.
const TRAINING_COPIES: u64 = 9;
/// The same while a model is measured: the dense one, and the model with its moments; and once more
/// for every thread, which simulates a frame.
const MEASURING_COPIES: u64 = 4;
/// Models that the checkpoint of a fine-tune holds: the model, both moments, the best so far, one
/// with more to spare, and a mean; and while it is replaced, all of this twice.
const CHECKPOINT_COPIES: u64 = 12;
/// Memory of a run of any size, bytes.
const BASE_B: u64 = 64 << 20;
/// Memory of a picture, with its share of loss and gradient, bytes a pixel.
const PIXEL_B: u64 = 48;

/// What a campaign will take.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The models that are made or measured, in order.
    pub jobs: Vec<String>,
    /// Their iterations, if none ends early because its quality has settled.
    pub iterations: u64,
    /// An iteration of the dense model at level 1, without a check of the quality, seconds.
    pub iteration_s: f64,
    /// A look at all gate views, seconds.
    pub check_s: f64,
    /// The scores of the dense model over all training views: what a prune takes, seconds.
    pub score_s: f64,
    /// Everything that is measured of a finished model, seconds.
    pub model_s: f64,
    /// All of the run, if no fine-tune ends early. Pruned models take less time than the dense one,
    /// which only prunes count with.
    pub time: Times,
    /// Memory, bytes, at most.
    pub memory_b: u64,
    /// Files of the run folder, bytes, at most: models and a checkpoint.
    pub disk_b: u64,
    /// The temporary file of reference images, bytes.
    pub references_b: u64,
}

impl Campaign {
    /// What the campaign will take. `clock` tells seconds, and only goes on. `None`: cancelled.
    ///
    /// # Errors
    /// As [`Campaign::run`].
    pub fn estimate(
        &self,
        clock: &dyn Fn() -> f64,
        watch: &dyn CampaignWatch,
    ) -> Result<Option<Estimate>, CampaignError> {
        let setup = self.setup();
        let began = clock();
        let dense = self.dense_outcome(&setup)?;
        let model = clock() - began;
        let began = clock();
        setup.see(&self.dense, setup.gate_views(), setup.screens.map(|_| 1.0));
        let check = clock() - began;
        let score = self.scored(&setup, clock);
        let jobs = self.rehearsed(dense);
        // One level trains on what is looked at, the others on what the eye pools.
        let mut timed: Vec<(Objective, f64)> = Vec::new();
        let (mut iterations, mut time) = (0, Times::default());
        for (job, _) in &jobs {
            time.models_s += model;
            let Some(config) = job.config else { continue };
            let known = timed.iter().find(|(objective, _)| *objective == config.objective);
            let one = match known.map(|(_, one)| *one) {
                Some(one) => one,
                None => match self.timed(&setup, config, job, clock, watch)? {
                    Some(one) => one,
                    None => return Ok(None),
                },
            };
            if known.is_none() {
                timed.push((config.objective, one));
            }
            let checks = config.iterations / self.settings.interval.max(1);
            iterations += u64::from(config.iterations);
            time.iterations_s += one * f64::from(config.iterations);
            time.checks_s += check * Gauge::looks(setup.gate_views().len()) * f64::from(checks);
            if let DisplayTerm::Gains { .. } = config.display {
                time.checks_s += check * LOOKS as f64;
            }
            time.scores_s += score * prunes(config.pruning, checks, self.dense.len());
        }
        let likeness = timed.iter().find(|(objective, _)| *objective == Objective::Likeness);
        let disk = self.disk_b(&jobs);
        Ok(Some(Estimate {
            iterations,
            iteration_s: likeness.map_or(0.0, |(_, one)| *one),
            check_s: check,
            score_s: score,
            model_s: model,
            time,
            memory_b: self.memory_b(),
            disk_b: disk,
            references_b: self.pixels().map(|n| 6 * n).sum(),
            jobs: jobs.into_iter().map(|(job, _)| job.name).collect(),
        }))
    }

    /// Files of the run folder, bytes, at most: the models that are kept, with the moments of the
    /// last two, which take twice as much, and checkpoints.
    fn disk_b(&self, jobs: &[(Job, Outcome)]) -> u64 {
        let bytes = |o: &Outcome| model_bytes(o.points, self.dense.sh_degree);
        let done: Vec<Outcome> = jobs.iter().map(|(_, outcome)| outcome.clone()).collect();
        let trained = jobs.iter().filter(|(job, _)| job.config.is_some());
        let models = match self.keep_all {
            true => trained.map(|(_, o)| 3 * bytes(o)).sum(),
            false => {
                let kept = |n: usize| self.plan.kept(self.dense.len(), &done[..n]);
                let sum = |n: usize| kept(n).into_iter().map(bytes).sum::<u64>();
                let moments = trained.map(|(_, o)| 4 * bytes(o)).max().unwrap_or(0);
                (1..=done.len()).map(sum).max().unwrap_or(0) + moments
            }
        };
        models + CHECKPOINT_COPIES * model_bytes(self.dense.len(), self.dense.sh_degree)
    }

    fn dense_outcome(&self, setup: &Setup<'_>) -> Result<Outcome, CampaignError> {
        let job = self.plan.next(&self.settings, self.dense.len(), &[]);
        let job = job.expect("the first job measures the dense model");
        let judge = |quality| self.plan.judge(&[], job.role, job.place, quality);
        let model = Model::fresh(&self.dense);
        let outcome = Outcome::measured(setup, &job, &model, None, judge);
        let what = || job.name.clone();
        outcome.map_err(|error| CampaignError::Sim { what: what(), error })
    }

    /// The jobs as they follow if every model ends just at its target, with what they would leave.
    fn rehearsed(&self, dense: Outcome) -> Vec<(Job, Outcome)> {
        let points = self.dense.len();
        let (mut jobs, mut done) = (Vec::new(), Vec::new());
        while let Some(job) = self.plan.next(&self.settings, points, &done) {
            let outcome = match done.is_empty() {
                true => dense.clone(),
                false => self.imagined(&job, &dense, &done),
            };
            done.push(outcome.clone());
            jobs.push((job, outcome));
        }
        jobs
    }

    /// What a job leaves that ends at its target: rendering in proportion to the Gaussians, and a
    /// display that takes a little more the more is pruned.
    fn imagined(&self, job: &Job, dense: &Outcome, done: &[Outcome]) -> Outcome {
        let target = self.plan.target_at(done, job.role.baseline(), job.place);
        let hvsq = dense.gate.quality.hvsq.map(|_| 1.0);
        let quality = match target.or_else(|| self.plan.target(done, job.place.variant)) {
            Some(Target::Likeness(q)) => Quality { hvsq, ..q },
            Some(Target::Hvsq(most)) => Quality { hvsq: Some(most), ..dense.gate.quality },
            None => dense.gate.quality,
        };
        let base = job.base.unwrap_or(self.dense.len());
        let points = ((1.0 - job.rho) * base as f64) as usize;
        let left = points as f64 / self.dense.len().max(1) as f64;
        let display_w = dense.watts.display_w * (0.95 - 0.05 * left);
        let render_w = dense.watts.render_w * left;
        let iterations = job.config.map_or(0, |config| config.iterations);
        // Models that are only pruned have none.
        let lambda = job.config.filter(|config| config.display.is_term()).map(|_| 1.0);
        Outcome {
            name: job.name.clone(),
            role: job.role,
            place: job.place,
            rho: job.rho,
            points,
            iterations,
            kept_at: iterations.checked_sub(1),
            lambda,
            passing_lambda: lambda,
            gains: None,
            is_end: job.is_end,
            gate: Seen { quality, display_w },
            passed: true,
            test: Seen { quality, display_w },
            watts: OracleWatts { display_w, render_w, ..dense.watts },
            ..dense.clone()
        }
    }

    /// The time of an iteration of the dense model; `None`: cancelled.
    fn timed(
        &self,
        setup: &Setup<'_>,
        config: TuneConfig,
        job: &Job,
        clock: &dyn Fn() -> f64,
        watch: &dyn CampaignWatch,
    ) -> Result<Option<f64>, CampaignError> {
        // Out of reach, so that no check passes and nothing settles.
        let target = Target::Likeness(Quality::likeness(f64::INFINITY, f64::INFINITY));
        // Checks are timed apart; without pruning they are due in the first iteration only.
        let settings = Settings { interval: u32::MAX, ..self.settings.clone() };
        let setup = Setup { settings: &settings, ..*setup };
        let config = TuneConfig {
            iterations: u32::MAX,
            pruning: Pruning::Never,
            display: DisplayTerm::Fixed(f64::MIN_POSITIVE),
            keep: Keep::Last,
            ..config
        };
        let state = State::begin(Model::fresh(&self.dense));
        let mut tuner = Tuner::new(&setup, config, target, 0, state);
        let failed = |error| CampaignError::Tune { job: job.name.clone(), error };
        tuner.step().map_err(failed)?;
        let (began, mut n) = (clock(), 0u32);
        while n == 0 || (n < MOST_TIMED && clock() - began < TIMED) {
            if watch.is_cancelled() {
                return Ok(None);
            }
            tuner.step().map_err(failed)?;
            n += 1;
        }
        Ok(Some((clock() - began) / f64::from(n)))
    }

    /// The time of the scores of the dense model over all training views, from a few of them.
    fn scored(&self, setup: &Setup<'_>, clock: &dyn Fn() -> f64) -> f64 {
        let views = setup.train_cameras();
        let few = &views[..views.len().min(2 * rayon::current_num_threads())];
        let began = clock();
        setup.renderer.score(Score::Dominance, &self.dense, few);
        (clock() - began) * views.len() as f64 / few.len() as f64
    }

    /// Memory of the run, bytes, at most: for every thread a view and its reference.
    fn memory_b(&self) -> u64 {
        let threads = rayon::current_num_threads() as u64;
        let power = self.power_views.iter().map(|c| u64::from(c.width) * u64::from(c.height));
        let largest = self.pixels().chain(power).max().unwrap_or(0);
        let copies = TRAINING_COPIES.max(MEASURING_COPIES + threads);
        copies * model_bytes(self.dense.len(), self.dense.sh_degree)
            + BASE_B
            + 2 * threads * largest * PIXEL_B
    }

    /// Pixels of each view.
    fn pixels(&self) -> impl Iterator<Item = u64> {
        self.cameras.iter().map(|c| u64::from(c.width) * u64::from(c.height))
    }
}

/// How often the dense model of so many Gaussians could be scored in the time of the scores of a
/// fine-tune: all prunes that it may have, each of what is left.
fn prunes(pruning: Pruning, checks: u32, points: usize) -> f64 {
    match pruning {
        Pruning::Never => 0.0,
        Pruning::Steps { steps, .. } => f64::from(steps.get()),
        Pruning::WhilePassing { most, share, .. } => {
            let most = most as f64 / points.max(1) as f64;
            let (mut left, mut sum) = (1.0, 0.0);
            for _ in 0..checks {
                sum += left;
                left = f64::max(left - f64::min(share * left, most), 0.0);
            }
            sum
        }
    }
}
