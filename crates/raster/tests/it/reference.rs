//! Frozen reference vectors (`tests/data/README.md`).

use fearless_simd::Level;
use powergs_frame::splat::project::colours;
use powergs_frame::splat::{Cover, Intersection, TileGrid};
use powergs_raster::{Detail, Options, Rendered, render};
use powergs_scene::Gaussians;
use powergs_testkit::scenes::{camera, floats, forward_input, ints, load, rows};
use serde_json::Value;

fn forward_case() -> (Value, Gaussians, Rendered) {
    let (case, scene, camera, background) = forward_input();
    let options = Options { background, ..Options::reference(Detail::Dominance) };
    let rendered = render(&scene, &camera, &options);
    (case, scene, rendered)
}

/// A per-splat column by scene index; splats that are not visible count zero.
fn by_index(rendered: &Rendered, n: usize, value: impl Fn(usize) -> u32) -> Vec<u32> {
    let mut out = vec![0; n];
    for (rank, splat) in rendered.splats.iter().enumerate() {
        out[splat.index as usize] = value(rank);
    }
    out
}

#[test]
fn projected_geometry_matches() {
    let (case, scene, rendered) = forward_case();
    let geometry = &case["geometry_f64"];
    let (means, conics) = (rows::<2>(&geometry["mean2d"]), rows::<3>(&geometry["conic"]));
    assert!(rendered.splats.len() > 100, "most of {} are visible", scene.len());
    for splat in &rendered.splats {
        let i = splat.index as usize;
        for (got, want) in splat.mean.iter().zip(means[i]) {
            // f32 against f64: pixel coordinates up to about 100 carry 1e-5.
            assert!((got - want).abs() < 2e-4, "mean of {i}");
        }
        let conic = splat.conic().unwrap();
        for k in 0..3 {
            let scale = conics[i][0].abs().max(conics[i][2].abs());
            assert!((conic[k] - conics[i][k]).abs() < 2e-5 * scale, "conic of {i}");
        }
    }
}

#[test]
fn image_matches() {
    let (case, _, rendered) = forward_case();
    let expected = floats(&case["correct_obb"]["image"]);
    let got: Vec<f64> = if expected.len() == rendered.picture.pixels.len() * 3 {
        rendered.picture.pixels.iter().flatten().map(|&v| f64::from(v)).collect()
    } else {
        panic!("{} values", expected.len())
    };
    let chw: Vec<f64> = (0..3).flat_map(|c| got.iter().skip(c).step_by(3).copied()).collect();
    let worst =
        |a: &[f64]| a.iter().zip(&expected).map(|(x, y)| (x - y).abs()).fold(0.0f64, f64::max);
    let difference = worst(&got).min(worst(&chw));
    assert!(difference < 2e-5, "worst difference {difference}");
}

#[test]
fn counters_match_exactly() {
    let (case, scene, rendered) = forward_case();
    let want = &case["correct_obb"];
    let n = scene.len();
    let survivors: Vec<u32> =
        (0..n).map(|i| u32::from(rendered.survivor_bits[i / 8] >> (i % 8) & 1)).collect();
    let points = &want["point_statistics"];
    assert_eq!(survivors, ints(&points[0]), "Pcull");
    let column = |f: &dyn Fn(usize) -> u32| by_index(&rendered, n, f);
    assert_eq!(column(&|r| rendered.touches[r].tiles), ints(&points[1]), "N_inter");
    assert_eq!(column(&|r| u32::from(rendered.touches[r].tiles > 0)), ints(&points[2]), "P_inter");
    assert_eq!(column(&|r| u32::from(rendered.fetches[r] > 0)), ints(&points[3]), "P_used");
    assert_eq!(column(&|r| rendered.touches[r].tests), ints(&points[4]), "P_obb_count");
    assert_eq!(column(&|r| rendered.fetches[r]), ints(&want["intersect_count"]));
    assert_eq!(column(&|r| rendered.dominance[r]), ints(&want["dominance_count"]));
    let pixels = &want["pixel_statistics"];
    assert_eq!(rendered.iterated, ints(&pixels[2]), "T_bf_term");
    assert_eq!(rendered.pixels.blended, ints(&pixels[3]), "T_used");
    let (t_inter, t_load) = (ints(&pixels[0]), ints(&pixels[1]));
    let width = rendered.picture.width as usize;
    for (i, (inter, load)) in t_inter.iter().zip(&t_load).enumerate() {
        let tile = (i / width / 16) * width.div_ceil(16) + (i % width) / 16;
        assert_eq!(rendered.tiles[tile].entries, *inter, "T_inter of pixel {i}");
        assert_eq!(rendered.tiles[tile].loaded, *load, "T_load of pixel {i}");
    }
}

#[test]
fn isotropic_boxes_touch_the_right_tiles() {
    let v = load("obb_isotropic.json");
    let n = v["means"].as_array().unwrap().len();
    let scene = Gaussians {
        means: rows(&v["means"]),
        log_scales: rows::<3>(&v["scales"]).iter().map(|s| s.map(f32::ln)).collect(),
        rotations: rows(&v["quats"]),
        logit_opacities: vec![0.0; n],
        sh: vec![0.0; 3 * n],
        ..Gaussians::default()
    };
    let tan = ["tanfovx", "tanfovy"].map(|k| v[k].as_f64().unwrap());
    let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let camera = camera(96, 80, tan, &identity);
    let rendered = render(&scene, &camera, &Options::reference(Detail::Image));
    let grid = TileGrid::new(96, 80, 16);
    let mut tiles = vec![Vec::new(); n];
    for splat in &rendered.splats {
        for row in Cover::new(splat, grid, Intersection::Obb).rows() {
            tiles[splat.index as usize].extend((row.x0..row.x1).map(|x| row.y * 6 + x));
        }
    }
    for (i, expected) in v["tiles_correct"].as_array().unwrap().iter().enumerate() {
        assert_eq!(tiles[i], ints(expected), "tiles of splat {i}");
    }
}

#[test]
fn spherical_harmonics_match() {
    let v = load("spherical_harmonics.json");
    for case in v["cases"].as_array().unwrap() {
        let degree = case["degree"].as_u64().unwrap() as u8;
        let used = (degree as usize + 1).pow(2);
        let dirs = rows::<3>(&case["dirs"]);
        let sh = floats(&case["sh"]);
        let expected = rows::<3>(&case["color"]);
        for (i, dir) in dirs.iter().enumerate() {
            let scene = Gaussians {
                means: vec![dir.map(|d| d * 5.0)],
                log_scales: vec![[-3.0; 3]],
                rotations: vec![[1.0, 0.0, 0.0, 0.0]],
                logit_opacities: vec![10.0],
                sh_degree: degree,
                sh: (0..3)
                    .flat_map(|c| sh[(i * 3 + c) * 16..][..used].iter().map(|&x| x as f32))
                    .collect(),
                antialiased: false,
            };
            let colour = colours(&scene, [0.0; 3], Level::new());
            for c in 0..3 {
                let difference = (colour[0][c] - expected[i][c]).abs();
                assert!(difference < 1e-6, "degree {degree} direction {i}: {difference}");
            }
        }
    }
}
