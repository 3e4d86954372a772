//! `--confirm`: designs of a sweep once more, with `banked` in place of `calibrated`.

use std::collections::BTreeSet;
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use super::meter::Meter;
use crate::cli::pareto::{Unanswered, failure};
use crate::cli::{Context, Exit, Failure, OrExit, out};
use powergs_core::machine::DramModel;
use powergs_report::sweep::confirmed_csv;
use powergs_study::analysis::table::Collector;
use powergs_study::analysis::{Analysis, Confirmation, Question, SweepFacts, Table};
use powergs_study::sweep::run::confirm::{CONFIRMED_MAX, on_banked};
use powergs_study::sweep::run::results::header;
use powergs_study::sweep::run::{OpenedSweep, Plan, ResultSink, SharedResults, SweepFolder};

/// The comparison with exact numbers.
pub const CSV: &str = "confirmed.csv";
/// The comparison as the program reads it again.
pub const JSON: &str = "confirmed.json";

/// What is to be confirmed, and with what.
pub struct SweepConfirm<'a> {
    /// Designs at most; none leaves it out.
    pub most: u16,
    /// What sweeps share.
    pub shared: &'a mut SharedResults,
    /// Memory for binned frames, bytes.
    pub memory: usize,
}

/// How many designs are confirmed; says why none where some were asked for.
pub fn most(asked: Option<u16>, sweep: &OpenedSweep<'_>) -> u16 {
    match (asked, &sweep.banked) {
        (None, _) if sweep.is_calibrated => CONFIRMED_MAX,
        (None | Some(0), _) => 0,
        (Some(most), Some(_)) => most,
        (Some(_), None) => {
            let model = sweep.designs.base.machine.dram.model;
            let why = match model {
                _ if sweep.designs.columns().iter().any(|c| c.name == "dram.model") => {
                    "the sweep varies `dram.model`"
                }
                DramModel::Banked => "designs are simulated with `banked` already",
                DramModel::Bandwidth | DramModel::Calibrated => {
                    "designs do not have the DRAM model `calibrated`"
                }
            };
            out::complain(format_args!("note: --confirm: nothing to confirm: {why}"));
            0
        }
    }
}

/// How often the front is looked at again because confirmed designs made room on it.
const ROUNDS: usize = 4;

impl SweepConfirm<'_> {
    /// Simulates designs with `banked` until the front consists of confirmed ones: those of the
    /// front, and those that miss the display rate by less than the models differ. `table` has the
    /// results of the sweep and then those. `None` if none is to be confirmed.
    ///
    /// # Errors
    /// [`Unanswered::Failed`]: the folder cannot be written; [`Unanswered::Interrupted`]: Ctrl-C;
    /// [`Unanswered::Question`]: the results do not answer it.
    pub fn run(
        self,
        table: &mut Table,
        question: &Question,
        facts: &SweepFacts,
        folder: &mut SweepFolder<'_>,
        sweep: &mut OpenedSweep<'_>,
        context: &Context,
        path: &Path,
    ) -> Result<Option<(Plan, Confirmation)>, Unanswered> {
        if self.most == 0 || sweep.banked.is_none() {
            return Ok(None);
        }
        let unanswered = |error| Unanswered::Question(failure(path, error));
        let meter = Meter::new(context);
        let most = usize::from(self.most);
        let calibrated = table.clone();
        let before = Analysis::of(&calibrated, question).map_err(unanswered)?;
        let mut order: Vec<u64> = before.from_knee(most);
        let mut found = None;
        for _ in 0..ROUNDS {
            let points: BTreeSet<u64> = order.iter().copied().collect();
            let sink = ResultSink { folder: &mut *folder, shared: &mut *self.shared };
            let confirmed = on_banked(sweep, &points, sink, self.memory, &meter);
            let confirmed = confirmed.map_err(Failure::from)?.ok_or(Unanswered::Interrupted)?;
            let banked = Collector::new(&header(sweep), |column| question.needs(column));
            let mut banked = banked.or_exit(Exit::Internal, CSV)?;
            let rows = confirmed.rows.iter();
            rows.for_each(|row| drop(banked.row(row)));
            let mut banked = banked.finish();
            facts.settle(&mut banked, 0);
            banked.compute(&question.objectives).or_exit(Exit::Internal, CSV)?;
            table.replace(&banked);
            let after = Analysis::of(table, question).map_err(unanswered)?;
            let confirmation = Confirmation::of(&before, &after, &order);
            let error = confirmation.error();
            found = Some((confirmed.plan, confirmation));
            let mut more = after.from_knee(most);
            more.extend(after.nearly_met(error, most));
            more.retain(|point| !order.contains(point));
            // Each may be twice of what was asked for: the front, and what nearly meets the rate.
            more.truncate((2 * most).saturating_sub(order.len()));
            if more.is_empty() {
                break;
            }
            order.extend(more);
        }
        drop(meter);
        let Some((plan, confirmation)) = found else { return Ok(None) };
        let json = serde_json::to_vec_pretty(&confirmation).or_exit(Exit::Internal, JSON)?;
        let files = [(CSV, confirmed_csv(&confirmation)), (JSON, json)];
        let mut written = files.iter().map(|(name, bytes)| folder.store.write(name, bytes));
        written.try_for_each(|written| written).map_err(Failure::from)?;
        Ok(Some((plan, confirmation)))
    }
}

/// What is said of the front of a sweep in its folder; nothing where that is damaged, or of another
/// question.
pub fn noted(path: &Path, analysis: &Analysis<'_>) -> Option<Confirmation> {
    let text = fs::read(path.join(JSON)).ok()?;
    let confirmation: Confirmation = serde_json::from_slice(&text).ok()?;
    confirmation.fits(analysis).then_some(confirmation)
}

/// Takes away what an earlier run confirmed.
///
/// # Errors
/// Exit code 2: the folder cannot be written.
pub fn forget(path: &Path) -> Result<(), Failure> {
    for name in [CSV, JSON] {
        match fs::remove_file(path.join(name)) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                return Err(error).or_exit(Exit::Usage, path.join(name).display());
            }
            Ok(()) | Err(_) => {}
        }
    }
    Ok(())
}
