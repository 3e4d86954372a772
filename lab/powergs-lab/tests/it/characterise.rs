//! `characterise`: prices of the sorting units from a trace.

use std::fs;

use assert_cmd::Command;
use powergs_scene::synth::{Preset, generate};
use powergs_testkit::scene_files::{ply, sample};
use predicates::str::contains;

fn run(words: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-lab"));
    command
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .arg("characterise")
        .args(words)
        .assert()
}

#[test]
fn prices_hold_on_lists_that_were_held_out() {
    for (unit, library) in [("qsu", "45nm"), ("qsu", "7nm"), ("bsu", "7nm")] {
        let words = [unit, "--library", library, "--trace", "traces/demo.bin", "--frames", "0..3"];
        let done = run(&[&words[..], &["--json"]].concat()).success();
        let found: serde_json::Value =
            serde_json::from_slice(&done.get_output().stdout).expect("JSON");
        let number = |name: &str| found[name].as_f64().expect("a number");
        assert!(number("held_out").abs() < 0.05, "{found}");
        let actions = found["actions"].as_array().expect("actions");
        let named = |name: &str| actions.iter().find(|action| action["action"] == name);
        let cycle = named("cycle").expect("a cycle")["energy_pj"].as_f64().expect("a number");
        assert!(0.0 < cycle && cycle < number("energy_per_cycle_pj"), "{found}");
    }
}

#[test]
fn the_table_is_toml_and_is_not_written_over() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("qsu.toml");
    let file = path.to_str().expect("UTF-8");
    let words =
        ["qsu", "--library", "45nm", "--trace", "traces/demo.bin", "--frames", "0..3", "-o", file];
    run(&words).success().stdout(contains("held out"));
    let text = fs::read_to_string(&path).expect("a table");
    let table: toml::Table = text.parse().expect("TOML");
    assert_eq!(table["library"].as_str(), Some("nangate45"));
    assert!(table["actions"]["key"]["energy"].as_str().expect("an energy").ends_with(" pJ"));
    run(&words).code(2).stderr(contains("exists already"));
    run(&[&words[..], &["--force"]].concat()).success();
    assert_eq!(fs::read_to_string(&path).expect("a table"), text);
}

#[test]
fn a_rendering_core_is_priced_on_a_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("a.ply");
    fs::write(&scene, ply(&sample(400, 1))).expect("a scene");
    let scene = scene.to_str().expect("UTF-8");
    let words = |format: &'static str| {
        ["vrc", "--library", "7nm", "--scene", scene, "--orbit", "4", "--size", "128x96"]
            .into_iter()
            .chain(["--format", format, "--json"])
            .collect::<Vec<_>>()
    };
    let of = |format| -> serde_json::Value {
        let done = run(&words(format)).success();
        serde_json::from_slice(&done.get_output().stdout).expect("JSON")
    };
    let [wide, narrow] = ["e5m10", "e4m3"].map(of);
    let number = |found: &serde_json::Value, name: &str| found[name].as_f64().expect("a number");
    assert!(number(&wide, "held_out").abs() < 0.05, "{wide}");
    assert!(number(&narrow, "area_um2") < 0.5 * number(&wide, "area_um2"));
    assert!(number(&narrow, "energy_per_cycle_pj") < number(&wide, "energy_per_cycle_pj"));
    let ungated = number(&wide, "clock_ungated_per_cycle_pj");
    assert!(ungated > 2.0 * number(&wide, "clock_per_cycle_pj"), "{wide}");
    run(&words("e6m5")).code(2).stderr(contains("vrc-e6m5: no netlist"));
    run(&words("e5m12")).code(2).stderr(contains("8 to 16 bits"));
    run(&["vrc", "--library", "7nm", "--trace", "traces/demo.bin"]).code(2);
    let trace = ["vrc", "--library", "7nm", "--scene", "traces/demo.bin", "--orbit", "2"];
    run(&trace).code(3);
}

#[test]
fn the_front_and_the_control_are_priced_on_a_scene() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("lego.ply");
    let scene = scene.to_str().expect("UTF-8");
    let gaussians = generate(Preset::named("lego").expect("a preset"), 30_000, 1);
    fs::write(scene, ply(&gaussians)).expect("a file");
    for (unit, amount) in [("vru", ["--slots", "50000000"]), ("ccu", ["--gaussians", "20000"])] {
        let words =
            [unit, "--library", "7nm", "--scene", scene, "--orbit", "4", "--size", "160x120"];
        let done = run(&[&words[..], &amount, &["--json"]].concat()).success();
        let found: serde_json::Value =
            serde_json::from_slice(&done.get_output().stdout).expect("JSON");
        assert!(found["held_out"].as_f64().expect("a number").abs() < 0.05, "{found}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bad.bin");
    fs::write(&path, b"no trace").expect("a file");
    let bad = path.to_str().expect("UTF-8");
    run(&["qsu", "--library", "45nm", "--trace", bad]).code(3);
    let demo = "traces/demo.bin";
    run(&["tpu", "--library", "45nm", "--trace", demo])
        .code(2)
        .stderr(contains("unrecognized subcommand"));
    run(&["qsu", "--library", "28nm", "--trace", demo]).code(2).stderr(contains("45nm"));
    let late = ["qsu", "--library", "45nm", "--trace", demo, "--frames", "90.."];
    run(&late).code(2);
}

#[test]
fn a_netlist_of_ones_own_takes_the_place_of_the_committed_one() {
    let lists = ["--trace", "traces/demo.bin", "--frames", "0..3", "--json"];
    let bsu = |words: &[&str]| run(&[&["bsu"], words, &lists].concat());
    let of = |words| bsu(words).success().get_output().stdout.clone();
    let own = of(&["--netlist", "rtl/netlists/bsu-nangate45.gates"]);
    assert_eq!(own, of(&["--library", "45nm"]));
    bsu(&["--netlist", "rtl/netlists/vrc-asap7.gates"]).code(3).stderr(contains("sort_valid"));
    bsu(&["--netlist", "README.md"]).code(3).stderr(contains("README.md"));
    bsu(&["--netlist", "a.gates", "--library", "45nm"]).code(2);
    bsu(&["--library", "45nm", "--liberty", "a.lib"]).code(2);
    let folder = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("a file");
        path.to_str().expect("UTF-8").to_owned()
    };
    let cells = "lab/gates/tests/data/invented.lib";
    let empty = file("bsu.json", r#"{ "modules": { "bsu": { "ports": {}, "cells": {} } } }"#);
    bsu(&["--netlist", &empty]).code(2).stderr(contains("--liberty"));
    bsu(&["--netlist", &empty, "--liberty", cells]).code(3).stderr(contains("report.json"));
    let report = file("report.json", "{}");
    bsu(&["--netlist", &empty, "--liberty", cells]).code(3).stderr(contains("period_ns"));
    fs::write(
        report,
        r#"{ "period_ns": 1, "clock_transition_ns": 0.02,
        "input_transition_ns": 0.02, "load_ff": 5 }"#,
    )
    .expect("a file");
    bsu(&["--netlist", &empty, "--liberty", "Cargo.toml"]).code(3).stderr(contains("Cargo.toml"));
    bsu(&["--netlist", &empty, "--liberty", cells])
        .code(3)
        .stderr(contains("bsu.json: the netlist"));
}
