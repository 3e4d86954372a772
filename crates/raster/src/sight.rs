//! How much of a scene its views have in sight.

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use powergs_frame::splat::NEAR;
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

/// Most views that are asked what the near plane cuts off.
const NEAR_VIEWS: usize = 8;

/// Gaussians whose centres are in pictures, by what the near plane does to them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct NearCut {
    /// Those between a camera and its near plane, which are not drawn.
    pub cut: u64,
    /// Those behind it.
    pub drawn: u64,
}

/// What the near plane cuts off `scene` in a few of the views, together.
pub fn near_cut(scene: &Gaussians, cameras: &[Camera]) -> NearCut {
    let every = cameras.len().div_ceil(NEAR_VIEWS).max(1);
    let of_view = |camera: &Camera| {
        let (width, height) = (f64::from(camera.width), f64::from(camera.height));
        let axes = [0, 1, 2].map(|axis| camera.world_to_camera.row(axis).to_array());
        let centre = camera.centre.to_array();
        let of = |mean: &[f32; 3]| {
            let [x, y, z] = axes.map(|axis| {
                (0..3).map(|k| axis[k] * (f64::from(mean[k]) - centre[k])).sum::<f64>()
            });
            let (x, y) = (x / z * camera.fx + camera.cx, y / z * camera.fy + camera.cy);
            let is_inside = (0.0..=width).contains(&x) && (0.0..=height).contains(&y);
            match is_inside && z > 0.0 {
                false => NearCut::default(),
                true if z <= f64::from(NEAR) => NearCut { cut: 1, drawn: 0 },
                true => NearCut { cut: 0, drawn: 1 },
            }
        };
        scene.means.par_iter().with_min_len(4096).map(of).reduce(NearCut::default, NearCut::plus)
    };
    cameras.iter().step_by(every).map(of_view).fold(NearCut::default(), NearCut::plus)
}

impl NearCut {
    fn plus(self, other: NearCut) -> NearCut {
        NearCut { cut: self.cut + other.cut, drawn: self.drawn + other.drawn }
    }
}
