//! The memory: a queue, and a bus that moves 1024 ticks' worth in a cycle.

use std::collections::VecDeque;

use powergs_sim::accel::Design;
use powergs_sim::accel::dram::{Dram, TICKS};

/// A request, to ask for later.
pub type Ticket = usize;

struct Queued {
    ticket: Ticket,
    ticks_left: u64,
    is_read: bool,
}

pub struct Memory {
    dram: Dram,
    queue: VecDeque<Queued>,
    /// Tick at which each ticket is done.
    done: Vec<Option<u64>>,
    pub requests: u64,
    pub read: [u64; 3],
    pub written: [u64; 3],
}

impl Memory {
    pub fn new(design: &Design) -> Self {
        let (queue, done) = (VecDeque::new(), Vec::new());
        Self { dram: design.dram, queue, done, requests: 0, read: [0; 3], written: [0; 3] }
    }

    pub fn read(&mut self, now: u64, stage: usize, bytes: u64) -> Ticket {
        self.read[stage] += bytes;
        self.issue(now, bytes, true)
    }

    pub fn write(&mut self, now: u64, stage: usize, bytes: u64) -> Ticket {
        self.written[stage] += bytes;
        self.issue(now, bytes, false)
    }

    fn issue(&mut self, now: u64, bytes: u64, is_read: bool) -> Ticket {
        let ticket = self.done.len();
        if bytes == 0 {
            self.done.push(Some((now + 1) * TICKS));
            return ticket;
        }
        self.requests += 1;
        self.done.push(None);
        self.queue.push_back(Queued { ticket, ticks_left: self.dram.service(bytes), is_read });
        ticket
    }

    pub fn is_done(&self, ticket: Ticket, now: u64) -> bool {
        self.done[ticket].is_some_and(|tick| tick <= now * TICKS)
    }

    /// The bus works for one cycle, after everybody has issued.
    pub fn tick(&mut self, now: u64) {
        let mut spent = 0;
        while spent < TICKS {
            let Some(head) = self.queue.front_mut() else { return };
            let moved = head.ticks_left.min(TICKS - spent);
            head.ticks_left -= moved;
            spent += moved;
            if head.ticks_left == 0 {
                let latency = if head.is_read { self.dram.latency } else { 0 };
                self.done[head.ticket] = Some(now * TICKS + spent + latency);
                self.queue.pop_front();
            }
        }
    }
}
