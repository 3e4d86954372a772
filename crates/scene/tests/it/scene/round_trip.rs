//! What is written in a format is read back, up to that format's quantisation.

use powergs_scene::{Format, Gaussians, Warning, read};
use powergs_testkit::difference::{Difference, difference};
use powergs_testkit::scene_files::{self as encode, sample};

use super::read_bytes;

/// Half a step of the quantisation of each parameter, with 2 % for the arithmetic.
fn check(found: &Difference, limits: [f64; 6]) {
    let Difference { mean, log_scale, rotation, opacity, dc, rest } = *found;
    let differences = [mean, log_scale, rotation, opacity as f32, dc, rest].map(f64::from);
    for (i, (difference, limit)) in differences.iter().zip(limits).enumerate() {
        assert!(*difference <= 1.02 * limit, "parameter {i}: {difference} > {limit}: {found:?}");
    }
}

#[test]
fn ply_keeps_every_bit() {
    for degree in 0..=3 {
        let scene = sample(300, degree);
        let model = read_bytes(&encode::ply(&scene)).unwrap();
        assert_eq!(model.gaussians, scene);
        assert_eq!(model.format, Format::Ply);
        assert_eq!(read_bytes(&encode::ascii_ply(&scene)).unwrap().gaussians, scene);
    }
}

#[test]
fn degree_three_has_62_properties() {
    let bytes = encode::ply(&sample(1, 3));
    let header = String::from_utf8_lossy(&bytes);
    assert_eq!(header.matches("property float ").count(), 62);
}

#[test]
fn splat_rows() {
    let scene = sample(300, 0);
    let model = read_bytes(&encode::splat(&scene)).unwrap();
    assert_eq!(model.format, Format::Splat);
    // Means are exact, scales pass through exp and ln; the rest are bytes, and a component of 1
    // is cut off at 127/128.
    let dc = 0.5 / 255.0 / 0.2820948;
    let found = difference(&scene, &clamp_colour(model.gaussians, &scene));
    check(&found, [0.0, 1e-5, 1.0 / 128.0, 0.5 / 255.0, dc, 0.0]);
}

/// Colours beyond 0 and 1 cannot be stored in rows; those are not compared.
fn clamp_colour(mut read: Gaussians, scene: &Gaussians) -> Gaussians {
    for (read, written) in read.sh.iter_mut().zip(&scene.sh) {
        if !(0.0..=1.0).contains(&(written * 0.2820948 + 0.5)) {
            *read = *written;
        }
    }
    read
}

#[test]
fn compressed_ply_with_two_chunks() {
    for degree in [0, 1, 2, 3] {
        let scene = sample(300, degree);
        let model = read_bytes(&encode::compressed_ply(&scene)).unwrap();
        assert_eq!(model.format, Format::CompressedPly);
        // The coarsest of 11-10-11 bits over ranges of 2 and 4; colour over a range of 2.
        let step = 0.5 / 1023.0;
        let rotation = step * 2_f64.sqrt();
        let dc = 0.5 * 2.0 / 255.0 / 0.2820948;
        let found = difference(&scene, &model.gaussians);
        // The largest component is derived: its error is the sum of the others'.
        check(&found, [2.0 * step, 4.0 * step, 3.0 * rotation, 0.5 / 255.0, dc, 0.5 * 8.0 / 256.0]);
    }
}

/// SPZ stores other axes: what the writer put in as it is comes out turned.
fn turned(scene: &Gaussians) -> Gaussians {
    let mut scene = scene.clone();
    scene.means.iter_mut().for_each(|m| *m = [m[0], -m[1], -m[2]]);
    scene.rotations.iter_mut().for_each(|q| *q = [q[0], q[1], -q[2], -q[3]]);
    scene
}

#[test]
fn spz_of_every_version() {
    for version in 1..=4 {
        let scene = sample(300, 0);
        let model = read_bytes(&encode::spz(&scene, version, &[])).unwrap();
        assert_eq!(model.format, Format::Spz(version));
        // Half precision is cut off below 1: 2^-11; fixed point has 12 bits.
        let mean = if version == 1 { 0.5_f64.powi(11) } else { 0.5 / 4096.0 };
        // Bytes over -1 to 1, or ten bits; the derived component, where it is small, has a large
        // error in versions 1 and 2: sqrt(3 * 2 / 255).
        let rotation = if version < 3 { 0.154 } else { 3.0 * 0.5 / 511.0 * 0.7072 };
        let found = difference(&turned(&scene), &model.gaussians);
        check(&found, [mean, 0.5 / 16.0, rotation, 0.5 / 255.0, 0.5 / 255.0 / 0.15, 0.0]);
    }
}

#[test]
fn spz_versions_3_and_4_agree() {
    let scene = sample(100, 3);
    let old = read_bytes(&encode::spz(&scene, 3, &[])).unwrap().gaussians;
    let new = read_bytes(&encode::spz(&scene, 4, &[])).unwrap().gaussians;
    assert_eq!(old, new);
}

/// The spherical harmonics of degree 0 to 3, with the signs of 3DGS.
fn basis([x, y, z]: [f64; 3]) -> [f64; 16] {
    [
        1.0,
        -y,
        z,
        -x,
        x * y,
        -y * z,
        2.0 * z * z - x * x - y * y,
        -x * z,
        x * x - y * y,
        -y * (3.0 * x * x - y * y),
        x * y * z,
        -y * (4.0 * z * z - x * x - y * y),
        z * (2.0 * z * z - 3.0 * x * x - 3.0 * y * y),
        -x * (4.0 * z * z - x * x - y * y),
        z * (x * x - y * y),
        -x * (x * x - 3.0 * y * y),
    ]
}

#[test]
fn spz_colour_seen_from_the_same_side_stays_the_same() {
    let scene = sample(20, 3);
    let record = |system: u8| {
        [&0xadbe_0003_u32.to_le_bytes()[..], &[4, 0, 0, 0], &[system, 0, 0, 0]].concat()
    };
    // Right-up-back by default, and as the record says: bit 0 right, bit 1 up, bit 2 front.
    let cases =
        [(Vec::new(), [1.0, -1.0, -1.0]), (record(6), [1.0; 3]), (record(1), [-1.0, 1.0, -1.0])];
    for (extensions, signs) in cases {
        let read = read_bytes(&encode::spz(&scene, 4, &extensions)).unwrap().gaussians;
        let stored_direction = [0.48, -0.6, 0.64];
        let direction: [f64; 3] = std::array::from_fn(|i| stored_direction[i] * signs[i]);
        let shade = |sh: &[f32], d| -> f64 {
            sh[1..16].iter().zip(&basis(d)[1..]).map(|(c, b)| f64::from(*c) * b).sum()
        };
        for i in 0..scene.len() {
            let (stored, turned) =
                (shade(scene.sh_of(i), stored_direction), shade(read.sh_of(i), direction));
            // 15 coefficients, each off by half a step of 1/128, times basis values below 4.
            assert!((stored - turned).abs() < 15.0 * 4.0 / 256.0, "{i}: {stored} {turned}");
            let close = |axis: usize| {
                (read.means[i][axis] - scene.means[i][axis] * signs[axis] as f32).abs() < 2e-4
            };
            assert!((0..3).all(close), "Gaussian {i} with {signs:?}");
        }
    }
}

#[test]
fn spz_of_degree_4_is_cut() {
    let scene = sample(5, 3);
    let mut with_24 = Gaussians { sh_degree: 4, sh: Vec::new(), ..scene.clone() };
    for channel in scene.sh.chunks_exact(16) {
        with_24.sh.extend(channel);
        with_24.sh.extend([0.5; 9]);
    }
    for version in [3, 4] {
        let model = read_bytes(&encode::spz(&with_24, version, &[])).unwrap();
        let of_three = read_bytes(&encode::spz(&scene, version, &[])).unwrap();
        assert_eq!(model.gaussians, of_three.gaussians);
        assert_eq!(model.warnings, [Warning::ShReduced { from: 4 }]);
    }
}

#[test]
fn sog_folder_and_bundle() {
    for (version, degree) in [(1, 0), (1, 2), (2, 0), (2, 1), (2, 2), (2, 3)] {
        let scene = sample(300, degree);
        let files = encode::sog(&scene, version);
        let model = read(&files, "meta.json", None).unwrap();
        assert_eq!(model.format, Format::Sog(version));
        // 16 bits over 2 ln 2, widened by e^x at most; the codebooks have 255 steps over at most 4
        // (scales), 6 (colours share theirs with raw opacities) and 3 (SH).
        let mean = 2.0 * 2_f64.ln() / 65535.0;
        let rotation = 3.0 * 0.5 / 255.0 * 2_f64.sqrt();
        let limits = [
            mean,
            2.0 / 255.0,
            rotation,
            3.0 / 255.0 / 4.0 + 0.5 / 255.0,
            3.0 / 255.0,
            1.5 / 255.0,
        ];
        check(&difference(&scene, &model.gaussians), limits);
        let bundle = read_bytes(&encode::zipped(&files)).unwrap();
        assert_eq!(bundle.gaussians, model.gaussians);
        // A bundle may hold its files in a folder.
        let inside = files.iter().map(|(name, b)| (format!("room/{name}"), b.clone())).collect();
        assert_eq!(read_bytes(&encode::zipped(&inside)).unwrap().gaussians, model.gaussians);
    }
}

#[test]
fn streamed_sog_has_levels() {
    let parts = [("0_0", sample(70, 1)), ("0_1", sample(40, 0)), ("1_0", sample(20, 1))];
    let mut files = encode::Files::new();
    for (name, scene) in &parts {
        let inner = encode::sog(scene, 2);
        files.extend(inner.into_iter().map(|(file, bytes)| (format!("{name}/{file}"), bytes)));
    }
    let lods = |file: u32| serde_json::json!({ "file": file, "offset": 0, "count": 1 });
    let index = serde_json::json!({
        "lodLevels": 2,
        "filenames": ["1_0/meta.json", "0_0/meta.json", "0_1/meta.json"],
        "tree": { "children": [
            { "lods": { "0": lods(2), "1": lods(0) } },
            { "lods": { "0": lods(1), "1": lods(0) } },
        ] },
    });
    files.insert("lod-meta.json".into(), index.to_string().into_bytes());
    let level = |lod| read(&files, "lod-meta.json", lod);
    let fine = level(None).unwrap();
    assert_eq!((fine.gaussians.len(), fine.format), (110, Format::StreamedSog));
    let (first, second) = (&parts[0].1, &parts[1].1);
    let mut both = first.clone();
    both.append(second.clone());
    // Files in the order of the list, the lower degree padded with zeros.
    let found = difference(&both, &fine.gaussians);
    assert!(found.mean < 1e-4 && found.rest < 0.01, "{found:?}");
    assert_eq!(level(Some(0)).unwrap().gaussians, fine.gaussians);
    assert_eq!(level(Some(1)).unwrap().gaussians.len(), 20);
    let error = level(Some(2)).unwrap_err().to_string();
    assert!(error.contains("choose one of 0 (the finest) to 1"), "{error}");
}
