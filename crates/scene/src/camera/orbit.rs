//! A circle of cameras around a scene.

use glam::{DMat3, DVec3};

use super::super::Gaussians;
use super::Camera;

/// Most Gaussians that are looked at to find the bounds.
const SAMPLES: usize = 100_000;
/// The share of Gaussians that the extent holds: floaters and a background shell are left out.
const EXTENT_QUANTILE: f64 = 0.75;

/// Where a scene is and how large, robust against outliers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneBounds {
    /// Median of the Gaussian centres per axis, world units.
    pub centre: DVec3,
    /// Distance from `centre` within which three quarters of the Gaussians are, world units.
    pub extent: f64,
}

impl SceneBounds {
    /// Bounds of a scene; of at most 100,000 evenly spaced Gaussians of it. Gaussians whose centre
    /// is not finite are left out. An empty scene has extent 1 around the origin.
    pub fn of(scene: &Gaussians) -> SceneBounds {
        let stride = scene.len().div_ceil(SAMPLES).max(1);
        let finite = |m: &&[f32; 3]| m.iter().all(|v| v.is_finite());
        let means: Vec<DVec3> = scene
            .means
            .iter()
            .step_by(stride)
            .filter(finite)
            .map(|m| DVec3::from_array(m.map(f64::from)))
            .collect();
        if means.is_empty() {
            return SceneBounds { centre: DVec3::ZERO, extent: 1.0 };
        }
        let axis = |k: usize| quantile(means.iter().map(|m| m[k]).collect(), 0.5);
        let centre = DVec3::new(axis(0), axis(1), axis(2));
        let distances = means.iter().map(|m| m.distance(centre)).collect();
        let extent = quantile(distances, EXTENT_QUANTILE);
        SceneBounds { centre, extent: if extent > 0.0 { extent } else { 1.0 } }
    }
}

fn quantile(mut values: Vec<f64>, q: f64) -> f64 {
    let idx = ((values.len() - 1) as f64 * q) as usize;
    *values.select_nth_unstable_by(idx, f64::total_cmp).1
}

/// A circle of views that all look at its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orbit {
    /// Number of views, evenly spaced; the last is one step before the first.
    pub views: usize,
    /// What they look at, world units.
    pub centre: DVec3,
    /// Distance of every camera from `centre`, world units.
    pub radius: f64,
    /// Angle above the horizon, radians.
    pub elevation: f64,
    /// Where up is, unit vector.
    pub up: DVec3,
    /// Vertical field of view, radians.
    pub vertical_fov: f64,
    /// Width and height of the image, pixels.
    pub size: (u32, u32),
}

impl Orbit {
    /// The radius at which a sphere of `extent` fills the smaller image side.
    pub fn fitting_radius(extent: f64, vertical_fov: f64, (width, height): (u32, u32)) -> f64 {
        let aspect = (f64::from(width) / f64::from(height)).min(1.0);
        let half = ((0.5 * vertical_fov).tan() * aspect).atan();
        extent / half.sin()
    }

    /// The cameras, named `orbit_0000` and so on.
    pub fn cameras(&self) -> Vec<Camera> {
        let right = self.up.any_orthonormal_vector();
        let axes = DMat3::from_cols(right, self.up.cross(right), self.up);
        (0..self.views)
            .map(|idx| {
                let angle = std::f64::consts::TAU * idx as f64 / self.views as f64;
                let (sin, cos) = angle.sin_cos();
                let (rise, flat) = self.elevation.sin_cos();
                let offset = axes * DVec3::new(flat * cos, flat * sin, rise) * self.radius;
                let centre = self.centre + offset;
                let (fov, size) = (self.vertical_fov, self.size);
                let mut camera = Camera::looking_at(centre, self.centre, self.up, fov, size);
                camera.name = format!("orbit_{idx:04}");
                camera
            })
            .collect()
    }
}
