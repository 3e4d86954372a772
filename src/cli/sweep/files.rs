//! The files of a sweep, opened and noted: what results depend on.

use std::path::Path;
use std::sync::{Arc, Mutex};

use powergs_core::run::files::Files as _;
use powergs_core::run::{Input, files};
use powergs_study::sweep::key::FileKind;
use powergs_study::sweep::library::{FileText, Files};

/// Opens files by name or path, and remembers what it has opened.
#[derive(Debug, Clone, Default)]
pub struct DiskFiles {
    opened: Arc<Mutex<Vec<Input>>>,
}

impl DiskFiles {
    /// Everything that was opened so far, sorted, each once.
    pub fn inputs(&self) -> Vec<Input> {
        let mut inputs = self.opened.lock().expect("no panic while it is held").clone();
        inputs.sort_by(|a, b| (a.role, &a.name, a.xxh3).cmp(&(b.role, &b.name, b.xxh3)));
        inputs.dedup();
        inputs
    }
}

impl Files for DiskFiles {
    fn read(&self, kind: FileKind, name: &str, beside: Option<&str>) -> Result<FileText, String> {
        let folder = beside.and_then(|origin| Path::new(origin).parent());
        let text = files::DiskFiles.read(kind, name, folder).map_err(|e| e.to_string())?;
        let input = Input::of_text(kind.role(), &text.origin, &text.text);
        self.opened.lock().expect("no panic while it is held").push(input);
        Ok(FileText { origin: text.origin, text: text.text })
    }
}
