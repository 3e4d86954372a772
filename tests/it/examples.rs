//! The programs of `examples/` run and print numbers.

use std::path::Path;

use assert_cmd::Command;

#[test]
fn every_example_runs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let test = std::env::current_exe().expect("a path");
    let folder = test.parent().and_then(Path::parent).expect("target/PROFILE").join("examples");
    let sources = std::fs::read_dir(root.join("examples")).expect("examples");
    let names =
        sources.filter_map(|e| Some(e.expect("an entry").path().file_stem()?.to_str()?.to_owned()));
    // Seeds are written into the repository's own folder, by hand.
    let mut names: Vec<String> = names.filter(|name| name != "fuzz_seeds").collect();
    names.sort();
    assert!(names.len() >= 4, "{names:?}");
    for name in names {
        let program = folder.join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
        assert!(program.exists(), "{}: cargo build --examples", program.display());
        let run = Command::new(&program).current_dir(root).assert().success();
        let said = String::from_utf8_lossy(&run.get_output().stdout).into_owned();
        assert!(said.lines().count() >= 2 && said.contains(|c: char| c.is_ascii_digit()), "{said}");
    }
}
