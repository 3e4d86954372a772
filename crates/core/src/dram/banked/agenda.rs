//! When something happens next in each channel.

use super::table::{MOST, Table};

/// The next CK of all channels.
#[derive(Debug, Clone)]
pub(super) struct Agenda {
    channels: usize,
    next: Table<u64>,
}

impl Agenda {
    /// The agenda of channels with these next CK.
    pub(super) fn new(next: impl ExactSizeIterator<Item = u64>) -> Self {
        let mut agenda = Self { channels: next.len().min(MOST), next: Table::new(u64::MAX) };
        next.enumerate().for_each(|(channel, ck)| agenda.set(channel, ck));
        agenda
    }

    /// Sets the CK in which something happens next in a channel.
    #[inline]
    pub(super) fn set(&mut self, channel: usize, ck: u64) {
        *self.next.at_mut(channel) = ck;
    }

    /// The CK in which something happens next, and the lowest channel in which it does.
    #[inline]
    pub(super) fn first(&self) -> (u64, usize) {
        let mut first = (u64::MAX, 0);
        for (number, ck) in self.next.up_to(self.channels).iter().enumerate() {
            first = if *ck < first.0 { (*ck, number) } else { first };
        }
        first
    }
}
