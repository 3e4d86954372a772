//! `arch` and `explain` as the user sees them.

use assert_cmd::Command;
use powergs_sim::config::embedded::MACHINES;
use powergs_sim::config::{key_docs, knob};
use powergs_sim::machine::Machine;
use powergs_sim::run::files::DiskFiles;
use powergs_sim::run::{System, SystemSpec};
use predicates::prelude::*;
use predicates::str::{contains, ends_with};

use super::gscore;

fn program(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
    command.args(args);
    command
}

#[test]
fn list_fits_a_terminal() {
    let output = program(&["arch", "list"]).assert().code(0).get_output().stdout.clone();
    let text = String::from_utf8(output).expect("text");
    for name in
        ["gscore ", "gscore-16core", "edge", "gscore-28nm", "paper", "oled-d22", "sram-bandwidth"]
    {
        assert!(text.contains(name), "{text}");
    }
    assert!(text.lines().all(|l| l.chars().count() <= 80), "{text}");
    program(&["arch", "list", "--json"]).assert().code(0).stdout(contains("\"description\""));
}

#[test]
fn show_prints_the_file_or_what_a_run_would_use() {
    // The first line of the file names a schema that a copy does not have beside it.
    let (schema, rest) = gscore().split_once('\n').expect("a first line");
    assert_eq!(schema, "#:schema ../schema/machine.json");
    let whole = program(&["arch", "show", "gscore"]).assert().code(0);
    whole.stdout(ends_with(rest).and(contains("arch schema machine")).and(contains("../").not()));
    let shown = program(&["arch", "show", "gscore", "--set", "vru.cores=8"]).assert().code(0);
    shown.stdout(contains("cores = 8").and(contains('#').not()));
    let unknown = program(&["arch", "show", "gscor"]).assert().code(2);
    unknown.stderr(contains("did you mean `gscore`?").and(contains("edge")));
    program(&["arch", "show", "no/such.toml"]).assert().code(2).stderr(contains("no/such.toml"));
    let unknown = program(&["arch", "show", "gscor", "--figure", "-o", "x.svg"]).assert().code(2);
    unknown.stderr(contains("gscore"));
    let ending = program(&["arch", "show", "gscore", "--figure", "-o", "x.gif"]).assert().code(2);
    ending.stderr(contains("x.gif: a chart is a .png, .svg or .pdf file"));
}

#[test]
fn check_reports_everything_with_exit_code_2() {
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("mine.toml");
    let bad = gscore().replace("cores = 4 ", "core = 4 ").replace("\"1 GHz\"", "1");
    std::fs::write(&path, bad).expect("a file");
    let file = path.to_str().expect("a path");
    let failed = program(&["arch", "check", "gscore", file, "paper"]).assert().code(2);
    let failed = failed.stdout(contains("gscore: ok").and(contains("paper: ok")));
    let wanted = contains("2 problems").and(contains("did you mean `cores`?"));
    failed.stderr(wanted.and(contains("^^^")).and(contains("mine.toml: ")));
    let json = program(&["arch", "check", "--json", file]).assert().code(2);
    let output = json.get_output().stdout.clone();
    let report: serde_json::Value = serde_json::from_slice(&output).expect("JSON");
    assert_eq!(report[0]["problems"][0]["key"], "clock");
    assert_eq!(report[0]["problems"][0]["line"], 11);
    std::fs::write(&path, [0xff, 0xfe, 0x00]).expect("a file");
    program(&["arch", "check", file]).assert().code(2).stderr(contains("not UTF-8"));
}

#[test]
fn sweeps_are_listed_shown_and_checked() {
    program(&["arch", "show", "tiles"]).assert().code(0).stdout(contains("question = "));
    program(&["arch", "schema", "sweep"]).assert().code(0).stdout(contains("\"constraints\""));
    let resolved = program(&["arch", "show", "tiles", "--resolved"]).assert().code(2);
    resolved.stderr(contains("sweep show"));
    for name in ["gscore-units", "node-choice", "node-energy", "sram-bandwidth", "tiles"] {
        let good = program(&["arch", "check", name]).assert().code(0);
        good.stdout(contains(": ok (sweep of gscore, a space of "));
    }
    let dir = tempfile::tempdir().expect("a folder");
    let path = dir.path().join("mine.toml");
    let bad = "question = \"?\"\nbase = \"gscore\"\n[[axes]]\nkey = \"vru.core\"\nvalues = [1]\n";
    std::fs::write(&path, bad).expect("a file");
    let failed = program(&["arch", "check", path.to_str().expect("a path")]).assert().code(2);
    failed.stderr(contains("mine.toml: ").and(contains("vru.cores")));
}

#[test]
fn check_looks_at_the_energy_table_too() {
    let args = ["arch", "check", "gscore", "--set", "energy=gscore-28"];
    let failed = program(&args).assert().code(2);
    failed.stderr(contains("in --set energy=gscore-28").and(contains("`gscore-28nm`")));
    let args = ["arch", "check", "gscore", "--set", "buffers.feature.capacity=512 MiB"];
    program(&args).assert().code(2).stderr(contains("allow-extrapolation"));
}

#[test]
fn explain_knows_keys_and_statistics() {
    let cores = program(&["explain", "vru.cores"]).assert().code(0);
    cores.stdout(contains("unit   cores").and(contains("4 in gscore")).and(contains("own GSU")));
    program(&["explain", "frame_time_ms"]).assert().code(0).stdout(contains("(statistic)"));
    let both = program(&["explain", "dram"]).assert().code(0);
    both.stdout(contains("dram.efficiency").and(contains("statistic")));
    program(&["explain", "vru.cors"]).assert().code(2).stderr(contains("`vru.cores`"));
    program(&["explain", "--json", "clock"]).assert().code(0).stdout(contains("\"unit\""));
}

#[test]
fn a_machine_is_loaded_with_its_table_and_its_sources() {
    let dir = tempfile::tempdir().expect("a folder");
    let energy =
        powergs_sim::config::embedded::find(powergs_sim::config::embedded::ENERGY, "gscore-28nm");
    std::fs::write(dir.path().join("mine-energy.toml"), energy.expect("a table")).expect("a file");
    let machine = gscore().replace("energy = \"gscore-28nm\"", "energy = \"mine-energy.toml\"");
    let path = dir.path().join("mine.toml");
    std::fs::write(&path, machine).expect("a file");
    let file = path.to_str().expect("a path");
    let sets = vec!["vru.cores=2".to_owned()];
    let spec = SystemSpec { sets, ..SystemSpec::named(file) };
    let loaded = System::load(&spec, &DiskFiles).expect("a table beside the machine");
    assert_eq!(loaded.machine().tiles().vru.cores, 2);
    assert!(loaded.machine_toml().contains("cores = 2"));
    assert_eq!(loaded.energy_table().name, "gscore-28nm");
    for source in ["neo", "cacti", "A4", "A10"] {
        assert!(loaded.sources().contains(source), "{:?}", loaded.sources());
    }
    let default = System::named("gscore").expect("the default");
    assert!(
        loaded.prices().leakage_w() < default.prices().leakage_w(),
        "two cores leak less than four"
    );
}

/// Without bases, and without keys of parts that it does not have.
#[test]
fn a_resolved_file_is_the_same_machine() {
    for file in MACHINES {
        let shown = program(&["arch", "show", file.name, "--resolved"]).assert().code(0);
        let text = String::from_utf8_lossy(&shown.get_output().stdout).into_owned();
        let [whole, own] = [&text, file.text].map(|text| Machine::parse(text).expect(file.name));
        assert_eq!(whole.to_toml(), own.to_toml(), "{}", file.name);
        assert!(text.contains(" # ") && !text.contains("\nbase = "), "{}", file.name);
        let said: toml::Table = text.parse().expect("TOML");
        for key in key_docs::<Machine>().iter().filter(|key| !key.table) {
            let [said, stated] =
                [&said, &own.stated()].map(|table| knob::values(table, &key.path).len());
            // `numbers = "none"` is said and is no value.
            assert!(said >= stated, "{}: {}", file.name, key.path);
        }
    }
}

#[test]
fn a_file_on_a_base_is_shown_checked_and_compared() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = |name: &str, text: &str| {
        let path = dir.path().join(name);
        std::fs::write(&path, text).expect("a file");
        path.display().to_string()
    };
    let mine =
        file("mine.toml", "base = \"gscore\"\nname = \"mine\"\n\n[vru]\ncores = 2 # [neo]\n");
    // A base by path, beside the file that names it.
    let next = file("next.toml", "base = \"mine.toml\"\nname = \"next\"\nclock = \"500 MHz\"\n");
    program(&["arch", "check", &next]).assert().code(0).stdout(contains("machine next"));
    let shown = program(&["arch", "show", &next]).assert().code(0);
    shown.stdout(contains("base = \"mine.toml\"").and(contains("units").not()));
    let whole = program(&["arch", "show", &next, "--resolved"]).assert().code(0);
    let comment = "cores = 2 # [neo]";
    whole.stdout(contains(comment).and(contains("# [nerarch-sim]")).and(contains("#line").not()));
    let different = program(&["arch", "diff", "gscore", &next, "--json"]).assert().code(0);
    let keys: serde_json::Value =
        serde_json::from_slice(&different.get_output().stdout).expect("JSON");
    let keys: Vec<&str> =
        keys.as_array().unwrap().iter().map(|k| k["key"].as_str().unwrap()).collect();
    assert_eq!(keys, ["name", "description", "clock", "vru.cores"]);
    program(&["arch", "diff", "gscore", "gscore-28nm"]).assert().code(2);
    // A complete file makes the same machine, and a run names all files that it came from.
    let complete = file(
        "complete.toml",
        &String::from_utf8_lossy(
            &program(&["arch", "show", &next, "--resolved"]).output().unwrap().stdout,
        ),
    );
    let replay = |machine: &str, out: &str| {
        let out = dir.path().join(out);
        let out = out.display().to_string();
        let trace = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
        let run = ["replay", trace, "--arch", machine, "--what-if", "0", "--out", &out, "-q"];
        program(&run).assert().code(0);
        let read = |name: &str| std::fs::read_to_string(format!("{out}/{name}")).expect(name);
        (read("results.csv"), read("run.toml"))
    };
    let (a, b) = (replay(&next, "a"), replay(&complete, "b"));
    assert_eq!(a.0, b.0);
    for name in ["next.toml", "mine.toml", "gscore"] {
        assert!(a.1.contains(&format!("name = \"{name}\"")), "{name}\n{}", a.1);
    }
    // Where a value was written is where it is wrong.
    file("mine.toml", "base = \"gscore\"\nname = \"mine\"\n\n[vru]\ncores = 0\n");
    let wrong = program(&["arch", "check", &next]).assert().code(2);
    wrong.stderr(contains("line 5 of ").and(contains("mine.toml")).and(contains("`vru.cores`")));
    for (base, why) in [
        ("next.toml", "goes round in a circle"),
        ("nobody.toml", "nobody.toml"),
        ("gscor", "did you mean `gscore`?"),
    ] {
        file("mine.toml", &format!("base = \"{base}\"\nname = \"mine\"\n[vru]\ncores = 1\n"));
        for command in [&["arch", "check", &mine][..], &["replay", "x.bin", "--arch", &mine]] {
            let failed = program(command).assert().failure();
            failed.stderr(contains("`base`").and(contains(why)));
        }
    }
    // A table of prices is no base of a machine.
    let machine = file("m.toml", "base = \"gscore-28nm\"\nname = \"m\"\n[vru]\ncores = 1\n");
    program(&["arch", "check", &machine]).assert().code(2).stderr(contains("no machine"));
}

/// Papers write KB for 1,024 bytes; files are read as they are written, and what looks like a
/// paper's number is asked about.
#[test]
fn kilobytes_that_may_be_kibibytes_are_asked_about() {
    let dir = tempfile::tempdir().expect("a folder");
    let file = |name: &str, size: &str| {
        let path = dir.path().join(name);
        let head = "name = \"mine\"\nbase = \"gscore\"";
        let text = format!("{head}\n[buffers.feature]\ncapacity = \"{size}\"\n");
        std::fs::write(&path, text).expect("a file");
        path.to_str().expect("a path").to_owned()
    };
    // Pages are wrapped.
    let asked = || contains("is 1000 B here").and(contains("\"64 KiB\" where a"));
    let paper = file("paper.toml", "64 KB");
    program(&["arch", "check", &paper]).assert().code(0).stdout(asked());
    let replay =
        program(&["replay", "traces/demo.bin", "--frames", "0..1", "--arch", &paper]).assert();
    replay.code(0).stderr(asked());
    for (name, size) in [("binary.toml", "64 KiB"), ("round.toml", "100 KB"), ("two.toml", "2 KB")]
    {
        let said = program(&["arch", "check", &file(name, size)]).assert();
        said.stdout(contains("1000 B here").not());
    }
}
