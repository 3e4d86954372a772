//! When something happens next in each channel.

use super::table::MOST;

/// Bits of the number of a channel.
const NUMBER: u32 = MOST.ilog2();

/// No CK, as it is kept.
const NEVER: u64 = u64::MAX >> NUMBER;

/// Words that are compared at once.
const LANES: usize = 8;

/// The next CK of all channels, with their numbers below: the least comes first.
#[derive(Debug, Clone)]
pub(super) struct Agenda {
    next: Vec<[u64; LANES]>,
    /// The least of them, when it was last looked for.
    first: u64,
}

impl Agenda {
    /// The agenda of channels with these next CK.
    pub(super) fn new(next: impl ExactSizeIterator<Item = u64>) -> Self {
        let words = vec![[u64::MAX; LANES]; next.len().div_ceil(LANES)];
        let mut agenda = Self { next: words, first: u64::MAX };
        next.enumerate().for_each(|(channel, ck)| agenda.set(channel, ck));
        agenda.look();
        agenda
    }

    /// Sets the CK in which something happens next in a channel; [`Agenda::look`] comes after it.
    #[inline]
    pub(super) fn set(&mut self, channel: usize, ck: u64) {
        // With the number below the CK one minimum finds the earliest and, of equals, the lowest
        // channel.
        let word = ck.min(NEVER) << NUMBER | channel as u64;
        self.next[channel / LANES][channel % LANES] = word;
    }

    /// Looks for the first of all channels.
    #[inline]
    pub(super) fn look(&mut self) {
        let least = |n: &[u64; LANES]| {
            let [a, b] = [n[0].min(n[1]), n[2].min(n[3])];
            let [c, d] = [n[4].min(n[5]), n[6].min(n[7])];
            a.min(b).min(c.min(d))
        };
        self.first = self.next.iter().map(least).fold(u64::MAX, u64::min);
    }

    /// The CK in which something happens next, and the lowest channel in which it does.
    #[inline]
    pub(super) fn first(&self) -> (u64, usize) {
        let ck = self.first >> NUMBER;
        (if ck == NEVER { u64::MAX } else { ck }, self.first as usize % MOST)
    }
}
