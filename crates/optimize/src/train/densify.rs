//! Adaptive density control: what is too coarse is cloned or split, what is nearly transparent or
//! too large is pruned, and opacities are reset.

use glam::{Quat, Vec3};
use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;

use super::super::adam::Adam;
use super::super::prune::keep;
use super::super::tune::Model;
use powergs_raster::train::Slopes;
use powergs_scene::{Camera, Gaussians};

/// Gaussians that one becomes when it is split.
const CHILDREN: usize = 2;
/// Scales of the children are those of the parent over this.
const SHRINK: f32 = 0.8 * CHILDREN as f32;
/// The most opacity after a reset.
const RESET_OPACITY: f32 = 0.01;

/// What was seen of every Gaussian since the last densification.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Observed {
    /// The sum over views of the length of the gradient by the centre, the loss by half widths and
    /// heights of the picture.
    pub slopes: Vec<f32>,
    /// Views that saw it.
    pub views: Vec<u32>,
    /// The largest radius, pixels.
    pub radii: Vec<f32>,
}

impl Observed {
    /// Nothing yet, of `points` Gaussians.
    pub fn new(points: usize) -> Observed {
        Observed { slopes: vec![0.0; points], views: vec![0; points], radii: vec![0.0; points] }
    }

    /// Adds what a view sees.
    pub fn add(&mut self, slopes: &Slopes<'_>, camera: &Camera) {
        let half = [camera.width, camera.height].map(|side| 0.5 * side as f32);
        for (splat, [x, y]) in slopes.by_centre() {
            let i = splat.index as usize;
            self.slopes[i] += (x * half[0]).hypot(y * half[1]);
            self.views[i] += 1;
            self.radii[i] = self.radii[i].max(splat.radius());
        }
    }

    /// The mean gradient of a Gaussian; 0 if no view saw it.
    fn mean(&self, gaussian: usize) -> f32 {
        match self.views[gaussian] {
            0 => 0.0,
            views => self.slopes[gaussian] / views as f32,
        }
    }
}

/// What is done to which Gaussians, in units of the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Density {
    /// The least mean gradient of what is cloned or split.
    pub slope: f32,
    /// Of these, those whose largest scale is above this are split, the others cloned.
    pub split_scale: f32,
    /// What has less opacity goes.
    pub prune_opacity: f32,
    /// What has a larger scale goes.
    pub prune_scale: Option<f32>,
    /// What was larger in a picture goes, pixels.
    pub prune_radius: Option<f32>,
    /// The most Gaussians that are made.
    pub most: usize,
    /// Seed of the places of children.
    pub seed: u64,
}

/// What was done.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct DensifyCounts {
    /// Gaussians that got a copy.
    pub cloned: usize,
    /// Gaussians that became two.
    pub split: usize,
    /// Gaussians that went, without those that were split.
    pub pruned: usize,
    /// Whether there would have been too many: then none was cloned or split.
    pub is_capped: bool,
}

/// One densification. Those that stay keep their order and their moments; behind them come copies,
/// then first children, then second ones, with moments of zero. What was seen begins anew.
pub fn densify(model: &mut Model, observed: &mut Observed, rule: &Density) -> DensifyCounts {
    let count = model.scene.len();
    let largest = |scene: &Gaussians, i: usize| {
        scene.log_scales[i].into_iter().fold(f32::NEG_INFINITY, f32::max).exp()
    };
    let (mut clones, mut splits) = (Vec::new(), Vec::new());
    for i in (0..count).filter(|i| observed.mean(*i) >= rule.slope) {
        let is_large = largest(&model.scene, i) > rule.split_scale;
        if is_large { splits.push(i as u32) } else { clones.push(i as u32) }
    }
    // A split adds one, for the parent goes.
    let is_capped = count + clones.len() + splits.len() > rule.most
        && !(clones.is_empty() && splits.is_empty());
    if is_capped {
        clones.clear();
        splits.clear();
    }
    copy(model, &clones);
    let first_child = model.scene.len();
    for _ in 0..CHILDREN {
        copy(model, &splits);
    }
    scatter(&mut model.scene, first_child, rule.seed);
    let mut is_split = vec![false; model.scene.len()];
    splits.iter().for_each(|i| is_split[*i as usize] = true);
    let least = logit(rule.prune_opacity);
    let goes = |i: usize| {
        let is_wide = rule.prune_scale.is_some_and(|most| largest(&model.scene, i) > most);
        let radius = observed.radii.get(i).copied().unwrap_or(0.0);
        let is_large = rule.prune_radius.is_some_and(|most| radius > most);
        model.scene.logit_opacities[i] < least || is_wide || is_large
    };
    let stays = |i: &u32| !is_split[*i as usize] && !goes(*i as usize);
    let kept: Vec<u32> = (0..model.scene.len() as u32).filter(stays).collect();
    let pruned = model.scene.len() - splits.len() - kept.len();
    keep(&mut model.scene, &mut model.adam, &kept, 1.0);
    *observed = Observed::new(kept.len());
    DensifyCounts { cloned: clones.len(), split: splits.len(), pruned, is_capped }
}

/// Limits opacities to 0.01 and forgets their moments.
pub fn reset_opacities(model: &mut Model) {
    let most = logit(RESET_OPACITY);
    model.scene.logit_opacities.iter_mut().for_each(|o| *o = o.min(most));
    model.adam.forget_opacities();
}

fn logit(opacity: f32) -> f32 {
    (opacity / (1.0 - opacity)).ln()
}

/// Appends Gaussians of the model to it, with moments of zero. Steps are those of the original: the
/// published optimiser counts them once for all.
fn copy(model: &mut Model, of: &[u32]) {
    let Model { scene, adam: Adam { first, second, steps } } = model;
    let width = 3 * scene.sh_coefficients();
    for moments in [first, second] {
        let count = scene.len() + of.len();
        moments.means.resize(count, [0.0; 3]);
        moments.log_scales.resize(count, [0.0; 3]);
        moments.rotations.resize(count, [0.0; 4]);
        moments.logit_opacities.resize(count, 0.0);
        moments.sh.resize(count * width, 0.0);
    }
    for &i in of {
        let i = i as usize;
        scene.means.push(scene.means[i]);
        scene.log_scales.push(scene.log_scales[i]);
        scene.rotations.push(scene.rotations[i]);
        scene.logit_opacities.push(scene.logit_opacities[i]);
        scene.sh.extend_from_within(i * width..(i + 1) * width);
        steps.push(steps[i]);
    }
}

/// Moves children, which begin at `first` where their parents are, to places drawn from these, and
/// makes them smaller.
fn scatter(scene: &mut Gaussians, first: usize, seed: u64) {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    for i in first..scene.len() {
        let mut normal = || -> f32 { StandardNormal.sample(&mut rng) };
        let off = scene.log_scales[i].map(|s| s.exp() * normal());
        let [w, x, y, z] = scene.rotations[i];
        let rotation = Quat::from_xyzw(x, y, z, w);
        // A quaternion of zero turns nothing.
        let rotation = if rotation.length() > 0.0 { rotation.normalize() } else { Quat::IDENTITY };
        let turned = rotation * Vec3::from_array(off);
        let place = Vec3::from_array(scene.means[i]) + turned;
        scene.means[i] = place.to_array();
        scene.log_scales[i] = scene.log_scales[i].map(|s| s - SHRINK.ln());
    }
}
