//! Traces of training steps along the way.

use std::fs;
use std::io::BufWriter;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::inputs::TrainViews;
use crate::cli::{Context, Exit, Failure, OrExit, output_file};
use powergs_core::run::store::atomic::{persist, temporary};
use powergs_core::run::{Frames, Watch};
use powergs_frame::scene::StorageOrder;
use powergs_frame::trace::TraceHeader;
use powergs_scene::{Camera, Gaussians};
use powergs_study::extract::extract;
use powergs_views::RenderedViews;

/// Which traces are written.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Traces of training steps")]
pub struct StepTraceArgs {
    /// Every N iterations, write a trace of some training views of the model as it is then
    #[arg(long, value_name = "N", requires = "traces")]
    trace_every: Option<NonZeroU32>,
    /// Folder for the traces: step-000500.bin and so on
    #[arg(long, value_name = "DIR", requires = "trace_every")]
    traces: Option<PathBuf>,
    /// Training views in each trace, evenly spaced
    #[arg(long, value_name = "N", default_value = "4")]
    trace_views: NonZeroUsize,
}

/// The traces of a training.
pub struct StepTraces {
    folder: Option<PathBuf>,
    every: u32,
    views: usize,
    iterations: u32,
}

impl StepTraceArgs {
    /// The traces, none of which is there already unless it may be replaced.
    ///
    /// # Errors
    /// Exit code 2: one is there.
    pub fn open(&self, iterations: u32, is_replaced: bool) -> Result<StepTraces, Failure> {
        let every = self.trace_every.map_or(u32::MAX, NonZeroU32::get);
        let (folder, views) = (self.traces.clone(), self.trace_views.get());
        let traces = StepTraces { folder, every, views, iterations };
        traces.steps().try_for_each(|step| output_file::check(&step, is_replaced))?;
        if let Some(folder) = &traces.folder {
            fs::create_dir_all(folder).or_exit(Exit::Usage, folder.display())?;
        }
        Ok(traces)
    }
}

impl StepTraces {
    fn steps(&self) -> impl Iterator<Item = PathBuf> {
        let count = self.folder.as_ref().map_or(0, |_| self.iterations / self.every);
        (1..=count).filter_map(|i| self.step(i * self.every))
    }

    /// All of them.
    pub fn files(&self) -> Vec<String> {
        self.steps().map(|path| path.display().to_string()).collect()
    }

    /// The trace of an iteration, if it has one.
    fn step(&self, iteration: u32) -> Option<PathBuf> {
        let folder = self.folder.as_ref()?;
        let is_due = iteration.is_multiple_of(self.every);
        is_due.then(|| folder.join(format!("step-{iteration:06}.bin")))
    }

    /// Writes the trace of an iteration that has one.
    ///
    /// # Errors
    /// Exit code 2: it cannot be written, or a frame takes too much memory.
    pub fn write(
        &self,
        iteration: u32,
        scene: &Gaussians,
        views: &TrainViews,
        background: [f32; 3],
        context: &Context,
    ) -> Result<(), Failure> {
        let Some(path) = self.step(iteration) else { return Ok(()) };
        let (n, taken) = (views.train.len(), views.train.len().min(self.views));
        let view = |i: usize| views.cameras[views.train[i * n / taken]].clone();
        let cameras: Vec<Camera> = (0..taken).map(view).collect();
        let header = TraceHeader {
            generator: concat!("powergs-sim ", env!("CARGO_PKG_VERSION")).to_owned(),
            scene: format!("step-{iteration:06}"),
            points: scene.len() as u64,
            order: StorageOrder::default(),
        };
        write(&path, &header, scene, cameras, background, context)
    }
}

fn write(
    path: &Path,
    header: &TraceHeader,
    scene: &Gaussians,
    cameras: Vec<Camera>,
    background: [f32; 3],
    context: &Context,
) -> Result<(), Failure> {
    let frames = RenderedViews::new(&header.scene, Arc::new(scene.clone()), cameras);
    let mut frames = frames.on_background(background);
    frames.allow(context.global.memory);
    let place = || format!("{}: cannot be written", path.display());
    let file = temporary(path).or_exit(Exit::Usage, place())?;
    let frames: &mut dyn Frames = &mut frames;
    let trace = extract(frames, header, BufWriter::new(file), &WholeTrace)?;
    let file = trace.out.into_inner().map_err(|e| e.into_error()).or_exit(Exit::Usage, place())?;
    persist(file, path).or_exit(Exit::Usage, place())
}

/// A few frames are written to the end: a trace that is there is whole.
struct WholeTrace;

impl Watch for WholeTrace {}
