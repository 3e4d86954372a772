//! How much more the nets of a unit toggle when gates have delays: an event-driven simulation
//! beside the settled values of each cycle.
//!
//! ```text
//! glitches FOLDER/UNIT.json LIBERTY... CYCLES
//! ```
//!
//! Takes what `rtl/synth/synthesise.py` wrote. A gate's delay is that of the library's table for
//! the input that changes, the edge of the output, the transition time there (as timing analysis
//! has it) and the load. It is inertial: what an input does while the output is on its way decides
//! anew, so that pulses shorter than the delay vanish. Inputs change with the clock edge, outputs
//! of flip-flops after their delay; each cycle ends when nothing moves. Inputs are random bits in
//! each cycle; a volume-rendering core gets tiles of 20 splats one after the other.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::error::Error;
use std::path::Path;
use std::{env, fs};

use powergs_datapath::{NumberFormat, Record};
use powergs_gates::energy;
use powergs_gates::liberty::library::{Library, Sense};
use powergs_gates::liberty::unpack;
use powergs_gates::netlist::{Behaviour, Netlist};
use powergs_gates::price::{Conditions, Priced, price};
use powergs_gates::simulator::Toggles;
use powergs_gates::slew::Slew;
use powergs_gates::yosys::Mapped;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde_json::Value;

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [json, liberty @ .., cycles] = arguments.as_slice() else {
        return Err("UNIT.json LIBERTY... CYCLES".into());
    };
    let cycles: u32 = cycles.parse()?;
    let mut texts = Vec::new();
    for file in liberty {
        texts.push((file.as_str(), unpack(file, &fs::read(file)?)?));
    }
    let texts: Vec<(&str, &str)> = texts.iter().map(|(f, text)| (*f, text.as_str())).collect();
    let library = Library::parse(&texts)?;
    let mapped = Mapped::parse(json, &fs::read_to_string(json)?)?;
    let report = fs::read_to_string(Path::new(json).with_file_name("report.json"))?;
    let report: Value = serde_json::from_str(&report)?;
    let number = |name: &str| report.get(name).and_then(Value::as_f64).unwrap_or(0.0);
    let conditions = Conditions {
        library: String::new(),
        period_ns: number("period_ns"),
        critical_path_ns: number("critical_path_ns"),
        clock_transition_ns: number("clock_transition_ns"),
        input_transition_ns: number("input_transition_ns"),
        load_ff: number("load_ff"),
    };
    let priced = price(&mapped, &library, &conditions)?;
    let netlist = &priced.netlist;
    let mut circuit = Circuit::new(&priced, &mapped, &library, conditions.clock_transition_ns);
    let mut inputs = Inputs::new(netlist);
    for cycle in 0..cycles + 8 {
        if cycle == 8 {
            circuit.count_anew();
        }
        let changes = inputs.next(netlist, &circuit.values, cycle < 4);
        circuit.cycle(netlist, &changes);
    }
    let with = energy::of(netlist, &circuit.toggles(&circuit.moves));
    let without = energy::of(netlist, &circuit.toggles(&circuit.settled));
    let total = |counts: &[[u64; 2]]| counts.iter().flatten().sum::<u64>() as f64;
    let ratio = |of: fn(&energy::Energy) -> f64| of(&with) / of(&without);
    println!(
        "{}: {cycles} cycles, toggles x{:.2}, switching x{:.2}, gates x{:.2}, \
         all but the clock x{:.2}, all x{:.2}; {:.2} pJ a cycle instead of {:.2}",
        mapped.name,
        total(&circuit.moves) / total(&circuit.settled),
        ratio(|energy| energy.nets),
        ratio(|energy| energy.gates),
        ratio(|energy| energy.without_clock()),
        ratio(|energy| energy.total()),
        with.total() / f64::from(cycles) * 1e-3,
        without.total() / f64::from(cycles) * 1e-3,
    );
    Ok(())
}

/// Delay of an output behind an input, fs.
#[derive(Debug, Clone, Copy)]
struct Delay {
    rise: u64,
    fall: u64,
}

/// An output of a gate that reads a net.
#[derive(Debug, Clone, Copy)]
struct Reader {
    cell: u32,
    output: u32,
    delay: Delay,
}

#[derive(Debug)]
struct Circuit {
    values: Vec<bool>,
    /// What each net is on its way to, and the number of the event that brings it there.
    pending: Vec<Option<(bool, u64)>>,
    readers: Vec<Vec<Reader>>,
    /// Delay of the outputs of flip-flops, by net.
    behind_clock: Vec<Delay>,
    stored: Vec<bool>,
    /// Rising and falling edges of each net: all, and those that settled values show.
    moves: Vec<[u64; 2]>,
    settled: Vec<[u64; 2]>,
    /// Rising edges behind clock gates.
    open: Vec<u64>,
    cycles: u64,
    events: u64,
}

impl Circuit {
    fn new(priced: &Priced, mapped: &Mapped, library: &Library, clock: f64) -> Circuit {
        let netlist = &priced.netlist;
        let nets = netlist.nets();
        let none = Delay { rise: 0, fall: 0 };
        let mut circuit = Circuit {
            values: vec![false; nets],
            pending: vec![None; nets],
            readers: vec![Vec::new(); nets],
            behind_clock: vec![none; nets],
            stored: vec![false; netlist.parts().cells.len()],
            moves: vec![[0; 2]; nets],
            settled: vec![[0; 2]; nets],
            open: vec![0; nets],
            cycles: 0,
            events: 0,
        };
        circuit.values[1] = true;
        let slews = &priced.slews;
        for (cell, &place) in priced.instances.iter().enumerate() {
            let kind = &library.cells[&mapped.cells[place].kind];
            let (inputs, outputs) = netlist.pins(cell);
            let data: Vec<usize> =
                (0..kind.inputs.len()).filter(|input| Some(*input) != kind.clock()).collect();
            for (number, (output, pin)) in kind.outputs.iter().zip(outputs).enumerate() {
                let load = f64::from(netlist.parts().capacitance[pin.net as usize]);
                let delay_from = |input: usize, slew: Slew| {
                    let mut delay = none;
                    for arc in output.arcs.iter().filter(|arc| arc.from == input) {
                        let (before_rise, before_fall) = match arc.sense {
                            Sense::Positive => (slew.rise, slew.fall),
                            Sense::Negative => (slew.fall, slew.rise),
                            Sense::Rising => (slew.rise, slew.rise),
                            Sense::Either => (slew.rise.max(slew.fall), slew.rise.max(slew.fall)),
                        };
                        let fs = |ns: f64| (ns.max(0.0) * 1e6) as u64;
                        let at = |table: &Option<_>, slew: f64| {
                            let table: Option<&powergs_gates::liberty::table::Table> =
                                table.as_ref();
                            table.map_or(0, |table| fs(table.at(slew, load)))
                        };
                        delay.rise = delay.rise.max(at(&arc.delay_rise, before_rise));
                        delay.fall = delay.fall.max(at(&arc.delay_fall, before_fall));
                    }
                    delay
                };
                match &netlist.kind(cell).behaviour {
                    Behaviour::Gate(_) => {
                        for (&input, from) in data.iter().zip(inputs) {
                            let delay = delay_from(input, slews[from.net as usize]);
                            let reader = Reader { cell: cell as u32, output: number as u32, delay };
                            circuit.readers[from.net as usize].push(reader);
                        }
                    }
                    Behaviour::FlipFlop(_) => {
                        let pin_of_clock = kind.clock().expect("a flip-flop has a clock");
                        let delay = delay_from(pin_of_clock, Slew::both(clock));
                        circuit.behind_clock[pin.net as usize] = delay;
                    }
                    Behaviour::ClockGate(_) => {}
                }
            }
        }
        circuit.settle_all(netlist);
        circuit
    }

    /// The value of an output of a gate, for the values of nets.
    fn output(&self, netlist: &Netlist, cell: usize, output: usize) -> bool {
        let Behaviour::Gate(functions) = &netlist.kind(cell).behaviour else { unreachable!() };
        let (inputs, _) = netlist.pins(cell);
        let value =
            |input: usize| 0u64.wrapping_sub(u64::from(self.values[inputs[input].net as usize]));
        functions[output].evaluate(value) & 1 == 1
    }

    /// Brings all gates to the values that follow from inputs and flip-flops, without delay.
    fn settle_all(&mut self, netlist: &Netlist) {
        let mut order: Vec<usize> = (0..netlist.parts().cells.len()).collect();
        order.sort_by_key(|cell| netlist.levels()[*cell]);
        for cell in 0..netlist.parts().cells.len() {
            if let Behaviour::FlipFlop(kind) = &netlist.kind(cell).behaviour {
                for (pin, inverted) in netlist.pins(cell).1.iter().zip(&kind.inverted) {
                    self.values[pin.net as usize] = self.stored[cell] != *inverted;
                }
            }
        }
        for cell in order {
            if let Behaviour::Gate(functions) = &netlist.kind(cell).behaviour {
                for number in 0..functions.len() {
                    let value = self.output(netlist, cell, number);
                    self.values[netlist.pins(cell).1[number].net as usize] = value;
                }
            }
        }
    }

    fn count_anew(&mut self) {
        self.moves.fill([0; 2]);
        self.settled.fill([0; 2]);
        self.open.fill(0);
        self.cycles = 0;
    }

    /// A clock edge with new inputs, and all that follows from it.
    fn cycle(&mut self, netlist: &Netlist, changes: &[(u32, bool)]) {
        let before = self.values.clone();
        let value = |net: u32| 0u64.wrapping_sub(u64::from(before[net as usize]));
        let parts = netlist.parts();
        let mut opened = vec![false; before.len()];
        for cell in 0..parts.cells.len() {
            if let Behaviour::ClockGate(kind) = &netlist.kind(cell).behaviour {
                let (inputs, outputs) = netlist.pins(cell);
                let open = kind.enable.evaluate(|input| value(inputs[input].net)) & 1 == 1;
                opened[outputs[0].net as usize] = open;
                self.open[outputs[0].net as usize] += u64::from(open);
            }
        }
        // Time, number, net, value.
        let mut queue = BinaryHeap::new();
        for cell in 0..parts.cells.len() {
            let Behaviour::FlipFlop(kind) = &netlist.kind(cell).behaviour else { continue };
            let clock = parts.clocks[cell];
            if clock != parts.clock && !opened[clock as usize] {
                continue;
            }
            let (inputs, outputs) = netlist.pins(cell);
            let next = kind.next.evaluate(|input| value(inputs[input].net)) & 1 == 1;
            self.stored[cell] = next;
            for (pin, inverted) in outputs.iter().zip(&kind.inverted) {
                let shown = next != *inverted;
                if shown != before[pin.net as usize] {
                    let Delay { rise, fall } = self.behind_clock[pin.net as usize];
                    self.schedule(&mut queue, if shown { rise } else { fall }, pin.net, shown);
                }
            }
        }
        for &(net, value) in changes {
            if value != before[net as usize] {
                self.schedule(&mut queue, 0, net, value);
            }
        }
        while let Some(Reverse((time, number, net, value))) = queue.pop() {
            if self.pending[net as usize] != Some((value, number)) {
                continue;
            }
            self.pending[net as usize] = None;
            self.values[net as usize] = value;
            self.moves[net as usize][usize::from(!value)] += 1;
            for place in 0..self.readers[net as usize].len() {
                let reader = self.readers[net as usize][place];
                let (cell, output) = (reader.cell as usize, reader.output as usize);
                let new = self.output(netlist, cell, output);
                let driven = netlist.pins(cell).1[output].net;
                let now = self.values[driven as usize];
                match self.pending[driven as usize] {
                    Some((to, _)) if to == new => {}
                    None if new == now => {}
                    _ if new == now => self.pending[driven as usize] = None,
                    _ => {
                        let Delay { rise, fall } = reader.delay;
                        let delay = if new { rise } else { fall };
                        self.schedule(&mut queue, time + delay, driven, new);
                    }
                }
            }
        }
        for ((&from, &to), settled) in before.iter().zip(&self.values).zip(&mut self.settled) {
            if from != to {
                settled[usize::from(!to)] += 1;
            }
        }
        self.cycles += 1;
        let with_delays = self.values.clone();
        self.settle_all(netlist);
        assert!(with_delays == self.values, "delays must not change what a cycle ends with");
    }

    fn schedule(&mut self, queue: &mut Queue, time: u64, net: u32, value: bool) {
        self.events += 1;
        self.pending[net as usize] = Some((value, self.events));
        queue.push(Reverse((time, self.events, net, value)));
    }

    fn toggles(&self, counts: &[[u64; 2]]) -> Toggles {
        let edges = |edge: usize| counts.iter().map(move |count| count[edge]);
        let behind_gates = |edge| edges(edge).zip(&self.open).map(|(count, open)| count + open);
        Toggles {
            lane_cycles: self.cycles,
            rises: behind_gates(0).collect(),
            falls: behind_gates(1).collect(),
        }
    }
}

type Queue = BinaryHeap<Reverse<(u64, u64, u32, bool)>>;

/// What comes in.
struct Inputs {
    random: Pcg64Mcg,
    /// Beats of tiles to a volume-rendering core: what to do, and the bits of the record.
    beats: Vec<(u64, Vec<bool>)>,
}

impl Inputs {
    fn new(netlist: &Netlist) -> Inputs {
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let mut beats = Vec::new();
        if let Some(record) = netlist.port("in_record") {
            let width = record.nets.len() / 9;
            let exponent = if width == 8 { 4 } else { 5 };
            let format = NumberFormat::new(exponent, width as u32 - 1 - exponent);
            let format = format.expect("a format that cores are mapped for");
            for _ in 0..50 {
                beats.push((2, vec![false; 9 * width]));
                for _ in 0..20 {
                    beats.push((1, bits(&splat(&mut random, format), width)));
                }
                beats.push((0, vec![false; 9 * width]));
            }
        }
        Inputs { random, beats }
    }

    fn next(&mut self, netlist: &Netlist, values: &[bool], reset: bool) -> Vec<(u32, bool)> {
        let mut changes = Vec::new();
        let ready = netlist.port("in_ready").is_some_and(|port| values[port.nets[0] as usize]);
        let core = netlist.port("in_record").is_some();
        if core && !reset && ready && self.beats.len() > 1 {
            self.beats.pop();
        }
        let ports = netlist.parts().ports.iter().filter(|port| port.input);
        for port in ports {
            for (bit, &net) in port.nets.iter().enumerate() {
                let value = match (port.name.as_str(), self.beats.last()) {
                    ("clk", _) => continue,
                    ("rst_n", _) => !reset,
                    ("in_op", Some((op, _))) => op >> bit & 1 == 1,
                    ("in_record", Some((_, record))) => record[bit],
                    ("open_x" | "open_y", Some(_)) => false,
                    (_, Some(_)) => true,
                    (_, None) => self.random.next_u64() & 1 == 1,
                };
                changes.push((net, value));
            }
        }
        changes
    }
}

/// A splat somewhere near the first pixel of a tile.
fn splat(random: &mut Pcg64Mcg, format: NumberFormat) -> Record {
    loop {
        let mean = [0; 2].map(|_| random.random_range(-3.0..4.0) - 7.5);
        let [a, d] = [0; 2].map(|_| random.random_range(0.3f32..20.0));
        let b = random.random_range(-0.9..0.9) * (a * d).sqrt();
        let opacity = random.random_range(0.002f32..1.0);
        let colour = [0; 3].map(|_| random.random_range(0.0f32..1.0));
        if let Some(record) = Record::new(format, mean, [a, b, d], opacity, colour) {
            return record;
        }
    }
}

fn bits(record: &Record, width: usize) -> Vec<bool> {
    let Record { mean, root, opacity, colour } = *record;
    let numbers = [mean[0], mean[1], root[0], root[1], root[2], opacity];
    let numbers = numbers.into_iter().chain(colour);
    numbers.flat_map(|number| (0..width).map(move |bit| number >> bit & 1 == 1)).collect()
}
