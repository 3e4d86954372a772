//! What a run works on, and its settings: everything that does not change while it runs.

use rayon::prelude::*;

use super::adam::Rates;
use super::lambda::Rule;
use super::oracle::{PowerOracle, Watts};
use super::schedule::Plan;
use super::target::Quality;
use super::views::ViewSplit;
use powergs_base::picture::Picture;
use powergs_core::sim::SimError;
use powergs_frame::display::Display;
use powergs_frame::fovea::Screen;
use powergs_quality::flip::{PIXELS_PER_DEGREE, flip};
use powergs_quality::hvsq::Measures;
use powergs_quality::{Lpips, likeness};
use powergs_raster::{Detail, Options, render};
use powergs_scene::{Camera, Gaussians};

/// A reference image in 16 bits a channel: half the room of floats, exact for 8-bit photos, and 96
/// dB away from any other image in 0..1.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reference {
    width: u32,
    height: u32,
    codes: Vec<[u16; 3]>,
}

impl Reference {
    /// Stores a picture; values are clamped to 0..1.
    pub fn new(picture: &Picture) -> Reference {
        let code = |v: f32| (f64::from(v.clamp(0.0, 1.0)) * 65535.0).round() as u16;
        let codes = picture.pixels.par_iter().map(|p| p.map(code)).collect();
        Reference { width: picture.width, height: picture.height, codes }
    }

    /// A reference of `width` x `height` pixels, all black.
    pub fn black(width: u32, height: u32) -> Reference {
        Reference { width, height, codes: vec![[0; 3]; width as usize * height as usize] }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The codes: three numbers of 16 bits a pixel, in the order of this processor.
    pub fn as_bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.codes)
    }

    /// The same, to be written.
    pub fn as_bytes_mut(&mut self) -> &mut [u8] {
        bytemuck::cast_slice_mut(&mut self.codes)
    }

    /// Writes the picture over another.
    pub fn write_to(&self, picture: &mut Picture) {
        (picture.width, picture.height) = (self.width, self.height);
        self.codes
            .par_iter()
            .map(|c| c.map(|v| f32::from(v) / 65535.0))
            .collect_into_vec(&mut picture.pixels);
    }
}

/// Where the reference images of a run are: in memory, or somewhere that memory is not spent on.
pub trait References: Sync {
    /// Writes the reference of a view over `picture`.
    fn write_to(&self, view: usize, picture: &mut Picture);
}

impl References for Vec<Reference> {
    fn write_to(&self, view: usize, picture: &mut Picture) {
        self[view].write_to(picture);
    }
}

/// Which views decide whether a model passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gate {
    /// Views held out of training for this.
    Validation,
    /// The test views, as the published code does: what it reports it has also selected on.
    Test,
}

/// The numbers of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Iterations of a sample, at least 1.
    pub iterations: u32,
    /// Iterations of the first sample, relative to the others: its λ comes from far away.
    pub first_effort: f64,
    /// Iterations of the final model and of each baseline.
    pub final_iterations: u32,
    /// Iterations of the fine-tunes in the periphery, relative to those of the first level.
    pub level_effort: f64,
    /// Iterations between checks of the quality.
    pub interval: u32,
    /// The share of a fine-tune in which λ is adjusted; then it rests.
    pub adjust_share: f64,
    /// Weight of the display term at the start, without unit: the term of an image that needs the
    /// display power of the dense model. λ, in 1/W, is this over that power.
    pub display_weight: f64,
    /// The same for the levels of the periphery; HVSQ is a smaller number than L1.
    pub level_display_weight: f64,
    /// How λ is controlled.
    pub rule: Rule,
    /// The quality has settled when it is less than this above the target, decibels.
    pub epsilon_db: f64,
    /// Opacities are limited to this when Gaussians are pruned; 1 for no limit.
    pub opacity_cap: f32,
    /// Factor on all learning rates.
    pub rate_scale: f64,
    /// The learning rates at the end of a fine-tune, relative to its beginning; a cosine between.
    pub rate_end: f64,
    /// Seed of the order of views.
    pub seed: u64,
    /// Which views decide.
    pub gate: Gate,
}

impl Settings {
    /// How the samples of a level (0 for level 1) are chosen, and the iterations of one.
    pub fn budget(&self, schedule: &Plan, level: u8) -> (Plan, u32) {
        if level == 0 {
            return (schedule.clone(), self.iterations);
        }
        let (plan, share) = schedule.upper(self.level_effort);
        (plan, share_of(self.iterations, share))
    }

    /// Iterations of the dense model that is trained on without the gate views.
    pub fn first_budget(&self) -> u32 {
        share_of(self.iterations, self.first_effort)
    }

    /// Iterations of the final model of a level, and of each baseline there.
    pub fn final_budget(&self, level: u8) -> u32 {
        let share = if level == 0 { 1.0 } else { self.level_effort };
        share_of(self.final_iterations, share)
    }
}

/// A share of a number of iterations, at least 1.
pub(super) fn share_of(iterations: u32, share: f64) -> u32 {
    ((f64::from(iterations) * share).round() as u32).max(1)
}

/// A run's inputs.
pub struct Setup<'a> {
    /// The model to optimise.
    pub dense: &'a Gaussians,
    /// All views.
    pub cameras: &'a [Camera],
    /// The reference image of each view.
    pub references: &'a dyn References,
    /// Which view does what.
    pub split: &'a ViewSplit,
    /// The views that power is a mean over.
    pub power_views: &'a [Camera],
    /// Behind everything, sRGB.
    pub background: [f32; 3],
    /// The panel.
    pub display: &'a Display,
    /// What rendering costs.
    pub oracle: &'a dyn PowerOracle,
    /// The virtual screen of a foveated run: models are also measured by HVSQ.
    pub screen: Option<Screen>,
    /// What LPIPS of the test views is measured with; `None`: it is not measured.
    pub lpips: Option<&'a Lpips>,
    /// Numbers.
    pub settings: &'a Settings,
}

/// Quality and display power over some views.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Mean quality.
    pub quality: Quality,
    /// Mean display power of the displayed images, watts.
    pub display_w: f64,
}

impl Setup<'_> {
    /// The views that gate.
    pub fn gate_views(&self) -> &[usize] {
        match self.settings.gate {
            Gate::Validation => &self.split.validation,
            Gate::Test => &self.split.test,
        }
    }

    /// The training cameras.
    pub fn train_cameras(&self) -> Vec<Camera> {
        self.split.train.iter().map(|&v| self.cameras[v].clone()).collect()
    }

    /// Quality and display power of `scene` over `views`, means in the order of views; with a
    /// pooling, HVSQ too.
    pub fn see(&self, scene: &Gaussians, views: &[usize], pooling: Option<f64>) -> Seen {
        let options = Options { background: self.background, ..Options::reference(Detail::Image) };
        let seen: Vec<(f64, f64, f64)> = views
            .par_iter()
            .map(|&view| {
                let picture = render(scene, &self.cameras[view], &options).picture;
                let watts = self.display.power(picture.mean_linear_rgb()).0;
                let mut reference = Picture::default();
                self.references.write_to(view, &mut reference);
                let like = likeness(&picture, &reference);
                (like.psnr_db, like.ssim, watts)
            })
            .collect();
        let mean = |value: fn(&(f64, f64, f64)) -> f64| {
            seen.iter().map(value).sum::<f64>() / seen.len().max(1) as f64
        };
        let hvsq = pooling.map(|p| self.hvsq(scene, views, p));
        let quality = Quality { psnr_db: mean(|s| s.0), ssim: mean(|s| s.1), hvsq };
        Seen { quality, display_w: mean(|s| s.2) }
    }

    /// HVSQ of `scene` at a pooling, mean over `views`; not a number for views that it is not
    /// defined for. One view at a time: pyramids take much memory, and use all threads.
    fn hvsq(&self, scene: &Gaussians, views: &[usize], pooling: f64) -> f64 {
        let mut measures = Measures::default();
        let options = Options { background: self.background, ..Options::reference(Detail::Image) };
        let (mut sum, mut reference) = (0.0, Picture::default());
        for &view in views {
            let picture = render(scene, &self.cameras[view], &options).picture;
            self.references.write_to(view, &mut reference);
            let Ok(measure) = measures.of(&picture, &[pooling]) else { return f64::NAN };
            let reference = measure.reference(&reference);
            sum += measure.values(&picture, &reference)[0];
        }
        sum / views.len().max(1) as f64
    }

    /// FLIP of `scene`, mean over the test views.
    pub fn flip_test(&self, scene: &Gaussians) -> f64 {
        self.mean_over_test(scene, |picture, reference| {
            Some(flip(reference, picture, PIXELS_PER_DEGREE))
        })
        .unwrap_or(f64::NAN)
    }

    /// LPIPS of `scene`, mean over the test views; `None` without weights, or if a view is too
    /// small or too large for them. One view at a time: features take much memory.
    pub fn lpips_test(&self, scene: &Gaussians) -> Option<f64> {
        let lpips = self.lpips?;
        self.mean_over_test(scene, |picture, reference| lpips.distance(picture, reference).ok())
    }

    fn mean_over_test(
        &self,
        scene: &Gaussians,
        measure: impl Fn(&Picture, &Picture) -> Option<f64>,
    ) -> Option<f64> {
        let options = Options { background: self.background, ..Options::reference(Detail::Image) };
        let (mut sum, mut reference) = (0.0, Picture::default());
        for &view in &self.split.test {
            let picture = render(scene, &self.cameras[view], &options).picture;
            self.references.write_to(view, &mut reference);
            sum += measure(&picture, &reference)?;
        }
        Some(sum / self.split.test.len().max(1) as f64)
    }

    /// Power of `scene`, mean over the power views.
    ///
    /// # Errors
    /// [`SimError`]: a machine that cannot run the frame, or a defect of the simulator.
    pub fn watts(&self, scene: &Gaussians) -> Result<Watts, SimError> {
        self.oracle.watts(scene, self.power_views, self.background, self.display)
    }

    /// The learning rates of this run, before decay.
    pub fn rates(&self) -> Rates {
        let cameras = self.split.train.iter().map(|&v| self.cameras[v].centre);
        let n = self.split.train.len().max(1) as f64;
        let mean = cameras.clone().sum::<glam::DVec3>() / n;
        let farthest = cameras.map(|c| c.distance(mean)).fold(0.0, f64::max);
        // One camera has no extent: its distance from the scene's centre would be the next guess.
        let extent = if farthest > 0.0 { 1.1 * farthest } else { 1.0 };
        Rates::published(extent).scaled(self.settings.rate_scale)
    }
}
