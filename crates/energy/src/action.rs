//! What hardware can be charged for: actions, how often each happened, and for which stage.
//!
//! Units charge actions (counts only); `energy` prices them. Nothing here knows a joule or a cycle.

use powergs_base::quantity::Bytes;

/// The three stages of the pipeline, as in the published PowerGS breakdown, and the power that no
/// stage causes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Cull, project, intersect (CCU).
    Preprocessing,
    /// Approximate and precise depth sorting (GSU: QSU and BSU).
    Sorting,
    /// α evaluation and blending (VRU), feature loads, colour from spherical harmonics.
    Rendering,
    /// Leakage and DRAM background: paid for time, not for work.
    Standby,
}

impl Stage {
    /// All stages, in report order.
    pub const ALL: [Stage; 4] =
        [Stage::Preprocessing, Stage::Sorting, Stage::Rendering, Stage::Standby];
    /// Stages that do work.
    pub const WORK: [Stage; 3] = [Stage::Preprocessing, Stage::Sorting, Stage::Rendering];

    /// The name in every output (snake_case).
    pub const fn name(self) -> &'static str {
        match self {
            Stage::Preprocessing => "preprocessing",
            Stage::Sorting => "sorting",
            Stage::Rendering => "rendering",
            Stage::Standby => "standby",
        }
    }
}

/// The kinds of hardware unit, in pipeline order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum UnitKind {
    /// Culling and conversion.
    Ccu,
    /// Approximate sorting by pivots.
    Qsu,
    /// Precise bitonic sorting.
    Bsu,
    /// Volume rendering.
    Vru,
}

impl UnitKind {
    /// All kinds, in pipeline order.
    pub const ALL: [UnitKind; 4] = [UnitKind::Ccu, UnitKind::Qsu, UnitKind::Bsu, UnitKind::Vru];

    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            UnitKind::Ccu => "ccu",
            UnitKind::Qsu => "qsu",
            UnitKind::Bsu => "bsu",
            UnitKind::Vru => "vru",
        }
    }

    /// The stage that it works for.
    pub const fn stage(self) -> Stage {
        match self {
            UnitKind::Ccu => Stage::Preprocessing,
            UnitKind::Qsu | UnitKind::Bsu => Stage::Sorting,
            UnitKind::Vru => Stage::Rendering,
        }
    }
}

/// The on-chip buffers, named as in the published GSCore re-models (`hardware.md` §1.4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Buffer {
    /// Records on their way from DRAM to the CCU.
    GaussianIn,
    /// (key, id) pairs on their way from the CCU to DRAM.
    TileList,
    /// Keys of the tile that is being sorted.
    Sorting,
    /// Features of the chunk that is being rendered.
    Feature,
    /// Finished pixels on their way to DRAM.
    PixelOut,
    /// Feature records that another tile may need again.
    Cache,
    /// Where the next entry of each tile goes.
    Pointers,
    /// Entries of each tile on their way to DRAM.
    Combining,
    /// Coefficients of colours that records name by a number.
    Codebook,
}

impl Buffer {
    /// All buffers, in report order.
    pub const ALL: [Buffer; 9] = [
        Buffer::GaussianIn,
        Buffer::TileList,
        Buffer::Sorting,
        Buffer::Feature,
        Buffer::PixelOut,
        Buffer::Cache,
        Buffer::Pointers,
        Buffer::Combining,
        Buffer::Codebook,
    ];

    /// Those that fill and empty, in report order: the others are tables, which are always full.
    pub const FILLED: [Buffer; 5] =
        [Buffer::GaussianIn, Buffer::TileList, Buffer::Sorting, Buffer::Feature, Buffer::PixelOut];

    /// The name in every output (snake_case).
    pub const fn name(self) -> &'static str {
        match self {
            Buffer::GaussianIn => "gaussian_in",
            Buffer::TileList => "tile_list",
            Buffer::Sorting => "sorting",
            Buffer::Feature => "feature",
            Buffer::PixelOut => "pixel_out",
            Buffer::Cache => "cache",
            Buffer::Pointers => "pointers",
            Buffer::Combining => "combining",
            Buffer::Codebook => "codebook",
        }
    }
}

/// How one buffer is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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

/// What one unit, or the feature cache, is built of in amounts that an architect chooses. What else
/// a unit has is fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Part {
    /// Operations that a CCU makes a cycle, without box tests.
    CcuOperations,
    /// Box tests that a CCU makes a cycle.
    CcuIntersectionUnits,
    /// Tile levels that a CCU looks up a cycle.
    CcuLevelTests,
    /// Bits of the batches that a CCU has asked for: requests, and which records survive.
    CcuBatches,
    /// Pivots of a QSU.
    QsuPivots,
    /// Keys that a QSU compares with a pivot in a cycle.
    QsuComparators,
    /// Compare-exchanges of the network of a BSU.
    BsuNetwork,
    /// Bits of the lists and chunks that a core has asked for, over its BSUs.
    BsuQueue,
    /// Blends of a rendering unit a cycle, in all of its accumulators.
    VruBlend,
    /// Bits of the pixels that a rendering unit holds.
    VruPixels,
    /// Inverse of the cycles after which a rendering unit can blend into a pixel again.
    VruRecurrence,
    /// Bits of the feature records that a rendering unit holds: its own, of 19 B, and its share of
    /// the queues.
    VruQueue,
    /// Ways of the feature cache that are compared at a time.
    CacheWays,
}

impl Part {
    /// All parts.
    pub const ALL: [Part; 13] = [
        Part::CcuOperations,
        Part::CcuIntersectionUnits,
        Part::CcuLevelTests,
        Part::CcuBatches,
        Part::QsuPivots,
        Part::QsuComparators,
        Part::BsuNetwork,
        Part::BsuQueue,
        Part::VruBlend,
        Part::VruPixels,
        Part::VruRecurrence,
        Part::VruQueue,
        Part::CacheWays,
    ];

    /// The unit that it is a part of; `None` for the feature cache.
    pub const fn unit(self) -> Option<UnitKind> {
        match self {
            Part::CcuOperations
            | Part::CcuIntersectionUnits
            | Part::CcuLevelTests
            | Part::CcuBatches => Some(UnitKind::Ccu),
            Part::QsuPivots | Part::QsuComparators => Some(UnitKind::Qsu),
            Part::BsuNetwork | Part::BsuQueue => Some(UnitKind::Bsu),
            Part::VruBlend | Part::VruPixels | Part::VruRecurrence | Part::VruQueue => {
                Some(UnitKind::Vru)
            }
            Part::CacheWays => None,
        }
    }
}

/// The hardware of a machine: everything that leaks and takes area.
#[derive(Debug, Clone, PartialEq)]
pub struct Inventory {
    /// In the order of [`Buffer::ALL`].
    pub memories: [Memory; Buffer::ALL.len()],
    /// CCUs, QSUs, BSUs and rendering units.
    pub units: [u32; 4],
    /// How much of each part one unit has, in the order of [`Part::ALL`].
    pub parts: [f64; Part::ALL.len()],
    /// Operations a cycle of all colour units; 0 where CCUs evaluate colours.
    pub colour_operations: f64,
}

/// Something that a unit does and that costs energy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Action {
    /// One Gaussian taken through cull and the part of projection that the cull needs.
    Cull,
    /// One survivor projected to a 2D covariance, with its bounding box.
    Project,
    /// Axes of the oriented box of one splat that needs box tests.
    ObbPrepare,
    /// One oriented-box-against-tile test.
    ObbTest,
    /// One view-dependent colour from spherical harmonics.
    ShColour,
    /// One key moved through the pivots of a QSU in one pass.
    PivotKey,
    /// One compare-exchange of a BSU.
    CompareExchange,
    /// One row that a BSU sorts.
    SortedRow,
    /// One row that a BSU merges from two lists.
    MergedRow,
    /// One α evaluated for one live pixel, whether or not it contributes.
    Alpha,
    /// One slot of a pixel that has stopped, or is outside of the image, in a pair that is worked
    /// on.
    StoppedPixel,
    /// One blend of a splat into one pixel.
    Blend,
    /// One pixel finished: background added and written out.
    PixelFinish,
    /// One feature record pushed into a queue in front of rendering units, and taken out.
    QueueEntry,
    /// One cycle of a unit that has work or waits with it.
    Clock(UnitKind),
    /// One cycle of a unit without work.
    IdleClock(UnitKind),
    /// One byte read from a buffer.
    SramRead(Buffer),
    /// One byte written to a buffer.
    SramWrite(Buffer),
    /// One byte read from DRAM.
    DramRead,
    /// One byte written to DRAM.
    DramWrite,
}

impl Action {
    /// Number of actions: the length of a row of [`ActionCounts`].
    pub const COUNT: usize = 16 + 2 * UnitKind::ALL.len() + 2 * Buffer::ALL.len();

    /// All actions, in the order of [`Action::index`].
    pub fn all() -> [Action; Self::COUNT] {
        use Action::*;
        let (b, u) = (Buffer::ALL, UnitKind::ALL);
        [
            Cull,
            Project,
            ObbPrepare,
            ObbTest,
            ShColour,
            PivotKey,
            CompareExchange,
            SortedRow,
            MergedRow,
            Alpha,
            StoppedPixel,
            Blend,
            PixelFinish,
            QueueEntry,
            Clock(u[0]),
            Clock(u[1]),
            Clock(u[2]),
            Clock(u[3]),
            IdleClock(u[0]),
            IdleClock(u[1]),
            IdleClock(u[2]),
            IdleClock(u[3]),
            DramRead,
            DramWrite,
            SramRead(b[0]),
            SramRead(b[1]),
            SramRead(b[2]),
            SramRead(b[3]),
            SramRead(b[4]),
            SramRead(b[5]),
            SramRead(b[6]),
            SramRead(b[7]),
            SramRead(b[8]),
            SramWrite(b[0]),
            SramWrite(b[1]),
            SramWrite(b[2]),
            SramWrite(b[3]),
            SramWrite(b[4]),
            SramWrite(b[5]),
            SramWrite(b[6]),
            SramWrite(b[7]),
            SramWrite(b[8]),
        ]
    }

    /// Position in a row of [`ActionCounts`].
    pub const fn index(self) -> usize {
        match self {
            Action::Cull => 0,
            Action::Project => 1,
            Action::ObbPrepare => 2,
            Action::ObbTest => 3,
            Action::ShColour => 4,
            Action::PivotKey => 5,
            Action::CompareExchange => 6,
            Action::SortedRow => 7,
            Action::MergedRow => 8,
            Action::Alpha => 9,
            Action::StoppedPixel => 10,
            Action::Blend => 11,
            Action::PixelFinish => 12,
            Action::QueueEntry => 13,
            Action::Clock(u) => 14 + u as usize,
            Action::IdleClock(u) => 14 + UnitKind::ALL.len() + u as usize,
            Action::DramRead => 14 + 2 * UnitKind::ALL.len(),
            Action::DramWrite => 15 + 2 * UnitKind::ALL.len(),
            Action::SramRead(b) => 16 + 2 * UnitKind::ALL.len() + b as usize,
            Action::SramWrite(b) => 16 + 2 * UnitKind::ALL.len() + Buffer::ALL.len() + b as usize,
        }
    }

    /// The name in energy tables (kebab-case) and, with `_`, in outputs: `alpha`,
    /// `sram-read.feature`.
    pub fn key(self) -> String {
        match self {
            Action::Cull => "cull".into(),
            Action::Project => "project".into(),
            Action::ObbPrepare => "obb-prepare".into(),
            Action::ObbTest => "obb-test".into(),
            Action::ShColour => "sh-colour".into(),
            Action::PivotKey => "pivot-key".into(),
            Action::CompareExchange => "compare-exchange".into(),
            Action::SortedRow => "sorted-row".into(),
            Action::MergedRow => "merged-row".into(),
            Action::Alpha => "alpha".into(),
            Action::StoppedPixel => "stopped-pixel".into(),
            Action::Blend => "blend".into(),
            Action::PixelFinish => "pixel-finish".into(),
            Action::QueueEntry => "queue-entry".into(),
            Action::Clock(u) => format!("clock.{}", u.name()),
            Action::IdleClock(u) => format!("idle-clock.{}", u.name()),
            Action::DramRead => "dram-read".into(),
            Action::DramWrite => "dram-write".into(),
            Action::SramRead(b) => format!("sram-read.{}", b.name().replace('_', "-")),
            Action::SramWrite(b) => format!("sram-write.{}", b.name().replace('_', "-")),
        }
    }
}

/// How often each action happened, per stage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ActionCounts {
    counts: [[u64; Action::COUNT]; Stage::WORK.len()],
}

impl Default for ActionCounts {
    fn default() -> Self {
        Self { counts: [[0; Action::COUNT]; Stage::WORK.len()] }
    }
}

impl ActionCounts {
    /// Charges `n` times `action` to `stage`. `Standby` does no work and cannot be charged.
    pub fn charge(&mut self, stage: Stage, action: Action, n: u64) {
        assert!(stage != Stage::Standby, "standby does no work: {action:?}");
        let count = &mut self.counts[stage as usize][action.index()];
        *count = count.saturating_add(n);
    }

    /// How often `action` happened for `stage`.
    pub fn count(&self, stage: Stage, action: Action) -> u64 {
        self.counts.get(stage as usize).map_or(0, |row| row[action.index()])
    }

    /// How often `action` happened in all stages.
    pub fn total(&self, action: Action) -> u64 {
        self.counts.iter().map(|row| row[action.index()]).sum()
    }

    /// Adds the counts of `other` unless one of them would exceed `most`; returns whether it did.
    pub fn add_within(&mut self, other: &ActionCounts, most: u64) -> bool {
        let fits = |(n, m): (&u64, &u64)| n.checked_add(*m).is_some_and(|sum| sum <= most);
        let rows = || self.counts.iter().zip(&other.counts);
        let is_within = rows().all(|(row, theirs)| row.iter().zip(theirs).all(fits));
        if is_within {
            self.add(other);
        }
        is_within
    }

    /// Adds the counts of `other`.
    pub fn add(&mut self, other: &ActionCounts) {
        for (row, theirs) in self.counts.iter_mut().zip(&other.counts) {
            for (n, m) in row.iter_mut().zip(theirs) {
                *n += m;
            }
        }
    }
}
