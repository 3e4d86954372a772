//! A readable twin of the rasteriser: one pixel, one splat, one formula at a time, in double
//! precision, with a separating-axis test spelled out.

use powergs_frame::splat::{Intersection, Splat};
use powergs_raster::Options;
use powergs_scene::{Camera, Gaussians};

/// One pixel as the twin sees it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Pixel {
    pub colour: [f64; 3],
    pub iterated: u32,
    pub blended: u32,
    pub stop_rank: Option<u32>,
    /// Ranks of the splats that its colour is of.
    pub hits: Vec<u32>,
}

/// View-space position and 2D mean and covariance of Gaussian `i`, from `powergs.md` §1.1.
pub fn project(scene: &Gaussians, camera: &Camera, i: usize) -> (f64, [f64; 2], [f64; 3]) {
    let p = glam::DVec3::from_array(scene.means[i].map(f64::from));
    let t = camera.world_to_camera * (p - camera.centre);
    let q = scene.rotations[i].map(f64::from);
    let rotation =
        glam::DMat3::from_quat(glam::DQuat::from_xyzw(q[1], q[2], q[3], q[0]).normalize());
    let s = glam::DVec3::from_array(scene.log_scales[i].map(|l| f64::from(l).exp()));
    let m = rotation * glam::DMat3::from_diagonal(s);
    let sigma = camera.world_to_camera * m * m.transpose() * camera.world_to_camera.transpose();
    let (tan_x, tan_y) =
        (f64::from(camera.width) / (2.0 * camera.fx), f64::from(camera.height) / (2.0 * camera.fy));
    let x = (t.x / t.z).clamp(-1.3 * tan_x, 1.3 * tan_x) * t.z;
    let y = (t.y / t.z).clamp(-1.3 * tan_y, 1.3 * tan_y) * t.z;
    let j0 = glam::DVec3::new(camera.fx / t.z, 0.0, -camera.fx * x / (t.z * t.z));
    let j1 = glam::DVec3::new(0.0, camera.fy / t.z, -camera.fy * y / (t.z * t.z));
    let cov = [j0.dot(sigma * j0) + 0.3, j0.dot(sigma * j1), j1.dot(sigma * j1) + 0.3];
    let w = 1.0 / (t.z + 1e-7);
    let mean = [camera.fx * t.x * w + camera.cx - 0.5, camera.fy * t.y * w + camera.cy - 0.5];
    (t.z, mean, cov)
}

/// Whether `splat` is in the list of tile (tx, ty): rectangle, then separating axes.
pub fn accepted(splat: &Splat, camera: &Camera, options: &Options, tx: u32, ty: u32) -> bool {
    let t = options.tile as f32;
    let r = splat.radius();
    let grid = [camera.width.div_ceil(options.tile), camera.height.div_ceil(options.tile)];
    let lo = |k: usize| (((splat.mean[k] - r) / t) as i32).clamp(0, grid[k] as i32) as u32;
    let hi =
        |k: usize| (((splat.mean[k] + r + t - 1.0) / t) as i32).clamp(0, grid[k] as i32) as u32;
    let inside = (lo(0)..hi(0)).contains(&tx) && (lo(1)..hi(1)).contains(&ty);
    let candidates = (hi(0) - lo(0)) * (hi(1) - lo(1));
    if !inside || candidates == 1 || options.test == Intersection::Aabb {
        return inside;
    }
    let [a, b, d] = splat.cov.map(f64::from);
    let theta = 0.5 * (2.0 * b).atan2(a - d);
    let (mid, root) = (0.5 * (a + d), ((0.5 * (a - d)).powi(2) + b * b).sqrt());
    let half = [3.0 * (mid + root).sqrt(), 3.0 * (mid - root).max(0.0).sqrt()];
    let axes = [[theta.cos(), theta.sin()], [-theta.sin(), theta.cos()]];
    let tile = f64::from(options.tile);
    let centre = [(f64::from(tx) + 0.5) * tile, (f64::from(ty) + 0.5) * tile];
    let offset = [centre[0] - f64::from(splat.mean[0]), centre[1] - f64::from(splat.mean[1])];
    let dot = |u: [f64; 2], v: [f64; 2]| u[0] * v[0] + u[1] * v[1];
    [[1.0, 0.0], [0.0, 1.0], axes[0], axes[1]].iter().all(|&axis| {
        let tile_reach = 0.5 * tile * (axis[0].abs() + axis[1].abs());
        let box_reach: f64 = (0..2).map(|k| half[k] * dot(axes[k], axis).abs()).sum();
        dot(offset, axis).abs() <= tile_reach + box_reach
    })
}

/// Blends the list of its tile into pixel (x, y).
pub fn blend(
    list: &[u32],
    splats: &[Splat],
    colours: &[[f32; 3]],
    (x, y): (u32, u32),
    background: [f32; 3],
) -> Pixel {
    let mut pixel = Pixel::default();
    let mut t = 1.0f64;
    for &rank in list {
        let splat = &splats[rank as usize];
        pixel.iterated += 1;
        let c = splat.conic().unwrap().map(f64::from);
        let dx = f64::from(splat.mean[0]) - f64::from(x);
        let dy = f64::from(splat.mean[1]) - f64::from(y);
        let power = -0.5 * (c[0] * dx * dx + c[2] * dy * dy) - c[1] * dx * dy;
        let alpha = (f64::from(splat.opacity) * power.exp()).min(0.99);
        if power > 0.0 || alpha < 1.0 / 255.0 {
            continue;
        }
        pixel.blended += 1;
        if t * (1.0 - alpha) < 1e-4 {
            pixel.stop_rank = Some(rank);
            break;
        }
        for (sum, c) in pixel.colour.iter_mut().zip(colours[splat.index as usize]) {
            *sum += alpha * t * f64::from(c);
        }
        pixel.hits.push(rank);
        t *= 1.0 - alpha;
    }
    for (sum, c) in pixel.colour.iter_mut().zip(background) {
        *sum += t * f64::from(c);
    }
    pixel
}
