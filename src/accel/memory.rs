//! The memory as the units see it: requests go in, and at some cycle they are done.
//!
//! With the `bandwidth` and `window` models that cycle is known when a request is issued. With the
//! `banked` model it is known when it comes: requests are reordered, so a later one may still get in
//! between.

use super::DramUse;
use super::dram::Channel;
use super::layout::{Layout, Span};
use super::traffic::Traffic;
use crate::action::Stage;
use crate::workload::FrameWorkload;

/// No cycle.
pub const NEVER: u64 = u64::MAX;

/// A request under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival(u64);

impl Arrival {
    /// Nothing is waited for.
    pub const NOW: Arrival = Arrival(0);
}

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Request {
    /// Which agent asks, and is woken.
    pub owner: u32,
    /// On behalf of which stage.
    pub stage: Stage,
    /// Whether it writes.
    pub write: bool,
    /// Bytes asked for.
    pub bytes: u64,
    /// Where they are.
    pub span: Span,
}

/// Somebody who wants to know the requests.
pub trait Listener {
    /// Whether anybody wants to know.
    const LISTENS: bool;
    /// Takes a piece of a request.
    fn request(&mut self, write: bool, address: u64, bytes: u64);
}

/// The memory of one frame.
pub struct Memory<'a> {
    workload: &'a FrameWorkload,
    layout: Layout,
    flat: Channel,
    traffic: Traffic,
}

impl<'a> Memory<'a> {
    /// An idle memory.
    pub fn new(workload: &'a FrameWorkload, layout: Layout, flat: Channel) -> Memory<'a> {
        Memory { workload, layout, flat, traffic: Traffic::default() }
    }

    /// Where things lie.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Issues a request in cycle `now`. Nothing is asked for in a request of no bytes, which is done
    /// one cycle later.
    pub fn issue(&mut self, now: u64, request: Request, listener: &mut impl Listener) -> Arrival {
        if request.bytes == 0 {
            return Arrival(now + 1);
        }
        let stage = &mut self.traffic.stages[request.stage as usize];
        *(if request.write { &mut stage.write } else { &mut stage.read }) += request.bytes;
        self.tell(&request, listener);
        Arrival(self.flat.serve(now, request.write, request.bytes))
    }

    fn tell<L: Listener>(&self, request: &Request, listener: &mut L) {
        if !L::LISTENS {
            return;
        }
        let mut cursor = 0;
        while let Some(p) = self.layout.piece(&request.span, &mut cursor, self.workload) {
            listener.request(request.write, p.address, p.bytes);
        }
    }

    /// The cycle in which a request is done; [`NEVER`] while that is not known.
    pub fn at(&self, arrival: Arrival) -> u64 {
        arrival.0
    }

    /// Works until a request is done whose end was not known, at most until cycle `until`: the
    /// cycle, and the agent that asked.
    pub fn advance(&mut self, _until: u64) -> Option<(u64, u32)> {
        None
    }

    /// Bytes asked for, by stage.
    pub fn traffic(&self) -> Traffic {
        self.traffic
    }

    /// What the memory did.
    pub fn usage(&self) -> DramUse {
        let total = self.traffic.total();
        DramUse { read_bytes: total.read, write_bytes: total.write, ..self.flat.usage() }
    }
}
