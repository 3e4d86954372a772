//! Room in a buffer, and what passed through it.
//!
//! Rule of every buffer: an item enters when it fits beside what is there, or when the buffer is
//! empty. The second half means that an item larger than its buffer streams through it alone; what
//! it costs to be that large is said by the unit (a list that does not fit spills to DRAM). Buffers
//! of a machine are divided evenly among the units or cores that use them.

use super::BufferUse;
use crate::action::Buffer;

/// The room of one unit or core in one buffer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Room {
    capacity: u64,
    used: u64,
    peak: u64,
    filled: u64,
    discarded: u64,
    byte_cycles: u128,
    since: u64,
}

impl Room {
    /// An empty buffer of `capacity` bytes.
    pub fn new(capacity: u64) -> Self {
        let (used, peak, filled, discarded) = (0, 0, 0, 0);
        Self { capacity, used, peak, filled, discarded, byte_cycles: 0, since: 0 }
    }

    /// Bytes that it holds.
    pub fn used(&self) -> u64 {
        self.used
    }

    /// Whether `bytes` may enter now.
    pub fn admits(&self, bytes: u64) -> bool {
        self.used == 0 || self.used.saturating_add(bytes) <= self.capacity
    }

    /// Takes room in cycle `now`.
    pub fn fill(&mut self, now: u64, bytes: u64) {
        self.pass(now);
        self.used += bytes;
        self.filled += bytes;
        self.peak = self.peak.max(self.used);
    }

    /// Gives room back in cycle `now`: the bytes have been used.
    pub fn release(&mut self, now: u64, bytes: u64) {
        assert!(self.used >= bytes, "a buffer gives back what it took: {} < {bytes}", self.used);
        self.pass(now);
        self.used -= bytes;
    }

    /// Gives room back in cycle `now`: nobody needed the bytes.
    pub fn discard(&mut self, now: u64, bytes: u64) {
        self.release(now, bytes);
        self.discarded += bytes;
    }

    fn pass(&mut self, now: u64) {
        self.byte_cycles += u128::from(self.used) * u128::from(now - self.since);
        self.since = now;
    }
}

/// Adds up the shares of a buffer.
pub fn usage<'a>(buffer: Buffer, shares: impl Iterator<Item = &'a Room>) -> BufferUse {
    let mut sum = BufferUse {
        buffer,
        capacity: 0,
        peak: 0,
        byte_cycles: 0,
        filled: 0,
        consumed: 0,
        discarded: 0,
    };
    for room in shares {
        sum.capacity += room.capacity;
        sum.peak += room.peak;
        sum.byte_cycles += room.byte_cycles;
        sum.filled += room.filled;
        sum.consumed += room.filled - room.discarded - room.used;
        sum.discarded += room.discarded;
    }
    sum
}
