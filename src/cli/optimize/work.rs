//! The run: job after job, each stoppable after any iteration.

use std::path::Path;

use super::super::invocation::Started;
use super::super::progress::Progress as Bar;
use super::super::{Context, Exit, Failure, OrExit, out};
use super::folder::Folder;
use super::inputs::Inputs;
use super::{Args, StudyArg, finish, settings};
use powergs_optimize::checkpoint::Progress;
use powergs_optimize::plan::{Campaign, Ended, Job, Outcome, Role};
use powergs_optimize::setup::{Settings, Setup};
use powergs_optimize::target::{Quality, Target};
use powergs_optimize::tune::{Model, Orders, State, Tuner};
use powergs_report::format::{engineering, shortened, wrapped};

/// A target this far above the dense model is not tried, decibels.
const HOPELESS_DB: f64 = 1.0;
/// The same in SSIM.
const HOPELESS_SSIM: f64 = 0.02;

/// How the jobs ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stop {
    /// All are done.
    Done,
    /// Ctrl-C; a checkpoint is written.
    Interrupted,
    /// The target is out of reach of the dense model itself.
    Hopeless,
}

/// Runs `optimize`.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let started = Started::now();
    let settings = settings::settings(args)?;
    if args.demo && !context.global.quiet {
        out::complain(wrapped(super::demo::NOTE, 80));
    }
    // What is wrong with the arguments is said before anything is loaded.
    settings::campaign(args, args.views.images.is_none(), 1)?;
    let inputs = Inputs::load(args, context)?;
    let campaign = settings::campaign(args, inputs.is_self, inputs.levels())?;
    let record = super::record::run_toml(args, &inputs, &settings, &campaign)?;
    let fingerprint = inputs.fingerprint(&record);
    let path = args.out.clone().unwrap_or_else(|| Path::new("runs").join(&inputs.name));
    let (mut folder, mut progress) = Folder::open(&path, fingerprint, args.resume)?;
    folder.write("run.toml", record.as_bytes())?;
    if !args.resume {
        // Killed before its first checkpoint, a run can be resumed all the same.
        folder.save(&[], None)?;
    }
    let setup = setup(&inputs, &settings, args);
    let every = args.search.checkpoint_every;
    let work = Work { setup: &setup, campaign: &campaign, inputs: &inputs, every, context };
    let stop = work.jobs(&mut folder, &mut progress)?;
    folder.write("invocation.toml", started.invocation_toml().as_bytes())?;
    let stopped = match stop {
        Stop::Done => None,
        Stop::Interrupted => {
            if !context.global.quiet {
                let again = "the same command with --resume goes on";
                out::complain(format!("interrupted, {}: {again}", path.display()));
            }
            return Ok(Exit::Interrupted);
        }
        Stop::Hopeless => Some(
            "the target is out of reach: the dense model itself is far below it; lower \
             the target",
        ),
    };
    let wants_ratios = args.compare.study.contains(&StudyArg::Ratio);
    let fps = args.power.fps;
    let filter_flops = args.fovea.filter_flops;
    let (setup, campaign) = (&setup, &campaign);
    let run = finish::Finished { setup, campaign, fps, wants_ratios, filter_flops, stopped };
    finish::finish(&run, &inputs, &mut folder, &progress, context)
}

fn setup<'a>(inputs: &'a Inputs, settings: &'a Settings, args: &Args) -> Setup<'a> {
    Setup {
        dense: &inputs.dense,
        cameras: &inputs.cameras,
        references: &inputs.references,
        split: &inputs.split,
        power_views: &inputs.power_views,
        background: args.views.background.0,
        display: &inputs.display,
        oracle: inputs.oracle.as_ref(),
        screen: inputs.screen,
        lpips: inputs.lpips.as_ref().map(|l| &l.0),
        settings,
    }
}

/// What all jobs share.
pub struct Work<'a> {
    /// Inputs and numbers.
    pub setup: &'a Setup<'a>,
    /// What is to be done.
    pub campaign: &'a Campaign,
    inputs: &'a Inputs,
    every: u32,
    context: &'a Context,
}

impl Work<'_> {
    /// Does the jobs that are left.
    fn jobs(&self, folder: &mut Folder, progress: &mut Progress) -> Result<Stop, Failure> {
        let settings = self.setup.settings;
        let points = self.setup.dense.len();
        let total = self.campaign.most_iterations(settings);
        let bar = Bar::new(self.context, total, "iterations");
        bar.advance(progress.outcomes.iter().map(|o| u64::from(o.iterations)).sum());
        while let Some(job) = self.campaign.next(settings, points, &progress.outcomes) {
            if self.is_hopeless(progress) {
                return Ok(Stop::Hopeless);
            }
            if self.context.is_cancelled() {
                let current = progress.current.as_ref();
                folder.save(&progress.outcomes, current.map(|(name, s)| (name.as_str(), s)))?;
                return Ok(Stop::Interrupted);
            }
            let done = match job.orders {
                Some(orders) => self.tune(&job, orders, folder, progress, &bar)?,
                None => Some((self.untuned(&job), None)),
            };
            let Some((model, ended)) = done else { return Ok(Stop::Interrupted) };
            let done = &progress.outcomes;
            let judge = |quality| self.campaign.judge(done, &job, quality);
            let outcome = Outcome::measured(self.setup, &job, &model, ended, judge)
                .or_exit(Exit::Internal, format_args!("internal error in job {}", job.name))?;
            self.inputs.references.check()?;
            if job.is_kept() {
                folder.save_model(&job.name, &model)?;
            }
            self.say(&outcome);
            progress.outcomes.push(outcome);
            folder.save(&progress.outcomes, None)?;
        }
        Ok(Stop::Done)
    }

    /// Whether the target is far above what the dense model itself reaches.
    fn is_hopeless(&self, progress: &Progress) -> bool {
        let Some(target) = self.campaign.target(&progress.outcomes, 0) else { return false };
        let Some(dense) = progress.outcomes.first() else { return false };
        let short = target.shortfall(dense.gate.quality);
        short.psnr_db > HOPELESS_DB || short.ssim > HOPELESS_SSIM
    }

    fn untuned(&self, job: &Job) -> Model {
        match job.role {
            Role::External(position) => Model::fresh(&self.inputs.externals[position].1),
            Role::Dense
            | Role::HeldOut
            | Role::Sample
            | Role::Final
            | Role::Baseline(_)
            | Role::Sweep(_) => Model::fresh(self.setup.dense),
        }
    }

    /// Trains; `None` after Ctrl-C.
    fn tune(
        &self,
        job: &Job,
        orders: Orders,
        folder: &mut Folder,
        progress: &mut Progress,
        bar: &Bar,
    ) -> Result<Option<(Model, Option<Ended>)>, Failure> {
        let target = self.campaign.target_at(&progress.outcomes, job.role.line(), job.place);
        let target = target.unwrap_or(UNREACHED);
        let state = self.state(job, folder, progress)?;
        bar.advance(u64::from(state.iteration));
        let stream = progress.outcomes.len() as u64;
        let mut tuner = Tuner::new(self.setup, orders, target, stream, state);
        while !tuner.is_done() {
            let row = tuner.step().or_exit(Exit::BadInput, format_args!("job {}", job.name))?;
            self.inputs.references.check()?;
            folder.record(self.setup, job, &row)?;
            bar.advance(1);
            let cancelled = self.context.is_cancelled();
            if cancelled || (row.iteration + 1).is_multiple_of(self.every) {
                folder.save(&progress.outcomes, Some((&job.name, tuner.state())))?;
            }
            if cancelled {
                return Ok(None);
            }
        }
        let iterations = tuner.state().iteration;
        bar.advance(u64::from(orders.iterations.saturating_sub(iterations)));
        let (model, check, passing_lambda) = tuner.finish();
        Ok(Some((model, Some(Ended { iterations, check, passing_lambda }))))
    }

    /// Where the job in flight is, or its beginning.
    fn state(&self, job: &Job, folder: &Folder, progress: &mut Progress) -> Result<State, Failure> {
        if let Some((name, state)) = progress.current.take()
            && name == job.name
        {
            return Ok(state);
        }
        let model = match &job.from {
            Some(from) => {
                let model = folder.load_model(from)?;
                let is_own =
                    progress.outcomes.iter().any(|o| o.name == *from && o.place == job.place);
                // Moments of another loss would hold the first hundreds of steps back.
                if is_own { model } else { Model::fresh(&model.scene) }
            }
            None => Model::fresh(self.setup.dense),
        };
        Ok(State::begin(model))
    }

    /// One line about a finished job, on standard error.
    fn say(&self, outcome: &Outcome) {
        if self.context.global.quiet {
            return;
        }
        if outcome.role == Role::Dense {
            let power = "total = rendering + display";
            out::complain(format!(
                "{:17} {:>9} {:>8} {:6} {:6} {power}",
                "model", "Gaussians", "PSNR, dB", "SSIM", "target"
            ));
        }
        let q = &outcome.gate.quality;
        let w = &outcome.watts;
        let quality = match q.hvsq.filter(|_| outcome.place.level > 0) {
            Some(hvsq) => format!("HVSQ {hvsq:>10.3e}"),
            None => format!("{:>8.2} {:.4}", q.psnr_db, q.ssim),
        };
        out::complain(format!(
            "{:17} {:>9} {quality} {:6} {} = {} + {}",
            shortened(&outcome.name, 17),
            outcome.points,
            if outcome.passed { "ok" } else { "missed" },
            engineering(w.total_w(), "W"),
            engineering(w.render_w, "W"),
            engineering(w.display_w, "W")
        ));
    }
}

/// No job trains before the dense model is measured; this target is reached by nothing.
const UNREACHED: Target = Target::Likeness(Quality::likeness(f64::INFINITY, f64::INFINITY));
