//! The folder of a sweep, and the folder of its analysis.

use std::fs::{self, File};
use std::io::{BufReader, ErrorKind};
use std::path::{Path, PathBuf};

use super::{FOLDER, QUESTION, failure};
use crate::cli::run_folder::{RunFolder, numbered};
use crate::cli::{Context, Exit, Failure, OrExit};
use powergs_core::run::store::FileStore;
use powergs_report::sweep::{self, Provenance};
use powergs_study::analysis::{Analysis, Confirmation, Question, SweepFacts, Table};
use powergs_study::sweep::run::results::CSV;
use powergs_study::sweep::run::state;

/// A sweep that has results.
#[derive(Debug)]
pub(super) struct FinishedSweep {
    path: PathBuf,
    /// What its files say about it.
    pub facts: SweepFacts,
}

impl FinishedSweep {
    /// Opens a folder. The sweep file in it may be absent; the results may not.
    pub(super) fn open(path: &Path) -> Result<FinishedSweep, Failure> {
        let mut sweep = FinishedSweep { path: path.to_owned(), facts: SweepFacts::default() };
        sweep.results()?;
        sweep.facts = SweepFacts::read(&FileStore::new(path))?;
        Ok(sweep)
    }

    /// The path of the results.
    pub(super) fn results_path(&self) -> PathBuf {
        self.path.join(CSV)
    }

    /// The results, from their beginning.
    pub(super) fn results(&self) -> Result<BufReader<File>, Failure> {
        let path = self.results_path();
        match File::open(&path) {
            Ok(file) => Ok(BufReader::new(file)),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                Err(Failure::new(Exit::BadInput, self.without_results()))
            }
            Err(error) => Err(error).or_exit(Exit::BadInput, path.display()),
        }
    }

    /// Why a folder has no results.
    fn without_results(&self) -> String {
        let folder = self.path.display();
        if !self.path.exists() {
            return format!("{folder}: no such folder; give the folder of a sweep");
        }
        if self.path.join(state::FILE).exists() {
            return format!(
                "{folder}: the sweep in it is unfinished; go on with the same `sweep` command and \
                 --resume"
            );
        }
        format!("{folder}: holds no sweep: there is no {CSV} in it")
    }

    /// The results as columns, those that the question needs.
    pub(super) fn table(&self, question: &Question) -> Result<Table, Failure> {
        let read = Table::read(self.results()?, |column| question.needs(column));
        let mut table = read.or_exit(Exit::BadInput, self.results_path().display())?;
        self.facts.settle(&mut table, self.facts.excluded);
        let computed = table.compute(&question.objectives);
        computed.map_err(|error| failure(&self.path, error))?;
        Ok(table)
    }
}

/// Reports of a sweep are numbered up to here.
const REPORTS_MAX: usize = 1000;

/// Whether a folder has the report that a sweep wrote at its end: no question of its own.
fn is_of_sweep(path: &Path) -> bool {
    path.exists() && !path.join(QUESTION).is_file()
}

/// Where the report of a question goes: next to that of the sweep, in place of an earlier answer to
/// the same question.
///
/// # Errors
/// Exit code 2: there are too many.
pub(super) fn next_to(sweep: &Path, question: &str) -> Result<PathBuf, Failure> {
    let base = sweep.join(FOLDER);
    let is_free = |path: &PathBuf| {
        let asked = path.join(QUESTION);
        let is_same = asked.is_file() && fs::read_to_string(&asked).is_ok_and(|q| q == question);
        is_same || !path.exists()
    };
    let found = (1..=REPORTS_MAX).map(|i| numbered(&base, i)).find(is_free);
    found.ok_or_else(|| {
        let what = "holds too many reports; delete old ones or give --out a folder";
        Failure::new(Exit::Usage, format!("{}: {what}", sweep.display()))
    })
}

/// A folder that the user names: not the report of the sweep.
///
/// # Errors
/// Exit code 2: it is that.
pub(super) fn given(path: &Path, sweep: &Path) -> Result<PathBuf, Failure> {
    let whole = |path: &Path| fs::canonicalize(path).ok();
    let own = sweep.join(FOLDER);
    if is_of_sweep(&own) && whole(path).is_some() && whole(path) == whole(&own) {
        let what = "is the report of the sweep itself; leave --out out or give another folder";
        return Err(Failure::new(Exit::Usage, format!("{}: {what}", path.display())));
    }
    Ok(path.to_owned())
}

/// What a report has besides its analysis.
pub(super) struct Sources<'a> {
    /// `pareto.csv`.
    pub pareto: &'a [u8],
    /// The front with `banked`.
    pub confirmation: Option<&'a Confirmation>,
    /// Where it comes from.
    pub provenance: &'a Provenance,
    /// The question, where it was asked of a finished sweep.
    pub question: Option<&'a str>,
}

/// Writes the report folder; `None` if it was interrupted.
pub(super) fn write(
    path: &Path,
    analysis: &Analysis,
    from: &Sources<'_>,
    context: &Context,
) -> Result<Option<PathBuf>, Failure> {
    let Sources { pareto, confirmation, provenance, question } = *from;
    let folder = RunFolder::analysis(path)?;
    let charts = sweep::charts(analysis);
    folder.write("pareto.csv", pareto)?;
    if let Some(question) = question {
        folder.write(QUESTION, question.as_bytes())?;
    }
    if let Some(table) = sweep::speedup_csv(analysis) {
        folder.write("speedup.csv", &table)?;
    }
    let page = sweep::document(analysis, &charts, confirmation, provenance);
    folder.write_pages(&page, &context.drawing)?;
    for chart in &charts {
        if context.is_cancelled() {
            return Ok(None);
        }
        folder.write_charts(std::slice::from_ref(chart), &context.drawing)?;
    }
    Ok(Some(folder.finish()?))
}
