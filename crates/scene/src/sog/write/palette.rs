//! The palette of SH coefficients beyond DC: vectors that stand for those of all Gaussians.

use std::collections::HashMap;

use super::super::super::Gaussians;
use super::super::super::convert::rest_of;
use super::codebook::ENTRIES;
use super::vectors::{Vectors, cluster};

/// Labels have 16 bits.
const MOST: usize = 1 << 16;

/// Vectors, and which of them each Gaussian has.
pub(super) struct SogPalette {
    /// The entries, `[channel][coefficient]` each.
    pub values: Vec<f32>,
    /// For each Gaussian the index of its entry.
    pub labels: Vec<u16>,
}

impl SogPalette {
    /// The palette of a model whose degree is not 0.
    ///
    /// All different vectors where labels and codebook hold them, that is up to 65,536 vectors of
    /// at most 256 different numbers, or where there are no more than the palette has room for
    /// ([`size`]); otherwise means of vectors that are alike.
    pub(crate) fn of(scene: &Gaussians) -> SogPalette {
        let n = scene.sh_coefficients();
        let channels = scene.sh.chunks_exact(n);
        let values: Vec<f32> = channels.flat_map(|channel| &channel[1..]).copied().collect();
        let vectors = Vectors { values: &values, dimensions: 3 * rest_of(scene.sh_degree) };
        let room = size(scene.len());
        match different(&vectors) {
            Some(all) if all.len(&vectors) <= room || has_few_values(&all.values) => all,
            _ => {
                let (values, labels) = cluster(&vectors, room);
                SogPalette { values, labels }
            }
        }
    }

    fn len(&self, vectors: &Vectors<'_>) -> usize {
        self.values.len() / vectors.dimensions
    }
}

/// Entries of a palette for `count` Gaussians: the largest power of two that is not above their
/// number, up to 65,536, as other writers have it.
fn size(count: usize) -> usize {
    MOST.min(1 << count.ilog2())
}

/// All different vectors in the order in which they appear, unless there are too many.
fn different(vectors: &Vectors<'_>) -> Option<SogPalette> {
    let mut places: HashMap<&[u8], u16> = HashMap::new();
    let mut palette = SogPalette { values: Vec::new(), labels: Vec::new() };
    for vector in vectors.iter() {
        let bits: &[u8] = bytemuck::cast_slice(vector);
        let next = places.len();
        let label = match places.get(bits) {
            Some(label) => *label,
            None => {
                let label = u16::try_from(next).ok()?;
                places.insert(bits, label);
                palette.values.extend_from_slice(vector);
                label
            }
        };
        palette.labels.push(label);
    }
    Some(palette)
}

/// Whether a codebook holds all of the numbers.
fn has_few_values(values: &[f32]) -> bool {
    let mut different = std::collections::BTreeSet::new();
    values.iter().all(|value| {
        different.insert(value.to_bits());
        different.len() <= ENTRIES
    })
}
