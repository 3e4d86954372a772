//! Filters over dataflows: what becomes of a frame before a machine takes it, whatever its
//! dataflow: which pixels are rendered at all, lists of frames before, the second eye.
//!
//! A filter takes a frame that was prepared for a machine, and what was kept of frames before, and
//! makes another one of it, with what moves for that. Turned off it makes none.

pub mod kept_order;
pub mod levels;
pub mod pixels;
pub mod second_eye;

use crate::kernel::Stall;
use crate::kernel::blocks::{BlockStream, BlockUnit, MovedBlock};
use crate::kernel::stream::Streams;
use crate::machine::Machine;
use powergs_energy::action::{ActionCounts, StageId};

/// A unit that is done before anything else of a frame begins: what it finds decides what the
/// others do.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstUnit {
    /// Its stage.
    pub stage: StageId,
    /// Items a cycle.
    pub rate: u64,
    /// The streams that it reads and writes.
    pub streams: [&'static str; 2],
    /// What it waits for where its bytes are on their way.
    pub waits: Stall,
    /// What it does.
    pub blocks: Vec<MovedBlock>,
    /// The same, as it is paid for.
    pub actions: ActionCounts,
}

impl FirstUnit {
    /// Those of a machine, in the order in which they act, for a frame of a scene of `points`
    /// Gaussians.
    pub fn of(machine: &Machine, points: u64) -> Vec<FirstUnit> {
        levels::first(machine, points).into_iter().collect()
    }

    /// Bytes that it reads and writes.
    pub fn bytes(&self) -> [u64; 2] {
        BlockStream::bytes(&self.blocks)
    }

    /// It in front of its first block: the agent that it is, and where what it reads and writes
    /// begins.
    pub(super) fn stream(&self, owner: u32, streams: &Streams, places: [u64; 2]) -> BlockStream {
        let FirstUnit { stage, rate, waits, .. } = *self;
        let streams = self.streams.map(|key| streams.id(key));
        BlockStream::new(BlockUnit { stage, owner, rate, streams, places, waits }, &self.blocks)
    }
}
