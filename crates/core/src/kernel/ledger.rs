//! Cycle account of one unit, or of a gang of units that work together: busy, stalled by cause,
//! idle.

use crate::kernel::timeline::{Observer, Span, State};
use crate::stage::Stall;
use powergs_energy::action::StageId;

/// The account.
#[derive(Debug, Clone)]
pub(crate) struct Ledger {
    unit: StageId,
    instance: u32,
    pub busy: u64,
    /// By [`Stall::index`].
    pub stalls: [u64; Stall::MOST],
    pub idle: u64,
}

impl Ledger {
    pub(crate) fn new(unit: StageId, instance: u32) -> Self {
        Self { unit, instance, busy: 0, stalls: [0; Stall::MOST], idle: 0 }
    }

    /// Which CCU, or which core.
    pub(crate) fn instance(&self) -> u32 {
        self.instance
    }

    /// Books the cycles from `from` up to `to`.
    pub(crate) fn book(&mut self, state: State, from: u64, to: u64, observer: &mut impl Observer) {
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
