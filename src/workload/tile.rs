//! One row of tiles: lists from runs, sub-tile bitmaps, and what each chunk has to do.

use super::{ChunkWork, Geometry, TileWork};
use crate::splat::runs::Runs;
use crate::splat::{Cover, TileGrid};
use crate::trace::{Frame, NEVER};

/// A binned row of tiles; positions are relative to the row.
#[derive(Debug, Default)]
pub struct RowPart {
    /// Tiles, left to right.
    pub tiles: Vec<TileWork>,
    /// Fetched chunks, tile by tile.
    pub chunks: Vec<ChunkWork>,
    /// Depth ranks, tile by tile.
    pub list: Vec<u32>,
    /// Sub-tile bitmaps of the entries.
    pub bitmaps: Vec<u8>,
}

/// Bins row `ty`.
pub fn bin_row(frame: &Frame, runs: &Runs, geometry: Geometry, ty: u32) -> RowPart {
    let (starts, list, bitmaps) = build_lists(frame, runs, geometry, ty);
    let mut part = RowPart { list, bitmaps, ..RowPart::default() };
    let mut scratch = Scratch::default();
    for tx in 0..runs.grid.nx {
        let range = starts[tx as usize]..starts[tx as usize + 1];
        let bytes = geometry.bitmap_bytes();
        let tile = Tile {
            frame,
            geometry,
            pixels: runs.grid.pixels(tx, ty),
            list: &part.list[range.clone()],
            bitmaps: &part.bitmaps[range.start * bytes..range.end * bytes],
        };
        let mut work = tile.count(&mut scratch);
        work.list_start = range.start as u32;
        work.chunk_start = part.chunks.len() as u32;
        tile.push_chunks(&work, &mut scratch, &mut part.chunks);
        part.tiles.push(work);
    }
    part
}

fn build_lists(
    frame: &Frame,
    runs: &Runs,
    geometry: Geometry,
    ty: u32,
) -> (Vec<usize>, Vec<u32>, Vec<u8>) {
    let nx = runs.grid.nx as usize;
    let mut starts = vec![0usize; nx + 1];
    for run in runs.row(ty) {
        for n in &mut starts[run.x0 as usize + 1..=run.x1 as usize] {
            *n += 1;
        }
    }
    for x in 0..nx {
        starts[x + 1] += starts[x];
    }
    let bytes = geometry.bitmap_bytes();
    let mut next = starts.clone();
    let mut list = vec![0u32; starts[nx]];
    let mut bitmaps = vec![0u8; starts[nx] * bytes];
    let camera = &frame.facts.camera;
    let subgrid = TileGrid::new(camera.width, camera.height, geometry.subtile);
    for run in runs.row(ty) {
        let splat = &frame.splats[run.rank as usize];
        let cover = Cover::new(splat, subgrid, geometry.test);
        let per_side = geometry.subtiles_per_side();
        for x in run.x0 as usize..run.x1 as usize {
            list[next[x]] = run.rank;
        }
        for (sy, y) in (ty * per_side..((ty + 1) * per_side).min(subgrid.ny)).enumerate() {
            let Some(row) = cover.row(y) else { continue };
            let (first, end) = (
                row.x0.max(u32::from(run.x0) * per_side),
                row.x1.min(u32::from(run.x1) * per_side),
            );
            for sx in first..end {
                let bit = sy as u32 * per_side + sx % per_side;
                let entry = next[(sx / per_side) as usize];
                bitmaps[entry * bytes + bit as usize / 8] |= 1 << (bit % 8);
            }
        }
        for n in &mut next[run.x0 as usize..run.x1 as usize] {
            *n += 1;
        }
    }
    (starts, list, bitmaps)
}

#[derive(Debug, Default)]
struct Scratch {
    /// Entries that each pixel of the tile iterates, sub-tile by sub-tile.
    iterated: Vec<(u32, u32)>,
    /// Entries until the last pixel of each sub-tile stopped.
    ends: Vec<u32>,
    /// Entries with a set bit before each position, of one sub-tile.
    before: Vec<u32>,
}

struct Tile<'a> {
    frame: &'a Frame,
    geometry: Geometry,
    /// `(x0, y0, x1, y1)`, half open, inside the image.
    pixels: (u32, u32, u32, u32),
    list: &'a [u32],
    bitmaps: &'a [u8],
}

impl Tile<'_> {
    /// Pixel counts of the tile; fills `iterated` and `ends`.
    fn count(&self, scratch: &mut Scratch) -> TileWork {
        let (x0, y0, x1, y1) = self.pixels;
        let n = self.list.len() as u32;
        scratch.iterated.clear();
        scratch.ends.clear();
        scratch.ends.resize(self.geometry.subtiles() as usize, 0);
        let mut work =
            TileWork { entries: n, pixels: (x1 - x0) * (y1 - y0), ..TileWork::default() };
        let columns = &self.frame.pixels;
        let width = self.frame.facts.camera.width as usize;
        let mut last = (NEVER, n);
        for y in y0..y1 {
            for x in x0..x1 {
                let i = y as usize * width + x as usize;
                let stop = columns.stop_rank[i];
                if stop != last.0 {
                    let iterated = if stop == NEVER {
                        n
                    } else {
                        self.list.partition_point(|&rank| rank <= stop) as u32
                    };
                    last = (stop, iterated);
                }
                let subtile = (y - y0) / self.geometry.subtile * self.geometry.subtiles_per_side()
                    + (x - x0) / self.geometry.subtile;
                scratch.iterated.push((subtile, last.1));
                let end = &mut scratch.ends[subtile as usize];
                *end = (*end).max(last.1);
                work.alpha_evaluations += u64::from(last.1);
                work.blends += u64::from(columns.blended[i]);
            }
        }
        let most = scratch.ends.iter().copied().max().unwrap_or(0);
        work.chunks = most.div_ceil(self.geometry.chunk).max(u32::from(n > 0));
        work.loaded =
            (u64::from(work.chunks) * u64::from(self.geometry.chunk)).min(u64::from(n)) as u32;
        work
    }

    /// Appends the fetched chunks, without their first loads.
    fn push_chunks(&self, work: &TileWork, scratch: &mut Scratch, out: &mut Vec<ChunkWork>) {
        let (start, chunk) = (out.len(), self.geometry.chunk);
        for c in 0..work.chunks {
            let entries = chunk.min(work.loaded - c * chunk);
            out.push(ChunkWork { entries, ..ChunkWork::default() });
        }
        scratch.iterated.sort_unstable();
        let mut pixels = scratch.iterated.as_slice();
        for (subtile, &end) in scratch.ends.iter().enumerate() {
            let n = pixels.partition_point(|p| p.0 as usize == subtile);
            let (own, rest) = pixels.split_at(n);
            pixels = rest;
            self.count_bits(subtile, end, &mut scratch.before);
            for (c, work) in out[start..].iter_mut().enumerate() {
                let first = c as u32 * chunk;
                let stop = (first + work.entries).min(end);
                if stop <= first {
                    break;
                }
                let before = &scratch.before;
                let set = |p: u32| before[p as usize] - before[first as usize];
                work.subtile_pairs += set(stop);
                work.subtile_pairs_unskipped += stop - first;
                let live = own[own.partition_point(|p| p.1 <= first)..].iter();
                work.live_evaluations += live.map(|p| set(p.1.min(stop))).sum::<u32>();
            }
        }
    }

    /// `before[p]`: entries with the bit of `subtile` set among the first p, for p up to `end`.
    fn count_bits(&self, subtile: usize, end: u32, before: &mut Vec<u32>) {
        let bytes = self.geometry.bitmap_bytes();
        before.clear();
        before.push(0);
        let mut n = 0;
        for bitmap in self.bitmaps.chunks_exact(bytes).take(end as usize) {
            n += u32::from(bitmap[subtile / 8] >> (subtile % 8) & 1);
            before.push(n);
        }
    }
}
