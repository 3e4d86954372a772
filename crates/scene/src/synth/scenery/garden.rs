//! A table on a lawn among bushes and trees, far to the horizon, as bicycle, garden and stump.

use glam::DVec3;
use rand_pcg::Pcg64Mcg;

use super::super::layout::{Builder, LayoutKind, LayoutPart};
use super::super::shape::SynthShape;
use super::super::texture::{Look, Pattern};
use super::{between, bush, floaters, paint, sky, tree};

/// The garden.
pub(in super::super) fn parts(rng: &mut Pcg64Mcg) -> Vec<LayoutPart> {
    let mut builder = Builder::default();
    table(&mut builder, rng);
    builder.focus(0.09);
    let from = builder.parts.len();
    let soil = Look::matt([0.30, 0.24, 0.16], [0.36, 0.40, 0.18], Pattern::Noise, 0.6);
    let ground = SynthShape::Ground { centre: DVec3::ZERO, core: 2.2, radius: 80.0 };
    builder.surface(ground, soil, 1.0);
    builder.share(from, 0.11);
    let lawn = Look::matt([0.14, 0.28, 0.06], [0.46, 0.52, 0.18], Pattern::Noise, 0.4);
    let (core, radius, height, layers) = (2.2, 40.0, 0.12, 1.5);
    let grass = SynthShape::Grass { centre: DVec3::ZERO, core, radius, height, layers };
    builder.other(grass, lawn, LayoutKind::Foliage, 0.19, 0.46);
    let from = builder.parts.len();
    plants(&mut builder, rng);
    builder.share(from, 0.50);
    sky(&mut builder, 150.0, 0.09);
    floaters(&mut builder, DVec3::new(0.0, 0.0, 1.5), 6.0, 0.02);
    builder.parts
}

fn table(builder: &mut Builder, rng: &mut Pcg64Mcg) {
    let wood = Look::matt([0.46, 0.34, 0.22], [0.62, 0.50, 0.36], Pattern::Planks, 0.12);
    let top = SynthShape::Cylinder {
        base: DVec3::new(0.0, 0.0, 0.7),
        axis: DVec3::Z,
        radius: 0.65,
        height: 0.05,
    };
    builder.surface(top, wood, 1.2);
    let steel = Look::plastic([0.25, 0.26, 0.28]);
    for idx in 0..4 {
        let angle = std::f64::consts::FRAC_PI_2 * f64::from(idx) + 0.4;
        let base = DVec3::new(0.45 * angle.cos(), 0.45 * angle.sin(), 0.0);
        builder.surface(
            SynthShape::Cylinder { base, axis: DVec3::Z, radius: 0.035, height: 0.7 },
            steel,
            1.5,
        );
    }
    let vase = SynthShape::Cylinder {
        base: DVec3::new(0.0, 0.0, 0.75),
        axis: DVec3::Z,
        radius: 0.1,
        height: 0.24,
    };
    builder.surface(vase, Look::plastic(paint(rng)), 1.8);
    for _ in 0..5 {
        let offset = DVec3::new(between(rng, -0.1, 0.1), between(rng, -0.1, 0.1), 1.1);
        bush(builder, offset, DVec3::splat(between(rng, 0.08, 0.14)), 0.12);
    }
}

/// Bushes and trees; what is nearer gets more Gaussians, as it does in training.
fn plants(builder: &mut Builder, rng: &mut Pcg64Mcg) {
    for idx in 0..26 {
        let angle = 0.2417 * f64::from(idx) + between(rng, -0.1, 0.1);
        let far = between(rng, 5.0, 11.0);
        let size = between(rng, 0.5, 1.3);
        let centre = DVec3::new(far * angle.cos(), far * angle.sin(), 0.6 * size);
        let radius = DVec3::new(size, size, 0.8 * size);
        bush(builder, centre, radius, 1.0 / (far * far));
    }
    for idx in 0..30 {
        let angle = 0.2094 * f64::from(idx) + between(rng, -0.1, 0.1);
        let far = between(rng, 9.0, 38.0);
        let foot = DVec3::new(far * angle.cos(), far * angle.sin(), 0.0);
        let height = between(rng, 4.0, 10.0);
        tree(builder, rng, foot, height, 1.0 / (far * far));
    }
}
