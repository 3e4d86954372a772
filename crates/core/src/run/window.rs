//! Binned frames in memory: as many of a list as fit, the next ones when those are done.
//!
//! A [`Session`](super::session::Session) hands each frame to all systems at once. Where systems
//! are too many to be held, a window of frames is held instead, and systems are made one by one.

use super::error::RunError;
use super::frames::Frames;
use super::session::{BinnedFrame, bin_demand};
use crate::flow::WorkKey;

/// Consecutive frames, prepared under one key.
pub struct Window {
    /// The frames.
    pub frames: Vec<BinnedFrame>,
    /// Whether they are all frames of the list.
    pub is_whole: bool,
    /// Position of the first of them.
    pub start: usize,
    /// Position after the last of them.
    pub end: usize,
}

impl Window {
    /// Bins frames from position `start` on until they take `most_bytes`, at least one.
    ///
    /// # Errors
    /// [`RunError::Input`]: a frame that cannot be read, or that takes more memory than
    /// [`Frames::budget`].
    pub fn bin(
        source: &mut dyn Frames,
        key: &WorkKey,
        start: usize,
        most_bytes: usize,
    ) -> Result<Window, RunError> {
        let range = source.range();
        let (mut frames, mut bytes, mut end) = (Vec::new(), 0, start);
        while end < range.end && (frames.is_empty() || bytes < most_bytes) {
            let frame = source.take(end)?.get()?;
            bin_demand(source.name(), &frame, std::slice::from_ref(key), source.budget())?;
            let frame = BinnedFrame::new(end, &frame, std::slice::from_ref(key), source.budget());
            bytes += frame.bytes();
            frames.push(frame);
            end += 1;
        }
        let is_whole = start == range.start && end == range.end;
        Ok(Window { frames, is_whole, start, end })
    }
}
