//! One row of tiles of a foveated frame.

use fearless_simd::{Level, Simd, dispatch};

use super::super::blend::{BLOCK, BlendBlock, BlendRecord, blend};
use super::super::row::{Fetched, RowKeep, RowLists, TileCount};
use super::FoveatedTile;
use super::paints::LevelPaints;
use super::pair::{FoveatedPair, blend_pair};
use powergs_frame::fovea::{TileLevel, TileLevels};
use powergs_frame::splat::levels::LevelFilter;
use powergs_frame::splat::runs::{Run, Runs};
use powergs_frame::trace::NEVER;

/// Where one row of tiles is written. Columns that are not recorded are empty.
pub(super) struct FoveatedRowTarget<'a> {
    pub pixels: &'a mut [[f32; 3]],
    pub stop_rank: &'a mut [u32],
    pub blended: &'a mut [u32],
    /// Stop rank, entries while both are open, blended.
    pub second: [&'a mut [u32]; 3],
    pub tiles: &'a mut [FoveatedTile],
    pub fetched: &'a mut [Fetched],
}

/// What all rows share.
pub(super) struct Shared<'a> {
    pub runs: &'a Runs,
    pub paints: &'a LevelPaints,
    pub levels: &'a TileLevels,
    pub filter: &'a LevelFilter,
    pub background: [f32; 3],
    pub chunk: u32,
    pub level: Level,
}

/// Keeps the splats of the levels of a row of tiles.
struct ByLevel<'a> {
    /// Levels of the tiles of the row.
    first: &'a [u8],
    highest: &'a [u8],
}

impl RowKeep for ByLevel<'_> {
    const ALL: bool = false;

    #[inline]
    fn highest(&self, run: &Run) -> u8 {
        self.highest[run.rank as usize]
    }

    #[inline]
    fn keeps(&self, highest: u8, x: usize) -> bool {
        self.first[x] <= highest
    }
}

impl Shared<'_> {
    /// What the tiles of row `ty` keep.
    pub fn keep(&self, ty: u32) -> impl RowKeep {
        let grid = &self.runs.grid;
        let row = grid.index(0, ty)..grid.index(0, ty) + grid.nx as usize;
        ByLevel { first: &self.filter.first[row], highest: &self.paints.highest }
    }
}

/// Renders row `ty` into `out`.
pub(super) fn render_row<R: BlendRecord>(
    shared: &Shared<'_>,
    ty: u32,
    record: R,
    work: &mut Work,
    out: &mut FoveatedRowTarget<'_>,
) {
    let grid = &shared.runs.grid;
    work.lists.build(shared.runs, ty, &shared.keep(ty));
    for tx in 0..grid.nx {
        let entries = work.lists.of(tx);
        let level = shared.levels.tiles[grid.index(tx, ty)];
        let accepted = entries.len() as u32;
        let tile = LevelTile { shared, tx, ty, level, entries, accepted };
        let tile_counts = tile.render(record, &mut work.blocks, out);
        out.tiles[tx as usize] = tile_counts;
        if R::COUNT {
            out.fetched[tx as usize] = Fetched::of(entries, tile_counts.count.loaded);
        }
    }
}

/// Memory that is used again for each row.
#[derive(Default)]
pub(super) struct Work {
    lists: RowLists,
    blocks: Blocks,
}

/// Memory that is used again for each tile.
#[derive(Default)]
struct Blocks {
    first: BlendBlock,
    second: BlendBlock,
    shares: RowShares,
}

struct LevelTile<'a> {
    shared: &'a Shared<'a>,
    tx: u32,
    ty: u32,
    level: TileLevel,
    /// Ranks.
    entries: &'a [u32],
    accepted: u32,
}

/// Shares of the second level of the pixels of a block.
type RowShares = [[f32; BLOCK]; BLOCK];

impl LevelTile<'_> {
    fn render<R: BlendRecord>(
        &self,
        record: R,
        work: &mut Blocks,
        out: &mut FoveatedRowTarget<'_>,
    ) -> FoveatedTile {
        let shared = self.shared;
        let (x0, y0, x1, y1) = shared.runs.grid.pixels(self.tx, self.ty);
        let count = TileCount { entries: self.accepted, ..TileCount::default() };
        let mut tile = FoveatedTile { count, ..FoveatedTile::default() };
        let mut most = 0;
        for by in (y0..y1).step_by(BLOCK) {
            for bx in (x0..x1).step_by(BLOCK) {
                let size = [(x1 - bx).min(BLOCK as u32), (y1 - by).min(BLOCK as u32)];
                let block = PixelBlock { x: bx, y: by, size: size.map(|n| n as usize) };
                self.blend(record, &block, work);
                for y in 0..block.size[1] {
                    let line = (by - y0) as usize + y;
                    let start = line * shared.runs.grid.width as usize + bx as usize;
                    let row = Row { start, y, width: block.size[0] };
                    self.write(&row, work, out);
                    if R::COUNT {
                        let iterated = match self.level.blends {
                            true => self.count_two(&row, work, &mut tile, out),
                            false => self.count_one(&row, &work.first, &mut tile, out),
                        };
                        most = most.max(iterated);
                    }
                }
            }
        }
        let batches = most.div_ceil(shared.chunk).max(u32::from(self.accepted > 0));
        let fetched = u64::from(batches) * u64::from(shared.chunk);
        tile.count.loaded = fetched.min(u64::from(self.accepted)) as u32;
        tile
    }

    /// Blends one block into one or two accumulators.
    fn blend<R: BlendRecord>(&self, record: R, at: &PixelBlock, work: &mut Blocks) {
        let shared = self.shared;
        let [width, height] = at.size;
        work.first.reset::<R>(at.x, at.y, width, height);
        let paints = shared.paints.of_level(self.level.first);
        if !self.level.blends {
            dispatch!(shared.level, simd =>
                blend(simd, record, &mut work.first, self.entries, paints));
            return;
        }
        work.second.reset::<R>(at.x, at.y, width, height);
        self.share(at, work);
        let blocks = [&mut work.first, &mut work.second];
        let mut pair = FoveatedPair { blocks, paints };
        dispatch!(shared.level, simd => blend_pair(simd, record, &mut pair, self.entries));
    }

    /// Finds the shares of a block; takes pixels that see one level only out of the other.
    fn share(&self, at: &PixelBlock, work: &mut Blocks) {
        let side = f64::from(self.shared.runs.grid.tile);
        let offset = |p: u32, t: u32| f64::from(p) / side - f64::from(t) - 0.5;
        let dx: [f64; BLOCK] = std::array::from_fn(|x| offset(at.x + x as u32, self.tx));
        for (y, shares) in work.shares.iter_mut().enumerate().take(at.size[1]) {
            let dy = offset(at.y + y as u32, self.ty);
            let (mut only_first, mut only_second) = (0u32, 0u32);
            for (x, share) in shares.iter_mut().enumerate() {
                *share = self.level.share([dx[x], dy]) as f32;
                only_first |= u32::from(*share <= 0.0) << x;
                only_second |= u32::from(*share >= 1.0) << x;
            }
            work.first.leave_out(y, only_second);
            work.second.leave_out(y, only_first);
        }
    }

    fn write(&self, row: &Row, work: &Blocks, out: &mut FoveatedRowTarget<'_>) {
        let pixels = &mut out.pixels[row.start..][..row.width];
        dispatch!(self.shared.level, simd => self.write_row(simd, row, work, pixels));
    }

    #[inline(always)]
    fn write_row<S: Simd>(&self, simd: S, row: &Row, work: &Blocks, pixels: &mut [[f32; 3]]) {
        let background = self.shared.background;
        let shares = &work.shares[row.y][..row.width];
        if !self.level.blends || shares.iter().all(|&share| share <= 0.0) {
            work.first.write_row(simd, row.y, background, pixels);
        } else if shares.iter().all(|&share| share >= 1.0) {
            work.second.write_row(simd, row.y, background, pixels);
        } else {
            let a = work.first.row(simd, row.y, background);
            let b = work.second.row(simd, row.y, background);
            for ((x, pixel), share) in pixels.iter_mut().enumerate().zip(shares) {
                *pixel = [0, 1, 2].map(|c| (1.0 - share) * a[c][x] + share * b[c][x]);
            }
        }
    }

    /// Writes the counts of a finished row of a tile of one level; returns the entries that its
    /// last pixel iterated.
    fn count_one(
        &self,
        row: &Row,
        block: &BlendBlock,
        tile: &mut FoveatedTile,
        out: &mut FoveatedRowTarget<'_>,
    ) -> u32 {
        let range = row.start..row.start + row.width;
        let blended = &block.blended(row.y)[..row.width];
        out.blended[range.clone()].copy_from_slice(blended);
        tile.count.blends += blended.iter().map(|&n| u64::from(n)).sum::<u64>();
        if self.left_out() != 0 {
            out.second[0][range.clone()].fill(self.left_out());
        }
        let Some(stops) = block.stops(row.y) else {
            out.stop_rank[range].fill(NEVER);
            tile.count.alpha_evaluations += u64::from(self.accepted) * row.width as u64;
            return self.accepted;
        };
        let mut most = 0;
        for (&stop, rank) in stops.iter().zip(&mut out.stop_rank[range]) {
            let entry = self.entries.get(stop as usize);
            let iterated = entry.map_or(self.accepted, |_| stop + 1);
            *rank = entry.copied().unwrap_or(NEVER);
            tile.count.alpha_evaluations += u64::from(iterated);
            most = most.max(iterated);
        }
        most
    }

    /// The stop rank of pixels that take no part: 0, at which nothing stops, unless there are no
    /// splats at all.
    fn left_out(&self) -> u32 {
        if self.shared.paints.splats.is_empty() { NEVER } else { 0 }
    }

    /// As [`LevelTile::count_one`], of a tile that blends two levels.
    fn count_two(
        &self,
        row: &Row,
        work: &Blocks,
        tile: &mut FoveatedTile,
        out: &mut FoveatedRowTarget<'_>,
    ) -> u32 {
        let left_out = self.left_out();
        let stops = [work.first.stops(row.y), work.second.stops(row.y)];
        let blended = [work.first.blended(row.y), work.second.blended(row.y)];
        let mut most = 0;
        for x in 0..row.width {
            let share = work.shares[row.y][x];
            let takes_part = [share < 1.0, share > 0.0];
            // Stop rank, entries iterated, blended, whether it stopped.
            let seen: [(u32, u32, u32, bool); 2] = std::array::from_fn(|k| {
                if !takes_part[k] {
                    return (left_out, 0, 0, false);
                }
                let stop = stops[k].map(|stops| stops[x]).filter(|&at| at < self.accepted);
                let iterated = stop.map_or(self.accepted, |at| at + 1);
                let rank = stop.map_or(NEVER, |at| self.entries[at as usize]);
                (rank, iterated, blended[k][x], stop.is_some())
            });
            let [a, b] = seen;
            let iterated = a.1.max(b.1);
            // Entries that both levels looked at: the shorter of the two walks.
            let both = if takes_part == [true, true] { a.1.min(b.1) } else { 0 };
            // Unlike the column of the first level, this one leaves out the entry that stops a
            // pixel.
            let blended_2 = b.2 - u32::from(b.3);
            let i = row.start + x;
            (out.stop_rank[i], out.blended[i]) = (a.0, a.2);
            for (column, value) in out.second.iter_mut().zip([b.0, both, blended_2]) {
                column[i] = value;
            }
            tile.count.alpha_evaluations += u64::from(iterated);
            tile.count.blends += u64::from(a.2);
            tile.extra_alpha += u64::from(both);
            tile.blends_2 += u64::from(blended_2);
            most = most.max(iterated);
        }
        most
    }
}

/// Pixels of a block: its corner and its size.
struct PixelBlock {
    x: u32,
    y: u32,
    size: [usize; 2],
}

/// A row of pixels of a block.
struct Row {
    /// First pixel in the target.
    start: usize,
    /// Row in the block.
    y: usize,
    width: usize,
}
