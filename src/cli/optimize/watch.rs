//! What is seen of a run while it works: a bar, a line for each model, and `history.csv`.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::super::background::Background;
use super::super::progress::Progress;
use super::super::{Context, Exit, Failure, OrExit, out};
use powergs_core::run::Watch;
use powergs_optimize::job::Place;
use powergs_optimize::outcome::Outcome;
use powergs_optimize::role::Role;
use powergs_optimize::times::Times;
use powergs_optimize::tune::{Check, Iteration};
use powergs_optimize::watch::CampaignWatch;
use powergs_report::format::{engineering, shortened, time};
use powergs_scene::Camera;

/// PSNR from which a model is its own reference, decibels.
const ITSELF: f64 = 100.0;
/// Less time is not worth a word, seconds.
const NOTHING: f64 = 0.1;
/// The history of all iterations.
const HISTORY: &str = "history.csv";
/// What the bar counts: fine-tunes end when the quality has settled, and nobody knows when.
const AT_MOST: &str = "iterations at most";
/// Its columns.
const COLUMNS: &str = "job,iteration,view,gaussians,loss,l1,ssim,psnr_db,lambda,display_w,\
                       gate_psnr_db,gate_ssim,gate_display_w,gate_passed,hvsq,gate_hvsq\n";

/// Ctrl-C, a bar, notes and the history.
pub struct Watched<'a> {
    context: &'a Context,
    began: Instant,
    /// With photos: what the dense model must show on them.
    gate: Option<PhotoGate>,
    /// PSNR of a dense model that has less.
    unlike: Mutex<Option<f64>>,
    bar: Mutex<Option<Progress>>,
    /// Power of the dense model and the least that passed, watts.
    watts: Mutex<Option<(f64, Option<f64>)>>,
    history: Mutex<Option<History>>,
}

/// Whether photos show what the dense model shows.
#[derive(Debug, Clone, Copy)]
pub struct PhotoGate {
    /// PSNR that it must have on them, decibels.
    pub least_db: f64,
    /// What it is shown over.
    pub background: Background,
}

/// `history.csv`, written anew whenever a run begins or goes on.
struct History {
    file: File,
    place: String,
    /// Names of the views, as cells.
    views: Vec<String>,
    /// The first failure; nothing is written after it.
    failure: Option<Failure>,
}

impl<'a> Watched<'a> {
    /// Without a history, which the folder may not be there for.
    pub fn new(context: &'a Context, gate: Option<PhotoGate>) -> Watched<'a> {
        let (unlike, bar, watts) = Default::default();
        let (began, history) = (Instant::now(), Mutex::new(None));
        Watched { context, began, gate, unlike, bar, watts, history }
    }

    /// Begins `history.csv` in a run folder.
    ///
    /// # Errors
    /// Exit code 2: it cannot be written.
    pub fn record(&self, folder: &Path, cameras: &[Camera]) -> Result<(), Failure> {
        let path = folder.join(HISTORY);
        let place = path.display().to_string();
        let mut file = File::create(&path).or_exit(Exit::Usage, &place)?;
        file.write_all(COLUMNS.as_bytes()).or_exit(Exit::Usage, &place)?;
        let cell = |camera: &Camera| camera.name.replace([',', '"', '\n', '\r'], "_");
        let views = cameras.iter().map(cell).collect();
        *held(&self.history) = Some(History { file, place, views, failure: None });
        Ok(())
    }

    /// Ends the bar.
    ///
    /// # Errors
    /// Exit code 2: the history could not be written; 3: photos that show something else than the
    /// model.
    pub fn finish(self) -> Result<(), Failure> {
        if let (Some(db), Some(PhotoGate { least_db, background })) =
            (*held(&self.unlike), self.gate)
        {
            let what = format!(
                "the photos do not show what the model shows: its PSNR over the gate views is \
                 {db:.2} dB, less than {least_db} dB, over a {background} background; give the \
                 photos and cameras that the model was trained on, and its --background, or go on \
                 all the same with --least-likeness 0"
            );
            return Err(Failure::new(Exit::BadInput, what));
        }
        match held(&self.history).take().and_then(|history| history.failure) {
            Some(failure) => Err(failure),
            None => Ok(()),
        }
    }

    fn bar(&self, total: u64, what: &'static str) {
        *held(&self.bar) = Some(Progress::new(self.context, total, what));
    }

    fn advance(&self, n: u64) {
        if let Some(bar) = &*held(&self.bar) {
            bar.advance(n);
        }
    }

    /// Puts the last check and the best model so far behind the bar.
    fn show(&self, job: &str, check: &Check) {
        let quality = match check.seen.quality.hvsq {
            Some(hvsq) => format!("HVSQ {hvsq:.3e}"),
            None => format!("{:.2} dB", check.seen.quality.psnr_db),
        };
        let best = match *held(&self.watts) {
            Some((dense, Some(best))) => {
                format!("; best {} of {}", engineering(best, "W"), engineering(dense, "W"))
            }
            Some((_, None)) | None => String::new(),
        };
        if let Some(bar) = &*held(&self.bar) {
            let display = engineering(check.seen.display_w, "W");
            bar.say(format!("; {job}: {quality}, display {display}{best}"));
        }
    }

    fn say(&self, text: impl std::fmt::Display) {
        if !self.context.global.quiet {
            out::complain(text);
        }
    }
}

fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Watch for Watched<'_> {
    fn is_cancelled(&self) -> bool {
        let has_failed = |history: &History| history.failure.is_some();
        self.context.is_cancelled()
            || held(&self.unlike).is_some()
            || held(&self.history).as_ref().is_some_and(has_failed)
    }
}

impl CampaignWatch for Watched<'_> {
    fn rendering(&self, views: u64) {
        self.bar(views, "reference images");
    }

    fn rendered(&self) {
        self.advance(1);
    }

    fn planned(&self, iterations: u64) {
        self.bar(iterations, AT_MOST);
    }

    fn advanced(&self, n: u64) {
        self.advance(n);
    }

    fn seconds(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    fn took(&self, times: &Times) {
        let all = times.total_s();
        // A run that had all of its models took no time.
        if all < NOTHING {
            return;
        }
        let share = |part: f64| format!("{:.0} %", 100.0 * part / all);
        self.say(format_args!(
            "{}: iterations {}, checks {}, scores for pruning {}, measuring models {}",
            time(all),
            share(times.iterations_s),
            share(times.checks_s),
            share(times.scores_s),
            share(times.models_s)
        ));
    }

    fn iteration(&self, job: &str, iteration: &Iteration) {
        if let Some(check) = &iteration.check {
            self.show(job, check);
        }
        let mut history = held(&self.history);
        if let Some(history) = history.as_mut().filter(|h| h.failure.is_none()) {
            let line = line(job, &history.views[iteration.view], iteration);
            let written = history.file.write_all(line.as_bytes());
            history.failure = written.or_exit(Exit::Usage, &history.place).err();
        }
    }

    fn outcome(&self, outcome: &Outcome) {
        if outcome.role == Role::Dense {
            let power = "total = accelerator + display";
            self.say(format_args!(
                "{:17} {:>9} {:>8} {:6} {:6} {power}",
                "model", "Gaussians", "gate, dB", "SSIM", "target"
            ));
            let db = outcome.gate.quality.psnr_db;
            if self.gate.is_some_and(|gate| db < gate.least_db) {
                *held(&self.unlike) = Some(db);
            }
        }
        let q = &outcome.gate.quality;
        let w = &outcome.watts;
        if outcome.place == Place::default() {
            let mut watts = held(&self.watts);
            let (dense, best) = watts.unwrap_or((w.total_w(), None));
            let ours = matches!(outcome.role, Role::Sample | Role::Optimum) && outcome.passed;
            let least = best.into_iter().chain(ours.then(|| w.total_w())).reduce(f64::min);
            *watts = Some((dense, least));
        }
        let quality = match q.hvsq.filter(|_| outcome.place.level > 0) {
            Some(hvsq) => format!("HVSQ {hvsq:>10.3e}"),
            // Of its own renders a model differs by rounding only.
            None if q.psnr_db >= ITSELF => format!("{:>8} {:.4}", "equal", q.ssim),
            None => format!("{:>8.2} {:.4}", q.psnr_db, q.ssim),
        };
        let is_reference = matches!(outcome.role, Role::Dense | Role::HeldOut);
        let verdict = match outcome.passed {
            true if is_reference => "",
            true => "ok",
            false => "missed",
        };
        self.say(format_args!(
            "{:17} {:>9} {quality} {:6} {} = {} + {}",
            shortened(&outcome.name, 17),
            outcome.points,
            verdict,
            engineering(w.total_w(), "W"),
            engineering(w.render_w, "W"),
            engineering(w.display_w, "W")
        ));
    }

    fn note(&self, text: &str) {
        *held(&self.bar) = None;
        self.say(format_args!("note: {text}"));
    }

    fn warn(&self, text: &str) {
        self.say(format_args!("warning: {text}"));
    }
}

/// A line of the history.
fn line(job: &str, view: &str, row: &Iteration) -> String {
    let loss = &row.loss;
    let check = row.check.map_or_else(
        || ",,,".to_owned(),
        |c| {
            let (psnr_db, ssim) = (c.seen.quality.psnr_db, c.seen.quality.ssim);
            format!("{psnr_db:.4},{ssim:.6},{:.6},{}", c.seen.display_w, c.passed)
        },
    );
    let likeness = loss.likeness.map_or_else(
        || ",,".to_owned(),
        |[l1, ssim, psnr_db]| format!("{l1:.8},{ssim:.6},{psnr_db:.4}"),
    );
    let shown = |hvsq: Option<f64>| hvsq.map_or(String::new(), |v| format!("{v:.6e}"));
    let (hvsq, gate) = (shown(loss.hvsq), shown(row.check.and_then(|c| c.seen.quality.hvsq)));
    format!(
        "{job},{},{view},{},{:.8},{likeness},{:.6e},{:.6},{check},{hvsq},{gate}\n",
        row.iteration, row.points, loss.total, row.lambda, loss.display_w,
    )
}
