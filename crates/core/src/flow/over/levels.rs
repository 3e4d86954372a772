//! Levels of detail (`[levels]`; A152): the traversal of the hierarchy that a frame's Gaussians are
//! the cut of, before anything else of it.
//!
//! A model of levels is a tree: a node has some Gaussians, and `children` nodes of the next finer
//! level. The cut of a frame are the nodes whose Gaussians it has; the one of the frame before is
//! kept, and its nodes are looked at again: projected, and compared with the size that they may
//! have on the screen, each with the node above it, which may take its place. One in `period` is
//! looked at in a frame. Node by node the cut is read, its records are, and the new cut is written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::FirstUnit;
use crate::kernel::blocks::{BlockStream, MovedBlock};
use crate::kernel::stream::{reads, writes};
use crate::machine::check::{Found, RECORD_MAX, SIZE_MAX};
use crate::machine::{BufferSpec, Machine, Optional, Ports};
use crate::stage::{
    Bias, DRAM_READ, DRAM_WRITE, StageDecl, Stall, buffer, buffer_id, double, omit, part,
    sram_read, sram_write, stage_id, work, work_id,
};
use powergs_base::quantity::Bytes;
use powergs_energy::action::{ActionCounts, ActionId, BufferId, Memory, Phase, StageId};

/// The `[levels]` table: the hierarchy of levels of detail, and the unit that traverses it.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct LevelsSpec {
    /// Gaussians of a node of the cut, in the mean; 0 for models without levels.
    #[schemars(range(min = 0, max = 1048576), extend("x-unit" = "Gaussians"))]
    pub gaussians: u32,
    /// Nodes of the next finer level below a node.
    #[schemars(range(min = 2, max = 64), extend("x-unit" = "nodes"))]
    pub children: u32,
    /// Bytes of a node: bounds, the size of what it leaves out, its Gaussians, its first child.
    pub record: Bytes,
    /// Bytes of a node of the cut that is kept.
    pub entry: Bytes,
    /// Frames in which every node of the cut is looked at once.
    #[schemars(range(min = 1, max = 1000), extend("x-unit" = "frames"))]
    pub period: u32,
    /// Operations of a node.
    #[schemars(range(min = 1, max = 10000), extend("x-unit" = "operations"))]
    pub operations: u32,
    /// Operations that the unit does in a cycle.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "operations per cycle"))]
    pub operations_per_cycle: u32,
    /// On chip: records and entries on their way.
    pub buffer: BufferSpec,
}

impl Default for LevelsSpec {
    /// No levels; what there is where the file says only how many Gaussians a node has (A152).
    fn default() -> LevelsSpec {
        LevelsSpec {
            gaussians: 0,
            children: 8,
            record: Bytes(32),
            entry: Bytes(4),
            period: 1,
            operations: 48,
            operations_per_cycle: 48,
            buffer: BufferSpec {
                capacity: Bytes(8 << 10),
                word: Bytes(32),
                banks: 1,
                ports: Ports::ReadOrWrite,
            },
        }
    }
}

/// Operations that are paid for as one test of a box, which has as many.
const TEST: u64 = 48;

/// Blocks that have a place in the buffer: the one at work, and those that are read ahead.
const HELD: u64 = 5;

impl LevelsSpec {
    /// Whether models have levels.
    pub fn is_there(&self) -> bool {
        self.gaussians > 0
    }

    /// Nodes that a block has.
    fn block(&self) -> u64 {
        (self.buffer.capacity.0 / HELD / (self.record.0 + self.entry.0).max(1)).max(1)
    }

    /// What is looked at for a frame of `points` Gaussians, block by block; items are operations.
    pub fn blocks(&self, points: u64) -> Vec<MovedBlock> {
        if !self.is_there() {
            return Vec::new();
        }
        let cut = points.div_ceil(u64::from(self.gaussians));
        let nodes = cut.div_ceil(u64::from(self.period));
        let step = self.block();
        let block = |first: u64| {
            let own = step.min(nodes - first);
            // Those above them, some of which two blocks share.
            let above = own.div_ceil(u64::from(self.children));
            MovedBlock {
                items: (own + above) * u64::from(self.operations),
                read: own * self.entry.0 + (own + above) * self.record.0,
                write: own * self.entry.0,
            }
        };
        (0..nodes).step_by(step as usize).map(block).collect()
    }
}

fn spec(m: &Machine) -> &LevelsSpec {
    m.of_type()
}

/// What the unit declares.
pub const LEVELS: StageDecl = StageDecl {
    units: Some(|m| u32::from(spec(m).is_there())),
    works: &[work(
        "level-test",
        TEST as u32,
        "48 operations of the levels: a node, if it has as many.",
    )
    .a_cycle(|m| f64::from(spec(m).operations_per_cycle) / TEST as f64)
    .priced_as("obb-test")],
    buffers: &[buffer("levels", "levels.buffer", |m| {
        let memory = spec(m).buffer.shared(1);
        match spec(m).is_there() {
            true => memory,
            false => Memory { bank: Bytes(0), banks: 0, ..memory },
        }
    })
    .full()],
    streams: &[
        reads("levels-in", "nodes of the cut", &[], ["records", "lists"]).scattered(),
        writes("levels-out", "the cut that is kept", ["results", "pixels"]),
    ],
    counted_in: Some(("ccu", "operations")),
    parts: &[part("operations", "Operations a cycle: `levels.operations-per-cycle`.", |m| {
        f64::from(spec(m).operations_per_cycle)
    })],
    also_waits: &["records"],
    doubles: &[double("levels.operations-per-cycle", &["levels.operations-per-cycle"], &["A152"])],
    omits: &[omit("nodes of the cut that split or merge in a frame", Bias::Optimistic, "A152")
        .by("levels.gaussians > 0", |m| spec(m).is_there())],
    behind: &["A152"],
    optional: &[Optional {
        what: "levels of detail",
        switch: "levels.gaussians",
        keys: &[
            "levels.children",
            "levels.record",
            "levels.entry",
            "levels.period",
            "levels.operations",
            "levels.operations-per-cycle",
            "levels.buffer",
        ],
        with: &["levels.gaussians=16", "levels.operations-per-cycle=1"],
        is_there: |m| spec(m).is_there(),
    }],
    check: Some(check),
    ..StageDecl::new(
        "ltu",
        "level traversal unit (LTU)",
        Phase::Preprocessing,
        "Finds the Gaussians of a frame in a model of levels: the cut of the frame before, node by \
         node. Keys: `levels`.",
    )
};

/// The unit.
pub const LTU: StageId = stage_id("ltu");
const LEVEL_TEST: ActionId = work_id("level-test");
/// Nodes on their way.
const NODES: BufferId = buffer_id("levels");

/// The unit, where a machine has one, with what it does for a frame of `points` Gaussians.
pub(super) fn first(machine: &Machine, points: u64) -> Option<FirstUnit> {
    let spec = machine.tables.get::<LevelsSpec>().filter(|spec| spec.is_there())?;
    let blocks = spec.blocks(points);
    let items: u64 = blocks.iter().map(|block| block.items).sum();
    let [read, write] = BlockStream::bytes(&blocks);
    let mut actions = ActionCounts::default();
    let all = [
        (LEVEL_TEST, items.div_ceil(TEST)),
        (DRAM_READ, read),
        (DRAM_WRITE, write),
        // What is read passes through the buffer, and what is written comes from it.
        (sram_write(NODES), read),
        (sram_read(NODES), read + write),
    ];
    all.into_iter().for_each(|(action, n)| actions.charge(Phase::Preprocessing, action, n));
    Some(FirstUnit {
        stage: LTU,
        rate: spec.operations_per_cycle.into(),
        streams: ["levels-in", "levels-out"],
        waits: Stall::of("records"),
        blocks,
        actions,
    })
}

/// Sizes of the unit.
fn check(machine: &Machine, found: &mut Found) {
    let spec = spec(machine);
    if !spec.is_there() {
        return;
    }
    for (key, bytes) in [("levels.record", spec.record), ("levels.entry", spec.entry)] {
        if !(1..=RECORD_MAX.0).contains(&bytes.0) {
            found.add(key, format!("`{key}` = {bytes} must be from 1 B to {RECORD_MAX}"));
        }
    }
    let least = Bytes(HELD * (spec.record.0.saturating_add(spec.entry.0)));
    let capacity = spec.buffer.capacity;
    if !(least..=SIZE_MAX).contains(&capacity) {
        let message = format!(
            "`levels.buffer.capacity` = {capacity} must be from {least}, a node at work and four \
             that are read ahead, to {SIZE_MAX}"
        );
        found.add("levels.buffer.capacity", message);
        found.ends_with("levels.buffer.capacity", format!("{} B", least.0));
    }
    if !(1..=capacity.0).contains(&spec.buffer.word.0) {
        let message = format!(
            "`levels.buffer.word` = {} must be from 1 B to the capacity, {capacity}",
            spec.buffer.word
        );
        found.add("levels.buffer.word", message);
    }
}
