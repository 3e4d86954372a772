//! One fine-tune: prune, forward, loss, backward, Adam, and at intervals a check of the quality.
//!
//! The [`State`] after any iteration is enough to go on bit for bit.

mod average;
mod config;
mod gains;
mod gauge;
mod heat;
mod kept;
mod objective;
mod stride;

use serde::{Deserialize, Serialize};

use super::adam::{Adam, BadGradient, Rates};
use super::lambda::{ControllerState, LambdaController, LambdaVerdict};
use super::pooled::Pooled;
use super::prune::{Score, keep, select, survivors};
use super::record::{RecordFormats, RecordReader};
use super::renderer::{RendererStep, Stepper};
use super::setup::{Seen, Setup};
use super::target::Target;
use super::times::Times;
use super::views::ViewOrder;
use objective::Losses;
use powergs_quality::HvsqError;
use powergs_raster::train::Which;
use powergs_scene::Gaussians;

pub use config::{DisplayTerm, Keep, Objective, Pace, Pruning, Trains, TuneConfig};
pub(crate) use gains::LOOKS;
pub use gains::{Gains, Spent};
pub(crate) use gauge::confirms;
pub use gauge::{Gauge, confirming};
pub use heat::Heat;
pub use objective::Term;
pub use stride::Stride;

/// Iterations without a step before the first, so that second moments know the size of gradients.
const WARM_UP: usize = 16;
/// Iterations between two models of a mean. Steps resemble those of ten iterations before, so that
/// more of them say little more, and each is a pass over all parameters.
const AVERAGE_EVERY: u32 = 5;
/// Iterations after which Gaussians look for the nearest entry of a codebook again.
const RELABEL_EVERY: u32 = 50;
/// Part of the iterations for which a fine-tune goes on where views that did not choose its model
/// find it below the target.
const EXTENSION: u32 = 10;
/// Where along the fall of the learning rates it is then, so that something moves.
const EXTENSION_RATE: f64 = 0.75;

/// A model in training.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Model {
    /// Its parameters.
    pub scene: Gaussians,
    /// Their moments.
    pub adam: Adam,
}

impl Model {
    /// A model with moments of zero.
    pub fn fresh(scene: &Gaussians) -> Model {
        Model { scene: scene.clone(), adam: Adam::new(scene) }
    }
}

/// A check of the quality over the gate views.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// After this iteration, counted from 0.
    pub iteration: u32,
    /// What was seen: an estimate of all gate views, those that do not choose among them.
    pub seen: Seen,
    /// Whether it reached the target.
    pub passed: bool,
    /// Whether it did so with enough to spare for views that do not choose.
    pub sure: bool,
    /// Whether all gate views that choose were looked at.
    pub confirmed: bool,
    /// λ of the iterations before.
    pub lambda: f64,
}

/// Where a fine-tune is.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// The model.
    pub model: Model,
    /// Iterations done.
    pub iteration: u32,
    /// Pruning steps done.
    pub pruned: u32,
    /// The controller's state.
    pub control: Option<ControllerState>,
    /// The mean over the last iterations, and over how many so far.
    pub average: Option<(Gaussians, u32)>,
    /// What is known of the gate views.
    pub gauge: Gauge,
    /// Checks since one that was confirmed.
    pub unconfirmed: u32,
    /// The heat; none before the first check.
    pub heat: Option<Heat>,
    /// How much goes at the next prune while the target is reached.
    pub stride: Stride,
    /// The entry of the codebook that each Gaussian shares; none without a codebook.
    pub labels: Vec<u32>,
    /// The parameters to keep so far, as they are read, with their check.
    pub best: Option<(Gaussians, Check)>,
    /// The same of one with more to spare, should views that did not choose say no.
    pub spare: Option<(Gaussians, Check)>,
    /// The last check.
    pub last: Option<Check>,
    /// The controller says that the quality has settled.
    pub settled: bool,
    /// The iterations that were done when it went on because views that did not choose said no.
    pub extended: Option<u32>,
    /// What the parameters to keep have above the target, spent on the display, once all is done.
    pub spent: Option<Spent>,
}

impl State {
    /// The beginning.
    pub fn begin(model: Model) -> State {
        State {
            model,
            iteration: 0,
            pruned: 0,
            control: None,
            average: None,
            gauge: Gauge::default(),
            unconfirmed: 0,
            heat: None,
            stride: Stride::FIRST,
            labels: Vec::new(),
            best: None,
            last: None,
            settled: false,
            extended: None,
            spare: None,
            spent: None,
        }
    }

    /// The model that is checked and kept.
    fn shown(&self) -> &Gaussians {
        self.average.as_ref().map_or(&self.model.scene, |(mean, _)| mean)
    }
}

/// What happened in an iteration.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Iteration {
    /// Counted from 0.
    pub iteration: u32,
    /// The training view, index into the list of views.
    pub view: usize,
    /// Gaussians.
    pub points: usize,
    /// The loss.
    pub loss: Term,
    /// λ in it.
    pub lambda: f64,
    /// The check after it.
    pub check: Option<Check>,
}

/// A fine-tune went wrong.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TuneError {
    /// A gradient that cannot be used.
    #[error(
        "iteration {iteration}, view {view}: the gradient of {} {} of Gaussian {} is not finite; \
         no model was written from it; look at that Gaussian, or train with a smaller --rate-scale",
        bad.group.name(), bad.position, bad.gaussian
    )]
    Gradient {
        /// Where in the parameters.
        bad: BadGradient,
        /// Counted from 0.
        iteration: u32,
        /// Name of the training view.
        view: String,
    },
    /// The loss itself.
    #[error(
        "iteration {iteration}, view {view}: the loss is not finite; a reference image or the \
         model holds values that are not numbers"
    )]
    Loss {
        /// Counted from 0.
        iteration: u32,
        /// Name of the training view.
        view: String,
    },
    /// A view that HVSQ is not defined for.
    #[error("view {view}: {what}")]
    Size {
        /// What is wrong.
        what: HvsqError,
        /// Name of the training view.
        view: String,
    },
}

/// A fine-tune at work.
pub struct Tuner<'a> {
    setup: &'a Setup<'a>,
    config: TuneConfig,
    target: Target,
    state: State,
    controller: Option<LambdaController>,
    order: ViewOrder,
    stepper: Box<dyn Stepper + 'a>,
    losses: Losses,
    /// HVSQ, where that is the objective.
    pooled: Option<Pooled>,
    reader: RecordReader,
    clock: &'a dyn Fn() -> f64,
    times: Times,
}

impl<'a> Tuner<'a> {
    /// A tuner in `state`. `stream` keeps the order of views of different fine-tunes apart.
    pub fn new(
        setup: &'a Setup<'a>,
        config: TuneConfig,
        target: Target,
        stream: u64,
        state: State,
    ) -> Tuner<'a> {
        let controller = match (config.display, state.control) {
            (DisplayTerm::Controlled { control, .. }, None) => Some(LambdaController::new(control)),
            (DisplayTerm::Controlled { control, .. }, Some(s)) => {
                Some(LambdaController::restored(control, s))
            }
            (DisplayTerm::Off | DisplayTerm::Gains { .. } | DisplayTerm::Fixed(_), _) => None,
        };
        let pooled = match config.objective {
            Objective::Likeness => None,
            Objective::Hvsq { pooling } => Some(Pooled::new(pooling)),
        };
        // An odd factor: streams that are near each other give orders that are unlike.
        let seed = setup.settings.seed ^ stream.wrapping_mul(0xd134_2543_de82_ef95);
        Tuner {
            setup,
            config,
            target,
            state,
            controller,
            order: ViewOrder::new(seed, setup.split.train.len()),
            stepper: setup.renderer.stepper(),
            losses: Losses::default(),
            pooled,
            reader: RecordReader::default(),
            clock: &|| 0.0,
            times: Times::default(),
        }
    }

    /// The same for a machine that reads the model in these numbers: it is rendered, looked at and
    /// scored as it is read, and gradients by the numbers that are read go to the parameters as
    /// they are (straight through). The model that it ends with is that which is read.
    pub fn reading(self, formats: RecordFormats) -> Tuner<'a> {
        Tuner { reader: RecordReader::new(formats), ..self }
    }

    /// The same by a clock, in seconds, which says where the time goes and changes nothing.
    pub(crate) fn timed(self, clock: &'a dyn Fn() -> f64) -> Tuner<'a> {
        Tuner { clock, ..self }
    }

    /// Where the time of the iterations since it was made went, by that clock.
    pub(crate) fn times(&self) -> Times {
        self.times
    }

    /// Does some of the work of `part`. Work of another part in it is counted there.
    fn part<T>(
        &mut self,
        part: fn(&mut Times) -> &mut f64,
        work: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let (began, before) = ((self.clock)(), self.times.total_s());
        let done = work(self);
        // Parts within this one have counted their own time.
        let inside = self.times.total_s() - before;
        *part(&mut self.times) += (self.clock)() - began - inside;
        done
    }

    /// Whether nothing is left to do.
    pub fn is_done(&self) -> bool {
        self.state.settled || self.state.iteration >= self.iterations()
    }

    /// Iterations, with those that follow where views that did not choose said no: a tenth more,
    /// but two checks at least.
    fn iterations(&self) -> u32 {
        let Some(done) = self.state.extended else { return self.config.iterations };
        let checks = self.setup.settings.interval.saturating_mul(2);
        done.saturating_add((self.config.iterations / EXTENSION).max(checks))
    }

    /// The state now.
    pub fn state(&mut self) -> &State {
        self.state.control = self.controller.as_ref().map(LambdaController::state);
        &self.state
    }

    /// What the model to keep spends on the display by gains; `None` where it has none, or it is
    /// not done.
    pub fn spent(&self) -> Option<Spent> {
        self.state.spent
    }

    /// The model to keep and its check, and the controller's last passing λ.
    pub fn finish(mut self) -> (Model, Option<Check>, Option<f64>) {
        let passing = self.controller.as_ref().and_then(LambdaController::passing);
        if let Some((mean, _)) = self.state.average.take() {
            self.state.model.scene = mean;
        }
        self.reader.of(&self.state.model.scene, &self.state.labels);
        if let Some(read) = self.reader.rounded() {
            self.state.model.scene.clone_from(read);
        }
        match (self.config.keep, self.state.best.take()) {
            (Keep::Dimmest | Keep::LastPassing, Some((mut scene, mut check))) => {
                self.state.dim(&mut scene, &mut check, self.config.trains);
                // Moments are those of the last iteration, if nothing was pruned since.
                let adam = self.state.model.adam;
                let is_same = adam.steps.len() == scene.len();
                let adam = if is_same { adam } else { Adam::new(&scene) };
                (Model { scene, adam }, Some(check), passing)
            }
            (Keep::Last | Keep::Dimmest | Keep::LastPassing, _) => {
                (self.state.model, self.state.last, passing)
            }
        }
    }

    /// One iteration.
    ///
    /// # Errors
    /// A loss or gradient that is not finite. The model is of no use then: some Gaussians may
    /// have done their step.
    pub fn step(&mut self) -> Result<Iteration, TuneError> {
        self.part(|t| &mut t.iterations_s, Tuner::stepped)
    }

    fn stepped(&mut self) -> Result<Iteration, TuneError> {
        let iteration = self.state.iteration;
        if iteration.is_multiple_of(RELABEL_EVERY) {
            self.reader.label(&self.state.model.scene, &mut self.state.labels);
        }
        // Before anything is pruned, because heat is measured by what the first prune takes.
        if iteration == 0 && self.state.heat.is_none() {
            let seen = self.part(
                |t| &mut t.checks_s,
                |tuner| {
                    let read = tuner.reader.of(&tuner.state.model.scene, &tuner.state.labels);
                    tuner.state.gauge.all(tuner.setup, read, tuner.pooled.as_mut())
                },
            );
            let margin_db = self.target.margin_db(seen.quality);
            self.state.heat = Some(Heat::begin(margin_db, self.config.pace));
        }
        self.prune_if_due(iteration);
        let lambda = self.lambda(iteration);
        if iteration == 0 && self.config.pace.averaged > 1 && self.state.model.adam.is_cold() {
            self.warm_up(0, lambda)?;
        }
        let rates = self.setup.rates().scaled(self.decay(iteration));
        let heat = self.state.heat.map_or(1.0, |heat| heat.factor);
        let (view, loss) = self.descend(iteration, lambda, rates.heated(heat))?;
        self.average(iteration);
        let points = self.state.model.scene.len();
        let check = self
            .is_check_due(iteration)
            .then(|| self.part(|t| &mut t.checks_s, |tuner| tuner.check(iteration, lambda)));
        self.state.iteration += 1;
        if check.is_some() {
            self.give_up_if_due(lambda)?;
        }
        let mut seen = None;
        if self.is_done() {
            seen = self.part(|t| &mut t.checks_s, Tuner::confirm)?;
        }
        // Asked again, because views that did not choose may just have extended it.
        if self.is_done() {
            self.part(|t| &mut t.checks_s, |tuner| tuner.spend(seen));
        }
        Ok(Iteration { iteration, view, points, loss, lambda, check })
    }

    /// Gradients without a step, for moments that are cold.
    fn warm_up(&mut self, from: u32, lambda: f64) -> Result<(), TuneError> {
        for i in 0..WARM_UP.min(self.setup.split.train.len()) {
            self.descend(from.saturating_add(i as u32), lambda, Rates::still())?;
        }
        Ok(())
    }

    fn lambda(&self, iteration: u32) -> f64 {
        match (self.config.display, &self.controller) {
            (DisplayTerm::Fixed(lambda), _) => lambda,
            (DisplayTerm::Controlled { from, .. }, Some(c)) if iteration >= from => c.lambda(),
            (DisplayTerm::Off | DisplayTerm::Gains { .. } | DisplayTerm::Controlled { .. }, _) => {
                0.0
            }
        }
    }

    /// Takes the parameters into their mean where it is time.
    fn average(&mut self, iteration: u32) {
        let State { model, average, .. } = &mut self.state;
        let most = self.config.pace.averaged;
        if most < 2 || !(iteration + 1).is_multiple_of(AVERAGE_EVERY) {
            return;
        }
        let (mean, count) = average.get_or_insert_with(|| (model.scene.clone(), 0));
        // Capped: from then on old iterations fade, and the mean stays near the model that moves.
        *count = (*count + AVERAGE_EVERY).min(most.max(AVERAGE_EVERY));
        average::mix(mean, &model.scene, AVERAGE_EVERY as f32 / *count as f32);
    }

    /// Forward, loss, backward, Adam.
    fn descend(
        &mut self,
        iteration: u32,
        lambda: f64,
        rates: Rates,
    ) -> Result<(usize, Term), TuneError> {
        let setup = self.setup;
        let view = setup.split.train[self.order.at(u64::from(iteration))];
        let camera = &setup.cameras[view];
        let which = match self.config.trains {
            Trains::ColoursAndOpacities => Which::ColourAndOpacity,
            Trains::All | Trains::Colours => Which::All,
        };
        let rates = match self.config.trains {
            Trains::All => rates,
            Trains::Colours => rates.colours_only(),
            Trains::ColoursAndOpacities => rates.colours_and_opacities(),
        };
        self.reader.of(&self.state.model.scene, &self.state.labels);
        let (background, read) = (setup.background, self.reader.rounded());
        let step = RendererStep { camera, background, which, rates, read };
        let (losses, mut pooled) = (&mut self.losses, self.pooled.as_mut());
        let mut loss = None;
        let stepped = self.stepper.step(&mut self.state.model, &step, &mut |picture, by_pixel| {
            let found =
                losses.evaluate(setup, pooled.as_deref_mut(), view, picture, lambda, by_pixel);
            let is_finite = found.as_ref().is_ok_and(|term| term.total.is_finite());
            loss = Some(found);
            is_finite
        });
        let view_name = || camera.name.clone();
        let loss = loss.expect("a step asks for its loss");
        let loss = loss.map_err(|what| TuneError::Size { what, view: view_name() })?;
        if !loss.total.is_finite() {
            return Err(TuneError::Loss { iteration, view: view_name() });
        }
        let failed = |bad| TuneError::Gradient { bad, iteration, view: view_name() };
        stepped.map_err(failed)?;
        Ok((view, loss))
    }

    /// What the fall of the learning rates along a fine-tune leaves of them.
    fn decay(&self, iteration: u32) -> f64 {
        let end = self.setup.settings.rate_end;
        let share = match self.state.extended {
            Some(_) => EXTENSION_RATE,
            None => f64::from(iteration) / f64::from(self.config.iterations.max(1)),
        };
        end + (1.0 - end) * 0.5 * (1.0 + (std::f64::consts::PI * share).cos())
    }

    fn prune_if_due(&mut self, iteration: u32) {
        let Pruning::Steps { score, goal, steps, every } = self.config.pruning else { return };
        let due = |pruned: u32| {
            pruned < steps.get() && u64::from(iteration) >= u64::from(pruned) * u64::from(every)
        };
        // Budgets with fewer iterations than steps have several at once.
        while due(self.state.pruned) {
            let left = (steps.get() - self.state.pruned) as usize;
            let surplus = self.state.model.scene.len().saturating_sub(goal);
            self.prune(score, surplus.div_ceil(left));
        }
    }

    fn prune(&mut self, score: Score, count: usize) {
        self.state.pruned += 1;
        if count == 0 {
            return;
        }
        let scores = self.part(
            |t| &mut t.scores_s,
            |tuner| {
                let read = tuner.reader.of(&tuner.state.model.scene, &tuner.state.labels);
                let views = tuner.setup.train_cameras();
                tuner.setup.renderer.score(score, read, &views)
            },
        );
        let model = &mut self.state.model;
        let kept = survivors(&scores, count);
        keep(&mut model.scene, &mut model.adam, &kept, self.setup.settings.opacity_cap);
        // Labels are by place, and places have just moved.
        if !self.state.labels.is_empty() {
            self.state.labels = kept.iter().map(|&i| self.state.labels[i as usize]).collect();
        }
        // What is left of the mean has half of its weight: others must take the place of what went.
        if let Some((mean, averaged)) = &mut self.state.average {
            select(mean, &kept);
            *averaged /= 2;
        }
        if let Some(heat) = &mut self.state.heat {
            heat.pruned();
        }
    }

    fn is_check_due(&self, iteration: u32) -> bool {
        if iteration + 1 >= self.iterations() {
            return true;
        }
        let interval = self.setup.settings.interval.max(1);
        match (self.config.display, self.config.pruning, &self.controller) {
            (DisplayTerm::Controlled { from, .. }, _, Some(controller)) if iteration >= from => {
                controller.is_due(iteration - from)
            }
            (DisplayTerm::Controlled { .. }, ..) if self.config.pace.heat <= 1.0 => false,
            (_, Pruning::WhilePassing { .. }, _) => (iteration + 1).is_multiple_of(interval),
            (_, Pruning::Never | Pruning::Steps { .. }, _) => iteration.is_multiple_of(interval),
        }
    }

    fn check(&mut self, iteration: u32, lambda: f64) -> Check {
        let setup = self.setup;
        let is_last = iteration + 1 >= self.iterations();
        let look = |tuner: &mut Self, all: bool| {
            let mut gauge = std::mem::take(&mut tuner.state.gauge);
            let shown = tuner.reader.of(tuner.state.shown(), &tuner.state.labels);
            let seen = match all {
                true => gauge.chosen(setup, shown, tuner.pooled.as_mut()),
                false => gauge.some(setup, shown, tuner.pooled.as_mut()),
            };
            tuner.state.gauge = gauge;
            seen
        };
        let mut seen = look(self, is_last);
        let mut confirmed = is_last;
        if !is_last && self.wants_confirmation(seen.quality, lambda) {
            seen = look(self, true);
            confirmed = true;
        }
        let mut check = self.checked(iteration, seen, confirmed, lambda);
        let mut is_dimming = matches!(self.config.display, DisplayTerm::Fixed(_));
        if let DisplayTerm::Controlled { from, .. } = self.config.display
            && let Some(controller) = &mut self.controller
            && iteration >= from
        {
            is_dimming = true;
            let verdict = controller.observe(iteration - from, seen.quality, &self.target);
            if verdict == LambdaVerdict::Settled && self.is_pruned() {
                // Where it ends, too, all views that choose are looked at.
                if !confirmed {
                    seen = look(self, true);
                    check = self.checked(iteration, seen, true, lambda);
                }
                self.state.settled = check.passed;
            }
        }
        if let Some(heat) = &mut self.state.heat {
            let margin_db = self.target.margin_db(seen.quality);
            heat.observe(margin_db, self.config.pace, is_dimming);
        }
        match self.config.pruning {
            Pruning::WhilePassing { most, share, .. }
                if check.sure && !is_last && self.may_prune(iteration) =>
            {
                let margin_db = self.target.margin_db(seen.quality);
                let stride = if share < 1.0 { self.state.stride.passed(margin_db) } else { 1.0 };
                let count = (share * stride * self.state.model.scene.len() as f64) as usize;
                let most = (most as f64 * stride.max(1.0)) as usize;
                self.prune(Score::Dominance, count.clamp(1, most.max(1)));
            }
            Pruning::WhilePassing { .. } => {
                self.state.stride.missed(self.target.margin_db(seen.quality));
            }
            Pruning::Never | Pruning::Steps { .. } => {}
        }
        // Whatever they show: views that do not choose say how much they differ from the others.
        let mut gauge = std::mem::take(&mut self.state.gauge);
        let shown = self.reader.of(self.state.shown(), &self.state.labels);
        gauge.correct(setup, shown, self.pooled.as_mut(), (iteration, self.config.iterations));
        self.state.gauge = gauge;
        check
    }

    /// A check of what was seen, which is remembered if its model may be kept.
    fn checked(&mut self, iteration: u32, seen: Seen, confirmed: bool, lambda: f64) -> Check {
        let (passed, sure) = (self.target.passes(seen.quality), self.is_sure(&seen));
        let check = Check { iteration, seen, passed, sure, confirmed, lambda };
        self.state.last = Some(check);
        self.state.unconfirmed = if confirmed { 0 } else { self.state.unconfirmed + 1 };
        if passed && confirmed && self.is_pruned() {
            self.remember(check);
        }
        check
    }

    /// Whether all pruning that was ordered is done.
    fn is_pruned(&self) -> bool {
        match self.config.pruning {
            Pruning::Steps { steps, .. } => self.state.pruned >= steps.get(),
            Pruning::Never | Pruning::WhilePassing { .. } => true,
        }
    }
}
