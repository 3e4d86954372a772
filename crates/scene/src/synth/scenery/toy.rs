//! A digger of plastic bricks on a studded plate, as the Lego scene of the Blender set.

use glam::DVec3;
use rand_pcg::Pcg64Mcg;

use super::super::layout::{Builder, LayoutPart};
use super::super::shape::SynthShape;
use super::super::texture::{Look, Pattern};
use super::{between, floaters, paint};

/// The plate.
const GREEN: [f32; 3] = [0.30, 0.48, 0.22];

/// The toy alone, before black.
pub(in super::super) fn parts(rng: &mut Pcg64Mcg) -> Vec<LayoutPart> {
    let mut builder = Builder::default();
    digger(&mut builder);
    studs(&mut builder);
    bricks(&mut builder, rng, 120, 1.0);
    builder.focus(1.0);
    floaters(&mut builder, DVec3::new(0.0, 0.0, 0.3), 1.0, 0.004);
    builder.parts
}

/// The toy on a table in front of a wall of colour: small, with a background.
pub(in super::super) fn on_a_table(rng: &mut Pcg64Mcg) -> Vec<LayoutPart> {
    let mut builder = Builder::default();
    digger(&mut builder);
    bricks(&mut builder, rng, 16, 1.8);
    builder.focus(0.70);
    let board = Look::matt([0.52, 0.34, 0.20], [0.70, 0.52, 0.34], Pattern::Planks, 0.35);
    let table = SynthShape::Ground { centre: DVec3::new(0.0, 0.0, -0.06), core: 1.2, radius: 5.0 };
    let from = builder.parts.len();
    builder.surface(table, board, 1.0);
    builder.share(from, 0.20);
    super::sky(&mut builder, 12.0, 0.095);
    floaters(&mut builder, DVec3::new(0.0, 0.0, 0.3), 1.2, 0.005);
    builder.parts
}

fn digger(builder: &mut Builder) {
    let yellow = Look::plastic([0.93, 0.68, 0.08]);
    let grey = Look::plastic([0.30, 0.31, 0.33]);
    let green = Look::plastic(GREEN);
    let block = |builder: &mut Builder, base: [f64; 3], size: [f64; 3], look, detail| {
        builder.block(DVec3::from_array(base), DVec3::from_array(size), 0.0, look, detail);
    };
    block(builder, [0.0, 0.0, -0.06], [1.7, 1.1, 0.06], green, 0.7);
    for side in [-0.32, 0.32] {
        block(builder, [0.0, side, 0.05], [1.0, 0.18, 0.10], grey, 1.5);
        for wheel in 0..6 {
            let base = DVec3::new(-0.42 + 0.168 * f64::from(wheel), side - 0.10, 0.11);
            let shape = SynthShape::Cylinder { base, axis: DVec3::Y, radius: 0.085, height: 0.2 };
            builder.surface(shape, grey, 1.8);
        }
    }
    block(builder, [0.0, 0.0, 0.18], [0.8, 0.5, 0.14], yellow, 1.4);
    block(builder, [-0.2, 0.0, 0.32], [0.34, 0.4, 0.34], yellow, 1.4);
    block(builder, [-0.2, 0.0, 0.66], [0.40, 0.46, 0.05], grey, 1.4);
    block(builder, [0.66, 0.0, 0.06], [0.06, 0.9, 0.34], yellow, 1.4);
    for side in [-0.2, 0.2] {
        block(builder, [0.48, side, 0.22], [0.34, 0.05, 0.06], grey, 1.6);
        let base = DVec3::new(-0.62, side, 0.28);
        let axis = DVec3::new(-0.35, 0.0, 0.93).normalize();
        builder.surface(SynthShape::Cylinder { base, axis, radius: 0.03, height: 0.5 }, grey, 1.8);
    }
}

/// The studs of the plate.
fn studs(builder: &mut Builder) {
    for ix in 0..16 {
        for iy in 0..10 {
            let (x, y) = (0.1066 * f64::from(ix), 0.109 * f64::from(iy));
            stud(builder, DVec3::new(x - 0.8, y - 0.49, 0.0), 0.032, Look::plastic(GREEN));
        }
    }
}

/// Small bricks with a stud each, wherever they landed on the machine.
fn bricks(builder: &mut Builder, rng: &mut Pcg64Mcg, count: usize, scale: f64) {
    for _ in 0..count {
        let size = DVec3::new(between(rng, 0.04, 0.16), between(rng, 0.04, 0.1), 0.04) * scale;
        let x = between(rng, -0.6, 0.6);
        let z = if x < 0.0 { between(rng, 0.30, 0.74) } else { between(rng, 0.12, 0.34) };
        let base = DVec3::new(x, between(rng, -0.3, 0.3), z);
        let look = Look::plastic(paint(rng));
        builder.block(base, size, between(rng, 0.0, 0.4), look, 1.3);
        stud(builder, base + DVec3::Z * size.z, 0.022, look);
    }
}

fn stud(builder: &mut Builder, base: DVec3, radius: f64, look: Look) {
    builder.surface(
        SynthShape::Cylinder { base, axis: DVec3::Z, radius, height: 0.8 * radius },
        look,
        1.5,
    );
}
