//! Prices for another clock than that of the machine.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use predicates::str::contains;
use serde_json::Value;
use tempfile::TempDir;

/// A folder with a slow GPU.
struct SlowGpu {
    home: TempDir,
}

const SWEEP: &str = r#"
question = "Which clock?"
base = "orin-nx"

[[traces]]
path = "demo.bin"

[[axes]]
key = "clock"
values = ["459 MHz", "918 MHz"]
"#;

impl SlowGpu {
    fn new() -> SlowGpu {
        let gpu = SlowGpu { home: tempfile::tempdir().expect("a folder") };
        let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/demo.bin");
        fs::copy(demo, gpu.path("demo.bin")).expect("a trace");
        let slow = "base = \"orin-nx\"\nname = \"slow\"\nclock = \"459 MHz\"\n";
        fs::write(gpu.path("slow.toml"), slow).expect("a file");
        fs::write(gpu.path("clocks.toml"), SWEEP).expect("a file");
        gpu
    }

    fn path(&self, name: &str) -> PathBuf {
        self.home.path().join(name)
    }

    /// The program on one frame, with the folder `out` for its report.
    fn program(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        command.current_dir(self.home.path()).env_remove("POWERGS_SHARD");
        command.args(arguments).args(["--frames", "0..1", "--out", "out"]);
        command
    }

    /// The page of the report.
    fn page(&self, path: &str) -> String {
        fs::read_to_string(self.path(path)).expect("a page")
    }
}

const SAID: &str = "its prices are for 918 MHz, and the machine has 459 MHz";

#[test]
fn a_replay_did_not_say_that_prices_are_for_another_clock() {
    let gpu = SlowGpu::new();
    let replay = ["replay", "demo.bin", "--arch", "slow.toml", "--what-if", "0", "--json"];
    let done = gpu.program(&replay).assert().success().stderr(contains(SAID));
    let json: Value = serde_json::from_slice(&done.get_output().stdout).expect("JSON");
    assert!(json["machine"]["doubts"][0].as_str().is_some_and(|d| d.contains(SAID)), "{json}");
    let page = gpu.page("out/summary.md");
    assert!(page.contains(SAID), "{page}");
}

#[test]
fn a_comparison_did_not_say_that_prices_are_for_another_clock() {
    let gpu = SlowGpu::new();
    gpu.program(&["compare", "orin-nx", "slow.toml", "demo.bin"]).assert().success();
    let said = "the prices of slow are for 918 MHz, and it has 459 MHz";
    let page = gpu.page("out/summary.md");
    assert!(page.contains(said), "{page}");
}

#[test]
fn a_sweep_over_the_clock_did_not_say_that_prices_stay() {
    let gpu = SlowGpu::new();
    let said = "prices are for 918 MHz and as given at any other clock";
    gpu.program(&["sweep", "clocks.toml"]).assert().success().stderr(contains(said));
    let page = gpu.page("out/analysis/summary.md");
    assert!(page.contains(said), "{page}");
}
