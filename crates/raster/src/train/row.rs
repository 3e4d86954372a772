//! One row of tiles on the tape: what blended where, and the sums of the backward pass.

use fearless_simd::dispatch;

use super::unblend::{UnblendBlock, UnblendKind, UnblendList, unblend};
use super::{Clamp, Options};
use crate::blend::{BATCH, BLOCK, BlendBlock, Hit, Paint, Palette, Taped, blend, write_block};
use crate::row::{KeepEverything, find_starts};
use powergs_frame::splat::gradient::PixelSums;
use powergs_frame::splat::runs::Runs;
use powergs_frame::splat::{TileGrid, touch};

/// The records of one row of tiles.
#[derive(Debug, Default)]
pub struct Row {
    /// By run: the rank of its splat.
    ranks: Vec<u32>,
    /// The splats of each tile by their runs, front to back, one tile after the other.
    runs: Vec<u32>,
    /// Where the lists of the tiles begin, and the end.
    lists: Vec<usize>,
    hits: Vec<Hit>,
    /// The first hit of each tile, and the end.
    starts: Vec<usize>,
    /// By run.
    sums: Vec<PixelSums>,
}

/// The pixels of a row of tiles.
pub struct Lines<'a> {
    /// The grid.
    pub grid: TileGrid,
    /// Row of tiles.
    pub ty: u32,
    /// The picture.
    pub pixels: &'a [[f32; 3]],
    /// The gradient by its channels.
    pub by_pixel: &'a [[f32; 3]],
}

/// Paints of splats that are told by their runs in a row of tiles.
#[derive(Debug, Clone, Copy)]
struct ByRun<'a> {
    /// By run.
    ranks: &'a [u32],
    /// By rank.
    paints: &'a [Paint],
}

impl Palette for ByRun<'_> {
    #[inline(always)]
    fn fetch(&self, runs: &[u32], near: &mut [Paint; BATCH]) {
        for (paint, &run) in near.iter_mut().zip(runs) {
            *paint = self.paints[self.ranks[run as usize] as usize];
        }
    }
}

impl Row {
    /// Renders row `ty` into `pixels`.
    pub(crate) fn forward(
        &mut self,
        runs: &Runs,
        paints: &[Paint],
        ty: u32,
        options: &Options,
        pixels: &mut [[f32; 3]],
    ) {
        self.list(runs, ty);
        let grid = runs.grid;
        let palette = ByRun { ranks: &self.ranks, paints };
        let mut block = BlendBlock::new();
        // Lent to the block, which appends: one list has the hits of all tiles of the row.
        block.hits = std::mem::take(&mut self.hits);
        block.hits.clear();
        self.starts.clear();
        for tx in 0..grid.nx {
            self.starts.push(block.hits.len());
            let list = &self.runs[self.lists[tx as usize]..self.lists[tx as usize + 1]];
            let (x0, y0, x1, y1) = grid.pixels(tx, ty);
            let (w, h) = ((x1 - x0) as usize, (y1 - y0) as usize);
            block.reset::<Taped>(x0, y0, w, h);
            dispatch!(options.level, simd => blend(simd, Taped, &mut block, list, palette));
            let pixels = &mut pixels[x0 as usize..];
            let width = grid.width as usize;
            dispatch!(options.level, simd =>
                write_block(simd, &block, options.background, (w, h), pixels, width));
        }
        self.starts.push(block.hits.len());
        self.hits = std::mem::take(&mut block.hits);
    }

    /// Lists the splats of each tile in depth order, by their runs: what a list says of a splat is
    /// then one number.
    fn list(&mut self, runs: &Runs, ty: u32) {
        let total = find_starts(runs, ty, &KeepEverything, &mut self.lists);
        let mut next = self.lists.clone();
        self.runs.resize(total, 0);
        self.ranks.clear();
        for (i, run) in runs.row(ty).enumerate() {
            self.ranks.push(run.rank);
            for next in &mut next[run.x0 as usize..run.x1 as usize] {
                self.runs[*next] = i as u32;
                *next += 1;
            }
        }
        self.sums.clear();
        self.sums.resize(self.ranks.len(), [0.0; 9]);
    }

    /// Finds the sums of all runs of the row.
    pub(crate) fn backward<K: UnblendKind>(
        &mut self,
        paints: &[Paint],
        lines: &Lines<'_>,
        options: &Options,
        kind: K,
    ) {
        self.sums.fill([0.0; 9]);
        let mut block = UnblendBlock::new(match options.clamp {
            Clamp::Exact => powergs_frame::splat::ALPHA_MAX,
            Clamp::PassThrough => f32::INFINITY,
        });
        for tx in 0..lines.grid.nx {
            let hits = &self.hits[self.starts[tx as usize]..self.starts[tx as usize + 1]];
            if hits.is_empty() {
                continue;
            }
            let (x0, y0, x1, y1) = lines.grid.pixels(tx, lines.ty);
            block.reset(x0, y0);
            let (width, height) = ((x1 - x0) as usize, (y1 - y0) as usize);
            let line = |y: usize| {
                let start = y * lines.grid.width as usize + x0 as usize;
                start..start + width
            };
            // Lines of the picture are far apart.
            touch((0..height).map(|y| lines.pixels[line(y)].as_flattened()));
            touch((0..height).map(|y| lines.by_pixel[line(y)].as_flattened()));
            for y in 0..height {
                block.load_row(y, &lines.pixels[line(y)], &lines.by_pixel[line(y)]);
            }
            let list = self.lists[tx as usize]..self.lists[tx as usize + 1];
            let list = UnblendList { ranks: &self.ranks, runs: &self.runs[list], hits };
            let sums = &mut self.sums;
            dispatch!(options.level, simd => unblend(simd, kind, &mut block, list, paints, sums));
        }
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        (self.ranks.capacity() + self.runs.capacity()) * size_of::<u32>()
            + self.lists.capacity() * size_of::<usize>()
            + self.hits.capacity() * size_of::<Hit>()
            + self.starts.capacity() * size_of::<usize>()
            + self.sums.capacity() * size_of::<PixelSums>()
    }

    /// The sums of each run of the row.
    pub(crate) fn sums(&self) -> &[PixelSums] {
        &self.sums
    }
}

const _: () = assert!(BLOCK == 16, "a block is a tile of the reference tiling");
