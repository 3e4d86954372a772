//! The jobs of one search: samples, the realised optimum, and what it is compared with. A search
//! starts from the dense model, or in the periphery from the model of the level before.

use std::num::NonZeroU32;

use super::{Line, Plan};
use crate::job::{Job, Place};
use crate::lambda::Control;
use crate::outcome::{Outcome, at};
use crate::prune::Score;
use crate::role::{Baseline, Role};
use crate::schedule::TakenSample;
use crate::settings::{Settings, share_of};
use crate::tune::{DisplayTerm, Keep, Objective, Pruning, Trains, TuneConfig};
use powergs_frame::fovea::POOLINGS;

/// Pruning steps of the final model.
const FINAL_STEPS: u32 = 5;
/// The share of the final fine-tune that prunes, with the display term off.
const FINAL_PRUNING: f64 = 0.4;
/// The share of all Gaussians that `render-only` prunes at a time.
const RENDER_ONLY_SHARE: f64 = 0.05;

/// A search at one place.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    plan: &'a Plan,
    settings: &'a Settings,
    /// Everything so far.
    done: &'a [Outcome],
    place: Place,
    /// The job whose model it starts from; `None`: the dense model.
    start: Option<&'a Outcome>,
    /// Gaussians of that model: ratios are shares of them.
    points: usize,
    /// One over the display power of the dense model, 1/W: the unit of λ.
    unit: f64,
}

/// A job that trains nothing.
pub(super) fn measured(name: &str, role: Role) -> Job {
    let place = Place::default();
    Job { name: name.into(), role, place, rho: 0.0, base: None, from: None, config: None }
}

impl<'a> Search<'a> {
    /// A search from the dense model, which has `points` Gaussians.
    pub fn new(
        plan: &'a Plan,
        settings: &'a Settings,
        points: usize,
        done: &'a [Outcome],
    ) -> Search<'a> {
        let dense = done.iter().find(|o| o.role == Role::Dense);
        let watts = dense.map_or(1.0, |o| o.gate.display_w);
        let unit = if watts > 0.0 { watts.recip() } else { 1.0 };
        let start = done.iter().find(|o| o.role == Role::HeldOut);
        Search { plan, settings, done, place: Place::default(), start, points, unit }
    }

    /// The same search for another quality.
    pub fn of_variant(self, variant: u8) -> Search<'a> {
        Search { place: Place { variant, level: 0 }, ..self }
    }

    /// The search of a level of the periphery; `None` until the level before has its model.
    pub fn upper(&self, line: Line, level: u8) -> Option<Search<'a>> {
        let before = Place { level: level - 1, ..self.place };
        let start = self.plan.model_at(self.done, line, before)?;
        // Without it there is no target.
        let place = Place { level, ..self.place };
        self.plan.target_at(self.done, line, place)?;
        Some(Search { place, start: Some(start), points: start.points, ..*self })
    }

    fn name(&self, what: &str) -> String {
        let variant = match self.place.variant {
            0 => String::new(),
            v => format!("{}-", self.plan.variants[usize::from(v)].name),
        };
        match self.place.level {
            0 => format!("{variant}{what}"),
            level => format!("{variant}L{}-{what}", level + 1),
        }
    }

    /// A job of this search, named after its role.
    fn job(&self, role: Role, rho: f64, config: TuneConfig) -> Job {
        Job {
            name: self.name(&role.name()),
            role,
            place: self.place,
            rho,
            base: self.start.map(|o| o.points),
            from: self.start.map(|o| o.name.clone()),
            config: Some(config),
        }
    }

    /// The next sample or the final model; `None` if nothing is left, or a job that is done.
    pub fn next(&self) -> Option<Job> {
        self.sample().or_else(|| {
            let rho = self.plan.conclusion(self.done, self.place).rho?;
            Some(self.realised(rho)).filter(|job| self.done.iter().all(|o| o.name != job.name))
        })
    }

    fn sample(&self) -> Option<Job> {
        let settings = self.settings;
        let here = at(self.done, self.place);
        let samples: Vec<&Outcome> = here.iter().filter(|o| o.role == Role::Sample).collect();
        let facts: Vec<TakenSample> = samples
            .iter()
            .map(|o| TakenSample { rho: o.rho, total_w: o.watts.total_w(), passed: o.passed })
            .collect();
        let (schedule, budget) = settings.budget(&self.plan.schedule, self.place.level);
        let sample = schedule.next(&facts, settings.first_effort)?;
        let from = sample.from.map(|i| samples[i]);
        let lambda = from.filter(|o| o.passed).and_then(|o| o.passing_lambda);
        let iterations = share_of(budget, sample.effort);
        let display = self.controlled(0, lambda, iterations);
        let pruning = self.steps(sample.rho, 1, 0);
        let config = TuneConfig { pruning, display, keep: Keep::Dimmest, ..self.plain(iterations) };
        let name = self.name(&format!("{}-{:02}", Role::Sample.name(), samples.len() + 1));
        let job = Job { name, ..self.job(Role::Sample, sample.rho, config) };
        Some(match from {
            Some(from) => Job { from: Some(from.name.clone()), ..job },
            None => job,
        })
    }

    /// The starting model, pruned in steps to `rho`, then tuned with the display term.
    fn realised(&self, rho: f64) -> Job {
        let iterations = self.settings.final_budget(self.place.level);
        let pruned_by = share_of(iterations, FINAL_PRUNING).min(iterations - 1);
        let here = at(self.done, self.place);
        let near = |o: &&Outcome| o.role == Role::Sample && o.passed;
        let distance = |o: &Outcome| (o.rho - rho).abs();
        let nearest = here.iter().filter(near).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let pruned_by = if rho > 0.0 { pruned_by } else { 0 };
        let lambda = nearest.and_then(|o| o.passing_lambda);
        let steps = FINAL_STEPS.min(pruned_by.max(1));
        let config = TuneConfig {
            pruning: self.steps(rho, steps, pruned_by / FINAL_STEPS),
            display: self.controlled(pruned_by, lambda, iterations - pruned_by),
            keep: Keep::Dimmest,
            ..self.plain(iterations)
        };
        self.job(Role::Optimum, rho, config)
    }

    /// A model to compare level 1 with.
    pub fn baseline(&self, baseline: Baseline) -> Job {
        let iterations = self.settings.final_budget(0);
        let controlled = self.controlled(0, None, iterations);
        let plain = self.plain(iterations);
        let (rho, config) = match baseline {
            Baseline::RenderOnly => (0.0, self.while_passing(plain)),
            Baseline::DisplayOnly => {
                (0.0, TuneConfig { display: controlled, keep: Keep::Dimmest, ..plain })
            }
            Baseline::LightGaussian(percent) => {
                let share = f64::from(percent) / 100.0;
                let pruning = Pruning::Steps {
                    score: Score::LightGaussian,
                    goal: goal(self.points, share),
                    steps: NonZeroU32::MIN,
                    every: 0,
                };
                (share, TuneConfig { pruning, ..plain })
            }
            Baseline::TwoStage => {
                let trains = Trains::Colours;
                let keep = Keep::Dimmest;
                (0.0, TuneConfig { display: controlled, trains, keep, ..plain })
            }
        };
        let job = self.job(Role::Baseline(baseline), rho, config);
        match baseline {
            Baseline::TwoStage => Job { from: Some(Baseline::RenderOnly.name()), ..job },
            Baseline::RenderOnly | Baseline::DisplayOnly | Baseline::LightGaussian(_) => job,
        }
    }

    /// The dense model, trained on without the gate views.
    pub fn held_out(&self) -> Job {
        let job = measured(&Role::HeldOut.name(), Role::HeldOut);
        Job { config: Some(self.plain(self.settings.first_budget())), ..job }
    }

    /// A baseline's model of a level of the periphery.
    pub fn upper_baseline(&self, baseline: Baseline) -> Job {
        let plain = self.plain(self.settings.final_budget(self.place.level));
        let config = match baseline {
            Baseline::DisplayOnly => {
                let display = self.controlled(0, None, plain.iterations);
                TuneConfig { display, keep: Keep::Dimmest, ..plain }
            }
            Baseline::RenderOnly | Baseline::LightGaussian(_) | Baseline::TwoStage => {
                self.while_passing(plain)
            }
        };
        self.job(Role::Baseline(baseline), 0.0, config)
    }

    /// A fixed λ without pruning; `weight` is that of the display term, without unit.
    pub fn sweep(&self, weight: f64) -> Job {
        let display = DisplayTerm::Fixed(weight * self.unit);
        let config = TuneConfig { display, ..self.plain(self.settings.final_budget(0)) };
        self.job(Role::Sweep(weight), 0.0, config)
    }

    /// TuneConfig that neither prune nor dim.
    fn plain(&self, iterations: u32) -> TuneConfig {
        let (objective, trains) = match self.place.level {
            0 => (Objective::Likeness, Trains::All),
            level => {
                let pooling = POOLINGS[usize::from(level)];
                (Objective::Hvsq { pooling }, Trains::ColoursAndOpacities)
            }
        };
        TuneConfig {
            iterations,
            pruning: Pruning::Never,
            display: DisplayTerm::Off,
            objective,
            trains,
            keep: Keep::Last,
        }
    }

    fn while_passing(&self, config: TuneConfig) -> TuneConfig {
        let count = ((self.points as f64 * RENDER_ONLY_SHARE) as usize).max(1);
        TuneConfig { pruning: Pruning::WhilePassing { count }, keep: Keep::LastPassing, ..config }
    }

    /// A display term from an iteration on, with `start` or the first λ of the place.
    fn controlled(&self, from: u32, start: Option<f64>, iterations: u32) -> DisplayTerm {
        let settings = self.settings;
        let first = || match self.place.level {
            0 => settings.display_weight * self.unit,
            // What the level before ended with is near.
            level if level > 1 => self
                .start
                .and_then(|o| o.passing_lambda)
                .unwrap_or(settings.level_display_weight * self.unit),
            _ => settings.level_display_weight * self.unit,
        };
        let control = Control {
            rule: settings.rule,
            start: start.unwrap_or_else(first),
            interval: settings.interval,
            adjust: share_of(iterations, settings.adjust_share),
            epsilon_db: settings.epsilon_db,
        };
        DisplayTerm::Controlled { from, control }
    }

    fn steps(&self, rho: f64, steps: u32, every: u32) -> Pruning {
        if rho <= 0.0 {
            return Pruning::Never;
        }
        let steps = NonZeroU32::new(steps).unwrap_or(NonZeroU32::MIN);
        let goal = goal(self.points, rho);
        Pruning::Steps { score: Score::Dominance, goal, steps, every }
    }
}

fn goal(points: usize, rho: f64) -> usize {
    points - ((points as f64 * rho) as usize).min(points.saturating_sub(1))
}
