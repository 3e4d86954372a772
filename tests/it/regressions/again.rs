//! `again` reads the recorded command as the program does, and looks at nothing but what that
//! command wrote.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::PathBuf;

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use tempfile::TempDir;

/// A folder with the demo trace.
struct Bench(TempDir);

impl Bench {
    fn new() -> Bench {
        let bench = Bench(tempfile::tempdir().expect("a folder"));
        let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
        fs::copy(demo, bench.path("demo.bin")).expect("the demo trace");
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn program(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        command.current_dir(self.0.path()).args(arguments);
        command.env_remove("POWERGS_SHARD").env("COLUMNS", "200");
        command
    }

    fn replay(&self, more: &[&str]) {
        let replay = ["replay", "demo.bin", "--frames", "..1", "--what-if", "0"];
        self.program(&[&replay, more].concat()).assert().success();
    }

    fn sweep(&self, more: &[&str]) {
        let text = "question = \"Which?\"\nbase = \"gscore\"\n\
                    [[axes]]\nkey = \"vru.cores\"\nvalues = [1, 2, 4]\n";
        fs::write(self.path("cores.toml"), text).expect("written");
        let sweep = ["sweep", "cores.toml", "--traces", "demo.bin", "--frames", "..1", "-q"];
        self.program(&[&sweep, more].concat()).assert().success();
    }
}

#[test]
fn short_forms_of_flags_are_those_of_the_program() {
    let bench = Bench::new();
    bench.replay(&["-q", "-oa1"]);
    bench.program(&["again", "a1"]).assert().code(0).stdout(contains("The same bytes."));
    bench.replay(&["-qo", "a2"]);
    bench.program(&["again", "a2"]).assert().code(0).stdout(contains("The same bytes."));
    bench.replay(&["--quiet", "--out=a3", "--arch=edge"]);
    bench.program(&["again", "a3"]).assert().code(0).stdout(contains("The same bytes."));
}

#[test]
fn files_of_other_flags_are_not_replaced() {
    let bench = Bench::new();
    bench.replay(&["-q", "-o", "a", "--dump-dram", "requests.txt"]);
    fs::write(bench.path("requests.txt"), "mine").expect("written");
    bench.program(&["again", "a"]).assert().code(0);
    let kept = fs::read_to_string(bench.path("requests.txt")).expect("a file");
    assert_eq!(kept, "mine");
}

#[test]
fn links_are_not_followed_and_pipes_are_not_opened() {
    let bench = Bench::new();
    bench.replay(&["-q", "-o", "a"]);
    fs::create_dir(bench.path("a/x")).expect("made");
    for name in ["a/x/a", "a/x/b"] {
        symlink(".", bench.path(name)).expect("a link");
    }
    fs::remove_file(bench.path("a/results.csv")).expect("removed");
    let made = std::process::Command::new("mkfifo").arg(bench.path("a/results.csv")).status();
    assert!(made.expect("mkfifo").success());
    let said = contains("not opened").and(contains("results.csv"));
    bench.program(&["again", "a"]).assert().code(1).stdout(said);
}

#[test]
fn an_input_that_was_replaced_is_named_first_and_numbers_have_units() {
    let bench = Bench::new();
    bench.replay(&["-q", "-o", "a"]);
    let scene = ["synth", "demo", "--points", "400", "-o", "s.ply", "--cameras", "c.json"];
    bench.program(&scene).assert().success();
    let views = ["extract", "s.ply", "--cameras", "c.json", "--size", "64x48", "--frames", "0..2"];
    bench.program(&views).args(["-o", "demo.bin", "--force"]).assert().success();
    bench
        .program(&["again", "a"])
        .assert()
        .code(1)
        .stderr(contains("demo.bin is another file"))
        .stdout(contains("other inputs").and(contains("trace demo.bin is another file")))
        .stdout(contains(" % at most ("));
}

#[test]
fn a_small_difference_is_not_shown_as_none() {
    let bench = Bench::new();
    bench.replay(&["-q", "-o", "a"]);
    let path = bench.path("a/results.csv");
    let text = fs::read_to_string(&path).expect("a table");
    let (head, row) = text.split_once('\n').expect("rows");
    let at = head.split(',').position(|name| name == "energy_pj.total").expect("a column");
    let cell = row.split(',').nth(at).expect("a cell");
    let number: f64 = cell.parse().expect("a number");
    let changed = text.replacen(cell, &(number * (1.0 + 1e-9)).to_string(), 1);
    fs::write(&path, changed).expect("written");
    let said = contains("1 number, by 1.0e-7 % at most (energy_pj.total: ").and(contains(" pJ"));
    bench.program(&["again", "a"]).assert().code(1).stdout(said);
}

#[test]
fn a_sweep_with_a_store_is_simulated_again() {
    let bench = Bench::new();
    bench.sweep(&["--out", "s", "--store", "known"]);
    fs::remove_dir_all(bench.path("known")).expect("removed");
    bench
        .program(&["again", "s"])
        .assert()
        .code(0)
        .stderr(contains("--store known is left out"))
        .stdout(contains("The same bytes."));
    assert!(!bench.path("known").exists(), "nothing was taken from it, or put there");
}

#[test]
fn pareto_leaves_the_report_of_the_sweep_as_it_was() {
    let bench = Bench::new();
    bench.sweep(&["--out", "s"]);
    let page = || fs::read_to_string(bench.path("s/analysis/report.html")).expect("a page");
    let before = page();
    let asked = ["pareto", "s", "-q", "--minimize", "power_w.mean"];
    bench.program(&asked).assert().success();
    bench.program(&asked).assert().success();
    bench.program(&["pareto", "s", "-q", "--maximize", "fps.mean"]).assert().success();
    assert_eq!(page(), before);
    let is_there = |name: &str| bench.path("s").join(name).join("report.html").is_file();
    assert!(is_there("analysis-2") && is_there("analysis-3") && !is_there("analysis-4"));
    bench.program(&["again", "s"]).assert().code(0).stdout(contains("The same bytes."));
    let own = bench.program(&["pareto", "s", "--out", "s/analysis"]).assert().code(2);
    own.stderr(contains("is the report of the sweep itself"));
}
