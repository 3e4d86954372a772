//! A folder of files that belong together: it appears complete or not at all, and never in place of
//! something else.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf, absolute};
use std::time::Duration;

use tempfile::TempDir;

use super::{Exit, Failure, OrExit};
use powergs_chart::Chart;
use powergs_core::run::store::atomic::{exchange, nameless, sync_folder};
use powergs_report::document::Document;
use powergs_report::{Drawing, is_file_name, sweep};
use powergs_scene::export::FOLDER_FILES;

/// Where a report goes.
#[derive(Debug, Clone, clap::Args)]
pub struct ReportArgs {
    /// Report folder [default: a new one in reports/, named after what is simulated]
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the finished report in --out, and files that other flags name
    #[arg(long)]
    pub force: bool,
}

impl ReportArgs {
    /// As [`RunFolder::create`].
    ///
    /// # Errors
    /// Those of [`RunFolder::create`].
    pub fn folder(&self, name: &str) -> Result<RunFolder, Failure> {
        RunFolder::create(self.out.as_deref(), name, self.force)
    }
}

/// A folder being written: a hidden one beside the final place, renamed at the end, removed if it
/// is dropped before.
#[derive(Debug)]
pub struct RunFolder {
    staging: TempDir,
    target: RunFolderTarget,
    kind: Kind,
    /// Held while the folder is written: a hidden folder without it is one that a killed process
    /// left.
    _lock: Option<File>,
}

/// What a folder holds. One is never put in the place of the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// The report of `replay`, `compare` or `sensitivity`; replaced if the user says so.
    Report,
    /// The analysis of a sweep: it follows from the results, so an older one is simply replaced.
    Analysis,
    /// A model as SOG; replaced if the user says so.
    Model,
}

/// Where the folder will be.
#[derive(Debug, Clone)]
enum RunFolderTarget {
    /// Where the user said.
    Given { path: PathBuf, force: bool },
    /// The first free one of `path`, `path-2`, `path-3`, …
    Counted(PathBuf),
}

/// Names that end with a counter are tried up to here.
const MOST: usize = 10_000;

/// What the names of hidden folders begin with.
const PREFIX: &str = ".report-";

impl RunFolder {
    /// A new folder at `out`, or at the first free of `reports/NAME`, `reports/NAME-2`, …
    ///
    /// Refused with [`Exit::Usage`] before any work is done: a finished report without `force`,
    /// and, whatever the flags, a folder with files that are not of a report.
    pub fn create(out: Option<&Path>, name: &str, force: bool) -> Result<RunFolder, Failure> {
        let target = match out {
            Some(path) => RunFolderTarget::Given { path: path.to_owned(), force },
            None => RunFolderTarget::Counted(Path::new("reports").join(file_name(name))),
        };
        RunFolder::begin(target, Kind::Report)
    }

    /// The folder of an analysis, in place of an older one.
    ///
    /// Refused with [`Exit::Usage`]: a folder that holds anything else.
    pub fn analysis(path: &Path) -> Result<RunFolder, Failure> {
        RunFolder::begin(
            RunFolderTarget::Given { path: path.to_owned(), force: true },
            Kind::Analysis,
        )
    }

    /// The folder of a model.
    ///
    /// Refused with [`Exit::Usage`] as by [`RunFolder::check_model`].
    pub fn model(path: &Path, force: bool) -> Result<RunFolder, Failure> {
        RunFolder::begin(RunFolderTarget::Given { path: path.to_owned(), force }, Kind::Model)
    }

    /// Refuses a place for a model, before any work is done: a file, a model without `force`, and,
    /// whatever the flags, a folder with anything else.
    pub fn check_model(path: &Path, force: bool) -> Result<(), Failure> {
        check_given(path, force, Kind::Model)
    }

    fn begin(target: RunFolderTarget, kind: Kind) -> Result<RunFolder, Failure> {
        if let RunFolderTarget::Given { path, force } = &target {
            check_given(path, *force, kind)?;
        }
        let path = target.path();
        // `.` and `..` have a name and a folder that holds them, too.
        let parent = absolute(path).map_err(|e| kind.cannot(path, &e))?;
        let parent = parent.parent().unwrap_or(Path::new("/")).to_owned();
        fs::create_dir_all(&parent).map_err(|e| kind.cannot(path, &e))?;
        let (staging, lock) = stage(&parent).map_err(|e| kind.cannot(path, &e))?;
        Ok(RunFolder { staging, target, kind, _lock: lock })
    }

    /// Writes a file.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        debug_assert!(self.kind.has(name), "{name} is not a file of a report");
        let path = self.staging.path().join(name);
        fs::write(path, bytes).map_err(|e| self.kind.cannot(self.target.path(), &e))
    }

    /// Writes a page for editors and for browsers.
    pub fn write_pages(&self, page: &Document, drawing: &Drawing) -> Result<(), Failure> {
        for file in drawing.pages(page).or_exit(Exit::Internal, "report.html")? {
            self.write(&file.name, &file.bytes)?;
        }
        Ok(())
    }

    /// Writes the files of every chart.
    pub fn write_charts(&self, charts: &[Chart], drawing: &Drawing) -> Result<(), Failure> {
        for file in drawing.files(charts).or_exit(Exit::Internal, "charts")? {
            self.write(&file.name, &file.bytes)?;
        }
        Ok(())
    }

    /// Makes a file that is written as a stream.
    pub fn stream(&self, name: &str) -> Result<fs::File, Failure> {
        debug_assert!(self.kind.has(name), "{name} is not a file of a report");
        let path = self.staging.path().join(name);
        fs::File::create(path).map_err(|e| self.kind.cannot(self.target.path(), &e))
    }

    /// Moves the folder to its place and returns that.
    pub fn finish(self) -> Result<PathBuf, Failure> {
        let kind = self.kind;
        sync_all(self.staging.path()).map_err(|e| kind.cannot(self.target.path(), &e))?;
        match &self.target {
            RunFolderTarget::Given { path, force } => {
                check_given(path, *force, kind)?;
                let place = absolute(path).map_err(|e| kind.cannot(path, &e))?;
                replace(self.staging.path(), &place).map_err(|e| kind.cannot(path, &e))?;
                Ok(path.clone())
            }
            RunFolderTarget::Counted(base) => {
                for i in 1..MOST {
                    let path = numbered(base, i);
                    // Renaming over a folder with files fails, so of two runs one takes the next.
                    if !path.exists() && fs::rename(self.staging.path(), &path).is_ok() {
                        path.parent().into_iter().for_each(sync_folder);
                        return Ok(path);
                    }
                }
                let what = "no free name for a report; delete old reports or use --out";
                Err(Failure::new(Exit::Usage, format!("{}: {what}", base.display())))
            }
        }
    }
}

impl RunFolderTarget {
    fn path(&self) -> &Path {
        match self {
            RunFolderTarget::Given { path, .. } | RunFolderTarget::Counted(path) => path,
        }
    }
}

/// `base`, `base-2`, `base-3`, …: the `i`-th, from 1.
pub fn numbered(base: &Path, i: usize) -> PathBuf {
    if i == 1 {
        return base.to_owned();
    }
    let mut name = base.as_os_str().to_owned();
    name.push(format!("-{i}"));
    name.into()
}

/// A name that is one plain component of a path.
fn file_name(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let name: String = name.chars().take(100).map(plain).collect();
    let name = name.trim_start_matches('.');
    if name.is_empty() { "report".into() } else { name.into() }
}

impl Kind {
    /// Whether such a folder may have a file of this name.
    fn has(self, name: &str) -> bool {
        match self {
            Kind::Report => is_file_name(name),
            Kind::Analysis => sweep::is_file_name(name),
            Kind::Model => FOLDER_FILES.contains(&name),
        }
    }

    fn name(self) -> &'static str {
        match self {
            Kind::Report => "a report",
            Kind::Analysis => "an analysis",
            Kind::Model => "a model",
        }
    }

    /// What the user does to name another folder.
    fn advice(self) -> &'static str {
        match self {
            Kind::Report | Kind::Analysis => "give --out a folder",
            Kind::Model => "name a folder",
        }
    }

    fn cannot(self, path: &Path, e: &io::Error) -> Failure {
        // What a temporary folder is called is nobody's business.
        let cause = nameless(io::Error::new(e.kind(), e.to_string()));
        let what = match self {
            Kind::Report | Kind::Analysis => "the report",
            Kind::Model => "the model",
        };
        Failure::new(Exit::Usage, format!("{}: {what} cannot be written: {cause}", path.display()))
    }
}

/// Whether a folder of this kind may be put at `path`.
fn check_given(path: &Path, force: bool, kind: Kind) -> Result<(), Failure> {
    let refuse = |what: String| Failure::new(Exit::Usage, format!("{}: {what}", path.display()));
    let entries = match fs::read_dir(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        Err(e) if e.kind() == io::ErrorKind::NotADirectory => {
            return Err(refuse(format!("is a file; {}", kind.advice())));
        }
        Err(e) => return Err(kind.cannot(path, &e)),
        Ok(entries) => entries,
    };
    let is_here = |here: PathBuf| fs::canonicalize(path).is_ok_and(|path| path == here);
    if std::env::current_dir().is_ok_and(is_here) {
        let (name, advice) = (kind.name(), kind.advice());
        let what = format!(
            "is the working folder, and {name} takes the place of a whole folder; {advice} in it"
        );
        return Err(refuse(what));
    }
    let mut names: Vec<(OsString, bool)> = Vec::new();
    for entry in entries {
        let entry = entry.map_err(|e| kind.cannot(path, &e))?;
        let is_folder = entry.file_type().map_err(|e| kind.cannot(path, &e))?.is_dir();
        names.push((entry.file_name(), is_folder));
    }
    names.sort();
    let ours = |name: &OsString| name.to_str().is_some_and(|name| kind.has(name));
    if let Some((name, _)) = names.iter().find(|(name, is_folder)| *is_folder || !ours(name)) {
        let (name, kind) = (name.to_string_lossy(), kind.name());
        return Err(refuse(format!("holds `{name}`, which is not of {kind}; use another folder")));
    }
    if !names.is_empty() && !force {
        let kind = kind.name();
        let what = format!("holds {kind} already; use --force to replace it, or another folder");
        return Err(refuse(what));
    }
    Ok(())
}

/// A hidden folder, locked, after those that killed processes left were removed.
fn stage(parent: &Path) -> io::Result<(TempDir, Option<File>)> {
    // Whoever makes or removes hidden folders holds the lock of the folder around them, so that
    // none is taken for a leftover before it is locked itself.
    let guard = File::open(parent).ok().filter(|folder| {
        let tries = 0..100;
        tries.into_iter().any(|_| {
            let is_held = folder.try_lock().is_ok();
            if !is_held {
                std::thread::sleep(Duration::from_millis(5));
            }
            is_held
        })
    });
    if guard.is_some() {
        remove_leftovers(parent);
    }
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
    let staging = builder.tempdir_in(parent)?;
    let lock = File::open(staging.path()).ok().filter(|folder| folder.try_lock().is_ok());
    Ok((staging, lock))
}

/// Removes hidden folders that nobody has locked. What cannot be removed stays.
fn remove_leftovers(parent: &Path) {
    let Ok(entries) = fs::read_dir(parent) else { return };
    for entry in entries.flatten() {
        let is_hidden = entry.file_name().as_encoded_bytes().starts_with(PREFIX.as_bytes());
        if !is_hidden || !entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            continue;
        }
        let is_left = File::open(entry.path()).is_ok_and(|folder| folder.try_lock().is_ok());
        if is_left {
            let _ = fs::remove_dir_all(entry.path());
        }
    }
}

/// Makes sure that the files of a folder survive a power cut.
fn sync_all(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        File::open(entry?.path())?.sync_data()?;
    }
    sync_folder(folder);
    Ok(())
}

/// Puts `staging` in the place of `path`, which is absent, empty, or a report to be replaced. At no
/// moment is there neither the old nor the new one, where the file system can exchange two names.
fn replace(staging: &Path, path: &Path) -> io::Result<()> {
    if !path.exists() {
        fs::rename(staging, path)?;
    } else if exchange(staging, path).is_ok() {
        fs::remove_dir_all(staging)?;
    } else {
        let old = staging.with_extension("old");
        fs::rename(path, &old)?;
        if let Err(e) = fs::rename(staging, path) {
            fs::rename(&old, path)?;
            return Err(e);
        }
        fs::remove_dir_all(old)?;
    }
    path.parent().into_iter().for_each(sync_folder);
    Ok(())
}
