//! Kinds of models: what trainers and exporters write beside, or instead of, INRIA's columns.

use powergs_scene::export::{Files, Target, write};
use powergs_scene::{Gaussians, OneFile, Warning, read};
use powergs_testkit::scene_files::{self as encode, sample};

use super::read_bytes;

/// A binary PLY with one row, all `float` but for colours; values by name.
fn ply(comments: &str, columns: &[(&str, f32)]) -> Vec<u8> {
    let mut head = format!("ply\nformat binary_little_endian 1.0\n{comments}element vertex 1\n");
    let mut row = Vec::new();
    for &(name, value) in columns {
        if ["red", "green", "blue"].contains(&name) {
            head += &format!("property uchar {name}\n");
            row.push(value as u8);
        } else {
            head += &format!("property float {name}\n");
            row.extend(value.to_le_bytes());
        }
    }
    let mut bytes = (head + "end_header\n").into_bytes();
    bytes.extend(row);
    bytes
}

const BODY: [(&str, f32); 8] = [
    ("x", 1.0),
    ("y", 2.0),
    ("z", 3.0),
    ("opacity", 0.5),
    ("rot_0", 1.0),
    ("rot_1", 0.0),
    ("rot_2", 0.0),
    ("rot_3", 0.0),
];
const SCALES: [(&str, f32); 3] = [("scale_0", -1.0), ("scale_1", -2.0), ("scale_2", -3.0)];
const DC: [(&str, f32); 3] = [("f_dc_0", 0.1), ("f_dc_1", 0.2), ("f_dc_2", 0.3)];

fn refusal(bytes: &[u8]) -> String {
    read_bytes(bytes).expect_err("no Gaussians").to_string()
}

#[test]
fn colours_stand_for_coefficients_of_degree_0() {
    let rgb = [("red", 0.0), ("green", 51.0), ("blue", 255.0)];
    let model = read_bytes(&ply("", &[&BODY[..], &SCALES, &rgb].concat())).unwrap();
    let want = [0.0, 0.2, 1.0].map(|c: f64| ((c - 0.5) / 0.282_094_791_773_878_14) as f32);
    assert_eq!((model.gaussians.sh_degree, model.gaussians.sh), (0, want.to_vec()));
    assert_eq!(model.warnings, []);
}

#[test]
fn two_scales_make_flat_gaussians() {
    for comment in ["", "comment SplatRenderMode: mip\n"] {
        let model = read_bytes(&ply(comment, &[&BODY[..], &SCALES[..2], &DC].concat())).unwrap();
        assert_eq!(model.gaussians.log_scales, [[-1.0, -2.0, -20.0]]);
        assert_eq!(model.warnings, [Warning::Flat]);
        assert!(!model.gaussians.antialiased, "columns weigh more than a comment");
    }
    let tagged = ply("comment SplatRenderMode: 2dgs\n", &[&BODY[..], &SCALES, &DC].concat());
    assert_eq!(read_bytes(&tagged).unwrap().warnings, [Warning::Flat]);
}

/// Variances add, and the opacity falls by the root of the ratio of the determinants.
#[test]
fn the_3d_filter_is_folded_in() {
    let plain = read_bytes(&ply("", &[&BODY[..], &SCALES, &DC].concat())).unwrap().gaussians;
    let of = |filter: f32| {
        let columns = [&BODY[..], &SCALES, &DC, &[("filter_3D", filter)]].concat();
        read_bytes(&ply("", &columns)).unwrap()
    };
    assert_eq!(of(0.0).gaussians, plain);
    let model = of(0.25);
    assert_eq!(model.warnings, [Warning::Filter3d]);
    let (mut own, mut wide) = (1.0f64, 1.0f64);
    for (axis, scale) in model.gaussians.log_scales[0].iter().enumerate() {
        let before = f64::from(plain.log_scales[0][axis]).exp();
        let after = f64::from(*scale).exp();
        assert!((after.powi(2) - before.powi(2) - 0.0625).abs() < 1e-6, "{before} {after}");
        (own, wide) = (own * before, wide * after);
    }
    let sigmoid = |logit: f32| 1.0 / (1.0 + (-f64::from(logit)).exp());
    let want = sigmoid(0.5) * own / wide;
    assert!((sigmoid(model.gaussians.logit_opacities[0]) - want).abs() < 1e-6);
}

#[test]
fn relatives_are_refused_by_their_names() {
    let columns: Vec<(String, f32)> = (0..30).map(|i| (format!("f_offset_{i}"), 0.0)).collect();
    let offsets: Vec<(&str, f32)> = columns.iter().map(|(n, v)| (n.as_str(), *v)).collect();
    let error = refusal(&ply("", &[&BODY[..], &SCALES, &offsets].concat()));
    assert!(error.contains("Scaffold-GS"), "{error}");
    let points = [("x", 0.0), ("y", 0.0), ("z", 0.0), ("red", 1.0), ("green", 1.0), ("blue", 1.0)];
    let error = refusal(&ply("", &points));
    assert!(error.contains("point cloud"), "{error}");
}

#[test]
fn columns_that_are_not_read_are_named() {
    let more = [("nx", 0.0), ("t", 0.5), ("scale_t", 1.0), ("red", 3.0)];
    let model = read_bytes(&ply("", &[&BODY[..], &SCALES, &DC, &more].concat())).unwrap();
    let names = vec!["t".to_owned(), "scale_t".to_owned()];
    assert_eq!(model.warnings, [Warning::IgnoredColumns { names }]);
}

/// An exporter that stores opacities of 0 to 1 and scales above 0: in every format.
#[test]
fn activated_parameters_are_warned_of() {
    let mut scene = sample(40, 0);
    scene.logit_opacities.iter_mut().for_each(|o| *o = 0.02 * o.abs() + 0.5);
    scene.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s = s.exp());
    for target in Target::ALL {
        let Files::One(bytes) = write(&scene, target).unwrap().files else { continue };
        let warnings = read_bytes(&bytes).unwrap().warnings;
        assert_eq!(warnings, [Warning::Activated], "{target:?}");
    }
    // What is neither makes it a model; a tenth of it is no mistake.
    let mut model = sample(40, 0);
    model.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s = s.exp());
    model.log_scales[..16].fill([-0.1; 3]);
    assert_eq!(read_bytes(&encode::ply(&model)).unwrap().warnings, []);
}

#[test]
fn ends_of_ranges_are_kept_in_every_format() {
    let mut scene = sample(4, 0);
    scene.logit_opacities[..2].copy_from_slice(&[f32::INFINITY, f32::NEG_INFINITY]);
    scene.log_scales[2] = [-1.0, f32::NEG_INFINITY, f32::NEG_INFINITY];
    let model = read_bytes(&encode::ply(&scene)).unwrap();
    assert_eq!(model.warnings, [Warning::NonPositiveScales { count: 1 }]);
    let read = model.gaussians;
    let opacity = |i: usize| 1.0 / (1.0 + (-read.logit_opacities[i]).exp());
    assert_eq!((read.len(), opacity(0)), (4, 1.0));
    assert!(opacity(1) < 1e-6);
    assert_eq!(read.log_scales[2], [-1.0, 1e-12_f32.ln(), 1e-12_f32.ln()]);
    let mut rows = encode::splat(&sample(20, 0));
    rows[16..20].copy_from_slice(&(-1.0_f32).to_le_bytes());
    let model = read_bytes(&rows).unwrap();
    assert_eq!(model.warnings, [Warning::NonPositiveScales { count: 1 }]);
    assert_eq!(model.gaussians.log_scales[0][1], 1e-12_f32.ln());
}

#[test]
fn comments_say_that_a_model_is_antialiased() {
    for (comments, is) in [
        ("comment SplatRenderMode: mip\n", true),
        ("comment by Brush\ncomment SPLATRENDERMODE:  Mip \ncomment SH degree: 0\n", true),
        ("comment antialiased 1\n", true),
        ("comment antialiased 0\n", false),
        ("comment SplatRenderMode: default\n", false),
        ("comment SplatRenderMode: default\ncomment antialiased 1\n", true),
        ("comment antialiased 1\ncomment SplatRenderMode: default\n", false),
        ("comment not antialiased 1\n", false),
    ] {
        let model = read_bytes(&ply(comments, &[&BODY[..], &SCALES, &DC].concat())).unwrap();
        assert_eq!(model.gaussians.antialiased, is, "{comments}");
        assert_eq!(model.warnings.contains(&Warning::Antialiased), is, "{comments}");
    }
}

/// What is written says so again, in every format.
#[test]
fn the_tag_of_an_antialiased_model_is_kept() {
    for is in [true, false] {
        let scene = Gaussians { antialiased: is, ..sample(40, 1) };
        for target in Target::ALL {
            let model = match write(&scene, target).unwrap().files {
                Files::One(bytes) => read(&OneFile(&bytes), "file", None),
                Files::Folder(files) => read(&files, "meta.json", None),
            };
            let model = model.unwrap();
            assert_eq!(model.gaussians.antialiased, is, "{target:?}");
            assert_eq!(model.warnings.contains(&Warning::Antialiased), is, "{target:?}");
        }
    }
}
