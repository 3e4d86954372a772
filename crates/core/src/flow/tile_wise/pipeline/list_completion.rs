//! List completion: which tile lists have been written in full, with `schedule.overlap = "tiles"`.
//!
//! Batches are written out of order; a list is complete when all batches up to that of its last
//! splat have been written.

use std::collections::VecDeque;

/// Tracks the batches whose results have been written.
#[derive(Debug)]
pub(super) struct ListCompletion {
    /// Whether cores wait for list completion; otherwise every list counts as complete.
    pub is_watched: bool,
    /// First batch that has not been written.
    first: u32,
    /// Splats of each batch from there on, where it has been written.
    written: VecDeque<Option<u64>>,
    /// Splats of all batches before `first`.
    splats: u64,
    /// Whether `splats` has grown since it was last asked for.
    has_grown: bool,
}

impl ListCompletion {
    pub(crate) fn new(is_watched: bool) -> Self {
        Self { is_watched, first: 0, written: VecDeque::new(), splats: 0, has_grown: false }
    }

    /// Records that the results of a batch have been written.
    pub(crate) fn complete(&mut self, batch: u32, splats: u64) {
        if !self.is_watched {
            return;
        }
        let index = (batch - self.first) as usize;
        if self.written.len() <= index {
            self.written.resize(index + 1, None);
        }
        self.written[index] = Some(splats);
        // Lists are complete by storage order: a batch behind a gap completes none.
        while let Some(splats) = self.written.pop_front_if(|w| w.is_some()).flatten() {
            (self.first, self.splats, self.has_grown) =
                (self.first + 1, self.splats + splats, true);
        }
    }

    /// Whether the first `splats` splats in storage order have been written.
    pub(crate) fn has(&self, splats: u32) -> bool {
        !self.is_watched || u64::from(splats) <= self.splats
    }

    /// Whether further lists may have been completed since the last call.
    pub(crate) fn take_growth(&mut self) -> bool {
        std::mem::take(&mut self.has_grown)
    }
}
