//! From a mapped circuit and its library to a [`Netlist`]: what a toggle costs at every pin.
//!
//! Loads are the pins on a net, the library's wire-load model and the stated load of outputs. The
//! internal energy of an output's toggle is that of the library's tables at the transition time of
//! the input that causes it and at the load. Which input that is, and in which state of the others,
//! is not known when only toggles are counted: groups of a table are weighted by the states of
//! equal probability in which that input changes the output. Energies of different supply pins
//! add up; those of ground pins are the same charge a second time and are left out. Where the
//! library has energies for toggles at an input that reach no output, they are
//! weighted by the states they hold in.
//!
//! The clock pin of a flip-flop has two prices, of a cycle in which its bit stays and of one in
//! which it changes; both edges of the clock see the same difference between stored and next bit.
//! Behind a clock gate only cycles count in which it is open. Every clock pin sees the transition
//! time of the ideal clock, behind a gate too, as a timing analyser has it before there is a tree.
//!
//! A clock gate's prices know its state (`gate_prices`): enables change behind a rising edge of
//! the clock, so that what is different at the next falling edge for it is in the price of their
//! edge.

use std::collections::{BTreeMap, BTreeSet};

use thiserror::Error;

mod conditions;
mod gate_prices;

pub use conditions::Conditions;

use crate::function::Function;
use crate::liberty::library::{Cell, Library, Output, Power, Sense, Value};
use crate::netlist::file::rounded;
use crate::netlist::{
    About, Behaviour, ClockGate, FlipFlop, Kind, Netlist, NetlistError, Parts, Pin,
};
use crate::slew::{self, Slew};
use crate::yosys::{Instance, Mapped, ONE, Port, ZERO};

/// A priced circuit, and where its cells come from.
#[derive(Debug)]
pub struct Priced {
    /// The circuit.
    pub netlist: Netlist,
    /// For each cell of the netlist, its place among the instances of the mapped circuit.
    pub instances: Vec<usize>,
    /// Names of the outputs of each kind of cell, in the order of the netlist.
    pub outputs: BTreeMap<String, Vec<String>>,
    /// Transition times of each net.
    pub slews: Vec<Slew>,
}

/// A circuit that cannot be priced.
#[derive(Debug, Error)]
pub enum PriceError {
    /// A kind of cell that the library does not have.
    #[error("cell {instance} is a {kind}, which no Liberty file has; give the file that has it")]
    UnknownCell {
        /// Name of the cell.
        instance: String,
        /// Its kind.
        kind: String,
    },
    /// A kind of cell that the simulator cannot run.
    #[error("cell {instance}: a {kind} cannot be simulated, {reason}; map the unit without it")]
    Unsupported {
        /// Name of the cell.
        instance: String,
        /// Its kind.
        kind: String,
        /// What of it.
        reason: String,
    },
    /// A pin or a net that is wired wrongly.
    #[error("cell {instance} ({kind}): {reason}")]
    Wiring {
        /// Name of the cell.
        instance: String,
        /// Its kind.
        kind: String,
        /// What is wrong.
        reason: String,
    },
    /// The circuit as a whole.
    #[error(transparent)]
    Netlist(#[from] NetlistError),
}

/// Prices `mapped` with the tables of `library`.
///
/// # Errors
/// Where cells are unknown or cannot be simulated, where a net has no driver or two, where a clock
/// is none of the unit's inputs and does not come from it through one clock gate, and where gates
/// form a loop.
pub fn price(
    mapped: &Mapped,
    library: &Library,
    conditions: &Conditions,
) -> Result<Priced, PriceError> {
    let cells = look_up(mapped, library)?;
    let clocks = Clocks::find(mapped, &cells)?;
    let as_it_comes: Vec<usize> = (0..cells.len()).collect();
    let draft = Draft { mapped, library, conditions, cells, clocks };
    let unordered = Netlist::new(draft.parts(&as_it_comes)?)?;
    let mut order = as_it_comes;
    let levels = unordered.levels();
    // Flip-flops, clock gates, gates.
    let class = |cell: usize| match (&draft.cells[cell].flip_flop, &draft.cells[cell].clock_gate) {
        (Some(_), _) => 0,
        (None, Some(_)) => 1,
        (None, None) => 2,
    };
    order.sort_by_key(|cell| {
        (class(*cell), levels[*cell], mapped.cells[*cell].kind.as_str(), *cell)
    });
    let mut parts = draft.parts(&order)?;
    let slews = draft.fill_prices(&mut parts, &order);
    let names = |cell: &Cell| cell.outputs.iter().map(|output| output.name.clone()).collect();
    let kinds = mapped.cells.iter().zip(&draft.cells);
    let outputs = kinds.map(|(instance, cell)| (instance.kind.clone(), names(cell))).collect();
    Ok(Priced { netlist: Netlist::new(parts)?, instances: order, outputs, slews })
}

fn look_up<'l>(mapped: &Mapped, library: &'l Library) -> Result<Vec<&'l Cell>, PriceError> {
    let find = |instance: &Instance| {
        let (name, kind) = (instance.name.clone(), instance.kind.clone());
        let Some(cell) = library.cells.get(&kind) else {
            return Err(PriceError::UnknownCell { instance: name, kind });
        };
        match &cell.unsupported {
            Some(reason) => {
                Err(PriceError::Unsupported { instance: name, kind, reason: reason.clone() })
            }
            None if cell.inputs.len() > 12 => Err(PriceError::Unsupported {
                instance: name,
                kind,
                reason: "it has more than 12 inputs".to_owned(),
            }),
            None => Ok(cell),
        }
    };
    mapped.cells.iter().map(find).collect()
}

fn wiring(instance: &Instance, reason: String) -> PriceError {
    PriceError::Wiring { instance: instance.name.clone(), kind: instance.kind.clone(), reason }
}

/// The net of a pin.
fn net_of(instance: &Instance, pin: &str) -> Option<u32> {
    instance.pins.iter().find(|(name, _)| name == pin).map(|(_, net)| *net)
}

/// Clocks, by nets of the mapped circuit.
struct Clocks {
    /// The clock: an input of the unit.
    root: Option<u32>,
    /// What comes out of clock gates.
    gated: BTreeSet<u32>,
    /// Net of each cell's clock pin.
    of_cells: Vec<Option<u32>>,
}

impl Clocks {
    fn find(mapped: &Mapped, cells: &[&Cell]) -> Result<Clocks, PriceError> {
        let mut clocks = Clocks { root: None, gated: BTreeSet::new(), of_cells: Vec::new() };
        for (instance, cell) in mapped.cells.iter().zip(cells) {
            let output = cell.outputs.first().filter(|_| cell.clock_gate.is_some());
            clocks.gated.extend(output.and_then(|output| net_of(instance, &output.name)));
        }
        let ports = mapped.ports.iter().filter(|port| port.input);
        let inputs: BTreeSet<u32> = ports.flat_map(|port| port.nets.iter().copied()).collect();
        for (instance, cell) in mapped.cells.iter().zip(cells) {
            let Some(pin) = cell.clock() else {
                clocks.of_cells.push(None);
                continue;
            };
            let pin = &cell.inputs[pin].name;
            let Some(net) = net_of(instance, pin) else {
                return Err(wiring(instance, format!("its clock pin {pin} is open")));
            };
            clocks.of_cells.push(Some(net));
            if cell.clock_gate.is_none() && clocks.gated.contains(&net) {
                continue;
            }
            if *clocks.root.get_or_insert(net) != net || !inputs.contains(&net) {
                let reason = "its clock is derived or a second one; all flip-flops must have one \
                              clock that is an input of the unit, through one clock gate at most";
                return Err(wiring(instance, reason.to_owned()));
            }
        }
        Ok(clocks)
    }

    fn has(&self, net: u32) -> bool {
        self.root == Some(net) || self.gated.contains(&net)
    }
}

struct Draft<'a> {
    mapped: &'a Mapped,
    library: &'a Library,
    conditions: &'a Conditions,
    cells: Vec<&'a Cell>,
    clocks: Clocks,
}

impl Draft<'_> {
    /// Places of the data inputs of a cell.
    fn data(cell: &Cell) -> impl Iterator<Item = usize> + '_ {
        let clock = cell.clock();
        (0..cell.inputs.len()).filter(move |input| Some(*input) != clock)
    }

    /// The circuit with cells in `order`, without prices.
    fn parts(&self, order: &[usize]) -> Result<Parts, PriceError> {
        let (mut numbers, mut next) = (vec![u32::MAX; self.mapped.nets as usize], 2u32);
        (numbers[ZERO as usize], numbers[ONE as usize]) = (0, 1);
        // Gives the next number away; whether the net had none.
        let mut drive = |net: Option<u32>| {
            let mut nowhere = u32::MAX;
            let number = net.map_or(&mut nowhere, |net| &mut numbers[net as usize]);
            let free = *number == u32::MAX;
            *number = next;
            next += 1;
            free.then_some(next - 1)
        };
        for net in self.mapped.ports.iter().filter(|p| p.input).flat_map(|port| &port.nets) {
            drive(Some(*net));
        }
        // Net of each output; an open output toggles too.
        let mut outputs = Vec::new();
        for &place in order {
            let instance = &self.mapped.cells[place];
            for output in &self.cells[place].outputs {
                let Some(number) = drive(net_of(instance, &output.name)) else {
                    let reason = format!("output {} drives a net that is driven", output.name);
                    return Err(wiring(instance, reason));
                };
                outputs.push(number);
            }
        }
        let mut outputs = outputs.into_iter();
        let (mut kinds, mut known) = (Vec::new(), BTreeMap::new());
        let (mut cells, mut pins, mut clocks) = (Vec::new(), Vec::new(), Vec::new());
        for &place in order {
            let (instance, cell) = (&self.mapped.cells[place], self.cells[place]);
            let kind = *known.entry(instance.kind.as_str()).or_insert_with(|| {
                kinds.push(self.kind(&instance.kind, cell));
                kinds.len() - 1
            });
            cells.push(u16::try_from(kind).map_err(|_| {
                NetlistError::Malformed("more than 65,535 kinds of cells".to_owned())
            })?);
            let mut push = |net| pins.push(Pin { net, rise_fj: 0.0, fall_fj: 0.0 });
            for input in Self::data(cell) {
                let name = &cell.inputs[input].name;
                let Some(net) = net_of(instance, name) else {
                    return Err(wiring(instance, format!("input {name} is open")));
                };
                let number = numbers[net as usize];
                if number == u32::MAX || self.clocks.has(net) {
                    let what = if number == u32::MAX { "nobody drives" } else { "is a clock" };
                    return Err(wiring(instance, format!("input {name} reads a net that {what}")));
                }
                push(number);
            }
            outputs.by_ref().take(cell.outputs.len()).for_each(&mut push);
            let clock = self.clocks.of_cells[place];
            clocks.push(clock.map_or(0, |net| numbers[net as usize]));
        }
        let ports = self.ports(&numbers)?;
        Ok(Parts {
            about: self.about(),
            kinds,
            ports,
            clock: self.clocks.root.map_or(0, |net| numbers[net as usize]),
            cells,
            clocks,
            pins,
            capacitance: vec![0.0; next as usize],
        })
    }

    fn ports(&self, numbers: &[u32]) -> Result<Vec<Port>, PriceError> {
        let number = |port: &Port, net: u32| match numbers[net as usize] {
            u32::MAX => {
                let reason = format!("nobody drives an output of port {}", port.name);
                Err(PriceError::Netlist(NetlistError::Malformed(reason)))
            }
            number => Ok(number),
        };
        let renumber = |port: &Port| {
            let nets = port.nets.iter().map(|net| number(port, *net)).collect::<Result<_, _>>()?;
            Ok(Port { name: port.name.clone(), input: port.input, nets })
        };
        self.mapped.ports.iter().map(renumber).collect()
    }

    fn about(&self) -> About {
        let wires = self.library.wires.as_ref();
        About {
            unit: self.mapped.name.clone(),
            library: self.conditions.library.clone(),
            corner: self.library.corner.clone(),
            wires: wires.map_or_else(|| "none".to_owned(), |wires| wires.name.clone()),
            voltage: self.library.voltage,
            period_ns: self.conditions.period_ns,
            critical_path_ns: self.conditions.critical_path_ns,
            clock_transition_ns: self.conditions.clock_transition_ns,
            input_transition_ns: self.conditions.input_transition_ns,
            load_ff: self.conditions.load_ff,
        }
    }

    fn kind(&self, name: &str, cell: &Cell) -> Kind {
        let behaviour = match (&cell.flip_flop, &cell.clock_gate) {
            (None, Some(gate)) => Behaviour::ClockGate(ClockGate {
                enable: without_clock(&gate.enable, gate.clock),
                closed_fj: gate_prices::closed(cell, self.conditions.clock_transition_ns),
                clock_ff: cell.inputs[gate.clock].capacitance,
            }),
            (None, None) => {
                let functions = cell.outputs.iter().map(|output| match &output.value {
                    Value::Gate(function) => function.clone(),
                    // Other values make a cell unsupported.
                    Value::State { .. } | Value::GatedClock | Value::Unknown => {
                        Function::parse("0", &[]).expect("a constant")
                    }
                });
                Behaviour::Gate(functions.collect())
            }
            (Some(flip_flop), _) => {
                let inverted = |value: &Value| matches!(value, Value::State { inverted: true });
                let (idle_fj, change_fj) = self.clock_prices(cell);
                Behaviour::FlipFlop(FlipFlop {
                    next: without_clock(&flip_flop.next, flip_flop.clock),
                    inverted: cell.outputs.iter().map(|output| inverted(&output.value)).collect(),
                    idle_fj,
                    change_fj,
                    clock_ff: cell.inputs[flip_flop.clock].capacitance,
                })
            }
        };
        Kind {
            name: name.to_owned(),
            area: cell.area,
            leakage: cell.leakage,
            inputs: Self::data(cell).count() as u8,
            behaviour,
        }
    }

    /// Both edges of the clock pin, where the bit stays and where it changes.
    fn clock_prices(&self, cell: &Cell) -> (f64, f64) {
        let flip_flop = cell.flip_flop.as_ref().expect("a flip-flop");
        let slew = self.conditions.clock_transition_ns;
        let powers = &cell.inputs[flip_flop.clock].powers;
        let (mut sums, mut counts) = ([0.0; 2], [0.0f64; 2]);
        for state in states(cell) {
            let next = flip_flop.next.evaluate(|input| state.pin(input));
            let changes = usize::from(next & 1 != u64::from(state.stored));
            counts[changes] += 1.0;
            for power in powers.iter().filter(|power| state.allows(power.when.as_ref(), cell)) {
                let edge = |table: &Option<_>| energy(table, slew, 0.0);
                sums[changes] += edge(&power.rise) + edge(&power.fall);
            }
        }
        (sums[0] / counts[0].max(1.0), sums[1] / counts[1].max(1.0))
    }

    /// Prices and loads; gives the transition times of the nets.
    fn fill_prices(&self, parts: &mut Parts, order: &[usize]) -> Vec<Slew> {
        let nets = parts.capacitance.len();
        let (mut loads, mut fanout) = (vec![0.0; nets], vec![0u32; nets]);
        let mut first = 0;
        let mut firsts = Vec::with_capacity(order.len());
        for (&place, &clock) in order.iter().zip(&parts.clocks) {
            let cell = self.cells[place];
            firsts.push(first);
            for (input, at) in Self::data(cell).zip(first..) {
                let net = parts.pins[at].net as usize;
                loads[net] += cell.inputs[input].capacitance;
                fanout[net] += 1;
            }
            if let Some(pin) = cell.clock() {
                loads[clock as usize] += cell.inputs[pin].capacitance;
                fanout[clock as usize] += 1;
            }
            first += Self::data(cell).count() + cell.outputs.len();
        }
        for net in parts.ports.iter().filter(|port| !port.input).flat_map(|port| &port.nets) {
            loads[*net as usize] += self.conditions.load_ff;
            fanout[*net as usize] += 1;
        }
        if let Some(wires) = &self.library.wires {
            for (load, fanout) in loads.iter_mut().zip(&fanout) {
                *load += wires.capacitance(*fanout);
            }
        }
        (loads[0], loads[1]) = (0.0, 0.0);
        let mut slews = vec![Slew::both(self.conditions.input_transition_ns); nets];
        (slews[0], slews[1]) = (Slew::default(), Slew::default());
        slews[parts.clock as usize] = Slew::both(self.conditions.clock_transition_ns);
        let mut known = BTreeMap::new();
        for (&place, &first) in order.iter().zip(&firsts) {
            let cell = self.cells[place];
            let kind = self.mapped.cells[place].kind.as_str();
            let shares = known.entry(kind).or_insert_with(|| Shares::new(cell));
            let data: Vec<usize> = Self::data(cell).collect();
            let input_slew = |input: usize| match data.iter().position(|data| *data == input) {
                Some(at) => slews[parts.pins[first + at].net as usize],
                None => Slew::both(self.conditions.clock_transition_ns),
            };
            let outs = first + data.len();
            if let Some(gate) = &cell.clock_gate {
                let clock = self.conditions.clock_transition_ns;
                let load = loads[parts.pins[outs].net as usize];
                let slew_of = |input| input_slew(input);
                let prices = gate_prices::of_pins(cell, gate, clock, load, slew_of);
                for ((rise, fall), pin) in prices.into_iter().zip(&mut parts.pins[first..]) {
                    (pin.rise_fj, pin.fall_fj) = (rounded(rise), rounded(fall));
                }
                continue;
            }
            let mut prices = Vec::new();
            let mut of_outputs = Vec::new();
            for &input in &data {
                let powers = &cell.inputs[input].powers;
                prices.push(input_prices(powers, &shares.inputs[input], input_slew(input)));
            }
            for (output, at) in cell.outputs.iter().zip(outs..) {
                let load = loads[parts.pins[at].net as usize];
                of_outputs.push(slew::of_output(output, load, input_slew));
                prices.push(output_prices(output, &shares.outputs[at - outs], load, input_slew));
            }
            for (slew, at) in of_outputs.into_iter().zip(outs..) {
                slews[parts.pins[at].net as usize] = slew;
            }
            for ((rise, fall), pin) in prices.into_iter().zip(&mut parts.pins[first..]) {
                (pin.rise_fj, pin.fall_fj) = (rounded(rise), rounded(fall));
            }
        }
        parts.capacitance = loads.into_iter().map(rounded).collect();
        slews
    }
}

/// `function` over the inputs without the clock.
fn without_clock(function: &Function, clock: usize) -> Function {
    use crate::function::Step;
    let steps = function.steps().iter().map(|step| match *step {
        Step::Pin(pin) if usize::from(pin) > clock => Step::Pin(pin - 1),
        step => step,
    });
    Function::new(steps.collect(), 255).expect("as good as before")
}

/// A state of a cell: its inputs, and what it stores.
#[derive(Debug, Clone, Copy)]
struct State {
    inputs: u64,
    stored: bool,
}

/// All states, each as probable as any other.
fn states(cell: &Cell) -> impl Iterator<Item = State> {
    let stored: &[bool] = if cell.flip_flop.is_some() { &[false, true] } else { &[false] };
    let all = 0..1u64 << cell.inputs.len();
    all.flat_map(|inputs| stored.iter().map(move |stored| State { inputs, stored: *stored }))
}

impl State {
    fn pin(self, input: usize) -> u64 {
        0u64.wrapping_sub(self.inputs >> input & 1)
    }

    fn output(self, cell: &Cell, output: usize) -> u64 {
        match &cell.outputs[output].value {
            Value::Gate(function) => function.evaluate(|input| self.pin(input)),
            Value::State { inverted } => 0u64.wrapping_sub(u64::from(self.stored != *inverted)),
            Value::GatedClock | Value::Unknown => 0,
        }
    }

    /// Whether `when` holds, a function of inputs, then outputs.
    fn allows(self, when: Option<&Function>, cell: &Cell) -> bool {
        let inputs = cell.inputs.len();
        let pin = |pin: usize| match pin.checked_sub(inputs) {
            None => self.pin(pin),
            Some(output) => self.output(cell, output),
        };
        when.is_none_or(|when| when.evaluate(pin) & 1 == 1)
    }

    fn with_toggled(self, input: usize) -> State {
        State { inputs: self.inputs ^ 1 << input, ..self }
    }
}

fn energy(table: &Option<crate::liberty::table::Table>, slew: f64, load: f64) -> f64 {
    table.as_ref().map_or(0.0, |table| table.at(slew, load))
}

/// How much of each group of energies counts, for all inputs and outputs of a kind of cell.
struct Shares {
    inputs: Vec<Vec<f64>>,
    outputs: Vec<Vec<f64>>,
}

impl Shares {
    fn new(cell: &Cell) -> Shares {
        let states: Vec<State> = states(cell).collect();
        let of_input = |power: &Power| {
            let holds = states.iter().filter(|state| state.allows(power.when.as_ref(), cell));
            holds.count() as f64 / states.len() as f64
        };
        let inputs = cell.inputs.iter().map(|pin| pin.powers.iter().map(of_input).collect());
        let outputs = (0..cell.outputs.len()).map(|output| of_output(cell, output, &states));
        Shares { inputs: inputs.collect(), outputs: outputs.collect() }
    }
}

/// Shares of an output's groups, which are 1 in sum for each supply.
fn of_output(cell: &Cell, output: usize, states: &[State]) -> Vec<f64> {
    let gate = matches!(cell.outputs[output].value, Value::Gate(_));
    let powers = &cell.outputs[output].powers;
    let weight = |power: &Power| {
        let holds = |state: &&State| {
            let causes = match power.from {
                Some(from) if gate => {
                    state.output(cell, output) != state.with_toggled(from).output(cell, output)
                }
                _ => true,
            };
            causes && state.allows(power.when.as_ref(), cell)
        };
        states.iter().filter(holds).count() as f64
    };
    let weights: Vec<f64> = powers.iter().map(weight).collect();
    let share = |(power, weight): (&Power, &f64)| {
        let same = powers.iter().zip(&weights).filter(|(other, _)| other.supply == power.supply);
        let (count, sum) = same.fold((0.0, 0.0), |(n, sum), (_, weight)| (n + 1.0, sum + weight));
        if sum > 0.0 { weight / sum } else { 1.0 / count }
    };
    powers.iter().zip(&weights).map(share).collect()
}

/// Energy of an edge at an input, as far as it is not an output's: rising, falling.
fn input_prices(powers: &[Power], shares: &[f64], slew: Slew) -> (f64, f64) {
    powers.iter().zip(shares).fold((0.0, 0.0), |(rise, fall), (power, share)| {
        let (up, down) = (energy(&power.rise, slew.rise, 0.0), energy(&power.fall, slew.fall, 0.0));
        (rise + share * up, fall + share * down)
    })
}

/// Energy of an edge at an output: rising, falling.
fn output_prices(
    pin: &Output,
    shares: &[f64],
    load: f64,
    input_slew: impl Fn(usize) -> Slew,
) -> (f64, f64) {
    pin.powers.iter().zip(shares).fold((0.0, 0.0), |(rise, fall), (power, share)| {
        let sense = pin.arcs.iter().find(|arc| Some(arc.from) == power.from).map(|arc| arc.sense);
        let from = power.from.map_or_else(Slew::default, &input_slew);
        let (before_rise, before_fall) = match sense {
            Some(Sense::Negative) => (from.fall, from.rise),
            Some(Sense::Rising) => (from.rise, from.rise),
            Some(Sense::Positive | Sense::Either) | None => (from.rise, from.fall),
        };
        let (up, down) =
            (energy(&power.rise, before_rise, load), energy(&power.fall, before_fall, load));
        (rise + share * up, fall + share * down)
    })
}
