//! One row of tiles: lists from runs, blending, counters.

use std::sync::atomic::{AtomicU32, Ordering};

use fearless_simd::{Level, dispatch};

use super::blend::{BLOCK, Block, Entry, OPEN, Paint, Record, blend};
use crate::splat::TileGrid;
use crate::splat::runs::Runs;
use crate::trace::NEVER;

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

/// The pixels of one row of tiles, and its counts.
#[derive(Debug, Default)]
pub struct RowResult {
    /// Pixels, row-major.
    pub pixels: Vec<[f32; 3]>,
    /// Stop ranks, row-major (only if counted).
    pub stop_rank: Vec<u32>,
    /// Blended entries, row-major (only if counted).
    pub blended: Vec<u32>,
    /// Entries iterated, row-major (only if counted).
    pub iterated: Vec<u32>,
    /// Rank of the heaviest splat, row-major (only for dominance).
    pub heaviest: Vec<u32>,
    /// Tiles, left to right (only if counted).
    pub tiles: Vec<TileCount>,
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
    /// Instruction set.
    pub level: Level,
}

struct Lists {
    /// First entry of each tile, and the end.
    starts: Vec<usize>,
    entries: Vec<Entry>,
    /// Accepted splats of each tile.
    accepted: Vec<u32>,
}

/// Renders row `ty`.
pub fn render_row<R: Record>(shared: &Shared<'_>, ty: u32, record: R) -> RowResult {
    let grid = shared.runs.grid;
    let lists = build_lists(shared.runs, ty);
    let height = grid.pixels(0, ty).3 - ty * grid.tile;
    let n = grid.width as usize * height as usize;
    let mut out = RowResult { pixels: vec![[0.0; 3]; n], ..RowResult::default() };
    if R::COUNT {
        out.stop_rank = vec![NEVER; n];
        out.blended = vec![0; n];
        out.iterated = vec![0; n];
    }
    if R::DOMINANCE {
        out.heaviest = vec![OPEN; n];
    }
    for tx in 0..grid.nx {
        let entries = &lists.entries[lists.starts[tx as usize]..lists.starts[tx as usize + 1]];
        let tile = Tile { tx, ty, entries, accepted: lists.accepted[tx as usize] };
        let count = tile.render(shared, record, &mut out);
        if R::COUNT {
            out.tiles.push(count);
        }
    }
    if R::COUNT {
        count_fetches(shared, ty, &out.tiles);
    }
    out
}

fn build_lists(runs: &Runs, ty: u32) -> Lists {
    let nx = runs.grid.nx as usize;
    let mut counts = vec![0usize; nx];
    for run in runs.row(ty) {
        for n in &mut counts[run.tight0 as usize..run.tight1 as usize] {
            *n += 1;
        }
    }
    let mut starts = Vec::with_capacity(nx + 1);
    let mut total = 0;
    starts.push(0);
    for n in counts {
        total += n;
        starts.push(total);
    }
    let mut next = starts.clone();
    let mut accepted = vec![0u32; nx];
    let mut entries = vec![Entry { rank: 0, ordinal: 0 }; total];
    for run in runs.row(ty) {
        for x in run.tight0 as usize..run.tight1 as usize {
            entries[next[x]] = Entry { rank: run.rank, ordinal: accepted[x] };
            next[x] += 1;
        }
        for n in &mut accepted[run.x0 as usize..run.x1 as usize] {
            *n += 1;
        }
    }
    Lists { starts, entries, accepted }
}

/// Adds one to the fetches of every splat whose position in a tile's list is below what the tile
/// loaded.
fn count_fetches(shared: &Shared<'_>, ty: u32, tiles: &[TileCount]) {
    let mut seen = vec![0u32; tiles.len()];
    for run in shared.runs.row(ty) {
        let mut fetched = 0;
        for x in run.x0 as usize..run.x1 as usize {
            fetched += u32::from(seen[x] < tiles[x].loaded);
            seen[x] += 1;
        }
        if fetched > 0 {
            shared.fetches[run.rank as usize].fetch_add(fetched, Ordering::Relaxed);
        }
    }
}

struct Tile<'a> {
    tx: u32,
    ty: u32,
    entries: &'a [Entry],
    accepted: u32,
}

impl Tile<'_> {
    /// Renders the tile in blocks of 16x16 pixels.
    fn render<R: Record>(&self, shared: &Shared<'_>, record: R, out: &mut RowResult) -> TileCount {
        let grid = shared.runs.grid;
        let (x0, y0, x1, y1) = grid.pixels(self.tx, self.ty);
        let mut count = TileCount { entries: self.accepted, ..TileCount::default() };
        let mut iterated_most = 0;
        for by in (y0..y1).step_by(BLOCK) {
            for bx in (x0..x1).step_by(BLOCK) {
                let (w, h) = ((x1 - bx).min(BLOCK as u32), (y1 - by).min(BLOCK as u32));
                let mut block = Block::new(bx, by, w as usize, h as usize);
                dispatch!(shared.level, simd =>
                    blend(simd, record, &mut block, self.entries, shared.paints));
                let most = self.store::<R>(shared, &block, [bx, by, w, h], &mut count, out);
                iterated_most = iterated_most.max(most);
            }
        }
        // A batch is fetched unless every pixel was done at its start.
        let batches = iterated_most.div_ceil(shared.chunk).max(u32::from(self.accepted > 0));
        count.loaded =
            (u64::from(batches) * u64::from(shared.chunk)).min(u64::from(self.accepted)) as u32;
        count
    }

    /// Copies a finished block into the row; returns the entries that its last pixel iterated.
    fn store<R: Record>(
        &self,
        shared: &Shared<'_>,
        block: &Block,
        [bx, by, w, h]: [u32; 4],
        count: &mut TileCount,
        out: &mut RowResult,
    ) -> u32 {
        let grid: TileGrid = shared.runs.grid;
        let mut most = 0;
        for y in 0..h as usize {
            let line = (by - self.ty * grid.tile) as usize + y;
            let start = line * grid.width as usize + bx as usize;
            for x in 0..w as usize {
                out.pixels[start + x] = block.pixel(x, y, shared.background);
                if R::COUNT {
                    let stop = block.stop(x, y);
                    let entry = self.entries.get(stop as usize);
                    let iterated = entry.map_or(self.accepted, |e| e.ordinal + 1);
                    out.stop_rank[start + x] = entry.map_or(NEVER, |e| e.rank);
                    out.blended[start + x] = block.blended(x, y);
                    out.iterated[start + x] = iterated;
                    count.alpha_evaluations += u64::from(iterated);
                    count.blends += u64::from(block.blended(x, y));
                    most = most.max(iterated);
                }
                if R::DOMINANCE {
                    out.heaviest[start + x] = block.heaviest(x, y);
                }
            }
        }
        most
    }
}
