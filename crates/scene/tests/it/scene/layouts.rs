//! PLY as people write it, and what the boundary does with bad parameters.

use powergs_scene::{Gaussians, SceneStats, Warning};
use powergs_testkit::scene_files::{self as encode, sample};

use super::read_bytes;

/// A PLY with one row of the given columns.
fn ply_of(columns: &[(&str, &str, f64)], encoding: &str) -> Vec<u8> {
    let mut bytes = format!("ply\r\nformat {encoding} 1.0\r\ncomment by a test\r\n").into_bytes();
    bytes.extend(b"element vertex 1\r\n");
    for (kind, name, _) in columns {
        bytes.extend(format!("property {kind} {name}\r\n").into_bytes());
    }
    bytes.extend(b"end_header\r\n");
    for (kind, _, value) in columns {
        match (*kind, encoding) {
            ("float", "binary_big_endian") => bytes.extend((*value as f32).to_be_bytes()),
            ("double", "binary_big_endian") => bytes.extend(value.to_be_bytes()),
            ("double", _) => bytes.extend(value.to_le_bytes()),
            ("uchar", _) => bytes.push(*value as u8),
            ("short", "binary_big_endian") => bytes.extend((*value as i16).to_be_bytes()),
            ("short", _) => bytes.extend((*value as i16).to_le_bytes()),
            _ => bytes.extend((*value as f32).to_le_bytes()),
        }
    }
    bytes
}

/// The columns that a model needs, in an unusual order, with types and columns of all kinds.
const COLUMNS: [(&str, &str, f64); 16] = [
    ("float", "rot_0", 1.0),
    ("uchar", "segment", 7.0),
    ("float", "rot_1", 0.0),
    ("float", "rot_2", 0.0),
    ("float", "rot_3", 0.0),
    ("double", "x", 1.5),
    ("double", "y", -2.5),
    ("short", "z", -3.0),
    ("float", "opacity", 0.25),
    ("float", "scale_2", -3.0),
    ("float", "scale_1", -2.0),
    ("float", "scale_0", -1.0),
    ("float", "f_dc_2", 0.3),
    ("float", "f_dc_0", 0.1),
    ("float", "f_dc_1", 0.2),
    ("uchar", "red", 255.0),
];

#[test]
fn columns_are_found_by_name_in_any_order_type_and_byte_order() {
    for encoding in ["binary_little_endian", "binary_big_endian"] {
        let scene = read_bytes(&ply_of(&COLUMNS, encoding)).unwrap().gaussians;
        let expected = Gaussians {
            means: vec![[1.5, -2.5, -3.0]],
            log_scales: vec![[-1.0, -2.0, -3.0]],
            rotations: vec![[1.0, 0.0, 0.0, 0.0]],
            logit_opacities: vec![0.25],
            sh_degree: 0,
            sh: vec![0.1, 0.2, 0.3],
            antialiased: false,
        };
        assert_eq!(scene, expected);
    }
}

#[test]
fn a_missing_column_is_named() {
    for missing in ["x", "opacity", "scale_1", "rot_3", "f_dc_2"] {
        let columns: Vec<_> = COLUMNS.into_iter().filter(|c| c.1 != missing).collect();
        let error = read_bytes(&ply_of(&columns, "binary_little_endian")).unwrap_err().to_string();
        assert!(error.contains(&format!("no property `{missing}`")), "{error}");
    }
}

#[test]
fn an_odd_number_of_sh_columns_is_refused() {
    let mut columns = COLUMNS.to_vec();
    columns.push(("float", "f_rest_0", 0.0));
    let error = read_bytes(&ply_of(&columns, "binary_little_endian")).unwrap_err().to_string();
    assert!(error.contains("1 f_rest properties"), "{error}");
}

#[test]
fn elements_before_the_vertices_are_skipped() {
    let plain = ply_of(&COLUMNS, "binary_little_endian");
    let at = |needle: &[u8]| plain.windows(needle.len()).position(|w| w == needle).unwrap();
    let (element, data) = (at(b"element"), at(b"end_header\r\n") + 12);
    let camera = b"element camera 2\nproperty list uchar short ids\nproperty double f\n";
    let mut rows = Vec::new();
    for ids in [&[1_i16, 2, 3][..], &[]] {
        rows.push(ids.len() as u8);
        ids.iter().for_each(|id| rows.extend(id.to_le_bytes()));
        rows.extend(1.0_f64.to_le_bytes());
    }
    let parts = [&plain[..element], camera, &plain[element..data], &rows, &plain[data..]];
    assert_eq!(
        read_bytes(&parts.concat()).unwrap().gaussians,
        read_bytes(&plain).unwrap().gaussians
    );
}

#[test]
fn ascii_errors_name_the_row() {
    let text = String::from_utf8(encode::ascii_ply(&sample(3, 0))).unwrap();
    let last = text.trim_end().rfind('\n').unwrap();
    let broken = format!("{}\n1 2 three\n", &text[..last]);
    let error = read_bytes(broken.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("row 2") && error.contains("three"), "{error}");
    let short = format!("{}\n1 2 3\n", &text[..last]);
    let error = read_bytes(short.as_bytes()).unwrap_err().to_string();
    assert!(error.contains("row 2: 3 values for 17 columns"), "{error}");
}

#[test]
fn unusable_gaussians_are_dropped_and_counted() {
    let mut scene = sample(10, 1);
    let expected = {
        let mut rest = scene.clone();
        for i in [7, 5, 4, 3, 2] {
            rest.means.remove(i);
            rest.log_scales.remove(i);
            rest.rotations.remove(i);
            rest.logit_opacities.remove(i);
            rest.sh.drain(12 * i..12 * (i + 1));
        }
        rest
    };
    scene.means[2][1] = f32::NAN;
    scene.log_scales[3][0] = f32::INFINITY;
    scene.rotations[4][3] = f32::NEG_INFINITY;
    scene.logit_opacities[5] = f32::NAN;
    scene.sh[12 * 7 + 11] = 1e30;
    for bytes in [encode::ply(&scene), encode::ascii_ply(&scene)] {
        let model = read_bytes(&bytes).unwrap();
        assert_eq!(model.gaussians, expected);
        assert_eq!(model.warnings, [Warning::Dropped { count: 5, first: 2 }]);
    }
}

#[test]
fn a_model_without_one_usable_gaussian_is_refused() {
    let mut scene = sample(4, 0);
    scene.logit_opacities.fill(f32::NAN);
    let error = read_bytes(&encode::ply(&scene)).unwrap_err().to_string();
    assert!(error.contains("none of the 4 Gaussians"), "{error}");
}

#[test]
fn zero_quaternions_become_identity() {
    let mut scene = sample(4, 0);
    scene.rotations[1] = [0.0; 4];
    scene.rotations[3] = [1e-20; 4];
    let model = read_bytes(&encode::ply(&scene)).unwrap();
    assert_eq!(model.gaussians.rotations[1], [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(model.gaussians.rotations[3], [1.0, 0.0, 0.0, 0.0]);
    assert_eq!(model.warnings, [Warning::ZeroQuaternions { count: 2, first: 1 }]);
}

#[test]
fn splat_rows_with_a_scale_of_zero() {
    let mut bytes = encode::splat(&sample(20, 0));
    bytes[12..16].fill(0);
    let model = read_bytes(&bytes).unwrap();
    assert_eq!(model.warnings, [Warning::NonPositiveScales { count: 1 }]);
    assert!((model.gaussians.log_scales[0][0] - 1e-12_f32.ln()).abs() < 1e-4);
}

#[test]
fn statistics_of_a_model_counted_by_hand() {
    let mut scene = sample(4, 0);
    scene.means = vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 4.0, 0.0]];
    scene.log_scales = vec![[0.0, -3.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 0.5]];
    scene.logit_opacities = vec![-6.0, -1.0, 0.0, 1.0];
    scene.rotations[2] = [2.0, 0.0, 0.0, 0.0];
    let (stats, oddities) = SceneStats::of(&scene);
    assert_eq!((stats.points, stats.sh_degree, stats.memory_bytes), (4, 0, 4 * 14 * 4));
    assert_eq!((stats.bounds.min, stats.bounds.max), ([0.0; 3], [3.0, 4.0, 0.0]));
    assert_eq!(stats.share_opacity_below_0_35, 0.5);
    // Two are elongated; the first is a disc, the third a needle.
    assert_eq!(stats.share_axis_ratio_at_least_3, 0.5);
    assert_eq!(stats.share_needles_at_least_3, 0.25);
    // x is 0, 1, 2, 3: halfway for the median, a quarter of the way from 0 to 3 for p25.
    assert_eq!((stats.position[0].p50, stats.position[0].p25), (1.5, 0.75));
    // e^2 = 7.4 exceeds the diagonal of 5; logistic(-6) is below 1/255.
    let expected = [
        Warning::Unnormalised { count: 1 },
        Warning::AbsurdScales { count: 1 },
        Warning::Invisible { count: 1 },
    ];
    assert_eq!(oddities, expected);
}
