//! `compare` as a program, on the committed trace.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use predicates::prelude::*;

fn program(arguments: &[&str]) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
    program.current_dir(env!("CARGO_MANIFEST_DIR")).arg("compare").args(arguments);
    program
}

const TRACE: &str = "traces/demo.bin";

#[test]
fn machines_then_their_folders() {
    let root = tempfile::tempdir().expect("a folder");
    let path = |name: &str| root.path().join(name).to_string_lossy().into_owned();
    let out = path("pair");
    let arguments = ["gscore", "edge", TRACE, "--frames", "0..1", "--json", "--out", &out];
    let output = program(&arguments).assert().code(0);
    let json: serde_json::Value =
        serde_json::from_slice(&output.get_output().stdout).expect("JSON");
    let fps = json["measures"].as_array().expect("measures").iter();
    let fps = fps.clone().find(|m| m["name"] == "throughput_fps").expect("frames per second");
    let ratio = fps["ratios"][1].as_f64().expect("a ratio");
    assert!(ratio < 1.0, "edge is the smaller machine: {ratio}");
    for name in ["run.toml", "invocation.toml", "compare.csv", "summary.md", "power.png"] {
        assert!(Path::new(&out).join(name).is_file(), "{name}");
    }
    let goal = ["gscore", "edge", TRACE, "--frames", "0..1", "--at-least", "0.99", "--force"];
    let missed = program(&goal).args(["--out", &out]).assert().code(1);
    missed.stderr(predicate::str::contains("goal missed"));
    finished_reports(root.path());
}

#[test]
fn several_traces_have_speed_ups_with_their_mean() {
    let root = tempfile::tempdir().expect("a folder");
    let other = root.path().join("other.bin").to_string_lossy().into_owned();
    fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join(TRACE), &other).expect("copied");
    let out = root.path().join("two").to_string_lossy().into_owned();
    let how = ["--chart-size", "88.9mm", "--no-title", "--chart-format", "svg,pdf", "--json"];
    let output = program(&["gscore", "edge", TRACE, &other, "--frames", "0..1", "--out", &out])
        .args(how)
        .assert()
        .code(0);
    let json: serde_json::Value =
        serde_json::from_slice(&output.get_output().stdout).expect("JSON");
    let edge = &json["speedup"]["machines"][1];
    let (each, mean) = (&edge["speedup"], edge["speedup_geomean"].as_f64().expect("a mean"));
    assert_eq!(each[0], each[1], "the same frames");
    assert!((mean - each[0].as_f64().expect("a ratio")).abs() < 1e-12 && mean < 1.0);
    assert_eq!(json["traces"].as_array().map(Vec::len), Some(2));
    let read = |name: &str| fs::read_to_string(Path::new(&out).join(name)).expect(name);
    assert_eq!(read("speedup.csv").lines().filter(|l| l.starts_with("geomean,")).count(), 2);
    assert!(read("summary.md").contains("(speedup.svg)"));
    // What each trace says, as of one trace alone.
    assert_eq!(read("summary.md").matches("VRU-bound for").count(), 4, "two machines, two traces");
    let table = read("compare.csv");
    assert!(table.starts_with("trace,kind,name,gscore,edge,edge/gscore\n"), "{table}");
    assert!(table.contains("\ndemo,measure,") && table.contains("\nother,mean,"), "{table}");
    let svg = read("speedup.svg");
    assert!(svg.contains("width=\"3.500in\"") && !svg.contains("Speed-up over gscore</text>"));
    let pdf = fs::read(Path::new(&out).join("speedup.pdf")).expect("a PDF");
    // 3.5 in are 252 points.
    let page = String::from_utf8_lossy(&pdf);
    assert!(page.contains("/MediaBox[0 0 252 "), "{page}");
    assert!(!Path::new(&out).join("speedup.png").exists());
}

/// Two reports of one trace with different tables, in `root`.
fn finished_reports(root: &Path) {
    let path = |name: &str| root.join(name).to_string_lossy().into_owned();
    let replay = |name: &str, table: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        program.current_dir(env!("CARGO_MANIFEST_DIR")).args(["replay", TRACE, "--quiet"]);
        let table = format!("energy={table}");
        program.args(["--frames", "0..1", "--set", &table, "--out", &path(name)]).assert().code(0);
    };
    replay("a", "gscore-28nm");
    replay("b", "paper");
    let both = program(&[&path("a"), &path("b"), "--out", &path("both")]).assert().code(0);
    both.stdout(predicate::str::contains("Note: energy tables differ (gscore-28nm, paper)"));
    fs::write(root.join("b/results.csv"), "row,frame\nmean,\np99,\n").expect("written");
    // An older report without a column leaves a gap.
    let gaps = program(&[&path("a"), &path("b"), "--out", &path("x")]).assert().code(0);
    gaps.stdout(predicate::str::contains("frames per second"));
    fs::write(root.join("b/results.csv"), "nothing").expect("written");
    let broken = program(&[&path("a"), &path("b"), "--out", &path("y")]).assert().code(3);
    broken.stderr(predicate::str::contains("no row `mean`"));
    assert!(!root.join("y").exists());
}

#[test]
fn a_machine_is_compared_with_itself_without_its_parts() {
    let root = tempfile::tempdir().expect("a folder");
    let out = |name: &str| root.path().join(name).to_string_lossy().into_owned();
    let rows = |arguments: &[&str]| -> Vec<String> {
        let table = ["--table", "csv", "--frames", "0..2"];
        let output = program(arguments).args(table).assert().code(0);
        let text = String::from_utf8(output.get_output().stdout.clone()).expect("text");
        text.lines().skip(1).map(|line| line.split(',').next().expect("a name").into()).collect()
    };
    // Each optional part of its own, back to what files without it have.
    let neo = rows(&["neo", TRACE, "--ablate", "--out", &out("a")]);
    assert_eq!(neo[0], "neo");
    assert!(neo.iter().any(|name| name.starts_with("neo-gsu.impl-")), "{neo:?}");
    // What is named, and several of them.
    let named = ["--ablate", "geometry.test=aabb", "--ablate", "vru.cores=8"];
    let named = rows(&[&["gscore", TRACE][..], &named, &["--out", &out("b")]].concat());
    assert_eq!(named, ["gscore", "gscore-geometry.test-aabb", "gscore-vru.cores-8"]);
    for (arguments, words) in [
        (&["gscore", TRACE, "--ablate", "vru.cores=0"][..], "cannot do without"),
        (&["gscore", TRACE, "--ablate", "nonsense"][..], "write KEY=VALUE"),
        (&["gscore", "edge", TRACE, "--ablate"][..], "name one only"),
    ] {
        program(arguments).assert().code(2).stderr(predicate::str::contains(words));
    }
}

#[test]
fn one_memory_for_all_and_what_is_asked_of_them() {
    let root = tempfile::tempdir().expect("a folder");
    let out = |name: &str| root.path().join(name).to_string_lossy().into_owned();
    let found = |more: &[&str], name: &str| -> serde_json::Value {
        let machines = ["gscore", "vorion", "orin-nx", TRACE, "--frames", "0..2", "--json"];
        let output = program(&machines).args(more).args(["--out", &out(name)]).assert().code(0);
        serde_json::from_slice(&output.get_output().stdout).expect("JSON")
    };
    let names = |json: &serde_json::Value| -> Vec<String> {
        let basis = json["basis"].as_array().expect("a basis").iter();
        basis.map(|part| part["name"].as_str().expect("a name").to_owned()).collect()
    };
    let own = found(&[], "own");
    let parts = ["memory", "memory_model", "memory_price", "node", "area_scope", "power_scope"];
    assert_eq!(names(&own), parts);
    let common = found(&["--common"], "common");
    assert_eq!(names(&common), ["node", "area_scope", "power_scope"]);
    let peaks = common["measures"].as_array().expect("measures").iter();
    let peak = peaks.clone().find(|m| m["name"] == "dram_peak_gb_s").expect("a rate");
    assert_eq!(peak["values"], serde_json::json!([51.2, 51.2, 51.2]));
    // The second machine has two frames under way; it is met by the display, and late for eyes.
    let asked = found(&["--fps", "30", "--budget", "1W"], "asked");
    let verdict = |json: &serde_json::Value, i: usize| json["decision"][i]["verdict"].clone();
    assert_eq!(verdict(&asked, 0), "meets all");
    assert!(verdict(&asked, 2).as_str().expect("words").contains("OVER"), "{}", asked["decision"]);
    let late = found(&["--fps", "30", "--latency", "1us"], "late");
    assert!(verdict(&late, 0).as_str().expect("words").starts_with("LATE"));
    let not = found(&["--where", "dram.busy_frac.max < 0"], "where");
    assert_eq!(verdict(&not, 0), "NOT --where");
    let wrong = program(&["gscore", "edge", TRACE, "--where", "no_such < 1"]).assert().code(2);
    wrong.stderr(predicate::str::contains("no_such"));
    let rate = program(&["orin-nx", "gscore", TRACE, "--common"]).assert().code(2);
    rate.stderr(predicate::str::contains("begin with a machine that has a device"));
}

#[test]
fn tasks_have_no_ratios_and_tables_are_for_papers() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("t").to_string_lossy().into_owned();
    let machines = ["gscore", "gsarch", TRACE, "--frames", "0..1", "--out", &out];
    let page = program(&machines).assert().code(0);
    page.stdout(predicate::str::contains("tasks differ (render, train all)"))
        .stdout(predicate::str::contains("--across-tasks"));
    let tex = program(&machines).args(["--force", "--table", "tex"]).assert().code(0);
    tex.stdout(predicate::str::starts_with("\\begin{tabular}{lrrrlr}\n\\toprule\n"))
        .stdout(predicate::str::contains("gscore (render) & "))
        .stdout(predicate::str::contains("\n% tasks differ (render, train all)"));
    let md = program(&machines).args(["--force", "--table", "md"]).assert().code(0);
    md.stdout(predicate::str::contains("| gsarch (train) |"));
    program(&machines).args(["--force", "--table", "md", "--json"]).assert().code(2);
}

#[test]
fn usage() {
    for (arguments, code, words) in [
        (&["gscore", TRACE][..], 2, "one machine only"),
        (&["gscore", "edge"][..], 2, "no trace: edge is not a file"),
        (&[TRACE, "gscore", "edge"][..], 2, "traces go last"),
        (&["gscore", TRACE, "edge", TRACE][..], 2, "is a trace; traces go last"),
        (&[TRACE, TRACE][..], 2, "no machine"),
        (&["gscore", "gscor", TRACE][..], 2, "did you mean `gscore`?"),
        (&["gscore", "edge", "no-such.bin"][..], 3, "no-such.bin"),
        (&["gscore", "traces", TRACE][..], 2, "report folders cannot be compared with machines"),
        (&["traces", "reports"][..], 3, "is its folder a finished report"),
        (&["gscore"][..], 2, "one machine only"),
        (&["gscore", "edge", TRACE, "--at-least", "0"][..], 2, "must be above zero"),
        (&["gscore", "edge", TRACE, "--charts", "speedup"][..], 2, "has decision, power, cycles"),
        (&["gscore", "edge", TRACE, "--charts", "pie"][..], 2, "decision, power, cycles"),
        (&["gscore", "edge", TRACE, "--chart-size", "3.5"][..], 2, "3.5in, 88mm, 8.8cm or 252pt"),
        (&["gscore", "edge", TRACE, "--chart-size", "wide"][..], 2, "column, page or slide"),
        (&["gscore", "edge", TRACE, "--chart-size", "88m"][..], 2, "a width with its unit"),
        (&["gscore", "edge", TRACE, "--chart-size=-3in"][..], 2, "a width with its unit"),
        (&["gscore", "edge", TRACE, "--chart-size", "1in"][..], 2, "1.5in to 20in wide"),
        (&["gscore", "edge", TRACE, "--chart-size", "9999999pt"][..], 2, "1.5in to 20in wide"),
    ] {
        let failed = program(arguments).assert().code(code);
        failed.stderr(predicate::str::contains(words));
    }
}

#[test]
fn only_the_charts_that_are_asked_for_are_drawn() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("c");
    let args = ["gscore", "edge", TRACE, "--frames", "0..1", "--charts", "power,decision", "--out"];
    program(&[&args[..], &[out.to_str().expect("a path")]].concat()).assert().code(0);
    let drawn = |name: &str| out.join(name).exists();
    assert!(drawn("power.png") && drawn("decision.png") && !drawn("cycles.png"));
}

#[test]
fn what_is_in_the_wrong_place_is_said() {
    let trace = format!("{}/traces/demo.bin", env!("CARGO_MANIFEST_DIR"));
    let dir = tempfile::tempdir().expect("a folder");
    let folder = dir.path().display().to_string();
    let missing = dir.path().join("report-2").display().to_string();
    for (args, words) in [
        (["compare", "gscore", "edge", ""].as_slice(), "no trace"),
        (&["compare", &trace, "gscore", "edge"], "traces go last"),
        (&["compare", &folder, &missing, ""], "there is no such report folder"),
        (&["sensitivity", &trace, "gscore", ""], "the machine goes first"),
    ] {
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        command.args(args.iter().filter(|a| !a.is_empty())).current_dir(dir.path());
        let output = command.assert().code(2);
        let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(said.contains(words), "{args:?}: {said}");
    }
}

#[test]
fn tables_are_as_wide_as_columns_says() {
    let widest = |columns: &str| {
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        let output = command.args(["arch", "list"]).env("COLUMNS", columns).assert().code(0);
        let text = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
        text.lines().map(|l| l.chars().count()).max().unwrap_or(0)
    };
    assert!(widest("60") <= 60 && widest("80") <= 80);
    assert!((81..=160).contains(&widest("160")), "{}", widest("160"));
}

#[test]
fn standard_workloads_stand_in_for_traces() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("report").display().to_string();
    let flat = ["--set", "dram.model=bandwidth", "--out", &out];
    let words = ["gscore", "edge", "--workloads", "train", "--json"];
    let done = program(&words).args(flat).assert().success();
    let json: serde_json::Value = serde_json::from_slice(&done.get_output().stdout).expect("JSON");
    let trace = |side: usize| json["sides"][side]["trace"].as_str();
    assert_eq!([trace(0), trace(1)], [Some("train"), Some("train")], "{json}");
    // The frame before a path is remembered, and not asked for.
    let words = ["gscore", "neo", "--workloads", "uhd-path-hd", "--json", "--force"];
    let done = program(&words).args(flat).assert().success();
    let json: serde_json::Value = serde_json::from_slice(&done.get_output().stdout).expect("JSON");
    assert_eq!(json["sides"][1]["frames"], 2, "{json}");
    assert_eq!(json["sides"][1]["incomplete"], false, "{json}");
    for (arguments, words) in [
        (&["gscore", "edge", "--workloads", "moon"][..], "no workload `moon`"),
        (&["gscore", "--workloads", "train"][..], "one machine only"),
        (&["gscore", TRACE, "--workloads", "train"][..], "is a trace"),
        (&["--all-machines"][..], "--workloads"),
    ] {
        let failed = program(arguments).assert().code(2);
        failed.stderr(predicate::str::contains(words));
    }
}
