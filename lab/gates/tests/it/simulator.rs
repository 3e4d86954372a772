//! The simulator on circuits whose behaviour and toggles are known.

use powergs_gates::energy;
use powergs_gates::function::Function;
use powergs_gates::simulator::Simulator;

use super::toy::{circuit, counter, gated, priced};

#[test]
fn a_counter_counts_and_its_toggles_are_priced() {
    let netlist = priced(&counter()).expect("a netlist").netlist;
    let mut simulator = Simulator::new(&netlist);
    let net = |name: &str| netlist.port(name).expect("a port").nets[0];
    for count in 0..8u64 {
        simulator.settle();
        let bit = |name: &str| simulator.get(net(name)) & 1;
        assert_eq!(bit("low") + 2 * bit("high"), count % 4);
        assert!([0, !0].contains(&simulator.get(net("low"))), "all lanes do the same");
        simulator.clock();
    }
    let toggles = simulator.toggles();
    assert_eq!(toggles.lane_cycles, 8 * 64);
    let rises = |name: &str| toggles.rises[net(name) as usize];
    assert_eq!((rises("low"), rises("high")), (4 * 64, 2 * 64));
    let energy = energy::of(&netlist, &toggles);
    // Bits change 12 times in 16 flip-flop cycles; the low one rises and falls 4 times.
    assert_eq!(energy.clock_pins, 64.0 * (12.0 * 12.0 + 4.0 * 3.0));
    assert_eq!(energy.flip_flops, 64.0 * 6.0 * (10.0 + 20.0));
    // A clock net of two pins of 1 fF at 1 V, charged every cycle.
    assert_eq!(energy.clock_net, 64.0 * 8.0 * 2.0);
}

#[test]
fn a_gated_flip_flop_takes_what_is_in_front_only_where_its_gate_is_open() {
    let netlist = priced(&gated()).expect("a netlist").netlist;
    let mut simulator = Simulator::new(&netlist);
    let net = |name: &str| netlist.port(name).expect("a port").nets[0];
    // Lane 0 closed, 1 open, 2 every other cycle, 3 the other ones, the rest closed.
    let mut expected = 0u64;
    for cycle in 0..8u64 {
        let on = 0b0010 | if cycle % 2 == 0 { 0b0100 } else { 0b1000 };
        simulator.set(net("on"), on);
        simulator.settle();
        assert_eq!(simulator.get(net("bit")), expected);
        simulator.clock();
        expected ^= on;
    }
    let toggles = simulator.toggles();
    let behind = netlist.parts().clocks[0] as usize;
    assert_eq!((toggles.rises[behind], toggles.falls[behind]), (16, 16));
    let energy = energy::of(&netlist, &toggles);
    // 16 of 512 cycles are open; 16 changes of the bit are all of them. The enable rises 1 + 4 + 4
    // times and falls 4 + 3 times.
    assert_eq!(energy.clock_pins, 16.0 * 12.0);
    let gate = 496.0 * 1.5 + 16.0 * (6.0 + 8.0) + 9.0 * 2.125 + 7.0 * 8.25;
    assert_eq!(energy.clock_gates, gate);
    // The clock charges the gate's 3 fF in every cycle, the gate its 1 fF where it is open.
    assert_eq!((energy.clock_net, energy.gated_nets), (512.0 * 3.0, 16.0));
    assert_eq!(energy.clock(), energy.clock_pins + gate + 512.0 * 3.0 + 16.0);
    assert_eq!(energy.total(), energy.without_clock() + energy.clock());
    // Always open: the flip-flop's pin costs 3 in a cycle without a change, the gate 14.
    let ungated = 496.0 * 3.0 + 16.0 * 12.0 + 512.0 * (14.0 + 1.0 + 3.0);
    assert_eq!(energy.clock_ungated, ungated);
    assert_eq!(energy.total_ungated(), energy.without_clock() + ungated);
}

#[test]
fn without_gates_the_ungated_sum_is_the_same() {
    let netlist = priced(&counter()).expect("a netlist").netlist;
    let mut simulator = Simulator::new(&netlist);
    for _ in 0..5 {
        simulator.settle();
        simulator.clock();
    }
    let energy = energy::of(&netlist, &simulator.toggles());
    assert!(energy.clock() > 0.0 && energy.clock() == energy.clock_ungated);
    assert_eq!(energy.total(), energy.total_ungated());
}

#[test]
fn every_function_of_up_to_four_inputs_is_computed() {
    let pins: Vec<String> = ["A", "B", "C", "D"].map(str::to_owned).to_vec();
    for text in [
        "A",
        "!A",
        "A^B",
        "A'B",
        "(A B)'",
        "A B + C'",
        "!((A+B) C)",
        "A B + !A C",
        "A^B^C",
        "!(A B C D)",
        "A B + C D",
        "!((A B + C) D)",
        "A ^ B C + D'",
        "A B' C D'",
    ] {
        let json = circuit(
            &[("i", "input", &[2, 3, 4, 5]), ("y", "output", &[6])],
            &[("gate", "ANY", &[("A", 2), ("B", 3), ("C", 4), ("D", 5), ("Y", 6)])],
        );
        let mapped = powergs_gates::yosys::Mapped::parse("x.json", &json).expect("a netlist");
        let pin = |name: &String| format!("pin ({name}) {{ direction : input; }}");
        let text_of_pins: Vec<String> = pins.iter().map(pin).collect();
        let library = format!(
            "library (x) {{ nom_voltage : 1; cell (ANY) {{ {} pin (Y) {{ direction : output; \
             function : \"{text}\"; internal_power () {{ rise_power (scalar) {{ values (\"1\"); \
             }} }} }} }} }}",
            text_of_pins.join(" ")
        );
        let library = powergs_gates::liberty::library::Library::parse(&[("x.lib", &library)]);
        let conditions = powergs_gates::price::Conditions {
            library: String::new(),
            period_ns: 1.0,
            critical_path_ns: 0.0,
            clock_transition_ns: 0.0,
            input_transition_ns: 0.0,
            load_ff: 0.0,
        };
        let library = library.expect("a library");
        let priced = powergs_gates::price::price(&mapped, &library, &conditions);
        let netlist = priced.expect("a netlist").netlist;
        let mut simulator = Simulator::new(&netlist);
        let columns = [0xaaaa, 0xcccc, 0xf0f0, 0xff00];
        for (net, column) in netlist.port("i").expect("a port").nets.iter().zip(columns) {
            simulator.set(*net, column);
        }
        simulator.settle();
        let expected = Function::parse(text, &pins).expect(text).evaluate(|input| columns[input]);
        assert_eq!(simulator.get(netlist.port("y").expect("a port").nets[0]), expected, "{text}");
    }
}

#[test]
fn counting_begins_where_it_is_told() {
    let netlist = priced(&counter()).expect("a netlist").netlist;
    let mut simulator = Simulator::new(&netlist);
    simulator.settle();
    simulator.clock();
    simulator.count_anew();
    assert_eq!(simulator.cycles(), 0);
    let toggles = simulator.toggles();
    assert!(toggles.rises.iter().chain(&toggles.falls).all(|count| *count == 0));
}
