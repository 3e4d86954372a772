//! glTF: what is held, nodes, number types, and what is refused.

use std::collections::BTreeMap;

use glam::{DMat3, DQuat, DVec3};
use powergs_frame::scene::Camera;
use powergs_scene::export::{Files, Target, write};
use powergs_scene::{Gaussians, Model, OneFile, SceneError, Warning, read};
use powergs_testkit::scene_files::sample;
use serde_json::{Value, json};

fn bytes(scene: &Gaussians, target: Target) -> Vec<u8> {
    match write(scene, target).unwrap().files {
        Files::One(bytes) => bytes,
        Files::Folder(_) => panic!("one file"),
    }
}

fn open(bytes: &[u8]) -> Result<Model, SceneError> {
    read(&OneFile(bytes), "scene.gltf", None)
}

/// The JSON of a model, changed.
fn changed(scene: &Gaussians, change: impl FnOnce(&mut Value)) -> Vec<u8> {
    let mut json: Value = serde_json::from_slice(&bytes(scene, Target::Gltf)).unwrap();
    change(&mut json);
    json.to_string().into_bytes()
}

#[test]
fn attributes_are_held_to_the_last_bits() {
    for degree in 0..=3 {
        let scene = sample(60, degree);
        for target in [Target::Gltf, Target::Glb] {
            let model = open(&bytes(&scene, target)).unwrap();
            assert_eq!((model.format.name(), model.warnings), ("gltf", vec![]));
            let read = model.gaussians;
            assert_eq!((&read.means, &read.sh), (&scene.means, &scene.sh));
            let near = |a: &[f32], b: &[f32], most: f32| {
                a.iter().zip(b).all(|(a, b)| (a - b).abs() < most)
            };
            let flat = |g: &Gaussians| g.log_scales.as_flattened().to_vec();
            assert!(near(&flat(&read), &flat(&scene), 1e-6));
            let flat = |g: &Gaussians| g.rotations.as_flattened().to_vec();
            assert!(near(&flat(&read), &flat(&scene), 1e-6));
            assert!(near(&read.logit_opacities, &scene.logit_opacities, 1e-5));
        }
    }
}

/// In the file y is up and z is back, and so are quaternions.
#[test]
fn axes_of_the_file_are_those_of_gltf() {
    let scene = sample(3, 1);
    let json: Value = serde_json::from_slice(&bytes(&scene, Target::Gltf)).unwrap();
    let max = |axis: usize| json["accessors"][0]["max"][axis].as_f64().unwrap() as f32;
    let of = |axis: usize| scene.means.iter().map(move |m| m[axis]);
    assert_eq!(max(0), of(0).fold(f32::MIN, f32::max));
    assert_eq!(max(1), -of(1).fold(f32::MAX, f32::min));
    assert_eq!(max(2), -of(2).fold(f32::MAX, f32::min));
    assert_eq!(json["meshes"][0]["primitives"][0]["mode"], 0);
}

/// What a turned, scaled and moved camera sees of a scene that went the same way is the same.
#[test]
fn nodes_turn_scale_and_move_all_of_a_gaussian() {
    let mut scene = sample(200, 3);
    scene.log_scales.as_flattened_mut().iter_mut().for_each(|s| *s += 1.0);
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0);
    let (scale, shift) = (1.7, DVec3::new(3.0, -2.0, 0.5));
    let outer = json!({"translation": shift.to_array(), "children": [1]});
    let middle = json!({"rotation": turn.to_array(), "children": [2]});
    let matrix =
        [scale, 0.0, 0.0, 0.0, 0.0, scale, 0.0, 0.0, 0.0, 0.0, scale, 0.0, 0.0, 0.0, 0.0, 1.0];
    let inner = json!({"matrix": matrix, "mesh": 0});
    let text = changed(&scene, |json| json["nodes"] = json!([outer, middle, inner]));
    let moved = open(&text).unwrap().gaussians;
    // The same in the axes of PLY.
    let axes = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
    let (turn, shift) = (axes * DMat3::from_quat(turn) * axes, axes * shift);
    let camera =
        Camera::looking_at(DVec3::new(0.5, 0.2, -6.0), DVec3::ZERO, DVec3::NEG_Y, 0.5, (96, 64));
    let along = Camera {
        centre: turn * camera.centre * scale + shift,
        world_to_camera: camera.world_to_camera * turn.transpose(),
        ..camera.clone()
    };
    let colours = |scene: &Gaussians, camera: &Camera| {
        let eye = camera.centre.to_array().map(|v| v as f32);
        let level = fearless_simd::Level::new();
        powergs_frame::splat::project::colours(scene, eye, level)
    };
    for (a, b) in colours(&scene, &camera).iter().zip(colours(&moved, &along)) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-6), "{a:?} {b:?}");
    }
    for i in 0..scene.len() {
        let covariance = |scene: &Gaussians| {
            let [w, x, y, z] = scene.rotations[i].map(f64::from);
            let rotation = DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize());
            let s = DVec3::from_array(scene.log_scales[i].map(|s| f64::from(s).exp()));
            rotation * DMat3::from_diagonal(s * s) * rotation.transpose()
        };
        let want = turn * covariance(&scene) * turn.transpose() * (scale * scale);
        let off = (covariance(&moved) - want).to_cols_array();
        assert!(off.iter().all(|v| v.abs() < 1e-6), "{off:?}");
        let mean = |scene: &Gaussians| DVec3::from_array(scene.means[i].map(f64::from));
        assert!((mean(&moved) - (turn * mean(&scene) * scale + shift)).length() < 1e-5);
    }
}

#[test]
fn spz_inside_is_spz_alone() {
    let scene = Gaussians { antialiased: true, ..sample(50, 2) };
    let inside = read(&OneFile(&bytes(&scene, Target::GlbSpz)), "scene.glb", None).unwrap();
    let alone = read(&OneFile(&bytes(&scene, Target::Spz)), "scene.spz", None).unwrap();
    assert_eq!(inside.gaussians, alone.gaussians);
    assert_eq!(inside.warnings, [Warning::Antialiased]);
    assert_eq!(inside.format.name(), "gltf");
}

/// Integers that stand for fractions, strides, several primitives, a buffer in a file of its own,
/// and logarithms of scales as drafts have them.
#[test]
fn other_writers() {
    let name = |name: &str| format!("KHR_gaussian_splatting:{name}");
    let mut buffer = Vec::new();
    let mut views = Vec::new();
    let mut view = |bytes: &[u8], stride: Option<u32>| {
        let first = buffer.len();
        buffer.extend(bytes);
        buffer.resize(buffer.len().next_multiple_of(4), 0);
        let mut view = json!({"buffer": 0, "byteOffset": first, "byteLength": bytes.len()});
        if let Some(stride) = stride {
            view["byteStride"] = json!(stride);
        }
        views.push(view);
    };
    let floats = |v: &[f32]| v.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<_>>();
    view(&floats(&[1.0, 2.0, 3.0, 99.0, 4.0, 5.0, 6.0, 99.0]), Some(16));
    view(&[127, 0, 0, 0, 0, 0, 0, 0x81], None);
    view(&floats(&[-1.0, -2.0, -3.0, -1.0, -2.0, -3.0]), None);
    view(&[51, 255], None);
    view(&floats(&[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), None);
    let accessor = |view: usize, component: u32, kind: &str| {
        json!({"bufferView": view, "componentType": component, "count": 2, "type": kind,
            "normalized": component != 5126})
    };
    let attributes = json!({"POSITION": 0, name("ROTATION"): 1, name("SCALE"): 2,
        name("OPACITY"): 3, name("SH_DEGREE_0_COEF_0"): 4});
    let extensions = json!({"KHR_gaussian_splatting":
        {"kernel": "ellipse", "colorSpace": "lin_rec709_display"}});
    let primitive = json!({"mode": 0, "attributes": attributes, "extensions": extensions});
    let text = json!({"asset": {"version": "2.0"},
        "buffers": [{"uri": "a%20b.bin", "byteLength": buffer.len()}], "bufferViews": views,
        "accessors": [accessor(0, 5126, "VEC3"), accessor(1, 5120, "VEC4"),
            accessor(2, 5126, "VEC3"), accessor(3, 5121, "SCALAR"), accessor(4, 5126, "VEC3")],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}, primitive, primitive]}]});
    let files = BTreeMap::from([
        ("scene.gltf".to_owned(), text.to_string().into_bytes()),
        ("a b.bin".to_owned(), buffer),
    ]);
    let model = read(&files, "scene.gltf", None).unwrap();
    let scene = model.gaussians;
    assert_eq!(model.warnings, [Warning::LinearColours, Warning::LogarithmicScales]);
    assert_eq!(scene.means[..2], [[1.0, -2.0, -3.0], [4.0, -5.0, -6.0]]);
    assert_eq!((scene.len(), scene.means[0]), (4, scene.means[2]));
    assert_eq!(scene.rotations[..2], [[0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0]]);
    assert_eq!(scene.log_scales[0], [-1.0, -2.0, -3.0]);
    assert_eq!(scene.logit_opacities[0], 0.25_f32.ln());
    assert_eq!(1.0 / (1.0 + (-scene.logit_opacities[1]).exp()), 1.0);
    assert_eq!(scene.sh[..6], [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
}

#[test]
fn damage_and_features_are_named() {
    let scene = sample(5, 1);
    let error = |change: &dyn Fn(&mut Value)| {
        open(&changed(&scene, |json| change(json))).unwrap_err().to_string()
    };
    let check = |change: &dyn Fn(&mut Value), want: &str| {
        let message = error(change);
        assert!(message.contains(want), "{message}, not {want}");
    };
    check(&|j| j["asset"]["version"] = json!("1.0"), "version");
    check(&|j| j["accessors"][1]["count"] = json!(6), "6 entries do not fit");
    check(&|j| j["accessors"][1]["count"] = json!(2_000_000_000_u64), "promises");
    check(&|j| j["accessors"][1]["count"] = json!(4), "4 entries for 5 positions");
    check(&|j| j["accessors"][1]["byteOffset"] = json!(u64::MAX), "do not fit");
    check(&|j| j["accessors"][2]["type"] = json!("VEC4"), "instead of 3 components");
    check(&|j| j["accessors"][2]["componentType"] = json!(5125), "type of numbers");
    check(&|j| j["accessors"][2]["sparse"] = json!({}), "sparse");
    check(&|j| j["accessors"][2]["bufferView"] = json!(99), "bufferViews[99]: is missing");
    check(&|j| j["bufferViews"][2]["byteOffset"] = json!(u64::MAX), "bytes from byte");
    check(
        &|j| j["bufferViews"][2]["extensions"] = json!({"EXT_meshopt_compression": {}}),
        "compressed by EXT_meshopt_compression",
    );
    check(&|j| j["buffers"][0]["uri"] = json!("data:x;base64,!"), "not base64");
    check(&|j| j["buffers"][0]["uri"] = json!("../a.bin"), "leaves the folder");
    check(&|j| j["nodes"] = json!([{"children": [0], "mesh": 0}]), "two parents");
    check(&|j| j["nodes"] = json!([{"scale": [1, 2, 1], "mesh": 0}]), "scales unevenly");
    check(&|j| j["nodes"] = json!([{"scale": [-1, 1, 1], "mesh": 0}]), "mirrors");
    check(&|j| j["nodes"] = json!([{"matrix": [1], "mesh": 0}]), "16 numbers");
    check(&|j| j["nodes"] = json!([{"mesh": 7}]), "meshes[7]");
    let primitive = |j: &mut Value| j["meshes"][0]["primitives"][0].take();
    check(&|j| drop(primitive(j)), "no primitive with the extension");
    check(
        &|j| {
            j["meshes"][0]["primitives"][0]["extensions"]["KHR_gaussian_splatting"]["kernel"] =
                json!("disc");
        },
        "`disc`",
    );
    check(
        &|j| {
            let attributes = &mut j["meshes"][0]["primitives"][0]["attributes"];
            attributes.as_object_mut().unwrap().remove("KHR_gaussian_splatting:SCALE");
        },
        "SCALE: is missing",
    );
    // A thousand nodes that show one mesh.
    let many = sample(100, 0);
    let bomb = changed(&many, |json| {
        let nodes: Vec<Value> = (0..100_000).map(|_| json!({"mesh": 0})).collect();
        json["scenes"][0]["nodes"] = json!((0..nodes.len()).collect::<Vec<_>>());
        json["nodes"] = json!(nodes);
    });
    assert!(open(&bomb).unwrap_err().to_string().contains("too small"));
    // Every cut of a binary file is refused, and none panics.
    let glb = bytes(&scene, Target::Glb);
    for end in 4..glb.len() {
        assert!(read(&OneFile(&glb[..end]), "scene.glb", None).is_err(), "{end} bytes");
    }
}
