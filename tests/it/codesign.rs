//! `codesign` as the user sees it: a run on a tiny scene, resumed after a kill, and bad input.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use powergs_sim::cli::{self, Cli, Context, Exit, Failure};
use powergs_sim::scene::camera::inria;
use powergs_sim::scene::synth::{Preset, cameras, generate};
use powergs_sim::scene::{camera::edit::resized, write_ply};

/// A small space.
pub const SPACE: &str = "\
[model]
rho = [0.0, 0.4]

[[model.formats]]
name = \"short\"
scale = \"e5m8\"
rotation = \"e4m8\"
colour-dc = \"e4m7\"
colour-rest = \"e4m5\"

[machine.set]
\"display:scale\" = 0.3

[[machine.axes]]
key = \"vru.cores\"
values = [1, 2]

[[machine.axes]]
key = \"dram.channels\"
values = [4, 8]

[machine.derived]
\"buffers.sorting.capacity\" = \"16 KiB * vru.cores\"
";

/// A space of machines of another dataflow.
const RESIDENT: &str = "\
[model]
rho = [0.4]

[[model.formats]]
name = \"short\"
scale = \"e5m8\"
colour-rest = \"e4m5\"

[machine]
base = \"vorion\"

[machine.set]
\"display:scale\" = 0.3

[[machine.axes]]
key = \"order.units\"
values = [4, 8]
";

/// Writes a scene, its views and a space.
pub fn stage(folder: &Path, space: &str, views: usize) {
    let preset = Preset::named("demo").unwrap();
    let mut bytes = Vec::new();
    write_ply(&generate(preset, 300, 3), &mut bytes).unwrap();
    fs::write(folder.join("tiny.ply"), bytes).unwrap();
    let cameras: Vec<_> = cameras(preset).into_iter().step_by(6).take(views).collect();
    let cameras: Vec<_> = cameras.iter().map(|c| resized(c, 40, 30)).collect();
    fs::write(folder.join("cameras.json"), inria::write(&cameras)).unwrap();
    fs::write(folder.join("space.toml"), space).unwrap();
}

fn arguments(folder: &Path, more: &[&str]) -> Vec<String> {
    let path = |name: &str| folder.join(name).display().to_string();
    let mut words: Vec<String> = ["powergs-sim", "--quiet", "codesign"].map(String::from).into();
    words.extend([path("tiny.ply"), "--cameras".into(), path("cameras.json")]);
    words.extend(["--space".into(), path("space.toml"), "--out".into(), path("run")]);
    words.extend(
        ["--iterations", "20", "--interval", "4", "--checkpoint-every", "1"].map(String::from),
    );
    if !more.contains(&"--quality-db") {
        words.extend(["--quality-db", "22"].map(String::from));
    }
    words.extend(more.iter().map(|word| (*word).to_owned()));
    words
}

fn run(folder: &Path, more: &[&str]) -> Result<Exit, Failure> {
    let cli = Cli::try_parse_from(arguments(folder, more)).unwrap();
    let cancelled = Arc::new(AtomicBool::new(false));
    cli::run(&cli, &Context { global: cli.global.clone(), drawing: Default::default(), cancelled })
}

#[track_caller]
fn fails(folder: &Path, more: &[&str], exit: Exit, text: &str) {
    let failure = run(folder, more).unwrap_err();
    let message = failure.to_string();
    assert_eq!(failure.exit, exit, "{message}");
    assert!(message.contains(text), "{message}");
}

/// Everything that must not depend on how often a run was broken off.
pub fn contents(run: &Path) -> Vec<(&'static str, Vec<u8>)> {
    let names = [
        "run.toml",
        "space.toml",
        "pairs.csv",
        "models.csv",
        "summary.md",
        "report.html",
        "joint.ply",
        "joint.toml",
        "joint.bin",
        "front.png",
        "breakdown.svg",
        "strip.png",
    ];
    names.map(|name| (name, fs::read(run.join(name)).expect(name))).into()
}

#[test]
fn a_run_leaves_its_report_and_goes_on_to_the_same_bytes_whenever_it_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), SPACE, 12);
    let path = folder.path().join("run");
    assert_eq!(run(folder.path(), &[]).unwrap(), Exit::Done);
    let whole = contents(&path);
    crate::cli::explain::assert_explained(&path, &[]);
    let text = |name: &str| fs::read_to_string(path.join(name)).unwrap();
    // Two models and the dense one, four machines and the base machine.
    assert_eq!(text("pairs.csv").lines().count(), 1 + 3 * 5);
    assert_eq!(text("models.csv").lines().count(), 1 + 3);
    let summary = text("summary.md");
    assert!(summary.contains("(e)"));
    // Machines by their numbers, with the axes alone: the capacity follows from these.
    let head = "| machine | chosen by | vru.cores | dram.channels |\n|---|---|--:|--:|\n";
    let machines = summary.split(head).nth(1).expect("a table of machines");
    let ways = machines.lines().take_while(|line| line.starts_with('|')).collect::<String>();
    assert!(('a'..='e').all(|way| ways.contains(&format!("({way})"))), "{ways}");
    assert!(summary.lines().nth(2).is_some_and(|line| line.contains("cores=")), "{summary}");
    assert!(!text("run.toml").contains(&*folder.path().to_string_lossy()), "a place");
    fails(folder.path(), &[], Exit::Usage, "go on with --resume");
    // What is known is not made again, and models of another space do not stay in other formats.
    let exports = || {
        let files = ["joint.sog", "joint.compressed.ply", "joint.spz"].map(|name| path.join(name));
        files.map(|file| fs::read(file).ok())
    };
    let best = exports();
    assert!(best.iter().flatten().count() <= 1);
    for name in ["joint.sog", "joint.compressed.ply", "joint.spz"] {
        fs::write(path.join(name), b"of another space").unwrap();
    }
    assert_eq!(run(folder.path(), &["--resume"]).unwrap(), Exit::Done);
    assert_eq!(exports(), best);
    for (now, before) in contents(&path).iter().zip(&whole) {
        assert!(now.1 == before.1, "{} differs", now.0);
    }
    // Killed again and again, from its first moments on.
    fs::remove_dir_all(&path).unwrap();
    let mut kills = 0;
    for wait in [5, 20, 40, 60, 90, 120, 160, 220, 300, 400] {
        let resumed: &[&str] = if path.join("run.toml").is_file() { &["--resume"] } else { &[] };
        let arguments = arguments(folder.path(), resumed);
        let mut child = Command::new(env!("CARGO_BIN_EXE_powergs-sim"))
            .args(&arguments[1..])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(wait));
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            kills += 1;
        }
        child.wait().unwrap();
    }
    assert!(kills > 2, "{kills}");
    let resumed: &[&str] = if path.join("run.toml").is_file() { &["--resume"] } else { &[] };
    let threads = [resumed, ["--jobs", "1"].as_slice()].concat();
    assert_eq!(run(folder.path(), &threads).unwrap(), Exit::Done);
    for (now, before) in contents(&path).iter().zip(&whole) {
        assert!(now.1 == before.1, "{} differs after {kills} kills", now.0);
    }
}

#[test]
fn parts_of_a_run_end_in_the_bytes_of_one_process() {
    let (one, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for folder in [&one, &parts] {
        stage(folder.path(), SPACE, 12);
    }
    assert_eq!(run(one.path(), &[]).unwrap(), Exit::Done);
    // In any order, one of them twice, two at a time.
    assert_eq!(run(parts.path(), &["--shard", "3/3"]).unwrap(), Exit::Done);
    let both = ["1/3", "2/3"].map(|part| {
        let folder = parts.path().to_owned();
        std::thread::spawn(move || run(&folder, &["--shard", part]).unwrap())
    });
    both.into_iter().for_each(|part| assert_eq!(part.join().unwrap(), Exit::Done));
    assert_eq!(run(parts.path(), &["--shard", "3/3"]).unwrap(), Exit::Done);
    assert!(!parts.path().join("run/summary.md").exists(), "a part compares nothing");
    fails(parts.path(), &[], Exit::Usage, "go on with --resume");
    fails(parts.path(), &["--shard", "1/3", "--seed", "8"], Exit::Usage, "holds another run");
    assert_eq!(run(parts.path(), &["--resume"]).unwrap(), Exit::Done);
    let (one, parts) = (one.path().join("run"), parts.path().join("run"));
    for (now, before) in contents(&parts).iter().zip(&contents(&one)) {
        assert!(now.1 == before.1, "{} differs", now.0);
    }
}

#[test]
fn a_dry_run_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), SPACE, 12);
    assert_eq!(run(folder.path(), &["--dry-run"]).unwrap(), Exit::Done);
    assert!(!folder.path().join("run").exists());
    stage(folder.path(), &SPACE.replace("vru.cores\"\nvalues", "vru.coers\"\nvalues"), 12);
    fails(folder.path(), &["--dry-run"], Exit::Usage, "vru.cores");
}

/// `--force` throws away what runs put into a folder, and nothing else.
#[test]
fn force_stops_at_what_is_not_of_a_run_and_sweeps_what_kills_leave() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), SPACE, 12);
    let run_folder = folder.path().join("run");
    assert_eq!(run(folder.path(), &[]).unwrap(), Exit::Done);
    let model = fs::read_dir(run_folder.join("models")).unwrap().next().unwrap().unwrap().path();
    let left = model.join("checkpoints/.powergs-sim-Xx12Yz");
    fs::write(&left, b"half").unwrap();
    assert_eq!(run(folder.path(), &["--resume"]).unwrap(), Exit::Done);
    assert!(!left.exists());
    let mine = run_folder.join("models/mine");
    fs::create_dir(&mine).unwrap();
    fs::write(mine.join("notes.txt"), b"1").unwrap();
    fails(folder.path(), &["--force"], Exit::Usage, "`models/mine`, which is not of a run");
    assert!(model.exists() && mine.join("notes.txt").exists(), "nothing was removed");
    fs::remove_dir_all(&mine).unwrap();
    assert_eq!(run(folder.path(), &["--force"]).unwrap(), Exit::Done);
}

#[test]
fn bad_input_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    stage(at, SPACE, 1);
    fails(at, &[], Exit::Usage, "give at least 2");
    stage(at, &SPACE.replace("e4m5", "e8m7"), 12);
    fails(at, &[], Exit::Usage, "cannot hold every e8m7");
    stage(at, &SPACE.replace("vru.cores\"\nvalues", "vru.coers\"\nvalues"), 12);
    fails(at, &[], Exit::Usage, "vru.cores");
    stage(at, &SPACE.replace("rho = [0.0, 0.4]", "rho = [0.0, 1.4]"), 12);
    fails(at, &[], Exit::Usage, "line 2");
    stage(
        at,
        &format!("{SPACE}\n[[machine.axes]]\nkey = \"record.feature\"\nvalues = [\"18 B\"]\n"),
        12,
    );
    fails(at, &[], Exit::Usage, "change the picture");
    stage(at, &RESIDENT.replace("rho = [", "codebook = [0, 64]\nrho = ["), 12);
    fails(at, &[], Exit::Usage, "records name no colours by a number");
    assert!(!at.join("run").exists(), "nothing was written");
    stage(at, SPACE, 12);
    fails(at, &["--quality-db", "90"], Exit::GoalMissed, "reaches the quality");
    stage(at, &format!("{SPACE}\n[budget]\nframe-time = \"1 us\"\n"), 12);
    fails(at, &["--resume"], Exit::GoalMissed, "take more than 0.001 ms for a frame");
    stage(at, &format!("{SPACE}\n[budget]\narea = \"0.1 mm2\"\n"), 12);
    fails(at, &["--resume"], Exit::GoalMissed, "the nearest miss is");
    // Nothing is lost: with a budget that can be kept the same store goes on.
    stage(at, SPACE, 12);
    assert_eq!(run(at, &["--resume"]).unwrap(), Exit::Done);
    fs::remove_file(at.join("space.toml")).unwrap();
    fails(at, &["--resume"], Exit::Usage, "space.toml");
}

#[test]
fn machines_of_other_dataflows_are_designed_too() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), RESIDENT, 12);
    assert_eq!(run(folder.path(), &[]).unwrap(), Exit::Done);
    let machine = fs::read_to_string(folder.path().join("run/joint.toml")).unwrap();
    assert!(machine.contains("dataflow = \"resident\""), "{machine}");
}

#[test]
fn a_pair_of_eyes_takes_both_displays_and_one_deadline() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), SPACE, 12);
    let path = folder.path().join("run");
    let display_mw = |line: &str| -> f64 {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        cells[5].parse().unwrap_or_else(|_| panic!("{line}"))
    };
    let dense = |summary: &str| {
        let row = summary.lines().find(|line| line.contains("| (a) |"));
        display_mw(row.expect("the dense model"))
    };
    let summary = || fs::read_to_string(path.join("summary.md")).unwrap();
    let shown = ["--power-size", "80x60", "--rounds", "0"];
    assert_eq!(run(folder.path(), &shown).unwrap(), Exit::Done);
    let alone = summary();
    assert!(alone.contains("over 4 views of 80x60"), "{alone}");
    let pairs = [&shown[..], &["--power-stereo", "0.01", "--force"]].concat();
    assert_eq!(run(folder.path(), &pairs).unwrap(), Exit::Done);
    let both = summary();
    assert!(both.contains("over 4 pairs of 2 x 80x60"), "{both}");
    // Eyes so near to each other see the same.
    let ratio = dense(&both) / dense(&alone);
    assert!((ratio - 2.0).abs() < 0.02, "{ratio}");
}
