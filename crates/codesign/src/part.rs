//! A folder of a store as a store of its own.

use std::io::Read;

use powergs_core::run::store::{Journals, Lock, NewFile, Sharing};
use powergs_core::run::{RunError, Store};

/// A folder of a store.
#[derive(Clone)]
pub struct CodesignPart<'a> {
    whole: &'a dyn Store,
    folder: String,
}

impl<'a> CodesignPart<'a> {
    /// The folder of this name.
    pub fn new(whole: &'a dyn Store, folder: impl Into<String>) -> CodesignPart<'a> {
        CodesignPart { whole, folder: folder.into() }
    }

    fn name(&self, name: &str) -> String {
        if name.is_empty() { self.folder.clone() } else { format!("{}/{name}", self.folder) }
    }
}

impl Store for CodesignPart<'_> {
    fn place(&self, name: &str) -> String {
        self.whole.place(&self.name(name))
    }

    fn list(&self, folder: &str) -> Result<Vec<String>, RunError> {
        self.whole.list(&self.name(folder))
    }

    fn open(&self, name: &str) -> Result<Option<Box<dyn Read + Send>>, RunError> {
        self.whole.open(&self.name(name))
    }

    fn create(&self, name: &str) -> Result<Box<dyn NewFile>, RunError> {
        self.whole.create(&self.name(name))
    }

    fn remove(&self, folder: &str) -> Result<(), RunError> {
        self.whole.remove(&self.name(folder))
    }

    fn lock(&self, name: &str, sharing: Sharing) -> Result<Lock, RunError> {
        self.whole.lock(&self.name(name), sharing)
    }

    fn journals(&self, folder: &str, own: Option<&str>) -> Result<Box<dyn Journals>, RunError> {
        self.whole.journals(&self.name(folder), own)
    }
}
