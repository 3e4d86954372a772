//! `validate`: traces of the user's own, pages that are compared, rows that do not exist.

use std::fs;
use std::path::Path;

use clap::Parser;
use powergs_sim::cli::{self, Cli, Context, Exit, Failure};
use powergs_sim::sim::MODEL_VERSION;

fn run(args: &[&str]) -> Result<Exit, Failure> {
    let args = ["powergs-sim", "--quiet", "validate"].iter().chain(args);
    let cli = Cli::try_parse_from(args).map_err(|e| Failure::new(Exit::Usage, e.to_string()))?;
    let (global, drawing) = (cli.global.clone(), Default::default());
    cli::run(&cli, &Context { global, drawing, cancelled: Default::default() })
}

#[track_caller]
fn fails(args: &[&str], exit: Exit, words: &str) {
    let failure = run(args).unwrap_err();
    assert_eq!(failure.exit, exit, "{failure}");
    assert!(failure.to_string().contains(words), "{failure}");
}

#[test]
fn rows_are_measured_on_traces_of_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().to_str().unwrap();
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/demo.bin");
    fails(&["--scenes", place], Exit::Usage, "no traces (*.bin) there");
    fs::copy(demo, folder.path().join("demo.bin")).unwrap();
    let only = ["--scenes", place, "--only", "vr-pipe-termination"];
    assert_eq!(run(&only).unwrap(), Exit::Done);
    fails(&["--scenes", place, "--only", "gscore-area"], Exit::Usage, "a share or a ratio");
    fails(&["--scenes", place, "--bless"], Exit::Usage, "cannot be used with");
    fails(&["--scenes", "/nowhere/at/all"], Exit::BadInput, "/nowhere/at/all");
    fs::write(folder.path().join("worse.bin"), "no trace").unwrap();
    fails(&only, Exit::BadInput, "worse.bin");
}

#[test]
fn a_page_is_compared_with_what_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    let check = ["--only", "gscore-area", "--check", page.to_str().unwrap()];
    fails(&check, Exit::Usage, "page.md");
    let write = ["--only", "gscore-area", "--write", page.to_str().unwrap()];
    assert_eq!(run(&write).unwrap(), Exit::Done);
    let text = fs::read_to_string(&page).unwrap();
    let row = text.lines().find(|line| line.starts_with("| `gscore-area` |")).unwrap();
    fs::write(&page, text.replace(row, "| `gscore-area` | another |")).unwrap();
    assert_eq!(run(&check).unwrap(), Exit::GoalMissed);
    fails(&["--quick", "--only", "neo-rank"], Exit::Usage, "no such row");
}

/// The page that is written with a new baseline is of that, not of the one before.
#[test]
fn a_page_goes_with_the_baseline_that_is_blessed() {
    let folder = tempfile::tempdir().unwrap();
    let tables = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/validation");
    for name in ["published.csv", "workloads.csv", "baseline.csv"] {
        let text = fs::read_to_string(format!("{tables}/{name}")).unwrap();
        let is_area = |line: &str| line.starts_with("id,") || line.starts_with("gscore-area,");
        let lines = text.lines().filter(|line| name != "published.csv" || is_area(line));
        let mut text = lines.map(|line| format!("{line}\n")).collect::<String>();
        if name == "baseline.csv" {
            text = "# model version 1\nid,workload,ours\ngscore-area,,3.96\n".to_owned();
        }
        fs::write(folder.path().join(name), text).unwrap();
    }
    let page = folder.path().join("page.md");
    let [place, path] = [folder.path(), &page].map(|path| path.to_str().unwrap());
    assert_eq!(run(&["--rows", place, "--bless", "--write", path]).unwrap(), Exit::Done);
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains(&format!("Model version {MODEL_VERSION}.")), "{text}");
    assert!(!text.contains("worsened"), "{text}");
    assert_eq!(run(&["--rows", place, "--check", path]).unwrap(), Exit::Done);
}
