//! `chip`: the cores of `rtl/` against the cycle model and the datapath, on the same lists.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use powergs_testkit::scene_files::{ply, sample};
use powergs_testkit::verilator;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;
use tempfile::TempDir;

/// One core, whose buffers are the shares of one of four.
const ONE: [&str; 8] = [
    "--set",
    "vru.cores=1",
    "--set",
    "buffers.sorting.capacity=6KiB",
    "--set",
    "buffers.feature.capacity=32KiB",
    "--set",
    "buffers.pixel-out.capacity=4KiB",
];

fn run(words: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-lab"));
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    command.current_dir(root).arg("chip").args(words).assert()
}

fn scene(splats: usize) -> (TempDir, String) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.ply");
    fs::write(&path, ply(&sample(splats, 3))).expect("a scene");
    let path = path.to_str().expect("UTF-8").to_owned();
    (folder, path)
}

/// What is said of the first view; `None`, with a line, without Verilator.
fn view(words: &[&str]) -> Option<Value> {
    if !verilator::is_there("chip") {
        return None;
    }
    let build = concat!(env!("CARGO_TARGET_TMPDIR"), "/chip");
    let done = run(&[words, &["--json", "--build", build]].concat()).success();
    let all: Value = serde_json::from_slice(&done.get_output().stdout).expect("JSON");
    Some(all[0].clone())
}

fn pair(view: &Value, name: &str) -> [u64; 2] {
    let row = &view["rows"][name];
    ["model", "rtl"].map(|side| row[side].as_u64().unwrap_or_else(|| panic!("{name}: {view}")))
}

/// Pixels and bytes are equal, units are busy for as long within a percent, and the whole takes as
/// long within `share`.
fn agrees(view: &Value, share: f64) {
    assert_eq!(view["wrong_tiles"], Value::Array(Vec::new()), "{view}");
    for name in ["bytes of lists", "bytes of features", "bytes of pixels"] {
        let [model, rtl] = pair(view, name);
        assert_eq!(model, rtl, "{name}: {view}");
    }
    let phase = ("tile phase, cycles", share);
    for (name, share) in [("qsu busy", 0.01), ("bsu busy", 0.01), ("vru busy", 0.01), phase] {
        let [model, rtl] = pair(view, name).map(|cycles| cycles as f64);
        assert!((rtl / model - 1.0).abs() <= share, "{name}: {model} {rtl}; {view}");
    }
}

/// In one test, because all of it runs on the same bench.
#[test]
fn a_core_draws_the_pixels_of_the_datapath_in_the_cycles_of_the_model() {
    let (_folder, scene) = scene(3000);
    let of = [scene.as_str(), "--orbit", "1", "--size", "128x96"];
    let of = [&of[..], &ONE].concat();
    let Some(plain) = view(&of) else { return };
    assert!(plain["entries"].as_u64().is_some_and(|entries| entries > 4000), "{plain}");
    agrees(&plain, 0.03);
    // Tiles at the edge of the image, 11 columns and 4 rows of them inside.
    let edges = [scene.as_str(), "--orbit", "1", "--size", "75x52"];
    let Some(edges) = view(&[&edges[..], &ONE].concat()) else { return };
    agrees(&edges, 0.05);
    // Where pivots split unevenly, chunks are others and the picture is the same.
    let Some(sampled) = view(&[&of[..], &["--pivots", "sampled"]].concat()) else { return };
    assert_eq!(sampled["wrong_tiles"], Value::Array(Vec::new()), "{sampled}");
    assert!(pair(&sampled, "qsu busy")[1] > pair(&plain, "qsu busy")[1], "{sampled}");
    // Random stalls change no pixel.
    for (stalls, seed) in [("4,0,0", "1"), ("0,5,7", "2"), ("3,3,4", "3")] {
        let stalls = ["--tiles", "12", "--stalls", stalls, "--seed", seed];
        let Some(view) = view(&[&of[..], &stalls].concat()) else { return };
        assert_eq!(view["wrong_tiles"], Value::Array(Vec::new()), "{view}");
    }
    spills();
}

/// Lists that are longer than the sorting buffer, split once and twice, and given up when their
/// tiles are over.
fn spills() {
    for (splats, opacity) in [(5000, None), (9000, None), (9000, Some(6.0))] {
        let mut scene = sample(splats, 0);
        if let Some(opacity) = opacity {
            scene.logit_opacities.fill(opacity);
        }
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.ply");
        fs::write(&path, ply(&scene)).expect("a scene");
        let of = [path.to_str().expect("UTF-8"), "--orbit", "1", "--size", "48x32"];
        let of = [&of[..], &ONE].concat();
        let plain = view(&of).expect("Verilator");
        assert_eq!(plain["wrong_tiles"], Value::Array(Vec::new()), "{plain}");
        for name in ["bytes of lists", "bytes of features", "bytes of pixels"] {
            let [model, rtl] = pair(&plain, name);
            assert_eq!(model, rtl, "{name}: {plain}");
        }
        let [model, rtl] = pair(&plain, "tile phase, cycles").map(|cycles| cycles as f64);
        assert!((rtl / model - 1.0).abs() <= 0.03, "{plain}");
        // Rows that are not full, and those on their way, take room that the model gives to
        // entries.
        let [model, spilled] = pair(&plain, "bytes spilled");
        assert!(model > 30_000 && spilled >= model && 2 * spilled < 3 * model, "{plain}");
        let [_, back] = pair(&plain, "bytes read back");
        // What nobody wants any more is not read back.
        assert_eq!(back < spilled, opacity.is_some(), "{plain}");
        for (stalls, seed) in [("6,2,4", "1"), ("0,5,7", "2"), ("3,3,4", "3")] {
            let stalled = view(&[&of[..], &["--stalls", stalls, "--seed", seed]].concat());
            let stalled = stalled.expect("Verilator");
            assert_eq!(stalled["wrong_tiles"], Value::Array(Vec::new()), "{stalled}");
        }
    }
}

/// One core with two converters in front, as narrow as they come.
const CHIP: [&str; 13] = [
    "--front",
    "--set",
    "ccu.units=2",
    "--set",
    "buffers.gaussian-in.capacity=9696B",
    "--set",
    "ccu.cull-operations-per-cycle=2",
    "--set",
    "ccu.operations-per-cycle=4",
    "--set",
    "ccu.colour-operations-per-cycle=2",
    "--set",
    "ccu.operations={cull=12,project=208,obb-prepare=0,sh-colour=118}",
];

/// From the records of a scene to its picture.
#[test]
fn a_chip_makes_the_lists_and_the_picture() {
    let (folder, scene) = scene(3000);
    let picture = folder.path().join("chip.png");
    let of = [scene.as_str(), "--orbit", "1", "--size", "123x90"];
    let of = [&of[..], &ONE, &CHIP].concat();
    let written = ["--picture", picture.to_str().expect("UTF-8")];
    let Some(plain) = view(&[&of[..], &written].concat()) else { return };
    agrees(&plain, 0.03);
    for name in ["bytes read before", "bytes written before"] {
        let [model, rtl] = pair(&plain, name);
        assert_eq!(model, rtl, "{name}: {plain}");
    }
    // A front first empties the pointers of 8 x 6 tiles, one a cycle, of which the model knows
    // nothing.
    let emptied = 48;
    for name in ["frame, cycles", "preprocessing"] {
        let [model, rtl] = pair(&plain, name);
        let share = (rtl - emptied) as f64 / model as f64 - 1.0;
        assert!(share.abs() <= 0.03, "{name}: {plain}");
    }
    assert!(fs::metadata(&picture).expect("a picture").len() > 2000);
    // Random stalls change no pixel.
    let Some(view) = view(&[&of[..], &["--stalls", "3,4,5"]].concat()) else { return };
    assert_eq!(view["wrong_tiles"], Value::Array(Vec::new()), "{view}");
    // What is there is not replaced.
    run(&[&of[..], &written].concat()).code(2).stderr(contains("--force"));
}

/// Twelve subsets of tiles of two trained scenes, and a whole view of each. Minutes:
/// `RUN_SLOW_TESTS=1`.
#[test]
fn a_core_is_as_fast_as_the_model_says_on_trained_scenes() {
    if std::env::var_os("RUN_SLOW_TESTS").is_none() {
        eprintln!("skipped: minutes (RUN_SLOW_TESTS=1)");
        return;
    }
    for name in ["fox-posed", "snowmiku-posed"] {
        let folder = format!("{}/../../../shared/data/{name}", env!("CARGO_MANIFEST_DIR"));
        if !Path::new(&folder).exists() {
            eprintln!("skipped: {folder} is not there");
            return;
        }
        let (scene, cameras) =
            (format!("{folder}/point_cloud.ply"), format!("{folder}/cameras.json"));
        let of = [&scene, "--cameras", &cameras, "--frames", "0..1", "--size", "320x240"];
        // Nothing is spilled.
        let room = ["--set", "buffers.sorting.capacity=24KiB"];
        let of = [&of[..], &ONE, &room].concat();
        for offset in ["0", "1", "2", "3", "4", "5"] {
            let some = ["--tiles", "40", "--offset", offset];
            let Some(view) = view(&[&of[..], &some].concat()) else { return };
            agrees(&view, 0.02);
        }
        let Some(core) = view(&of) else { return };
        agrees(&core, 0.02);
        for (memory, share) in [("dram.model=bandwidth", 0.03), ("dram.model=banked", 0.05)] {
            let Some(view) = view(&[&of[..], &["--front", "--set", memory]].concat()) else {
                return;
            };
            agrees(&view, share);
            let [model, rtl] = pair(&view, "frame, cycles").map(|cycles| cycles as f64);
            assert!((rtl / model - 1.0).abs() <= share, "{view}");
        }
    }
}

#[test]
fn what_the_rtl_cannot_be_is_refused() {
    let (_folder, scene) = scene(20);
    for (setting, why) in [
        ("gsu.pivots=15", "gsu.pivots = 15: the RTL has 7 only"),
        ("vru.impl=\"serial\"", "the RTL has \"parallel\" only"),
        ("geometry.chunk=100", "geometry.chunk = 100: a multiple of 16, at most 256"),
        ("buffers.feature.capacity=96KiB", "a power of two for each core"),
        ("buffers.sorting.capacity=49KB", "times 96 B for each core"),
        ("vru.subtile-queue=1", "vru.subtile-queue = 1: 2 to 64"),
    ] {
        run(&[&scene, "--orbit", "1", "--size", "32x32", "--set", setting])
            .code(2)
            .stderr(contains(why));
    }
    for (setting, why) in [
        ("ccu.units=2", "buffers.gaussian-in.capacity = 4848 B: 4848 B for each converter"),
        ("ccu.operations-per-cycle=12", "there are programs for [2, 4, 2], [2, 8, 4]"),
        ("ccu.operations.cull=47", "operators times interval: [9, 192, 120]"),
        ("binning.combining.capacity=3KiB", "2 to 4096 lines, a power of two"),
        ("binning.block=3KiB", "256 B to 512 KiB, a power of two"),
        ("binning.impl=free", "binning.impl = \"free\": the RTL has \"append\" only"),
    ] {
        run(&[&scene, "--orbit", "1", "--size", "32x32", "--front", "--set", setting])
            .code(2)
            .stderr(contains(why));
    }
    run(&[&scene, "--orbit", "1", "--size", "1040x1040", "--front"])
        .code(2)
        .stderr(contains("65 x 65 tiles, and the RTL counts 511 a side, 4096 in all"));
    run(&["traces/demo.bin", "--orbit", "1"])
        .code(2)
        .stderr(contains("traces/demo.bin: is a trace").and(contains("--cameras")));
    run(&[&scene, "--orbit", "1", "--size", "32x32", "--stalls", "1,9,0"])
        .code(2)
        .stderr(contains("three numbers from 0 to 7"));
}

#[test]
fn runs_that_are_none_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let runs = folder.path().join("runs.toml");
    let assumptions = |words: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-lab"));
        command.current_dir(folder.path()).arg("assumptions").args(words).assert()
    };
    assumptions(&["--scenes", "nowhere"])
        .code(3)
        .stderr(contains("nowhere/fox-posed/point_cloud.ply"));
    fs::write(&runs, "size = \"64x64\"\nscenes = []\n").expect("a file");
    assumptions(&["runs.toml", "--scenes", "."])
        .code(2)
        .stderr(contains("runs.toml").and(contains("unknown field `scenes`")));
    let of = |phase: &str| {
        format!(
            "[[assumption]]\nids = [\"A33\"]\nwhat = \"\"\nmachine = \"a\"\nrow = \"b\"\n\
             phase = \"{phase}\"\n"
        )
    };
    let two =
        ["size = \"64x64\"\nscene = []\nmachine = []\nbase = { set = [] }\n", &of("x"), &of("y")];
    fs::write(&runs, two.concat()).expect("a file");
    assumptions(&["runs.toml", "--scenes", "."])
        .code(2)
        .stderr(contains("runs.toml: A33 has two phases: x, y"));
    assumptions(&["runs.toml", "--scenes", ".", "--write", "runs.toml"])
        .code(2)
        .stderr(contains("--force"));
}

#[test]
fn a_list_that_has_no_room_is_refused() {
    let (_folder, scene) = scene(4000);
    let small = ["--orbit", "1", "--size", "32x32", "--set", "buffers.sorting.capacity=18KiB"];
    run(&[&[scene.as_str()], &small[..]].concat())
        .code(2)
        .stderr(contains("room for 640 (buffers.sorting.capacity, geometry.chunk)"));
}
