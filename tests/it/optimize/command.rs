//! The command, end to end on a tiny scene: run folder, resume after a kill, bad input.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use powergs_pixels::RgbImage;
use powergs_sim::cli::{self, Cli, Context, Exit, Failure};
use powergs_sim::optimize::results::Results;
use powergs_sim::picture::Picture;
use powergs_sim::scene::camera::inria;
use powergs_sim::scene::{OneFile, Split, read, write_ply};
use powergs_testkit::lpips::{Kind, Made};

use super::scenes::{Tiny, tiny};

/// Writes a scene and its views; returns it.
pub fn stage(folder: &Path, points: usize) -> Tiny {
    let tiny = tiny(points, 3, (48, 36));
    let mut bytes = Vec::new();
    write_ply(&tiny.dense, &mut bytes).unwrap();
    fs::write(folder.join("tiny.ply"), bytes).unwrap();
    fs::write(folder.join("cameras.json"), inria::write(&tiny.cameras)).unwrap();
    tiny
}

/// The arguments of a short run in `folder`, more of them in `more`.
pub fn arguments(folder: &Path, more: &[&str]) -> Vec<String> {
    let path = |name: &str| folder.join(name).display().to_string();
    let mut words: Vec<String> = ["powergs-sim", "--quiet", "optimize"].map(String::from).into();
    words.extend([path("tiny.ply"), "--out".into(), path("run")]);
    for (flag, value) in [
        ("--iterations", "8"),
        ("--final-iterations", "12"),
        ("--held-out-iterations", "16"),
        ("--interval", "2"),
        ("--oracle", "paper"),
        ("--display-ratio", "0.5"),
    ] {
        if !more.contains(&flag) {
            words.extend([flag.into(), value.into()]);
        }
    }
    words.extend(more.iter().map(|w| w.replace("@", &folder.display().to_string())));
    words
}

pub fn run(folder: &Path, more: &[&str]) -> Result<Exit, Failure> {
    let cli = Cli::try_parse_from(arguments(folder, more)).unwrap();
    let cancelled = Arc::new(AtomicBool::new(false));
    cli::run(&cli, &Context { global: cli.global.clone(), drawing: Default::default(), cancelled })
}

const VIEWS: [&str; 2] = ["--cameras", "@/cameras.json"];

/// `VIEWS` and these.
pub fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    VIEWS.iter().copied().chain(more.iter().copied()).collect()
}

#[track_caller]
pub fn fails(folder: &Path, more: &[&str], exit: Exit, text: &str) {
    let failure = run(folder, more).unwrap_err();
    let message = failure.to_string();
    assert_eq!(failure.exit, exit, "{message}");
    assert!(message.contains(text), "{message}");
}

#[test]
fn a_run_leaves_a_model_tables_charts_and_a_summary() {
    let folder = tempfile::tempdir().unwrap();
    let tiny = stage(folder.path(), 400);
    let more = with(&["--quality-db", "20", "--baselines", "--study", "ratio"]);
    assert_eq!(run(folder.path(), &more).unwrap(), Exit::Done);
    let path = folder.path().join("run");
    let text = |name: &str| fs::read_to_string(path.join(name)).unwrap();
    let bytes = fs::read(path.join("final.ply")).unwrap();
    let model = read(&OneFile(&bytes), "final.ply", None).unwrap();
    assert!(model.warnings.is_empty() && model.gaussians.len() <= tiny.dense.len());
    for name in ["curves", "plane", "quality", "breakdown", "course", "strip", "ratio"] {
        assert!(path.join(format!("{name}.png")).is_file(), "{name}.png");
        assert!(path.join(format!("{name}.svg")).is_file(), "{name}.svg");
    }
    assert_eq!(text("samples.csv").lines().count(), 6, "five samples");
    let models = text("models.csv");
    for name in ["dense", "optimum", "render-only", "display-only", "two-stage", "lightgs-86"] {
        assert!(models.lines().any(|l| l.starts_with(&format!("{name},"))), "{name}: {models}");
    }
    let history = text("history.csv");
    // First sample twice as long; 4 more; final; two baselines of as many and four of the final's.
    let search = 16 + 4 * 8 + 12;
    let most = 1 + search + 2 * search + 4 * 12;
    assert!((most - 30..=most).contains(&history.lines().count()), "{}", history.lines().count());
    assert!(!history.contains("NaN"));
    let summary = text("summary.md");
    for word in ["saved", "by the fit, ", "| render-only |", "(plane.png)"] {
        assert!(summary.contains(word), "{word}: {summary}");
    }
    let results = Results::parse(&text("results.json")).unwrap();
    assert_eq!(results.models.len(), models.lines().count() - 1);
    assert_eq!(results.ours(&results.variants[0].name).unwrap().level, 1);
    assert!(results.foveated.is_empty() && results.screen.is_none());
    assert!(fs::metadata(path.join("final.bin")).unwrap().len() > 1000);
    let run: toml::Table = text("run.toml").parse().unwrap();
    assert_eq!(run["search"]["iterations"].as_integer(), Some(8));
    assert!(!text("run.toml").contains(&*folder.path().to_string_lossy()), "a place in run.toml");
    crate::cli::explain::assert_explained(&path, &[]);
}

/// What a run says whose test views are so many times as far away as they were, and the others so
/// many: from afar a Gaussian is hardly a pixel, and what was pruned shows.
fn seen_from(folder: &Path, test: f64, others: f64) -> String {
    let mut tiny = stage(folder, 300);
    for (i, camera) in tiny.cameras.iter_mut().enumerate() {
        let is_test = i % 4 == 0;
        camera.split = Some(if is_test { Split::Test } else { Split::Train });
        camera.centre *= if is_test { test } else { others };
    }
    fs::write(folder.join("cameras.json"), inria::write(&tiny.cameras)).unwrap();
    let more = with(&["--quality-db", "30", "--rhos", "0.3", "--iterations", "20"]);
    assert_eq!(run(folder, &more).unwrap(), Exit::Done);
    fs::read_to_string(folder.join("run/summary.md")).unwrap()
}

#[test]
fn quality_that_is_not_seen_in_views_that_did_not_choose_is_told_beside_the_watts() {
    let says = "test views, which did not choose it: ";
    let folder = tempfile::tempdir().unwrap();
    let summary = seen_from(folder.path(), 2.5, 1.0);
    let beside = summary.lines().skip_while(|line| !line.contains(" saved over ")).nth(1);
    assert!(beside.is_some_and(|line| line.starts_with(says)), "{summary}");
    assert!(summary.contains("less than asked for"), "{summary}");
    // Where they see more than was promised, there is nothing to tell.
    let folder = tempfile::tempdir().unwrap();
    let summary = seen_from(folder.path(), 1.0, 2.5);
    assert!(summary.contains(" saved over ") && !summary.contains(says), "{summary}");
    // Which views lost most, with the worst first.
    let lost = summary.split("Views that lost most").nth(1).unwrap();
    assert!(lost.contains("| gate |") && !lost.contains("between_"), "{lost}");
}

/// The facts of a run that is priced as `more` says.
fn priced(folder: &Path, more: &[&str]) -> (String, Results) {
    let more: Vec<&str> = with(&["--quality-db", "20", "--rhos", "0.3", "--force"])
        .into_iter()
        .chain(more.iter().copied())
        .collect();
    assert_eq!(run(folder, &more).unwrap(), Exit::Done);
    let text = |name: &str| fs::read_to_string(folder.join("run").join(name)).unwrap();
    (text("summary.md"), Results::parse(&text("results.json")).unwrap())
}

#[test]
fn power_is_that_of_the_size_of_the_cameras_unless_another_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let tiny = stage(folder, 300);
    let (summary, small) = priced(folder, &["--size", "24x18"]);
    assert!(summary.contains("saved over 8 views of 48x36"), "{summary}");
    assert!(summary.contains("FPS over 8 views of 48x36"), "{summary}");
    assert!(!summary.contains("power was counted at"), "{summary}");
    assert_eq!((small.width_px, small.height_px), (24, 18), "it trains at that of --size");
    // At the size of the training it takes less, and that is told.
    let (summary, low) = priced(folder, &["--size", "24x18", "--power-size", "24x18"]);
    assert!(summary.contains("saved over 8 views of 24x18"), "{summary}");
    assert!(summary.contains("at 24x18, below the 48x36 of the cameras"), "{summary}");
    let render = |results: &Results| results.dense().unwrap().render_w;
    assert!(render(&low) < render(&small));
    let (summary, _) = priced(folder, &["--power-size", "96x72", "--power-views", "3"]);
    assert!(summary.contains("saved over 3 of 8 views of 96x72"), "{summary}");
    // Other cameras.
    fs::write(folder.join("walk.json"), inria::write(&tiny.cameras[..2])).unwrap();
    let (summary, _) = priced(folder, &["--power-cameras", "@/walk.json"]);
    assert!(summary.contains("saved over 2 other views of 48x36"), "{summary}");
    // In charts, too.
    let plane = fs::read_to_string(folder.join("run/plane.svg")).unwrap();
    assert!(plane.contains("2 other views of 48x36"), "{plane}");
    // What was asked for has the name that it was given.
    assert!(summary.contains("| 20 dB |"), "{summary}");
    assert!(!summary.contains("Claims of the PowerGS paper"), "{summary}");
}

/// Everything in a run folder that must not depend on how often the run was broken off.
fn contents(run: &Path) -> Vec<(String, Vec<u8>)> {
    let names = ["final.ply", "final.bin", "history.csv", "samples.csv", "models.csv", "run.toml"];
    names.map(|n| (n.to_owned(), fs::read(run.join(n)).unwrap())).into()
}

/// Begins a run, kills it when its history `is_there`, and goes on with another number of threads:
/// results do not depend on it.
pub fn kill_and_resume(folder: &Path, more: &[&str], is_there: impl Fn(&str) -> bool) {
    let arguments = arguments(folder, more);
    let mut child = Command::new(env!("CARGO_BIN_EXE_powergs-sim"))
        .args(&arguments[1..])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let history = folder.join("run").join("history.csv");
    while !fs::read_to_string(&history).is_ok_and(|text| is_there(&text)) {
        assert!(child.try_wait().unwrap().is_none_or(|s| s.success()), "it failed by itself");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let resumed: Vec<&str> = more.iter().copied().chain(["--resume", "--jobs", "1"]).collect();
    assert_eq!(run(folder, &resumed).unwrap(), Exit::Done);
}

#[test]
fn a_killed_run_goes_on_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 300);
    let more = with(&["--quality-db", "20", "--checkpoint-every", "1"]);
    assert_eq!(run(folder.path(), &more).unwrap(), Exit::Done);
    let run_folder = folder.path().join("run");
    let whole = contents(&run_folder);
    fs::remove_dir_all(&run_folder).unwrap();
    // As soon as some iterations are on record, wherever that is.
    kill_and_resume(folder.path(), &more, |history| history.len() >= 2_000);
    for (now, before) in contents(&run_folder).iter().zip(&whole) {
        assert_eq!(now.0, before.0);
        assert!(now.1 == before.1, "{} differs", now.0);
    }
}

#[test]
fn a_run_is_replaced_by_force_only_and_foreign_files_stay() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 200);
    let more = with(&["--quality-db", "20", "--rhos", "0.3", "--iterations", "2"]);
    let run_folder = folder.path().join("run");
    // What a run leaves that is killed before its first checkpoint is no obstacle.
    fs::create_dir_all(run_folder.join("checkpoints")).unwrap();
    fs::write(run_folder.join("lock"), "").unwrap();
    fs::write(run_folder.join("checkpoints/.powergs-sim-Abc123"), "half").unwrap();
    run(folder.path(), &more).unwrap();
    assert!(!run_folder.join("checkpoints/.powergs-sim-Abc123").exists());
    fails(folder.path(), &more, Exit::Usage, "replace it with --force");
    fs::write(run_folder.join("thesis.tex"), "precious").unwrap();
    fs::write(run_folder.join("ratio.png"), "of an older run").unwrap();
    let forced: Vec<&str> = more.iter().copied().chain(["--force"]).collect();
    run(folder.path(), &forced).unwrap();
    assert!(run_folder.join("thesis.tex").exists() && !run_folder.join("ratio.png").exists());
}

#[test]
fn a_target_that_cannot_be_reached_exits_1_and_keeps_the_run() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 300);
    let more = with(&["--quality-db", "75", "--rhos", "0.5,0.6"]);
    assert_eq!(run(folder.path(), &more).unwrap(), Exit::GoalMissed);
    let path = folder.path().join("run");
    let summary = fs::read_to_string(path.join("summary.md")).unwrap();
    assert!(summary.contains("no model reached the target"), "{summary}");
    assert!(summary.contains("sample-01") && summary.contains("missed the target by"), "{summary}");
    assert!(!path.join("final.ply").exists());
    assert!(path.join("samples.csv").is_file() && path.join("history.csv").is_file());
    // Beyond what 16-bit references can say: the dense model itself is below.
    fs::remove_dir_all(&path).unwrap();
    assert_eq!(run(folder.path(), &with(&["--quality-db", "119"])).unwrap(), Exit::GoalMissed);
    assert_eq!(fs::read_to_string(path.join("samples.csv")).unwrap().lines().count(), 1);
}

#[test]
fn flags_that_make_no_sense_are_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 100);
    let usage = |more: &[&str], text| fails(folder.path(), &with(more), Exit::Usage, text);
    usage(&["--reference", "self", "--quality", "0.99"], "the dense model is perfect");
    usage(&["--quality", "0.99"], "the dense model is perfect");
    usage(&["--quality-db", "500"], "1 to 120");
    usage(&["--rhos", "0.5,0.2"], "ascending");
    usage(&["--rhos", "0,1"], "ascending");
    usage(&["--rhos", "NaN"], "ascending");
    usage(&["--iterations", "0"], "--iterations 0");
    usage(&["--rate-scale", "NaN"], "--rate-scale NaN");
    usage(&["--lambda=-1"], "--lambda -1");
    usage(&["--filter-flops=-1"], "--filter-flops -1: must be 0 to 1000000");
    usage(&["--display-ratio", "0"], "--display-ratio");
    usage(&["--baseline", "dense=@/tiny.ply"], "the name is taken");
    usage(&["--set", "vru.cores=2"], "no machine");
    usage(&["--resume"], "no run to go on with");
    usage(&["--path-frames", "0"], "--path-frames");
    usage(&["--train-on", "gscore"], "renders and does not train");
    usage(&["--train-on", "splatonic"], "updates no model");
    fails(folder.path(), &[], Exit::Usage, "no views");
    assert!(!folder.path().join("run").exists());
}

#[test]
fn folders_of_others_are_left_alone_and_other_runs_are_not_continued() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 100);
    let path = folder.path().join("run");
    fs::create_dir(&path).unwrap();
    fs::write(path.join("thesis.tex"), "mine").unwrap();
    let short = ["--quality-db", "20", "--rhos", "0.3", "--iterations", "2"];
    fails(folder.path(), &with(&short), Exit::Usage, "not empty");
    assert_eq!(fs::read_dir(&path).unwrap().count(), 1);
    fs::remove_dir_all(&path).unwrap();
    run(folder.path(), &with(&short)).unwrap();
    fails(folder.path(), &with(&short), Exit::Usage, "--resume");
    let other = ["--quality-db", "21", "--rhos", "0.3", "--iterations", "2", "--resume"];
    fails(folder.path(), &with(&other), Exit::BadInput, "other inputs or settings");
    let checkpoint = path.join("checkpoints/progress.ckpt");
    let bytes = fs::read(&checkpoint).unwrap();
    fs::write(&checkpoint, &bytes[..bytes.len() / 2]).unwrap();
    let again: Vec<&str> = short.iter().copied().chain(["--resume"]).collect();
    fails(folder.path(), &with(&again), Exit::BadInput, "damaged");
    // A finished run that is continued says the same again.
    fs::write(&checkpoint, &bytes).unwrap();
    let before = contents(&path);
    run(folder.path(), &with(&again)).unwrap();
    assert!(contents(&path) == before);
}

#[test]
fn photos_are_checked_and_used() {
    let folder = tempfile::tempdir().unwrap();
    let tiny = stage(folder.path(), 300);
    let photos = folder.path().join("photos");
    fs::create_dir(&photos).unwrap();
    let images = ["--images", "@/photos", "--cameras", "@/cameras.json"];
    fails(folder.path(), &images, Exit::BadInput, "8 of 8 photos are missing");
    for (camera, reference) in tiny.cameras.iter().zip(&tiny.references) {
        let mut picture = Picture::default();
        reference.write_to(&mut picture);
        let image = RgbImage::from_bytes(picture.width, picture.height, picture.to_rgb8()).unwrap();
        fs::write(photos.join(format!("{}.png", camera.name)), image.png().unwrap()).unwrap();
    }
    fs::copy(folder.path().join("cameras.json"), photos.join("cameras.json")).unwrap();
    let first = photos.join(format!("{}.png", tiny.cameras[0].name));
    let whole = fs::read(&first).unwrap();
    for (bytes, says) in [(&b"no image"[..], "not a PNG"), (&[0xff, 0xd8, 0xff, 0xe0], "too early")]
    {
        fs::write(&first, bytes).unwrap();
        fails(folder.path(), &images, Exit::BadInput, says);
    }
    fs::write(&first, whole).unwrap();
    let short = ["--images", "@/photos", "--quality", "0.4", "--rhos", "0,0.2,0.4"];
    assert_eq!(run(folder.path(), &short).unwrap(), Exit::Done);
    let path = folder.path().join("run");
    let record: toml::Table = fs::read_to_string(path.join("run.toml")).unwrap().parse().unwrap();
    assert_eq!(record["views"]["reference"].as_str(), Some("images"));
    assert_eq!(record["target"]["share-of-dense"].as_float(), Some(0.4));
    fs::remove_dir_all(&path).unwrap();
    // Photos of something else are found before anything is trained.
    let noise = |x: u32, y: u32| [(x * 97 + y * 31) as u8, (x * 53 + y * 201) as u8, (x * y) as u8];
    let others: Vec<(PathBuf, Vec<u8>)> = tiny
        .cameras
        .iter()
        .map(|camera| photos.join(format!("{}.png", camera.name)))
        .map(|photo| (photo.clone(), fs::read(photo).unwrap()))
        .collect();
    for (photo, _) in &others {
        fs::write(photo, RgbImage::from_fn(48, 36, noise).png().unwrap()).unwrap();
    }
    fails(folder.path(), &short, Exit::BadInput, "over a black background; give the photos");
    assert!(!path.join("models.csv").exists());
    for (photo, bytes) in &others {
        fs::write(photo, bytes).unwrap();
    }
    fs::remove_dir_all(&path).unwrap();
    let sized = |size| [short[0], short[1], "--size", size];
    fails(folder.path(), &sized("24x30"), Exit::Usage, "aspect");
    fails(folder.path(), &sized("96x72"), Exit::Usage, "smaller size");
    let first = photos.join(format!("{}.png", tiny.cameras[0].name));
    fs::write(&first, RgbImage::from_fn(20, 20, |_, _| [0; 3]).png().unwrap()).unwrap();
    fails(folder.path(), &short, Exit::BadInput, "is 20x20, its camera is 48x36: another aspect");
    fs::write(&first, b"\x89PNG\r\n\x1a\nbroken").unwrap();
    fails(folder.path(), &short, Exit::BadInput, &tiny.cameras[0].name);
    fs::remove_file(&first).unwrap();
    fails(folder.path(), &short, Exit::BadInput, "1 of 8 photos are missing");
}

#[test]
fn cameras_that_see_nothing_and_empty_models_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut tiny = stage(folder.path(), 100);
    for camera in &mut tiny.cameras {
        camera.centre += 1000.0 * camera.forward();
    }
    fs::write(folder.path().join("cameras.json"), inria::write(&tiny.cameras)).unwrap();
    fails(folder.path(), &with(&[]), Exit::BadInput, "no view sees anything");
    let mut bytes = Vec::new();
    let none = powergs_sim::scene::Gaussians::with_capacity(0, 3);
    write_ply(&none, &mut bytes).unwrap();
    fs::write(folder.path().join("tiny.ply"), bytes).unwrap();
    let failure = run(folder.path(), &with(&[])).unwrap_err();
    assert_eq!(failure.exit, Exit::BadInput, "{failure}");
}

#[test]
fn an_interrupted_run_says_so_and_can_be_continued() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 100);
    let more = with(&["--quality-db", "20", "--rhos", "0.3"]);
    let cli = Cli::try_parse_from(arguments(folder.path(), &more)).unwrap();
    let cancelled = Arc::new(AtomicBool::new(true));
    let context = Context { global: cli.global.clone(), drawing: Default::default(), cancelled };
    assert_eq!(cli::run(&cli, &context).unwrap(), Exit::Interrupted);
    let again: Vec<&str> = more.iter().copied().chain(["--resume"]).collect();
    assert_eq!(run(folder.path(), &again).unwrap(), Exit::Done);
}

#[test]
fn lpips_has_a_column_with_weights_only_and_belongs_to_the_run() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 100);
    for (name, seed) in [("one", 1), ("two", 2)] {
        fs::write(folder.path().join(name), Made::alex(seed).bytes(Kind::F16)).unwrap();
    }
    let path = folder.path().join("run");
    let text = |name: &str| fs::read_to_string(path.join(name)).unwrap();
    let short = with(&["--quality-db", "20", "--rhos", "0.3", "--iterations", "2"]);
    let and = |more: &[&'static str]| -> Vec<&str> {
        short.iter().copied().chain(more.iter().copied()).collect()
    };
    run(folder.path(), &short).unwrap();
    for name in ["models.csv", "summary.md", "run.toml"] {
        assert!(!text(name).to_lowercase().contains("lpips"), "{name}");
    }
    let weights = ["--lpips-weights", "@/one", "--resume"];
    fails(folder.path(), &and(&weights), Exit::BadInput, "other inputs or settings");
    fs::remove_dir_all(&path).unwrap();
    run(folder.path(), &and(&weights[..2])).unwrap();
    let models = text("models.csv");
    let mut lines = models.lines();
    assert!(lines.next().unwrap().ends_with(",flip_test,gain_red,gain_green,gain_blue,lpips_test"));
    for line in lines {
        let value: f64 = line.rsplit(',').next().unwrap().parse().unwrap();
        // The dense model is its own reference, but for 16 bits; the others have lost Gaussians.
        let expected = if line.starts_with("dense,") { 0.0..1e-4 } else { 1e-3..1.0 };
        assert!(expected.contains(&value), "{line}");
    }
    assert!(text("summary.md").contains("| test SSIM | test FLIP | test LPIPS | display,"));
    let record: toml::Table = text("run.toml").parse().unwrap();
    assert_eq!(record["lpips"]["network"].as_str(), Some("alex"));
    let other = ["--lpips-weights", "@/two", "--resume"];
    fails(folder.path(), &and(&other), Exit::BadInput, "other inputs or settings");
    let before = contents(&path);
    run(folder.path(), &and(&weights)).unwrap();
    assert!(contents(&path) == before);
    let missing = ["--lpips-weights", "@/none", "--resume"];
    fails(folder.path(), &and(&missing), Exit::BadInput, "none");
    // Too small for the pools: known before anything runs.
    fs::remove_dir_all(&path).unwrap();
    let small = ["--lpips-weights", "@/one", "--size", "40x30", "--power-size", "40x30"];
    fails(folder.path(), &and(&small), Exit::BadInput, "sides of 31");
    assert!(!path.exists());
}

#[test]
fn qualities_of_one_chain_have_a_table_and_a_file_each() {
    let folder = tempfile::tempdir().unwrap();
    stage(folder.path(), 300);
    let goals = ["--quality", "l,H", "--rhos", "0,0.1", "--iterations", "40"];
    let words = arguments(folder.path(), &with(&goals));
    let out = Command::new(env!("CARGO_BIN_EXE_powergs-sim"))
        .args(words.iter().skip(1).filter(|w| *w != "--quiet"))
        .output()
        .unwrap();
    let said = String::from_utf8(out.stdout).unwrap();
    assert_eq!(out.status.code(), Some(0), "{said}{}", String::from_utf8_lossy(&out.stderr));
    assert!(said.lines().all(|line| line.chars().count() <= 80), "{said}");
    let run = folder.path().join("run");
    let text = fs::read_to_string(run.join("results.json")).unwrap();
    let results = Results::parse(&text).unwrap();
    let names: Vec<&str> = results.variants.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(names, ["H", "L"], "the highest first, whatever was typed");
    let summary = fs::read_to_string(run.join("summary.md")).unwrap();
    for (name, file) in [("H", "final.ply"), ("L", "final-L.ply")] {
        let model = &results.result(name).unwrap().name;
        assert!(run.join(file).is_file(), "{file}");
        for text in [&said, &summary] {
            assert!(text.contains(model.as_str()) && text.contains(file), "{name}: {text}");
        }
    }
    assert!(summary.contains("Take the file of the lowest quality that looks right"), "{summary}");
    let failure = arguments(folder.path(), &with(&["--quality", "H,X"]));
    let Err(error) = Cli::try_parse_from(failure) else { panic!("accepted") };
    assert!(error.to_string().contains("H, M, L, several as H,M,L"), "{error}");
}
