//! What a frame does on a machine, from its totals alone: actions and DRAM bytes.
//!
//! Nothing here depends on time. The pipeline moves the same bytes request by request; that both
//! agree is checked in every run.

use super::batch::Batch;
use super::design::Design;
use super::machine::Fetch;
use super::qsu::List;
use super::unit::Unit;
use super::vru::Render;
use crate::action::{Action, ActionCounts, Stage};
use crate::workload::{ChunkWork, FrameWorkload, TileWork};

/// DRAM bytes of one stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StageTraffic {
    /// Read.
    pub read: u64,
    /// Written.
    pub write: u64,
}

/// DRAM bytes by stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Traffic {
    /// In the order of [`Stage::WORK`].
    pub stages: [StageTraffic; 3],
}

impl Traffic {
    /// Sum over stages.
    pub fn total(&self) -> StageTraffic {
        let [a, b, c] = self.stages;
        StageTraffic { read: a.read + b.read + c.read, write: a.write + b.write + c.write }
    }
}

/// Feature and colour bytes that a chunk loads.
pub fn chunk_read(chunk: &ChunkWork, design: &Design) -> u64 {
    let record = &design.ccu.record;
    let colours = match design.ccu.spec.fetch {
        Fetch::LazyColour => u64::from(chunk.first_loads) * record.colour.0,
        Fetch::Everything | Fetch::GeometryFirst => 0,
    };
    u64::from(chunk.entries) * record.feature.0 + colours
}

/// The DRAM bytes of a frame.
pub fn traffic(workload: &FrameWorkload, design: &Design) -> Traffic {
    let whole = Batch::whole(workload);
    let ccu = &design.ccu;
    let preprocessing = StageTraffic {
        read: ccu.first_read(&whole) + ccu.second_read(&whole),
        write: ccu.written(&whole),
    };
    let mut sorting = StageTraffic::default();
    let mut rendering = StageTraffic::default();
    for tile in &workload.tiles {
        let list = List { entries: u64::from(tile.entries) };
        let spill = u64::from(design.qsu.passes(list)) * design.qsu.overflow(list);
        sorting.read += list.entries * design.qsu.key + spill;
        sorting.write += spill;
        rendering.write += design.vru.pixel_bytes(tile);
    }
    for chunk in &workload.chunks {
        rendering.read += chunk_read(chunk, design);
    }
    Traffic { stages: [preprocessing, sorting, rendering] }
}

/// The chunks of a tile.
pub fn chunks_of<'a>(workload: &'a FrameWorkload, tile: &TileWork) -> &'a [ChunkWork] {
    &workload.chunks[tile.chunk_start as usize..][..tile.chunks as usize]
}

/// All actions of a frame.
pub fn actions(workload: &FrameWorkload, design: &Design) -> ActionCounts {
    let mut actions = ActionCounts::default();
    design.ccu.charge(&Batch::whole(workload), &mut actions);
    for tile in &workload.tiles {
        design.qsu.charge(&List { entries: u64::from(tile.entries) }, &mut actions);
        for chunk in chunks_of(workload, tile) {
            design.bsu.charge(chunk, &mut actions);
            design.vru.charge(&Render { chunk: *chunk, last: None }, &mut actions);
        }
        let end = Render { chunk: ChunkWork::default(), last: Some(*tile) };
        design.vru.charge(&end, &mut actions);
    }
    for (stage, bytes) in Stage::WORK.into_iter().zip(traffic(workload, design).stages) {
        actions.charge(stage, Action::DramRead, bytes.read);
        actions.charge(stage, Action::DramWrite, bytes.write);
    }
    actions
}
