//! The memory of the oracles: a queue, and a bus that moves 1024 ticks' worth in a cycle; or a
//! device that is asked in every cycle what is done.

use std::collections::{HashSet, VecDeque};

use powergs_core::kernel::dram::{Dram, TICKS};
use powergs_core::kernel::memory::Layout;
use powergs_core::kernel::stream::{StreamId, Streams};
use powergs_core::machine::{DramModel, Machine, MasterSpec, Priority};
use powergs_dram::{self, AddressRange, Banked, Rank};

/// A request, to ask for later.
pub type Ticket = usize;

struct Queued {
    ticket: Ticket,
    ticks_left: u64,
    /// Ticks from its last byte until it is done.
    latency: u64,
}

/// Another user of the device, from its rules in words: requests of one size at equal distances in
/// time; one that finds too many others under way waits for the oldest.
struct Master {
    spec: MasterSpec,
    base: u64,
    ck_fs: u64,
    /// Share of its rate and of its requests under way, and how these queue.
    share: f64,
    rank: Rank,
    /// First of its tickets.
    tickets: u32,
    class: u8,
    /// Of each request so far, when it was done, CK.
    done: Vec<Option<u64>>,
    /// Requests that have said where they are.
    placed: HashSet<usize>,
}

/// Bytes of the region of each.
const REGION: u64 = 1 << 26;

impl Master {
    /// The CK in which its next request arrives; `None` while that is not known.
    fn arrival(&self) -> Option<u64> {
        let rate = self.spec.rate.0 * self.share;
        let period = (self.spec.request.0 as f64 / rate * 1e15).round() as u128;
        let due = self.done.len() as u128 * period.max(1) / u128::from(self.ck_fs);
        let most = (f64::from(self.spec.in_flight) * self.share).round().max(1.0) as usize;
        let due = u64::try_from(due).expect("a short frame");
        match self.done.len().checked_sub(most) {
            None => Some(due),
            Some(oldest) => self.done[oldest].map(|done| due.max(done)),
        }
    }

    /// Whether request `n` writes: reads come as evenly as their share allows.
    fn writes(&self, n: usize) -> bool {
        let reads = |n: usize| (n as f64 * self.spec.reads).floor();
        reads(n + 1) <= reads(n)
    }

    /// The bytes that request `n` touches: one place behind the other, again and again.
    fn piece(&self, n: usize) -> AddressRange {
        let bytes = self.spec.request.0;
        let place = n as u64 % (REGION / bytes).max(1);
        AddressRange { address: self.base + place * bytes, bytes }
    }
}

/// Tickets of the first of them begin here, and those of each further one so much later.
const MASTER: u32 = 1 << 31;
const MASTERS_APART: u32 = 1 << 28;

enum Kind<P> {
    Bus(Box<Dram>, VecDeque<Queued>),
    Banked(Box<Banked>, Vec<(P, u64)>, Vec<Master>),
}

pub struct Memory<L: Layout> {
    kind: Kind<L::Pattern>,
    streams: &'static Streams,
    /// Femtoseconds of a cycle and of a CK.
    clocks: (u64, u64),
    pub layout: L,
    /// Tick at which each ticket is done.
    done: Vec<Option<u64>>,
    pub requests: u64,
    pub read: [u64; 3],
    pub written: [u64; 3],
}

impl<L: Layout> Memory<L> {
    pub fn new(layout: L, streams: &'static Streams, machine: &Machine, flat: Dram) -> Self {
        let device = || machine.device.as_ref().expect("linked");
        let fs = |ns: f64| (ns * 1e6).round() as u64;
        // With other masters `calibrated` is `banked`.
        let others = machine.dram.masters();
        let is_alone = !others.iter().any(|master| master.rate.0 > 0.0);
        let kind = match machine.dram.model {
            DramModel::Bandwidth => Kind::Bus(Box::new(flat), VecDeque::new()),
            DramModel::Calibrated if is_alone => Kind::Bus(Box::new(flat), VecDeque::new()),
            DramModel::Banked | DramModel::Calibrated => {
                let first = layout.end().next_multiple_of(REGION);
                let mut masters = Vec::new();
                for (k, spec) in others.iter().enumerate().filter(|(_, spec)| spec.rate.0 > 0.0) {
                    let own = match spec.priority {
                        Priority::First => Rank::First,
                        Priority::Equal => Rank::InTurn,
                        Priority::Last => Rank::Last,
                    };
                    let before = spec.guaranteed.0 / spec.rate.0;
                    // What is guaranteed is a master of its own, behind all others in memory.
                    for (n, share, rank) in [(k, 1.0 - before, own), (k + 3, before, Rank::First)] {
                        if share > 0.0 {
                            masters.push(Master {
                                spec: (*spec).clone(),
                                base: first + n as u64 * REGION,
                                ck_fs: fs(device().clock_period.0),
                                share,
                                rank,
                                tickets: MASTER + n as u32 * MASTERS_APART,
                                class: 23 + k as u8,
                                done: Vec::new(),
                                placed: HashSet::new(),
                            });
                        }
                    }
                }
                let device = Banked::new(device());
                let device = if is_alone { device } else { device.in_time() };
                Kind::Banked(Box::new(device), Vec::new(), masters)
            }
        };
        Self {
            kind,
            clocks: (
                fs(1e9 / machine.clock.0),
                machine.device.as_ref().map_or(1, |device| fs(device.clock_period.0)),
            ),
            layout,
            streams,
            done: Vec::new(),
            requests: 0,
            read: [0; 3],
            written: [0; 3],
        }
    }

    pub fn read(&mut self, now: u64, stream: &str, bytes: u64, span: L::Pattern) -> Ticket {
        let stream = self.streams.id(stream);
        self.read[self.streams.phase(stream) as usize] += bytes;
        self.issue(now, stream, bytes, span, true)
    }

    pub fn write(&mut self, now: u64, stream: &str, bytes: u64, span: L::Pattern) -> Ticket {
        let stream = self.streams.id(stream);
        self.written[self.streams.phase(stream) as usize] += bytes;
        self.issue(now, stream, bytes, span, false)
    }

    fn issue(
        &mut self,
        now: u64,
        stream: StreamId,
        bytes: u64,
        span: L::Pattern,
        is_read: bool,
    ) -> Ticket {
        let ticket = self.done.len();
        if bytes == 0 {
            self.done.push(Some((now + 1) * TICKS));
            if let Kind::Banked(_, spans, _) = &mut self.kind {
                spans.push((span, 0));
            }
            return ticket;
        }
        self.requests += 1;
        self.done.push(None);
        let (cycle, ck) = self.clocks;
        let arrival = (now * cycle).div_ceil(ck);
        match &mut self.kind {
            Kind::Bus(dram, queue) => {
                let waiting = queue.iter().map(|other| other.ticks_left).sum();
                let latency = dram.latency(stream, waiting);
                let ticks_left = dram.service(stream, bytes);
                queue.push_back(Queued { ticket, ticks_left, latency });
            }
            Kind::Banked(device, spans, _) => {
                spans.push((span, 0));
                device.push(powergs_dram::Request {
                    ticket: ticket as u32,
                    write: !is_read,
                    class: stream.index() as u8,
                    arrival,
                    rank: Rank::InTurn,
                });
            }
        }
        ticket
    }

    pub fn is_done(&self, ticket: Ticket, now: u64) -> bool {
        self.done[ticket].is_some_and(|tick| tick <= now * TICKS)
    }

    /// The memory works for one cycle, after everybody has issued.
    pub fn tick(&mut self, now: u64) {
        let (cycle, ck) = self.clocks;
        match &mut self.kind {
            Kind::Banked(device, spans, masters) => {
                let layout = &self.layout;
                let until = (now + 1) * cycle / ck;
                loop {
                    // The first of those that ask earliest.
                    let asking =
                        (0..masters.len()).filter_map(|k| Some((masters[k].arrival()?, k)));
                    let next = asking.min();
                    let of = |masters: &[Master], ticket: u32| {
                        let k = masters
                            .iter()
                            .position(|m| ticket.wrapping_sub(m.tickets) < MASTERS_APART);
                        let k = k.expect("a master");
                        (k, (ticket - masters[k].tickets) as usize)
                    };
                    let mut pieces = |ticket: u32| {
                        if ticket < MASTER {
                            let (span, cursor) = &mut spans[ticket as usize];
                            return layout.piece(span, cursor);
                        }
                        let (k, n) = of(masters, ticket);
                        let is_first = masters[k].placed.insert(n);
                        is_first.then(|| masters[k].piece(n))
                    };
                    let limit = next.map_or(until, |(arrival, _)| until.min(arrival));
                    match (device.advance(limit, &mut pieces), next) {
                        (Some((end, ticket)), _) if ticket >= MASTER => {
                            let (k, n) = of(masters, ticket);
                            masters[k].done[n] = Some(end);
                        }
                        (Some((end, ticket)), _) => {
                            let done = (end * ck).div_ceil(cycle).max(now + 1);
                            self.done[ticket as usize] = Some(done * TICKS);
                        }
                        (None, Some((arrival, k))) if arrival <= until => {
                            let n = masters[k].done.len();
                            let master = &mut masters[k];
                            device.push(powergs_dram::Request {
                                ticket: master.tickets + n as u32,
                                write: master.writes(n),
                                class: master.class,
                                arrival,
                                rank: master.rank,
                            });
                            master.done.push(None);
                        }
                        (None, _) => return,
                    }
                }
            }
            Kind::Bus(_, queue) => {
                let mut spent = 0;
                while spent < TICKS {
                    let Some(head) = queue.front_mut() else { return };
                    let moved = head.ticks_left.min(TICKS - spent);
                    head.ticks_left -= moved;
                    spent += moved;
                    if head.ticks_left == 0 {
                        self.done[head.ticket] = Some(now * TICKS + spent + head.latency);
                        queue.pop_front();
                    }
                }
            }
        }
    }
}
