//! `claims`: what finished optimisations say about the published claims.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use super::{Run, check, page as pages};
use powergs_chart::Format;
use powergs_core::run::store::atomic::write_atomically;
use powergs_optimize::results::{FILE, Results};
use powergs_sim::cli::output_file::Overwrite;
use powergs_sim::cli::{Context, Exit, Failure, OrExit, out};

/// Shown under `claims --help`.
pub const EXAMPLES: &str = "\
Examples:
  powergs-lab claims runs/snow-fr
  powergs-lab claims runs/snow-fr runs/fox-fr runs/bot-fr --write claims.md
  powergs-lab claims runs/snow-fr --json

A run is the folder of `powergs-sim optimize`; most claims need one made with
--foveated --baselines, some also --quality H,M,L or --study lambda. A claim
that does not hold here is shown with its numbers; the exit code stays 0.";

/// Larger files are no results.
const BYTES_MAX: u64 = 64 << 20;

/// The arguments of `claims`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folders of finished optimisations
    #[arg(required = true, value_name = "RUN")]
    pub runs: Vec<PathBuf>,
    /// Also write the answer to a page of Markdown
    #[arg(long, value_name = "FILE")]
    pub write: Option<PathBuf>,
    /// Whether a file is replaced.
    #[command(flatten)]
    pub overwrite: Overwrite,
}

/// Runs `claims`.
pub fn run(args: &Args, context: &Context) -> Result<Exit, Failure> {
    args.write.iter().try_for_each(|path| args.overwrite.check(path))?;
    let runs = args.runs.iter().map(|path| read(path)).collect::<Result<Vec<Run>, Failure>>()?;
    let book = check(&named_apart(runs));
    if let Some(path) = &args.write {
        let page = pages::document(&book).markdown(Format::Png);
        write_atomically(path, |w| w.write_all(page.as_bytes()))?;
    }
    if context.global.json {
        out::json(&pages::json(&book))?;
    } else if !context.global.quiet {
        out::document(&pages::document(&book))?;
    }
    Ok(Exit::Done)
}

/// The results of a run folder, under the name of the folder.
fn read(folder: &Path) -> Result<Run, Failure> {
    let shown = folder.display();
    let refuse = |what: &str| Err(Failure::new(Exit::BadInput, format!("{shown}: {what}")));
    if !folder.exists() {
        return refuse("there is no such folder; give the folder of a `powergs-sim optimize` run");
    }
    if !folder.is_dir() {
        return refuse("is a file; give the folder of a `powergs-sim optimize` run");
    }
    let path = folder.join(FILE);
    if !path.is_file() {
        let is_run = folder.join("checkpoints").is_dir();
        return refuse(match is_run {
            true => {
                "the run is not finished, or of an older version: it has no results.json; go on \
                 with `powergs-sim optimize … --resume`"
            }
            false => "no folder of a `powergs-sim optimize` run: it has no results.json",
        });
    }
    let file = File::open(&path).or_exit(Exit::BadInput, path.display())?;
    let mut text = String::new();
    let read = file.take(BYTES_MAX + 1).read_to_string(&mut text);
    read.or_exit(Exit::BadInput, path.display())?;
    if text.len() as u64 > BYTES_MAX {
        let what =
            format!("{}: more than {BYTES_MAX} bytes: these are not results", path.display());
        return Err(Failure::new(Exit::BadInput, what));
    }
    let results = Results::parse(&text).or_exit(Exit::BadInput, path.display())?;
    // `.` and `..` have no name of their own.
    let whole = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    let name = whole.file_name().map(|n| n.to_string_lossy().into_owned());
    Ok(Run { label: name.unwrap_or_else(|| results.scene.clone()), results })
}

/// Runs of the same name get numbers.
fn named_apart(mut runs: Vec<Run>) -> Vec<Run> {
    let mut taken = BTreeSet::new();
    for run in &mut runs {
        let own = run.label.clone();
        let mut n = 2;
        while !taken.insert(run.label.clone()) {
            run.label = format!("{own}-{n}");
            n += 1;
        }
    }
    runs
}
