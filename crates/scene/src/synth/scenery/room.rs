//! A room with a table full of things in its middle, as counter, room and bonsai.

use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

use super::super::layout::{Builder, LayoutPart};
use super::super::shape::SynthShape;
use super::super::texture::{Look, Pattern};
use super::{between, bush, floaters, paint};

/// Height of the table, metres.
const TABLE: f64 = 0.74;

/// The room.
pub(in super::super) fn parts(rng: &mut Pcg64Mcg) -> Vec<LayoutPart> {
    let mut builder = Builder::default();
    table(&mut builder, rng);
    builder.focus(0.53);
    let from = builder.parts.len();
    walls(&mut builder);
    builder.share(from, 0.29);
    let from = builder.parts.len();
    furniture(&mut builder, rng);
    builder.share(from, 0.16);
    floaters(&mut builder, DVec3::new(0.0, 0.0, 1.4), 2.4, 0.02);
    builder.parts
}

fn table(builder: &mut Builder, rng: &mut Pcg64Mcg) {
    let wood = Look::matt([0.45, 0.28, 0.16], [0.62, 0.44, 0.28], Pattern::Planks, 0.16);
    let size = DVec3::new(1.5, 1.0, 0.05);
    builder.block(DVec3::new(0.0, 0.0, TABLE - 0.05), size, 0.0, wood, 1.0);
    for (x, y) in [(-0.65, -0.4), (0.65, -0.4), (-0.65, 0.4), (0.65, 0.4)] {
        builder.block(DVec3::new(x, y, 0.0), DVec3::new(0.07, 0.07, 0.69), 0.0, wood, 0.6);
    }
    let pot = Look::matt([0.60, 0.32, 0.22], [0.45, 0.22, 0.15], Pattern::Noise, 0.05);
    let base = DVec3::new(0.0, 0.0, TABLE);
    builder.surface(
        SynthShape::Cylinder { base, axis: DVec3::Z, radius: 0.14, height: 0.12 },
        pot,
        1.5,
    );
    for _ in 0..7 {
        let offset = DVec3::new(
            between(rng, -0.18, 0.18),
            between(rng, -0.18, 0.18),
            between(rng, 0.2, 0.5),
        );
        bush(builder, base + offset, DVec3::splat(between(rng, 0.07, 0.13)), 1.0);
    }
    for _ in 0..28 {
        let foot = DVec3::new(between(rng, -0.66, 0.66), between(rng, -0.42, 0.42), TABLE);
        let look = Look { gloss: 0.5, ..thing(rng) };
        let (radius, height) = (between(rng, 0.02, 0.06), between(rng, 0.05, 0.2));
        let centre = foot + DVec3::Z * radius;
        match rng.random_range(0..3) {
            0 => builder.surface(SynthShape::Ball { centre, radius }, look, 1.5),
            1 => {
                let shape = SynthShape::Cylinder { base: foot, axis: DVec3::Z, radius, height };
                builder.surface(shape, look, 1.5);
            }
            _ => {
                let size = DVec3::new(2.0 * radius, 3.0 * radius, height);
                builder.block(foot, size, between(rng, 0.0, 3.0), look, 1.5);
            }
        }
    }
}

fn walls(builder: &mut Builder) {
    let floor = Look::matt([0.50, 0.40, 0.30], [0.66, 0.55, 0.42], Pattern::Planks, 0.15);
    let wall = Look::matt([0.80, 0.77, 0.70], [0.72, 0.68, 0.62], Pattern::Noise, 1.2);
    let brick = Look::matt([0.55, 0.30, 0.24], [0.75, 0.70, 0.64], Pattern::Bricks, 0.12);
    let centre = DVec3::new(0.0, 0.0, 0.0);
    builder.surface(SynthShape::Ground { centre, core: 2.0, radius: 3.2 }, floor, 1.0);
    builder.block(DVec3::new(0.0, 0.0, 2.7), DVec3::new(6.0, 5.0, 0.1), 0.0, wall, 0.25);
    for (x, look) in [(-3.0, wall), (3.0, brick)] {
        builder.block(DVec3::new(x, 0.0, 0.0), DVec3::new(0.1, 5.0, 2.7), 0.0, look, 0.4);
    }
    for (y, look) in [(-2.5, wall), (2.5, wall)] {
        builder.block(DVec3::new(0.0, y, 0.0), DVec3::new(6.0, 0.1, 2.7), 0.0, look, 0.4);
    }
}

/// Shelves with books along the walls, cupboards, a sofa, plants.
fn furniture(builder: &mut Builder, rng: &mut Pcg64Mcg) {
    let wood = Look::matt([0.36, 0.24, 0.15], [0.50, 0.36, 0.24], Pattern::Planks, 0.2);
    for y in [-2.25, 2.25] {
        for level in 0..4 {
            let z = 0.4 + 0.45 * f64::from(level);
            builder.block(DVec3::new(0.4, y, z), DVec3::new(2.4, 0.32, 0.03), 0.0, wood, 0.5);
            let mut x = -0.75;
            while x < 1.5 {
                let (thick, tall) = (between(rng, 0.02, 0.08), between(rng, 0.18, 0.34));
                let size = DVec3::new(thick, 0.22, tall);
                builder.block(DVec3::new(x, y, z + 0.03), size, 0.0, thing(rng), 0.7);
                x += thick + between(rng, 0.0, 0.06);
            }
        }
    }
    let cloth = Look::matt([0.25, 0.32, 0.42], [0.34, 0.42, 0.52], Pattern::Checker, 0.08);
    builder.block(DVec3::new(-2.4, 0.0, 0.0), DVec3::new(0.9, 2.0, 0.42), 0.0, cloth, 0.6);
    builder.block(DVec3::new(-2.8, 0.0, 0.4), DVec3::new(0.25, 2.0, 0.45), 0.0, cloth, 0.6);
    builder.block(DVec3::new(2.6, 1.0, 0.0), DVec3::new(0.6, 1.2, 0.9), 0.0, wood, 0.6);
    for (x, y) in [(2.4, -1.8), (-2.4, -1.9), (-2.5, 1.9)] {
        for _ in 0..4 {
            let offset = DVec3::new(between(rng, -0.2, 0.2), between(rng, -0.2, 0.2), 0.0);
            let centre = DVec3::new(x, y, between(rng, 0.6, 1.4)) + offset;
            bush(builder, centre, DVec3::splat(between(rng, 0.16, 0.3)), 0.5);
        }
    }
}

fn thing(rng: &mut Pcg64Mcg) -> Look {
    let colour = paint(rng);
    Look::matt(colour, colour.map(|c| 0.5 * c + 0.3), Pattern::Noise, 0.06)
}
