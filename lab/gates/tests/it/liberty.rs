//! Liberty and Yosys JSON: what is read, and what is refused.

use std::io::Write;

use powergs_gates::function::Function;
use powergs_gates::liberty::library::Library;
use powergs_gates::liberty::unpack;
use powergs_gates::price::{Conditions, price};
use powergs_gates::yosys::Mapped;
use proptest::prelude::*;

use super::toy;

fn refusal(text: &str) -> String {
    Library::parse(&[("x.lib", text)]).expect_err("refused").to_string()
}

#[test]
fn a_library_is_read() {
    let library = toy::library();
    let nand = &library.cells["NAND"];
    assert_eq!((nand.area, nand.leakage), (2.0, 2.0));
    assert_eq!(nand.inputs[1].capacitance, 2.0);
    assert_eq!(nand.outputs[0].arcs[0].fall.as_ref().expect("a table").at(0.7, 5.0), 0.35);
    // Beyond the last point the line goes on.
    assert_eq!(nand.outputs[0].powers[0].rise.as_ref().expect("a table").at(3.0, 0.0), 4.0);
    assert_eq!(library.corner, "nominal, 1 V, 25 C");
}

#[test]
fn units_are_brought_to_ns_ff_and_fj() {
    let text = toy::LIBRARY
        .replace(r#"time_unit : "1ns""#, r#"time_unit : "10ps""#)
        .replace("capacitive_load_unit (1, ff)", "capacitive_load_unit (0.5, pf)")
        .replace(r#"leakage_power_unit : "1nW""#, r#"leakage_power_unit : "1pW""#);
    let library = Library::parse(&[("x.lib", &text)]).expect("a library");
    let nand = &library.cells["NAND"];
    assert_eq!((nand.leakage, nand.inputs[0].capacitance), (0.002, 500.0));
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b, "{a}, not {b}");
    close(nand.outputs[0].arcs[0].rise.as_ref().expect("a table").at(0.0, 5000.0), 0.002);
    close(nand.outputs[0].powers[0].rise.as_ref().expect("a table").at(0.0, 0.0), 500.0);
}

#[test]
fn bad_libraries_are_refused_with_a_line() {
    assert!(refusal("").contains("empty"));
    assert!(refusal("module x;").contains("does not begin with `library`"));
    let half = &toy::LIBRARY[..1000];
    assert!(refusal(half).contains("truncated"), "{}", refusal(half));
    let deep = format!("library (x) {{ {}", "a () { ".repeat(100_000));
    assert!(refusal(&deep).contains("deeper than 32"));
    let numbers = toy::LIBRARY.replace(r#"values ("1, 2")"#, r#"values ("1, two")"#);
    assert_eq!(refusal(&numbers), "x.lib:25: `two` is no number");
    let missing = toy::LIBRARY.replace(r#"values ("1, 2")"#, r#"values ("1")"#);
    assert_eq!(refusal(&missing), "x.lib:25: a table of 1 values, 2 are expected");
    let axis = toy::LIBRARY.replace(r#"index_1 ("0, 1")"#, r#"index_1 ("1, 1")"#);
    assert!(refusal(&axis).contains("do not ascend"));
    assert!(refusal("library (x) { cell (A) { area : 1; } }").contains("no `nom_voltage`"));
    assert!(refusal("library (x) { nom_voltage : 1e9; }").contains("outside of 0.05 to 50 V"));
    let unit = toy::LIBRARY.replace(r#""1ns""#, r#""1 parsec""#);
    assert!(refusal(&unit).contains("unknown unit"));
    let twice = Library::parse(&[("a.lib", toy::LIBRARY), ("b.lib", toy::LIBRARY)]);
    assert!(twice.expect_err("refused").to_string().contains("in an earlier file too"));
}

#[test]
fn sizes_below_zero_and_numbers_beyond_belief_are_refused_with_their_line() {
    let text = include_str!("../data/invented.lib");
    let refused = |from: &str, to: &str, says: &str| {
        let place = text.find(from).unwrap_or_else(|| panic!("{from}"));
        let said = refusal(&text.replacen(from, to, 1));
        let line = text[..place].matches('\n').count() + 1;
        assert!(said.starts_with(&format!("x.lib:{line}: ")), "{said}");
        assert!(said.contains(says), "{said}");
    };
    refused("(INV) { area : 1;", "(INV) { area : -100;", "`area` is below zero");
    refused("cell_leakage_power : 1;", "cell_leakage_power : 1e308;", "`1e308` is above 1e12");
    refused("cell_leakage_power : 1;", "cell_leakage_power : -1;", "is below zero");
    refused(
        "direction : input; capacitance : 1;",
        "direction : input; capacitance : -50;",
        "below",
    );
    refused("(short) { capacitance : 0.5;", "(short) { capacitance : -5;", "below zero");
    refused("(INV) { area : 1;", "(INV) { area : inf;", "`inf` is no number");
    refused(r#"leakage_power_unit : "1nW""#, r#"leakage_power_unit : "1MW""#, "unknown unit");
}

#[test]
fn what_the_ground_pin_sees_is_not_counted_again() {
    let from = r#"cell (NAND) { area : 2;
    leakage_power () { when : "!A"; value : 1; }"#;
    let to = r#"cell (NAND) { area : 2;
    pg_pin (VSS) { pg_type : primary_ground; } pg_pin (VDD) { pg_type : primary_power; }
    leakage_power () { when : "!A"; value : 1; related_pg_pin : VDD; }
    leakage_power () { when : "!A"; value : 9; related_pg_pin : VSS; }"#;
    let text = toy::LIBRARY.replace(from, to).replacen(
        r#"internal_power () { related_pin : "A";"#,
        r#"internal_power () { related_pin : "A"; related_pg_pin : VSS;
           rise_power (p) { values ("9, 9"); } } internal_power () { related_pin : "A";"#,
        1,
    );
    let library = Library::parse(&[("x.lib", &text)]).expect("a library");
    let nand = &library.cells["NAND"];
    // One state has a supply pin, the other none: they are two kinds of leakage.
    assert_eq!((nand.leakage, nand.outputs[0].powers.len()), (4.0, 2));
}

#[test]
fn a_library_without_power_tables_is_refused() {
    let text = "library (x) { nom_voltage : 1; cell (I) { pin (A) { direction : input; } \
                pin (Y) { direction : output; function : \"!A\"; } } }";
    assert!(refusal(text).contains("no cell has tables of internal power"));
}

#[test]
fn clock_gates_of_other_kinds_are_not_supported() {
    let reason = |from: &str, to: &str| {
        let text = toy::LIBRARY.replace(from, to);
        let library = Library::parse(&[("x.lib", &text)]).expect("a library");
        library.cells["GATE"].unsupported.clone().unwrap_or_default()
    };
    assert_eq!(reason("", ""), "");
    let falling = reason("latch_posedge_precontrol", "latch_negedge");
    assert_eq!(falling, "it is a clock gate `latch_negedge`");
    let none = "it is a clock gate without clock and enable pin";
    assert_eq!(reason("clock_gate_clock_pin : true;", ""), none);
    let enables = ["clock_gate_enable_pin", "clock_gate_test_pin"];
    let text = enables.iter().fold(toy::LIBRARY.to_owned(), |text, mark| text.replace(mark, "x"));
    let library = Library::parse(&[("x.lib", &text)]).expect("a library");
    assert_eq!(library.cells["GATE"].unsupported.as_deref(), Some(none));
    let silent = reason(r#"clock_gating_integrated_cell : "latch_posedge_precontrol";"#, "");
    assert_eq!(silent, "it has a `statetable`");
}

#[test]
fn the_invented_cells_can_all_be_simulated() {
    let text = include_str!("../data/invented.lib");
    let library = Library::parse(&[("invented.lib", text)]).expect("a library");
    assert_eq!(library.cells.len(), 10);
    assert!(library.cells.values().all(|cell| cell.unsupported.is_none()));
    assert_eq!(library.wires.as_ref().expect("wires").capacitance(3), 1.75);
    let circuit = include_str!("../data/gated.json");
    let mapped = Mapped::parse("gated.json", circuit).expect("a netlist");
    let conditions = Conditions {
        library: "invented".to_owned(),
        period_ns: 1.0,
        critical_path_ns: 0.0,
        clock_transition_ns: 0.05,
        input_transition_ns: 0.05,
        load_ff: 5.0,
    };
    let netlist = price(&mapped, &library, &conditions).expect("a priced netlist").netlist;
    assert_eq!((netlist.flip_flops(), netlist.gated_flip_flops()), (2, 2));
    // Two pins of 1 fF behind the gate, and a wire of length 2.
    assert_eq!(netlist.parts().capacitance[netlist.parts().clocks[0] as usize], 3.0);
}

#[test]
fn packed_files_are_unpacked_and_bombs_are_not() {
    let pack = |bytes: &[u8]| {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        packer.write_all(bytes).expect("memory");
        packer.finish().expect("memory")
    };
    assert_eq!(unpack("x", &pack(b"library")).expect("text"), "library");
    assert_eq!(unpack("x", b"library").expect("text"), "library");
    let mut cut = pack(toy::LIBRARY.as_bytes());
    cut.truncate(cut.len() / 2);
    assert!(unpack("x", &cut).expect_err("refused").to_string().contains("damaged"));
    let mut bomb = Vec::new();
    let part = pack(&vec![b' '; 64 << 20]);
    (0..5).for_each(|_| bomb.extend(&part));
    assert!(unpack("x", &bomb).expect_err("refused").to_string().contains("larger than 256 MiB"));
    assert!(unpack("x", &[0xff]).expect_err("refused").to_string().contains("not UTF-8"));
}

#[test]
fn functions_follow_libertys_precedence() {
    let pins: Vec<String> = ["A", "B", "C"].map(str::to_owned).to_vec();
    let table = |text: &str| {
        let function = Function::parse(text, &pins).expect(text);
        (function.evaluate(|input| [0xaa, 0xcc, 0xf0][input]) & 0xff) as u8
    };
    assert_eq!(table("A + B C"), 0xaa | (0xcc & 0xf0));
    assert_eq!(table("!A B'"), !0xaa & !0xcc);
    assert_eq!(table("A & B ^ C"), 0xaa & (0xcc ^ 0xf0));
    assert_eq!(table("!(A|B)*(C^1)"), !(0xaa | 0xcc) & !0xf0);
    for bad in ["", "A +", "(A", "A)", "D", "A $ B", "!"] {
        assert!(Function::parse(bad, &pins).is_err(), "{bad}");
    }
    assert!(Function::parse(&"(".repeat(1 << 20), &pins).is_err());
    assert!(Function::parse(&"!".repeat(1 << 20), &pins).is_err());
}

#[test]
fn bad_json_is_refused() {
    let refusal = |text: &str| Mapped::parse("x.json", text).expect_err("refused").to_string();
    assert!(refusal("{").contains("truncated"));
    assert!(refusal(&"[".repeat(1 << 20)).contains("no JSON"));
    assert!(refusal("{}").contains("not written by Yosys"));
    assert!(refusal(r#"{"modules": {"a": {}, "b": {}}}"#).contains("none is top"));
    let vector = toy::counter().replace(r#""Y": [6]"#, r#""Y": [6, 8]"#);
    assert!(refusal(&vector).contains("is a vector"));
    let far = toy::counter().replace(": [3]", ": [4294967295]");
    assert_eq!(Mapped::parse("x.json", &far).expect("a netlist").nets, 8);
    let huge = toy::counter().replace(r#""Y": [6]"#, r#""Y": [99999999999]"#);
    assert!(refusal(&huge).contains("no bit of a netlist"));
}

proptest! {
    #[test]
    fn damaged_libraries_never_panic(at in 0..toy::LIBRARY.len(), with in "[(){};:\"a0 \n]{0,3}") {
        let mut text = toy::LIBRARY.to_owned();
        text.replace_range(at..at + 1, &with);
        let _ = Library::parse(&[("x.lib", &text)]);
        let _ = Library::parse(&[("x.lib", &toy::LIBRARY[..at])]);
    }
}
