//! Waiting bursts of one channel: entries in lists by bank and direction, each in order of age.

/// No entry.
pub(super) const NONE: u16 = u16::MAX;

/// No row.
pub(super) const CLOSED: u32 = u32::MAX;

/// A burst that waits for its read or write command.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry {
    /// Number of the burst in the device: its address over the bytes of a burst.
    pub burst: u64,
    /// Order of acceptance in the channel.
    pub age: u64,
    /// The CK of its acceptance.
    pub accepted: u64,
    /// Request that it belongs to.
    pub slot: u32,
    pub row: u32,
    pub bank: u8,
    pub class: u8,
    pub write: bool,
    /// Whether a command was issued for it.
    pub tried: bool,
    next: u16,
    prev: u16,
}

impl Entry {
    pub(super) fn new(burst: u64, slot: u32, bank: u8, row: u32, write: bool, class: u8) -> Self {
        let (age, accepted, tried, next, prev) = (0, 0, false, NONE, NONE);
        Self { burst, age, accepted, slot, row, bank, class, write, tried, next, prev }
    }
}

/// Entries of one bank and direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct List {
    pub head: u16,
    tail: u16,
    /// The oldest entry for the open row.
    pub hit: u16,
    /// The oldest entry for another row; of all if no row is open.
    pub miss: u16,
}

impl List {
    pub(super) const EMPTY: List = List { head: NONE, tail: NONE, hit: NONE, miss: NONE };
}

/// All entries of a channel.
#[derive(Debug, Clone)]
pub(super) struct Entries {
    entries: Vec<Entry>,
    free: Vec<u16>,
    next_age: u64,
}

impl Entries {
    /// Room for `capacity` entries.
    pub(super) fn new(capacity: usize) -> Self {
        let empty = Entry::new(0, 0, 0, 0, false, 0);
        let free = (0..capacity as u16).rev().collect();
        Self { entries: vec![empty; capacity], free, next_age: 0 }
    }

    pub(super) fn get(&self, index: u16) -> &Entry {
        &self.entries[usize::from(index)]
    }

    pub(super) fn get_mut(&mut self, index: u16) -> &mut Entry {
        &mut self.entries[usize::from(index)]
    }

    /// Appends an entry to a list of a bank whose open row is `open`; returns its index.
    pub(super) fn push(&mut self, mut entry: Entry, now: u64, list: &mut List, open: u32) -> u16 {
        let index = self.free.pop().expect("queues and banks have an entry each");
        entry.age = self.next_age;
        entry.accepted = now;
        entry.prev = list.tail;
        self.next_age += 1;
        if list.tail == NONE {
            list.head = index;
        } else {
            self.get_mut(list.tail).next = index;
        }
        list.tail = index;
        let first = if entry.row == open { &mut list.hit } else { &mut list.miss };
        if *first == NONE {
            *first = index;
        }
        self.entries[usize::from(index)] = entry;
        index
    }

    /// Takes an entry out of its list; it stays valid until [`Entries::release`].
    pub(super) fn unlink(&mut self, index: u16, list: &mut List, open: u32) {
        let Entry { next, prev, .. } = *self.get(index);
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

    /// Another row was opened or closed.
    pub(super) fn row_changed(&self, list: &mut List, open: u32) {
        if list.head == NONE {
            return;
        }
        list.hit = if open == CLOSED { NONE } else { self.find(list.head, |row| row == open) };
        list.miss = self.find(list.head, |row| row != open);
    }

    fn find(&self, from: u16, is: impl Fn(u32) -> bool) -> u16 {
        let mut at = from;
        while at != NONE && !is(self.get(at).row) {
            at = self.get(at).next;
        }
        at
    }
}
