//! The tables of a machine file.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

pub use super::gradients::GradientsSpec;
use super::rules::UnitRules;
pub use crate::flow::steps::TrainingSpec;
use crate::machine::{BufferSpec, Machine, Ports};
use crate::workload::binning::ListShape;
use crate::workload::{FrameDetail, Geometry};

pub use crate::workload::cache::Eviction;
use crate::workload::cache::Victims;
pub use crate::workload::order::{DepthKey, PivotRule, TileOrder};
use powergs_base::config::layer;
use powergs_base::number::NumberFormat;
use powergs_base::quantity::{Bytes, Hertz};
use powergs_frame::scene::ShDegree;

/// `none` is what a machine says whose base has a format.
fn some_numbers<'de, D: Deserializer<'de>>(from: D) -> Result<Option<NumberFormat>, D::Error> {
    let text = String::deserialize(from)?;
    match text == layer::NONE {
        true => Ok(None),
        false => text.parse().map(Some).map_err(serde::de::Error::custom),
    }
}

/// The tables of a tile-wise machine.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct TileWise {
    /// What decides the work: tile, sub-tile, chunk, intersection test.
    pub geometry: Geometry,
    /// Bytes of every record that crosses the DRAM interface.
    pub record: RecordSpec,
    /// Colours that records name by a number.
    #[serde(default)]
    pub codebook: CodebookSpec,
    /// Culling and conversion units.
    pub ccu: CcuSpec,
    /// Gaussian sorting units.
    pub gsu: GsuSpec,
    /// Volume rendering units.
    pub vru: VruSpec,
    /// What it has for foveated frames.
    #[serde(default)]
    pub fovea: FoveaSpec,
    /// On-chip buffers.
    pub buffers: BufferSpecs,
    /// How pairs get into the lists of tiles.
    #[serde(default)]
    pub binning: BinningSpec,
    /// Cache of feature records between the feature buffers and the DRAM.
    #[serde(default)]
    pub cache: CacheSpec,
    /// How the second view of a pair is made.
    #[serde(default)]
    pub stereo: StereoSpec,
    /// Which pixels are rendered, and where the others come from.
    #[serde(default)]
    pub pixels: PixelsSpec,
    /// What comes behind a frame that is trained on.
    #[serde(default)]
    pub training: TrainingSpec,
    /// Units that find gradients by what was blended.
    #[serde(default)]
    pub gradients: GradientsSpec,
    /// Which tile goes where, and what may overlap.
    pub schedule: ScheduleSpec,
    /// Timing rules from outside of this program.
    #[serde(default, skip_serializing_if = "UnitRules::are_built_in")]
    pub rules: UnitRules,
}

crate::flow::flow_tables!(
    TileWise,
    super::TileWiseFlow,
    [
        geometry, record, codebook, ccu, gsu, vru, fovea, buffers, binning, cache, stereo, pixels,
        training, gradients, schedule,
    ]
);

impl Machine {
    /// The tables of a tile-wise machine.
    ///
    /// # Panics
    /// On a machine of another dataflow.
    pub fn tiles(&self) -> &TileWise {
        self.tables.get().expect("a machine of this dataflow has its tables")
    }

    /// The same, to be changed.
    ///
    /// # Panics
    /// On a machine of another dataflow.
    pub fn tiles_mut(&mut self) -> &mut TileWise {
        self.tables.all_mut().expect("a machine of this dataflow has its tables")
    }
}

impl TileWise {
    /// Bytes of a list entry: depth, number of the splat, bitmap and distance to its next tile, in
    /// whole bytes.
    pub fn list_entry(&self) -> u64 {
        let subtiles = self.geometry.tile / self.geometry.subtile.max(1);
        let bitmap = if self.record.entry_bitmap { u64::from(subtiles).pow(2) } else { 0 };
        let bits = u64::from(self.record.depth_bits) + u64::from(self.record.id_bits) + bitmap;
        (bits + u64::from(self.cache.carried_bits())).div_ceil(8)
    }

    /// How its lists are made; `None` where they are there for nothing.
    pub fn list_shape(&self) -> Option<ListShape> {
        let b = &self.binning;
        let block = match b.implementation {
            BinningImpl::Free => return None,
            BinningImpl::Append => Some(b.block.0),
            BinningImpl::TwoPass => None,
        };
        Some(ListShape {
            entry: self.list_entry(),
            pointer: b.pointer_size.0,
            pointers: b.pointers.capacity.0 / b.pointer_size.0.max(1),
            line: b.line.0,
            lines: b.combining.capacity.0 / b.line.0.max(1),
            merges: b.partial == PartialWrite::ReadModifyWrite,
            block,
        })
    }

    /// What it needs of a frame besides its lists.
    pub fn detail(&self) -> FrameDetail {
        FrameDetail {
            pixels: self.vru.implementation.needs_pixels()
                || self.stereo.implementation == StereoImpl::Derived
                || self.gsu.keeps_lists()
                || self.pixels.source != PixelSource::All
                || self.training.interval > 0,
            whole: self.vru.termination == Termination::None,
        }
    }

    /// What decides which pixels are rendered; `None` where all are.
    pub fn pixel_numbers(&self) -> Option<Vec<u32>> {
        let p = &self.pixels;
        let both = |n: u64| [n as u32, (n >> 32) as u32];
        let of = match p.source {
            PixelSource::All => return None,
            PixelSource::Warped => {
                let bytes = both(self.record.pixel.0 + p.depth.0);
                [&[p.period][..], &both(p.holes.to_bits()), &bytes].concat()
            }
            PixelSource::Cached => {
                let sizes = [both(p.entry.0), both(p.buffer.capacity.0)].concat();
                [&[p.ids, p.ways, p.region][..], &sizes].concat()
            }
            PixelSource::Sampled => {
                vec![p.period, p.stride, p.pattern as u32, u32::from(p.filter)]
            }
        };
        Some([vec![p.source as u32], of].concat())
    }

    /// Bytes of pixel state that a core keeps in its share of the pixel buffer: that of a tile
    /// where its units change between sub-tiles, else none.
    pub fn state_bytes(&self) -> Bytes {
        if !self.vru.implementation.swaps() || self.geometry.subtiles() == 1 {
            return Bytes(0);
        }
        let levels = u64::from(self.fovea.accumulators.max(1));
        let pixels = u64::from(self.geometry.tile).pow(2);
        Bytes(pixels.saturating_mul(levels).saturating_mul(self.vru.pixel_state.0))
    }
    /// Everything that decides timing, as bytes.
    pub(super) fn timing(&self, clock: Hertz) -> Vec<u8> {
        let TileWise {
            geometry,
            record,
            codebook,
            ccu,
            gsu,
            vru,
            fovea,
            buffers,
            binning,
            cache,
            stereo,
            pixels,
            training,
            gradients,
            schedule,
            rules,
        } = self;
        let mut bytes = Vec::with_capacity(4096);
        let mut add = |part: Result<Vec<u8>, serde_json::Error>| {
            bytes.extend(part.expect("a machine has only tables, numbers and strings"));
            bytes.push(b'\n');
        };
        add(serde_json::to_vec(&(clock, geometry, record, ccu, gsu, vru, buffers, schedule)));
        add(serde_json::to_vec(fovea));
        if binning.implementation != BinningImpl::Free {
            add(serde_json::to_vec(binning));
        }
        if codebook.entries > 0 {
            add(serde_json::to_vec(codebook));
        }
        if cache.capacity.0 > 0 {
            add(serde_json::to_vec(cache));
        }
        if stereo.implementation != StereoImpl::Separate {
            add(serde_json::to_vec(stereo));
        }
        if pixels.source != PixelSource::All {
            add(serde_json::to_vec(pixels));
        }
        if training.interval > 0 {
            add(serde_json::to_vec(&(training, gradients)));
        }
        for (unit, rule) in rules.names() {
            bytes.extend(format!("{unit} rule {rule:?}\n").into_bytes());
        }
        bytes
    }
}

/// Bytes of the records that cross the DRAM interface.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RecordSpec {
    /// Read for every Gaussian of the scene: its position.
    pub position: Bytes,
    /// Read for every survivor: scale, rotation, opacity.
    pub geometry: Bytes,
    /// Colour of one Gaussian of a scene of SH degree 3; when it is read is decided by `ccu.fetch`.
    /// In a scene of lower degree d its coefficients take (d + 1)² / 16 of their bytes, rounded up.
    /// With a codebook a record has a sixteenth of their bits and the bits of the number of an
    /// entry, rounded up to bytes.
    pub colour: Bytes,
    /// Bytes of `colour` that are no SH coefficients and stay at every degree. As large as
    /// `colour`: a record that does not depend on the degree, and with a codebook has the number of
    /// an entry among them.
    pub colour_extra: Bytes,
    /// Written by the CCU for every splat with at least one tile.
    pub projected: Bytes,
    /// Bits of the depth in a list entry. An entry is written by the CCU per (splat, tile) pair and
    /// read back by the sorter; it has the bytes that its bits fill.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "bits"))]
    pub depth_bits: u32,
    /// Bits of the splat's number in a list entry.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "bits"))]
    pub id_bits: u32,
    /// Whether the number must tell all splats of a frame apart. `false` keeps a published count of
    /// bytes whose numbers cannot.
    pub id_check: bool,
    /// Whether a list entry has the bitmap of the sub-tiles that the splat touches, a bit each.
    pub entry_bitmap: bool,
    /// Read per list entry that a tile loads for rendering.
    pub feature: Bytes,
    /// Who writes what is read per list entry.
    pub feature_source: FeatureSource,
    /// Numbers that rendering units compute with, bits of exponent and mantissa: `e5m10` is FP16.
    /// An entry that they read has nine. Without it, or with `none`, units are those that the
    /// energy table has prices for.
    #[serde(default, deserialize_with = "some_numbers", skip_serializing_if = "Option::is_none")]
    pub numbers: Option<NumberFormat>,
    /// Written per pixel.
    pub pixel: Bytes,
    /// Distance of feature records in DRAM, at least `feature`.
    pub feature_pitch: Bytes,
    /// Distance of colour records of degree 3 in DRAM, at least `colour`. Smaller records lie as
    /// close as their alignment allows: to the largest power of two that divides this distance, at
    /// most 32 B; with a codebook to the least that holds one, so that none is in two bursts.
    pub colour_pitch: Bytes,
}

/// The `[codebook]` table: colours beyond the constant one as entries of a table on chip, which a
/// record names by its number. Each CCU, or with `ccu.fetch = "lazy-colour"` each core, has a whole
/// copy, which stays from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct CodebookSpec {
    /// Entries; without it, or with 0, there is none: records have the coefficients themselves.
    #[schemars(range(min = 0, max = 1048576), extend("x-unit" = "entries"))]
    pub entries: u32,
    /// Bytes of an entry: the coefficients of three channels, of the highest SH degree that it is
    /// made for. A look-up for a scene of a lower degree above 0 reads all of them.
    pub entry: Bytes,
    /// Bytes of one access of one bank.
    pub word: Bytes,
    /// Banks of a copy; the words of an entry lie in as many of them.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "banks"))]
    pub banks: u32,
}

impl Default for CodebookSpec {
    fn default() -> CodebookSpec {
        CodebookSpec { entries: 0, entry: Bytes(90), word: Bytes(32), banks: 1 }
    }
}

impl CodebookSpec {
    /// The codebook of a scene of this SH degree: constant colours have no entries.
    pub(crate) fn of_degree(self, degree: ShDegree) -> CodebookSpec {
        let entries = if degree == ShDegree::ZERO { 0 } else { self.entries };
        CodebookSpec { entries, ..self }
    }

    /// Bits of the number of an entry; 0 without a codebook.
    pub(crate) fn number_bits(&self) -> u64 {
        match self.entries {
            0 => 0,
            n => u64::from(u32::BITS - (n - 1).leading_zeros()),
        }
    }

    /// Words of an entry.
    pub(crate) fn words(&self) -> u64 {
        self.entry.0.div_ceil(self.word.0.max(1))
    }

    /// Cycles for which a look-up has its copy; 0 without a codebook.
    pub(crate) fn cycles(&self) -> u64 {
        match self.entries {
            0 => 0,
            _ => self.words().div_ceil(u64::from(self.banks)),
        }
    }

    /// Bytes that so many look-ups read: an access takes a whole word.
    pub(crate) fn bytes(&self, lookups: u64) -> u64 {
        match self.entries {
            0 => 0,
            _ => lookups * self.words() * self.word.0,
        }
    }

    /// Bytes of a bank of a copy.
    pub(crate) fn bank(&self) -> Bytes {
        let words = u64::from(self.entries) * self.words();
        Bytes(words.div_ceil(u64::from(self.banks.max(1))) * self.word.0)
    }
}

/// Who writes the features that rendering reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FeatureSource {
    /// The CCU: what it writes of a splat (`record.projected`) is its feature record, in its place.
    Ccu,
    /// Nobody: a published count of bytes that has no writes for them. Reports say how many bytes
    /// are read so.
    Nobody,
}

/// Colour records are aligned to at most this: a burst of LPDDR memories, and a usual buffer word.
const ALIGNMENT_MAX: u64 = 32;

/// What colours at this distance are aligned to.
pub(crate) fn alignment_of(pitch: u64) -> u64 {
    1 << pitch.trailing_zeros().min(ALIGNMENT_MAX.ilog2())
}

impl RecordSpec {
    /// The records of a scene of this SH degree on a machine with this codebook.
    pub(crate) fn of(&self, degree: ShDegree, codebook: &CodebookSpec) -> RecordSpec {
        let codebook = codebook.of_degree(degree);
        if degree == ShDegree::MAX && codebook.entries == 0 {
            return self.clone();
        }
        let coefficients = self.colour.0.saturating_sub(self.colour_extra.0);
        let all = ShDegree::MAX.coefficients();
        let kept = match (coefficients, codebook.entries) {
            (0, _) => 0,
            (_, 0) => (coefficients * degree.coefficients()).div_ceil(all),
            _ => ((8 * coefficients).div_ceil(all) + codebook.number_bits()).div_ceil(8),
        };
        let colour = self.colour.0 - coefficients + kept;
        let pitch = self.colour_pitch.0;
        let alignment = alignment_of(pitch);
        let alignment = match codebook.entries {
            0 => alignment,
            _ => colour.next_power_of_two().min(alignment),
        };
        RecordSpec {
            colour: Bytes(colour),
            colour_pitch: Bytes(colour.next_multiple_of(alignment).min(pitch)),
            ..self.clone()
        }
    }
}

/// When the colour (SH) record of a Gaussian is fetched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Fetch {
    /// The CCU reads the whole record of every Gaussian (the NeRArch-Sim model of GSCore).
    Everything,
    /// Positions of all, everything else of survivors.
    GeometryFirst,
    /// Positions of all, geometry of survivors, colour of those with a tile (GSCore, which converts
    /// what is visible before sorting).
    VisibleColour,
    /// Positions of all, geometry of survivors, colour when a tile first loads the splat (the
    /// PowerGS model of GSCore).
    LazyColour,
}

/// The `[ccu]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CcuSpec {
    /// Number of culling and conversion units.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "units"))]
    pub units: u32,
    /// Arithmetic of one CCU, without its box tests: operations of the table `operations` that it
    /// makes in a cycle.
    #[schemars(range(min = 1, max = 1048576), extend("x-unit" = "operations per cycle"))]
    pub operations_per_cycle: u32,
    /// Arithmetic for culling alone, beside that of the other steps; 0: they share theirs.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1048576), extend("x-unit" = "operations per cycle"))]
    pub cull_operations_per_cycle: u32,
    /// Arithmetic for colours alone, beside that of the other steps; 0: they share theirs.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1048576), extend("x-unit" = "operations per cycle"))]
    pub colour_operations_per_cycle: u32,
    /// What the steps of a conversion take.
    pub operations: CcuOperations,
    /// Intersection units of one CCU: box tests per cycle.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "tests per cycle"))]
    pub intersection_units: u32,
    /// Cycles from a record to its list entries.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub latency: u32,
    /// Records that one CCU takes from DRAM in one batch, at most as many as fit its input
    /// buffer.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "Gaussians"))]
    pub batch: u32,
    /// Batches that one CCU has asked for and not yet converted, at most.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "batches"))]
    pub queue: u32,
    /// When the records of a Gaussian are read.
    pub fetch: Fetch,
    /// Gaussians in storage order that have a common record of their bounds, which is tested first:
    /// a multiple of 32, or 0 for none.
    #[serde(default)]
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "Gaussians"))]
    pub clusters: u32,
    /// Bytes of the bounds of a cluster.
    #[serde(default = "bounds")]
    #[schemars(extend("x-unit" = "bytes"))]
    pub cluster: Bytes,
}

/// A136.
fn bounds() -> Bytes {
    Bytes(16)
}

/// The `ccu.operations` table: arithmetic operations of each step, in the count of the source that
/// `ccu.operations-per-cycle` is in.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct CcuOperations {
    /// The depth test of a record.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "operations"))]
    pub cull: u32,
    /// Projection of a survivor: mean, covariance, bounding square.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "operations"))]
    pub project: u32,
    /// Axes of the oriented box of a splat that is tested.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "operations"))]
    pub obb_prepare: u32,
    /// A colour from spherical harmonics of degree 3; lower degrees take as much less as they have
    /// fewer operations.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "operations"))]
    pub sh_colour: u32,
}

impl CcuSpec {
    /// Gaussians a cycle, at most 1, that each engine takes through its steps: that of culling,
    /// that of projection and boxes, that of colours. Steps that share an engine share its rate.
    pub fn gaussians_per_cycle(&self) -> [f64; 3] {
        let o = &self.operations;
        let colour = if self.fetch == Fetch::LazyColour { 0 } else { o.sh_colour };
        let own = [self.cull_operations_per_cycle, 0, self.colour_operations_per_cycle];
        let steps = [o.cull, o.project + o.obb_prepare, colour];
        let shared = steps.iter().zip(own).filter(|(_, own)| *own == 0).map(|(step, _)| step);
        let shared: u32 = shared.sum();
        let rate = |operations: u32, per_cycle: u32| {
            (f64::from(per_cycle) / f64::from(operations.max(1))).min(1.0)
        };
        [0, 1, 2].map(|step| match own[step] {
            0 => rate(shared, self.operations_per_cycle),
            own => rate(steps[step], own),
        })
    }

    /// Operations a cycle of all its engines.
    pub fn all_operations_per_cycle(&self) -> u64 {
        let own = [self.cull_operations_per_cycle, self.colour_operations_per_cycle];
        own.into_iter().map(u64::from).sum::<u64>() + u64::from(self.operations_per_cycle)
    }
}

/// The `[gsu]` table; counts are per core.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct GsuSpec {
    /// Quick sorting units per core.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "units per core"))]
    pub qsu_per_core: u32,
    /// Pivots of a QSU: one pass splits a list into `pivots + 1` parts.
    #[schemars(range(min = 1, max = 1023), extend("x-unit" = "pivots"))]
    pub pivots: u32,
    /// Keys per cycle of one QSU.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "keys per cycle"))]
    pub keys_per_cycle: u32,
    /// Pipeline latency of one QSU pass, cycles.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub qsu_latency: u32,
    /// Bitonic sorting units per core.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "units per core"))]
    pub bsu_per_core: u32,
    /// Inputs of the bitonic network.
    #[schemars(range(min = 2, max = 1024), extend("x-unit" = "keys"))]
    pub bsu_width: u32,
    /// Pipeline latency of the network, cycles.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub bsu_latency: u32,
    /// Tiles whose lists a core holds or has asked for ahead of the one that is rendered.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "tiles"))]
    pub queue: u32,
    /// Where the keys of a pass go.
    pub spill: Spill,
    /// How pivots are chosen; the order that comes out is checked with it.
    pub pivot_rule: PivotRule,
    /// What of a depth is in a key.
    pub depth: DepthKey,
    /// Where the order of a list comes from.
    #[serde(rename = "impl")]
    pub implementation: GsuImpl,
    /// Sorted parts that a merge takes together.
    #[serde(default = "merged_parts")]
    #[schemars(range(min = 2, max = 1024), extend("x-unit" = "parts"))]
    pub fan_in: u32,
    /// Frames after which every list is sorted from nothing again.
    #[serde(default = "reused_frames")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "frames"))]
    pub reuse_period: u32,
    /// How far a splat may be from a tile to be in its list of several frames.
    #[serde(default = "margin")]
    #[schemars(range(min = 0, max = 64), extend("x-unit" = "pixels"))]
    pub margin: u32,
    /// Who knows the depths of the entries that are kept.
    #[serde(default = "deferred")]
    pub depth_update: DepthUpdate,
    /// Weights that are made of depths in a cycle, per core.
    #[serde(default = "weights")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "depths per cycle"))]
    pub weights_per_cycle: u32,
}

/// A75.
fn deferred() -> DepthUpdate {
    DepthUpdate::Deferred
}

/// A134.
fn margin() -> u32 {
    16
}

/// A131.
fn weights() -> u32 {
    256
}

/// A126.
fn merged_parts() -> u32 {
    2
}

/// As long as a number says.
fn reused_frames() -> u32 {
    65_536
}

impl GsuSpec {
    /// Comparisons of a key with others in one pass: with pivots, or with the heads of other parts.
    pub fn comparisons(&self) -> u32 {
        match self.implementation {
            GsuImpl::Split | GsuImpl::Update => self.pivots,
            GsuImpl::Merge | GsuImpl::Last | GsuImpl::Shared => self.fan_in.saturating_sub(1),
            GsuImpl::None => 0,
        }
    }

    /// Whether there are units that sort.
    pub fn sorts(&self) -> bool {
        self.implementation != GsuImpl::None
    }

    /// Whether lists are sorted whole, chunk by chunk, and merged.
    pub fn merges(&self) -> bool {
        matches!(self.implementation, GsuImpl::Merge) || self.keeps_lists()
    }

    /// Whether frames go through lists of frames before.
    pub fn keeps_lists(&self) -> bool {
        matches!(self.implementation, GsuImpl::Last | GsuImpl::Shared)
    }

    /// Frames after which every list is sorted from nothing; 1 for every frame.
    pub fn period(&self) -> u32 {
        if self.implementation == GsuImpl::Update { self.reuse_period } else { 1 }
    }
}

/// Where the order of a list comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GsuImpl {
    /// Every list is split at pivots until its parts fit a chunk, and a chunk is sorted when it is
    /// needed, in every frame.
    Split,
    /// Every list is sorted chunk by chunk, and the chunks are merged, in every frame.
    Merge,
    /// The order of the frame before is updated, until `reuse-period` is over.
    Update,
    /// A frame goes through the lists of the frame before as they are; its own are merged
    /// meanwhile, for the next one.
    Last,
    /// Lists with a margin are merged every `reuse-period` frames, and go for all of these.
    Shared,
    /// Nobody sorts: blending does not depend on the order. Every entry has a weight by its depth,
    /// sums are divided by those of the weights, and nothing stops.
    None,
}

impl GsuImpl {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            GsuImpl::Split => "split",
            GsuImpl::Merge => "merge",
            GsuImpl::Update => "update",
            GsuImpl::Last => "last",
            GsuImpl::Shared => "shared",
            GsuImpl::None => "none",
        }
    }
}

/// Who knows the depths of the entries that an updated list keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DepthUpdate {
    /// The list: rendering, which reads the features of its entries anyway, has left them in it in
    /// the frame before.
    Deferred,
    /// They are read from the projected records before the list is sorted.
    Fetched,
}

/// The `[vru]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct VruSpec {
    /// Cores; each has its own GSU and feature buffer and renders one tile at a time.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "cores"))]
    pub cores: u32,
    /// Rendering units per core.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "units per core"))]
    pub units_per_core: u32,
    /// Pixels that one unit holds and rotates through its pipeline.
    #[serde(default = "quad")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "pixels"))]
    pub pixels_per_unit: u32,
    /// Pipeline latency, cycles: paid when a tile drains.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub latency: u32,
    /// Cycles from a pixel's α to its next one, because its transmittance must be known: a unit
    /// that rotates through fewer pixels waits.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "cycles"))]
    pub recurrence: u32,
    /// Whether sub-tiles whose bitmap bit is clear are skipped.
    #[serde(default = "skips")]
    pub subtile_skipping: bool,
    /// What stops when its pixels have all stopped.
    pub termination: Termination,
    /// Further cycles for which a unit is held by an α that is not pruned (α ≥ 1/255).
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles per blend"))]
    pub blend_stall: u32,
    /// Chunks of a tile that are fetched and sorted ahead of its last needed one, before anybody
    /// knows that they are not needed.
    #[schemars(range(min = 0, max = 1024), extend("x-unit" = "chunks"))]
    pub speculation: u32,
    /// Whether the next tile enters while the last one drains.
    pub tile_overlap: bool,
    /// How the units of a core go through the sub-tiles of a tile.
    #[serde(rename = "impl")]
    pub implementation: VruImpl,
    /// Entries that wait for the units of a sub-tile, or behind the scan, with the one that is
    /// worked on.
    #[serde(default = "queued_entries")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "entries"))]
    pub subtile_queue: u32,
    /// Entries that leave the feature buffer in a cycle: units that take single pixels put so many
    /// Gaussians of one together at a time.
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 256), extend("x-unit" = "entries/cycle"))]
    pub entries_per_cycle: u32,
    /// Leader pixels that a test unit looks at in a cycle.
    #[serde(default = "leaders")]
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "pixels per cycle"))]
    pub leaders_per_cycle: u32,
    /// Ratio of axes from which a splat is spiky: two leader pixels of a mini-tile are tested, and
    /// four of a smooth one. With 1 all are spiky.
    #[serde(default = "spiky")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "ratio"))]
    pub spiky_from: u32,
    /// Pixels that are divided by the sum of their weights in a cycle, per core.
    #[serde(default = "divisions")]
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "pixels per cycle"))]
    pub divisions_per_cycle: u32,
    /// State of a pixel that is not finished: transmittance and colour.
    pub pixel_state: Bytes,
    /// Cycles from the last pair of a sub-tile (or tile) that is needed until it is known to have
    /// stopped; pairs that begin in them are executed in vain.
    #[serde(default)]
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub stop_latency: u32,
    /// Arithmetic of the colour unit of a core, which `ccu.fetch = "lazy-colour"` needs: operations
    /// of `ccu.operations.sh-colour` that it makes in a cycle.
    #[serde(default)]
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "operations per cycle"))]
    pub colour_operations_per_cycle: u32,
    /// Pipeline latency of the colour unit, cycles.
    #[serde(default = "colour_cycles")]
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub colour_latency: u32,
}

/// A84: an entry in work and one that waits.
fn queued_entries() -> u32 {
    2
}

/// Units of 2x2 pixels.
fn quad() -> u32 {
    4
}

/// A131.
fn divisions() -> u32 {
    4
}

fn one() -> u32 {
    1
}

fn skips() -> bool {
    true
}

/// A128.
fn leaders() -> u32 {
    8
}

/// A128.
fn spiky() -> u32 {
    3
}

/// A103.
fn colour_cycles() -> u32 {
    16
}

impl VruSpec {
    /// Whether entries wait in queues in front of the units.
    pub fn has_queues(&self) -> bool {
        use VruImpl::{Leaders, Parallel, Rows, Scan};
        matches!(self.implementation, Parallel | Scan | Leaders | Rows)
    }
}

/// How the units of a core go through the sub-tiles of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VruImpl {
    /// All of them together, from one sub-tile to the next for nothing: the pixel state of a tile
    /// is in the units, without area and energy of its own.
    Serial,
    /// The same, where the pixel state of a sub-tile is written to the pixel buffer and that of
    /// another is read.
    Swap,
    /// The same, where the features of a chunk are scanned once for each sub-tile, and the pixel
    /// state changes once for each of them.
    Scan,
    /// Every sub-tile has its own share of the units, with a queue in front of it.
    Parallel,
    /// The same, where sub-tiles are mini-tiles and an entry is tested at leader pixels of 2x2 of
    /// them, after the boxes of its list entry have said which test units look at it.
    Leaders,
    /// Every unit has rows of the tile, with a queue in front of it, and takes of an entry the
    /// pixels between the ends of its ellipse in each row.
    Rows,
    /// All units together take quads, 2x2 pixels, that an entry reaches and that have not stopped,
    /// of as many entries as there is room for.
    Quads,
    /// The same with single pixels: no lane is ever empty while there is work in the chunk.
    Pixels,
    /// All units together take the pixels of an entry's bounding square in the tile, as many at a
    /// time as there are units.
    Box,
}

impl VruImpl {
    /// All of them.
    pub const ALL: [VruImpl; 9] = [
        VruImpl::Serial,
        VruImpl::Swap,
        VruImpl::Scan,
        VruImpl::Parallel,
        VruImpl::Leaders,
        VruImpl::Rows,
        VruImpl::Quads,
        VruImpl::Pixels,
        VruImpl::Box,
    ];

    /// Whether units work on whole sub-tiles.
    pub const fn has_subtiles(self) -> bool {
        !matches!(self, VruImpl::Rows | VruImpl::Quads | VruImpl::Pixels | VruImpl::Box)
    }

    /// Whether pixels are looked at one by one.
    pub const fn needs_pixels(self) -> bool {
        !self.has_subtiles() || matches!(self, VruImpl::Leaders)
    }

    /// What stops together, where there is no choice.
    pub const fn stops(self) -> Option<Termination> {
        match self {
            VruImpl::Rows | VruImpl::Box => Some(Termination::Tile),
            VruImpl::Quads => Some(Termination::Quad),
            VruImpl::Pixels => Some(Termination::Pixel),
            _ => None,
        }
    }

    /// Whether the pixel state of sub-tiles goes through the pixel buffer.
    pub const fn swaps(self) -> bool {
        matches!(self, VruImpl::Swap | VruImpl::Scan)
    }

    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            VruImpl::Serial => "serial",
            VruImpl::Swap => "swap",
            VruImpl::Scan => "scan",
            VruImpl::Parallel => "parallel",
            VruImpl::Leaders => "leaders",
            VruImpl::Rows => "rows",
            VruImpl::Quads => "quads",
            VruImpl::Pixels => "pixels",
            VruImpl::Box => "box",
        }
    }
}

/// The `[fovea]` table: what a machine has for foveated frames. Of no effect on others.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct FoveaSpec {
    /// Levels that a rendering unit blends at the same time in tiles that show two: 1 for one that
    /// blends the two one after the other, 2 for one with a second accumulator; without it, or with
    /// 0, the machine cannot show foveated frames.
    #[schemars(range(min = 0, max = 2), extend("x-unit" = "levels"))]
    pub accumulators: u32,
    /// Look-ups of the level of a tile, and comparisons with it, of one CCU a cycle.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "tests per cycle"))]
    pub level_tests: u32,
    /// Record of DC colour and opacity in one further level, in DRAM.
    pub record: Bytes,
    /// Colour and opacity of the second level, added to a feature record in tiles that show two.
    pub feature: Bytes,
}

impl Default for FoveaSpec {
    /// Nothing; what there is where the file says only the accumulators (A16).
    fn default() -> FoveaSpec {
        FoveaSpec { accumulators: 0, level_tests: 1, record: Bytes(19), feature: Bytes(8) }
    }
}

/// The `[buffers.*]` tables.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BufferSpecs {
    /// In front of the CCU.
    pub gaussian_in: BufferSpec,
    /// Behind the CCU.
    pub tile_list: BufferSpec,
    /// Keys being sorted, per machine.
    pub sorting: BufferSpec,
    /// Chunk features, per machine (divided among cores).
    pub feature: BufferSpec,
    /// Pixels, per machine (divided among cores).
    pub pixel_out: BufferSpec,
}

impl BufferSpecs {
    /// All of them.
    pub fn all(&self) -> [&BufferSpec; 5] {
        [&self.gaussian_in, &self.tile_list, &self.sorting, &self.feature, &self.pixel_out]
    }
}

/// The `[binning]` table: how (splat, tile) pairs get into the lists of tiles. Without it lists are
/// there for nothing.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct BinningSpec {
    /// Who knows where the next entry of a tile goes.
    #[serde(rename = "impl")]
    pub implementation: BinningImpl,
    /// Bytes of the pointer to the end of a list, or of the counter of its entries.
    pub pointer_size: Bytes,
    /// Pointers on chip, over all CCUs; the others are in DRAM.
    pub pointers: BufferSpec,
    /// Lines of entries on their way to DRAM, over all CCUs; with `0 B` every entry is written by
    /// itself.
    pub combining: BufferSpec,
    /// Bytes of a tile that are written together: a line.
    pub line: Bytes,
    /// How bytes are written that begin inside of a line.
    pub partial: PartialWrite,
    /// Bytes of the blocks in which lists grow.
    pub block: Bytes,
}

impl Default for BinningSpec {
    /// Free lists; what there is where the file says only another method (A91).
    fn default() -> BinningSpec {
        let memory = |capacity, word| BufferSpec {
            capacity: Bytes(capacity),
            word: Bytes(word),
            banks: 2,
            ports: Ports::ReadOrWrite,
        };
        BinningSpec {
            implementation: BinningImpl::Free,
            pointer_size: Bytes(4),
            pointers: memory(16 << 10, 4),
            combining: memory(8 << 10, 8),
            line: Bytes(32),
            partial: PartialWrite::Masked,
            block: Bytes(1 << 10),
        }
    }
}

/// How lists are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BinningImpl {
    /// Nobody: entries are written back to back, as if all pointers were known and all entries of a
    /// tile came together (a published count of bytes).
    Free,
    /// A pointer for each tile to the end of its list, which grows in blocks.
    Append,
    /// The first pass over all splats counts, a sum over the tiles places the lists, the second
    /// pass writes them.
    TwoPass,
}

impl BinningImpl {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            BinningImpl::Free => "free",
            BinningImpl::Append => "append",
            BinningImpl::TwoPass => "two-pass",
        }
    }
}

/// How bytes are written that begin inside of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PartialWrite {
    /// By themselves: the memory leaves the other bytes of a burst as they are.
    Masked,
    /// With those of the line before them, which are read for that.
    ReadModifyWrite,
}

/// The `[cache]` table: a set-associative cache of feature records, least recently used first out.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct CacheSpec {
    /// Size; without it, or with 0 B, there is none.
    pub capacity: Bytes,
    /// Records of a set.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "ways"))]
    pub ways: u32,
    /// Which record of a set leaves for a new one.
    pub eviction: Eviction,
    /// Bits of the distance to the next tile of a splat, in every list entry and every tag, with
    /// `eviction = "reuse-distance"`.
    #[schemars(range(min = 1, max = 32), extend("x-unit" = "bits"))]
    pub distance_bits: u32,
    /// Bytes of one access of one bank.
    pub word: Bytes,
    /// Banks.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "banks"))]
    pub banks: u32,
}

impl Default for CacheSpec {
    /// None; what one has where the file says only its size (A96, A102).
    fn default() -> CacheSpec {
        CacheSpec {
            capacity: Bytes(0),
            ways: 4,
            eviction: Eviction::Lru,
            distance_bits: 8,
            word: Bytes(32),
            banks: 4,
        }
    }
}

impl CacheSpec {
    /// Whether the machine has one.
    pub fn is_there(&self) -> bool {
        self.capacity.0 > 0 && self.ways > 0
    }

    /// Bits of a distance in list entries and tags; 0 where nothing is evicted by it.
    pub(crate) fn carried_bits(&self) -> u32 {
        match self.eviction {
            Eviction::ReuseDistance if self.is_there() => self.distance_bits,
            Eviction::ReuseDistance | Eviction::Lru => 0,
        }
    }

    /// How it evicts.
    pub(crate) fn victims(&self) -> Victims {
        match self.eviction {
            Eviction::Lru => Victims::Lru,
            Eviction::ReuseDistance => Victims::Furthest { bits: self.distance_bits },
        }
    }
}

/// The `[stereo]` table: how the second view of a pair is made. Of no effect on single views.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct StereoSpec {
    /// How much of the first view the second one uses.
    #[serde(rename = "impl")]
    pub implementation: StereoImpl,
    /// Tiles that the second view is behind the first one: the largest disparity that is handed on.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "tiles"))]
    pub lag: u32,
    /// Feature records on their way from the first view to the second one, over all cores.
    pub buffer: BufferSpec,
}

impl Default for StereoSpec {
    /// Separate views; what there is where the file says only another way (A132).
    fn default() -> StereoSpec {
        StereoSpec {
            implementation: StereoImpl::Separate,
            lag: 4,
            buffer: BufferSpec {
                capacity: Bytes(64 << 10),
                word: Bytes(32),
                banks: 4,
                ports: Ports::ReadOrWrite,
            },
        }
    }
}

/// How the second view of a pair is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StereoImpl {
    /// As any other frame.
    Separate,
    /// What both eyes see is converted once.
    Shared,
    /// The first view hands on what blends in it; the second one has no lists besides.
    Derived,
}

impl StereoImpl {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            StereoImpl::Separate => "separate",
            StereoImpl::Shared => "shared",
            StereoImpl::Derived => "derived",
        }
    }
}

/// The `[pixels]` table: which pixels of a frame are rendered, and where the others come from.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct PixelsSpec {
    /// Where pixels come from.
    #[serde(rename = "impl")]
    pub source: PixelSource,
    /// One frame in so many is rendered whole; with `sampled` 0 for none.
    #[schemars(range(min = 0, max = 1000), extend("x-unit" = "frames"))]
    pub period: u32,
    /// Largest share of a tile that may be missing where its pixels are moved: above it is rendered
    /// anew.
    #[schemars(range(min = 0, max = 1), extend("x-unit" = "fraction"))]
    pub holes: f64,
    /// Depth of a pixel that is kept beside its colour.
    pub depth: Bytes,
    /// Gaussians that a pixel blends before it is looked up.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "Gaussians"))]
    pub ids: u32,
    /// Ways of a set of the cache of colours.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "ways"))]
    pub ways: u32,
    /// An entry of it: tag and colour.
    pub entry: Bytes,
    /// Side of the square of pixels that has a cache of its own, which is fetched with it.
    #[schemars(range(min = 8, max = 4096), extend("x-unit" = "pixels"))]
    pub region: u32,
    /// One pixel in a square of this side is rendered.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "pixels"))]
    pub stride: u32,
    /// Which one.
    pub pattern: SamplePattern,
    /// Whether lists have only Gaussians that reach a pixel that is rendered: CCUs evaluate α at
    /// those in its bounding square, `ccu.intersection-units` a cycle.
    pub filter: bool,
    /// Pixels that the unit moves, or looks up, in a cycle.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "pixels"))]
    pub per_cycle: u32,
    /// On chip: counters of what is missing of tiles, or the cache of a region.
    pub buffer: BufferSpec,
}

impl PixelsSpec {
    /// Whether CCUs test pixels.
    pub fn filters(&self) -> bool {
        self.source == PixelSource::Sampled && self.filter
    }

    /// Bytes that are kept of a pixel beside its colour.
    pub fn kept(&self) -> Bytes {
        if self.source == PixelSource::Warped { self.depth } else { Bytes(0) }
    }
}

/// Where pixels come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PixelSource {
    /// All are rendered.
    All,
    /// Those of the frame before are moved to where their depth says that they are now; tiles of
    /// which too much is missing are rendered.
    Warped,
    /// Pixels whose first Gaussians are known stop there.
    Cached,
    /// Some are rendered, as tracking and mapping need them.
    Sampled,
}

impl PixelSource {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            PixelSource::All => "all",
            PixelSource::Warped => "warped",
            PixelSource::Cached => "cached",
            PixelSource::Sampled => "sampled",
        }
    }

    /// Whether a unit knows pixels.
    pub const fn has_unit(self) -> bool {
        matches!(self, PixelSource::Warped | PixelSource::Cached)
    }

    /// Whether everything else waits for it.
    pub const fn is_first(self) -> bool {
        matches!(self, PixelSource::Warped)
    }
}

/// Which pixel of a square is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SamplePattern {
    /// The one in the middle.
    Grid,
    /// Another one in each square and frame.
    Random,
    /// As `random`, and every pixel that is more than half transparent.
    Unseen,
}

/// The `[schedule]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ScheduleSpec {
    /// Order in which tiles (or sort groups) are dealt.
    pub order: TileOrder,
    /// Who takes which.
    pub assignment: Assignment,
    /// Neighbours in this order whose lists together have at most this many entries are one piece
    /// of work; 0 merges nothing.
    #[schemars(range(min = 0, max = 1048576), extend("x-unit" = "entries"))]
    pub merge_below: u32,
    /// What may run beside preprocessing.
    pub overlap: Overlap,
}

/// Which core takes which tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Assignment {
    /// Dealt round: the n-th tile to core n modulo the number of cores.
    Static,
    /// The next tile to the first core that has room.
    Greedy,
    /// As `greedy`, but the longest list first, whatever the order.
    LongestFirst,
}

/// What may run at the same time as the CCUs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Overlap {
    /// Nothing: tiles begin when the last list entry has been written.
    None,
    /// A tile begins when the last entry of its own list has been written.
    Tiles,
    /// The tiles of this frame run beside the preprocessing of the next one.
    Frames,
}

/// Where the keys of a sorting pass go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Spill {
    /// They stay in the sorting buffer; what does not fit is written to DRAM and read back.
    Overflow,
    /// All of them are written to DRAM and read back in every pass (Neo's model of GSCore).
    All,
}

/// What stops together, once all of its pixels have stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Termination {
    /// Every pixel: its unit rotates through the others of 2x2.
    Pixel,
    /// The 2x2 pixels of a unit: it sleeps until the sub-tile is done.
    Quad,
    /// A sub-tile.
    Subtile,
    /// The whole tile.
    Tile,
    /// Nothing: every pixel of a tile goes through all of its list.
    None,
}

impl Termination {
    /// The name in every file and output.
    pub const fn name(self) -> &'static str {
        match self {
            Termination::Pixel => "pixel",
            Termination::Quad => "quad",
            Termination::Subtile => "subtile",
            Termination::Tile => "tile",
            Termination::None => "none",
        }
    }
}
