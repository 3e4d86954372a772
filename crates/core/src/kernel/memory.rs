//! The memory as the units see it: requests are issued, and complete in a later cycle.
//!
//! With the `bandwidth` and `calibrated` models the cycle of completion is known when a request is
//! issued. With the `banked` model it is known only when the request completes, because the
//! controller may serve later requests first.

use crate::kernel::DramUse;
use crate::kernel::calibration::{Calibration, CalibrationSample, Recording};
use crate::kernel::dram::{Channel, Dram};
use crate::kernel::masters::{self, MASTERS, Masters};
use crate::kernel::spec::{DramModel, External, MasterSpec, Priority};
use crate::kernel::stream::{StreamId, Streams};
use crate::kernel::timeline::Observer;
use crate::kernel::traffic::Traffic;
use powergs_base::quantity::Hertz;
use powergs_dram::{AddressRange, Banked, Device, DramCommands, Rank, StageCommands};
use std::iter;

/// No cycle.
pub const NEVER: u64 = u64::MAX;

/// A request under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival(u64);

impl Arrival {
    /// Nothing is waited for.
    pub const NOW: Arrival = Arrival(0);
}

/// A request of a unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// The agent that issues it, and that its completion wakes.
    pub owner: u32,
    /// What it reads or writes.
    pub stream: StreamId,
    /// Bytes requested.
    pub bytes: u64,
}

/// Marks an arrival whose cycle is not known yet: the other bits are the number of the request.
const UNKNOWN: u64 = 1 << 63;

/// Where the data of a frame lies.
pub trait Layout {
    /// The addresses that a request touches.
    type Pattern: Copy;

    /// The next address range of a request of which `cursor` ranges are done.
    fn piece(&self, pattern: &Self::Pattern, cursor: &mut u64) -> Option<AddressRange>;

    /// First byte behind all regions of the frame.
    fn end(&self) -> u64;
}

/// A frame whose requests are one range of bytes each: address and length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Ranges {
    /// First byte behind all of them.
    pub end: u64,
}

impl Layout for Ranges {
    type Pattern = [u64; 2];

    fn piece(&self, [address, bytes]: &[u64; 2], cursor: &mut u64) -> Option<AddressRange> {
        *cursor += 1;
        (*cursor == 1).then_some(AddressRange { address: *address, bytes: *bytes })
    }

    fn end(&self) -> u64 {
        self.end
    }
}

/// Cycles in which an idle memory answers a read: a row is opened and read, or what the machine
/// says where it has no device or does not time it.
///
/// # Panics
/// When its model needs a device that was never looked up.
pub fn answers_in(external: &External<'_>) -> u64 {
    let seconds = match external.spec.timed() {
        DramModel::Bandwidth => external.spec.latency.0 * 1e-9,
        DramModel::Banked | DramModel::Calibrated => {
            let device = external.timed_device();
            let timing = &device.timing;
            let ck = timing.precharge_to_activate + timing.activate_to_read + timing.read_data;
            let all = f64::from(ck) + device.ck(device.controller.latency) as f64;
            all * device.clock_period.0 * 1e-9
        }
    };
    (seconds * external.clock.0).ceil() as u64
}

/// The memory of one frame.
pub struct Memory<'a, L: Layout> {
    layout: L,
    streams: &'static Streams,
    traffic: Traffic,
    timer: Timer<L::Pattern>,
    /// Other masters, where their requests are timed.
    masters: Option<Masters>,
    /// What they take in the `bandwidth` model.
    flat: FlatMasters,
    /// What device commands come with the requests of the `calibrated` model.
    calibration: Option<&'a Calibration>,
    /// The requests, for an observer that wants their times.
    samples: Vec<CalibrationSample>,
    /// The length of the frame, once it is over.
    frame: u64,
}

/// The DRAM model.
enum Timer<P> {
    Flat(Box<Channel>),
    Banked(Box<Queued<P>>, Clocks),
}

/// Address ranges of a request that are found together: their places in memory do not depend on
/// each other, so that the processor need not wait for one before it looks for the next.
#[derive(Debug, Default)]
struct Ahead {
    pieces: Vec<AddressRange>,
    taken: usize,
}

impl Ahead {
    /// How many are found together.
    const PIECES: usize = 32;

    fn next(&mut self, find: impl FnMut() -> Option<AddressRange>) -> Option<AddressRange> {
        if self.taken == self.pieces.len() {
            self.taken = 0;
            self.pieces.clear();
            self.pieces.extend(iter::from_fn(find).take(Self::PIECES));
        }
        let piece = self.pieces.get(self.taken).copied()?;
        self.taken += 1;
        Some(piece)
    }
}

/// A device with its requests, which it reorders.
struct Queued<P> {
    device: Banked,
    /// Of the request whose turn it is.
    ahead: Ahead,
    /// Requests by number: addresses, address ranges already taken, agent, cycle of completion.
    requests: Vec<(P, u64, u32, u64)>,
    /// How many of them are under way.
    open: usize,
}

/// Other masters of a memory that is a rate.
#[derive(Debug, Clone, Copy, Default)]
struct FlatMasters {
    /// Share of the bus that they take before the accelerator.
    share: f64,
    /// Bytes a cycle that each asks for.
    rates: [f64; MASTERS.len()],
    /// Share of the bus that each of those takes which take what is left.
    last: [f64; MASTERS.len()],
}

impl FlatMasters {
    fn new(external: &External<'_>) -> FlatMasters {
        let (all, peak) = (external.spec.masters(), external.peak.0);
        let is_last = |master: &&MasterSpec| master.priority == Priority::Last;
        FlatMasters {
            share: external.others_share(),
            rates: all.map(|master| master.rate.0 / external.clock.0),
            last: all.map(|master| if is_last(&master) { master.share(peak) } else { 0.0 }),
        }
    }

    /// Bytes of each in a frame, and the share of the bus that those get which take what is left.
    fn bytes(&self, frame: f64, busy: f64) -> ([u64; MASTERS.len()], f64) {
        let mut left = (1.0 - busy / frame.max(1.0)).max(0.0);
        let mut taken = 0.0;
        let mut bytes = self.rates.map(|rate| (rate * frame) as u64);
        for (bytes, last) in bytes.iter_mut().zip(self.last).filter(|(_, last)| *last > 0.0) {
            let gets = last.min(left);
            *bytes = (*bytes as f64 * gets / last) as u64;
            (left, taken) = (left - gets, taken + gets);
        }
        (bytes, taken)
    }
}

/// The class of requests of the first of them in statistics, behind those of the streams.
const MASTER_CLASS: u8 = Streams::MOST as u8;

/// The clock periods of the machine (cycles) and of the device (CK), in femtoseconds.
#[derive(Debug, Clone, Copy)]
struct Clocks {
    cycle_fs: u64,
    ck_fs: u64,
}

impl Clocks {
    fn new(clock: Hertz, device: &Device) -> Clocks {
        let fs = |seconds: f64| (seconds * 1e15).round() as u64;
        Clocks { cycle_fs: fs(clock.0.recip()), ck_fs: fs(device.clock_period.0 * 1e-9) }
    }

    /// The first CK at or after a cycle begins.
    fn ck_from(self, cycle: u64) -> u64 {
        cycle.saturating_mul(self.cycle_fs).div_ceil(self.ck_fs)
    }

    /// The last CK at or before a cycle begins.
    fn ck_until(self, cycle: u64) -> u64 {
        match cycle {
            NEVER => u64::MAX,
            _ => cycle.saturating_mul(self.cycle_fs) / self.ck_fs,
        }
    }

    /// The first cycle that begins at or after a CK.
    fn cycle(self, ck: u64) -> u64 {
        ck.saturating_mul(self.ck_fs).div_ceil(self.cycle_fs)
    }
}

impl<'a, L: Layout> Memory<'a, L> {
    /// An idle memory.
    ///
    /// # Panics
    /// When its model needs a device that was never looked up.
    pub fn new(
        layout: L,
        streams: &'static Streams,
        external: External<'_>,
        calibration: Option<&'a Calibration>,
    ) -> Self {
        let External { spec: table, peak, clock, .. } = external;
        let plain = || Dram::new(table, peak, clock, streams);
        let flat = calibration.map_or_else(plain, Calibration::dram);
        let mut masters = None;
        let timer = match table.timed() {
            DramModel::Bandwidth | DramModel::Calibrated => {
                Timer::Flat(Box::new(Channel::new(flat)))
            }
            DramModel::Banked => {
                let device = external.timed_device();
                let clocks = Clocks::new(clock, device);
                masters = Masters::new(table, layout.end(), clocks.ck_fs);
                let device = Banked::new(device);
                // The frame may end while requests of other masters are under way.
                let device = if masters.is_some() { device.in_time() } else { device };
                let (ahead, requests) = (Ahead::default(), Vec::new());
                let queued = Queued { device, ahead, requests, open: 0 };
                Timer::Banked(Box::new(queued), clocks)
            }
        };
        let flat_masters = match table.timed() {
            DramModel::Bandwidth => FlatMasters::new(&external),
            DramModel::Calibrated | DramModel::Banked => FlatMasters::default(),
        };
        let (traffic, samples) = (Traffic::default(), Vec::new());
        let flat = flat_masters;
        Memory { layout, streams, traffic, timer, masters, flat, calibration, samples, frame: 0 }
    }

    /// Where the data of the frame lies.
    pub fn layout(&self) -> &L {
        &self.layout
    }

    /// Whether the reads of one agent, and its writes of at least a byte, are done in the order in
    /// which they were issued.
    pub fn keeps_order(&self) -> bool {
        matches!(self.timer, Timer::Flat(_)) && self.calibration.is_none()
    }

    /// Issues a request in cycle `now`; `span` gives its addresses. A request of no bytes does not
    /// reach the memory and is done one cycle later.
    #[inline]
    pub fn issue<O: Observer>(
        &mut self,
        now: u64,
        request: Request,
        span: impl FnOnce(&L) -> L::Pattern,
        observer: &mut O,
    ) -> Arrival {
        if request.bytes == 0 {
            return Arrival(now + 1);
        }
        let (stream, bytes) = (request.stream, request.bytes);
        let stage = &mut self.traffic.stages[self.streams.phase(stream) as usize];
        *(if self.streams.is_write(stream) { &mut stage.write } else { &mut stage.read }) += bytes;
        if observer.wants_times() {
            self.samples.push(CalibrationSample { stream, bytes, issued: now, done: NEVER });
        }
        match &mut self.timer {
            Timer::Flat(channel) if !observer.wants_requests() => {
                Arrival(channel.serve(now, stream, bytes))
            }
            Timer::Flat(_) | Timer::Banked(..) => {
                let span = span(&self.layout);
                self.tell(&request, &span, observer);
                self.issue_at(now, request, span)
            }
        }
    }

    /// Issues a request to a memory that may depend on addresses.
    fn issue_at(&mut self, now: u64, request: Request, span: L::Pattern) -> Arrival {
        let (class, write) = (request.stream.index() as u8, self.streams.is_write(request.stream));
        match &mut self.timer {
            Timer::Flat(channel) => Arrival(channel.serve(now, request.stream, request.bytes)),
            Timer::Banked(queued, clocks) => {
                let number = queued.requests.len();
                queued.open += 1;
                queued.requests.push((span, 0, request.owner, NEVER));
                queued.device.push(powergs_dram::Request {
                    ticket: ticket(number as u64),
                    write,
                    class,
                    arrival: clocks.ck_from(now),
                    rank: Rank::InTurn,
                });
                Arrival(UNKNOWN | number as u64)
            }
        }
    }

    fn tell<O: Observer>(&self, request: &Request, span: &L::Pattern, observer: &mut O) {
        if !observer.wants_requests() {
            return;
        }
        let (mut cursor, is_write) = (0, self.streams.is_write(request.stream));
        while let Some(p) = self.layout.piece(span, &mut cursor) {
            observer.request(is_write, p.address, p.bytes);
        }
    }

    /// The cycle in which a request is done; [`NEVER`] while that is not known.
    #[inline]
    pub fn at(&self, arrival: Arrival) -> u64 {
        match &self.timer {
            Timer::Banked(queued, _) if arrival.0 & UNKNOWN != 0 => {
                queued.requests[(arrival.0 & !UNKNOWN) as usize].3
            }
            Timer::Flat(_) | Timer::Banked(..) => arrival.0,
        }
    }

    /// Cycle in which a request completes, if that is known already; otherwise 0.
    pub fn known_end(&self, arrival: Arrival) -> u64 {
        match self.at(arrival) {
            NEVER => 0,
            cycle => cycle,
        }
    }

    /// Runs the `banked` model until a request completes, at most until cycle `until`; returns the
    /// cycle of completion and the agent of the request. Requests of other masters enter as they
    /// arrive.
    pub fn advance(&mut self, until: u64) -> Option<(u64, u32)> {
        let Timer::Banked(queued, clocks) = &mut self.timer else { return None };
        let clocks = *clocks;
        let limit = clocks.ck_until(until);
        loop {
            let arrival = self.masters.as_ref().map_or(u64::MAX, Masters::next_arrival);
            // Without an end, only requests of the accelerator are waited for.
            if self.masters.is_some() && limit == u64::MAX && queued.open == 0 {
                return None;
            }
            let (layout, others) = (&self.layout, &mut self.masters);
            let (requests, ahead) = (&mut queued.requests, &mut queued.ahead);
            let mut pieces = |ticket: u32| match others {
                Some(others) if masters::is_others(ticket) => others.piece(ticket),
                _ => {
                    let (span, cursor, ..) = &mut requests[ticket as usize];
                    ahead.next(|| layout.piece(span, cursor))
                }
            };
            let found = queued.device.advance(limit.min(arrival), &mut pieces);
            match (found, &mut self.masters) {
                (Some((ck, ticket)), Some(others)) if masters::is_others(ticket) => {
                    others.done(ticket, ck);
                }
                (Some((ck, number)), _) => {
                    queued.open -= 1;
                    let (_, _, owner, done) = &mut queued.requests[number as usize];
                    *done = clocks.cycle(ck);
                    return Some((*done, *owner));
                }
                (None, Some(others)) if arrival <= limit && arrival < u64::MAX => {
                    queued.device.push(others.take(MASTER_CLASS));
                }
                (None, _) => return None,
            }
        }
    }

    /// Ends the frame in cycle `frame`: requests of other masters up to then are counted.
    pub fn close(&mut self, frame: u64) {
        self.frame = frame;
        match (&mut self.timer, &mut self.masters) {
            (Timer::Banked(..), Some(_)) => while self.advance(frame).is_some() {},
            (Timer::Flat(_), _) | (_, None) => {}
        }
    }

    /// The channel of the `bandwidth` model, and the bytes asked for; `None` with the others.
    pub fn flat(&self) -> Option<(&Channel, Traffic)> {
        match &self.timer {
            Timer::Flat(channel) => Some((channel, self.traffic)),
            Timer::Banked(..) => None,
        }
    }

    /// Continues with the state of another channel of the same rate.
    pub fn set_flat(&mut self, channel: Channel, traffic: Traffic) {
        self.timer = Timer::Flat(Box::new(channel));
        self.traffic = traffic;
    }

    /// Bytes asked for, by stage.
    pub fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// The requests with their times, and what the device did; `None` without a device whose
    /// requests an observer wanted.
    pub fn recording(&mut self) -> Option<Recording> {
        let Timer::Banked(queued, clocks) = &self.timer else { return None };
        let mut samples = std::mem::take(&mut self.samples);
        for (sample, request) in samples.iter_mut().zip(&queued.requests) {
            sample.done = request.3;
        }
        let stats = queued.device.stats();
        let cycles_per_ck = clocks.ck_fs as f64 / clocks.cycle_fs as f64;
        Some(Recording { samples, stats, cycles_per_ck, frame: self.frame })
    }

    /// DRAM activity of the frame.
    pub fn usage(&self) -> DramUse {
        let total = self.traffic.total();
        let usage = match &self.timer {
            Timer::Flat(channel) => {
                let share = self.flat.share;
                let (frame, busy) = (self.frame as f64, channel.busy_cycles());
                let served = channel.served();
                // While the accelerator's bytes move, so do those of other masters.
                let before = busy as f64 * (1.0 - share) + frame * share;
                let (master_bytes, last) = self.flat.bytes(frame, before);
                let all = (before + frame * last).ceil() as u64;
                let usage = DramUse {
                    requests_issued: served,
                    requests_served: served,
                    busy_cycles: if share + last > 0.0 { all.min(self.frame) } else { busy },
                    master_bytes,
                    ..DramUse::default()
                };
                match self.calibration {
                    Some(calibration) => DramUse {
                        busy_cycles: calibration.busy_cycles(&channel.bytes(), self.frame),
                        commands: Some(calibration.commands(&channel.bytes(), self.frame)),
                        ..usage
                    },
                    None => usage,
                }
            }
            Timer::Banked(queued, clocks) => {
                let issued = queued.requests.len() as u64;
                let mut usage = device_usage(self.streams, &queued.device, *clocks);
                usage.requests_issued = issued;
                usage
            }
        };
        let usage = match self.masters {
            Some(_) => DramUse { busy_cycles: usage.busy_cycles.min(self.frame), ..usage },
            None => usage,
        };
        DramUse { read_bytes: total.read, write_bytes: total.write, ..usage }
    }
}

/// The ticket of a request.
fn ticket(number: u64) -> u32 {
    let number = u32::try_from(number).ok().filter(|n| !masters::is_others(*n));
    number.expect("fewer than 2^31 requests in a frame")
}

fn device_usage(streams: &Streams, device: &Banked, clocks: Clocks) -> DramUse {
    let (stats, burst_bytes) = (device.stats(), device.burst_bytes());
    let others = &stats.classes[usize::from(MASTER_CLASS)..];
    let served = stats.total.requests - others.iter().map(|class| class.requests).sum::<u64>();
    let mut stages = [StageCommands::default(); 3];
    for stream in streams.all() {
        let t = &stats.classes[stream.index()];
        stages[streams.phase(stream) as usize].add(StageCommands {
            reads: t.reads,
            writes: t.writes,
            activates: t.row_misses + t.row_conflicts,
        });
    }
    DramUse {
        requests_issued: served,
        requests_served: served,
        master_bytes: std::array::from_fn(|place| others[place].requested_bytes()),
        busy_cycles: clocks.cycle(stats.busy_max),
        commands: Some(DramCommands {
            burst_bytes,
            stages,
            precharges: stats.precharges + stats.precharges_all,
            refreshes: stats.refreshes_all,
            bank_refreshes: stats.refreshes_bank,
        }),
        ..DramUse::default()
    }
}
