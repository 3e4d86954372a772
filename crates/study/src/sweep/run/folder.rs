//! The folder of a sweep: who may work in it, and what it was begun with.
//!
//! `state.toml` says what it was begun with, `records/` holds the journals, `lock` the lock. The
//! results are written at the end, each file whole or not at all.

use powergs_core::run::store::{Lock, Sharing};
use powergs_core::run::{RunError, Store};

use super::records::Records;
use super::state::{self, State};

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
pub struct SweepFolder<'a> {
    /// Where it is.
    pub store: &'a dyn Store,
    /// Its journals.
    pub records: Records,
    _lock: Lock,
}

/// The journals of a folder.
pub const RECORDS: &str = "records";

/// The lock of a folder.
const LOCK: &str = "lock";

impl<'a> SweepFolder<'a> {
    /// Makes a folder, or opens one for what `existing` says. `None` is the whole sweep, alone in
    /// its folder; parts work beside each other and always continue.
    ///
    /// # Errors
    /// [`RunError::Output`]: a folder of something else, of a sweep that was begun with other
    /// files, or one that another process works in.
    pub fn open(
        store: &'a dyn Store,
        now: &State,
        existing: Existing,
        part: Option<Shard>,
    ) -> Result<SweepFolder<'a>, RunError> {
        // Before the lock, which would be a file in the folder of something else.
        refuse_foreign(store)?;
        let sharing = if part.is_some() { Sharing::Beside } else { Sharing::Alone };
        let lock = store.lock(LOCK, sharing)?;
        // The tasks of an array job find the folder made by the first of them.
        begin(store, now, if part.is_some() { Existing::Resume } else { existing })?;
        let journal = part.unwrap_or(Shard::WHOLE).journal();
        let records = Records::open(store, RECORDS, Some(&journal))?;
        Ok(SweepFolder { store, records, _lock: lock })
    }

    /// The records of a folder, read only.
    ///
    /// # Errors
    /// [`RunError::Output`]: they cannot be read.
    pub fn records_of(store: &dyn Store) -> Result<Records, RunError> {
        Records::open(store, RECORDS, None)
    }
}

/// Notes in a folder what is about to begin in it, or sees to it that it may be continued.
///
/// # Errors
/// [`RunError::Output`]: a folder of something else, or of a sweep that was begun with other files.
pub fn begin(store: &dyn Store, now: &State, existing: Existing) -> Result<(), RunError> {
    refuse_foreign(store)?;
    match (State::read(store)?, existing) {
        (None, _) => now.write(store),
        (Some(_), Existing::Replace) => {
            // Records first: with the new state in place, the old ones would pass for its results.
            store.remove(RECORDS)?;
            now.write(store)
        }
        (Some(then), Existing::Resume) => same(store, &then, now),
        (Some(_), Existing::Refuse) => Err(refused(
            store,
            "holds a sweep; finish it with --resume, replace it with --force, or use another \
             folder",
        )),
    }
}

/// Refuses a state that differs.
///
/// # Errors
/// [`RunError::Output`], with the differences.
pub fn same(store: &dyn Store, then: &State, now: &State) -> Result<(), RunError> {
    let differences = then.differences(now);
    if differences.is_empty() {
        return Ok(());
    }
    let list = differences.join("\n  ");
    let what = "was begun with something else; nothing was changed. Use another folder (--store \
                keeps what both share), or --force to begin anew";
    Err(refused(store, &format!("{what}:\n  {list}")))
}

/// Refuses a folder with files but without a state: it is not ours.
fn refuse_foreign(store: &dyn Store) -> Result<(), RunError> {
    let names = store.list("")?;
    if names.iter().any(|name| name == state::FILE) {
        return Ok(());
    }
    // A lock is there when two tasks begin at the same time, `slurm` before the first of them.
    let ours = [LOCK, "slurm", RECORDS];
    let foreign = names.iter().find(|name| !ours.contains(&name.as_str()));
    let Some(name) = foreign else { return Ok(()) };
    Err(refused(store, &format!("holds `{name}`, which is not of a sweep; use another folder")))
}

fn refused(store: &dyn Store, what: &str) -> RunError {
    RunError::Output { place: store.place(""), message: what.to_owned() }
}
