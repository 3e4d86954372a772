//! Runs an optimisation: job after job, each of which can be stopped after any iteration and goes
//! on bit for bit, until everything that the plan asks for is made and measured.
//!
//! A [`Request`] is opened as a [`Campaign`], which begins or goes on in a [`Store`] and ends with
//! a [`Finished`]. Nothing is printed.
//!
//! [`Request`]: super::request::Request

mod collect;
mod error;
mod finished;
mod identity;
mod jobs;
mod open;
mod reprice;
mod traces;

pub use error::CampaignError;
pub use finished::{Finished, FoveatedModels};

use powergs_core::run::Store;
use powergs_frame::display::Display;
use powergs_quality::Lpips;
use powergs_scene::{Camera, Gaussians};

use super::checkpoint::{Checkpoints, Progress};
use super::counted::PowerCounted;
use super::judged::JudgedSize;
use super::oracle::PowerOracle;
use super::plan::Plan;
use super::references::ReferenceImages;
use super::renderer::Renderer;
use super::request::Foveation;
use super::settings::{Gate, Settings};
use super::setup::Setup;
use super::views::{Priced, TrainingDistance, ViewSplit};
use super::watch::CampaignWatch;

/// An optimisation with everything that it needs, checked. Fields are those of [`Request`], as
/// they are used.
///
/// [`Request`]: super::request::Request
pub struct Campaign {
    /// Name of the scene.
    pub name: String,
    /// The model to optimise.
    pub dense: Gaussians,
    /// Further models to compare with.
    pub externals: Vec<(String, Gaussians)>,
    /// All views; after those of the request, those that gate and test in another size than they
    /// train in, and those that were made to gate.
    pub cameras: Vec<Camera>,
    /// What they should look like.
    pub references: ReferenceImages,
    /// Behind everything, sRGB from 0 to 1.
    pub background: [f32; 3],
    /// Which view does what.
    pub split: ViewSplit,
    /// What the views of the request were before any were added.
    pub given: GivenViews,
    /// The sizes of what trains and of what gates and tests.
    pub judged: JudgedSize,
    /// The views that power is a mean over.
    pub power_views: Vec<Camera>,
    /// What these are: how many of how many, and how large.
    pub priced: Priced,
    /// What trains and looks.
    pub renderer: Box<dyn Renderer>,
    /// What rendering costs.
    pub oracle: Box<dyn PowerOracle>,
    /// The panel, scaled.
    pub display: Display,
    /// How power is counted.
    pub counted: PowerCounted,
    /// How it is searched.
    pub settings: Settings,
    /// What is to be made.
    pub plan: Plan,
    /// Whether savings are also computed over display-to-render ratios.
    pub ratio_study: bool,
    /// What levels for the periphery of sight are made for.
    pub foveation: Option<Foveation>,
    /// What LPIPS is measured with, and the hash of its file.
    pub lpips: Option<(Lpips, u128)>,
    /// Whether every model is kept with its moments.
    pub keep_all: bool,
}

/// The views of a request: the first of those of its campaign.
#[derive(Debug, Clone)]
pub struct GivenViews {
    /// How many there are.
    pub count: usize,
    /// Which of them does what.
    pub split: ViewSplit,
    /// A hash of their photos in the size that they train in; `None` for renders of the dense
    /// model.
    pub photos: Option<u128>,
}

impl Campaign {
    /// Number of views that decide whether a model passes.
    pub fn gate_views(&self) -> usize {
        match self.settings.gate {
            Gate::Validation => self.split.validation.len(),
            Gate::Test => self.split.test.len(),
        }
    }

    /// How far made gate views and test views are from those that train; `None` where none were
    /// made.
    pub fn training_distance(&self) -> Option<TrainingDistance> {
        TrainingDistance::of(&self.cameras, &self.split)
    }

    /// What every job works on.
    pub fn setup(&self) -> Setup<'_> {
        Setup {
            dense: &self.dense,
            cameras: &self.cameras,
            references: self.references.images(),
            split: &self.split,
            power_views: &self.power_views,
            background: self.background,
            display: &self.display,
            renderer: &*self.renderer,
            oracle: &*self.oracle,
            screens: self.foveation.as_ref().map(|f| f.screens),
            lpips: self.lpips.as_ref().map(|(lpips, _)| lpips),
            settings: &self.settings,
        }
    }

    /// Runs the campaign, or goes on with it where the store has it. `None`: it was cancelled, and
    /// goes on from there when it is run again.
    ///
    /// # Errors
    /// [`CampaignError`]: another run in the store, a store that fails, numbers that are not
    /// finite, a machine that cannot run a frame.
    pub fn run(
        &self,
        store: &dyn Store,
        watch: &dyn CampaignWatch,
    ) -> Result<Option<Finished>, CampaignError> {
        let has_run = Checkpoints::new(store, self.fingerprint()).has_run()?;
        let run = if has_run { self.resume(store)? } else { self.begin(store)? };
        run.work(watch)
    }

    /// A new run in a store.
    ///
    /// # Errors
    /// [`CampaignError::HoldsRun`], or a store that cannot be written.
    pub fn begin<'a>(&'a self, store: &'a dyn Store) -> Result<Run<'a>, CampaignError> {
        let checkpoints = Checkpoints::new(store, self.fingerprint());
        if checkpoints.has_run()? {
            return Err(CampaignError::HoldsRun);
        }
        // Killed before its next checkpoint, a run can be resumed all the same.
        checkpoints.save(&[], &[], None)?;
        self.mark(store)?;
        Ok(Run { campaign: self, checkpoints, progress: Progress::default() })
    }

    /// The run in a store, where it was stopped.
    ///
    /// # Errors
    /// [`CampaignError::NoRun`], or a checkpoint that is damaged or of another run.
    pub fn resume<'a>(&'a self, store: &'a dyn Store) -> Result<Run<'a>, CampaignError> {
        let checkpoints = Checkpoints::new(store, self.fingerprint());
        let progress = checkpoints.load()?.ok_or(CampaignError::NoRun)?;
        // Stopped between its first checkpoint and the mark, the run has none yet.
        if !self.is_marked(store)? {
            self.mark(store)?;
        }
        Ok(Run { campaign: self, checkpoints, progress })
    }
}

/// A campaign at work.
pub struct Run<'a> {
    campaign: &'a Campaign,
    checkpoints: Checkpoints<'a>,
    progress: Progress,
}

impl Run<'_> {
    /// What is known so far, without any further work.
    ///
    /// # Errors
    /// As [`Campaign::run`].
    pub fn priced(self) -> Result<Finished, CampaignError> {
        self.finished(None)
    }

    /// Does what is left. `None`: it was cancelled.
    ///
    /// # Errors
    /// As [`Campaign::run`].
    pub fn work(mut self, watch: &dyn CampaignWatch) -> Result<Option<Finished>, CampaignError> {
        match self.jobs(watch)? {
            jobs::Stop::Cancelled => Ok(None),
            jobs::Stop::Done => self.finished(None).map(Some),
            jobs::Stop::OutOfReach(why) => self.finished(Some(&why)).map(Some),
        }
    }
}
