//! `pack`: a folder with its inputs, unpacked elsewhere and run again.

use std::fs;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use tempfile::TempDir;
use zip::ZipArchive;

/// A folder with the demo trace and a machine on a base of its own.
struct Home(TempDir);

const MINE: &str = "base = \"../base.toml\"\nname = \"mine\"\n[vru]\ncores = 2\n";

impl Home {
    fn new() -> Home {
        let home = Home(tempfile::tempdir().expect("a folder"));
        for folder in ["work", "data", "elsewhere"] {
            fs::create_dir(home.path(folder)).expect("made");
        }
        home.trace("work/demo.bin");
        home.write("base.toml", "base = \"edge\"\nname = \"based\"\nclock = \"500 MHz\"\n");
        home.write("work/mine.toml", MINE);
        home
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn text(&self, name: &str) -> String {
        self.path(name).to_str().expect("UTF-8").to_owned()
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).expect("written");
    }

    fn trace(&self, name: &str) {
        let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/traces/demo.bin");
        fs::copy(demo, self.path(name)).expect("the demo trace");
    }

    fn run(&self, place: &str, arguments: &[&str]) -> assert_cmd::assert::Assert {
        let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
        command.current_dir(self.path(place)).args(arguments);
        command.env_remove("POWERGS_SHARD").env("COLUMNS", "200").assert()
    }

    /// Unpacks `work/NAME.zip`, deletes everything that it was made from, and runs it again.
    fn again_elsewhere(&self, name: &str) {
        let archive = self.path("elsewhere/it.zip");
        fs::rename(self.path(&format!("work/{name}.zip")), &archive).expect("moved");
        let mut zip = ZipArchive::new(fs::File::open(&archive).expect("there")).expect("a zip");
        zip.extract(self.path("elsewhere")).expect("unpacked");
        for folder in ["work", "data"] {
            fs::remove_dir_all(self.path(folder)).expect("removed");
        }
        fs::remove_file(self.path("base.toml")).expect("removed");
        let said = self.run("elsewhere", &["again", name]).code(0);
        said.stdout(contains("The same bytes.").and(contains("other inputs").not()));
    }

    /// Names in `work/NAME.zip`.
    fn names(&self, name: &str) -> Vec<String> {
        let file = fs::File::open(self.path(&format!("work/{name}.zip"))).expect("there");
        let zip = ZipArchive::new(file).expect("a zip");
        zip.file_names().map(|name| name.expect("a name").into_owned()).collect()
    }
}

const REPLAY: [&str; 8] =
    ["replay", "demo.bin", "--frames", "..1", "--what-if", "0", "-q", "--arch=mine.toml"];

#[test]
fn a_replay_is_the_same_wherever_it_is_unpacked() {
    let home = Home::new();
    home.run("work", &[&REPLAY[..], &["-o", "out"]].concat()).success();
    let said = home.run("work", &["pack", "out"]).success();
    said.stdout(contains("3 files").and(contains("3 inputs as in the record")));
    let names = home.names("out");
    for name in ["out/run.toml", "out/inputs/base.toml", "out/inputs/work/demo.bin"] {
        // The base lies above the working folder, and so it does in the archive.
        let name = name.replace("out/inputs/", "out/inputs/work/");
        assert!(names.contains(&name), "{name}: {names:?}");
    }
    // The same bytes whenever it is packed, and nothing is replaced.
    let first = fs::read(home.path("work/out.zip")).expect("an archive");
    home.run("work", &["pack", "out"]).code(2).stderr(contains("--force"));
    home.run("work", &["pack", "out", "--force", "-q"]).success();
    assert!(fs::read(home.path("work/out.zip")).expect("an archive") == first);
    home.again_elsewhere("out");
    // What is unpacked can be packed once more.
    home.run("elsewhere", &["pack", "out", "-q"]).success();
    assert!(fs::read(home.path("elsewhere/out.zip")).expect("an archive") == first);
}

#[test]
fn paths_from_the_root_get_places_in_the_archive() {
    let home = Home::new();
    home.trace("data/far.bin");
    home.write("data/table.toml", "base = \"gscore-28nm\"\nname = \"mine\"\n");
    let (trace, table) = (home.text("data/far.bin"), home.text("data/table.toml"));
    let (out, near) = (home.text("work/out"), home.text("work/mine.toml"));
    let energy = format!("energy={table}");
    let words = ["replay", &trace, "--arch", &near, "--set", &energy, "--frames", "..1"];
    home.run("work", &[&words[..], &["--what-if", "0", "-q", "--out", &out]].concat()).success();
    home.run("elsewhere", &["pack", &out, "-o", "../work/out.zip"]).success();
    let file = fs::File::open(home.path("work/out.zip")).expect("there");
    let mut zip = ZipArchive::new(file).expect("a zip");
    let record = zip.by_name("out/invocation.toml").expect("a record");
    let record = std::io::read_to_string(record).expect("text");
    // The record of the run has the path of the energy table, and no other.
    let root = home.0.path().to_str().expect("UTF-8");
    let moved = format!("\"../../2/table.toml\" = \"{table}\"");
    assert!(record.contains(&moved) && record.matches(root).count() == 1, "{record}");
    home.again_elsewhere("out");
}

#[test]
fn a_comparison_has_all_of_its_traces() {
    let home = Home::new();
    home.trace("data/other.bin");
    let other = home.text("data/other.bin");
    let words = ["compare", "edge", "mine.toml", "demo.bin", &other, "--frames", "..1", "-q"];
    home.run("work", &[&words[..], &["-o", "two"]].concat()).success();
    home.run("work", &["pack", "two"]).success().stdout(contains("4 inputs as in the record"));
    home.again_elsewhere("two");
}

#[test]
fn a_sweep_has_what_its_file_names() {
    let home = Home::new();
    home.trace("data/a.bin");
    home.trace("data/b.bin");
    home.write(
        "data/cores.toml",
        "question = \"Which?\"\nbase = \"../work/mine.toml\"\n\
         [[axes]]\nkey = \"vru.cores\"\nvalues = [1, 2]\n[[traces]]\npath = \"?.bin\"\n",
    );
    let sweep = ["sweep", "../data/cores.toml", "--frames", "..1", "-q", "-o", "cores"];
    home.run("work", &sweep).success();
    home.run("work", &["pack", "cores"]).success().stdout(contains("left out"));
    home.again_elsewhere("cores");
}

#[test]
fn a_sensitivity_analysis_is_packed() {
    let home = Home::new();
    let words = ["sensitivity", "mine.toml", "demo.bin", "--frames", "..1", "-q"];
    home.run("work", &[&words[..], &["--keys", "vru.cores", "-o", "out"]].concat()).success();
    home.run("work", &["pack", "out"]).success();
    home.again_elsewhere("out");
}

#[test]
fn a_trained_model_keeps_its_name_and_its_background() {
    let home = Home::new();
    let run = "data/chair/point_cloud/iteration_7";
    fs::create_dir_all(home.path(run)).expect("made");
    home.write("data/chair/cfg_args", "Namespace(white_background=True)");
    let model = home.text(&format!("{run}/point_cloud.ply"));
    home.run("work", &["synth", "lego", "--points", "500", "-q", "-o", &model]).success();
    let views = ["--orbit", "3", "--size", "32x32", "--iterations", "2", "--arch", "mine.toml"];
    let optimize = [&["optimize", &model], &views[..], &["-q", "-o", "chair"]].concat();
    home.run("work", &optimize);
    home.run("work", &["pack", "chair"]).success().stdout(contains("left out"));
    let names = home.names("chair");
    for name in ["chair/cfg_args", "chair/point_cloud/iteration_7/point_cloud.ply"] {
        assert!(names.contains(&format!("chair/inputs/1/{name}")), "{name}: {names:?}");
    }
    home.again_elsewhere("chair");
}

#[test]
fn what_cannot_be_packed_is_refused_by_name() {
    let home = Home::new();
    home.run("work", &[&REPLAY[..], &["-o", "out"]].concat()).success();
    let refused = |more: &[&str], code: i32, said: &str| {
        let run = home.run("work", &[&["pack"], more].concat());
        run.code(code).stderr(contains(said));
        assert!(!home.path("work/out.zip").exists());
    };
    refused(&["no-such"], 3, "no such folder");
    refused(&["../data"], 3, "no invocation.toml and run.toml");
    refused(&["out", "-o", "out.tar"], 2, "is a .zip file");
    refused(&["out", "-o", "out/it.zip"], 2, "is in the folder that is packed");
    refused(&["out", "-o", "no/such/it.zip"], 2, "cannot be written");
    refused(&["out", "--in", "../elsewhere"], 3, "not among the files that the command reads");
    home.write("work/mine.toml", &MINE.replace('2', "1"));
    refused(&["out"], 3, "mine.toml is another file");
    home.write("work/mine.toml", MINE);
    fs::rename(home.path("base.toml"), home.path("away.toml")).expect("moved");
    refused(&["out"], 3, "machine base.toml: not among the files");
    fs::rename(home.path("away.toml"), home.path("base.toml")).expect("moved");
    #[cfg(unix)]
    {
        let link = home.path("work/out/link.svg");
        std::os::unix::fs::symlink("energy.svg", &link).expect("a link");
        refused(&["out"], 3, "a link is not packed");
        fs::remove_file(&link).expect("removed");
    }
    let run = home.path("work/out/run.toml");
    let text = fs::read_to_string(&run).expect("a record");
    fs::write(&run, "schema-version = 3\n").expect("written");
    refused(&["out"], 3, "it is no record of a run");
    fs::write(&run, text.replace("incomplete = false", "incomplete = true")).expect("written");
    refused(&["out"], 3, "interrupted");
    assert_eq!(leftovers(&home.path("work")), Vec::<String>::new());
}

#[test]
fn a_path_from_the_root_in_a_file_is_refused() {
    let home = Home::new();
    let base = home.text("base.toml");
    home.write("work/mine.toml", &MINE.replace("../base.toml", &base));
    home.run("work", &[&REPLAY[..], &["-o", "out"]].concat()).success();
    home.run("work", &["pack", "out"]).code(3).stderr(contains("by an absolute path"));
}

/// Hidden files of a folder.
fn leftovers(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name().into_string());
    names.map(|name| name.expect("UTF-8")).filter(|name| name.starts_with('.')).collect()
}
