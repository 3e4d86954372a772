//! Which sweep is asked for.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use powergs_core::run::{RunError, Store};

/// A sweep file with what is changed of it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SweepRequest {
    /// The sweep file: a name that comes with the program, or a path.
    pub file: String,
    /// Trace files or patterns, in place of those in the sweep file.
    pub traces: Vec<String>,
    /// Only these frames of each trace, the end excluded, counted from 0.
    pub frames: Option<(usize, Option<usize>)>,
    /// Changed keys of the base machine, `key=value`.
    pub sets: Vec<String>,
    /// At most this many designs, spread over the space.
    pub points: Option<u64>,
    /// The model of the DRAM; without one that of the machine, with `calibrated` in place of
    /// `banked` where designs are many.
    #[serde(default)]
    pub dram_model: Option<String>,
    /// Another display rate than that of the sweep file, frames per second.
    #[serde(default)]
    pub display_fps: Option<f64>,
    /// Another display than that of the sweep file.
    #[serde(default)]
    pub display: Option<String>,
    /// What takes the place of `banked`, where no model is named.
    #[serde(default)]
    pub stand_in: StandIn,
    /// Where the files lie that `sets` and `display` name; without one the working folder.
    #[serde(default)]
    pub folder: Option<PathBuf>,
}

/// When `calibrated` takes the place of a machine's `banked`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StandIn {
    /// Where designs are many.
    #[default]
    Many,
    /// Always: nothing is confirmed either.
    Always,
    /// Never.
    Never,
}

/// What a sweep was begun with, in its folder.
const FILE: &str = "definition.json";

impl SweepRequest {
    /// A sweep file as it is.
    pub fn of(file: &str) -> SweepRequest {
        SweepRequest { file: file.to_owned(), ..SweepRequest::default() }
    }

    /// Where the files lie that it names, from anywhere.
    pub(super) fn folder(&self) -> Option<PathBuf> {
        self.folder.clone().or_else(|| std::path::absolute(".").ok())
    }

    /// Keeps the request, so that the sweep can be opened from its folder alone and from anywhere.
    ///
    /// # Errors
    /// [`RunError::Output`]: the store cannot be written.
    pub fn remember(&self, store: &dyn Store) -> Result<(), RunError> {
        let absolute = |path: &str| {
            let exists = std::path::Path::new(path).exists() || path.contains(['*', '?']);
            let whole = std::path::absolute(path).ok().filter(|_| exists);
            whole.map_or(path.to_owned(), |p| p.display().to_string())
        };
        let whole = SweepRequest {
            file: absolute(&self.file),
            traces: self.traces.iter().map(|t| absolute(t)).collect(),
            folder: self.folder(),
            ..self.clone()
        };
        let text = serde_json::to_string_pretty(&whole);
        let text = text.map_err(|e| RunError::Internal(format!("{FILE}: {e}")))?;
        store.write(FILE, text.as_bytes())
    }

    /// What the sweep of a folder was begun with.
    ///
    /// # Errors
    /// [`RunError::Input`]: it is not there, or damaged.
    pub(crate) fn recall(store: &dyn Store) -> Result<SweepRequest, RunError> {
        let place = store.place(FILE);
        let Some(text) = store.read_text(FILE)? else {
            let message = "No such file or directory (os error 2)".into();
            return Err(RunError::Input { place, message });
        };
        let json: Value = serde_json::from_str(&text).map_err(|e| RunError::input(&place, e))?;
        let damaged = || RunError::Input { place: place.clone(), message: "damaged".into() };
        serde_json::from_value(json).map_err(|_| damaged())
    }
}
