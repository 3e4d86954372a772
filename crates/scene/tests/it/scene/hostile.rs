//! Bytes that no writer makes: errors, never a panic, a hang or an allocation beyond the data.

use powergs_scene::{Model, OneFile, SceneError, read};
use powergs_testkit::bombs::{bombs, planes};
use powergs_testkit::scene_files::{self as encode, Files, gzip, sample};

use super::read_bytes;

#[test]
fn empty_and_unknown_files() {
    assert!(matches!(read_bytes(b""), Err(SceneError::Empty)));
    let others: [&[u8]; 6] =
        [b"x", b"solid cube\n", b"\x89PNG\r\n\x1a\n", &[0; 64], b"[1, 2]", &[b'a'; 3200]];
    for bytes in others {
        assert!(matches!(read_bytes(bytes), Err(SceneError::Unknown { .. })), "{bytes:?}");
    }
    let error = read_bytes(b"{\"frames\": []}").unwrap_err().to_string();
    assert!(error.contains("a camera file in place of a model"), "{error}");
    let error = read_bytes(b"{\"points\": []}").unwrap_err().to_string();
    assert!(error.contains("without a key `means`"), "{error}");
    let error =
        read_bytes(&gzip(b"just some text, and quite a lot of it")).unwrap_err().to_string();
    assert!(error.contains("no magic NGSP"), "{error}");
}

/// What others read is named, by its content or its name, with the way to a file that is read.
#[test]
fn foreign_formats_are_named() {
    let checkpoint = {
        let mut files = Files::new();
        files.insert("archive/data.pkl".into(), b"\x80\x02}q\x00.".to_vec());
        files.insert("archive/version".into(), b"3".to_vec());
        encode::zipped(&files)
    };
    let rows = encode::splat(&sample(20, 0));
    let cases: [(&str, &[u8], &str, &str); 8] = [
        ("a.ksplat", &[0; 4096], "KSPLAT", "splat-transform"),
        // Even where it looks like rows of `.splat`.
        ("a.ksplat", &rows, "KSPLAT", "splat-transform"),
        ("meta.lcc", b"{\"version\": 3}", "LCC", "splat-transform"),
        ("a.usda", b"#usda 1.0\n", "USD", "export"),
        ("a", b"PXR-USDC\0\0", "USD", "export"),
        ("step-000029999.ckpt", &checkpoint, "PyTorch checkpoint", "ns-export"),
        ("anything", &checkpoint, "PyTorch checkpoint", "ns-export"),
        ("model.npz", b"\x93NUMPY", "arrays", "export"),
    ];
    for (name, bytes, format, todo) in cases {
        let error = read(&OneFile(bytes), name, None).unwrap_err().to_string();
        assert!(error.contains(format) && error.contains(todo), "{name}: {error}");
    }
}

#[test]
fn every_prefix_is_an_error() {
    for (target, name, bytes) in encode::seeds() {
        if target == "scene_sog_plane" {
            continue;
        }
        for end in 0..bytes.len() {
            // Rows have no header: a whole number of them is a file.
            let whole_rows = target == "scene_splat" && end % 32 == 0 && end > 0;
            let result = read_bytes(&bytes[..end]);
            assert_eq!(result.is_ok(), whole_rows, "{target} {name} cut to {end}: {result:?}");
        }
        assert!(read_bytes(&bytes).is_ok(), "{target} {name}");
    }
}

#[test]
fn every_prefix_of_a_file_of_a_folder_is_an_error() {
    let files = encode::sog(&sample(2, 1), 2);
    for (name, bytes) in &files {
        // The index is long and all of a kind.
        let step = if name == "meta.json" { 41 } else { 1 };
        for end in (0..bytes.len()).step_by(step) {
            let mut cut: Files = files.clone();
            cut.insert(name.clone(), bytes[..end].to_vec());
            assert!(read(&cut, "meta.json", None).is_err(), "{name} cut to {end}");
        }
        let mut without = files.clone();
        without.remove(name);
        assert!(read(&without, "meta.json", None).is_err(), "without {name}");
    }
}

/// Reads damaged bytes. Damage may leave a valid file; then the model must be sound.
fn survive(result: Result<Model, SceneError>) {
    match result {
        Ok(model) => {
            let scene = model.gaussians;
            assert!(!scene.is_empty() && scene.sh_degree <= 3);
            assert_eq!(scene.sh.len(), scene.len() * 3 * scene.sh_coefficients());
            assert_eq!(scene.rotations.len(), scene.len());
            assert!(scene.means.as_flattened().iter().chain(&scene.sh).all(|v| v.is_finite()));
        }
        Err(error) => assert!(error.to_string().len() < 600, "a message of a novel's length"),
    }
}

#[test]
fn damaged_bytes_never_panic() {
    let mut state = 1_u64;
    let mut random = move |below: usize| {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let slow = std::env::var_os("RUN_SLOW_TESTS").is_some();
    let rounds = if slow { 20_000 } else { 200 };
    for (target, _, bytes) in encode::seeds() {
        let damaged = |bytes: Vec<u8>| match target {
            "scene_sog_plane" => survive(read(&planes(&bytes), "meta.json", None)),
            _ => survive(read_bytes(&bytes)),
        };
        // Each byte of the header region, to the values that matter most.
        let header = if target.starts_with("scene_sog") { 120 } else { 400 };
        for at in 0..bytes.len().min(header) {
            for value in [0, 0xff, bytes[at] ^ 1, bytes[at] ^ 0x80] {
                let mut copy = bytes.clone();
                copy[at] = value;
                damaged(copy);
            }
        }
        for _ in 0..rounds {
            let mut copy = bytes.clone();
            for _ in 0..=random(4) {
                let at = random(copy.len());
                copy[at] = random(256) as u8;
            }
            if random(4) == 0 {
                let (from, to) = (random(copy.len()), random(copy.len()));
                copy.splice(from.min(to)..from.max(to), []);
            }
            damaged(copy);
        }
    }
}

#[test]
fn damaged_json_never_panics() {
    let files = encode::sog(&sample(2, 1), 2);
    let meta = String::from_utf8(files["meta.json"].clone()).unwrap();
    let with = |from: &str, to: &str| {
        assert!(meta.contains(from), "{from}");
        let mut files = files.clone();
        files.insert("meta.json".into(), meta.replacen(from, to, 1).into_bytes());
        read(&files, "meta.json", None).unwrap_err().to_string()
    };
    let cases = [
        ("\"version\":2", "\"version\":3", "version 3"),
        ("\"count\":2", "\"count\":0", "no Gaussians"),
        ("\"count\":2", "\"count\":1e9", "invalid type"),
        ("\"count\":2", "\"count\":4000000000", "at most 2147483648"),
        ("\"count\":2", "\"count\":2000000000", "too small for them"),
        ("\"count\":2", "\"count\":60000", "pixels for 60000 Gaussians"),
        ("\"count\":2", "\"kount\":2", "count"),
        ("means_l.webp", "../secret.webp", "leaves the folder"),
        ("means_l.webp", "/etc/passwd", "leaves the folder"),
        ("means_l.webp", "c.webp\\u0000", "leaves the folder"),
        ("\"quats.webp\"", "", "0 names instead of 1"),
        ("\"quats.webp\"", "\"meta.json\"", "neither WebP nor PNG"),
        ("\"codebook\":[", "\"codebook\":[1,", "257 entries"),
        ("\"codebook\"", "\"kodebook\"", "missing"),
        ("\"c.webp\"", "\"l.webp\"", "not a palette"),
    ];
    for (from, to, message) in cases {
        let error = with(from, to);
        assert!(error.contains(message), "{from} -> {to}: {error}");
    }
    let deep = format!(
        "{{\"lodLevels\":1,\"filenames\":[],\"tree\":{}",
        "{\"children\":[".repeat(100_000)
    );
    assert!(read_bytes(deep.as_bytes()).is_err());
    let empty = br#"{"lodLevels":1,"filenames":[],"tree":{}}"#;
    assert!(read_bytes(empty).unwrap_err().to_string().contains("no Gaussians"));
}

#[test]
fn bombs_are_refused() {
    for (what, bytes) in bombs() {
        let error = read_bytes(&bytes).map(|m| m.gaussians.len()).expect_err(what).to_string();
        println!("{what}: {error}");
    }
}

#[test]
fn an_element_without_properties_is_refused() {
    let bytes = encode::compressed_ply(&sample(3, 0));
    let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a header");
    for element in ["element sh 3\n", "element sh 0\n"] {
        let bare = [&bytes[..end], element.as_bytes(), &bytes[end..]].concat();
        let error = read_bytes(&bare).unwrap_err().to_string();
        assert!(error.contains("PLY element `sh`: 0 properties; 9, 24 or 45"), "{error}");
    }
    let plain = encode::ply(&sample(1, 0));
    let end = plain.windows(11).position(|w| w == b"end_header\n").expect("a header");
    let bare =
        [b"ply\nformat binary_little_endian 1.0\nelement vertex 1\n", &plain[end..]].concat();
    assert!(read_bytes(&bare).is_err());
}
