//! Reference images in a temporary file: what one iteration needs is read back, so that a hundred
//! photos take the memory of one.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::Mutex;

use xxhash_rust::xxh3::Xxh3;

use super::{Exit, Failure, OrExit};
use powergs_base::picture::Picture;
use powergs_core::run::RunError;
use powergs_optimize::references::{Reference, ReferenceSink, References};

/// References in a temporary file, which is deleted with this value.
pub struct FileReferences {
    file: Mutex<File>,
    /// Where each one begins, and its width and height.
    places: Vec<(u64, (u32, u32))>,
    end: u64,
    hash: Xxh3,
    /// The first reading that failed.
    failure: Mutex<Option<io::Error>>,
    /// Where the file could not be deleted while it is open.
    path: Option<PathBuf>,
}

impl FileReferences {
    /// No references yet.
    ///
    /// # Errors
    /// Exit code 2: no temporary file can be made.
    pub fn new() -> Result<FileReferences, Failure> {
        let name = format!("powergs-sim-references-{}", std::process::id());
        let mut path = std::env::temp_dir().join(&name);
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true);
        // Somebody else's file of that name is left alone, that of another thread too.
        let mut attempt = 0;
        let file = loop {
            path.set_file_name(format!("{name}-{attempt}"));
            match options.open(&path) {
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 1000 => {
                    attempt += 1;
                }
                opened => break opened.or_exit(Exit::Usage, path.display())?,
            }
        };
        let path = fs::remove_file(&path).err().map(|_| path);
        let (file, failure) = (Mutex::new(file), Mutex::new(None));
        Ok(FileReferences { file, places: Vec::new(), end: 0, hash: Xxh3::new(), failure, path })
    }

    fn read(&self, view: usize) -> io::Result<Reference> {
        let (start, (width, height)) = self.places[view];
        let mut reference = Reference::black(width, height);
        let mut file = self.file.lock().unwrap_or_else(|broken| broken.into_inner());
        file.seek(SeekFrom::Start(start))?;
        file.read_exact(reference.as_bytes_mut())?;
        Ok(reference)
    }
}

impl ReferenceSink for FileReferences {
    fn push(&mut self, reference: Reference) -> Result<(), RunError> {
        let bytes = reference.as_bytes();
        let file = self.file.get_mut().unwrap_or_else(|broken| broken.into_inner());
        file.write_all(bytes).map_err(|e| RunError::Output {
            place: "the temporary file of reference images (TMPDIR says where it is)".into(),
            message: e.to_string(),
        })?;
        self.places.push((self.end, reference.size()));
        self.end += bytes.len() as u64;
        self.hash.update(bytes);
        Ok(())
    }
}

impl References for FileReferences {
    fn write_to(&self, view: usize, picture: &mut Picture) {
        let reference = self.read(view).unwrap_or_else(|error| {
            let mut failure = self.failure.lock().unwrap_or_else(|broken| broken.into_inner());
            failure.get_or_insert(error);
            let (width, height) = self.places[view].1;
            Reference::black(width, height)
        });
        reference.write_to(picture);
    }

    fn digest(&self) -> u128 {
        self.hash.digest128()
    }

    fn check(&self) -> Result<(), RunError> {
        let failure = self.failure.lock().unwrap_or_else(|broken| broken.into_inner());
        match &*failure {
            None => Ok(()),
            Some(e) => Err(RunError::Output {
                place: "reading a reference image".into(),
                message: e.to_string(),
            }),
        }
    }
}

impl Drop for FileReferences {
    fn drop(&mut self) {
        if let Some(path) = &self.path {
            // If it cannot be deleted, nothing else can be done.
            let _ = fs::remove_file(path);
        }
    }
}
