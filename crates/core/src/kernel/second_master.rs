//! A second master: another user of the memory that takes a given rate and pattern (A18).
//!
//! It asks for requests of one size at equal distances in time, from the start of the frame on.
//! `stream` goes through a region of its own from front to back, again and again; `random` jumps in
//! it, in an order that is the same in every frame. A request that finds `in-flight` others under
//! way waits until the oldest of them is done, and the requests that fell due meanwhile follow at
//! once. With the `banked` model the requests take their places among those of the accelerator by
//! arrival; the `bandwidth` model takes their share off its rate.

use crate::kernel::spec::{AccessOrder, SecondMasterSpec};
use powergs_dram::AddressRange;
use std::collections::VecDeque;

/// Bytes of its region.
const REGION: u64 = 1 << 26;

/// Bytes that a lone request moves at least: a burst of the LPDDR memories.
const BURST: u64 = 32;

impl SecondMasterSpec {
    /// Whether there is one.
    pub fn is_on(&self) -> bool {
        self.rate.0 > 0.0
    }

    /// Share of a memory of this peak rate (bytes per second) that it takes in the `bandwidth`
    /// model: the time of its transfers at its own efficiency. Random requests move whole bursts.
    pub fn share(&self, peak: f64) -> f64 {
        if !self.is_on() {
            return 0.0;
        }
        let moved = match self.pattern {
            AccessOrder::Stream => 1.0,
            AccessOrder::Random => {
                let bytes = self.request.0.max(1);
                bytes.next_multiple_of(BURST) as f64 / bytes as f64
            }
        };
        self.rate.0 * moved / (peak * self.efficiency)
    }
}

/// A request of the second master.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct MasterRequest {
    /// The CK of its arrival.
    pub(super) arrival: u64,
    /// Whether it writes.
    pub(super) write: bool,
    /// Its bytes.
    pub(super) piece: AddressRange,
}

/// The requests of the second master in one frame, one after the other.
#[derive(Debug)]
pub(super) struct SecondMaster {
    spec: SecondMasterSpec,
    /// Requests that may be under way.
    most: u64,
    /// First byte of its region.
    base: u64,
    /// Femtoseconds between two requests, and of one CK.
    period_fs: u128,
    ck_fs: u128,
    /// Number of the next request.
    next: u64,
    /// Completions of those under way: `None` while one is not known.
    under_way: VecDeque<Option<u64>>,
    /// Number of the first request under way.
    first: u64,
}

impl SecondMaster {
    /// The second master of a machine, on a region that begins at or after `base`; `None` where
    /// there is none.
    pub(super) fn new(spec: &SecondMasterSpec, base: u64, ck_fs: u64) -> Option<SecondMaster> {
        let period = spec.request.0 as f64 / spec.rate.0 * 1e15;
        spec.is_on().then(|| SecondMaster {
            spec: spec.clone(),
            most: u64::from(spec.in_flight),
            base: base.next_multiple_of(REGION),
            period_fs: (period.round() as u128).max(1),
            ck_fs: u128::from(ck_fs),
            next: 0,
            under_way: VecDeque::new(),
            first: 0,
        })
    }

    /// The CK in which the next request arrives; `u64::MAX` while that waits for a completion that
    /// is not known.
    pub(super) fn next_arrival(&self) -> u64 {
        let due = u128::from(self.next) * self.period_fs / self.ck_fs;
        let due = u64::try_from(due).unwrap_or(u64::MAX);
        if (self.under_way.len() as u64) < self.most {
            return due;
        }
        match self.under_way.front() {
            Some(Some(done)) => due.max(*done),
            Some(None) => u64::MAX,
            None => due,
        }
    }

    /// The next request and its number.
    pub(super) fn take(&mut self) -> (u64, MasterRequest) {
        let (number, arrival) = (self.next, self.next_arrival());
        if self.under_way.len() as u64 >= self.most {
            self.under_way.pop_front();
            self.first += 1;
        }
        self.under_way.push_back(None);
        self.next += 1;
        let reads_before = |n: u64| (n as f64 * self.spec.reads).floor();
        let read = reads_before(number + 1) > reads_before(number);
        (number, MasterRequest { arrival, write: !read, piece: self.piece(number) })
    }

    /// Says when a request is done.
    pub(super) fn done(&mut self, number: u64, ck: u64) {
        if let Some(slot) = number.checked_sub(self.first)
            && let Some(slot) = self.under_way.get_mut(slot as usize)
        {
            *slot = Some(ck);
        }
    }

    /// Its region's bytes that a request touches.
    pub(super) fn piece(&self, number: u64) -> AddressRange {
        let bytes = self.spec.request.0;
        let places = (REGION / bytes).max(1);
        let place = match self.spec.pattern {
            AccessOrder::Stream => number % places,
            AccessOrder::Random => scrambled(number) % places,
        };
        AddressRange { address: self.base + place * bytes, bytes }
    }
}

/// A number that looks drawn: SplitMix64.
fn scrambled(n: u64) -> u64 {
    let mut z = n.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
