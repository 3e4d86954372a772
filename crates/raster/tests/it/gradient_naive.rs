//! A readable twin of the differentiable rasteriser: the forward model of `powergs.md` §1 in
//! double precision on numbers that carry the derivative by one parameter. No backward pass of its
//! own, so it cannot repeat a defect of the renderer.

use powergs_frame::splat::Splat;
use powergs_raster::train::{Clamp, Options};
use powergs_scene::{Camera, Gaussians};

use super::dual::Dual;
use super::naive::accepted;

/// Parameters of a Gaussian before its SH coefficients: mean, log-scale, quaternion, opacity.
pub const BEFORE_SH: usize = 11;

/// A projected Gaussian.
#[derive(Debug, Clone, Copy)]
pub struct SplatTwin {
    mean: [Dual; 2],
    conic: [Dual; 3],
    opacity: Dual,
    colour: [Dual; 3],
}

fn dot(a: [Dual; 3], b: [Dual; 3]) -> Dual {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn rotation(q: [Dual; 4]) -> [[Dual; 3]; 3] {
    let norm = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]).sqrt();
    let [w, x, y, z] = q.map(|c| c / norm);
    let one = Dual::constant(1.0);
    [
        [one - (y * y + z * z) * 2.0, (x * y - w * z) * 2.0, (x * z + w * y) * 2.0],
        [(x * y + w * z) * 2.0, one - (x * x + z * z) * 2.0, (y * z - w * x) * 2.0],
        [(x * z - w * y) * 2.0, (y * z + w * x) * 2.0, one - (x * x + y * y) * 2.0],
    ]
}

/// The published polynomials.
fn harmonics(degree: u8, [x, y, z]: [Dual; 3]) -> Vec<Dual> {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    let mut out = vec![Dual::constant(0.282_094_791_773_878_14)];
    if degree >= 1 {
        let c = 0.488_602_511_902_919_9;
        out.extend([y * -c, z * c, x * -c]);
    }
    if degree >= 2 {
        out.extend([
            x * y * 1.092_548_430_592_079_2,
            y * z * -1.092_548_430_592_079_2,
            (zz * 2.0 - xx - yy) * 0.315_391_565_252_520_05,
            x * z * -1.092_548_430_592_079_2,
            (xx - yy) * 0.546_274_215_296_039_6,
        ]);
    }
    if degree >= 3 {
        out.extend([
            y * (xx * 3.0 - yy) * -0.590_043_589_926_643_5,
            x * y * z * 2.890_611_442_640_554,
            y * (zz * 4.0 - xx - yy) * -0.457_045_799_464_465_8,
            z * (zz * 2.0 - xx * 3.0 - yy * 3.0) * 0.373_176_332_590_115_4,
            x * (zz * 4.0 - xx - yy) * -0.457_045_799_464_465_8,
            z * (xx - yy) * 1.445_305_721_320_277,
            x * (xx - yy * 3.0) * -0.590_043_589_926_643_5,
        ]);
    }
    out
}

/// Projects Gaussian `i` with derivatives by its parameter `by` (counted through means, log-scales,
/// quaternion, opacity and SH).
pub fn project(scene: &Gaussians, camera: &Camera, i: usize, by: Option<usize>) -> SplatTwin {
    let mut place = 0;
    let mut next = |value: f32| {
        let slope = if by == Some(place) { 1.0 } else { 0.0 };
        place += 1;
        Dual { value: f64::from(value), slope }
    };
    let p = scene.means[i].map(&mut next);
    let s = scene.log_scales[i].map(&mut next).map(Dual::exp);
    let r = rotation(scene.rotations[i].map(&mut next));
    let opacity = Dual::constant(1.0) / ((-next(scene.logit_opacities[i])).exp() + 1.0);
    let sh: Vec<Dual> = scene.sh_of(i).iter().map(|&v| next(v)).collect();

    let centre = camera.centre.to_array();
    let offset: [Dual; 3] = std::array::from_fn(|k| p[k] - centre[k]);
    let row = |k: usize| camera.world_to_camera.row(k).to_array().map(Dual::constant);
    let t: [Dual; 3] = std::array::from_fn(|k| dot(row(k), offset));
    let focal = [camera.fx, camera.fy];
    let size = [f64::from(camera.width), f64::from(camera.height)];
    let principal = [camera.cx - 0.5, camera.cy - 0.5];
    let mean =
        std::array::from_fn(|k| t[k] * focal[k] / (t[2] + 1e-7) + Dual::constant(principal[k]));
    // Rows of J W R S; their products are the 2D covariance.
    let axes: [[Dual; 3]; 2] = std::array::from_fn(|k| {
        let limit = 1.3 * size[k] / (2.0 * focal[k]);
        let slope = (t[k] / t[2]).at_most(limit).at_least(-limit);
        let jw: [Dual; 3] =
            std::array::from_fn(|j| (row(k)[j] - slope * row(2)[j]) * focal[k] / t[2]);
        std::array::from_fn(|j| dot(jw, [r[0][j], r[1][j], r[2][j]]) * s[j])
    });
    let (a, b) = (dot(axes[0], axes[0]) + 0.3, dot(axes[0], axes[1]));
    let d = dot(axes[1], axes[1]) + 0.3;
    let det = a * d - b * b;
    let opacity = match scene.antialiased {
        true => opacity * ((dot(axes[0], axes[0]) * dot(axes[1], axes[1]) - b * b) / det).sqrt(),
        false => opacity,
    };
    let length = dot(offset, offset).sqrt();
    let basis = harmonics(scene.sh_degree, offset.map(|c| c / length));
    let colour = std::array::from_fn(|c| {
        let sum = basis
            .iter()
            .zip(&sh[c * basis.len()..])
            .fold(Dual::constant(0.5), |sum, (b, s)| sum + *b * *s);
        sum.at_least(0.0)
    });
    SplatTwin { mean, conic: [d / det, -b / det, a / det], opacity, colour }
}

/// α of a splat at pixel (x, y); `None` where it is skipped.
fn alpha(splat: &SplatTwin, x: u32, y: u32, clamp: Clamp) -> Option<Dual> {
    let (dx, dy) = (splat.mean[0] - f64::from(x), splat.mean[1] - f64::from(y));
    let [c0, c1, c2] = splat.conic;
    let power = (c0 * dx * dx + c2 * dy * dy) * -0.5 - c1 * dx * dy;
    let exact = splat.opacity * power.exp();
    let clamped = match clamp {
        Clamp::Exact => exact.at_most(0.99),
        Clamp::PassThrough => Dual { value: exact.value.min(0.99), ..exact },
    };
    (power.value <= 0.0 && clamped.value >= 1.0 / 255.0).then_some(clamped)
}

/// The picture's lists and splats, ready for one derivative after another.
pub struct Twin<'a> {
    pub scene: &'a Gaussians,
    pub camera: &'a Camera,
    pub options: &'a Options,
    splats: Vec<SplatTwin>,
    /// Scene index by rank.
    indices: Vec<usize>,
    /// Ranks per tile.
    lists: Vec<Vec<usize>>,
    nx: u32,
}

impl<'a> Twin<'a> {
    pub fn new(
        scene: &'a Gaussians,
        camera: &'a Camera,
        options: &'a Options,
        splats: &[Splat],
    ) -> Twin<'a> {
        let lists_of = powergs_raster::Options {
            test: options.test,
            ..powergs_raster::Options::reference(powergs_raster::Detail::Image)
        };
        let (nx, ny) = (camera.width.div_ceil(16), camera.height.div_ceil(16));
        let list = |tx, ty| {
            (0..splats.len()).filter(|&r| accepted(&splats[r], camera, &lists_of, tx, ty)).collect()
        };
        Twin {
            scene,
            camera,
            options,
            splats: splats.iter().map(|s| project(scene, camera, s.index as usize, None)).collect(),
            indices: splats.iter().map(|s| s.index as usize).collect(),
            lists: (0..ny)
                .flat_map(|ty| (0..nx).map(move |tx| (tx, ty)))
                .map(|(x, y)| list(x, y))
                .collect(),
            nx,
        }
    }

    /// The derivative of Σ weight · channel by parameter `by` of the splat of `rank`.
    pub fn derivative(&self, rank: usize, by: usize, weights: &[[f32; 3]]) -> f64 {
        let chosen = project(self.scene, self.camera, self.indices[rank], Some(by));
        let mut sum = 0.0;
        for (i, weight) in weights.iter().enumerate() {
            let (x, y) = (i as u32 % self.camera.width, i as u32 / self.camera.width);
            let list = &self.lists[(y / 16 * self.nx + x / 16) as usize];
            // Elsewhere the pixel does not depend on it.
            if !list.contains(&rank) || alpha(&chosen, x, y, self.options.clamp).is_none() {
                continue;
            }
            let pixel = self.pixel(list, x, y, (rank, &chosen));
            sum += (0..3).map(|c| f64::from(weight[c]) * pixel[c].slope).sum::<f64>();
        }
        sum
    }

    fn pixel(&self, list: &[usize], x: u32, y: u32, chosen: (usize, &SplatTwin)) -> [Dual; 3] {
        let mut colour = [Dual::constant(0.0); 3];
        let mut t = Dual::constant(1.0);
        for &rank in list {
            let splat = if rank == chosen.0 { chosen.1 } else { &self.splats[rank] };
            let Some(alpha) = alpha(splat, x, y, self.options.clamp) else { continue };
            let left = t - t * alpha;
            if left.value < 1e-4 {
                break;
            }
            for (sum, c) in colour.iter_mut().zip(splat.colour) {
                *sum = *sum + alpha * t * c;
            }
            t = left;
        }
        std::array::from_fn(|c| colour[c] + t * f64::from(self.options.background[c]))
    }
}
