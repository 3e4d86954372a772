//! A gate simulator: 64 circuits side by side, one a bit, with a count of toggles of every net.
//!
//! Gates are sorted by level and, within a level, by what they compute, and become flat code: runs
//! of one operation over lists of net numbers. Delays are zero: within a cycle every net takes its
//! final value once, so glitches are not counted. The net behind a clock gate is shown as 0; its
//! toggles are two for every cycle in which the gate is open.

use std::collections::BTreeMap;
use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use fearless_simd_macros::simd;

use crate::function::{Function, Step};
use crate::netlist::{Behaviour, Netlist, Pin};

mod shapes;

/// A circuit in 64 lanes, and how often each of its nets has changed.
#[derive(Debug)]
pub struct Simulator {
    level: Level,
    values: Vec<u64>,
    /// Values where counting began.
    began: Vec<u64>,
    toggles: Vec<u64>,
    runs: Vec<Run>,
    flip_flops: FlipFlops,
    cycles: u64,
}

/// Gates of one function in one level.
#[derive(Debug)]
struct Run {
    operation: Operation,
    inputs: usize,
    /// For each gate its inputs, then its output.
    nets: Vec<u32>,
}

#[derive(Debug, Clone, PartialEq)]
enum Operation {
    /// A function that is compiled in, by its number; inputs are in its order.
    Shape(usize),
    /// Any other.
    Other(Function),
}

#[derive(Debug, Default)]
struct FlipFlops {
    /// Functions of what is stored that are not a plain input.
    kinds: Vec<Function>,
    /// What comes next, flip-flops of a clock side by side.
    next: Vec<Next>,
    /// Clocks of the flip-flops, in their order.
    clocks: Vec<Clock>,
    /// Outputs: the flip-flop, the net, whether it is inverted.
    shown: Vec<(u32, u32, u64)>,
    stored: Vec<u64>,
}

/// The value of a net or its inverse, or a function and its inputs.
#[derive(Debug)]
enum Next {
    Net { net: u32, inverted: u64 },
    Function { kind: u32, inputs: Box<[u32]> },
}

/// A clock and the flip-flops that have it.
#[derive(Debug)]
struct Clock {
    /// What lets it through, and the net behind; `None` is the clock itself.
    gate: Option<(Next, u32)>,
    flip_flops: Range<usize>,
}

/// Toggles since counting began.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Toggles {
    /// Clock cycles, of all lanes together.
    pub lane_cycles: u64,
    /// Rising edges of each net, of all lanes together.
    pub rises: Vec<u64>,
    /// Falling edges.
    pub falls: Vec<u64>,
}

impl Simulator {
    /// The circuit with all nets and flip-flops at 0.
    pub fn new(netlist: &Netlist) -> Simulator {
        let mut values = vec![0; netlist.nets()];
        values[1] = !0;
        let mut simulator = Simulator {
            level: Level::new(),
            began: values.clone(),
            toggles: vec![0; values.len()],
            values,
            runs: runs(netlist),
            flip_flops: flip_flops(netlist),
            cycles: 0,
        };
        simulator.show();
        simulator.settle();
        simulator.count_anew();
        simulator
    }

    /// Sets an input bit in all lanes.
    pub fn set(&mut self, net: u32, value: u64) {
        let net = net as usize;
        self.toggles[net] += u64::from((self.values[net] ^ value).count_ones());
        self.values[net] = value;
    }

    /// The value of a net in all lanes.
    pub fn get(&self, net: u32) -> u64 {
        self.values[net as usize]
    }

    /// Lets all gates follow inputs and flip-flops.
    pub fn settle(&mut self) {
        let Simulator { level, values, toggles, runs, .. } = self;
        dispatch!(*level, simd => settle_all(simd, runs, values, toggles));
    }

    /// A rising edge of the clock: flip-flops take what is in front of them. Gates follow at the
    /// next [`settle`](Simulator::settle).
    pub fn clock(&mut self) {
        self.flip_flops.take(&self.values, &mut self.toggles);
        self.show();
        self.cycles += 1;
    }

    /// Counts from here.
    pub fn count_anew(&mut self) {
        self.toggles.fill(0);
        self.began.copy_from_slice(&self.values);
        self.cycles = 0;
    }

    /// Cycles since counting began.
    pub fn cycles(&self) -> u64 {
        self.cycles
    }

    /// What has been counted. A net that ends higher than it began has risen once more than it has
    /// fallen.
    pub fn toggles(&self) -> Toggles {
        let rises = |net: usize| {
            let (from, to) = (self.began[net].count_ones(), self.values[net].count_ones());
            (self.toggles[net] + u64::from(to) - u64::from(from)) / 2
        };
        let rises: Vec<u64> = (0..self.values.len()).map(rises).collect();
        let falls = self.toggles.iter().zip(&rises).map(|(all, rises)| all - rises).collect();
        Toggles { lane_cycles: 64 * self.cycles, rises, falls }
    }

    fn show(&mut self) {
        let FlipFlops { shown, stored, .. } = &self.flip_flops;
        for &(flip_flop, net, inverted) in shown {
            let (net, value) = (net as usize, stored[flip_flop as usize] ^ inverted);
            self.toggles[net] += u64::from((self.values[net] ^ value).count_ones());
            self.values[net] = value;
        }
    }
}

impl FlipFlops {
    fn take(&mut self, values: &[u64], toggles: &mut [u64]) {
        let FlipFlops { kinds, next, clocks, stored, .. } = self;
        let value = |next: &Next| match next {
            Next::Net { net, inverted } => values[*net as usize] ^ inverted,
            Next::Function { kind, inputs } => {
                kinds[*kind as usize].evaluate(|input| values[inputs[input] as usize])
            }
        };
        for Clock { gate, flip_flops } in clocks {
            let mut open = !0;
            if let Some((enable, net)) = gate {
                open = value(enable);
                toggles[*net as usize] += 2 * u64::from(open.count_ones());
            }
            let (stored, next) = (&mut stored[flip_flops.clone()], &next[flip_flops.clone()]);
            for (stored, next) in stored.iter_mut().zip(next).filter(|_| open != 0) {
                *stored ^= (*stored ^ value(next)) & open;
            }
        }
    }

    fn next(&mut self, function: &Function, inputs: &[Pin]) -> Next {
        if let [Step::Pin(pin)] | [Step::Pin(pin), Step::Not] = function.steps() {
            let inverted = if function.steps().len() == 1 { 0 } else { !0 };
            return Next::Net { net: inputs[usize::from(*pin)].net, inverted };
        }
        let known = self.kinds.iter().position(|known| known == function);
        let place = known.unwrap_or_else(|| {
            self.kinds.push(function.clone());
            self.kinds.len() - 1
        });
        Next::Function { kind: place as u32, inputs: inputs.iter().map(|pin| pin.net).collect() }
    }
}

#[simd]
fn settle_all<S: Simd>(_simd: S, runs: &[Run], values: &mut [u64], toggles: &mut [u64]) {
    for run in runs {
        match &run.operation {
            Operation::Shape(shape) => shapes::run(*shape, &run.nets, values, toggles),
            Operation::Other(function) => {
                for nets in run.nets.chunks_exact(run.inputs + 1) {
                    let value = function.evaluate(|input| values[nets[input] as usize]);
                    shapes::store(nets[run.inputs], value, values, toggles);
                }
            }
        }
    }
}

fn flip_flops(netlist: &Netlist) -> FlipFlops {
    let parts = netlist.parts();
    // Cells of each clock; gates that drive no flip-flop cost energy too.
    let mut of_clock: BTreeMap<u32, (Option<usize>, Vec<usize>)> = BTreeMap::new();
    for cell in 0..parts.cells.len() {
        match netlist.kind(cell).behaviour {
            Behaviour::Gate(_) => {}
            Behaviour::FlipFlop(_) => {
                of_clock.entry(parts.clocks[cell]).or_default().1.push(cell);
            }
            Behaviour::ClockGate(_) => {
                of_clock.entry(netlist.pins(cell).1[0].net).or_default().0 = Some(cell);
            }
        }
    }
    let mut all = FlipFlops::default();
    for (clock, (gate, cells)) in of_clock {
        let first = all.stored.len();
        for cell in cells {
            let Behaviour::FlipFlop(kind) = &netlist.kind(cell).behaviour else { continue };
            let (inputs, outputs) = netlist.pins(cell);
            let next = all.next(&kind.next, inputs);
            all.next.push(next);
            let number = all.stored.len() as u32;
            for (pin, inverted) in outputs.iter().zip(&kind.inverted) {
                all.shown.push((number, pin.net, if *inverted { !0 } else { 0 }));
            }
            all.stored.push(0);
        }
        let enable = gate.and_then(|cell| match &netlist.kind(cell).behaviour {
            Behaviour::ClockGate(kind) => Some(all.next(&kind.enable, netlist.pins(cell).0)),
            Behaviour::Gate(_) | Behaviour::FlipFlop(_) => None,
        });
        let gate = enable.map(|enable| (enable, clock));
        all.clocks.push(Clock { gate, flip_flops: first..all.stored.len() });
    }
    all
}

/// The gates as flat code.
fn runs(netlist: &Netlist) -> Vec<Run> {
    let kinds = &netlist.parts().kinds;
    // For each kind and output, its operation and the order of its inputs.
    let mut operations: Vec<(Operation, usize)> = Vec::new();
    let mut compiled: Vec<Vec<(usize, Vec<usize>)>> = Vec::new();
    for kind in kinds {
        let Behaviour::Gate(functions) = &kind.behaviour else {
            compiled.push(Vec::new());
            continue;
        };
        let compile = |function: &Function| {
            let inputs = usize::from(kind.inputs);
            let (operation, order) = match shapes::find(function, inputs) {
                Some((shape, order)) => (Operation::Shape(shape), order),
                None => (Operation::Other(function.clone()), (0..inputs).collect()),
            };
            let known = operations.iter().position(|(known, _)| *known == operation);
            let place = known.unwrap_or_else(|| {
                operations.push((operation, order.len()));
                operations.len() - 1
            });
            (place, order)
        };
        compiled.push(functions.iter().map(compile).collect());
    }
    let mut gates: Vec<(u32, usize, Vec<u32>)> = Vec::new();
    for (cell, kind) in netlist.parts().cells.iter().enumerate() {
        let (inputs, outputs) = netlist.pins(cell);
        for ((operation, order), output) in compiled[usize::from(*kind)].iter().zip(outputs) {
            let mut nets: Vec<u32> = order.iter().map(|input| inputs[*input].net).collect();
            nets.push(output.net);
            gates.push((netlist.levels()[cell], *operation, nets));
        }
    }
    gates.sort_by_key(|(level, operation, _)| (*level, *operation));
    let mut runs: Vec<Run> = Vec::new();
    let mut last = None;
    for (level, place, nets) in gates {
        if last != Some((level, place)) {
            let (operation, inputs) = operations[place].clone();
            runs.push(Run { operation, inputs, nets: Vec::new() });
            last = Some((level, place));
        }
        runs.last_mut().expect("a run").nets.extend(nets);
    }
    runs
}
