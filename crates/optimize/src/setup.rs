//! The inputs of a run, which do not change while it runs, and how models are measured on them.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::adam::Rates;
use super::oracle::{OracleWatts, PowerOracle};
use super::pooled::Pooled;
use super::references::References;
use super::renderer::Renderer;
use super::settings::{Gate, Settings};
use super::target::Quality;
use super::views::{ViewSplit, extent};
use powergs_base::picture::Picture;
use powergs_core::sim::SimError;
use powergs_frame::display::Display;
use powergs_frame::fovea::ScreenRule;
use powergs_quality::flip::{PIXELS_PER_DEGREE, flip};
use powergs_quality::{Lpips, likeness};
use powergs_scene::{Camera, Gaussians};

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
    /// What trains and looks.
    pub renderer: &'a dyn Renderer,
    /// What rendering costs.
    pub oracle: &'a dyn PowerOracle,
    /// The virtual screens of a foveated run: models are also measured by HVSQ.
    pub screens: Option<ScreenRule>,
    /// What LPIPS of the test views is measured with; `None`: it is not measured.
    pub lpips: Option<&'a Lpips>,
    /// Numbers.
    pub settings: &'a Settings,
}

/// Quality and display power over some views.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// Mean quality.
    pub quality: Quality,
    /// Mean display power of the displayed images, watts.
    pub display_w: f64,
}

impl Seen {
    /// The mean over views, in their order; HVSQ where all have it.
    pub(crate) fn mean(seen: &[Seen]) -> Seen {
        let mean = |value: &dyn Fn(&Seen) -> f64| {
            seen.iter().map(value).sum::<f64>() / seen.len().max(1) as f64
        };
        let has_hvsq = seen.iter().all(|s| s.quality.hvsq.is_some());
        let hvsq = mean(&|s| s.quality.hvsq.unwrap_or(f64::NAN));
        let quality = Quality {
            psnr_db: mean(&|s| s.quality.psnr_db),
            ssim: mean(&|s| s.quality.ssim),
            hvsq: has_hvsq.then_some(hvsq),
        };
        Seen { quality, display_w: mean(&|s| s.display_w) }
    }
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
    pub(crate) fn train_cameras(&self) -> Vec<Camera> {
        self.split.train.iter().map(|&v| self.cameras[v].clone()).collect()
    }

    /// The picture of a view, not clamped.
    pub(crate) fn look(&self, scene: &Gaussians, view: usize) -> Picture {
        self.renderer.look(scene, &self.cameras[view], self.background)
    }

    /// Quality and display power of `scene` over `views`, means in the order of views; with a
    /// pooling, HVSQ too.
    pub fn see(&self, scene: &Gaussians, views: &[usize], pooling: Option<f64>) -> Seen {
        let mut pooled = pooling.map(Pooled::new);
        Seen::mean(&self.see_each(scene, views, pooled.as_mut()))
    }

    /// The same of each view, in their order; HVSQ is not a number for views that it is not
    /// defined for.
    pub(crate) fn see_each(
        &self,
        scene: &Gaussians,
        views: &[usize],
        mut pooled: Option<&mut Pooled>,
    ) -> Vec<Seen> {
        let is_pooled = pooled.is_some();
        let look = |&view: &usize| {
            let picture = self.look(scene, view);
            let display_w = self.display.power(picture.mean_linear_rgb()).0;
            let mut reference = Picture::default();
            self.references.write_to(view, &mut reference);
            let like = likeness(&picture, &reference);
            let quality = Quality::likeness(like.psnr_db, like.ssim);
            (Seen { quality, display_w }, is_pooled.then_some(picture))
        };
        let mut seen = Vec::with_capacity(views.len());
        // HVSQ takes one view at a time: pyramids take much memory, and use all threads. A picture
        // for each thread waits for it.
        let at_once = if is_pooled { rayon::current_num_threads() } else { views.len() };
        for some in views.chunks(at_once.max(1)) {
            let looks: Vec<_> = some.par_iter().map(look).collect();
            for (&view, (mut one, picture)) in some.iter().zip(looks) {
                if let (Some(pooled), Some(picture)) = (&mut pooled, picture) {
                    let value = pooled.value(self, view, &picture);
                    one.quality.hvsq = Some(value.unwrap_or(f64::NAN));
                }
                seen.push(one);
            }
        }
        seen
    }

    /// FLIP of `scene`, mean over the test views.
    pub(crate) fn flip_test(&self, scene: &Gaussians) -> f64 {
        self.mean_over_test(scene, |picture, reference| {
            Some(flip(reference, picture, PIXELS_PER_DEGREE))
        })
        .unwrap_or(f64::NAN)
    }

    /// LPIPS of `scene`, mean over the test views; `None` without weights, or if a view is too
    /// small or too large for them. One view at a time: features take much memory.
    pub(crate) fn lpips_test(&self, scene: &Gaussians) -> Option<f64> {
        let lpips = self.lpips?;
        self.mean_over_test(scene, |picture, reference| lpips.distance(picture, reference).ok())
    }

    fn mean_over_test(
        &self,
        scene: &Gaussians,
        measure: impl Fn(&Picture, &Picture) -> Option<f64>,
    ) -> Option<f64> {
        let (mut sum, mut reference) = (0.0, Picture::default());
        for &view in &self.split.test {
            let picture = self.look(scene, view);
            self.references.write_to(view, &mut reference);
            sum += measure(&picture, &reference)?;
        }
        Some(sum / self.split.test.len().max(1) as f64)
    }

    /// Power of `scene`, mean over the power views.
    ///
    /// # Errors
    /// [`SimError`]: a machine that cannot run the frame, or a defect of the simulator.
    pub fn watts(&self, scene: &Gaussians) -> Result<OracleWatts, SimError> {
        self.oracle.watts(scene, self.power_views, self.background, self.display)
    }

    /// The learning rates of this run, before decay.
    pub(crate) fn rates(&self) -> Rates {
        let extent = extent(self.split.train.iter().map(|&v| self.cameras[v].centre));
        Rates::published(extent).scaled(self.settings.rate_scale)
    }
}
