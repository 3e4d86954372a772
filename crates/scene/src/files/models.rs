//! Models: a file, a folder with an index (`meta.json`, `lod-meta.json`) or with what a trainer
//! leaves in it, or such an index itself.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use super::super::foveated::MAGIC;
use super::super::{Folder, Foveated, Gaussians, Input, ReadAs, SceneError, Warning, read_as};
use super::{FileError, at, other};

/// Names of models in a folder, in the order in which they are looked for: indices of SOG, what
/// INRIA's trainer writes, what nerfstudio exports.
const NAMES: [&str; 4] = ["lod-meta.json", "meta.json", "point_cloud.ply", "splat.ply"];
/// Where INRIA's trainer keeps the models of a run, a folder for each iteration.
const ITERATIONS: [&str; 2] = ["point_cloud", "."];

/// A model that was read from a file.
#[derive(Debug, Clone)]
pub struct OpenedModel {
    /// The parameters.
    pub gaussians: Gaussians,
    /// A short name of the file's format, e.g. `ply`, `spz v4`.
    pub format: &'static str,
    /// Oddities that do not prevent its use.
    pub warnings: Vec<Warning>,
    /// The file that was opened: for a folder, the index inside it.
    pub path: PathBuf,
}

/// Reads the model at `path`, any format; `lod` is the detail of a streamed scene.
///
/// # Errors
/// [`FileError`]: it cannot be read, is no model or is damaged, or has no such detail.
pub fn open_model(path: &Path, lod: Option<u32>) -> Result<OpenedModel, FileError> {
    open_model_as(path, ReadAs { detail: lod, axes: None })
}

/// As [`open_model`], with what the file does not say.
///
/// # Errors
/// Those of [`open_model`].
pub fn open_model_as(path: &Path, known: ReadAs) -> Result<OpenedModel, FileError> {
    let path = if path.is_dir() { model_in(path)? } else { path.to_path_buf() };
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
    let folder = Disk(parent.unwrap_or(Path::new(".")).to_path_buf());
    let shown = path.display();
    let Some(name) = path.file_name().map(|name| name.to_string_lossy()) else {
        return Err(other(shown, "no name of a file"));
    };
    let name = name.as_ref();
    let model = match read_as(&ModelEntry { folder, path: &path, name }, name, known) {
        Ok(model) => model,
        // The file itself: its name is already in front.
        Err(SceneError::Io { name: own, source }) if own == name => return Err(at(shown)(source)),
        Err(error) => return Err(at(shown)(error)),
    };
    let format = model.format.name();
    Ok(OpenedModel { gaussians: model.gaussians, format, warnings: model.warnings, path })
}

/// Reads the foveated model at `path`.
///
/// # Errors
/// [`FileError`]: it cannot be read, is no foveated model or is damaged.
pub fn open_foveated(path: &Path) -> Result<Foveated, FileError> {
    let shown = path.display();
    let input = open(path).map_err(at(&shown))?;
    Foveated::read(input).map_err(at(&shown))
}

/// Whether the file at `path` says that it is a foveated model.
pub fn is_foveated(path: &Path) -> bool {
    let mut head = [0; MAGIC.len()];
    if !path.is_file() {
        return false;
    }
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut head));
    read.is_ok() && head == MAGIC
}

/// The model that a folder is for: its own, or that of the last iteration of a run.
fn model_in(folder: &Path) -> Result<PathBuf, FileError> {
    let own = |folder: &Path| NAMES.iter().map(|name| folder.join(name)).find(|p| p.is_file());
    let last = || ITERATIONS.iter().find_map(|name| last_iteration(&folder.join(name)));
    let what = "a folder without a model that is known by its name (meta.json, lod-meta.json, \
                point_cloud.ply, splat.ply, point_cloud/iteration_*/point_cloud.ply); give the \
                file of the scene";
    own(folder)
        .or_else(|| last().as_deref().and_then(own))
        .ok_or_else(|| other(folder.display(), what))
}

/// The folder of the highest iteration that has a model.
fn last_iteration(folder: &Path) -> Option<PathBuf> {
    let entries = std::fs::read_dir(folder).ok()?;
    let iteration = |path: PathBuf| {
        let name = path.file_name()?.to_str()?;
        let number: u64 = name.strip_prefix("iteration_")?.parse().ok()?;
        path.join("point_cloud.ply").is_file().then_some((number, path))
    };
    let iterations = entries.filter_map(|entry| iteration(entry.ok()?.path()));
    iterations.max().map(|(_, path)| path)
}

/// A folder on disk.
struct Disk(PathBuf);

impl Folder for Disk {
    fn open(&self, name: &str) -> io::Result<Input<'_>> {
        open(&self.0.join(name))
    }
}

/// The file that was named, and its folder. Its own name may be anything.
struct ModelEntry<'a> {
    folder: Disk,
    path: &'a Path,
    /// Its name as text; that on disk may be none.
    name: &'a str,
}

impl Folder for ModelEntry<'_> {
    fn open(&self, name: &str) -> io::Result<Input<'_>> {
        if name == self.name {
            return open(self.path);
        }
        self.folder.open(name)
    }
}

fn open(path: &Path) -> io::Result<Input<'static>> {
    // Opening a pipe waits for somebody who writes.
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::Unsupported, "not a regular file"));
    }
    let file = File::open(path)?;
    let facts = file.metadata()?;
    Ok(Input { reader: Box::new(BufReader::with_capacity(1 << 18, file)), len: facts.len() })
}
