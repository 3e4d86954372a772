//! `replay` over an engine that hands out prepared frames.

use std::fs;
use std::path::Path;
use std::sync::atomic::Ordering;

use clap::Parser;
use powergs_sim::cli::machine_file::load_machine;
use powergs_sim::cli::replay::{Args, EachFrame, Engine, execute};
use powergs_sim::cli::run_folder::RunFolder;
use powergs_sim::cli::timeline::{Asked, asked};
use powergs_sim::cli::what_if::Experiment;
use powergs_sim::cli::{Context, Exit, Failure, Global, dram_dump};
use powergs_sim::report::{Extras, Facts};

use crate::report::builder;

/// Frames of these millions of cycles; presses Ctrl-C while it makes frame `stop_at`.
struct Prepared<'a> {
    millions: &'a [f64],
    stop_at: Option<usize>,
    context: &'a Context,
}

impl Engine for Prepared<'_> {
    fn facts(&self) -> Facts {
        builder::facts(self.millions.len())
    }

    fn frames(&mut self, each: &mut EachFrame<'_>) -> Result<(), Failure> {
        for (i, &m) in self.millions.iter().enumerate() {
            if self.stop_at == Some(i) {
                self.context.cancelled.store(true, Ordering::Relaxed);
            }
            let mut tiles = || {
                let mut tiles = builder::tiles(64, 32, 16);
                tiles.frame = i;
                tiles
            };
            if each(builder::frame(i, m), &mut tiles).is_break() {
                break;
            }
        }
        Ok(())
    }

    fn timeline(&mut self, _: &RunFolder, _: &Asked) -> Result<Option<String>, Failure> {
        Ok(None)
    }

    fn dram_requests(&mut self, sink: &mut dram_dump::Sink<'_>) -> Result<(), Failure> {
        sink(false, 0x1f40, 64);
        sink(true, 0, 19);
        match self.stop_at {
            None => Ok(()),
            Some(_) => Err(Failure::new(Exit::Usage, "no addresses")),
        }
    }

    fn extras(&mut self) -> Extras {
        Extras { what_if: Some(builder::what_if()), dram_models: None }
    }
}

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    args: Args,
}

fn replay(out: &Path, millions: &[f64], stop_at: Option<usize>) -> Result<Exit, Failure> {
    let out = out.to_string_lossy().into_owned();
    let line = Line::try_parse_from(["replay", "garden.bin", "--out", &out]).expect("arguments");
    let global = Global { json: false, quiet: true, jobs: None };
    let context = Context { global, cancelled: Default::default() };
    let mut engine = Prepared { millions, stop_at, context: &context };
    execute(&line.args, &context, &mut engine)
}

#[test]
fn writes_the_whole_folder_and_the_same_bytes_twice() {
    let root = tempfile::tempdir().expect("a folder");
    let (a, b) = (root.path().join("a"), root.path().join("b"));
    for out in [&a, &b] {
        assert_eq!(replay(out, &[4.0, 6.0, 5.0], None).ok(), Some(Exit::Done));
    }
    for name in powergs_sim::report::FILE_NAMES {
        if powergs_sim::report::ASKED_FOR.contains(&name) {
            assert!(!a.join(name).exists(), "{name} was not asked for");
            continue;
        }
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
    assert_eq!(replay(&out, &[4.0; 9], Some(2)).ok(), Some(Exit::Interrupted));
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
    let failure = replay(&out, &[f64::NAN], None).expect_err("refused");
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
fn dram_requests_are_lines_in_a_file_that_is_whole_or_absent() {
    let root = tempfile::tempdir().expect("a folder");
    let global = Global { json: false, quiet: true, jobs: None };
    let context = Context { global, cancelled: Default::default() };
    let mut engine = Prepared { millions: &[4.0], stop_at: None, context: &context };
    let path = root.path().join("requests.trace");
    let written = dram_dump::write(&path, &mut |sink| engine.dram_requests(sink));
    assert_eq!(written.ok(), Some(2));
    assert_eq!(fs::read_to_string(&path).expect("it"), "R 0x1f40 64\nW 0x0 19\n");
    fs::remove_file(&path).expect("removed");
    engine.stop_at = Some(0);
    let refused = dram_dump::write(&path, &mut |sink| engine.dram_requests(sink));
    assert_eq!(refused.expect_err("refused").to_string(), "no addresses");
    assert_eq!(fs::read_dir(root.path()).expect("it").count(), 0, "nothing is left behind");
}

#[test]
fn timelines_are_asked_for_by_frame_and_tiles() {
    assert_eq!(asked("3"), Ok(Asked { frame: 3, tiles: None }));
    assert_eq!(asked("3:100..140"), Ok(Asked { frame: 3, tiles: Some(100..140) }));
    for bad in ["", "x", "3:", "3:5", "3:9..9", "3:9..2", "-1", "3:1..99999999999"] {
        assert!(asked(bad).is_err(), "{bad}");
    }
}

#[test]
fn every_resource_of_every_machine_can_be_doubled_or_says_why_not() {
    for name in ["gscore", "gscore-16core", "edge"] {
        let loaded = load_machine(name, &[]).expect("a machine");
        let mut experiment = Experiment::new(&loaded, vec![0]);
        assert!(experiment.doubled.len() >= 7, "{name}: {}", experiment.doubled.len());
        for doubled in &experiment.doubled {
            assert_ne!(doubled.variant.machine, loaded.machine, "{name}");
        }
        let costs = vec![Default::default(); experiment.doubled.len()];
        experiment.add(&builder::frame(0, 3.0), &costs);
        let found = experiment.finish().expect("a frame was tried");
        for skipped in &found.skipped {
            assert!(skipped.reason.contains("sram.table"), "{name}: {skipped:?}");
        }
    }
}

#[test]
fn a_resource_that_cannot_be_doubled_names_the_reason() {
    let sets = ["gsu.bsu-per-core=65536".to_owned()];
    let loaded = load_machine("gscore", &sets).expect("a machine");
    let mut experiment = Experiment::new(&loaded, vec![0]);
    experiment.add(&builder::frame(0, 3.0), &[]);
    let found = experiment.finish().expect("a frame was tried");
    let skipped = found.skipped.iter().find(|s| s.resource == "gsu.bsu-per-core");
    assert!(skipped.is_some_and(|s| s.reason.contains("65536")), "{:?}", found.skipped);
    assert!(found.skipped.iter().all(|s| !s.reason.contains('\n')));
}
