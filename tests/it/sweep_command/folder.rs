//! What a folder refuses, and what it says.

use std::fs::{self, File};

use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

use super::Bench;
use powergs_sim::run::store::journal;
use powergs_testkit::scene_files::{ply, sample};

/// Makes a trace of one small frame.
fn trace(bench: &Bench, points: usize, name: &str) {
    fs::write(bench.path("scene.ply"), ply(&sample(points, 1))).unwrap();
    let words = ["extract", "scene.ply", "--orbit", "1", "--size", "48x32", "--force", "-q", "-o"];
    bench.program(&[&words[..], &[name]].concat()).assert().success();
}

#[test]
fn two_traces_of_one_file_name_go_on_in_parts_and_are_compared_each_with_itself() {
    let bench = Bench::new();
    for (folder, points) in [("a", 30), ("b", 40)] {
        fs::create_dir(bench.path(folder)).unwrap();
        trace(&bench, points, &format!("{folder}/final.bin"));
    }
    let sweep = "question = \"Two scenes?\"\nbase = \"gscore\"\n\
                 [[traces]]\npath = \"a/final.bin\"\nlabel = \"a\"\n\
                 [[traces]]\npath = \"b/final.bin\"\nlabel = \"b\"\n\
                 [[axes]]\nkey = \"vru.cores\"\nvalues = [1, 2]\n";
    fs::write(bench.path("two.toml"), sweep).unwrap();
    let run = |more: &[&str]| bench.program(&[&["sweep"], more].concat()).assert();
    run(&["two.toml", "--out", "one", "-q"]).success();
    run(&["two.toml", "--out", "one", "--resume", "-q"]).success();
    for part in ["1/2", "2/2"] {
        run(&["two.toml", "--out", "parts", "--shard", part, "-q"]).success();
    }
    run(&["merge", "parts", "-q"]).success();
    run(&["status", "parts"]).success().stdout(contains("2 of 2 designs"));
    super::assert_same(&bench.path("one"), &bench.path("parts"));

    trace(&bench, 50, "b/final.bin");
    let other = run(&["two.toml", "--out", "one", "--resume"]).code(2);
    other.stderr(contains("trace `final.bin` has changed").count(1));
    trace(&bench, 30, "b/final.bin");
    trace(&bench, 40, "a/final.bin");
    let swapped = run(&["two.toml", "--out", "one", "--resume"]).code(2);
    swapped.stderr(contains("the same, in another order"));
}

#[test]
fn an_analysis_that_cannot_be_written_is_made_up_for() {
    let bench = Bench::new();
    fs::create_dir(bench.path("one")).unwrap();
    // In the way of the folder of the analysis.
    bench.sweep(&["--out", "one", "-q", "--shard", "1/1"]).assert().success();
    fs::write(bench.path("one/analysis"), "").unwrap();
    let failed = bench.sweep(&["--out", "one", "--resume", "-q"]).assert();
    failed.code(2).stderr(contains("is a file"));
    assert!(!bench.path("one/finished.toml").exists());
    fs::remove_file(bench.path("one/analysis")).unwrap();
    bench.sweep(&["--out", "one", "--resume", "-q"]).assert().success();
    assert!(bench.path("one/analysis/report.html").is_file());
    // A finished sweep without its analysis makes it.
    fs::remove_dir_all(bench.path("one/analysis")).unwrap();
    bench.sweep(&["--out", "one", "--resume", "-q"]).assert().success();
    assert!(bench.path("one/analysis/report.html").is_file());
}

#[test]
fn a_contradiction_of_the_simulator_is_an_internal_error_of_the_sweep() {
    let bench = Bench::new();
    // One thread: the last record is then that of the last design.
    bench.sweep(&["--out", "one", "-q", "-j", "1"]).assert().success();
    let records = bench.path("one/records/shard-00001-of-00001.jsonl");
    let text = fs::read_to_string(&records).unwrap();
    let (key, _) =
        journal::parse(text.split_inclusive('\n').next_back().unwrap().as_bytes()).unwrap();
    let mut lines: Vec<u8> = Vec::new();
    journal::append(&mut lines, key, r#"{"defect":"the VRU lost a cycle"}"#).unwrap();
    lines.extend(text.as_bytes());
    fs::write(&records, lines).unwrap();
    fs::remove_file(bench.path("one/finished.toml")).unwrap();
    let told = contains("on 1 design the simulator contradicted itself");
    bench.sweep(&["--out", "one", "--resume", "-q"]).assert().code(4).stderr(told.clone());
    let table = fs::read_to_string(bench.path("one/results.csv")).unwrap();
    assert!(table.contains("the VRU lost a cycle"));
    bench.sweep(&["--out", "one", "--resume", "-q"]).assert().code(4).stderr(told);
}

#[test]
fn a_finished_sweep_is_not_run_again_and_not_overwritten() {
    let bench = Bench::new();
    bench.sweep(&["--out", "one"]).assert().success().stdout(contains("How many CCUs and cores?"));
    let before = fs::metadata(bench.path("one/results.csv")).unwrap().modified().unwrap();
    let again = bench.sweep(&["--out", "one"]).assert();
    again.code(2).stderr(contains("--resume").and(contains("--force")));
    bench.sweep(&["--out", "one", "--resume"]).assert().success().stdout(contains("invalid"));
    let after = fs::metadata(bench.path("one/results.csv")).unwrap().modified().unwrap();
    assert_eq!(before, after);
    // A table that somebody changed is written again.
    fs::write(bench.path("one/results.csv"), "mine").unwrap();
    bench.sweep(&["--out", "one", "--resume", "-q"]).assert().success();
    assert!(fs::read_to_string(bench.path("one/results.csv")).unwrap().starts_with("point,"));
    bench.sweep(&["--out", "one", "--force", "-q"]).assert().success();
}

#[test]
fn what_changed_since_the_start_is_named() {
    let bench = Bench::new();
    bench.sweep(&["--out", "one", "-q"]).assert().success();
    let changed = super::SWEEP.replace("[1, 2, 4, 8]", "[1, 2, 4]");
    fs::write(bench.path("cores.toml"), changed).unwrap();
    let resumed = bench.sweep(&["--out", "one", "--resume"]).assert();
    resumed.code(2).stderr(contains("sweep `cores.toml` has changed").and(contains("--store")));
    fs::write(bench.path("cores.toml"), super::SWEEP).unwrap();

    let other = bench.program(&["extract", "--help"]).assert().success();
    drop(other);
    let mut trace = fs::read(bench.path("demo.bin")).unwrap();
    let last = trace.len() - 1;
    trace[last] ^= 1;
    fs::write(bench.path("demo.bin"), trace).unwrap();
    // The last byte is part of the checked footer: the trace is refused before it is compared.
    bench.sweep(&["--out", "one", "--resume"]).assert().code(3);
    let frames = bench.path("one/state.toml");
    let state = fs::read_to_string(&frames).unwrap();
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
    fs::copy(demo, bench.path("demo.bin")).unwrap();
    let place = state.find("role = \"trace\"").unwrap();
    let at = place + state[place..].find("xxh3-128 = \"").unwrap() + "xxh3-128 = \"".len();
    let mut other = state.clone();
    other.replace_range(at..at + 4, "0000");
    fs::write(&frames, other).unwrap();
    let replaced = bench.sweep(&["--out", "one", "--resume"]).assert();
    replaced.code(2).stderr(contains("trace `demo.bin` has changed"));
    let model = state.replace("model-version = ", "model-version = 9");
    fs::write(&frames, model).unwrap();
    let older = bench.sweep(&["--out", "one", "--resume"]).assert();
    older.code(2).stderr(contains("the version of the model was 9"));
}

#[test]
fn another_process_is_refused() {
    let bench = Bench::new();
    fs::create_dir(bench.path("one")).unwrap();
    let lock = File::create(bench.path("one/lock")).unwrap();
    lock.lock().unwrap();
    let second = bench.sweep(&["--out", "one"]).assert();
    second.code(2).stderr(contains("another process is writing it"));
    drop(lock);
    bench.sweep(&["--out", "one", "-q"]).assert().success();
}

#[test]
fn a_folder_of_something_else_is_left_alone() {
    let bench = Bench::new();
    fs::create_dir(bench.path("one")).unwrap();
    fs::write(bench.path("one/thesis.tex"), "precious").unwrap();
    let refused = bench.sweep(&["--out", "one", "--force"]).assert();
    refused.code(2).stderr(contains("`thesis.tex`"));
    assert_eq!(fs::read_dir(bench.path("one")).unwrap().count(), 1);
    let none = bench.program(&["sweep", "status", "one"]).assert();
    none.code(2).stderr(contains("holds no sweep"));
    let file = bench.sweep(&["--out", "cores.toml"]).assert();
    file.code(2);
}

#[test]
fn mistakes_are_found_before_anything_runs() {
    let bench = Bench::new();
    let no_trace = bench.program(&["sweep", "cores.toml", "--out", "one"]).assert();
    no_trace.code(2).stderr(contains("--traces"));
    let missing = bench.program(&["sweep", "cores.toml", "--traces", "no*.bin"]).assert();
    missing.code(3).stderr(contains("`no*.bin`: no such file"));
    let unknown = bench.program(&["sweep", "gscore-unit", "--traces", "demo.bin"]).assert();
    unknown.code(2).stderr(contains("did you mean `gscore-units`?"));
    bench.sweep(&["--shard", "4/3"]).assert().code(2).stderr(contains("3/16"));
    let objective = format!("{}\n[objectives]\nminimize = [\"energy_pj.meen\"]\n", super::SWEEP);
    fs::write(bench.path("cores.toml"), objective).unwrap();
    let typo = bench.sweep(&["--out", "one"]).assert();
    typo.code(2).stderr(contains("did you mean `energy_pj.mean`?"));
    assert!(!bench.path("one").exists());
}

#[test]
fn a_dry_run_writes_nothing() {
    let bench = Bench::new();
    let dry = bench.sweep(&["--out", "one", "--dry-run"]).assert().success();
    dry.stdout(
        contains("24 of a space of 24")
            .and(contains("Excluded"))
            .and(contains("at least"))
            .and(contains("buffers.feature.capacity` = 64 KiB is too small")),
    );
    assert!(!bench.path("one").exists());
    let json = bench.sweep(&["--dry-run", "--json"]).output().unwrap().stdout;
    let json: serde_json::Value = serde_json::from_slice(&json).unwrap();
    assert_eq!(json["points"], 24);
    assert_eq!(json["geometries"], 1);
    assert!(json["estimated_time_s"].as_f64().unwrap() > 0.0);
}

#[test]
fn a_design_can_be_taken_out_and_replayed() {
    let bench = Bench::new();
    bench.sweep(&["--out", "one", "-q"]).assert().success();
    let shown = bench.program(&["sweep", "show", "9", "one", "--json"]).output().unwrap().stdout;
    let shown: serde_json::Value = serde_json::from_slice(&shown).unwrap();
    assert_eq!(shown["settings"]["ccu.units"], 2);
    let id = shown["id"].as_str().unwrap();
    let machine = bench.program(&["sweep", "show", &id[..8], "one", "--toml"]).output().unwrap();
    fs::write(bench.path("best.toml"), machine.stdout).unwrap();
    let replay = ["replay", "demo.bin", "--arch", "best.toml", "--json", "--out", "r"];
    let replayed = bench.program(&replay).output().unwrap().stdout;
    let replayed: serde_json::Value = serde_json::from_slice(&replayed).unwrap();
    let table = fs::read_to_string(bench.path("one/results.csv")).unwrap();
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let header = rows.headers().unwrap().clone();
    let place = |name: &str| header.iter().position(|h| h == name).unwrap();
    let row = rows.records().map(Result::unwrap).find(|r| {
        &r[place("id")] == id && &r[place("energy_table")] == "28nm" && &r[place("scope")] == "mean"
    });
    let row = row.unwrap();
    let of_table = |name: &str| row[place(name)].parse::<f64>().unwrap();
    let mean = |name: &str| replayed["aggregate"][name]["mean"].as_f64();
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs();
    assert!(close(of_table("frame_time_ms.mean"), mean("frame_time_ms").unwrap()));
    let energy = replayed["aggregate"]["energy_pj"]["total"]["mean"].as_f64().unwrap();
    assert!(close(of_table("energy_pj.mean"), energy));
    bench.program(&["sweep", "show", "zzz", "one"]).assert().code(2);
    bench.program(&["sweep", "show", "0000dead0000", "one"]).assert().code(2);
}

#[test]
fn an_optional_number_out_of_range_is_one_problem() {
    let bench = Bench::new();
    let sweep = "question = \"q\"\nbase = \"gscore\"\n[[axes]]\nkey = \"vru.cores\"\n\
                 range = { from = 1, to = 4, count = 0 }\n";
    fs::write(bench.path("range.toml"), sweep).unwrap();
    let refused = bench.program(&["sweep", "range.toml", "--traces", "demo.bin"]).assert().code(2);
    let told = String::from_utf8(refused.get_output().stderr.clone()).unwrap();
    assert!(told.contains("must be at least 2, not 0") && told.lines().count() < 8, "{told}");
}

#[test]
fn a_label_that_begins_like_a_formula_is_text_in_the_table() {
    let bench = Bench::new();
    trace(&bench, 30, "t.bin");
    let sweep = "question = \"q\"\nbase = \"gscore\"\n[[traces]]\npath = \"t.bin\"\n\
                 label = \"=cmd|x\"\n[[axes]]\nkey = \"vru.cores\"\nvalues = [1, 2]\n";
    fs::write(bench.path("formula.toml"), sweep).unwrap();
    bench.program(&["sweep", "formula.toml", "--out", "one", "-q"]).assert().success();
    let table = fs::read_to_string(bench.path("one/results.csv")).unwrap();
    assert!(table.contains(",'=cmd|x,") && !table.contains(",=cmd"));
    bench.program(&["pareto", "one", "-q"]).assert().success();
}

#[test]
fn the_end_has_the_width_of_the_terminal_and_is_said_again() {
    let bench = Bench::new();
    let said = |columns: &str| {
        let first = !bench.path("wide").exists();
        let more: &[&str] = if first { &[] } else { &["--resume"] };
        let mut command = bench.sweep(&[&["-o", "wide"], more].concat());
        let output = command.env("COLUMNS", columns).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let widest = |text: &str| text.lines().map(|l| l.chars().count()).max().unwrap();
    let (wide, again, narrow) = (said("120"), said("120"), said("60"));
    assert!((81..=120).contains(&widest(&wide)), "{wide}");
    assert_eq!(wide, again);
    assert!(widest(&narrow) <= 60, "{narrow}");
    assert_eq!(wide.matches("How many CCUs and cores?").count(), 1, "{wide}");
}
