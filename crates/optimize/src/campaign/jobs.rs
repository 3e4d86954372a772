//! The loop over the jobs of a plan.

use std::collections::BTreeSet;

use super::{CampaignError, Run};
use crate::history::HistoryRow;
use crate::job::Job;
use crate::outcome::{Outcome, Training};
use crate::role::Role;
use crate::target::{Quality, Target};
use crate::times::Times;
use crate::tune::{Model, State, TuneConfig, Tuner};
use crate::watch::CampaignWatch;

/// A target this far above the dense model is not tried, decibels.
const OUT_OF_REACH_DB: f64 = 1.0;
/// The same in SSIM.
const OUT_OF_REACH_SSIM: f64 = 0.02;
/// No job trains before the dense model is measured; this target is reached by nothing.
const UNREACHED: Target = Target::Likeness(Quality::likeness(f64::INFINITY, f64::INFINITY));

/// How the jobs ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Stop {
    /// All are done.
    Done,
    /// Cancelled; a checkpoint is written.
    Cancelled,
    /// The dense model itself is far below the target: by how much.
    OutOfReach(String),
}

/// What a fine-tune left.
struct Tuned {
    model: Model,
    /// `None`: it was measured only.
    training: Option<Training>,
}

impl Run<'_> {
    /// Does the jobs that are left, and tells where the time went.
    pub(super) fn jobs(&mut self, watch: &dyn CampaignWatch) -> Result<Stop, CampaignError> {
        let mut times = Times::default();
        let stop = self.all_jobs(watch, &mut times)?;
        watch.took(&times);
        Ok(stop)
    }

    fn all_jobs(
        &mut self,
        watch: &dyn CampaignWatch,
        times: &mut Times,
    ) -> Result<Stop, CampaignError> {
        let campaign = self.campaign;
        let setup = campaign.setup();
        let points = campaign.dense.len();
        watch.planned(campaign.plan.most_iterations(&campaign.settings));
        self.tell_known(watch);
        // A run that was killed may have left more.
        self.clear()?;
        while let Some(job) =
            campaign.plan.next(&campaign.settings, points, &self.progress.outcomes)
        {
            if let Some(why) = self.out_of_reach() {
                return Ok(Stop::OutOfReach(why));
            }
            if watch.is_cancelled() {
                let current = self.progress.current.as_ref();
                self.save(current.map(|(name, state)| (name.as_str(), state)))?;
                return Ok(Stop::Cancelled);
            }
            let done = match job.config {
                Some(config) => self.tune(&job, config, watch, times)?,
                None => Some(Tuned { model: self.untuned(&job), training: None }),
            };
            let Some(Tuned { model, training }) = done else { return Ok(Stop::Cancelled) };
            let judge = |quality| {
                campaign.plan.judge(&self.progress.outcomes, job.role, job.place, quality)
            };
            let began = watch.seconds();
            let outcome = Outcome::measured(&setup, &job, &model, training, judge);
            times.models_s += watch.seconds() - began;
            let what = || format!("job {}", job.name);
            let outcome = outcome.map_err(|error| CampaignError::Sim { what: what(), error })?;
            campaign.references.images().check()?;
            watch.outcome(&outcome);
            if outcome.role == Role::Dense && !outcome.passed {
                watch.note("the dense model itself misses the target; training may reach it");
            }
            self.progress.outcomes.push(outcome);
            let outcomes = &self.progress.outcomes;
            let kept = campaign.plan.kept(points, outcomes);
            if campaign.keep_all || kept.iter().any(|o| o.name == job.name) {
                self.checkpoints.save_model(&job.name, &model)?;
            }
            // Before `clear`, which may load another one: two take much memory.
            drop(model);
            self.save(None)?;
            // After the checkpoint: if it is stopped in between, the old one finds all its models.
            self.clear()?;
        }
        self.forget(1)?;
        Ok(Stop::Done)
    }

    /// Leaves the models that are kept, and moments of the last alone.
    fn clear(&self) -> Result<(), CampaignError> {
        let campaign = self.campaign;
        if campaign.keep_all {
            return Ok(());
        }
        let outcomes = &self.progress.outcomes;
        let kept = campaign.plan.kept(campaign.dense.len(), outcomes);
        for outcome in outcomes {
            if !kept.iter().any(|o| o.name == outcome.name) {
                self.checkpoints.remove_model(&outcome.name)?;
            }
        }
        self.forget(2)
    }

    /// Moments are for the job that follows: those of the job so many before the end are not
    /// needed any more.
    fn forget(&self, back: usize) -> Result<(), CampaignError> {
        let outcomes = &self.progress.outcomes;
        let done = outcomes.len().checked_sub(back).map(|i| &outcomes[i]);
        if let Some(outcome) = done.filter(|_| !self.campaign.keep_all) {
            self.checkpoints.forget_moments(&outcome.name)?;
        }
        Ok(())
    }

    fn save(&self, current: Option<(&str, &State)>) -> Result<(), CampaignError> {
        let (outcomes, history) = (&self.progress.outcomes, &self.progress.history);
        Ok(self.checkpoints.save(outcomes, history, current)?)
    }

    /// Tells of everything that was done before.
    fn tell_known(&self, watch: &dyn CampaignWatch) {
        let progress = &self.progress;
        // Models that were priced anew are not of this run.
        let trained: BTreeSet<usize> = progress.history.iter().map(|row| row.job).collect();
        let known = progress.outcomes.iter().enumerate().filter(|(job, _)| trained.contains(job));
        watch.advanced(known.map(|(_, o)| u64::from(o.iterations)).sum());
        let current = progress.current.as_ref().map_or("", |(name, _)| name);
        for row in &progress.history {
            let job = progress.outcomes.get(row.job).map_or(current, |o| &o.name);
            watch.iteration(job, &row.iteration);
        }
    }

    /// Why there is no use in going on: the target is far above what the dense model reaches.
    fn out_of_reach(&self) -> Option<String> {
        let outcomes = &self.progress.outcomes;
        let target = self.campaign.plan.target(outcomes, 0)?;
        let dense = outcomes.first()?;
        let short = target.shortfall(dense.gate.quality);
        let is_far = short.psnr_db > OUT_OF_REACH_DB || short.ssim > OUT_OF_REACH_SSIM;
        is_far.then(|| {
            let Quality { psnr_db, ssim, .. } = dense.gate.quality;
            format!(
                "the target is out of reach: over the gate views the dense model itself has \
                 {psnr_db:.2} dB and an SSIM of {ssim:.4}, {:.2} dB and {:.4} too little; lower \
                 the target",
                short.psnr_db, short.ssim
            )
        })
    }

    fn untuned(&self, job: &Job) -> Model {
        Model::fresh(match job.role {
            Role::External(position) => &self.campaign.externals[position].1,
            Role::Dense
            | Role::HeldOut
            | Role::Sample
            | Role::Optimum
            | Role::Baseline(_)
            | Role::Sweep(_) => &self.campaign.dense,
        })
    }

    /// Trains; `None` if it was cancelled.
    fn tune(
        &mut self,
        job: &Job,
        config: TuneConfig,
        watch: &dyn CampaignWatch,
        times: &mut Times,
    ) -> Result<Option<Tuned>, CampaignError> {
        let campaign = self.campaign;
        let setup = campaign.setup();
        let target =
            campaign.plan.target_at(&self.progress.outcomes, job.role.baseline(), job.place);
        let state = self.state(job)?;
        watch.advanced(u64::from(state.iteration.min(config.iterations)));
        let position = self.progress.outcomes.len();
        let target = target.unwrap_or(UNREACHED);
        let clock = || watch.seconds();
        let mut tuner = Tuner::new(&setup, config, target, job.stream, state).timed(&clock);
        while !tuner.is_done() {
            let iteration = tuner
                .step()
                .map_err(|error| CampaignError::Tune { job: job.name.clone(), error })?;
            campaign.references.images().check()?;
            self.progress.history.push(HistoryRow { job: position, iteration });
            watch.iteration(&job.name, &iteration);
            // Beyond them it goes on where views that did not choose said no.
            watch.advanced(u64::from(iteration.iteration < config.iterations));
            let is_cancelled = watch.is_cancelled();
            let every = campaign.settings.checkpoint_every;
            if is_cancelled || (iteration.iteration + 1).is_multiple_of(every) {
                self.save(Some((&job.name, tuner.state())))?;
            }
            if is_cancelled {
                times.add(tuner.times());
                return Ok(None);
            }
        }
        times.add(tuner.times());
        let iterations = tuner.state().iteration;
        watch.advanced(u64::from(config.iterations.saturating_sub(iterations)));
        let spent = tuner.spent();
        let (model, check, passing_lambda) = tuner.finish();
        let training = Training { iterations, check, passing_lambda, spent };
        Ok(Some(Tuned { model, training: Some(training) }))
    }

    /// Where the job in flight is, or its beginning.
    fn state(&mut self, job: &Job) -> Result<State, CampaignError> {
        if let Some((name, state)) = self.progress.current.take()
            && name == job.name
        {
            return Ok(state);
        }
        let Some(from) = &job.from else {
            return Ok(State::begin(Model::fresh(&self.campaign.dense)));
        };
        let mut model = self.checkpoints.load_model(from)?;
        // It trains as it was before it was dimmed; a level of the periphery, as far as it trains.
        let before = self.progress.outcomes.iter().find(|o| o.name == *from);
        if let (Some(gains), Some(config)) = (before.and_then(|o| o.gains), job.config) {
            gains.undo(&mut model.scene, config.trains);
        }
        // Moments of another loss would hold the first hundreds of steps back, and those of models
        // before the last are gone. The held-out model begins all qualities alike.
        let is_next =
            self.progress.outcomes.last().is_some_and(|o| {
                o.name == *from && o.place == job.place && o.role != Role::HeldOut
            });
        Ok(State::begin(if is_next { model } else { Model::fresh(&model.scene) }))
    }
}
