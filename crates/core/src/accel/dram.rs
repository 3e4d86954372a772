//! External memory, model `bandwidth`: one server, first come first served.
//!
//! Timing rule: requests queue in the order in which they are issued; those of one cycle in the
//! order of units or cores. A request of b bytes holds the data bus for `b / (bandwidth
//! efficiency)`, and starts when it was issued or when the bus is free, whichever is later. A read
//! is there `latency` after its last byte left the bus; a write has left the chip when the bus is
//! done with it. The bus counts in ticks of 1/1024 cycle and rounds every request up to whole
//! ticks, so it never exceeds its rate; units see the first whole cycle at which a request is done.
//! Requests of zero bytes never reach the DRAM ([`memory`](super::memory)). A second master takes
//! its share of the bus all the time: the rest is the rate of the accelerator.

use super::DramUse;
use super::machine::DramSpec;
use powergs_base::quantity::{BytesPerSecond, Hertz};

/// Ticks of the data bus per cycle.
pub const TICKS: u64 = 1024;

/// Fractional bits of the ticks per byte.
const FRACTION: u32 = 32;

/// The memory: how long a request takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dram {
    /// Ticks per byte, with 32 fractional bits.
    rate: u128,
    /// Ticks from the last byte on the bus to the unit.
    pub latency: u64,
}

impl Dram {
    /// The memory of `spec` with this peak rate, seen from a clock.
    pub fn new(spec: &DramSpec, peak: BytesPerSecond, clock: Hertz) -> Self {
        let ticks_per_second = clock.0 * TICKS as f64;
        let left = 1.0 - spec.second_master.share(peak.0);
        let per_byte = ticks_per_second / (peak.0 * spec.efficiency * left);
        Self {
            rate: (per_byte * f64::from(FRACTION).exp2()).round() as u128,
            latency: (spec.latency.0 * 1e-9 * ticks_per_second).round() as u64,
        }
    }

    /// Ticks for which `bytes` hold the bus, at least 1.
    #[inline]
    pub fn service(&self, bytes: u64) -> u64 {
        let bytes = u128::from(bytes);
        let ticks = match u64::try_from(self.rate) {
            Ok(rate) => bytes * u128::from(rate),
            Err(_) => bytes.saturating_mul(self.rate),
        };
        let ticks = ticks.div_ceil(1 << FRACTION);
        u64::try_from(ticks).unwrap_or(u64::MAX).max(1)
    }
}

/// State of the memory: when its bus is free, and the bytes served so far.
#[derive(Debug, Clone)]
pub struct Channel {
    dram: Dram,
    free: u64,
    busy: u64,
    served: u64,
}

impl Channel {
    /// An idle channel.
    pub fn new(dram: Dram) -> Self {
        Self { dram, free: 0, busy: 0, served: 0 }
    }

    /// Takes a request in cycle `now`; returns the cycle in which a read is there, or in which the
    /// last byte of a write has left.
    #[inline]
    pub fn serve(&mut self, now: u64, write: bool, bytes: u64) -> u64 {
        let service = self.dram.service(bytes);
        self.free = now.saturating_mul(TICKS).max(self.free).saturating_add(service);
        self.busy = self.busy.saturating_add(service);
        self.served += 1;
        let latency = if write { 0 } else { self.dram.latency };
        self.free.saturating_add(latency).div_ceil(TICKS)
    }

    /// Activity of the memory so far, without bytes.
    pub fn usage(&self) -> DramUse {
        DramUse {
            requests_issued: self.served,
            requests_served: self.served,
            busy_cycles: self.busy.div_ceil(TICKS),
            ..DramUse::default()
        }
    }
}
