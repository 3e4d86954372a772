//! Machines that differ from one in a single resource, which they have twice, and what frames cost
//! on them.

use powergs_base::config::knob;
use powergs_core::run::{Change, FileKind, RunError, System};
use powergs_core::sim::FrameReport;
use powergs_core::stage::{DoubleDecl, doubles};

use crate::findings::cost::Cost;
use crate::findings::what_if::{Skipped, Step, WhatIf};

/// What doubles a resource of a system.
fn changes(system: &System, resource: &DoubleDecl) -> Result<Vec<Change>, RunError> {
    let table = system.table(FileKind::Machine).unwrap_or_default();
    let twice = |key: &&str| {
        let value = knob::values(&table, key).pop();
        let value = value.and_then(|value| knob::scaled(&value, 2.0));
        let value = value.ok_or_else(|| RunError::Internal(format!("`{key}` is no number")))?;
        Ok(Change::machine(*key, value))
    };
    resource.keys.iter().map(twice).collect()
}

/// A machine with each of its resources doubled.
#[derive(Default)]
pub(super) struct Doubling {
    /// The machines, one for each resource that can be doubled.
    pub(super) systems: Vec<System>,
    resources: Vec<(&'static DoubleDecl, Vec<String>)>,
    skipped: Vec<Skipped>,
}

impl Doubling {
    /// Doubles every resource of `system`.
    pub(super) fn of(system: &System) -> Doubling {
        let mut all = Doubling::default();
        for resource in doubles(system.machine()) {
            let doubled = changes(system, resource).and_then(|changes| {
                let sets = changes.iter().map(Change::to_string).collect();
                Ok((system.with(&changes)?, sets))
            });
            match doubled {
                Ok((doubled, sets)) => {
                    all.systems.push(doubled);
                    all.resources.push((resource, sets));
                }
                Err(error) => {
                    let reason = error.message();
                    all.skipped.push(Skipped { resource: resource.name, reason });
                }
            }
        }
        all
    }

    /// What came out on the frames at these positions; `None` if none of them was done. `base` has
    /// the reports of the machine itself, `doubled` those of the others on these frames.
    pub(super) fn finish(
        self,
        positions: &[usize],
        base: &[FrameReport],
        doubled: &[Vec<FrameReport>],
        display_fps: f64,
    ) -> Option<WhatIf> {
        let tried: Vec<&FrameReport> =
            base.iter().filter(|report| positions.contains(&report.frame)).collect();
        if tried.is_empty() {
            return None;
        }
        let n = tried.len();
        let step = |((resource, sets), reports): ((&DoubleDecl, _), &Vec<FrameReport>)| Step {
            resource: resource.name,
            sets,
            cost: Cost::of_frames(reports.iter().take(n), display_fps),
            assumptions: resource.assumptions,
        };
        let steps = self.resources.into_iter().zip(doubled).map(step).collect();
        let frames = tried.iter().map(|report| report.frame).collect();
        let base = Cost::of_frames(tried, display_fps);
        Some(WhatIf::new(frames, base, steps, self.skipped))
    }
}
