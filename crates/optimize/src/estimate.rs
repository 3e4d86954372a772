//! What a campaign will take, before it is begun: its jobs, gone through without training, and
//! times of the dense model.

use super::campaign::{Campaign, CampaignError};
use super::checkpoint::model_bytes;
use super::job::Job;
use super::oracle::Watts;
use super::outcome::Outcome;
use super::settings::Settings;
use super::setup::{Seen, Setup};
use super::target::{Quality, Target};
use super::tune::{DisplayTerm, Keep, Model, Objective, Pruning, State, TuneConfig, Tuner};
use super::watch::CampaignWatch;

/// Iterations are timed for at least so long, seconds, but for the first, which takes memory.
const TIMED: f64 = 2.0;
/// No more are timed than this.
const MOST_TIMED: u32 = 20;
/// Memory that a run takes at most, times the parameters of the dense model: the model, its
/// gradient and moments, the best so far with its own, and what a view needs of every Gaussian.
const COPIES: u64 = 10;
/// Models that the checkpoint of a fine-tune holds: the model, both moments, the same of the best
/// so far, and a mean; and while it is replaced, all of this twice.
const CHECKPOINT_COPIES: u64 = 14;
/// Memory of a run of any size, bytes.
const BASE_B: u64 = 64 << 20;
/// Memory of a picture in training, with its loss and gradient, bytes a pixel.
const PIXEL_B: u64 = 64;

/// What a campaign will take.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The models that are made or measured, in order.
    pub jobs: Vec<String>,
    /// Their iterations, if none ends early because its quality has settled.
    pub iterations: u64,
    /// An iteration of the dense model at level 1, without a check of the quality, seconds.
    pub iteration_s: f64,
    /// A check of the quality over all gate views, seconds.
    pub check_s: f64,
    /// Everything that is measured of a finished model, seconds.
    pub model_s: f64,
    /// All of the run, seconds, if no fine-tune ends early. Pruned models take less time than the
    /// dense one.
    pub time_s: f64,
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
        setup.see(&self.dense, setup.gate_views(), setup.screen.map(|_| 1.0));
        let check = clock() - began;
        let jobs = self.rehearsed(dense);
        // One level trains on what is looked at, the others on what the eye pools.
        let mut timed: Vec<(Objective, f64)> = Vec::new();
        let (mut iterations, mut time) = (0, 0.0);
        for (job, _) in &jobs {
            time += model;
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
            time += one * f64::from(config.iterations) + check * f64::from(checks);
        }
        let likeness = timed.iter().find(|(objective, _)| *objective == Objective::Likeness);
        let degree = self.dense.sh_degree;
        let kept: Vec<u64> = jobs
            .iter()
            .filter(|(job, _)| job.is_kept() || self.keep_all)
            .map(|(_, outcome)| model_bytes(outcome.points, degree))
            .collect();
        // Moments take twice as much as the model: all are kept, or those of the last two.
        let moments =
            if self.keep_all { kept.iter().sum() } else { kept.iter().max().map_or(0, |m| 2 * m) };
        let kept = kept.iter().sum::<u64>() + 2 * moments;
        Ok(Some(Estimate {
            iterations,
            iteration_s: likeness.map_or(0.0, |(_, one)| *one),
            check_s: check,
            model_s: model,
            time_s: time,
            memory_b: self.memory_b(),
            disk_b: kept + CHECKPOINT_COPIES * model_bytes(self.dense.len(), degree),
            references_b: self.pixels().map(|n| 6 * n).sum(),
            jobs: jobs.into_iter().map(|(job, _)| job.name).collect(),
        }))
    }

    fn dense_outcome(&self, setup: &Setup<'_>) -> Result<Outcome, CampaignError> {
        let job = self.plan.next(&self.settings, self.dense.len(), &[]);
        let job = job.expect("the first job measures the dense model");
        let judge = |quality| self.plan.judge(&[], &job, quality);
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
        let lambda = job.config.filter(|c| c.display != DisplayTerm::Off).map(|_| 1.0);
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
            gate: Seen { quality, display_w },
            passed: true,
            test: Seen { quality, display_w },
            watts: Watts { display_w, render_w, ..dense.watts },
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

    /// Memory of the run, bytes, at most: for every thread a view and its reference.
    fn memory_b(&self) -> u64 {
        let threads = rayon::current_num_threads() as u64;
        let largest = self.pixels().max().unwrap_or(0);
        COPIES * model_bytes(self.dense.len(), self.dense.sh_degree)
            + BASE_B
            + 2 * threads * largest * PIXEL_B
    }

    /// Pixels of each view.
    fn pixels(&self) -> impl Iterator<Item = u64> {
        self.cameras.iter().map(|c| u64::from(c.width) * u64::from(c.height))
    }
}
