//! A truck on a yard among houses and trees, as Train and Truck.

use glam::DVec3;
use rand_pcg::Pcg64Mcg;

use super::super::layout::{Builder, LayoutPart};
use super::super::shape::SynthShape;
use super::super::texture::{Look, Pattern};
use super::{between, floaters, paint, sky, tree};

/// The yard.
pub(in super::super) fn parts(rng: &mut Pcg64Mcg) -> Vec<LayoutPart> {
    let mut builder = Builder::default();
    truck(&mut builder, rng);
    builder.focus(0.14);
    let from = builder.parts.len();
    let gravel = Look::matt([0.42, 0.40, 0.37], [0.58, 0.56, 0.52], Pattern::Noise, 0.3);
    let ground = SynthShape::Ground { centre: DVec3::ZERO, core: 5.0, radius: 45.0 };
    builder.surface(ground, gravel, 1.0);
    builder.share(from, 0.15);
    let from = builder.parts.len();
    houses(&mut builder, rng);
    builder.share(from, 0.28);
    let from = builder.parts.len();
    for idx in 0..14 {
        let angle = 0.45 * f64::from(idx) + between(rng, -0.15, 0.15);
        let far = between(rng, 12.0, 26.0);
        let foot = DVec3::new(far * angle.cos(), far * angle.sin(), 0.0);
        let height = between(rng, 5.0, 9.0);
        tree(&mut builder, rng, foot, height, 1.0 / (far * far));
    }
    builder.share(from, 0.31);
    sky(&mut builder, 90.0, 0.09);
    floaters(&mut builder, DVec3::new(0.0, 0.0, 2.5), 8.0, 0.03);
    builder.parts
}

fn truck(builder: &mut Builder, rng: &mut Pcg64Mcg) {
    let body = Look { gloss: 0.5, ..Look::plastic([0.20, 0.38, 0.55]) };
    let steel = Look::matt([0.30, 0.30, 0.32], [0.44, 0.40, 0.36], Pattern::Noise, 0.25);
    let wood = Look::matt([0.48, 0.36, 0.24], [0.62, 0.50, 0.36], Pattern::Planks, 0.2);
    let mut block = |base: [f64; 3], size: [f64; 3], look, detail| {
        builder.block(DVec3::from_array(base), DVec3::from_array(size), 0.0, look, detail);
    };
    block([0.0, 0.0, 0.55], [5.6, 1.9, 0.18], steel, 1.0);
    block([1.8, 0.0, 0.7], [1.5, 2.0, 1.5], body, 1.4);
    block([2.9, 0.0, 0.7], [0.8, 1.8, 0.8], body, 1.4);
    block([-1.1, 0.0, 0.75], [3.6, 2.1, 0.1], wood, 1.0);
    for side in [-1.0, 1.0] {
        block([-1.1, side, 0.85], [3.6, 0.06, 0.6], wood, 1.2);
    }
    for x in [-2.0, -1.0, 2.4] {
        for side in [-1.05, 0.8] {
            let base = DVec3::new(x, side, 0.45);
            let shape = SynthShape::Cylinder { base, axis: DVec3::Y, radius: 0.45, height: 0.25 };
            builder.surface(shape, steel, 1.6);
        }
    }
    for _ in 0..60 {
        let base = DVec3::new(between(rng, -2.7, 0.5), between(rng, -0.85, 0.85), 0.85);
        let size =
            DVec3::new(between(rng, 0.1, 0.5), between(rng, 0.1, 0.4), between(rng, 0.1, 0.7));
        let colour = paint(rng);
        let look = Look::matt(colour, colour.map(|c| 0.6 * c), Pattern::Noise, 0.15);
        builder.block(base, size, between(rng, 0.0, 3.0), look, 0.4);
    }
}

/// Houses around the yard, at distances at which a view sees several.
fn houses(builder: &mut Builder, rng: &mut Pcg64Mcg) {
    for idx in 0..11 {
        let angle = 0.57 * f64::from(idx) + between(rng, -0.1, 0.1);
        let far = between(rng, 14.0, 24.0);
        let base = DVec3::new(far * angle.cos(), far * angle.sin(), 0.0);
        let size =
            DVec3::new(between(rng, 4.0, 8.0), between(rng, 4.0, 7.0), between(rng, 3.0, 7.0));
        let wall = Look::matt([0.58, 0.36, 0.28], [0.78, 0.74, 0.68], Pattern::Bricks, 0.5);
        let roof = Look::matt([0.32, 0.22, 0.20], [0.42, 0.30, 0.26], Pattern::Planks, 0.4);
        builder.block(base, size, angle, wall, 1.0 / (far * far));
        let top = base + DVec3::Z * size.z;
        let eaves = DVec3::new(size.x + 0.6, size.y + 0.6, 0.5);
        builder.block(top, eaves, angle, roof, 1.0 / (far * far));
    }
}
