//! The journals of a sweep on disk: all of them are read, one is appended to.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crate::cli::{Exit, Failure, OrExit};
use powergs_study::sweep::journal::{self, Index, Place, Record};

/// Ending of journals.
const ENDING: &str = "jsonl";

/// The journals of a folder.
#[derive(Debug)]
pub struct Records {
    files: Vec<(PathBuf, File)>,
    /// Where every record lies.
    pub index: Index,
    own: Option<Own>,
}

/// The journal that is appended to.
#[derive(Debug)]
struct Own {
    number: u32,
    end: u64,
}

impl Records {
    /// Opens and reads every journal in `folder`, which is made if it is not there. With `own`,
    /// that journal is appended to, and nobody else may do so at the same time.
    ///
    /// # Errors
    /// Exit code 2: the folder or a file cannot be read or written, or another process writes.
    pub fn open(folder: &Path, own: Option<&str>) -> Result<Records, Failure> {
        fs::create_dir_all(folder).or_exit(Exit::Usage, folder.display())?;
        let mut records = Records { files: Vec::new(), index: Index::default(), own: None };
        let own = own.map(|name| folder.join(format!("{name}.{ENDING}")));
        if let Some(path) = &own {
            let mut options = OpenOptions::new();
            let file = options.create(true).read(true).append(true).open(path);
            lock(path, &file.or_exit(Exit::Usage, path.display())?)?;
        }
        let mut paths = Vec::new();
        for entry in fs::read_dir(folder).or_exit(Exit::Usage, folder.display())? {
            let path = entry.or_exit(Exit::Usage, folder.display())?.path();
            if path.extension().is_some_and(|e| e == ENDING) {
                paths.push(path);
            }
        }
        paths.sort();
        for path in paths {
            let writes = own.as_ref() == Some(&path);
            records.add(path, writes)?;
        }
        Ok(records)
    }

    fn add(&mut self, path: PathBuf, writes: bool) -> Result<(), Failure> {
        let mut options = OpenOptions::new();
        options.read(true).append(writes);
        let mut file = options.open(&path).or_exit(Exit::Usage, path.display())?;
        if writes {
            lock(&path, &file)?;
        }
        let number = self.files.len() as u32;
        let reader = BufReader::with_capacity(1 << 20, &file);
        let whole = self.index.read(number, reader, 0).or_exit(Exit::Usage, path.display())?;
        if writes {
            let mut end = file.seek(SeekFrom::End(0)).or_exit(Exit::Usage, path.display())?;
            if end > whole {
                // What a killed run left of its last line must not swallow the next one.
                file.write_all(b"\n").or_exit(Exit::Usage, path.display())?;
                end += 1;
            }
            self.own = Some(Own { number, end });
        }
        self.files.push((path, file));
        Ok(())
    }

    /// Appends a record, if there is none of its key.
    ///
    /// # Errors
    /// Exit code 2: the disk is full or gone; everything before is safe.
    pub fn append(&mut self, key: u128, record: &Record) -> Result<(), Failure> {
        if self.index.place(key).is_some() {
            return Ok(());
        }
        let own = self.own.as_mut().expect("opened for writing");
        let (path, file) = &mut self.files[own.number as usize];
        let mut line = Vec::new();
        journal::append(&mut line, key, record).or_exit(Exit::Internal, path.display())?;
        file.write_all(&line).map_err(|e| {
            let what = "what was done before is safe; make room and run again with --resume";
            Failure::new(Exit::Usage, format!("{}: cannot be written: {e}; {what}", path.display()))
        })?;
        let place = Place { journal: own.number, offset: own.end, length: line.len() as u32 };
        own.end += u64::from(place.length);
        self.index.note(key, place);
        Ok(())
    }

    /// The record of a key; `None` if there is none, or if it was damaged since it was indexed.
    ///
    /// # Errors
    /// Exit code 3: the journal cannot be read.
    pub fn get(&mut self, key: u128) -> Result<Option<Record>, Failure> {
        let Some(place) = self.index.place(key) else { return Ok(None) };
        let (path, file) = &mut self.files[place.journal as usize];
        let mut line = vec![0u8; place.length as usize];
        let read =
            file.seek(SeekFrom::Start(place.offset)).and_then(|_| file.read_exact(&mut line));
        read.or_exit(Exit::BadInput, path.display())?;
        Ok(journal::parse(&line).filter(|(found, _)| *found == key).map(|(_, record)| record))
    }

    /// Sees to it that what was appended survives a power cut.
    ///
    /// # Errors
    /// Exit code 2: the disk is full or gone.
    pub fn sync(&self) -> Result<(), Failure> {
        let Some(own) = &self.own else { return Ok(()) };
        let (path, file) = &self.files[own.number as usize];
        file.sync_data().or_exit(Exit::Usage, path.display())
    }
}

/// Takes the lock of a file until it is closed.
fn lock(path: &Path, file: &File) -> Result<(), Failure> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(taken(path)),
        // Some network file systems have no locks: then whoever starts two is on his own.
        Err(TryLockError::Error(_)) => Ok(()),
    }
}

/// Somebody else is at work.
pub fn taken(path: &Path) -> Failure {
    let what = "another process is writing it; wait for it, or use another folder or --shard";
    Failure::new(Exit::Usage, format!("{}: {what}", path.display()))
}
