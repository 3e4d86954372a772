//! Blocks of houses along streets, seen from above: what a level of detail leaves of a city, so
//! that what is farther away has fewer and larger Gaussians.

use glam::DVec3;
use rand_pcg::Pcg64Mcg;

use super::super::layout::{Builder, LayoutPart};
use super::super::shape::SynthShape;
use super::super::texture::{Look, Pattern};
use super::{between, floaters, paint, sky, tree};

/// Blocks on a side, odd so that one is in the middle.
const BLOCKS: i32 = 9;
/// From the middle of a block to that of the next, metres.
const PITCH: f64 = 44.0;
/// The width of a street with its pavements, metres.
const STREET: f64 = 14.0;
/// The distance at which a cut has a third of the detail, metres.
const CORE: f64 = 70.0;

/// The city.
pub(in super::super) fn parts(rng: &mut Pcg64Mcg) -> Vec<LayoutPart> {
    let mut builder = Builder::default();
    for x in -BLOCKS / 2..=BLOCKS / 2 {
        for y in -BLOCKS / 2..=BLOCKS / 2 {
            block(&mut builder, rng, DVec3::new(f64::from(x), f64::from(y), 0.0) * PITCH);
        }
    }
    builder.focus(0.52);
    let from = builder.parts.len();
    let asphalt = Look::matt([0.30, 0.30, 0.31], [0.46, 0.45, 0.43], Pattern::Noise, 0.8);
    let ground = SynthShape::Ground { centre: DVec3::ZERO, core: CORE, radius: 600.0 };
    builder.surface(ground, asphalt, 1.0);
    builder.share(from, 0.19);
    let from = builder.parts.len();
    for _ in 0..120 {
        let edge = PITCH * f64::from(BLOCKS) * 0.5;
        let (x, y) = (between(rng, -edge, edge), between(rng, -edge, edge));
        // On the pavement of the nearest street.
        let x = ((x / PITCH - 0.5).round() + 0.5) * PITCH + 0.4 * STREET;
        let foot = DVec3::new(x, y, 0.0);
        let height = between(rng, 6.0, 12.0);
        tree(&mut builder, rng, foot, height, detail(foot));
    }
    builder.share(from, 0.20);
    sky(&mut builder, 900.0, 0.06);
    floaters(&mut builder, DVec3::new(0.0, 0.0, 25.0), 60.0, 0.03);
    builder.parts
}

/// The share of Gaussians that a cut keeps per area.
fn detail(at: DVec3) -> f64 {
    (1.0 + at.length_squared() / (CORE * CORE)).powf(-1.5)
}

/// Houses around a court, and cars on the street before them.
fn block(builder: &mut Builder, rng: &mut Pcg64Mcg, centre: DVec3) {
    let side = PITCH - STREET;
    let lot = side / 2.0;
    for (x, y) in [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)] {
        let base = centre + DVec3::new(x, y, 0.0) * lot;
        let height = between(rng, 6.0, 26.0);
        let size = DVec3::new(between(rng, 0.7, 1.0) * lot, between(rng, 0.7, 1.0) * lot, height);
        let colour = paint(rng);
        let [wall, joint] = [0.3, 0.2].map(|share| colour.map(|c| share * c + 0.4));
        let wall = Look::matt(wall, joint, Pattern::Bricks, 1.5);
        let roof = Look::matt([0.34, 0.25, 0.22], [0.50, 0.44, 0.40], Pattern::Planks, 1.2);
        builder.block(base, size, 0.0, wall, detail(base));
        let eaves = DVec3::new(size.x + 0.8, size.y + 0.8, 0.6);
        builder.block(base + DVec3::Z * height, eaves, 0.0, roof, detail(base));
    }
    for _ in 0..5 {
        let along = between(rng, -0.5, 0.5) * side;
        let base = centre + DVec3::new(along, -0.5 * side - 3.0, 0.2);
        let look = Look::plastic(paint(rng));
        builder.block(base, DVec3::new(4.2, 1.8, 1.4), 0.0, look, 2.0 * detail(base));
    }
}
