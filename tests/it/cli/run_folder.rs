//! Report folders: complete or absent, never over something else.

use std::fs;
use std::path::Path;

use powergs_sim::cli::Exit;
use powergs_sim::cli::run_folder::RunFolder;

fn write(out: &Path, text: &str, force: bool) -> Result<(), Exit> {
    let folder = RunFolder::create(Some(out), "unused", force).map_err(|f| f.exit)?;
    folder.write("run.toml", text.as_bytes()).map_err(|f| f.exit)?;
    folder.finish().map(|_| ()).map_err(|f| f.exit)
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let name = |e: fs::DirEntry| e.file_name().to_string_lossy().into_owned();
    let mut names: Vec<String> = entries.map(|e| name(e.expect("an entry"))).collect();
    names.sort();
    names
}

#[test]
fn a_finished_report_is_replaced_only_by_force() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("deep/report");
    assert_eq!(write(&out, "one", false), Ok(()));
    assert_eq!(write(&out, "two", false), Err(Exit::Usage));
    assert_eq!(fs::read_to_string(out.join("run.toml")).expect("a file"), "one");
    assert_eq!(write(&out, "three", true), Ok(()));
    assert_eq!(fs::read_to_string(out.join("run.toml")).expect("a file"), "three");
    assert_eq!(names(&root.path().join("deep")), ["report"], "nothing is left beside it");
}

#[test]
fn an_empty_folder_is_taken_and_a_foreign_one_never() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("mine");
    fs::create_dir(&out).expect("a folder");
    assert_eq!(write(&out, "one", false), Ok(()));
    fs::write(out.join("thesis.tex"), "ten years").expect("written");
    for force in [false, true] {
        assert_eq!(write(&out, "two", force), Err(Exit::Usage));
    }
    assert_eq!(names(&out), ["run.toml", "thesis.tex"]);
    let file = root.path().join("file");
    fs::write(&file, "x").expect("written");
    assert_eq!(write(&file, "two", true), Err(Exit::Usage));
}

#[test]
fn a_dropped_folder_leaves_nothing() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("report");
    let folder = RunFolder::create(Some(&out), "unused", false).expect("a folder");
    folder.write("run.toml", b"half").expect("written");
    drop(folder);
    assert!(names(root.path()).is_empty());
}

#[cfg(unix)]
#[test]
fn others_may_read_it_as_the_umask_says() {
    use std::os::unix::fs::PermissionsExt;
    let root = tempfile::tempdir().expect("a folder");
    let plain = root.path().join("plain");
    fs::create_dir(&plain).expect("a folder");
    let out = root.path().join("report");
    assert_eq!(write(&out, "one", false), Ok(()));
    let mode = |path: &Path| fs::metadata(path).expect("it").permissions().mode();
    assert_eq!(mode(&out), mode(&plain));
}

#[test]
fn an_analysis_takes_the_place_of_an_analysis_only() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("out");
    let analysis = || {
        let folder = RunFolder::analysis(&out).map_err(|f| f.exit)?;
        folder.write("pareto.csv", b"rows").map_err(|f| f.exit)?;
        folder.finish().map(|_| ()).map_err(|f| f.exit)
    };
    assert_eq!(analysis(), Ok(()));
    assert_eq!(analysis(), Ok(()));
    assert_eq!(write(&out, "a replay", true), Err(Exit::Usage));
    fs::remove_dir_all(&out).expect("removed");
    assert_eq!(write(&out, "a replay", false), Ok(()));
    assert_eq!(analysis(), Err(Exit::Usage));
    assert_eq!(fs::read_to_string(out.join("run.toml")).expect("a file"), "a replay");
}

#[test]
fn a_folder_with_the_name_of_a_file_of_ours_is_not_ours() {
    let root = tempfile::tempdir().expect("a folder");
    let out = root.path().join("out");
    fs::create_dir_all(out.join("summary.md/thesis")).expect("folders");
    assert_eq!(write(&out, "one", true), Err(Exit::Usage));
    assert!(out.join("summary.md/thesis").is_dir());
}

#[cfg(unix)]
#[test]
fn what_a_killed_process_left_is_removed_and_what_another_writes_is_not() {
    let root = tempfile::tempdir().expect("a folder");
    fs::create_dir(root.path().join(".report-killed")).expect("a folder");
    let other = RunFolder::create(Some(&root.path().join("a")), "", false).expect("a folder");
    other.write("run.toml", b"a").expect("written");
    assert_eq!(write(&root.path().join("b"), "b", false), Ok(()));
    other.finish().expect("written");
    assert_eq!(names(root.path()), ["a", "b"]);
}
