//! The folder of a run that is resumed: its store, and what a finished run leaves beside that.

use std::ffi::OsStr;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::{Exit, Failure, OrExit};
use powergs_chart::Chart;
use powergs_core::run::FileStore;
use powergs_core::run::Store;
use powergs_core::run::store::atomic::{is_temporary, remove_leftovers, write_atomically};
use powergs_core::run::store::{Lock, Sharing};
use powergs_report::Drawing;
pub use powergs_study::sweep::run::Existing;

/// The lock.
const LOCK: &str = "lock";
/// A run is there, and nobody said what to do with it.
const HOLDS: &str =
    "holds a run; go on with --resume, replace it with --force, or give another --out";
/// Something is there that is no run.
const NOT_EMPTY: &str = "is not empty; give --out a new folder";

/// What is in the folder of a run of some kind.
#[derive(Debug)]
pub struct FolderLayout {
    /// The file that a run has from its first moment on.
    pub marker: &'static str,
    /// The folders of its store.
    pub stores: &'static [&'static str],
    /// Whether a run has something of this name in one of them.
    pub is_ours: fn(&str) -> bool,
    /// The folders of what starts its parts; they may be there before the run.
    pub jobs: &'static [&'static str],
    /// What it leaves beside them and its charts.
    pub files: &'static [&'static str],
    /// Its charts, without their endings.
    pub charts: &'static [&'static str],
    /// What the names of further charts begin with; empty for none.
    pub further_charts: &'static str,
}

/// Folders in folders of a store at most.
const STORE_DEPTH: u32 = 3;

/// Removes what killed processes left half written in a folder and those below it. What cannot be
/// removed stays: it is no part of any result.
fn sweep(folder: &Path, depth: u32) {
    let _ = remove_leftovers(folder);
    let Ok(entries) = fs::read_dir(folder) else { return };
    let folders = entries.flatten().filter(|e| e.file_type().is_ok_and(|kind| kind.is_dir()));
    if depth > 0 {
        folders.for_each(|entry| sweep(&entry.path(), depth - 1));
    }
}

/// Where a run is that can be gone on with.
#[derive(Debug, Clone, clap::Args)]
pub struct RunArgs {
    /// Folder of the run [default: runs/NAME]
    #[arg(long, short, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Go on with the run in the folder; repeat its other arguments
    #[arg(long, conflicts_with = "force")]
    pub resume: bool,
    /// Throw away the run in the folder
    #[arg(long)]
    pub force: bool,
}

impl RunArgs {
    /// What to do with a run that is in the folder already.
    pub fn existing(&self) -> Existing {
        match (self.resume, self.force) {
            (true, _) => Existing::Resume,
            (_, true) => Existing::Replace,
            _ => Existing::Refuse,
        }
    }
}

/// A run folder.
pub struct Folder {
    layout: &'static FolderLayout,
    path: PathBuf,
    store: FileStore,
}

impl Folder {
    /// The folder; nothing is opened or made yet.
    pub fn new(path: &Path, layout: &'static FolderLayout) -> Folder {
        Folder { layout, path: path.to_owned(), store: FileStore::new(path) }
    }

    /// Makes the folder ready for a run that begins, or goes on. No other process works in it while
    /// the lock is held.
    ///
    /// # Errors
    /// Exit code 2: a folder that holds something else or that another process works in, a run
    /// that is neither to be resumed nor replaced, no run to resume; 3: a damaged checkpoint, or
    /// one of another run.
    pub fn open(&self, existing: Existing) -> Result<Lock, Failure> {
        let has_run = self.has_run();
        match existing {
            Existing::Resume if !has_run => {
                return self.refuse("no run to go on with; leave --resume out");
            }
            Existing::Refuse if has_run => return self.refuse(HOLDS),
            Existing::Refuse | Existing::Replace if !has_run && !self.is_free(&[]) => {
                return self.refuse(NOT_EMPTY);
            }
            Existing::Resume | Existing::Refuse | Existing::Replace => {}
        }
        if existing == Existing::Replace && has_run {
            self.refuse_foreign()?;
        }
        let lock = self.store.lock(LOCK, Sharing::Alone)?;
        if existing == Existing::Replace && has_run {
            self.clear()?;
        }
        // The lock has swept the folder itself; nobody else writes in the store now.
        let stores = self.layout.stores.iter().map(|store| self.path.join(store));
        stores.for_each(|store| sweep(&store, STORE_DEPTH));
        Ok(lock)
    }

    /// Makes the folder ready for one part of a run: other processes may work on other parts. Files
    /// that tell what the run is are written by the first, and the others must be about the same.
    ///
    /// # Errors
    /// Exit code 2: a folder that holds something else, another run, or one that a process has for
    /// itself.
    pub fn open_part(&self, about: &[(&str, String)]) -> Result<Lock, Failure> {
        // Another part may be about to write what the run is.
        let names: Vec<&str> = about.iter().map(|(name, _)| *name).collect();
        if !self.has_run() && !self.is_free(&names) {
            return self.refuse(NOT_EMPTY);
        }
        let lock = self.store.lock(LOCK, Sharing::Beside)?;
        for (name, text) in about {
            match fs::read_to_string(self.path.join(name)) {
                Ok(there) if there == *text => {}
                Ok(_) => {
                    return self.refuse(&format!(
                        "holds another run: its {name} differs; all parts have the same arguments, \
                         or give another --out"
                    ));
                }
                // The marker comes last: a folder that has it has the others.
                Err(_) => self.write(name, text)?,
            }
        }
        Ok(lock)
    }

    /// Makes the folder ready for parts that other processes do, and leaves it to them.
    ///
    /// # Errors
    /// As [`Folder::open_part`], and for a run that is there and not to be resumed.
    pub fn begin_parts(&self, existing: Existing, about: &[(&str, String)]) -> Result<(), Failure> {
        if existing == Existing::Refuse && self.has_run() {
            return self.refuse(HOLDS);
        }
        self.open_part(about).map(drop)
    }

    fn has_run(&self) -> bool {
        self.path.join(self.layout.marker).is_file()
    }

    fn refuse<T>(&self, what: &str) -> Result<T, Failure> {
        Err(Failure::new(Exit::Usage, format!("{}: {what}", self.path.display())))
    }

    /// Where the run is kept.
    pub fn store(&self) -> &FileStore {
        &self.store
    }

    /// Whether the folder is not there, or empty but for what a run leaves that was killed before
    /// its first checkpoint, jobs, and files of these names.
    fn is_free(&self, but: &[&str]) -> bool {
        let Ok(entries) = fs::read_dir(&self.path) else { return !self.path.exists() };
        let is_store = |name: &OsStr| self.layout.stores.iter().any(|store| name == *store);
        let is_job = |name: &OsStr| self.layout.jobs.iter().any(|folder| name == *folder);
        entries.flatten().all(|entry| match entry.file_name() {
            name if is_store(&name) => fs::read_dir(entry.path())
                .is_ok_and(|inner| inner.flatten().all(|file| is_temporary(&file.file_name()))),
            name if name == LOCK || is_job(&name) || is_temporary(&name) => true,
            name => but.iter().any(|but| name == *but),
        })
    }

    /// Refuses to throw away what the folders of the store hold and no run puts there.
    fn refuse_foreign(&self) -> Result<(), Failure> {
        for store in self.layout.stores {
            let folder = self.path.join(store);
            let Ok(entries) = fs::read_dir(&folder) else { continue };
            for entry in entries {
                let name = entry.or_exit(Exit::Usage, folder.display())?.file_name();
                let is_ours = name.to_str().is_some_and(|name| (self.layout.is_ours)(name));
                if !is_ours && !is_temporary(&name) {
                    let name = Path::new(store).join(&name);
                    return self.refuse(&format!(
                        "holds `{}`, which is not of a run, and --force would remove it: take it \
                         elsewhere, or give another --out",
                        name.display()
                    ));
                }
            }
        }
        Ok(())
    }

    /// Removes the run that is there. Files that are not of a run stay.
    fn clear(&self) -> Result<(), Failure> {
        let entries = fs::read_dir(&self.path).or_exit(Exit::Usage, self.path.display())?;
        for entry in entries {
            let entry = entry.or_exit(Exit::Usage, self.path.display())?;
            let name = entry.file_name();
            if name.to_str().is_some_and(|name| self.layout.has(name)) {
                fs::remove_file(entry.path()).or_exit(Exit::Usage, entry.path().display())?;
            }
        }
        let folders = self.layout.stores.iter().chain(self.layout.jobs);
        Ok(folders.into_iter().try_for_each(|folder| self.store.remove(folder))?)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes a file of the folder, part by part.
    pub fn stream(
        &self,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        Ok(write_atomically(&self.path.join(name), write)?)
    }

    /// Removes a file of the folder that an earlier run may have left.
    pub fn remove(&self, name: &str) -> Result<(), Failure> {
        let path = self.path.join(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                Err(error).or_exit(Exit::Usage, path.display())
            }
            Ok(()) | Err(_) => Ok(()),
        }
    }

    /// Writes a file of the folder.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
        self.stream(name, |w| w.write_all(bytes.as_ref()))
    }

    /// Draws and writes charts.
    pub fn draw(&self, charts: &[Chart], drawing: &Drawing) -> Result<(), Failure> {
        for file in drawing.files(charts).or_exit(Exit::Internal, "charts")? {
            self.write(&file.name, file.bytes)?;
        }
        Ok(())
    }
}

impl FolderLayout {
    /// Whether a run may leave a file of this name.
    fn has(&self, name: &str) -> bool {
        let (stem, ending) = name.rsplit_once('.').unwrap_or((name, ""));
        let is_further = !self.further_charts.is_empty() && stem.starts_with(self.further_charts);
        match ending {
            "png" | "svg" | "pdf" => self.charts.contains(&stem) || is_further,
            _ => self.files.contains(&name),
        }
    }
}
