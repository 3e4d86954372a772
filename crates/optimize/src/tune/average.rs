//! The mean of a model over iterations: it is quiet where long steps shake every single one.

use rayon::prelude::*;

use super::super::adam::Group;
use powergs_scene::Gaussians;

/// Parameters that one task works on.
const PART: usize = 1 << 16;

/// Takes `scene` into `mean` with a weight from 0 to 1. Every parameter is worked on alone.
pub(super) fn mix(mean: &mut Gaussians, scene: &Gaussians, weight: f32) {
    for group in Group::ALL {
        let values = group.of(scene).par_chunks(PART);
        group.of_mut(mean).par_chunks_mut(PART).zip(values).for_each(|(mean, values)| {
            for (m, v) in mean.iter_mut().zip(values) {
                *m += weight * (v - *m);
            }
        });
    }
}
