//! Banks and ports of a buffer: how long its accesses take.
//!
//! Rule: a bank serves one access of one word per cycle, or one read and one write with two ports.
//! Streams (records, rows of keys, features, pixels) are interleaved over the banks word by word,
//! so they take `ceil(accesses / banks)` cycles, and a unit that needs fewer stalls for the rest.
//! A QSU writes keys to the part that their value selects, so these accesses hit random banks: of
//! `a` accesses in a cycle, `b` banks serve `b (1 - (1 - 1/b)^a)` on average (A39).

use crate::kernel::divide::Divisor;
use crate::kernel::spec::{BufferSpec, Ports};

/// The banks of a buffer, as one unit or core sees its share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Banks {
    banks: Divisor,
    word: Divisor,
    two_ports: bool,
}

impl Banks {
    /// The banks of a buffer.
    pub fn new(spec: &BufferSpec) -> Self {
        Self {
            banks: Divisor::new(u64::from(spec.banks)),
            word: Divisor::new(spec.word.0.max(1)),
            two_ports: spec.ports == Ports::ReadAndWrite,
        }
    }

    /// Words of `records` records of `bytes` each; every record begins at a new word.
    pub fn words_of_records(&self, records: u64, bytes: u64) -> u64 {
        records * self.word.div_ceil(bytes)
    }

    /// Words of `bytes` contiguous bytes.
    #[inline]
    pub fn words(&self, bytes: u64) -> u64 {
        self.word.div_ceil(bytes)
    }

    /// Bytes of one word.
    pub fn word(&self) -> u64 {
        self.word.get()
    }

    /// Cycles that `reads` and `writes` words take beyond `cycles`.
    #[inline]
    pub fn excess(&self, reads: u64, writes: u64, cycles: u64) -> u64 {
        let accesses = if self.two_ports { reads.max(writes) } else { reads + writes };
        self.banks.div_ceil(accesses).saturating_sub(cycles)
    }

    /// Cycles beyond `cycles` when `keys` keys of `bytes` are read as a stream and written to
    /// random banks, each word once.
    pub fn excess_of_dealing(&self, keys: u64, bytes: u64, cycles: u64) -> u64 {
        let words = self.words(keys * bytes);
        let each_way = words as f64 / cycles.max(1) as f64;
        let asked = if self.two_ports { each_way } else { 2.0 * each_way };
        let banks = self.banks.get() as f64;
        let served = banks * (1.0 - (1.0 - banks.recip()).powf(asked));
        if served >= asked || asked == 0.0 {
            return self.excess(words, words, cycles);
        }
        let stretched = (cycles as f64 * (asked / served)).ceil() as u64;
        stretched.saturating_sub(cycles).max(self.excess(words, words, cycles))
    }
}
