//! Small foveated models, and gazes at them.

use powergs_frame::fovea::{Screen, ScreenGaze};
use powergs_frame::scene::Gaussians;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A screen on which small pictures show all levels.
pub const EAGER: Screen = Screen { fov_deg: 100.0, pooling_rate: 0.4 };

pub fn gaze_at(gaze: [f32; 2]) -> ScreenGaze {
    ScreenGaze { point: gaze, screen: EAGER }
}

/// The four levels of a random model in front of a camera at the origin that looks along z: each
/// level keeps about `kept` of the one before, with other colours and opacities.
pub fn levels(seed: u64, points: usize, degree: u8, kept: f64) -> [Gaussians; 4] {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut base = Gaussians::with_capacity(points, degree);
    for _ in 0..points {
        let z = rng.random_range(2.0..6.0f32);
        base.means.push([rng.random_range(-1.1..1.1) * z, rng.random_range(-1.1..1.1) * z, z]);
        base.log_scales.push(std::array::from_fn(|_| rng.random_range(-4.5..-1.5)));
        base.rotations.push(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        base.logit_opacities.push(rng.random_range(-2.0..4.0));
        for _ in 0..base.sh_coefficients() * 3 {
            base.sh.push(rng.random_range(-0.8..0.8));
        }
    }
    let mut all = vec![base];
    for _ in 1..4 {
        let next = part(&mut rng, all.last().expect("a level"), kept);
        all.push(next);
    }
    all.try_into().expect("four levels")
}

fn part(rng: &mut Pcg64Mcg, from: &Gaussians, kept: f64) -> Gaussians {
    let mut out = Gaussians::with_capacity(from.len(), from.sh_degree);
    let n = from.sh_coefficients();
    for i in 0..from.len() {
        if i > 0 && !rng.random_bool(kept) {
            continue;
        }
        out.means.push(from.means[i]);
        out.log_scales.push(from.log_scales[i]);
        out.rotations.push(from.rotations[i]);
        out.logit_opacities.push(from.logit_opacities[i] + rng.random_range(-0.5..0.8));
        for channel in from.sh_of(i).chunks(n) {
            out.sh.push(channel[0] + rng.random_range(-0.3..0.3));
            out.sh.extend_from_slice(&channel[1..]);
        }
    }
    out
}
