//! The steerable pyramid of a picture: opponent colours, highest frequencies, six orientations at
//! four sizes, lowest frequencies.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use super::axis::Taps;
use super::bands::{bands_row, split_row};
use super::plane::{Plane, lanes};
use super::{BANDS, LEVELS, MAPS};

/// The decomposition of one channel.
#[derive(Debug)]
struct PyramidChannel {
    image: Plane,
    high: Plane,
    /// The plane that the bands of a level are filtered from; the last has none.
    low: [Plane; LEVELS + 1],
    bands: [[Plane; BANDS]; LEVELS],
}

/// The decomposition of a picture.
#[derive(Debug)]
pub(crate) struct Pyramid {
    /// Size of pictures.
    pub size: [usize; 2],
    /// The same, brought up to multiples of 32.
    pub full: [usize; 2],
    /// How columns and rows are brought up.
    pub resize: [Taps; 2],
    channels: [PyramidChannel; 3],
}

/// Sides after `level` halvings.
pub(crate) fn halved(full: [usize; 2], level: usize) -> [usize; 2] {
    full.map(|n| n >> level)
}

impl Pyramid {
    /// Room for the pyramid of a picture.
    pub(crate) fn new(size: [usize; 2], full: [usize; 2]) -> Pyramid {
        let channel = |_| PyramidChannel {
            image: Plane::new(full, 2),
            high: Plane::new(full, 0),
            low: std::array::from_fn(|k| {
                Plane::new(halved(full, k), if k < LEVELS { 2 } else { 0 })
            }),
            bands: std::array::from_fn(|k| std::array::from_fn(|_| Plane::new(halved(full, k), 0))),
        };
        let resize = std::array::from_fn(|i| Taps::new(size[i], full[i]));
        Pyramid { size, full, resize, channels: std::array::from_fn(channel) }
    }

    /// Level and values of one of the maps of all channels.
    pub(crate) fn map(&self, i: usize) -> (usize, &Plane) {
        let channel = &self.channels[i / MAPS];
        match (i % MAPS).checked_sub(1) {
            None => (0, &channel.high),
            Some(k) => (k / BANDS, &channel.bands[k / BANDS][k % BANDS]),
        }
    }

    /// The lowest frequencies of a channel.
    pub(crate) fn lowest(&self, channel: usize) -> &Plane {
        &self.channels[channel].low[LEVELS]
    }

    /// Decomposes a picture.
    pub(crate) fn analyse(&mut self, pixels: &[[f32; 3]]) {
        self.colours(pixels);
        let level = Level::new();
        for channel in &mut self.channels {
            channel.image.reflect();
            channel.split(level);
            for k in 0..LEVELS {
                let (done, next) = channel.low.split_at_mut(k + 1);
                done[k].reflect();
                oriented(level, &done[k], &mut channel.bands[k]);
                done[k].halve(&mut next[0]);
            }
        }
    }

    /// Opponent colours of the picture, brought up to the full size.
    fn colours(&mut self, pixels: &[[f32; 3]]) {
        let (width, [columns, rows], full) = (self.size[0], &self.resize, self.full);
        let same = self.size == full;
        let [a, b, c] = &mut self.channels;
        let (stride, margin) = (a.image.stride, a.image.margin);
        let planes = (
            a.image.body_mut().par_chunks_mut(stride),
            b.image.body_mut().par_chunks_mut(stride),
            c.image.body_mut().par_chunks_mut(stride),
        );
        planes.into_par_iter().enumerate().for_each_init(
            || vec![[0.0f32; 3]; width],
            |between, (y, planes)| {
                let above = &pixels[rows.first[y] as usize * width..][..width];
                let row = if same {
                    above
                } else {
                    let below = (rows.first[y] as usize + 1).min(pixels.len() / width - 1);
                    let below = &pixels[below * width..][..width];
                    for ((out, a), b) in between.iter_mut().zip(above).zip(below) {
                        *out = mixed(*a, *b, rows.weight[y]);
                    }
                    between
                };
                for x in 0..full[0] {
                    let first = columns.first[x] as usize;
                    let next = row[(first + 1).min(width - 1)];
                    let rgb = mixed(row[first], next, columns.weight[x]);
                    let at = margin + x;
                    [planes.0[at], planes.1[at], planes.2[at]] = opponent(rgb);
                }
            },
        );
    }
}

fn mixed(a: [f32; 3], b: [f32; 3], weight: f32) -> [f32; 3] {
    std::array::from_fn(|c| a[c] + weight * (b[c] - a[c]))
}

/// Y, Cr, Cb.
fn opponent([r, g, b]: [f32; 3]) -> [f32; 3] {
    let y = 0.299 * r + 0.587 * g + 0.114 * b;
    [y, 0.5 + 0.713 * (r - y), 0.5 + 0.564 * (b - y)]
}

/// The adjoint of [`opponent`], which is linear but for a constant.
pub(crate) fn opponent_adjoint([y, cr, cb]: [f32; 3]) -> [f32; 3] {
    let y = y - 0.713 * cr - 0.564 * cb;
    [0.299 * y + 0.713 * cr, 0.587 * y, 0.114 * y + 0.564 * cb]
}

impl PyramidChannel {
    fn split(&mut self, level: Level) {
        let image = &self.image;
        let n = lanes(image.width);
        let low = &mut self.low[0];
        let (margin, stride) = (low.margin, low.stride);
        let rows = (
            self.high.body_mut().par_chunks_mut(image_stride(image)),
            low.body_mut().par_chunks_mut(stride),
        );
        rows.into_par_iter().enumerate().with_min_len(8).for_each(|(y, (high, low))| {
            let (high, low) = (&mut high[..n], &mut low[margin..margin + n]);
            dispatch!(level, simd => split_row(simd, image, y, high, low));
        });
    }
}

/// The stride of planes of this width without a margin.
fn image_stride(plane: &Plane) -> usize {
    lanes(plane.width) + super::plane::LANES
}

fn oriented(level: Level, from: &Plane, bands: &mut [Plane; BANDS]) {
    let n = lanes(from.width);
    let stride = bands[0].stride;
    let [a, b, c, d, e, f] = bands.each_mut().map(|p| p.body_mut().par_chunks_mut(stride));
    let rows = (a, b, c, d, e, f).into_par_iter().enumerate().with_min_len(8);
    rows.for_each(|(y, (a, b, c, d, e, f))| {
        let out = [a, b, c, d, e, f].map(|row| &mut row[..n]);
        dispatch!(level, simd => bands_row(simd, from, y, out));
    });
}
