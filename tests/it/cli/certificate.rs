//! `certificate`: what numbers of a machine rest on.

use std::fs;
use std::path::Path;

use powergs_base::config::embedded::{MACHINES, find};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;

use super::explain::program;

fn json(arch: &str) -> Value {
    let run = program(&["certificate", arch, "--json"]).assert().success();
    serde_json::from_slice(&run.get_output().stdout).expect("JSON")
}

fn strings(value: &Value) -> Vec<&str> {
    value.as_array().expect("a list").iter().map(|v| v.as_str().expect("a text")).collect()
}

#[test]
fn a_machine_has_its_rows_with_the_stored_values() {
    let gscore = json("gscore");
    let rows = gscore["rows"].as_array().expect("rows");
    assert!(rows.len() > 20 && rows.iter().all(|row| row["machine"] == "gscore"), "{rows:?}");
    assert!(rows.iter().all(|row| row["ours"].is_number()), "{rows:?}");
    assert_eq!(gscore["is_evidence"], true);
    assert_eq!(gscore["program"]["model_version"], gscore["stored_model_version"]);
    assert_eq!(gscore["energy"]["name"], "gscore-28nm");
    assert!(strings(&gscore["energy"]["sources"]).contains(&"gscore"), "{}", gscore["energy"]);
    assert!(strings(&gscore["assumptions"]).contains(&"A16"));
    assert!(gscore["files"][0]["xxh3_128"].as_str().is_some_and(|hash| hash.len() == 32));
    let variants = gscore["variants"].as_array().expect("rows");
    assert!(variants.iter().all(|row| row["machine"] != "gscore") && !variants.is_empty());
    // What it misses most comes first, then other gaps.
    assert_eq!(rows[0]["id"], gscore["headline"]["id"]);
    let is_gap = |row: &Value| row["status"] == "known_gap";
    let first_near = rows.iter().position(|row| !is_gap(row)).expect("a row that holds");
    assert!(first_near > 0 && !rows[first_near..].iter().any(is_gap), "{rows:?}");
}

#[test]
fn what_it_misses_most_is_said_first() {
    let gsarch = program(&["certificate", "gsarch"]).assert().success();
    let said = contains("Missed most: gsarch-train: 87 % above the published rate");
    gsarch.stdout(
        said.and(contains("Nothing was simulated")).and(contains("1 row: known gaps: preset 1.")),
    );
    assert_eq!(json("orin-nx")["headline"]["id"], "gpu-orin-energy");
    // The other side of comparisons is no evidence of its own.
    assert!(strings(&json("orin-nx")["against"]).contains(&"gaurast-speed"));
}

#[test]
fn a_machine_without_rows_says_so() {
    let none = program(&["certificate", "chang"]).assert().success();
    none.stdout(contains("No published number is held against this file"));
    let chang = json("chang");
    assert_eq!((&chang["is_evidence"], &chang["headline"]), (&Value::Bool(false), &Value::Null));
}

#[test]
fn a_file_of_ones_own_names_its_base_and_what_differs() {
    let home = tempfile::tempdir().expect("a folder");
    let path = |name: &str| home.path().join(name).to_str().expect("UTF-8").to_owned();
    let mine = path("mine.toml");
    fs::write(&mine, "base = \"gscore\"\nname = \"mine\"\n[vru]\ncores = 8\n").expect("written");
    let of_mine = json(&mine);
    let base = &of_mine["base"];
    assert_eq!((&base["name"], &of_mine["shipped"]), (&"gscore".into(), &Value::Null));
    let changed = serde_json::json!([{ "key": "vru.cores", "base": "4", "value": "8" }]);
    assert_eq!(base["changed"], changed);
    assert_eq!((&of_mine["rows"], &of_mine["is_evidence"]), (&Value::Array(vec![]), &false.into()));
    let said = program(&["certificate", &mine]).assert().success();
    let nothing = contains("No published number is held against this file");
    said.stdout(nothing.and(contains("Differs from its base, gscore, in 1 key")));
    // A copy is the machine, whatever its file is called.
    let copy = path("copy.toml");
    fs::write(&copy, find(MACHINES, "gscore").expect("it is shipped")).expect("written");
    assert_eq!(json(&copy)["shipped"], "gscore");
}

#[test]
fn the_page_is_written_once() {
    let home = tempfile::tempdir().expect("a folder");
    let path = home.path().join("c.md");
    let run = |more: &[&str], code: i32| {
        let words = ["certificate", "gsarch", "-o", path.to_str().expect("UTF-8")];
        program(&[&words[..], more].concat()).assert().code(code)
    };
    run(&[], 0).stdout(contains("certificate of gsarch"));
    let page = fs::read_to_string(Path::new(&path)).expect("a page");
    for words in ["# Certificate of gsarch", "| `gsarch-train` |", "## Assumptions", "`A146`: "] {
        assert!(page.contains(words), "{words}: {page}");
    }
    run(&[], 2).stderr(contains("--force"));
    run(&["--force", "-q"], 0).stdout("");
    assert_eq!(fs::read_to_string(&path).expect("a page"), page);
    program(&["certificate", "gsarc"]).assert().code(2).stderr(contains("gsarch"));
}
