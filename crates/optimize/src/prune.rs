//! Which Gaussians go, and what goes with them.
//!
//! The score of a Gaussian is the number of pixels in which it has the largest weight, divided by
//! the number of tiles that fetch it; of all training views the maximum counts. The lowest scores
//! go first (`powergs`, section 4.1). A pixel without any contribution is not counted. Many
//! Gaussians of a trained scene are nowhere the heaviest, and the publication does not say which of
//! them go first: here those that least is blended of, the sum of the weights of a view, the
//! maximum over the views. Ties are broken by index.

use rayon::prelude::*;

use super::adam::Adam;
use powergs_raster::{Canvas, Detail, Options};
use powergs_scene::{Camera, Gaussians};

/// Avoids a division by zero for a splat that no tile fetched; the published value.
const GUARD: f64 = 1e-7;
/// The score of what no view shows. Between it and zero is what is nowhere the heaviest.
const UNSEEN: f64 = -1.0;
/// Exponent of the volume term of LightGaussian's score.
const VOLUME_POWER: f64 = 0.1;
/// The share of Gaussians below the reference volume of that score.
const VOLUME_QUANTILE: f64 = 0.9;

/// How Gaussians are ranked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Score {
    /// Dominance per intersected tile, maximum over views (PowerGS, from MetaSapiens).
    Dominance,
    /// Hits times opacity times a power of the volume, sum over views (LightGaussian).
    LightGaussian,
}

impl Score {
    /// The score of every Gaussian over `views`; more is worth more. Views are worked on in
    /// parallel; the result does not depend on the number of threads.
    pub fn of(self, scene: &Gaussians, views: &[Camera]) -> Vec<f64> {
        match self {
            Score::Dominance => dominance(scene, views),
            Score::LightGaussian => light_gaussian(scene, views),
        }
    }
}

fn dominance(scene: &Gaussians, views: &[Camera]) -> Vec<f64> {
    let of_view = |canvas: &mut Canvas, camera: &Camera| {
        let rendered = canvas.render(scene, camera, &Options::reference(Detail::Dominance));
        let mut score = vec![UNSEEN; scene.len()];
        let counts = rendered.fetches.iter().zip(&rendered.dominance).zip(&rendered.weights);
        for (splat, ((&tiles, &pixels), &weight)) in rendered.splats.iter().zip(counts) {
            score[splat.index as usize] = match pixels {
                0 => UNSEEN / (1.0 + weight),
                _ => f64::from(pixels) / (f64::from(tiles) + GUARD),
            };
        }
        score
    };
    folded(scene.len(), UNSEEN, views, of_view, f64::max)
}

/// Hits are the pixels that a Gaussian is blended into, counted exactly. The published code adds
/// its opacity for each of them without a lock, so that its sums differ from run to run.
fn light_gaussian(scene: &Gaussians, views: &[Camera]) -> Vec<f64> {
    let of_view = |canvas: &mut Canvas, camera: &Camera| {
        let rendered = canvas.render(scene, camera, &Options::reference(Detail::Hits));
        let mut score = vec![0.0; scene.len()];
        for (splat, &pixels) in rendered.splats.iter().zip(&rendered.hits) {
            score[splat.index as usize] = f64::from(pixels) * f64::from(splat.opacity);
        }
        score
    };
    let mut score = folded(scene.len(), 0.0, views, of_view, |a, b| a + b);
    let volumes: Vec<f64> =
        scene.log_scales.iter().map(|s| s.iter().map(|&v| f64::from(v)).sum()).collect();
    let mut sorted = volumes.clone();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let at = ((VOLUME_QUANTILE * sorted.len() as f64) as usize).min(sorted.len().max(1) - 1);
    let reference = sorted.get(at).copied().unwrap_or(0.0);
    for (score, volume) in score.iter_mut().zip(volumes) {
        *score *= (VOLUME_POWER * (volume - reference)).exp();
    }
    score
}

/// Joins the scores of all views in their order; at most one score and one
/// canvas per thread are in memory.
fn folded(
    len: usize,
    start: f64,
    views: &[Camera],
    of_view: impl Fn(&mut Canvas, &Camera) -> Vec<f64> + Sync,
    join: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    let mut total = vec![start; len];
    let mut canvases = Vec::new();
    canvases.resize_with(rayon::current_num_threads().max(1), Canvas::new);
    for group in views.chunks(canvases.len()) {
        let scores: Vec<Vec<f64>> = canvases
            .par_iter_mut()
            .zip(group)
            .map(|(canvas, camera)| of_view(canvas, camera))
            .collect();
        for score in scores {
            total.iter_mut().zip(score).for_each(|(t, s)| *t = join(*t, s));
        }
    }
    total
}

/// Indices that stay when the `count` lowest scores go, ascending. At least one stays.
pub fn survivors(score: &[f64], count: usize) -> Vec<u32> {
    let count = count.min(score.len().saturating_sub(1));
    let mut order: Vec<u32> = (0..score.len() as u32).collect();
    order
        .sort_unstable_by(|&a, &b| score[a as usize].total_cmp(&score[b as usize]).then(a.cmp(&b)));
    let mut kept = order.split_off(count);
    kept.sort_unstable();
    kept
}

/// Keeps the Gaussians of `kept` (ascending indices) and their moments, limits opacities to `cap`
/// (0 to 1; 1 leaves them alone) and, where there is a limit, forgets the moments of all opacities.
pub fn keep(scene: &mut Gaussians, adam: &mut Adam, kept: &[u32], cap: f32) {
    select(scene, kept);
    adam.select(kept);
    if cap < 1.0 {
        let most = (cap / (1.0 - cap)).ln();
        scene.logit_opacities.iter_mut().for_each(|o| *o = o.min(most));
        adam.forget_opacities();
    }
}

/// Keeps the Gaussians of `kept`, ascending indices.
pub fn select(scene: &mut Gaussians, kept: &[u32]) {
    let width = 3 * scene.sh_coefficients();
    // Indices ascend, so that nothing is written over before it has moved.
    for (to, &from) in kept.iter().enumerate() {
        let from = from as usize;
        scene.means[to] = scene.means[from];
        scene.log_scales[to] = scene.log_scales[from];
        scene.rotations[to] = scene.rotations[from];
        scene.logit_opacities[to] = scene.logit_opacities[from];
        scene.sh.copy_within(from * width..(from + 1) * width, to * width);
    }
    let n = kept.len();
    scene.means.truncate(n);
    scene.log_scales.truncate(n);
    scene.rotations.truncate(n);
    scene.logit_opacities.truncate(n);
    scene.sh.truncate(n * width);
}
