//! The folder of a sweep, and the folder of its analysis.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use super::about::About;
use crate::cli::run_folder::RunFolder;
use crate::cli::{Context, Exit, Failure, OrExit};
use powergs_report::sweep::{self, Provenance};
use powergs_study::analysis::{Analysis, Objective, Question, Table};
use powergs_study::sweep::run::results::CSV;

/// The largest sweep file that is read, bytes.
const SWEEP_FILE_MAX: u64 = 1 << 20;

/// A sweep that has results.
#[derive(Debug)]
pub(super) struct FinishedSweep {
    path: PathBuf,
    /// What its files say about it.
    pub about: About,
}

impl FinishedSweep {
    /// Opens a folder. The sweep file in it may be absent; the results may not.
    pub(super) fn open(path: &Path) -> Result<FinishedSweep, Failure> {
        let mut sweep = FinishedSweep { path: path.to_owned(), about: About::default() };
        sweep.results()?;
        let file = path.join("sweep.toml");
        let mut text = String::new();
        let read = match File::open(&file) {
            Ok(file) => file.take(SWEEP_FILE_MAX).read_to_string(&mut text).map(|_| true),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(false),
            Err(e) => Err(e),
        };
        if read.or_exit(Exit::BadInput, file.display())? {
            let root: toml::Table = text.parse().or_exit(Exit::BadInput, file.display())?;
            sweep.describe(&root);
        }
        let inputs = sweep.inputs();
        let names = |role: &str| -> Vec<String> {
            let of_role =
                |i: &&toml::Value| i.get("role").and_then(toml::Value::as_str) == Some(role);
            let inputs = inputs.iter().filter(of_role);
            inputs.filter_map(|i| Some(i.get("name")?.as_str()?.to_owned())).collect()
        };
        (sweep.about.sweeps, sweep.about.traces) = (names("sweep"), names("trace"));
        Ok(sweep)
    }

    /// What the sweep file says.
    fn describe(&mut self, root: &toml::Table) {
        if let Some(question) = root.get("question").and_then(toml::Value::as_str) {
            self.about.text = question.trim().to_owned();
        }
        let names = |key: &str| -> Vec<String> {
            let list = root.get("objectives").and_then(|o| o.get(key));
            let list = list.and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
            list.iter().filter_map(toml::Value::as_str).map(str::to_owned).collect()
        };
        let minimize = names("minimize").into_iter().map(Objective::minimize);
        let maximize = names("maximize").into_iter().map(Objective::maximize);
        self.about.objectives = minimize.chain(maximize).collect();
        self.about.followers = followers(root);
    }

    /// The files that the sweep was made from, as `run.toml` has them.
    fn inputs(&self) -> Vec<toml::Value> {
        let mut text = String::new();
        let file = File::open(self.path.join("run.toml"));
        let read = file.and_then(|f| f.take(SWEEP_FILE_MAX).read_to_string(&mut text));
        let root = read.ok().and_then(|_| text.parse::<toml::Table>().ok()).unwrap_or_default();
        root.get("inputs").and_then(toml::Value::as_array).cloned().unwrap_or_default()
    }

    /// The path of the results.
    pub(super) fn results_path(&self) -> PathBuf {
        self.path.join(CSV)
    }

    /// The results, from their beginning.
    pub(super) fn results(&self) -> Result<BufReader<File>, Failure> {
        let path = self.results_path();
        let what = || format!("{}: is its folder one of `sweep`?", path.display());
        Ok(BufReader::new(File::open(&path).or_exit(Exit::BadInput, what())?))
    }

    /// The results as columns, those that the question needs.
    pub(super) fn table(&self, question: &Question) -> Result<Table, Failure> {
        let read = Table::read(self.results()?, |column| question.needs(column));
        let mut table = read.or_exit(Exit::BadInput, self.results_path().display())?;
        table.follow(&self.about.followers);
        Ok(table)
    }
}

/// Derived keys, and of keys that are varied together all but the first.
fn followers(sweep: &toml::Table) -> BTreeSet<String> {
    let mut all = Vec::new();
    if let Some(derived) = sweep.get("derived").and_then(toml::Value::as_table) {
        keys("", derived, DEPTH_MAX, &mut all);
    }
    let axes = sweep.get("axes").and_then(toml::Value::as_array);
    for axis in axes.into_iter().flatten() {
        if let Some(zip) = axis.get("zip").and_then(toml::Value::as_table) {
            let mut together = Vec::new();
            keys("", zip, DEPTH_MAX, &mut together);
            all.extend(together.into_iter().skip(1));
        }
    }
    all.into_iter().collect()
}

/// Parts of a key; files have fewer.
const DEPTH_MAX: usize = 16;

/// The dotted keys of a table; a table with `from` is a range and no further part of the key.
fn keys(prefix: &str, table: &toml::Table, depth: usize, found: &mut Vec<String>) {
    for (key, value) in table {
        let key = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            toml::Value::Table(inner) if depth > 0 && !inner.contains_key("from") => {
                keys(&key, inner, depth - 1, found);
            }
            _ => found.push(key),
        }
    }
}

/// Writes the report folder; `None` if it was interrupted.
pub(super) fn write(
    path: &Path,
    analysis: &Analysis,
    pareto: &[u8],
    provenance: &Provenance,
    context: &Context,
) -> Result<Option<PathBuf>, Failure> {
    // A report follows from the results: an older one is simply replaced.
    let folder = RunFolder::create(Some(path), "analysis", true)?;
    let charts = sweep::charts(analysis);
    folder.write("pareto.csv", pareto)?;
    let page = sweep::document(analysis, &charts, provenance);
    folder.write("summary.md", page.markdown().as_bytes())?;
    let html = page.html(&provenance.title).or_exit(Exit::Internal, "report")?;
    folder.write("report.html", html.as_bytes())?;
    for chart in &charts {
        if context.is_cancelled() {
            return Ok(None);
        }
        folder.write_charts(std::slice::from_ref(chart))?;
    }
    Ok(Some(folder.finish()?))
}
