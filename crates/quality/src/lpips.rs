//! LPIPS: the distance of two pictures in the features of a trained network. The user supplies the
//! weights.
//!
//! Zhang et al., "The Unreasonable Effectiveness of Deep Features as a Perceptual Metric" (CVPR
//! 2018), version 0.1, over AlexNet or VGG16, forward only (`lpips` in `docs/metrics.md`). Nothing
//! is computed without weights, and none come with this package.

mod convolution;
mod network;
mod weights;

use rayon::prelude::*;

use convolution::{Filters, Map};
use network::Network;
use powergs_base::picture::Picture;
pub use weights::LpipsError;

/// Added to the length of a feature vector before it divides.
const EPSILON: f32 = 1e-10;
/// The most memory that the features of two pictures may take, bytes.
const MEMORY_MAX: u64 = 8 << 30;

/// A network with its weights and those of the distance.
#[derive(Debug, Clone)]
pub struct Lpips {
    network: &'static Network,
    /// Of each slice, its convolutions.
    slices: Vec<Vec<Filters>>,
    /// Of each slice, the weight of the squared difference of a channel.
    heads: Vec<Vec<f32>>,
    /// Taken from the input of -1 to 1, per channel.
    shift: [f32; 3],
    /// Divides the input after that.
    scale: [f32; 3],
}

impl Lpips {
    /// From the bytes of a safetensors file; tensors are named as the `lpips` package of Python
    /// names them. Memory is in proportion to the file.
    ///
    /// # Errors
    /// [`LpipsError`]: the file is damaged, lacks a tensor, or holds one that cannot be used.
    pub fn from_safetensors(bytes: &[u8]) -> Result<Lpips, LpipsError> {
        weights::read(bytes)
    }

    /// The network: `alex` or `vgg`.
    pub fn network(&self) -> &'static str {
        self.network.name
    }

    /// Whether pictures of this size, in pixels, can be compared.
    ///
    /// # Errors
    /// [`LpipsError::Small`] if nothing would be left after the pools, [`LpipsError::Large`] if
    /// the features would take too much memory.
    pub fn check_size(&self, width: u32, height: u32) -> Result<(), LpipsError> {
        let least = self.network.least_side();
        if width.min(height) < least {
            return Err(LpipsError::Small { width, height, least, network: self.network.name });
        }
        let bytes = self.network.memory_bytes(width, height);
        if bytes > MEMORY_MAX {
            let (gib, most) = (bytes.div_ceil(1 << 30), MEMORY_MAX >> 30);
            return Err(LpipsError::Large { width, height, gib, most });
        }
        Ok(())
    }

    /// The distance of two pictures: 0 for equal ones, about 1 for those that have nothing in
    /// common. Values are clamped to 0..1; NaN if one is not finite. The same for any number of
    /// threads.
    ///
    /// # Errors
    /// Those of [`Lpips::check_size`].
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn distance(&self, a: &Picture, b: &Picture) -> Result<f64, LpipsError> {
        assert_eq!((a.width, a.height), (b.width, b.height), "equal sizes");
        self.check_size(a.width, a.height)?;
        let is_finite = |p: &Picture| p.pixels.par_iter().flatten().all(|v| v.is_finite());
        if !is_finite(a) || !is_finite(b) {
            return Ok(f64::NAN);
        }
        let mut maps = [self.input(a), self.input(b)];
        let mut sum = 0.0;
        for ((slice, filters), head) in
            self.network.slices.iter().zip(&self.slices).zip(&self.heads)
        {
            for map in &mut maps {
                if let Some(pool) = slice.pool {
                    *map = pool.of(map);
                }
                for (convolution, filters) in slice.convolutions.iter().zip(filters) {
                    *map = convolution.of(map, filters);
                }
            }
            sum += difference(&maps[0], &maps[1], head);
        }
        Ok(sum)
    }

    fn input(&self, picture: &Picture) -> Map {
        let (width, height) = (picture.width as usize, picture.height as usize);
        let pixel = |p: &[f32; 3]| -> [f32; 3] {
            let value =
                |c: usize| (2.0 * p[c].clamp(0.0, 1.0) - 1.0 - self.shift[c]) / self.scale[c];
            std::array::from_fn(value)
        };
        let pixels: Vec<[f32; 3]> = picture.pixels.par_iter().map(pixel).collect();
        Map { width, height, channels: 3, values: pixels.into_flattened() }
    }
}

/// The weighted squared difference of unit feature vectors, mean over places.
fn difference(a: &Map, b: &Map, head: &[f32]) -> f64 {
    let row = a.width * a.channels;
    // One sum per row, added up in their order: independent of threads.
    let rows: Vec<f64> = a
        .values
        .par_chunks(row)
        .zip(b.values.par_chunks(row))
        .map(|(a, b)| {
            let places = a.chunks_exact(head.len()).zip(b.chunks_exact(head.len()));
            places.map(|(a, b)| at_a_place(a, b, head)).sum()
        })
        .collect();
    rows.iter().sum::<f64>() / (a.width * a.height) as f64
}

fn at_a_place(a: &[f32], b: &[f32], head: &[f32]) -> f64 {
    let length = |v: &[f32]| v.iter().map(|v| v * v).sum::<f32>().sqrt() + EPSILON;
    let (la, lb) = (length(a), length(b));
    let term = |((a, b), w): ((&f32, &f32), &f32)| {
        let d = a / la - b / lb;
        f64::from(w * d * d)
    };
    a.iter().zip(b).zip(head).map(term).sum()
}
