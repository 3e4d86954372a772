//! Cycle account of one unit, or of a gang of units that work together: busy, stalled by cause,
//! idle.

use crate::kernel::Stall;
use crate::kernel::UnitCycles;
use crate::kernel::timeline::{Observer, Span, State};
use powergs_energy::action::StageId;

/// The account.
#[derive(Debug, Clone)]
pub struct Ledger {
    unit: StageId,
    instance: u32,
    /// Cycles with work.
    pub busy: u64,
    /// By [`Stall::index`].
    pub stalls: [u64; Stall::MOST],
    /// Cycles without work.
    pub idle: u64,
}

impl Ledger {
    /// A unit, and which of its kind, before its first cycle.
    pub fn new(unit: StageId, instance: u32) -> Self {
        Self { unit, instance, busy: 0, stalls: [0; Stall::MOST], idle: 0 }
    }

    /// Which CCU, or which core.
    pub fn instance(&self) -> u32 {
        self.instance
    }

    /// Books the cycles from `from` up to `to`.
    pub fn book(&mut self, state: State, from: u64, to: u64, observer: &mut impl Observer) {
        if from >= to {
            return;
        }
        match state {
            State::Busy(_) => self.busy += to - from,
            State::Stalled(cause) => self.stalls[cause.index()] += to - from,
            State::Idle => self.idle += to - from,
        }
        observer.span(Span { unit: self.unit, instance: self.instance, state, from, to });
    }
}

/// The account of a unit that says, whenever it acts, in which state it is from then on.
#[derive(Debug, Clone)]
pub struct Account {
    /// What is booked.
    pub ledger: Ledger,
    state: State,
    since: u64,
}

impl Account {
    /// A unit, and which of its kind: without work from cycle 0 on.
    pub fn new(unit: StageId, instance: u32) -> Account {
        Account { ledger: Ledger::new(unit, instance), state: State::Idle, since: 0 }
    }

    /// Books the cycles up to `now`.
    pub fn up_to(&mut self, now: u64, observer: &mut impl Observer) {
        self.ledger.book(self.state, self.since, now, observer);
        self.since = self.since.max(now);
    }

    /// Says how it is from the last booked cycle on.
    pub fn is(&mut self, state: State) {
        self.state = state;
    }
}

/// Sums the ledgers of gangs of `gang` units each.
pub fn cycles<'a>(
    unit: StageId,
    gang: u32,
    ledgers: impl Iterator<Item = &'a Ledger>,
) -> UnitCycles {
    let stalls = [0; Stall::MOST];
    let mut sum = UnitCycles { unit, instances: 0, busy: 0, stalls, idle: 0 };
    for ledger in ledgers {
        sum.instances += gang;
        sum.busy += ledger.busy * u64::from(gang);
        sum.idle += ledger.idle * u64::from(gang);
        for (total, cycles) in sum.stalls.iter_mut().zip(ledger.stalls) {
            *total += cycles * u64::from(gang);
        }
    }
    sum
}
