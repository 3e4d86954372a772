//! glTF of other writers: logits, vertex colours, drafts, and files that take for ever.

use powergs_scene::export::{Files, Target, write};
use powergs_scene::{Gaussians, Warning};
use powergs_testkit::scene_files::sample;
use serde_json::{Value, json};

use crate::scene::read_bytes;

const EXTENSION: &str = "KHR_gaussian_splatting";

/// A binary glTF in parts.
struct Glb {
    json: Value,
    binary: Vec<u8>,
}

impl Glb {
    fn of(scene: &Gaussians) -> Glb {
        let Files::One(bytes) = write(scene, Target::Glb).unwrap().files else {
            panic!("one file");
        };
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let json = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
        Glb { json, binary: bytes[28 + length..].to_vec() }
    }

    fn attributes(&mut self) -> &mut serde_json::Map<String, Value> {
        let attributes = &mut self.json["meshes"][0]["primitives"][0]["attributes"];
        attributes.as_object_mut().unwrap()
    }

    /// Other numbers of an attribute.
    fn put(&mut self, name: &str, values: &[f32]) {
        let accessor = self.attributes()[&format!("{EXTENSION}:{name}")].as_u64().unwrap();
        let view = &self.json["accessors"][accessor as usize]["bufferView"];
        let view = &self.json["bufferViews"][view.as_u64().unwrap() as usize];
        let first = view["byteOffset"].as_u64().unwrap() as usize;
        for (slot, value) in self.binary[first..].chunks_exact_mut(4).zip(values) {
            slot.copy_from_slice(&value.to_le_bytes());
        }
    }

    /// One attribute more, of four numbers each.
    fn add(&mut self, name: &str, values: &[[f32; 4]]) {
        let first = self.binary.len();
        values.as_flattened().iter().for_each(|v| self.binary.extend(v.to_le_bytes()));
        let list = |json: &mut Value, key: &str, entry: Value| {
            let list = json[key].as_array_mut().unwrap();
            list.push(entry);
            list.len() - 1
        };
        let length = self.binary.len() - first;
        let view = json!({ "buffer": 0, "byteOffset": first, "byteLength": length });
        let view = list(&mut self.json, "bufferViews", view);
        let (kind, count) = ("VEC4", values.len());
        let accessor =
            json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
        let accessor = list(&mut self.json, "accessors", accessor);
        self.attributes().insert(name.to_owned(), json!(accessor));
        self.json["buffers"][0]["byteLength"] = json!(self.binary.len());
    }

    fn bytes(&self) -> Vec<u8> {
        let mut json = self.json.to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let length = |n: usize| (n as u32).to_le_bytes();
        let whole = 28 + json.len() + self.binary.len();
        let parts: [&[u8]; 8] = [
            b"glTF",
            &length(2),
            &length(whole),
            &length(json.len()),
            b"JSON",
            &json,
            &length(self.binary.len()),
            b"BIN\0",
        ];
        [parts.concat(), self.binary.clone()].concat()
    }
}

fn near(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4)
}

#[test]
fn opacities_that_are_logits_are_read_as_logits() {
    let scene = sample(60, 1);
    let mut glb = Glb::of(&scene);
    glb.put("OPACITY", &scene.logit_opacities);
    let model = read_bytes(&glb.bytes()).unwrap();
    assert_eq!(model.warnings, [Warning::LogitOpacities]);
    assert_eq!(model.gaussians.logit_opacities, scene.logit_opacities);
    assert!(near(model.gaussians.log_scales.as_flattened(), scene.log_scales.as_flattened()));
}

/// One number that went wrong does not decide what the others are.
#[test]
fn one_opacity_above_1_or_one_negative_scale_decides_nothing() {
    let scene = sample(60, 0);
    let shares: Vec<f32> = scene.logit_opacities.iter().map(|o| 1.0 / (1.0 + (-o).exp())).collect();
    let mut glb = Glb::of(&scene);
    let with = |at: usize, value: f32| {
        let mut shares = shares.clone();
        shares[at] = value;
        shares
    };
    glb.put("OPACITY", &with(7, 1.5));
    let model = read_bytes(&glb.bytes()).unwrap();
    assert_eq!(model.warnings, [Warning::Dropped { count: 1, first: 7 }]);
    let kept = [&scene.logit_opacities[..7], &scene.logit_opacities[8..]].concat();
    assert!(near(&model.gaussians.logit_opacities, &kept));
    // Rounded: opaque, and invisible.
    for (value, opacity) in [(1.000_001, 1.0), (-0.000_001, 0.0)] {
        glb.put("OPACITY", &with(7, value));
        let model = read_bytes(&glb.bytes()).unwrap();
        assert_eq!((model.warnings.len(), model.gaussians.len()), (0, 60));
        let read = 1.0 / (1.0 + (-model.gaussians.logit_opacities[7]).exp());
        assert!((read - opacity).abs() < 1e-6, "{value}: {read}");
    }
    let mut glb = Glb::of(&scene);
    let mut scales: Vec<f32> = scene.log_scales.as_flattened().iter().map(|s| s.exp()).collect();
    scales[10] *= -1.0;
    glb.put("SCALE", &scales);
    let model = read_bytes(&glb.bytes()).unwrap();
    assert_eq!(model.warnings, [Warning::NonPositiveScales { count: 1 }]);
    let (read, own) = (model.gaussians.log_scales.as_flattened(), scene.log_scales.as_flattened());
    assert!(near(&read[..10], &own[..10]) && near(&read[11..], &own[11..]));
    // Logarithms some of which are above 0.
    let mut logarithms = scene.log_scales.as_flattened().to_vec();
    logarithms[..100].fill(0.5);
    glb.put("SCALE", &logarithms);
    let model = read_bytes(&glb.bytes()).unwrap();
    assert_eq!(model.warnings, [Warning::LogarithmicScales]);
    assert_eq!(model.gaussians.log_scales.as_flattened(), logarithms);
}

/// A file without spherical harmonics has the colours that viewers of plain points show; drafts of
/// 2025 keep opacities there, too, and have other names.
#[test]
fn colours_and_opacities_of_vertices() {
    let scene = sample(60, 0);
    let colours: Vec<[f32; 4]> =
        (0..60).map(|i| [0.1, 0.5, i as f32 / 60.0, 0.2 + 0.01 * i as f32]).collect();
    let check = |glb: &Glb, opacity: &dyn Fn(usize) -> f32| {
        let model = read_bytes(&glb.bytes()).unwrap();
        assert_eq!(model.warnings, [Warning::VertexColours]);
        let read = model.gaussians;
        for (i, [r, g, b, _]) in colours.iter().enumerate() {
            let dc = [*r, *g, *b].map(|c| (c - 0.5) / 0.282_094_8);
            assert!(near(read.sh_of(i), &dc), "{i}: {:?}", read.sh_of(i));
            assert!((read.logit_opacities[i] - opacity(i)).abs() < 1e-4, "{i}");
        }
        assert!(near(read.log_scales.as_flattened(), scene.log_scales.as_flattened()));
        assert!(near(read.rotations.as_flattened(), scene.rotations.as_flattened()));
    };
    let mut glb = Glb::of(&scene);
    glb.attributes().remove(&format!("{EXTENSION}:SH_DEGREE_0_COEF_0")).unwrap();
    glb.add("COLOR_0", &colours);
    check(&glb, &|i| scene.logit_opacities[i]);
    glb.attributes().remove(&format!("{EXTENSION}:OPACITY")).unwrap();
    for name in ["ROTATION", "SCALE"] {
        let accessor = glb.attributes().remove(&format!("{EXTENSION}:{name}")).unwrap();
        glb.attributes().insert(format!("_{name}"), accessor);
    }
    check(&glb, &|i| {
        let alpha = colours[i][3];
        (alpha / (1.0 - alpha)).ln()
    });
    glb.attributes().remove("COLOR_0").unwrap();
    let error = read_bytes(&glb.bytes()).unwrap_err().to_string();
    assert!(error.contains("OPACITY: is missing, and so is COLOR_0"), "{error}");
}

/// Every node that shows a mesh used to go through all of its primitives, and copy them.
#[test]
fn nodes_times_primitives_are_no_work() {
    let n = 30_000;
    let many = json!({
        "asset": { "version": "2.0" },
        "nodes": vec![json!({ "mesh": 0 }); n],
        "meshes": [{ "primitives": vec![json!({}); n] }],
    });
    let error = read_bytes(many.to_string().as_bytes()).unwrap_err().to_string();
    assert!(error.contains("no primitive with the extension"), "{error}");
    // Many primitives of one buffer are refused before they are all in memory.
    let mut glb = Glb::of(&sample(100, 0));
    let primitive = glb.json["meshes"][0]["primitives"][0].clone();
    glb.json["meshes"][0]["primitives"] = vec![primitive; 10_000].into();
    let error = read_bytes(&glb.bytes()).unwrap_err().to_string();
    assert!(error.contains("too small"), "{error}");
}

/// A mesh that several nodes show is there as often, each time where its node is.
#[test]
fn several_nodes_show_one_mesh() {
    let scene = sample(5, 0);
    let mut glb = Glb::of(&scene);
    let node = |x: f32| json!({ "mesh": 0, "translation": [x, 0, 0] });
    glb.json["nodes"] = json!([node(1.0), node(2.0), node(4.0)]);
    glb.json["scenes"][0]["nodes"] = json!([0, 1, 2]);
    let read = read_bytes(&glb.bytes()).unwrap().gaussians;
    assert_eq!(read.len(), 15);
    for (copy, shift) in [1.0, 2.0, 4.0].into_iter().enumerate() {
        let means = &read.means[5 * copy..5 * copy + 5];
        let own = scene.means.iter().map(|m| [m[0] + shift, m[1], m[2]]).collect::<Vec<_>>();
        assert!(near(means.as_flattened(), own.as_flattened()), "copy {copy}");
    }
}
