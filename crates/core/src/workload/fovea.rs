//! The levels of the tiles of a foveated frame under a geometry.

use super::FoveaWork;
use super::bin::NOBODY;
use super::tile::RowPart;
use powergs_frame::fovea::{ScreenGaze, TileLevels};
use powergs_frame::splat::levels::LevelFilter;
use powergs_frame::splat::runs::{Levels, Touch};
use powergs_frame::splat::{FoveaCounters, TileGrid};
use powergs_frame::trace::Fovea;

/// The levels of tiles and splats of one frame.
#[derive(Debug)]
pub(crate) struct TileFovea<'a> {
    gaze: ScreenGaze,
    tiles: TileLevels,
    /// What decides which splats take part in which tiles.
    pub filter: LevelFilter,
    /// The highest level of every splat, by rank.
    pub highest: &'a [u8],
}

impl<'a> TileFovea<'a> {
    /// Finds the levels of the tiles of `grid`.
    pub(crate) fn new(fovea: &'a Fovea, grid: TileGrid) -> Self {
        let gaze = fovea.screen_gaze();
        let map = gaze.eccentricity_map([grid.width, grid.height]);
        let map = map.expect("a frame that was checked has its gaze on a screen");
        let tiles = TileLevels::new(&map, grid);
        let filter = tiles.filter();
        TileFovea { gaze, tiles, filter, highest: &fovea.highest_level }
    }

    /// For the intersection tests.
    pub(crate) fn levels(&self) -> Levels<'_> {
        Levels { filter: &self.filter, highest: self.highest }
    }

    /// Whether tile `tile` keeps the splat at `rank`.
    #[inline]
    pub(crate) fn keeps(&self, tile: usize, rank: u32) -> bool {
        self.filter.keeps(tile, self.highest[rank as usize])
    }

    /// Whether a tile that blends has the splat at `rank` in its second level too.
    #[inline]
    pub(crate) fn is_second(&self, tile: usize, rank: u32) -> bool {
        self.filter.blends[tile] && self.highest[rank as usize] > self.filter.first[tile]
    }

    /// The foveated work of the frame, for its workload.
    pub(crate) fn work(
        self,
        touches: &[Touch],
        first_tile: &[u32],
        parts: &[RowPart],
    ) -> FoveaWork {
        let mut counters = FoveaCounters::default();
        for (touch, &tile) in touches.iter().zip(first_tile) {
            counters.touch(touch);
            if tile != NOBODY {
                counters.fetch(touch);
            }
        }
        for tile in parts.iter().flat_map(|part| &part.tiles) {
            counters.extra_alpha += tile.extra_alpha;
            counters.blends_2 += tile.blends_2;
        }
        FoveaWork {
            gaze: self.gaze,
            regions: self.tiles.tiles.iter().map(|tile| tile.region()).collect(),
            blending_tiles: self.filter.blends.iter().filter(|b| **b).count() as u64,
            counters,
        }
    }
}
