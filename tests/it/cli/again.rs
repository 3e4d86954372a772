//! `again`: the command of a folder once more.

use std::fs;
use std::path::Path;

use predicates::str::contains;

use super::explain::{program, trace};

/// A report of the demo, its folder, and what `again` says of it with these arguments.
fn again(folder: &Path, more: &[&str], code: i32, said: &[&str]) {
    let args = [&["again", folder.to_str().expect("a path")], more].concat();
    let mut run = program(&args).assert().code(code);
    for words in said {
        run = run.stdout(contains(*words));
    }
}

#[test]
fn a_report_is_made_again_and_compared() {
    let home = tempfile::tempdir().expect("a folder");
    let out = home.path().join("report");
    let out_text = out.to_str().expect("a path");
    program(&["replay", &trace(), "--arch", "edge", "--frames", "..1", "--out", out_text])
        .assert()
        .code(0);
    again(&out, &[], 0, &["The same bytes.", "same files"]);
    // Another number, a file that is gone, one that came.
    let path = out.join("results.csv");
    let text = fs::read_to_string(&path).expect("a table");
    fs::write(&path, format!("{}9\n", text.trim_end())).expect("written");
    fs::remove_file(out.join("energy.svg")).expect("removed");
    fs::write(out.join("mine.txt"), "mine").expect("written");
    let said = ["results.csv  1 ", "only before", "mine.txt", "energy.svg"];
    again(&out, &[], 1, &said);
    // A picture of another build is no difference, a number is one.
    fs::write(&path, &text).expect("written");
    fs::remove_file(out.join("mine.txt")).expect("removed");
    program(&[
        "replay",
        &trace(),
        "--arch",
        "edge",
        "--frames",
        "..1",
        "--out",
        out_text,
        "--force",
    ])
    .assert()
    .code(0);
    let record = fs::read_to_string(out.join("run.toml")).expect("a record");
    let other = record.replace("tool-version = ", "tool-version = \"0.0.1\" # ");
    fs::write(out.join("run.toml"), other).expect("written");
    fs::write(out.join("energy.png"), "another").expect("written");
    again(&out.join("run.toml"), &[], 0, &["another build made it", "0.0.1"]);
    // Kept where it is asked for, over nothing.
    let kept = home.path().join("kept");
    let kept_text = kept.to_str().expect("a path");
    again(&out, &["--out", kept_text], 0, &[]);
    assert!(kept.join("results.csv").exists());
    program(&["again", out_text, "--out", kept_text])
        .assert()
        .code(2)
        .stderr(contains("is there already"));
}

#[test]
fn what_is_no_run_is_refused() {
    let home = tempfile::tempdir().expect("a folder");
    let folder = home.path();
    let refused = |code: i32, said: &str| {
        let args = ["again", folder.to_str().expect("a path")];
        program(&args).assert().code(code).stderr(contains(said));
    };
    refused(3, "invocation.toml");
    let record = |command: &str, place: &str| {
        let text = format!("command = {command}\nworking-folder = \"{place}\"\n");
        fs::write(folder.join("invocation.toml"), text).expect("written");
    };
    fs::write(folder.join("run.toml"), "tool-version = \"0.2.0\"\n").expect("written");
    record("[\"powergs-sim\", \"arch\", \"list\"]", "/");
    refused(3, "it writes no folder");
    record("[\"powergs-sim\", \"replay\", \"a.bin\", \"--no-such-flag\"]", "/");
    refused(3, "--no-such-flag");
    record("[\"powergs-sim\", \"replay\", \"a.bin\"]", "/no/such/place");
    refused(2, "say where with --in");
    record("[\"powergs-sim\", \"replay\", \"no-such.bin\"]", "/");
    refused(3, "the command fails now");
    record("3", "/");
    refused(3, "invocation.toml");
}
