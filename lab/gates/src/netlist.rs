//! A mapped circuit with what it costs: gates, and the energy of a toggle at each pin.

pub mod file;

use thiserror::Error;

use crate::function::Function;
use crate::yosys::Port;

/// Where a netlist comes from and what its numbers hold for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct About {
    /// Name of the unit.
    pub unit: String,
    /// Name of the library.
    pub library: String,
    /// Operating conditions of the library.
    pub corner: String,
    /// Wire-load model, or that there is none.
    pub wires: String,
    /// Supply, V.
    pub voltage: f64,
    /// Clock period that the circuit was mapped for, ns.
    pub period_ns: f64,
    /// Critical path by static timing analysis, ns; 0 if it was not analysed.
    pub critical_path_ns: f64,
    /// Transition time of the ideal clock, ns.
    pub clock_transition_ns: f64,
    /// Transition time at inputs, ns.
    pub input_transition_ns: f64,
    /// Load of each output, fF.
    pub load_ff: f64,
}

/// A kind of cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Kind {
    /// Its name in the library.
    pub name: String,
    /// Area, um².
    pub area: f64,
    /// Leakage, nW.
    pub leakage: f64,
    /// Number of inputs, without the clock.
    pub inputs: u8,
    /// What it does.
    pub behaviour: Behaviour,
}

/// What a kind of cell does.
#[derive(Debug, Clone, PartialEq)]
pub enum Behaviour {
    /// One function of the inputs for each output.
    Gate(Vec<Function>),
    /// A bit that is stored at the rising edge of the clock.
    FlipFlop(FlipFlop),
    /// A clock that is let through where it is enabled.
    ClockGate(ClockGate),
}

/// A stored bit, and what its clock pin costs.
#[derive(Debug, Clone, PartialEq)]
pub struct FlipFlop {
    /// What is stored, of the inputs.
    pub next: Function,
    /// For each output, whether it shows the inverse.
    pub inverted: Vec<bool>,
    /// Internal energy of both edges in a cycle in which the bit stays, fJ.
    pub idle_fj: f64,
    /// The same in a cycle in which it changes, without what its outputs cost, fJ.
    pub change_fj: f64,
    /// Capacitance of the clock pin, fF.
    pub clock_ff: f64,
}

/// A clock gate. Its output is the clock in every cycle at whose beginning, the rising edge, its
/// enable is 1, and 0 in the others. A rising edge of the output carries what the whole cycle costs
/// but the falling edge; an edge of an enable what it costs itself and what the clock's next
/// falling edge costs more for it.
#[derive(Debug, Clone, PartialEq)]
pub struct ClockGate {
    /// Whether the clock is let through, of the inputs.
    pub enable: Function,
    /// Internal energy of both edges of the clock in a cycle in which it is not, fJ.
    pub closed_fj: f64,
    /// Capacitance of the clock pin, fF.
    pub clock_ff: f64,
}

impl Kind {
    /// Number of outputs.
    pub fn outputs(&self) -> usize {
        match &self.behaviour {
            Behaviour::Gate(functions) => functions.len(),
            Behaviour::FlipFlop(flip_flop) => flip_flop.inverted.len(),
            Behaviour::ClockGate(_) => 1,
        }
    }

    /// Number of pins: inputs, then outputs.
    pub fn pins(&self) -> usize {
        usize::from(self.inputs) + self.outputs()
    }
}

/// A pin of a cell: what it is connected to, and internal energy of the cell for each toggle there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pin {
    /// Its net.
    pub net: u32,
    /// Of a rising edge, fJ.
    pub rise_fj: f32,
    /// Of a falling edge, fJ.
    pub fall_fj: f32,
}

/// The parts of a netlist.
///
/// Net 0 is 0 and net 1 is 1. Then follow the bits of the input ports in order, then the outputs of
/// the cells in order: who drives a net is clear from its number.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parts {
    /// Where it comes from.
    pub about: About,
    /// Kinds of cells.
    pub kinds: Vec<Kind>,
    /// Ports.
    pub ports: Vec<Port>,
    /// The net of the clock, one of the input bits; 0 without flip-flops.
    pub clock: u32,
    /// Kind of each cell.
    pub cells: Vec<u16>,
    /// For each cell the net of its clock pin: the clock, or the output of a clock gate for a
    /// flip-flop behind one; 0 for gates.
    pub clocks: Vec<u32>,
    /// Pins of all cells, inputs then outputs of each.
    pub pins: Vec<Pin>,
    /// Capacitance of each net, fF: pins, wire, and the load at output ports.
    pub capacitance: Vec<f32>,
}

/// A circuit that cannot be simulated.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum NetlistError {
    /// Gates that wait for each other.
    #[error(
        "cell {cell} ({kind}) is on a combinational loop; a unit must break every loop with a \
         flip-flop"
    )]
    Loop {
        /// Place of one of them.
        cell: usize,
        /// Its kind.
        kind: String,
    },
    /// Anything else that cannot be.
    #[error("no netlist: {0}")]
    Malformed(String),
}

/// A checked circuit.
#[derive(Debug, Clone, PartialEq)]
pub struct Netlist {
    parts: Parts,
    levels: Vec<u32>,
    first_pin: Vec<u32>,
}

impl Netlist {
    /// Checks `parts`.
    ///
    /// # Errors
    /// When numbers of nets, pins or kinds do not fit together, or gates form a loop.
    pub fn new(parts: Parts) -> Result<Netlist, NetlistError> {
        let first_pin = check(&parts)?;
        let levels = levels(&parts, &first_pin)?;
        Ok(Netlist { parts, levels, first_pin })
    }

    /// What it is made of.
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// For each cell, how many gates are before it at most; 0 for flip-flops.
    pub fn levels(&self) -> &[u32] {
        &self.levels
    }

    /// Number of nets.
    pub fn nets(&self) -> usize {
        self.parts.capacitance.len()
    }

    /// The kind of cell `cell`.
    pub fn kind(&self, cell: usize) -> &Kind {
        &self.parts.kinds[usize::from(self.parts.cells[cell])]
    }

    /// Pins of cell `cell`: inputs and outputs.
    pub fn pins(&self, cell: usize) -> (&[Pin], &[Pin]) {
        let (kind, first) = (self.kind(cell), self.first_pin[cell] as usize);
        self.parts.pins[first..first + kind.pins()].split_at(usize::from(kind.inputs))
    }

    /// The port called `name`.
    pub fn port(&self, name: &str) -> Option<&Port> {
        self.parts.ports.iter().find(|port| port.name == name)
    }

    /// Area of all cells, um².
    pub fn area(&self) -> f64 {
        (0..self.parts.cells.len()).map(|cell| self.kind(cell).area).sum()
    }

    /// Leakage of all cells, nW.
    pub fn leakage(&self) -> f64 {
        (0..self.parts.cells.len()).map(|cell| self.kind(cell).leakage).sum()
    }

    /// Number of flip-flops.
    pub fn flip_flops(&self) -> usize {
        let is_one = |cell: &usize| matches!(self.kind(*cell).behaviour, Behaviour::FlipFlop(_));
        (0..self.parts.cells.len()).filter(is_one).count()
    }

    /// Number of flip-flops whose clock comes through a gate.
    pub fn gated_flip_flops(&self) -> usize {
        self.parts.clocks.iter().filter(|net| ![0, self.parts.clock].contains(net)).count()
    }

    /// Number of clock gates.
    pub fn clock_gates(&self) -> usize {
        let is_one = |cell: &usize| matches!(self.kind(*cell).behaviour, Behaviour::ClockGate(_));
        (0..self.parts.cells.len()).filter(is_one).count()
    }
}

fn malformed(reason: impl Into<String>) -> NetlistError {
    NetlistError::Malformed(reason.into())
}

/// Bits of the input ports.
pub(crate) fn input_bits(ports: &[Port]) -> usize {
    ports.iter().filter(|port| port.input).map(|port| port.nets.len()).sum()
}

/// The first pin of each cell.
fn check(parts: &Parts) -> Result<Vec<u32>, NetlistError> {
    let nets = parts.capacitance.len();
    let inputs = 2 + input_bits(&parts.ports);
    let mut next = 2;
    for port in &parts.ports {
        for &net in &port.nets {
            if port.input && net as usize != next {
                return Err(malformed(format!("port {}: net {net} out of order", port.name)));
            }
            next += usize::from(port.input);
            if net as usize >= nets {
                return Err(malformed(format!("port {}: net {net} does not exist", port.name)));
            }
        }
    }
    let mut first_pin = Vec::with_capacity(parts.cells.len());
    let mut pin = 0usize;
    for (cell, &kind) in parts.cells.iter().enumerate() {
        let Some(kind) = parts.kinds.get(usize::from(kind)) else {
            return Err(malformed(format!("cell {cell} is of no kind")));
        };
        first_pin.push(u32::try_from(pin).map_err(|_| malformed("too many pins"))?);
        let Some(pins) = parts.pins.get(pin..pin + kind.pins()) else {
            return Err(malformed(format!("cell {cell} lacks pins")));
        };
        let (from, to) = pins.split_at(usize::from(kind.inputs));
        if from.iter().any(|pin| pin.net as usize >= nets) {
            return Err(malformed(format!("cell {cell} reads a net that does not exist")));
        }
        for pin in to {
            if pin.net as usize != next {
                return Err(malformed(format!("cell {cell} drives a net out of order")));
            }
            next += 1;
        }
        pin += kind.pins();
        if !matches!(kind.behaviour, Behaviour::Gate(_))
            && !(2..inputs).contains(&(parts.clock as usize))
        {
            return Err(malformed("flip-flops, but no clock among the inputs"));
        }
    }
    if pin != parts.pins.len() || next != nets {
        return Err(malformed("pins or nets are left over"));
    }
    let finite = |pin: &Pin| pin.rise_fj.is_finite() && pin.fall_fj.is_finite();
    if !parts.pins.iter().all(finite) || !parts.capacitance.iter().all(|c| c.is_finite()) {
        return Err(malformed("an energy or a capacitance is no number"));
    }
    check_clocks(parts, &first_pin)?;
    Ok(first_pin)
}

/// Every flip-flop has the clock or the output of a clock gate, every clock gate the clock, and
/// nobody else reads what comes out of a clock gate.
fn check_clocks(parts: &Parts, first_pin: &[u32]) -> Result<(), NetlistError> {
    if parts.clocks.len() != parts.cells.len() {
        return Err(malformed("not one clock for each cell"));
    }
    let kind = |cell: usize| &parts.kinds[usize::from(parts.cells[cell])];
    let inputs = |cell: usize| {
        let first = first_pin[cell] as usize;
        &parts.pins[first..first + usize::from(kind(cell).inputs)]
    };
    let mut gated = vec![false; parts.capacitance.len()];
    for (cell, &first) in first_pin.iter().enumerate() {
        if let Behaviour::ClockGate(_) = kind(cell).behaviour {
            let output = parts.pins[first as usize + usize::from(kind(cell).inputs)].net;
            gated[output as usize] = true;
        }
    }
    for (cell, &clock) in parts.clocks.iter().enumerate() {
        let fits = match kind(cell).behaviour {
            Behaviour::Gate(_) => clock == 0,
            Behaviour::ClockGate(_) => clock == parts.clock,
            Behaviour::FlipFlop(_) => {
                clock == parts.clock || gated.get(clock as usize) == Some(&true)
            }
        };
        if !fits {
            return Err(malformed(format!("cell {cell} has a clock that it cannot have")));
        }
        if inputs(cell).iter().any(|pin| gated[pin.net as usize]) {
            return Err(malformed(format!("cell {cell} reads the output of a clock gate")));
        }
    }
    let mut leaving = parts.ports.iter().flat_map(|port| &port.nets);
    if leaving.any(|net| gated[*net as usize]) {
        return Err(malformed("the output of a clock gate leaves through a port"));
    }
    Ok(())
}

/// Gates before each gate, or a gate on a loop.
fn levels(parts: &Parts, first_pin: &[u32]) -> Result<Vec<u32>, NetlistError> {
    let nets = parts.capacitance.len();
    let kind = |cell: usize| &parts.kinds[usize::from(parts.cells[cell])];
    let is_gate = |cell: usize| matches!(kind(cell).behaviour, Behaviour::Gate(_));
    let pins = |cell: usize| {
        let first = first_pin[cell] as usize;
        parts.pins[first..first + kind(cell).pins()].split_at(usize::from(kind(cell).inputs))
    };
    // Readers of each net, as lists in one array.
    let mut start = vec![0u32; nets + 1];
    let gates = || (0..parts.cells.len()).filter(|cell| is_gate(*cell));
    for cell in gates() {
        pins(cell).0.iter().for_each(|pin| start[pin.net as usize + 1] += 1);
    }
    for net in 0..nets {
        start[net + 1] += start[net];
    }
    let mut fill = start.clone();
    let mut readers = vec![0u32; start[nets] as usize];
    let mut missing = vec![0u32; parts.cells.len()];
    let mut driven_by_gate = vec![false; nets];
    for cell in gates() {
        pins(cell).1.iter().for_each(|pin| driven_by_gate[pin.net as usize] = true);
        for pin in pins(cell).0 {
            readers[fill[pin.net as usize] as usize] = cell as u32;
            fill[pin.net as usize] += 1;
        }
    }
    for cell in gates() {
        let waits = pins(cell).0.iter().filter(|pin| driven_by_gate[pin.net as usize]);
        missing[cell] = waits.count() as u32;
    }
    let mut level = vec![0u32; parts.cells.len()];
    let mut ready: Vec<u32> = gates().filter(|c| missing[*c] == 0).map(|c| c as u32).collect();
    while let Some(cell) = ready.pop() {
        let after = level[cell as usize] + 1;
        for pin in pins(cell as usize).1 {
            let net = pin.net as usize;
            for &reader in &readers[start[net] as usize..start[net + 1] as usize] {
                let reader_idx = reader as usize;
                level[reader_idx] = level[reader_idx].max(after);
                missing[reader_idx] -= 1;
                if missing[reader_idx] == 0 {
                    ready.push(reader);
                }
            }
        }
    }
    match gates().find(|cell| missing[*cell] > 0) {
        Some(cell) => Err(NetlistError::Loop { cell, kind: kind(cell).name.clone() }),
        None => Ok(level),
    }
}
