//! The folder of a sweep: who may work in it, and what it was begun with.
//!
//! `state.toml` says what it was begun with, `records/` holds the journals, `lock` the lock. The
//! results are written at the end, each file whole or not at all.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

use super::records::{Records, taken};
use super::state::{self, State};
use crate::cli::{Exit, Failure, OrExit, aside};

/// Which part of a sweep a process does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From 1.
    pub number: u32,
    /// How many there are.
    pub of: u32,
}

impl Shard {
    /// The whole sweep.
    pub const WHOLE: Shard = Shard { number: 1, of: 1 };

    /// The journal of this part.
    pub fn journal(self) -> String {
        format!("shard-{:05}-of-{:05}", self.number, self.of)
    }

    /// Whether the design at `position` of the order of work belongs to this part: neighbours in
    /// that order share binned frames, so a part is a run of neighbours.
    pub fn has(self, position: u64, count: u64) -> bool {
        let (number, of) = (u128::from(self.number - 1), u128::from(self.of));
        let owner = u128::from(position) * of / u128::from(count.max(1));
        owner == number
    }
}

/// What to do with a folder that holds a sweep already.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// Say so.
    Refuse,
    /// Finish it.
    Resume,
    /// Throw its results away.
    Replace,
}

/// A folder in which this process may work.
#[derive(Debug)]
pub struct SweepFolder {
    /// Where it is.
    pub path: PathBuf,
    /// Its journals.
    pub records: Records,
    _lock: File,
}

/// The journals of a folder.
pub const RECORDS: &str = "records";

impl SweepFolder {
    /// Makes a folder, or opens one for what `existing` says. `None` is the whole sweep, alone in
    /// its folder; parts work beside each other and always continue.
    ///
    /// # Errors
    /// Exit code 2: a folder of something else, of a sweep that was begun with other files, or one
    /// that another process works in.
    pub fn open(
        path: &Path,
        now: &State,
        existing: Existing,
        part: Option<Shard>,
    ) -> Result<SweepFolder, Failure> {
        refuse_foreign(path)?;
        fs::create_dir_all(path).or_exit(Exit::Usage, path.display())?;
        let lock = lock(path, part.is_some())?;
        if part.is_none() {
            aside::sweep_away(path).or_exit(Exit::Usage, path.display())?;
        }
        // The tasks of an array job find the folder made by the first of them.
        begin(path, now, if part.is_some() { Existing::Resume } else { existing })?;
        let journal = part.unwrap_or(Shard::WHOLE).journal();
        let records = Records::open(&path.join(RECORDS), Some(&journal))?;
        Ok(SweepFolder { path: path.to_owned(), records, _lock: lock })
    }
}

/// Notes in a folder what is about to begin in it, or sees to it that it may be continued.
///
/// # Errors
/// Exit code 2: a folder of something else, or of a sweep that was begun with other files.
pub fn begin(path: &Path, now: &State, existing: Existing) -> Result<(), Failure> {
    refuse_foreign(path)?;
    fs::create_dir_all(path).or_exit(Exit::Usage, path.display())?;
    match (State::read(path)?, existing) {
        (None, _) => now.write(path),
        (Some(_), Existing::Replace) => {
            fs::remove_dir_all(path.join(RECORDS))
                .or_else(absent_is_fine)
                .or_exit(Exit::Usage, path.display())?;
            now.write(path)
        }
        (Some(then), Existing::Resume) => same(path, &then, now),
        (Some(_), Existing::Refuse) => {
            let what = "holds a sweep; finish it with --resume, replace it with --force, or use \
                        another folder";
            Err(Failure::new(Exit::Usage, format!("{}: {what}", path.display())))
        }
    }
}

/// Refuses a state that differs.
///
/// # Errors
/// Exit code 2, with the differences.
pub fn same(path: &Path, then: &State, now: &State) -> Result<(), Failure> {
    let differences = then.differences(now);
    if differences.is_empty() {
        return Ok(());
    }
    let list = differences.join("\n  ");
    let what = "was begun with something else; nothing was changed. Use another folder (--store \
                keeps what both share), or --force to begin anew";
    Err(Failure::new(Exit::Usage, format!("{}: {what}:\n  {list}", path.display())))
}

fn absent_is_fine(e: std::io::Error) -> std::io::Result<()> {
    if e.kind() == std::io::ErrorKind::NotFound { Ok(()) } else { Err(e) }
}

/// Refuses a folder with files but without a state: it is not ours.
fn refuse_foreign(path: &Path) -> Result<(), Failure> {
    if !path.exists() || path.join(state::FILE).exists() {
        return Ok(());
    }
    let mut entries = fs::read_dir(path).or_exit(Exit::Usage, path.display())?;
    // A lock is there when two tasks begin at the same time, `slurm` before the first of them.
    let names = ["lock", "slurm", RECORDS, state::FILE];
    let ours = |name: &std::ffi::OsStr| names.iter().any(|ours| name == *ours);
    let foreign = entries
        .find_map(|e| Some(e.ok()?.file_name()).filter(|n| !ours(n) && !aside::is_temporary(n)));
    let Some(name) = foreign else { return Ok(()) };
    let what = format!("holds `{}`, which is not of a sweep; use another folder", name.display());
    Err(Failure::new(Exit::Usage, format!("{}: {what}", path.display())))
}

/// Alone, or beside other shards.
pub fn lock(path: &Path, shared: bool) -> Result<File, Failure> {
    let place = path.join("lock");
    let mut options = OpenOptions::new();
    options.create(true).truncate(false).read(true).write(true);
    let file = options.open(&place).or_exit(Exit::Usage, place.display())?;
    let locked = if shared { file.try_lock_shared() } else { file.try_lock() };
    match locked {
        Err(TryLockError::WouldBlock) => Err(taken(path)),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}
