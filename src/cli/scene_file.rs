//! Opening scenes: a file, a folder with `meta.json` or `lod-meta.json`, or such an index itself.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use super::gaze::{GazeArgs, refuse_plain};
use super::{Exit, Failure, OrExit};
use powergs_scene::foveated::MAGIC;
use powergs_scene::{self as scene, Folder, Foveated, Gaussians, Input, SceneError, Warning};

/// Names of index files in a folder, in the order in which they are looked for.
const INDICES: [&str; 2] = ["lod-meta.json", "meta.json"];

/// A model that was read from a file.
#[derive(Debug, Clone)]
pub struct LoadedScene {
    /// The parameters.
    pub gaussians: Gaussians,
    /// A short name of the file's format, e.g. `ply`, `spz v4`.
    pub format: &'static str,
    /// Oddities that do not prevent its use.
    pub warnings: Vec<Warning>,
    /// The file that was opened: for a folder, the index inside it.
    pub path: PathBuf,
}

impl LoadedScene {
    /// Prints the warnings on standard error, unless that is silenced.
    pub fn warn(&self, context: &super::Context) {
        if !context.global.quiet {
            let name = self.path.display();
            self.warnings.iter().for_each(|w| super::out::complain(format!("{name}: {w}")));
        }
    }
}

/// Reads the scene at `path`, any format; `lod` is the level of a streamed scene.
pub fn load(path: &Path, lod: Option<u32>) -> Result<LoadedScene, Failure> {
    let path = if path.is_dir() { index_of(path)? } else { path.to_path_buf() };
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty());
    let folder = Disk(parent.unwrap_or(Path::new(".")).to_path_buf());
    let shown = path.display();
    let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
        return Err(Failure::new(Exit::BadInput, format!("{shown}: no name of a file")));
    };
    let model = match scene::read(&Entry { folder, path: &path }, name, lod) {
        Ok(model) => model,
        // The file itself: its name is already in front.
        Err(SceneError::Io { name: at, source }) if at == name => {
            return Err(source).or_exit(Exit::BadInput, shown);
        }
        Err(e @ (SceneError::NoLevels { .. } | SceneError::NoSuchLevel { .. })) => {
            return Err(e).or_exit(Exit::Usage, format!("{shown}: --lod"));
        }
        Err(e) => return Err(e).or_exit(Exit::BadInput, shown),
    };
    let format = model.format.name();
    Ok(LoadedScene { gaussians: model.gaussians, format, warnings: model.warnings, path })
}

/// Reads the foveated model at `path`.
pub fn load_foveated(path: &Path) -> Result<Foveated, Failure> {
    let shown = path.display();
    let input = open(path).or_exit(Exit::BadInput, &shown)?;
    Foveated::read(input).or_exit(Exit::BadInput, &shown)
}

/// What a command shows: a plain model, or all levels of a foveated one.
#[derive(Debug)]
pub enum Shown {
    /// A plain model.
    Plain(LoadedScene),
    /// A foveated model.
    Foveated(Box<Foveated>),
}

impl Shown {
    /// Opens what a command with gaze flags shows: with a gaze a foveated model is needed, without
    /// one such a model gives its level 1, or another with `lod`.
    ///
    /// # Errors
    /// As [`load`]; exit code 2 for a gaze with a plain model, or with `lod`.
    pub fn open(
        path: &Path,
        lod: Option<u32>,
        gaze: &GazeArgs,
        context: &super::Context,
    ) -> Result<Shown, Failure> {
        if !gaze.is_given() {
            let scene = load(path, lod)?;
            scene.warn(context);
            return Ok(Shown::Plain(scene));
        }
        if !is_foveated(path) {
            // A file that is not there is said to be that.
            load(path, lod)?;
            refuse_plain(path.display())?;
        }
        if lod.is_some() {
            let what = "--lod chooses one level and a gaze shows all: leave one of them out";
            return Err(Failure::new(Exit::Usage, what));
        }
        Ok(Shown::Foveated(Box::new(load_foveated(path)?)))
    }

    /// Level 1, or the only one.
    pub fn base(&self) -> &Gaussians {
        match self {
            Shown::Plain(scene) => &scene.gaussians,
            Shown::Foveated(model) => &model.base,
        }
    }
}

/// Whether the file at `path` says that it is a foveated model.
pub fn is_foveated(path: &Path) -> bool {
    let mut head = [0; MAGIC.len()];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut head));
    read.is_ok() && head == MAGIC
}

fn index_of(folder: &Path) -> Result<PathBuf, Failure> {
    INDICES.iter().map(|name| folder.join(name)).find(|path| path.is_file()).ok_or_else(|| {
        let what = "a folder without meta.json or lod-meta.json; give the file of the scene";
        Failure::new(Exit::BadInput, format!("{}: {what}", folder.display()))
    })
}

/// A folder on disk.
struct Disk(PathBuf);

impl Folder for Disk {
    fn open(&self, name: &str) -> io::Result<Input<'_>> {
        open(&self.0.join(name))
    }
}

/// The file that the user named, and its folder. Its own name may be anything.
struct Entry<'a> {
    folder: Disk,
    path: &'a Path,
}

impl Folder for Entry<'_> {
    fn open(&self, name: &str) -> io::Result<Input<'_>> {
        if self.path.file_name().is_some_and(|own| own == name) {
            return open(self.path);
        }
        self.folder.open(name)
    }
}

fn open(path: &Path) -> io::Result<Input<'static>> {
    let file = File::open(path)?;
    let facts = file.metadata()?;
    if !facts.is_file() {
        return Err(io::Error::new(io::ErrorKind::Unsupported, "no regular file"));
    }
    Ok(Input { reader: Box::new(BufReader::with_capacity(1 << 18, file)), len: facts.len() })
}
