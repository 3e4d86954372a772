//! What an optimisation leaves: tables, charts and a summary, as functions from its outcomes.

mod balance;
mod breakdown;
mod course;
pub mod foveated;
mod plane;
mod quality;
mod ratio;
mod strip;
mod summary;
mod sweep;
mod tables;

use super::fit::MadeOptimum;
use super::format::shortened;
use powergs_chart::{Chart, Colour};
use powergs_optimize::campaign::{Campaign, Finished};
use powergs_optimize::conclusion::Conclusion;
use powergs_optimize::counted::PowerCounted;
use powergs_optimize::history::rows_of;
use powergs_optimize::job::Place;
use powergs_optimize::judged::JudgedSize;
use powergs_optimize::next_quality::{NextQuality, next_quality};
use powergs_optimize::outcome::Outcome;
use powergs_optimize::pictures::BeforeAfter;
use powergs_optimize::plan::Variant;
use powergs_optimize::ratio_study::RatioRow;
use powergs_optimize::results::LostRecord;
use powergs_optimize::role::{Baseline, Role};
use powergs_optimize::target::{Quality, Target, TargetRule};
use powergs_optimize::tune::Iteration;
use powergs_optimize::views::{Priced, TrainingDistance};

pub use course::Moment;
use summary::short_of;
pub use summary::{Facts, document};
pub use tables::{models_csv, ratios_csv, samples_csv};

/// Everything that the charts and the summary of a run show.
#[derive(Debug, Clone)]
pub struct Story<'a> {
    /// Name of the scene.
    pub name: String,
    /// What counted the power: a machine, or `paper`.
    pub oracle: String,
    /// By which counts, whether standby is in them, and how the panel was scaled.
    pub counted: PowerCounted,
    /// The panel.
    pub display: String,
    /// Frames shown per second.
    pub fps: f64,
    /// What power was counted over.
    pub priced: Priced,
    /// The sizes of what trains and of what gates and tests.
    pub judged: JudgedSize,
    /// The outcomes of the quality of the run at level 1, in order.
    pub done: &'a [Outcome],
    /// The outcomes of all qualities and levels, in order.
    pub all: &'a [Outcome],
    /// The qualities, first that of the run.
    pub grades: Vec<Grade>,
    /// What was to be reached over the gate views, if the dense model was measured.
    pub target: Option<Quality>,
    /// What that is over the test views: the same share of what the reference has there, or the
    /// same numbers.
    pub test_target: Option<Quality>,
    /// What was asked for, in words.
    pub asked: String,
    /// Number of gate and of test views.
    pub views: (usize, usize),
    /// Gate views of these that were made between the others.
    pub made: usize,
    /// How far these and the test views are from those that train.
    pub distance: Option<TrainingDistance>,
    /// The views in which the result lost most.
    pub lost: &'a [LostRecord],
    /// Iterations of a sample that were asked for, at most.
    pub iterations: u32,
    /// What the samples say.
    pub conclusion: &'a Conclusion,
    /// Checks of the quality, in order.
    pub course: Vec<Moment>,
    /// The study of display-to-render ratios; empty if it was not asked for.
    pub ratios: Vec<RatioRow>,
    /// Pictures of one view.
    pub strip: Option<BeforeAfter>,
}

/// A quality that models were made for: H, M, L, or one of the user's own.
#[derive(Debug, Clone, PartialEq)]
pub struct Grade {
    /// Its name.
    pub name: String,
    /// Position among the qualities of the run.
    pub variant: u8,
    /// The job that made its model, ours or a comparison with fewer watts; `None` if none reached
    /// it.
    pub result: Option<String>,
    /// What it had to reach over the gate views, if the dense model was measured.
    pub target: Option<Quality>,
    /// What the next lower quality would buy.
    pub next: Option<NextQuality>,
}

impl Grade {
    /// The file of its model in the run folder.
    pub fn file(&self) -> String {
        if self.variant == 0 { "final.ply".into() } else { format!("final-{}.ply", self.name) }
    }

    /// Those of a campaign.
    fn all(campaign: &Campaign, outcomes: &[Outcome]) -> Vec<Grade> {
        let (plan, is_own) = (&campaign.plan, campaign.references.is_own());
        let of = |(variant, quality): (u8, &Variant)| Grade {
            name: quality.name.clone(),
            variant,
            result: plan.result(outcomes, variant).map(|o| o.name.clone()),
            target: plan.target(outcomes, variant).and_then(|t| t.likeness_target()),
            next: next_quality(plan, outcomes, variant, is_own),
        };
        (0..).zip(&campaign.plan.variants).map(of).collect()
    }
}

impl<'a> Story<'a> {
    /// What a finished campaign says; `done` are its outcomes of level 1
    /// ([`Finished::first`]), whose report is the same with and without levels beyond it.
    pub fn of(campaign: &Campaign, finished: &'a Finished, done: &'a [Outcome]) -> Story<'a> {
        Story {
            name: campaign.name.clone(),
            oracle: campaign.oracle.name(),
            counted: campaign.counted,
            display: campaign.display.name.clone(),
            fps: campaign.oracle.fps(),
            priced: campaign.priced.clone(),
            judged: campaign.judged,
            done,
            all: &finished.outcomes,
            grades: Grade::all(campaign, &finished.outcomes),
            target: campaign.plan.target(done, 0).and_then(|t| t.likeness_target()),
            test_target: campaign.plan.test_target(done, 0).and_then(|t| t.likeness_target()),
            asked: asked(campaign),
            views: (campaign.gate_views(), campaign.split.test.len()),
            made: campaign.split.made,
            distance: campaign.training_distance(),
            lost: &finished.results.lost,
            iterations: campaign.settings.iterations,
            conclusion: &finished.conclusion,
            course: course(finished),
            ratios: finished.ratios.clone(),
            strip: finished.pictures.clone(),
        }
    }
}

/// What the first quality of a campaign asks for: a share says of what.
pub fn asked(campaign: &Campaign) -> String {
    let plan = &campaign.plan;
    match plan.variants.first().map(|v| v.rule) {
        Some(TargetRule::Share(share)) => {
            let of = match plan.holds_out || plan.reference.is_some() {
                true => "held-out, the dense model trained on without the gate views",
                false => "the dense model",
            };
            format!("{} % of the PSNR and SSIM of {of}", super::format::significant(100.0 * share))
        }
        Some(TargetRule::Absolute(target)) => summary::quality(target),
        None => String::new(),
    }
}

/// The checks of the samples and of the final model.
fn course(finished: &Finished) -> Vec<Moment> {
    let is_shown =
        |o: &Outcome| o.place == Place::default() && matches!(o.role, Role::Sample | Role::Optimum);
    let moment = |(outcome, iteration): (&Outcome, &Iteration)| {
        Some(Moment {
            job: outcome.name.clone(),
            iteration: iteration.iteration,
            lambda: iteration.lambda,
            points: iteration.points,
            psnr_db: iteration.check?.seen.quality.psnr_db,
        })
    };
    rows_of(&finished.history, &finished.outcomes, is_shown).filter_map(moment).collect()
}

impl Story<'_> {
    fn chart(&self, name: &'static str, title: &'static str, what: &str) -> Chart {
        let what = format!("{}; {what}", self.priced);
        let subtitle = subtitle(&self.name, &self.oracle, self.fps, &what);
        Chart::new(name, title, subtitle).note(power_note(&self.counted, &self.oracle))
    }

    /// How the watts are counted, in a sentence without an end.
    fn counted(&self) -> String {
        let by = self.counted.by_what(&shortened(&self.oracle, 24));
        format!("{by}; {}", self.counted.panel(&self.display))
    }

    /// By how many decibels the test views, which chose nothing, are below what was asked for;
    /// `None` where that is little or nothing.
    fn short_of_promise(&self) -> Option<f64> {
        let target = Target::Likeness(self.test_target?);
        let short_db = target.shortfall(self.result()?.test.quality).psnr_db;
        Some(short_db).filter(|db| *db > PROMISED_DB)
    }

    fn of_role(&self, role: Role) -> Option<&Outcome> {
        self.done.iter().find(|o| o.role == role)
    }

    fn samples(&self) -> impl Iterator<Item = &Outcome> {
        self.done.iter().filter(|o| o.role == Role::Sample)
    }

    /// The model of a quality.
    fn result_of(&self, grade: &Grade) -> Option<&Outcome> {
        self.all.iter().find(|o| Some(&o.name) == grade.result.as_ref())
    }

    /// The model that the run ends with.
    fn result(&self) -> Option<&Outcome> {
        self.result_of(self.grades.first()?)
    }

    /// The best model of the search itself.
    fn ours(&self) -> Option<&Outcome> {
        let name = self.conclusion.best.as_ref()?;
        self.all.iter().find(|o| o.name == *name)
    }
}

/// What stands under a chart with watts: those of another count are others.
fn power_note(counted: &PowerCounted, oracle: &str) -> String {
    let by = counted.by_what(&shortened(oracle, 24));
    match counted.display_ratio {
        None => format!("Power by {by}; the panel as it is."),
        Some(ratio) => {
            format!("Power by {by}; the panel scaled to a display-to-render ratio of {ratio}.")
        }
    }
}

/// A line about a scene, what counts its power, and frames shown per second.
fn subtitle(scene: &str, oracle: &str, fps: f64, what: &str) -> String {
    let scene = shortened(scene, 24);
    let oracle = shortened(oracle, 20);
    let oracle = if oracle == "paper" { "the paper model".into() } else { oracle };
    let fps = super::format::rate(fps);
    format!("{scene} on {oracle} at {fps} FPS, {what}")
}

/// All charts that the run has data for, in the order of the summary.
pub fn charts(story: &Story<'_>) -> Vec<Chart> {
    let charts = [
        curves(story),
        plane::chart(story),
        quality::chart(story),
        breakdown::chart(story),
        course::chart(story),
        strip::chart(story),
        ratio::chart(story),
        sweep::chart(story),
    ];
    charts.into_iter().flatten().collect()
}

/// D and R with their fits, and the total with its minimum and the model that was made there.
fn curves(story: &Story<'_>) -> Option<Chart> {
    let fit = story.conclusion.fit.as_ref().ok()?;
    let passed = |rho: f64| story.samples().any(|o| o.rho == rho && o.passed);
    let name = format!("{} over {}", shortened(&story.name, 16), story.priced);
    let made = story.of_role(Role::Optimum);
    let made = made.map(|o| MadeOptimum { rho: o.rho, total_w: o.watts.total_w() });
    let note = power_note(&story.counted, &story.oracle);
    let chart = super::fit::chart_of(fit, &name, &passed, made);
    Some(Chart { name: "curves", ..chart }.note(note))
}

/// The colour of a model in every chart.
fn colour(role: Role) -> Colour {
    match role {
        // Models that nobody has pruned or dimmed for this target.
        Role::Dense | Role::HeldOut | Role::External(_) => Colour::INK,
        Role::Sample => Colour::SKY,
        Role::Optimum => Colour::YELLOW,
        Role::Baseline(Baseline::RenderOnly) => Colour::ORANGE,
        Role::Baseline(Baseline::DisplayOnly) => Colour::BLUE,
        Role::Baseline(Baseline::TwoStage) => Colour::PURPLE,
        Role::Baseline(Baseline::LightGaussian(_)) => Colour::GREEN,
        Role::Sweep(_) => Colour::GREY,
    }
}

/// Test views that are so far below what was asked for are told beside the watts, decibels.
const PROMISED_DB: f64 = 0.3;
/// PSNR from which a model is its own reference, decibels: what is left is rounding.
const ITSELF: f64 = 100.0;

impl Story<'_> {
    /// The name of a model in all charts and tables; that of the result says so.
    fn label(&self, outcome: &Outcome) -> String {
        let name = shortened(&outcome.name, 24);
        if self.is_result(outcome) { format!("result ({name})") } else { name }
    }

    /// Whether a model reaches the target of the run over the gate views. The dense model and the
    /// one that shares are shares of are measured before there is a target.
    fn passed(&self, outcome: &Outcome) -> bool {
        match outcome.role {
            Role::Dense | Role::HeldOut => {
                let target = self.target.map(Target::Likeness);
                target.is_some_and(|target| target.passes(outcome.gate.quality))
            }
            Role::Sample
            | Role::Optimum
            | Role::Baseline(_)
            | Role::External(_)
            | Role::Sweep(_) => outcome.passed,
        }
    }

    fn is_result(&self, outcome: &Outcome) -> bool {
        self.result().is_some_and(|result| result.name == outcome.name)
    }

    /// The colour of a model: that of the result, grey for samples that missed, else by its role.
    fn colour(&self, outcome: &Outcome) -> Colour {
        let is_own = matches!(outcome.role, Role::Sample | Role::Optimum);
        if self.is_result(outcome) {
            RESULT
        } else if is_own && !outcome.passed {
            MISSED
        } else {
            colour(outcome.role)
        }
    }
}

/// Decimals of powers in a table whose unit is so many a watt: parts of a few milliwatts are told.
fn decimals(per_watt: f64) -> usize {
    if per_watt > 1.0 { 2 } else { 3 }
}

/// The colour of the model that the run ends with.
const RESULT: Colour = Colour::VERMILION;
/// The colour of models that missed the target.
const MISSED: Colour = Colour::GREY;
