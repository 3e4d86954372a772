//! The end of a sweep: a note that its folder is whole.

use std::io::Read;

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::Xxh3;

use super::opened::OpenedSweep;
use super::plan::Plan;
use super::results::{CSV, PARQUET, Tally};
use super::state::State;
use crate::sweep::space::FreeAxis;
use powergs_core::run::{RunError, Store};

/// Its name in the folder.
const FILE: &str = "finished.toml";

/// What the results of a finished sweep were made from, as every report has it: a [`State`].
pub(crate) const RUN_FILE: &str = "run.toml";
/// The sweep file of a finished sweep.
pub(crate) const SWEEP_FILE: &str = "sweep.toml";

/// A sweep that is whole.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct Finished {
    /// Hash of the state that it was made from.
    state: String,
    /// Hash of its table.
    results: String,
    /// Designs with all results.
    pub ok: u64,
    /// Configurations that cannot exist.
    pub invalid: u64,
    /// Designs whose simulation went wrong.
    pub failed: u64,
    /// Points that constraints exclude.
    pub excluded: u64,
    /// Designs on which the simulator contradicted itself; they are among the failed.
    #[serde(default)]
    pub defects: u64,
    /// Whether its results answer the question of the sweep file.
    pub answered: bool,
    /// How many designs of the front were to be confirmed with `banked`.
    #[serde(default)]
    pub confirm: u16,
    /// What is right in the base machine and in the energy tables, and doubtful.
    #[serde(default)]
    pub doubts: Vec<String>,
    /// Axes that cost nothing.
    pub free: Vec<FreeAxis>,
}

impl Finished {
    /// What a folder says of itself, whatever it was made from; `None` if it says nothing.
    pub fn noted(store: &dyn Store) -> Option<Finished> {
        toml::from_str(&store.read_text(FILE).ok()??).ok()
    }

    /// What a folder says of this state; `None` if it is not whole, or its table was changed.
    pub fn read(store: &dyn Store, state: &State) -> Option<Finished> {
        let text = store.read_text(FILE).ok()??;
        let finished: Finished = toml::from_str(&text).ok()?;
        let same = finished.state == format!("{:032x}", state.hash())
            && finished.results == format!("{:032x}", hash(store, CSV)?)
            && store.list("").ok()?.iter().any(|name| name == PARQUET);
        same.then_some(finished)
    }

    /// A sweep whose table has this hash, whose question was `answered`, and of whose front
    /// `confirm` designs were to be confirmed.
    pub fn new(
        sweep: &OpenedSweep<'_>,
        plan: &Plan,
        tally: Tally,
        table: u128,
        answered: bool,
        confirm: u16,
    ) -> Finished {
        Finished {
            state: format!("{:032x}", sweep.state.hash()),
            results: format!("{table:032x}"),
            ok: tally.ok,
            invalid: tally.invalid,
            failed: tally.failed,
            excluded: plan.excluded.values().sum(),
            defects: tally.defects,
            answered,
            confirm,
            doubts: sweep.designs.doubts(),
            free: sweep.designs.space.free_axes(),
        }
    }

    /// Notes it in the folder. This comes last: a run that is killed before is continued, and makes
    /// every other file anew.
    ///
    /// # Errors
    /// [`RunError::Output`]: the store cannot be written.
    pub fn write(&self, store: &dyn Store) -> Result<(), RunError> {
        let text = toml::to_string(self);
        let text = text.map_err(|e| RunError::Internal(format!("{FILE}: {e}")))?;
        store.write(FILE, text.as_bytes())
    }
}

/// Notes in the folder what the results were made from, as every report has it.
///
/// # Errors
/// [`RunError::Output`]: the store cannot be written.
pub fn write_sources(sweep: &OpenedSweep<'_>, store: &dyn Store) -> Result<(), RunError> {
    store.write(RUN_FILE, sweep.state.toml().as_bytes())?;
    sweep.hand_out.iter().try_for_each(|hand_out| hand_out.keep(store))?;
    store.write(SWEEP_FILE, sweep.file.text().as_bytes())
}

fn hash(store: &dyn Store, name: &str) -> Option<u128> {
    let mut hash = Xxh3::new();
    let mut file = store.open(name).ok()??;
    let mut buffer = vec![0; 1 << 18];
    loop {
        match file.read(&mut buffer).ok()? {
            0 => return Some(hash.digest128()),
            n => hash.update(&buffer[..n]),
        }
    }
}
