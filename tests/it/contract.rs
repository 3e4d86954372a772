//! One machine, many commands: every number that two of them print is the same number.
//!
//! The machines are those that loops of their own have got wrong: one that keeps the order of the
//! frame before, one with a feature cache, one on foveated frames, one with a banked DRAM.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use assert_cmd::Command;
use powergs_sim::optimize::oracle::{CycleOracle, PowerOracle, RenderedFrame};
use powergs_sim::raster::{Detail, Options, render};
use powergs_sim::run::{Session, Subject, System};
use powergs_sim::scene::camera::edit::resized;
use powergs_sim::scene::synth::{Preset, cameras, generate};
use powergs_sim::views::RenderedViews;
use serde_json::Value;
use tempfile::TempDir;

/// A machine with `--set` values, and the trace it runs.
struct Case {
    name: &'static str,
    arch: &'static str,
    sets: &'static [&'static str],
    trace: &'static str,
}

/// What-if and sweeps of a machine with `banked` take another model, unless they are told not to.
const FLAT: &str = "dram.model=bandwidth";

const PLAIN: Case = Case { name: "plain", arch: "gscore", sets: &[FLAT], trace: "demo.bin" };

const CASES: [Case; 5] = [
    PLAIN,
    Case { name: "order reuse", arch: "neo", sets: &[FLAT], trace: "demo.bin" },
    Case {
        name: "feature cache",
        arch: "gscore",
        sets: &[FLAT, "cache.capacity=32 KiB", "cache.ways=4"],
        trace: "demo.bin",
    },
    Case { name: "banked", arch: "gscore", sets: &["dram.model=banked"], trace: "demo.bin" },
    Case {
        name: "foveated",
        arch: "gscore",
        sets: &[FLAT, "fovea.accumulators=2"],
        trace: "gazed.bin",
    },
];

/// A folder with a plain and a foveated trace.
struct Bench {
    folder: TempDir,
}

impl Bench {
    fn new() -> Bench {
        let folder = tempfile::tempdir().expect("a folder");
        let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
        fs::copy(demo, folder.path().join("demo.bin")).expect("the demo trace");
        let bench = Bench { folder };
        let scene = ["synth", "demo", "--points", "1500", "-o", "s.ply", "--cameras", "c.json"];
        bench.run(&scene);
        bench.run(&["scene", "compose", "s.ply", "s.ply", "s.ply", "s.ply", "-o", "s.fov"]);
        let views = ["--cameras", "c.json", "--size", "160x120", "--frames", "0..3"];
        let gaze = ["--gaze", "0.4,0.6", "--screen", "powergs", "-o", "gazed.bin"];
        bench.run(&[&["extract", "s.fov"][..], &views, &gaze].concat());
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Standard output of the program, which must end with 0.
    fn run(&self, arguments: &[&str]) -> Vec<u8> {
        let mut program = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        program.current_dir(self.folder.path()).args(arguments).env_remove("POWERGS_SHARD");
        program.assert().success().get_output().stdout.clone()
    }

    fn json(&self, arguments: &[&str]) -> Value {
        let output = self.run(&[arguments, &["--json"]].concat());
        serde_json::from_slice(&output).expect("JSON")
    }

    fn replay(&self, case: &Case, more: &[&str], out: &str) -> Value {
        let sets = case.sets.iter().flat_map(|&set| ["--set", set]);
        let mut arguments = vec!["replay", case.trace, "--arch", case.arch, "--out", out];
        arguments.extend(sets);
        arguments.extend(more);
        self.json(&arguments)
    }

    /// The rows of a CSV file by their first cell, the last row of that name.
    fn rows(&self, path: &str, key: usize) -> BTreeMap<String, BTreeMap<String, String>> {
        table(&self.path(path), key)
    }
}

fn table(path: &Path, key: usize) -> BTreeMap<String, BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let head = reader.headers().expect("columns").clone();
    let row = |record: csv::StringRecord| {
        let cells = head.iter().map(str::to_owned).zip(record.iter().map(str::to_owned));
        (record[key].to_owned(), cells.collect())
    };
    reader.records().map(|record| row(record.expect("a row"))).collect()
}

/// The same number, to the rounding of sums in another order.
#[track_caller]
fn same(what: &str, a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * a.abs().max(b.abs()), "{what}: {a} against {b}");
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok()
}

#[test]
fn every_command_prints_the_same_numbers() {
    let bench = Bench::new();
    for (i, case) in CASES.iter().enumerate() {
        let folder = format!("replay-{i}");
        let replay = bench.replay(case, &["--what-if", "9", "--timeline", "1"], &folder);
        let rows = bench.rows(&format!("{folder}/results.csv"), 0);
        timeline(&bench, case, &folder);
        what_if(case, &replay);
        compare(&bench, case, &rows["mean"], i);
        sensitivity(&bench, case, &rows["mean"], i);
        sweep(&bench, case, (&replay, &rows), i);
    }
}

/// The last event of a timeline ends with the frame.
fn timeline(bench: &Bench, case: &Case, folder: &str) {
    let frames = bench.rows(&format!("{folder}/results.csv"), 1);
    let end_us = 1e3 * number(&frames["1"]["frame_time_ms"]).expect("a time");
    let file = fs::File::open(bench.path(folder).join("trace.json.gz")).expect("a timeline");
    let mut text = String::new();
    flate2::read::GzDecoder::new(file).read_to_string(&mut text).expect("gzip");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let events = json["traceEvents"].as_array().expect("events").iter();
    let ends = events.filter_map(|e| Some(e["ts"].as_f64()? + e["dur"].as_f64()?));
    let last = ends.fold(0.0, f64::max);
    let most = 1.01 * end_us;
    assert!(last <= most && last > 0.99 * end_us, "{}: {last} us of {end_us} us", case.name);
}

/// The base of the experiment, here on all frames, is the run itself.
fn what_if(case: &Case, replay: &Value) {
    for name in ["frame_time_ms", "energy_pj"] {
        let of = |v: &Value| v["mean"].as_f64().or_else(|| v["total"]["mean"].as_f64());
        let aggregate = &replay["aggregate"][name];
        let all = of(aggregate).unwrap_or_else(|| panic!("{name}: {aggregate}"));
        let base = replay["what_if"][name].as_f64().expect("a base");
        if case.name == "banked" {
            // Ten machines are compared with the calibrated model, this one among them.
            assert!(base != all && (base / all - 1.0).abs() < 0.04, "{name}: {base} for {all}");
            continue;
        }
        same(&format!("{}: what-if {name}", case.name), all, base);
    }
}

/// Every statistic of `replay` is what `compare` says of the same machine.
fn compare(bench: &Bench, case: &Case, means: &BTreeMap<String, String>, i: usize) {
    let folder = format!("compare-{i}");
    let sets = case.sets.iter().flat_map(|&set| ["--set", set]);
    let mut arguments = vec!["compare", case.arch, case.arch, case.trace, "--out", &folder, "-q"];
    arguments.extend(sets);
    bench.run(&arguments);
    let rows = bench.rows(&format!("{folder}/compare.csv"), 1);
    let column = rows["frame_time_ms"].keys().find(|k| k.starts_with(case.arch)).expect("a side");
    let mut compared = 0;
    for (name, cell) in means {
        let (Some(ours), Some(row)) = (number(cell), rows.get(name)) else { continue };
        let theirs = number(&row[column]).unwrap_or_else(|| panic!("{}: {name}", case.name));
        same(&format!("{}: compare {name}", case.name), ours, theirs);
        compared += 1;
    }
    assert!(compared > 80, "{}: only {compared} statistics", case.name);
}

/// What `sensitivity` compares with is the run, and so is the machine with a key at twice its
/// value.
fn sensitivity(bench: &Bench, case: &Case, means: &BTreeMap<String, String>, i: usize) {
    let folder = format!("sensitivity-{i}");
    let sets = case.sets.iter().flat_map(|&set| ["--set", set]);
    let mut arguments = vec!["sensitivity", case.arch, case.trace, "--keys", "vru.units-per-core"];
    arguments.extend(["--out", &folder]);
    if case.name == "banked" {
        arguments.extend(["--dram-model", "banked"]);
    }
    arguments.extend(sets);
    let json = bench.json(&arguments);
    let base = &json["traces"][0]["base"];
    let value = |from: &Value, name: &str| from[name].as_f64().expect("a number");
    let mean = |means: &BTreeMap<String, String>, name: &str| number(&means[name]).expect(name);
    let columns = [
        ("frame_time_ms", "frame_time_ms"),
        ("energy_pj", "energy_pj.total"),
        ("power_display_rate_w", "power_w.total"),
        ("area_mm2", "area_mm2.total"),
    ];
    for (ours, theirs) in columns {
        let what = format!("{}: sensitivity {ours}", case.name);
        same(&what, value(base, ours), mean(means, theirs));
    }
    let turned = json["keys"][0]["varied"].as_array().expect("values");
    let twice = turned.iter().find(|t| t["reach"] == "far" && t["ratio"] == 2.0);
    let twice = twice.expect("twice the units");
    let set = format!("vru.units-per-core={}", twice["value"].as_str().expect("a value"));
    let folder = format!("twice-{i}");
    bench.replay(case, &["--what-if", "0", "--set", &set], &folder);
    let rows = bench.rows(&format!("{folder}/results.csv"), 0);
    for (ours, theirs) in columns {
        let what = format!("{}: {set} {ours}", case.name);
        same(&what, value(&twice["outcomes"][0], ours), mean(&rows["mean"], theirs));
    }
}

/// The baseline of a sweep is the run: every column that both have.
fn sweep(
    bench: &Bench,
    case: &Case,
    (replay, rows): (&Value, &BTreeMap<String, BTreeMap<String, String>>),
    i: usize,
) {
    let file = format!(
        "question = \"q\"\nbase = \"{}\"\n[[axes]]\nkey = \"vru.cores\"\nvalues = [2, 4]\n",
        case.arch
    );
    let name = format!("sweep-{i}.toml");
    fs::write(bench.path(&name), file).expect("a file");
    let folder = format!("sweep-{i}");
    let mut arguments = vec!["sweep", &name, "--traces", case.trace, "--out", &folder, "-q"];
    arguments.extend(case.sets.iter().flat_map(|&set| ["--set", set]));
    bench.run(&arguments);
    let baseline = bench.rows(&format!("{folder}/results.csv"), 1)["true"].clone();
    assert_eq!(baseline["status"], "ok", "{}: {}", case.name, baseline["reason"]);
    // Over all frames together, which is not the mean of the powers of the frames.
    let throughput = replay["throughput_power_w"].as_f64().expect("a power");
    let full_rate = number(&baseline["power_full_rate_w"]).expect("a power");
    same(&format!("{}: power_full_rate_w", case.name), throughput, full_rate);
    let mut compared = 0;
    for (column, cell) in baseline.iter().filter(|(name, _)| *name != "power_full_rate_w") {
        let (name, row) = match column.rsplit_once('.') {
            Some((name, row @ ("mean" | "p50" | "p95" | "p99" | "max"))) => (name, row),
            _ => (column.as_str(), "mean"),
        };
        let row = &rows[row];
        let ours = row.get(name).or_else(|| row.get(&format!("{name}.total")));
        let (Some(ours), Some(theirs)) = (ours.and_then(|c| number(c)), number(cell)) else {
            continue;
        };
        same(&format!("{}: sweep {column}", case.name), ours, theirs);
        compared += 1;
    }
    assert!(compared > 30, "{}: only {compared} columns", case.name);
}

/// The optimiser asks the machine for one frame; a session over the same view says the same.
#[test]
fn the_oracle_of_the_optimiser_is_the_session() {
    let preset = Preset::named("demo").expect("a preset");
    let scene = Arc::new(generate(preset, 1500, 1));
    let views: Vec<_> = cameras(preset).iter().take(2).map(|c| resized(c, 160, 120)).collect();
    for case in CASES.iter().filter(|case| case.trace == "demo.bin") {
        let sets: Result<Vec<_>, String> = case.sets.iter().map(|set| set.parse()).collect();
        let system = System::named(case.arch).and_then(|s| s.with(&sets.expect("changes")));
        let system = system.expect("a machine");
        let oracle = CycleOracle {
            system: system.clone(),
            fps: 60.0,
            memory: powergs_sim::budget::Budget::DEFAULT,
        };
        for view in &views {
            let mut frames = RenderedViews::new("views", Arc::clone(&scene), vec![view.clone()]);
            let folded = Session::new(&mut frames, &())
                .fold(
                    &[Subject::of(&system)],
                    |_| 0.0,
                    |watts, view| {
                        *watts += view.report.power_display_rate_w(60.0);
                    },
                )
                .expect("a session");
            let shot = render(&scene, view, &Options::reference(Detail::Counters));
            let parts =
                oracle.frame(RenderedFrame::Plain(shot), view, [0.0; 3]).expect("the oracle");
            same(&format!("{}: oracle", case.name), parts.total_w(), folded.states[0]);
        }
    }
}

/// A machine that cannot show foveated frames is refused in the same way by every command.
#[test]
fn refusals_are_the_same_everywhere() {
    let bench = Bench::new();
    let commands: [&[&str]; 3] = [
        &["replay", "gazed.bin", "--arch", "flicker"],
        &["compare", "gscore", "flicker", "gazed.bin"],
        &["sensitivity", "flicker", "gazed.bin", "--keys", "vru.*"],
    ];
    let mut messages = Vec::new();
    for arguments in commands {
        let mut program = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        program.current_dir(bench.folder.path()).args(arguments).args(["--set", FLAT]);
        let assert = program.assert().code(2);
        messages.push(String::from_utf8(assert.get_output().stderr.clone()).expect("text"));
    }
    assert!(messages[0].contains("fovea.accumulators = 1"), "{}", messages[0]);
    assert!(messages.iter().all(|m| *m == messages[0]), "{messages:#?}");
}
