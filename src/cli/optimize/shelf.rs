//! Reference images in a temporary file: what one iteration needs is read back, so that a hundred
//! photos take the memory of one.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::Mutex;

use xxhash_rust::xxh3::Xxh3;

use super::super::{Exit, Failure, OrExit};
use powergs_base::picture::Picture;
use powergs_optimize::setup::{Reference, References};

/// References in a file of the system's folder for such, which goes when this does.
pub struct Shelf {
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

impl Shelf {
    /// An empty shelf.
    ///
    /// # Errors
    /// Exit code 2: no temporary file can be made.
    pub fn new() -> Result<Shelf, Failure> {
        let name = format!("powergs-sim-references-{}", std::process::id());
        let mut path = std::env::temp_dir().join(&name);
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true);
        // Somebody else's file of that name is left alone.
        for attempt in 0..1000 {
            path.set_file_name(format!("{name}-{attempt}"));
            if !path.exists() {
                break;
            }
        }
        let file = options.open(&path).or_exit(Exit::Usage, path.display())?;
        let path = fs::remove_file(&path).err().map(|_| path);
        let (file, failure) = (Mutex::new(file), Mutex::new(None));
        Ok(Shelf { file, places: Vec::new(), end: 0, hash: Xxh3::new(), failure, path })
    }

    /// Adds the reference of the next view.
    ///
    /// # Errors
    /// Exit code 2: the file cannot be written.
    pub fn push(&mut self, reference: &Reference) -> Result<(), Failure> {
        let bytes = reference.as_bytes();
        let file = self.file.get_mut().unwrap_or_else(|broken| broken.into_inner());
        let what = "the temporary file of reference images (TMPDIR says where it is)";
        file.write_all(bytes).or_exit(Exit::Usage, what)?;
        self.places.push((self.end, reference.size()));
        self.end += bytes.len() as u64;
        self.hash.update(bytes);
        Ok(())
    }

    /// A hash of all references.
    pub fn digest(&self) -> u128 {
        self.hash.digest128()
    }

    /// Fails if a reference could not be read back; everything since then is worthless.
    ///
    /// # Errors
    /// Exit code 2.
    pub fn check(&self) -> Result<(), Failure> {
        let failure = self.failure.lock().unwrap_or_else(|broken| broken.into_inner());
        match &*failure {
            None => Ok(()),
            Some(e) => Err(Failure::new(Exit::Usage, format!("reading a reference image: {e}"))),
        }
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

impl References for Shelf {
    fn write_to(&self, view: usize, picture: &mut Picture) {
        let reference = self.read(view).unwrap_or_else(|error| {
            let mut failure = self.failure.lock().unwrap_or_else(|broken| broken.into_inner());
            failure.get_or_insert(error);
            let (width, height) = self.places[view].1;
            Reference::black(width, height)
        });
        reference.write_to(picture);
    }
}

impl Drop for Shelf {
    fn drop(&mut self) {
        if let Some(path) = &self.path {
            // Nothing else can be done about a file that stays.
            let _ = fs::remove_file(path);
        }
    }
}
