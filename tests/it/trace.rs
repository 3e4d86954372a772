//! `trace info`, `verify`, `dump`, `repair`: output, exit codes, files.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use powergs_sim::trace::Frame;
use powergs_testkit::traces::{SMALL, Shape, frame, read_all, written};
use serde_json::Value;

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}

fn frames() -> Vec<Frame> {
    (0..14).map(|k| frame(k, Shape { foveated: k == 0, ..SMALL })).collect()
}

/// Runs `trace` and returns standard output and standard error.
#[track_caller]
fn trace(code: i32, verb: &str, file: &Path, rest: &[&str]) -> (String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_powergs-sim"));
    let output = command.args(["trace", verb]).arg(file).args(rest).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let (out, err) = (text(output.stdout), text(output.stderr));
    assert_eq!(output.status.code(), Some(code), "{out}{err}");
    (out, err)
}

#[test]
fn info_fits_80_columns_and_agrees_with_json() {
    let folder = Folder::new();
    let mut list = frames();
    list[1].facts.camera.name = "a very long name of a view \u{1b}[31m".into();
    for (k, eye) in [(2, "left"), (3, "right")] {
        list[k].facts.camera.name = format!("20240212_003919.jpg_{eye}");
    }
    let bytes = written(&list);
    let file = folder.file("t.bin", &bytes);
    let (text, _) = trace(0, "info", Path::new(&file), &[]);
    for line in text.lines().filter(|l| !l.starts_with("file")) {
        assert!(line.chars().count() <= 80, "{line}");
    }
    for eye in ["left", "right"] {
        let is_shown = |line: &str| line.contains("2024021") && line.contains(&format!("_{eye} "));
        assert!(text.lines().any(is_shown), "cut at its end: {text}");
    }
    assert!(text.contains("frames      14, 1 of them foveated"), "{text}");
    assert!(text.contains("... 2 frames more: --all") && !text.contains('\u{1b}'), "{text}");
    let (all, _) = trace(0, "info", &file, &["--all"]);
    assert_eq!(all.lines().count(), text.lines().count() + 1);
    let (json, _) = trace(0, "info", &file, &["--json"]);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["bytes"], bytes.len());
    assert_eq!((json["frame_count"].as_u64(), json["points"].as_u64()), (Some(14), Some(21)));
    let first = &json["frames"][0];
    assert_eq!(first["visible_splats"], 9);
    let parts = ["splat_bytes", "pixel_bytes", "other_bytes"];
    let sum: u64 = parts.iter().map(|p| first[p].as_u64().unwrap()).sum();
    assert_eq!(first["bytes"], sum);
    assert_eq!(first["columns"]["depth"]["raw_bytes"], 36);
}

#[test]
fn an_empty_trace_has_information_too() {
    let folder = Folder::new();
    let file = folder.file("t.bin", &written(&[]));
    assert!(trace(0, "info", &file, &[]).0.contains("frames      0"));
    assert!(trace(0, "info", &file, &["--json"]).0.contains("\"mean\": null"));
    assert!(trace(0, "verify", &file, &[]).0.contains("good: 0 frames"));
    assert!(trace(2, "dump", &file, &["--frame", "0"]).1.contains("has 0 frames"));
}

#[test]
fn verify_lists_damage_and_repair_keeps_the_rest() {
    let folder = Folder::new();
    let list = frames();
    let good = written(&list);
    let file = folder.file("good.bin", &good);
    assert!(trace(0, "verify", &file, &[]).0.contains("good: 14 frames"));
    let mut bad = good.clone();
    let middle = good.len() / 2;
    bad[middle] ^= 1;
    let file = folder.file("bad.bin", &bad);
    let (text, _) = trace(3, "verify", &file, &[]);
    assert!(text.contains("  byte ") && text.contains("13 of 14 frames intact"), "{text}");
    let (json, _) = trace(3, "verify", &file, &["--json"]);
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["good"], &json["frames_intact"]), (&Value::Bool(false), &Value::from(13)));
    let new = folder.path("new.bin");
    let (text, _) = trace(0, "repair", &file, &["-o", new.to_str().unwrap()]);
    assert!(text.contains("13 of 14 frames kept"), "{text}");
    let kept = read_all(&std::fs::read(&new).unwrap()).unwrap();
    assert_eq!(kept.len(), 13);
    assert!(kept.iter().all(|f| list.contains(f)));
}

#[test]
fn an_incomplete_trace_is_refused_and_can_be_repaired() {
    let folder = Folder::new();
    let good = written(&frames());
    let file = folder.file("cut.bin", &good[..good.len() - 40]);
    for verb in ["info", "dump"] {
        let rest: &[&str] = if verb == "dump" { &["--frame", "0"] } else { &[] };
        let (out, err) = trace(3, verb, &file, rest);
        assert!(err.contains("INCOMPLETE") && err.contains("14 whole frames"), "{err}");
        assert!(err.contains("cut.bin") && out.is_empty());
    }
    let new = folder.path("new.bin");
    trace(0, "repair", &file, &["-o", new.to_str().unwrap()]);
    assert_eq!(std::fs::read(&new).unwrap(), good);
    let nothing = folder.file("none.bin", &good[..90]);
    let other = folder.path("other.bin");
    let (_, err) = trace(3, "repair", &nothing, &["-o", other.to_str().unwrap()]);
    assert!(err.contains("no frame is intact"), "{err}");
    assert_eq!(std::fs::read_dir(folder.0.path()).unwrap().count(), 3, "nothing half written");
    assert!(trace(3, "info", &folder.path("absent.bin"), &[]).1.contains("absent.bin"));
}

#[test]
fn dump_writes_every_value() {
    let folder = Folder::new();
    let list = frames();
    let file = folder.file("t.bin", &written(&list));
    let (csv, _) = trace(0, "dump", &file, &["--frame", "0"]);
    let mut rows = csv::Reader::from_reader(csv.as_bytes());
    assert_eq!(rows.headers().unwrap().get(4), Some("mean_y_px"));
    for (row, splat) in rows.records().map(Result::unwrap).zip(&list[0].splats) {
        let floats: Vec<f32> = row.iter().skip(2).map(|v| v.parse().unwrap()).collect();
        let ([x, y], [a, b, d]) = (splat.mean, splat.cov);
        assert_eq!(floats[..7], [splat.depth, x, y, a, b, d, splat.opacity]);
    }
    let (csv, _) = trace(0, "dump", &file, &["--frame", "1", "--what", "pixels"]);
    assert_eq!(csv.lines().next(), Some("x_px,y_px,stop_rank,blended"));
    assert_eq!(csv.lines().count(), 1 + 15);
    let out = folder.path("facts.csv");
    let flags = ["--frame", "0", "--what", "facts", "-o", out.to_str().unwrap()];
    trace(0, "dump", &file, &flags);
    let facts = std::fs::read_to_string(&out).unwrap();
    assert!(facts.contains("fx_px,100.5\n") && facts.contains("gaze_x,0.25\n"), "{facts}");
    trace(2, "dump", &file, &["--frame", "14"]);
    trace(2, "dump", &file, &["--frame", "0", "--json"]);
}
