//! What single volume-rendering cores do in a frame: the lists of sub-tiles, with what becomes of
//! every splat at the pixels of a core; and what rendering units get for a tile.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::picture::ordered;
use powergs_datapath::{Entry, NumberFormat, Outcome, Pixel, Record, TILE, Vrc};
use powergs_frame::splat::runs::Runs;
use powergs_frame::splat::{Splat, TileGrid};
use powergs_raster::Options;
use powergs_scene::{Camera, Gaussians};

/// Side of a sub-tile, pixels.
const SUBTILE: u32 = TILE / 2;

/// The pixels of a core.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CorePixels {
    /// Columns of pixels: 2 or 4.
    pub columns: u32,
    /// Rows of pixels.
    pub rows: u32,
}

/// What a core does in a tile.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CoreWork {
    /// Column and row of its first pixel in the tile.
    pub place: [u8; 2],
    /// Its pixels that are inside the image, from the lowest bit, row by row.
    pub mask: u64,
    /// The splats of its sub-tile, front to back, up to the one that stops its last pixel.
    pub splats: Vec<CoreSplat>,
    /// Its pixels in the end.
    pub pixels: Vec<Pixel>,
}

/// A splat at a core.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CoreSplat {
    /// The splat relative to the tile.
    pub record: Record,
    /// Pixels that had stopped, where it is dropped, blended, and that stop with it.
    pub outcomes: [u8; 4],
}

/// Work of cores with `pixels` pixels each in one view, as their sub-tiles give it to them: of
/// whole sub-tiles, picked all over the image, so that the cores have `slots` (splat, pixel) slots
/// at most by the lengths of the lists.
pub fn core_work(
    scene: &Gaussians,
    camera: &Camera,
    options: &Options,
    (vrc, keys): (&Vrc, Option<NumberFormat>),
    pixels: CorePixels,
    slots: u64,
) -> Vec<CoreWork> {
    let (splats, colours) = ordered(scene, camera, options, keys);
    let grid = TileGrid::new(camera.width, camera.height, SUBTILE);
    let lists = lists(&splats, grid, options);
    let all: u64 = lists.iter().map(|list| list.len() as u64 * u64::from(SUBTILE * SUBTILE)).sum();
    let view = View { vrc, splats: &splats, colours: &colours };
    let picked = picked(grid.nx * grid.ny, all.div_ceil(slots.max(1)).max(1));
    let cores = picked.par_iter().flat_map_iter(|&place| {
        let list = &lists[place as usize];
        let subtile = [place % grid.nx, place / grid.nx];
        let size = [camera.width, camera.height];
        let firsts = (0..SUBTILE)
            .step_by(pixels.rows as usize)
            .flat_map(move |y| (0..SUBTILE).step_by(pixels.columns as usize).map(move |x| [x, y]));
        firsts.filter_map(move |first| view.core(list, subtile, first, pixels, size))
    });
    cores.collect()
}

/// A tile as a rendering unit gets it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TileWork {
    /// Columns and rows of its pixels that are in the image.
    pub size: [u32; 2],
    /// Its list, front to back, to the end: a rendering unit finds out by itself where it stops.
    pub entries: Vec<Entry>,
}

/// Tiles of one view as rendering units get them: whole lists with bitmaps of sub-tiles, of tiles
/// picked all over the image, about `pairs` (splat, sub-tile) pairs in all.
pub fn tile_work(
    scene: &Gaussians,
    camera: &Camera,
    options: &Options,
    (vrc, keys): (&Vrc, Option<NumberFormat>),
    pairs: u64,
) -> Vec<TileWork> {
    let (splats, colours) = ordered(scene, camera, options, keys);
    let grid = TileGrid::new(camera.width, camera.height, TILE);
    let fine = TileGrid::new(camera.width, camera.height, SUBTILE);
    let lists = lists(&splats, fine, options);
    let all: u64 = lists.iter().map(|list| list.len() as u64).sum();
    let view = View { vrc, splats: &splats, colours: &colours };
    let picked = picked(grid.nx * grid.ny, all.div_ceil(pairs.max(1)).max(1));
    let tile = |&place: &u32| {
        let tile = [place % grid.nx, place / grid.nx];
        let mut bitmaps = BTreeMap::new();
        for subtile in 0..4 {
            let [x, y] = [2 * tile[0] + subtile % 2, 2 * tile[1] + subtile / 2];
            if x < fine.nx && y < fine.ny {
                for &rank in &lists[(y * fine.nx + x) as usize] {
                    *bitmaps.entry(rank).or_insert(0u8) |= 1 << subtile;
                }
            }
        }
        let (x0, y0, x1, y1) = grid.pixels(tile[0], tile[1]);
        let entry = |(rank, bitmap)| Some(Entry { splat: view.record(rank, [x0, y0])?, bitmap });
        TileWork {
            size: [x1 - x0, y1 - y0],
            entries: bitmaps.into_iter().filter_map(entry).collect(),
        }
    };
    picked.par_iter().map(tile).filter(|tile| !tile.entries.is_empty()).collect()
}

/// Ranks of the splats of each cell of a grid, front to back.
fn lists(splats: &[Splat], grid: TileGrid, options: &Options) -> Vec<Vec<u32>> {
    let runs = Runs::new(splats, grid, options.test);
    let mut lists: Vec<Vec<u32>> = vec![Vec::new(); (grid.nx * grid.ny) as usize];
    for y in 0..grid.ny {
        for run in runs.row(y) {
            let row = &mut lists[(y * grid.nx) as usize..][..grid.nx as usize];
            for list in &mut row[usize::from(run.x0)..usize::from(run.x1)] {
                list.push(run.rank);
            }
        }
    }
    lists
}

/// One of `stride` places, spread by the golden ratio, so that no stride follows the columns of the
/// image.
fn picked(places: u32, stride: u64) -> Vec<u32> {
    let is_picked = |place: &u32| {
        let spread = u64::from(*place).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        (spread * stride) >> 32 == 0
    };
    (0..places).filter(is_picked).collect()
}

/// What all cores share.
#[derive(Clone, Copy)]
struct View<'a> {
    vrc: &'a Vrc,
    splats: &'a [Splat],
    colours: &'a [[f32; 3]],
}

impl View<'_> {
    /// A splat relative to the tile whose first pixel is given; `None` where it is no ellipse.
    fn record(&self, rank: u32, first: [u32; 2]) -> Option<Record> {
        let Splat { mean, cov, opacity, .. } = self.splats[rank as usize];
        let middle = first.map(|pixel| f64::from(pixel) + 0.5 * f64::from(TILE - 1));
        let mean = [0, 1].map(|i| f64::from(mean[i]) - middle[i]);
        self.vrc.record(mean, cov, opacity, self.colours[rank as usize])
    }

    /// The core whose first pixel is at `first` in sub-tile `subtile`; `None` outside of the image
    /// and where there is no splat.
    fn core(
        &self,
        list: &[u32],
        subtile: [u32; 2],
        first: [u32; 2],
        pixels: CorePixels,
        size: [u32; 2],
    ) -> Option<CoreWork> {
        let at = [0, 1].map(|i| subtile[i] * SUBTILE + first[i]);
        let place = at.map(|pixel| pixel % TILE);
        let first = [0, 1].map(|i| at[i] - place[i]);
        let count = pixels.columns * pixels.rows;
        let inside =
            |i: &u32| at[0] + i % pixels.columns < size[0] && at[1] + i / pixels.columns < size[1];
        let mask: u64 = (0..count).filter(inside).map(|i| 1 << i).sum();
        let open = |i: u32| Pixel::open(self.vrc.format(), mask >> i & 1 == 1);
        let mut state: Vec<Pixel> = (0..count).map(open).collect();
        let mut splats = Vec::new();
        for &rank in list {
            if state.iter().all(|pixel| !pixel.live) {
                break;
            }
            let Some(record) = self.record(rank, first) else { continue };
            let mut outcomes = [0; 4];
            for (i, pixel) in (0..).zip(&mut state) {
                let (x, y) = (place[0] + i % pixels.columns, place[1] + i / pixels.columns);
                let outcome = match self.vrc.blend(pixel, &record, x, y) {
                    Outcome::Idle => 0,
                    Outcome::Dropped => 1,
                    Outcome::Blended => 2,
                    Outcome::Stopped => 3,
                };
                outcomes[outcome] += 1;
            }
            splats.push(CoreSplat { record, outcomes });
        }
        let place = place.map(|pixel| pixel as u8);
        (!splats.is_empty()).then_some(CoreWork { place, mask, splats, pixels: state })
    }
}
