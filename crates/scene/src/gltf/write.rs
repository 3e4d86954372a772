//! Writes glTF: attributes as single-precision floats, or an SPZ file.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::super::Gaussians;
use super::super::convert::sigmoid;
use super::super::export::{Clamped, ExportError};
use super::super::spz;
use super::placement::turn_axes;
use super::{ANTIALIASED, EXTENSION, MAGIC};

/// How the JSON and the numbers of a file are put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Container {
    /// JSON, with the numbers as text.
    Json,
    /// Binary.
    Binary,
    /// Binary, with an SPZ file in place of the numbers.
    Spz,
}

/// The variant that says version 2 of SPZ, which has newer versions by now.
const SPZ_2: &str = "KHR_gaussian_splatting_compression_spz_2";
const FLOAT: u32 = 5126;

/// Attributes on their way into a buffer.
#[derive(Default)]
struct GltfBuffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    attributes: serde_json::Map<String, Value>,
}

impl GltfBuffer {
    fn push<const N: usize>(&mut self, name: &str, values: impl Iterator<Item = [f32; N]> + Clone) {
        let first = self.bytes.len();
        values.clone().flatten().for_each(|v| self.bytes.extend(v.to_le_bytes()));
        let mut accessor = self.describe::<N>(name, values);
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(json!({
            "buffer": 0, "byteOffset": first, "byteLength": self.bytes.len() - first,
        }));
        self.accessors.push(accessor);
    }

    /// An accessor without its numbers, and the attribute that it is of.
    fn describe<const N: usize>(
        &mut self,
        name: &str,
        values: impl Iterator<Item = [f32; N]> + Clone,
    ) -> Value {
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let count = values.clone().count();
        let mut accessor = json!({ "componentType": FLOAT, "count": count, "type": kind });
        let mut key = format!("{EXTENSION}:{name}");
        if name == "POSITION" {
            let end = |pick: fn(f32, f32) -> f32| {
                values.clone().reduce(|a, b| std::array::from_fn(|i| pick(a[i], b[i])))
            };
            let list = |v: Option<[f32; N]>| v.map(|v| v.to_vec());
            accessor["min"] = json!(list(end(f32::min)));
            accessor["max"] = json!(list(end(f32::max)));
            name.clone_into(&mut key);
        }
        self.attributes.insert(key, json!(self.accessors.len()));
        accessor
    }
}

/// The file, and what was cut off.
///
/// # Errors
/// Those of SPZ.
pub(crate) fn write(
    scene: &Gaussians,
    container: Container,
) -> Result<(Vec<u8>, Clamped), ExportError> {
    let mut buffer = GltfBuffer::default();
    let mut extension = json!({ "kernel": "ellipse", "colorSpace": "srgb_rec709_display" });
    let mut used = vec![EXTENSION];
    let mut turned = scene.clone();
    turn_axes(&mut turned);
    let clamped = if container == Container::Spz {
        let (bytes, clamped) = spz::write(scene)?;
        let positions = buffer.describe("POSITION", turned.means.iter().copied());
        buffer.accessors.push(positions);
        buffer.views.push(json!({ "buffer": 0, "byteLength": bytes.len() }));
        buffer.bytes = bytes;
        extension["extensions"] = json!({ SPZ_2: { "bufferView": 0 } });
        used.push(SPZ_2);
        clamped
    } else {
        attributes(&turned, &mut buffer)
    };
    let mut primitive = json!({
        "mode": 0,
        "attributes": buffer.attributes,
        "extensions": { EXTENSION: extension },
    });
    if scene.antialiased {
        primitive["extras"] = json!({ ANTIALIASED: true });
    }
    let mut document = json!({
        "asset": {
            "version": "2.0",
            "generator": concat!("powergs-sim ", env!("CARGO_PKG_VERSION")),
        },
        "extensionsUsed": used,
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [primitive] }],
        "accessors": buffer.accessors,
        "bufferViews": buffer.views,
        "buffers": [{ "byteLength": buffer.bytes.len() }],
    });
    if container == Container::Spz {
        document["extensionsRequired"] = json!(used);
    }
    if container == Container::Json {
        let data = STANDARD.encode(&buffer.bytes);
        document["buffers"][0]["uri"] =
            Value::String(format!("data:application/octet-stream;base64,{data}"));
        return Ok((document.to_string().into_bytes(), clamped));
    }
    Ok((binary(&document, buffer.bytes)?, clamped))
}

/// All attributes of a model that has the axes of glTF.
fn attributes(scene: &Gaussians, buffer: &mut GltfBuffer) -> Clamped {
    buffer.push("POSITION", scene.means.iter().copied());
    buffer.push(
        "ROTATION",
        scene.rotations.iter().map(|q| {
            let [w, x, y, z] = q.map(f64::from);
            let length = (w * w + x * x + y * y + z * z).sqrt();
            [x, y, z, w].map(|v| (v / length) as f32)
        }),
    );
    buffer.push("SCALE", scene.log_scales.iter().map(|s| s.map(f32::exp)));
    buffer.push("OPACITY", scene.logit_opacities.iter().map(|o| [sigmoid(*o) as f32]));
    let each = scene.sh_coefficients();
    for degree in 0..=usize::from(scene.sh_degree) {
        for n in 0..=2 * degree {
            let k = degree * degree + n;
            let colour = move |sh: &[f32]| [sh[k], sh[each + k], sh[2 * each + k]];
            let name = format!("SH_DEGREE_{degree}_COEF_{n}");
            buffer.push(&name, scene.sh.chunks_exact(3 * each).map(colour));
        }
    }
    // Below this, numbers of single precision lose their last bits and then everything.
    let is_lost = |s: &&f32| s.exp() < f32::MIN_POSITIVE;
    let is_opaque = |o: &&f32| sigmoid(**o) as f32 >= 1.0;
    Clamped {
        scale: scene.log_scales.as_flattened().iter().filter(is_lost).count() as u64,
        opacity: scene.logit_opacities.iter().filter(is_opaque).count() as u64,
        ..Clamped::default()
    }
}

/// The two chunks of a `.glb`, each filled up to whole words.
fn binary(document: &Value, mut numbers: Vec<u8>) -> Result<Vec<u8>, ExportError> {
    let mut json = document.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    numbers.resize(numbers.len().next_multiple_of(4), 0);
    let length = 12 + 8 + json.len() + 8 + numbers.len();
    let word = |n: usize| u32::try_from(n).map(u32::to_le_bytes);
    let too_long = |_| std::io::Error::other("a GLB of 4 GiB or more; write .gltf or .ply");
    let mut out = Vec::with_capacity(length);
    out.extend(MAGIC);
    out.extend(2_u32.to_le_bytes());
    out.extend(word(length).map_err(too_long)?);
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", numbers)] {
        out.extend(word(chunk.len()).map_err(too_long)?);
        out.extend(kind);
        out.extend(chunk);
    }
    Ok(out)
}
