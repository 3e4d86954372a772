//! The tables of a machine file.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

pub use super::cache::CacheSpec;
pub use super::ccu::{CcuOperations, CcuSpec, Fetch};
pub use super::colour::CodebookSpec;
pub use super::gradients::GradientsSpec;
pub use super::gsu::{DepthUpdate, GsuImpl, GsuSpec, Spill};
pub use super::lists::{BinningImpl, BinningSpec, PartialWrite};
use super::rules::UnitRules;
pub use super::stereo::{StereoImpl, StereoSpec};
pub use super::vru::{FoveaSpec, Termination, VruImpl, VruSpec};
use crate::flow::Incompatible;
use crate::flow::lists::alignment_of;
use crate::flow::over::levels::LevelsSpec;
use crate::flow::over::pixels::PixelFilter;
pub use crate::flow::over::pixels::{PixelSource, PixelsSpec, SamplePattern};
pub use crate::flow::steps::TrainingSpec;
use crate::machine::{BufferSpec, Machine};
use crate::workload::binning::ListShape;
pub use crate::workload::cache::Eviction;
pub use crate::workload::order::{DepthKey, PivotRule, TileOrder};
use crate::workload::{FrameDetail, FrameWorkload, Geometry};
use powergs_base::config::layer;
use powergs_base::number::NumberFormat;
use powergs_base::quantity::Bytes;
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
    /// Levels of detail, and the unit that traverses them.
    #[serde(default)]
    pub levels: LevelsSpec,
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
        levels, training, gradients, schedule,
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

    /// Which pixels are rendered; `None` where all are.
    pub fn pixel_filter(&self) -> Option<PixelFilter<'_>> {
        self.pixels.filter(self.record.pixel)
    }

    /// Whether the machine can show a frame, as far as its pixels go.
    ///
    /// # Errors
    /// As [`PixelsSpec::fits`](crate::flow::over::pixels::PixelsSpec::fits) and
    /// [`PixelsSpec::counts`](crate::flow::over::pixels::PixelsSpec::counts).
    pub fn shows(&self, machine: &str, workload: &FrameWorkload) -> Result<(), Incompatible> {
        self.pixels.fits(machine, [workload.width, workload.height])?;
        self.pixels.counts(machine, workload.tiles.len(), "geometry.tile")
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
