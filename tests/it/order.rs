//! Models that are sorted when they are loaded: `extract --order`, `scene convert --order`.

use predicates::str::contains;
use serde_json::Value;

use super::headset::{json, program};

#[test]
fn traces_say_their_order_and_a_sorted_model_has_the_same_one() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path();
    let run = |arguments: &[&str]| drop(program(folder, arguments).assert().code(0));
    run(&["synth", "demo", "--points", "20000", "-o", "s.ply", "--cameras", "all.json", "-q"]);
    run(&["scene", "convert", "s.ply", "sorted.ply", "--order", "hilbert", "-q"]);
    let extract = |scene: &str, order: &[&str], to: &str| {
        let views = ["extract", scene, "--cameras", "all.json", "--frames", "0..2", "-q", "-o", to];
        run(&[&views[..], order].concat());
    };
    extract("s.ply", &[], "stored.bin");
    extract("s.ply", &["--order", "hilbert"], "hilbert.bin");
    extract("sorted.ply", &[], "converted.bin");
    let order =
        |trace: &str| json(folder, &["trace", "info", trace, "--json"])["storage_order"].clone();
    assert_eq!(
        ["stored.bin", "hilbert.bin", "converted.bin"].map(order),
        ["storage", "hilbert", "storage"]
    );
    program(folder, &["trace", "info", "hilbert.bin"])
        .assert()
        .stdout(contains("20000 Gaussians in hilbert order"));
    let replay = |trace: &str| json(folder, &["replay", trace, "--json", "-q"]);
    let [stored, hilbert, converted] = ["stored.bin", "hilbert.bin", "converted.bin"].map(replay);
    // The same addresses, told or not.
    assert_eq!(hilbert["frames"], converted["frames"]);
    let mean = |report: &Value, place: &str| {
        let value = report.pointer(&format!("/aggregate/{place}/mean"));
        value.and_then(Value::as_f64).unwrap_or_else(|| panic!("{place}"))
    };
    let pairs = "counters/tile_pairs";
    assert_eq!(mean(&stored, pairs), mean(&hilbert, pairs), "the same picture");
    let hits = "dram/row_hit_frac";
    assert!(mean(&hilbert, hits) > mean(&stored, hits), "neighbours lie in one row");
    program(folder, &["extract", "s.ply", "--orbit", "1", "--order", "random", "-o", "x.bin"])
        .assert()
        .code(2)
        .stderr(contains("storage, morton, hilbert, opacity"));
}
