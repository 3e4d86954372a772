//! Colours by the first Gaussians that a pixel blends: a cache for each region of the image.

use rayon::prelude::*;

use super::PixelsSpec;
use super::{mixed, own_list};
use crate::workload::blend::TileBlend;
use crate::workload::{FrameWorkload, TileList};

/// The caches of all regions, as they lie in memory.
#[derive(Debug, Clone)]
pub(super) struct RadianceCaches {
    /// Pixels of the image, and of a side of a region.
    size: [u32; 3],
    sets: u64,
    ways: usize,
    /// Of each region: its sets one after the other, in each the entries that were used last first.
    regions: Vec<Vec<Vec<RadianceEntry>>>,
    /// Frames that were seen.
    frame: u32,
}

/// A colour that is known.
#[derive(Debug, Clone, Copy)]
struct RadianceEntry {
    /// Made of the first Gaussians.
    key: u64,
    /// Frame and pixel that it is of.
    from: [u32; 2],
}

/// A region of a frame.
pub(super) struct RegionFrame {
    pub lookups: u64,
    pub hits: u64,
    pub tiles: Vec<KnownTile>,
}

/// A tile of a region.
pub(super) struct KnownTile {
    pub tile: usize,
    /// What it goes through.
    pub list: TileList,
    /// The frame and pixel that each of its pixels is known from.
    pub known: Vec<Option<[u32; 2]>>,
}

impl RadianceCaches {
    /// Empty ones.
    pub fn new(workload: &FrameWorkload, spec: &PixelsSpec) -> RadianceCaches {
        let (ways, side) = (spec.ways.max(1), spec.region.max(1));
        let sets = (spec.buffer.capacity.0 / spec.entry.0.max(1) / u64::from(ways)).max(1);
        let regions = workload.width.div_ceil(side) * workload.height.div_ceil(side);
        let regions = vec![vec![Vec::new(); sets as usize]; regions as usize];
        let size = [workload.width, workload.height, side];
        RadianceCaches { size, sets, ways: ways as usize, regions, frame: 0 }
    }

    /// Whether they are of frames like this one.
    pub fn fits(&self, workload: &FrameWorkload, spec: &PixelsSpec) -> bool {
        self.size == [workload.width, workload.height, spec.region]
    }

    /// Entries that each region has.
    pub fn entries(&self) -> Vec<u64> {
        let of = |region: &Vec<Vec<RadianceEntry>>| region.iter().map(|set| set.len() as u64).sum();
        self.regions.iter().map(of).collect()
    }

    /// Takes a frame through them.
    pub fn frame(&mut self, workload: &FrameWorkload, spec: &PixelsSpec) -> Vec<RegionFrame> {
        let [width, _, side] = self.size;
        let across = width.div_ceil(side);
        let (sets, ways, frame) = (self.sets, self.ways, self.frame);
        self.frame += 1;
        let tile = workload.geometry.tile;
        let of = |(number, region): (usize, &mut Vec<Vec<RadianceEntry>>)| {
            let [x, y] = [number as u32 % across, number as u32 / across].map(|n| n * side / tile);
            let per_side = side / tile;
            let rows = y..(y + per_side).min(workload.tiles_y);
            let columns = x..(x + per_side).min(workload.tiles_x);
            let mut found = RegionFrame { lookups: 0, hits: 0, tiles: Vec::new() };
            for tile in rows.flat_map(|y| columns.clone().map(move |x| (y, x))) {
                let tile = (tile.0 * workload.tiles_x + tile.1) as usize;
                let (list, known) = looked_up(workload, tile, spec.ids, |key, pixel| {
                    found.lookups += 1;
                    let set = &mut region[(key % sets) as usize];
                    let known = set.iter().position(|known| known.key == key);
                    let known = known.map(|at| set.remove(at));
                    found.hits += u64::from(known.is_some());
                    // A hit has left its place already, so that only a miss drops the entry that
                    // was used longest ago.
                    set.truncate(ways - 1);
                    set.insert(0, known.unwrap_or(RadianceEntry { key, from: [frame, pixel] }));
                    known.map(|known| known.from)
                });
                found.tiles.push(KnownTile { tile, list, known });
            }
            found
        };
        self.regions.par_iter_mut().enumerate().map(of).collect()
    }
}

/// A tile whose pixels stop where `known` says that their colour is: the frame and pixel that it is
/// from.
fn looked_up(
    workload: &FrameWorkload,
    tile: usize,
    ids: u32,
    mut known: impl FnMut(u64, u32) -> Option<[u32; 2]>,
) -> (TileList, Vec<Option<[u32; 2]>>) {
    let mut list = own_list(workload, tile);
    let mut pixels = TileBlend::new(workload, tile, list.ranks.len() as u32);
    // The key of the first Gaussians, how many there are, where the last of them is, and all.
    let mut seen = vec![(0u64, 0u32, 0u32, 0u32); pixels.iterated.len()];
    for (at, &rank) in (0..).zip(&list.ranks) {
        let id = u64::from(workload.index[rank as usize]);
        pixels.blend_and(at, rank, |pixel, _| {
            let (key, first, last, all) = &mut seen[pixel];
            *all += 1;
            if *first < ids {
                // Mixed step by step: the same Gaussians in another order are another key.
                (*key, *first, *last) = (mixed(*key ^ id), *first + 1, at);
            }
        });
    }
    let (x0, y0, x1, _) = workload.pixels_of(tile);
    let mut from = vec![None; seen.len()];
    for (i, (key, first, last, all)) in (0u32..).zip(seen) {
        let pixel = (y0 + i / (x1 - x0)) * workload.width + x0 + i % (x1 - x0);
        // Who has blended fewer has nothing to look up.
        let hit = if first == ids { known(key, pixel) } else { None };
        list.blends += u64::from(if hit.is_some() { first } else { all });
        if hit.is_some() {
            pixels.iterated[i as usize] = last + 1;
        }
        from[i as usize] = hit;
    }
    list.iterated = pixels.iterated;
    (list, from)
}
