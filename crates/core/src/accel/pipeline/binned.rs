//! How much of the scene has been binned: which lists are complete.

use std::collections::VecDeque;

/// Batches whose results have been written, and the splats of all batches before the first one that
/// has not.
#[derive(Debug)]
pub(super) struct Binned {
    /// Whether cores wait for lists; otherwise every list counts as complete.
    pub is_watched: bool,
    /// First batch that is not written.
    first: u32,
    /// Splats of batches from there on that are.
    written: VecDeque<Option<u64>>,
    splats: u64,
    has_news: bool,
}

impl Binned {
    pub fn new(is_watched: bool) -> Self {
        Self { is_watched, first: 0, written: VecDeque::new(), splats: 0, has_news: false }
    }

    /// The results of a batch have been written.
    pub fn complete(&mut self, batch: u32, splats: u64) {
        if !self.is_watched {
            return;
        }
        let index = (batch - self.first) as usize;
        if self.written.len() <= index {
            self.written.resize(index + 1, None);
        }
        self.written[index] = Some(splats);
        while let Some(splats) = self.written.pop_front_if(|w| w.is_some()).flatten() {
            (self.first, self.splats, self.has_news) = (self.first + 1, self.splats + splats, true);
        }
    }

    /// Whether the first `splats` splats in storage order have been written.
    pub fn has(&self, splats: u32) -> bool {
        !self.is_watched || u64::from(splats) <= self.splats
    }

    /// Whether there is more than when this was asked last.
    pub fn take_news(&mut self) -> bool {
        std::mem::take(&mut self.has_news)
    }
}
