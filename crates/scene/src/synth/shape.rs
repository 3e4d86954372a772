//! Where the Gaussians of a part are, and how densely.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use rand::RngExt;
use rand_distr::{Distribution, UnitSphere};
use rand_pcg::Pcg64Mcg;

/// A shape, in world units; z is up.
#[derive(Debug, Clone, Copy)]
pub(super) enum SynthShape {
    /// The six faces of an upright box, turned around z by `yaw` (radians).
    Block { centre: DVec3, half: DVec3, yaw: f64 },
    /// A cylinder with both caps, from `base` along the unit vector `axis`.
    Cylinder { base: DVec3, axis: DVec3, radius: f64, height: f64 },
    /// A ball's surface.
    Ball { centre: DVec3, radius: f64 },
    /// Flat ground around `centre` with a density that falls as `(1 + (r / core)²)^-3/2`, as the
    /// pixels of a view from some height per area of ground do.
    Ground { centre: DVec3, core: f64, radius: f64 },
    /// Blades on such a ground, up to `height` above it; `layers` blades deep.
    Grass { centre: DVec3, core: f64, radius: f64, height: f64, layers: f64 },
    /// Leaves in a ball, mostly in its outer half, `layers` deep.
    Crown { centre: DVec3, radius: DVec3, layers: f64 },
    /// The upper part of a sphere, seen from inside.
    Sky { centre: DVec3, radius: f64 },
    /// Anywhere in a ball.
    Cloud { centre: DVec3, radius: f64 },
}

/// A point of a shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShapeSample {
    /// Position.
    pub position: DVec3,
    /// Unit normal of the surface.
    pub normal: DVec3,
    /// The direction of the longest axis, where the shape has one.
    pub along: Option<DVec3>,
    /// Probability density per unit of area at this point (total 1).
    pub density: f64,
}

impl SynthShape {
    /// Area that Gaussians are spread over.
    pub(crate) fn area(&self) -> f64 {
        match *self {
            SynthShape::Block { half: h, .. } => 8.0 * (h.x * h.y + h.y * h.z + h.z * h.x),
            SynthShape::Cylinder { radius, height, .. } => TAU * radius * (radius + height),
            SynthShape::Ball { radius, .. } => 2.0 * TAU * radius * radius,
            SynthShape::Ground { core, radius, .. } => ground_area(core, radius),
            SynthShape::Grass { core, radius, layers, .. } => layers * ground_area(core, radius),
            SynthShape::Crown { radius, layers, .. } => {
                layers * 2.0 * TAU * (radius.x * radius.y * radius.z).powf(2.0 / 3.0)
            }
            SynthShape::Sky { radius, .. } => TAU * radius * radius * (1.0 - SKY_LOWEST),
            SynthShape::Cloud { radius, .. } => 2.0 * TAU * radius * radius,
        }
    }

    /// Draws a point.
    pub(crate) fn sample(&self, rng: &mut Pcg64Mcg) -> ShapeSample {
        let even = 1.0 / self.area();
        let at = |position, normal| ShapeSample { position, normal, along: None, density: even };
        match *self {
            SynthShape::Block { centre, half, yaw } => {
                let (point, normal) = block_point(half, rng);
                let turn = DQuat::from_rotation_z(yaw);
                at(centre + turn * point, turn * normal)
            }
            SynthShape::Cylinder { base, axis, radius, height } => {
                let (point, normal) = cylinder_point(radius, height, rng);
                let turn = DQuat::from_rotation_arc(DVec3::Z, axis);
                at(base + turn * point, turn * normal)
            }
            SynthShape::Ball { centre, radius } => {
                let normal = direction(rng);
                at(centre + normal * radius, normal)
            }
            SynthShape::Ground { centre, core, radius } => {
                let (offset, density) = ground_point(core, radius, rng);
                ShapeSample { density, ..at(centre + offset, DVec3::Z) }
            }
            SynthShape::Grass { centre, core, radius, height, layers } => {
                let (offset, density) = ground_point(core, radius, rng);
                let rise = height * rng.random::<f64>().powi(2);
                let lean = direction(rng) * 0.45;
                let along = (DVec3::Z + lean).normalize();
                let normal = along.cross(direction(rng)).normalize_or(DVec3::X);
                let position = centre + offset + DVec3::Z * rise;
                ShapeSample { position, normal, along: Some(along), density: density / layers }
            }
            SynthShape::Crown { centre, radius, .. } => {
                let depth = rng.random::<f64>().powf(0.25);
                at(centre + direction(rng) * depth * radius, direction(rng))
            }
            SynthShape::Sky { centre, radius } => {
                let z = SKY_LOWEST + (1.0 - SKY_LOWEST) * rng.random::<f64>();
                let angle = TAU * rng.random::<f64>();
                let flat = (1.0 - z * z).sqrt();
                let out = DVec3::new(flat * angle.cos(), flat * angle.sin(), z);
                at(centre + out * radius * (0.85 + 0.3 * rng.random::<f64>()), -out)
            }
            SynthShape::Cloud { centre, radius } => {
                let depth = rng.random::<f64>().cbrt();
                at(centre + direction(rng) * depth * radius, direction(rng))
            }
        }
    }
}

/// Sine of the lowest elevation of the sky shell.
const SKY_LOWEST: f64 = -0.08;

fn direction(rng: &mut Pcg64Mcg) -> DVec3 {
    DVec3::from_array(UnitSphere.sample(rng))
}

/// The area that ground of even density would need to be as dense as ours is in the middle.
fn ground_area(core: f64, radius: f64) -> f64 {
    TAU * core * core * ground_mass(core, radius)
}

/// The integral of `x (1 + x²)^-3/2` up to `radius / core`.
fn ground_mass(core: f64, radius: f64) -> f64 {
    1.0 - 1.0 / 1f64.hypot(radius / core)
}

/// Inverts the distribution of the radius.
fn ground_point(core: f64, radius: f64, rng: &mut Pcg64Mcg) -> (DVec3, f64) {
    let stretch = 1.0 / (1.0 - rng.random::<f64>() * ground_mass(core, radius));
    let r = core * (stretch * stretch - 1.0).max(0.0).sqrt();
    let angle = TAU * rng.random::<f64>();
    let density = 1.0 / (ground_area(core, radius) * stretch.powi(3));
    (DVec3::new(r * angle.cos(), r * angle.sin(), 0.0), density)
}

fn block_point(half: DVec3, rng: &mut Pcg64Mcg) -> (DVec3, DVec3) {
    let areas = [half.y * half.z, half.z * half.x, half.x * half.y];
    let at = rng.random::<f64>() * (areas[0] + areas[1] + areas[2]);
    let axis = if at < areas[0] { 0 } else { 1 + usize::from(at >= areas[0] + areas[1]) };
    let mut point =
        half * DVec3::from_array(std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0));
    let mut normal = DVec3::ZERO;
    normal[axis] = if rng.random() { 1.0 } else { -1.0 };
    point[axis] = normal[axis] * half[axis];
    (point, normal)
}

fn cylinder_point(radius: f64, height: f64, rng: &mut Pcg64Mcg) -> (DVec3, DVec3) {
    let angle = TAU * rng.random::<f64>();
    let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
    if rng.random::<f64>() * (radius + height) < height {
        return (out * radius + DVec3::Z * height * rng.random::<f64>(), out);
    }
    let within = out * radius * rng.random::<f64>().sqrt();
    if rng.random() { (within + DVec3::Z * height, DVec3::Z) } else { (within, DVec3::NEG_Z) }
}
