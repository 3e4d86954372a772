//! The step: gradients, moments and parameters in one pass.

use std::sync::LazyLock;

use rayon::prelude::*;

use super::{Adam, BadGradient, Group, Rates};
use powergs_frame::splat::gradient::{GradientBlock, SH_MOST, SHAPE, Stretch};
use powergs_frame::splat::project::LANES;
use powergs_raster::train::Slopes;
use powergs_scene::Gaussians;

/// Decay of the first moment.
const BETA_1: f64 = 0.9;
/// Decay of the second moment.
const BETA_2: f64 = 0.999;
/// Keeps the step of a parameter without gradient finite.
const EPSILON: f32 = 1e-15;
/// Gradients beyond this would overflow when squared: as bad as infinite ones.
const LARGEST: f32 = 1e18;
/// Gaussians that one task works on.
const PART: usize = 128 * LANES;

/// What moments of zero at the beginning take: by the number of steps, one over the correction of
/// the first moment, and over the root of that of the second.
static CORRECTIONS: LazyLock<Vec<[f32; 2]>> = LazyLock::new(|| {
    let of = |steps: i32| {
        let [first, second] = [BETA_1, BETA_2].map(|b| 1.0 / (1.0 - b.powi(steps)));
        [first as f32, second.sqrt() as f32]
    };
    // In single precision both are 1 after some thousands of steps: there the list may end.
    (1..).map(of).take_while(|c| *c != [1.0; 2]).collect()
});

/// The corrections after so many steps, at least 1.
fn corrections(steps: u32) -> [f32; 2] {
    CORRECTIONS.get(steps as usize - 1).copied().unwrap_or([1.0; 2])
}

/// Rates as they lie in a [`GradientBlock`].
struct Steps {
    shape: [f32; LANES],
    sh: [f32; SH_MOST],
    /// Whether anything but spherical harmonics moves.
    moves_shape: bool,
    /// Whether spherical harmonics move.
    moves_sh: bool,
}

impl Steps {
    fn new(scene: &Gaussians, rates: &Rates) -> Steps {
        let (mut shape, mut sh) = ([0.0; LANES], [0.0; SH_MOST]);
        let mut at = 0;
        for group in Group::ALL.into_iter().filter(|group| *group != Group::Sh) {
            let width = group.width(scene);
            shape[at..at + width].fill(rates.of(group, 0) as f32);
            at += width;
        }
        let coefficients = scene.sh_coefficients();
        for (i, rate) in sh[..3 * coefficients].iter_mut().enumerate() {
            *rate = rates.of(Group::Sh, i % coefficients) as f32;
        }
        let moves = |rates: &[f32]| rates.iter().any(|rate| *rate != 0.0);
        Steps { moves_shape: moves(&shape), moves_sh: moves(&sh), shape, sh }
    }
}

/// See [`Adam::step`].
pub(super) fn step(
    adam: &mut Adam,
    scene: &mut Gaussians,
    read: Option<&Gaussians>,
    slopes: &Slopes<'_>,
    rates: &Rates,
) -> Result<(), BadGradient> {
    assert_eq!(slopes.points(), scene.len(), "a step needs the scene of the forward pass");
    let steps = Steps::new(scene, rates);
    let Adam { first, second, steps: counts } = adam;
    let moments = parts(first).zip(parts(second)).zip(counts.chunks_mut(PART));
    let work: Vec<_> = parts(scene).zip(moments).collect();
    // The first in the order of Gaussians, whichever thread ends first: messages repeat.
    let bad = work.into_par_iter().enumerate().find_map_first(|(i, (values, moments))| {
        let ((first, second), counts) = moments;
        AdamPart { values, first, second, counts }.step(i * PART, read, slopes, &steps)
    });
    bad.map_or(Ok(()), Err)
}

/// Values of consecutive Gaussians.
struct AdamValues<'a> {
    means: &'a mut [[f32; 3]],
    log_scales: &'a mut [[f32; 3]],
    rotations: &'a mut [[f32; 4]],
    logit_opacities: &'a mut [f32],
    sh: &'a mut [f32],
    sh_degree: u8,
    antialiased: bool,
}

/// All Gaussians, [`PART`] at a time.
fn parts(of: &mut Gaussians) -> impl Iterator<Item = AdamValues<'_>> {
    let (n, sh_degree, antialiased) = (3 * of.sh_coefficients(), of.sh_degree, of.antialiased);
    let shapes = of.means.chunks_mut(PART).zip(of.log_scales.chunks_mut(PART));
    let shapes = shapes.zip(of.rotations.chunks_mut(PART));
    let others = of.logit_opacities.chunks_mut(PART).zip(of.sh.chunks_mut(PART * n));
    shapes.zip(others).map(move |(((means, log_scales), rotations), (logit_opacities, sh))| {
        AdamValues { means, log_scales, rotations, logit_opacities, sh, sh_degree, antialiased }
    })
}

impl AdamValues<'_> {
    fn stretch(&self) -> Stretch<'_> {
        Stretch {
            means: self.means,
            log_scales: self.log_scales,
            rotations: self.rotations,
            logit_opacities: self.logit_opacities,
            sh: self.sh,
            sh_degree: self.sh_degree,
            antialiased: self.antialiased,
        }
    }

    /// Everything but spherical harmonics, in the order of a [`GradientBlock`].
    #[inline(always)]
    fn shape(&self, place: usize) -> [f32; LANES] {
        let mut shape = [0.0; LANES];
        shape[..3].copy_from_slice(&self.means[place]);
        shape[3..6].copy_from_slice(&self.log_scales[place]);
        shape[6..10].copy_from_slice(&self.rotations[place]);
        shape[SHAPE - 1] = self.logit_opacities[place];
        shape
    }

    #[inline(always)]
    fn set_shape(&mut self, place: usize, shape: &[f32; LANES]) {
        self.means[place].copy_from_slice(&shape[..3]);
        self.log_scales[place].copy_from_slice(&shape[3..6]);
        self.rotations[place].copy_from_slice(&shape[6..10]);
        self.logit_opacities[place] = shape[SHAPE - 1];
    }

    #[inline(always)]
    fn sh(&mut self, place: usize, n: usize) -> &mut [f32] {
        &mut self.sh[place * n..(place + 1) * n]
    }
}

/// Consecutive Gaussians with their moments.
struct AdamPart<'a> {
    values: AdamValues<'a>,
    first: AdamValues<'a>,
    second: AdamValues<'a>,
    counts: &'a mut [u32],
}

impl AdamPart<'_> {
    /// The step of those that are seen; `at` is the index of the first. Stops before a block of
    /// them that has a bad gradient.
    fn step(
        mut self,
        at: usize,
        read: Option<&Gaussians>,
        slopes: &Slopes<'_>,
        steps: &Steps,
    ) -> Option<BadGradient> {
        // Places in what was rendered: this part, or the whole model as it was read.
        let first = if read.is_some() { 0 } else { at };
        let all = at..at + self.counts.len();
        let seen = all.filter(|gaussian| slopes.is_seen(*gaussian));
        let seen: Vec<u32> = seen.map(|gaussian| (gaussian - first) as u32).collect();
        let n = self.values.sh.len() / self.counts.len();
        let mut block = GradientBlock::default();
        for seen in seen.chunks(LANES) {
            let rendered = read.map_or_else(|| self.values.stretch(), Stretch::all);
            slopes.find(&rendered, first, seen, &mut block);
            // All gradients of a block are looked at before any of it steps: no block is half
            // moved.
            for (lane, &place) in seen.iter().enumerate() {
                if let Some((group, position)) = bad(&block, lane, n) {
                    return Some(BadGradient { group, gaussian: first + place as usize, position });
                }
            }
            for (lane, &place) in seen.iter().enumerate() {
                let place = first + place as usize - at;
                self.step_one(place, &block.shape[lane], &block.sh[lane][..n], steps);
            }
        }
        None
    }

    #[inline(always)]
    fn step_one(&mut self, place: usize, shape: &[f32; LANES], sh: &[f32], steps: &Steps) {
        self.counts[place] = self.counts[place].saturating_add(1);
        let corrections = corrections(self.counts[place]);
        if steps.moves_shape {
            let mut values = self.values.shape(place);
            let (mut first, mut second) = (self.first.shape(place), self.second.shape(place));
            update(&mut values, shape, &mut first, &mut second, &steps.shape, corrections);
            self.values.set_shape(place, &values);
            self.first.set_shape(place, &first);
            self.second.set_shape(place, &second);
        }
        if steps.moves_sh {
            let n = sh.len();
            let (values, first) = (self.values.sh(place, n), self.first.sh(place, n));
            let second = self.second.sh(place, n);
            update(values, sh, first, second, &steps.sh[..n], corrections);
        }
    }
}

/// The first bad gradient of a Gaussian of a block that has `n` SH coefficients.
fn bad(block: &GradientBlock, lane: usize, n: usize) -> Option<(Group, usize)> {
    let (shape, sh) = (&block.shape[lane], &block.sh[lane][..n]);
    // Without a branch for each: almost always all are good.
    let is_bad = |v: &f32| v.is_nan() || v.abs() > LARGEST;
    let count = |values: &[f32]| values.iter().map(|v| u32::from(is_bad(v))).sum::<u32>();
    if count(shape) + count(sh) == 0 {
        return None;
    }
    let lists = [&shape[..3], &shape[3..6], &shape[6..10], &shape[10..SHAPE], sh];
    let first = |(group, values): (Group, &[f32])| Some((group, values.iter().position(is_bad)?));
    Group::ALL.into_iter().zip(lists).find_map(first)
}

/// The rule of the module. `corrections`: as [`corrections`].
#[inline(always)]
fn update(
    values: &mut [f32],
    slopes: &[f32],
    first: &mut [f32],
    second: &mut [f32],
    rates: &[f32],
    corrections: [f32; 2],
) {
    const B1: f32 = BETA_1 as f32;
    const B2: f32 = BETA_2 as f32;
    let moments = first.iter_mut().zip(second);
    for ((p, g), ((m, v), rate)) in values.iter_mut().zip(slopes).zip(moments.zip(rates)) {
        *m = B1 * *m + (1.0 - B1) * g;
        *v = B2 * *v + (1.0 - B2) * g * g;
        *p -= rate * corrections[0] * *m / (v.sqrt() * corrections[1] + EPSILON);
    }
}
