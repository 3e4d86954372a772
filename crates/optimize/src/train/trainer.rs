//! The training loop, one iteration at a time.

use powergs_base::picture::Picture;
use powergs_base::quantity::Watts;
use powergs_frame::display::Display;
use powergs_quality::{Loss, likeness};
use powergs_raster::train::{Clamp, Options, Tape, Which};
use powergs_raster::{Detail, render};
use powergs_scene::{Camera, Gaussians};
use rayon::prelude::*;
use serde::Serialize;
use xxhash_rust::xxh3::Xxh3;

use super::super::adam::{BadGradient, Group};
use super::super::references::References;
use super::super::tune::Model;
use super::super::views::{ViewOrder, extent};
use super::TrainRules;
use super::densify::{DensifyCounts, Density, Observed, densify, reset_opacities};

/// Raised whenever a training would go on by other rules than it began with.
const RULES_VERSION: u32 = 1;

/// What a training reads.
#[derive(Clone, Copy)]
pub struct TrainInputs<'a> {
    /// All views.
    pub cameras: &'a [Camera],
    /// The photo of each view, in its size.
    pub references: &'a dyn References,
    /// Views that train, at least one: indices into the list of views.
    pub train: &'a [usize],
    /// Views that are held out, for reports.
    pub held_out: &'a [usize],
    /// Behind everything, sRGB.
    pub background: [f32; 3],
    /// The rules.
    pub rules: &'a TrainRules,
}

impl TrainInputs<'_> {
    /// A hash of everything that the model of a training from `start` depends on.
    pub fn fingerprint(&self, start: &Gaussians) -> u128 {
        let mut hash = Xxh3::new();
        hash.update(&RULES_VERSION.to_le_bytes());
        let rules = (self.rules, self.train, self.background, self.cameras.len());
        hash.update(&postcard::to_stdvec(&rules).expect("numbers can be written"));
        for camera in self.cameras {
            let [x, y, z] = camera.centre.to_array();
            let numbers = [camera.fx, camera.fy, camera.cx, camera.cy, x, y, z];
            let turned = camera.world_to_camera.to_cols_array();
            numbers.iter().chain(&turned).for_each(|v| hash.update(&v.to_le_bytes()));
            [camera.width, camera.height].iter().for_each(|v| hash.update(&v.to_le_bytes()));
        }
        hash.update(&self.references.digest().to_le_bytes());
        for group in Group::ALL {
            group.of(start).iter().for_each(|v| hash.update(&v.to_le_bytes()));
        }
        hash.digest128()
    }
}

/// Where a training is.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TrainState {
    /// The model.
    pub model: Model,
    /// What was seen of it since the last densification.
    pub observed: Observed,
    /// Iterations done.
    pub iteration: u32,
    /// Whether Gaussians were not cloned or split because there would have been too many.
    pub is_capped: bool,
}

impl TrainState {
    /// The beginning.
    pub fn begin(start: &Gaussians) -> TrainState {
        let model = Model::fresh(start);
        let observed = Observed::new(start.len());
        TrainState { model, observed, iteration: 0, is_capped: false }
    }
}

/// What happened in an iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrainStep {
    /// Counted from 1.
    pub iteration: u32,
    /// The view that trained, index into the list of views.
    pub view: usize,
    /// The loss.
    pub loss: f64,
    /// PSNR of the view before the step, decibels.
    pub psnr_db: f64,
    /// What densification did, where it was due.
    pub densified: Option<DensifyCounts>,
    /// Whether opacities were reset: until they recover the model shows little.
    pub is_reset: bool,
}

/// Quality over held-out views, means.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HeldOutSeen {
    /// PSNR, decibels.
    pub psnr_db: f64,
    /// SSIM.
    pub ssim: f64,
    /// Views.
    pub views: usize,
}

/// A training went wrong.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrainError {
    /// A gradient that cannot be used.
    #[error(
        "iteration {iteration}, view {view}: the gradient of {} {} of Gaussian {} is not finite; \
         train with smaller rates", bad.group.name(), bad.position, bad.gaussian
    )]
    Gradient {
        /// Where in the parameters.
        bad: BadGradient,
        /// Counted from 1.
        iteration: u32,
        /// Name of the view.
        view: String,
    },
    /// The loss itself.
    #[error("iteration {iteration}, view {view}: the loss is not finite; train with smaller rates")]
    Loss {
        /// Counted from 1.
        iteration: u32,
        /// Name of the view.
        view: String,
    },
    /// Nothing is left.
    #[error(
        "iteration {iteration}: all Gaussians were pruned; do photos and cameras belong together, \
         and do the points lie where the cameras look?"
    )]
    Empty {
        /// Counted from 1.
        iteration: u32,
    },
}

/// A training at work.
pub struct Trainer<'a> {
    inputs: TrainInputs<'a>,
    extent: f64,
    state: TrainState,
    order: ViewOrder,
    tape: Tape,
    losses: Vec<((u32, u32), Loss)>,
    reference: Picture,
    by_pixel: Vec<[f32; 3]>,
    /// The loss asks for a display; this one takes nothing.
    dark: Display,
}

impl<'a> Trainer<'a> {
    /// A trainer in `state`.
    ///
    /// # Panics
    /// Without a view that trains.
    pub fn new(inputs: TrainInputs<'a>, state: TrainState) -> Trainer<'a> {
        let dark = Display {
            name: String::new(),
            description: String::new(),
            scale: 0.0,
            red: Watts(0.0),
            green: Watts(0.0),
            blue: Watts(0.0),
            static_power: Watts(0.0),
            source: String::new(),
        };
        Trainer {
            inputs,
            extent: extent(inputs.train.iter().map(|view| inputs.cameras[*view].centre)),
            state,
            order: ViewOrder::new(inputs.rules.seed, inputs.train.len()),
            tape: Tape::new(),
            losses: Vec::new(),
            reference: Picture::default(),
            by_pixel: Vec::new(),
            dark,
        }
    }

    /// Whether all iterations are done.
    pub fn is_done(&self) -> bool {
        self.state.iteration >= self.inputs.rules.iterations
    }

    /// Where it is.
    pub fn state(&self) -> &TrainState {
        &self.state
    }

    /// Its rules.
    pub fn rules(&self) -> &'a TrainRules {
        self.inputs.rules
    }

    /// What is behind everything, sRGB.
    pub fn background(&self) -> [f32; 3] {
        self.inputs.background
    }

    /// The model so far.
    pub fn scene(&self) -> &Gaussians {
        &self.state.model.scene
    }

    /// The next iteration. One that densifies does not step: the published optimiser has no
    /// gradients of the Gaussians that it makes anew.
    ///
    /// # Errors
    /// [`TrainError`]: the model is of no use then.
    pub fn step(&mut self) -> Result<TrainStep, TrainError> {
        let rules = self.inputs.rules;
        let iteration = self.state.iteration + 1;
        let view = self.inputs.train[self.order.at(u64::from(iteration - 1))];
        let camera = &self.inputs.cameras[view];
        self.raise_degree(rules.degree(iteration));
        let background = self.inputs.background;
        let options = Options { background, clamp: Clamp::PassThrough, ..Options::reference() };
        self.inputs.references.write_to(view, &mut self.reference);
        let model = &mut self.state.model;
        let picture = self.tape.forward(&model.scene, camera, &options);
        self.by_pixel.resize(picture.pixels.len(), [0.0; 3]);
        let loss = loss_of(&mut self.losses, (picture.width, picture.height));
        let parts = loss.evaluate(picture, &self.reference, 0.0, &self.dark, &mut self.by_pixel);
        let name = || camera.name.clone();
        if !parts.total.is_finite() {
            return Err(TrainError::Loss { iteration, view: name() });
        }
        let slopes = self.tape.slopes(&self.by_pixel, Which::All);
        if rules.observes(iteration) {
            self.state.observed.add(&slopes, camera);
        }
        let is_white = background == [1.0; 3];
        let (densifies, resets) = (rules.densifies(iteration), rules.resets(iteration, is_white));
        let mut densified = None;
        if densifies {
            let done =
                densify(model, &mut self.state.observed, &density(rules, self.extent, iteration));
            self.state.is_capped |= done.is_capped;
            densified = Some(done);
            if self.state.model.scene.is_empty() {
                return Err(TrainError::Empty { iteration });
            }
        } else {
            let rates = rules.rates(iteration, self.extent);
            let stepped = model.adam.step(&mut model.scene, None, &slopes, &rates);
            stepped.map_err(|bad| TrainError::Gradient { bad, iteration, view: name() })?;
        }
        if resets {
            reset_opacities(&mut self.state.model);
        }
        self.state.iteration = iteration;
        let (loss, psnr_db) = (parts.total, parts.psnr_db);
        Ok(TrainStep { iteration, view, loss, psnr_db, densified, is_reset: resets })
    }

    fn raise_degree(&mut self, degree: u8) {
        let Model { scene, adam } = &mut self.state.model;
        for of in [scene, &mut adam.first, &mut adam.second] {
            of.raise_degree(degree);
        }
    }

    /// Quality of the model over the held-out views; `None` without any.
    pub fn held_out(&self) -> Option<HeldOutSeen> {
        let TrainInputs { cameras, references, held_out, background, .. } = self.inputs;
        let look = |view: &usize| {
            let options = powergs_raster::Options {
                background,
                ..powergs_raster::Options::reference(Detail::Image)
            };
            let picture = render(self.scene(), &cameras[*view], &options).picture;
            let mut reference = Picture::default();
            references.write_to(*view, &mut reference);
            let like = likeness(&picture, &reference);
            (like.psnr_db, like.ssim)
        };
        // In the order of the views, so that sums are the same in every run.
        let seen: Vec<(f64, f64)> = held_out.par_iter().map(look).collect();
        let n = seen.len() as f64;
        let psnr_db = seen.iter().map(|s| s.0).sum::<f64>() / n;
        let ssim = seen.iter().map(|s| s.1).sum::<f64>() / n;
        (!seen.is_empty()).then_some(HeldOutSeen { psnr_db, ssim, views: seen.len() })
    }
}

/// The loss for pictures of a size.
fn loss_of(losses: &mut Vec<((u32, u32), Loss)>, size: (u32, u32)) -> &mut Loss {
    let at = losses.iter().position(|(s, _)| *s == size).unwrap_or_else(|| {
        losses.push((size, Loss::new(size.0, size.1)));
        losses.len() - 1
    });
    &mut losses[at].1
}

/// The rules of one densification.
fn density(rules: &TrainRules, extent: f64, iteration: u32) -> Density {
    let after_reset = iteration > rules.reset_every;
    let radius = (rules.prune_radius > 0.0).then_some(rules.prune_radius as f32);
    Density {
        slope: rules.densify_slope as f32,
        split_scale: (rules.split_scale * extent) as f32,
        prune_opacity: rules.prune_opacity as f32,
        prune_scale: after_reset.then_some((rules.prune_scale * extent) as f32),
        prune_radius: radius.filter(|_| after_reset),
        most: usize::try_from(rules.max_points).unwrap_or(usize::MAX),
        // An odd factor spreads the bits of small numbers.
        seed: rules.seed ^ u64::from(iteration).wrapping_mul(0x9e37_79b9_7f4a_7c15),
    }
}
