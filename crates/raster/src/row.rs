//! One row of tiles: lists from runs, blending, counters.

use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, u32x16};
use rayon::prelude::*;

use super::blend::{BLOCK, BlendBlock, BlendRecord, Paint, blend, write_block};
use powergs_frame::splat::runs::{Run, Runs};
use powergs_frame::trace::NEVER;

/// Counts of one tile.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct TileCount {
    /// List length (`T_inter`).
    pub entries: u32,
    /// Entries fetched (`T_load`).
    pub loaded: u32,
    /// Entries iterated by its pixels (`T_bf_term`).
    pub alpha_evaluations: u64,
    /// Entries blended by its pixels (`T_used`).
    pub blends: u64,
}

/// Where one row of tiles is written: lines of the image, row-major. Columns that are not recorded
/// are empty.
#[derive(Debug)]
pub(crate) struct RowTarget<'a> {
    /// Pixels.
    pub pixels: &'a mut [[f32; 3]],
    /// Stop ranks (only if counted).
    pub stop_rank: &'a mut [u32],
    /// Blended entries (only if counted).
    pub blended: &'a mut [u32],
    /// Entries iterated (only for dominance).
    pub iterated: &'a mut [u32],
    /// Rank of the heaviest splat (only for dominance).
    pub heaviest: &'a mut [u32],
    /// Counts of the tiles, left to right.
    pub tiles: &'a mut [TileCount],
    /// How far the lists of the tiles are fetched (only if counted).
    pub fetched: &'a mut [Fetched],
}

/// How far the list of a tile is fetched: the rank of the first splat that is not.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fetched(u32);

impl Fetched {
    /// To its end.
    pub const ALL: Fetched = Fetched(u32::MAX);

    /// The first `loaded` entries of a list of ranks.
    pub fn of(entries: &[u32], loaded: u32) -> Fetched {
        entries.get(loaded as usize).map_or(Fetched::ALL, |&rank| Fetched(rank))
    }
}

/// What all rows share.
pub struct Shared<'a> {
    /// Runs of all splats.
    pub runs: &'a Runs,
    /// Splats in the form that blending uses, by rank.
    pub paints: &'a [Paint],
    /// Background colour.
    pub background: [f32; 3],
    /// Entries fetched together.
    pub chunk: u32,
    /// Pixels that each splat was blended into, or the sum of its weights there in steps of
    /// `WEIGHT_STEP`, by rank (only if tallied).
    pub tally: &'a [AtomicU64],
    /// Instruction set.
    pub level: Level,
}

/// The lists of a row of tiles.
#[derive(Debug, Default)]
pub(super) struct RowLists {
    /// First entry of each tile, and the end.
    starts: Vec<usize>,
    /// Where the next entry of each tile goes.
    next: Vec<usize>,
    /// Ranks of the splats, front to back.
    entries: Vec<u32>,
}

/// Which splats a tile of a row keeps of those that touch it.
pub(super) trait RowKeep {
    /// All of them: nothing is asked.
    const ALL: bool;

    /// The highest level of the splat of `run`.
    fn highest(&self, run: &Run) -> u8;

    /// Whether tile `x` keeps a splat of this highest level.
    fn keeps(&self, highest: u8, x: usize) -> bool;
}

/// Keeps all.
pub(super) struct KeepEverything;

impl RowKeep for KeepEverything {
    const ALL: bool = true;

    fn highest(&self, _: &Run) -> u8 {
        0
    }

    fn keeps(&self, _: u8, _: usize) -> bool {
        true
    }
}

/// Memory that is used again for each row.
#[derive(Debug, Default)]
pub(super) struct Work {
    lists: RowLists,
    block: BlendBlock,
}

/// Renders row `ty` into `out`.
pub(super) fn render_row<R: BlendRecord>(
    shared: &Shared<'_>,
    ty: u32,
    record: R,
    Work { lists, block }: &mut Work,
    out: &mut RowTarget<'_>,
) {
    lists.build(shared.runs, ty, &KeepEverything);
    for tx in 0..shared.runs.grid.nx {
        let entries = lists.of(tx);
        let tile = RasterTile { tx, ty, entries, accepted: entries.len() as u32 };
        let count = tile.render(shared, record, block, out);
        out.tiles[tx as usize] = count;
        if R::COUNT {
            out.fetched[tx as usize] = Fetched::of(entries, count.loaded);
        }
    }
}

impl RowLists {
    /// Makes the lists of row `ty`.
    pub fn build<K: RowKeep>(&mut self, runs: &Runs, ty: u32, keep: &K) {
        let RowLists { starts, next, entries } = self;
        let total = find_starts(runs, ty, keep, starts);
        next.clone_from(starts);
        entries.resize(total, 0);
        for run in runs.row(ty) {
            let highest = keep.highest(run);
            for x in run.x0 as usize..run.x1 as usize {
                if K::ALL || keep.keeps(highest, x) {
                    entries[next[x]] = run.rank;
                    next[x] += 1;
                }
            }
        }
    }

    /// The list of tile `tx`: ranks of splats, front to back.
    pub fn of(&self, tx: u32) -> &[u32] {
        &self.entries[self.starts[tx as usize]..self.starts[tx as usize + 1]]
    }
}

/// Finds where the lists of row `ty` begin, and the end; returns how many entries they have.
pub(super) fn find_starts<K: RowKeep>(
    runs: &Runs,
    ty: u32,
    keep: &K,
    starts: &mut Vec<usize>,
) -> usize {
    // First, how many more entries a tile has than the one before: wraps, and the sums do not.
    starts.clear();
    starts.resize(runs.grid.nx as usize + 1, 0);
    for run in runs.row(ty) {
        let (first, end) = (run.x0 as usize, run.x1 as usize);
        if K::ALL {
            starts[first] = starts[first].wrapping_add(1);
            starts[end] = starts[end].wrapping_sub(1);
            continue;
        }
        let highest = keep.highest(run);
        for x in (first..end).filter(|&x| keep.keeps(highest, x)) {
            starts[x] = starts[x].wrapping_add(1);
            starts[x + 1] = starts[x + 1].wrapping_sub(1);
        }
    }
    let (mut n, mut total) = (0usize, 0);
    for more in starts {
        n = n.wrapping_add(*more);
        *more = total;
        total += n;
    }
    total
}

/// Counts the tiles that fetched each splat, by rank. `keep` says what the tiles of a row keep.
pub(super) fn count_fetches<K: RowKeep>(
    runs: &Runs,
    fetched: &[Fetched],
    level: Level,
    keep: impl Fn(u32) -> K + Sync,
    fetches: &mut Vec<u32>,
) {
    fetches.resize(runs.touches.len(), 0);
    let nx = runs.grid.nx as usize;
    let parts = runs.parts().par_iter().zip(fetches.par_chunks_mut(runs.part_len()));
    parts.enumerate().for_each_init(Vec::new, |row, (i, (rows, fetches))| {
        let first = (i * runs.part_len()) as u32;
        fetches.fill(0);
        for (ty, (runs, fetched)) in (0..).zip(rows.iter().zip(fetched.chunks(nx))) {
            // Sixteen tiles from the last one on must be there to be read.
            row.clear();
            row.extend(fetched.iter().map(|tile| tile.0));
            row.resize(fetched.len() + LANES, 0);
            let keep = keep(ty);
            dispatch!(level, simd => add_fetches(simd, runs, row, &keep, first, fetches));
        }
    });
}

/// Tiles that are compared at once.
const LANES: usize = 16;

/// Adds the fetches of the runs of a row, of splats from rank `first` on; the tiles of the row are
/// fetched as far as `row` says.
#[inline(always)]
fn add_fetches<S: Simd, K: RowKeep>(
    simd: S,
    runs: &[Run],
    row: &[u32],
    keep: &K,
    first: u32,
    fetches: &mut [u32],
) {
    for run in runs {
        let highest = keep.highest(run);
        let columns = run.x0 as usize..run.x1 as usize;
        let mut n = 0;
        if K::ALL {
            let rank = u32x16::splat(simd, run.rank);
            for x in columns.clone().step_by(LANES) {
                // The last lanes may reach beyond the run.
                let in_run = (1 << (columns.end - x).min(LANES)) - 1;
                let has = u32x16::from_slice(simd, &row[x..x + LANES]).simd_gt(rank);
                n += (has.to_bitmask() as u32 & in_run).count_ones();
            }
        } else {
            let has = |x: &usize| keep.keeps(highest, *x) && run.rank < row[*x];
            n = columns.filter(has).count() as u32;
        }
        fetches[(run.rank - first) as usize] += n;
    }
}

struct RasterTile<'a> {
    tx: u32,
    ty: u32,
    /// Ranks.
    entries: &'a [u32],
    accepted: u32,
}

impl RasterTile<'_> {
    /// Renders the tile in blocks of 16x16 pixels.
    fn render<R: BlendRecord>(
        &self,
        shared: &Shared<'_>,
        record: R,
        block: &mut BlendBlock,
        out: &mut RowTarget<'_>,
    ) -> TileCount {
        let (x0, y0, x1, y1) = shared.runs.grid.pixels(self.tx, self.ty);
        let mut count = TileCount { entries: self.accepted, ..TileCount::default() };
        let mut most = 0;
        for by in (y0..y1).step_by(BLOCK) {
            for bx in (x0..x1).step_by(BLOCK) {
                let (w, h) = ((x1 - bx).min(BLOCK as u32), (y1 - by).min(BLOCK as u32));
                block.reset::<R>(bx, by, w as usize, h as usize);
                dispatch!(shared.level, simd =>
                    blend(simd, record, block, self.entries, shared.paints));
                if R::PIXELS || R::WEIGHTS {
                    // Whole numbers, so that the order in which threads add them changes nothing.
                    for (rank, n) in block.tally.drain(..) {
                        shared.tally[rank as usize].fetch_add(u64::from(n), Ordering::Relaxed);
                    }
                }
                let width = shared.runs.grid.width as usize;
                let corner = (by - y0) as usize * width + bx as usize;
                let (pixels, size) = (&mut out.pixels[corner..], (w as usize, h as usize));
                dispatch!(shared.level, simd =>
                    write_block(simd, block, shared.background, size, pixels, width));
                if R::COUNT {
                    let iterated = dispatch!(shared.level, _simd =>
                        self.count_block::<R>(block, size, corner, width, &mut count, out));
                    most = most.max(iterated);
                }
                if R::DOMINANCE {
                    for y in 0..h as usize {
                        let start = corner + y * width;
                        out.heaviest[start..start + w as usize]
                            .copy_from_slice(&block.heaviest(y)[..w as usize]);
                    }
                }
            }
        }
        // A batch is fetched unless every pixel was done at its start.
        let batches = most.div_ceil(shared.chunk).max(u32::from(self.accepted > 0));
        count.loaded =
            (u64::from(batches) * u64::from(shared.chunk)).min(u64::from(self.accepted)) as u32;
        count
    }

    /// Writes the counts of a finished block of `w` x `h` pixels to the columns, from `corner` on
    /// in lines of `width`; returns the entries that its last pixel iterated.
    #[inline(always)]
    fn count_block<R: BlendRecord>(
        &self,
        block: &BlendBlock,
        (w, h): (usize, usize),
        corner: usize,
        width: usize,
        count: &mut TileCount,
        out: &mut RowTarget<'_>,
    ) -> u32 {
        let mut most = 0;
        for y in 0..h {
            let start = corner + y * width;
            let range = start..start + w;
            let blended = block.blended(y);
            // A whole row needs no loop.
            match <&mut [u32; BLOCK]>::try_from(&mut out.blended[range.clone()]) {
                Ok(row) => *row = *blended,
                Err(_) => out.blended[range.clone()].copy_from_slice(&blended[..w]),
            }
            // Pixels that take no part blend nothing.
            count.blends += blended.iter().map(|&n| u64::from(n)).sum::<u64>();
            let Some(stops) = block.stops(y) else {
                out.stop_rank[range.clone()].fill(NEVER);
                if R::DOMINANCE {
                    out.iterated[range].fill(self.accepted);
                }
                count.alpha_evaluations += u64::from(self.accepted) * w as u64;
                most = self.accepted;
                continue;
            };
            for (rank, &stop) in out.stop_rank[range.clone()].iter_mut().zip(stops) {
                *rank = self.entries.get(stop as usize).copied().unwrap_or(NEVER);
            }
            // Saturating, because `OPEN` is the largest number there is.
            let iterated = |&stop: &u32| stop.saturating_add(1).min(self.accepted);
            for n in stops[..w].iter().map(iterated) {
                count.alpha_evaluations += u64::from(n);
                most = most.max(n);
            }
            if R::DOMINANCE {
                for (out, n) in out.iterated[range].iter_mut().zip(stops.iter().map(iterated)) {
                    *out = n;
                }
            }
        }
        most
    }
}
