//! A store that sweeps share: what one has simulated, another need not.

use std::fs;
use std::path::Path;

use super::folder::Shard;
use super::records::Records;
use super::state::State;
use crate::cli::{Failure, out};
use powergs_core::sim::MODEL_VERSION;
use powergs_study::sweep::journal::Record;
use powergs_study::sweep::outcome::OUTCOME_VERSION;

/// A shared store, or none.
#[derive(Debug)]
pub struct Store(Option<Records>);

impl Store {
    /// Opens the store in `folder`. Records of other versions of the model lie in folders of their
    /// own: they are kept, and not used.
    ///
    /// # Errors
    /// Exit code 2: it cannot be read or written.
    pub fn open(folder: Option<&Path>, state: &State, shard: Shard) -> Result<Store, Failure> {
        let Some(folder) = folder else { return Ok(Store(None)) };
        let ours = format!("model-{MODEL_VERSION}.{OUTCOME_VERSION}");
        let path = folder.join(&ours);
        if !path.exists() {
            let others = fs::read_dir(folder).into_iter().flatten().flatten();
            let others = others.map(|e| e.file_name().to_string_lossy().into_owned());
            let mut others: Vec<String> = others.filter(|n| n.starts_with("model-")).collect();
            others.sort();
            if !others.is_empty() {
                out::complain(format_args!(
                    "note: {}: written by other versions ({}); they are kept, {ours} is used",
                    folder.display(),
                    others.join(", ")
                ));
            }
        }
        let name = format!("{:032x}-{}", state.hash(), shard.journal());
        Ok(Store(Some(Records::open(&path, Some(&name))?)))
    }

    /// What the store knows under a key.
    ///
    /// # Errors
    /// Exit code 3: a journal that cannot be read.
    pub fn get(&mut self, key: u128) -> Result<Option<Record>, Failure> {
        self.0.as_mut().map_or(Ok(None), |records| records.get(key))
    }

    /// Adds a record. Failures stay with the sweep that had them.
    ///
    /// # Errors
    /// Exit code 2: the disk is full or gone.
    pub fn append(&mut self, key: u128, record: &Record) -> Result<(), Failure> {
        match (&mut self.0, record) {
            (Some(records), Record::Ok(_)) => records.append(key, record),
            _ => Ok(()),
        }
    }
}
