//! What a run does: a list of jobs, each of which follows from the outcomes of those before. The
//! next job is a function of settings and outcomes alone, so a run can be continued anywhere.

mod kept;
mod search;

use serde::Serialize;

use super::conclusion::{Conclusion, conclude, slack_price};
use super::job::{Job, Place};
use super::outcome::{Outcome, at};
use super::role::{Baseline, Role};
use super::schedule::Schedule;
use super::settings::Settings;
use super::slack::{SlackPrice, Spending};
use super::target::{Quality, Target, TargetRule};
use search::{AROUND, Search, measured};

/// A quality that models are made for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Variant {
    /// `H`, `M`, `L`, or what the user asked for.
    pub name: String,
    /// What is to be reached.
    pub rule: TargetRule,
}

/// Everything that a run is to do.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// The samples.
    pub schedule: Schedule,
    /// Comparisons, in order.
    pub baselines: Vec<Baseline>,
    /// Names of the user's other models.
    pub externals: Vec<String>,
    /// Weights of the display term that are tried without pruning. Without unit, as
    /// [`Settings::display_weight`].
    pub sweep_weights: Vec<f64>,
    /// The qualities in the order in which they are made, the highest first: each starts from what
    /// was made for those before it. At least one.
    pub variants: Vec<Variant>,
    /// Whether the dense model is first trained further without the gate views, and targets are
    /// shares of the quality that it reaches then. It may have been trained on those views, and
    /// quality that it has memorised cannot be kept.
    pub holds_out: bool,
    /// What shares are shares of, where the model that had it is not there any more: qualities over
    /// gate and test views.
    pub reference: Option<(Quality, Quality)>,
    /// How many samples of level 1 there are from the start, by quality: a few more are taken
    /// around the minimum, and no others. `None`: all samples are taken.
    pub given: Option<Vec<usize>>,
    /// Number of levels to make: 1, or with foveation as many as the views show, up to 4.
    pub levels: u8,
}

/// The models of one kind: ours, or those of a baseline.
pub type PlanLine = Option<Baseline>;

impl Plan {
    /// The most iterations that the run can have.
    pub fn most_iterations(&self, settings: &Settings) -> u64 {
        let levels = 0..self.levels;
        // What is given was trained before, and so were comparisons.
        let is_whole = self.given.is_none();
        let of_search = |level| match (is_whole, level) {
            (false, 0) => u64::from(self.further_iterations(settings)),
            (true, 0) | (_, 1..) => u64::from(self.search_iterations(settings, level)),
        };
        let of_variant = |v: usize| {
            let compared =
                self.compared(v).map(|b| u64::from(self.compared_iterations(settings, b, 0)));
            let upper = self
                .foveated_baselines()
                .flat_map(|b| levels.clone().skip(1).map(move |level| (b, level)));
            let upper = upper.map(|(b, l)| u64::from(self.compared_iterations(settings, b, l)));
            let others = if is_whole { compared.sum::<u64>() + upper.sum::<u64>() } else { 0 };
            levels.clone().map(of_search).sum::<u64>() + others
        };
        let all: u64 = (0..self.variants.len()).map(of_variant).sum();
        let held_out =
            if self.holds_out && is_whole { u64::from(settings.held_out_iterations) } else { 0 };
        let swept = self.sweep_weights.len() as u64 * u64::from(settings.final_iterations);
        held_out + all + swept
    }

    /// The most iterations that the search of a level takes, all samples and the final model.
    fn search_iterations(&self, settings: &Settings, level: u8) -> u32 {
        let (plan, budget) = settings.budget(&self.schedule, level);
        let samples = (plan.most_effort(settings.first_effort) * f64::from(budget)).ceil() as u32;
        samples.saturating_add(settings.final_budget(level))
    }

    /// The most iterations at level 1 where samples are given: those of a few more and of the final
    /// model.
    fn further_iterations(&self, settings: &Settings) -> u32 {
        let effort = match self.schedule {
            Schedule::Adaptive { first, .. } => {
                Schedule::Adaptive { count: AROUND, first }.most_effort(1.0)
            }
            Schedule::Listed(_) | Schedule::Published { .. } => 0.0,
        };
        let samples = (effort * f64::from(settings.iterations)).ceil() as u32;
        samples.saturating_add(settings.final_budget(0))
    }

    /// Iterations of a comparison: those of the whole search, where it prunes or dims for as long
    /// as the target is met; else those of the final model.
    fn compared_iterations(&self, settings: &Settings, baseline: Baseline, level: u8) -> u32 {
        match baseline {
            Baseline::RenderOnly | Baseline::DisplayOnly => self.search_iterations(settings, level),
            Baseline::TwoStage | Baseline::LightGaussian(_) => settings.final_budget(level),
        }
    }

    /// Comparisons of a variant: all for the first, those with levels for the others.
    fn compared(&self, variant: usize) -> impl Iterator<Item = Baseline> {
        let all = self.baselines.iter().copied();
        all.filter(move |b| variant == 0 || b.has_levels())
    }

    fn foveated_baselines(&self) -> impl Iterator<Item = Baseline> {
        self.baselines.iter().copied().filter(|b| self.levels > 1 && b.has_levels())
    }

    /// What targets that are shares are shares of: qualities over gate and test views; `None`
    /// before it is known.
    pub fn reference(&self, done: &[Outcome]) -> Option<(Quality, Quality)> {
        let role = if self.holds_out { Role::HeldOut } else { Role::Dense };
        let made = || done.iter().find(|o| o.role == role);
        self.reference.or_else(|| made().map(|o| (o.gate.quality, o.test.quality)))
    }

    /// What PSNR and SSIM the models of a variant must reach, once the dense model is measured.
    pub fn target(&self, done: &[Outcome], variant: u8) -> Option<Target> {
        let (gate, _) = self.reference(done)?;
        Some(self.variants.get(usize::from(variant))?.rule.target(gate))
    }

    /// What the target of a variant is over the test views: the same share of the quality that its
    /// reference has there, or the same numbers.
    pub fn test_target(&self, done: &[Outcome], variant: u8) -> Option<Target> {
        let (_, test) = self.reference(done)?;
        Some(self.variants.get(usize::from(variant))?.rule.target(test))
    }

    /// What the models of `line` must reach at a place: in the periphery, the HVSQ of their level 1
    /// at pooling 1.
    pub fn target_at(&self, done: &[Outcome], line: PlanLine, place: Place) -> Option<Target> {
        if place.level == 0 {
            return self.target(done, place.variant);
        }
        let first = self.model_at(done, line, Place { level: 0, ..place })?;
        first.gate.quality.hvsq.map(Target::Hvsq)
    }

    /// What a model of a role at a place must reach, given the quality that it has.
    pub fn judge(
        &self,
        done: &[Outcome],
        role: Role,
        place: Place,
        quality: Quality,
    ) -> Option<Target> {
        if matches!(role, Role::Dense | Role::HeldOut) {
            return self.variants.first().map(|v| v.rule.target(quality));
        }
        self.target_at(done, role.baseline(), place)
    }

    /// What the samples at a place say.
    pub fn conclusion(&self, done: &[Outcome], place: Place) -> Conclusion {
        let target = self.target_at(done, None, place);
        conclude(&at(done, place), target, self.intact(done, place))
    }

    /// The model that the searches of level 1 begin with, against the target of a place; in the
    /// periphery it was not measured.
    fn intact(&self, done: &[Outcome], place: Place) -> Option<Spending> {
        let target = self.target(done, place.variant).filter(|_| place.level == 0)?;
        let (gate, _) = self.reference(done)?;
        let role = |role: Role| done.iter().find(|o| o.role == role);
        let model = role(Role::HeldOut).or_else(|| role(Role::Dense))?;
        Some(Spending { margin_db: target.margin_db(gate), display_w: model.watts.display_w })
    }

    /// What the slack of models at a place would buy, once a sample says so.
    fn slack_price(&self, done: &[Outcome], place: Place) -> Option<(SlackPrice, Target)> {
        let target = self.target_at(done, None, place)?;
        let price = slack_price(&at(done, place), target, self.intact(done, place))?;
        Some((price, target))
    }

    /// The model of `line` that stands for a place: in the periphery that of the level before where
    /// none passed, and among ours of level 1 that of a higher quality where it takes fewer watts.
    pub fn model_at<'a>(
        &self,
        done: &'a [Outcome],
        line: PlanLine,
        place: Place,
    ) -> Option<&'a Outcome> {
        let least = |a: &&Outcome, b: &&Outcome| a.watts.total_w().total_cmp(&b.watts.total_w());
        let own = match line {
            None => {
                let best = self.conclusion(done, place).best;
                let own = best.and_then(|name| done.iter().find(|o| o.name == name));
                let higher = place.variant.checked_sub(1).filter(|_| place.level == 0);
                let higher =
                    higher.and_then(|v| self.model_at(done, None, Place { variant: v, level: 0 }));
                let target = self.target(done, place.variant);
                let higher = higher.filter(|o| target.is_some_and(|t| t.passes(o.gate.quality)));
                own.into_iter().chain(higher).min_by(least)
            }
            Some(b) => done
                .iter()
                .find(|o| o.role == Role::Baseline(b) && o.place == place)
                .filter(|o| o.passed || place.level == 0),
        };
        match place.level.checked_sub(1) {
            Some(level) if own.is_none() => self.model_at(done, line, Place { level, ..place }),
            _ => own,
        }
    }

    /// The model that the run ends with at a quality: ours, or a comparison that was trained beside
    /// it and passed with fewer watts. Then the search has missed it, and says so.
    pub fn result<'a>(&self, done: &'a [Outcome], variant: u8) -> Option<&'a Outcome> {
        let place = Place { variant, level: 0 };
        let compared =
            done.iter().filter(|o| o.place == place && o.passed && o.role.baseline().is_some());
        let ours = self.model_at(done, None, place).into_iter();
        ours.chain(compared).min_by(|a, b| a.watts.total_w().total_cmp(&b.watts.total_w()))
    }

    /// The next job; `None` at the end. `points` is the size of the dense model.
    pub fn next(&self, settings: &Settings, points: usize, done: &[Outcome]) -> Option<Job> {
        let is_new = |job: &Job| done.iter().all(|o| o.name != job.name);
        // Targets and ratios are relative to what the dense model has.
        let dense = measured(&Role::Dense.name(), Role::Dense);
        if is_new(&dense) {
            return Some(dense);
        }
        let kept = self.kept(points, done);
        let first = Search::new(self, settings, points, done, &kept);
        let held_out = first.held_out();
        if self.holds_out && is_new(&held_out) {
            return Some(held_out);
        }
        // All of one quality before the next, which may start from any model of it.
        for variant in 0..self.variants.len() as u8 {
            let search = first.of_variant(variant);
            let own = || search.next().filter(is_new);
            let compared = || self.compared(usize::from(variant));
            let baselines = || compared().map(|b| search.baseline(b)).find(is_new);
            let upper = || self.next_upper(&search, &is_new);
            if let Some(job) = own().or_else(baselines).or_else(upper) {
                return Some(job);
            }
        }
        let externals = self.externals.iter().enumerate();
        let externals = externals.map(|(i, name)| measured(name, Role::External(i)));
        let sweep = self.sweep_weights.iter().map(|lambda| first.sweep(*lambda));
        externals.chain(sweep).find(is_new)
    }

    /// The next job in the periphery of a variant.
    fn next_upper(&self, first: &Search<'_>, is_new: &dyn Fn(&Job) -> bool) -> Option<Job> {
        let ours = (1..self.levels).find_map(|level| first.upper(None, level)?.next());
        ours.filter(is_new).or_else(|| {
            self.foveated_baselines().find_map(|b| {
                let job = |level| Some(first.upper(Some(b), level)?.upper_baseline(b));
                (1..self.levels).filter_map(job).find(is_new)
            })
        })
    }
}
