//! `claims`: from run folders to an answer, and what is no run folder.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Parser;
use powergs_lab::Cli;
use powergs_sim::cli::{Context, Exit, Failure};

use crate::foveated_run;

fn claims(words: &[&Path], more: &[&str]) -> Result<Exit, Failure> {
    let mut all = vec!["powergs-sim".to_owned(), "--quiet".into(), "claims".into()];
    all.extend(words.iter().map(|p| p.display().to_string()));
    all.extend(more.iter().map(|w| (*w).to_owned()));
    let cli = Cli::try_parse_from(all).unwrap();
    let cancelled = Arc::new(AtomicBool::new(false));
    powergs_lab::run(
        &cli,
        &Context { global: cli.global.clone(), drawing: Default::default(), cancelled },
    )
}

#[track_caller]
fn fails(path: &Path, exit: Exit, says: &str) {
    let failure = claims(&[path], &[]).unwrap_err();
    assert_eq!(failure.exit, exit, "{failure}");
    let message = failure.to_string();
    assert!(message.contains(says), "{message}");
    assert!(message.contains(&*path.file_name().unwrap().to_string_lossy()), "{message}");
}

#[test]
fn a_page_of_two_runs_names_them_apart() {
    let folder = tempfile::tempdir().unwrap();
    let runs: Vec<_> = ["a/same", "b/same"].map(|n| folder.path().join(n)).into();
    for run in &runs {
        fs::create_dir_all(run).unwrap();
        fs::write(run.join("results.json"), foveated_run::run().to_json()).unwrap();
    }
    let page = folder.path().join("page.md");
    let words: Vec<&Path> = runs.iter().map(|r| r.as_path()).collect();
    let write = ["--write", page.to_str().unwrap()];
    assert_eq!(claims(&words, &write).unwrap(), Exit::Done);
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains("- **same**: bicycle") && text.contains("- **same-2**: bicycle"));
    assert!(text.contains("30 of 30 claims agree on most scenes"), "{text}");
    // The same again, byte for byte.
    assert_eq!(claims(&words, &write).unwrap_err().exit, Exit::Usage);
    claims(&words, &[&write[..], &["--force"]].concat()).unwrap();
    assert_eq!(fs::read_to_string(&page).unwrap(), text);
}

#[test]
fn what_is_no_run_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fails(&path("gone"), Exit::BadInput, "no such folder");
    fs::write(path("file"), "x").unwrap();
    fails(&path("file"), Exit::BadInput, "is a file");
    fs::create_dir(path("other")).unwrap();
    fails(&path("other"), Exit::BadInput, "no folder of a `powergs-sim optimize` run");
    fs::create_dir_all(path("half/checkpoints")).unwrap();
    fails(&path("half"), Exit::BadInput, "--resume");
    fs::create_dir(path("broken")).unwrap();
    let broken = |bytes: &[u8], says: &str| {
        fs::write(path("broken/results.json"), bytes).unwrap();
        fails(&path("broken"), Exit::BadInput, says);
    };
    let text = foveated_run::run().to_json();
    broken(&text.as_bytes()[..text.len() / 2], "truncated");
    broken(b"", "truncated");
    broken(b"\xff\xfe\0{", "UTF-8");
    broken(text.replace("\"version\": 1", "\"version\": 9").as_bytes(), "version 9");
    // One bad run of two: nothing is written.
    fs::create_dir(path("good")).unwrap();
    fs::write(path("good/results.json"), text).unwrap();
    let page = path("page.md");
    let write = ["--write", page.to_str().unwrap()];
    claims(&[&path("good"), &path("broken")], &write).unwrap_err();
    assert!(!page.exists());
}
