//! Level `banked`: every command of every bank, from event to event.
//!
//! Requests enter in program order. Each is cut into bursts when its turn comes; a burst goes to
//! its channel if it is less than a window ahead of the oldest burst that no controller has
//! accepted, and a read only begins while fewer than the allowed number are in flight. Every CK a
//! controller accepts up to two bursts into its read and write queues and issues one command. A CK
//! in which nothing can happen costs nothing.
//!
//! Addresses beyond the capacity of the device wrap.

mod channel;
mod front;
mod issue;
mod log;
mod plan;
mod queue;
mod rules;
mod sleep;

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use super::device::Device;
use super::mapping::Decoder;
use super::stats::{CLASSES, Stats};
use channel::Channel;
use front::{Fifo, Slot};
pub use log::{CommandKind, Logged};
use rules::Rules;

/// A contiguous range of bytes of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AddressRange {
    /// First byte.
    pub address: u64,
    /// Bytes; each burst that they touch is moved once per range.
    pub bytes: u64,
}

/// A read or a write of any number of pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// The caller's name for it.
    pub ticket: u32,
    /// Whether it writes.
    pub write: bool,
    /// For statistics, below 4.
    pub class: u8,
    /// The CK from which it may enter.
    pub arrival: u64,
}

/// From when the latency of a read counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LatencyFrom {
    /// The CK in which its first burst entered.
    Entry,
    /// Its arrival.
    Arrival,
}

/// The state of a memory: its channels, and the front end that feeds them.
#[derive(Debug, Clone)]
pub struct Banked {
    rules: Rules,
    decoder: Decoder,
    channels: Vec<Channel>,
    /// The CK of the next step of each channel.
    wakes: Vec<u64>,
    fifos: Vec<Fifo>,
    /// Channels that may accept a burst, one bit each.
    accepting: u64,
    /// The CK in which the front end can do something.
    front_due: u64,
    /// The first CK that has not been simulated.
    floor: u64,
    /// Requests in program order, of which not all bursts have entered.
    order: VecDeque<u32>,
    slots: Vec<Slot>,
    free: Vec<u32>,
    /// Next burst of the current piece, and its end.
    cursor: (u64, u64),
    /// Which of the bursts in the window were accepted, by number modulo the length.
    accepted: Vec<bool>,
    /// Most bursts between the oldest that no controller has accepted and the next, exclusive.
    window: u64,
    /// Number of the next burst in program order.
    next: u64,
    /// Number of the oldest burst that no controller has accepted.
    oldest: u64,
    /// Most bursts that a controller accepts in a CK.
    acceptances: u32,
    reads_max: u64,
    reads_in_flight: u64,
    latency_from: LatencyFrom,
    latency: u64,
    /// Requests with bursts for which no column command was issued.
    working: usize,
    /// Completed requests: when, ticket, slot.
    done: BinaryHeap<Reverse<(u64, u32, u32)>>,
    stats: Stats,
}

impl Banked {
    /// An idle memory with the front end of the device. Latencies count from arrival.
    pub fn new(device: &Device) -> Banked {
        let front = &device.front_end;
        let window = (front.window.0 / device.organisation.burst.0).max(1);
        let rules = Rules::new(device);
        let n_channels = device.organisation.channels as usize;
        let channels = vec![Channel::new(&rules); n_channels];
        Banked {
            wakes: channels.iter().map(|c| c.next_refresh).collect(),
            channels,
            rules,
            decoder: Decoder::new(device),
            fifos: vec![Fifo::default(); n_channels],
            accepting: 0,
            front_due: u64::MAX,
            floor: 0,
            order: VecDeque::new(),
            slots: Vec::new(),
            free: Vec::new(),
            cursor: (0, 0),
            accepted: vec![false; window.next_power_of_two() as usize],
            window,
            next: 0,
            oldest: 0,
            acceptances: front.acceptances,
            reads_max: match front.reads_in_flight {
                0 => u64::MAX,
                n => u64::from(n),
            },
            reads_in_flight: 0,
            latency_from: LatencyFrom::Arrival,
            latency: device.ck(device.controller.latency),
            working: 0,
            done: BinaryHeap::new(),
            stats: Stats::default(),
        }
    }

    /// The same, with the latency of reads counted from another moment.
    #[must_use]
    pub(crate) fn with_latency_from(mut self, from: LatencyFrom) -> Banked {
        self.latency_from = from;
        self
    }

    /// The same, keeping every command for [`Banked::log`].
    #[must_use]
    pub(crate) fn with_log(mut self) -> Banked {
        self.channels.iter_mut().for_each(|c| c.log = Some(Vec::new()));
        self
    }

    /// The commands of a channel, if they were kept.
    pub fn log(&self, channel: usize) -> &[Logged] {
        self.channels[channel].log.as_deref().unwrap_or(&[])
    }

    /// Appends a request in program order. Its pieces are asked for lazily. It enters at its
    /// arrival, but not before anything that was already simulated.
    ///
    /// # Panics
    /// If its class is not below 4.
    pub fn push(&mut self, request: Request) {
        assert!(usize::from(request.class) < CLASSES, "class {} of a request", request.class);
        let slot = Slot::new(request);
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
        if self.order.is_empty() {
            self.front_due = self.front_due.min(request.arrival.max(self.floor));
        }
        self.order.push_back(index);
        self.working += 1;
    }

    /// Runs until the first whole request completes or nothing can complete at or before `until`.
    ///
    /// A read completes with its last data and the latency of the controller, a write with its last
    /// column command, a request without pieces when its turn comes. `pieces` yields the next
    /// [`AddressRange`] of a request, `None` when there is no more. Returns the CK and the ticket;
    /// several that complete in one CK come one per call in the order of tickets. Nothing beyond
    /// `until` is simulated.
    pub fn advance<F>(&mut self, until: u64, pieces: &mut F) -> Option<(u64, u32)>
    where
        F: FnMut(u32) -> Option<AddressRange> + ?Sized,
    {
        loop {
            let tick = self.next_tick();
            if let Some(&Reverse((time, ticket, slot))) = self.done.peek()
                && time < tick
            {
                if time > until {
                    break;
                }
                self.done.pop();
                self.retire(time, slot);
                return Some((time, ticket));
            }
            if tick > until || tick == u64::MAX {
                break;
            }
            self.tick(tick, pieces);
            self.skip_refreshes(tick);
        }
        if until < u64::MAX {
            self.floor = self.floor.max(until);
        }
        None
    }

    /// Bytes of a burst.
    pub(crate) fn burst_bytes(&self) -> u64 {
        self.rules.burst_bytes
    }

    /// Activity so far.
    pub fn stats(&self) -> Stats {
        let mut stats = self.stats.clone();
        let buses: Vec<u64> =
            self.channels.iter().flat_map(|c| c.pseudo_channels.iter().map(|r| r.bursts)).collect();
        let cycles = self.rules.burst_cycles;
        stats.busy_max = buses.iter().max().map_or(0, |b| b * cycles);
        stats.busy_mean = buses.iter().sum::<u64>() as f64 * cycles as f64 / buses.len() as f64;
        for channel in &self.channels {
            let mut sleep = channel.sleep;
            sleep.count(stats.until, channel.open_banks > 0, &self.rules.sleep_after);
            stats.active += sleep.active;
            stats.power_down += sleep.power_down;
            stats.self_refresh += sleep.self_refresh;
        }
        stats
    }

    /// The next CK in which anything happens; `u64::MAX` when no request is under way.
    fn next_tick(&self) -> u64 {
        if self.working == 0 {
            return u64::MAX;
        }
        self.wakes.iter().fold(self.front_due, |a, b| a.min(*b))
    }

    /// Skips the refreshes of a long idle time: only their number matters.
    fn skip_refreshes(&mut self, tick: u64) {
        let long = tick.saturating_add(4 * self.rules.refresh_interval);
        if self.front_due <= long || self.next != self.oldest || self.front_due == u64::MAX {
            return;
        }
        if self.channels.iter().all(Channel::is_empty) {
            for (channel, wake) in self.channels.iter_mut().zip(&mut self.wakes) {
                if channel.skip_refreshes(self.front_due, &self.rules, &mut self.stats) {
                    *wake = channel.next_refresh;
                }
            }
        }
    }

    fn tick<F>(&mut self, now: u64, pieces: &mut F)
    where
        F: FnMut(u32) -> Option<AddressRange> + ?Sized,
    {
        self.floor = self.floor.max(now + 1);
        self.stats.until = self.stats.until.max(now);
        if self.front_due <= now {
            self.front_due = u64::MAX;
            self.enter(now, pieces);
            self.accept(now);
        }
        for number in 0..self.channels.len() {
            if self.wakes[number] > now {
                continue;
            }
            let outcome = self.channels[number].step(now, &self.rules, &mut self.stats);
            self.wakes[number] = outcome.wake;
            if let Some((slot, time)) = outcome.column {
                self.burst_done(slot, time);
            }
            if outcome.freed && !self.fifos[number].is_empty() {
                self.accepting |= 1 << number;
                self.front_due = self.front_due.min(now + 1);
            }
        }
    }
}
