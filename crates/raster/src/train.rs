//! The differentiable rasteriser: a picture, and from the gradient of a loss by its pixels the
//! gradient by every raw parameter of the scene.
//!
//! [`Tape::forward`] renders as [`render`](super::render) does, at the reference tiling, and keeps
//! which entries blended in which rows; [`Tape::backward`] visits only those, front to back. The
//! rules are those of the forward pass: same lists, same thresholds (taken as constants), no cut at
//! 3 sigma. Gradients are the same bytes for any number of threads: a row of tiles sums in the
//! order of its lists, and a splat sums its rows from top to bottom. `docs/gradients.md` has the
//! formulas.

mod gradients;
mod row;
mod slopes;
mod unblend;

use fearless_simd::Level;
use rayon::prelude::*;

pub use gradients::Gradients;
pub use slopes::Slopes;

use self::row::Row;
use self::unblend::{ColourOpacity, Everything};
use super::blend::BLOCK;
use super::prepare::Prepared;
use powergs_base::picture::Picture;
use powergs_frame::splat::gradient::{COLOUR, HIDDEN, PixelSums};
use powergs_frame::splat::project::View;
use powergs_frame::splat::{Intersection, Splat, TileGrid};
use powergs_scene::{Camera, Gaussians};

/// How to render and differentiate.
#[derive(Debug, Clone, Copy)]
pub struct Options {
    /// Splat-against-tile test of the 16x16 tiles (OBB in the reference).
    pub test: Intersection,
    /// Background colour, sRGB.
    pub background: [f32; 3],
    /// The gradient where α is clamped to 0.99.
    pub clamp: Clamp,
    /// Instruction set; the best of this processor by default.
    pub level: Level,
}

impl Options {
    /// The reference lists over a black background, with exact derivatives.
    pub fn reference() -> Options {
        Options {
            test: Intersection::Obb,
            background: [0.0; 3],
            clamp: Clamp::Exact,
            level: Level::new(),
        }
    }
}

/// The gradient through α = min(0.99, ·).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clamp {
    /// The derivative: zero where α is clamped.
    Exact,
    /// As if α were not clamped, like INRIA's and PowerGS's backward pass.
    PassThrough,
}

/// The parameters to find gradients of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// All of them.
    All,
    /// The constant SH coefficient of each channel and the opacity; the others get zero.
    ColourAndOpacity,
}

/// One rendered view and what its backward pass needs. Buffers are kept from view to view.
#[derive(Debug, Default)]
pub struct Tape {
    picture: Picture,
    frame: Option<TrainFrame>,
    prepared: Prepared,
    rows: Vec<Row>,
    /// By rank.
    sums: Vec<PixelSums>,
    /// Rank of each Gaussian, or [`HIDDEN`].
    ranks: Vec<u32>,
}

#[derive(Debug)]
struct TrainFrame {
    view: View,
    options: Options,
    /// Gaussians in the scene.
    points: usize,
}

impl Tape {
    /// A tape without a view.
    pub fn new() -> Tape {
        Tape::default()
    }

    /// Renders `scene` from `camera`. The picture is over the background and not clamped.
    pub fn forward(&mut self, scene: &Gaussians, camera: &Camera, options: &Options) -> &Picture {
        let grid = TileGrid::new(camera.width, camera.height, BLOCK as u32);
        self.prepared.prepare(scene, camera, grid, options.test, options.level);
        let Prepared { paints, runs, .. } = &self.prepared;
        (self.picture.width, self.picture.height) = (camera.width, camera.height);
        self.picture.pixels.resize(camera.width as usize * camera.height as usize, [0.0; 3]);
        self.rows.resize_with(grid.ny as usize, Row::default);
        let lines = grid.width as usize * BLOCK;
        self.rows
            .par_iter_mut()
            .zip(self.picture.pixels.par_chunks_mut(lines.max(1)))
            .enumerate()
            .for_each(|(ty, (row, pixels))| {
                row.forward(runs, paints, ty as u32, options, pixels);
            });
        let view = View::new(camera);
        let points = scene.len();
        self.frame = Some(TrainFrame { view, options: *options, points });
        &self.picture
    }

    /// The picture of the last [`Tape::forward`]; empty before the first.
    pub fn picture(&self) -> &Picture {
        &self.picture
    }

    /// The visible splats of the last view in depth order.
    pub fn splats(&self) -> &[Splat] {
        &self.prepared.splats
    }

    /// Bytes of the tape in memory.
    pub fn bytes(&self) -> u64 {
        let rows: usize = self.rows.iter().map(Row::bytes).sum();
        let pixels = size_of_val(&self.picture.pixels[..]);
        let sums = self.sums.capacity() * size_of::<PixelSums>() + 4 * self.ranks.capacity();
        (self.prepared.bytes() + rows + pixels + sums) as u64
    }

    /// Writes to `out` the gradient of a loss by the parameters of `scene`; arguments as in
    /// [`Tape::slopes`]. `scene` must be the one of the last [`Tape::forward`]. Gaussians that are
    /// not seen get zero.
    pub fn backward(
        &mut self,
        scene: &Gaussians,
        by_pixel: &[[f32; 3]],
        which: Which,
        out: &mut Gradients,
    ) {
        out.write(scene, &self.slopes(by_pixel, which));
    }

    /// The slopes of a loss, given `by_pixel`, its gradient by the channels of the picture of the
    /// last [`Tape::forward`], row-major. Gradients are finite if `by_pixel` is and nothing
    /// overflows single precision.
    pub fn slopes(&mut self, by_pixel: &[[f32; 3]], which: Which) -> Slopes<'_> {
        let frame = self.frame.as_ref().expect("forward comes before backward");
        let Prepared { splats, paints, runs, .. } = &self.prepared;
        assert_eq!(by_pixel.len(), self.picture.pixels.len(), "a gradient for every pixel");
        let lines = (self.picture.width as usize * BLOCK).max(1);
        self.rows
            .par_iter_mut()
            .zip(self.picture.pixels.par_chunks(lines))
            .zip(by_pixel.par_chunks(lines))
            .enumerate()
            .for_each(|(ty, ((row, pixels), by_pixel))| {
                let tiles = row::Lines { grid: runs.grid, ty: ty as u32, pixels, by_pixel };
                match which {
                    Which::All => {
                        row.backward(paints, &tiles, &frame.options, Everything);
                    }
                    Which::ColourAndOpacity => {
                        row.backward(paints, &tiles, &frame.options, ColourOpacity);
                    }
                }
            });
        add_rows(&mut self.sums, &self.rows, &self.prepared);
        self.ranks.clear();
        self.ranks.resize(frame.points, HIDDEN);
        for (rank, splat) in splats.iter().enumerate() {
            self.ranks[splat.index as usize] = rank as u32;
        }
        Slopes { frame, which, ranks: &self.ranks, sums: &self.sums, splats }
    }
}

/// The sums of each splat over its rows of tiles, from top to bottom. Where a colour is clamped to
/// zero its gradient is zero.
fn add_rows(sums: &mut Vec<PixelSums>, rows: &[Row], prepared: &Prepared) {
    sums.clear();
    sums.resize(prepared.splats.len(), [0.0; 9]);
    let parts = prepared.runs.parts();
    // Where the runs of each part begin in each row.
    let mut first = vec![0usize; rows.len()];
    let mut starts = Vec::with_capacity(parts.len());
    for part in parts {
        starts.push(first.clone());
        for (first, runs) in first.iter_mut().zip(part) {
            *first += runs.len();
        }
    }
    let part_len = prepared.runs.part_len();
    sums.par_chunks_mut(part_len)
        .zip(prepared.paints.par_chunks(part_len))
        .zip(parts.par_iter().zip(&starts))
        .enumerate()
        .for_each(|(i, ((sums, paints), (part, starts)))| {
            let first_rank = i * part_len;
            // Rows in one order, whichever thread works: rounding is the same in every run.
            for ((row, runs), start) in rows.iter().zip(part).zip(starts) {
                for (run, from) in runs.iter().zip(&row.sums()[*start..]) {
                    let to = &mut sums[run.rank as usize - first_rank];
                    for (to, from) in to.iter_mut().zip(from) {
                        *to += from;
                    }
                }
            }
            for (sums, paint) in sums.iter_mut().zip(paints) {
                for (sum, colour) in sums[COLOUR..].iter_mut().zip(paint.colour) {
                    // A colour that was clamped does not follow its coefficients.
                    if colour <= 0.0 {
                        *sum = 0.0;
                    }
                }
            }
        });
}
