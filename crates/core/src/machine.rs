//! The machine file: every key that an architect can turn.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashSet};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::flow::{self, Dataflow, Tables};
use crate::stage;
use powergs_base::config::document::Document;
use powergs_base::config::embedded::{DRAM, MACHINES};
use powergs_base::config::{self, ConfigError, Place, Problem, layer, schema_of};
use powergs_base::quantity::{BytesPerSecond, Hertz};
use powergs_dram::Device;
use powergs_dram::device::Order;
use powergs_energy::action::{Inventory, Memory};

pub mod check;
mod exclusion;
pub(crate) mod optional;
mod reference;

pub use crate::kernel::masters::MASTERS;
pub use crate::kernel::spec::{
    AccessOrder, BufferSpec, DramModel, DramSpec, External, MasterSpec, MemoryOwner, NO_DEVICE,
    Ports, Priority,
};
pub use exclusion::{Exclusion, KeyValues};
pub use optional::{Optional, without_key};
pub use reference::Reference;

/// The `[gating]` table: power gating; without it there is none.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct GatingSpec {
    /// Whether units without work are switched off.
    pub units: bool,
    /// Share of its leakage that a unit keeps when it is switched off, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0), extend("x-unit" = "fraction"))]
    pub residual: f64,
}

impl Default for GatingSpec {
    /// None; what is left where units are switched off (A38).
    fn default() -> GatingSpec {
        GatingSpec { units: false, residual: 0.1 }
    }
}

/// A machine as written in `arch-configs/machines/*.toml`, checked: everything in it fits together.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Name in reports: letters, digits, `-`, `_` and `.`.
    pub name: String,
    /// What it is, in one line.
    pub description: String,
    /// Clock of all units.
    pub clock: Hertz,
    /// Name of the energy table (`arch-configs/energy/NAME.toml`) or path of one.
    pub energy: String,
    /// The tables of its dataflow.
    pub tables: Tables,
    /// What is switched off while it has no work.
    pub gating: GatingSpec,
    /// External memory.
    pub dram: DramSpec,
    /// The device of `dram.device`, with this machine's channels, mapping and latency; known where
    /// it comes with the program, or after [`Machine::link`]. `None` for `dram.device = "none"`.
    pub device: Option<Arc<Device>>,
}

/// What is in the files of all machines.
#[derive(Debug, Clone, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct CommonKeys {
    /// Name in reports: letters, digits, `-`, `_` and `.`.
    name: String,
    /// What it is, in one line.
    description: String,
    /// How Gaussians become pixels: which tables the file has, and which stages the machine.
    #[serde(default = "default_flow")]
    dataflow: String,
    /// Clock of all units.
    clock: Hertz,
    /// Name of the energy table (`arch-configs/energy/NAME.toml`) or path of one.
    energy: String,
    /// What is switched off while it has no work.
    #[serde(default)]
    gating: GatingSpec,
    /// External memory.
    dram: DramSpec,
}

fn default_flow() -> String {
    flow::DEFAULT.to_owned()
}

/// Those of its keys that are told behind the tables of the dataflow.
const BEHIND: [&str; 2] = ["gating", "dram"];

impl CommonKeys {
    /// Its keys, in order.
    fn keys() -> &'static [String] {
        static KEYS: LazyLock<Vec<String>> = LazyLock::new(|| {
            let schema = schema_of::<CommonKeys>();
            let keys = schema["properties"].as_object().map(|keys| keys.keys().cloned().collect());
            keys.unwrap_or_default()
        });
        &KEYS
    }
}

/// The dataflow that a table names.
fn flow_of(table: &DeTable<'_>) -> Result<&'static dyn Dataflow, String> {
    match table.get("dataflow").map(Spanned::get_ref) {
        Some(DeValue::String(name)) => flow::named(name),
        // Of another type: the schema says so.
        Some(_) | None => flow::named(flow::DEFAULT),
    }
}

/// The schema of machine files of some dataflows: what all have, with the tables of each between.
fn schema(flows: &[&dyn Dataflow]) -> Value {
    let mut schema = schema_of::<CommonKeys>();
    let mut required = required(&schema);
    let common = schema["properties"].as_object().cloned().unwrap_or_default();
    let is_behind = |key: &String| BEHIND.contains(&key.as_str());
    let mut keys: Map<String, Value> = common
        .iter()
        .filter(|(key, _)| !is_behind(key))
        .map(|(k, v)| (k.clone(), v.clone()))
        .collect();
    for flow in flows {
        let own = (flow.tables().schema)();
        for (key, table) in own["properties"].as_object().into_iter().flatten() {
            let known = keys.entry(key.clone()).or_insert_with(|| table.clone());
            // Of a table that several dataflows have, all keys: what they share means the same.
            let more = table["properties"].as_object().cloned().unwrap_or_default();
            if let Some(all) = known["properties"].as_object_mut() {
                more.into_iter().for_each(|(key, own)| _ = all.entry(key).or_insert(own));
            }
        }
        if flows.len() == 1 {
            required.extend(self::required(&own));
        }
    }
    keys.extend(common.into_iter().filter(|(key, _)| is_behind(key)));
    keys["dataflow"]["enum"] = flow::all().map(|flow| flow.key()).collect::<Vec<_>>().into();
    // As the keys stand in the file.
    let order: Vec<&String> = keys.keys().collect();
    required.sort_by_key(|key| order.iter().position(|known| *known == key));
    schema["properties"] = Value::Object(keys);
    schema["required"] = required.into();
    if let [flow] = flows {
        // For those who write a table of another dataflow.
        let others = flow::all().filter(|other| other.key() != flow.key());
        let tables = others.flat_map(|other| {
            let own = (other.tables().schema)();
            let own = own["properties"].as_object().cloned().unwrap_or_default();
            own.into_iter().map(|(table, _)| (table, other.key()))
        });
        let elsewhere = tables.map(|(table, other)| {
            let why = format!(
                "it is of machines with `dataflow = \"{other}\"`, and this one has \"{}\"",
                flow.key()
            );
            (table, Value::String(why))
        });
        schema[config::ELSEWHERE] = Value::Object(elsewhere.collect());
    }
    schema["title"] = "Machine".into();
    schema["description"] =
        "A machine as written in `arch-configs/machines/*.toml`, checked: everything in it fits \
                             together."
            .into();
    schema
}

fn required(schema: &Value) -> Vec<String> {
    let keys = schema.get("required").and_then(Value::as_array).into_iter().flatten();
    keys.filter_map(Value::as_str).map(str::to_owned).collect()
}

impl JsonSchema for Machine {
    fn schema_name() -> Cow<'static, str> {
        "Machine".into()
    }

    /// With the tables of all dataflows.
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let flows: Vec<&dyn Dataflow> = flow::all().collect();
        Schema::try_from(schema(&flows)).expect("an object is a schema")
    }
}

impl Document for Machine {
    /// Made once for each dataflow.
    fn schema(table: &DeTable<'_>) -> Result<Arc<Value>, (&'static str, String)> {
        static KNOWN: Mutex<BTreeMap<&str, Arc<Value>>> = Mutex::new(BTreeMap::new());
        let flow = flow_of(table).map_err(|message| ("dataflow", message))?;
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(known.entry(flow.key()).or_insert_with(|| Arc::new(schema(&[flow]))).clone())
    }

    fn read(table: Spanned<DeTable<'_>>) -> Result<Machine, toml::de::Error> {
        let flow = flow_of(table.get_ref()).map_err(serde::de::Error::custom)?;
        let span = table.span();
        let (mut common, mut tables) = (DeTable::new(), DeTable::new());
        for (key, value) in table.into_inner() {
            let is_common = CommonKeys::keys().iter().any(|known| *known == **key.get_ref());
            let to = if is_common { &mut common } else { &mut tables };
            to.insert(key, value);
        }
        let common = toml::Deserializer::from(Spanned::new(span.clone(), common));
        let common = CommonKeys::deserialize(common)?;
        Ok(Machine::of(common, (flow.tables().read)(Spanned::new(span, tables))?))
    }
}

impl Serialize for Machine {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        self.table().serialize(to)
    }
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
    let mut added: Vec<String> = Vec::new();
    let mut problems = problems.to_vec();
    for _ in 0..REMEDY_ROUNDS {
        for problem in &problems {
            let all = problem.remedies.iter().map(|(key, value)| (*key, format!("{key}={value}")));
            if all.clone().any(|(_, set)| added.contains(&set)) {
                continue;
            }
            // What was asked for stays.
            let Some((key, set)) = all.clone().find(|(key, _)| !fixed.contains(*key)) else {
                return Vec::new();
            };
            fixed.insert(key.to_owned());
            added.push(set);
        }
        let all = [sets, &added[..]].concat();
        let Ok(config) = config::parse::<Machine>(text, &all) else { return Vec::new() };
        problems = check::problems(&config.value);
        if problems.is_empty() {
            return added;
        }
    }
    Vec::new()
}

/// Keys that were set and say what has been done already.
fn fixed(config: &config::Config<Machine>) -> Vec<Problem> {
    let set = config.stated().filter(|(_, place)| matches!(place, Place::Set(_)));
    let why = |key| config.value.flow().fixed(key).map(|message| config.problem(key, message));
    set.filter_map(|(key, _)| why(key)).collect()
}

/// The error of a machine whose dataflow was set: it has the tables of the old one.
fn of_other_flow(error: ConfigError, sets: &[String]) -> ConfigError {
    let set = sets.iter().rev().find_map(|set| Some((set, set.split_once('=')?)));
    let Some((set, ("dataflow", name))) = set.map(|(s, (k, v))| (s, (k.trim(), v.trim()))) else {
        return error;
    };
    let Ok(flow) = flow::named(name.trim_matches('"')) else { return error };
    let file = flow::example(flow).map_or(String::new(), |file| format!(", as `{}`", file.name));
    let message = format!(
        "a machine of another dataflow has other tables: take one with `{name}`{file}, in place of \
         this one"
    );
    let place = Place::Set(set.clone());
    ConfigError::new(vec![Problem { place, key: "dataflow".into(), message }])
}

impl Machine {
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
        let config = config::parse::<Machine>(text, sets).map_err(|e| of_other_flow(e, sets))?;
        let mut strays = optional::strays(&config);
        strays.extend(fixed(&config));
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
        let mut machine = Machine::read_table(table).map_err(|e| e.message().to_owned())?;
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

    /// Paths of the tables that a file may leave out, or set to `"none"`, of every dataflow.
    pub fn optional_tables() -> Vec<String> {
        let of = |flow: &'static dyn Dataflow| config::schema::optional_tables(&schema(&[flow]));
        flow::all().flat_map(of).collect()
    }

    /// Takes over from the machine that this one is a variant of what no file has: a run that was
    /// made elsewhere.
    ///
    /// # Errors
    /// A variant that there cannot be, and why.
    pub fn keep(&mut self, old: &Machine) -> Result<(), String> {
        if self.flow().key() == old.flow().key() { self.flow().keep(self, old) } else { Ok(()) }
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
        check::taken(self).or_else(|| check::beyond_pattern(self)).map_or(Ok(()), Err)
    }

    /// Its external memory.
    ///
    /// # Panics
    /// As [`Machine::dram_peak`].
    pub fn memory(&self) -> External<'_> {
        let (device, peak) = (self.device.as_deref(), self.dram_peak());
        External { spec: &self.dram, device, peak, clock: self.clock }
    }

    /// Peak rate of its external memory: that of the device with this machine's channels, or the
    /// one of `dram.bandwidth` where there is no device, or that of its dataflow's own tables.
    ///
    /// # Panics
    /// When the machine names a device and [`Machine::link`] was never called.
    pub fn dram_peak(&self) -> BytesPerSecond {
        match (&self.device, self.dram.bandwidth) {
            (Some(device), _) => BytesPerSecond(device.peak_gb_s() * 1e9),
            (None, Some(bandwidth)) => bandwidth,
            (None, None) => {
                let own = self.flow().memory_rate(self);
                own.expect("a machine is linked to its DRAM device")
            }
        }
    }

    fn of(common: CommonKeys, tables: Tables) -> Machine {
        let CommonKeys { name, description, dataflow: _, clock, energy, gating, dram } = common;
        Machine { name, description, clock, energy, tables, gating, dram, device: None }
    }

    /// The machine of a table that has been held against the schema.
    fn read_table(table: toml::Table) -> Result<Machine, toml::de::Error> {
        let name = table.get("dataflow").and_then(toml::Value::as_str);
        let flow = flow::named(name.unwrap_or(flow::DEFAULT)).map_err(serde::de::Error::custom)?;
        let is_common = |key: &str| CommonKeys::keys().iter().any(|known| known == key);
        let (common, tables): (toml::Table, toml::Table) =
            table.into_iter().partition(|(key, _)| is_common(key));
        let common = CommonKeys::deserialize(toml::Value::Table(common))?;
        Ok(Machine::of(common, (flow.tables().read_plain)(tables)?))
    }

    /// Its dataflow.
    pub fn flow(&self) -> &'static dyn Dataflow {
        self.tables.flow()
    }

    /// A table of its dataflow, by its type.
    ///
    /// # Panics
    /// When the dataflow has no such table.
    pub fn of_type<T: 'static>(&self) -> &T {
        self.tables.get().expect("a machine has the tables of its stages")
    }

    /// What a key has where a file of this machine says nothing of it; `None` where one must.
    pub fn default_of(&self, key: &str) -> Option<toml::Value> {
        let without = optional::without_key(self.table(), key);
        let machine = Machine::read_table(without).ok()?;
        config::knob::values(&machine.table(), key).pop()
    }

    /// Every key, overlays applied.
    pub fn table(&self) -> toml::Table {
        let common = CommonKeys {
            name: self.name.clone(),
            description: self.description.clone(),
            dataflow: self.flow().key().to_owned(),
            clock: self.clock,
            energy: self.energy.clone(),
            gating: self.gating.clone(),
            dram: self.dram.clone(),
        };
        let common = toml::Table::try_from(common);
        let mut table = common.expect("a machine has only tables, numbers and strings");
        let behind = BEHIND.map(|key| table.remove_entry(key));
        table.extend(self.tables.to_toml());
        table.extend(behind.into_iter().flatten());
        table
    }

    /// Every key that has an effect, overlays applied.
    pub fn stated(&self) -> toml::Table {
        let mut table = self.table();
        optional::leave_out(&mut table, self);
        table
    }

    /// The machine as TOML, as [`Machine::stated`], no comments.
    pub fn to_toml(&self) -> String {
        self.stated().to_string()
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
        self.flow().inventory(self)
    }

    /// What its stages declare of that.
    pub(crate) fn declared(&self) -> Inventory {
        let all = || stage::stages().iter().map(|stage| (stage, self.has_stage(stage.key)));
        let memories = all().flat_map(|(s, has)| s.buffers.iter().map(move |b| (b, has)));
        let parts = all().flat_map(|(s, has)| s.parts.iter().map(move |p| (p, has)));
        Inventory {
            memories: memories
                .map(|(b, has)| if has { (b.memory)(self) } else { Memory::default() })
                .collect(),
            units: all().map(|(s, _)| s.count(self)).collect(),
            parts: parts.map(|(p, has)| if has { (p.amount)(self) } else { 0.0 }).collect(),
        }
    }

    /// Keys of it that contradict each other: none of a machine that was read.
    pub fn contradictions(&self) -> Vec<check::Contradiction> {
        check::problems(self)
    }

    /// Whether its dataflow has a stage.
    pub fn has_stage(&self, key: &str) -> bool {
        self.flow().stages().iter().any(|stage| stage.key == key)
    }
}
