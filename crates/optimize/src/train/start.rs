//! What a training starts from: Gaussians around points.

use glam::{DMat3, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::nearest_three;
use powergs_scene::convert::dc;
use powergs_scene::{Camera, Gaussians};

/// Opacity at the beginning.
const OPACITY: f32 = 0.1;
/// The least mean squared distance of neighbours, world units².
const LEAST_SQUARE: f32 = 1e-7;
/// Random colours are grey within this many steps of the constant coefficient.
const GREY: f32 = 1.0 / 255.0;

/// Gaussians around points by the published rule: as large as the root of the mean squared distance
/// to the three nearest neighbours, round, of opacity 0.1, of the colour of the point (sRGB 0 to 1)
/// and SH degree 0.
///
/// # Panics
/// Without a colour for every point.
pub fn around(positions: &[[f32; 3]], colours: &[[f32; 3]]) -> Gaussians {
    assert_eq!(positions.len(), colours.len(), "a colour for every point");
    let scales = nearest_three(positions);
    let log_scale = |square: f32| [0.5 * square.max(LEAST_SQUARE).ln(); 3];
    Gaussians {
        means: positions.to_vec(),
        log_scales: scales.into_iter().map(log_scale).collect(),
        rotations: vec![[1.0, 0.0, 0.0, 0.0]; positions.len()],
        logit_opacities: vec![(OPACITY / (1.0 - OPACITY)).ln(); positions.len()],
        sh_degree: 0,
        sh: colours.iter().flat_map(|c| c.map(|v| dc(v.into()))).collect(),
        antialiased: false,
    }
}

/// Points drawn evenly in a cube around what the cameras look at, half as wide as `cube` extents of
/// the cameras, and nearly grey colours: positions and colours, sRGB.
pub fn scattered(
    cameras: &[Camera],
    count: usize,
    cube: f64,
    seed: u64,
) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let centre = focus(cameras);
    let half = cube * super::super::views::extent(cameras.iter().map(|camera| camera.centre));
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut draw = || rng.random_range(-1.0..1.0_f64);
    let place = |_| (centre + half * DVec3::new(draw(), draw(), draw())).to_array();
    let positions = (0..count).map(place).map(|p| p.map(|v| v as f32)).collect();
    let mut rng = Pcg64Mcg::seed_from_u64(!seed);
    let mut grey = || 0.5 + GREY * rng.random_range(0.0..1.0_f32) * 0.282_094_8;
    let colours = (0..count).map(|_| [grey(), grey(), grey()]).collect();
    (positions, colours)
}

/// The point that is nearest to all optical axes; the mean of the cameras where these are parallel.
fn focus(cameras: &[Camera]) -> DVec3 {
    let n = cameras.len().max(1) as f64;
    let mean = cameras.iter().map(|camera| camera.centre).sum::<DVec3>() / n;
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for camera in cameras {
        let axis = camera.world_to_camera.row(2);
        let across =
            DMat3::IDENTITY - DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
        matrix += across;
        // Around the mean, so that worlds far from the origin lose nothing.
        right += across * (camera.centre - mean);
    }
    let point = (matrix / n).inverse() * (right / n);
    let is_parallel = (matrix / n).determinant() < 1e-6 || !point.is_finite();
    if is_parallel { mean } else { mean + point }
}
