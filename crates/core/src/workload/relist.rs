//! Frames whose tiles go through other lists than their own.

use rayon::prelude::*;

use super::{
    ChunkScratch, ChunkWork, FrameWorkload, STORAGE_BLOCK, StoragePrefix, TilePixels, TileWork,
    push_chunks,
};
use powergs_frame::splat::Counters;

/// What a tile goes through in place of its own list.
#[derive(Debug, Clone, Default)]
pub struct TileList {
    /// Depth ranks, in the order in which they come.
    pub ranks: Vec<u32>,
    /// Sub-tile bitmap of each entry, as in [`FrameWorkload::bitmaps`].
    pub bitmaps: Vec<u8>,
    /// List position from which on each pixel inside the image needs nothing, row by row.
    pub iterated: Vec<u32>,
    /// Entries that its pixels blend.
    pub blends: u64,
    /// Pixels that an entry of these stops.
    pub stopped: u32,
    /// Pixels of it that are finished; `None` for all inside of the image.
    pub finished: Option<u32>,
}

/// What a list comes to.
struct Relisted {
    work: TileWork,
    chunks: Vec<ChunkWork>,
    stops: Vec<[u32; 4]>,
}

impl FrameWorkload {
    /// The frame with other lists, one for each tile, row-major. What was done to make its own ones
    /// is left out: `counters` and `storage` are zero and empty.
    ///
    /// # Panics
    /// When it was not binned for [`FrameDetail::pixels`](super::FrameDetail), or has another
    /// number of tiles.
    pub fn with_lists(&self, lists: Vec<TileList>) -> FrameWorkload {
        assert_eq!(lists.len(), self.tiles.len(), "a list for each tile");
        let geometry = self.geometry;
        let parts: Vec<Relisted> =
            (0..lists.len()).into_par_iter().map(|tile| self.part(tile, &lists[tile])).collect();
        let mut made = FrameWorkload {
            width: self.width,
            height: self.height,
            tiles_x: self.tiles_x,
            tiles_y: self.tiles_y,
            camera: self.camera.clone(),
            sh_degree: self.sh_degree,
            detail: self.detail,
            pixels: self.pixels.clone(),
            index: self.index.clone(),
            depth: self.depth.clone(),
            slot: self.slot.clone(),
            ..FrameWorkload::empty(geometry)
        };
        // The tile that loads each splat first.
        let mut first_seen = vec![false; self.index.len()];
        for (tile, (mut part, list)) in parts.into_iter().zip(lists).enumerate() {
            let loaded = list.ranks[..part.work.loaded as usize].chunks(geometry.chunk as usize);
            for (chunk, entries) in part.chunks.iter_mut().zip(loaded) {
                let is_first =
                    |&&rank: &&u32| !std::mem::replace(&mut first_seen[rank as usize], true);
                chunk.first_loads = entries.iter().filter(is_first).count() as u32;
            }
            part.work.list_start = made.list.len() as u32;
            part.work.chunk_start = made.chunks.len() as u32;
            made.tiles.push(part.work);
            made.list.extend(list.ranks);
            made.bitmaps.extend(list.bitmaps);
            made.chunks.extend(part.chunks);
            made.stops.extend(part.stops);
            let (x0, y0, x1, _) = made.pixels_of(tile);
            let pixels = made.pixels.as_mut().expect("binned for pixels");
            let width = (x1 - x0) as usize;
            for (y, row) in (y0..).zip(list.iterated.chunks_exact(width.max(1))) {
                let start = y as usize * self.width as usize + x0 as usize;
                pixels.iterated[start..start + width].copy_from_slice(row);
            }
        }
        made.counters.fetched_points = first_seen.iter().filter(|seen| **seen).count() as u64;
        made
    }

    /// The frame with a part of its own lists: whole lists of some tiles, none of the others. What
    /// is converted, tested and written is that which they need.
    ///
    /// # Panics
    /// As [`FrameWorkload::with_lists`].
    pub fn with_some_lists(&self, lists: Vec<TileList>) -> FrameWorkload {
        let mut made = self.with_lists(lists);
        let mut pairs = vec![0u32; self.index.len()];
        made.list.iter().for_each(|&rank| pairs[rank as usize] += 1);
        let fetched_points = made.counters.fetched_points;
        let splats = pairs.iter().filter(|&&pairs| pairs > 0).count() as u64;
        let (all, whole) = (&self.counters, made.list.len() as u64);
        let part = |n: u64, of: u64, all: u64| {
            (u128::from(n) * u128::from(of) / u128::from(all.max(1))) as u64
        };
        made.counters = Counters {
            tile_pairs: whole,
            intersecting_points: splats,
            fetched_points,
            obb_tests: part(all.obb_tests, whole, all.tile_pairs),
            obb_prepared: part(all.obb_prepared, splats, all.intersecting_points),
            tile_loads: made.tiles.iter().map(|tile| u64::from(tile.loaded)).sum(),
            alpha_evaluations: made.tiles.iter().map(|tile| tile.alpha_evaluations).sum(),
            blends: made.tiles.iter().map(|tile| tile.blends).sum(),
            ..*all
        };
        made.place(&pairs, &self.storage, (splats, all.intersecting_points));
        made
    }

    /// Says where splats lie of which so many pairs are written, by rank. Box tests are as the
    /// pairs, `before` has them for the whole frame.
    fn place(&mut self, pairs: &[u32], before: &[StoragePrefix], (splats, all): (u64, u64)) {
        let mut ranks: Vec<u32> = (0..pairs.len() as u32).collect();
        ranks.retain(|&rank| pairs[rank as usize] > 0);
        ranks.par_sort_unstable_by_key(|&rank| self.index[rank as usize]);
        self.slot = vec![u32::MAX; pairs.len()];
        let mut own = vec![[0u32; 2]; before.len()];
        for (slot, &rank) in (0..).zip(&ranks) {
            self.slot[rank as usize] = slot;
            let block = self.index[rank as usize] as usize / STORAGE_BLOCK as usize;
            if let Some([splats, written]) = own.get_mut(block) {
                *splats += 1;
                *written += pairs[rank as usize];
            }
        }
        let needed = |rank: &u32| self.slot[*rank as usize].wrapping_add(1);
        for tile in &mut self.tiles {
            let list = &self.list[tile.list_start as usize..][..tile.entries as usize];
            tile.complete_after = list.iter().map(needed).max().unwrap_or(0);
        }
        let (written, whole) = (u128::from(self.counters.tile_pairs), before.last());
        let whole = whole.map_or(1, |whole| u128::from(whole.pairs.max(1)));
        let mut sum = StoragePrefix::default();
        self.storage = before.to_vec();
        for (prefix, [own, pairs]) in self.storage.iter_mut().zip(own) {
            sum.splats += own;
            sum.pairs += pairs;
            prefix.prepared =
                (u64::from(prefix.prepared) * splats / all.max(1)).min(u32::MAX.into()) as u32;
            prefix.tests = (u128::from(prefix.tests) * written / whole) as u32;
            (prefix.splats, prefix.pairs) = (sum.splats, sum.pairs);
        }
    }

    fn part(&self, tile: usize, list: &TileList) -> Relisted {
        let (g, own) = (self.geometry, &self.tiles[tile]);
        let (x0, _, x1, _) = self.pixels_of(tile);
        let n = list.ranks.len() as u32;
        let needed = |&rank: &u32| self.slot[rank as usize].wrapping_add(1);
        let chunks = list.iterated.iter().max().map_or(0, |most| most.div_ceil(g.chunk));
        let chunks = chunks.max(u32::from(n > 0));
        let work = TileWork {
            pixels: list.finished.unwrap_or(own.pixels),
            complete_after: list
                .ranks
                .iter()
                .map(needed)
                .max()
                .unwrap_or(0)
                .max(own.complete_after),
            entries: n,
            alpha_evaluations: list.iterated.iter().map(|&i| u64::from(i)).sum(),
            blends: list.blends,
            stopped: list.stopped,
            chunks,
            loaded: (u64::from(chunks) * u64::from(g.chunk)).min(u64::from(n)) as u32,
            ..TileWork::default()
        };
        let mut part = Relisted { work, chunks: Vec::new(), stops: Vec::new() };
        let pixels =
            TilePixels { width: x1 - x0, iterated: &list.iterated, both: &[], seconds: &[] };
        let mut scratch = ChunkScratch::default();
        let (chunks, stops) = (&mut part.chunks, &mut part.stops);
        push_chunks(g, &part.work, pixels, &list.bitmaps, &mut scratch, chunks, stops);
        part
    }
}
