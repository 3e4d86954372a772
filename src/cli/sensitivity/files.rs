//! The files of a machine as text: changed as TOML, read again and checked.

use toml::{Table, Value};

use crate::cli::machine_file::LoadedMachine;
use crate::cli::what_if::Variant;
use powergs_base::config::assumptions::{Knob, KnobFile};
use powergs_base::config::embedded::{DRAM, ENERGY, MACHINES, find};
use powergs_base::config::knob;
use powergs_core::accel::Machine;
use powergs_core::dram::Device;
use powergs_core::energy::EnergyTable;
use powergs_core::sim;

/// The three files of a machine, as text.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Files {
    machine: String,
    energy: String,
    device: String,
}

impl Files {
    /// Those of `loaded` with further `--set` values; another energy table or device must be one
    /// that comes with the program.
    ///
    /// # Errors
    /// Why that is no machine, in one line.
    pub fn of(loaded: &LoadedMachine, with: &[String]) -> Result<Files, String> {
        let machine = Machine::parse_with(&loaded.resolved_toml, with).map_err(one_line)?;
        let other = |kind: &str, name: &str, files| {
            let text = find(files, name).map(str::to_owned);
            text.ok_or_else(|| format!("no {kind} `{name}` comes with the program"))
        };
        let energy = match machine.energy == loaded.machine.energy {
            true => loaded.energy_toml.clone(),
            false => other("energy table", &machine.energy, ENERGY)?,
        };
        let device = match machine.dram.device == loaded.machine.dram.device {
            true => loaded.device_file.text.clone(),
            false => other("DRAM device", &machine.dram.device, DRAM)?,
        };
        Ok(Files { machine: machine.to_toml(), energy, device })
    }

    /// Those of another machine, which comes with the program.
    ///
    /// # Errors
    /// As [`Files::of`].
    pub fn of_other(name: &str, with: &[String]) -> Result<Files, String> {
        let text = find(MACHINES, name);
        let text = text.ok_or_else(|| format!("no machine `{name}` comes with the program"))?;
        let machine = Machine::parse_with(text, with).map_err(one_line)?;
        let text = |files, name: &str| {
            let text = find(files, name).map(str::to_owned);
            text.ok_or_else(|| format!("no file `{name}` comes with the program"))
        };
        let energy = text(ENERGY, &machine.energy)?;
        let device = text(DRAM, &machine.dram.device)?;
        Ok(Files { machine: machine.to_toml(), energy, device })
    }

    fn text_mut(&mut self, file: KnobFile) -> &mut String {
        match file {
            KnobFile::Machine => &mut self.machine,
            KnobFile::Energy => &mut self.energy,
            KnobFile::Dram => &mut self.device,
        }
    }

    /// A file as a table.
    pub fn table(&self, file: KnobFile) -> Table {
        let text = match file {
            KnobFile::Machine => &self.machine,
            KnobFile::Energy => &self.energy,
            KnobFile::Dram => &self.device,
        };
        text.parse().unwrap_or_default()
    }

    /// The files with some keys set. Another `energy` or `dram.device` of the machine must be a
    /// name that comes with the program.
    ///
    /// # Errors
    /// A name that is unknown.
    pub fn with(&self, values: &[(KnobFile, &str, &Value)]) -> Result<Files, String> {
        let mut files = self.clone();
        // The machine first: it may bring other files.
        for file in KnobFile::ALL {
            let mut table = None;
            for (_, key, value) in values.iter().filter(|v| v.0 == file) {
                let table = table.get_or_insert_with(|| files.table(file));
                let old = knob::values(table, key).pop();
                if file == KnobFile::Machine && old.as_ref() != Some(value) {
                    files.bring(key, value)?;
                }
                knob::change(table, key, &mut |_| Some((*value).clone()));
            }
            if let Some(table) = table {
                *files.text_mut(file) = table.to_string();
            }
        }
        Ok(files)
    }

    /// The file that a key of the machine names.
    fn bring(&mut self, key: &str, value: &Value) -> Result<(), String> {
        let (files, text) = match key {
            "energy" => (ENERGY, &mut self.energy),
            "dram.device" => (DRAM, &mut self.device),
            _ => return Ok(()),
        };
        let name = knob::shown(value);
        let found = find(files, &name);
        *text = found.ok_or_else(|| format!("no file `{name}` comes with the program"))?.to_owned();
        Ok(())
    }

    /// What the files have at the keys of `knob`, numbers or names, each once.
    pub fn values(&self, knob: &Knob) -> Vec<String> {
        let table = self.table(knob.file);
        let all = knob.keys.iter().flat_map(|key| knob::values(&table, key));
        let mut shown: Vec<String> = all.map(|v| knob::shown(&v)).collect();
        shown.dedup();
        shown
    }

    /// The files with every key of `knob` changed, and the values that came out, each once. A key
    /// whose value cannot be changed (a price that is zero) stays.
    pub fn turned(
        &self,
        knob: &Knob,
        mut to: impl FnMut(&Value) -> Option<Value>,
    ) -> Option<(Files, Vec<String>)> {
        let mut files = self.clone();
        let mut table: Table = files.text_mut(knob.file).parse().ok()?;
        let mut shown = Vec::new();
        for key in &knob.keys {
            knob::change(&mut table, key, &mut |value| {
                let new = to(value)?;
                shown.push(knob::shown(&new));
                Some(new)
            });
        }
        shown.dedup();
        *files.text_mut(knob.file) = table.to_string();
        (!shown.is_empty()).then_some((files, shown))
    }

    /// The machine of these files with its prices.
    ///
    /// # Errors
    /// Why they are none, in one line.
    pub fn variant(&self) -> Result<Variant, String> {
        let mut machine = Machine::parse(&self.machine).map_err(one_line)?;
        let device = Device::parse(&self.device).map_err(one_line)?;
        machine.link(&device).map_err(|(_, message)| message)?;
        let table = EnergyTable::parse(&self.energy).map_err(one_line)?;
        let prices = sim::cost::prices(&table, &machine).map_err(one_line)?;
        Ok(Variant { machine, prices })
    }
}

/// An error without its place in a file that nobody has.
fn one_line(error: impl std::fmt::Display) -> String {
    let text = error.to_string();
    let lines = text.lines().map(str::trim).filter(|l| !l.is_empty() && !l.contains('|'));
    let without_place = |line: &str| {
        let rest = line.strip_prefix("line ").and_then(|l| l.split_once(": "));
        rest.map_or(line, |(_, what)| what).to_owned()
    };
    lines.map(without_place).collect::<Vec<_>>().join(" ")
}
