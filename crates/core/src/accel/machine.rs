//! The machine file: every key that an architect can turn.

use std::collections::{BTreeMap, HashSet};
use std::sync::{Arc, LazyLock};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::rules::UnitRules;
use crate::stage;
use crate::workload::Geometry;
use crate::workload::binning::ListShape;
use powergs_base::config::embedded::{DRAM, MACHINES};
use powergs_base::config::{self, ConfigError, layer};
use powergs_base::quantity::{Bytes, BytesPerSecond, Hertz};
use powergs_dram::Device;
use powergs_dram::device::Order;
use powergs_energy::action::{Inventory, Memory};

mod check;
mod optional;
mod spec;

pub use optional::{OPTIONAL, Optional};
pub use spec::{
    AccessOrder, Assignment, BinningMethod, BinningSpec, BufferSpec, BufferSpecs, CacheSpec,
    CcuOperations, CcuSpec, CodebookSpec, DepthKey, DramModel, DramSpec, Eviction, FeatureSource,
    Fetch, FoveaSpec, GatingSpec, GsuSpec, NO_DEVICE, Organisation, Overlap, PartialWrite,
    PivotRule, Ports, RecordSpec, ScheduleSpec, SecondMasterSpec, Spill, Switch, Termination,
    TileOrder, VruSpec,
};

/// A machine as written in `arch-configs/machines/*.toml`, checked: everything in it fits together.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Machine {
    /// Name in reports: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// What it is, in one line.
    pub description: String,
    /// Clock of all units.
    pub clock: Hertz,
    /// Name of the energy table (`arch-configs/energy/NAME.toml`) or path of one.
    pub energy: String,
    /// What decides the work: tile, sub-tile, chunk, intersection test.
    pub geometry: Geometry,
    /// Bytes of every record that crosses the DRAM interface.
    pub record: RecordSpec,
    /// Colours that records name by a number.
    #[serde(default)]
    pub codebook: CodebookSpec,
    /// Culling and conversion units.
    pub ccu: CcuSpec,
    /// Gaussian sorting units.
    pub gsu: GsuSpec,
    /// Volume rendering units.
    pub vru: VruSpec,
    /// What it has for foveated frames.
    #[serde(default)]
    pub fovea: FoveaSpec,
    /// On-chip buffers.
    pub buffers: BufferSpecs,
    /// How pairs get into the lists of tiles.
    #[serde(default)]
    pub binning: BinningSpec,
    /// Cache of feature records between the feature buffers and the DRAM.
    #[serde(default)]
    pub cache: CacheSpec,
    /// Which tile goes where, and what may overlap.
    pub schedule: ScheduleSpec,
    /// What is switched off while it has no work.
    #[serde(default)]
    pub gating: GatingSpec,
    /// External memory.
    pub dram: DramSpec,
    /// The device of `dram.device`, with this machine's channels, mapping and latency; known where
    /// it comes with the program, or after [`Machine::link`]. `None` for `dram.device = "none"`.
    #[serde(skip)]
    #[schemars(skip)]
    pub device: Option<Arc<Device>>,
    /// Timing rules of units; all built in unless a program replaces them. Not in the file.
    #[serde(skip)]
    #[schemars(skip)]
    pub rules: UnitRules,
}

/// Rounds in which one remedy may bring up the next contradiction.
const REMEDY_ROUNDS: usize = 8;

/// The changes that end `problems` of a machine with `sets`, and all that they bring up themselves;
/// empty where nobody asked for a change, a remedy is not plain, or it would undo what was asked.
fn together(text: &str, sets: &[String], problems: &[check::Contradiction]) -> Vec<String> {
    let key_of = |set: &str| set.split('=').next().unwrap_or_default().trim().to_owned();
    let mut fixed: HashSet<String> = sets.iter().map(|set| key_of(set)).collect();
    if fixed.is_empty() {
        return Vec::new();
    }
    let remedies = |problems: &[check::Contradiction]| -> Option<Vec<(String, String)>> {
        let remedies = problems.iter().map(|p| p.remedy.clone());
        remedies.map(|r| r.map(|(key, value)| (key.to_owned(), value))).collect()
    };
    let mut added: Vec<String> = Vec::new();
    let mut wanted = remedies(problems);
    for _ in 0..REMEDY_ROUNDS {
        for (key, value) in wanted.take().unwrap_or_default() {
            let set = format!("{key}={value}");
            if !added.contains(&set) {
                if !fixed.insert(key) {
                    return Vec::new();
                }
                added.push(set);
            }
        }
        let all = [sets, &added[..]].concat();
        let Ok(config) = config::parse::<Machine>(text, &all) else { return Vec::new() };
        let problems = check::problems(&config.value);
        if problems.is_empty() {
            return added;
        }
        wanted = remedies(&problems);
        if wanted.is_none() {
            return Vec::new();
        }
    }
    Vec::new()
}

impl Machine {
    /// Bytes of a list entry: depth, number of the splat, bitmap and distance to its next tile, in
    /// whole bytes.
    pub fn list_entry(&self) -> u64 {
        let subtiles = self.geometry.tile / self.geometry.subtile.max(1);
        let bitmap = if self.record.entry_bitmap { u64::from(subtiles).pow(2) } else { 0 };
        let bits = u64::from(self.record.depth_bits) + u64::from(self.record.id_bits) + bitmap;
        (bits + u64::from(self.cache.carried_bits())).div_ceil(8)
    }

    /// How its lists are made; `None` where they are there for nothing.
    pub fn list_shape(&self) -> Option<ListShape> {
        let b = &self.binning;
        let block = match b.method {
            BinningMethod::Free => return None,
            BinningMethod::Append => Some(b.block.0),
            BinningMethod::TwoPass => None,
        };
        Some(ListShape {
            entry: self.list_entry(),
            pointer: b.pointer_size.0,
            pointers: b.pointers.capacity.0 / b.pointer_size.0.max(1),
            line: b.line.0,
            lines: b.combining.capacity.0 / b.line.0.max(1),
            merges: b.partial == PartialWrite::ReadModifyWrite,
            block,
        })
    }

    /// Reads and checks a machine file.
    ///
    /// # Errors
    /// Everything that is wrong with it, each with its line; see [`config::parse`].
    pub fn parse(text: &str) -> Result<Machine, ConfigError> {
        Machine::parse_with(text, &[])
    }

    /// Reads and checks a machine file with `dotted.key=value` overlays on top.
    ///
    /// # Errors
    /// As [`Machine::parse`]; a problem of an overlay names the overlay.
    pub fn parse_with(text: &str, sets: &[String]) -> Result<Machine, ConfigError> {
        let text = &layer::on_embedded(text, MACHINES)?;
        let config = config::parse::<Machine>(text, sets)?;
        let strays = optional::strays(&config);
        if !strays.is_empty() {
            return config.checked(strays);
        }
        let problems = check::problems(&config.value);
        if !problems.is_empty() {
            let remedy = together(text, sets, &problems);
            let problems = problems.into_iter().map(|p| config.problem(p.key, p.message));
            return Err(ConfigError { remedy, ..ConfigError::new(problems.collect()) });
        }
        let mut machine = config.value.clone();
        if let Some(device) = embedded_device(&machine.dram.device)
            && let Err((key, message)) = machine.link(device)
        {
            let problem = config.problem(key, message);
            return config.checked(vec![problem]);
        }
        Ok(machine)
    }

    /// A machine from a table of all its keys, each of the right type and in its range, with its
    /// DRAM device if it names one. Faster than [`Machine::parse`]: for thousands of machines that
    /// differ in a few keys.
    ///
    /// # Errors
    /// What does not fit together, in one line.
    pub fn from_table(table: toml::Table, device: Option<&Device>) -> Result<Machine, String> {
        let machine = Machine::deserialize(toml::Value::Table(table));
        let mut machine = machine.map_err(|e| e.message().to_owned())?;
        let problems = check::problems(&machine);
        if !problems.is_empty() {
            let messages: Vec<String> = problems.into_iter().map(|p| p.message).collect();
            return Err(messages.join("; "));
        }
        if let Some(device) = device {
            machine.link(device).map_err(|(_, message)| message)?;
        }
        Ok(machine)
    }

    /// Gives the machine its DRAM device, as the file says it. A `dram.bandwidth` that says the
    /// same as the device is forgotten: later changes of the channels need not repeat it.
    ///
    /// # Errors
    /// A key of the machine that does not fit the device, and why.
    pub fn link(&mut self, device: &Device) -> Result<(), (&'static str, String)> {
        let mut device = device.clone();
        let spec = &self.dram;
        device.organisation.channels = spec.channels;
        device.controller.latency = spec.controller_latency;
        if !spec.channels.is_power_of_two() {
            let message = format!("`dram.channels` = {} must be a power of two", spec.channels);
            return Err(("dram.channels", message));
        }
        if spec.mapping != Order::Fields {
            let message = |e| format!("`dram.mapping` does not fit `dram.device`: {e}");
            device = device.with_order(spec.mapping).map_err(|e| ("dram.mapping", message(e)))?;
        } else if device.mapping.fields.is_none() {
            let message = "`dram.mapping` = \"fields\", but the device has no `mapping.fields`";
            return Err(("dram.mapping", message.to_owned()));
        }
        if spec.model != DramModel::Bandwidth && self.clock.0 < 1e6 {
            let message = "`clock` must be at least 1 MHz with a timed DRAM device".to_owned();
            return Err(("clock", message));
        }
        if let Some(bandwidth) = spec.bandwidth {
            let peak = BytesPerSecond(device.peak_gb_s() * 1e9);
            if (bandwidth.0 - peak.0).abs() > SAME_RATE * peak.0 {
                let message = format!(
                    "`dram.bandwidth` = {bandwidth} contradicts `dram.device` = \"{}\" with \
                     `dram.channels` = {}, which have {peak}: leave `dram.bandwidth` out and set \
                     `dram.channels` or another device, or have a mere rate with `dram.device` = \
                     \"{NO_DEVICE}\"",
                    spec.device, spec.channels
                );
                return Err(("dram.bandwidth", message));
            }
            self.dram.bandwidth = None;
        }
        self.device = Some(Arc::new(device));
        match check::taken(self) {
            Some(message) => Err(("dram.second-master.rate", message)),
            None => Ok(()),
        }
    }

    /// Share of its external memory that the second master takes in the `bandwidth` model, 0 to 1.
    ///
    /// # Panics
    /// As [`Machine::dram_peak`].
    pub(crate) fn second_master_share(&self) -> f64 {
        self.dram.second_master.share(self.dram_peak().0)
    }

    /// Peak rate of its external memory: that of the device with this machine's channels, or the
    /// one of `dram.bandwidth` where there is no device.
    ///
    /// # Panics
    /// When the machine names a device and [`Machine::link`] was never called.
    pub fn dram_peak(&self) -> BytesPerSecond {
        match (&self.device, self.dram.bandwidth) {
            (Some(device), _) => BytesPerSecond(device.peak_gb_s() * 1e9),
            (None, Some(bandwidth)) => bandwidth,
            (None, None) => panic!("a machine is linked to its DRAM device"),
        }
    }

    /// Every key that has an effect, overlays applied.
    pub fn stated(&self) -> toml::Table {
        let table = toml::Table::try_from(self);
        let mut table = table.expect("a machine has only tables, numbers and strings");
        optional::leave_out(&mut table, self);
        table
    }

    /// The machine as TOML, as [`Machine::stated`], no comments.
    pub fn to_toml(&self) -> String {
        self.stated().to_string()
    }

    /// Bytes of pixel state that a core keeps in its share of the pixel buffer: that of a tile
    /// where its units change between sub-tiles, else none.
    pub fn state_bytes(&self) -> Bytes {
        let is_serial = self.vru.organisation == Organisation::SubtileSerial;
        let changes = is_serial && self.vru.switch != Switch::Free;
        if !changes || self.geometry.subtiles() == 1 {
            return Bytes(0);
        }
        let levels = u64::from(self.fovea.accumulators.max(1));
        let pixels = u64::from(self.geometry.tile).pow(2);
        Bytes(pixels.saturating_mul(levels).saturating_mul(self.vru.pixel_state.0))
    }
}

/// Rates that differ by less, relatively, are the same, written with fewer digits.
const SAME_RATE: f64 = 1e-3;

/// A device that comes with the program.
fn embedded_device(name: &str) -> Option<&'static Device> {
    static DEVICES: LazyLock<BTreeMap<&str, Device>> = LazyLock::new(|| {
        let parse = |text| Device::parse(text).expect("embedded files are checked by tests");
        DRAM.iter().map(|file| (file.name, parse(file.text))).collect()
    });
    DEVICES.get(name)
}

impl Machine {
    /// What has to be built: memories, units, and how much of each part they have.
    pub fn inventory(&self) -> Inventory {
        let stages = || stage::stages().iter();
        Inventory {
            memories: stages().flat_map(|s| s.buffers).map(|b| (b.memory)(self)).collect(),
            units: stages().map(|s| s.count(self)).collect(),
            parts: stages().flat_map(|s| s.parts).map(|p| (p.amount)(self)).collect(),
        }
    }
}

impl BufferSpec {
    /// How it is built for so many CCUs or cores: each has its own share, cut into `banks` banks
    /// (A13).
    pub(crate) fn shared(&self, owners: u32) -> Memory {
        Memory {
            bank: Bytes(self.capacity.0 / (u64::from(owners) * u64::from(self.banks)).max(1)),
            banks: owners.saturating_mul(self.banks),
            word: self.word,
            two_ports: self.ports == Ports::ReadAndWrite,
        }
    }
}
