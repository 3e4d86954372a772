//! The front end: from requests in program order to bursts in the queues of channels.

use std::cmp::Reverse;
use std::collections::VecDeque;

use super::queue::Entry;
use super::{AddressRange, Banked, LatencyFrom, Request};

/// A burst on its way to a controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct Burst {
    /// Its entry in the queues.
    pub entry: Entry,
    /// Its number in program order.
    pub sequence: u64,
}

/// Bursts that wait for the controller of a channel.
pub(super) type Fifo = VecDeque<Burst>;

/// A request on its way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot {
    pub request: Request,
    /// When its first burst entered.
    pub entered: Option<u64>,
    /// Bursts that entered and are not done.
    pub left: u32,
    /// Whether all bursts entered.
    pub complete: bool,
    /// When the last of its bursts was done, so far.
    pub last: u64,
}

impl Slot {
    pub(super) fn new(request: Request) -> Self {
        Self { request, entered: None, left: 0, complete: false, last: 0 }
    }
}

impl Banked {
    /// Moves bursts in program order to their channels as far as the limits allow.
    pub(super) fn enter<F>(&mut self, now: u64, pieces: &mut F)
    where
        F: FnMut(u32) -> Option<AddressRange> + ?Sized,
    {
        while let Some(&index) = self.order.front() {
            let slot = self.slots[index as usize];
            if slot.request.arrival > now {
                self.front_due = self.front_due.min(slot.request.arrival);
                return;
            }
            if self.cursor.0 == self.cursor.1 {
                let Some(span) = pieces(slot.request.ticket) else {
                    self.order.pop_front();
                    self.all_entered(index, now);
                    continue;
                };
                self.begin(index, span);
                continue;
            }
            if self.next - self.oldest >= self.window {
                return;
            }
            if slot.entered.is_none() {
                if !slot.request.write {
                    if self.reads_in_flight >= self.reads_max {
                        return;
                    }
                    self.reads_in_flight += 1;
                }
                self.slots[index as usize].entered = Some(now);
            }
            self.send(index);
        }
    }

    /// Cuts a piece into bursts.
    fn begin(&mut self, index: u32, span: AddressRange) {
        let request = self.slots[index as usize].request;
        let bytes = span.bytes;
        for traffic in [&mut self.stats.total, &mut self.stats.classes[request.class as usize]] {
            if request.write {
                traffic.write_bytes += bytes;
            } else {
                traffic.read_bytes += bytes;
            }
        }
        if bytes > 0 {
            let shift = self.decoder.shift;
            let first = span.address >> shift;
            let last = span.address.saturating_add(bytes - 1) >> shift;
            self.cursor = (first, last + 1);
        }
    }

    /// Sends the next burst of the current piece to its channel.
    fn send(&mut self, index: u32) {
        let slot = &mut self.slots[index as usize];
        slot.left += 1;
        let Request { write, class, .. } = slot.request;
        let burst = self.decoder.burst(self.cursor.0 << self.decoder.shift);
        self.cursor.0 += 1;
        let place = self.decoder.place(burst);
        let entry = Entry::new(burst, index, place.bank as u8, place.row, write, class);
        self.stats.total.bursts += 1;
        self.stats.classes[usize::from(class)].bursts += 1;
        self.fifos[place.channel as usize].push_back(Burst { entry, sequence: self.next });
        self.next += 1;
        self.accepting |= 1 << place.channel;
    }

    /// The heads of the FIFOs go into the queues.
    pub(super) fn accept(&mut self, now: u64) {
        let oldest = self.oldest;
        let mut left = self.accepting;
        while left != 0 {
            let number = left.trailing_zeros() as usize;
            left &= left - 1;
            let mut room = self.acceptances;
            while room > 0 && self.accept_head(number, now) {
                room -= 1;
            }
            if room > 0 || self.fifos[number].is_empty() {
                self.accepting &= !(1 << number);
            } else {
                self.front_due = self.front_due.min(now + 1);
            }
        }
        let mask = self.accepted.len() - 1;
        while self.oldest < self.next && self.accepted[self.oldest as usize & mask] {
            self.accepted[self.oldest as usize & mask] = false;
            self.oldest += 1;
        }
        if self.oldest != oldest && !self.order.is_empty() {
            self.front_due = self.front_due.min(now + 1);
        }
    }

    /// Accepts the head of a FIFO, if there is one and it has room.
    fn accept_head(&mut self, number: usize, now: u64) -> bool {
        let Some(&Burst { entry, sequence }) = self.fifos[number].front() else { return false };
        let channel = &mut self.channels[number];
        let class = usize::from(entry.class);
        if channel.has_write(entry.burst) {
            for traffic in [&mut self.stats.total, &mut self.stats.classes[class]] {
                if entry.write {
                    traffic.absorbed_writes += 1;
                } else {
                    traffic.forwarded_reads += 1;
                }
            }
            self.burst_done(entry.slot, now);
        } else if channel.has_room(entry.write, &self.rules) {
            let wake = channel.accept(entry, now, &self.rules);
            self.wakes[number] = self.wakes[number].min(wake.max(now));
        } else {
            return false;
        }
        self.fifos[number].pop_front();
        let mask = self.accepted.len() - 1;
        self.accepted[sequence as usize & mask] = true;
        true
    }

    /// A burst of a request has its data or has been written.
    pub(super) fn burst_done(&mut self, slot: u32, time: u64) {
        let state = &mut self.slots[slot as usize];
        state.left -= 1;
        state.last = state.last.max(time);
        if state.complete && state.left == 0 {
            self.finish(slot);
        }
    }

    /// All bursts of a request have entered.
    fn all_entered(&mut self, index: u32, now: u64) {
        let state = &mut self.slots[index as usize];
        state.complete = true;
        if state.entered.is_none() {
            state.last = now;
        }
        if state.left == 0 {
            self.finish(index);
        }
    }

    fn finish(&mut self, index: u32) {
        let state = &self.slots[index as usize];
        let Request { ticket, write, .. } = state.request;
        let extra = if write || state.entered.is_none() { 0 } else { self.latency };
        self.working -= 1;
        self.done.push(Reverse((state.last + extra, ticket, index)));
    }

    /// A request is complete.
    pub(super) fn retire(&mut self, time: u64, index: u32) {
        let Slot { request, entered, .. } = self.slots[index as usize];
        self.free.push(index);
        self.floor = self.floor.max(time);
        self.stats.until = self.stats.until.max(time);
        let class = usize::from(request.class);
        self.stats.total.requests += 1;
        self.stats.classes[class].requests += 1;
        let Some(entered) = entered.filter(|_| !request.write) else { return };
        if self.reads_in_flight >= self.reads_max && !self.order.is_empty() {
            self.front_due = self.front_due.min(time + 1);
        }
        self.reads_in_flight -= 1;
        let from = match self.latency_from {
            LatencyFrom::Entry => entered,
            LatencyFrom::Arrival => request.arrival,
        };
        let latency = time.saturating_sub(from);
        self.stats.latency.add(latency);
        for traffic in [&mut self.stats.total, &mut self.stats.classes[class]] {
            traffic.latency += latency;
            traffic.latency_requests += 1;
        }
    }
}
