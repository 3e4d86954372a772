//! Sorting units: lists of keys from a trace.

use std::path::PathBuf;

use super::super::camera_file::{FrameRange, frame_range};
use super::super::{Context, Exit, Failure, inputs};
use super::Target;
use powergs_core::run::{Frames, Window};
use powergs_core::workload::order::DepthKey;
use powergs_core::workload::{FrameWorkload, Geometry};
use powergs_gates::characterise::{CharacteriseError, Characterised};
use powergs_gates::netlist::Netlist;

/// Arguments of `characterise qsu` and `bsu`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Trace whose lists are sorted
    #[arg(long, value_name = "FILE")]
    trace: PathBuf,
    /// Frames of the trace [default: the first]
    #[arg(long, value_name = "RANGE", value_parser = frame_range)]
    frames: Option<FrameRange>,
    #[command(flatten)]
    target: Target,
}

type Lists = Vec<Vec<u16>>;

impl Args {
    /// Prices by `prices` of what `given` takes from each list.
    pub(super) fn run(
        &self,
        unit: &str,
        given: fn(&FrameWorkload, &[u32], &mut Lists),
        prices: fn(&Netlist, &[Vec<u16>]) -> Result<Characterised, CharacteriseError>,
        context: &Context,
    ) -> Result<Exit, Failure> {
        let netlist = self.target.netlist(unit)?;
        let Some(lists) = self.lists(given, context)? else { return Ok(Exit::Interrupted) };
        let trace = self.trace.display().to_string();
        self.target.write((unit, &trace), &netlist, prices(&netlist, &lists), context)
    }

    /// `None`: interrupted.
    fn lists(
        &self,
        given: fn(&FrameWorkload, &[u32], &mut Lists),
        context: &Context,
    ) -> Result<Option<Lists>, Failure> {
        let mut trace = inputs::trace(&self.trace, self.frames, context)?;
        let range = trace.range();
        let last = if self.frames.is_some() { range.end } else { range.end.min(range.start + 1) };
        let mut lists = Vec::new();
        for position in range.start..last {
            if context.is_cancelled() {
                return Ok(None);
            }
            // One frame: it is checked against the budget before it is binned.
            let window = Window::bin(&mut trace, Geometry::REFERENCE, position, 1)?;
            let workload = &window.frames[0].bins[&Geometry::REFERENCE].workload;
            for tile in &workload.tiles {
                given(workload, workload.list_of(tile), &mut lists);
            }
        }
        Ok(Some(lists))
    }
}

/// Lists that are longer than a chunk, as a QSU gets them.
pub(super) fn whole(workload: &FrameWorkload, list: &[u32], lists: &mut Lists) {
    if list.len() > workload.geometry.chunk as usize {
        lists.push(arriving(workload, list));
    }
}

/// Chunks, as a BSU gets them: pivots have cut the list into stretches of the exact order.
pub(super) fn chunks(workload: &FrameWorkload, list: &[u32], lists: &mut Lists) {
    let chunk = workload.geometry.chunk as usize;
    lists.extend(list.chunks(chunk).map(|part| arriving(workload, part)));
}

/// FP16 keys of some ranks in storage order.
fn arriving(workload: &FrameWorkload, ranks: &[u32]) -> Vec<u16> {
    let mut ranks = ranks.to_vec();
    ranks.sort_unstable_by_key(|rank| workload.index[*rank as usize]);
    let key = |rank: &u32| DepthKey::Fp16.of(workload.depth[*rank as usize]) as u16;
    ranks.iter().map(key).collect()
}
