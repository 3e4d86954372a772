//! Convolutions and pools over feature maps.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch, f32x16};
use fearless_simd_macros::simd;
use rayon::prelude::*;

use super::network::{Convolution, Pool};

/// Output channels that are computed together.
pub(crate) const LANES: usize = 16;
/// Places of a row that are computed together.
const PLACES: usize = 6;

/// A feature map: rows of places, the channels of a place side by side.
#[derive(Debug)]
pub struct Map {
    /// Places in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Channels of a place.
    pub channels: usize,
    /// All of them.
    pub values: Vec<f32>,
}

/// The weights of a convolution, in the order in which they are used.
#[derive(Debug, Clone)]
pub(crate) struct Filters {
    /// Per [`LANES`] outputs: kernel rows, kernel columns, inputs.
    weights: Vec<[f32; LANES]>,
    /// Per [`LANES`] outputs.
    bias: Vec<[f32; LANES]>,
}

impl Filters {
    /// From weights by output, input, kernel row and kernel column.
    pub(crate) fn new(shape: &Convolution, weights: &[f32], bias: &[f32]) -> Filters {
        let (inputs, area) = (shape.inputs, shape.side * shape.side);
        let mut packed = Vec::with_capacity(weights.len() / LANES);
        for group in 0..shape.outputs / LANES {
            for at in 0..area {
                for input in 0..inputs {
                    let lane =
                        |l: usize| weights[((group * LANES + l) * inputs + input) * area + at];
                    packed.push(std::array::from_fn(lane));
                }
            }
        }
        Filters { weights: packed, bias: bias.as_chunks().0.to_vec() }
    }
}

impl Map {
    /// The map with `pad` zeros around.
    fn padded(&self, pad: usize) -> Map {
        let (width, height) = (self.width + 2 * pad, self.height + 2 * pad);
        let mut values = vec![0.0; width * height * self.channels];
        let (from, to) = (self.width * self.channels, width * self.channels);
        let rows = values.par_chunks_mut(to).skip(pad).zip(self.values.par_chunks(from));
        rows.for_each(|(to, row)| to[pad * self.channels..][..from].copy_from_slice(row));
        Map { width, height, channels: self.channels, values }
    }
}

impl Convolution {
    /// The convolution of `map` with ReLU. Sums are taken in one order for any number of threads
    /// and any processor.
    ///
    /// # Panics
    /// If the kernel does not fit into the padded map.
    pub(crate) fn of(&self, map: &Map, filters: &Filters) -> Map {
        let side = |n| self.output_side(n).expect("the size was checked");
        let (width, height) = (side(map.width), side(map.height));
        let input = map.padded(self.pad);
        let row = width * self.outputs;
        let mut values = vec![0.0; row * height];
        let level = Level::new();
        values.par_chunks_mut(row).enumerate().for_each(|(y, out)| {
            let top = y * self.stride * input.width * input.channels;
            let rows = &input.values[top..];
            dispatch!(level, simd => convolve_row(simd, self, filters, rows, input.width, out));
        });
        Map { width, height, channels: self.outputs, values }
    }
}

/// One row of the output; `rows` begins with the first row of the input that it needs.
#[simd]
fn convolve_row<S: Simd>(
    simd: S,
    shape: &Convolution,
    filters: &Filters,
    rows: &[f32],
    width: usize,
    out: &mut [f32],
) {
    let run = shape.side * shape.inputs;
    let places = out.len() / shape.outputs;
    let groups = filters.weights.chunks_exact(shape.side * run).zip(&filters.bias);
    for (group, (weights, bias)) in groups.enumerate() {
        for first in (0..places).step_by(PLACES) {
            let mut sums = [f32x16::simd_from(simd, *bias); PLACES];
            for (ky, weights) in weights.chunks_exact(run).enumerate() {
                let row = &rows[ky * width * shape.inputs..];
                // Beyond the end of the row the last place is computed again, and left out.
                let inputs: [&[f32]; PLACES] = std::array::from_fn(|p| {
                    let x = (first + p).min(places - 1) * shape.stride;
                    &row[x * shape.inputs..][..run]
                });
                for (j, lanes) in weights.iter().enumerate() {
                    let lanes = f32x16::simd_from(simd, *lanes);
                    for p in 0..PLACES {
                        sums[p] += f32x16::splat(simd, inputs[p][j]) * lanes;
                    }
                }
            }
            for (p, sum) in sums.into_iter().enumerate().take(places - first) {
                let at = (first + p) * shape.outputs + group * LANES;
                let sum: [f32; LANES] = sum.into();
                // Not `max`, which would turn NaN into a number.
                let rectified = sum.map(|v| if v < 0.0 { 0.0 } else { v });
                out[at..at + LANES].copy_from_slice(&rectified);
            }
        }
    }
}

impl Pool {
    /// The largest value of each square, per channel; incomplete squares at the end are left out.
    ///
    /// # Panics
    /// If the map is smaller than a square.
    pub(crate) fn of(&self, map: &Map) -> Map {
        let side = |n| self.output_side(n).expect("the size was checked");
        let (width, height, channels) = (side(map.width), side(map.height), map.channels);
        let row = width * channels;
        let mut values = vec![f32::NEG_INFINITY; row * height];
        values.par_chunks_mut(row).enumerate().for_each(|(y, out)| {
            for (x, out) in out.chunks_exact_mut(channels).enumerate() {
                for i in 0..self.side * self.side {
                    let (dx, dy) = (i % self.side, i / self.side);
                    let place = (y * self.stride + dy) * map.width + x * self.stride + dx;
                    let square = &map.values[place * channels..][..channels];
                    for (most, v) in out.iter_mut().zip(square) {
                        if v.is_nan() || *v > *most {
                            *most = *v;
                        }
                    }
                }
            }
        });
        Map { width, height, channels, values }
    }
}
