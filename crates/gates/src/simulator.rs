//! A gate simulator: 64 circuits side by side, one a bit, with a count of toggles of every net.
//!
//! Gates are sorted by level and, within a level, by what they compute, and become flat code: runs
//! of one operation over lists of net numbers. Delays are zero: within a cycle every net takes its
//! final value once, so glitches are not counted.

use fearless_simd::prelude::*;
use fearless_simd::{Level, dispatch};
use fearless_simd_macros::simd;

use crate::function::Function;
use crate::netlist::{Behaviour, Netlist};

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
    /// Net of the input, or kind and inputs.
    next: Vec<Next>,
    /// Outputs: the flip-flop, the net, whether it is inverted.
    shown: Vec<(u32, u32, u64)>,
    stored: Vec<u64>,
}

#[derive(Debug)]
enum Next {
    Net(u32),
    Function { kind: u32, inputs: Box<[u32]> },
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
        self.flip_flops.take(&self.values);
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
    fn take(&mut self, values: &[u64]) {
        for (stored, next) in self.stored.iter_mut().zip(&self.next) {
            *stored = match next {
                Next::Net(net) => values[*net as usize],
                Next::Function { kind, inputs } => {
                    self.kinds[*kind as usize].evaluate(|input| values[inputs[input] as usize])
                }
            };
        }
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
    let mut all = FlipFlops::default();
    for cell in 0..netlist.parts().cells.len() {
        let Behaviour::FlipFlop(kind) = &netlist.kind(cell).behaviour else { continue };
        let (inputs, outputs) = netlist.pins(cell);
        let nets: Box<[u32]> = inputs.iter().map(|pin| pin.net).collect();
        all.next.push(match kind.next.steps() {
            [crate::function::Step::Pin(pin)] => Next::Net(nets[usize::from(*pin)]),
            _ => {
                let known = all.kinds.iter().position(|function| *function == kind.next);
                let place = known.unwrap_or_else(|| {
                    all.kinds.push(kind.next.clone());
                    all.kinds.len() - 1
                });
                Next::Function { kind: place as u32, inputs: nets }
            }
        });
        let number = all.stored.len() as u32;
        for (pin, inverted) in outputs.iter().zip(&kind.inverted) {
            all.shown.push((number, pin.net, if *inverted { !0 } else { 0 }));
        }
        all.stored.push(0);
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
