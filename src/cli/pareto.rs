//! `pareto`: which designs of a finished sweep to keep, and why.

mod folder;
mod provenance;
mod question;

use std::path::{Path, PathBuf};

use super::chart_args::ChartArgs;
use super::compare::watts;
use super::output_file::Overwrite;
use super::sweep::confirm::{self, SweepConfirm};
use super::{Context, Exit, Failure, OrExit, invocation, out};
use folder::{FinishedSweep, Sources};
use powergs_base::quantity::Watts;
use powergs_core::run::store::atomic::write_atomically;
use powergs_report::document::{Block, Document, Shown};
use powergs_report::sweep as report;
use powergs_study::analysis::table::{Collector, TableError};
use powergs_study::analysis::{Analysis, AnalysisError, Confirmation, Question, SweepFacts, Table};
use powergs_study::sweep::run::results::{CSV, Planned, header, some_rows};
use powergs_study::sweep::run::{OpenedSweep, Plan, SweepFolder};
use powergs_study::sweep::table::Cell;
use provenance::provenance;

/// Shown under `pareto --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim pareto reports/units
  powergs-sim pareto reports/units --minimize power_w.mean,area_mm2 \\
      --maximize fps.mean --where 'frame_time_ms.p99 <= 16.67 && area_mm2 <= 13'
  powergs-sim pareto reports/units --scope worst --energy-table paper --json
  powergs-sim pareto reports/units --design 12 --colour vru.cores

DIR is the folder of a sweep. The answer is printed, and written with charts and
an HTML report to DIR/analysis-2, or the next free number: the report of the
sweep itself, DIR/analysis, stays as it is. The same question asked again
replaces its own report.";

/// The arguments of `pareto`.
#[derive(Debug, Clone, clap::Args)]
pub struct ParetoArgs {
    /// The folder of a sweep, with its results.csv
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Columns to make small, or expressions of them: 'area_mm2 * frame_time_ms.p99'
    /// [default: those of the sweep file]
    #[arg(long, value_name = "COLUMN,...", value_delimiter = ',')]
    pub minimize: Vec<String>,
    /// Columns to make large, or expressions of them
    #[arg(long, value_name = "COLUMN,...", value_delimiter = ',')]
    pub maximize: Vec<String>,
    /// Only designs that meet this on every trace: 'area_mm2 <= 12 && power_w.mean <= 1.5'; what
    /// stands in mean(...) is over the traces
    #[arg(long = "where", value_name = "EXPR")]
    pub condition: Option<String>,
    /// Only designs that take at most this power on every trace, and a line at it in the
    /// charts: 1.5W, 800mW
    #[arg(long, value_name = "POWER", value_parser = watts)]
    pub budget: Option<Watts>,
    /// Which rows count: mean (over the traces), worst (of each column the worst trace), or
    /// the label of a trace
    #[arg(long, value_name = "SCOPE", default_value = "mean")]
    pub scope: String,
    /// Label of the energy table [default: the first of the results]
    #[arg(long, value_name = "LABEL")]
    pub energy_table: Option<String>,
    /// Column that colours the points
    #[arg(long, visible_alias = "color", value_name = "COLUMN")]
    pub colour: Option<String>,
    /// Design whose distance to the front is reported: baseline, a point, or the first
    /// digits of an id
    #[arg(long, value_name = "DESIGN", default_value = "baseline")]
    pub design: String,
    /// Rank designs that miss the display rate like all others; without it they come behind
    #[arg(long)]
    pub include_misses: bool,
    /// Differences up to this share are noise: 0.001, 0.1%
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub epsilon: Option<f64>,
    /// How many designs are listed and ranked
    #[arg(long, value_name = "N", default_value = "10")]
    #[arg(value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub top: u16,
    /// Folder for the report, which replaces one of pareto [default: the first free of
    /// DIR/analysis-2, DIR/analysis-3, ...]
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Also write the rows of the front to FILE
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Whether a file is replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
    /// How charts are drawn.
    #[command(flatten)]
    pub charts: ChartArgs,
    /// Of `sweep`: refused with the way to it.
    #[arg(long, hide = true, value_name = "RATE")]
    pub fps: Option<String>,
    /// Of `sweep`: refused with the way to it.
    #[arg(long, hide = true, value_name = "DISPLAY")]
    pub display: Option<String>,
}

impl ParetoArgs {
    /// Powers and missed frames of a sweep are those at its display; results keep means over the
    /// frames, from which those at another rate do not follow.
    fn other_display(&self, facts: &SweepFacts) -> Result<(), Failure> {
        let [fps, display] = [("--fps", &self.fps), ("--display", &self.display)]
            .map(|(flag, value)| value.as_ref().map(|value| format!("{flag} {value}")));
        let Some(asked) = fps.into_iter().chain(display).reduce(|a, b| format!("{a} {b}")) else {
            return Ok(());
        };
        let file = facts.sweeps.first().map_or("SWEEP", String::as_str);
        let what = format!(
            "{asked}: the results hold powers and missed frames at the display of the sweep; run \
             it for another one: powergs-sim sweep {file} {asked} --out DIR"
        );
        Err(Failure::new(Exit::Usage, what))
    }
}

/// A share, as it is or in percent.
fn share(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let share = match text.trim().strip_suffix('%') {
        Some(percent) => number(percent).map(|x| x / 100.0),
        None => number(text),
    };
    let share = share.filter(|x| (0.0..=0.5).contains(x));
    share.ok_or_else(|| "write a share from 0 to 0.5, or in percent: 0.001, 0.1%".to_owned())
}

/// Runs the command.
pub fn run(args: &ParetoArgs, context: &Context) -> Result<Exit, Failure> {
    let Some(answer) = answer(args, &invocation::shown_words(), context)? else {
        return Ok(Exit::Interrupted);
    };
    if context.global.json {
        out::json(&answer.json)?;
    } else if !context.global.quiet {
        out::document(&answer.page)?;
    }
    Ok(Exit::Done)
}

/// The folder of the analysis in that of its sweep.
const FOLDER: &str = "analysis";

/// What was asked, in the folder of an answer of `pareto`.
pub const QUESTION: &str = "question.toml";

/// Where the report of a finished sweep is in its folder.
pub const REPORT: &str = "analysis/report.html";

/// The analysis of a sweep, in its forms.
struct Answer {
    /// For people.
    page: Document,
    /// For programs.
    json: serde_json::Value,
}

/// The analysis of a sweep that was just run: it sees the rows of the table as they are written.
pub struct OfSweep {
    facts: SweepFacts,
    question: Question,
    table: Result<Collector, TableError>,
}

impl OfSweep {
    /// The question of the sweep file; `most` designs of the front are to be confirmed.
    pub fn new(sweep: &OpenedSweep<'_>, most: u16) -> OfSweep {
        let facts = SweepFacts { confirm: Some(most), ..SweepFacts::of(sweep) };
        let question = facts.question();
        let table = Collector::new(&header(sweep), |column| question.needs(column));
        OfSweep { facts, question, table }
    }

    /// Takes a row of the table.
    pub fn row(&mut self, row: &[Cell]) {
        let Ok(table) = &mut self.table else { return };
        if let Err(error) = table.row(row) {
            self.table = Err(error);
        }
    }

    /// The results so far, as columns.
    ///
    /// # Errors
    /// [`Unanswered::Question`]: a table that does not answer the question.
    fn table(&mut self, path: &Path, excluded: u64) -> Result<Table, Unanswered> {
        let none = Collector::new(&[], |_| false);
        let table = std::mem::replace(&mut self.table, none);
        let table = table.or_exit(Exit::BadInput, path.join(CSV).display());
        let mut table = table.map_err(Unanswered::Question)?.finish();
        self.facts.settle(&mut table, excluded);
        let computed = table.compute(&self.question.objectives);
        computed.map_err(|error| Unanswered::Question(failure(path, error)))?;
        Ok(table)
    }

    /// Confirms designs; see [`SweepConfirm::run`].
    ///
    /// # Errors
    /// [`Unanswered`].
    pub fn confirmed(
        &mut self,
        folder: &mut SweepFolder<'_>,
        path: &Path,
        sweep: &mut OpenedSweep<'_>,
        plan: &Plan,
        confirm: SweepConfirm<'_>,
        context: &Context,
    ) -> Result<Option<(Plan, Confirmation)>, Unanswered> {
        let mut table = self.table(path, plan.excluded.values().sum())?;
        confirm.run(&mut table, &self.question, &self.facts, folder, sweep, context, path)
    }

    /// Writes the analysis into the folder of the sweep and returns what people read of it.
    ///
    /// # Errors
    /// [`Unanswered`]: a table that does not answer the question, a folder that cannot be written,
    /// Ctrl-C.
    pub fn answer(
        mut self,
        folder: &mut SweepFolder<'_>,
        path: &Path,
        sweep: &OpenedSweep<'_>,
        planned: Planned<'_>,
        confirmation: Option<&Confirmation>,
        context: &Context,
    ) -> Result<Document, Unanswered> {
        let table = self.table(path, planned.plan.excluded.values().sum())?;
        let analysis = Analysis::of(&table, &self.question)
            .map_err(|error| Unanswered::Question(failure(path, error)))?;
        if context.is_cancelled() {
            return Err(Unanswered::Interrupted);
        }
        let head: Vec<String> = header(sweep).into_iter().map(|c| c.name).collect();
        let wanted = report::pareto_rows(&analysis);
        let rows = some_rows(sweep, planned, &mut folder.records, &wanted);
        let rows = rows.map_err(Failure::from)?.into_iter();
        let rows = rows.map(|(n, row)| (n, row.iter().map(Cell::text).collect()));
        let pareto = report::pareto_csv(&analysis, &head, &rows.collect());
        let pareto = pareto.or_exit(Exit::Internal, "pareto.csv")?;
        let provenance = provenance(&self.facts, &[]);
        let out = path.join(FOLDER);
        let question = None;
        let from = Sources { pareto: &pareto, confirmation, provenance: &provenance, question };
        let written = folder::write(&out, &analysis, &from, context)?;
        written.ok_or(Unanswered::Interrupted)?;
        Ok(report::document(&analysis, &[], confirmation, &provenance))
    }
}

/// The answer to the question of a finished sweep once more; nothing is written.
///
/// # Errors
/// Why there is none: the results do not answer the question.
pub fn once_more(path: &Path) -> Result<Document, Failure> {
    let sweep = FinishedSweep::open(path)?;
    let question = sweep.facts.question();
    let table = sweep.table(&question)?;
    let analysis = Analysis::of(&table, &question).map_err(|error| failure(path, error))?;
    let confirmation = confirm::noted(path, &analysis);
    let provenance = provenance(&sweep.facts, &[]);
    Ok(report::document(&analysis, &[], confirmation.as_ref(), &provenance))
}

/// Why a sweep has no analysis.
pub enum Unanswered {
    /// The results do not answer the question of the sweep file.
    Question(Failure),
    /// It could not be written.
    Failed(Failure),
    /// The user pressed Ctrl-C.
    Interrupted,
}

impl From<Failure> for Unanswered {
    fn from(failure: Failure) -> Unanswered {
        Unanswered::Failed(failure)
    }
}

/// Reads, analyses and writes; `None` if the user pressed Ctrl-C.
fn answer(
    args: &ParetoArgs,
    typed: &[String],
    context: &Context,
) -> Result<Option<Answer>, Failure> {
    args.csv.iter().try_for_each(|path| args.overwrite.check(path))?;
    let sweep = FinishedSweep::open(&args.folder)?;
    args.other_display(&sweep.facts)?;
    let question = question::question(args, &sweep.facts)?;
    let table = sweep.table(&question)?;
    let analysis = Analysis::of(&table, &question).map_err(|error| failure(&args.folder, error))?;
    if context.is_cancelled() {
        return Ok(None);
    }
    let pareto = report::pareto_csv_of(&analysis, sweep.results()?)
        .or_exit(Exit::BadInput, sweep.results_path().display())?;
    if let Some(path) = &args.csv {
        write_atomically(path, |w| w.write_all(&pareto))?;
    }
    let provenance = provenance(&sweep.facts, typed);
    let asked = question::noted(&question);
    let out = match &args.out {
        Some(path) => folder::given(path, &args.folder)?,
        None => folder::next_to(&args.folder, &asked)?,
    };
    let confirmation = confirm::noted(&args.folder, &analysis);
    let confirmation = confirmation.as_ref();
    let question = Some(asked.as_str());
    let from = Sources { pareto: &pareto, confirmation, provenance: &provenance, question };
    let written = folder::write(&out, &analysis, &from, context)?;
    let Some(written) = written else { return Ok(None) };
    let json = serde_json::to_value(report::json(&analysis)).or_exit(Exit::Internal, "json")?;
    let mut page = report::document(&analysis, &[], confirmation, &provenance);
    let report = written.join("report.html").display().to_string();
    page.on(Shown::Terminal, Block::Facts(vec![("report".into(), report.into())]));
    Ok(Some(Answer { page, json }))
}

/// A condition that no design meets is a goal that was missed; an empty table is a bad input.
pub fn failure(folder: &Path, error: AnalysisError) -> Failure {
    let exit = match error {
        AnalysisError::Unmet { .. } => Exit::GoalMissed,
        AnalysisError::Nothing { .. } => Exit::BadInput,
        AnalysisError::Column { .. }
        | AnalysisError::Words(_)
        | AnalysisError::Objectives(_)
        | AnalysisError::Label { .. }
        | AnalysisError::Condition(_)
        | AnalysisError::Design(_)
        | AnalysisError::Ambiguous(_) => Exit::Usage,
    };
    Failure::new(exit, format!("{}: {error}", folder.display()))
}
