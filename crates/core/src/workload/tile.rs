//! One row of tiles: lists from runs, sub-tile bitmaps, and what each chunk has to do.

use super::chunk::{ChunkScratch, TilePixels, push_chunks};
use super::fovea::TileFovea;
use super::{ChunkWork, FrameDetail, Geometry, TileWork};
use powergs_frame::splat::runs::Runs;
use powergs_frame::splat::{Cover, Ellipse, TileGrid};
use powergs_frame::trace::{Frame, NEVER};

/// A binned row of tiles; positions are relative to the row.
#[derive(Debug, Default)]
pub(crate) struct RowPart {
    /// Tiles, left to right.
    pub tiles: Vec<TileWork>,
    /// Fetched chunks, tile by tile.
    pub chunks: Vec<ChunkWork>,
    /// Depth ranks, tile by tile.
    pub list: Vec<u32>,
    /// Sub-tile bitmaps of the entries.
    pub bitmaps: Vec<u8>,
    /// Where sub-tiles stop, tile by tile.
    pub stops: Vec<[u32; 4]>,
    /// Where pixels stop, row by row; empty where nobody asks.
    pub iterated: Vec<u32>,
}

impl RowPart {
    /// Keeps where the pixels `x0..x1` of all rows of a tile stop.
    fn keep(&mut self, width: u32, (x0, y0, x1, y1): (u32, u32, u32, u32), stops: &[u32]) {
        self.iterated.resize(width as usize * (y1 - y0) as usize, 0);
        let rows = self.iterated.chunks_exact_mut(width as usize);
        for (row, stops) in rows.zip(stops.chunks_exact((x1 - x0) as usize)) {
            row[x0 as usize..x1 as usize].copy_from_slice(stops);
        }
    }
}

/// Bins row `ty`.
pub(crate) fn bin_row(
    frame: &Frame,
    runs: &Runs,
    fovea: Option<&TileFovea<'_>>,
    (geometry, detail): (Geometry, FrameDetail),
    ty: u32,
) -> RowPart {
    let (starts, list, bitmaps) = build_lists(frame, runs, fovea, geometry, ty);
    let mut part = RowPart { list, bitmaps, ..RowPart::default() };
    let mut counted = Counted::default();
    let mut scratch = ChunkScratch::default();
    for tx in 0..runs.grid.nx {
        let range = starts[tx as usize]..starts[tx as usize + 1];
        let bytes = geometry.bitmap_bytes();
        let tile = Tile {
            frame,
            geometry,
            whole: detail.whole,
            fovea: fovea.map(|fovea| (fovea, runs.grid.index(tx, ty))),
            pixels: runs.grid.pixels(tx, ty),
            list: &part.list[range.clone()],
            bitmaps: &part.bitmaps[range.start * bytes..range.end * bytes],
        };
        let mut work = tile.count(&mut counted);
        work.list_start = range.start as u32;
        work.chunk_start = part.chunks.len() as u32;
        let Counted { iterated, both, seconds } = &counted;
        let width = tile.pixels.2 - tile.pixels.0;
        let pixels = TilePixels { width, iterated, both, seconds };
        let (chunks, stops) = (&mut part.chunks, &mut part.stops);
        push_chunks(geometry, &work, pixels, tile.bitmaps, &mut scratch, chunks, stops);
        if detail.pixels {
            part.keep(frame.facts.camera.width, tile.pixels, iterated);
        }
        part.tiles.push(work);
    }
    part
}

fn build_lists(
    frame: &Frame,
    runs: &Runs,
    fovea: Option<&TileFovea<'_>>,
    geometry: Geometry,
    ty: u32,
) -> (Vec<usize>, Vec<u32>, Vec<u8>) {
    let nx = runs.grid.nx as usize;
    let mut starts = vec![0usize; nx + 1];
    let row = runs.grid.index(0, ty);
    let keeps = |rank: u32, x: usize| fovea.is_none_or(|fovea| fovea.keeps(row + x, rank));
    for run in runs.row(ty) {
        let columns = run.x0 as usize..run.x1 as usize;
        for (x, n) in columns.zip(&mut starts[run.x0 as usize + 1..=run.x1 as usize]) {
            *n += usize::from(keeps(run.rank, x));
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
        for x in (run.x0 as usize..run.x1 as usize).filter(|&x| keeps(run.rank, x)) {
            list[next[x]] = run.rank;
        }
        for (sy, y) in (ty * per_side..((ty + 1) * per_side).min(subgrid.ny)).enumerate() {
            let Some(row) = cover.row(y) else { continue };
            let (first, end) = (
                row.x0.max(u32::from(run.x0) * per_side),
                row.x1.min(u32::from(run.x1) * per_side),
            );
            let kept = |sx: &u32| keeps(run.rank, (sx / per_side) as usize);
            for sx in (first..end).filter(kept) {
                let bit = sy as u32 * per_side + sx % per_side;
                let entry = next[(sx / per_side) as usize];
                bitmaps[entry * bytes + bit as usize / 8] |= 1 << (bit % 8);
            }
        }
        let columns = run.x0 as usize..run.x1 as usize;
        for (x, n) in columns.clone().zip(&mut next[columns]) {
            *n += usize::from(keeps(run.rank, x));
        }
    }
    (starts, list, bitmaps)
}

/// Counters of the pixels of a tile, row by row, and of its entries. The last two are empty
/// where nothing is blended between levels.
#[derive(Debug, Default)]
struct Counted {
    /// Entries that each pixel iterates.
    iterated: Vec<u32>,
    /// Entries that it iterates while both of its levels are open.
    both: Vec<u32>,
    /// Whether the second level has the entry.
    seconds: Vec<bool>,
}

struct Tile<'a> {
    frame: &'a Frame,
    geometry: Geometry,
    /// Whether pixels go through the whole list.
    whole: bool,
    /// The levels of a foveated frame, and which tile this is.
    fovea: Option<(&'a TileFovea<'a>, usize)>,
    /// `(x0, y0, x1, y1)`, half open, inside the image.
    pixels: (u32, u32, u32, u32),
    list: &'a [u32],
    bitmaps: &'a [u8],
}

impl Tile<'_> {
    /// Pixel counts of the tile.
    fn count(&self, counted: &mut Counted) -> TileWork {
        let iterated = &mut counted.iterated;
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
                let stop = if self.whole { NEVER } else { stop };
                if stop != last.0 {
                    last = (stop, self.iterated_until(stop));
                }
                iterated.push(last.1);
                most = most.max(last.1);
                work.alpha_evaluations += u64::from(last.1);
                work.blends += u64::from(blended);
                work.stopped += u32::from(stop != NEVER);
            }
        }
        if self.whole {
            work.blends = self.reached();
        }
        counted.both.clear();
        counted.seconds.clear();
        if let Some((fovea, index)) = self.fovea {
            most = self.count_levels(fovea, index, counted, &mut work);
        }
        work.chunks = most.div_ceil(self.geometry.chunk).max(u32::from(n > 0));
        work.loaded =
            (u64::from(work.chunks) * u64::from(self.geometry.chunk)).min(u64::from(n)) as u32;
        work
    }

    /// The same where pixels have two levels: they iterate until both have stopped. Rank 0 says
    /// that a pixel does not show a level. Returns the most that a pixel iterates.
    fn count_levels(
        &self,
        fovea: &TileFovea<'_>,
        index: usize,
        counted: &mut Counted,
        work: &mut TileWork,
    ) -> u32 {
        let Some(columns) = &self.frame.fovea else { return 0 };
        let blends = fovea.filter.blends[index];
        let (x0, y0, x1, y1) = self.pixels;
        let width = self.frame.facts.camera.width as usize;
        let pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y)));
        let (mut most, mut last) = (0, ([NEVER, NEVER], [0, 0]));
        work.alpha_evaluations = 0;
        for ((x, y), iterated) in pixels.zip(&mut counted.iterated) {
            let i = y as usize * width + x as usize;
            let stops = [self.frame.pixels.stop_rank[i], columns.stop_rank_2[i]];
            if stops != last.0 || most == 0 {
                last = (stops, stops.map(|stop| self.iterated_until(stop)));
            }
            let [first, second] = last.1;
            // A frame without splats names no rank at all.
            let shows = stops.map(|stop| stop > 0);
            *iterated = first.max(second);
            most = most.max(*iterated);
            work.alpha_evaluations += u64::from(*iterated);
            work.blends_2 += u64::from(columns.blended_2[i]);
            work.extra_alpha += u64::from(columns.extra_alpha[i]);
            if blends {
                let both = if shows == [true, true] { first.min(second) } else { 0 };
                counted.both.push(both);
            }
        }
        if blends {
            work.mixed = work.pixels;
            counted.seconds.extend(self.list.iter().map(|&rank| fovea.is_second(index, rank)));
        }
        most
    }

    /// Pixels in which an entry reaches α = 1/255, whatever is in front of it: what blends where
    /// nothing stops.
    fn reached(&self) -> u64 {
        let (x0, y0, x1, y1) = self.pixels;
        let of = |&rank: &u32| {
            let Some(ellipse) = Ellipse::of(&self.frame.splats[rank as usize]) else { return 0 };
            let spans = (y0..y1).filter_map(|y| ellipse.span(y, [x0, x1]));
            spans.map(|[first, end]| u64::from(end - first)).sum::<u64>()
        };
        self.list.iter().map(of).sum()
    }

    /// Entries that a pixel iterates that stops at rank `stop`.
    fn iterated_until(&self, stop: u32) -> u32 {
        match stop {
            NEVER => self.list.len() as u32,
            stop => self.list.partition_point(|&rank| rank <= stop) as u32,
        }
    }
}
