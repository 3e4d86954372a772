//! The traces of a sweep: patterns become files, files become opened and hashed traces with labels
//! that differ.

use std::path::{Path, PathBuf};

use crate::sweep::table::TraceLabel;
use powergs_core::run::files::placed_in;
use powergs_core::run::{Frames, Input, RunError, TraceFile};

/// A trace of a sweep, opened.
pub struct SweepTrace<'a> {
    /// Its frames.
    pub frames: Box<dyn Frames + 'a>,
    /// What the table calls it.
    pub label: TraceLabel,
    /// Hash of its content and of which frames are used.
    pub hash: u128,
    /// What was read.
    pub input: Input,
    /// Whether its views have the names of pairs, and are none.
    pub looks_paired: bool,
    /// Its file, as it was found; `None` for frames in memory.
    pub place: Option<String>,
}

impl<'a> SweepTrace<'a> {
    /// Frames under the name that the table gives them, with their weight in means over traces.
    ///
    /// # Errors
    /// [`RunError::Input`]: frames that cannot be read.
    pub fn new(
        mut frames: Box<dyn Frames + 'a>,
        label: TraceLabel,
    ) -> Result<SweepTrace<'a>, RunError> {
        let input = frames.identity()?;
        let mut bytes = input.xxh3.to_le_bytes().to_vec();
        bytes.extend((frames.range().start as u64).to_le_bytes());
        bytes.extend((frames.range().end as u64).to_le_bytes());
        let hash = xxhash_rust::xxh3::xxh3_128(&bytes);
        Ok(SweepTrace { frames, label, hash, input, looks_paired: false, place: None })
    }
}

/// A trace of a request: a file, or a pattern of files.
#[derive(Debug, Clone)]
pub struct TraceRequest {
    /// Path or pattern: `*` and `?` stand for any characters of a name.
    pub pattern: String,
    /// The folder that it is in; without one the working folder.
    pub folder: Option<PathBuf>,
    /// What the table calls it; the name of the file without its ending by default.
    pub label: Option<String>,
    /// Its weight; of each file, if there are several.
    pub weight: f64,
}

/// Opens all traces.
///
/// # Errors
/// [`RunError::Request`]: two traces with one label, a range without frames; [`RunError::Input`]:
/// a pattern without files, a file that is no trace.
pub fn open(
    wanted: &[TraceRequest],
    range: Option<(usize, Option<usize>)>,
) -> Result<Vec<SweepTrace<'static>>, RunError> {
    let mut opened: Vec<SweepTrace> = Vec::new();
    for w in wanted {
        let files = trace_files(&w.pattern, w.folder.as_deref())?;
        if files.len() > 1 && w.label.is_some() {
            let what = format!("traces `{}`: one label for {} files", w.pattern, files.len());
            return Err(RunError::Request(format!("{what}; leave `label` out")));
        }
        for file in files {
            let mut trace = TraceFile::open(&file)?;
            if let Some((start, end)) = range {
                trace.select(start, end)?;
            }
            let label = w.label.clone().unwrap_or_else(|| trace.name().to_owned());
            if opened.iter().any(|t| t.label.label == label) {
                let what = format!("two traces are called `{label}`");
                let what = format!("{what}: give them labels in the sweep file ([[traces]])");
                return Err(RunError::Request(what));
            }
            let label = TraceLabel { label, weight: w.weight };
            let looks_paired = trace.looks_paired()?;
            let trace = SweepTrace::new(Box::new(trace), label)?;
            let place = Some(file.display().to_string());
            opened.push(SweepTrace { looks_paired, place, ..trace });
        }
    }
    Ok(opened)
}

/// Files of one pattern at most.
const FILES_MAX: usize = 10_000;

/// The files of a pattern with `*` and `?` in `folder`, or in the working folder, sorted.
///
/// # Errors
/// [`RunError::Input`]: there is none; [`RunError::Request`]: too many.
pub fn trace_files(pattern: &str, folder: Option<&Path>) -> Result<Vec<PathBuf>, RunError> {
    let path = placed_in(pattern, folder);
    if path.exists() {
        return Ok(vec![path]);
    }
    let found = glob::glob(&glob_of(pattern, folder));
    let found = found.map_err(|e| RunError::config(format!("traces `{pattern}`"), e))?;
    let mut files: Vec<PathBuf> = found.filter_map(Result::ok).take(FILES_MAX + 1).collect();
    if files.len() > FILES_MAX {
        let what = format!("traces `{pattern}`: more than {FILES_MAX} files; narrow the pattern");
        return Err(RunError::Request(what));
    }
    files.sort();
    if files.is_empty() {
        let place = format!("traces `{}`", path.display());
        let message = "no such file; make one with `extract`".into();
        return Err(RunError::Input { place, message });
    }
    Ok(files)
}

/// A pattern in a folder as `glob` has it, which takes brackets for sets of characters, and would
/// read a folder as a pattern.
fn glob_of(pattern: &str, folder: Option<&Path>) -> String {
    let plain = |c: char| match c {
        '[' | ']' => format!("[{c}]"),
        c => c.to_string(),
    };
    let pattern: String = pattern.chars().map(plain).collect();
    let folder = folder.map(|folder| glob::Pattern::escape(&folder.to_string_lossy()));
    let folder = folder.filter(|folder| !folder.is_empty() && !Path::new(&pattern).is_absolute());
    folder.map_or(pattern.clone(), |folder| format!("{folder}/{pattern}"))
}
