//! Seeded scenes that behave like trained ones: for tests, for the committed trace, and for
//! whoever has no trained model at hand.
//!
//! A scene is a `Layout`: parts with a shape, a look and a share of the Gaussians. A Gaussian
//! draws its part, then a point on the part's surface, and becomes a flat ellipsoid whose size
//! follows from how densely the part is sampled there, as training arranges it. The order of the
//! Gaussians is random in space, as that of trained models is, so that their DRAM addresses say
//! nothing about where they are.
//!
//! Presets are files, `arch-configs/synth/*.toml`; `docs/synth.md` says which published statistics
//! each aims at, and how near it comes.

mod gaussian;
mod layout;
pub mod preset;
mod scenery;
mod shape;
mod texture;

use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::camera::Camera;
use super::{Gaussians, Split};
use gaussian::{COEFFICIENTS, Gaussian};
use layout::Layout;
pub use preset::{Preset, Statistic, Target, presets};

/// Gaussians made from one seed; fixed, so that threads do not matter.
const PART: usize = 4096;
/// Every how many-th view is held out, as in the published evaluations.
const HELD_OUT: usize = 8;
/// SH degree of every synthetic scene.
const SH_DEGREE: u8 = 3;

/// A scene of `points` Gaussians that looks as `preset` does. The same `seed` gives the same scene
/// on any number of threads; with other `points` the same layout is covered by larger or smaller
/// Gaussians.
pub fn generate(preset: &Preset, points: usize, seed: u64) -> Gaussians {
    let layout = Layout::new(preset, points, seed);
    let mut scene = Gaussians {
        means: vec![[0.0; 3]; points],
        log_scales: vec![[0.0; 3]; points],
        rotations: vec![[0.0; 4]; points],
        logit_opacities: vec![0.0; points],
        sh_degree: SH_DEGREE,
        sh: vec![0.0; points * COEFFICIENTS],
        antialiased: false,
    };
    let geometry = scene.means.par_chunks_mut(PART).zip(scene.log_scales.par_chunks_mut(PART));
    let look = scene
        .logit_opacities
        .par_chunks_mut(PART)
        .zip(scene.sh.par_chunks_mut(PART * COEFFICIENTS));
    let parts = geometry.zip(scene.rotations.par_chunks_mut(PART)).zip(look);
    parts.enumerate().for_each(|(idx, (((means, scales), rotations), (opacities, sh)))| {
        let mut rng = generator(seed, idx as u64 + 1);
        for i in 0..means.len() {
            let gaussian = Gaussian::draw(&layout, &mut rng);
            means[i] = gaussian.mean;
            scales[i] = gaussian.log_scale;
            rotations[i] = gaussian.rotation;
            opacities[i] = gaussian.logit_opacity;
            sh[i * COEFFICIENTS..(i + 1) * COEFFICIENTS].copy_from_slice(&gaussian.sh);
        }
    });
    scene
}

/// The views of `preset`: every eighth is held out.
pub fn cameras(preset: &Preset) -> Vec<Camera> {
    let mut cameras = preset.rig.cameras(preset.size());
    for (idx, camera) in cameras.iter_mut().enumerate() {
        camera.name = format!("view_{idx:03}");
        camera.split = Some(if idx % HELD_OUT == 0 { Split::Test } else { Split::Train });
    }
    cameras
}

/// Stream `stream` of `seed`. The finaliser of SplitMix64 makes neighbouring streams unrelated.
fn generator(seed: u64, stream: u64) -> Pcg64Mcg {
    let mut z = seed.wrapping_add(stream.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    Pcg64Mcg::seed_from_u64(z ^ (z >> 31))
}
