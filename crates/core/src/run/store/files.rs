//! A store in a folder.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, BufReader, ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use super::atomic::{is_temporary, nameless, persist, remove_leftovers, temporary};
use super::journal::{self, Index, JournalPlace};
use super::{Journals, Lock, NewFile, Sharing, Store, cannot_write, taken, unusable};
use crate::run::error::RunError;

/// Ending of journals.
const ENDING: &str = "jsonl";

/// A folder.
#[derive(Debug, Clone)]
pub struct FileStore {
    path: PathBuf,
}

impl FileStore {
    /// The store in a folder; nothing is opened or made yet.
    pub fn new(path: impl Into<PathBuf>) -> FileStore {
        FileStore { path: path.into() }
    }

    fn at(&self, name: &str) -> PathBuf {
        if name.is_empty() { self.path.clone() } else { self.path.join(name) }
    }
}

/// A temporary file and where it belongs.
struct PendingFile {
    file: NamedTempFile,
    path: PathBuf,
}

impl Write for PendingFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes).map_err(nameless)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush().map_err(nameless)
    }
}

impl NewFile for PendingFile {
    fn commit(self: Box<Self>) -> io::Result<()> {
        persist(self.file, &self.path)
    }
}

impl Store for FileStore {
    fn place(&self, name: &str) -> String {
        self.at(name).display().to_string()
    }

    fn list(&self, folder: &str) -> Result<Vec<String>, RunError> {
        let path = self.at(folder);
        let entries = match fs::read_dir(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries.map_err(|e| unusable(path.display(), &e))?,
        };
        let mut names = Vec::new();
        for entry in entries {
            let name = entry.map_err(|e| unusable(path.display(), &e))?.file_name();
            if !is_temporary(&name) {
                names.push(name.to_string_lossy().into_owned());
            }
        }
        names.sort();
        Ok(names)
    }

    fn open(&self, name: &str) -> Result<Option<Box<dyn Read + Send>>, RunError> {
        let path = self.at(name);
        match File::open(&path) {
            Ok(file) => Ok(Some(Box::new(file))),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
            Err(e) => Err(RunError::input(path.display(), e)),
        }
    }

    fn create(&self, name: &str) -> Result<Box<dyn NewFile>, RunError> {
        let path = self.at(name);
        let folder = path.parent().unwrap_or(&self.path);
        fs::create_dir_all(folder).map_err(|e| unusable(folder.display(), &e))?;
        let file = temporary(&path).map_err(|e| cannot_write(path.display().to_string(), &e))?;
        Ok(Box::new(PendingFile { file, path }))
    }

    fn remove(&self, name: &str) -> Result<(), RunError> {
        let path = self.at(name);
        let is_file = path.symlink_metadata().is_ok_and(|meta| !meta.is_dir());
        let removed = if is_file { fs::remove_file(&path) } else { fs::remove_dir_all(&path) };
        match removed {
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(()),
            removed => removed.map_err(|e| unusable(path.display(), &e)),
        }
    }

    fn lock(&self, name: &str, sharing: Sharing) -> Result<Lock, RunError> {
        let path = self.at(name);
        let folder = path.parent().unwrap_or(&self.path);
        fs::create_dir_all(folder).map_err(|e| unusable(folder.display(), &e))?;
        let mut options = OpenOptions::new();
        options.create(true).truncate(false).read(true).write(true);
        let file = options.open(&path).map_err(|e| unusable(path.display(), &e))?;
        let locked = match sharing {
            Sharing::Beside => file.try_lock_shared(),
            Sharing::Alone => file.try_lock(),
        };
        if let Err(TryLockError::WouldBlock) = locked {
            return Err(taken(folder.display()));
        }
        if sharing == Sharing::Alone {
            remove_leftovers(folder).map_err(|e| unusable(folder.display(), &e))?;
        }
        Ok(Lock::new(file))
    }

    fn journals(&self, folder: &str, own: Option<&str>) -> Result<Box<dyn Journals>, RunError> {
        Ok(Box::new(FileJournals::open(&self.at(folder), own)?))
    }
}

/// The journals of a folder.
#[derive(Debug)]
struct FileJournals {
    files: Vec<(PathBuf, File)>,
    index: Index,
    own: Option<Own>,
}

/// The journal that is appended to.
#[derive(Debug)]
struct Own {
    number: u32,
    end: u64,
}

impl FileJournals {
    fn open(folder: &Path, own: Option<&str>) -> Result<FileJournals, RunError> {
        let bad_folder = |e: io::Error| unusable(folder.display(), &e);
        fs::create_dir_all(folder).map_err(bad_folder)?;
        let mut journals = FileJournals { files: Vec::new(), index: Index::default(), own: None };
        let own = own.map(|name| folder.join(format!("{name}.{ENDING}")));
        if let Some(path) = &own {
            let mut options = OpenOptions::new();
            let file = options.create(true).read(true).append(true).open(path);
            lock(path, &file.map_err(|e| unusable(path.display(), &e))?)?;
        }
        let mut paths = Vec::new();
        for entry in fs::read_dir(folder).map_err(bad_folder)? {
            let path = entry.map_err(bad_folder)?.path();
            if path.extension().is_some_and(|e| e == ENDING) {
                paths.push(path);
            }
        }
        paths.sort();
        for path in paths {
            let writes = own.as_ref() == Some(&path);
            journals.add(path, writes)?;
        }
        Ok(journals)
    }

    fn add(&mut self, path: PathBuf, writes: bool) -> Result<(), RunError> {
        let bad = |e: io::Error| unusable(path.display(), &e);
        let mut options = OpenOptions::new();
        options.read(true).append(writes);
        let mut file = options.open(&path).map_err(bad)?;
        if writes {
            lock(&path, &file)?;
        }
        let number = self.files.len() as u32;
        let reader = BufReader::with_capacity(1 << 20, &file);
        let whole = self.index.read(number, reader, 0).map_err(bad)?;
        if writes {
            let mut end = file.seek(SeekFrom::End(0)).map_err(bad)?;
            if end > whole {
                // What a killed run left of its last line must not swallow the next one.
                file.write_all(b"\n").map_err(bad)?;
                end += 1;
            }
            self.own = Some(Own { number, end });
        }
        self.files.push((path, file));
        Ok(())
    }
}

impl Journals for FileJournals {
    fn has(&self, key: u128) -> bool {
        self.index.place(key).is_some()
    }

    fn get(&mut self, key: u128) -> Result<Option<String>, RunError> {
        let Some(place) = self.index.place(key) else { return Ok(None) };
        let (path, file) = &mut self.files[place.journal as usize];
        let mut line = vec![0u8; place.length as usize];
        let read =
            file.seek(SeekFrom::Start(place.offset)).and_then(|_| file.read_exact(&mut line));
        read.map_err(|e| RunError::input(path.display(), e))?;
        let found = journal::parse(&line).filter(|(found, _)| *found == key);
        Ok(found.map(|(_, record)| record.to_owned()))
    }

    fn append(&mut self, key: u128, record: &str) -> Result<(), RunError> {
        if self.has(key) {
            return Ok(());
        }
        let own = self.own.as_mut().expect("opened for writing");
        let (path, file) = &mut self.files[own.number as usize];
        let mut line = Vec::new();
        let written = journal::append(&mut line, key, record).and_then(|()| file.write_all(&line));
        written.map_err(|e| {
            let what = "what was done before is safe; make room and run again with --resume";
            let message = format!("cannot be written: {e}; {what}");
            RunError::Output { place: path.display().to_string(), message }
        })?;
        let place =
            JournalPlace { journal: own.number, offset: own.end, length: line.len() as u32 };
        own.end += u64::from(place.length);
        self.index.note(key, place);
        Ok(())
    }

    fn sync(&self) -> Result<(), RunError> {
        let Some(own) = &self.own else { return Ok(()) };
        let (path, file) = &self.files[own.number as usize];
        file.sync_data().map_err(|e| unusable(path.display(), &e))
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

/// Takes the lock of a file until it is closed.
fn lock(path: &Path, file: &File) -> Result<(), RunError> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(taken(path.display())),
        // Some network file systems have no locks: then whoever starts two is on his own.
        Err(TryLockError::Error(_)) => Ok(()),
    }
}
