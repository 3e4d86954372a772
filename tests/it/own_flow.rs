//! The example of a dataflow of one's own: every command knows it.

use std::path::Path;
use std::process::Command;

/// It is registered before anything else asks for dataflows, which is in a process of its own.
fn program(arguments: &[&str]) -> String {
    let test = std::env::current_exe().expect("a path");
    let folder = test.parent().and_then(Path::parent).expect("target/PROFILE").join("examples");
    let program = folder.join(format!("own_flow{}", std::env::consts::EXE_SUFFIX));
    let mut command = Command::new(program);
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    let run = command.output().expect("it runs");
    let said = String::from_utf8_lossy(&run.stdout).into_owned();
    assert!(run.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&run.stderr));
    said
}

const MACHINE: &str = "examples/own_flow/unsorted.toml";
const DEMO: &str = "traces/demo.bin";

#[test]
fn commands_know_a_dataflow_from_outside() {
    let home = tempfile::tempdir().expect("a folder");
    let out = |name: &str| home.path().join(name).display().to_string();
    let replay = program(&["replay", DEMO, "--arch", MACHINE, "--out", &out("replay")]);
    assert!(replay.contains("BLENDER-bound") && replay.contains("blender.lanes"), "{replay}");
    let csv = std::fs::read_to_string(home.path().join("replay/results.csv")).expect("a table");
    let header = csv.lines().next().expect("a header");
    for column in ["units.blender.busy_cycles", "actions.divide", "area_mm2.blender"] {
        assert!(header.split(',').any(|name| name == column), "{column}: {header}");
    }
    assert!(!header.contains("units.vru.") && !header.contains("units.raster."), "{header}");
    let words = program(&["explain", "BLENDER"]);
    assert!(words.contains("Adds up the Gaussians of a tile in any order"), "{words}");
    let key = program(&["explain", "blender.lanes"]);
    assert!(key.contains("Pixels that one evaluates in a cycle"), "{key}");
    let sweep = ["sweep", "examples/own_flow/sweep.toml", "--traces", DEMO, "--out", &out("sweep")];
    let sweep = program(&sweep);
    assert!(sweep.contains("lanes"), "{sweep}");
    let files = std::fs::read_dir(home.path().join("sweep/analysis")).expect("a folder");
    let names: Vec<String> = files
        .map(|file| file.expect("a file").file_name().to_string_lossy().into_owned())
        .collect();
    let has = |end: &str| names.iter().any(|name| name.ends_with(end));
    assert!(has(".png") && has(".csv"), "{names:?}");
    let both = ["compare", "gscore", MACHINE, DEMO, "--out", &out("compare")];
    let both = program(&both);
    assert!(both.contains("blender busy") && both.contains("vru busy"), "{both}");
    let refused = ["replay", DEMO, "--arch", MACHINE, "--set", "vru.cores=2"];
    let test = std::panic::catch_unwind(|| program(&refused));
    assert!(test.is_err(), "a key of another dataflow");
}
