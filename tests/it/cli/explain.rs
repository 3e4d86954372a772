//! `explain`: whatever a report prints has a definition.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use powergs_sim::cli::explain;
use powergs_sim::config::assumptions::assumptions;
use powergs_sim::config::references::references;
use predicates::prelude::*;
use predicates::str::contains;

pub fn program(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
    command.args(args);
    command
}

pub fn trace() -> String {
    format!("{}/traces/demo.bin", env!("CARGO_MANIFEST_DIR"))
}

/// Every head of a column and every assumption in the pages and tables of a folder.
fn words(folder: &Path, found: &mut BTreeSet<String>) {
    for entry in fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            words(&path, found);
        } else if path.extension().is_some_and(|e| e == "md") {
            of_page(&fs::read_to_string(&path).expect("text"), found);
        } else if path.extension().is_some_and(|e| e == "csv") {
            let text = fs::read_to_string(&path).expect("text");
            let head = text.lines().next().unwrap_or_default();
            found.extend(head.split(',').map(|w| w.trim_matches('"').to_owned()));
            let measures = text.lines().filter_map(|l| l.strip_prefix("measure,"));
            found.extend(measures.filter_map(|l| Some(l.split(',').next()?.to_owned())));
        }
    }
}

fn of_page(text: &str, found: &mut BTreeSet<String>) {
    let lines: Vec<&str> = text.lines().collect();
    for pair in lines.windows(2).filter(|pair| pair[1].starts_with("|--")) {
        let cells = pair[0].trim_matches('|').split('|');
        found.extend(cells.map(|c| c.trim().replace(['`', '*', '\\'], "")));
    }
    for word in text.split(|c: char| !c.is_alphanumeric()) {
        let digits = word.strip_prefix('A').unwrap_or_default();
        if !digits.is_empty() && digits.chars().all(|c| c.is_ascii_digit()) {
            found.insert(word.to_owned());
        }
    }
}

/// Every word of the reports in `folder` is explained. `names` are those of machines, designs and
/// models, which head columns too.
pub fn assert_explained(folder: &Path, names: &[&str]) {
    let mut found = BTreeSet::new();
    words(folder, &mut found);
    found.retain(|w| !w.is_empty() && !names.contains(&w.as_str()));
    assert!(found.len() > 4, "{found:?}");
    let unknown = explain::unknown(found.iter().map(String::as_str));
    assert!(unknown.is_empty(), "{}: not explained: {unknown:#?}", folder.display());
}

#[test]
fn every_word_of_a_replay_is_explained() {
    let dir = tempfile::tempdir().expect("a folder");
    let out = dir.path().join("report");
    let path = out.to_str().expect("a path");
    let printed = program(&["replay", &trace(), "--out", path]).assert().code(0);
    let printed = String::from_utf8_lossy(&printed.get_output().stdout).into_owned();
    assert!(printed.contains("A84 (Each"), "in words:\n{printed}");
    assert_explained(&out, &[]);
}

#[test]
fn every_word_of_a_comparison_is_explained() {
    let dir = tempfile::tempdir().expect("a folder");
    let out = dir.path().join("report");
    let args = ["compare", "gscore", "edge", &trace(), "--out", out.to_str().expect("a path")];
    program(&args).assert().code(0);
    assert_explained(&out, &["gscore", "edge", "edge/gscore"]);
}

#[test]
fn every_word_of_a_sweep_and_its_front_is_explained() {
    let dir = tempfile::tempdir().expect("a folder");
    let out = dir.path().join("sweep");
    let path = out.to_str().expect("a path");
    program(&["sweep", "gscore-units", "--traces", &trace(), "--points", "12", "--out", path])
        .assert()
        .code(0);
    assert_explained(&out, &["sorters"]);
}

#[test]
fn every_word_of_a_sensitivity_is_explained() {
    let dir = tempfile::tempdir().expect("a folder");
    for (name, more) in [
        ("keys", ["--keys", "vru.*"].as_slice()),
        ("assumptions", &["--assumptions", "--only", "A1,A26"]),
        (
            "morris",
            &["--interactions", "morris", "--keys", "vru.cores,ccu.units", "--samples", "2"],
        ),
    ] {
        let out = dir.path().join(name);
        let trace = trace();
        let args = ["sensitivity", "edge", &trace, "--frames", "..1", "--out"];
        let args = [&args, [out.to_str().expect("a path")].as_slice(), more].concat();
        program(&args).assert().code(0);
        assert_explained(&out, &[]);
    }
}

#[test]
fn every_assumption_and_every_source_is_explained() {
    let numbers: Vec<String> = assumptions().keys().map(|n| format!("A{n}")).collect();
    assert!(numbers.len() > 60);
    let sources = references().keys().map(String::as_str);
    let unknown = explain::unknown(numbers.iter().map(String::as_str).chain(sources));
    assert!(unknown.is_empty(), "{unknown:?}");
    let a26 = program(&["explain", "a26"]).assert().code(0);
    a26.stdout(contains("A26 (assumption)").and(contains("in full  ")).and(contains("--only A26")));
    let a1 = program(&["explain", "A1"]).assert().code(0);
    a1.stdout(contains("ccu.operations-per-cycle").and(contains("426 in gscore")));
    let powergs = program(&["explain", "powergs"]).assert().code(0);
    powergs.stdout(contains("SIGGRAPH Asia 2025").and(contains("cited by")));
    let link = "https://arxiv.org/abs/2509.21702";
    let powergs = program(&["explain", "powergs"]).assert().code(0);
    powergs.stdout(contains("10.1145/3757377.3763851").and(contains(link)));
    program(&["explain", "A999"]).assert().code(2).stderr(contains("nothing is called `A999`"));
}

#[test]
fn terms_of_reports_and_columns_of_sweeps_are_explained() {
    let names = [
        "knee",
        "merit",
        "rho",
        "lambda",
        "what_if",
        "node_nm",
        "OBB",
        "CCU",
        "GSU",
        "QSU",
        "BSU",
        "VRU",
        "precision",
        "frame_time_ms.p99",
        "fps.min",
        "area_mm2.vru",
        "busy",
        "idle",
        "mW at 60 FPS",
        "mW at 72 FPS",
        "doubled (3 frames)",
        "elasticity: fps",
        "rendering, mJ",
        "qsu waits: output",
        "gscore",
        "gscore-units",
        "power_w.total",
        "vru.cores",
        "deadline_missed_frac",
        "is_baseline",
    ];
    assert_eq!(explain::unknown(names), [""; 0]);
    assert_eq!(
        explain::unknown(["nosuch", "fps.p12", "vru.cors"]),
        ["nosuch", "fps.p12", "vru.cors"]
    );
}

/// Whoever asks where a picojoule comes from gets it table by table.
#[test]
fn a_price_is_told_with_its_source() {
    let done = program(&["explain", "actions.alpha", "--json"]).assert().success();
    let text = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    assert!(text.contains("10.32 pJ (source: rtl) in gscore-rtl-28nm"), "{text}");
    program(&["explain", "clock.ccu"]).assert().success().stdout(contains("source: rtl"));
}
