//! The brief of a headset maker, from scene to answer: two eyes, 72 Hz, a budget of watts and mm².
//! Every number is worked out from those of single views.

use std::fs;
use std::path::Path;

use approx::assert_relative_eq;
use assert_cmd::Command;
use predicates::str::contains;
use serde_json::Value;

/// A clock at which small views take as long as large ones do.
const SLOW: &str = "clock=20 MHz";

pub fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
    program.current_dir(folder).args(arguments);
    program
}

pub fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = program(folder, arguments).assert().code(0);
    serde_json::from_slice(&output.get_output().stdout).expect("JSON")
}

fn number(report: &Value, path: &str) -> f64 {
    let found = path.split('.').fold(report, |value, key| match key.parse::<usize>() {
        Ok(i) => &value[i],
        Err(_) => &value[key],
    });
    found.as_f64().unwrap_or_else(|| panic!("{path}: {found}"))
}

/// Two pairs of views of a small scene, and the same views as pairs that nobody told of.
fn scene(folder: &Path) {
    let run = |arguments: &[&str]| drop(program(folder, arguments).assert().code(0));
    run(&["synth", "room", "--points", "3000", "-o", "room.ply", "--cameras", "all.json"]);
    let views = ["--every", "20", "--frames", "0..2", "--size", "206x220", "--stereo", "0.064"];
    let mut eyes = vec!["camera", "convert", "--cameras", "all.json", "-o", "eyes.json"];
    eyes.extend(views);
    eyes.extend(["--fov", "55+45x48+48"]);
    run(&eyes);
    run(&["extract", "room.ply", "--cameras", "eyes.json", "-o", "pairs.bin"]);
    let text = fs::read_to_string(folder.join("eyes.json")).expect("cameras");
    let mut list: Value = serde_json::from_str(&text).expect("JSON");
    for view in list.as_array_mut().expect("views") {
        view.as_object_mut().expect("a view").remove("eye").expect("an eye");
    }
    fs::write(folder.join("views.json"), list.to_string()).expect("a file");
    run(&["extract", "room.ply", "--cameras", "views.json", "-o", "views.bin"]);
}

#[test]
fn the_brief_of_a_headset() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path();
    scene(folder);
    // Off-centre frusta, mirrored: 55 degrees to the temple, 45 to the nose.
    let text = fs::read_to_string(folder.join("eyes.json")).expect("cameras");
    let eyes: Value = serde_json::from_str(&text).expect("JSON");
    let tan = |degrees: f64| degrees.to_radians().tan();
    let fx = 206.0 / (tan(55.0) + tan(45.0));
    for (i, outer) in [(0, 55.0), (1, 45.0)] {
        assert_relative_eq!(number(&eyes[i], "fx"), fx, max_relative = 1e-9);
        assert_relative_eq!(number(&eyes[i], "cx"), fx * tan(outer), max_relative = 1e-9);
        assert_relative_eq!(number(&eyes[i], "cy"), 110.0, max_relative = 1e-9);
    }
    let replay = |trace: &str, more: &[&str]| {
        let mut arguments = vec!["replay", trace, "--what-if", "0", "--json", "--force"];
        arguments.extend(["--out", "report"]);
        arguments.extend(more);
        json(folder, &arguments)
    };
    let single = replay("views.bin", &["--fps", "72"]);
    let pairs = replay("pairs.bin", &["--fps", "72"]);
    assert_eq!(pairs["frames"].as_array().expect("frames").len(), 2);
    assert_eq!(number(&pairs, "trace.eyes"), 2.0);
    let sums = |path: &str, pair: usize| {
        let of = |eye: usize| number(&single, &format!("frames.{}.{path}", 2 * pair + eye));
        of(0) + of(1)
    };
    for pair in 0..2 {
        for path in ["frame_time_ms", "energy_pj.total", "dram_read_bytes", "display_power_w"] {
            let both = number(&pairs, &format!("frames.{pair}.{path}"));
            assert_relative_eq!(both, sums(path, pair), max_relative = 1e-9);
        }
        // Work of both eyes 72 times a second, standby once.
        let of = |report: &Value, frame: usize, path: &str| {
            number(report, &format!("frames.{frame}.{path}"))
        };
        let work: f64 = ["dram", "sram", "flop"]
            .map(|part| sums(&format!("energy_pj.{part}"), pair))
            .iter()
            .sum();
        let standby: f64 = ["leakage", "background", "refresh"]
            .map(|part| of(&pairs, pair, &format!("power_w.{part}")))
            .iter()
            .sum();
        let watts = of(&pairs, pair, "power_w.total");
        assert_relative_eq!(watts, work * 1e-12 * 72.0 + standby, max_relative = 1e-9);
    }
    // A rate that each view keeps and no pair does, on a slow machine: these views are small.
    let slow = ["--set", SLOW];
    let times = replay("views.bin", &slow);
    let slowest = (0..4).map(|i| number(&times, &format!("frames.{i}.frame_time_ms")));
    let fps = format!("{:.0}", 1e3 / (1.3 * slowest.fold(0.0, f64::max)));
    let share = |report: &Value| number(report, "aggregate.deadline_missed.mean");
    let at = ["--fps", &fps, slow[0], slow[1]];
    assert_eq!(share(&replay("views.bin", &at)), 0.0);
    assert_eq!(share(&replay("pairs.bin", &at)), 1.0);
    // The die is what stands on the bill: eight channels of 1 mm² and 0.1 mm² of controller.
    let area = |name: &str| number(&pairs, &format!("aggregate.area_mm2.{name}.mean"));
    assert_relative_eq!(area("total"), area("core") + 8.0 * 1.1, max_relative = 1e-9);

    said_in_words(folder, &fps);
}

/// First lines, notes, and answers of the commands that choose.
fn said_in_words(folder: &Path, fps: &str) {
    let shown = |trace: &str| {
        let arguments = ["replay", trace, "--what-if", "0", "--force", "--out", "report"];
        program(folder, &arguments).args(["--fps", fps, "--set", SLOW]).assert().code(0)
    };
    let first = format!("pairs on gscore: 2 pairs of 2 x 206x220 at {fps} Hz");
    let missed = shown("pairs.bin").stdout(contains(first));
    missed.stdout(contains("MISSED by 2 of 2 pairs")).stdout(contains("of both displays"));
    let loud = shown("views.bin").stdout(contains("met by 4 frames"));
    loud.stderr(contains("those of ONE eye"));
    // Half of a pair is no frame.
    let cut = ["replay", "pairs.bin", "--frames", "1..3", "--out", "cut"];
    program(folder, &cut).assert().code(2).stderr(contains("write 0..4"));
    // Sweeps and comparisons count the same way.
    let compare = ["compare", "gscore", "edge", "pairs.bin", "--fps", fps, "--out", "compared"];
    let compared = program(folder, &compare).args(["--set", SLOW]).assert().code(0);
    compared.stdout(contains("in 2 of 2 pairs"));
    fs::write(
        folder.join("cores.toml"),
        "question = \"How many cores?\"\nbase = \"gscore\"\ndisplay-fps = 1\n\
         set = { clock = \"20 MHz\" }\n\
         [[axes]]\nkey = \"vru.cores\"\nvalues = [4, 16]\n",
    )
    .expect("a file");
    let sweep = ["sweep", "cores.toml", "--traces", "pairs.bin", "--fps", fps, "-o", "swept"];
    let swept = program(folder, &sweep).assert().code(0);
    swept.stdout(contains("Memory: banked for all designs"));
    let rows = fs::read_to_string(folder.join("swept/results.csv")).expect("a table");
    let mut rows = csv::Reader::from_reader(rows.as_bytes());
    let head = rows.headers().expect("a head").clone();
    let place = |name: &str| head.iter().position(|h| h == name).expect("a column");
    let (frames, missed) = (place("frames"), place("deadline_missed_frac"));
    let base = rows.records().next().expect("a row").expect("a row");
    assert_eq!((&base[frames], &base[missed]), ("2", "1"), "two pairs, both late");
}
