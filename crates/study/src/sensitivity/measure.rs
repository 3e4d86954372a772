//! Takes lists of frames through all machines of an experiment.

use powergs_core::run::{FrameView, Frames, RunError, Session, Subject, System, Watch};

use powergs_core::sim::statistics::Weight;

use crate::findings::sensitivity::{Outcome, Traced};
use crate::findings::what_if::Cost;

/// The machines of an experiment; the first is the one that is perturbed.
pub(super) struct Machines(Vec<System>);

impl Machines {
    /// The machine that is perturbed.
    pub(super) fn new(base: &System) -> Machines {
        Machines(vec![base.clone()])
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
    ) -> Result<Option<Measurements>, RunError> {
        let mut traces = Vec::new();
        for list in lists {
            if watch.is_cancelled() {
                break;
            }
            traces.extend(self.on_list(list, display_fps, watch)?);
        }
        Ok((!traces.is_empty()).then_some(Measurements(traces)))
    }

    fn on_list(
        &self,
        list: &mut impl Frames,
        display_fps: f64,
        watch: &dyn Watch,
    ) -> Result<Option<OnTrace>, RunError> {
        let (name, asked) = (list.name().to_owned(), list.range().len());
        let subjects: Vec<Subject> = self.0.iter().map(Subject::of).collect();
        let add = |(sum, shown): &mut (Outcome, f64), view: FrameView<'_>| {
            let cost = Cost::of(&view.report);
            sum.frame_time_ms += cost.frame_time_ms;
            sum.energy_pj += cost.energy_pj;
            let seconds = Weight::Displayed.of(&view.report, display_fps);
            sum.power_w += view.report.power_display_rate_w(display_fps) * seconds;
            *shown += seconds;
        };
        let folded = Session::new(list, watch).fold(&subjects, |_| Default::default(), add)?;
        let frames = folded.frames;
        if frames == 0 {
            return Ok(None);
        }
        let mean = |((sum, shown), system): ((Outcome, f64), &System)| Outcome {
            frame_time_ms: sum.frame_time_ms / frames as f64,
            energy_pj: sum.energy_pj / frames as f64,
            power_w: sum.power_w / shown,
            area_mm2: system.prices().area.map(|a| a.total().0),
        };
        let outcomes = folded.states.into_iter().zip(&self.0).map(mean).collect();
        Ok(Some(OnTrace { name, frames, asked, outcomes }))
    }
}

/// One list of frames.
struct OnTrace {
    name: String,
    frames: usize,
    asked: usize,
    /// By place of the machine.
    outcomes: Vec<Outcome>,
}

/// What every machine costs on every list of frames.
pub(super) struct Measurements(Vec<OnTrace>);

impl Measurements {
    /// What the machine at a place costs, by list.
    pub(super) fn outcomes(&self, place: usize) -> Vec<Outcome> {
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
