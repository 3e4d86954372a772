//! Driving a memory with a stream of addresses, as the reference simulators were driven.
//!
//! | mode | requests arrive | limit |
//! |---|---|---|
//! | `sat` | at once | the window of the device |
//! | `mlpN` | at once | N read requests in flight |
//! | `idle` | at once | one read in flight, the first 8192 requests |
//! | `lookN` | at once | a window of N x 64 B |
//! | `rateN` | at N GB/s of requested bytes | the window of the device |
//!
//! Time is the CK in which the last read had its data or the last write its command, times the
//! period. The latency of a read counts from its first burst in the front end, in `rateN` from its
//! arrival. Source: `ramulator` runs; `docs/dram.md`.

use std::fmt;
use std::str::FromStr;

use super::banked::{AddressRange, Banked, LatencyFrom, Rank, Request};
use super::device::Device;
use super::stats::Stats;

use powergs_base::quantity::Bytes;

/// Requests of a run in mode `idle`.
pub(crate) const IDLE_REQUESTS: usize = 8192;

/// Requests that are handed to the memory before the first of them completed.
const AHEAD: usize = 4096;

/// How requests are offered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mode {
    /// As fast as they are accepted.
    Saturated,
    /// With at most this many reads in flight.
    Parallel(u32),
    /// One after the other.
    Idle,
    /// With a window of this many 64-byte blocks.
    Look(u32),
    /// At this many GB/s.
    Rate(f64),
}

impl FromStr for Mode {
    type Err = String;

    fn from_str(text: &str) -> Result<Mode, String> {
        let count = |digits: &str, most: u32| {
            let n: Option<u32> = digits.parse().ok();
            n.filter(|n| (1..=most).contains(n))
        };
        let found = match text {
            "sat" => Some(Mode::Saturated),
            "idle" => Some(Mode::Idle),
            _ => None,
        };
        let mlp = || Some(Mode::Parallel(count(text.strip_prefix("mlp")?, 1 << 20)?));
        let look = || Some(Mode::Look(count(text.strip_prefix("look")?, 1 << 18)?));
        let rate = || {
            let rate: f64 = text.strip_prefix("rate")?.parse().ok()?;
            (0.001..=1e6).contains(&rate).then_some(Mode::Rate(rate))
        };
        found.or_else(mlp).or_else(look).or_else(rate).ok_or_else(|| {
            "write sat, idle, mlp32 (reads in flight), look16 (window in 64-byte blocks) or rate20 \
             (GB/s)"
                .to_owned()
        })
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Mode::Saturated => write!(f, "sat"),
            Mode::Parallel(n) => write!(f, "mlp{n}"),
            Mode::Idle => write!(f, "idle"),
            Mode::Look(n) => write!(f, "look{n}"),
            Mode::Rate(n) => write!(f, "rate{n}"),
        }
    }
}

/// One request of an address trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Access {
    /// Whether it writes.
    pub write: bool,
    /// First byte.
    pub address: u64,
    /// Bytes.
    pub bytes: u32,
}

impl Access {
    /// Its addresses.
    pub fn range(&self) -> AddressRange {
        AddressRange { address: self.address, bytes: self.bytes.into() }
    }
}

/// The result of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// CK until the last completion.
    pub cycles: u64,
    /// Activity of the memory.
    pub stats: Stats,
}

/// The device as a mode uses it.
pub(crate) fn device_for(device: &Device, mode: Mode) -> Device {
    let mut device = device.clone();
    match mode {
        Mode::Parallel(n) => device.front_end.reads_in_flight = n,
        Mode::Idle => device.front_end.reads_in_flight = 1,
        Mode::Look(n) => {
            let blocks = Bytes(u64::from(n) * 64);
            device.front_end.window = blocks.max(device.organisation.burst);
        }
        Mode::Saturated | Mode::Rate(_) => {}
    }
    device
}

/// A run of level `banked` that takes its requests one by one.
#[derive(Debug)]
pub struct Drive {
    memory: Banked,
    mode: Mode,
    /// CK per requested byte, in `rateN`.
    per_byte: f64,
    /// Requests that were taken, by ticket modulo their number: the pieces that are left.
    waiting: Vec<Option<Access>>,
    taken: usize,
    completed: usize,
    bytes: u64,
    end: u64,
}

impl Drive {
    /// An idle memory in a mode.
    pub fn new(device: &Device, mode: Mode) -> Drive {
        let from = match mode {
            Mode::Rate(_) => LatencyFrom::Arrival,
            Mode::Saturated | Mode::Parallel(_) | Mode::Idle | Mode::Look(_) => LatencyFrom::Entry,
        };
        Drive {
            memory: Banked::new(&device_for(device, mode)).with_latency_from(from),
            mode,
            per_byte: per_byte(device, mode),
            waiting: vec![None; AHEAD],
            taken: 0,
            completed: 0,
            bytes: 0,
            end: 0,
        }
    }

    /// The same, keeping every command for [`Banked::log`].
    #[must_use]
    pub fn with_log(mut self) -> Drive {
        self.memory = self.memory.with_log();
        self
    }

    /// Whether the mode takes no more requests.
    pub fn is_full(&self) -> bool {
        self.mode == Mode::Idle && self.taken >= IDLE_REQUESTS
    }

    /// Takes the next request of the stream; simulates until there is room for it.
    pub fn take(&mut self, access: Access) {
        // A ticket is a place in `waiting`, and the place must be free before it is used again.
        while self.taken - self.completed >= AHEAD || self.waiting[self.taken % AHEAD].is_some() {
            self.complete_one();
        }
        let ticket = (self.taken % AHEAD) as u32;
        self.waiting[ticket as usize] = Some(access);
        let arrival = (self.bytes as f64 * self.per_byte).ceil() as u64;
        let (write, rank) = (access.write, Rank::InTurn);
        self.memory.push(Request { ticket, write, class: 0, arrival, rank });
        self.bytes += u64::from(access.bytes);
        self.taken += 1;
    }

    fn complete_one(&mut self) -> bool {
        let waiting = &mut self.waiting;
        let mut pieces = |ticket: u32| {
            let access = waiting[ticket as usize].take()?;
            Some(access.range())
        };
        let Some((time, _)) = self.memory.advance(u64::MAX, &mut pieces) else { return false };
        self.end = self.end.max(time);
        self.completed += 1;
        true
    }

    /// Completes all requests; returns time and activity of the run, and the memory with its log.
    pub fn finish(mut self) -> (Run, Banked) {
        while self.complete_one() {}
        (Run { cycles: self.end, stats: self.memory.stats() }, self.memory)
    }
}

/// Runs a stream at level `banked`.
pub fn banked(device: &Device, mode: Mode, stream: impl IntoIterator<Item = Access>) -> Run {
    let mut drive = Drive::new(device, mode);
    for access in stream {
        if drive.is_full() {
            break;
        }
        drive.take(access);
    }
    drive.finish().0
}

fn per_byte(device: &Device, mode: Mode) -> f64 {
    match mode {
        Mode::Rate(rate) => 1.0 / (rate * device.clock_period.0),
        Mode::Saturated | Mode::Parallel(_) | Mode::Idle | Mode::Look(_) => 0.0,
    }
}
