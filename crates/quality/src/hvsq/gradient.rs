//! The backward pass: from derivatives by the maps to derivatives by the picture.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::bands::{bands_adjoint_row, split_adjoint_row};
use super::plane::Plane;
use super::pyramid::{Pyramid, halved, opponent_adjoint};
use super::{BANDS, LEVELS};

/// Derivatives by the decomposition of one channel.
#[derive(Debug)]
struct GradientChannel {
    image: Plane,
    high: Plane,
    low: [Plane; LEVELS + 1],
    bands: [[Plane; BANDS]; LEVELS],
}

/// Derivatives by all maps.
#[derive(Debug)]
pub struct HvsqGradients {
    channels: [GradientChannel; 3],
    /// Per level: derivatives by a plane with its reflected margin.
    padded: [Plane; LEVELS],
}

impl HvsqGradients {
    /// Zeros, for the maps of `pyramid`.
    pub(crate) fn new(pyramid: &Pyramid) -> HvsqGradients {
        let full = pyramid.full;
        let channel = |_| GradientChannel {
            image: Plane::new(full, 0),
            high: Plane::new(full, 4),
            low: std::array::from_fn(|k| Plane::new(halved(full, k), 4)),
            bands: std::array::from_fn(|k| std::array::from_fn(|_| Plane::new(halved(full, k), 4))),
        };
        HvsqGradients {
            channels: std::array::from_fn(channel),
            padded: std::array::from_fn(|k| Plane::new(halved(full, k), 2)),
        }
    }

    /// Derivatives by the maps, in the order of the pyramid.
    pub(crate) fn maps_mut(&mut self) -> impl Iterator<Item = &mut Plane> {
        self.channels
            .iter_mut()
            .flat_map(|c| std::iter::once(&mut c.high).chain(c.bands.iter_mut().flatten()))
    }

    /// The derivative by the lowest frequencies of a channel.
    pub(crate) fn lowest_mut(&mut self, channel: usize) -> &mut Plane {
        &mut self.channels[channel].low[LEVELS]
    }

    /// The derivative by the picture.
    pub(crate) fn collect(&mut self, pyramid: &Pyramid, gradient: &mut [[f32; 3]]) {
        let level = Level::new();
        for channel in &mut self.channels {
            for k in (0..LEVELS).rev() {
                let (low, half) = channel.low.split_at_mut(k + 1);
                let (bands, padded) = (&channel.bands[k], &mut self.padded[k]);
                whole_rows(padded, |y, out| {
                    dispatch!(level, simd => bands_adjoint_row(simd, bands, y, out));
                });
                fold(padded, &mut low[k]);
                low[k].add_doubled(&half[0]);
            }
            let (high, low) = (&channel.high, &channel.low[0]);
            let padded = &mut self.padded[0];
            whole_rows(padded, |y, out| {
                dispatch!(level, simd => split_adjoint_row(simd, high, low, y, out));
            });
            fold(padded, &mut channel.image);
        }
        self.colours(pyramid, gradient);
    }

    /// The adjoint of the resize and of the opponent colours.
    fn colours(&self, pyramid: &Pyramid, gradient: &mut [[f32; 3]]) {
        let [a, b, c] = &self.channels;
        let [columns, rows] = &pyramid.resize;
        let full = pyramid.full;
        let same = pyramid.size == full;
        gradient.par_chunks_mut(pyramid.size[0]).enumerate().for_each_init(
            || [vec![0.0; full[0]], vec![0.0; full[0]], vec![0.0; full[0]]],
            |sums, (y, out)| {
                // Full rows between the row above and the row below this one.
                let from = rows.start[y.saturating_sub(1)] as usize;
                let to = if same { y + 1 } else { rows.start[y + 1] as usize };
                let from = if same { y } else { from };
                sums.iter_mut().for_each(|s| s.fill(0.0));
                for full_row in from..to {
                    let weight = rows.weight[full_row];
                    let share =
                        if rows.first[full_row] as usize == y { 1.0 - weight } else { weight };
                    for (sum, plane) in sums.iter_mut().zip([&a.image, &b.image, &c.image]) {
                        for (s, v) in sum.iter_mut().zip(plane.row(full_row)) {
                            *s += share * v;
                        }
                    }
                }
                out.fill([0.0; 3]);
                let last = out.len() - 1;
                let [first_sum, second_sum, third_sum] = &*sums;
                let pixels = first_sum.iter().zip(second_sum).zip(third_sum).take(full[0]);
                for (x, ((&l, &s), &y)) in pixels.enumerate() {
                    let rgb = opponent_adjoint([l, s, y]);
                    let (first, weight) = (columns.first[x] as usize, columns.weight[x]);
                    for c in 0..3 {
                        out[first][c] += (1.0 - weight) * rgb[c];
                        out[(first + 1).min(last)][c] += weight * rgb[c];
                    }
                }
            },
        );
    }
}

/// Runs `row` on all rows of a plane, margins included.
fn whole_rows(plane: &mut Plane, row: impl Fn(usize, &mut [f32]) + Sync) {
    let stride = plane.stride;
    let rows = plane.values.par_chunks_mut(stride).enumerate().with_min_len(8);
    rows.for_each(|(y, out)| row(y, out));
}

/// The adjoint of the reflection: what lies in the margin of 2 goes back inside.
fn fold(padded: &Plane, out: &mut Plane) {
    let (width, height, margin) = (out.width, out.height, out.margin);
    let stride = out.stride;
    let rows = out.body_mut().par_chunks_mut(stride).enumerate().with_min_len(8);
    rows.for_each(|(y, row)| {
        let out = &mut row[margin..margin + width];
        out.fill(0.0);
        let mirrored = [1, 2].map(|d| (y == d).then_some(2 - d));
        let far = [1, 2].map(|d| (y + d + 1 == height).then_some(height + 1 + d));
        let sources = [Some(y + 2)].into_iter().chain(mirrored).chain(far).flatten();
        for source in sources {
            let from = padded.whole_row(source);
            for (o, v) in out.iter_mut().zip(&from[2..2 + width]) {
                *o += v;
            }
            for d in 1..=2 {
                out[d] += from[2 - d];
                out[width - 1 - d] += from[width + 1 + d];
            }
        }
    });
}
