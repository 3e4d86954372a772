//! `characterise`: prices of the sorting units from a trace.

use std::fs;

use assert_cmd::Command;
use predicates::str::contains;

fn run(words: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("characterise").args(words).assert()
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
fn what_cannot_be_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bad.bin");
    fs::write(&path, b"no trace").expect("a file");
    let bad = path.to_str().expect("UTF-8");
    run(&["qsu", "--library", "45nm", "--trace", bad]).code(3);
    let demo = "traces/demo.bin";
    run(&["vru", "--library", "45nm", "--trace", demo]).code(2).stderr(contains("invalid value"));
    run(&["qsu", "--library", "28nm", "--trace", demo]).code(2).stderr(contains("45nm"));
    let late = ["qsu", "--library", "45nm", "--trace", demo, "--frames", "90.."];
    run(&late).code(2);
}
