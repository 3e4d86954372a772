//! The traces of a sweep: patterns become files, files become opened and hashed traces with labels
//! that differ.

use std::path::{Path, PathBuf};

use crate::cli::camera_file::FrameRange;
use crate::cli::{Exit, Failure, OrExit, inputs};
use powergs_core::run::{Frames, TraceFile};
use powergs_study::sweep::table::TraceLabel;

/// A trace, opened.
pub struct OpenedTrace {
    /// Its frames.
    pub source: TraceFile,
    /// What the table calls it.
    pub label: TraceLabel,
    /// Hash of its content and of which frames are used.
    pub hash: u128,
}

/// A trace that somebody asked for: a file, or a pattern of files.
#[derive(Debug, Clone)]
pub struct Wanted {
    /// Path or pattern.
    pub pattern: String,
    /// What the table calls it; the name of the file without its ending by default.
    pub label: Option<String>,
    /// Its weight; of each file, if there are several.
    pub weight: f64,
}

/// Opens all traces. Paths are relative to `folder`, if they are there.
///
/// # Errors
/// Exit code 2: a pattern without files, two traces with one label; 3: a file that is no trace.
pub fn open(
    wanted: &[Wanted],
    folder: Option<&Path>,
    frames: Option<FrameRange>,
) -> Result<Vec<OpenedTrace>, Failure> {
    let mut opened: Vec<OpenedTrace> = Vec::new();
    for w in wanted {
        let files = files(&w.pattern, folder)?;
        if files.len() > 1 && w.label.is_some() {
            let what = format!("traces `{}`: one label for {} files", w.pattern, files.len());
            return Err(Failure::new(Exit::Usage, format!("{what}; leave `label` out")));
        }
        for file in files {
            let source = inputs::trace(&file, frames)?;
            let label = w.label.clone().unwrap_or_else(|| source.name().to_owned());
            if opened.iter().any(|t| t.label.label == label) {
                let what = format!("two traces are called `{label}`");
                let what = format!("{what}: give them labels in the sweep file ([[traces]])");
                return Err(Failure::new(Exit::Usage, what));
            }
            let label = TraceLabel { label, weight: w.weight };
            let hash = hash(&source);
            opened.push(OpenedTrace { source, label, hash });
        }
    }
    Ok(opened)
}

fn hash(source: &TraceFile) -> u128 {
    let mut bytes = source.input().xxh3.to_le_bytes().to_vec();
    bytes.extend((source.range().start as u64).to_le_bytes());
    bytes.extend((source.range().end as u64).to_le_bytes());
    xxhash_rust::xxh3::xxh3_128(&bytes)
}

/// The files of a pattern, sorted.
fn files(pattern: &str, folder: Option<&Path>) -> Result<Vec<PathBuf>, Failure> {
    let beside = folder.map(|f| f.join(pattern));
    for path in beside.iter().map(PathBuf::as_path).chain([Path::new(pattern)]) {
        if path.exists() {
            return Ok(vec![path.to_owned()]);
        }
        let text = path.to_string_lossy();
        let found = glob::glob(&text).or_exit(Exit::Usage, format_args!("--traces {pattern}"))?;
        let mut files: Vec<PathBuf> = found.filter_map(Result::ok).collect();
        files.sort();
        if !files.is_empty() {
            return Ok(files);
        }
    }
    let what = format!("traces `{pattern}`: no such file; make one with `extract`");
    Err(Failure::new(Exit::BadInput, what))
}
