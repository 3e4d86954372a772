//! Waiting bursts of one channel: entries in lists by bank and direction, each in order of age.

use super::front::Burst;
use super::plan::BY_AGE;

/// No entry.
pub(super) const NONE: u16 = u16::MAX;

/// No row.
pub(super) const CLOSED: u32 = u32::MAX;

/// A burst that waits for its read or write command.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct QueueEntry {
    /// Number of the burst in the device: its address over the bytes of a burst.
    pub burst: u64,
    /// Order of acceptance in the channel, as the key of a command for it.
    pub key: u64,
    /// The CK of its acceptance.
    pub accepted: u64,
    /// Request that it belongs to.
    pub slot: u32,
    pub row: u32,
    next: u16,
    prev: u16,
    pub class: u8,
    pub write: bool,
    /// Whether a command was issued for it.
    pub tried: bool,
}

/// Entries of one bank and direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct QueueList {
    pub head: u16,
    tail: u16,
    /// The oldest entry for the open row.
    pub hit: u16,
    /// The oldest entry for another row; of all if no row is open.
    pub miss: u16,
}

impl QueueList {
    pub(super) const EMPTY: QueueList = QueueList { head: NONE, tail: NONE, hit: NONE, miss: NONE };
}

/// All entries of a channel.
#[derive(Debug, Clone)]
pub(super) struct Entries {
    entries: Vec<QueueEntry>,
    free: Vec<u16>,
    next_age: u64,
}

impl Entries {
    /// Room for `capacity` entries.
    pub(super) fn new(capacity: usize) -> Self {
        let free = (0..capacity as u16).rev().collect();
        Self { entries: vec![QueueEntry::default(); capacity], free, next_age: 0 }
    }

    #[inline]
    pub(super) fn get(&self, index: u16) -> &QueueEntry {
        &self.entries[usize::from(index)]
    }

    /// The entry with an index, if that is one.
    pub(super) fn find_entry(&self, index: u16) -> Option<&QueueEntry> {
        self.entries.get(usize::from(index))
    }

    #[inline]
    pub(super) fn get_mut(&mut self, index: u16) -> &mut QueueEntry {
        &mut self.entries[usize::from(index)]
    }

    /// Appends a burst to a list of its bank, whose open row is `open`; returns whether it is the
    /// oldest there of those for the open row, or of the others.
    #[inline]
    pub(super) fn push(
        &mut self,
        burst: &Burst,
        now: u64,
        list: &mut QueueList,
        open: u32,
    ) -> bool {
        let index = self.free.pop().expect("queues and banks have an entry each");
        self.entries[usize::from(index)] = QueueEntry {
            burst: burst.number,
            key: BY_AGE | self.next_age,
            accepted: now,
            slot: burst.slot,
            row: burst.row,
            next: NONE,
            prev: list.tail,
            class: burst.class,
            write: burst.write,
            tried: false,
        };
        self.next_age += 1;
        if list.tail == NONE {
            list.head = index;
        } else {
            self.get_mut(list.tail).next = index;
        }
        list.tail = index;
        // The list is in the order of age, so that the first of a kind is the oldest of it.
        let first = if burst.row == open { &mut list.hit } else { &mut list.miss };
        let is_first = *first == NONE;
        if is_first {
            *first = index;
        }
        is_first
    }

    /// Takes an entry out of its list; it stays valid until [`Entries::release`].
    #[inline]
    pub(super) fn unlink(&mut self, index: u16, list: &mut QueueList, open: u32) {
        let QueueEntry { next, prev, .. } = *self.get(index);
        // The first of its kind: the next one can only lie behind it.
        if list.hit == index {
            list.hit = self.find(next, |row| row == open);
        }
        if list.miss == index {
            list.miss = self.find(next, |row| row != open);
        }
        if prev == NONE {
            list.head = next
        } else {
            self.get_mut(prev).next = next
        }
        if next == NONE { list.tail = prev } else { self.get_mut(next).prev = prev }
    }

    /// Frees an entry that is in no list.
    pub(super) fn release(&mut self, index: u16) {
        self.free.push(index);
    }

    /// A row was opened.
    #[inline]
    pub(super) fn row_opened(&self, list: &mut QueueList, row: u32) {
        list.hit = self.find(list.head, |other| other == row);
        list.miss = self.find(list.head, |other| other != row);
    }

    #[inline]
    fn find(&self, from: u16, is: impl Fn(u32) -> bool) -> u16 {
        let mut at = from;
        while at != NONE && !is(self.get(at).row) {
            at = self.get(at).next;
        }
        at
    }
}

/// Numbers of the bursts in the write queue, with a quick answer for those that are not there.
#[derive(Debug, Clone)]
pub(super) struct Writes {
    bursts: Vec<u64>,
    /// How many of them fall on each place.
    counts: [u16; PLACES],
}

const PLACES: usize = 256;

impl Default for Writes {
    fn default() -> Self {
        Self { bursts: Vec::new(), counts: [0; PLACES] }
    }
}

impl Writes {
    fn place(burst: u64) -> usize {
        (burst ^ burst >> 8 ^ burst >> 16) as usize % PLACES
    }

    #[inline]
    pub(super) fn has(&self, burst: u64) -> bool {
        // Most bursts are not queued, and the count says so without a search.
        self.counts[Self::place(burst)] > 0 && self.bursts.contains(&burst)
    }

    pub(super) fn insert(&mut self, burst: u64) {
        self.counts[Self::place(burst)] += 1;
        self.bursts.push(burst);
    }

    pub(super) fn remove(&mut self, burst: u64) {
        if let Some(at) = self.bursts.iter().position(|w| *w == burst) {
            self.bursts.swap_remove(at);
            self.counts[Self::place(burst)] -= 1;
        }
    }
}
