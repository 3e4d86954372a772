//! What the readers refuse, and with which words.

use powergs_scene::camera::{colmap, inria, json};
use powergs_testkit::camera_files::{binary_files, sample};

/// Reading must fail, and the message must hold every one of `words`.
#[track_caller]
fn refused(text: &str, words: &[&str]) {
    let message = json::read(text, None).unwrap_err().to_string();
    for word in words {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
}

#[test]
fn json_that_is_not_a_camera_file() {
    refused("", &["line 1, column 0", "not JSON"]);
    refused("[", &["not JSON"]);
    refused("[]", &["holds no views"]);
    refused("{}", &["neither a list of views"]);
    refused("3", &["neither a list of views"]);
    refused(r#"{"frames": []}"#, &["holds no views"]);
    refused(r#"{"frames": 3}"#, &["neither a list of views"]);
    refused("[3]", &["view 0", "must be an object"]);
    refused("[NaN]", &["not JSON"]);
    refused(&"[".repeat(100_000), &["not JSON", "recursion"]);
}

#[test]
fn every_truncation_of_a_json_file() {
    let text = inria::write(&[sample()]);
    for end in 0..text.trim_end().len() {
        assert!(json::read(&text[..end], None).is_err(), "the first {end} bytes were accepted");
    }
}

#[test]
fn values_out_of_range_name_view_and_key() {
    let good = inria::write(&[sample(), sample()]);
    let bad = |from: &str, to: &str| {
        let at = good.rfind(from).unwrap_or_else(|| panic!("{from} is not in the file"));
        format!("{}{to}{}", &good[..at], &good[at + from.len()..])
    };
    let fx = "\"fx\":700.0";
    for value in ["0", "-700", "1e300", "1e-300"] {
        refused(&bad(fx, &format!("\"fx\":{value}")), &["view 1 (a.jpg), key `fx`", "focal"]);
    }
    refused(&bad(fx, "\"fx\":\"700\""), &["view 1", "key `fx`", "must be a number"]);
    refused(&bad("\"fy\":710.0,", ""), &["view 1", "key `fy`", "is missing"]);
    refused(&bad(fx, "\"fx\":1e999"), &["not JSON", "out of range"]);
    for value in ["0", "-3", "800.5", "65537", "1e30"] {
        refused(&bad("\"width\":800", &format!("\"width\":{value}")), &["view 1", "key `width`"]);
    }
    refused(&bad("\"cx\":410.0", "\"cx\":1e12"), &["view 1", "key `cx`"]);
    refused(&bad("\"position\":[1.0", "\"position\":[1e30"), &["view 1", "key `position`"]);
    refused(&bad("\"position\":[1.0", "\"position\":[1.0,2.0"), &["`position`", "three numbers"]);
    refused(&bad("\"rotation\":[[", "\"rotation\":[[\"x\","), &["view 1", "`rotation`", "row 0"]);
    refused(&bad("\"rotation\":[[0.9", "\"rotation\":[[0.8"), &["view 1", "not a rotation"]);
}

#[test]
fn reflections_and_projective_matrices_are_refused() {
    let frame = |matrix: &str| {
        format!(r#"{{"w":8,"h":8,"fl_x":9,"frames":[{{"transform_matrix":{matrix}}}]}}"#)
    };
    refused(&frame("[[1,0,0,0],[0,1,0,0],[0,0,-1,0]]"), &["view 0", "reflection"]);
    refused(&frame("[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,1,1]]"), &["last row"]);
    refused(&frame("[[1,0,0],[0,1,0],[0,0,1]]"), &["row 0 must have 4 numbers"]);
    refused(&frame("[[2,0,0,0],[0,2,0,0],[0,0,2,0]]"), &["not a rotation", "remove scale"]);
    assert!(json::read(&frame("[[1,0,0,0],[0,1,0,0],[0,0,1,0]]"), None).is_ok());
}

#[test]
fn blender_angles_and_missing_sizes() {
    let pose = r#""frames":[{"file_path":"r_0","transform_matrix":
        [[1,0,0,0],[0,1,0,0],[0,0,1,0]]}]"#;
    refused(&format!(r#"{{"camera_angle_x":0.7,{pose}}}"#), &["view 0 (r_0)", "size is missing"]);
    refused(&format!(r#"{{"w":8,"h":8,{pose}}}"#), &["view 0 (r_0)", "`fl_x`"]);
    for angle in ["0", "-1", "3.15"] {
        let text = format!(r#"{{"w":8,"h":8,"camera_angle_x":{angle},{pose}}}"#);
        refused(&text, &["view 0 (r_0)", "`camera_angle_x`"]);
    }
    let split = pose.replace("{\"file_path\"", "{\"split\":\"tset\",\"file_path\"");
    refused(&format!(r#"{{"w":8,"h":8,"fl_x":9,{split}}}"#), &["`split`", "`tset`"]);
}

#[test]
fn every_truncation_of_a_colmap_binary() {
    let (cameras, images) = binary_files();
    for end in 0..cameras.len() {
        let error = colmap::read_binary(&cameras[..end], images.as_slice()).unwrap_err();
        assert!(error.to_string().starts_with("cameras.bin, byte"), "{end}: {error}");
    }
    for end in 0..images.len() {
        let error = colmap::read_binary(cameras.as_slice(), &images[..end]).unwrap_err();
        assert!(error.to_string().starts_with("images.bin, byte"), "{end}: {error}");
    }
    let mut longer = images.clone();
    longer.push(0);
    let error = colmap::read_binary(cameras.as_slice(), longer.as_slice()).unwrap_err();
    assert!(error.to_string().contains("bytes follow"), "{error}");
}

#[test]
fn colmap_counts_that_promise_terabytes() {
    let (cameras, images) = binary_files();
    let huge = |bytes: &[u8], at: usize, value: u64| {
        let mut bytes = bytes.to_vec();
        bytes[at..at + 8].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    // The count of 2D points of the first image stands before its one point.
    let points = 8 + 4 + 56 + 4 + 6;
    for value in [u64::MAX, 1 << 60, 1 << 40] {
        let error = |cameras: &[u8], images: &[u8]| {
            colmap::read_binary(cameras, images).unwrap_err().to_string()
        };
        assert!(error(&huge(&cameras, 0, value), &images).contains("ends inside"));
        assert!(error(&cameras, &huge(&images, 0, value)).contains("ends inside"));
        assert!(error(&cameras, &huge(&images, points, value)).contains("are promised"));
        assert!(error(&huge(&cameras, 16, value), &images).contains("image side"));
    }
}

#[test]
fn colmap_values() {
    let (cameras, images) = binary_files();
    let error = |file: &str, at: usize, bytes: &[u8]| {
        let (mut cameras, mut images) = (cameras.clone(), images.clone());
        let target = if file == "cameras" { &mut cameras } else { &mut images };
        target[at..at + bytes.len()].copy_from_slice(bytes);
        colmap::read_binary(cameras.as_slice(), images.as_slice()).unwrap_err().to_string()
    };
    assert!(error("cameras", 12, &17i32.to_le_bytes()).contains("a panorama"));
    assert!(error("cameras", 12, &18i32.to_le_bytes()).contains("not a camera model"));
    assert!(error("cameras", 12, &(-1i32).to_le_bytes()).contains("not a camera model"));
    assert!(error("cameras", 32, &0f64.to_le_bytes()).contains("focal length x"));
    assert!(error("cameras", 32, &f64::NAN.to_le_bytes()).contains("focal length x"));
    assert!(error("cameras", 48, &f64::INFINITY.to_le_bytes()).contains("principal point"));
    assert!(error("cameras", 64, &1u32.to_le_bytes()).contains("occurs twice"));
    assert!(error("images", 12, &f64::NAN.to_le_bytes()).contains("rotation quaternion"));
    assert!(error("images", 20, &0f64.to_le_bytes()).contains("rotation quaternion"));
    assert!(error("images", 44, &f64::NAN.to_le_bytes()).contains("translation"));
    assert!(error("images", 68, &9u32.to_le_bytes()).contains("camera 9 is not in"));
    assert!(error("images", 72, &[0xff]).contains("not UTF-8"));
}

#[test]
fn colmap_text_errors_name_the_line() {
    let camera = "1 PINHOLE 640 480 500 500 320 240\n";
    let image = "1 1 0 0 0 0 0 0 1 a.png\n\n";
    let error = |cameras: &str, images: &str| {
        colmap::read_text(cameras.as_bytes(), images.as_bytes()).unwrap_err().to_string()
    };
    assert!(error("# x\n1 PINHOLE 640\n", image).starts_with("cameras.txt, line 2: the line ends"));
    assert!(error("1 PINHOL 640 480 1 1 1 1\n", image).contains("`PINHOL` is not a camera model"));
    assert!(error("1 PINHOLE 640 480 x 1 1 1\n", image).contains("`x` is not"));
    assert!(error(camera, "1 1 0 0 0 0 0 0 1\n").contains("images.txt, line 1: the image name"));
    let one_line = "1 1 0 0 0 0 0 0 1 a\n2 1 0 0 0 0 0 0 1 b\n";
    let message = error(camera, one_line);
    assert!(message.starts_with("images.txt, line 2: this is no list of 2D points"), "{message}");
    let named_as_numbers = "1 1 0 0 0 0 0 0 1 7 8 9\n2 1 0 0 0 0 0 0 1 x 8 9\n";
    assert!(error(camera, named_as_numbers).contains("line 2: this is no list"));
    assert!(error(camera, "").contains("no views"));
    assert!(error("", image).contains("camera 1 is not in"));
}

#[test]
fn damaged_colmap_binaries_never_panic() {
    use rand::{RngExt, SeedableRng};
    let (cameras, images) = powergs_testkit::camera_files::binary_files();
    let whole = powergs_testkit::camera_files::joined(&cameras, &images);
    let mut rng = rand_pcg::Pcg64Mcg::seed_from_u64(5);
    let mut refused = 0;
    for _ in 0..20_000 {
        let mut bytes = whole.clone();
        for _ in 0..rng.random_range(1..4) {
            let at = rng.random_range(2..bytes.len());
            bytes[at] = rng.random();
        }
        let (cameras, images) = bytes[2..].split_at(cameras.len());
        refused += u32::from(colmap::read_binary(cameras, images).is_err());
    }
    // Most bytes are doubles, where a change is another valid pose; orthonormality catches few.
    assert!(refused > 2_000, "{refused} of 20000 refused");
}
