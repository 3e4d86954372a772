//! `optimize`: what it said, and what it was.

use std::fs;
use std::path::Path;
use std::time::Duration;

use powergs_sim::cli::Exit;
use powergs_sim::cli::progress::left;
use powergs_sim::optimize::counted::PowerCounts;
use powergs_sim::optimize::results::Results;

use crate::optimize::command::{run, stage, with};

/// Page and results of the run in a folder.
fn told(folder: &Path) -> (String, Results) {
    let text = |name: &str| fs::read_to_string(folder.join("run").join(name)).unwrap();
    (text("summary.md"), Results::parse(&text("results.json")).unwrap())
}

#[test]
fn watts_of_the_camera_file_stood_beside_decibels_of_a_smaller_size() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stage(folder, 300);
    let more = with(&["--size", "24x18", "--quality-db", "15", "--rhos", "0.3"]);
    assert_eq!(run(folder, &more).unwrap(), Exit::Done);
    let (page, results) = told(folder);
    let judged = results.judged.unwrap();
    assert_eq!((judged.trained, judged.judged, judged.is_priced), ([24, 18], [48, 36], true));
    assert_eq!(results.priced.as_ref().unwrap().size, judged.judged);
    assert!(page.contains("saved over 8 views of 48x36; trained at 24x18"), "{page}");
    let trained = [&more[..], &["--gate-size", "trained", "--force"]].concat();
    assert_eq!(run(folder, &trained).unwrap(), Exit::Done);
    let (page, results) = told(folder);
    assert_eq!(results.judged.unwrap().judged, [24, 18]);
    assert!(page.contains("saved over 8 views of 48x36; quality at 24x18"), "{page}");
}

#[test]
fn the_page_did_not_say_by_which_counts_its_watts_are() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stage(folder, 300);
    let more = with(&["--quality-db", "15", "--rhos", "0.3"]);
    assert_eq!(run(folder, &more).unwrap(), Exit::Done);
    let (page, results) = told(folder);
    let counted = results.counted.unwrap();
    assert_eq!((counted.counts, counted.has_standby), (PowerCounts::ClosedForm, false));
    let page: String = page.split_whitespace().collect::<Vec<_>>().join(" ");
    for says in ["the published closed form, without standby", "a display-to-render ratio of 0.5"] {
        assert!(page.contains(says), "{says}: {page}");
    }
}

#[test]
fn the_table_said_that_pruning_is_used_up_and_the_list_that_it_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stage(folder, 300);
    let more = with(&["--quality-db", "15", "--rhos", "0,0.3", "--baselines"]);
    assert_eq!(run(folder, &more).unwrap(), Exit::Done);
    let (page, results) = told(folder);
    for model in &results.models {
        // Its own renders are infinitely like the dense model.
        let db = model.gate.psnr_db.unwrap_or(f64::INFINITY);
        assert_eq!(model.passed, db >= 15.0, "{}: {db} dB", model.name);
    }
    // The table and the list below it say the same of what is used up.
    let list = page.lines().find(|line| line.contains("Pruning: ")).expect("a list");
    let row = page.lines().find(|line| line.contains("final.ply") && line.starts_with('|'));
    let row = row.expect("a row of the result");
    let in_table = ["both", "pruning"].iter().any(|word| row.contains(&format!("| {word} |")));
    assert_eq!(in_table, list.contains("passed, used up: "), "{row}\n{list}");
}

#[test]
fn a_run_of_minutes_said_that_days_were_left() {
    let minute = Duration::from_secs(60);
    assert_eq!(left(minute, 1000, 7000), Some(7 * minute));
    assert_eq!(left(minute, 0, 7000), None, "nothing was done yet");
    assert_eq!(left(minute, 10, 0), Some(Duration::ZERO));
}
