//! `sweep` as a user runs it: the same results whatever the threads, parts and interruptions.

mod confirm;
mod examples;
mod folder;
mod parts;

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use tempfile::TempDir;

/// A sweep of 24 designs and two energy tables; four configurations are invalid.
pub const SWEEP: &str = r#"
question = "How many CCUs and cores?"
base = "gscore"
set = { dram.model = "calibrated" }
constraints = ["ccu.units * vru.cores <= 32"]

[[energy]]
label = "28nm"
table = "gscore-28nm"

[[energy]]
label = "cheap-dram"
table = "gscore-28nm-flat"
set = { dram.flat.read.energy = "5 pJ/B" }

[[axes]]
key = "ccu.units"
values = [1, 2, 4, 8]

[[axes]]
key = "vru.cores"
values = [2, 4, 8]

[[axes]]
key = "buffers.feature.capacity"
values = ["64 KiB", "128 KiB"]
"#;

/// A folder with the sweep above and the demo trace in it.
pub struct Bench {
    pub folder: TempDir,
}

impl Bench {
    pub fn new() -> Bench {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("cores.toml"), SWEEP).unwrap();
        let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
        fs::copy(demo, folder.path().join("demo.bin")).unwrap();
        Bench { folder }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The program with these arguments, in the folder.
    pub fn program(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        command.current_dir(self.folder.path()).args(arguments).env_remove("POWERGS_SHARD");
        command
    }

    /// `sweep cores.toml --traces demo.bin` with more arguments.
    pub fn sweep(&self, arguments: &[&str]) -> Command {
        let mut command = self.program(&["sweep", "cores.toml", "--traces", "demo.bin"]);
        command.args(arguments);
        command
    }
}

/// Every file of a finished sweep that must not depend on how it was run, with its content.
pub fn results(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    for place in [folder.to_owned(), folder.join("analysis")] {
        for entry in fs::read_dir(&place).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let typed = ["invocation.toml", "definition.json", "lock"];
            if path.is_file() && !typed.contains(&name.as_str()) {
                files.push((name, fs::read(path).unwrap()));
            }
        }
    }
    files.sort();
    files
}

#[track_caller]
pub fn assert_same(a: &Path, b: &Path) {
    let (a, b) = (results(a), results(b));
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&a), names(&b));
    for (a, b) in a.iter().zip(&b) {
        assert!(a.1 == b.1, "{} differs", a.0);
    }
    for wanted in ["results.csv", "results.parquet", "summary.txt", "pareto.csv", "report.html"] {
        assert!(a.iter().any(|(name, _)| name == wanted), "no {wanted}");
    }
}
