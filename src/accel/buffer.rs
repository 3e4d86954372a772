//! Room in an on-chip buffer.
//!
//! Rule of every buffer: an item enters when it fits beside what is there, or when the buffer is
//! empty. The second half means that an item larger than its buffer streams through it alone; what
//! it costs to be that large is said by the unit (a list that does not fit spills to DRAM). Buffers
//! of a machine are divided evenly among the units or cores that use them.

/// The room of one unit or core in one buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Room {
    capacity: u64,
    used: u64,
}

impl Room {
    /// An empty buffer of `capacity` bytes.
    pub fn new(capacity: u64) -> Self {
        Self { capacity, used: 0 }
    }

    /// Whether `bytes` may enter now.
    pub fn admits(&self, bytes: u64) -> bool {
        self.used == 0 || self.used.saturating_add(bytes) <= self.capacity
    }

    /// Takes room.
    pub fn fill(&mut self, bytes: u64) {
        self.used += bytes;
    }

    /// Gives room back.
    pub fn release(&mut self, bytes: u64) {
        assert!(self.used >= bytes, "a buffer gives back what it took: {} < {bytes}", self.used);
        self.used -= bytes;
    }

    /// Bytes that are taken.
    pub fn used(&self) -> u64 {
        self.used
    }
}
