//! Units that need a trace only: its lists.

use std::path::PathBuf;

use powergs_core::flow::lists::work_key;
use powergs_core::run::{Frames, Window};
use powergs_core::workload::order::DepthKey;
use powergs_core::workload::{FrameWorkload, Geometry};
use powergs_sim::cli::camera_file::{FrameRange, frame_range};
use powergs_sim::cli::{Context, Failure, inputs};

/// A trace.
#[derive(Debug, clap::Args)]
pub struct Lists {
    /// Trace whose lists are sorted
    #[arg(long, value_name = "FILE")]
    trace: PathBuf,
    /// Frames of the trace [default: the first]
    #[arg(long, value_name = "RANGE", value_parser = frame_range)]
    frames: Option<FrameRange>,
}

/// FP16 keys in storage order.
pub type Keys = Vec<Vec<u16>>;

/// What is taken from a list.
pub type Given = fn(&FrameWorkload, &[u32], &mut Keys);

impl Lists {
    /// The trace, for messages.
    pub fn source(&self) -> String {
        self.trace.display().to_string()
    }

    /// What `given` takes from each list; `None`: interrupted.
    pub fn keys(&self, given: Given, context: &Context) -> Result<Option<Keys>, Failure> {
        let mut trace = inputs::trace(&self.trace, self.frames, context)?;
        let range = trace.range();
        let last = if self.frames.is_some() { range.end } else { range.end.min(range.start + 1) };
        let mut lists = Vec::new();
        for position in range.start..last {
            if context.is_cancelled() {
                return Ok(None);
            }
            // One frame: it is checked against the budget before it is binned.
            let key = work_key(Geometry::REFERENCE);
            let window = Window::bin(&mut trace, &key, position, 1)?;
            let workload = window.frames[0].bins[&key].work.of::<FrameWorkload>();
            let workload = workload.expect("the work of a geometry");
            for tile in &workload.tiles {
                given(workload, workload.list_of(tile), &mut lists);
            }
        }
        Ok(Some(lists))
    }
}

/// Lists that are longer than a chunk, as a QSU gets them.
pub fn whole(workload: &FrameWorkload, list: &[u32], lists: &mut Keys) {
    if list.len() > workload.geometry.chunk as usize {
        lists.push(arriving(workload, list));
    }
}

/// Chunks, as a BSU gets them: pivots have cut the list into stretches of the exact order.
pub fn chunks(workload: &FrameWorkload, list: &[u32], lists: &mut Keys) {
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
