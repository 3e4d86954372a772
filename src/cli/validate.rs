//! `validate`: published numbers beside ours.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::output_file::Overwrite;
use super::progress::{ProgressCounts, WatchedProgress};
use super::{Context, Exit, Failure, OrExit, inputs, out};
use powergs_core::run::store::atomic::write_atomically;
use powergs_core::run::{Frames, TraceFile};
use powergs_core::sim::MODEL_VERSION;
use powergs_report::validate as pages;
use powergs_study::validate::numbers::baseline_csv;
use powergs_study::validate::run::{MEMORY, measure_on, of_any_scene, steps, value};
use powergs_study::validate::{Baseline, Built, Judged, MachineName, Row, Tables, judge, measure};
use powergs_views::rendered;

/// Shown under `validate --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-sim validate
  powergs-sim validate --quick --check evidence/validation.md
  powergs-sim validate --only lego,area
  powergs-sim validate --force --write evidence/validation.md
  powergs-sim validate --rows mine --only my-chip --json
  powergs-sim validate --scenes traces/

Exit code 1: a row that must hold is outside of its tolerance, a row has
worsened, or the page of --check says something else. A plausible row whose
miss is in the baseline fails no run.";

/// The largest table that is read.
const TABLE_MAX: u64 = 1 << 24;
/// Where the tables are in the source of the program.
const TABLES: &str = "tests/validation";

/// Check the simulator against published numbers
#[derive(Debug, Clone, clap::Args)]
pub struct ValidateArgs {
    /// Only rows whose name contains one of these, comma-separated
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    only: Vec<String>,
    /// Only rows without frames, and those on workloads that are marked as quick: a minute
    #[arg(long)]
    quick: bool,
    /// Folder with published.csv, workloads.csv and baseline.csv, in place of what comes
    /// with the program
    #[arg(long, value_name = "DIR")]
    rows: Option<PathBuf>,
    /// Measure shares and ratios on the traces (*.bin) of this folder instead of the workloads
    #[arg(long, value_name = "DIR", conflicts_with_all = ["write", "bless", "check", "quick"])]
    scenes: Option<PathBuf>,
    /// Write the page (evidence/validation.md) to this file
    #[arg(long, value_name = "FILE")]
    write: Option<PathBuf>,
    /// Compare with this page: its model version, and every row that was measured
    #[arg(long, value_name = "FILE", conflicts_with_all = ["write", "bless"])]
    check: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    /// Keep what comes out as the new baseline: baseline.csv in --rows, or in
    /// tests/validation
    #[arg(long)]
    bless: bool,
}

/// Runs the command.
pub fn run(args: &ValidateArgs, context: &Context) -> Result<Exit, Failure> {
    args.write.iter().try_for_each(|path| args.overwrite.check(path))?;
    let tables = tables(args.rows.as_deref())?;
    let page = args.check.as_deref().map(table).transpose()?;
    let wanted = |row: &&Row| {
        (args.only.is_empty() || args.only.iter().any(|name| row.id.contains(name.as_str())))
            && (!args.quick || tables.is_quick(row))
    };
    let rows: Vec<&Row> = tables.rows.iter().filter(wanted).collect();
    if rows.is_empty() {
        let only = format!("--only {}", args.only.join(","));
        let flags = match (args.only.is_empty(), args.quick) {
            (true, _) => "--quick".to_owned(),
            (false, true) => format!("--quick {only}"),
            (false, false) => only,
        };
        let what = format!("{flags}: there is no such row");
        return Err(Failure::new(Exit::Usage, what));
    }
    if let Some(folder) = &args.scenes {
        return on_scenes(folder, context, &tables, &rows);
    }
    let built = machines(&rows)?;
    let watch =
        WatchedProgress::of_total(context, steps(&tables, &rows), ProgressCounts::Simulations);
    let asked = context.global.memory;
    let is_enough = args.rows.is_some() || asked.0 >= MEMORY.0;
    let memory = if is_enough { asked } else { MEMORY };
    let Some(measured) = measure(&tables, &rows, &built, &rendered, memory, &watch)? else {
        return Ok(Exit::Interrupted);
    };
    drop(watch);
    let ours: Baseline =
        rows.iter().filter_map(|row| Some((row.id.clone(), value(row, &measured)?))).collect();
    // The page that goes with a new baseline is of that baseline, not of the one before.
    let blessed = match args.bless {
        true => Some(tables.blessed(&ours, MODEL_VERSION).or_exit(Exit::Internal, "baseline")?),
        false => None,
    };
    let shown = blessed.as_ref().unwrap_or(&tables);
    let judged: Vec<Judged> = shown
        .rows
        .iter()
        .filter(wanted)
        .map(|row| judge(row, ours.get(&row.id), shown.before(row)))
        .collect();
    let exit = finish(args, context, shown, &ours, &judged)?;
    let Some((text, path)) = page.zip(args.check.as_ref()) else { return Ok(exit) };
    let differences = pages::differences(&text, &tables, &judged, MODEL_VERSION);
    for difference in &differences {
        out::complain(format_args!("{}: {difference}", path.display()));
    }
    if differences.is_empty() {
        return Ok(exit);
    }
    let remedy = "make it anew: powergs-sim validate --bless --force --write";
    let page = path.display();
    out::complain(format_args!("{page}: not the page of this program; {remedy} {page}"));
    Ok(Exit::GoalMissed)
}

/// Measures what any scene can show on each trace of a folder.
fn on_scenes(
    folder: &Path,
    context: &Context,
    tables: &Tables,
    rows: &[&Row],
) -> Result<Exit, Failure> {
    let rows = of_any_scene(tables, rows);
    let entries = fs::read_dir(folder).or_exit(Exit::BadInput, folder.display())?;
    let mut paths = Vec::new();
    for entry in entries {
        let path = entry.or_exit(Exit::BadInput, folder.display())?.path();
        paths.extend(Some(path).filter(|p| p.extension().is_some_and(|end| end == "bin")));
    }
    paths.sort();
    if paths.is_empty() || rows.is_empty() {
        let what = match rows.is_empty() {
            true => "no row is a share or a ratio of frames that are not on a path".to_owned(),
            false => format!("{}: no traces (*.bin) there; extract some", folder.display()),
        };
        return Err(Failure::new(Exit::Usage, what));
    }
    let built = machines(&rows)?;
    let mut scenes = Vec::new();
    for path in &paths {
        let mut trace = TraceFile::open(path)?;
        trace.allow(context.global.memory);
        let steps = (trace.range().len() * built.len()) as u64;
        let watch = WatchedProgress::of_total(context, steps, ProgressCounts::Simulations);
        let Some(values) = measure_on(&mut trace, &rows, &built, &watch)? else {
            return Ok(Exit::Interrupted);
        };
        scenes.push((trace.name().to_owned(), values));
    }
    if context.global.json {
        out::json(&pages::scenes_json(&rows, &scenes))?;
    } else if !context.global.quiet {
        out::document(&pages::scenes(tables, &rows, &scenes))?;
    }
    Ok(Exit::Done)
}

/// Writes and prints what was asked for.
fn finish(
    args: &ValidateArgs,
    context: &Context,
    tables: &Tables,
    ours: &Baseline,
    judged: &[Judged],
) -> Result<Exit, Failure> {
    if let Some(path) = &args.write {
        let page = pages::page(tables, judged);
        write_atomically(path, |w| w.write_all(page.as_bytes()))?;
    }
    if args.bless {
        let folder = args.rows.as_deref().unwrap_or(Path::new(TABLES));
        let text = baseline_csv(tables, ours, MODEL_VERSION);
        write_atomically(&folder.join("baseline.csv"), |w| w.write_all(text.as_bytes()))?;
    }
    if context.global.json {
        out::json(&pages::json(tables, judged))?;
    } else if !context.global.quiet {
        out::document(&pages::document(tables, judged))?;
    }
    let is_bad = |j: &Judged| match args.bless {
        true => j.verdict == powergs_study::validate::Verdict::Fails,
        false => j.is_bad(),
    };
    Ok(if judged.iter().any(is_bad) { Exit::GoalMissed } else { Exit::Done })
}

fn tables(folder: Option<&Path>) -> Result<Tables, Failure> {
    let Some(folder) = folder else {
        return Ok(Tables::embedded());
    };
    let read = |name: &str| table(&folder.join(name));
    let baseline = match folder.join("baseline.csv").exists() {
        true => read("baseline.csv")?,
        false => "id,workload,ours\n".to_owned(),
    };
    let tables = Tables::parse(&read("published.csv")?, &read("workloads.csv")?, &baseline);
    let tables = match folder.join("ledger.csv").exists() {
        true => {
            let ledger = read("ledger.csv")?;
            tables.and_then(|tables| tables.with_ledger(&ledger))
        }
        false => tables,
    };
    tables.or_exit(Exit::Usage, folder.display())
}

/// The text of a table or page.
fn table(path: &Path) -> Result<String, Failure> {
    let size = fs::metadata(path).or_exit(Exit::Usage, path.display())?.len();
    if size > TABLE_MAX {
        let what = format!("{}: {size} bytes are too many for a table", path.display());
        return Err(Failure::new(Exit::Usage, what));
    }
    fs::read_to_string(path).or_exit(Exit::Usage, path.display())
}

/// Every machine that the rows name.
fn machines(rows: &[&Row]) -> Result<BTreeMap<MachineName, Built>, Failure> {
    let mut built = BTreeMap::new();
    for row in rows {
        for name in [Some(&row.machine), row.against.as_ref()].into_iter().flatten() {
            if !built.contains_key(name) {
                let machine = build(name).map_err(|e| Failure {
                    exit: e.exit,
                    error: e.error.context(row.id.clone()),
                })?;
                built.insert(name.clone(), machine);
            }
        }
    }
    Ok(built)
}

fn build(name: &MachineName) -> Result<Built, Failure> {
    Ok(Built::new(inputs::system(&name.arch, &name.sets, None)?))
}
