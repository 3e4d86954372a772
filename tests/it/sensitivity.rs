//! Sensitivity: the assumptions, elasticities against differences on a machine, dead keys against
//! `arch-configs/inert.toml`, and the command.

mod assumptions;
mod charts;
mod interactions;
mod keys;

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

fn program() -> Command {
    let mut command = Command::cargo_bin("powergs-sim").expect("the program");
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

/// `sensitivity MACHINE` on one frame of the demo trace, into this folder.
fn sensitivity(machine: &str, args: &[&str], out: &Path) -> Command {
    let mut command = program();
    command.args(["sensitivity", machine, "traces/demo.bin", "--frames", "..1"]);
    command.args(args).args(["--out".as_ref(), out.as_os_str()]);
    command
}

fn json(machine: &str, args: &[&str]) -> Value {
    let root = tempfile::tempdir().expect("a folder");
    let run = sensitivity(machine, args, &root.path().join("s")).arg("--json").assert().success();
    serde_json::from_slice(&run.get_output().stdout).expect("JSON")
}

fn rows<'a>(found: &'a Value, name: &str) -> &'a Vec<Value> {
    found[name].as_array().unwrap_or_else(|| panic!("no {name}: {found}"))
}

fn text<'a>(value: &'a Value, name: &str) -> &'a str {
    value[name].as_str().unwrap_or_else(|| panic!("no {name}: {value}"))
}
