//! Machines: a machine file with its energy table, DRAM device and display.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::basic::CompareOp;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::error::{Fault, defect};
use crate::table::{Column, Table};
use crate::value;
use powergs_base::config::suggest::nearest;
use powergs_base::config::{KeyDoc, embedded, key_docs, knob};
use powergs_core::machine::Machine as MachineFile;
use powergs_core::machine::Optional;
use powergs_core::run::files::{ConfigText, DiskFiles, FileKind, Files};
use powergs_core::run::{Change, RunError, System, SystemSpec};
use powergs_core::sim::cost::peak_w;
use powergs_core::stage::{EnergyTable, hardware};
use powergs_dram::Device;
use powergs_energy::Area;
use powergs_frame::display::Display;
use powergs_report::document::Document;
use powergs_study::sweep::design::Design;

/// The display that machines have unless another is named.
pub const DISPLAY: &str = "oled-powergs";

/// A machine: its file, the energy table and the DRAM device that it names, and a display.
///
/// Parameters
/// ----------
/// name : str or path
///     A machine that comes with the package (``powergs.names("machine")``), or a TOML file.
/// energy : str or path, optional
///     Energy table in place of the machine's: a name, a TOML file, or a table of Accelergy.
/// display : str or path
///     Display whose power is counted beside that of the machine.
///
/// A machine never changes; ``with_`` gives another one.
///
/// >>> eight = powergs.Machine("gscore").with_({"vru.cores": 8, "clock": "1.2 GHz"})
/// >>> eight["vru.cores"]
/// 8
#[pyclass(frozen, module = "powergs", name = "Machine")]
pub struct Machine {
    system: Arc<System>,
    /// What it was made of, for pickles.
    name: String,
}

/// A text, or a path as `os.fspath` gives it.
pub fn path_text(path: &Bound<'_, PyAny>) -> PyResult<String> {
    match path.cast::<PyString>() {
        Ok(text) => Ok(text.to_str()?.to_owned()),
        Err(_) => Ok(path.extract::<PathBuf>()?.to_string_lossy().into_owned()),
    }
}

/// Refuses a whole file in place of its name.
fn not_a_text(name: &str) -> PyResult<()> {
    if name.contains('\n') {
        let what = "a machine is named by its name or its path; for the text of a file there is \
                    Machine.from_toml";
        return Err(Fault::config(what).raise());
    }
    Ok(())
}

impl Machine {
    /// The system that it has.
    pub fn system(&self) -> Arc<System> {
        Arc::clone(&self.system)
    }

    /// What it was opened as.
    pub fn opened_as(&self) -> &str {
        &self.name
    }

    /// Area of the chip, mm², where the energy table has areas.
    fn known_area(&self) -> Option<f64> {
        self.system.prices().area.as_ref().map(|area| area.total().0)
    }

    /// The same machine with another system.
    pub fn of(&self, system: System) -> Machine {
        Machine { system: Arc::new(system), name: self.name.clone() }
    }

    /// The machine of an argument: a `Machine`, or a name or path. `display` is in place of its
    /// own.
    pub fn from_argument(given: &Bound<'_, PyAny>, display: Option<String>) -> PyResult<Machine> {
        if let Ok(machine) = given.cast::<Machine>() {
            let machine = machine.get();
            let Some(display) = display else {
                return Ok(Machine::new(&machine.name, (*machine.system).clone()));
            };
            let (name, mut files) = parts(&machine.name, &machine.system);
            let read = DiskFiles.read(FileKind::Display, &display, None).map_err(Fault::from)?;
            let (table, own) = (read.text.clone(), read.own().to_owned());
            files.insert("display".into(), (read.origin, read.folder, own, table, read.bases));
            return Ok(Machine::new(&name, unpickled((name.clone(), files))?));
        }
        let name = path_text(given).map_err(|_| {
            let what = "a machine is a powergs.Machine, or the name or path of one";
            pyo3::exceptions::PyTypeError::new_err(what)
        })?;
        Machine::loaded(&name, display)
    }

    /// A machine by name or path, with the usual display.
    pub fn named(name: &str) -> PyResult<Machine> {
        Machine::loaded(name, None)
    }

    fn loaded(name: &str, display: Option<String>) -> PyResult<Machine> {
        not_a_text(name)?;
        let display = Some(display.unwrap_or_else(|| DISPLAY.into()));
        let spec = SystemSpec { machine: name.to_owned(), display, ..SystemSpec::default() };
        Ok(Machine::new(name, System::load(&spec, &DiskFiles).map_err(Fault::from)?))
    }

    /// The machine of a design of a sweep, with its first energy table.
    pub fn of_design(design: &Design) -> PyResult<Machine> {
        let name = design.machine.name.clone();
        let machine = ("machine".to_owned(), design.resolved_machine_toml());
        let mut files = BTreeMap::new();
        for (role, text) in std::iter::once(machine).chain(design.files()) {
            let role = role.split(' ').next().unwrap_or_default().to_owned();
            let part = (role.clone(), None, text.clone(), text, Vec::new());
            files.entry(role).or_insert(part);
        }
        Ok(Machine::new(&name, unpickled((name.clone(), files))?))
    }

    fn lacks(&self, key: &str) -> Option<&'static Optional> {
        self.system.machine().lacks(key)
    }

    /// A machine of a system that was opened as `name`.
    pub fn new(name: &str, system: System) -> Machine {
        Machine { system: Arc::new(system), name: name.to_owned() }
    }

    /// The system with some keys changed; errors name the file of the machine.
    pub fn changed(&self, changes: &[Change]) -> Result<System, Fault> {
        let origin = || self.system.read(FileKind::Machine).map_or("", |file| &file.origin);
        self.system.with(changes).map_err(|error| match error {
            RunError::Config { place, message } if place.is_empty() => {
                RunError::config(origin(), message).into()
            }
            other => other.into(),
        })
    }
}

/// The key that was probably meant, where the files have none of this name.
fn misspelt(change: &Change) -> Option<String> {
    let docs = docs_of(change.file);
    let known = || docs.iter().map(|doc| doc.path.as_str());
    if known().any(|path| path == change.path) {
        return None;
    }
    nearest(&change.path, known()).map(str::to_owned)
}

/// The keys of a kind of file.
fn docs_of(kind: FileKind) -> Vec<KeyDoc> {
    match kind {
        FileKind::Machine => key_docs::<MachineFile>(),
        FileKind::Energy => key_docs::<EnergyTable>(),
        FileKind::Dram => key_docs::<Device>(),
        FileKind::Display => key_docs::<Display>(),
    }
}

#[pymethods]
impl Machine {
    #[new]
    #[pyo3(signature = (name, /, *, energy=None, display=None))]
    fn open(
        name: &Bound<'_, PyAny>,
        energy: Option<&Bound<'_, PyAny>>,
        display: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Machine> {
        let name = path_text(name)?;
        not_a_text(&name)?;
        let display = display.map(path_text).transpose()?.unwrap_or_else(|| DISPLAY.into());
        let spec = SystemSpec {
            machine: name.clone(),
            sets: Vec::new(),
            energy: energy.map(path_text).transpose()?,
            display: Some(display),
        };
        let system = System::load(&spec, &DiskFiles).map_err(Fault::from)?;
        Ok(Machine { system: Arc::new(system), name })
    }

    /// The same machine with some keys changed.
    ///
    /// Keys have dots (``"vru.cores"``); as keyword arguments they have ``__`` for the dots and
    /// ``_`` for ``-``. Values are numbers, texts with a unit (``"1.2 GHz"``), truth values or
    /// lists. ``energy:``, ``dram:`` and ``display:`` in front of a key name the other files.
    ///
    /// Raises ``ConfigError`` for a key that the file does not have, with a suggestion, for one of
    /// a part that the machine does not have, and for values that do not fit together.
    #[pyo3(signature = (keys=None, /, **named))]
    fn with_(
        &self,
        keys: Option<&Bound<'_, PyDict>>,
        named: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Machine> {
        let changes = value::changes(keys, named)?;
        let machine = self.of(self.changed(&changes)?);
        let of_machine = |change: &&Change| change.file == FileKind::Machine;
        let absent = |change: &Change| Some(machine.lacks(&change.path)?.absent(&change.path));
        match changes.iter().filter(of_machine).find_map(absent) {
            Some(message) => Err(Fault::config(message).into()),
            None => Ok(machine),
        }
    }

    /// Name of the machine.
    #[getter]
    fn name(&self) -> String {
        self.system.label()
    }

    /// What it is, in a sentence.
    #[getter]
    fn description(&self) -> &str {
        &self.system.machine().description
    }

    /// Name of its energy table.
    #[getter]
    fn energy_table(&self) -> &str {
        &self.system.energy_table().name
    }

    /// Clock, hertz.
    #[getter]
    fn clock_hz(&self) -> f64 {
        self.system.machine().clock.0
    }

    /// Peak rate of its DRAM, 10⁹ bytes per second.
    #[getter]
    fn dram_peak_gb_s(&self) -> f64 {
        self.system.dram_peak() * 1e-9
    }

    /// Area of the chip, mm²; NaN where the energy table has no areas.
    #[getter]
    fn area_mm2(&self) -> f64 {
        self.known_area().unwrap_or(f64::NAN)
    }

    /// Area and peak power of its blocks: ``block``, ``area_mm2``, ``peak_power_w``.
    fn area(&self) -> PyResult<Table> {
        let prices = self.system.prices();
        let watts = peak_w(self.system.machine(), prices);
        let names: Vec<&str> = Area::blocks(hardware()).iter().map(|block| block.name).collect();
        let area = |i: usize| prices.area.as_ref().map(|area| area.areas()[i].0);
        let peak = |name: &&str| watts.iter().find(|(block, _)| block == name).map(|(_, w)| *w);
        Table::new([
            Column::text("block", "Block of the chip.", names.iter().map(Some)),
            Column::real("area_mm2", "mm²", "Area of the block.", (0..names.len()).map(area)),
            Column::real(
                "peak_power_w",
                "W",
                "Power of the block if all of it worked in every cycle.",
                names.iter().map(peak),
            ),
        ])
    }

    /// Every key with its value, unit and definition.
    ///
    /// ``file`` is ``"machine"``, ``"energy"``, ``"dram"`` or ``"display"``.
    #[pyo3(signature = (file="machine"))]
    fn keys(&self, file: &str) -> PyResult<Table> {
        let kind = FileKind::ALL.into_iter().find(|kind| kind.role() == file);
        let unknown = || Fault::config("file: one of machine, energy, dram, display");
        let kind = kind.ok_or_else(unknown)?;
        let missing = || Fault::config(format!("this machine has no {}", kind.name()));
        let table = self.system.table(kind).ok_or_else(missing)?;
        let mut rows: Vec<(KeyDoc, Option<String>)> = Vec::new();
        let lacks = |key: &str| kind == FileKind::Machine && self.lacks(key).is_some();
        for doc in docs_of(kind).into_iter().filter(|doc| !doc.table) {
            let mut values = knob::values(&table, doc.path.trim_end_matches("[]"));
            values.retain(|_| !lacks(&doc.path));
            let shown: Vec<String> = values.iter().map(knob::shown).collect();
            let value = (!shown.is_empty()).then(|| shown.join(", "));
            rows.push((doc, value));
        }
        let docs = || rows.iter().map(|(doc, _)| doc);
        Table::new([
            Column::text("key", "Name with dots.", docs().map(|d| Some(&d.path))),
            Column::text(
                "value",
                "As the file has it; null for a part that is not there.",
                rows.iter().map(|(_, v)| v.as_ref()),
            ),
            Column::text("unit", "Unit or kind of the value.", docs().map(|d| Some(&d.unit))),
            Column::text("definition", "What it is.", docs().map(|d| Some(&d.definition))),
        ])
    }

    /// The value of a key: a number, a text with its unit, a truth value, a list or a table.
    fn __getitem__<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let change: Change = format!("{key}=0").parse().map_err(Fault::config)?;
        if let Some(part) = self.lacks(&change.path).filter(|_| change.file == FileKind::Machine) {
            return Err(PyKeyError::new_err(part.absent(&change.path)));
        }
        let table = self.system.table(change.file);
        let found = table.and_then(|table| knob::values(&table, &change.path).into_iter().next());
        match found {
            Some(found) => value::python(py, &found),
            None => {
                let hint = misspelt(&change).map(|near| format!("; did you mean `{near}`?"));
                Err(PyKeyError::new_err(format!("no key `{key}`{}", hint.unwrap_or_default())))
            }
        }
    }

    /// A machine file as a text, such as that of ``to_toml``; it may name a ``base``. ``energy``
    /// and ``display`` are as for ``Machine(...)``.
    #[staticmethod]
    #[pyo3(signature = (text, /, *, energy=None, display=None))]
    fn from_toml(
        text: String,
        energy: Option<&Bound<'_, PyAny>>,
        display: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Machine> {
        let file = ConfigText::in_memory(FileKind::Machine, text).map_err(Fault::from)?;
        let display = display.map(path_text).transpose()?.unwrap_or_else(|| DISPLAY.into());
        let energy = energy.map(path_text).transpose()?;
        let machine = file.origin.clone();
        let spec = SystemSpec {
            machine: machine.clone(),
            sets: Vec::new(),
            energy,
            display: Some(display),
        };
        let part = (machine, None, file.own().to_owned(), String::new(), file.bases.clone());
        let files = Pickled(BTreeMap::from([(FileKind::Machine.role().to_owned(), part)]));
        let system = System::load(&spec, &files).map_err(Fault::from)?;
        let name = system.machine().name.clone();
        Ok(Machine::new(&name, system))
    }

    /// A machine file as a dictionary of tables: ``{"base": "gscore", "vru": {"cores": 8}}``.
    #[staticmethod]
    #[pyo3(signature = (keys, /, *, energy=None, display=None))]
    fn from_dict(
        keys: &Bound<'_, PyDict>,
        energy: Option<&Bound<'_, PyAny>>,
        display: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Machine> {
        let mut keys = value::table(keys)?;
        keys.entry("name").or_insert_with(|| "own".into());
        Machine::from_toml(keys.to_string(), energy, display)
    }

    /// The machine file as TOML, with every key and all changes.
    fn to_toml(&self) -> String {
        self.system.machine_toml()
    }

    fn __repr__(&self) -> String {
        let clock = self.system.machine().clock;
        let area = self.known_area().map(|mm2| format!(", {mm2:.3} mm²")).unwrap_or_default();
        format!("<Machine {}: {clock}, {}{area}>", self.name(), self.energy_table())
    }

    fn _repr_html_(&self) -> PyResult<String> {
        let mut page = Document::new();
        page.title(self.name());
        page.paragraph(self.description());
        let mut facts = vec![
            ("clock", self.system.machine().clock.to_string()),
            ("energy table", self.energy_table().to_owned()),
            ("DRAM", format!("{:.1} GB/s at most", self.dram_peak_gb_s())),
        ];
        facts.extend(self.known_area().map(|mm2| ("area", format!("{mm2:.3} mm²"))));
        page.facts(facts);
        page.fragment().map_err(defect)
    }

    fn __richcmp__(&self, other: &Machine, op: CompareOp) -> PyResult<bool> {
        let same = self.system.id() == other.system.id();
        match op {
            CompareOp::Eq => Ok(same),
            CompareOp::Ne => Ok(!same),
            CompareOp::Lt | CompareOp::Le | CompareOp::Gt | CompareOp::Ge => {
                let what = "machines have no order; compare their results";
                Err(pyo3::exceptions::PyTypeError::new_err(what))
            }
        }
    }

    fn __hash__(&self) -> u64 {
        self.system.id() as u64
    }

    /// What tells this machine from others: its files, with all changes made. Stores use it.
    #[getter]
    fn _key(&self) -> BTreeMap<String, String> {
        let files = parts(&self.name, &self.system).1.into_iter();
        let attached = self.system.read(FileKind::Machine).into_iter().flat_map(|f| f.attached());
        let attached = attached.map(|run| (run.role.to_owned(), format!("{:032x}", run.xxh3)));
        files.map(|(role, file)| (role, file.3)).chain(attached).collect()
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Parts)> {
        let of = py.import("powergs._powergs")?.getattr("_machine")?;
        Ok((of, parts(&self.name, &self.system)))
    }
}

/// A file as read (origin, folder, text), as changed, and the bases that it had: origin and text.
type FileParts = (String, Option<PathBuf>, String, String, Vec<(String, String)>);

/// What a machine is pickled as: its name, and every file.
pub type Parts = (String, BTreeMap<String, FileParts>);

/// What a system is pickled as.
pub fn parts(name: &str, system: &System) -> Parts {
    let file = |kind: FileKind| {
        let read = system.read(kind)?;
        let table = system.table(kind)?.to_string();
        let (origin, folder, own) = (read.origin.clone(), read.folder.clone(), read.own().into());
        let entry = (origin, folder, own, table, read.bases.clone());
        Some((kind.role().to_owned(), entry))
    };
    (name.to_owned(), FileKind::ALL.into_iter().filter_map(file).collect())
}

/// Files in memory, as of a pickle; what is not there comes from the disk.
struct Pickled(BTreeMap<String, FileParts>);

impl Files for Pickled {
    fn read(
        &self,
        kind: FileKind,
        name: &str,
        folder: Option<&Path>,
    ) -> Result<ConfigText, RunError> {
        match self.0.get(kind.role()) {
            Some((origin, folder, text, _, bases)) => {
                let own = ConfigText::new(origin.clone(), folder.clone(), text.clone());
                own.on_bases(bases.clone())
            }
            None => DiskFiles.read(kind, name, folder),
        }
    }
}

/// A system from its parts.
pub fn unpickled((name, files): Parts) -> PyResult<System> {
    let display = files.contains_key("display").then(|| "display".to_owned());
    let files = Pickled(files);
    let spec = SystemSpec { machine: name, sets: Vec::new(), energy: None, display };
    let mut system = System::load(&spec, &files).map_err(Fault::from)?;
    for kind in FileKind::ALL {
        let Some((_, _, _, wanted, _)) = files.0.get(kind.role()) else { continue };
        let wanted = wanted.parse::<toml::Table>().map_err(|e| Fault::config(e.to_string()))?;
        if system.table(kind).as_ref() != Some(&wanted) {
            system = system.with_table(kind, &wanted, &files).map_err(Fault::from)?;
        }
    }
    Ok(system)
}

/// A pickled machine.
#[pyfunction]
pub fn _machine(name: String, files: BTreeMap<String, FileParts>) -> PyResult<Machine> {
    let system = unpickled((name.clone(), files))?;
    Ok(Machine { system: Arc::new(system), name })
}

/// Names of files that come with the package.
///
/// ``kind`` is ``"machine"``, ``"energy"``, ``"display"``, ``"dram"``, ``"sweep"`` or ``"synth"``.
#[pyfunction]
#[pyo3(signature = (kind="machine"))]
pub fn names(kind: &str) -> PyResult<Vec<&'static str>> {
    let files = match kind {
        "machine" => embedded::MACHINES,
        "energy" => embedded::ENERGY,
        "display" => embedded::DISPLAYS,
        "dram" => embedded::DRAM,
        "sweep" => embedded::SWEEPS,
        "synth" => embedded::SYNTH,
        _ => {
            let what = "kind: one of machine, energy, display, dram, sweep, synth";
            return Err(Fault::config(what).raise());
        }
    };
    Ok(files.iter().map(|file| file.name).collect())
}
