//! The jobs of one search: samples, the realised optimum, and what it is compared with. A search
//! starts from the dense model, or in the periphery from the model of the level before.

use std::num::NonZeroU32;

use xxhash_rust::xxh3::xxh3_64;

use super::{Plan, PlanLine};
use crate::job::{Job, Place};
use crate::lambda::Control;
use crate::outcome::Outcome;
use crate::prune::Score;
use crate::role::{Baseline, LEVEL, Role};
use crate::schedule::{Schedule, TakenSample};
use crate::settings::{Dimming, Settings, share_of};
use crate::slack::{SlackPrice, spent_w};
use crate::target::Target;
use crate::tune::{DisplayTerm, Keep, Objective, Pace, Pruning, Trains, TuneConfig};
use powergs_frame::fovea::POOLINGS;

/// The share of all Gaussians that goes in one step.
const STEP: f64 = 0.05;
/// The share of a fine-tune in which it prunes, and then the share in which it recovers, both with
/// the display term off.
const PRUNING: f64 = 0.25;
/// See [`PRUNING`].
const RECOVERY: f64 = 0.25;
/// Two ratios that differ by less are the same.
const SAME: f64 = 0.01;
/// The share of all Gaussians that goes at most at a time while the target is reached; with the
/// published schedule always.
const WHILE_PASSING: f64 = 0.05;
/// The share of what is left that goes at most.
const OF_WHAT_IS_LEFT: f64 = 0.05;
/// Models of so many decibels above the target bear whole learning rates between prunes.
const BEARS_ALL_DB: f64 = 1.0;
/// The factor on the learning rates of what is pruned, at least, where a prune did no damage.
const AT_REST: f64 = 0.25;

/// Samples that are taken around the minimum where all others are given.
pub(super) const AROUND: usize = 2;

/// A search at one place.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    plan: &'a Plan,
    settings: &'a Settings,
    /// Everything so far.
    done: &'a [Outcome],
    /// The finished jobs whose models are there.
    kept: &'a [&'a Outcome],
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
    let stream = xxh3_64(name.as_bytes());
    Job {
        name: name.into(),
        role,
        place,
        rho: 0.0,
        base: None,
        from: None,
        is_end: false,
        config: None,
        stream,
    }
}

impl<'a> Search<'a> {
    /// A search from the dense model, which has `points` Gaussians.
    pub fn new(
        plan: &'a Plan,
        settings: &'a Settings,
        points: usize,
        done: &'a [Outcome],
        kept: &'a [&'a Outcome],
    ) -> Search<'a> {
        let dense = done.iter().find(|o| o.role == Role::Dense);
        let watts = dense.map_or(1.0, |o| o.gate.display_w);
        let unit = if watts > 0.0 { watts.recip() } else { 1.0 };
        let start = kept.iter().copied().find(|o| o.role == Role::HeldOut);
        Search { plan, settings, done, kept, place: Place::default(), start, points, unit }
    }

    /// The same search for another quality.
    pub fn of_variant(self, variant: u8) -> Search<'a> {
        Search { place: Place { variant, level: 0 }, ..self }
    }

    /// The search of a level of the periphery; `None` until the level before has its model.
    pub fn upper(&self, line: PlanLine, level: u8) -> Option<Search<'a>> {
        let before = Place { level: level - 1, ..self.place };
        let start = self.plan.model_at(self.done, line, before)?;
        // Without it there is no target.
        let place = Place { level, ..self.place };
        self.plan.target_at(self.done, line, place)?;
        Some(Search { place, start: Some(start), points: start.points, ..*self })
    }

    /// A job of this search. `what` is its name among those of its variant and level.
    fn job(&self, what: &str, role: Role, rho: f64, config: TuneConfig) -> Job {
        let variant = match self.place.variant {
            0 => String::new(),
            v => format!("{}-", self.plan.variants[usize::from(v)].name),
        };
        let name = match self.place.level {
            0 => what.to_owned(),
            level => format!("{LEVEL}{}-{what}", level + 1),
        };
        Job {
            stream: xxh3_64(name.as_bytes()),
            name: variant + &name,
            role,
            place: self.place,
            rho,
            base: self.start.map(|o| o.points),
            from: self.start.map(|o| o.name.clone()),
            is_end: false,
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
        let is_here = |o: &&Outcome| o.role == Role::Sample && o.place == self.place;
        let samples: Vec<&Outcome> = self.done.iter().filter(is_here).collect();
        let price = self.plan.slack_price(self.done, self.place);
        let facts: Vec<TakenSample> = samples.iter().map(|o| taken(o, price)).collect();
        let (schedule, budget) = settings.budget(&self.plan.schedule, self.place.level);
        let schedule = self.around(schedule)?;
        let sample = schedule.next(&facts, settings.first_effort)?;
        let from = self.start_of(sample.from.map(|i| samples[i]), sample.rho, sample.is_end);
        let iterations = share_of(budget, sample.effort);
        let config = match sample.is_end {
            true => {
                let display = match settings.dimming {
                    Dimming::Gains => DisplayTerm::Gains { from: iterations },
                    Dimming::Term(_) => DisplayTerm::Off,
                };
                let pruned = self.while_passing(self.plain(iterations));
                TuneConfig { display, ..pruned }
            }
            false => self.iso_quality(from, sample.rho, iterations),
        };
        let what = sample_name(self.done, self.place);
        let job = self.job(&what, Role::Sample, sample.rho, config);
        Some(Self::from(from, Job { is_end: sample.is_end, ..job }))
    }

    /// The schedule, and where samples are given, one that takes a few more around the minimum.
    fn around(&self, schedule: Schedule) -> Option<Schedule> {
        let Some(given) = self.plan.given.as_ref().filter(|_| self.place.level == 0) else {
            return Some(schedule);
        };
        let given = given.get(usize::from(self.place.variant)).copied().filter(|n| *n > 0)?;
        match schedule {
            Schedule::Adaptive { first, .. } => {
                Some(Schedule::Adaptive { count: given + AROUND, first })
            }
            Schedule::Listed(_) | Schedule::Published { .. } => None,
        }
    }

    /// What a sample starts from: what the schedule says, or a model that is nearer to its ratio
    /// and was made for a higher quality, or where that of the schedule was not kept, the nearest.
    fn start_of(&self, said: Option<&'a Outcome>, rho: f64, is_end: bool) -> Option<&'a Outcome> {
        if matches!(self.plan.schedule, Schedule::Published { .. }) {
            return said;
        }
        let is_there = |o: &&Outcome| self.kept.iter().any(|k| k.name == o.name);
        let said = match said {
            Some(o) => Some(o).filter(is_there).or_else(|| self.nearest(rho, self.place.variant)),
            None => None,
        };
        // The rendering end prunes as far as it can, so that no start is pruned too far.
        let most = if is_end { 1.0 } else { rho };
        let higher = self.place.variant.checked_sub(1).and_then(|v| self.nearest(most, v));
        match (said, higher) {
            (Some(said), Some(higher)) if higher.rho <= said.rho + SAME => Some(said),
            (said, higher) => higher.or(said),
        }
    }

    /// The model that is pruned most, but not beyond `rho`, of those that were kept of this search,
    /// or at level 1 of a quality from the highest to `variant`, and reach the target.
    fn nearest(&self, rho: f64, variant: u8) -> Option<&'a Outcome> {
        let target = self.plan.target_at(self.done, None, self.place)?;
        let is_near = |o: &&&Outcome| {
            let is_own = o.place == self.place;
            let is_higher =
                (o.place.level, self.place.level) == (0, 0) && o.place.variant < self.place.variant;
            let is_ours = matches!(o.role, Role::Sample | Role::Optimum);
            is_ours
                && (is_own || is_higher)
                && o.place.variant <= variant
                && o.rho <= rho + SAME
                && target.passes(o.gate.quality)
        };
        let all = self.kept.iter().filter(is_near).copied();
        all.max_by(|a, b| a.rho.total_cmp(&b.rho))
    }

    /// The optimum made real, from the model with the highest ratio below it.
    fn realised(&self, rho: f64) -> Job {
        let iterations = self.settings.final_budget(self.place.level);
        let is_adaptive = matches!(self.plan.schedule, Schedule::Adaptive { .. });
        let from = self.nearest(rho, self.place.variant).filter(|_| is_adaptive);
        let config = self.iso_quality(from, rho, iterations);
        Self::from(from, self.job(&Role::Optimum.name(), Role::Optimum, rho, config))
    }

    /// `job` from another model than that of the search.
    fn from(from: Option<&Outcome>, job: Job) -> Job {
        Job { from: from.map(|o| o.name.clone()).or(job.from), ..job }
    }

    /// From the model of `from`, or that of the search: pruned step by step to `rho` and recovered
    /// without the display term, then with it until all the slack is spent.
    fn iso_quality(&self, from: Option<&Outcome>, rho: f64, iterations: u32) -> TuneConfig {
        let pruned = from.map_or(0.0, |o| o.rho);
        let is_published = matches!(self.plan.schedule, Schedule::Published { .. });
        // After pruning there is another slack, and another λ.
        let lambda = from.and_then(|o| o.passing_lambda);
        // Below half a Gaussian nothing is left to prune.
        let (pruning, display) = if rho - pruned < 0.5 / self.points.max(1) as f64 {
            (Pruning::Never, self.dimmed(0, lambda, iterations))
        } else if is_published {
            (self.steps(rho, 1, 0), self.dimmed(0, lambda, iterations))
        } else {
            let steps = ((rho - pruned) / STEP).ceil().max(1.0) as u32;
            let every = share_of(iterations, PRUNING) / steps;
            let every = every.min(2 * self.settings.interval);
            // The last iteration at least has the display term.
            let from =
                (every * steps + (f64::from(iterations) * RECOVERY) as u32).min(iterations - 1);
            (self.steps(rho, steps, every), self.dimmed(from, None, iterations - from))
        };
        let plain = self.plain(iterations);
        let pace = if pruning == Pruning::Never { plain.pace } else { self.pruned(plain.pace) };
        TuneConfig { pruning, display, pace, keep: Keep::Dimmest, ..plain }
    }

    /// A model to compare level 1 with.
    pub fn baseline(&self, baseline: Baseline) -> Job {
        let iterations = self.plan.compared_iterations(self.settings, baseline, 0);
        let display = self.dimmed(0, None, iterations);
        let plain = self.plain(iterations);
        let (rho, config) = match baseline {
            Baseline::RenderOnly => (0.0, self.while_passing(plain)),
            Baseline::DisplayOnly => (0.0, TuneConfig { display, keep: Keep::Dimmest, ..plain }),
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
                (0.0, TuneConfig { display, trains, keep, ..plain })
            }
        };
        let job = self.job(&baseline.name(), Role::Baseline(baseline), rho, config);
        match baseline {
            Baseline::TwoStage => Job { from: Some(Baseline::RenderOnly.name()), ..job },
            Baseline::RenderOnly | Baseline::DisplayOnly | Baseline::LightGaussian(_) => job,
        }
    }

    /// The dense model, trained on without the gate views.
    pub fn held_out(&self) -> Job {
        let job = measured(&Role::HeldOut.name(), Role::HeldOut);
        Job { config: Some(self.plain(self.settings.held_out_iterations)), ..job }
    }

    /// A baseline's model of a level of the periphery.
    pub fn upper_baseline(&self, baseline: Baseline) -> Job {
        let level = self.place.level;
        let plain = self.plain(self.plan.compared_iterations(self.settings, baseline, level));
        let config = match baseline {
            Baseline::DisplayOnly => {
                let display = self.dimmed(0, None, plain.iterations);
                TuneConfig { display, keep: Keep::Dimmest, ..plain }
            }
            Baseline::RenderOnly | Baseline::LightGaussian(_) | Baseline::TwoStage => {
                self.while_passing(plain)
            }
        };
        self.job(&baseline.name(), Role::Baseline(baseline), 0.0, config)
    }

    /// A fixed λ without pruning; `weight` is that of the display term, without unit.
    pub fn sweep(&self, weight: f64) -> Job {
        let display = DisplayTerm::Fixed(weight * self.unit);
        let config = TuneConfig { display, ..self.plain(self.settings.final_budget(0)) };
        let role = Role::Sweep(weight);
        self.job(&role.name(), role, 0.0, config)
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
            pace: match self.plan.schedule {
                Schedule::Published { .. } => Pace::PUBLISHED,
                Schedule::Adaptive { .. } | Schedule::Listed(_) => Pace::RECOVERING,
            },
        }
    }

    /// Pruned whenever it passes: a search and what it is compared with in the same steps, shorter
    /// ones where it takes long to recover. The published code takes a twentieth of all at a time.
    fn while_passing(&self, config: TuneConfig) -> TuneConfig {
        let most = (self.points as f64 * WHILE_PASSING) as usize;
        let share = match self.plan.schedule {
            Schedule::Published { .. } => 1.0,
            Schedule::Adaptive { .. } | Schedule::Listed(_) => OF_WHAT_IS_LEFT,
        };
        let pruning = Pruning::WhilePassing { most, share };
        TuneConfig { pruning, pace: self.pruned(config.pace), keep: Keep::LastPassing, ..config }
    }

    /// The pace of what is pruned where the rates follow the damage. Models arrive annealed, and
    /// whole rates shake them, on photos for good: what that adds to the error grows with the
    /// rates, and what may be added is what the intact model has above the target. In the
    /// periphery only colours and opacities move, and further.
    fn pruned(&self, pace: Pace) -> Pace {
        if self.place.level > 0 || pace.heat <= 1.0 {
            return pace;
        }
        let intact = self.plan.intact(self.done, self.place).map_or(0.0, |intact| intact.margin_db);
        Pace { rest: (intact / BEARS_ALL_DB).clamp(AT_REST, 1.0), ..pace }
    }

    /// What spends the quality above the target on the display: gains, or a display term from an
    /// iteration on, with `start` or the first λ of the place.
    fn dimmed(&self, from: u32, start: Option<f64>, iterations: u32) -> DisplayTerm {
        let settings = self.settings;
        let rule = match settings.dimming {
            Dimming::Gains => return DisplayTerm::Gains { from },
            Dimming::Term(rule) => rule,
        };
        let weight = match self.place.level {
            0 => settings.display_weight,
            _ => settings.level_display_weight,
        };
        // What the level before ended with is near, if it was a λ of the same loss.
        let before = || self.start.filter(|o| self.place.level > 1 && o.place.level > 0);
        let known = start.or_else(|| before()?.passing_lambda);
        let control = Control {
            rule,
            start: known.unwrap_or(weight * self.unit),
            is_estimated: known.is_none(),
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

/// What the next sample of a place is called, without the letter of a quality or the number of a
/// level. Of those before it some may be gone.
fn sample_name(done: &[Outcome], place: Place) -> String {
    let here = done.iter().filter(|o| o.role == Role::Sample && o.place == place);
    let number = |o: &Outcome| o.name.rsplit('-').next()?.parse::<usize>().ok();
    let last = here.filter_map(number).max().unwrap_or(0);
    format!("{}-{:02}", Role::Sample.name(), last + 1)
}

/// A sample as the schedule sees it: with its slack spent.
fn taken(o: &Outcome, price: Option<(SlackPrice, Target)>) -> TakenSample {
    TakenSample {
        rho: o.rho,
        display_w: spent_w(o, price),
        render_w: o.watts.render_w,
        passed: o.passed,
        is_end: o.is_end,
    }
}

fn goal(points: usize, rho: f64) -> usize {
    points - ((points as f64 * rho) as usize).min(points.saturating_sub(1))
}
