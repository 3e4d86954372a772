//! What each chunk of a tile has to do, sub-tile by sub-tile.
//!
//! A pixel that iterates n entries is live at list positions below n. A quad (the 2x2 pixels of a
//! rendering unit), a sub-tile and a tile are live as long as one of their pixels is.

use super::{ChunkWork, Geometry, PairWork, TileWork};

/// Pixels of a quad.
const QUAD: usize = 4;

/// The pixels of one tile inside the image, row by row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TilePixels<'a> {
    /// Pixels per row.
    pub width: u32,
    /// Entries that each pixel iterates.
    pub iterated: &'a [u32],
    /// Those that it iterates while both of its levels are open; empty where a tile has one level.
    pub both: &'a [u32],
    /// Whether the second level has the entry, by position in the list; empty as `both`.
    pub seconds: &'a [bool],
}

/// Memory that is used again for each tile.
#[derive(Debug, Default)]
pub struct ChunkScratch {
    subtile: Subtile,
    /// Entries with a set bit before each position, of one sub-tile.
    before: Vec<u32>,
}

/// Until where the parts of one sub-tile are live.
#[derive(Debug, Default)]
struct Subtile {
    /// Entries that each pixel iterates, ascending.
    pixels: Vec<u32>,
    /// Entries of the last pixel of each quad, and the pixels of the quad; ascending.
    quads: Vec<(u32, u32)>,
    /// The k-th is how long any quad has more than k live pixels.
    slots: [u32; QUAD],
}

/// Appends the fetched chunks of a tile, without their first loads, and where its sub-tiles stop.
pub(crate) fn push_chunks(
    geometry: Geometry,
    tile: &TileWork,
    pixels: TilePixels,
    bitmaps: &[u8],
    scratch: &mut ChunkScratch,
    out: &mut Vec<ChunkWork>,
    stops: &mut Vec<[u32; QUAD]>,
) {
    let (start, chunk) = (out.len(), geometry.chunk);
    for first in (0..tile.chunks).map(|c| c * chunk) {
        let entries = chunk.min(tile.loaded - first);
        out.push(ChunkWork { entries, group_end: first + entries, ..ChunkWork::default() });
    }
    if !pixels.seconds.is_empty() {
        let mut entries = pixels.seconds.iter();
        for work in &mut out[start..] {
            let own = entries.by_ref().take(work.entries as usize);
            work.seconds = own.filter(|second| **second).count() as u32;
        }
    }
    let end = pixels.iterated.iter().copied().max().unwrap_or(0);
    let bytes = geometry.bitmap_bytes();
    let side = geometry.subtiles_per_side();
    for index in 0..geometry.subtiles() {
        let corner = (index % side * geometry.subtile, index / side * geometry.subtile);
        if !scratch.subtile.fill(pixels, corner, geometry.subtile) {
            stops.push([0; QUAD]);
            continue;
        }
        stops.push(scratch.subtile.slots);
        count_bits(bitmaps, bytes, index as usize, end, &mut scratch.before);
        if !pixels.both.is_empty() {
            let both = last_of_both(pixels, corner, geometry.subtile);
            count_both(bitmaps, bytes, index as usize, both, pixels.seconds, &mut out[start..]);
        }
        let mut first = 0;
        for work in &mut out[start..] {
            let stop = (first + work.entries).min(end);
            if stop <= first {
                break;
            }
            scratch.subtile.add(first, stop, &scratch.before, work);
            first += work.entries;
        }
    }
}

/// The list position up to which any pixel of a sub-tile blends both levels.
fn last_of_both(tile: TilePixels, (x0, y0): (u32, u32), side: u32) -> u32 {
    let height = tile.both.len() as u32 / tile.width.max(1);
    let (x1, y1) = ((x0 + side).min(tile.width), (y0 + side).min(height));
    let rows = (y0..y1).map(|y| &tile.both[(y * tile.width + x0) as usize..][..(x1 - x0) as usize]);
    rows.flatten().copied().max().unwrap_or(0)
}

/// Counts the entries of both levels before position `end`, with the bit of `subtile` and without
/// asking for it.
fn count_both(
    bitmaps: &[u8],
    bytes: usize,
    subtile: usize,
    end: u32,
    seconds: &[bool],
    chunks: &mut [ChunkWork],
) {
    let mut entries = bitmaps.chunks_exact(bytes).zip(seconds).take(end as usize);
    for work in chunks {
        for (bitmap, _) in entries.by_ref().take(work.entries as usize).filter(|e| *e.1) {
            work.unskipped.both_pairs += 1;
            work.skipping.both_pairs += u32::from(bitmap[subtile / 8] >> (subtile % 8) & 1);
        }
    }
}

impl Subtile {
    /// Collects the pixels of the sub-tile at the corner (x0, y0) of the tile; returns whether it
    /// has any.
    fn fill(&mut self, tile: TilePixels, (x0, y0): (u32, u32), side: u32) -> bool {
        let height = tile.iterated.len() as u32 / tile.width.max(1);
        let (x1, y1) = ((x0 + side).min(tile.width), (y0 + side).min(height));
        if x0 >= x1 || y0 >= y1 {
            return false;
        }
        self.pixels.clear();
        self.quads.clear();
        self.slots = [0; QUAD];
        for y in (y0..y1).step_by(2) {
            for x in (x0..x1).step_by(2) {
                let (mut quad, mut n) = ([0; QUAD], 0);
                for y in y..(y + 2).min(y1) {
                    let row = (y * tile.width) as usize;
                    for &iterated in
                        &tile.iterated[row + x as usize..row + (x + 2).min(x1) as usize]
                    {
                        quad[n] = iterated;
                        n += 1;
                    }
                }
                self.pixels.extend(&quad[..n]);
                quad.sort_unstable_by(|a, b| b.cmp(a));
                self.quads.push((quad[0], n as u32));
                for (most, own) in self.slots.iter_mut().zip(quad) {
                    *most = own.max(*most);
                }
            }
        }
        self.pixels.sort_unstable();
        self.quads.sort_unstable();
        true
    }

    /// Adds the list positions `first..tile_stop` of a chunk to its work. Positions are before the
    /// end of the tile.
    fn add(&self, first: u32, tile_stop: u32, before: &[u32], work: &mut ChunkWork) {
        let (skipping, unskipped) = (&mut work.skipping, &mut work.unskipped);
        let set = |p: u32| before[p as usize] - before[first as usize];
        skipping.tile_pairs += set(tile_stop);
        unskipped.tile_pairs += tile_stop - first;
        let stop = tile_stop.min(self.slots[0]);
        if stop <= first {
            return;
        }
        skipping.subtile_pairs += set(stop);
        unskipped.subtile_pairs += stop - first;
        let mut each = |end: u32, pixels: u32, into: fn(&mut PairWork) -> &mut u32| {
            let p = end.min(stop);
            *into(skipping) += pixels * set(p);
            *into(unskipped) += pixels * (p - first);
        };
        for &p in &self.pixels[self.pixels.partition_point(|&p| p <= first)..] {
            each(p, 1, |w| &mut w.live_evaluations);
        }
        for &(p, n) in &self.quads[self.quads.partition_point(|q| q.0 <= first)..] {
            each(p, n, |w| &mut w.quad_evaluations);
        }
        for &p in self.slots.iter().filter(|&&p| p > first) {
            each(p, 1, |w| &mut w.pixel_slots);
        }
    }
}

/// `before[p]`: entries with the bit of `subtile` set among the first p, for p up to `end`.
fn count_bits(bitmaps: &[u8], bytes: usize, subtile: usize, end: u32, before: &mut Vec<u32>) {
    before.clear();
    before.push(0);
    let mut n = 0;
    for bitmap in bitmaps.chunks_exact(bytes).take(end as usize) {
        n += u32::from(bitmap[subtile / 8] >> (subtile % 8) & 1);
        before.push(n);
    }
}
