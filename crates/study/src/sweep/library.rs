//! The files that designs are made of: read once, parsed once for every set of changes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;
use toml::{Table, Value};

use super::key::{FileKind, Key};
use powergs_base::config::ConfigError;
use powergs_base::config::knob;
use powergs_core::machine::Machine;
use powergs_core::run::files::Files;
use powergs_core::run::identity::content_id;
use powergs_core::run::{ConfigText, RunError};
use powergs_core::stage::EnergyTable;
use powergs_dram::Device;
use powergs_frame::display::Display;

/// Changed files that are kept; beyond that they are made anew for every point.
const KEPT_MAX: usize = 4096;

/// A file as a value, as a table and as text.
#[derive(Debug, PartialEq)]
pub struct LibraryDocument<T> {
    /// What it says.
    pub value: T,
    /// The folder that it lies in; `None` for files that come with the program.
    pub folder: Option<PathBuf>,
    /// Every key, changes applied.
    pub table: Table,
    /// Hash of everything but name and description.
    pub id: u128,
}

/// A kind of file.
pub trait Parsed: Sized + Serialize {
    /// Which.
    const KIND: FileKind;

    /// Reads and checks it.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    fn read(text: &str) -> Result<Self, ConfigError>;

    /// Reads what it needs besides its file.
    ///
    /// # Errors
    /// What is wrong with that.
    fn attach(&mut self, _file: &mut ConfigText, _files: &dyn Files) -> Result<(), RunError> {
        Ok(())
    }
}

macro_rules! parsed {
    ($t:ident, $kind:ident $(, $attach:item)?) => {
        impl Parsed for $t {
            const KIND: FileKind = FileKind::$kind;

            fn read(text: &str) -> Result<Self, ConfigError> {
                $t::parse(text)
            }

            $($attach)?
        }
    };
}
parsed!(
    Machine,
    Machine,
    fn attach(&mut self, file: &mut ConfigText, files: &dyn Files) -> Result<(), RunError> {
        file.attach(self, files)
    }
);
parsed!(EnergyTable, Energy);
parsed!(Device, Dram);
parsed!(Display, Display);

/// A changed key.
pub(super) type LibraryChange = (&'static Key, Value);

type Shelf<T> = Mutex<BTreeMap<String, Result<Arc<LibraryDocument<T>>, String>>>;

/// All files of a space.
pub(super) struct Library {
    files: Arc<dyn Files>,
    machines: Shelf<Machine>,
    tables: Shelf<EnergyTable>,
    devices: Shelf<Device>,
    displays: Shelf<Display>,
}

impl Library {
    pub(super) fn new(files: Arc<dyn Files>) -> Self {
        Self {
            files,
            machines: Shelf::default(),
            tables: Shelf::default(),
            devices: Shelf::default(),
            displays: Shelf::default(),
        }
    }

    pub(super) fn machine(&self, name: &str) -> Result<Arc<LibraryDocument<Machine>>, String> {
        self.get(&self.machines, name, None, &[])
    }

    pub(super) fn table(
        &self,
        name: &str,
        beside: Option<&Path>,
        changes: &[LibraryChange],
    ) -> Result<Arc<LibraryDocument<EnergyTable>>, String> {
        self.get(&self.tables, name, beside, changes)
    }

    pub(super) fn device(
        &self,
        name: &str,
        beside: Option<&Path>,
        changes: &[LibraryChange],
    ) -> Result<Arc<LibraryDocument<Device>>, String> {
        self.get(&self.devices, name, beside, changes)
    }

    pub(super) fn display(
        &self,
        name: &str,
        changes: &[LibraryChange],
    ) -> Result<Arc<LibraryDocument<Display>>, String> {
        self.get(&self.displays, name, None, changes)
    }

    fn get<T: Parsed>(
        &self,
        shelf: &Shelf<T>,
        name: &str,
        beside: Option<&Path>,
        changes: &[LibraryChange],
    ) -> Result<Arc<LibraryDocument<T>>, String> {
        let mut id = format!("{name}\n{}", beside.unwrap_or(Path::new("")).display());
        for (key, value) in changes {
            id.push_str(&format!("\n{}={value}", key.path));
        }
        let lock = || shelf.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = lock().get(&id) {
            return found.clone();
        }
        // Without the lock, so that others need not wait; two who make the same make it alike.
        let made = self.make::<T>(name, beside, changes).map(Arc::new);
        let mut shelf = lock();
        if shelf.len() < KEPT_MAX {
            shelf.insert(id, made.clone());
        }
        made
    }

    fn make<T: Parsed>(
        &self,
        name: &str,
        beside: Option<&Path>,
        changes: &[LibraryChange],
    ) -> Result<LibraryDocument<T>, String> {
        let mut file = self.files.read(T::KIND, name, beside).map_err(|e| e.to_string())?;
        let mut value =
            T::read(&file.text).map_err(|e| format!("{} {}: {e}", T::KIND.name(), file.origin))?;
        let mut table = table_of(&value)?;
        if !changes.is_empty() {
            for (key, value) in changes {
                if !knob::set(&mut table, &key.path, value) {
                    return Err(format!("{} `{name}` has no `{}`", T::KIND.name(), key.path));
                }
            }
            // Read anew: a changed file is checked like any other.
            value = T::read(&table.to_string()).map_err(|e| changed(T::KIND, name, &e))?;
            table = table_of(&value)?;
        }
        value.attach(&mut file, &*self.files).map_err(|e| e.to_string())?;
        let id = content_id(&value).map_err(|e| e.to_string())?;
        Ok(LibraryDocument { value, folder: file.folder, table, id })
    }
}

fn table_of<T: Serialize>(value: &T) -> Result<Table, String> {
    Table::try_from(value).map_err(|e| e.to_string())
}

/// Problems of a text that was composed here: without lines, which the user has never seen.
fn changed(kind: FileKind, name: &str, error: &ConfigError) -> String {
    let messages: Vec<&str> = error.problems.iter().map(|p| p.message.as_str()).collect();
    format!("{} `{name}` as changed: {}", kind.name(), messages.join("; "))
}
