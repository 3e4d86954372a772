//! Runs of other simulators: the way from `trace dump` to a comparison, as its page tells it.

use std::fs;
use std::path::Path;
use std::process::Command;

use assert_cmd::Command as Program;

/// The program in a folder.
fn powergs(arguments: &[&str]) -> Program {
    let mut command = Program::new(env!("CARGO_BIN_EXE_powergs-sim"));
    command.args(arguments);
    command
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn text(path: &str) -> String {
    fs::read_to_string(root().join(path)).expect(path)
}

#[test]
fn the_page_shows_the_example() {
    let page = text("docs/elsewhere.md");
    for path in ["examples/elsewhere/run.py", "examples/elsewhere/elsewhere.toml"] {
        assert!(page.contains(text(path).trim_end()), "docs/elsewhere.md lacks {path}");
    }
}

/// Without Python there is nothing to run the example with.
#[test]
fn from_a_dump_to_a_comparison() {
    if Command::new("python3").arg("--version").output().is_err() {
        eprintln!("skipped: no python3");
        return;
    }
    let home = tempfile::tempdir().expect("a folder");
    let at = |name: &str| home.path().join(name).display().to_string();
    let demo = root().join("traces/demo.bin").display().to_string();
    fs::create_dir(home.path().join("frame0")).expect("a folder");
    for what in ["splats", "facts"] {
        let file = at(&format!("frame0/{what}.csv"));
        let dump = ["trace", "dump", &demo, "--frame", "0", "--what", what, "-o", &file];
        powergs(&dump).assert().success();
    }
    let mut script = Command::new("python3");
    script.arg(root().join("examples/elsewhere/run.py")).arg(home.path().join("frame0"));
    let run = script.output().expect("it runs");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    fs::write(home.path().join("demo.csv"), &run.stdout).expect("a file");
    let machine = at("elsewhere.toml");
    fs::copy(root().join("examples/elsewhere/elsewhere.toml"), &machine).expect("a file");
    let said = |arguments: &[&str]| {
        let run = powergs(arguments).assert().success();
        String::from_utf8_lossy(&run.get_output().stdout).into_owned()
    };
    let compare =
        ["compare", "gscore", &machine, &demo, "--frames", "0..1", "--out", &at("compare")];
    let compare = said(&compare);
    assert!(compare.contains("raster busy") && compare.contains("vru busy"), "{compare}");
    let sweep = r#"
question = "How many channels does it need, beside GSCore?"
base = "elsewhere.toml"
[objectives]
minimize = ["power_w.mean", "area_mm2"]
maximize = ["fps.mean"]
[[axes]]
key = "machine"
values = ["elsewhere.toml", "gscore"]
[[axes]]
key = "dram.channels"
values = [2, 4, 8]
"#;
    fs::write(home.path().join("sweep.toml"), sweep).expect("a file");
    let mut command = powergs(&["sweep", "sweep.toml", "--traces", &demo, "--frames", "0..1"]);
    command.current_dir(home.path()).args(["--out", "sweep"]).assert().success();
    let record = fs::read_to_string(home.path().join("sweep/run.toml")).expect("a record");
    assert!(record.contains(r#"role = "run""#), "the run is an input: {record}");
    let pareto = said(&["pareto", &at("sweep")]);
    assert!(pareto.contains("elsewhere.toml"), "{pareto}");
    // The other frames were not run.
    let missing = powergs(&["replay", &demo, "--arch", &machine, "--out", &at("all")]).assert();
    let missing = String::from_utf8_lossy(&missing.failure().get_output().stderr).into_owned();
    assert!(missing.contains("`demo.csv` has no frame") && missing.contains("--what facts"));
    powergs(&["arch", "check", &machine]).assert().success();
    // And none of them is of a model that is made here.
    let (scene, cameras) = (at("scene.ply"), at("cameras.json"));
    let synth = ["synth", "demo", "--points", "300", "-o", &scene, "--cameras", &cameras];
    powergs(&synth).assert().success();
    let mut optimize = powergs(&["optimize", &scene, "--cameras", &cameras, "--arch", &machine]);
    let refused = optimize.args(["--out", &at("optimised")]).assert().code(2);
    let refused = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
    assert!(refused.contains("frames that were run elsewhere"), "{refused}");
    fs::write(home.path().join("demo.csv"), "frame,what,count\n").expect("a file");
    let empty = powergs(&["arch", "check", &machine]).assert().failure();
    let empty = String::from_utf8_lossy(&empty.get_output().stderr).into_owned();
    assert!(empty.contains("it has no frames"), "{empty}");
}
