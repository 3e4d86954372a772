//! The machine file: every key that an architect can turn.

use crate::quantity::{Bytes, BytesPerSecond, Hertz, Nanoseconds};
use crate::workload::Geometry;

/// A machine as written in `arch-configs/machines/*.toml`, checked: everything in it fits together.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Name in reports.
    pub name: String,
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

/// Bytes of the records that cross the DRAM interface.
#[derive(Debug, Clone, PartialEq)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
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
#[derive(Debug, Clone, PartialEq)]
pub struct CcuSpec {
    /// Number of units.
    pub units: u32,
    /// Cycles between Gaussians of one unit.
    pub initiation_interval: u32,
    /// Box tests per cycle of one unit.
    pub tests_per_cycle: u32,
    /// Cycles from a record to its list entries.
    pub latency: u32,
    /// Records taken from DRAM in one batch.
    pub batch: u32,
    /// Fetch policy.
    pub fetch: Fetch,
}

/// The `[gsu]` table; counts are per core.
#[derive(Debug, Clone, PartialEq)]
pub struct GsuSpec {
    /// Quick sorting units per core.
    pub qsu_per_core: u32,
    /// Pivots of a QSU: one pass splits a list into `pivots + 1` parts.
    pub pivots: u32,
    /// Keys per cycle of one QSU.
    pub keys_per_cycle: u32,
    /// Pipeline latency of one QSU pass, cycles.
    pub qsu_latency: u32,
    /// Bitonic sorting units per core.
    pub bsu_per_core: u32,
    /// Inputs of the bitonic network.
    pub bsu_width: u32,
    /// Pipeline latency of the network, cycles.
    pub bsu_latency: u32,
}

/// The `[vru]` table.
#[derive(Debug, Clone, PartialEq)]
pub struct VruSpec {
    /// Cores; each has its own GSU and feature buffer and renders one tile at a time.
    pub cores: u32,
    /// Rendering units per core.
    pub units_per_core: u32,
    /// Pixels that one unit holds and rotates through its pipeline.
    pub pixels_per_unit: u32,
    /// Pipeline latency, cycles: paid when a tile drains.
    pub latency: u32,
    /// Whether sub-tiles whose bitmap bit is clear are skipped.
    pub subtile_skipping: bool,
}

/// The `[buffers.*]` tables.
#[derive(Debug, Clone, PartialEq)]
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
#[derive(Debug, Clone, PartialEq)]
pub struct BufferSpec {
    /// Size.
    pub capacity: Bytes,
}

/// The `[dram]` table: the `bandwidth` model.
#[derive(Debug, Clone, PartialEq)]
pub struct DramSpec {
    /// Peak rate.
    pub bandwidth: BytesPerSecond,
    /// Fraction of the peak that transfers reach, 0 to 1.
    pub efficiency: f64,
    /// From request to first data.
    pub latency: Nanoseconds,
}
