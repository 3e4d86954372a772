//! A store in memory: for tests, and for runs that leave nothing behind.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Read, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::journal::{self, Index, JournalPlace};
use super::{Journals, Lock, NewFile, Sharing, Store, taken};
use crate::run::error::RunError;

/// Ending of journals.
const ENDING: &str = ".jsonl";

/// A store in memory; clones are the same store.
#[derive(Debug, Clone, Default)]
pub struct MemoryStore {
    shared: Arc<Mutex<MemoryShared>>,
}

#[derive(Debug, Default)]
struct MemoryShared {
    files: BTreeMap<String, Vec<u8>>,
    /// How many hold a lock; -1 is one who has it alone.
    locks: BTreeMap<String, i32>,
}

impl MemoryStore {
    /// An empty store.
    pub fn new() -> MemoryStore {
        MemoryStore::default()
    }

    fn shared(&self) -> MutexGuard<'_, MemoryShared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Gives a lock back.
struct HeldMemory {
    store: MemoryStore,
    name: String,
}

impl Drop for HeldMemory {
    fn drop(&mut self) {
        let mut shared = self.store.shared();
        let count = shared.locks.entry(self.name.clone()).or_default();
        *count = (*count - 1).max(0);
    }
}

/// Bytes that are not seen yet.
struct PendingMemory {
    store: MemoryStore,
    name: String,
    bytes: Vec<u8>,
}

impl Write for PendingMemory {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl NewFile for PendingMemory {
    fn commit(self: Box<Self>) -> io::Result<()> {
        let PendingMemory { store, name, bytes } = *self;
        store.shared().files.insert(name, bytes);
        Ok(())
    }
}

impl Store for MemoryStore {
    fn place(&self, name: &str) -> String {
        format!("memory:{name}")
    }

    fn list(&self, folder: &str) -> Result<Vec<String>, RunError> {
        let prefix = if folder.is_empty() { String::new() } else { format!("{folder}/") };
        let shared = self.shared();
        let names = shared.files.keys().filter_map(|name| name.strip_prefix(&prefix));
        let mut names: Vec<String> =
            names.map(|n| n.split('/').next().unwrap_or(n).to_owned()).collect();
        names.sort();
        names.dedup();
        Ok(names)
    }

    fn open(&self, name: &str) -> Result<Option<Box<dyn Read + Send>>, RunError> {
        let bytes = self.shared().files.get(name).cloned();
        Ok(bytes.map(|bytes| Box::new(Cursor::new(bytes)) as Box<dyn Read + Send>))
    }

    fn create(&self, name: &str) -> Result<Box<dyn NewFile>, RunError> {
        let (store, name) = (self.clone(), name.to_owned());
        Ok(Box::new(PendingMemory { store, name, bytes: Vec::new() }))
    }

    fn remove(&self, name: &str) -> Result<(), RunError> {
        let inside = format!("{name}/");
        self.shared().files.retain(|file, _| file != name && !file.starts_with(&inside));
        Ok(())
    }

    fn lock(&self, name: &str, sharing: Sharing) -> Result<Lock, RunError> {
        let mut shared = self.shared();
        let count = shared.locks.entry(name.to_owned()).or_default();
        match (sharing, *count) {
            (Sharing::Alone, 0) => *count = -1,
            (Sharing::Beside, 0..) => *count += 1,
            _ => return Err(taken(self.place(name))),
        }
        Ok(Lock::new(HeldMemory { store: self.clone(), name: name.to_owned() }))
    }

    fn journals(&self, folder: &str, own: Option<&str>) -> Result<Box<dyn Journals>, RunError> {
        let full = |name: &str| format!("{folder}/{name}");
        let own = own.map(|name| full(&format!("{name}{ENDING}")));
        let lock = own.as_deref().map(|name| self.lock(name, Sharing::Alone)).transpose()?;
        if let Some(own) = &own {
            let mut shared = self.shared();
            let bytes = shared.files.entry(own.clone()).or_default();
            // What a killed run left of its last line must not swallow the next one.
            if bytes.last().is_some_and(|&last| last != b'\n') {
                bytes.push(b'\n');
            }
        }
        let names = self.list(folder)?.into_iter().filter(|name| name.ends_with(ENDING));
        let names: Vec<String> = names.map(|name| full(&name)).collect();
        let mut index = Index::default();
        for (number, name) in (0..).zip(&names) {
            let shared = self.shared();
            let read = index.read(number, shared.files[name].as_slice(), 0);
            read.map_err(|e| RunError::input(self.place(name), e))?;
        }
        let own = own.and_then(|own| names.iter().position(|name| *name == own));
        Ok(Box::new(MemoryJournals { store: self.clone(), names, index, own, _lock: lock }))
    }
}

/// The journals of a folder.
#[derive(Debug)]
struct MemoryJournals {
    store: MemoryStore,
    names: Vec<String>,
    index: Index,
    /// Place of the journal that is appended to.
    own: Option<usize>,
    _lock: Option<Lock>,
}

impl Journals for MemoryJournals {
    fn has(&self, key: u128) -> bool {
        self.index.place(key).is_some()
    }

    fn get(&mut self, key: u128) -> Result<Option<String>, RunError> {
        let Some(place) = self.index.place(key) else { return Ok(None) };
        let shared = self.store.shared();
        let bytes = shared.files.get(&self.names[place.journal as usize]);
        let line = bytes
            .and_then(|bytes| bytes.get(place.offset as usize..)?.get(..place.length as usize));
        let found = line.and_then(journal::parse).filter(|(found, _)| *found == key);
        Ok(found.map(|(_, record)| record.to_owned()))
    }

    fn append(&mut self, key: u128, record: &str) -> Result<(), RunError> {
        if self.has(key) {
            return Ok(());
        }
        let own = self.own.expect("opened for writing");
        let mut shared = self.store.shared();
        let bytes = shared.files.entry(self.names[own].clone()).or_default();
        let offset = bytes.len() as u64;
        journal::append(bytes, key, record).expect("memory can be written");
        let length = (bytes.len() as u64 - offset) as u32;
        self.index.note(key, JournalPlace { journal: own as u32, offset, length });
        Ok(())
    }

    fn sync(&self) -> Result<(), RunError> {
        Ok(())
    }

    fn keys(&self) -> Vec<u128> {
        self.index.sorted_keys()
    }

    fn len(&self) -> usize {
        self.index.len()
    }

    fn damaged(&self) -> u64 {
        self.index.damaged
    }
}
