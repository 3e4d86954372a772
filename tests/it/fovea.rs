//! Foveation as a user meets it.

use std::path::Path;

use assert_cmd::Command;
use powergs_sim::scene::write_ply;
use powergs_testkit::foveated::levels;
use serde_json::Value;

fn program() -> Command {
    Command::cargo_bin("powergs-sim").expect("the program was built")
}

fn json(run: &mut Command) -> Value {
    let done = run.assert().success();
    serde_json::from_slice(&done.get_output().stdout).expect("JSON")
}

fn error(run: &mut Command, exit: i32) -> String {
    let done = run.assert().code(exit);
    String::from_utf8(done.get_output().stderr.clone()).expect("UTF-8")
}

/// Four levels and the model of them.
fn compose(folder: &Path) {
    for (k, part) in levels(1, 400, 1, 0.6).iter().enumerate() {
        let mut bytes = Vec::new();
        write_ply(part, &mut bytes).expect("memory");
        std::fs::write(folder.join(format!("L{}.ply", k + 1)), bytes).expect("a folder");
    }
    let mut run = program();
    run.current_dir(folder).args(["--json", "scene", "compose"]);
    run.args(["L1.ply", "L2.ply", "L3.ply", "L4.ply", "-o", "model.fov"]);
    assert_eq!(json(&mut run)["points"][0], 400);
}

const VIEWS: [&str; 8] =
    ["--orbit", "3", "--size", "96x64", "--orbit-radius", "6", "--orbit-fov", "60"];
const EYE: [&str; 4] = ["--screen", "wide-110", "--pooling-rate", "0.5"];

#[test]
fn from_four_files_to_a_report_with_regions() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    compose(at);
    let run = |args: &[&str]| {
        let mut run = program();
        run.current_dir(at).args(args);
        run
    };
    run(&["scene", "level", "model.fov", "--level", "3", "-o", "back.ply"]).assert().success();
    let read = |name: &str| std::fs::read(at.join(name)).expect("a file");
    assert_eq!(read("back.ply"), read("L3.ply"));

    let mut render = run(&["render", "model.fov", "--gaze", "0.4,0.6", "--levels", "-o", "map"]);
    let done = render.args(VIEWS).args(EYE).assert().success();
    let note = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    assert!(note.starts_with("note: the screen is 110.0") && note.lines().count() == 1, "{note}");
    assert_eq!(std::fs::read_dir(at.join("map")).expect("a folder").count(), 3);
    // On the screen of its camera the image is too small: said, and gone on.
    let mut small = run(&["render", "model.fov", "--gaze", "0.5,0.5", "-o", "small"]);
    let done = small.args(VIEWS).assert().success();
    let note = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    assert!(note.contains("no pixel is in R2, R3, R4"), "{note}");

    let mut extract = run(&["extract", "model.fov", "--gaze-cycle", "9", "-o", "fr.bin"]);
    extract.args(VIEWS).args(EYE).assert().success();
    let info = json(&mut run(&["--json", "trace", "info", "fr.bin"]));
    assert_eq!(info["frames"][2]["foveated"], true);
    assert_eq!(info["frames"][2]["gaze"], serde_json::json!([0.25, 0.75]));

    for (arch, sets) in
        [("gscore", "fovea.accumulators=2"), ("gscore-powergs", "fovea.accumulators=1")]
    {
        let mut replay = run(&["--json", "replay", "fr.bin", "--arch", arch, "--set", sets]);
        let out = format!("report-{arch}");
        let report = json(replay.args(["--out", &out]));
        let frame = &report["frames"][0];
        for region in ["r1", "r2", "r3", "r4"] {
            let own = &frame["regions"][region];
            assert!(own["tiles"].as_u64().is_some() && own["energy_pj"].as_f64().is_some());
        }
        assert_eq!(frame["fovea"]["gaze_y"], 0.25);
        let summary = std::fs::read_to_string(at.join(&out).join("summary.md")).expect("it");
        assert!(summary.contains("| R4 |"), "{summary}");
    }
    let done = run(&["replay", "fr.bin", "--arch", "gscore", "--out", "said"]).assert().success();
    let said = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    let rows = said.lines().skip_while(|line| !line.starts_with("region, a frame"));
    let names: Vec<&str> = rows.skip(1).take(4).filter_map(|row| row.get(..2)).collect();
    assert_eq!(names, ["R1", "R2", "R3", "R4"], "{said}");
    assert!(said.lines().take_while(|l| !l.starts_with("report")).all(|l| l.len() <= 82), "{said}");
    let refused = error(&mut run(&["replay", "fr.bin", "--arch", "neo", "--out", "no"]), 2);
    assert!(refused.contains("fovea.accumulators = 1"), "{refused}");
    let paper = json(&mut run(&["--json", "replay", "fr.bin", "--model", "paper", "--out", "p"]));
    assert!(paper["frames"][0]["fovea"]["level_lookups"].as_u64().expect("a count") > 0);
    let both = ["compare", "gscore", "edge", "fr.bin", "--out", "both"];
    run(&both).assert().success();
}

/// A sweep over what machines can do with foveated frames: results per region, and machines that
/// cannot render them fail with a reason.
#[test]
fn a_sweep_has_results_of_regions() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    compose(at);
    let run = |args: &[&str]| {
        let mut run = program();
        run.current_dir(at).args(args);
        run
    };
    let mut extract = run(&["extract", "model.fov", "--gaze", "0.5,0.5", "-o", "fr.bin"]);
    extract.args(VIEWS).args(EYE).assert().success();
    let sweep = "question = \"What does a second accumulator buy?\"\nbase = \"gscore\"\n\
                 [[axes]]\nkey = \"fovea.accumulators\"\nvalues = [0, 1, 2]\n";
    std::fs::write(at.join("two.toml"), sweep).expect("a folder");
    run(&["-q", "sweep", "two.toml", "--traces", "fr.bin", "--out", "s"]).assert().success();
    let mut table = csv::Reader::from_path(at.join("s/results.csv")).expect("results");
    let names = table.headers().expect("a header").clone();
    let place = |name: &str| names.iter().position(|n| n == name).expect(name);
    let mut tiles = [0; 3];
    for row in table.records().map(|row| row.expect("a row")) {
        let units: usize = row[place("fovea.accumulators")].parse().expect("a number");
        assert_eq!(&row[place("status")], if units == 0 { "failed" } else { "ok" }, "{row:?}");
        let sum = |what: &str| -> f64 {
            let of = |k: usize| row[place(&format!("regions.r{k}.{what}"))].parse().unwrap_or(0.0);
            (1..=4).map(of).sum()
        };
        tiles[units] = sum("tiles") as u64;
        assert_eq!(sum("energy_pj") > 0.0, units > 0, "{row:?}");
    }
    assert_eq!(tiles, [0, 24, 24], "6 x 4 tiles");
}

#[test]
fn what_cannot_be_is_refused_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    compose(at);
    let render = |args: &[&str]| {
        let mut run = program();
        run.current_dir(at).arg("render").args(args).args(VIEWS).args(["-o", "out"]);
        run
    };
    for gaze in ["1.0000001,0.5", "-0.1,0.5", "NaN,0.5"] {
        let said = error(&mut render(&["model.fov", "--gaze", gaze]), 2);
        assert!(said.contains("two numbers from 0 to 1"), "{gaze}: {said}");
    }
    for screen in ["0", "180", "-5", "NaN", "huge"] {
        let mut run = render(&["model.fov", "--gaze", "0.5,0.5", "--screen", screen]);
        error(&mut run, 2);
    }
    let said = error(&mut render(&["L1.ply", "--gaze", "0.5,0.5"]), 2);
    assert!(said.contains("scene compose"), "{said}");
    let said = error(&mut render(&["model.fov", "--levels"]), 2);
    assert!(said.contains("--gaze"), "{said}");
    let said = error(&mut render(&["model.fov", "--gaze", "0.5,0.5", "--detail", "1"]), 2);
    assert!(said.contains("--detail"), "{said}");
    std::fs::write(at.join("eye.csv"), "time_s,x,y\n0,0.5,0.5\n0.02,0.6,0.5\n").expect("it");
    let stream = ["model.fov", "--gaze-stream", "eye.csv", "--gaze-rate", "100"];
    render(&stream).assert().success();
    let slow = ["model.fov", "--gaze-stream", "eye.csv", "--gaze-rate", "5"];
    let said = error(&mut render(&slow), 3);
    assert!(said.contains("view 1") && said.contains("--gaze-gap"), "{said}");
    let said = error(
        program().current_dir(at).args(["scene", "compose"]).args([
            "L1.ply",
            "L3.ply",
            "L2.ply",
            "L4.ply",
            "-o",
            "wrong.fov",
        ]),
        3,
    );
    assert!(said.contains("of level 3 is not in level 2"), "{said}");
    assert!(!at.join("wrong.fov").exists());
    std::fs::write(at.join("cut.fov"), &std::fs::read(at.join("model.fov")).expect("it")[..99])
        .expect("it");
    error(&mut render(&["cut.fov", "--gaze", "0.5,0.5"]), 3);
}
