//! The workload counters of one frame, with the names that every output uses.

/// Counts of one frame (`spec` names in brackets: the published PowerGS statistics).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Counters {
    /// Gaussians in the scene.
    pub points: u64,
    /// Gaussians in front of the near plane (`Pcull`).
    pub survivors: u64,
    /// Accepted (splat, tile) pairs (`N_inter`).
    pub tile_pairs: u64,
    /// Splats with at least one accepted tile (`P_inter`).
    pub intersecting_points: u64,
    /// Splats fetched by at least one tile (`P_used`).
    pub fetched_points: u64,
    /// Tiles tested against an oriented box; a splat with one candidate is not tested
    /// (`P_obb_count`).
    pub obb_tests: u64,
    /// Splats that needed box tests at all: their axes are prepared once.
    pub obb_prepared: u64,
    /// List entries fetched, in whole batches of a chunk until the tile is done (`T_load`).
    pub tile_loads: u64,
    /// Entries that pixels iterate until they stop, the terminating one included (`T_bf_term`).
    pub alpha_evaluations: u64,
    /// Entries that reach α ≥ 1/255, the terminating one included (`T_used`).
    pub blends: u64,
}
