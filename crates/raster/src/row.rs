//! One row of tiles: lists from runs, blending, counters.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use fearless_simd::{Level, dispatch};

use super::blend::{BLOCK, Block, Paint, Record, blend, write_block};
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
    /// Tiles that fetched each splat, by rank.
    pub fetches: &'a [AtomicU32],
    /// Pixels that each splat was blended into, or the sum of its weights there in steps of
    /// `WEIGHT_STEP`, by rank (only if tallied).
    pub tally: &'a [AtomicU64],
    /// Instruction set.
    pub level: Level,
}

/// The lists of a row of tiles.
pub(super) struct Lists {
    /// First entry of each tile, and the end.
    pub starts: Vec<usize>,
    /// Ranks of the splats, front to back.
    pub entries: Vec<u32>,
}

/// Which splats a tile of a row keeps of those that touch it.
pub(super) trait Keep {
    /// All of them: nothing is asked.
    const ALL: bool;

    /// The highest level of the splat of `run`.
    fn highest(&self, run: &Run) -> u8;

    /// Whether tile `x` keeps a splat of this highest level.
    fn keeps(&self, highest: u8, x: usize) -> bool;
}

/// Keeps all.
pub(super) struct Everything;

impl Keep for Everything {
    const ALL: bool = true;

    fn highest(&self, _: &Run) -> u8 {
        0
    }

    fn keeps(&self, _: u8, _: usize) -> bool {
        true
    }
}

/// Renders row `ty` into `out`; returns the counts of its tiles, left to right.
pub(crate) fn render_row<R: Record>(
    shared: &Shared<'_>,
    ty: u32,
    record: R,
    out: &mut RowTarget<'_>,
) -> Vec<TileCount> {
    let lists = build_lists(shared.runs, ty, &Everything);
    let mut block = Block::new();
    let mut tiles = Vec::with_capacity(shared.runs.grid.nx as usize);
    for tx in 0..shared.runs.grid.nx {
        let entries = &lists.entries[lists.starts[tx as usize]..lists.starts[tx as usize + 1]];
        let tile = Tile { tx, ty, entries, accepted: entries.len() as u32 };
        tiles.push(tile.render(shared, record, &mut block, out));
    }
    if R::COUNT {
        count_fetches(shared.runs, shared.fetches, ty, &tiles, &Everything);
    }
    tiles
}

/// The lists of row `ty`.
pub(super) fn build_lists<K: Keep>(runs: &Runs, ty: u32, keep: &K) -> Lists {
    let (starts, total) = starts(runs, ty, keep);
    let mut next = starts.clone();
    let mut entries = vec![0; total];
    for run in runs.row(ty) {
        let highest = keep.highest(run);
        for x in run.x0 as usize..run.x1 as usize {
            if K::ALL || keep.keeps(highest, x) {
                entries[next[x]] = run.rank;
                next[x] += 1;
            }
        }
    }
    Lists { starts, entries }
}

/// Where the lists of row `ty` begin, and the end; and how many entries they have.
pub(super) fn starts<K: Keep>(runs: &Runs, ty: u32, keep: &K) -> (Vec<usize>, usize) {
    let nx = runs.grid.nx as usize;
    // How many more entries a tile has than the one before: wraps, and the sums do not.
    let mut more = vec![0usize; nx + 1];
    for run in runs.row(ty) {
        let (first, end) = (run.x0 as usize, run.x1 as usize);
        if K::ALL {
            more[first] = more[first].wrapping_add(1);
            more[end] = more[end].wrapping_sub(1);
            continue;
        }
        let highest = keep.highest(run);
        for x in (first..end).filter(|&x| keep.keeps(highest, x)) {
            more[x] = more[x].wrapping_add(1);
            more[x + 1] = more[x + 1].wrapping_sub(1);
        }
    }
    let (mut n, mut total) = (0usize, 0);
    for more in &mut more {
        n = n.wrapping_add(*more);
        *more = total;
        total += n;
    }
    (more, total)
}

/// Adds one to the fetches of every splat that a tile loaded: those at positions of its list below
/// the number of loads.
pub(super) fn count_fetches<K: Keep>(
    runs: &Runs,
    fetches: &[AtomicU32],
    ty: u32,
    tiles: &[TileCount],
    keep: &K,
) {
    let add = |rank: u32, n: u32| {
        fetches[rank as usize].fetch_add(n, Ordering::Relaxed);
    };
    if K::ALL && tiles.iter().all(|tile| tile.loaded == tile.entries) {
        runs.row(ty).for_each(|run| add(run.rank, u32::from(run.x1 - run.x0)));
        return;
    }
    let mut seen = vec![0u32; tiles.len()];
    for run in runs.row(ty) {
        let mut fetched = 0;
        let highest = keep.highest(run);
        let columns = run.x0 as usize..run.x1 as usize;
        for x in columns.filter(|&x| K::ALL || keep.keeps(highest, x)) {
            fetched += u32::from(seen[x] < tiles[x].loaded);
            seen[x] += 1;
        }
        if fetched > 0 {
            add(run.rank, fetched);
        }
    }
}

struct Tile<'a> {
    tx: u32,
    ty: u32,
    /// Ranks.
    entries: &'a [u32],
    accepted: u32,
}

impl Tile<'_> {
    /// Renders the tile in blocks of 16x16 pixels.
    fn render<R: Record>(
        &self,
        shared: &Shared<'_>,
        record: R,
        block: &mut Block,
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
                    for (rank, n) in block.tally.drain(..) {
                        shared.tally[rank as usize].fetch_add(u64::from(n), Ordering::Relaxed);
                    }
                }
                let width = shared.runs.grid.width as usize;
                let corner = (by - y0) as usize * width + bx as usize;
                let (pixels, size) = (&mut out.pixels[corner..], (w as usize, h as usize));
                dispatch!(shared.level, simd =>
                    write_block(simd, block, shared.background, size, pixels, width));
                for y in 0..h as usize {
                    let start = corner + y * width;
                    let range = start..start + w as usize;
                    if R::COUNT {
                        most =
                            most.max(self.count_row::<R>(block, y, range.clone(), &mut count, out));
                    }
                    if R::DOMINANCE {
                        out.heaviest[range.clone()]
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

    /// Writes the counts of row `y` of a finished block to `range` of the columns; returns the
    /// entries that its last pixel iterated.
    fn count_row<R: Record>(
        &self,
        block: &Block,
        y: usize,
        range: Range<usize>,
        count: &mut TileCount,
        out: &mut RowTarget<'_>,
    ) -> u32 {
        let blended = &block.blended(y)[..range.len()];
        out.blended[range.clone()].copy_from_slice(blended);
        count.blends += blended.iter().map(|&n| u64::from(n)).sum::<u64>();
        let Some(stops) = block.stops(y) else {
            out.stop_rank[range.clone()].fill(NEVER);
            if R::DOMINANCE {
                out.iterated[range.clone()].fill(self.accepted);
            }
            count.alpha_evaluations += u64::from(self.accepted) * range.len() as u64;
            return self.accepted;
        };
        let mut most = 0;
        for (x, i) in range.enumerate() {
            let entry = self.entries.get(stops[x] as usize);
            let iterated = entry.map_or(self.accepted, |_| stops[x] + 1);
            out.stop_rank[i] = entry.copied().unwrap_or(NEVER);
            if R::DOMINANCE {
                out.iterated[i] = iterated;
            }
            count.alpha_evaluations += u64::from(iterated);
            most = most.max(iterated);
        }
        most
    }
}
