//! Designs of one machine on their way through a trace: timed once, priced by each of them.

use std::panic::{AssertUnwindSafe, catch_unwind};

use super::window::{Binned, Window};
use powergs_core::sim::{Label, Lists, Measured, priced, time_again};
use powergs_study::sweep::design::Design;
use powergs_study::sweep::journal::Record;
use powergs_study::sweep::outcome::Accumulator;

/// Designs with the same machine, and the frames that they have done.
pub struct Running {
    designs: Vec<Design>,
    lists: Lists,
    /// Per design, per energy table.
    sums: Vec<Vec<Accumulator>>,
    failed: Option<String>,
}

impl Running {
    /// Before the first frame. All designs have the machine of the first.
    pub fn new(designs: Vec<Design>) -> Running {
        let sums = designs.iter().map(|d| vec![Accumulator::default(); d.prices.len()]).collect();
        Running { designs, lists: Lists::default(), sums, failed: None }
    }

    /// Does the frames of a window; the windows of a trace must come in order. A frame that breaks
    /// off fails the designs, and nothing else.
    pub fn frames(&mut self, window: &Window, display_fps: f64) {
        for frame in &window.frames {
            if self.failed.is_some() {
                return;
            }
            let outcome = catch_unwind(AssertUnwindSafe(|| self.frame(frame, display_fps)));
            let name = &frame.label.name;
            self.failed = match outcome {
                Ok(Ok(())) => None,
                Ok(Err(breach)) => Some(format!("frame {name}: {breach}")),
                Err(panic) => Some(format!("frame {name}: internal error: {}", said(&*panic))),
            };
        }
    }

    fn frame(&mut self, frame: &Binned, display_fps: f64) -> Result<(), powergs_core::sim::Breach> {
        let machine = &self.designs[0].machine;
        let workload = &frame.workload;
        let measured = match machine.gsu.reuse_period {
            1 => Measured::needed(workload, machine),
            _ => Measured::of(workload, machine, &mut self.lists),
        };
        let timed = time_again(frame.label.frame, workload, &measured, machine, &frame.memo)?;
        for (design, sums) in self.designs.iter().zip(&mut self.sums) {
            let display = design.display.as_ref().zip(frame.mean_linear_rgb);
            let display_w = display.map(|(display, mean)| display.value.power(mean).0);
            for (table, sum) in design.prices.iter().zip(sums) {
                let label = Label { display_w, ..frame.label.clone() };
                sum.add(&priced(label, &timed, &table.prices)?, display_fps);
            }
        }
        Ok(())
    }

    /// The records: per design, per energy table.
    pub fn finish(self) -> Vec<Record> {
        let failed = self.failed;
        let record = |sum: Accumulator| match (&failed, sum.finish()) {
            (Some(reason), _) => Record::Failed(reason.clone()),
            (None, Some(outcome)) => Record::Ok(outcome),
            (None, None) => Record::Failed("the trace has no frames".into()),
        };
        self.sums.into_iter().flatten().map(record).collect()
    }
}

/// What a panic said.
fn said(panic: &(dyn std::any::Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("it says no more")
}
