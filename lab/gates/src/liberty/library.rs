//! What a library says of its cells: functions, capacitances, transition and power tables, leakage.

use std::collections::BTreeMap;

use super::LibertyError;
use super::table::{Axis, Table};
use super::tree::{self, Group};
use crate::function::{Function, Step};

/// Cells of one or several Liberty files of the same library.
#[derive(Debug)]
pub struct Library {
    /// Supply, V.
    pub voltage: f64,
    /// Name of the operating conditions, with temperature.
    pub corner: String,
    /// Wires that are not laid out; `None` where the library has no model of them.
    pub wires: Option<WireLoad>,
    /// Cells by name.
    pub cells: BTreeMap<String, Cell>,
}

/// A wire-load model: length by fan-out, capacitance by length.
#[derive(Debug, Clone, PartialEq)]
pub struct WireLoad {
    /// Name in the library.
    pub name: String,
    /// fF for a unit of length.
    pub capacitance: f64,
    /// Length for every further load beyond the table.
    pub slope: f64,
    /// Length by number of loads, ascending.
    pub lengths: Vec<(u32, f64)>,
}

impl WireLoad {
    /// Capacitance of a wire to `loads` pins, fF.
    pub fn capacitance(&self, loads: u32) -> f64 {
        let next = self.lengths.partition_point(|(fanout, _)| *fanout < loads);
        let length = match (next.checked_sub(1).map(|i| self.lengths[i]), self.lengths.get(next)) {
            _ if loads == 0 => 0.0,
            (_, Some((fanout, length))) if *fanout == loads => *length,
            (Some((f0, l0)), Some((f1, l1))) => {
                l0 + (l1 - l0) * f64::from(loads - f0) / f64::from(f1 - f0)
            }
            (None, Some((fanout, length))) => length * f64::from(loads) / f64::from(*fanout),
            (Some((fanout, length)), None) => length + self.slope * f64::from(loads - fanout),
            (None, None) => self.slope * f64::from(loads),
        };
        length * self.capacitance
    }
}

/// A cell.
#[derive(Debug)]
pub struct Cell {
    /// Area, um².
    pub area: f64,
    /// Mean leakage over the states of its inputs, nW.
    pub leakage: f64,
    /// Inputs in the order of the file.
    pub inputs: Vec<Input>,
    /// Outputs in the order of the file.
    pub outputs: Vec<Output>,
    /// What it stores.
    pub flip_flop: Option<FlipFlop>,
    /// What it lets through, if it is an integrated clock gate.
    pub clock_gate: Option<ClockGate>,
    /// Why it cannot be simulated, if it cannot.
    pub unsupported: Option<String>,
}

impl Cell {
    /// Which input is a clock.
    pub fn clock(&self) -> Option<usize> {
        let flip_flop = self.flip_flop.as_ref().map(|flip_flop| flip_flop.clock);
        flip_flop.or(self.clock_gate.as_ref().map(|gate| gate.clock))
    }
}

/// An integrated clock gate for rising edges: a latch that is open while the clock is low, and an
/// AND of what it holds and the clock.
#[derive(Debug)]
pub struct ClockGate {
    /// What the latch takes, of the inputs.
    pub enable: Function,
    /// Which input is the clock.
    pub clock: usize,
}

/// An edge-triggered bit: rising edge, neither cleared nor set asynchronously.
#[derive(Debug)]
pub struct FlipFlop {
    /// What it stores at the edge, of the inputs.
    pub next: Function,
    /// Which input is the clock.
    pub clock: usize,
}

/// An input pin.
#[derive(Debug)]
pub struct Input {
    /// Its name.
    pub name: String,
    /// Capacitance, fF.
    pub capacitance: f64,
    /// Energy of a toggle that reaches no output.
    pub powers: Vec<Power>,
}

/// An output pin.
#[derive(Debug)]
pub struct Output {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: Value,
    /// Transition times.
    pub arcs: Vec<Arc>,
    /// Energy of a toggle.
    pub powers: Vec<Power>,
}

/// What an output shows.
#[derive(Debug)]
pub enum Value {
    /// A function of the inputs.
    Gate(Function),
    /// The stored bit.
    State {
        /// Inverted.
        inverted: bool,
    },
    /// The clock where a clock gate lets it through.
    GatedClock,
    /// Not known.
    Unknown,
}

/// Which edge of the input an edge of the output follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sense {
    /// The same.
    Positive,
    /// The other.
    Negative,
    /// Either.
    Either,
    /// The rising one, of a clock.
    Rising,
}

/// Transition times and delays of an output behind one input.
#[derive(Debug)]
pub struct Arc {
    /// Which input.
    pub from: usize,
    /// Which of its edges.
    pub sense: Sense,
    /// Of the rising output, ns.
    pub rise: Option<Table>,
    /// Of the falling output, ns.
    pub fall: Option<Table>,
    /// Delay of the rising output, ns.
    pub delay_rise: Option<Table>,
    /// Delay of the falling output, ns.
    pub delay_fall: Option<Table>,
}

/// One group of internal power; energies in fJ.
#[derive(Debug)]
pub struct Power {
    /// Supply pin it is drawn from; energies of different ones add up, ground pins are left out.
    pub supply: String,
    /// The input that causes it, of an output's.
    pub from: Option<usize>,
    /// In which states of inputs, then outputs.
    pub when: Option<Function>,
    /// At a rising edge of the pin.
    pub rise: Option<Table>,
    /// At a falling edge of the pin.
    pub fall: Option<Table>,
}

/// Factors from units of the file to ns, fF, nW and fJ.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Units {
    time: f64,
    capacitance: f64,
    leakage: f64,
    energy: f64,
}

struct Reader<'a> {
    file: &'a str,
    units: Units,
    /// Ground pins of the cell that is read. Where a library states what both rails see, that is
    /// the same charge twice: a cycle's sum at the ground pin equals that at the supply pin.
    grounds: Vec<&'a str>,
    templates: BTreeMap<&'a str, Vec<(Axis, Vec<f64>)>>,
}

type Result<T> = std::result::Result<T, LibertyError>;

impl Library {
    /// Reads files of one library, `(name, text)` each.
    ///
    /// # Errors
    /// Where a text is no Liberty, where files contradict each other (supply, a cell twice), and
    /// where a library has no tables of internal power: energy cannot be had from it.
    pub fn parse(files: &[(&str, &str)]) -> Result<Library> {
        let mut library: Option<Library> = None;
        let mut with_power = false;
        for (file, text) in files {
            let root = tree::parse(file, text)?;
            let read = read_library(file, &root)?;
            let powers = |cell: &Cell| cell.outputs.iter().any(|pin| !pin.powers.is_empty());
            with_power |= read.cells.values().any(powers);
            let Some(whole) = &mut library else {
                library = Some(read);
                continue;
            };
            let refuse =
                |reason| LibertyError { file: (*file).to_owned(), line: root.line, reason };
            if whole.voltage != read.voltage {
                let (a, b) = (whole.voltage, read.voltage);
                return Err(refuse(format!("{b} V, but the files before are of {a} V")));
            }
            whole.wires = whole.wires.take().or(read.wires);
            for (name, cell) in read.cells {
                let reason = format!("cell {name} is in an earlier file too");
                if whole.cells.insert(name, cell).is_some() {
                    return Err(refuse(reason));
                }
            }
        }
        let file = files.first().map_or("", |(file, _)| file).to_owned();
        let refuse = |reason: &str| LibertyError { file, line: 0, reason: reason.to_owned() };
        match library {
            None => Err(refuse("no Liberty file is given")),
            Some(_) if !with_power => Err(refuse(
                "no cell has tables of internal power; take the library's power characterisation \
                 (NLDM or CCS with `internal_power`)",
            )),
            Some(library) => Ok(library),
        }
    }
}

fn read_library<'a>(file: &'a str, root: &'a Group<'a>) -> Result<Library> {
    let mut reader = Reader {
        file,
        units: Units { time: 1.0, capacitance: 1.0, leakage: 1.0, energy: 1.0 },
        grounds: Vec::new(),
        templates: BTreeMap::new(),
    };
    let voltage_attribute = root.attribute("nom_voltage");
    let Some(attribute) = voltage_attribute else {
        return Err(reader.refuse(root.line, "the library states no `nom_voltage`"));
    };
    let voltage = reader.number(attribute.line, attribute.values.first().copied())?;
    if !(0.05..=50.0).contains(&voltage) {
        return Err(reader.refuse(attribute.line, "a supply outside of 0.05 to 50 V"));
    }
    reader.units = reader.read_units(root)?;
    for template in &root.groups {
        if matches!(template.name, "lu_table_template" | "power_lut_template") {
            let axes = reader.template_axes(template)?;
            reader.templates.insert(template.arguments.first().copied().unwrap_or(""), axes);
        }
    }
    let mut cells = BTreeMap::new();
    for group in root.of("cell") {
        let name = group.arguments.first().copied().unwrap_or("").to_owned();
        let is_ground = |pin: &&Group| pin.value("pg_type").is_some_and(|t| t.contains("ground"));
        let grounds = group.of("pg_pin").filter(is_ground);
        reader.grounds = grounds.flat_map(|pin| pin.arguments.first().copied()).collect();
        let cell = reader.cell(group)?;
        if cells.insert(name.clone(), cell).is_some() {
            return Err(reader.refuse(group.line, &format!("cell {name} is there twice")));
        }
    }
    let conditions = root.value("default_operating_conditions").unwrap_or("nominal");
    let temperature = root.value("nom_temperature").unwrap_or("?");
    let corner = format!("{conditions}, {voltage} V, {temperature} C");
    Ok(Library { voltage, corner, wires: reader.wires(root)?, cells })
}

/// The largest number that a library may hold, in whatever unit it counts: an area of a square
/// metre in square micrometres, a milliwatt in attowatts.
const LARGEST: f64 = 1e12;

impl<'a> Reader<'a> {
    fn refuse(&self, line: usize, reason: &str) -> LibertyError {
        LibertyError { file: self.file.to_owned(), line, reason: reason.to_owned() }
    }

    fn number(&self, line: usize, text: Option<&str>) -> Result<f64> {
        let text = text.unwrap_or("").trim();
        let shown = || text.chars().take(40).collect::<String>();
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        let number =
            number.ok_or_else(|| self.refuse(line, &format!("`{}` is no number", shown())))?;
        if number.abs() > LARGEST {
            return Err(self.refuse(line, &format!("`{}` is above {LARGEST:e}", shown())));
        }
        Ok(number)
    }

    /// An attribute that is a size: an area, a capacitance, a leakage. Energies of arcs may be
    /// below zero, these may not.
    fn size(&self, group: &Group, name: &str) -> Result<Option<f64>> {
        let size = self.attribute(group, name)?;
        if size.is_some_and(|size| size < 0.0) {
            let line = group.attribute(name).map_or(group.line, |found| found.line);
            return Err(self.refuse(line, &format!("`{name}` is below zero")));
        }
        Ok(size)
    }

    fn attribute(&self, group: &Group, name: &str) -> Result<Option<f64>> {
        let found = group.attribute(name);
        found.map(|found| self.number(found.line, found.values.first().copied())).transpose()
    }

    fn numbers(&self, group: &Group, name: &str) -> Result<Vec<f64>> {
        let Some(found) = group.attribute(name) else { return Ok(Vec::new()) };
        let texts = found.values.iter().flat_map(|list| list.split([',', ' ', '\t', '\n', '\\']));
        let texts = texts.map(str::trim).filter(|text| !text.is_empty());
        texts.map(|text| self.number(found.line, Some(text))).collect()
    }

    /// `"1ns"`, `"10ps"`: the number and the factor of its unit.
    fn unit(&self, root: &Group, name: &str, of: &[(&str, f64)], default: f64) -> Result<f64> {
        let Some(found) = root.attribute(name) else { return Ok(default) };
        // Case counts nowhere but between milli and mega.
        let text = found.values.concat().replace('M', "mega").to_lowercase();
        let digits = text.find(|c: char| c.is_alphabetic()).unwrap_or(text.len());
        let (number, unit) = text.split_at(digits);
        let factor = of.iter().find(|(known, _)| *known == unit.trim()).map(|(_, factor)| *factor);
        let Some(factor) = factor else {
            return Err(self.refuse(found.line, &format!("unknown unit `{text}` of {name}")));
        };
        Ok(self.number(found.line, Some(number))? * factor)
    }

    fn read_units(&self, root: &Group) -> Result<Units> {
        let time = [("ns", 1.0), ("ps", 1e-3), ("us", 1e3)];
        let farad = [("ff", 1.0), ("pf", 1e3)];
        let watt = [("nw", 1.0), ("pw", 1e-3), ("uw", 1e3), ("mw", 1e6), ("w", 1e9)];
        let volt = self.unit(root, "voltage_unit", &[("v", 1.0), ("mv", 1e-3)], 1.0)?;
        let capacitance = self.unit(root, "capacitive_load_unit", &farad, 1e3)?;
        Ok(Units {
            time: self.unit(root, "time_unit", &time, 1.0)?,
            capacitance,
            leakage: self.unit(root, "leakage_power_unit", &watt, 1.0)?,
            energy: capacitance * volt * volt,
        })
    }

    fn axis(&self, template: &Group, name: &str) -> Result<Option<Axis>> {
        let Some(found) = template.attribute(name) else { return Ok(None) };
        Ok(match found.values.first().copied().unwrap_or("") {
            "input_net_transition" | "input_transition_time" => Some(Axis::Slew),
            "total_output_net_capacitance" => Some(Axis::Load),
            // Tables of constraints are not read.
            _ => None,
        })
    }

    fn template_axes(&self, template: &Group) -> Result<Vec<(Axis, Vec<f64>)>> {
        let mut axes = Vec::new();
        for (variable, index) in [("variable_1", "index_1"), ("variable_2", "index_2")] {
            if let Some(axis) = self.axis(template, variable)? {
                axes.push((axis, self.numbers(template, index)?));
            }
        }
        Ok(axes)
    }

    /// The table `name` of `group`, its values times `scale`.
    fn table(&self, group: &Group<'a>, name: &'a str, scale: f64) -> Result<Option<Table>> {
        let Some(table) = group.of(name).next() else { return Ok(None) };
        let values = self.numbers(table, "values")?;
        let template = table.arguments.first().copied().unwrap_or("");
        let mut axes = match self.templates.get(template) {
            Some(axes) => axes.clone(),
            None if template == "scalar" || template.is_empty() => Vec::new(),
            None => {
                return Err(self.refuse(table.line, &format!("no template `{template}`")));
            }
        };
        for ((axis, points), index) in axes.iter_mut().zip(["index_1", "index_2"]) {
            let own = self.numbers(table, index)?;
            if !own.is_empty() {
                *points = own;
            }
            let unit = if *axis == Axis::Slew { self.units.time } else { self.units.capacitance };
            points.iter_mut().for_each(|point| *point *= unit);
            if points.is_empty() || points.windows(2).any(|pair| pair[0] >= pair[1]) {
                return Err(self.refuse(table.line, "points of an axis do not ascend"));
            }
        }
        let size: usize = axes.iter().map(|(_, points)| points.len()).product();
        if values.len() != size {
            let reason = format!("a table of {} values, {size} are expected", values.len());
            return Err(self.refuse(table.line, &reason));
        }
        let values = values.into_iter().map(|value| value * scale).collect();
        Ok(Some(Table { axes, values }))
    }

    fn wires(&self, root: &Group<'a>) -> Result<Option<WireLoad>> {
        let Some(name) = root.value("default_wire_load") else { return Ok(None) };
        let group = root.of("wire_load").find(|group| group.arguments.first() == Some(&name));
        let Some(group) = group else {
            return Err(self.refuse(root.line, &format!("no wire_load `{name}`")));
        };
        let mut lengths = Vec::new();
        for point in group.attributes.iter().filter(|point| point.name == "fanout_length") {
            let fanout = self.number(point.line, point.values.first().copied())?;
            let length = self.number(point.line, point.values.get(1).copied())?;
            if length < 0.0 {
                return Err(self.refuse(point.line, "a length below zero"));
            }
            if !(1.0..1e6).contains(&fanout) {
                return Err(self.refuse(point.line, "a fan-out outside of 1 to 1,000,000"));
            }
            lengths.push((fanout as u32, length));
        }
        lengths.sort_by_key(|(fanout, _)| *fanout);
        lengths.dedup_by_key(|(fanout, _)| *fanout);
        Ok(Some(WireLoad {
            name: name.to_owned(),
            capacitance: self.size(group, "capacitance")?.unwrap_or(0.0) * self.units.capacitance,
            slope: self.size(group, "slope")?.unwrap_or(0.0),
            lengths,
        }))
    }

    fn cell(&self, group: &Group<'a>) -> Result<Cell> {
        let named = |direction: &'static str| {
            let pins = group.of("pin").filter(move |pin| pin.value("direction") == Some(direction));
            pins.map(|pin| pin.arguments.first().copied().unwrap_or("").to_owned())
        };
        let (inputs, outputs): (Vec<_>, Vec<_>) =
            (named("input").collect(), named("output").collect());
        let mut unsupported = None;
        let clock_gate = self.clock_gate(group, &inputs, &outputs, &mut unsupported);
        let stateful = ["latch", "latch_bank", "ff_bank", "statetable", "bus", "bundle"];
        for kind in stateful.into_iter().filter(|_| clock_gate.is_none()) {
            if group.of(kind).next().is_some() && unsupported.is_none() {
                unsupported = Some(format!("it has a `{kind}`"));
            }
        }
        let (flip_flop, states) = self.flip_flop(group, &inputs, &mut unsupported);
        let mut cell = Cell {
            area: self.size(group, "area")?.unwrap_or(0.0),
            leakage: self.leakage(group)?,
            inputs: Vec::new(),
            outputs: Vec::new(),
            flip_flop,
            clock_gate,
            unsupported,
        };
        let everything: Vec<String> = inputs.iter().chain(&outputs).cloned().collect();
        for pin in group.of("pin") {
            let name = pin.arguments.first().copied().unwrap_or("").to_owned();
            let powers = self.powers(pin, &inputs, &everything)?;
            match pin.value("direction") {
                Some("input") => {
                    let rise = self.size(pin, "rise_capacitance")?;
                    let fall = self.size(pin, "fall_capacitance")?;
                    let plain = self.size(pin, "capacitance")?;
                    let larger = rise.into_iter().chain(fall).fold(0.0, f64::max);
                    let capacitance = plain.unwrap_or(larger) * self.units.capacitance;
                    cell.inputs.push(Input { name, capacitance, powers });
                }
                Some("output") => {
                    if pin.attribute("three_state").is_some() {
                        cell.unsupported = Some("it can let go of its output".to_owned());
                    }
                    let function = pin.value("function");
                    let value = match cell.clock_gate {
                        Some(_) => Value::GatedClock,
                        None => self.value(function, &inputs, &states, &mut cell.unsupported),
                    };
                    let arcs = self.arcs(pin, &inputs)?;
                    cell.outputs.push(Output { name, value, arcs, powers });
                }
                _ => {}
            }
        }
        Ok(cell)
    }

    /// The gate that `clock_gating_integrated_cell` says; test pins open it as its enable does.
    fn clock_gate(
        &self,
        group: &Group<'a>,
        inputs: &[String],
        outputs: &[String],
        unsupported: &mut Option<String>,
    ) -> Option<ClockGate> {
        let kind = group.value("clock_gating_integrated_cell")?;
        if !matches!(kind, "latch_posedge" | "latch_posedge_precontrol") || outputs.len() != 1 {
            *unsupported = Some(format!("it is a clock gate `{kind}`"));
            return None;
        }
        let marked = |mark: &'static str| {
            let pins = group.of("pin").filter(move |pin| pin.value(mark) == Some("true"));
            let place = |pin: &Group| {
                inputs.iter().position(|name| Some(&name.as_str()) == pin.arguments.first())
            };
            pins.filter_map(place).collect::<Vec<usize>>()
        };
        let enables = [marked("clock_gate_enable_pin"), marked("clock_gate_test_pin")].concat();
        let mut steps = Vec::new();
        for (count, pin) in enables.into_iter().enumerate() {
            steps.push(Step::Pin(u8::try_from(pin).unwrap_or(u8::MAX)));
            steps.extend((count > 0).then_some(Step::Or));
        }
        match (Function::new(steps, inputs.len()), marked("clock_gate_clock_pin").as_slice()) {
            (Ok(enable), &[clock]) => Some(ClockGate { enable, clock }),
            _ => {
                *unsupported = Some("it is a clock gate without clock and enable pin".to_owned());
                None
            }
        }
    }

    fn flip_flop(
        &self,
        group: &Group<'a>,
        inputs: &[String],
        unsupported: &mut Option<String>,
    ) -> (Option<FlipFlop>, Vec<String>) {
        let Some(ff) = group.of("ff").next() else { return (None, Vec::new()) };
        let states: Vec<String> = ff.arguments.iter().map(|name| (*name).to_owned()).collect();
        if ff.attribute("clear").is_some() || ff.attribute("preset").is_some() {
            *unsupported = Some("it is cleared or set asynchronously".to_owned());
            return (None, states);
        }
        let parse = |name| Function::parse(ff.value(name).unwrap_or(""), inputs);
        let (next, clock) = (parse("next_state"), parse("clocked_on"));
        match (next, clock.as_ref().map(Function::steps)) {
            (Ok(next), Ok([Step::Pin(clock)])) => {
                (Some(FlipFlop { next, clock: usize::from(*clock) }), states)
            }
            _ => {
                *unsupported = Some("its clock is not the rising edge of a pin".to_owned());
                (None, states)
            }
        }
    }

    fn value(
        &self,
        function: Option<&str>,
        inputs: &[String],
        states: &[String],
        unsupported: &mut Option<String>,
    ) -> Value {
        let Some(text) = function else {
            unsupported.get_or_insert("an output has no function".to_owned());
            return Value::Unknown;
        };
        if let Ok(function) = Function::parse(text, states) {
            let (plain, other) = (function.steps() == [Step::Pin(0)], function.steps());
            let inverted = matches!(other, [Step::Pin(1)] | [Step::Pin(0), Step::Not]);
            if plain || inverted {
                return Value::State { inverted };
            }
        }
        match Function::parse(text, inputs) {
            Ok(function) => Value::Gate(function),
            Err(error) => {
                unsupported.get_or_insert(error.to_string());
                Value::Unknown
            }
        }
    }

    fn arcs(&self, pin: &Group<'a>, inputs: &[String]) -> Result<Vec<Arc>> {
        let mut arcs = Vec::new();
        for timing in pin.of("timing") {
            let kind = timing.value("timing_type").unwrap_or("combinational");
            let sense = match (kind, timing.value("timing_sense")) {
                ("rising_edge", _) => Sense::Rising,
                ("combinational", Some("positive_unate")) => Sense::Positive,
                ("combinational", Some("negative_unate")) => Sense::Negative,
                ("combinational", _) => Sense::Either,
                _ => continue,
            };
            let rise = self.table(timing, "rise_transition", self.units.time)?;
            let fall = self.table(timing, "fall_transition", self.units.time)?;
            let delay_rise = self.table(timing, "cell_rise", self.units.time)?;
            let delay_fall = self.table(timing, "cell_fall", self.units.time)?;
            for from in related(timing, inputs) {
                let (rise, fall) = (rise.clone(), fall.clone());
                let (delay_rise, delay_fall) = (delay_rise.clone(), delay_fall.clone());
                arcs.push(Arc { from, sense, rise, fall, delay_rise, delay_fall });
            }
        }
        Ok(arcs)
    }

    /// Whether a group of power is not one of a ground pin.
    fn is_counted(&self, group: &Group) -> bool {
        group.value("related_pg_pin").is_none_or(|pin| !self.grounds.contains(&pin))
    }

    fn powers(
        &self,
        pin: &Group<'a>,
        inputs: &[String],
        everything: &[String],
    ) -> Result<Vec<Power>> {
        let mut powers = Vec::new();
        for group in pin.of("internal_power").filter(|group| self.is_counted(group)) {
            let both = self.table(group, "power", self.units.energy)?;
            let rise = self.table(group, "rise_power", self.units.energy)?.or(both.clone());
            let fall = self.table(group, "fall_power", self.units.energy)?.or(both);
            let when = match group.attribute("when") {
                Some(found) => {
                    let text = found.values.concat();
                    let parsed = Function::parse(&text, everything);
                    let refuse = |error| self.refuse(found.line, &format!("{error}"));
                    Some(parsed.map_err(refuse)?)
                }
                None => None,
            };
            let supply = group.value("related_pg_pin").unwrap_or("").to_owned();
            let from: Vec<_> = related(group, inputs).map(Some).collect();
            for from in if from.is_empty() { vec![None] } else { from } {
                let (supply, when) = (supply.clone(), when.clone());
                powers.push(Power { supply, from, when, rise: rise.clone(), fall: fall.clone() });
            }
        }
        Ok(powers)
    }

    /// States of equal weight, summed over supplies; the plain number only where there are none.
    fn leakage(&self, group: &Group<'a>) -> Result<f64> {
        let mut of_states: BTreeMap<&str, (f64, u32)> = BTreeMap::new();
        let mut plain = None;
        for leakage in group.of("leakage_power").filter(|group| self.is_counted(group)) {
            let value = self.size(leakage, "value")?.unwrap_or(0.0);
            if leakage.attribute("when").is_some() {
                let supply = leakage.value("related_pg_pin").unwrap_or("");
                let sum = of_states.entry(supply).or_default();
                *sum = (sum.0 + value, sum.1 + 1);
            } else {
                plain = Some(plain.unwrap_or(0.0) + value);
            }
        }
        let mean = || of_states.values().map(|(sum, count)| sum / f64::from(*count)).sum::<f64>();
        let whole = self.size(group, "cell_leakage_power")?.unwrap_or(0.0);
        let nw = if of_states.is_empty() { plain.unwrap_or(whole) } else { mean() };
        Ok(nw * self.units.leakage)
    }
}

/// Places of the related pins of a group among the inputs.
fn related<'i>(group: &Group<'_>, inputs: &'i [String]) -> impl Iterator<Item = usize> + use<'i> {
    let text = group.value("related_pin").unwrap_or("").to_owned();
    let named = move |name: &String| text.split_whitespace().any(|related| related == name);
    inputs.iter().enumerate().filter(move |(_, name)| named(name)).map(|(place, _)| place)
}
