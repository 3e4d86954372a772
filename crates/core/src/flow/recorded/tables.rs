//! The tables of a machine file.

use std::collections::BTreeMap;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{RecordedFlow, RecordedRun};
use crate::flow::Task;
use crate::machine::BufferSpec;

/// The tables of a machine whose run was made elsewhere.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Recorded {
    /// What ran, and where its run is.
    pub recorded: RecordedSpec,
}

crate::flow::flow_tables!(Recorded, RecordedFlow, [recorded]);

/// The `[recorded]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RecordedSpec {
    /// The run: a CSV file, beside the machine file (`docs/elsewhere.md`).
    pub file: String,
    /// Requests to the memory that may be under way; the oldest makes room.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "requests"))]
    pub outstanding: u32,
    /// What a frame of the run is, as comparisons call it: `render`, `train all`, `train visible`,
    /// `gradients`, `track`, each with `, 1 pixel in 256` or the like behind it.
    #[serde(default = "render", skip_serializing_if = "is_render")]
    pub task: String,
    /// Frames that are in the machine at once: a picture is there this number of frame times after
    /// its first read.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "frames"))]
    pub under_way: u32,
    /// Units that the machine has, by the name that energy tables know: what leaks and takes area.
    pub units: BTreeMap<String, RecordedUnit>,
    /// Buffers that the machine has, likewise; sizes and banks are those of all units together.
    #[serde(default)]
    pub buffers: BTreeMap<String, BufferSpec>,
    /// The run, once it has been read.
    #[serde(skip)]
    #[schemars(skip)]
    pub run: Attached,
}

/// Units of a kind.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RecordedUnit {
    /// How many.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "units"))]
    pub count: u32,
    /// What one of them has, as `[parts]` of energy tables names it: `lanes = 16`.
    #[serde(default)]
    pub parts: BTreeMap<String, PartAmount>,
}

/// How much of a part one unit has.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(transparent)]
#[schemars(extend("x-unit" = "amount of the part"))]
pub struct PartAmount(pub f64);

fn render() -> String {
    Task::RENDER.name()
}

fn is_render(task: &str) -> bool {
    task == render()
}

const fn one() -> u32 {
    1
}

const fn is_one(n: &u32) -> bool {
    *n == 1
}

impl RecordedSpec {
    /// How many units of a stage there are.
    pub fn count(&self, stage: &str) -> u32 {
        self.units.get(stage).map_or(0, |unit| unit.count)
    }
}

/// A run that has been read, or not yet. Runs are the same where their files are.
#[derive(Debug, Clone, Default)]
pub struct Attached(pub Option<Arc<RecordedRun>>);

impl Attached {
    /// The run; `None` before it has been read.
    pub fn get(&self) -> Option<&RecordedRun> {
        self.0.as_deref()
    }
}

impl PartialEq for Attached {
    fn eq(&self, other: &Attached) -> bool {
        self.get().map(|run| run.xxh3) == other.get().map(|run| run.xxh3)
    }
}
