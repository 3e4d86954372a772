//! Level `banked`: every command of every bank, from event to event.
//!
//! Requests enter in program order. Each is cut into bursts when its turn comes; a burst goes to
//! its channel if it is less than a window ahead of the oldest burst that no controller has
//! accepted, and a read only begins while fewer than the allowed number are in flight. Every CK a
//! controller accepts up to two bursts into its read and write queues and issues one command. A CK
//! in which nothing can happen costs nothing.
//!
//! Addresses beyond the capacity of the device wrap.

mod agenda;
mod channel;
mod class;
mod counts;
mod front;
mod issue;
mod log;
mod plan;
mod queue;
mod rules;
mod sleep;
mod table;

use super::device::Device;
use super::stats::{CLASSES, Stats};
use agenda::Agenda;
use channel::BankedChannel;
use front::Front;
pub use log::{CommandKind, Logged};
use plan::bits;
use rules::Rules;

/// A contiguous range of bytes of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AddressRange {
    /// First byte.
    pub address: u64,
    /// Bytes; each burst that they touch is moved once per range.
    pub bytes: u64,
}

/// Which of the requests that wait outside enters first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rank {
    /// Before all others.
    First,
    /// In program order.
    InTurn,
    /// While no other could, and nothing that has entered waits for a controller.
    Last,
}

/// A read or a write of any number of pieces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// The caller's name for it.
    pub ticket: u32,
    /// Whether it writes.
    pub write: bool,
    /// For statistics, below [`CLASSES`].
    pub class: u8,
    /// The CK from which it may enter.
    pub arrival: u64,
    /// Whether it enters before others. Requests of one rank enter in program order.
    pub rank: Rank,
}

/// From when the latency of a read counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LatencyFrom {
    /// The CK in which its first burst entered.
    Entry,
    /// Its arrival.
    Arrival,
}

/// The state of a memory: its channels, and the front end that feeds them.
#[derive(Debug, Clone)]
pub struct Banked {
    rules: Rules,
    front: Front,
    channels: Vec<BankedChannel>,
    /// The CK in which something happens next in each channel.
    agenda: Agenda,
    /// The first CK that has not been simulated.
    floor: u64,
    /// The last CK in which anything happened.
    until: u64,
    /// Whether nothing is simulated that comes after the next completion.
    in_time: bool,
}

impl Banked {
    /// An idle memory with the front end of the device. Latencies count from arrival.
    pub fn new(device: &Device) -> Banked {
        let rules = Rules::new(device);
        let channels = vec![BankedChannel::new(&rules); device.organisation.channels as usize];
        Banked {
            front: Front::new(device),
            agenda: Agenda::new(channels.iter().map(BankedChannel::next)),
            channels,
            rules,
            floor: 0,
            until: 0,
            in_time: false,
        }
    }

    /// The same, for a caller that ends before all requests are complete: nothing that comes after
    /// the last completion that it was told of is in the [`Banked::stats`].
    #[must_use]
    pub fn in_time(mut self) -> Banked {
        self.in_time = true;
        self
    }

    /// The same, with the latency of reads counted from another moment.
    #[must_use]
    pub fn with_latency_from(mut self, from: LatencyFrom) -> Banked {
        self.front.latency_from = from;
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
    /// If its class is not below [`CLASSES`].
    pub fn push(&mut self, request: Request) {
        assert!(usize::from(request.class) < CLASSES, "class {} of a request", request.class);
        self.front.push(request, self.floor);
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
        let mut may_run_ahead = !self.in_time;
        loop {
            // Asked again only when the front end could act: until then the answer is the same.
            if may_run_ahead && self.front.is_full() {
                self.run_ahead(until, pieces);
                may_run_ahead = false;
            }
            let (next, _) = self.agenda.first();
            // Without requests only refreshes are left, and they must not keep this loop going.
            let tick = if self.front.working == 0 { u64::MAX } else { self.front.due.min(next) };
            let time = self.front.first_done();
            // Not at `tick` itself: a request with a lower ticket may still complete in that CK.
            if time < tick {
                if time > until {
                    break;
                }
                self.floor = self.floor.max(time);
                self.until = self.until.max(time);
                return self.front.retire();
            }
            if tick > until || tick == u64::MAX {
                break;
            }
            may_run_ahead |= self.front.due <= tick && !self.in_time;
            self.tick(tick, pieces);
            self.skip_refreshes(tick);
        }
        // What was simulated cannot change any more, so that later requests enter behind it.
        if until < u64::MAX {
            self.floor = self.floor.max(until);
        }
        None
    }

    /// Bytes of a burst.
    pub fn burst_bytes(&self) -> u64 {
        self.rules.burst_bytes
    }

    /// Activity so far.
    pub fn stats(&self) -> Stats {
        let mut stats = Stats { until: self.until, ..Stats::default() };
        self.front.add_to(&mut stats);
        let buses = self.channels.iter().flat_map(|channel| {
            (0..self.rules.pseudo_channels).map(|pseudo| channel.pseudo_channels.at(pseudo).bursts)
        });
        let buses: Vec<u64> = buses.collect();
        let cycles = self.rules.burst_cycles;
        stats.busy_max = buses.iter().max().map_or(0, |b| b * cycles);
        stats.busy_mean = buses.iter().sum::<u64>() as f64 * cycles as f64 / buses.len() as f64;
        for channel in &self.channels {
            channel.counts.add_to(&mut stats, self.rules.burst_bytes);
            // A copy is counted on, because statistics may be asked for in the middle of a run.
            let mut sleep = channel.sleep;
            sleep.count(self.until, channel.open != 0, &self.rules.sleep_after);
            stats.active += sleep.active;
            stats.power_down += sleep.power_down;
            stats.self_refresh += sleep.self_refresh;
        }
        stats
    }

    /// Skips the refreshes of a long idle time: only their number matters.
    #[inline]
    fn skip_refreshes(&mut self, tick: u64) {
        let due = self.front.due;
        let long = tick.saturating_add(4 * self.rules.refresh_interval);
        if due == u64::MAX || due <= long || !self.front.is_empty() {
            return;
        }
        if self.channels.iter().all(BankedChannel::is_empty) {
            for (number, channel) in self.channels.iter_mut().enumerate() {
                if channel.skip_refreshes(due, &self.rules) {
                    channel.wake = channel.next_refresh;
                    self.agenda.set(number, channel.next());
                }
            }
            self.agenda.look();
        }
    }

    /// Runs the channels out of the order of time where that changes nothing.
    fn run_ahead<F>(&mut self, until: u64, pieces: &mut F)
    where
        F: FnMut(u32) -> Option<AddressRange> + ?Sized,
    {
        let touched = self.front.run_ahead(until, &mut self.channels, &self.rules, pieces);
        for number in bits(touched) {
            self.agenda.set(number, self.channels[number].next());
        }
        self.agenda.look();
    }

    #[inline]
    fn tick<F>(&mut self, now: u64, pieces: &mut F)
    where
        F: FnMut(u32) -> Option<AddressRange> + ?Sized,
    {
        self.floor = self.floor.max(now + 1);
        self.until = self.until.max(now);
        // Bursts enter before controllers act, so that one is accepted in the CK in which it came.
        if self.front.due <= now {
            self.front.due = u64::MAX;
            for number in bits(self.front.enter(now, &mut self.channels, pieces)) {
                self.agenda.set(number, now);
            }
            self.agenda.look();
        }
        loop {
            let (next, number) = self.agenda.first();
            if next > now {
                break;
            }
            let channel = &mut self.channels[number];
            channel.tick(now, &self.rules, &mut self.front);
            self.agenda.set(number, channel.next());
            self.agenda.look();
        }
    }
}
