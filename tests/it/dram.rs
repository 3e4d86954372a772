//! The command `dram` as the user sees it.

use std::path::PathBuf;

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;

use powergs_sim::config::embedded::{DRAM, find};
use powergs_sim::dram::Device;
use streams::{as_text, traffic};

// Tests of the model use more of it.
#[allow(dead_code)]
#[path = "../../crates/dram/tests/it/streams.rs"]
mod streams;

fn program(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
    command.arg("dram").args(args);
    command
}

fn trace() -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("addresses.trace");
    std::fs::write(&path, as_text(&traffic(1, 3000, 3))).expect("a file");
    (dir, path)
}

#[test]
fn json_has_the_promised_names() {
    let (_dir, path) = trace();
    let file = path.to_str().expect("a path");
    for (device, mode) in [
        ("lpddr4-3200-x16x8", "sat"),
        ("lpddr4-3200-x32x4", "mlp32"),
        ("lpddr5-6400-x16x4", "idle"),
        ("hbm2-8ch", "rate20"),
    ] {
        let args = [file, "--device", device, "--mode", mode, "--json"];
        let output = program(&args).assert().code(0).get_output().stdout.clone();
        let value: serde_json::Value = serde_json::from_slice(&output).expect("JSON");
        let number = |path: &str| {
            let found = value.pointer(path).and_then(serde_json::Value::as_f64);
            found.unwrap_or_else(|| panic!("{path}: {value}"))
        };
        assert!(number("/time_ns") > 0.0 && number("/bandwidth_gb_s") > 0.0);
        assert!((-0.1..=1.0).contains(&number("/row_hit_rate")));
        let [mean, p50, p95, p99] =
            ["mean", "p50", "p95", "p99"].map(|n| number(&format!("/read_latency_ns/{n}")));
        assert!(mean > 0.0 && p50 <= p95 && p95 <= p99);
        assert!(number("/commands/ACT") > 0.0 && number("/energy_pj/total") > 0.0);
        assert_eq!(value["device"], device);
        assert_eq!(value["mode"], mode);
    }
}

#[test]
fn the_table_fits_a_terminal() {
    let (_dir, path) = trace();
    let file = path.to_str().expect("a path");
    let args = [file, "--mapping", "bg64", "--device", "lpddr5-6400-x16x4"];
    let output = program(&args).assert().code(0).get_output().stdout.clone();
    let text = String::from_utf8(output).expect("text");
    assert!(text.lines().all(|l| l.chars().count() <= 80), "{text}");
    program(&[file, "--quiet"]).assert().code(0).stdout("");
}

#[test]
fn a_device_may_be_a_file_and_the_trace_standard_input() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("mine.toml");
    let shown = narrow_hbm2().to_toml();
    std::fs::write(&path, shown).expect("a file");
    let file = path.to_str().expect("a path");
    let run =
        program(&["-", "--device", file, "--json"]).write_stdin("LD 0x40\nST 0x80\n").assert();
    run.code(0).stdout(contains("\"requests\": 2").and(contains("\"peak_bandwidth_gb_s\": 64.0")));
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let (dir, path) = trace();
    let file = path.to_str().expect("a path");
    let bad = dir.path().join("bad.trace");
    std::fs::write(&bad, "R 0x40 64\nR 0x80 x\n").expect("a file");
    let broken = program(&[bad.to_str().expect("a path")]).assert().code(3);
    broken.stderr(contains("bad.trace: line 2: `x` is not a size")).stdout("");
    program(&["no/such.trace"]).assert().code(3).stderr(contains("no/such.trace"));
    let folder = dir.path().to_str().expect("a path");
    program(&[folder]).assert().code(3).stderr(contains("a folder"));
    let unknown = program(&[file, "--device", "lpddr4-3200-x16x9"]).assert().code(2);
    unknown.stderr(contains("did you mean `lpddr4-3200-x16x"));
    program(&[file, "--mode", "mlp0"]).assert().code(2).stderr(contains("mlp32"));
    program(&[file, "--mapping", "xyz"]).assert().code(2).stderr(contains("RoBaCoCh"));
    let set = program(&[file, "--set", "controller.write-low=0.9"]).assert().code(2);
    set.stderr(contains("in --set controller.write-low=0.9"));
}

/// The device of `--device hbm2-8ch --set organisation.channels=2`.
fn narrow_hbm2() -> Device {
    let text = find(DRAM, "hbm2-8ch").expect("a device of the program");
    Device::parse_with(text, &["organisation.channels=2".to_owned()]).expect("a device")
}
