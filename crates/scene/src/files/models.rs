//! Models: a file, a folder with `meta.json` or `lod-meta.json`, or such an index itself.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use super::super::foveated::MAGIC;
use super::super::{Folder, Foveated, Gaussians, Input, SceneError, Warning, read};
use super::{FileError, at, other};

/// Names of index files in a folder, in the order in which they are looked for.
const INDICES: [&str; 2] = ["lod-meta.json", "meta.json"];

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
    let path = if path.is_dir() { index_of(path)? } else { path.to_path_buf() };
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
    let folder = Disk(parent.unwrap_or(Path::new(".")).to_path_buf());
    let shown = path.display();
    let Some(name) = path.file_name().map(|name| name.to_string_lossy()) else {
        return Err(other(shown, "no name of a file"));
    };
    let name = name.as_ref();
    let model = match read(&Entry { folder, path: &path, name }, name, lod) {
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

fn index_of(folder: &Path) -> Result<PathBuf, FileError> {
    let found = INDICES.iter().map(|name| folder.join(name)).find(|path| path.is_file());
    let what = "a folder without meta.json or lod-meta.json; give the file of the scene";
    found.ok_or_else(|| other(folder.display(), what))
}

/// A folder on disk.
struct Disk(PathBuf);

impl Folder for Disk {
    fn open(&self, name: &str) -> io::Result<Input<'_>> {
        open(&self.0.join(name))
    }
}

/// The file that was named, and its folder. Its own name may be anything.
struct Entry<'a> {
    folder: Disk,
    path: &'a Path,
    /// Its name as text; that on disk may be none.
    name: &'a str,
}

impl Folder for Entry<'_> {
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
