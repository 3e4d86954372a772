//! Lenses: their formulas, and what is left of a photo without one.

use powergs_scene::Camera;
use powergs_scene::camera::lens::{LEAST_SHARE, Lens, without_lens};
use powergs_scene::camera::{colmap, json};

/// The camera and the lens of a COLMAP camera.
fn of_colmap(model: &str) -> (Camera, Option<Lens>) {
    let image = "1 1 0 0 0 0 0 0 1 a.png\n\n";
    let file = colmap::read_text(format!("1 {model}\n").as_bytes(), image.as_bytes()).unwrap();
    (file.cameras[0].clone(), file.lenses.get("a.png").copied())
}

#[test]
fn every_model_bends_as_its_formula_says() {
    // Of the ray (0.43, -0.31), by the formulas of COLMAP written out in another language.
    let (k, rest) = ("-0.12 0.03", "0.002 -0.0015");
    let all = [
        ("SIMPLE_RADIAL", "-0.12".to_owned(), [0.4155004, -0.2995468]),
        ("RADIAL", "-0.12 0".into(), [0.4155004, -0.2995468]),
        ("OPENCV", format!("{k} {rest}"), [0.4150095969, -0.2989348373]),
        (
            "FULL_OPENCV",
            format!("{k} {rest} -0.01 0.02 0.005 -0.003"),
            [0.41245184711213373, -0.29709087815060803],
        ),
        ("OPENCV_FISHEYE", format!("{k} -0.01 0.02"), [0.3847622681596181, -0.27738675146391073]),
        ("FOV", "0.9".into(), [0.42659230321909336, -0.30754328836725336]),
        (
            "THIN_PRISM_FISHEYE",
            format!("{k} {rest} -0.01 0.02 0.001 -0.002"),
            [0.3837236355437535, -0.2767236127789363],
        ),
    ];
    for (model, coefficients, expected) in all {
        let focal = if model.ends_with("RADIAL") { "500" } else { "500 500" };
        let lens = of_colmap(&format!("{model} 640 480 {focal} 320 240 {coefficients}")).1;
        let bent = lens.unwrap().bent([0.43, -0.31]);
        for (got, wanted) in bent.into_iter().zip(expected) {
            assert!((got - wanted).abs() < 1e-12, "{model}: {bent:?}, {expected:?}");
        }
    }
    // The same polynomial of the angle under two names.
    let simple = of_colmap("SIMPLE_RADIAL_FISHEYE 640 480 500 320 240 -0.1").1;
    let radial = of_colmap("RADIAL_FISHEYE 640 480 500 320 240 -0.1 0").1;
    assert_eq!(simple, Some(Lens::Fisheye([-0.1, 0.0, 0.0, 0.0])));
    assert_eq!(simple, radial);
    // Lenses without coefficients are none; a fisheye always is one.
    assert_eq!(of_colmap("OPENCV 640 480 500 500 320 240 0 0 0 0").1, None);
    assert!(of_colmap("OPENCV_FISHEYE 640 480 500 500 320 240 0 0 0 0").1.is_some());
}

/// COLMAP's models 11 to 16, against their inverses or against what they are with fewer numbers.
#[test]
fn newer_models_of_colmap() {
    let ray = [0.43, -0.31];
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-12;
    for (text, k) in [
        ("SIMPLE_DIVISION 640 480 500 320 240 -0.2", -0.2),
        ("DIVISION 640 480 500 501 320 240 0.1", 0.1),
    ] {
        let [x, y] = of_colmap(text).1.unwrap().bent(ray);
        let back = 1.0 / (1.0 + k * (x * x + y * y));
        assert!(near([x * back, y * back], ray), "{text}");
    }
    assert_eq!(of_colmap("DIVISION 640 480 500 501 320 240 0").1, None);
    let (alpha, beta) = (0.57, 1.2);
    let [x, y] = of_colmap("EUCM 640 480 500 501 320 240 0.57 1.2").1.unwrap().bent(ray);
    let r2 = x * x + y * y;
    let depth = (1.0 - alpha * alpha * beta * r2)
        / (alpha * (1.0 - (2.0 * alpha - 1.0) * beta * r2).sqrt() + 1.0 - alpha);
    assert!(near([x / depth, y / depth], ray));
    assert_eq!(of_colmap("EUCM 640 480 500 501 320 240 0 1").1, None);
    let bare = Lens::Fisheye([0.0; 4]);
    for text in ["SIMPLE_FISHEYE 640 480 500 320 240", "FISHEYE 640 480 500 501 320 240"] {
        assert_eq!(of_colmap(text).1, Some(bare), "{text}");
    }
    let aria = |k: &str| {
        let text = format!("RAD_TAN_THIN_PRISM_FISHEYE 640 480 500 501 320 240 {k}");
        of_colmap(&text).1.unwrap().bent(ray)
    };
    let fisheye = Lens::Fisheye([0.1, -0.02, 0.003, 0.001]);
    assert!(near(aria("0.1 -0.02 0.003 0.001 0 0 0 0 0 0 0 0"), fisheye.bent(ray)));
    // The published formula, number by number.
    let [x, y] = fisheye.bent(ray);
    let r2 = x * x + y * y;
    let (p0, p1, s) = (0.01, -0.02, [0.03, 0.004, -0.05, 0.006]);
    let want = [
        x + (2.0 * x * x + r2) * p0 + 2.0 * x * y * p1 + s[0] * r2 + s[1] * r2 * r2,
        y + (2.0 * y * y + r2) * p1 + 2.0 * x * y * p0 + s[2] * r2 + s[3] * r2 * r2,
    ];
    let got = aria("0.1 -0.02 0.003 0.001 0 0 0.01 -0.02 0.03 0.004 -0.05 0.006");
    assert!(near(got, want), "{got:?} {want:?}");
}

#[test]
fn all_formulas_are_smooth_at_the_axis() {
    let lenses = [
        Lens::Rational { radial: [0.1; 6], tangential: [0.01; 2] },
        Lens::Fisheye([0.1; 4]),
        Lens::FieldOfView(0.9),
        Lens::FieldOfView(1e-9),
        Lens::ThinPrism { radial: [0.1; 4], tangential: [0.01; 2], prism: [0.01; 2] },
        Lens::Division(-0.3),
        Lens::Unified { alpha: 0.6, beta: 1.1 },
        Lens::RadTanThinPrism { radial: [0.1; 6], tangential: [0.01; 2], prism: [0.01; 4] },
    ];
    for lens in lenses {
        assert_eq!(lens.bent([0.0; 2]), [0.0; 2], "{lens:?}");
        let near = |x: f64| lens.bent([x, 0.0])[0] / x;
        assert!((near(1e-5) / near(1e-10) - 1.0).abs() < 1e-5, "{lens:?}");
    }
}

#[test]
fn nerf_files_name_lenses_by_their_coefficients() {
    let file = |more: &str| {
        let matrix = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";
        let text = format!(
            r#"{{"fl_x": 500, "w": 640, "h": 480{more},
                "frames": [{{"file_path": "a.png", "transform_matrix": {matrix}}}]}}"#
        );
        json::read(&text, None).unwrap()
    };
    let of = |more: &str| file(more).lenses.get("a.png").copied();
    assert_eq!(of(r#", "k1": 0, "p1": 0.0"#), None);
    let radial = [0.1, 0.0, 0.0, 0.0, 0.0, 0.0];
    assert_eq!(
        of(r#", "k1": 0.1, "p2": 0.02"#),
        Some(Lens::Rational { radial, tangential: [0.0, 0.02] })
    );
    let fisheye = Some(Lens::Fisheye([0.1, 0.0, 0.0, 0.0]));
    assert_eq!(of(r#", "k1": 0.1, "camera_model": "OPENCV_FISHEYE""#), fisheye);
    assert_eq!(of(r#", "k1": 0.1, "is_fisheye": true"#), fisheye);
    assert!(file(r#", "is_fisheye": true"#).warnings[0].contains("(fisheye)"));
}

#[test]
fn a_lens_leaves_what_the_photo_shows_everywhere() {
    let camera = |model: &str| of_colmap(model).0;
    // A barrel shows more than a pinhole of its focal length.
    let (barrel, lens) = of_colmap("SIMPLE_RADIAL 640 480 500 310 250 -0.1");
    assert_eq!(without_lens(&barrel, &lens.unwrap()), Some(barrel));
    // A pincushion shows less, and what is left touches the border of the photo.
    let (cushion, lens) = of_colmap("SIMPLE_RADIAL 640 480 500 310 250 0.1");
    let lens = lens.unwrap();
    let left = without_lens(&cushion, &lens).unwrap();
    assert!((560..630).contains(&left.width) && (420..470).contains(&left.height), "{left:?}");
    assert_eq!((left.fx, left.centre), (cushion.fx, cushion.centre));
    let mut least = f64::MAX;
    for (x, y) in (0..=left.width).flat_map(|x| [(x, 0), (x, left.height)]) {
        let ray = [(f64::from(x) - left.cx) / left.fx, (f64::from(y) - left.cy) / left.fy];
        let [x, y] = lens.bent(ray);
        let (x, y) = (x * cushion.fx + cushion.cx, y * cushion.fy + cushion.cy);
        let inside = [x, 640.0 - x, y, 480.0 - y].into_iter().fold(f64::MAX, f64::min);
        assert!(inside > -1.0, "{inside} pixels inside");
        least = least.min(inside);
    }
    assert!(least < 1.5, "{least} pixels are wasted");
    // Where a polynomial turns back it means nothing.
    let wild = Lens::Rational { radial: [-3.0, 0.0, 0.0, 0.0, 0.0, 0.0], tangential: [0.0; 2] };
    let left = without_lens(&camera("PINHOLE 640 480 500 500 320 240"), &wild).unwrap();
    let corner = (f64::from(left.width) / 1000.0).hypot(f64::from(left.height) / 1000.0);
    assert!(corner < (1.0f64 / 9.0).sqrt(), "1 - 9 r^2 > 0: {corner}");
    for absurd in [-1e6, f64::NAN, f64::INFINITY] {
        let radial = [absurd, 0.0, 0.0, 0.0, 0.0, 0.0];
        let lens = Lens::Rational { radial, tangential: [0.0; 2] };
        let (camera, _) = of_colmap("PINHOLE 640 480 500 500 320 240");
        let left = without_lens(&camera, &lens);
        assert!(left.is_none(), "{absurd}: less than {LEAST_SHARE}, {left:?}");
    }
}
