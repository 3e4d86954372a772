//! The front end: from requests in program order to bursts in the queues of channels.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use super::channel::BankedChannel;
use super::plan::bits;
use super::rules::Rules;
use super::{AddressRange, LatencyFrom, Rank, Request};
use crate::device::Device;
use crate::mapping::Decoder;
use crate::stats::{CLASSES, Latency, Stats, Traffic};

/// A burst on its way to a controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct Burst {
    /// Number of the burst in the device: its address over the bytes of a burst.
    pub number: u64,
    /// Request that it belongs to.
    pub slot: u32,
    pub row: u32,
    /// The CK in which it entered.
    pub entered: u64,
    /// Its number in program order, but for the upper bits.
    pub sequence: u32,
    pub bank: u8,
    pub class: u8,
    pub write: bool,
}

/// Bursts that wait for the controller of a channel.
pub(super) type Fifo = VecDeque<Burst>;

/// No CK.
const NEVER: u64 = u64::MAX;

/// A request on its way.
#[derive(Debug, Clone, Copy)]
struct Slot {
    arrival: u64,
    /// When its first burst entered; [`NEVER`] before that.
    entered: u64,
    /// When the last of its bursts was done, so far.
    last: u64,
    ticket: u32,
    /// Bursts that entered and are not done.
    left: u32,
    class: u8,
    write: bool,
    /// Whether all bursts entered.
    complete: bool,
}

/// Requests of one rank.
#[derive(Debug, Clone, Default)]
struct RankLane {
    /// In program order, those of which not all bursts have entered.
    order: VecDeque<u32>,
    /// Next burst of the current piece of the first, and its end.
    cursor: (u64, u64),
    /// Whether the first has no more pieces.
    ended: bool,
}

/// Ranks, as lanes.
const LANES: usize = 3;

/// Bursts that may go before others that wait: then these have their turn, so that a twentieth of
/// what enters is left to them.
const PASSES: u64 = 19;

/// The front end.
#[derive(Debug, Clone)]
pub(super) struct Front {
    decoder: Decoder,
    /// The CK in which the front end can do something.
    pub due: u64,
    /// Requests that wait or are entering, by rank; and which lanes have some, one bit each.
    lanes: [RankLane; LANES],
    waiting: u64,
    /// Bursts that went first since others had their turn.
    passed: u64,
    slots: Vec<Slot>,
    free: Vec<u32>,
    /// When the bursts in the window were accepted ([`NEVER`]: not yet), and their channels, by
    /// number modulo the length.
    accepted: Vec<u64>,
    channels: Vec<u8>,
    /// Whether channels run ahead of each other: see [`Front::is_full`].
    pub runs_ahead: bool,
    /// Most bursts between the oldest that no controller has accepted and the next, exclusive.
    window: u64,
    /// Number of the next burst in program order.
    next: u64,
    /// Number of the oldest burst that no controller has accepted.
    oldest: u64,
    reads_max: u64,
    reads_in_flight: u64,
    pub latency_from: LatencyFrom,
    /// Of the controller.
    latency: u64,
    /// Requests with bursts for which no column command was issued.
    pub working: usize,
    /// Completed requests: when, ticket, slot.
    done: BinaryHeap<Reverse<(u64, u32, u32)>>,
    /// Requests, bytes, bursts and latencies.
    classes: [Traffic; CLASSES],
    latencies: Latency,
}

impl Front {
    pub(super) fn new(device: &Device) -> Front {
        let front = &device.front_end;
        let window = (front.window.0 / device.organisation.burst.0).max(1);
        Front {
            decoder: Decoder::new(device),
            due: NEVER,
            lanes: Default::default(),
            waiting: 0,
            passed: 0,
            slots: Vec::new(),
            free: Vec::new(),
            accepted: vec![NEVER; window.next_power_of_two() as usize],
            channels: vec![0; window.next_power_of_two() as usize],
            runs_ahead: false,
            window,
            next: 0,
            oldest: 0,
            reads_max: match front.reads_in_flight {
                0 => u64::MAX,
                n => u64::from(n),
            },
            reads_in_flight: 0,
            latency_from: LatencyFrom::Arrival,
            latency: device.ck(device.controller.latency),
            working: 0,
            done: BinaryHeap::new(),
            classes: Default::default(),
            latencies: Latency::default(),
        }
    }

    /// Appends a request in program order, not before the CK `floor`.
    pub(super) fn push(&mut self, request: Request, floor: u64) {
        let slot = Slot {
            arrival: request.arrival,
            entered: NEVER,
            last: 0,
            ticket: request.ticket,
            left: 0,
            class: request.class,
            write: request.write,
            complete: false,
        };
        let index = match self.free.pop() {
            Some(index) => {
                self.slots[index as usize] = slot;
                index
            }
            None => {
                self.slots.push(slot);
                (self.slots.len() - 1) as u32
            }
        };
        // Requests enter in program order: behind another one its own arrival decides nothing.
        let lane = &mut self.lanes[request.rank as usize];
        if lane.order.is_empty() {
            self.due = self.due.min(request.arrival.max(floor));
        }
        lane.order.push_back(index);
        self.waiting |= 1 << request.rank as u64;
        self.working += 1;
    }

    /// Whether all bursts that entered were accepted.
    pub(super) fn is_empty(&self) -> bool {
        self.next == self.oldest
    }

    /// Moves bursts in program order to their channels as far as the limits allow; returns the
    /// channels that have some to accept, one bit each.
    pub(super) fn enter<F>(
        &mut self,
        now: u64,
        channels: &mut [BankedChannel],
        pieces: &mut F,
    ) -> u64
    where
        F: FnMut(u32) -> Option<AddressRange> + ?Sized,
    {
        let mut sent = 0;
        while let Some((rank, index)) = self.turn(now) {
            let lane = &mut self.lanes[rank];
            if lane.cursor.0 == lane.cursor.1 {
                let slot = &self.slots[index as usize];
                let next = if lane.ended { None } else { pieces(slot.ticket) };
                let Some(span) = next else {
                    lane.ended = self.runs_ahead && lane.order.len() == 1;
                    if lane.ended {
                        // What is pushed before this CK comes enters in it too.
                        self.due = now;
                        return sent;
                    }
                    lane.order.pop_front();
                    self.waiting &= !(u64::from(lane.order.is_empty()) << rank);
                    self.all_entered(index, now);
                    continue;
                };
                self.begin(rank, index, span);
                continue;
            }
            let room = self.window - (self.next - self.oldest);
            // Who waits for all others does so at the controllers too: nothing passes there.
            if room == 0 || (rank == Rank::Last as usize && !self.is_empty()) {
                return sent;
            }
            let slot = &mut self.slots[index as usize];
            if slot.entered == NEVER {
                if !slot.write {
                    if self.reads_in_flight >= self.reads_max {
                        return sent;
                    }
                    self.reads_in_flight += 1;
                }
                slot.entered = now;
            }
            sent |= self.send(rank, index, room, now, channels);
        }
        sent
    }

    /// The request whose turn it is, and its rank; `None` if none has arrived.
    #[inline]
    fn turn(&mut self, now: u64) -> Option<(usize, u32)> {
        for rank in bits(self.waiting) {
            let index = *self.lanes[rank].order.front()?;
            let arrival = self.slots[index as usize].arrival;
            if arrival > now {
                self.due = self.due.min(arrival);
            } else if rank != Rank::First as usize || !self.is_held_up(now) {
                return Some((rank, index));
            }
        }
        None
    }

    /// Whether requests that go first have passed others that wait for long enough.
    fn is_held_up(&self, now: u64) -> bool {
        let next = self.lanes[Rank::InTurn as usize].order.front();
        let waits = next.is_some_and(|index| self.slots[*index as usize].arrival <= now);
        waits && self.passed >= PASSES
    }

    /// Cuts a piece into bursts.
    #[inline]
    fn begin(&mut self, rank: usize, index: u32, span: AddressRange) {
        let Slot { write, class, .. } = self.slots[index as usize];
        let bytes = span.bytes;
        let traffic = &mut self.classes[usize::from(class)];
        *(if write { &mut traffic.write_bytes } else { &mut traffic.read_bytes }) += bytes;
        if bytes > 0 {
            let shift = self.decoder.shift;
            let first = span.address >> shift;
            let last = span.address.saturating_add(bytes - 1) >> shift;
            self.lanes[rank].cursor = (first, last + 1);
        }
    }

    /// Sends the next bursts of the current piece to their channels, at most `room`; returns the
    /// channels that had none, one bit each.
    #[inline]
    fn send(
        &mut self,
        rank: usize,
        index: u32,
        room: u64,
        now: u64,
        channels: &mut [BankedChannel],
    ) -> u64 {
        let slot = &mut self.slots[index as usize];
        let Slot { write, class, .. } = *slot;
        let (first, end) = self.lanes[rank].cursor;
        let bursts = room.min(end - first);
        slot.left += bursts as u32;
        self.lanes[rank].cursor.0 = first + bursts;
        self.passed = if rank == Rank::First as usize { self.passed + bursts } else { 0 };
        self.classes[usize::from(class)].bursts += bursts;
        let mut sent = 0;
        for position in first..first + bursts {
            let number = self.decoder.burst(position << self.decoder.shift);
            let place = self.decoder.place(number);
            let (bank, row, sequence) = (place.bank as u8, place.row, self.next as u32);
            let channel = &mut channels[place.channel as usize];
            if channel.fifo.is_empty() {
                channel.accepts = now;
                sent |= 1 << place.channel;
            }
            let (slot, entered) = (index, now);
            let burst = Burst { number, slot, row, entered, sequence, bank, class, write };
            channel.fifo.push_back(burst);
            let mask = self.channels.len() - 1;
            self.channels[sequence as usize & mask] = place.channel as u8;
            self.next += 1;
        }
        sent
    }

    /// A controller has accepted a burst.
    #[inline]
    pub(super) fn accepted(&mut self, sequence: u32, now: u64) {
        let mask = self.accepted.len() - 1;
        self.accepted[sequence as usize & mask] = now;
        // While channels run ahead, `run_ahead` moves the window itself, in the order of time.
        if sequence == self.oldest as u32 && !self.runs_ahead {
            while self.oldest < self.next && self.is_accepted(self.oldest) {
                self.leave_window();
            }
            if self.waiting != 0 {
                self.due = self.due.min(now + 1);
            }
        }
    }

    /// Whether a burst in the window was accepted.
    #[inline]
    pub(super) fn is_accepted(&self, sequence: u64) -> bool {
        self.accepted_at(sequence) != NEVER
    }

    #[inline]
    fn accepted_at(&self, sequence: u64) -> u64 {
        self.accepted[sequence as usize & (self.accepted.len() - 1)]
    }

    /// The oldest burst in the window leaves it.
    #[inline]
    fn leave_window(&mut self) {
        let mask = self.accepted.len() - 1;
        self.accepted[self.oldest as usize & mask] = NEVER;
        self.oldest += 1;
    }

    /// Whether nothing can enter before the oldest burst in the window has been accepted: what
    /// happens in the other channels until then changes nothing here.
    #[inline]
    pub(super) fn is_full(&self) -> bool {
        let window = self.next - self.oldest == self.window;
        // With a limit of reads a completion lets the next one enter, and completions are not known
        // ahead.
        window && self.reads_max == u64::MAX && self.waiting != 0 && self.due == NEVER
    }

    /// Runs the channels as far as bursts in a full window wait for them, until nothing more is
    /// known to enter until the CK `until`; returns the channels that were run, one bit each.
    ///
    /// Channels are not taken in the order of time here: each runs until it has accepted the burst
    /// that is the oldest in the window, which is all that the next to enter waits for.
    pub(super) fn run_ahead<F>(
        &mut self,
        until: u64,
        channels: &mut [BankedChannel],
        rules: &Rules,
        pieces: &mut F,
    ) -> u64
    where
        F: FnMut(u32) -> Option<AddressRange> + ?Sized,
    {
        let mut touched = 0;
        self.runs_ahead = true;
        loop {
            touched |= self.run_oldest(until, channels, rules);
            let now = self.accepted_at(self.oldest);
            if now == NEVER {
                break;
            }
            // All that were accepted by then leave together: there is room for others in the next
            // CK.
            while self.accepted_at(self.oldest) <= now {
                self.leave_window();
                if self.oldest == self.next {
                    break;
                }
                touched |= self.run_oldest(now, channels, rules);
            }
            self.due = now + 1;
            if self.due > until {
                break;
            }
            self.due = NEVER;
            touched |= self.enter(now + 1, channels, pieces);
            if !self.is_full() {
                break;
            }
        }
        self.runs_ahead = false;
        touched
    }

    /// Runs the channel of the oldest burst in the window until it has accepted it, but not beyond
    /// the CK `limit`; returns the channel as a bit.
    #[inline]
    fn run_oldest(&mut self, limit: u64, channels: &mut [BankedChannel], rules: &Rules) -> u64 {
        if self.is_accepted(self.oldest) {
            return 0;
        }
        let number = self.channels[self.oldest as usize & (self.channels.len() - 1)];
        let channel = &mut channels[usize::from(number)];
        loop {
            let now = channel.next();
            if now > limit {
                break;
            }
            channel.tick(now, rules, self);
            if self.is_accepted(self.oldest) {
                break;
            }
        }
        1 << number
    }

    /// A burst of a request has its data or has been written.
    #[inline]
    pub(super) fn burst_done(&mut self, slot: u32, time: u64) {
        let state = &mut self.slots[slot as usize];
        state.left -= 1;
        // Bursts of a request lie in several channels: the last to be issued need not be the last
        // to end.
        state.last = state.last.max(time);
        if state.complete && state.left == 0 {
            self.finish(slot);
        }
    }

    /// All bursts of a request have entered.
    fn all_entered(&mut self, index: u32, now: u64) {
        let state = &mut self.slots[index as usize];
        state.complete = true;
        if state.entered == NEVER {
            state.last = now;
        }
        if state.left == 0 {
            self.finish(index);
        }
    }

    fn finish(&mut self, index: u32) {
        let state = &self.slots[index as usize];
        let extra = if state.write || state.entered == NEVER { 0 } else { self.latency };
        self.working -= 1;
        self.done.push(Reverse((state.last + extra, state.ticket, index)));
    }

    /// When the next request completes, of those that are known to; [`u64::MAX`] if none is.
    #[inline]
    pub(super) fn first_done(&self) -> u64 {
        self.done.peek().map_or(NEVER, |Reverse((time, ..))| *time)
    }

    /// Takes the next completed request: the CK and its ticket.
    pub(super) fn retire(&mut self) -> Option<(u64, u32)> {
        let Reverse((time, ticket, index)) = self.done.pop()?;
        self.free.push(index);
        let Slot { arrival, entered, class, write, .. } = self.slots[index as usize];
        let traffic = &mut self.classes[usize::from(class)];
        traffic.requests += 1;
        if write || entered == NEVER {
            return Some((time, ticket));
        }
        // A read that the limit held back may enter in the next CK.
        if self.reads_in_flight >= self.reads_max && self.waiting != 0 {
            self.due = self.due.min(time + 1);
        }
        self.reads_in_flight -= 1;
        let from = match self.latency_from {
            LatencyFrom::Entry => entered,
            LatencyFrom::Arrival => arrival,
        };
        let latency = time.saturating_sub(from);
        self.latencies.add(latency);
        traffic.latency += latency;
        traffic.latency_requests += 1;
        Some((time, ticket))
    }

    /// Adds requests, bytes, bursts and latencies to the activity of the memory.
    pub(super) fn add_to(&self, stats: &mut Stats) {
        stats.latency = self.latencies.clone();
        for (class, own) in self.classes.iter().enumerate() {
            for traffic in [&mut stats.total, &mut stats.classes[class]] {
                traffic.requests += own.requests;
                traffic.read_bytes += own.read_bytes;
                traffic.write_bytes += own.write_bytes;
                traffic.bursts += own.bursts;
                traffic.latency += own.latency;
                traffic.latency_requests += own.latency_requests;
            }
        }
    }
}
