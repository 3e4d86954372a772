//! Takes lists of frames through all machines of an experiment.

use powergs_core::run::{FrameView, Frames, RunError, Session, Subject, System, Watch};

use crate::findings::cost::{Cost, CostSum};
use crate::findings::sensitivity::Traced;

/// The machines of an experiment; the first is the one that is perturbed.
pub(super) struct MeasuredMachines(Vec<System>);

impl MeasuredMachines {
    /// The machine that is perturbed.
    pub(super) fn new(base: &System) -> MeasuredMachines {
        MeasuredMachines(vec![base.clone()])
    }

    /// Adds a machine and returns its place.
    pub(super) fn add(&mut self, system: System) -> usize {
        self.0.push(system);
        self.0.len() - 1
    }

    /// Takes all frames of all lists through all machines; `None` if not even one frame was done.
    ///
    /// # Errors
    /// As [`Session::fold`].
    pub(super) fn measure<F: Frames>(
        &self,
        lists: &mut [F],
        display_fps: f64,
        watch: &dyn Watch,
    ) -> Result<Option<SensitivityMeasurements>, RunError> {
        let mut traces = Vec::new();
        for list in lists {
            if watch.is_cancelled() {
                break;
            }
            traces.extend(self.on_list(list, display_fps, watch)?);
        }
        Ok((!traces.is_empty()).then_some(SensitivityMeasurements(traces)))
    }

    fn on_list(
        &self,
        list: &mut impl Frames,
        display_fps: f64,
        watch: &dyn Watch,
    ) -> Result<Option<OnTrace>, RunError> {
        let (name, asked) = (list.name().to_owned(), list.range().len() / list.eyes());
        let subjects: Vec<Subject> = self.0.iter().map(Subject::of).collect();
        let add = |sum: &mut CostSum, view: FrameView<'_>| sum.add(&view.report, display_fps);
        let folded = Session::new(list, watch).fold(&subjects, |_| CostSum::default(), add)?;
        let frames = folded.frames;
        if frames == 0 {
            return Ok(None);
        }
        let outcomes = folded.states.iter().map(CostSum::mean).collect();
        Ok(Some(OnTrace { name, frames, asked, outcomes }))
    }
}

/// One list of frames.
struct OnTrace {
    name: String,
    frames: usize,
    asked: usize,
    /// By place of the machine.
    outcomes: Vec<Cost>,
}

/// What every machine costs on every list of frames.
pub(super) struct SensitivityMeasurements(Vec<OnTrace>);

impl SensitivityMeasurements {
    /// What the machine at a place costs, by list.
    pub(super) fn outcomes(&self, place: usize) -> Vec<Cost> {
        self.0.iter().map(|trace| trace.outcomes[place]).collect()
    }

    /// The lists, with the machine that is perturbed.
    pub(super) fn traced(&self) -> Vec<Traced> {
        let of = |trace: &OnTrace| Traced {
            name: trace.name.clone(),
            frames: trace.frames,
            asked: trace.asked,
            base: trace.outcomes[0],
        };
        self.0.iter().map(of).collect()
    }
}
