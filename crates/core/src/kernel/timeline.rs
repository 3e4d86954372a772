//! What every unit did when: the pipeline tells an [`Observer`], and [`Timeline`] keeps it.

use super::Stall;
use powergs_energy::action::{BufferId, StageId};

/// The state of a unit in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It works on an item: a batch in a CCU, a tile in the other units.
    Busy(u32),
    /// It has work that cannot proceed.
    Stalled(Stall),
    /// It has no work.
    Idle,
}

/// Some cycles of one unit, or of the units of one kind in one core.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// Which kind of unit.
    pub unit: StageId,
    /// Which CCU, or which core.
    pub instance: u32,
    /// Its state.
    pub state: State,
    /// First cycle.
    pub from: u64,
    /// First cycle after it.
    pub to: u64,
}

/// The occupancy of one share of a buffer from a cycle on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Level {
    /// The buffer.
    pub buffer: BufferId,
    /// Which CCU, or which core.
    pub instance: u32,
    /// First cycle.
    pub from: u64,
    /// Bytes.
    pub bytes: u64,
}

/// Somebody who wants to know. Spans of one unit come in order and without gaps, except that those
/// of a BSU are told when they are decided.
pub trait Observer {
    /// Whether it wants to know anything: else a machine may take over what another one did.
    fn watches(&self) -> bool {
        true
    }

    /// Whether it wants to know the requests to the DRAM.
    fn wants_requests(&self) -> bool {
        false
    }

    /// Whether it wants to know when requests to a device were made and done.
    fn wants_times(&self) -> bool {
        false
    }

    /// Whether it wants to know what buffers hold.
    fn wants_levels(&self) -> bool {
        false
    }

    /// Takes a span that is not empty.
    fn span(&mut self, span: Span);
    /// Takes a contiguous piece of a request, in the order in which requests are issued.
    fn request(&mut self, _is_write: bool, _address: u64, _bytes: u64) {}
    /// Takes the occupancy of a buffer's share; in order of time for each share, also where it has
    /// not changed.
    fn level(&mut self, _level: Level) {}
}

/// Nobody.
impl Observer for () {
    fn watches(&self) -> bool {
        false
    }

    fn span(&mut self, _: Span) {}
}

/// Somebody who is known at run time only.
impl Observer for &mut dyn Observer {
    fn watches(&self) -> bool {
        (**self).watches()
    }

    fn wants_requests(&self) -> bool {
        (**self).wants_requests()
    }

    fn wants_times(&self) -> bool {
        (**self).wants_times()
    }

    fn wants_levels(&self) -> bool {
        (**self).wants_levels()
    }

    fn span(&mut self, span: Span) {
        (**self).span(span);
    }

    fn request(&mut self, is_write: bool, address: u64, bytes: u64) {
        (**self).request(is_write, address, bytes);
    }

    fn level(&mut self, level: Level) {
        (**self).level(level);
    }
}

/// Keeps all spans.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Timeline {
    /// The spans, as told.
    pub spans: Vec<Span>,
}

impl Observer for Timeline {
    fn span(&mut self, span: Span) {
        self.spans.push(span);
    }
}
