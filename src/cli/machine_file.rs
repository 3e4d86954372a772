//! Finding machine files, energy tables and display presets: embedded ones by name, others by path.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::{Exit, Failure, OrExit};
use powergs_base::config::document::TEXT_MAX;
use powergs_base::config::embedded::{DISPLAYS, DRAM, ENERGY, MACHINES, find, names};
use powergs_base::config::references::cited;
use powergs_base::config::suggest::nearest;
use powergs_base::config::{ConfigError, Embedded};
use powergs_base::quantity::Hertz;
use powergs_core::accel::Machine;
use powergs_core::dram::Device;
use powergs_core::energy::{EnergyTable, Prices, accelergy};
use powergs_core::sim;
use powergs_frame::display::Display;

/// A configuration text and where it came from.
#[derive(Debug, Clone)]
pub struct Text {
    /// What error messages call it: the path, or the name of an embedded file.
    pub origin: String,
    /// The folder that it lies in, for paths inside it; `None` for embedded files.
    pub folder: Option<PathBuf>,
    /// The text.
    pub text: String,
}

/// A machine with everything that a run needs to know about it.
#[derive(Debug, Clone)]
pub struct LoadedMachine {
    /// The machine, overlays applied.
    pub machine: Machine,
    /// Its energy table.
    pub energy_table: EnergyTable,
    /// The table applied to the machine.
    pub prices: Prices,
    /// The machine as resolved: every key, overlays applied.
    pub resolved_toml: String,
    /// Keys of `references.toml` and assumption numbers that machine and table cite.
    pub sources: BTreeSet<String>,
    /// The machine file as it was read.
    pub machine_file: Text,
    /// The energy table as it was read.
    pub energy_file: Text,
    /// The DRAM device as it was read.
    pub device_file: Text,
    /// The energy table as TOML: as it was read, or made of the reference tables that were read.
    pub energy_toml: String,
}

/// Loads a machine by name or path, with `key=value` overlays, and its energy table and DRAM
/// device.
///
/// # Errors
/// Exit code 2: an unknown name (with the known ones), a file that cannot be read, and everything
/// that is wrong in it.
pub fn load_machine(arch: &str, sets: &[String]) -> Result<LoadedMachine, Failure> {
    load_machine_with(arch, sets, None)
}

/// As [`load_machine`], with this energy table in place of the machine's: a name, or a path from
/// the working folder.
///
/// # Errors
/// As [`load_machine`].
pub fn load_machine_with(
    arch: &str,
    sets: &[String],
    energy: Option<&str>,
) -> Result<LoadedMachine, Failure> {
    let machine_file = read("machine", arch, MACHINES, None)?;
    let mut machine = Machine::parse_with(&machine_file.text, sets).usage(&machine_file.origin)?;
    let folder = machine_file.folder.as_deref();
    let device_file = read("DRAM device", &machine.dram.device, DRAM, folder)?;
    if machine.device.is_none() {
        let device = Device::parse(&device_file.text).usage(&device_file.origin)?;
        let wrong =
            |(_, message)| Failure::new(Exit::Usage, format!("{}: {message}", machine_file.origin));
        machine.link(&device).map_err(wrong)?;
    }
    let energy_folder = if energy.is_some() { None } else { folder };
    if let Some(name) = energy {
        name.clone_into(&mut machine.energy);
    }
    let energy_file = read("energy table", &machine.energy, ENERGY, energy_folder)?;
    let (energy_table, energy_toml) = energy_table(&energy_file, machine.clock)?;
    let prices =
        sim::cost::prices(&energy_table, &machine).or_exit(Exit::Usage, &machine_file.origin)?;
    let mut sources = cited(&machine_file.text);
    sources.extend(cited(&energy_toml));
    sources.extend(cited(&device_file.text));
    let resolved_toml = machine.to_toml();
    Ok(LoadedMachine {
        machine,
        energy_table,
        prices,
        resolved_toml,
        sources,
        machine_file,
        energy_file,
        device_file,
        energy_toml,
    })
}

/// The energy table in a file, TOML or an energy reference table of Accelergy, and its TOML.
///
/// # Errors
/// Exit code 2: everything that is wrong in it.
pub fn energy_table(file: &Text, clock: Hertz) -> Result<(EnergyTable, String), Failure> {
    if !is_yaml(&file.origin) {
        return Ok((EnergyTable::parse(&file.text).usage(&file.origin)?, file.text.clone()));
    }
    let path = Path::new(&file.origin);
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let beside = path.file_name().map(|n| n.to_string_lossy().replace("ERT", "ART"));
    let beside = beside.map(|n| path.with_file_name(n)).filter(|p| p != path && p.exists());
    let art = match &beside {
        Some(path) => Some(read_text(path).or_exit(Exit::Usage, path.display())?),
        None => None,
    };
    let origin = match &beside {
        Some(art) => format!("{} (areas: {})", file.origin, art.display()),
        None => file.origin.clone(),
    };
    let table =
        accelergy::table(&name, &file.text, art.as_deref(), clock).or_exit(Exit::Usage, origin)?;
    let text = toml::to_string(&table).or_exit(Exit::Internal, &file.origin)?;
    Ok((table, text))
}

/// Whether a file is read as a reference table of Accelergy.
pub fn is_yaml(name: &str) -> bool {
    let end = Path::new(name).extension().unwrap_or_default().to_string_lossy().to_lowercase();
    end == "yaml" || end == "yml"
}

/// Loads a display preset by name or path.
///
/// # Errors
/// As [`load_machine`].
pub fn load_display(name: &str) -> Result<Display, Failure> {
    let file = read("display preset", name, DISPLAYS, None)?;
    Display::parse(&file.text).usage(&file.origin)
}

/// Reads an embedded file by name, or any other by path, relative to `folder` if it is there.
///
/// # Errors
/// Exit code 2: an unknown name (with the known ones), or a file that cannot be read as text.
pub fn read(
    kind: &str,
    name: &str,
    embedded: &[Embedded],
    folder: Option<&Path>,
) -> Result<Text, Failure> {
    if let Some(text) = find(embedded, name) {
        return Ok(Text { origin: name.to_owned(), folder: None, text: text.to_owned() });
    }
    let beside = folder.map(|f| f.join(name)).filter(|p| p.exists());
    let path = beside.unwrap_or_else(|| PathBuf::from(name));
    let looks_like_path = name.contains(['/', '\\']) || name.ends_with(".toml") || is_yaml(name);
    if !path.exists() && !looks_like_path {
        let near = nearest(name, embedded.iter().map(|f| f.name));
        let near = near.map_or(String::new(), |n| format!("did you mean `{n}`? "));
        let known = names(embedded);
        let message = format!("no {kind} `{name}`; {near}known: {known}; or give a TOML file");
        return Err(Failure::new(Exit::Usage, message));
    }
    let text = read_text(&path).or_exit(Exit::Usage, path.display())?;
    let folder = path.parent().map(Path::to_path_buf);
    Ok(Text { origin: path.display().to_string(), folder, text })
}

/// Reads a text file that is small enough for a configuration.
fn read_text(path: &Path) -> anyhow::Result<String> {
    let mut bytes = Vec::new();
    File::open(path)?.take(TEXT_MAX as u64 + 1).read_to_end(&mut bytes)?;
    String::from_utf8(bytes).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        anyhow::anyhow!("byte {at} is not UTF-8: this is no configuration file")
    })
}

/// Names the file that a configuration error is about.
pub trait ConfigUsage<T> {
    /// Exit code 2, and `origin: error`.
    fn usage(self, origin: &str) -> Result<T, Failure>;
}

impl<T> ConfigUsage<T> for Result<T, ConfigError> {
    fn usage(self, origin: &str) -> Result<T, Failure> {
        self.map_err(|e| Failure::new(Exit::Usage, format!("{origin}: {e}")))
    }
}
