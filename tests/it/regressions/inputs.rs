//! Files that are named in files, and what is typed beside them.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use tempfile::TempDir;

/// A folder with a sweep in `study`, and with another table and another display of the same names
/// as those beside the sweep.
struct Study {
    home: TempDir,
}

const SWEEP: &str = r#"
question = "Which prices are these?"
base = "gscore"
display = "panel.toml"

[[traces]]
path = "v[1]/*.bin"

[[energy]]
label = "mine"
table = "mine.toml"

[[axes]]
key = "vru.cores"
values = [2, 4]
"#;

/// Prices with α at this many picojoules.
fn prices(alpha: u32) -> String {
    let alpha = format!("[actions]\nalpha = {{ energy = \"{alpha} pJ\", source = \"A10\" }}\n");
    format!("base = \"gscore-28nm\"\nname = \"mine\"\n{alpha}")
}

impl Study {
    fn new() -> Study {
        let study = Study { home: tempfile::tempdir().expect("a folder") };
        study.write("study/sweep.toml", SWEEP);
        study.write("study/mine.toml", &prices(5));
        study.write("mine.toml", &prices(500_000));
        study.write("study/panel.toml", "base = \"oled-powergs\"\nname = \"panel\"\n");
        study.write("panel.toml", "base = \"oled-d22\"\nname = \"panel\"\n");
        let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/demo.bin");
        for name in ["study/v[1]/demo.bin", "v[1]/demo.bin"] {
            fs::create_dir_all(study.path(name).parent().expect("a folder")).expect("a folder");
            fs::copy(&demo, study.path(name)).expect("a trace");
        }
        study
    }

    fn path(&self, name: &str) -> PathBuf {
        self.home.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        fs::write(path, text).expect("a file");
    }

    /// The program in a folder of it.
    fn program(&self, folder: &str, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        command.current_dir(self.path(folder)).args(arguments).env_remove("POWERGS_SHARD");
        command
    }

    /// The table of a sweep.
    fn table(&self, folder: &str, arguments: &[&str]) -> String {
        let common = ["sweep", "--frames", "0..1", "--force", "-q", "--out", "done"];
        self.program(folder, &[&common[..], arguments].concat()).assert().success();
        fs::read_to_string(self.path(folder).join("done/results.csv")).expect("a table")
    }
}

#[test]
fn a_sweep_depended_on_the_folder_that_it_was_started_in() {
    let study = Study::new();
    let inside = study.table("study", &["sweep.toml"]);
    assert_eq!(inside, study.table(".", &["study/sweep.toml"]));
    assert_eq!(inside, study.table("v[1]", &["../study/sweep.toml"]));
    // What is typed is of the working folder.
    let typed = study.table(".", &["study/sweep.toml", "--display", "panel.toml"]);
    assert_ne!(inside, typed);
    let same = ["../study/sweep.toml", "--display", "../study/panel.toml"];
    assert_eq!(inside, study.table("v[1]", &same));
    // Without the table there is none, whatever the working folder has.
    fs::remove_file(study.path("study/mine.toml")).expect("a file");
    let missing = ["sweep", "study/sweep.toml", "--dry-run"];
    let missing = study.program(".", &missing).assert().code(2);
    missing.stderr(contains("study/sweep.toml: line").and(contains("is not taken")));
}

#[test]
fn a_table_that_is_typed_is_that_of_the_working_folder_from_anywhere() {
    let study = Study::new();
    study.write("study/plain.toml", &SWEEP.replace("[[energy]]\nlabel = \"mine\"\ntable", "#"));
    let dear = ["study/plain.toml", "--set", "energy=mine.toml"];
    let dear = study.table(".", &dear);
    let cheap = study.table("study", &["plain.toml", "--set", "energy=mine.toml"]);
    assert_ne!(dear, cheap);
    // The sweep of a folder is opened again from another one.
    study.program("study", &["sweep", "status", "../done"]).assert().success();
}

#[test]
fn brackets_in_patterns_were_sets_of_characters() {
    let study = Study::new();
    let shown = study.table(".", &["study/sweep.toml", "--traces", "v[1]/*.bin"]);
    assert!(shown.contains("demo"), "{shown}");
    study.table(".", &["study/sweep.toml", "--traces", "v[1]/dem?.bin"]);
    let none = ["sweep", "study/sweep.toml", "--traces", "v[2]/*.bin"];
    study.program(".", &none).assert().code(3).stderr(contains("no such file"));
}

#[test]
fn parts_were_switched_off_in_replay_only() {
    let study = Study::new();
    let off = ["--set", "fovea=none", "--set", "pixels.impl=warped"];
    let typed = study.table("study", &[&["sweep.toml"][..], &off[..]].concat());
    let set = "[set]\nfovea = \"none\"\n\"pixels.impl\" = \"warped\"\n";
    study.write("study/off.toml", &format!("{SWEEP}{set}"));
    assert_eq!(typed, study.table("study", &["off.toml"]));
    let wrong = ["sweep", "study/sweep.toml", "--dry-run", "--set", "fovea=off"];
    let wrong = study.program(".", &wrong).assert().code(2);
    wrong.stderr(contains("in --set fovea=off: `fovea` is a table"));
}

#[test]
fn the_base_of_a_space_was_that_of_the_working_folder() {
    let study = Study::new();
    study.write("base.toml", "base = \"gscore\"\nname = \"other\"\n");
    let space = "[model]\nrho = [0.5]\n[machine]\nbase = \"base.toml\"\n";
    study.write("study/space.toml", space);
    let run = ["codesign", "model.ply", "--space", "study/space.toml", "--dry-run"];
    let missing = study.program(".", &run).assert().code(2);
    missing.stderr(contains("study/space.toml: study/base.toml: "));
    study.write("study/base.toml", "base = \"gscore\"\nname = \"mine\"\n");
    // Only the model is missing.
    study.program(".", &run).assert().failure().stderr(contains("model.ply"));
}

#[test]
fn a_second_word_behind_keys_was_a_missing_trace() {
    let study = Study::new();
    let run = ["sensitivity", "gscore", "v[1]/demo.bin", "--keys", "vru.*", "ccu.*"];
    let said = study.program(".", &run).assert().code(3);
    said.stderr(contains("give all of them in one list: --keys 'vru.*,ccu.*'"));
}
