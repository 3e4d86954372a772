//! Files that are not read: each is told by what it is.

use powergs_scene::camera::json;
use powergs_scene::{OneFile, read};
use powergs_testkit::scene_files::{Files, gzip, ply, sample, zipped};

#[test]
fn what_is_no_model_is_named() {
    let model = ply(&sample(5, 0));
    let archive = zipped(&Files::from([("run/point_cloud.ply".to_owned(), model.clone())]));
    let tileset = br#"{"asset": {"version": "1.1"}, "geometricError": 10, "root": {
        "content": {"uri": "a.glb"}, "children": [{"contents": [{"uri": "b.glb"}]},
        {"content": {"url": "c.glb"}}, {"content": {"uri": "d.glb"}}]}}"#;
    let cases: [(&str, &[u8], &[&str]); 9] = [
        ("tileset.json", tileset, &["3D Tiles", "a.glb, b.glb, c.glb, ..."]),
        ("model.ply.gz", &gzip(&model), &["a gzip file with a PLY file in it", "unpack"]),
        ("model.zip", &archive, &["a zip archive with `run/point_cloud.ply` in it", "unpack"]),
        ("a.ply", b"<!DOCTYPE html>\n<html></html>", &["web page (HTML)", "login"]),
        ("b.ply", b"\n<HTML><body>", &["web page (HTML)"]),
        ("c.ply", b"<?xml version='1.0'?><Error/>", &["XML document"]),
        ("d.ply", b"version https://git-lfs.github.com/spec/v1\n", &["Git LFS", "git lfs pull"]),
        ("cameras.json", b"[{\"id\": 0, \"img_name\": \"a\"}]", &["camera file", "--cameras"]),
        ("e.zst", &[0x28, 0xb5, 0x2f, 0xfd, 0, 0], &["zstd", "unpack"]),
    ];
    for (name, bytes, words) in cases {
        let error = read(&OneFile(bytes), name, None).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{name}: {error}");
        assert!(!error.contains("damaged"), "{name}: {error}");
    }
}

/// The point_cloud.ply of a trainer with another kernel, and one with other names.
#[test]
fn columns_that_are_there_are_named() {
    let of = |columns: &[&str]| {
        let mut text = String::from("ply\nformat ascii 1.0\nelement vertex 1\n");
        columns.iter().for_each(|name| text += &format!("property float {name}\n"));
        text += "end_header\n";
        text += &"0 ".repeat(columns.len());
        read(&OneFile(text.as_bytes()), "point_cloud.ply", None).unwrap_err().to_string()
    };
    let common = ["x", "y", "z", "opacity", "scale_0", "scale_1", "scale_2"];
    let turn = ["rot_0", "rot_1", "rot_2", "rot_3"];
    let beta = of(&[&common[..], &turn, &["sh0_0", "sb_params_0", "beta"]].concat());
    assert!(beta.contains("Beta Splatting") && beta.contains("kernel"), "{beta}");
    let others = of(&[&common[..], &turn, &["colour_0", "colour_1", "feature"]].concat());
    assert!(others.contains("no property `f_dc_0`"), "{others}");
    assert!(others.contains("rot_0..., colour_0..., feature"), "{others}");
}

#[test]
fn cameras_of_other_programs_are_named() {
    for (text, words) in [
        (
            r#"[{"cameras": {}, "shots": {"a.jpg": {}}, "points": {}}]"#,
            ["OpenSfM", "export_colmap"],
        ),
        (r#"{"sfm_data_version": "0.3", "views": []}"#, ["OpenMVG", "COLMAP"]),
        (r#"{"views": [], "poses": [], "intrinsics": []}"#, ["AliceVision", "COLMAP"]),
    ] {
        let error = json::read(text, None).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    }
}
