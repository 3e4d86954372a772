//! `train` as the user sees it: photos become a model, interrupted or not, and steps become traces.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Parser;
use powergs_sim::cli::{self, Cli, Context, Exit, Failure};
use powergs_sim::scene::files::{open_cameras, open_model};

/// Runs a command; `@` is the folder.
fn run_until(folder: &Path, command: &str, cancelled: Arc<AtomicBool>) -> Result<Exit, Failure> {
    let command = format!("powergs-sim --quiet {command}");
    let here = folder.display().to_string();
    let words: Vec<String> = command.split(' ').map(|word| word.replace('@', &here)).collect();
    let cli = Cli::try_parse_from(words).unwrap();
    cli::run(&cli, &Context { global: cli.global.clone(), drawing: Default::default(), cancelled })
}

fn run(folder: &Path, command: &str) -> Result<Exit, Failure> {
    run_until(folder, command, Arc::default())
}

#[track_caller]
fn fails(folder: &Path, command: &str, exit: Exit, text: &str) {
    let failure = run(folder, command).unwrap_err();
    let message = failure.to_string();
    assert_eq!(failure.exit, exit, "{message}");
    assert!(message.contains(text), "{message}");
}

/// A folder with the pictures of a few views.
fn stage() -> tempfile::TempDir {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path();
    run(folder, "synth demo --points 600 -o @/demo.ply --cameras @/all.json").unwrap();
    run(folder, "camera convert --cameras @/all.json -o @/cameras.json --every 6 --size 48x36")
        .unwrap();
    run(folder, "render @/demo.ply --cameras @/cameras.json -o @/photos").unwrap();
    let cameras = open_cameras(&folder.join("cameras.json"), None, None).unwrap().cameras;
    for (i, camera) in cameras.iter().enumerate() {
        let at = |name: &str| folder.join(format!("photos/{name}.png"));
        fs::rename(at(&format!("{i:03}")), at(&camera.name)).unwrap();
    }
    home
}

const SHORT: &str = "train @/photos --cameras @/cameras.json --points 300 --cube 0.3 \
                     --iterations 120 --reset-every 100 --densify-from 30 --densify-every 20 \
                     --densify-until 100";

#[test]
fn photos_become_a_model_and_steps_become_traces() {
    let home = stage();
    let folder = home.path();
    let traces = "--trace-every 60 --traces @/steps --trace-views 2";
    run(folder, &format!("{SHORT} -o @/model.ply {traces}")).unwrap();
    let model = open_model(&folder.join("model.ply"), None).unwrap().gaussians;
    assert_eq!(model.sh_degree, 3);
    assert!(!model.is_empty());
    for step in ["step-000060", "step-000120"] {
        let replay = format!("replay @/steps/{step}.bin --arch gsarch --out @/{step}");
        run(folder, &replay).unwrap();
    }
    let names: Vec<_> = fs::read_dir(folder.join("steps")).unwrap().collect();
    assert_eq!(names.len(), 2);
    // What is there is replaced by nobody who was not asked to.
    let again = format!("{SHORT} -o @/other.ply {traces}");
    fails(folder, &again, Exit::Usage, "step-000060.bin: exists already");
    fails(folder, &format!("{SHORT} -o @/model.ply"), Exit::Usage, "exists already");
    run(folder, &format!("{SHORT} -o @/model.spz --jobs 1")).unwrap();
    let packed = open_model(&folder.join("model.spz"), None).unwrap().gaussians;
    assert_eq!(packed.len(), model.len());
}

#[test]
fn an_interrupted_training_ends_as_if_it_was_not() {
    let home = stage();
    let folder = home.path();
    run(folder, &format!("{SHORT} -o @/whole.ply")).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let begun = format!("{SHORT} -o @/parts.ply --checkpoint @/train.ckpt");
    let waits = Arc::clone(&stop);
    let waiting = std::thread::spawn(move || {
        std::thread::sleep(Duration::from_millis(100));
        waits.store(true, Ordering::Relaxed);
    });
    let exit = run_until(folder, &begun, stop).unwrap();
    waiting.join().unwrap();
    assert_eq!(exit == Exit::Interrupted, !folder.join("parts.ply").exists());
    fails(folder, &format!("{begun} --force --resume --seed 3"), Exit::BadInput, "other inputs");
    let resumed = run(folder, &format!("{begun} --force --resume"));
    assert_eq!(resumed.unwrap(), Exit::Done);
    let bytes = |name: &str| fs::read(folder.join(name)).unwrap();
    assert!(bytes("parts.ply") == bytes("whole.ply"));
    fails(folder, &format!("{SHORT} -o @/x.ply --checkpoint @/train.ckpt"), Exit::Usage, "exists");
    let nowhere = format!("{SHORT} -o @/x.ply --checkpoint @/none.ckpt --resume");
    fails(folder, &nowhere, Exit::Usage, "no checkpoint is there");
    fs::write(folder.join("train.ckpt"), b"PGSOPT and nothing").unwrap();
    let damaged = format!("{SHORT} -o @/x.ply --checkpoint @/train.ckpt --resume");
    fails(folder, &damaged, Exit::BadInput, "train.ckpt");
}

#[test]
fn what_cannot_be_trained_is_said_before_any_work() {
    let home = stage();
    let folder = home.path();
    let with = |more: &str| format!("train @/photos -o @/x.ply {more}");
    fails(folder, &format!("{SHORT} -o @/x.txt"), Exit::Usage, "says no format that is written");
    fails(folder, &with("--cameras @/all.json"), Exit::BadInput, "photos are missing");
    let own = "--cameras @/cameras.json";
    fails(folder, &with(&format!("{own} --hold-out 1")), Exit::Usage, "no view is left");
    fails(folder, &with(&format!("{own} --size 480x360")), Exit::Usage, "--size 480x360");
    fails(
        folder,
        &with(&format!("{own} --densify-slope 5000")),
        Exit::Usage,
        "--densify-slope 5000",
    );
    fails(folder, &with(&format!("{own} --cube 0")), Exit::Usage, "--cube 0");
    let many = format!("{own} --points 500 --max-points 400");
    fails(folder, &with(&many), Exit::Usage, "--points 500: --max-points allows 400");
    fails(folder, &with(&format!("{own} --init @/none.ply")), Exit::BadInput, "none.ply");
    fails(folder, &with(&format!("{own} --init @/cameras.json")), Exit::BadInput, "cameras.json");
    // A COLMAP model without points.
    let sparse = folder.join("sparse");
    fs::create_dir(&sparse).unwrap();
    fs::write(sparse.join("cameras.txt"), "1 PINHOLE 48 36 40 40 24 18\n").unwrap();
    fs::write(sparse.join("points3D.txt"), "# none\n").unwrap();
    let photo = fs::read_dir(folder.join("photos")).unwrap().next().unwrap().unwrap();
    let name = photo.file_name().into_string().unwrap();
    fs::write(sparse.join("images.txt"), format!("1 1 0 0 0 0 0 4 1 {name}\n\n")).unwrap();
    let empty = with("--cameras @/sparse --hold-out 0");
    fails(folder, &empty, Exit::BadInput, "points3D holds no points");
    // With some, they are what it starts from.
    let points = "1 0 0 1 9 9 9 0\n2 0 1 1 9 9 9 0\n3 1 0 1 9 9 9 0\n";
    fs::write(sparse.join("points3D.txt"), points).unwrap();
    run(folder, &format!("{empty} --iterations 2 --densify-until 0")).unwrap();
    assert_eq!(open_model(&folder.join("x.ply"), None).unwrap().gaussians.len(), 3);
}
