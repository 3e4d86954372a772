//! The machine file: every key that an architect can turn.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::action::Buffer;
use crate::config::{self, ConfigError};
use crate::quantity::{Bytes, BytesPerSecond, Hertz, Nanoseconds};
use crate::workload::Geometry;

mod check;

/// A machine as written in `arch-configs/machines/*.toml`, checked: everything in it fits together.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Machine {
    /// Name in reports: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// What it is, in one line.
    pub description: String,
    /// Clock of all units.
    pub clock: Hertz,
    /// Name of the energy table (`arch-configs/energy/NAME.toml`) or path of one.
    pub energy: String,
    /// What decides the work: tile, sub-tile, chunk, intersection test.
    pub geometry: Geometry,
    /// Bytes of every record that crosses the DRAM interface.
    pub record: RecordSpec,
    /// Culling and conversion units.
    pub ccu: CcuSpec,
    /// Gaussian sorting units.
    pub gsu: GsuSpec,
    /// Volume rendering units.
    pub vru: VruSpec,
    /// On-chip buffers.
    pub buffers: BufferSpecs,
    /// External memory.
    pub dram: DramSpec,
}

impl Machine {
    /// Reads and checks a machine file.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line; see [`config::parse`].
    pub fn parse(text: &str) -> Result<Machine, ConfigError> {
        Machine::parse_with(text, &[])
    }

    /// Reads and checks a machine file with `dotted.key=value` overlays on top.
    ///
    /// # Errors
    /// As [`Machine::parse`]; a problem of an overlay names the overlay.
    pub fn parse_with(text: &str, sets: &[String]) -> Result<Machine, ConfigError> {
        let config = config::parse::<Machine>(text, sets)?;
        let problems =
            check::problems(&config.value).into_iter().map(|(k, m)| config.problem(k, m)).collect();
        config.checked(problems)
    }

    /// The machine as TOML: every key, overlays applied, no comments.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("a machine has only tables, numbers and strings")
    }

    /// How many CCUs, QSUs, BSUs and rendering units it has.
    pub fn unit_counts(&self) -> [u32; 4] {
        let (cores, gsu) = (self.vru.cores, &self.gsu);
        let vrus = cores.saturating_mul(self.vru.units_per_core);
        [self.ccu.units, cores * gsu.qsu_per_core, cores * gsu.bsu_per_core, vrus]
    }
}

impl Machine {
    /// How the buffers are built, in the order of [`Buffer::ALL`]: the size of one bank and how
    /// many there are. Each CCU or core has a bank of its own (A13).
    pub fn banks(&self) -> [(Bytes, u32); Buffer::ALL.len()] {
        let capacities = self.buffers.capacities();
        Buffer::ALL.map(|b| {
            let count = match b {
                Buffer::GaussianIn | Buffer::TileList => self.ccu.units,
                Buffer::Sorting | Buffer::Feature | Buffer::PixelOut => self.vru.cores,
            };
            (Bytes(capacities[b as usize].0 / u64::from(count)), count)
        })
    }
}

impl BufferSpecs {
    /// Capacities in the order of [`Buffer::ALL`].
    pub fn capacities(&self) -> [Bytes; Buffer::ALL.len()] {
        Buffer::ALL.map(|b| match b {
            Buffer::GaussianIn => self.gaussian_in.capacity,
            Buffer::TileList => self.tile_list.capacity,
            Buffer::Sorting => self.sorting.capacity,
            Buffer::Feature => self.feature.capacity,
            Buffer::PixelOut => self.pixel_out.capacity,
        })
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
    /// Spherical harmonics of one Gaussian; when it is read is decided by `ccu.fetch`.
    pub colour: Bytes,
    /// Written by the CCU for every splat with at least one tile.
    pub projected: Bytes,
    /// Written by the CCU per (splat, tile) pair, and read back by the sorter.
    pub list_entry: Bytes,
    /// Read per list entry that a tile loads for rendering.
    pub feature: Bytes,
    /// Written per pixel.
    pub pixel: Bytes,
}

/// When the colour (SH) record of a Gaussian is fetched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Fetch {
    /// The CCU reads the whole record of every Gaussian (the NeRArch-Sim model of GSCore).
    Everything,
    /// Positions of all, everything else of survivors.
    GeometryFirst,
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
    /// Cycles between Gaussians of one unit.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "cycles per Gaussian"))]
    pub initiation_interval: u32,
    /// Box tests per cycle of one unit.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "tests per cycle"))]
    pub tests_per_cycle: u32,
    /// Cycles from a record to its list entries.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub latency: u32,
    /// Records that one CCU takes from DRAM in one batch, at most as many as fit half of its input
    /// buffer.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "Gaussians"))]
    pub batch: u32,
    /// When the records of a Gaussian are read.
    pub fetch: Fetch,
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
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "pixels"))]
    pub pixels_per_unit: u32,
    /// Pipeline latency, cycles: paid when a tile drains.
    #[schemars(range(min = 0, max = 65536), extend("x-unit" = "cycles"))]
    pub latency: u32,
    /// Whether sub-tiles whose bitmap bit is clear are skipped.
    pub subtile_skipping: bool,
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

/// One on-chip buffer.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct BufferSpec {
    /// Size of the whole buffer, divided evenly among the CCUs or cores that use it.
    pub capacity: Bytes,
}

/// How DRAM requests are timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DramModel {
    /// One server with a latency and a rate.
    Bandwidth,
}

/// The `[dram]` table: the `bandwidth` model.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct DramSpec {
    /// Timing model.
    pub model: DramModel,
    /// Peak rate.
    pub bandwidth: BytesPerSecond,
    /// Fraction of the peak that transfers reach, 0 to 1.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1, "x-unit" = "fraction"))]
    pub efficiency: f64,
    /// From request to first data.
    pub latency: Nanoseconds,
}
