//! Binned frames in memory: as many of a trace as fit, the next ones when those are done.

use crate::cli::Failure;
use powergs_core::run::session::BinnedFrame;
use powergs_core::run::{Frames, TraceFile};
use powergs_core::workload::Geometry;

/// Some frames of a trace in a row, under one geometry.
pub struct Window {
    /// The frames.
    pub frames: Vec<BinnedFrame>,
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
        source: &mut TraceFile,
        geometry: Geometry,
        start: usize,
        most_bytes: usize,
    ) -> Result<Window, Failure> {
        let range = source.range();
        let (mut frames, mut bytes, mut end) = (Vec::new(), 0, start);
        while end < range.end && (frames.is_empty() || bytes < most_bytes) {
            let frame = source.take(end)?()?;
            let frame = BinnedFrame::new(end, &frame, &[geometry]);
            bytes += frame.bytes();
            frames.push(frame);
            end += 1;
        }
        let is_whole = start == range.start && end == range.end;
        Ok(Window { frames, is_whole, start, end })
    }
}
