//! The files that designs are made of: read once, parsed once for every set of changes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;
use toml::{Table, Value};

use super::key::{FileKind, Key};
use powergs_base::config::ConfigError;
use powergs_base::config::knob;
use powergs_base::quantity::Hertz;
use powergs_core::machine::Machine;
use powergs_core::run::files::{Files, is_yaml};
use powergs_core::run::identity::content_id;
use powergs_core::run::system::{DEVICE, ENERGY, energy_table};
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
    /// The folder of the energy table that it names; `None` for what comes with the program.
    pub energy_in: Option<PathBuf>,
    /// The same of the DRAM device.
    pub device_in: Option<PathBuf>,
    /// Every key, changes applied.
    pub table: Table,
    /// Hash of everything but name and description.
    pub id: u128,
}

/// A kind of file.
pub trait Parsed: Sized + Serialize {
    /// Which.
    const KIND: FileKind;

    /// Reads and checks its text.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    fn read(text: &str) -> Result<Self, ConfigError>;

    /// Reads and checks its file, for a machine with this clock.
    ///
    /// # Errors
    /// Everything that is wrong with it, with its name.
    fn of_file(file: &ConfigText, _clock: Hertz) -> Result<Self, String> {
        Self::read(&file.text).map_err(|e| format!("{} {}: {e}", Self::KIND.name(), file.origin))
    }

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
parsed!(
    EnergyTable,
    Energy,
    fn of_file(file: &ConfigText, clock: Hertz) -> Result<Self, String> {
        let kind = Self::KIND.name();
        energy_table(file, clock).map_err(|e| format!("{kind} {e}"))
    }
);
parsed!(Device, Dram);
parsed!(Display, Display);

/// A changed key.
pub(super) type LibraryChange = (&'static Key, Value);

type Shelf<T> = Mutex<BTreeMap<String, Result<Arc<LibraryDocument<T>>, String>>>;

/// Which file, and what is otherwise in it.
#[derive(Clone, Copy)]
pub(super) struct LibraryFile<'a> {
    /// Its name, or its path.
    pub(super) name: &'a str,
    /// The folder of the file that names it.
    pub(super) folder: Option<&'a Path>,
    /// Keys that are changed.
    pub(super) changes: &'a [LibraryChange],
}

impl<'a> LibraryFile<'a> {
    /// A file as it is.
    pub(super) fn plain(name: &'a str, folder: Option<&'a Path>) -> LibraryFile<'a> {
        LibraryFile { name, folder, changes: &[] }
    }
}

/// The clock of files that do not depend on one.
pub(super) const ANY_CLOCK: Hertz = Hertz(1e9);

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

    pub(super) fn machine(
        &self,
        name: &str,
        folder: Option<&Path>,
    ) -> Result<Arc<LibraryDocument<Machine>>, String> {
        self.get(&self.machines, LibraryFile::plain(name, folder), ANY_CLOCK)
    }

    /// An energy table for a machine with this clock: reference tables of Accelergy have leakage
    /// per cycle.
    pub(super) fn table(
        &self,
        asked: LibraryFile<'_>,
        clock: Hertz,
    ) -> Result<Arc<LibraryDocument<EnergyTable>>, String> {
        self.get(&self.tables, asked, if is_yaml(asked.name) { clock } else { ANY_CLOCK })
    }

    pub(super) fn device(
        &self,
        asked: LibraryFile<'_>,
    ) -> Result<Arc<LibraryDocument<Device>>, String> {
        self.get(&self.devices, asked, ANY_CLOCK)
    }

    pub(super) fn display(
        &self,
        asked: LibraryFile<'_>,
    ) -> Result<Arc<LibraryDocument<Display>>, String> {
        self.get(&self.displays, asked, ANY_CLOCK)
    }

    fn get<T: Parsed>(
        &self,
        shelf: &Shelf<T>,
        asked: LibraryFile<'_>,
        clock: Hertz,
    ) -> Result<Arc<LibraryDocument<T>>, String> {
        let LibraryFile { name, folder, changes } = asked;
        let mut id = format!("{name}\n{}\n{}", folder.unwrap_or(Path::new("")).display(), clock.0);
        for (key, value) in changes {
            id.push_str(&format!("\n{}={value}", key.path));
        }
        let lock = || shelf.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = lock().get(&id) {
            return found.clone();
        }
        // Without the lock, so that others need not wait; two who make the same make it alike.
        let made = self.make::<T>(asked, clock).map(Arc::new);
        let mut shelf = lock();
        if shelf.len() < KEPT_MAX {
            shelf.insert(id, made.clone());
        }
        made
    }

    fn make<T: Parsed>(
        &self,
        asked: LibraryFile<'_>,
        clock: Hertz,
    ) -> Result<LibraryDocument<T>, String> {
        let LibraryFile { name, folder, changes } = asked;
        let mut file = self.files.read(T::KIND, name, folder).map_err(|e| e.to_string())?;
        let mut value = T::of_file(&file, clock)?;
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
        let folder = |key| file.folder_of(key, &[]).filter(|_| T::KIND == FileKind::Machine);
        let (energy_in, device_in) = (folder(ENERGY), folder(DEVICE));
        Ok(LibraryDocument { value, energy_in, device_in, table, id })
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
