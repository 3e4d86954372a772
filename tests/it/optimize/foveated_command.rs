//! `optimize --foveated`, end to end on a tiny scene.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use powergs_sim::cli::{self, Cli, Context, Exit};
use powergs_sim::scene::Foveated;

use super::command::{arguments, fails, kill_and_resume, run, stage, with};

/// A short run on a screen on which 48 pixels show all levels.
const FOVEATED: [&str; 10] = [
    "--foveated",
    "--quality-db",
    "20",
    "--rhos",
    "0,0.3",
    "--screen",
    "powergs",
    "--pooling-rate",
    "1.2",
    "--baselines",
];

fn other(words: &[&str]) -> Exit {
    let cli = Cli::try_parse_from(["powergs-sim", "--quiet"].iter().chain(words)).unwrap();
    let cancelled = Arc::new(AtomicBool::new(false));
    cli::run(&cli, &Context { global: cli.global.clone(), drawing: Default::default(), cancelled })
        .unwrap()
}

fn contents(run: &Path) -> Vec<(String, Vec<u8>)> {
    let names = ["model.fov", "fr.bin", "final.ply", "history.csv", "summary.md", "run.toml"];
    names.map(|n| (n.to_owned(), fs::read(run.join(n)).unwrap())).into()
}

#[test]
fn a_foveated_run_leaves_one_model_that_every_command_takes() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 300);
    let path = |name: &str| folder.path().join(name).display().to_string();
    assert_eq!(run(folder.path(), &with(&FOVEATED)).unwrap(), Exit::Done);
    let model = fs::read(path("run/model.fov")).unwrap();
    let model = Foveated::read(model.as_slice().into()).unwrap();
    let counts = model.counts();
    assert!(counts[3] > 0 && counts.windows(2).all(|w| w[1] <= w[0]), "{counts:?}");
    let history = fs::read_to_string(path("run/history.csv")).unwrap();
    for job in ["level2-sample-01", "level4-sample-02", "level3-render-only", "level4-display-only"]
    {
        let row = history.lines().find(|l| l.starts_with(&format!("{job},"))).unwrap();
        // No L1 or PSNR in the periphery, but HVSQ.
        let cells: Vec<&str> = row.split(',').collect();
        assert!(cells[5].is_empty() && cells[14].parse::<f64>().unwrap() > 0.0, "{row}");
    }
    assert!(!history.contains("NaN"));
    let (fov, cameras) = (path("run/model.fov"), path("cameras.json"));
    let picture = path("fr.png");
    let views = ["--cameras", &cameras, "--gaze", "0.3,0.6", "-o", &picture];
    assert_eq!(other(&[["render", &fov].as_slice(), &views].concat()), Exit::Done);
    assert!(fs::metadata(&picture).unwrap().len() > 100);
    // One file has the first view, and a filtered picture lies beside the picture.
    assert_eq!(other(&["filter", &picture, "--gaze", "0.5,0.5", "--fov", "90"]), Exit::Done);
    let hvsq = ["--hvsq", "1,3,7,12", "--json"];
    let pair = ["quality", &picture, &path("fr-d22.png")];
    assert_eq!(other(&[pair.as_slice(), &hvsq].concat()), Exit::Done);
    let cycle = ["--cameras", &cameras, "--gaze-cycle", "9", "-o", &path("cycle.bin")];
    assert_eq!(other(&[["extract", &fov].as_slice(), &cycle].concat()), Exit::Done);
    let (trace, report) = (path("run/fr.bin"), path("report"));
    assert_eq!(other(&["replay", &trace, "--arch", "gscore", "--out", &report]), Exit::Done);
    crate::cli::explain::assert_explained(&folder.path().join("run"), &[]);
}

#[test]
fn a_foveated_run_that_is_killed_in_a_level_goes_on_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 200);
    let more = with(&[&FOVEATED[..9], &["--checkpoint-every", "1"]].concat());
    assert_eq!(run(folder.path(), &more).unwrap(), Exit::Done);
    let run_folder = folder.path().join("run");
    let whole = contents(&run_folder);
    fs::remove_dir_all(&run_folder).unwrap();
    kill_and_resume(folder.path(), &more, |history| history.contains("level3-sample-01"));
    for (now, before) in contents(&run_folder).iter().zip(&whole) {
        assert!(now == before, "{} differs", now.0);
    }
}

#[test]
fn levels_that_small_images_do_not_show_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 100);
    let more = ["--foveated", "--quality-db", "20", "--rhos", "0"];
    assert_eq!(run(folder.path(), &with(&more)).unwrap(), Exit::Done);
    let history = fs::read_to_string(folder.path().join("run/history.csv")).unwrap();
    assert!(!history.contains("level3-"), "48 pixels have no third level");
    let run: toml::Table =
        fs::read_to_string(folder.path().join("run/run.toml")).unwrap().parse().unwrap();
    assert!(run["foveation"]["levels"].as_integer().unwrap() < 3);
    assert_eq!(run["foveation"]["screen-deg"].as_str(), Some("camera"));
    let model = fs::read(folder.path().join("run/model.fov")).unwrap();
    assert!(Foveated::read(model.as_slice().into()).is_ok());
}

#[test]
fn screens_and_machines_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 50);
    let base = ["--quality-db", "20", "--foveated"];
    let refused = |more: &[&str], text: &str| {
        let all = with(&[base.as_slice(), more].concat());
        fails(folder.path(), &all, Exit::Usage, text);
        assert!(!folder.path().join("run").exists(), "{more:?} left a folder");
    };
    refused(&["--pooling-rate", "nan"], "pooling rate");
    refused(&["--pooling-rate", "-1"], "pooling rate");
    refused(&["--arch", "flicker"], "fovea.accumulators");
    refused(&["--arch", "vorion"], "another --arch (gscore)");
    refused(&["--set", "fovea.accumulators=0"], "fovea.accumulators");
    refused(&["--level-effort", "0"], "--level-effort");
    for screen in ["0", "180", "-90", "nan", "wide"] {
        let words = arguments(folder.path(), &with(&["--foveated", "--screen", screen]));
        assert!(Cli::try_parse_from(words).is_err(), "--screen {screen}");
    }
    let words = arguments(folder.path(), &with(&["--screen", "100"]));
    assert!(Cli::try_parse_from(words).is_err(), "a screen for nothing");
}
