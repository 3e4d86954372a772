//! What the readers read.

use powergs_scene::Split;
use powergs_scene::camera::{CameraFile, colmap, inria, json};
use powergs_testkit::camera_files::{binary_files, sample};
use powergs_testkit::data;

use super::difference;

const TRANSFORMS: &str = r#"{
  "camera_angle_x": 0.6911112070083618,
  "frames": [
    {"file_path": "./train/r_0", "transform_matrix":
      [[1, 0, 0, 0], [0, 0, -1, -4], [0, 1, 0, 0.5], [0, 0, 0, 1]]}
  ]
}"#;

#[test]
fn real_inria_and_nerf_files_agree() {
    let Some(data) = data() else { return };
    for set in ["snowmiku-posed", "fox-posed", "nerfsyn-chair-posed"] {
        let read = |file: &str| {
            let text = std::fs::read_to_string(data.join(set).join(file)).unwrap();
            json::read(&text, None).unwrap()
        };
        let (inria, nerf) = (read("cameras.json"), read("transforms.json"));
        assert_eq!(inria.cameras.len(), nerf.cameras.len(), "{set}");
        assert_eq!((&inria.warnings, &nerf.warnings), (&vec![], &vec![]), "{set}");
        for (a, b) in inria.cameras.iter().zip(&nerf.cameras) {
            assert_eq!((&a.name, a.split), (&b.name, b.split), "{set}");
            // The files hold the same doubles; only the order of operations differs.
            assert!(difference(a, b) < 1e-6, "{set} {}: {}", a.name, difference(a, b));
        }
    }
}

#[test]
fn blender_file_takes_the_size_from_outside() {
    let file = json::read(TRANSFORMS, Some((800, 800))).unwrap();
    let camera = &file.cameras[0];
    assert_eq!((camera.name.as_str(), camera.width, camera.cx), ("r_0", 800, 400.0));
    // 1111.11 pixels is the published focal length of the Blender sets.
    assert!((camera.fx - 1111.1110311937682).abs() < 1e-6 && camera.fx == camera.fy);
    // The camera stands at y = -4 and looks along +y, with z up: image "down" is -z.
    assert!((camera.forward() - glam::DVec3::Y).length() < 1e-12);
    assert!((camera.world_to_camera.row(1) - glam::DVec3::NEG_Z).length() < 1e-12);
}

#[test]
fn nerf_frames_override_the_file_and_distortion_warns() {
    let text = TRANSFORMS.replace(
        "\"camera_angle_x\": 0.6911112070083618",
        "\"fl_x\": 500.0, \"fl_y\": 510, \"w\": 640.0, \"h\": 480, \"k1\": 0.1, \"p2\": 0.0",
    );
    let text = text.replace("{\"file_path\"", "{\"split\": \"val\", \"cx\": 300, \"file_path\"");
    let file = json::read(&text, None).unwrap();
    let camera = &file.cameras[0];
    assert_eq!((camera.fx, camera.fy, camera.cx, camera.cy), (500.0, 510.0, 300.0, 240.0));
    assert_eq!(camera.split, Some(Split::Test));
    assert_eq!(file.warnings.len(), 1);
    assert!(file.warnings[0].contains("(k1)"), "{}", file.warnings[0]);
}

#[test]
fn inria_round_trip_is_exact() {
    let mut cameras = vec![sample(), sample()];
    cameras[1].split = Some(Split::Train);
    cameras[1].name = "b \"quoted\".png".to_string();
    let back = json::read(&inria::write(&cameras), None).unwrap().cameras;
    for (a, b) in cameras.iter().zip(&back) {
        assert_eq!(difference(a, b), 0.0);
        assert_eq!((&a.name, a.split), (&b.name, b.split));
    }
}

#[test]
fn inria_without_principal_point_is_centred() {
    let text = inria::write(&[sample()]).replace(",\"cx\":410.0,\"cy\":290.0", "");
    let camera = &json::read(&text, None).unwrap().cameras[0];
    assert_eq!((camera.cx, camera.cy), (400.0, 300.0));
}

#[test]
fn slightly_rounded_rotation_becomes_exact() {
    let exact = inria::write(&[sample()]);
    let text = exact.replacen("\"rotation\":[[0.955336", "\"rotation\":[[0.955736", 1);
    assert_ne!(text, exact, "the sample's first element is cos 0.3");
    let camera = &json::read(&text, None).unwrap().cameras[0];
    let r = camera.world_to_camera;
    let error = (r * r.transpose() - glam::DMat3::IDENTITY).to_cols_array();
    assert!(error.iter().all(|e| e.abs() < 1e-15), "{error:?}");
}

#[test]
fn colmap_binary_and_text_agree() {
    let binary = binary_model();
    let text = colmap::read_text(CAMERAS_TXT.as_bytes(), IMAGES_TXT.as_bytes()).unwrap();
    assert_eq!(binary.cameras, text.cameras);
    assert_eq!(binary.warnings, text.warnings);
    let names: Vec<&str> = binary.cameras.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["a b.png", "z.png"], "sorted by name");
    let camera = &binary.cameras[1];
    assert_eq!((camera.fx, camera.fy, camera.cx, camera.cy), (500.0, 500.0, 320.0, 240.0));
    // Half a turn about x; centre = -Rᵀ t = (-1, 2, 3).
    assert!((camera.centre - glam::DVec3::new(-1.0, 2.0, 3.0)).length() < 1e-12);
    assert!((camera.forward() - glam::DVec3::NEG_Z).length() < 1e-12);
    assert_eq!(binary.warnings.len(), 1);
    assert!(binary.warnings[0].contains("camera 2 (SIMPLE_RADIAL)"), "{:?}", binary.warnings);
}

#[test]
fn colmap_knows_all_models() {
    let models = [
        ("SIMPLE_PINHOLE", 3),
        ("PINHOLE", 4),
        ("SIMPLE_RADIAL", 4),
        ("RADIAL", 5),
        ("OPENCV", 8),
        ("OPENCV_FISHEYE", 8),
        ("FULL_OPENCV", 12),
        ("FOV", 5),
        ("SIMPLE_RADIAL_FISHEYE", 4),
        ("RADIAL_FISHEYE", 5),
        ("THIN_PRISM_FISHEYE", 12),
    ];
    for (name, n) in models {
        let parameters = |n: usize| (0..n).map(|i| format!(" {}", 100 + i)).collect::<String>();
        let cameras = |n| format!("1 {name} 640 480{}\n", parameters(n));
        let image = "1 1 0 0 0 0 0 0 1 a.png\n\n";
        let file = colmap::read_text(cameras(n).as_bytes(), image.as_bytes()).unwrap();
        let camera = &file.cameras[0];
        let one_focal = ["SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL"].contains(&name)
            || name.ends_with("RADIAL_FISHEYE");
        let expected =
            if one_focal { [100.0, 100.0, 101.0, 102.0] } else { [100.0, 101.0, 102.0, 103.0] };
        assert_eq!([camera.fx, camera.fy, camera.cx, camera.cy], expected, "{name}");
        assert_eq!(file.warnings.is_empty(), name.ends_with("PINHOLE"), "{name}");
        let short = colmap::read_text(cameras(n - 1).as_bytes(), image.as_bytes()).unwrap_err();
        assert!(short.to_string().contains(&format!("takes {n} parameters")), "{short}");
    }
}

const CAMERAS_TXT: &str = "# Camera list with one line of data per camera:
#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]
# Number of cameras: 2
1 PINHOLE 640 480 500 500 320 240
2 SIMPLE_RADIAL 320 240 250 160 120 0.01
";
const IMAGES_TXT: &str = "# Number of images: 2, mean observations per image: 0.5
7 0 1 0 0 1 2 3 1 z.png
10.5 20.5 -1
3 1 0 0 0 0 0 0 2 a b.png

";

/// Who takes views out by hand leaves the comments as they are.
#[test]
fn counts_in_comments_are_not_believed() {
    let (cameras, images) = (CAMERAS_TXT.replace(": 2", ": 5"), IMAGES_TXT.replace(": 2", ": 4"));
    let file = colmap::read_text(cameras.as_bytes(), images.as_bytes()).unwrap();
    assert_eq!(file.cameras.len(), 2);
    let said = "images.txt: a comment promises 4 entries, the file has 2";
    assert!(file.warnings.iter().any(|w| w.contains(said)), "{:?}", file.warnings);
    assert!(file.warnings.iter().any(|w| w.contains("cameras.txt: a comment promises 5")));
}

fn binary_model() -> CameraFile {
    let (cameras, images) = binary_files();
    colmap::read_binary(cameras.as_slice(), images.as_slice()).unwrap()
}

#[test]
fn seeds_of_the_fuzz_targets_are_views() {
    for (target, name, bytes) in powergs_testkit::camera_files::seeds() {
        let file = if target == "cameras_colmap" {
            let (length, rest) = bytes.split_first_chunk::<2>().unwrap();
            let (cameras, images) = rest.split_at(usize::from(u16::from_le_bytes(*length)));
            colmap::read_binary(cameras, images)
        } else {
            json::read(std::str::from_utf8(&bytes).unwrap(), None)
        };
        let file = file.unwrap_or_else(|e| panic!("{target}/{name}: {e}"));
        assert!(!file.cameras.is_empty(), "{target}/{name}");
    }
}
