//! A library and circuits that are small enough to price by hand.

use powergs_gates::liberty::library::Library;
use powergs_gates::price::{Conditions, PriceError, Priced, price};
use powergs_gates::yosys::Mapped;

/// Two gates, a tie cell and a flip-flop. Transition times are 0.1 + 0.01 x load; internal energies
/// are single numbers, 1 V.
pub const LIBRARY: &str = r#"
library (toy) {
  time_unit : "1ns"; voltage_unit : "1V"; capacitive_load_unit (1, ff);
  leakage_power_unit : "1nW"; nom_voltage : 1.0; nom_temperature : 25;
  /* a comment
     of two lines */
  lu_table_template (t) { variable_1 : input_net_transition; index_1 ("0, 1");
    variable_2 : total_output_net_capacitance; index_2 ("0, 10"); }
  power_lut_template (p) { variable_1 : input_transition_time; index_1 ("0, 1"); }
  cell (NAND) { area : 2;
    leakage_power () { when : "!A"; value : 1; }
    leakage_power () { when : "A"; value : 3; }
    pin (A) { direction : input; capacitance : 1; }
    pin (B) { direction : input; capacitance : 2;
      internal_power () { when : "!A"; rise_power (scalar) { values ("0.5"); }
        fall_power (scalar) { values ("0.25"); } } }
    pin (Y) { direction : output; function : "!(A B)";
      timing () { related_pin : "A"; timing_sense : negative_unate;
        rise_transition (t) { values ("0.1, 0.2", "0.1, 0.2"); }
        fall_transition (t) { values ("0.3, 0.4", "0.3, 0.4"); } }
      timing () { related_pin : "B"; timing_sense : negative_unate;
        rise_transition (t) { values ("0.1, 0.2", "0.1, 0.2"); }
        fall_transition (t) { values ("0.3, 0.4", "0.3, 0.4"); } }
      internal_power () { related_pin : "A";
        rise_power (p) { values ("1, 2"); } fall_power (p) { values ("3, 4"); } }
      internal_power () { related_pin : "B";
        rise_power (p) { values ("5, 6"); } fall_power (p) { values ("7, 8"); } }
    }
  }
  cell (XOR) { area : 3; cell_leakage_power : 4;
    pin (A) { direction : input; capacitance : 1; }
    pin (B) { direction : input; capacitance : 1; }
    pin (Y) { direction : output; function : "A ^ B"; } }
  cell (HIGH) { area : 1; pin (Y) { direction : output; function : "1"; } }
  cell (DFF) { area : 5;
    ff (IQ, IQN) { next_state : "D"; clocked_on : "C"; }
    pin (D) { direction : input; capacitance : 1; }
    pin (C) { direction : input; capacitance : 1; clock : true;
      internal_power () { when : "D & Q | !D & !Q"; rise_power (scalar) { values ("1"); }
        fall_power (scalar) { values ("2"); } }
      internal_power () { when : "D & !Q | !D & Q"; rise_power (scalar) { values ("4"); }
        fall_power (scalar) { values ("8"); } } }
    pin (Q) { direction : output; function : "IQ";
      timing () { related_pin : "C"; timing_type : rising_edge;
        rise_transition (t) { values ("0.1, 0.2", "0.1, 0.2"); }
        fall_transition (t) { values ("0.1, 0.2", "0.1, 0.2"); } }
      internal_power () { related_pin : "C"; rise_power (scalar) { values ("10"); }
        fall_power (scalar) { values ("20"); } } }
    pin (QN) { direction : output; function : "IQN"; }
  }
  cell (GATE) { area : 6; clock_gating_integrated_cell : "latch_posedge_precontrol";
    statetable ("C E S", "IQ") { table : "L L L : - : L, L H - : - : H,
      L - H : - : H, H - - : - : N"; }
    pin (IQ) { direction : internal; internal_node : "IQ"; }
    pin (E) { direction : input; capacitance : 1; clock_gate_enable_pin : true;
      internal_power () { when : "C & !Z"; rise_power (scalar) { values ("0.125"); }
        fall_power (scalar) { values ("64"); } }
      internal_power () { when : "C & Z"; rise_power (scalar) { values ("64"); }
        fall_power (scalar) { values ("0.25"); } }
      internal_power () { when : "!C"; rise_power (scalar) { values ("64"); }
        fall_power (scalar) { values ("64"); } } }
    pin (S) { direction : input; capacitance : 1; clock_gate_test_pin : true; }
    pin (C) { direction : input; capacitance : 3; clock_gate_clock_pin : true;
      internal_power () { when : "!E & !S & !Z"; rise_power (scalar) { values ("0.5"); }
        fall_power (scalar) { values ("1"); } }
      internal_power () { when : "(E | S) & !Z"; rise_power (scalar) { values ("0"); }
        fall_power (scalar) { values ("3"); } } }
    pin (Z) { direction : output; state_function : "C & IQ"; clock_gate_out_pin : true;
      internal_power () { related_pin : "C"; when : "!E & !S";
        rise_power (scalar) { values ("0"); }
        fall_power (scalar) { values ("16"); } }
      internal_power () { related_pin : "C"; when : "E | S"; rise_power (scalar) { values ("6"); }
        fall_power (scalar) { values ("8"); } } }
  }
  cell (LATCH) { area : 4; latch (IQ, IQN) { enable : "E"; data_in : "D"; }
    pin (D) { direction : input; } pin (E) { direction : input; }
    pin (Q) { direction : output; function : "IQ"; } }
}
"#;

/// The library, read.
pub fn library() -> Library {
    Library::parse(&[("toy.lib", LIBRARY)]).expect("a library")
}

/// A cell: its name, its kind, and the net of each pin.
pub type Cell<'a> = (&'a str, &'a str, &'a [(&'a str, u32)]);

/// A netlist of `cells` (name, kind, pins with nets) and `ports` (name, direction, nets).
pub fn circuit(ports: &[(&str, &str, &[u32])], cells: &[Cell]) -> String {
    let port = |(name, direction, nets): &(&str, &str, &[u32])| {
        format!(r#""{name}": {{"direction": "{direction}", "bits": {nets:?}}}"#)
    };
    let cell = |(name, kind, pins): &Cell| {
        let pins: Vec<String> =
            pins.iter().map(|(pin, net)| format!(r#""{pin}": [{net}]"#)).collect();
        format!(r#""{name}": {{"type": "{kind}", "connections": {{{}}}}}"#, pins.join(","))
    };
    let ports: Vec<String> = ports.iter().map(port).collect();
    let cells: Vec<String> = cells.iter().map(cell).collect();
    format!(
        r#"{{"modules": {{"toy": {{"ports": {{{}}}, "cells": {{{}}}}}}}}}"#,
        ports.join(","),
        cells.join(",")
    )
}

/// Prices a circuit with the toy library: clock transition 0, inputs 0.5 ns, outputs 10 fF.
pub fn priced(json: &str) -> Result<Priced, PriceError> {
    let mapped = Mapped::parse("toy.json", json).expect("a netlist");
    let conditions = Conditions {
        library: "toy".to_owned(),
        period_ns: 1.0,
        critical_path_ns: 0.0,
        clock_transition_ns: 0.0,
        input_transition_ns: 0.5,
        load_ff: 10.0,
    };
    price(&mapped, &library(), &conditions)
}

/// A bit that inverts itself where `on` is 1, its clock gated, and the clock's gate itself.
pub fn gated() -> String {
    circuit(
        &[("clk", "input", &[2]), ("on", "input", &[3]), ("bit", "output", &[4])],
        &[
            ("one", "HIGH", &[("Y", 5)]),
            ("low", "NAND", &[("A", 5), ("B", 5), ("Y", 8)]),
            ("flip", "NAND", &[("A", 4), ("B", 5), ("Y", 6)]),
            ("gate", "GATE", &[("E", 3), ("S", 8), ("C", 2), ("Z", 7)]),
            ("bit", "DFF", &[("D", 6), ("C", 7), ("Q", 4)]),
        ],
    )
}

/// A counter of two bits: the low one inverts itself, the high one takes the exclusive or.
pub fn counter() -> String {
    circuit(
        &[("clk", "input", &[2]), ("low", "output", &[3]), ("high", "output", &[4])],
        &[
            ("one", "HIGH", &[("Y", 5)]),
            ("flip", "NAND", &[("A", 3), ("B", 5), ("Y", 6)]),
            ("carry", "XOR", &[("A", 3), ("B", 4), ("Y", 7)]),
            ("low", "DFF", &[("D", 6), ("C", 2), ("Q", 3)]),
            ("high", "DFF", &[("D", 7), ("C", 2), ("Q", 4)]),
        ],
    )
}
