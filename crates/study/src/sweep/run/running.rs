//! Designs of one machine on their way through a trace: timed once, priced by each of them.

use crate::sweep::design::{Design, DesignPriced};
use crate::sweep::outcome::Accumulator;
use crate::sweep::record::Record;
use powergs_core::flow::{FrameTask, History, WorkKey};
use powergs_core::kernel::Halt;
use powergs_core::run::session::{BinnedFrame, time};
use powergs_core::run::{RunError, Window};
use powergs_core::sim::priced;

/// Designs with the same machine, and the frames that they have done.
pub struct Running {
    designs: Vec<Design>,
    /// What the machine needs of a frame.
    work: WorkKey,
    history: History,
    /// Views that make a frame.
    eyes: usize,
    /// Per design, per energy table.
    sums: Vec<Vec<Accumulator>>,
    failed: Option<RunError>,
    /// Whether a frame was left half done, as nobody wants it any more.
    is_halted: bool,
}

impl Running {
    /// Before the first frame, of which each has `eyes` views. All designs have the machine of the
    /// first.
    pub fn new(designs: Vec<Design>, eyes: usize) -> Running {
        let sums = designs.iter().map(|d| vec![Accumulator::default(); d.prices.len()]).collect();
        let machine = &designs[0].machine;
        let (work, history) = (machine.flow().work_key(machine), History::default());
        Running { designs, work, history, eyes, sums, failed: None, is_halted: false }
    }

    /// Does the frames of a window; the windows of a trace must come in order. A frame that breaks
    /// off fails the designs, and nothing else; one that `halt` ends is the last one.
    pub fn frames(&mut self, window: &Window, display_fps: f64, halt: Halt<'_>) {
        for frame in &window.frames {
            if self.failed.is_some() || self.is_halted {
                return;
            }
            match self.frame(frame, display_fps, halt) {
                Ok(is_done) => self.is_halted = !is_done,
                Err(error) => self.failed = Some(error),
            }
        }
    }

    /// Whether it was ended within a frame: there are no results.
    pub fn is_halted(&self) -> bool {
        self.is_halted
    }

    /// Does a frame; returns whether it was done.
    fn frame(
        &mut self,
        frame: &BinnedFrame,
        display_fps: f64,
        halt: Halt<'_>,
    ) -> Result<bool, RunError> {
        let machine = &self.designs[0].machine;
        let work = &*frame.bins[&self.work].work;
        let before = machine.flow().hand_over(machine, work, frame.eye, &mut self.history);
        let task = FrameTask { halt, ..frame.task(machine, &self.work, before.as_ref()) };
        let Some(timed) = time(&frame.name, &task)? else { return Ok(false) };
        for (design, sums) in self.designs.iter().zip(&mut self.sums) {
            let label = frame.label(design.display.as_ref().map(|display| &display.value));
            for (table, sum) in design.prices.iter().zip(sums) {
                let Ok(prices) = &table.prices else { continue };
                let report = priced(label.clone(), &timed, prices)
                    .map_err(|e| RunError::in_frame(&frame.name, e.into()))?;
                sum.add(report, self.eyes, display_fps);
            }
        }
        Ok(true)
    }

    /// The records: per design, per energy table.
    pub fn finish(self) -> Vec<Record> {
        let failed = self.failed.map(|error| match error {
            RunError::Invariant { .. } | RunError::Internal(_) => Record::Defect(error.to_string()),
            error => Record::Failed(error.to_string()),
        });
        let record = |sum: Accumulator| match (&failed, sum.finish()) {
            (Some(record), _) => record.clone(),
            (None, Some(outcome)) => Record::Ok(outcome),
            (None, None) => Record::Failed("the trace has no frames".into()),
        };
        let of_design = |(design, sums): (Design, Vec<Accumulator>)| {
            let of_table = |(table, sum): (DesignPriced, Accumulator)| match table.prices {
                Ok(_) => record(sum),
                Err(reason) => Record::Failed(reason),
            };
            design.prices.into_iter().zip(sums).map(of_table).collect::<Vec<_>>()
        };
        self.designs.into_iter().zip(self.sums).flat_map(of_design).collect()
    }
}
