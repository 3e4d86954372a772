//! The workload counters of one frame, with the names that every output uses.

use super::runs::Touch;

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

impl Counters {
    /// Adds the counts of another frame.
    pub fn add(&mut self, other: &Counters) {
        let Counters {
            points,
            survivors,
            tile_pairs,
            intersecting_points,
            fetched_points,
            obb_tests,
            obb_prepared,
            tile_loads,
            alpha_evaluations,
            blends,
        } = other;
        self.points += points;
        self.survivors += survivors;
        self.tile_pairs += tile_pairs;
        self.intersecting_points += intersecting_points;
        self.fetched_points += fetched_points;
        self.obb_tests += obb_tests;
        self.obb_prepared += obb_prepared;
        self.tile_loads += tile_loads;
        self.alpha_evaluations += alpha_evaluations;
        self.blends += blends;
    }

    /// Counts what is known of the intersections of a splat.
    pub fn touch(&mut self, touch: &Touch) {
        self.tile_pairs += u64::from(touch.tiles);
        self.intersecting_points += u64::from(touch.tiles > 0);
        self.obb_tests += u64::from(touch.tests);
        self.obb_prepared += u64::from(touch.tests > 0);
    }
}

/// Counters of foveated frames (`powergs.md` §1.4).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FoveaCounters {
    /// Look-ups of tile levels (`P_tile_ecc_accesses`).
    pub lookups: u64,
    /// Splats with more than one box test: those that the published model prepares.
    pub prepared_published: u64,
    /// Fetched splats that need one, two, three and four levels' colours (`P_used` by `P_levels`).
    pub points_by_levels: [u64; 4],
    /// Entries iterated while both levels of a pixel are open (`T_extra_alpha`).
    pub extra_alpha: u64,
    /// Entries blended for the second level, without terminating ones (`T_used2`).
    pub blends_2: u64,
}

impl FoveaCounters {
    /// Adds the counts of another frame.
    pub fn add(&mut self, other: &FoveaCounters) {
        let FoveaCounters { lookups, prepared_published, points_by_levels, extra_alpha, blends_2 } =
            other;
        self.lookups += lookups;
        self.prepared_published += prepared_published;
        self.points_by_levels.iter_mut().zip(points_by_levels).for_each(|(a, b)| *a += b);
        self.extra_alpha += extra_alpha;
        self.blends_2 += blends_2;
    }

    /// Counts what is known of the intersections of a splat.
    pub fn touch(&mut self, touch: &Touch) {
        self.lookups += u64::from(touch.lookups);
        self.prepared_published += u64::from(touch.tests > 1);
    }

    /// Counts a splat that was fetched.
    pub fn fetch(&mut self, touch: &Touch) {
        self.points_by_levels[usize::from(touch.levels.clamp(1, 4) - 1)] += 1;
    }
}
