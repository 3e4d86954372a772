//! `--reprice` and `--dry-run`, as processes: the first reads what was typed.

use std::fs;
use std::path::Path;
use std::process::Command;

use powergs_sim::optimize::results::{ModelRecord, Results};
use serde_json::Value;

use super::command::{arguments, stage, with};

/// Runs the program; returns its exit code, standard output and standard error.
fn program(words: &[String]) -> (Option<i32>, String, String) {
    let out = Command::new(env!("CARGO_BIN_EXE_powergs-sim")).args(&words[1..]).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (out.status.code(), text(out.stdout), text(out.stderr))
}

/// Prices the run in `folder` anew, into `to`.
fn reprice(folder: &Path, to: &str, more: &[&str]) -> (Option<i32>, String) {
    let path = |name: &str| folder.join(name).display().to_string();
    let mut words = vec!["powergs-sim".to_owned(), "optimize".into()];
    words.extend(["--reprice".into(), path("run"), "--out".into(), path(to)]);
    words.extend(more.iter().map(|w| w.replace('@', &folder.display().to_string())));
    let (code, _, said) = program(&words);
    (code, said)
}

fn results(folder: &Path, run: &str) -> Results {
    let text = fs::read_to_string(folder.join(run).join("results.json")).unwrap();
    Results::parse(&text).unwrap()
}

/// The samples of a run, and the model that was made for its optimum.
fn curve(results: &Results) -> Vec<&ModelRecord> {
    results
        .models
        .iter()
        .filter(|m| m.name.contains("sample") || m.name.contains("optimum"))
        .collect()
}

#[test]
fn a_run_is_priced_anew_without_training() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stage(folder, 300);
    let term = ["--dimming", "damped"];
    let more = with(&["--quality-db", "20", "--rhos", "0,0.3,0.6", "--baselines"]);
    let words = arguments(folder, &[&more[..], &term].concat());
    let (code, _, said) = program(&words);
    assert_eq!(code, Some(0), "{said}");
    let first = results(folder, "run");

    // With the power of before, the numbers of before.
    let (code, said) = reprice(folder, "same", &[]);
    assert_eq!(code, Some(0), "{said}");
    assert!(!said.contains("left out: "), "{said}");
    assert!(said.contains("no model was trained"), "{said}");
    let same = results(folder, "same");
    assert_eq!(curve(&same).len(), curve(&first).len());
    assert_eq!(same.models.len(), first.models.len(), "comparisons among them");
    for (a, b) in curve(&same).into_iter().zip(curve(&first)) {
        assert_eq!(
            (a.display_w, a.render_w, a.rho),
            (b.display_w, b.render_w, b.rho),
            "{}",
            b.name
        );
        assert_eq!((a.gate, a.passed, a.lambda_per_w), (b.gate, b.passed, b.lambda_per_w));
    }
    assert!(same.model("former-optimum").is_some(), "the optimum of before keeps its name");

    // Four times the display power, half the frames.
    let (code, said) = reprice(folder, "other", &["--display-ratio", "4", "--fps", "30"]);
    assert_eq!(code, Some(0), "{said}");
    let other = results(folder, "other");
    assert_eq!(other.fps, 30.0);
    let ratio = other.display_to_render.unwrap();
    assert!((ratio - 4.0).abs() < 1e-9, "{ratio}");
    for (a, b) in curve(&other).into_iter().zip(curve(&first)) {
        assert!((a.render_w / b.render_w - 0.5).abs() < 1e-12, "{}", b.name);
        assert!((a.display_w / b.display_w - 4.0).abs() < 1e-9, "{}", b.name);
        let weighed = a.lambda_per_w.unwrap() * a.display_w;
        let before = b.lambda_per_w.unwrap() * b.display_w;
        let off = (weighed - before).abs();
        assert!(off <= 1e-9 * before, "{}: {weighed}, {before}", b.name);
    }
    assert!(other.model("optimum").is_none());
    let best = other.ours(&other.variants[0].name).unwrap().total_w();
    assert!(curve(&other).iter().filter(|m| m.passed).all(|m| m.total_w() >= best));
    for name in ["final.ply", "final.bin", "summary.md", "samples.csv", "run.toml"] {
        assert!(folder.join("other").join(name).is_file(), "{name}");
    }

    // At another size, by either name; quality is what it is there.
    for flag in ["--size", "--power-size"] {
        let to = flag.trim_start_matches('-');
        let (code, said) = reprice(folder, to, &[flag, "96x72", "--power-views", "2"]);
        let large = results(folder, to);
        // Models that were on the target may miss it there.
        let has_result = large.variants[0].result.is_some();
        assert_eq!(code, Some(if has_result { 0 } else { 1 }), "{said}");
        let summary = fs::read_to_string(folder.join(to).join("summary.md")).unwrap();
        assert!(summary.contains("FPS over 2 of 8 views of 96x72"), "{summary}");
        assert!(said.contains("quality was measured anew at 96x72"), "{said}");
        for (a, b) in curve(&large).into_iter().zip(curve(&first)) {
            assert_ne!(a.gate.psnr_db, b.gate.psnr_db, "{}", b.name);
        }
        assert!(large.dense().unwrap().render_w > first.dense().unwrap().render_w);
    }

    // A machine by its name counts.
    let (code, said) = reprice(folder, "edge", &["--arch", "edge"]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(results(folder, "edge").oracle, "edge");

    // The optimum on demand.
    let (code, said) = reprice(folder, "made", &["--display-ratio", "4", "--realise"]);
    assert_eq!(code, Some(0), "{said}");
    let made = results(folder, "made");
    assert_eq!(made.model("optimum").map(|m| m.iterations > 0), Some(true));
    let two_stage = |results: &Results| results.model("two-stage").map(|m| m.gate.psnr_db);
    assert!(two_stage(&made) == two_stage(&other), "nor is what was left");
}

#[test]
fn what_cannot_be_priced_anew_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stage(folder, 100);
    #[track_caller]
    fn refused(folder: &Path, more: &[&str], code: i32, says: &str) {
        let (got, said) = reprice(folder, "other", more);
        assert_eq!(got, Some(code), "{said}");
        assert!(said.contains(says), "{said}");
        assert!(!folder.join("other/results.json").exists());
    }
    refused(folder, &[], 2, "takes the folder of a finished run");
    let more = with(&["--quality-db", "20", "--rhos", "0.3", "--iterations", "2"]);
    let (code, _, said) = program(&arguments(folder, &more));
    assert_eq!(code, Some(0), "{said}");
    for flag in [["--quality", "M"], ["--iterations", "5"], ["--cameras", "x"], ["--rhos", "0.1"]] {
        refused(folder, &flag, 2, "cannot be used with");
    }
    refused(folder, &["--realise", "--dry-run"], 2, "cannot be used with");
    // Of another version.
    let mark = folder.join("run/checkpoints/run.json");
    let text = fs::read_to_string(&mark).unwrap();
    let mut other: Value = serde_json::from_str(&text).unwrap();
    other["model_version"] = 1.into();
    fs::write(&mark, other.to_string()).unwrap();
    refused(folder, &[], 3, "was made by version");
    fs::write(&mark, &text[..text.len() / 2]).unwrap();
    refused(folder, &[], 3, "no record of a run");
    fs::write(&mark, &text).unwrap();
    // Of a model that has changed since.
    let model = fs::read(folder.join("tiny.ply")).unwrap();
    stage(folder, 90);
    refused(folder, &[], 3, "other inputs");
    fs::write(folder.join("tiny.ply"), model).unwrap();
    // Into itself, by whatever name: nothing is thrown away.
    let mut names = vec!["run", "run/", "./run/../run"];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(folder.join("run"), folder.join("link")).unwrap();
        names.push("link");
    }
    let before = fs::read_dir(folder.join("run/checkpoints")).unwrap().count();
    for name in names {
        let (code, said) = reprice(folder, name, &["--force"]);
        assert_eq!(code, Some(2), "{name}: {said}");
        assert!(said.contains("give --out another"), "{said}");
        assert_eq!(fs::read_dir(folder.join("run/checkpoints")).unwrap().count(), before);
        assert!(folder.join("run/results.json").is_file());
    }
    // Damaged.
    let sample = folder.join("run/checkpoints/sample-01.ckpt");
    let bytes = fs::read(&sample).unwrap();
    fs::write(&sample, &bytes[..bytes.len() - 9]).unwrap();
    refused(folder, &["--force"], 3, "sample-01");
    fs::write(&sample, bytes).unwrap();
    let (code, said) = reprice(folder, "other", &["--force"]);
    assert_eq!(code, Some(0), "{said}");
    let (code, said) = reprice(folder, "other", &[]);
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("holds a run"), "{said}");
    // A damaged one does not replace a good one.
    fs::write(&sample, b"nothing").unwrap();
    let (code, said) = reprice(folder, "other", &["--force"]);
    assert_eq!(code, Some(3), "{said}");
    assert!(
        folder.join("other/results.json").is_file() && folder.join("other/final.ply").is_file()
    );
}

#[test]
fn a_dry_run_estimates_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    stage(folder, 300);
    let more = with(&["--quality-db", "20", "--rhos", "0,0.3", "--dry-run", "--json"]);
    let (code, said, _) = program(&arguments(folder, &more));
    assert_eq!(code, Some(0), "{said}");
    let seen: Value = serde_json::from_str(&said).unwrap();
    assert!(!folder.join("run").exists());
    let real = |key: &str| seen[key].as_f64().unwrap();
    assert!(real("iteration_s") > 0.0 && real("estimated_time_s") > real("iteration_s"));
    // What the run does, and what it leaves.
    let (code, _, said) = program(&arguments(folder, &more[..more.len() - 2]));
    assert_eq!(code, Some(0), "{said}");
    let done = results(folder, "run");
    let names: Vec<&str> = done.models.iter().map(|m| m.name.as_str()).collect();
    let planned: Vec<&str> =
        seen["jobs"].as_array().unwrap().iter().map(|job| job.as_str().unwrap()).collect();
    assert_eq!(planned, names);
    let most: u32 = done.models.iter().map(|m| m.iterations).sum();
    assert!(real("iterations") >= f64::from(most), "{} of {most}", real("iterations"));
    let files = fs::read_dir(folder.join("run/checkpoints")).unwrap();
    let disk: u64 = files.map(|file| file.unwrap().metadata().unwrap().len()).sum();
    assert!(real("estimated_disk_bytes") >= disk as f64, "{disk} bytes");
}
