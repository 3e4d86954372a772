//! Binned frames in memory: as many of a trace as fit, the next ones when those are done.

use crate::cli::Failure;
use crate::cli::trace_source::TraceSource;
use powergs_core::accel::Memo;
use powergs_core::sim::Label;
use powergs_core::workload::{FrameWorkload, Geometry, bin};

/// A frame, binned.
pub struct Binned {
    /// What a report says about it; the display power is that of each design's display.
    pub label: Label,
    /// Mean linear colour of its image, where the trace has it.
    pub mean_linear_rgb: Option<[f64; 3]>,
    /// The frame.
    pub workload: FrameWorkload,
    /// Its preprocessing on machines that were met before.
    pub memo: Memo,
}

/// Some frames of a trace in a row, under one geometry.
pub struct Window {
    /// The frames.
    pub frames: Vec<Binned>,
    /// Whether they are all frames of the trace.
    pub is_whole: bool,
    /// Position of the first of them.
    pub start: usize,
    /// Position after the last of them.
    pub end: usize,
}

impl Window {
    /// Bins frames from position `start` of the trace until they take `most_bytes`, at least one.
    ///
    /// # Errors
    /// Exit code 3: a frame that cannot be read.
    pub fn bin(
        source: &mut TraceSource,
        geometry: Geometry,
        start: usize,
        most_bytes: usize,
    ) -> Result<Window, Failure> {
        let range = source.range();
        let (mut frames, mut bytes, mut end) = (Vec::new(), 0, start);
        while end < range.end && (frames.is_empty() || bytes < most_bytes) {
            let frame = source.frame(end)?;
            let workload = bin(&frame.frame, geometry);
            bytes += workload.bytes();
            let mean_linear_rgb = frame.frame.facts.mean_linear_rgb;
            let memo = Memo::default();
            frames.push(Binned { label: frame.label, mean_linear_rgb, workload, memo });
            end += 1;
        }
        let is_whole = start == range.start && end == range.end;
        Ok(Window { frames, is_whole, start, end })
    }
}
