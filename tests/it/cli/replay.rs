//! `replay`: its report folder, and what may be asked for.

use std::fs;
use std::path::Path;

use clap::Parser;
use powergs_sim::cli::invocation::Started;
use powergs_sim::cli::replay::{ReplayArgs, folder, publish};
use powergs_sim::cli::timeline::{TimelineRequest, asked};
use powergs_sim::cli::{Context, Exit, Failure, Global};
use powergs_sim::run_record::{Experiments, Run};

use crate::builder;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    args: ReplayArgs,
}

/// Publishes a run of `asked` frames, of which those of these millions of cycles were done.
fn replay(out: &Path, asked: usize, millions: &[f64]) -> Result<Exit, Failure> {
    let out = out.to_string_lossy().into_owned();
    let line = Line::try_parse_from(["replay", "garden.bin", "--out", &out]).expect("arguments");
    let memory = powergs_base::budget::Budget::DEFAULT;
    let global = Global { json: false, quiet: true, jobs: None, memory };
    let context = Context { global, drawing: Default::default(), cancelled: Default::default() };
    let started = Started::now();
    let facts = builder::facts(asked);
    let folder = folder(&line.args, &facts)?;
    let mut tiles = builder::tiles(64, 32, 16);
    let slowest = (0..millions.len()).max_by(|&a, &b| millions[a].total_cmp(&millions[b]));
    tiles.frame = slowest.unwrap_or(0);
    let frames = millions.iter().enumerate().map(|(i, &m)| builder::frame(i, m)).collect();
    let experiments = Experiments { what_if: Some(builder::what_if()), ..Experiments::default() };
    let run = Run { facts, frames, tiles: Some(tiles), experiments };
    publish(&line.args, &context, &started, folder, &run, &mut |_, _| Ok(None))
}

#[test]
fn writes_the_whole_folder_and_the_same_bytes_twice() {
    let root = tempfile::tempdir().expect("a folder");
    let (a, b) = (root.path().join("a"), root.path().join("b"));
    for out in [&a, &b] {
        assert_eq!(replay(out, 3, &[4.0, 6.0, 5.0]).ok(), Some(Exit::Done));
    }
    let mut names: Vec<String> = fs::read_dir(&a)
        .expect("a folder")
        .map(|entry| entry.expect("a file").file_name().into_string().expect("text"))
        .collect();
    names.sort();
    assert_eq!(names.len(), 5 + 2 * 7, "{names:?}");
    for name in names.iter().map(String::as_str) {
        let read = |folder: &Path| fs::read(folder.join(name)).expect(name);
        assert!(!read(&a).is_empty(), "{name}");
        if name == "invocation.toml" {
            let text = String::from_utf8(read(&a)).expect("text");
            let table: toml::Table = text.parse().expect("TOML");
            assert!(table["command"].is_array() && table["started"].is_str());
        } else {
            assert!(read(&a) == read(&b), "{name} differs");
        }
    }
    let svg = fs::read_to_string(a.join("tile_load.svg")).expect("a chart");
    assert!(svg.contains("frame 1 (the slowest frame)"));
}

#[test]
fn ctrl_c_keeps_what_is_finished_and_marks_it() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("stopped");
    assert_eq!(replay(&out, 9, &[4.0; 3]).ok(), Some(Exit::Interrupted));
    let read = |name: &str| fs::read_to_string(out.join(name)).expect(name);
    assert!(read("summary.md").contains("INCOMPLETE: 3 of 9 frames"));
    assert!(read("run.toml").contains("incomplete = true"));
    assert!(read("energy.svg").contains("INCOMPLETE"));
    assert_eq!(read("results.csv").lines().filter(|l| l.contains(",true,")).count(), 3 + 5);
}

#[test]
fn a_finished_report_is_refused_before_any_work() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("report");
    fs::create_dir(&out).expect("a folder");
    fs::write(out.join("run.toml"), "").expect("written");
    let failure = replay(&out, 1, &[f64::NAN]).expect_err("refused");
    assert_eq!(failure.exit, Exit::Usage);
    assert!(failure.to_string().contains("--force"), "{failure}");
}

#[test]
fn rates_are_checked() {
    for bad in ["0", "-60", "NaN", "inf", "sixty", "1e9"] {
        let line = Line::try_parse_from(["replay", "garden.bin", &format!("--fps={bad}")]);
        assert!(line.is_err(), "{bad}");
    }
}

#[test]
fn timelines_are_asked_for_by_frame_and_tiles() {
    assert_eq!(asked("3"), Ok(TimelineRequest { frame: 3, tiles: None }));
    assert_eq!(asked("3:100..140"), Ok(TimelineRequest { frame: 3, tiles: Some(100..140) }));
    for bad in ["", "x", "3:", "3:5", "3:9..9", "3:9..2", "-1", "3:1..99999999999"] {
        assert!(asked(bad).is_err(), "{bad}");
    }
}
