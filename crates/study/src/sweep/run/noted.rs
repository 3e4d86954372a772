//! Configuration files, noted as they are read: what results depend on.

use std::io::Read;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use powergs_core::run::files::Files;
use powergs_core::run::{ConfigText, FileKind, Input, RunError};

/// Hands files on, and remembers what was read.
#[derive(Clone)]
pub struct NotedFiles {
    files: Arc<dyn Files>,
    read: Arc<Mutex<Vec<Input>>>,
}

impl NotedFiles {
    /// Files from `files`.
    pub fn new(files: Arc<dyn Files>) -> NotedFiles {
        NotedFiles { files, read: Arc::default() }
    }

    /// Everything that was read so far, sorted, each once.
    pub fn inputs(&self) -> Vec<Input> {
        let mut inputs = self.read.lock().unwrap_or_else(PoisonError::into_inner).clone();
        inputs.sort_by(|a, b| (a.role, &a.name, a.xxh3).cmp(&(b.role, &b.name, b.xxh3)));
        inputs.dedup();
        inputs
    }
}

impl Files for NotedFiles {
    fn read(
        &self,
        kind: FileKind,
        name: &str,
        folder: Option<&Path>,
    ) -> Result<ConfigText, RunError> {
        let file = self.files.read(kind, name, folder)?;
        self.note(&file.inputs(kind.role()));
        Ok(file)
    }

    fn open(&self, path: &str, folder: Option<&Path>) -> Result<Box<dyn Read>, String> {
        self.files.open(path, folder)
    }

    fn note(&self, files: &[Input]) {
        self.read.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(files);
    }
}
