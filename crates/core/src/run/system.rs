//! A machine with everything that a simulation and a price need.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use powergs_base::config::knob;
use powergs_base::config::references::cited;
use powergs_base::quantity::Hertz;
use powergs_frame::display::Display;
use toml::Table;
use xxhash_rust::xxh3::Xxh3;

use super::change::Change;
use super::error::RunError;
use super::files::{ConfigText, DiskFiles, FileKind, Files, is_yaml, read_text};
use super::identity::{content_id, timing_id};
use super::input::Input;
use crate::flow::Work;
use crate::machine::Machine;
use crate::machine::{DramModel, NO_DEVICE};
use crate::sim::{self, SimError};
use crate::stage::EnergyTable;
use powergs_dram::Device;
use powergs_energy::{Prices, accelergy, same_costs};

/// The key of a machine file that names its energy table.
pub const ENERGY: &str = "energy";

/// The key of a machine file that names its DRAM device.
pub const DEVICE: &str = "dram.device";

/// Which system: names of files that come with the program, or paths.
#[derive(Debug, Clone, Default)]
pub struct SystemSpec {
    /// The machine.
    pub machine: String,
    /// `key=value` overlays of the machine file; keys behind `energy:`, `dram:` and `display:` are
    /// those of the other files.
    pub sets: Vec<String>,
    /// The energy table, in place of the one that the machine names.
    pub energy: Option<String>,
    /// The display that shows the frames.
    pub display: Option<String>,
}

impl SystemSpec {
    /// A machine by name or path, as its file says.
    pub fn named(machine: &str) -> SystemSpec {
        SystemSpec { machine: machine.to_owned(), ..SystemSpec::default() }
    }
}

/// A file of a system.
#[derive(Debug, Clone)]
struct SystemFile {
    /// As it was read.
    read: Arc<ConfigText>,
    /// Every key, changes applied; for a machine its value has them.
    table: Option<Arc<Table>>,
}

/// A machine, linked to its DRAM device, with its prices. Everything in it fits together.
#[derive(Debug, Clone)]
pub struct System {
    machine: Machine,
    energy: Arc<EnergyTable>,
    prices: Prices,
    device: Option<Arc<Device>>,
    display: Option<Arc<Display>>,
    files: [Option<SystemFile>; FileKind::ALL.len()],
}

impl System {
    /// A machine by name or path, with the energy table and the DRAM device that it names, and
    /// without a display.
    ///
    /// # Errors
    /// [`RunError::Config`]: an unknown name (with the known ones), a file that cannot be read,
    /// and everything that is wrong in it.
    pub fn named(machine: &str) -> Result<System, RunError> {
        System::load(&SystemSpec::named(machine), &DiskFiles)
    }

    /// The system that `spec` describes, from `files`.
    ///
    /// # Errors
    /// As [`System::named`].
    pub fn load(spec: &SystemSpec, files: &dyn Files) -> Result<System, RunError> {
        let (sets, others) = by_file(&spec.sets)?;
        let source = files;
        let mut machine_file = files.read(FileKind::Machine, &spec.machine, None)?;
        let origin = machine_file.origin.clone();
        let mut machine = Machine::parse_with(&machine_file.text, &sets)
            .map_err(|e| RunError::config(&origin, e))?;
        machine_file.attach(&mut machine, files)?;
        let folder = |key: &str| machine_file.folder_of(key, &spec.sets);
        let device_file = match machine.dram.has_device() {
            true => {
                let folder = folder(DEVICE);
                Some(files.read(FileKind::Dram, &machine.dram.device, folder.as_deref())?)
            }
            false => None,
        };
        let device = match &device_file {
            Some(file) => {
                let device = Device::parse(&file.text);
                Some(device.map_err(|e| RunError::config(&file.origin, e))?)
            }
            None => None,
        };
        if let (Some(device), None) = (&device, &machine.device) {
            machine.link(device).map_err(|(_, message)| RunError::config(&origin, message))?;
        }
        let energy_folder = folder(ENERGY).filter(|_| spec.energy.is_none());
        if let Some(name) = &spec.energy {
            name.clone_into(&mut machine.energy);
        }
        let energy_file =
            files.read(FileKind::Energy, &machine.energy, energy_folder.as_deref())?;
        let energy = energy_table(&energy_file, machine.clock)?;
        let prices =
            sim::cost::prices(&energy, &machine).map_err(|e| RunError::config(&origin, e))?;
        let (display, display_file) = match &spec.display {
            Some(name) => {
                let file = files.read(FileKind::Display, name, None)?;
                let display =
                    Display::parse(&file.text).map_err(|e| RunError::config(&file.origin, e))?;
                (Some(Arc::new(display)), Some(file))
            }
            None => (None, None),
        };
        let energy_table = table_of(&energy_file, &energy)?;
        let parsed = |file: &ConfigText| {
            file.text.parse::<Table>().map_err(|e| RunError::config(&file.origin, e))
        };
        let device_table = device_file.as_ref().map(parsed).transpose()?;
        let display_table = display_file.as_ref().map(parsed).transpose()?;
        let entry = |read: ConfigText, table: Option<Table>| {
            Some(SystemFile { read: Arc::new(read), table: table.map(Arc::new) })
        };
        let files = [
            entry(machine_file, None),
            entry(energy_file, Some(energy_table)),
            device_file.and_then(|file| entry(file, device_table)),
            display_file.and_then(|file| entry(file, display_table)),
        ];
        let (energy, device) = (Arc::new(energy), device.map(Arc::new));
        let system = System { machine, energy, prices, device, display, files };
        if others.is_empty() { Ok(system) } else { system.with_from(&others, source) }
    }

    /// The system with some keys of its files changed. Another `energy` or `dram.device` of the
    /// machine is read from `files`, a relative path in the working folder; keys of those files are
    /// changed after that.
    ///
    /// # Errors
    /// [`RunError::Config`]: a key that the file does not have, or a system that does not fit
    /// together, and why, in one line.
    pub fn with_from(&self, changes: &[Change], files: &dyn Files) -> Result<System, RunError> {
        let mut system = self.clone();
        for kind in FileKind::ALL {
            let mut of_file = changes.iter().filter(|c| c.file == kind).peekable();
            if of_file.peek().is_none() {
                continue;
            }
            let Some(mut table) = system.table(kind) else {
                return Err(invalid(format!("the system has no {}", kind.name())));
            };
            for change in of_file {
                let old = knob::values(&table, &change.path).pop();
                if !knob::set(&mut table, &change.path, &change.value) {
                    let what = format!("the {} file has no `{}`", kind.role(), change.path);
                    return Err(invalid(what));
                }
                if kind == FileKind::Machine && old.as_ref() != Some(&change.value) {
                    system.take_over(change, files)?;
                }
            }
            system.parse(kind, &table)?;
        }
        system.fit()?;
        Ok(system)
    }

    /// The system with all keys of one file as in `table`. Another `energy` or `dram.device` of the
    /// machine is read from `files`, as in [`System::with_from`].
    ///
    /// # Errors
    /// As [`System::with_from`].
    pub fn with_table(
        &self,
        kind: FileKind,
        table: &Table,
        files: &dyn Files,
    ) -> Result<System, RunError> {
        let mut system = self.clone();
        let old = self.table(kind);
        let Some(old) = old else {
            return Err(invalid(format!("the system has no {}", kind.name())));
        };
        if kind == FileKind::Machine {
            for path in [ENERGY, DEVICE] {
                let value = |table: &Table| knob::values(table, path).pop();
                if let Some(new) = value(table).filter(|new| value(&old).as_ref() != Some(new)) {
                    system.take_over(&Change::machine(path, new), files)?;
                }
            }
        }
        system.parse(kind, table)?;
        system.fit()?;
        Ok(system)
    }

    /// As [`System::with_from`]; other energy tables and devices by name or path.
    ///
    /// # Errors
    /// As [`System::with_from`].
    pub fn with(&self, changes: &[Change]) -> Result<System, RunError> {
        self.with_from(changes, &DiskFiles)
    }

    /// The same with the `calibrated` model of its DRAM, for many variants of it on the same
    /// frames; `None` where its model is not `banked`, or `calibrated` would be no faster.
    ///
    /// # Errors
    /// As [`System::with`].
    pub fn calibrated(&self) -> Result<Option<System>, RunError> {
        let dram = &self.machine.dram;
        let gains = dram.model == DramModel::Banked && dram.is_alone();
        let model = || Change::machine("dram.model", DramModel::Calibrated.name());
        gains.then(|| self.with(&[model()])).transpose()
    }

    /// Takes over the file that a changed key of the machine names.
    fn take_over(&mut self, change: &Change, files: &dyn Files) -> Result<(), RunError> {
        let kind = match change.path.as_str() {
            ENERGY => FileKind::Energy,
            DEVICE => FileKind::Dram,
            _ => return Ok(()),
        };
        let name = knob::shown(&change.value);
        if kind == FileKind::Dram && name == NO_DEVICE {
            self.device = None;
            self.files[kind as usize] = None;
            return Ok(());
        }
        let read = files.read(kind, &name, None)?;
        let table = match kind {
            FileKind::Energy => table_of(&read, &energy_table(&read, self.machine.clock)?)?,
            _ => read.text.parse().map_err(|e: toml::de::Error| RunError::config("", e))?,
        };
        self.files[kind as usize] = Some(SystemFile { read: Arc::new(read), table: None });
        self.parse(kind, &table)
    }

    /// Takes a file from a table of its keys.
    fn parse(&mut self, kind: FileKind, table: &Table) -> Result<(), RunError> {
        let text = table.to_string();
        let wrong = |e| invalid(one_line(&e));
        match kind {
            FileKind::Machine => {
                let machine = Machine::parse(&text).map_err(wrong)?;
                let old = std::mem::replace(&mut self.machine, machine);
                return self.machine.keep(&old).map_err(invalid);
            }
            FileKind::Energy => {
                self.energy = Arc::new(EnergyTable::parse(&text).map_err(wrong)?);
            }
            FileKind::Dram => {
                self.device = Some(Arc::new(Device::parse(&text).map_err(wrong)?));
            }
            FileKind::Display => {
                self.display = Some(Arc::new(Display::parse(&text).map_err(wrong)?));
            }
        }
        if let Some(file) = &mut self.files[kind as usize] {
            file.table = Some(Arc::new(table.clone()));
        }
        Ok(())
    }

    /// Links the machine to its device and prices it.
    fn fit(&mut self) -> Result<(), RunError> {
        if let Some(device) = &self.device {
            self.machine.link(device).map_err(|(_, message)| invalid(message))?;
        }
        let prices = sim::cost::prices(&self.energy, &self.machine);
        self.prices = prices.map_err(|e| invalid(one_line(&e)))?;
        Ok(())
    }

    /// The machine.
    pub fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Its energy table.
    pub fn energy_table(&self) -> &EnergyTable {
        &self.energy
    }

    /// The table applied to the machine.
    pub fn prices(&self) -> &Prices {
        &self.prices
    }

    /// The DRAM device, before the machine's own channels and mapping; `None` where the machine
    /// has a mere rate.
    pub fn device(&self) -> Option<&Device> {
        self.device.as_deref()
    }

    /// The display, where the system has one.
    pub fn display(&self) -> Option<&Display> {
        self.display.as_deref()
    }

    /// A file of the system as it was read; the display and the DRAM device may be absent.
    pub fn read(&self, kind: FileKind) -> Option<&ConfigText> {
        self.files[kind as usize].as_ref().map(|file| &*file.read)
    }

    /// Every key of a file, changes applied; the display and the DRAM device may be absent.
    pub fn table(&self, kind: FileKind) -> Option<Table> {
        if kind == FileKind::Machine {
            let table = Table::try_from(&self.machine);
            return Some(table.expect("a machine has only tables, numbers and strings"));
        }
        self.files[kind as usize].as_ref()?.table.as_deref().cloned()
    }

    /// The kinds of files that it has.
    fn kinds(&self) -> impl Iterator<Item = FileKind> {
        FileKind::ALL.into_iter().filter(|&kind| self.files[kind as usize].is_some())
    }

    /// What the machine is called: its `name`, or the name of its file where that is a file of the
    /// user that has another one, as a copy of a preset has.
    pub fn label(&self) -> String {
        let name = &self.machine.name;
        let file = self.read(FileKind::Machine).filter(|file| file.folder.is_some());
        let stem = file.and_then(|file| Path::new(&file.origin).file_stem());
        stem.map_or_else(|| name.clone(), |stem| stem.to_string_lossy().into_owned())
    }

    /// The machine as TOML: every key, changes applied.
    pub fn machine_toml(&self) -> String {
        self.machine.to_toml()
    }

    /// Keys of `references.toml` and assumption numbers that machine, energy table and device cite.
    pub fn sources(&self) -> BTreeSet<String> {
        let mut sources = BTreeSet::new();
        for kind in self.kinds().filter(|&kind| kind != FileKind::Display) {
            let Some(read) = self.read(kind) else { continue };
            match (kind == FileKind::Energy && is_yaml(&read.origin), self.table(kind)) {
                (true, Some(table)) => sources.extend(cited(&table.to_string())),
                _ => sources.extend(cited(&read.text)),
            }
        }
        sources
    }

    /// Hashes of the files as they were read.
    pub fn inputs(&self) -> Vec<Input> {
        let hash = |kind: FileKind| Some(self.read(kind)?.inputs(kind.role()));
        self.kinds().filter_map(hash).flatten().collect()
    }

    /// Every file as it is used, under its role.
    pub fn configuration(&self) -> Table {
        let entry = |kind: FileKind| {
            let table = match kind {
                FileKind::Machine => self.machine_toml().parse().ok()?,
                _ => self.table(kind)?,
            };
            Some((kind.role().to_owned(), toml::Value::Table(table)))
        };
        self.kinds().filter_map(entry).collect()
    }

    /// What is right in its files and doubtful, in sentences without their ends.
    pub fn doubts(&self) -> Vec<String> {
        let sizes = self.read(FileKind::Machine).and_then(ConfigText::decimal_sizes);
        sizes.into_iter().chain(doubts(&self.machine, &self.energy)).collect()
    }

    /// Simulates a frame that was prepared for this machine as if it were the first of its list.
    ///
    /// # Errors
    /// [`SimError`]: a frame that the machine cannot run, or a defect of the simulator.
    pub fn simulate(
        &self,
        label: sim::Label,
        work: &dyn Work,
    ) -> Result<sim::FrameReport, SimError> {
        sim::simulate(label, work, &self.machine, &self.prices)
    }

    /// Whether another system costs the same, whatever it does: see [`same_costs`].
    pub fn same_costs(&self, other: &System) -> bool {
        same_costs(&self.prices, &other.prices)
    }

    /// Peak rate of the DRAM that is timed, bytes per second.
    pub fn dram_peak(&self) -> f64 {
        self.machine.dram_peak().0
    }

    /// Hash of what decides timing: systems that agree in it have the same cycles and action counts
    /// on the same frame.
    pub fn timing_id(&self) -> u128 {
        let id = |device: &Device| {
            content_id(device).expect("a device has only tables, numbers, strings")
        };
        timing_id(&self.machine, self.device().map(id))
    }

    /// Hash of all files as they are used: systems that agree in it give the same results.
    pub fn id(&self) -> u128 {
        let mut hash = Xxh3::new();
        for kind in self.kinds() {
            hash.update(kind.role().as_bytes());
            hash.update(self.table(kind).unwrap_or_default().to_string().as_bytes());
        }
        for run in self.read(FileKind::Machine).into_iter().flat_map(ConfigText::attached) {
            hash.update(&run.xxh3.to_le_bytes());
        }
        hash.digest128()
    }
}

/// What is right in a machine and its energy table, and doubtful: prices of another unit or for
/// another clock, a run with more than the machine can do.
pub fn doubts(machine: &Machine, energy: &EnergyTable) -> Vec<String> {
    let run = machine.flow().doubt(machine);
    let prices = accelergy::doubt(energy).into_iter().chain(energy.clock_doubt(machine.clock));
    run.into_iter().chain(prices).collect()
}

/// Overlays of the machine file, and changes of what only whole files can be read without: those of
/// other files, and of every item of a list.
fn by_file(sets: &[String]) -> Result<(Vec<String>, Vec<Change>), RunError> {
    let (mut own, mut others) = (Vec::new(), Vec::new());
    for set in sets {
        let key = set.split('=').next().unwrap_or_default().trim();
        let mut kinds = FileKind::ALL.into_iter().filter(|kind| !kind.prefix().is_empty());
        if kinds.any(|kind| key.starts_with(kind.prefix())) || key.contains("[]") {
            let change: Result<Change, String> = set.parse();
            others.push(change.map_err(|e| RunError::config("--set", e))?);
        } else {
            own.push(set.clone());
        }
    }
    Ok((own, others))
}

/// An invalid configuration without a file that anybody has seen.
fn invalid(message: String) -> RunError {
    RunError::Config { place: String::new(), message }
}

/// The keys of an energy table; those of a reference table of Accelergy are its values.
fn table_of(file: &ConfigText, energy: &EnergyTable) -> Result<Table, RunError> {
    if is_yaml(&file.origin) {
        return Table::try_from(energy).map_err(|e| RunError::Internal(e.to_string()));
    }
    file.text.parse().map_err(|e: toml::de::Error| RunError::config(&file.origin, e))
}

/// The energy table in a file: TOML, or an energy reference table of Accelergy with the area table
/// beside it.
///
/// # Errors
/// [`RunError::Config`]: everything that is wrong in it.
pub fn energy_table(file: &ConfigText, clock: Hertz) -> Result<EnergyTable, RunError> {
    if !is_yaml(&file.origin) {
        return EnergyTable::parse(&file.text).map_err(|e| RunError::config(&file.origin, e));
    }
    let path = Path::new(&file.origin);
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let beside = path.file_name().map(|n| n.to_string_lossy().replace("ERT", "ART"));
    let beside = beside.map(|n| path.with_file_name(n)).filter(|p| p != path && p.exists());
    let areas = beside.as_deref().map(read_text).transpose()?;
    let origin = match &beside {
        Some(art) => format!("{} (areas: {})", file.origin, art.display()),
        None => file.origin.clone(),
    };
    accelergy::table(&name, &file.text, areas.as_deref(), clock)
        .map_err(|e| RunError::config(origin, super::error::causes(&e)))
}

/// An error without its line, which would be a line of a text that the user never saw.
fn one_line(error: &dyn std::error::Error) -> String {
    let text = error.to_string();
    let lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.contains('|'));
    let without_place = |line: &str| {
        let rest = line.strip_prefix("line ").and_then(|l| l.split_once(": "));
        rest.map_or(line, |(_, what)| what).to_owned()
    };
    lines.map(without_place).collect::<Vec<_>>().join(" ")
}
