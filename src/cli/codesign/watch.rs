//! What is seen of a co-design while it works: a bar, a line for each model and each pair.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::super::progress::Progress;
use super::super::{Context, out};
use powergs_codesign::Codesign;
use powergs_codesign::compare::Comparison;
use powergs_codesign::fit::Fitted;
use powergs_codesign::model::ModelPoint;
use powergs_codesign::watch::CodesignWatch;
use powergs_core::run::Watch;
use powergs_optimize::tune::Iteration;
use powergs_optimize::watch::CampaignWatch;
use powergs_report::format::{engineering, shortened, wrapped};
use powergs_study::sweep::Objective;
use powergs_study::sweep::run::SweepWatch;

/// What the bar counts in fine-tunes: they end when the quality has settled.
const AT_MOST: &str = "iterations at most";
/// What it counts in sweeps.
const FRAMES: &str = "machine-frames";

/// Ctrl-C, a bar and lines on standard error.
pub struct Watched<'a> {
    context: &'a Context,
    bar: Mutex<Option<Progress>>,
    /// Models, those that are done.
    models: Mutex<(usize, usize)>,
}

fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Watched<'a> {
    /// No bar yet.
    pub fn new(context: &'a Context) -> Watched<'a> {
        Watched { context, bar: Mutex::new(None), models: Mutex::new((0, 0)) }
    }

    /// Says what is about to be done.
    pub fn begin(&self, codesign: &Codesign) {
        let campaign = &codesign.campaign;
        let text = format!(
            "{} models of {} Gaussians, {} views; {} of them decide, {} are only reported",
            codesign.models.len() - 1,
            campaign.dense.len(),
            campaign.given.count,
            campaign.gate_views(),
            campaign.split.test.len()
        );
        self.say(wrapped(&text, 80));
        for (table, why) in &codesign.machines.left_out {
            self.say(format_args!("note: the energy table `{table}` is left out: {why}"));
        }
        *held(&self.models) = (codesign.models.len(), 0);
    }

    /// Takes the bar away.
    pub fn clear(&self) {
        *held(&self.bar) = None;
    }

    fn start(&self, total: u64, what: &'static str) {
        *held(&self.bar) = Some(Progress::new(self.context, total, what));
    }

    fn advance(&self, n: u64) {
        if let Some(bar) = &*held(&self.bar) {
            bar.advance(n);
        }
    }

    fn say(&self, text: impl std::fmt::Display) {
        if !self.context.global.quiet {
            out::complain(text);
        }
    }
}

impl Watch for Watched<'_> {
    fn is_cancelled(&self) -> bool {
        self.context.is_cancelled()
    }

    fn simulated(&self, n: u64) {
        self.advance(n);
    }
}

impl SweepWatch for Watched<'_> {
    fn working(&self, machine_frames: u64, _: &[Objective]) {
        self.start(machine_frames, FRAMES);
    }

    fn known(&self, machine_frames: u64) {
        self.advance(machine_frames);
    }
}

impl CampaignWatch for Watched<'_> {
    fn rendering(&self, views: u64) {
        self.start(views, "reference images");
    }

    fn rendered(&self) {
        self.advance(1);
    }

    fn note(&self, text: &str) {
        self.clear();
        self.say(format_args!("note: {text}"));
    }

    fn warn(&self, text: &str) {
        self.say(format_args!("warning: {text}"));
    }
}

impl CodesignWatch for Watched<'_> {
    fn fitting(&self, _: usize, iterations: u64) {
        self.start(iterations, AT_MOST);
    }

    fn advanced(&self, n: u64) {
        self.advance(n);
    }

    fn iteration(&self, model: &ModelPoint, iteration: &Iteration) {
        let Some(check) = &iteration.check else { return };
        if let Some(bar) = &*held(&self.bar) {
            let quality = check.seen.quality.psnr_db;
            bar.say(format!("; {}: {quality:.2} dB", model.name()));
        }
    }

    fn fitted(&self, model: &Fitted) {
        let facts = &model.facts;
        let quality = match model.point.is_dense {
            true => "is the reference".to_owned(),
            false => format!(
                "{:.2} dB, {}",
                facts.gate.quality.psnr_db,
                if facts.passed { "ok" } else { "missed" }
            ),
        };
        self.say(format_args!(
            "{:32} {:>9} Gaussians, display {}, {quality}",
            shortened(&model.point.name(), 32),
            facts.points,
            engineering(facts.gate.display_w, "W")
        ));
    }

    fn confirmed(&self, comparison: &Comparison) {
        let text = match comparison.watts() {
            Some(watts) => engineering(watts, "W"),
            None => "nothing keeps the budget".into(),
        };
        let way = comparison.way;
        self.say(format_args!("({}) {}: {text}", way.letter(), way.words()));
    }
}
