//! What a run does: a list of jobs, each of which follows from the outcomes of those before. The
//! next job is a function of settings and outcomes alone, so a run can be continued anywhere.

use std::num::NonZeroU32;

use super::lambda::Control;
use super::prune::Score;
use super::schedule::{Done, Plan};
use super::search::{self, Conclusion};
use super::setup::Settings;
use super::target::{Target, TargetRule};
use super::tune::{DisplayTerm, Keep, Orders, Pruning};

pub use super::job::{Baseline, Ended, Job, Outcome, Role};

/// Pruning steps of the final model.
const FINAL_STEPS: u32 = 5;
/// The share of the final fine-tune in which it is pruned and the display term is off.
const FINAL_PRUNING: f64 = 0.4;
/// The share of all Gaussians that `render-only` prunes at a time.
const RENDER_ONLY_SHARE: f64 = 0.05;

/// Everything that a run is to do.
#[derive(Debug, Clone, PartialEq)]
pub struct Campaign {
    /// The samples.
    pub schedule: Plan,
    /// Comparisons, in order.
    pub baselines: Vec<Baseline>,
    /// Names of the user's other models.
    pub externals: Vec<String>,
    /// Values of λ for the sweep, in units of one over the dense model's display power.
    pub sweep: Vec<f64>,
    /// What is to be reached.
    pub rule: TargetRule,
}

impl Campaign {
    /// The most jobs that the run can have.
    pub fn most_jobs(&self) -> usize {
        let extra = self.baselines.len() + self.externals.len() + self.sweep.len();
        2 + self.schedule.count() + extra
    }

    /// The most iterations that the run can have.
    pub fn most_iterations(&self, settings: &Settings) -> u64 {
        let samples = self.schedule.most_effort(settings.first_effort);
        let samples = (samples * f64::from(settings.iterations)).ceil() as u64;
        let others = self.baselines.len() + self.sweep.len() + 1;
        samples + others as u64 * u64::from(settings.final_iterations)
    }

    /// The target, once the dense model is measured.
    pub fn target(&self, done: &[Outcome]) -> Option<Target> {
        let dense = done.iter().find(|o| o.role == Role::Dense)?;
        Some(self.rule.target(dense.gate.quality))
    }

    /// What the samples say.
    pub fn conclusion(&self, done: &[Outcome]) -> Conclusion {
        search::conclude(done, self.target(done))
    }

    /// The next job; `None` at the end. `points` is the size of the dense model.
    pub fn next(&self, settings: &Settings, points: usize, done: &[Outcome]) -> Option<Job> {
        let is_new = |job: &Job| done.iter().all(|o| o.name != job.name);
        let measured =
            |name: &str, role| Job { name: name.into(), role, rho: 0.0, from: None, orders: None };
        let dense = measured("dense", Role::Dense);
        if is_new(&dense) {
            return Some(dense);
        }
        let scale = Scale::of(settings, points, done);
        if let Some(job) = self.next_sample(&scale, done) {
            return Some(job);
        }
        if let Some(rho) = self.conclusion(done).optimum() {
            let job = final_job(&scale, rho, done);
            if is_new(&job) {
                return Some(job);
            }
        }
        let baselines = self.baselines.iter().map(|b| baseline_job(&scale, *b));
        let externals = self.externals.iter().enumerate();
        let externals = externals.map(|(i, name)| measured(name, Role::External(i)));
        let sweep = self.sweep.iter().map(|lambda| sweep_job(&scale, *lambda));
        baselines.chain(externals).chain(sweep).find(is_new)
    }

    fn next_sample(&self, scale: &Scale<'_>, done: &[Outcome]) -> Option<Job> {
        let (settings, points) = (scale.settings, scale.points);
        let samples: Vec<&Outcome> = done.iter().filter(|o| o.role == Role::Sample).collect();
        let facts: Vec<Done> = samples
            .iter()
            .map(|o| Done { rho: o.rho, total_w: o.watts.total_w(), passed: o.passed })
            .collect();
        let sample = self.schedule.next(&facts, settings.first_effort)?;
        let from = sample.from.map(|i| samples[i]);
        let start = from.filter(|o| o.passed).and_then(|o| o.passing_lambda);
        let iterations = budget(settings.iterations, sample.effort);
        let pruning = steps(points, sample.rho, 1, 0);
        let control = scale.control(start, iterations);
        Some(Job {
            name: format!("sample-{:02}", samples.len() + 1),
            role: Role::Sample,
            rho: sample.rho,
            from: from.map(|o| o.name.clone()),
            orders: Some(Orders {
                iterations,
                pruning,
                display: DisplayTerm::Controlled { from: 0, control },
                colours_only: false,
                keep: Keep::Dimmest,
            }),
        })
    }
}

fn budget(iterations: u32, effort: f64) -> u32 {
    ((f64::from(iterations) * effort).round() as u32).max(1)
}

/// What budgets and weights are in proportion to.
struct Scale<'a> {
    settings: &'a Settings,
    /// Gaussians of the dense model.
    points: usize,
    /// One over the display power of the dense model, 1/W: the unit of λ.
    unit: f64,
}

impl<'a> Scale<'a> {
    fn of(settings: &'a Settings, points: usize, done: &[Outcome]) -> Scale<'a> {
        let dense = done.iter().find(|o| o.role == Role::Dense);
        let watts = dense.map_or(1.0, |o| o.gate.display_w);
        Scale { settings, points, unit: if watts > 0.0 { watts.recip() } else { 1.0 } }
    }

    fn control(&self, start: Option<f64>, iterations: u32) -> Control {
        Control {
            rule: self.settings.rule,
            start: start.unwrap_or(self.settings.lambda * self.unit),
            interval: self.settings.interval,
            adjust: budget(iterations, self.settings.adjust_share),
            epsilon_db: self.settings.epsilon_db,
        }
    }
}

fn goal(points: usize, rho: f64) -> usize {
    points - ((points as f64 * rho) as usize).min(points.saturating_sub(1))
}

fn steps(points: usize, rho: f64, steps: u32, every: u32) -> Pruning {
    if rho <= 0.0 {
        return Pruning::Never;
    }
    let steps = NonZeroU32::new(steps).unwrap_or(NonZeroU32::MIN);
    Pruning::Steps { score: Score::Dominance, goal: goal(points, rho), steps, every }
}

/// The dense model, pruned in steps to `rho`, then tuned with the display term.
fn final_job(scale: &Scale<'_>, rho: f64, done: &[Outcome]) -> Job {
    let (points, iterations) = (scale.points, scale.settings.final_iterations.max(1));
    let pruned_by = budget(iterations, FINAL_PRUNING).min(iterations - 1);
    let near = |o: &&Outcome| o.role == Role::Sample && o.passed;
    let nearest =
        done.iter().filter(near).min_by(|a, b| (a.rho - rho).abs().total_cmp(&(b.rho - rho).abs()));
    let pruned_by = if rho > 0.0 { pruned_by } else { 0 };
    let start = nearest.and_then(|o| o.passing_lambda);
    let control = scale.control(start, iterations - pruned_by);
    Job {
        name: "final".into(),
        role: Role::Final,
        rho,
        from: None,
        orders: Some(Orders {
            iterations,
            pruning: steps(points, rho, FINAL_STEPS.min(pruned_by.max(1)), pruned_by / FINAL_STEPS),
            display: DisplayTerm::Controlled { from: pruned_by, control },
            colours_only: false,
            keep: Keep::Dimmest,
        }),
    }
}

fn baseline_job(scale: &Scale<'_>, baseline: Baseline) -> Job {
    let (points, iterations) = (scale.points, scale.settings.final_iterations.max(1));
    let controlled = DisplayTerm::Controlled { from: 0, control: scale.control(None, iterations) };
    let plain = Orders {
        iterations,
        pruning: Pruning::Never,
        display: DisplayTerm::Off,
        colours_only: false,
        keep: Keep::Last,
    };
    let count = ((points as f64 * RENDER_ONLY_SHARE) as usize).max(1);
    let (rho, from, orders) = match baseline {
        Baseline::RenderOnly => {
            let pruning = Pruning::WhilePassing { count };
            (0.0, None, Orders { pruning, keep: Keep::LastPassing, ..plain })
        }
        Baseline::DisplayOnly => {
            (0.0, None, Orders { display: controlled, keep: Keep::Dimmest, ..plain })
        }
        Baseline::LightGaussian(share) => {
            let pruning = Pruning::Steps {
                score: Score::LightGaussian,
                goal: goal(points, share),
                steps: NonZeroU32::MIN,
                every: 0,
            };
            (share, None, Orders { pruning, ..plain })
        }
        Baseline::TwoStage => {
            let from = Some(Baseline::RenderOnly.name());
            let keep = Keep::Dimmest;
            (0.0, from, Orders { display: controlled, colours_only: true, keep, ..plain })
        }
    };
    Job { name: baseline.name(), role: Role::Baseline(baseline), rho, from, orders: Some(orders) }
}

fn sweep_job(scale: &Scale<'_>, lambda: f64) -> Job {
    Job {
        name: format!("lambda-{lambda}"),
        role: Role::Sweep(lambda),
        rho: 0.0,
        from: None,
        orders: Some(Orders {
            iterations: scale.settings.final_iterations.max(1),
            pruning: Pruning::Never,
            display: DisplayTerm::Fixed(lambda * scale.unit),
            colours_only: false,
            keep: Keep::Last,
        }),
    }
}
