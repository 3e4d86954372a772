//! What the threads of a frame do: warps of the blending kernel, pixel by pixel, and those of the
//! kernels in front of it.
//!
//! A warp of the blending kernel evaluates an entry of its list as long as a pixel of it has not
//! stopped, and blends where the ellipse of the splat reaches a pixel that has not: the others wait
//! for it. With a test for warps (`blend.test`) it evaluates those entries alone that reach such a
//! pixel.

use rayon::prelude::*;

use super::tables::WARP;
use super::{BlendSpec, Gpu};
use crate::kernel::memo::MemoKey;
use crate::workload::{FrameWorkload, STORAGE_BLOCK};
use powergs_frame::splat::pixel::spans;

/// How pixels are dealt to warps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WarpShape {
    /// Width of the pixels of a warp.
    pub width: u32,
    /// Geometry of the workload: machines of one frame may have several.
    pub geometry: crate::workload::Geometry,
}

impl WarpShape {
    /// That of a machine.
    pub fn of(machine: &Gpu) -> WarpShape {
        WarpShape { width: machine.blend.warp_width, geometry: machine.geometry() }
    }
}

impl MemoKey for WarpShape {
    type Value = FrameWarps;
    const MOST: usize = 64;
}

/// A block of the blending kernel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BlockWarps {
    /// Entries that are read until all of its pixels have stopped, in whole batches.
    pub loaded: u32,
    /// (Entry, warp) pairs up to the last pixel of each warp that stops.
    pub evaluated: u64,
    /// Those of them in which a pixel blends.
    pub blended: u64,
    /// Entries that any of its pixels blends.
    pub met: u32,
    /// The most of [`BlockWarps::evaluated`] that one warp has, and what it blends.
    pub longest: [u32; 2],
    /// Whether any of its pixels is rendered: the others leave at once.
    pub renders: bool,
}

/// What the threads of a frame do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameWarps {
    /// Blocks of the blending kernel, tile by tile.
    pub blocks: Vec<BlockWarps>,
    /// Warps of the kernel that converts: all, those with a Gaussian that is not culled, those with
    /// one that has a tile.
    pub converting: [u64; 3],
    /// Gaussians that are not culled, and those with a tile.
    pub gaussians: [u64; 2],
    /// Sum over warps of the most pairs of a thread.
    pub pair_steps: u64,
}

impl FrameWarps {
    /// Counts them.
    ///
    /// # Panics
    /// On a workload without its pixels.
    pub fn new(workload: &FrameWorkload, shape: &WarpShape) -> FrameWarps {
        let tiles = 0..workload.tiles.len();
        let blocks = tiles.into_par_iter().map(|tile| block(workload, tile, shape.width)).collect();
        let points = workload.counters.points;
        // A thread for each record: a block of the storage counters has as many as a warp.
        let warps = points.div_ceil(STORAGE_BLOCK);
        let mut pairs = vec![0_u32; workload.index.len()];
        workload.list.iter().for_each(|&rank| pairs[rank as usize] += 1);
        let mut longest = vec![0_u32; warps as usize];
        for (&index, &n) in workload.index.iter().zip(&pairs) {
            let most = &mut longest[index as usize / WARP as usize];
            *most = n.max(*most);
        }
        let busy = longest.iter().filter(|most| **most > 0).count() as u64;
        let with_pairs = pairs.iter().filter(|n| **n > 0).count() as u64;
        let (mut before, mut alive) = (0, 0);
        for prefix in &workload.storage {
            alive += u64::from(prefix.survivors > before);
            before = prefix.survivors;
        }
        // Scenes that are too large for counts by block: as if what is culled lay apart.
        if workload.storage.is_empty() {
            alive = workload.counters.survivors.div_ceil(STORAGE_BLOCK);
        }
        FrameWarps {
            blocks,
            converting: [warps, alive.max(busy), busy],
            gaussians: [workload.counters.survivors, with_pairs],
            pair_steps: longest.iter().map(|most| u64::from(*most)).sum(),
        }
    }

    /// (Entry, warp) pairs that are evaluated, and those that blend.
    pub fn pairs(&self) -> [u64; 2] {
        let sum = |of: fn(&BlockWarps) -> u64| self.blocks.iter().map(of).sum();
        [sum(|block| block.evaluated), sum(|block| block.blended)]
    }
}

/// One block.
fn block(workload: &FrameWorkload, tile: usize, width: u32) -> BlockWarps {
    let pixels = workload.pixels.as_ref().expect("binned with its pixels");
    let work = &workload.tiles[tile];
    let area = workload.pixels_of(tile);
    let (x0, y0, x1, y1) = area;
    let (wide, high) = (width, WARP / width);
    let across = workload.geometry.tile / wide;
    let warp = |x: u32, y: u32| ((y - y0) / high * across + (x - x0) / wide) as usize;
    let stops = |y: u32, from: u32, to: u32| {
        let row = y as usize * workload.width as usize;
        &pixels.iterated[row + from as usize..row + to as usize]
    };
    let mut evaluated = vec![0_u32; (across * (workload.geometry.tile / high)) as usize];
    for y in y0..y1 {
        for (x, &stop) in (x0..x1).zip(stops(y, x0, x1)) {
            let most = &mut evaluated[warp(x, y)];
            *most = stop.max(*most);
        }
    }
    let last = evaluated.iter().copied().max().unwrap_or(0);
    let mut blended = vec![0_u32; evaluated.len()];
    // The entry that a warp has blended last, one more than its position.
    let mut seen = vec![0_u32; evaluated.len()];
    let mut met = 0;
    for (at, &rank) in (0..last).zip(workload.list_of(work)) {
        let mut is_met = false;
        for (y, span) in spans(&pixels.splats[rank as usize], area) {
            let Some([first, end]) = span else { continue };
            let mut x = first;
            while x < end {
                // The part of the row that is of one warp.
                let to = (x0 + ((x - x0) / wide + 1) * wide).min(end);
                let warp = warp(x, y);
                let is_new = seen[warp] <= at && at < evaluated[warp];
                if is_new && stops(y, x, to).iter().any(|&stop| stop > at) {
                    seen[warp] = at + 1;
                    blended[warp] += 1;
                    is_met = true;
                }
                x = to;
            }
        }
        met += u32::from(is_met);
    }
    let longest = evaluated.iter().zip(&blended).max_by_key(|(e, b)| (**e, **b));
    let sum = |all: &[u32]| all.iter().map(|n| u64::from(*n)).sum();
    BlockWarps {
        loaded: work.loaded,
        evaluated: sum(&evaluated),
        blended: sum(&blended),
        met,
        longest: longest.map_or([0; 2], |(e, b)| [*e, *b]),
        renders: work.pixels > 0,
    }
}

impl BlendSpec {
    /// Warps of a block.
    pub fn block_warps(&self) -> u64 {
        u64::from((self.tile * self.tile).div_ceil(WARP))
    }

    /// Warp instructions of (entry, warp) pairs that are evaluated, of which some blend.
    pub fn instructions(&self, [evaluated, blended]: [u64; 2]) -> u64 {
        let [test, alpha, blend] = [self.test, self.alpha, self.blend].map(u64::from);
        match test {
            0 => evaluated * alpha + blended * blend,
            _ => evaluated * test + blended * (alpha + blend),
        }
    }

    /// Exponentials of the same, warp by warp.
    pub fn exponentials(&self, [evaluated, blended]: [u64; 2]) -> u64 {
        if self.test > 0 { blended } else { evaluated }
    }
}
