//! The storage of a long run: journals that are appended to, and files that are written atomically.
//!
//! [`FileStore`] is a folder, [`MemoryStore`] is for tests and for runs that leave nothing behind.

pub mod atomic;
pub mod files;
pub mod journal;
pub mod memory;

use std::fmt;
use std::io::{self, Read, Write};

pub use files::FileStore;
pub use memory::MemoryStore;

use super::error::{RunError, causes};

/// Who may hold a lock at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sharing {
    /// One process only.
    Alone,
    /// Any number of processes that share it as well.
    Beside,
}

/// A lock; given back when it is dropped.
pub struct Lock {
    #[expect(dead_code, reason = "held until it is dropped")]
    held: Box<dyn Send + Sync>,
}

impl Lock {
    fn new(held: impl Send + Sync + 'static) -> Lock {
        Lock { held: Box::new(held) }
    }
}

impl fmt::Debug for Lock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Lock")
    }
}

/// A file that is being written: invisible to readers until it is committed.
pub trait NewFile: Write + Send {
    /// Puts the file in its place, in one step.
    ///
    /// # Errors
    /// Errors of the file system; the previous file is kept.
    fn commit(self: Box<Self>) -> io::Result<()>;
}

/// A place for journals and whole files. Names are relative, with `/` between folders.
pub trait Store: Send + Sync {
    /// The name of a file in messages; for an empty name, that of the store.
    fn place(&self, name: &str) -> String;

    /// The names in a folder, sorted; none where there is no such folder.
    ///
    /// # Errors
    /// [`RunError::Output`]: it cannot be read.
    fn list(&self, folder: &str) -> Result<Vec<String>, RunError>;

    /// A file, from its beginning; `None` if there is none.
    ///
    /// # Errors
    /// [`RunError::Input`]: it cannot be read.
    fn open(&self, name: &str) -> Result<Option<Box<dyn Read + Send>>, RunError>;

    /// Begins a file that replaces the previous one when it is committed.
    ///
    /// # Errors
    /// [`RunError::Output`]: the store cannot be written.
    fn create(&self, name: &str) -> Result<Box<dyn NewFile>, RunError>;

    /// Removes a file, or a folder with everything in it, if it is there.
    ///
    /// # Errors
    /// [`RunError::Output`]: the store cannot be written.
    fn remove(&self, name: &str) -> Result<(), RunError>;

    /// Takes the lock of this name. With an exclusive lock of the whole store, files that a killed
    /// process left half written are removed.
    ///
    /// # Errors
    /// [`RunError::Output`]: another process holds the lock.
    fn lock(&self, name: &str, sharing: Sharing) -> Result<Lock, RunError>;

    /// Opens and reads all journals in a folder, which is made if it is not there. The journal
    /// `own` is opened for appending, by one process at a time.
    ///
    /// # Errors
    /// [`RunError::Output`]: it cannot be read or written, or another process writes.
    fn journals(&self, folder: &str, own: Option<&str>) -> Result<Box<dyn Journals>, RunError>;

    /// The bytes of a file; `None` if there is none.
    ///
    /// # Errors
    /// As [`Store::open`].
    fn read(&self, name: &str) -> Result<Option<Vec<u8>>, RunError> {
        let Some(mut file) = self.open(name)? else { return Ok(None) };
        let mut bytes = Vec::new();
        let read = file.read_to_end(&mut bytes);
        read.map_err(|e| RunError::input(self.place(name), e))?;
        Ok(Some(bytes))
    }

    /// A text file; `None` if there is none.
    ///
    /// # Errors
    /// As [`Store::open`], and for a file that is no text.
    fn read_text(&self, name: &str) -> Result<Option<String>, RunError> {
        let text = self.read(name)?.map(String::from_utf8).transpose();
        text.map_err(|e| RunError::input(self.place(name), e))
    }

    /// Writes a file, whole or not at all.
    ///
    /// # Errors
    /// As [`Store::create`].
    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), RunError> {
        let mut file = self.create(name)?;
        let written = file.write_all(bytes).and_then(|()| file.commit());
        written.map_err(|e| cannot_write(self.place(name), &e))
    }
}

/// Records under keys. A key has one record: the first that was written.
pub trait Journals: Send {
    /// Whether there is a record of this key.
    fn has(&self, key: u128) -> bool;

    /// The record of a key; `None` if there is none, or if it was damaged since it was opened.
    ///
    /// # Errors
    /// [`RunError::Input`]: the journal cannot be read.
    fn get(&mut self, key: u128) -> Result<Option<String>, RunError>;

    /// Appends a record of one line to the own journal, if there is none of its key.
    ///
    /// # Errors
    /// [`RunError::Output`]: the disk is full or gone; everything before is safe.
    fn append(&mut self, key: u128, record: &str) -> Result<(), RunError>;

    /// Makes sure that all appended records survive a power cut.
    ///
    /// # Errors
    /// [`RunError::Output`]: the disk is full or gone.
    fn sync(&self) -> Result<(), RunError>;

    /// All keys, ascending.
    fn keys(&self) -> Vec<u128>;

    /// How many keys there are.
    fn len(&self) -> usize;

    /// Whether there is none.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Records that were found cut off or damaged when the journals were opened.
    fn damaged(&self) -> u64;
}

/// A file or folder that cannot be written.
fn cannot_write(place: String, error: &io::Error) -> RunError {
    RunError::Output { place, message: format!("cannot be written: {}", causes(error)) }
}

/// A file or folder that cannot be used.
fn unusable(place: impl fmt::Display, error: &io::Error) -> RunError {
    RunError::Output { place: place.to_string(), message: causes(error) }
}

/// The lock is held by another process.
fn taken(place: impl fmt::Display) -> RunError {
    let message = "another process is writing it; wait for it, or use another folder or --shard";
    RunError::Output { place: place.to_string(), message: message.into() }
}
