//! `--confirm`: designs of the front of a sweep once more, with `banked` in place of `calibrated`.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use super::meter::Meter;
use crate::cli::pareto::Unanswered;
use crate::cli::{Context, Exit, Failure, OrExit, out};
use powergs_core::accel::machine::DramModel;
use powergs_report::sweep::confirmed_csv;
use powergs_study::analysis::table::Collector;
use powergs_study::analysis::{Analysis, Confirmation, SweepFacts};
use powergs_study::sweep::run::confirm::{CONFIRMED_MAX, on_banked};
use powergs_study::sweep::run::results::header;
use powergs_study::sweep::run::{OpenedSweep, ResultSink, SharedResults, SweepFolder};

/// The comparison with exact numbers.
pub const CSV: &str = "confirmed.csv";
/// The comparison as the program reads it again.
pub const JSON: &str = "confirmed.json";

/// What is to be confirmed, and with what.
pub struct Confirm<'a> {
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
                DramModel::Bandwidth | DramModel::Window | DramModel::Calibrated => {
                    "designs do not have the DRAM model `calibrated`"
                }
            };
            out::complain(format_args!("note: --confirm: nothing to confirm: {why}"));
            0
        }
    }
}

impl Confirm<'_> {
    /// Simulates designs of the front with `banked` and writes how they compare; `None` if none is
    /// to be confirmed.
    ///
    /// # Errors
    /// [`Unanswered::Failed`]: the folder cannot be written; [`Unanswered::Interrupted`]: Ctrl-C.
    pub fn run(
        self,
        analysis: &Analysis<'_>,
        facts: &SweepFacts,
        folder: &mut SweepFolder<'_>,
        sweep: &mut OpenedSweep<'_>,
        context: &Context,
    ) -> Result<Option<Confirmation>, Unanswered> {
        if self.most == 0 || sweep.banked.is_none() {
            return Ok(None);
        }
        let points = analysis.from_knee(usize::from(self.most));
        let meter = Meter::new(context);
        let sink = ResultSink { folder: &mut *folder, shared: self.shared };
        let rows = on_banked(sweep, &points, sink, self.memory, &meter).map_err(Failure::from)?;
        drop(meter);
        let rows = rows.ok_or(Unanswered::Interrupted)?;
        let question = &analysis.question;
        let table = Collector::new(&header(sweep), |column| question.needs(column));
        let mut table = table.or_exit(Exit::Internal, CSV)?;
        rows.iter().try_for_each(|row| table.row(row)).or_exit(Exit::Internal, CSV)?;
        let mut table = table.finish();
        facts.settle(&mut table, 0);
        table.compute(&question.objectives).or_exit(Exit::Internal, CSV)?;
        let confirmation = Confirmation::of(analysis, &points, &table);
        let confirmation = confirmation.or_exit(Exit::Internal, CSV)?;
        let json = serde_json::to_vec_pretty(&confirmation).or_exit(Exit::Internal, JSON)?;
        let files = [(CSV, confirmed_csv(&confirmation)), (JSON, json)];
        let mut written = files.iter().map(|(name, bytes)| folder.store.write(name, bytes));
        written.try_for_each(|written| written).map_err(Failure::from)?;
        Ok(Some(confirmation))
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
