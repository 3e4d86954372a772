//! Files that commands write: not over others without `--force`, and with a line that names them.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use powergs_testkit::scene_files::{ply, sample};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::{contains, is_empty};

fn run(folder: &Path, words: &str) -> Assert {
    let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
    command.current_dir(folder).args(words.split_whitespace()).assert()
}

#[test]
fn nothing_is_replaced_without_force() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::write(path.join("a.ply"), ply(&sample(40, 1))).unwrap();
    run(path, "extract a.ply --orbit 2 --size 48x32 -o t.bin -q").success();
    let samples = "rho,display_w,render_w\n0,1,1\n0.2,0.9,0.9\n0.4,0.85,0.8\n0.6,0.84,0.7\n";
    fs::write(path.join("s.csv"), samples).unwrap();
    run(path, "render a.ply --orbit 1 --size 16x16 -o p.png -q").success();
    for (command, file) in [
        ("extract a.ply --orbit 1 --size 16x16 -o @", "x.bin"),
        ("render a.ply --orbit 1 --size 16x16 -o @", "x.png"),
        ("render a.ply --orbit 2 --size 16x16 -o views", "views/000.png"),
        ("scene convert a.ply @", "x.ply"),
        ("scene convert a.ply @", "x.sog"),
        ("camera convert --orbit 2 --size 16x16 -o @", "x.json"),
        ("trace dump t.bin --frame 0 -o @", "x.csv"),
        ("trace repair t.bin -o @", "y.bin"),
        ("filter p.png --gaze 0.5,0.5 -o @", "y.png"),
        ("fit s.csv -o @", "y.svg"),
        ("arch show gscore --figure -o @", "gscore.pdf"),
        ("replay t.bin --out r --force --dump-dram @", "dram.txt"),
    ] {
        let command = command.replace('@', file);
        let name = file.split('/').next().unwrap();
        let shown = command.contains("replay") || command.contains("fit");
        let first = run(path, &command).success();
        if !shown {
            first.stdout(contains(name));
        }
        fs::write(path.join(file), "mine").unwrap();
        if command.contains("--force") {
            run(path, &command).success();
            continue;
        }
        let refused = run(path, &command).code(2);
        refused.stderr(contains(file).and(contains("--force")));
        assert_eq!(fs::read_to_string(path.join(file)).unwrap(), "mine", "{command}");
        run(path, &format!("{command} --force -q")).success().stdout(is_empty());
        assert_ne!(fs::read(path.join(file)).unwrap(), b"mine", "{command}");
    }
}

#[test]
fn pictures_are_png_files() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.ply"), ply(&sample(40, 1))).unwrap();
    let jpeg = run(folder.path(), "render a.ply --orbit 1 --size 16x16 -o x.jpg").code(2);
    jpeg.stderr(contains("written as .png, not as .jpg"));
    run(folder.path(), "render a.ply --orbit 1 --size 16x16 -o v.2/ -q").success();
    assert!(folder.path().join("v.2/000.png").is_file());
}

#[test]
fn a_report_that_cannot_be_written_is_said_before_anything_is_simulated() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("out"), "a file").unwrap();
    // The trace is not even there.
    let refused = run(folder.path(), "compare gscore edge no.bin --out out").code(2);
    refused.stderr(contains("is a file; give --out a folder"));
}
