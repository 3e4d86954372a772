//! Runs, which test sixteen splats at a time, against the tests of one.

use powergs_frame::splat::runs::{Run, Runs};
use powergs_frame::splat::{Cover, Intersection, Splat, TileGrid};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// What covariances and means may be in a file that nobody checked.
const ODD: [f32; 14] = [
    0.0,
    -0.0,
    1.0,
    -7.5,
    1e-45,
    1e-20,
    2e19,
    -2e19,
    1e30,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

fn splat(mean: [f32; 2], cov: [f32; 3]) -> Splat {
    Splat { index: 0, depth: 1.0, mean, cov, opacity: 0.5 }
}

/// A covariance with these standard deviations at an angle.
fn turned(size: [f32; 2], angle: f32) -> [f32; 3] {
    let ([u, v], (s, c)) = (size.map(|s| s * s), angle.sin_cos());
    [u * c * c + v * s * s, (u - v) * s * c, u * s * s + v * c * c]
}

fn splats(random: &mut impl Rng) -> Vec<Splat> {
    let mut splats = Vec::new();
    for i in 0..3000 {
        let mean = [random.random_range(-40.0..260.0), random.random_range(-40.0..160.0)];
        let size = [0, 1].map(|_| random.random_range(-3.0f32..4.5).exp());
        let angle = match i % 8 {
            0 => 0.0,
            1 => std::f32::consts::FRAC_PI_2,
            _ => random.random_range(-4.0..4.0),
        };
        let size = if i % 11 == 0 { [size[0]; 2] } else { size };
        splats.push(splat(mean, turned(size, angle)));
    }
    for _ in 0..20_000 {
        let mut odd = || ODD[random.random_range(0..ODD.len())];
        let (mean, cov) = ([odd(), odd()], [odd(), odd(), odd()]);
        let usual = [random.random_range(0.0..200.0), random.random_range(0.0..120.0)];
        let mean = if random.random() { mean } else { usual };
        splats.push(splat(mean, cov));
    }
    splats
}

#[test]
fn runs_are_the_tiles_of_single_splats() {
    let splats = splats(&mut Pcg64Mcg::seed_from_u64(5));
    let grids = [TileGrid::new(203, 117, 16), TileGrid::new(640, 33, 8), TileGrid::new(5, 5, 64)];
    for grid in grids {
        for test in [Intersection::Obb, Intersection::Aabb, Intersection::Ellipse] {
            let mut expected = vec![Vec::new(); grid.ny as usize];
            let mut touches = Vec::new();
            for (rank, splat) in (0..).zip(&splats) {
                let cover = Cover::new(splat, grid, test);
                let before = touches.len();
                touches.push((cover.tests() as u32, 0));
                for row in cover.rows() {
                    touches[before].1 += row.x1 - row.x0;
                    let (x0, x1) = (row.x0 as u16, row.x1 as u16);
                    expected[row.y as usize].push(Run { rank, x0, x1 });
                }
            }
            let runs = Runs::new(&splats, grid, test);
            for (y, expected) in (0..).zip(&expected) {
                let differs = runs.row(y).zip(expected).find(|(a, b)| a != b);
                let splat = differs.map(|(a, b)| splats[a.rank.min(b.rank) as usize]);
                let place = format!("row {y} of {grid:?}, {test:?}");
                assert!(runs.row(y).eq(expected), "{place}: {differs:?}, {splat:?}");
            }
            let found = runs.touches.iter().map(|touch| (touch.tests, touch.tiles));
            assert!(found.eq(touches.iter().copied()), "{grid:?}, {test:?}");
            assert!(touches.iter().filter(|(_, tiles)| *tiles > 0).count() > 300);
        }
    }
}
