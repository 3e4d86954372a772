//! Other users of the memory, each of which takes a given rate and pattern (A18).
//!
//! One asks for requests of one size at equal distances in time, from the start of the frame on.
//! `stream` goes through a region of its own from front to back, again and again; `random` jumps in
//! it, in an order that is the same in every frame. A request that finds `in-flight` others under
//! way waits until the oldest of them is done, and the requests that fell due meanwhile follow at
//! once. With the `banked` model the requests take their places among those of the accelerator by
//! arrival, or by `priority` and `guaranteed`; the `bandwidth` model takes their share off its
//! rate.

use crate::kernel::spec::{AccessOrder, DramSpec, MasterSpec, Priority};
use powergs_base::quantity::BytesPerSecond;
use powergs_dram::{AddressRange, Banked, Device, Rank, Request};
use std::collections::VecDeque;

/// Bytes of the region of one.
const REGION: u64 = 1 << 26;

/// Bytes that a lone request moves at least: a burst of the LPDDR memories.
const BURST: u64 = 32;

/// The others that a memory may have, by the first word of their tables: `dram.second-master`.
pub const MASTERS: [&str; 3] = ["second", "third", "fourth"];

impl DramSpec {
    /// The other users that there may be, in the order of [`MASTERS`].
    pub fn masters(&self) -> [&MasterSpec; MASTERS.len()] {
        [&self.second_master, &self.third_master, &self.fourth_master]
    }

    /// Whether the accelerator has the memory for itself.
    pub fn is_alone(&self) -> bool {
        !self.masters().iter().any(|master| master.is_on())
    }

    /// Share of a memory of this peak rate (bytes per second) that the others take from the
    /// accelerator in the `bandwidth` model. What waits for all others takes nothing.
    pub fn share(&self, peak: f64) -> f64 {
        let before = self.masters().into_iter().filter(|m| m.priority != Priority::Last);
        before.map(|master| master.share(peak)).sum()
    }
}

impl MasterSpec {
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

    /// The most that its requests get of a device which nobody else uses, bytes per second: what
    /// its pattern, the size of its requests and their number under way allow.
    pub fn ceiling(&self, device: &Device) -> f64 {
        let ck = device.clock_period.0 * 1e-9;
        // Alone there is nobody to go before or after.
        let due = MasterSpec {
            rate: BytesPerSecond(self.request.0 as f64 / ck),
            priority: Priority::Equal,
            guaranteed: BytesPerSecond(0.0),
            ..self.clone()
        };
        let mut masters = Masters::of(&[&due], 0, (ck * 1e15).round() as u64);
        let mut memory = Banked::new(device).in_time();
        let (mut served, mut end) = (0, 1);
        while served < REQUESTS.min((BYTES / self.request.0).max(FEWEST)) {
            let arrival = masters.next_arrival();
            let mut pieces = |ticket| masters.piece(ticket);
            match memory.advance(arrival, &mut pieces) {
                Some((at, ticket)) => {
                    masters.done(ticket, at);
                    (served, end) = (served + 1, end.max(at));
                }
                None => memory.push(masters.take(0)),
            }
        }
        served as f64 * self.request.0 as f64 / (end as f64 * ck)
    }
}

/// How long a master is asked for its ceiling: this number of requests, fewer where they have more
/// than this number of bytes together, but some.
const REQUESTS: u64 = 4096;
const BYTES: u64 = 1 << 19;
const FEWEST: u64 = 64;

/// Number of what is guaranteed to the first of them, behind what is not of all.
const FURTHER: usize = MASTERS.len();

/// Marks tickets of other masters: the other bits are the number of the master and that of its
/// request.
const TICKETS: u32 = 1 << 31;
const NUMBER: u32 = 28;

/// Whether a ticket of a device is that of another master.
pub(super) fn is_others(ticket: u32) -> bool {
    ticket & TICKETS != 0
}

/// The requests of all others in one frame.
#[derive(Debug)]
pub(super) struct Masters {
    all: Vec<Master>,
}

impl Masters {
    /// Those of a machine, on regions that begin at or after `base`; `None` where there are none.
    pub(super) fn new(spec: &DramSpec, base: u64, ck_fs: u64) -> Option<Masters> {
        (!spec.is_alone()).then(|| Masters::of(&spec.masters(), base, ck_fs))
    }

    fn of(specs: &[&MasterSpec], base: u64, ck_fs: u64) -> Masters {
        let first = base.next_multiple_of(REGION);
        let on = specs.iter().enumerate().filter(|(_, spec)| spec.is_on());
        let all = on.flat_map(|(place, spec)| {
            let rank = match spec.priority {
                Priority::First => Rank::First,
                Priority::Equal => Rank::InTurn,
                Priority::Last => Rank::Last,
            };
            // What is guaranteed does not wait behind the rest: it has requests of its own.
            let guaranteed = spec.guaranteed.0 / spec.rate.0;
            let parts =
                [(place, rank, 1.0 - guaranteed), (FURTHER + place, Rank::First, guaranteed)];
            let parts = parts.into_iter().filter(|(.., share)| *share > 0.0);
            parts.map(move |(number, rank, share)| {
                let period = spec.request.0 as f64 / (spec.rate.0 * share) * 1e15;
                Master {
                    spec: (*spec).clone(),
                    number,
                    class: place as u8,
                    rank,
                    most: ((f64::from(spec.in_flight) * share).round() as u64).max(1),
                    base: first + number as u64 * REGION,
                    period_fs: (period.round() as u128).max(1),
                    ck_fs: u128::from(ck_fs),
                    next: 0,
                    under_way: VecDeque::new(),
                    first: 0,
                }
            })
        });
        Masters { all: all.collect() }
    }

    /// The CK in which the next request arrives; `u64::MAX` while all wait for completions that are
    /// not known.
    pub(super) fn next_arrival(&self) -> u64 {
        self.all.iter().map(Master::next_arrival).min().unwrap_or(u64::MAX)
    }

    /// The next request, of the classes that begin with this one.
    ///
    /// # Panics
    /// When none has arrived.
    pub(super) fn take(&mut self, class: u8) -> Request {
        let next = self.all.iter_mut().min_by_key(|master| master.next_arrival());
        next.expect("a master").take(class)
    }

    /// Says when a request is done.
    pub(super) fn done(&mut self, ticket: u32, ck: u64) {
        let (master, number) = self.of_ticket(ticket);
        if let Some(request) = master.request(number) {
            request.done = Some(ck);
        }
    }

    /// The bytes that a request touches, once.
    pub(super) fn piece(&mut self, ticket: u32) -> Option<AddressRange> {
        let (master, number) = self.of_ticket(ticket);
        let piece = master.piece(number);
        let request = master.request(number)?;
        (!std::mem::replace(&mut request.is_given, true)).then_some(piece)
    }

    fn of_ticket(&mut self, ticket: u32) -> (&mut Master, u64) {
        let number = ((ticket & !TICKETS) >> NUMBER) as usize;
        let master = self.all.iter_mut().find(|master| master.number == number);
        (master.expect("a ticket of a master"), u64::from(ticket & ((1 << NUMBER) - 1)))
    }
}

/// A request under way.
#[derive(Debug, Clone, Copy, Default)]
struct UnderWay {
    /// The CK of its completion, once known.
    done: Option<u64>,
    /// Whether its bytes were handed over.
    is_given: bool,
}

/// The requests of one master that enter the memory alike, one after the other.
#[derive(Debug)]
struct Master {
    spec: MasterSpec,
    /// Its place among [`MASTERS`]; [`FURTHER`] more for what is guaranteed to it.
    number: usize,
    /// Its class, from the first on.
    class: u8,
    rank: Rank,
    /// Requests that may be under way.
    most: u64,
    /// First byte of its region.
    base: u64,
    /// Femtoseconds between two requests, and of one CK.
    period_fs: u128,
    ck_fs: u128,
    /// Number of the next request.
    next: u64,
    under_way: VecDeque<UnderWay>,
    /// Number of the first request under way.
    first: u64,
}

impl Master {
    fn next_arrival(&self) -> u64 {
        let due = u128::from(self.next) * self.period_fs / self.ck_fs;
        let due = u64::try_from(due).unwrap_or(u64::MAX);
        if (self.under_way.len() as u64) < self.most {
            return due;
        }
        match self.under_way.front() {
            Some(UnderWay { done: Some(done), .. }) => due.max(*done),
            Some(UnderWay { done: None, .. }) => u64::MAX,
            None => due,
        }
    }

    fn take(&mut self, class: u8) -> Request {
        let (number, arrival) = (self.next, self.next_arrival());
        if self.under_way.len() as u64 >= self.most {
            self.under_way.pop_front();
            self.first += 1;
        }
        self.under_way.push_back(UnderWay::default());
        self.next += 1;
        let reads_before = |n: u64| (n as f64 * self.spec.reads).floor();
        let read = reads_before(number + 1) > reads_before(number);
        let request = u32::try_from(number).ok().filter(|number| number >> NUMBER == 0);
        let request = request.expect("fewer than 2^28 requests of a master in a frame");
        Request {
            ticket: TICKETS | (self.number as u32) << NUMBER | request,
            write: !read,
            class: class + self.class,
            arrival,
            rank: self.rank,
        }
    }

    fn request(&mut self, number: u64) -> Option<&mut UnderWay> {
        self.under_way.get_mut(number.checked_sub(self.first)? as usize)
    }

    /// Its region's bytes that a request touches.
    fn piece(&self, number: u64) -> AddressRange {
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
