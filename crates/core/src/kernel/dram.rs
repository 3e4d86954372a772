//! External memory, model `bandwidth`: one server, first come first served.
//!
//! Timing rule: requests queue in the order in which they are issued; those of one cycle in the
//! order of units or cores. A request of b bytes holds the data bus for `b / (bandwidth
//! efficiency)`, and starts when it was issued or when the bus is free, whichever is later. A read
//! is there `latency` after its last byte left the bus; a write has left the chip when the bus is
//! done with it. The bus counts in ticks of 1/1024 cycle and rounds every request up to whole
//! ticks, so it never exceeds its rate; units see the first whole cycle at which a request is done.
//! Requests of zero bytes never reach the DRAM ([`memory`](super::memory)). Other masters take
//! their shares of the bus all the time: the rest is the rate of the accelerator.

use crate::kernel::spec::DramSpec;
use crate::kernel::stream::{StreamId, Streams};
use powergs_base::quantity::{BytesPerSecond, Hertz};

/// Ticks of the data bus per cycle.
pub const TICKS: u64 = 1024;

/// Fractional bits of the ticks per byte.
const FRACTION: u32 = 32;

/// How long requests of a stream take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Service {
    /// Ticks per byte, with 32 fractional bits.
    rate: u128,
    /// Ticks for which every request holds the bus besides its bytes.
    fixed: u64,
    /// Ticks from the last byte on the bus until the request is done.
    latency: u64,
    /// Further ticks behind a queue of `full` ticks, and in proportion behind a shorter one.
    loaded: u64,
    full: u64,
}

impl Service {
    fn new(ticks_per_byte: f64, latency_ticks: f64) -> Service {
        Service {
            rate: (ticks_per_byte * f64::from(FRACTION).exp2()).round() as u128,
            fixed: 0,
            latency: latency_ticks.round() as u64,
            loaded: 0,
            full: 1,
        }
    }
}

/// What a stream takes, in cycles.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct StreamCost {
    /// For every byte on the bus.
    pub(super) byte: f64,
    /// For every request on the bus, besides its bytes.
    pub(super) request: f64,
    /// From the last byte on the bus until the request is done, in an idle memory.
    pub(super) latency: f64,
    /// What that is longer behind a queue of `full` cycles or more.
    pub(super) loaded: f64,
    pub(super) full: f64,
}

/// The memory: how long a request takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dram {
    streams: [Service; Streams::MOST],
}

impl Dram {
    /// The memory of `spec` with this peak rate, seen from a clock by these streams.
    pub fn new(spec: &DramSpec, peak: BytesPerSecond, clock: Hertz, streams: &Streams) -> Self {
        let ticks_per_second = clock.0 * TICKS as f64;
        let left = 1.0 - spec.share(peak.0);
        let per_byte = ticks_per_second / (peak.0 * spec.efficiency * left);
        let latency = spec.latency.0 * 1e-9 * ticks_per_second;
        let mut all = [Service::new(per_byte, latency); Streams::MOST];
        for stream in streams.all().filter(|stream| streams.is_write(*stream)) {
            all[stream.index()].latency = 0;
        }
        Self { streams: all }
    }

    /// A memory whose streams cost this.
    pub(super) fn of_streams(costs: [StreamCost; Streams::MOST]) -> Self {
        let ticks = |cycles: f64| cycles * TICKS as f64;
        let service = |cost: StreamCost| Service {
            fixed: ticks(cost.request).round() as u64,
            loaded: ticks(cost.loaded).round() as u64,
            full: (ticks(cost.full).round() as u64).max(1),
            ..Service::new(ticks(cost.byte), ticks(cost.latency))
        };
        Self { streams: costs.map(service) }
    }

    /// Ticks from the last byte of a request on the bus until it is done, behind a queue of so many
    /// ticks.
    #[inline]
    pub fn latency(&self, stream: StreamId, queue: u64) -> u64 {
        let s = &self.streams[stream.index()];
        if s.loaded == 0 {
            return s.latency;
        }
        s.latency + s.loaded * queue.min(s.full) / s.full
    }

    /// Ticks for which `bytes` of a stream hold the bus, at least 1.
    #[inline]
    pub fn service(&self, stream: StreamId, bytes: u64) -> u64 {
        let (bytes, rate) = (u128::from(bytes), self.streams[stream.index()].rate);
        let ticks = match u64::try_from(rate) {
            Ok(rate) => bytes * u128::from(rate),
            Err(_) => bytes.saturating_mul(rate),
        };
        let ticks = ticks.div_ceil(1 << FRACTION);
        let ticks = u64::try_from(ticks).unwrap_or(u64::MAX).max(1);
        ticks.saturating_add(self.streams[stream.index()].fixed)
    }
}

/// State of the memory: when its bus is free, and the bytes served so far.
#[derive(Debug, Clone)]
pub struct Channel {
    dram: Dram,
    free: u64,
    busy: u64,
    served: u64,
    bytes: [u64; Streams::MOST],
}

impl Channel {
    /// An idle channel.
    pub fn new(dram: Dram) -> Self {
        Self { dram, free: 0, busy: 0, served: 0, bytes: [0; Streams::MOST] }
    }

    /// Takes a request in cycle `now`; returns the cycle in which a read is there, or in which the
    /// last byte of a write has left.
    #[inline]
    pub fn serve(&mut self, now: u64, stream: StreamId, bytes: u64) -> u64 {
        let service = self.dram.service(stream, bytes);
        let now = now.saturating_mul(TICKS);
        let latency = self.dram.latency(stream, self.free.saturating_sub(now));
        self.free = now.max(self.free).saturating_add(service);
        self.busy = self.busy.saturating_add(service);
        self.served += 1;
        self.bytes[stream.index()] += bytes;
        self.free.saturating_add(latency).div_ceil(TICKS)
    }

    /// Requests served so far.
    pub fn served(&self) -> u64 {
        self.served
    }

    /// Bytes of each stream so far.
    pub fn bytes(&self) -> [u64; Streams::MOST] {
        self.bytes
    }

    /// Cycles for which the bus was held so far, rounded up.
    pub fn busy_cycles(&self) -> u64 {
        self.busy.div_ceil(TICKS)
    }

    /// The time at which the bus is free, in cycles.
    pub(super) fn free_cycles(&self) -> f64 {
        self.free as f64 / TICKS as f64
    }
}
