//! Netlists of Yosys: any text is a circuit of the invented cells, which runs, or an error.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use powergs_gates::energy;
use powergs_gates::liberty::library::Library;
use powergs_gates::price::{Conditions, price};
use powergs_gates::simulator::Simulator;
use powergs_gates::yosys::Mapped;

static LIBRARY: LazyLock<Library> = LazyLock::new(|| {
    let text = include_str!("../../lab/gates/tests/data/invented.lib");
    Library::parse(&[("invented.lib", text)]).expect("a library")
});

fuzz_target!(|text: &str| {
    let Ok(mapped) = Mapped::parse("x.json", text) else { return };
    let conditions = Conditions {
        library: "invented".to_owned(),
        period_ns: 1.0,
        critical_path_ns: 0.0,
        clock_transition_ns: 0.1,
        input_transition_ns: 0.1,
        load_ff: 5.0,
    };
    let Ok(priced) = price(&mapped, &LIBRARY, &conditions) else { return };
    let mut simulator = Simulator::new(&priced.netlist);
    simulator.settle();
    simulator.clock();
    let _ = energy::of(&priced.netlist, &simulator.toggles());
});
