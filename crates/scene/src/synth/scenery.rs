//! The building blocks of the presets.

pub(super) mod city;
pub(super) mod garden;
pub(super) mod room;
pub(super) mod street;
pub(super) mod toy;

use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::layout::{Builder, LayoutKind};
use super::shape::SynthShape;
use super::texture::{Look, Pattern};

/// An even draw from `low` to `high`.
fn between(rng: &mut Pcg64Mcg, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// A lively colour.
fn paint(rng: &mut Pcg64Mcg) -> [f32; 3] {
    const COLOURS: [[f32; 3]; 8] = [
        [0.86, 0.16, 0.12],
        [0.95, 0.72, 0.10],
        [0.12, 0.35, 0.70],
        [0.15, 0.50, 0.22],
        [0.88, 0.86, 0.80],
        [0.22, 0.22, 0.25],
        [0.90, 0.45, 0.12],
        [0.55, 0.36, 0.22],
    ];
    COLOURS[rng.random_range(0..COLOURS.len())]
}

fn leaves() -> Look {
    Look::matt([0.10, 0.22, 0.05], [0.42, 0.52, 0.16], Pattern::Noise, 0.25)
}

/// A tree: a trunk and a crown of overlapping balls of leaves.
fn tree(builder: &mut Builder, rng: &mut Pcg64Mcg, foot: DVec3, height: f64, detail: f64) {
    let bark = Look::matt([0.25, 0.18, 0.12], [0.42, 0.33, 0.25], Pattern::Noise, 0.2);
    let radius = 0.03 * height;
    let trunk = SynthShape::Cylinder { base: foot, axis: DVec3::Z, radius, height: 0.5 * height };
    builder.surface(trunk, bark, detail);
    for _ in 0..5 {
        let spread = 0.22 * height;
        let offset = DVec3::new(
            between(rng, -spread, spread),
            between(rng, -spread, spread),
            between(rng, 0.5, 0.9) * height,
        );
        let radius = DVec3::splat(between(rng, 0.12, 0.22) * height);
        bush(builder, foot + offset, radius, detail);
    }
}

/// A ball of leaves.
fn bush(builder: &mut Builder, centre: DVec3, radius: DVec3, detail: f64) {
    let crown = SynthShape::Crown { centre, radius, layers: 3.0 };
    builder.other(crown, leaves(), LayoutKind::Foliage, crown.area() * detail, 0.4);
}

fn sky(builder: &mut Builder, radius: f64, weight: f64) {
    let look = Look::matt([0.74, 0.80, 0.86], [0.36, 0.55, 0.85], Pattern::Sky, 0.3 * radius);
    builder.other(
        SynthShape::Sky { centre: DVec3::ZERO, radius },
        look,
        LayoutKind::Shell,
        weight,
        1.3,
    );
}

fn floaters(builder: &mut Builder, centre: DVec3, radius: f64, weight: f64) {
    let look = Look::matt([0.4, 0.4, 0.4], [0.6, 0.6, 0.55], Pattern::Noise, radius);
    builder.other(SynthShape::Cloud { centre, radius }, look, LayoutKind::Floaters, weight, 0.12);
}
