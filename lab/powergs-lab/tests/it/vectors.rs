//! `vectors`: real work of units for their test benches, and with Verilator what the RTL makes of
//! it.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use powergs_testkit::scene_files::{ply, sample};
use powergs_testkit::verilator::Bench;
use predicates::str::contains;
use tempfile::TempDir;

fn run(words: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-lab"));
    command
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .arg("vectors")
        .args(words)
        .assert()
}

fn words(path: &Path) -> Vec<u16> {
    let bytes = fs::read(path).expect("a file");
    bytes.chunks_exact(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect()
}

fn folder_with_scene() -> (TempDir, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = folder.path().join("a.ply");
    fs::write(&scene, ply(&sample(400, 3))).expect("a scene");
    let scene = scene.to_str().expect("UTF-8").to_owned();
    (folder, scene)
}

/// A unit, where its work comes from, and the parameters of its RTL.
type Unit<'a> = (&'a str, &'a [&'a str], &'a [(&'a str, u32)]);

/// What the RTL writes is the file of what is expected, byte for byte where cycles are stated.
#[test]
fn the_rtl_answers_real_work_as_the_files_say() {
    let (folder, scene) = folder_with_scene();
    let trace = ["--trace", "traces/demo.bin"];
    let view = ["--scene", &scene, "--orbit", "3", "--size", "128x96"];
    let fp16 = [("EXP", 5), ("MAN", 10), ("SPLIT", 1)];
    let core = [&fp16[..], &[("PIXELS", 4), ("COLUMNS", 2)]].concat();
    let unit = [&fp16[..], &[("QUEUE", 2)]].concat();
    let front = [("EXP", 8), ("MAN", 15), ("TO_EXP", 5), ("TO_MAN", 10), ("OPS", 8)];
    let units: [Unit; 5] = [
        ("qsu", &trace, &[]),
        ("bsu", &trace, &[]),
        ("vrc", &view, &core),
        ("vru", &view, &unit),
        ("ccu", &view, &front),
    ];
    for (unit, of, parameters) in units {
        let out = folder.path().join(unit);
        let to = out.to_str().expect("UTF-8");
        let words_of = [&[unit, "--out", to, "--json"], of].concat();
        let done = run(&words_of).success();
        let facts: serde_json::Value =
            serde_json::from_slice(&done.get_output().stdout).expect("JSON");
        let number = |name: &str| facts[name].as_u64().expect("a number") as usize;
        let (stimulus, expected) =
            (words(&out.join("stimulus.bin")), words(&out.join("expected.bin")));
        assert_eq!(stimulus.len(), number("words"));
        let event = number("words_of_an_event");
        assert_eq!(expected.len(), number("events") * event);
        assert!(number("events") > 500, "{unit}: {facts}");
        let Some(bench) = Bench::build(env!("CARGO_TARGET_TMPDIR"), unit, parameters) else {
            continue;
        };
        let mut found = bench.run(&stimulus);
        if facts["cycles"].is_null() {
            // In the order of their kinds, with cycles of 0.
            let mut events: Vec<&mut [u16]> = found.chunks_exact_mut(event).collect();
            events.iter_mut().for_each(|event| (event[1], event[2]) = (0, 0));
            events.sort_by_key(|event| event[0]);
            found = events.into_iter().flat_map(|event| event.iter().copied()).collect();
        }
        assert!(found == expected, "{unit}");
    }
}

#[test]
fn vectors_are_the_same_for_any_number_of_threads_and_not_written_over() {
    let (folder, scene) = folder_with_scene();
    let out = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let of = |threads: &str, to: &str| {
        let words = ["vru", "--scene", &scene, "--orbit", "2", "--size", "96x64", "-j", threads];
        run(&[&words[..], &["--out", to]].concat())
    };
    of("1", &out("one")).success().stdout(contains("words of stimulus"));
    of("2", &out("two")).success();
    for file in ["stimulus.bin", "expected.bin"] {
        assert_eq!(
            words(&Path::new(&out("one")).join(file)),
            words(&Path::new(&out("two")).join(file))
        );
    }
    of("1", &out("one")).code(2).stderr(contains("exists already"));
}

#[test]
fn there_must_be_something_to_do() {
    let (folder, scene) = folder_with_scene();
    let to = folder.path().join("no");
    let to = to.to_str().expect("UTF-8");
    let view = ["--scene", &scene, "--orbit", "1", "--size", "64x48"];
    run(&[&["vrc", "--out", to, "--format", "e3m4"], &view[..]].concat())
        .code(2)
        .stderr(contains("four bits of exponent"));
    run(&["qsu", "--out", to, "--trace", &scene]).code(3).stderr(contains("a.ply"));
    assert!(!Path::new(to).exists());
}
