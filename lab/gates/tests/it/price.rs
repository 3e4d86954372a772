//! Prices of a circuit that can be priced by hand.

use powergs_gates::netlist::Behaviour;

use super::toy::{circuit, counter, gated, priced};

/// The energies of the pins of the cell of `kind`: rise and fall of each.
fn energies(json: &str, kind: &str) -> Vec<(f32, f32)> {
    let netlist = priced(json).expect("a netlist").netlist;
    let cells = 0..netlist.parts().cells.len();
    let cell = cells.into_iter().find(|cell| netlist.kind(*cell).name == kind).expect("a cell");
    let (inputs, outputs) = netlist.pins(cell);
    inputs.iter().chain(outputs).map(|pin| (pin.rise_fj, pin.fall_fj)).collect()
}

#[test]
fn toggles_cost_what_the_tables_say_at_slew_and_load() {
    let json = circuit(
        &[("a", "input", &[2]), ("b", "input", &[3]), ("y", "output", &[5])],
        &[
            ("first", "NAND", &[("A", 2), ("B", 3), ("Y", 4)]),
            ("second", "XOR", &[("A", 4), ("B", 3), ("Y", 5)]),
        ],
    );
    // A and B cause as many changes of the output; both have a slew of 0.5 ns: means of 1.5 and
    // 5.5, 3.5 and 7.5. Energy at B alone holds in half of the states.
    let expected = [(0.0, 0.0), (0.25, 0.125), (3.5, 5.5)];
    assert_eq!(energies(&json, "NAND"), expected);
    let netlist = priced(&json).expect("a netlist").netlist;
    // Net 4 of the file: pin A of the second gate. The output port: its load.
    assert_eq!(netlist.parts().capacitance, [0.0, 0.0, 1.0, 3.0, 1.0, 10.0]);
    assert_eq!((netlist.area(), netlist.leakage()), (5.0, 6.0));
}

#[test]
fn transition_times_go_through_the_gates() {
    let json = circuit(
        &[("a", "input", &[2]), ("b", "input", &[3]), ("y", "output", &[5])],
        &[
            ("first", "NAND", &[("A", 2), ("B", 3), ("Y", 4)]),
            ("second", "NAND", &[("A", 4), ("B", 4), ("Y", 5)]),
        ],
    );
    let netlist = priced(&json).expect("a netlist").netlist;
    let last = netlist.pins(1).1[0];
    // Net 4 carries 3 fF: it rises in 0.13 and falls in 0.33 ns. An output rises when inputs fall.
    let at = |rise: f64, fall: f64| ((1.0 + 5.0) / 2.0 + fall, (3.0 + 7.0) / 2.0 + rise);
    let (rise, fall) = at(0.13, 0.33);
    let close = |a: f32, b: f64| assert!((f64::from(a) - b).abs() < 0.002 * b, "{a}, not {b}");
    close(last.rise_fj, rise);
    close(last.fall_fj, fall);
}

#[test]
fn clocks_have_a_price_for_bits_that_stay_and_for_bits_that_change() {
    let netlist = priced(&counter()).expect("a netlist").netlist;
    let Behaviour::FlipFlop(kind) = &netlist.kind(0).behaviour else { panic!("flip-flops first") };
    assert_eq!((kind.idle_fj, kind.change_fj, kind.clock_ff), (3.0, 12.0, 1.0));
    assert_eq!(energies(&counter(), "DFF"), [(0.0, 0.0), (10.0, 20.0), (0.0, 0.0)]);
    assert_eq!(netlist.flip_flops(), 2);
}

#[test]
fn circuits_that_cannot_be_are_refused() {
    let refusal = |json: &str| priced(json).expect_err("refused").to_string();
    let change = |from: &str, to: &str| counter().replacen(from, to, 1);
    let unknown = change(r#""type": "XOR""#, r#""type": "XOR9""#);
    assert!(refusal(&unknown).contains("cell carry is a XOR9, which no Liberty file has"));
    let latch = change(r#""type": "NAND""#, r#""type": "LATCH""#);
    assert!(refusal(&latch).contains("cannot be simulated, it has a `latch`"));
    let looped = change(r#""A": [3],"B": [5],"Y": [6]"#, r#""A": [7],"B": [5],"Y": [6]"#);
    let looped =
        looped.replacen(r#""A": [3],"B": [4],"Y": [7]"#, r#""A": [6],"B": [4],"Y": [7]"#, 1);
    assert!(refusal(&looped).contains("is on a combinational loop"), "{}", refusal(&looped));
    let gated = change(r#""D": [6],"C": [2]"#, r#""D": [6],"C": [7]"#);
    assert!(refusal(&gated).contains("its clock is derived or a second one"));
    let open = change(r#""A": [3],"B": [5],"#, r#""A": [3],"#);
    assert!(refusal(&open).contains("input B is open"));
    let undriven = change(r#""A": [3],"B": [5]"#, r#""A": [3],"B": [9]"#);
    assert!(refusal(&undriven).contains("nobody drives"));
    let twice = change(r#""Y": [7]"#, r#""Y": [6]"#);
    assert!(refusal(&twice).contains("drives a net that is driven"));
    let clocked = change(r#""A": [3],"B": [5]"#, r#""A": [2],"B": [5]"#);
    assert!(refusal(&clocked).contains("reads a net that is a clock"));
}

#[test]
fn cycles_of_clock_gates_have_their_price() {
    // Closed: both edges of the clock without its enable. Open: both edges of the output with it.
    // The clock falls at 3 instead of 1 where the enable rose behind its edge, and the output at 16
    // instead of 8 where it fell.
    let netlist = priced(&gated()).expect("a netlist").netlist;
    let Behaviour::ClockGate(kind) = &netlist.kind(1).behaviour else { panic!("a clock gate") };
    assert_eq!((kind.closed_fj, kind.clock_ff), (1.5, 3.0));
    let enable = (0.125 + 3.0 - 1.0, 0.25 + 16.0 - 8.0);
    let test = (3.0 - 1.0, 16.0 - 8.0);
    assert_eq!(energies(&gated(), "GATE"), [enable, test, (6.0, 8.0)].map(|(r, f)| (r, f)));
    // The clock drives the gate alone, the gate the flip-flop.
    let (clock, behind) = (netlist.parts().clock as usize, netlist.parts().clocks[0] as usize);
    let capacitance = &netlist.parts().capacitance;
    assert_eq!((capacitance[clock], capacitance[behind]), (3.0, 1.0));
    let counts = (netlist.flip_flops(), netlist.gated_flip_flops(), netlist.clock_gates());
    assert_eq!(counts, (1, 1, 1));
}

#[test]
fn clocks_behind_gates_are_clocks_alone() {
    let refusal = |from: &str, to: &str| {
        priced(&gated().replacen(from, to, 1)).expect_err("refused").to_string()
    };
    let read = refusal(r#""A": [4],"B": [5]"#, r#""A": [7],"B": [5]"#);
    assert!(read.contains("input A reads a net that is a clock"), "{read}");
    let twice = refusal(r#""S": [8],"C": [2]"#, r#""S": [8],"C": [7]"#);
    assert!(twice.contains("through one clock gate at most"), "{twice}");
    let leaves = refusal(r#""bits": [4]"#, r#""bits": [7]"#);
    assert!(leaves.contains("the output of a clock gate leaves"), "{leaves}");
    let open = refusal(r#""S": [8],"C": [2]"#, r#""S": [8]"#);
    assert!(open.contains("its clock pin C is open"), "{open}");
}
