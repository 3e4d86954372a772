//! The records of a sweep: what became of each design on each trace under each energy table.

use std::fmt;

use powergs_core::run::store::Journals;
use powergs_core::run::{RunError, Store};

use crate::sweep::record::Record;

/// The journals of a folder of a store: all of them are read, one may be appended to.
pub struct Records {
    journals: Box<dyn Journals>,
}

impl fmt::Debug for Records {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} records", self.journals.len())
    }
}

impl Records {
    /// Opens all journals in `folder`; with `own`, that one is appended to.
    ///
    /// # Errors
    /// [`RunError::Output`]: they cannot be read or written, or another process writes.
    pub fn open(store: &dyn Store, folder: &str, own: Option<&str>) -> Result<Records, RunError> {
        Ok(Records { journals: store.journals(folder, own)? })
    }

    /// Whether there is a record of this key.
    pub fn has(&self, key: u128) -> bool {
        self.journals.has(key)
    }

    /// The record of a key; `None` if there is none, or if it was damaged.
    ///
    /// # Errors
    /// [`RunError::Input`]: a journal cannot be read.
    pub fn get(&mut self, key: u128) -> Result<Option<Record>, RunError> {
        Ok(self.journals.get(key)?.and_then(|text| Record::parse(&text)))
    }

    /// Appends a record, if there is none of its key.
    ///
    /// # Errors
    /// [`RunError::Output`]: the disk is full or gone; everything before is safe.
    pub fn append(&mut self, key: u128, record: &Record) -> Result<(), RunError> {
        if self.has(key) {
            return Ok(());
        }
        self.journals.append(key, &record.text())
    }

    /// Sees to it that what was appended survives a power cut.
    ///
    /// # Errors
    /// [`RunError::Output`]: the disk is full or gone.
    pub fn sync(&self) -> Result<(), RunError> {
        self.journals.sync()
    }

    /// Appends everything that other records have and these do not.
    ///
    /// # Errors
    /// As [`Records::get`] and [`Records::append`].
    pub fn take_over(&mut self, other: &mut Records) -> Result<(), RunError> {
        for key in other.journals.keys() {
            if let Some(record) = other.get(key)? {
                self.append(key, &record)?;
            }
        }
        Ok(())
    }

    /// How many records there are.
    pub fn len(&self) -> usize {
        self.journals.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Records that were found cut off or damaged.
    pub fn damaged(&self) -> u64 {
        self.journals.damaged()
    }
}
