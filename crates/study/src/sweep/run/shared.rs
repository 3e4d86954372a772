//! Results that sweeps share, so that none simulates what another has.

use powergs_core::run::{RunError, Store};
use powergs_core::sim::MODEL_VERSION;

use super::folder::Shard;
use super::records::Records;
use super::state::State;
use super::watch::SweepWatch;
use crate::sweep::outcome::OUTCOME_VERSION;
use crate::sweep::record::Record;

/// Shared results, or none.
#[derive(Debug, Default)]
pub struct SharedResults(Option<Records>);

impl SharedResults {
    /// Opens the results in `store`. Records of other versions of the model lie in folders of their
    /// own: they are kept, and not used.
    ///
    /// # Errors
    /// [`RunError::Output`]: the store cannot be read or written.
    pub fn open(
        store: &dyn Store,
        state: &State,
        shard: Shard,
        watch: &dyn SweepWatch,
    ) -> Result<SharedResults, RunError> {
        let ours = format!("model-{MODEL_VERSION}.{OUTCOME_VERSION}");
        let mut others = store.list("").unwrap_or_default();
        others.retain(|name| name.starts_with("model-"));
        if !others.contains(&ours) && !others.is_empty() {
            let others = others.join(", ");
            let what =
                format!("written by other versions ({others}); they are kept, {ours} is used");
            watch.note(&format!("{}: {what}", store.place("")));
        }
        let name = format!("{:032x}-{}", state.hash(), shard.journal());
        Ok(SharedResults(Some(Records::open(store, &ours, Some(&name))?)))
    }

    /// What is known under a key.
    ///
    /// # Errors
    /// [`RunError::Input`]: a journal that cannot be read.
    pub fn get(&mut self, key: u128) -> Result<Option<Record>, RunError> {
        self.0.as_mut().map_or(Ok(None), |records| records.get(key))
    }

    /// Adds a record. Failures stay with the sweep that had them.
    ///
    /// # Errors
    /// [`RunError::Output`]: the disk is full or gone.
    pub fn append(&mut self, key: u128, record: &Record) -> Result<(), RunError> {
        match (&mut self.0, record) {
            (Some(records), Record::Ok(_)) => records.append(key, record),
            _ => Ok(()),
        }
    }
}
