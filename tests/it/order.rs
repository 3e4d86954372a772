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

/// Pictures in the order that machines make, frame after frame of a path.
#[test]
fn pictures_in_an_order_are_compared_with_exact_ones() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path();
    let run = |arguments: &[&str]| drop(program(folder, arguments).assert().code(0));
    run(&["synth", "demo", "--points", "20000", "-o", "s.ply", "--cameras", "all.json", "-q"]);
    let path = ["camera", "convert", "--cameras", "all.json", "--path-frames", "200"];
    run(&[&path[..], &["-o", "path.json", "-q"]].concat());
    let views = ["render", "s.ply", "--cameras", "path.json", "--frames", "0..3"];
    let of = |order: &[&str]| {
        let words = [&views[..], &["--json", "--force", "-o", "views/", "--order"], order].concat();
        json(folder, &words)
    };
    let number = |found: &Value, view: usize, key: &str| found["images"][view][key].as_f64();
    let psnr = |found: &Value, view| number(found, view, "psnr_db").unwrap_or(f64::INFINITY);
    let [update, last, alone] =
        [&["update"][..], &["last"], &["shared", "--set", "gsu.margin=0"]].map(of);
    // The first frame has nothing to take over.
    for first in [&update, &last, &alone] {
        assert!(psnr(first, 0) > 60.0, "{first}");
    }
    assert!(psnr(&update, 2) > 50.0, "{update}");
    assert!(psnr(&update, 2) > psnr(&last, 2), "{update} {last}");
    // One frame of before is nearer than two.
    assert!(psnr(&last, 2) > psnr(&alone, 2), "{last} {alone}");
    assert_eq!(number(&update, 2, "missing_frac"), Some(0.0));
    assert!(number(&alone, 2, "missing_frac") > number(&last, 2, "missing_frac"));
    let margin = of(&["shared", "--set", "gsu.margin=16"]);
    assert!(psnr(&margin, 2) > psnr(&alone, 2), "{margin}");
    assert!(number(&margin, 2, "missing_frac") < number(&alone, 2, "missing_frac"));
    let keys = |bits: &str| psnr(&of(&["split", "--set", &format!("gsu.depth={bits}")]), 1);
    assert!(keys("fp16") > keys("bf16") + 3.0);
    let weighted = of(&["none", "--weight-power", "2"]);
    assert_eq!(weighted["weight_power"], 2.0);
    assert!(psnr(&of(&["none"]), 0) >= psnr(&weighted, 0));
    let refused = |arguments: &[&str], words: &[&str]| {
        let done = program(folder, &[&views[..], arguments].concat()).assert().code(2);
        let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    };
    refused(&["--order", "first", "-o", "v/"], &["gsu.impl", "first"]);
    refused(&["--order", "last", "--arch", "vorion", "-o", "v/"], &["vorion"]);
    refused(&["--order", "last", "-o", "v.png"], &["name a folder"]);
    refused(&["--set", "gsu.margin=3", "-o", "v/"], &["--order"]);
    refused(&["--order", "none", "--weight-power", "-1", "-o", "v/"], &["weight-power"]);
    assert!(!folder.join("v").exists());
}

/// Pictures whose pixels are moved from the frame before, or known by their first Gaussians.
#[test]
fn pictures_that_are_not_rendered_whole_are_compared_with_exact_ones() {
    let root = tempfile::tempdir().expect("a folder");
    let folder = root.path();
    let run = |arguments: &[&str]| drop(program(folder, arguments).assert().code(0));
    run(&["synth", "demo", "--points", "20000", "-o", "s.ply", "--cameras", "all.json", "-q"]);
    let path = ["camera", "convert", "--cameras", "all.json", "--path-frames", "400"];
    run(&[&path[..], &["-o", "path.json", "-q"]].concat());
    let views = ["render", "s.ply", "--cameras", "path.json", "--frames", "0..4"];
    let of = |more: &[&str]| {
        let words = [&views[..], &["--json", "--force", "-o", "views/", "--pixels"], more].concat();
        json(folder, &words)
    };
    let number = |found: &Value, view: usize, key: &str| found["images"][view][key].as_f64();
    let psnr = |found: &Value, view| number(found, view, "psnr_db").unwrap_or(f64::INFINITY);
    let warped = of(&["warped", "--set", "pixels.period=3"]);
    assert_eq!((warped["pixels"].as_str(), psnr(&warped, 0)), (Some("warped"), f64::INFINITY));
    for view in [1, 2] {
        assert!(psnr(&warped, view) > 25.0 && psnr(&warped, view) < 60.0, "{warped}");
        assert!(number(&warped, view, "rendered_frac") < Some(0.5), "{warped}");
    }
    // One in three is whole again.
    assert_eq!((psnr(&warped, 3), number(&warped, 3, "rendered_frac")), (f64::INFINITY, Some(1.0)));
    // Where every hole is rendered nothing is filled in.
    let strict = of(&["warped", "--set", "pixels.period=3", "--set", "pixels.holes=0"]);
    assert_eq!(number(&strict, 2, "filled_in_frac"), Some(0.0));
    assert!(psnr(&strict, 2) > psnr(&warped, 2), "{strict} {warped}");
    // The more Gaussians are asked for, the fewer pixels are known, and the better they are.
    let [few, many] = ["2", "12"].map(|ids| of(&["cached", "--set", &format!("pixels.ids={ids}")]));
    assert!(number(&many, 1, "rendered_frac") > number(&few, 1, "rendered_frac"));
    assert!(psnr(&many, 1) > psnr(&few, 1), "{few} {many}");
    // What a machine does with a path is what a replay of it says; of one frame it is refused.
    let extract = ["extract", "s.ply", "--cameras", "path.json", "--frames", "0..4", "-q"];
    run(&[&extract[..], &["-o", "path.bin"]].concat());
    let replay = ["replay", "path.bin", "--arch", "ls-gaussian", "--json", "-q"];
    let found = json(folder, &replay);
    let shares: Vec<f64> = (0..4)
        .map(|frame| found["frames"][frame]["pixels"]["rendered_frac"].as_f64().expect("a share"))
        .collect();
    assert!(shares[0] == 1.0 && shares[1..].iter().all(|share| *share < 1.0), "{shares:?}");
    let refused = |arguments: &[&str], words: &[&str]| {
        let done = program(folder, arguments).assert().code(2);
        let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    };
    refused(&[&replay[..], &["--frames", "0..1"]].concat(), &["pixels.period", "--path-frames"]);
    let pixels = |more: &[&str], word: &str| {
        refused(&[&views[..], &["-o", "v/", "--pixels"], more].concat(), &[word]);
    };
    pixels(&["all"], "leave --pixels out");
    pixels(&["sampled"], "samples are no picture");
    pixels(&["warped", "--order", "last"], "cannot be used with");
    pixels(&["warped", "--arch", "nebula"], "stereo.impl");
}
