//! Liberty files: any bytes are a library or an error, and every cell of a library has a price in a
//! circuit of its own or is refused.
#![no_main]

use libfuzzer_sys::fuzz_target;
use powergs_gates::energy;
use powergs_gates::liberty::library::{Cell, Library};
use powergs_gates::liberty::unpack;
use powergs_gates::price::{Conditions, price};
use powergs_gates::simulator::Simulator;
use powergs_gates::yosys::{Instance, Mapped, Port};

/// One cell between ports.
fn alone(kind: &str, cell: &Cell) -> Mapped {
    let mut nets = 2..;
    let mut ports = Vec::new();
    let mut pins = Vec::new();
    let inputs = cell.inputs.iter().map(|pin| (&pin.name, true));
    for (name, input) in inputs.chain(cell.outputs.iter().map(|pin| (&pin.name, false))) {
        let net = nets.next().expect("a number");
        ports.push(Port { name: name.clone(), input, nets: vec![net] });
        pins.push((name.clone(), net));
    }
    let instance = Instance { name: "cell".to_owned(), kind: kind.to_owned(), pins };
    let nets = nets.next().expect("a number");
    Mapped { name: "alone".to_owned(), nets, ports, cells: vec![instance] }
}

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = unpack("x.lib", bytes) else { return };
    let Ok(library) = Library::parse(&[("x.lib", &text)]) else { return };
    let conditions = Conditions {
        library: String::new(),
        period_ns: 1.0,
        critical_path_ns: 0.0,
        clock_transition_ns: 0.1,
        input_transition_ns: 0.1,
        load_ff: 5.0,
    };
    for (kind, cell) in &library.cells {
        let Ok(priced) = price(&alone(kind, cell), &library, &conditions) else { continue };
        let mut simulator = Simulator::new(&priced.netlist);
        simulator.settle();
        simulator.clock();
        let _ = energy::of(&priced.netlist, &simulator.toggles());
    }
});
