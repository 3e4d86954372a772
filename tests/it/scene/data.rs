//! Real models: against statistics that another program measured, and against each other.

use std::path::Path;

use powergs_sim::scene::SceneStats;
use powergs_sim::scene::files::{OpenedModel, open_model};
use powergs_sim::scene::stats::Percentiles;
use powergs_testkit::data;
use powergs_testkit::difference::difference;
use serde_json::Value;

fn open(path: &Path, lod: Option<u32>) -> OpenedModel {
    open_model(path, lod).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The statistics are rounded to three decimals.
const ROUNDING: f64 = 0.000_501;

fn check(stats: &SceneStats, expected: &Value, flipped: bool) {
    let number = |key: &str| expected[key].as_f64().expect("a number");
    let list = |key: &str| -> Vec<f64> {
        expected[key].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    };
    assert_eq!(stats.points as f64, number("n"));
    assert_eq!(f64::from(stats.sh_degree), number("shdeg"));
    let close = |what: &str, found: f64, expected: f64| {
        assert!((found - expected).abs() <= ROUNDING, "{what}: {found} instead of {expected}");
    };
    let (min, max) = (list("bbox_min"), list("bbox_max"));
    let (p1, p99) = (list("bbox_p1"), list("bbox_p99"));
    for axis in 0..3 {
        // The other program leaves SPZ in its own axes.
        let (sign, [min, max], [p1, p99]) = if flipped && axis > 0 {
            (-1.0, [max[axis], min[axis]], [p99[axis], p1[axis]])
        } else {
            (1.0, [min[axis], max[axis]], [p1[axis], p99[axis]])
        };
        close("lowest", f64::from(stats.bounds.min[axis]), sign * min);
        close("highest", f64::from(stats.bounds.max[axis]), sign * max);
        close("1 %", stats.position[axis].p1, sign * p1);
        close("99 %", stats.position[axis].p99, sign * p99);
    }
    let opacities = list("opac_pct");
    let Percentiles { p1, p25, p50, p75, p99, .. } = stats.opacity;
    for (found, i) in [(p1, 0), (p25, 2), (p50, 3), (p75, 4), (p99, 6)] {
        close("opacity", found, opacities[i]);
    }
    let median = number("scale_med");
    assert!((stats.scale.p50 / median - 1.0).abs() < 0.01, "{} {median}", stats.scale.p50);
    let ratio = number("aniso_med");
    assert!((stats.axis_ratio.p50 / ratio - 1.0).abs() < 0.002, "{}", stats.axis_ratio.p50);
}

#[test]
fn counts_bounds_and_percentiles_are_those_of_another_reader() {
    let Some(data) = data() else { return };
    let sets = [
        ("playcanvas-biker", "biker.compressed.ply", "biker.compressed.ply", None),
        ("playcanvas-biker", "biker.spz", "biker.spz", None),
        ("playcanvas-logo", "", "sog", None),
        ("playcanvas-flowers", "", "lod2 (2_*)", Some(2)),
        ("playcanvas-flowers", "lod-meta.json", "lod3 (3_*)", Some(3)),
        ("playcanvas-playbot", "playbot_lod1_sh2.ply", "playbot_lod1_sh2.ply", None),
        ("playcanvas-playbot", "lod-meta.json", "lod3 (3_0)", Some(3)),
        ("playcanvas-playbot", "6_0/meta.json", "lod6 (6_0)", None),
        ("snowmiku-posed", "point_cloud.ply", "point_cloud.ply", None),
        ("fox-posed", "point_cloud.ply", "point_cloud.ply", None),
    ];
    for (set, file, key, lod) in sets {
        let folder = data.join(set);
        let scene = open(&folder.join(file), lod);
        let (stats, _) = SceneStats::of(&scene.gaussians);
        let all = std::fs::read_to_string(folder.join("stats.json")).unwrap();
        let all: Value = serde_json::from_str(&all).unwrap();
        assert!(all[key]["n"].is_number(), "{set}: no {key} in stats.json");
        check(&stats, &all[key], scene.format.starts_with("spz"));
    }
}

#[test]
fn two_encodings_of_the_biker_agree() {
    let Some(data) = data() else { return };
    let folder = data.join("playcanvas-biker");
    let mut ply = open(&folder.join("biker.compressed.ply"), None).gaussians;
    let spz = open(&folder.join("biker.spz"), None).gaussians;
    // SPZ stores logarithmic scales from -10 on, in steps of 1/16.
    ply.log_scales.iter_mut().for_each(|s| *s = s.map(|v| v.max(-10.0)));
    let found = difference(&ply, &spz);
    // The same Gaussians in the same order. Means have 12 bits after the point, rotations 9 to 10
    // bits in both files, colours steps of 1/255/0.15, opacities the same byte.
    assert!(found.mean <= 0.501 / 4096.0, "{found:?}");
    assert!(found.log_scale <= 0.501 / 16.0, "{found:?}");
    assert!(found.rotation <= 1.0 / 511.0, "{found:?}");
    assert!(found.opacity < 1e-6, "{found:?}");
    assert!(found.dc <= 0.501 / 255.0 / 0.15, "{found:?}");
}

#[test]
fn a_converted_ply_and_its_sog_are_the_same_model() {
    let Some(data) = data() else { return };
    let folder = data.join("playcanvas-playbot");
    let ply = open(&folder.join("playbot_lod1_sh2.ply"), None).gaussians;
    let sog = open(&folder.join("1_0"), None).gaussians;
    // The same bytes decoded by two programs: rounding of single precision only.
    let found = difference(&ply, &sog);
    assert!(found.mean < 1e-6 && found.log_scale < 1e-5 && found.rotation < 1e-6, "{found:?}");
    assert!(found.opacity < 1e-6 && found.dc < 1e-6 && found.rest < 1e-6, "{found:?}");
}
