//! Buffer allocator: admits items to one share of an on-chip buffer and keeps its statistics.
//!
//! Rule of every buffer: an item is admitted when it fits in the free space, or when the buffer is
//! empty. By the second half of the rule an item larger than its buffer streams through it alone;
//! the unit charges what that costs (a list that does not fit spills to DRAM). Each buffer of a
//! machine is divided evenly among the units or cores that use it.

use crate::kernel::BufferUse;
use powergs_energy::action::BufferId;

/// Occupancy of the share of one buffer that one unit or core has to itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BufferAllocator {
    capacity: u64,
    used: u64,
    peak: u64,
    filled: u64,
    discarded: u64,
    byte_cycles: u128,
    since: u64,
}

impl BufferAllocator {
    /// An empty buffer of `capacity` bytes.
    pub fn new(capacity: u64) -> Self {
        let (used, peak, filled, discarded) = (0, 0, 0, 0);
        Self { capacity, used, peak, filled, discarded, byte_cycles: 0, since: 0 }
    }

    /// Bytes allocated.
    pub fn used(&self) -> u64 {
        self.used
    }

    /// Bytes that are free with `more` allocated; `None` where that is larger than the buffer.
    pub fn free_with(&self, more: u64) -> Option<u64> {
        self.capacity.checked_sub(self.used.checked_add(more)?)
    }

    /// Whether an item of `bytes` is admitted now.
    pub fn admits(&self, bytes: u64) -> bool {
        self.used == 0 || self.used.saturating_add(bytes) <= self.capacity
    }

    /// Allocates `bytes` in cycle `now`.
    pub fn fill(&mut self, now: u64, bytes: u64) {
        self.advance(now);
        self.used += bytes;
        self.filled += bytes;
        self.peak = self.peak.max(self.used);
    }

    /// Frees `bytes` in cycle `now`: their consumer has read them.
    ///
    /// # Panics
    /// When fewer bytes are allocated.
    pub fn release(&mut self, now: u64, bytes: u64) {
        assert!(self.used >= bytes, "more bytes freed than allocated: {} < {bytes}", self.used);
        self.advance(now);
        self.used -= bytes;
    }

    /// Frees `bytes` in cycle `now` that were fetched speculatively and not used.
    ///
    /// # Panics
    /// When fewer bytes are allocated.
    pub fn discard(&mut self, now: u64, bytes: u64) {
        self.release(now, bytes);
        self.discarded += bytes;
    }

    fn advance(&mut self, now: u64) {
        self.byte_cycles += u128::from(self.used) * u128::from(now - self.since);
        self.since = now;
    }
}

/// Sums the statistics of all shares of a buffer.
pub fn usage<'a>(buffer: BufferId, shares: impl Iterator<Item = &'a BufferAllocator>) -> BufferUse {
    let mut sum = BufferUse {
        buffer,
        capacity: 0,
        peak: 0,
        byte_cycles: 0,
        filled: 0,
        consumed: 0,
        discarded: 0,
    };
    for share in shares {
        sum.capacity += share.capacity;
        sum.peak += share.peak;
        sum.byte_cycles += share.byte_cycles;
        sum.filled += share.filled;
        sum.consumed += share.filled - share.discarded - share.used;
        sum.discarded += share.discarded;
    }
    sum
}
