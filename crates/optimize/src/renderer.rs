//! The three places where training touches the renderer: a step of a model, a look at it, and the
//! scores of its Gaussians. One trait, so that another device can take all three.

use super::adam::{BadGradient, Rates};
use super::prune::Score;
use super::tune::Model;
use powergs_base::picture::Picture;
use powergs_raster::train::{self, Tape, Which};
use powergs_raster::{Detail, Options, render};
use powergs_scene::{Camera, Gaussians};

/// Renders and differentiates models for training.
pub trait Renderer: Send + Sync {
    /// What its numbers depend on, beside models and views: a run goes on with the same id only.
    fn id(&self) -> String;

    /// What takes the steps of one fine-tune; it may keep buffers from step to step. Steps depend
    /// on their arguments alone, not on the steps before.
    fn stepper(&self) -> Box<dyn Stepper + '_>;

    /// The picture of a view, over a background (sRGB), not clamped.
    fn look(&self, scene: &Gaussians, camera: &Camera, background: [f32; 3]) -> Picture;

    /// The score of every Gaussian over some views; more is worth more.
    fn score(&self, score: Score, scene: &Gaussians, views: &[Camera]) -> Vec<f64>;
}

/// A view to step by.
#[derive(Debug, Clone, Copy)]
pub struct RendererStep<'a> {
    /// The view.
    pub camera: &'a Camera,
    /// Behind everything, sRGB.
    pub background: [f32; 3],
    /// The parameters that have gradients.
    pub which: Which,
    /// The learning rates.
    pub rates: Rates,
    /// The model that is rendered, where it is not the one that steps itself.
    pub read: Option<&'a Gaussians>,
}

/// A loss of a picture, not clamped: writes its derivatives by the channels of the pixels,
/// row-major. `false`: there is no use in a step.
pub type LossOf<'a> = dyn FnMut(&Picture, &mut [[f32; 3]]) -> bool + 'a;

/// Takes steps.
pub trait Stepper {
    /// Renders a view of `model`, asks `loss`, and lets what the view sees step down
    /// ([`Adam::step`](super::adam::Adam::step)) unless the loss says no.
    ///
    /// # Errors
    /// The first gradient that cannot be used; the model is of no use then.
    fn step(
        &mut self,
        model: &mut Model,
        step: &RendererStep<'_>,
        loss: &mut LossOf<'_>,
    ) -> Result<(), BadGradient>;
}

/// This processor: the rasteriser of `powergs-raster`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Processor;

impl Renderer for Processor {
    fn id(&self) -> String {
        "processor".into()
    }

    fn stepper(&self) -> Box<dyn Stepper + '_> {
        Box::<TapeStepper>::default()
    }

    fn look(&self, scene: &Gaussians, camera: &Camera, background: [f32; 3]) -> Picture {
        let options = Options { background, ..Options::reference(Detail::Image) };
        render(scene, camera, &options).picture
    }

    fn score(&self, score: Score, scene: &Gaussians, views: &[Camera]) -> Vec<f64> {
        score.of(scene, views)
    }
}

/// Steps on a tape, whose buffers are kept.
#[derive(Debug, Default)]
struct TapeStepper {
    tape: Tape,
    by_pixel: Vec<[f32; 3]>,
}

impl Stepper for TapeStepper {
    fn step(
        &mut self,
        model: &mut Model,
        step: &RendererStep<'_>,
        loss: &mut LossOf<'_>,
    ) -> Result<(), BadGradient> {
        let Model { scene, adam } = model;
        let background = step.background;
        let options = train::Options { background, ..train::Options::reference() };
        let rendered = step.read.unwrap_or(scene);
        let picture = self.tape.forward(rendered, step.camera, &options);
        self.by_pixel.resize(picture.pixels.len(), [0.0; 3]);
        if !loss(picture, &mut self.by_pixel) {
            return Ok(());
        }
        let slopes = self.tape.slopes(&self.by_pixel, step.which);
        adam.step(scene, step.read, &slopes, &step.rates)
    }
}
