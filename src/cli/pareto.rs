//! `pareto`: which designs of a finished sweep to keep, and why.

mod folder;
mod question;

use std::path::PathBuf;

use super::sweep::finish;
use super::{Context, Exit, Failure, OrExit, out};
use powergs_report::sweep;
use powergs_study::analysis::{Analysis, AnalysisError};

/// Shown under `pareto --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim pareto reports/units
  powergs-sim pareto reports/units --minimize energy_pj.mean,area_mm2 \\
      --maximize fps.mean --where 'frame_time_ms.p99 <= 16.67 && area_mm2 <= 4'
  powergs-sim pareto reports/units --scope worst --energy-table paper --json
  powergs-sim pareto reports/units --design 12 --colour vru.cores

DIR is the folder of a sweep. The answer is printed and written with its charts and
an HTML report to DIR/analysis.";

/// The arguments of `pareto`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// The folder of a sweep, with its results.csv
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Columns to make small [default: those of the sweep file]
    #[arg(long, value_name = "COLUMN,...", value_delimiter = ',')]
    pub minimize: Vec<String>,
    /// Columns to make large
    #[arg(long, value_name = "COLUMN,...", value_delimiter = ',')]
    pub maximize: Vec<String>,
    /// Only designs that meet this: 'area_mm2 <= 4 && vru.cores >= 2'
    #[arg(long = "where", value_name = "EXPR")]
    pub condition: Option<String>,
    /// Which rows count: mean (over the traces), worst (the slowest), or the label of a
    /// trace
    #[arg(long, value_name = "SCOPE", default_value = "mean")]
    pub scope: String,
    /// Label of the energy table [default: the first of the results]
    #[arg(long, value_name = "LABEL")]
    pub energy_table: Option<String>,
    /// Column that colours the points
    #[arg(long, visible_alias = "color", value_name = "COLUMN")]
    pub colour: Option<String>,
    /// Whose distance from the front is told: baseline, a point, or the first digits of
    /// an id
    #[arg(long, value_name = "DESIGN", default_value = "baseline")]
    pub design: String,
    /// How many designs are listed and ranked
    #[arg(long, value_name = "N", default_value = "10")]
    #[arg(value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub top: u16,
    /// Folder for the report [default: DIR/analysis]; a report there is replaced
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Also write the rows of the front to FILE
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
}

/// Runs the command.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    let typed: Vec<String> =
        std::env::args_os().map(|w| w.to_string_lossy().into_owned()).collect();
    let Some(answer) = answer(args, &typed, finish::excluded(&args.folder), context)? else {
        return Ok(Exit::Interrupted);
    };
    if context.global.json {
        out::json(&answer.json)?;
    } else if !context.global.quiet {
        out::text(&format!("{}\nreport  {}\n", answer.terminal, answer.report.display()))?;
    }
    Ok(Exit::Done)
}

/// Where the report of a finished sweep is in its folder.
pub const REPORT: &str = "analysis/report.html";

/// What a sweep comes to.
pub struct Answer {
    /// For a terminal.
    pub terminal: String,
    /// The report.
    pub report: PathBuf,
    /// For programs.
    pub json: serde_json::Value,
}

/// Answers the question of the sweep file in `folder`, of which constraints left out `excluded`
/// designs, and writes the analysis beside its results.
///
/// # Errors
/// As the command.
pub fn analyse(
    folder: &std::path::Path,
    excluded: u64,
    context: &Context,
) -> Result<Option<Answer>, Failure> {
    let args = Args {
        folder: folder.to_owned(),
        minimize: Vec::new(),
        maximize: Vec::new(),
        condition: None,
        scope: "mean".into(),
        energy_table: None,
        colour: None,
        design: "baseline".into(),
        top: 10,
        out: None,
        csv: None,
    };
    answer(&args, &[], Some(excluded), context)
}

/// Reads, analyses and writes; `None` if the user broke off.
fn answer(
    args: &Args,
    typed: &[String],
    excluded: Option<u64>,
    context: &Context,
) -> Result<Option<Answer>, Failure> {
    let sweep = folder::SweepFolder::open(&args.folder)?;
    let question = question::question(args, &sweep)?;
    let mut table = sweep.table(&question)?;
    table.leave_out(excluded.unwrap_or(0) as usize);
    let analysis = match Analysis::of(&table, &question) {
        Ok(analysis) => analysis,
        Err(error) => return Err(failure(args, error)),
    };
    if context.is_cancelled() {
        return Ok(None);
    }
    let pareto = sweep::pareto_csv(&analysis, sweep.results()?)
        .or_exit(Exit::BadInput, sweep.results_path().display())?;
    if let Some(path) = &args.csv {
        super::aside::write_aside(path, |w| w.write_all(&pareto))?;
    }
    let provenance = sweep.provenance(typed);
    let written = folder::write(args, &sweep, &analysis, &pareto, &provenance, context)?;
    let Some(written) = written else { return Ok(None) };
    let report = written.join("report.html");
    let json = serde_json::to_value(sweep::json(&analysis)).or_exit(Exit::Internal, "json")?;
    Ok(Some(Answer { terminal: sweep::terminal(&analysis), report, json }))
}

/// A condition that nobody meets is a goal that was missed; an empty table is a bad input.
fn failure(args: &Args, error: AnalysisError) -> Failure {
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
    Failure::new(exit, format!("{}: {error}", args.folder.display()))
}
