//! The programs of `examples/` run and print numbers.

use std::path::Path;

use assert_cmd::Command;

#[test]
fn every_example_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let test = std::env::current_exe().expect("a path");
    let folder = test.parent().and_then(Path::parent).expect("target/PROFILE").join("examples");
    let sources = std::fs::read_dir(root.join("examples")).expect("examples");
    let programs = sources.map(|entry| entry.expect("an entry").path());
    let programs = programs.filter(|path| path.extension().is_some_and(|end| end == "rs"));
    let names = programs.filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned()));
    // Seeds and manual pages are written into folders of the repository, by hand.
    let by_hand = |name: &String| ["fuzz_seeds", "manual"].contains(&name.as_str());
    let mut names: Vec<String> = names.filter(|name| !by_hand(name)).collect();
    names.sort();
    assert!(names.len() >= 4, "{names:?}");
    for name in names {
        let program = folder.join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
        assert!(program.exists(), "{}: cargo build --examples", program.display());
        // The whole program with a dataflow of its own.
        let replay = ["replay", "traces/demo.bin", "--arch", "examples/own_flow/unsorted.toml"];
        let arguments = if name == "own_flow" { &replay[..] } else { &[] };
        let home = tempfile::tempdir().expect("a folder");
        let out = ["--out".to_owned(), home.path().join("report").display().to_string()];
        // The site checks every link of the pages.
        let site = [home.path().join("site").display().to_string()];
        let out = match name.as_str() {
            "own_flow" => &out[..],
            "site" => &site[..],
            _ => &[],
        };
        let mut command = Command::new(&program);
        command.current_dir(root).args(arguments).args(out);
        let run = command.assert().success();
        let said = String::from_utf8_lossy(&run.get_output().stdout).into_owned();
        assert!(said.lines().count() >= 2 && said.contains(|c: char| c.is_ascii_digit()), "{said}");
    }
}
