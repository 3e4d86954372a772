//! The files of a sweep, opened and noted: what results depend on.

use std::path::Path;
use std::sync::{Arc, Mutex};

use crate::cli::machine_file::read;
use crate::cli::trace_source::hashed;
use powergs_base::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES};
use powergs_report::Input;
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
        let (role, words, embedded) = match kind {
            FileKind::Machine => ("machine", "machine", MACHINES),
            FileKind::Energy => ("energy", "energy table", ENERGY),
            FileKind::Dram => ("dram", "DRAM device", DRAM),
            FileKind::Display => ("display", "display preset", DISPLAYS),
        };
        let folder = beside.and_then(|origin| Path::new(origin).parent());
        let text = read(words, name, embedded, folder).map_err(|e| e.to_string())?;
        let input = hashed(role, &text.origin, &mut text.text.as_bytes(), &text.origin);
        self.opened
            .lock()
            .expect("no panic while it is held")
            .push(input.map_err(|e| e.to_string())?);
        Ok(FileText { origin: text.origin, text: text.text })
    }
}
