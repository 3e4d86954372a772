//! Points of COLMAP and of plain PLY files, and what is refused.

use std::fs;

use powergs_scene::PointCloud;
use powergs_scene::camera::colmap::{read_points_binary, read_points_text};
use powergs_scene::files::{open_colmap_points, open_point_ply};

const TEXT: &str = "\
# 3D point list with one line of data per point:
#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)
# Number of points: 2, mean track length: 1.5
7 1.5 -2 3e-1 255 0 51 0.4 1 0 2 5

9 0 0 1 0 0 0 0.1 1 1
";

fn cloud() -> PointCloud {
    PointCloud {
        positions: vec![[1.5, -2.0, 0.3], [0.0, 0.0, 1.0]],
        colours: vec![[1.0, 0.0, 0.2], [0.0; 3]],
    }
}

/// The same in binary.
fn binary() -> Vec<u8> {
    let mut bytes = 2_u64.to_le_bytes().to_vec();
    let points = [(7_u64, [1.5, -2.0, 0.3], [255, 0, 51], 2_u64), (9, [0.0, 0.0, 1.0], [0; 3], 1)];
    for (id, place, colour, track) in points {
        bytes.extend(id.to_le_bytes());
        place.iter().for_each(|v: &f64| bytes.extend(v.to_le_bytes()));
        bytes.extend(colour);
        bytes.extend(0.4_f64.to_le_bytes());
        bytes.extend(track.to_le_bytes());
        bytes.extend(vec![1; 8 * track as usize]);
    }
    bytes
}

#[test]
fn points_of_colmap_are_read() {
    assert_eq!(read_points_text(TEXT.as_bytes()).unwrap(), cloud());
    assert_eq!(read_points_binary(&binary()[..]).unwrap(), cloud());
    assert!(read_points_text(&b"# nothing\n"[..]).unwrap().is_empty());
}

#[test]
fn every_truncation_is_refused() {
    let bytes = binary();
    for end in 0..bytes.len() {
        let error = read_points_binary(&bytes[..end]).unwrap_err().to_string();
        assert!(error.starts_with("points3D.bin, byte "), "{error}");
    }
    let longer = [&bytes[..], &[0]].concat();
    let error = read_points_binary(&longer[..]).unwrap_err().to_string();
    assert!(error.contains("bytes follow the last of the points"), "{error}");
    // Promises that nobody allocates for.
    let mut many = bytes.clone();
    many[..8].fill(255);
    assert!(read_points_binary(&many[..]).is_err());
    let mut track = bytes.clone();
    track[8 + 43..8 + 51].fill(255);
    let error = read_points_binary(&track[..]).unwrap_err().to_string();
    assert!(error.contains("elements of a track are promised but not there"), "{error}");
    let mut far = bytes;
    far[16..24].copy_from_slice(&1e300_f64.to_le_bytes());
    let error = read_points_binary(&far[..]).unwrap_err().to_string();
    assert!(error.contains("is not a place"), "{error}");
}

#[test]
fn lines_that_are_no_points_are_named() {
    for (line, what) in [
        ("7 1 2", "line 1: the line ends before three coordinates"),
        ("7 1 2 x 0 0 0", "line 1: `x` is not three coordinates"),
        ("7 1 2 3 0 0 256", "line 1: `256` is not a colour"),
        ("7 1 2 inf 0 0 0", "is not a place"),
    ] {
        let error = read_points_text(line.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
}

#[test]
fn files_are_found() {
    let path = std::env::temp_dir().join(format!("powergs-points-{}", std::process::id()));
    let path = path.as_path();
    fs::create_dir_all(path).unwrap();
    assert_eq!(open_colmap_points(path).unwrap(), None);
    let model = path.join("sparse/0");
    fs::create_dir_all(&model).unwrap();
    fs::write(model.join("cameras.bin"), []).unwrap();
    assert_eq!(open_colmap_points(path).unwrap(), None);
    fs::write(model.join("points3D.bin"), binary()).unwrap();
    assert_eq!(open_colmap_points(path).unwrap(), Some(cloud()));
    let ply = path.join("points.ply");
    let head = "ply\nformat ascii 1.0\nelement vertex";
    let places = "property float x\nproperty float y\nproperty float z\n";
    let colours = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
    let rows = "1.5 -2 0.3 255 0 51\n0 0 1 0 0 0\n";
    fs::write(&ply, format!("{head} 2\n{places}{colours}end_header\n{rows}")).unwrap();
    assert_eq!(open_point_ply(&ply).unwrap(), cloud());
    fs::write(&ply, format!("{head} 1\n{places}end_header\n0 0 nan\n")).unwrap();
    assert!(open_point_ply(&ply).unwrap_err().to_string().contains("row 0"));
    fs::write(&ply, format!("{head} 0\n{places}end_header\n")).unwrap();
    assert!(open_point_ply(&ply).unwrap_err().to_string().contains("no points"));
    fs::write(&ply, format!("{head} 1\n{colours}end_header\n0 0 0\n")).unwrap();
    assert!(open_point_ply(&ply).unwrap_err().to_string().contains("no column `x`"));
    fs::remove_dir_all(path).unwrap();
}
