//! One row of tiles: lists from runs, sub-tile bitmaps, and what each chunk has to do.

use super::chunk::{Scratch, TilePixels, push_chunks};
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
    let mut iterated = Vec::new();
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
        let mut work = tile.count(&mut iterated);
        work.list_start = range.start as u32;
        work.chunk_start = part.chunks.len() as u32;
        let pixels = TilePixels { width: tile.pixels.2 - tile.pixels.0, iterated: &iterated };
        push_chunks(geometry, &work, pixels, tile.bitmaps, &mut scratch, &mut part.chunks);
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

struct Tile<'a> {
    frame: &'a Frame,
    geometry: Geometry,
    /// `(x0, y0, x1, y1)`, half open, inside the image.
    pixels: (u32, u32, u32, u32),
    list: &'a [u32],
    bitmaps: &'a [u8],
}

impl Tile<'_> {
    /// Pixel counts of the tile; fills `iterated` with the entries that each of its pixels
    /// iterates, row by row.
    fn count(&self, iterated: &mut Vec<u32>) -> TileWork {
        let (x0, y0, x1, y1) = self.pixels;
        let n = self.list.len() as u32;
        iterated.clear();
        let mut work =
            TileWork { entries: n, pixels: (x1 - x0) * (y1 - y0), ..TileWork::default() };
        let columns = &self.frame.pixels;
        let width = self.frame.facts.camera.width as usize;
        let mut last = (NEVER, n);
        let mut most = 0;
        for y in y0 as usize..y1 as usize {
            let row = y * width + x0 as usize..y * width + x1 as usize;
            for (&stop, &blended) in
                columns.stop_rank[row.clone()].iter().zip(&columns.blended[row])
            {
                if stop != last.0 {
                    last = (stop, self.iterated_until(stop));
                }
                iterated.push(last.1);
                most = most.max(last.1);
                work.alpha_evaluations += u64::from(last.1);
                work.blends += u64::from(blended);
            }
        }
        work.chunks = most.div_ceil(self.geometry.chunk).max(u32::from(n > 0));
        work.loaded =
            (u64::from(work.chunks) * u64::from(self.geometry.chunk)).min(u64::from(n)) as u32;
        work
    }

    /// Entries that a pixel iterates that stops at rank `stop`.
    fn iterated_until(&self, stop: u32) -> u32 {
        match stop {
            NEVER => self.list.len() as u32,
            stop => self.list.partition_point(|&rank| rank <= stop) as u32,
        }
    }
}
