//! How much of a scene its views have in sight.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use powergs_frame::splat::project::{LANES, View, may_see};
use powergs_scene::{Camera, Gaussians};

/// Gaussians that the view that sees most of `scene` may see: none is missed, a few may be beside
/// the picture. Views are looked at until one sees `enough`.
pub fn most_in_sight(scene: &Gaussians, cameras: &[Camera], enough: u64) -> u64 {
    let level = Level::new();
    let mut most = 0;
    for camera in cameras {
        if most >= enough {
            break;
        }
        let view = View::new(camera);
        let blocks = scene.means.par_chunks(LANES).zip(scene.log_scales.par_chunks(LANES));
        let in_sight = |(means, scales): (&[[f32; 3]], &[[f32; 3]])| {
            let seen = dispatch!(level, simd => may_see(simd, &view, means, scales));
            u64::from(seen.count_ones())
        };
        most = most.max(blocks.with_min_len(256).map(in_sight).sum());
    }
    most
}
