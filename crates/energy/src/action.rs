//! What hardware can be charged for: actions, how often each happened, and for which stage.
//!
//! Units charge actions (counts only); `energy` prices them. Nothing here knows a joule or a cycle,
//! or which actions there are: stages declare them ([`Hardware`]).

use crate::hardware::Hardware;
use powergs_base::quantity::Bytes;

/// The three phases of a frame, as in the published PowerGS breakdown, and the power that no work
/// causes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Phase {
    /// Cull, project, intersect (CCU).
    Preprocessing,
    /// Approximate and precise depth sorting (GSU: QSU and BSU).
    Sorting,
    /// α evaluation and blending (VRU), feature loads, colour from spherical harmonics.
    Rendering,
    /// Leakage and DRAM background: paid for time, not for work.
    Standby,
}

impl Phase {
    /// All stages, in report order.
    pub const ALL: [Phase; 4] =
        [Phase::Preprocessing, Phase::Sorting, Phase::Rendering, Phase::Standby];
    /// Stages that do work.
    pub const WORK: [Phase; 3] = [Phase::Preprocessing, Phase::Sorting, Phase::Rendering];

    /// The name in every output (snake_case).
    pub const fn name(self) -> &'static str {
        match self {
            Phase::Preprocessing => "preprocessing",
            Phase::Sorting => "sorting",
            Phase::Rendering => "rendering",
            Phase::Standby => "standby",
        }
    }
}

/// A number of something that stages declare: dense, from 0.
macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(u16);

        impl $name {
            /// The one with this position.
            ///
            /// # Panics
            /// Beyond 65,535.
            pub const fn new(index: usize) -> $name {
                assert!(index <= u16::MAX as usize, "there are fewer than 65,536 of anything");
                $name(index as u16)
            }

            /// Its position.
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }
    };
}

id! {
    /// A stage of a machine: units of a kind, or something that units share.
    StageId
}
id! {
    /// Something that hardware does and that costs energy.
    ActionId
}
id! {
    /// An on-chip buffer.
    BufferId
}
id! {
    /// Something that a unit has in an amount that an architect chooses.
    PartId
}

/// How one buffer is built.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Memory {
    /// Size of one bank.
    pub bank: Bytes,
    /// Banks in the whole machine; 0 where the machine has no such buffer.
    pub banks: u32,
    /// Bytes of one access of a bank.
    pub word: Bytes,
    /// Whether a bank reads and writes in the same cycle.
    pub two_ports: bool,
}

/// The hardware of a machine: everything that leaks and takes area.
#[derive(Debug, Clone, PartialEq)]
pub struct Inventory {
    /// By [`BufferId`].
    pub memories: Vec<Memory>,
    /// Units of each stage, by [`StageId`]; 0 for what is no unit, and where the machine has none.
    pub units: Vec<u32>,
    /// How much of each part one unit of its stage has, by [`PartId`].
    pub parts: Vec<f64>,
}

impl Inventory {
    /// Whether the machine has a buffer of a stage.
    pub(crate) fn has_buffer_of(&self, hardware: &Hardware, stage: StageId) -> bool {
        let own = hardware.buffers().filter(|(id, _)| hardware.stage_of(*id) == stage);
        own.into_iter().any(|(id, _)| self.memories[id.index()].banks > 0)
    }
}

/// How often each action happened, per phase.
#[derive(Debug, Clone, Default)]
pub struct ActionCounts {
    /// By [`ActionId`], up to the last that was charged.
    counts: [Vec<u64>; Phase::WORK.len()],
}

impl PartialEq for ActionCounts {
    fn eq(&self, other: &ActionCounts) -> bool {
        let n = |row: &[u64], i: usize| row.get(i).copied().unwrap_or(0);
        self.counts
            .iter()
            .zip(&other.counts)
            .all(|(a, b)| (0..a.len().max(b.len())).all(|i| n(a, i) == n(b, i)))
    }
}

impl Eq for ActionCounts {}

impl ActionCounts {
    /// Charges `n` times `action` to `phase`. `Standby` does no work and cannot be charged.
    #[inline]
    pub fn charge(&mut self, phase: Phase, action: ActionId, n: u64) {
        assert!(phase != Phase::Standby, "standby does no work: {action:?}");
        let count = self.at(phase as usize, action.index());
        *count = count.saturating_add(n);
    }

    #[inline]
    fn at(&mut self, row: usize, action: usize) -> &mut u64 {
        let row = &mut self.counts[row];
        if row.len() <= action {
            row.resize(action + 1, 0);
        }
        &mut row[action]
    }

    /// How often `action` happened in `phase`.
    pub fn count(&self, phase: Phase, action: ActionId) -> u64 {
        let row = self.counts.get(phase as usize);
        row.and_then(|row| row.get(action.index())).copied().unwrap_or(0)
    }

    /// How often `action` happened in all phases.
    pub fn total(&self, action: ActionId) -> u64 {
        Phase::WORK.into_iter().map(|phase| self.count(phase, action)).sum()
    }

    /// Adds the counts of `other` unless one of them would exceed `most`; returns whether it did.
    pub fn add_within(&mut self, other: &ActionCounts, most: u64) -> bool {
        let is_within = Phase::WORK.into_iter().all(|phase| {
            let theirs = other.counts[phase as usize].iter().enumerate();
            theirs
                .map(|(i, m)| (self.count(phase, ActionId::new(i)), m))
                .all(|(n, m)| n.checked_add(*m).is_some_and(|sum| sum <= most))
        });
        if is_within {
            self.add(other);
        }
        is_within
    }

    /// Adds the counts of `other`.
    pub fn add(&mut self, other: &ActionCounts) {
        for (row, theirs) in other.counts.iter().enumerate() {
            for (action, m) in theirs.iter().enumerate() {
                *self.at(row, action) += m;
            }
        }
    }
}
