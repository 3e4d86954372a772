//! In which order the Gaussians of a model lie in memory.

use rayon::prelude::*;

use super::Gaussians;

/// In which order the Gaussians of a model lie in memory: position is address. Models are sorted
/// once, when they are loaded; their pictures do not change.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum StorageOrder {
    /// As the file has them. Trainers leave them almost anywhere in space, writers of compressed
    /// formats along a curve.
    #[default]
    Storage,
    /// Along the Z-order curve of their centres.
    Morton,
    /// Along the Hilbert curve of their centres, each step of which goes to a neighbour.
    Hilbert,
    /// The most opaque first.
    Opacity,
}

/// Bits of a coordinate on a curve: three of them fill a key.
const BITS: u32 = 21;

impl StorageOrder {
    /// Every order, by its code in trace files.
    pub const ALL: [StorageOrder; 4] =
        [StorageOrder::Storage, StorageOrder::Morton, StorageOrder::Hilbert, StorageOrder::Opacity];

    /// The name on the command line and in every output.
    pub const fn name(self) -> &'static str {
        match self {
            StorageOrder::Storage => "storage",
            StorageOrder::Morton => "morton",
            StorageOrder::Hilbert => "hilbert",
            StorageOrder::Opacity => "opacity",
        }
    }

    /// The order of this name.
    pub fn from_name(name: &str) -> Option<StorageOrder> {
        StorageOrder::ALL.into_iter().find(|order| order.name() == name)
    }

    /// Which Gaussian of `scene` comes at each position, `None` where none moves. Those with equal
    /// keys stay in the order of the file.
    pub fn of(self, scene: &Gaussians) -> Option<Vec<u32>> {
        let keys: Vec<u64> = match self {
            StorageOrder::Storage => return None,
            StorageOrder::Opacity => scene.logit_opacities.iter().map(|v| descending(*v)).collect(),
            StorageOrder::Morton => on_curve(scene, interleaved),
            StorageOrder::Hilbert => on_curve(scene, |mut at| {
                hilbert(&mut at);
                interleaved(at)
            }),
        };
        let mut order: Vec<u32> = (0..scene.len() as u32).collect();
        order.par_sort_by_key(|i| keys[*i as usize]);
        Some(order)
    }
}

/// A key that is smaller for larger values.
fn descending(value: f32) -> u64 {
    let bits = value.to_bits();
    u64::from(if value.is_sign_negative() { bits } else { !bits & (u32::MAX >> 1) })
}

/// The key of every centre in a grid over all of them.
fn on_curve(scene: &Gaussians, key: impl Fn([u32; 3]) -> u64 + Sync) -> Vec<u64> {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for mean in &scene.means {
        for axis in 0..3 {
            low[axis] = low[axis].min(mean[axis]);
            high[axis] = high[axis].max(mean[axis]);
        }
    }
    // One step for all axes: cells are cubes.
    let extent =
        (0..3).map(|axis| f64::from(high[axis]) - f64::from(low[axis])).fold(0.0, f64::max);
    let steps = f64::from((1u32 << BITS) - 1) / extent.max(f64::MIN_POSITIVE);
    let cell = |mean: &[f32; 3]| {
        std::array::from_fn(|axis| ((f64::from(mean[axis]) - f64::from(low[axis])) * steps) as u32)
    };
    scene.means.par_iter().map(|mean| key(cell(mean))).collect()
}

/// The bits of x, y and z in turn, those of x first.
fn interleaved(at: [u32; 3]) -> u64 {
    let bit = |axis: usize, bit: u32| u64::from(at[axis] >> bit & 1) << (3 * bit + 2 - axis as u32);
    (0..BITS).map(|b| bit(0, b) | bit(1, b) | bit(2, b)).sum()
}

/// From coordinates to the transpose of their distance on the Hilbert curve (J. Skilling,
/// Programming the Hilbert curve, AIP Conf. Proc. 707, 2004).
fn hilbert(at: &mut [u32; 3]) {
    let highest = 1 << (BITS - 1);
    let mut bit = highest;
    while bit > 1 {
        let lower = bit - 1;
        for axis in 0..3 {
            if at[axis] & bit != 0 {
                at[0] ^= lower;
            } else {
                let swapped = (at[0] ^ at[axis]) & lower;
                at[0] ^= swapped;
                at[axis] ^= swapped;
            }
        }
        bit >>= 1;
    }
    at[1] ^= at[0];
    at[2] ^= at[1];
    let mut flip = 0;
    bit = highest;
    while bit > 1 {
        if at[2] & bit != 0 {
            flip ^= bit - 1;
        }
        bit >>= 1;
    }
    at.iter_mut().for_each(|x| *x ^= flip);
}

impl Gaussians {
    /// The Gaussian of `order[i]` at every position `i`.
    ///
    /// # Panics
    /// Where `order` names a Gaussian that is not there.
    pub fn permuted(&self, order: &[u32]) -> Gaussians {
        fn pick<T: Copy>(all: &[T], order: &[u32]) -> Vec<T> {
            order.iter().map(|i| all[*i as usize]).collect()
        }
        Gaussians {
            means: pick(&self.means, order),
            log_scales: pick(&self.log_scales, order),
            rotations: pick(&self.rotations, order),
            logit_opacities: pick(&self.logit_opacities, order),
            sh: order.iter().flat_map(|i| self.sh_of(*i as usize)).copied().collect(),
            sh_degree: self.sh_degree,
            antialiased: self.antialiased,
        }
    }
}
