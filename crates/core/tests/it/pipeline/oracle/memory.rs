//! The memory: a queue, and a bus that moves 1024 ticks' worth in a cycle; or a device that is
//! asked in every cycle what is done.

use std::collections::VecDeque;

use powergs_core::flow::tile_wise::layout::{AccessPattern, Layout};
use powergs_core::flow::tile_wise::schedule::Plan;
use powergs_core::flow::tile_wise::{FrameContext, ResolvedUnits};
use powergs_core::kernel::dram::{Dram, TICKS};
use powergs_core::kernel::stream::Stream;
use powergs_core::machine::DramModel;
use powergs_core::machine::Machine;
use powergs_core::workload::FrameWorkload;
use powergs_dram::{self, Banked};

/// A stream of this direction: with one rate, all are alike.
fn any_stream(is_read: bool) -> Stream {
    if is_read { Stream::Features } else { Stream::Pixels }
}

/// A request, to ask for later.
pub type Ticket = usize;

struct Queued {
    ticket: Ticket,
    ticks_left: u64,
    is_read: bool,
}

enum Kind {
    Bus(Box<Dram>, VecDeque<Queued>),
    Banked(Box<Banked>, Vec<(AccessPattern, u64)>),
}

pub struct Memory<'a> {
    kind: Kind,
    /// Femtoseconds of a cycle and of a CK.
    clocks: (u64, u64),
    pub layout: Layout<'a>,
    /// Tick at which each ticket is done.
    done: Vec<Option<u64>>,
    pub requests: u64,
    pub read: [u64; 3],
    pub written: [u64; 3],
}

impl<'a> Memory<'a> {
    pub fn new(
        workload: &'a FrameWorkload,
        machine: &Machine,
        design: &ResolvedUnits,
        plan: &'a Plan,
        given: &FrameContext<'a>,
    ) -> Self {
        let device = || machine.device.as_ref().expect("linked");
        let kind = match machine.dram.model {
            DramModel::Bandwidth => Kind::Bus(Box::new(design.dram), VecDeque::new()),
            DramModel::Calibrated => panic!("the oracle has no run to calibrate with"),
            DramModel::Banked => Kind::Banked(Box::new(Banked::new(device())), Vec::new()),
        };
        let fs = |ns: f64| (ns * 1e6).round() as u64;
        Self {
            kind,
            clocks: (
                fs(1e9 / machine.clock.0),
                machine.device.as_ref().map_or(1, |device| fs(device.clock_period.0)),
            ),
            layout: Layout::new(workload, design, plan, given),
            done: Vec::new(),
            requests: 0,
            read: [0; 3],
            written: [0; 3],
        }
    }

    pub fn read(&mut self, now: u64, stage: usize, bytes: u64, span: AccessPattern) -> Ticket {
        self.read[stage] += bytes;
        self.issue(now, stage, bytes, span, true)
    }

    pub fn write(&mut self, now: u64, stage: usize, bytes: u64, span: AccessPattern) -> Ticket {
        self.written[stage] += bytes;
        self.issue(now, stage, bytes, span, false)
    }

    fn issue(
        &mut self,
        now: u64,
        stage: usize,
        bytes: u64,
        span: AccessPattern,
        is_read: bool,
    ) -> Ticket {
        let ticket = self.done.len();
        if bytes == 0 {
            self.done.push(Some((now + 1) * TICKS));
            if let Kind::Banked(_, spans) = &mut self.kind {
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
                let ticks_left = dram.service(any_stream(is_read), bytes);
                queue.push_back(Queued { ticket, ticks_left, is_read });
            }
            Kind::Banked(device, spans) => {
                spans.push((span, 0));
                device.push(powergs_dram::Request {
                    ticket: ticket as u32,
                    write: !is_read,
                    class: stage as u8,
                    arrival,
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
            Kind::Banked(device, spans) => {
                let layout = &self.layout;
                let until = (now + 1) * cycle / ck;
                let mut pieces = |ticket: u32| {
                    let (span, cursor) = &mut spans[ticket as usize];
                    layout.piece(span, cursor)
                };
                while let Some((end, ticket)) = device.advance(until, &mut pieces) {
                    let done = (end * ck).div_ceil(cycle).max(now + 1);
                    self.done[ticket as usize] = Some(done * TICKS);
                }
            }
            Kind::Bus(dram, queue) => {
                let mut spent = 0;
                while spent < TICKS {
                    let Some(head) = queue.front_mut() else { return };
                    let moved = head.ticks_left.min(TICKS - spent);
                    head.ticks_left -= moved;
                    spent += moved;
                    if head.ticks_left == 0 {
                        let latency = dram.latency(any_stream(head.is_read), 0);
                        self.done[head.ticket] = Some(now * TICKS + spent + latency);
                        queue.pop_front();
                    }
                }
            }
        }
    }
}
