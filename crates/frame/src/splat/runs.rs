//! Accepted tiles of many splats, bucketed by row of tiles and kept in depth order.
//!
//! Every row of tiles can then be worked on by itself, in parallel and without shared state:
//! position in a bucket is depth order for any number of threads.

use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use rayon::prelude::*;

use super::cover::{CoverBlock, TileRow};
use super::levels::LevelFilter;
use super::project::LANES;
use super::{Cover, Intersection, Splat, TileGrid};

/// Tiles of one row that one splat touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// Depth rank of the splat.
    pub rank: u32,
    /// First column that the intersection test accepts.
    pub x0: u16,
    /// End column.
    pub x1: u16,
}

/// Intersection counts of one splat.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Touch {
    /// Tiles tested (`P_obb_count`).
    pub tests: u32,
    /// Tiles accepted (`N_inter`).
    pub tiles: u32,
    /// Tiles whose level is looked up (`P_tile_ecc_accesses`): all candidates in foveated frames, 0
    /// in others.
    pub lookups: u32,
    /// Levels whose colours it needs (`P_levels` + 1); 0 without a tile and in other frames.
    pub levels: u8,
}

/// The level test of a foveated frame: which splats take part in which tiles.
#[derive(Debug, Clone, Copy)]
pub struct Levels<'a> {
    /// The levels of the tiles.
    pub filter: &'a LevelFilter,
    /// The highest level of every splat, by rank.
    pub highest: &'a [u8],
}

/// All runs of a frame.
#[derive(Debug, Clone, Default)]
pub struct Runs {
    /// The grid.
    pub grid: TileGrid,
    /// Per splat, by rank.
    pub touches: Vec<Touch>,
    /// Ranks in a part (the last one may have fewer).
    part: usize,
    /// Per part (consecutive ranks) and row of tiles.
    parts: Vec<Vec<Vec<Run>>>,
}

impl Runs {
    /// Tests all `splats` (in depth order) against the tiles of `grid`.
    pub fn new(splats: &[Splat], grid: TileGrid, test: Intersection) -> Runs {
        Runs::of(splats, grid, test, None)
    }

    /// As [`Runs::new`], with the level test before the others. The tiles of a run are still those
    /// that the intersection test accepts: the filter says which of them keep the splat. Touches
    /// count only those.
    pub fn foveated(
        splats: &[Splat],
        grid: TileGrid,
        test: Intersection,
        levels: Levels<'_>,
    ) -> Runs {
        Runs::of(splats, grid, test, Some(levels))
    }

    fn of(
        splats: &[Splat],
        grid: TileGrid,
        test: Intersection,
        levels: Option<Levels<'_>>,
    ) -> Runs {
        let mut runs = Runs { grid, ..Runs::default() };
        runs.fill(splats, test, levels);
        runs
    }

    /// Becomes [`Runs::new`] of others, in the memory that it has.
    pub fn renew(&mut self, splats: &[Splat], grid: TileGrid, test: Intersection) {
        self.grid = grid;
        self.fill(splats, test, None);
    }

    fn fill(&mut self, splats: &[Splat], test: Intersection, levels: Option<Levels<'_>>) {
        let simd_level = Level::new();
        let (grid, part) =
            (self.grid, splats.len().div_ceil(4 * rayon::current_num_threads()).max(4096));
        self.part = part;
        self.touches.resize(splats.len(), Touch::default());
        self.parts.resize_with(splats.len().div_ceil(part), Vec::new);
        let parts = self.parts.par_iter_mut().zip(self.touches.par_chunks_mut(part));
        parts.zip(splats.par_chunks(part)).enumerate().for_each(
            |(i, ((rows, touches), splats))| {
                rows.resize_with(grid.ny as usize, Vec::new);
                rows.iter_mut().for_each(Vec::clear);
                let first = (i * part) as u32;
                let of = RunPart { first, splats, grid, test, levels };
                dispatch!(simd_level, simd => add_part(simd, rows, touches, &of));
            },
        );
    }

    /// The runs of row `ty`, in depth order.
    pub fn row(&self, ty: u32) -> impl Iterator<Item = &Run> + Clone {
        self.parts.iter().flat_map(move |rows| &rows[ty as usize])
    }

    /// Ranks in a part; the last part may have fewer.
    pub fn part_len(&self) -> usize {
        self.part
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> usize {
        let runs = self.parts.iter().flatten().map(Vec::capacity).sum::<usize>();
        self.touches.capacity() * size_of::<Touch>() + runs * size_of::<Run>()
    }

    /// Parts of [`Runs::part_len`] consecutive ranks, each with its runs per row of tiles. The runs
    /// of a row are those of all parts in turn.
    pub fn parts(&self) -> &[Vec<Vec<Run>>] {
        &self.parts
    }
}

/// Splats of consecutive ranks, and how they are tested.
struct RunPart<'a> {
    /// The first rank.
    first: u32,
    splats: &'a [Splat],
    grid: TileGrid,
    test: Intersection,
    levels: Option<Levels<'a>>,
}

/// Adds the runs of the splats of `part` to their rows of tiles, and writes their counts.
#[simd]
fn add_part<S: Simd>(simd: S, rows: &mut [Vec<Run>], touches: &mut [Touch], part: &RunPart<'_>) {
    let firsts = (part.first..).step_by(LANES);
    let blocks = part.splats.chunks(LANES).zip(touches.chunks_mut(LANES));
    for (first, (splats, touches)) in firsts.zip(blocks) {
        if part.test == Intersection::Obb {
            let covers = CoverBlock::new(simd, splats, part.grid);
            for ((lane, rank), touch) in (first..).enumerate().zip(touches) {
                *touch = add_runs(simd, rows, rank, &covers.get(lane), part);
            }
        } else {
            for ((rank, splat), touch) in (first..).zip(splats).zip(touches) {
                let cover = Cover::new(splat, part.grid, part.test);
                *touch = add_runs(simd, rows, rank, &cover, part);
            }
        }
    }
}

/// Adds the runs of one splat to those of its rows of tiles.
#[inline(always)]
fn add_runs<S: Simd>(
    simd: S,
    rows: &mut [Vec<Run>],
    rank: u32,
    cover: &Cover,
    part: &RunPart<'_>,
) -> Touch {
    let mut touch = Touch { tests: cover.tests() as u32, ..Touch::default() };
    let mut needed = Needed::new(part.levels, rank, cover, &mut touch);
    for y in cover.rect.y0..cover.rect.y1 {
        let Some(row) = cover.row_by(simd, y) else { continue };
        match &mut needed {
            None => touch.tiles += row.x1 - row.x0,
            Some(needed) => needed.row(&row, &mut touch),
        }
        let run = Run { rank, x0: row.x0 as u16, x1: row.x1 as u16 };
        rows[row.y as usize].push(run);
    }
    touch
}

/// The level test of one splat.
struct Needed<'a> {
    filter: &'a LevelFilter,
    highest: u8,
    /// First and last level that it needs so far.
    span: (u8, u8),
}

impl<'a> Needed<'a> {
    /// Looks the levels of all candidates up; box tests are made where they say so.
    fn new(
        levels: Option<Levels<'a>>,
        rank: u32,
        cover: &Cover,
        touch: &mut Touch,
    ) -> Option<Self> {
        let Levels { filter, highest } = levels?;
        let highest = highest[rank as usize];
        touch.lookups = cover.rect.area() as u32;
        if touch.tests > 0 {
            touch.tests = filter.count(&cover.rect, highest) as u32;
        }
        Some(Needed { filter, highest, span: (u8::MAX, 0) })
    }

    fn row(&mut self, row: &TileRow, touch: &mut Touch) {
        let start = self.filter.grid.index(0, row.y);
        for tile in start + row.x0 as usize..start + row.x1 as usize {
            if self.filter.keeps(tile, self.highest) {
                let (first, last) = self.filter.needed(tile, self.highest);
                self.span = (self.span.0.min(first), self.span.1.max(last));
                touch.tiles += 1;
                touch.levels = self.span.1 - self.span.0 + 1;
            }
        }
    }
}
