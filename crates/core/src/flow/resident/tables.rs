//! The tables of a machine file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::work::RegionEntry;
use crate::flow::lists::alignment_of;
use crate::flow::over::levels::LevelsSpec;
use crate::flow::over::pixels::{PixelFilter, PixelsSpec};
use crate::machine::{BufferSpec, Machine, Ports};
use powergs_base::quantity::Bytes;
use powergs_frame::scene::ShDegree;

pub use crate::flow::steps::{TrainingSpec, Updated};

/// The tables of a machine with resident pixels.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Resident {
    /// What stays on chip while Gaussians pass.
    pub region: RegionSpec,
    /// Bytes of every record that crosses the DRAM interface.
    pub gaussian: GaussianSpec,
    /// Units that convert Gaussians.
    pub front: FrontSpec,
    /// Units that sort the lists of regions.
    pub order: OrderSpec,
    /// Engines that take Gaussians through a region.
    pub raster: RasterSpec,
    /// Units that finish regions pixel by pixel.
    #[serde(default)]
    pub tail: TailSpec,
    /// Units that put the depth slices of a region together.
    #[serde(default)]
    pub compose: ComposeSpec,
    /// What follows a frame that is trained on.
    #[serde(default)]
    pub training: TrainingSpec,
    /// Levels of detail, and the unit that traverses them.
    #[serde(default)]
    pub levels: LevelsSpec,
    /// Which regions of a frame are rendered.
    #[serde(default)]
    pub pixels: PixelsSpec,
    /// On-chip buffers.
    pub stores: StoreSpecs,
}

crate::flow::flow_tables!(
    Resident,
    super::ResidentFlow,
    [region, gaussian, front, order, raster, tail, compose, training, pixels, levels, stores],
    super::KEYS_NOT_BY_REGION
);

impl Machine {
    /// The tables of a machine with resident pixels.
    ///
    /// # Panics
    /// On a machine of another dataflow.
    pub fn resident(&self) -> &Resident {
        self.of_type()
    }

    /// The same, to be changed.
    ///
    /// # Panics
    /// On a machine of another dataflow.
    pub fn resident_mut(&mut self) -> &mut Resident {
        self.tables.all_mut().expect("a machine of this dataflow has its tables")
    }
}

/// Which pixels of a Gaussian go to the lanes, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Cut {
    /// Those of its bounding square of 3 sigma, as many at a time as there are lanes.
    Box,
    /// The same, row by row.
    Rows,
    /// Those of each row in which α may reach 1/255, row by row.
    Exact,
}

impl Cut {
    /// All of them.
    pub const ALL: [Cut; 3] = [Cut::Box, Cut::Rows, Cut::Exact];
}

/// The `[region]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RegionSpec {
    /// Width of the pixels that stay on chip; 0 for that of the image.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "pixels"))]
    pub width: u32,
    /// Height of the pixels that stay on chip; 0 for that of the image.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "pixels"))]
    pub height: u32,
    /// Which pixels of a Gaussian go to the lanes, and how.
    pub cut: Cut,
    /// Parts along depth into which the list of a region is cut, each for an engine of its own.
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "slices"))]
    pub slices: u32,
}

fn one() -> u32 {
    1
}

/// The floating-point operations of a row.
fn row_operations() -> u32 {
    13
}

/// The `[gaussian]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct GaussianSpec {
    /// Position, as stored.
    pub position: Bytes,
    /// Scale, rotation and opacity, as stored.
    pub shape: Bytes,
    /// Spherical harmonics of degree 3, as stored: in a scene of lower degree d they take (d + 1)²
    /// / 16 of these bytes, rounded up.
    pub colour: Bytes,
    /// Distance of two colours in memory.
    pub colour_pitch: Bytes,
    /// A converted Gaussian: mean, conic, opacity, colour.
    pub feature: Bytes,
    /// Distance of two of them in memory.
    pub feature_pitch: Bytes,
    /// An entry of a list: depth and number.
    pub entry: Bytes,
    /// A finished pixel.
    pub pixel: Bytes,
}

/// The `[front]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct FrontSpec {
    /// Units.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "units"))]
    pub units: u32,
    /// Operations of one in a cycle.
    #[schemars(range(min = 1, max = 1048576), extend("x-unit" = "operations/cycle"))]
    pub operations_per_cycle: u32,
    /// Operations of a Gaussian that is culled or not.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "operations"))]
    pub cull: u32,
    /// Operations of the projection of one that is not culled.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "operations"))]
    pub project: u32,
    /// Operations of the colour of one with a region.
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "operations"))]
    pub shade: u32,
    /// Operations of one row of a Gaussian in which its regions are looked for (`region.cut =
    /// "exact"`, more than one region).
    #[serde(default = "row_operations")]
    #[schemars(range(min = 0, max = 100000), extend("x-unit" = "operations"))]
    pub row: u32,
    /// List entries that one makes in a cycle.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "entries/cycle"))]
    pub entries_per_cycle: u32,
    /// Cycles from the last operation of a batch to its results.
    #[schemars(range(min = 0, max = 4096), extend("x-unit" = "cycles"))]
    pub latency: u32,
    /// Gaussians of a batch, a multiple of 32.
    #[schemars(range(min = 32, max = 65536), extend("x-unit" = "Gaussians"))]
    pub batch: u32,
    /// Batches that a unit has at a time.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "batches"))]
    pub queue: u32,
    /// Whether Gaussians are converted in depth order, as a region takes them, until it is opaque,
    /// each for every region; else all once, before the first region.
    #[serde(default)]
    pub lazy: bool,
    /// What runs beside the other stages.
    #[serde(default)]
    pub overlap: FrontOverlap,
}

/// What the front does while the other stages work on a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FrontOverlap {
    /// Nothing: it converts the frame first.
    #[default]
    None,
    /// It converts the next frame, which is like this one.
    Frames,
}

/// The `[order]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct OrderSpec {
    /// Units.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "units"))]
    pub units: u32,
    /// Sorted parts that one merges in a pass.
    #[schemars(range(min = 2, max = 65536), extend("x-unit" = "parts"))]
    pub ways: u32,
    /// Keys that one moves in a cycle of a pass.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "keys/cycle"))]
    pub keys_per_cycle: u32,
    /// Cycles from the last key of a pass to its result.
    #[schemars(range(min = 0, max = 4096), extend("x-unit" = "cycles"))]
    pub latency: u32,
}

/// The `[raster]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct RasterSpec {
    /// Engines.
    #[schemars(range(min = 1, max = 1024), extend("x-unit" = "engines"))]
    pub engines: u32,
    /// Pixels that one evaluates in a cycle.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "lanes"))]
    pub lanes: u32,
    /// Cycles from the last Gaussian of a region to its last pixel.
    #[schemars(range(min = 0, max = 4096), extend("x-unit" = "cycles"))]
    pub latency: u32,
    /// Gaussians that are read together.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "Gaussians"))]
    pub chunk: u32,
    /// Bytes of a pixel while it is worked on: transmittance and colour.
    pub pixel_state: Bytes,
    /// Cycles in which the ends of one row of a Gaussian are found (`region.cut = "exact"`).
    #[serde(default = "one")]
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "cycles"))]
    pub row_cycles: u32,
    /// Whether an engine leaves a region when all of its pixels have stopped.
    #[serde(default)]
    pub saturation: bool,
}

/// The `[tail]` table: a unit behind each engine that finishes regions pixel by pixel; without it
/// there is none.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct TailSpec {
    /// The part of each list that it takes, from the back; 0 for no such unit.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "fraction"))]
    pub share: f64,
    /// Pixels that one evaluates in a cycle.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "lanes"))]
    pub lanes: u32,
    /// Cycles from the last evaluation of a region to its last pixel.
    #[schemars(range(min = 0, max = 4096), extend("x-unit" = "cycles"))]
    pub latency: u32,
}

impl Default for TailSpec {
    fn default() -> TailSpec {
        TailSpec { share: 0.0, lanes: 4, latency: 3 }
    }
}

/// The `[compose]` table: a unit behind each engine that puts depth slices together; without it
/// there is none.
#[derive(Debug, Clone, Default, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct ComposeSpec {
    /// Pixels that one puts together in a cycle; 0 for no such unit.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "lanes"))]
    pub lanes: u32,
    /// Where slices are until then.
    pub through: ComposePath,
}

/// Where the depth slices of a region are until they are put together.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ComposePath {
    /// They are written to DRAM, and read.
    #[default]
    Dram,
    /// They stay in the buffers of their engines.
    Stores,
}

/// The `[stores]` table.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct StoreSpecs {
    /// Records on their way to the front.
    pub records: BufferSpec,
    /// Converted Gaussians and list entries on their way from the front.
    pub results: BufferSpec,
    /// Keys that are sorted.
    pub keys: BufferSpec,
    /// Entries and features of the chunks of the engines.
    pub gaussians: BufferSpec,
    /// Pixels of the regions, until they are written.
    pub pixels: BufferSpec,
    /// Entries and features of the chunks of the tail units.
    #[serde(default = "no_store")]
    pub tail: BufferSpec,
}

/// What a machine without tail units has.
fn no_store() -> BufferSpec {
    BufferSpec { capacity: Bytes(0), word: Bytes(16), banks: 1, ports: Ports::ReadOrWrite }
}

impl StoreSpecs {
    /// Each with its key.
    pub fn all(&self) -> [(&'static str, &BufferSpec); 6] {
        [
            ("stores.records", &self.records),
            ("stores.results", &self.results),
            ("stores.keys", &self.keys),
            ("stores.gaussians", &self.gaussians),
            ("stores.pixels", &self.pixels),
            ("stores.tail", &self.tail),
        ]
    }
}

impl Resident {
    /// Which regions are rendered; `None` where all are.
    pub fn pixel_filter(&self) -> Option<PixelFilter<'_>> {
        self.pixels.filter(self.gaussian.pixel)
    }

    /// The same with what is kept of finished pixels, for scenes of a degree: colours have the
    /// bytes of its coefficients, and lie as near as the alignment of the others lets them.
    #[must_use]
    pub fn of_degree(&self, degree: ShDegree) -> Resident {
        let mut own = self.clone();
        own.gaussian.pixel.0 += self.pixels.kept().0;
        if degree == ShDegree::MAX {
            return own;
        }
        let (g, all) = (&mut own.gaussian, ShDegree::MAX.coefficients());
        let (colour, pitch) =
            ((g.colour.0 * degree.coefficients()).div_ceil(all), g.colour_pitch.0);
        g.colour = Bytes(colour);
        g.colour_pitch = Bytes(colour.next_multiple_of(alignment_of(pitch)).min(pitch));
        own
    }

    /// Bytes of the buffer for pixels that each engine has.
    pub fn pixel_share(&self) -> u64 {
        self.stores.pixels.capacity.0 / u64::from(self.raster.engines)
    }

    /// Words that go through the banks of an engine for a pixel: a lane reads it and writes it
    /// back.
    pub fn pixel_words(&self) -> u32 {
        let pixels = &self.stores.pixels;
        let accesses = match pixels.ports {
            Ports::ReadOrWrite => 2,
            Ports::ReadAndWrite => 1,
        };
        let words = self.raster.pixel_state.0.div_ceil(pixels.word.0.max(1)) * accesses;
        u32::try_from(words).unwrap_or(u32::MAX)
    }

    /// Cycles in which an engine takes an entry: those of its lanes, or those in which the ends of
    /// its rows are found, whichever are more.
    pub fn entry_cycles(&self, entry: &RegionEntry) -> u64 {
        let found = u64::from(entry.rows) * u64::from(self.raster.row_cycles);
        found.max(entry.cycles.into())
    }

    /// The entries of a list that the raster engine takes; the tail unit has the others.
    pub fn front_part(&self, entries: u32) -> u32 {
        entries - (f64::from(entries) * self.tail.share).round() as u32
    }
}
