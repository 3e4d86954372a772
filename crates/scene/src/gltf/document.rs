//! The JSON of a glTF file, its buffers, and the attributes of primitives.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value};

use super::super::convert::{dc, rest_of};
use super::super::error::{DAMAGED, REEXPORT, SceneError};
use super::super::input::{Folder, Input, check_count, clip, open, plausible};
use super::super::read::Model;
use super::super::spz;
use super::super::{Gaussians, Warning};
use super::dialect::GltfPart;
use super::placement::turn_axes;
use super::{ANTIALIASED, EXTENSION, MAGIC, SPZ, SPZ_DRAFT};

/// Largest buffer, bytes.
const MAX_BUFFER: u64 = 16 << 30;
const DATA: &str = "data:";
/// The colours that a mesh without the extension has.
const VERTEX_COLOUR: &str = "COLOR_0";

/// The JSON and the binary chunk of a `.glb`; without one it is empty.
pub(super) fn chunks(bytes: &[u8]) -> Result<(&[u8], &[u8]), SceneError> {
    let short = |what: &str| SceneError::truncated("GLB", what.to_owned());
    let word = |at: usize| -> Option<u32> {
        bytes.get(at..at + 4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(short("the header is cut off"));
    };
    if version != 2 || !bytes.starts_with(MAGIC) {
        let what = format!("version {version}; 2 is known");
        return Err(SceneError::malformed("GLB", what, REEXPORT));
    }
    if (length as usize) > bytes.len() {
        return Err(short(&format!("{} of {length} bytes", bytes.len())));
    }
    let (mut at, mut json, mut binary) = (12, None, None);
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let end = (at + 8).checked_add(length as usize).filter(|end| *end <= bytes.len());
        let Some(end) = end else { return Err(short("a chunk is cut off")) };
        match &kind.to_le_bytes() {
            b"JSON" => json = json.or(Some(&bytes[at + 8..end])),
            b"BIN\0" => binary = binary.or(Some(&bytes[at + 8..end])),
            _ => {}
        }
        at = end;
    }
    match json {
        Some(json) => Ok((json, binary.unwrap_or_default())),
        None => Err(SceneError::malformed("GLB", "no JSON chunk", DAMAGED)),
    }
}

/// A file whose buffers are opened as they are asked for.
pub(super) struct Document<'a> {
    keys: Map<String, Value>,
    /// That of a `.glb`.
    binary: Option<&'a [u8]>,
    folder: &'a dyn Folder,
    prefix: &'a str,
    buffers: BTreeMap<usize, Cow<'a, [u8]>>,
}

/// A list of vectors in a buffer.
struct Accessor<'b> {
    bytes: &'b [u8],
    count: usize,
    stride: usize,
    component: DocumentComponent,
}

/// The number at the start of bytes.
type GltfNumber = fn(&[u8]) -> f64;

/// The type of a number, and whether it stands for a fraction.
#[derive(Clone, Copy)]
struct DocumentComponent {
    bytes: usize,
    of: GltfNumber,
    /// What an integer is divided by.
    whole: f64,
}

impl DocumentComponent {
    fn new(kind: u64, is_normalized: bool) -> Option<DocumentComponent> {
        let (bytes, of, most): (usize, GltfNumber, f64) = match kind {
            5120 => (1, |b| f64::from(b[0] as i8), 127.0),
            5121 => (1, |b| f64::from(b[0]), 255.0),
            5122 => (2, |b| f64::from(i16::from_le_bytes([b[0], b[1]])), 32_767.0),
            5123 => (2, |b| f64::from(u16::from_le_bytes([b[0], b[1]])), 65_535.0),
            5126 => (4, |b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])), 1.0),
            _ => return None,
        };
        Some(DocumentComponent { bytes, of, whole: if is_normalized { most } else { 1.0 } })
    }

    fn value(self, bytes: &[u8]) -> f64 {
        // The lowest of a signed type is below -1.
        ((self.of)(bytes) / self.whole).max(if self.whole > 1.0 { -1.0 } else { f64::MIN })
    }
}

impl<'a> Document<'a> {
    pub(super) fn new(
        keys: Map<String, Value>,
        binary: Option<&'a [u8]>,
        folder: &'a dyn Folder,
        prefix: &'a str,
    ) -> Result<Document<'a>, SceneError> {
        let version = keys.get("asset").and_then(|asset| asset.get("version"));
        match version.and_then(Value::as_str) {
            Some(version) if version.starts_with("2.") => {}
            other => {
                let what = format!("version {other:?}; 2.0 is known");
                return Err(SceneError::malformed("glTF", what, REEXPORT));
            }
        }
        Ok(Document { keys, binary, folder, prefix, buffers: BTreeMap::new() })
    }

    /// Bytes of the buffers that were read.
    pub(super) fn read_bytes(&self) -> u64 {
        self.buffers.values().map(|buffer| buffer.len() as u64).sum()
    }

    /// Entry `index` of a list at the top.
    pub(super) fn entry(&self, list: &str, index: usize) -> Result<&Value, SceneError> {
        let entries = self.keys.get(list).and_then(Value::as_array);
        let entry = entries.and_then(|entries| entries.get(index));
        entry.ok_or_else(|| wrong(&format!("{list}[{index}]"), "is missing"))
    }

    /// Entries of a list at the top.
    pub(super) fn count(&self, list: &str) -> usize {
        self.keys.get(list).and_then(Value::as_array).map_or(0, Vec::len)
    }

    /// The scene that is shown, if the file has scenes.
    pub(super) fn scene(&self) -> Result<Option<&Value>, SceneError> {
        if self.count("scenes") == 0 {
            return Ok(None);
        }
        let shown = self.keys.get("scene").and_then(Value::as_u64).unwrap_or(0);
        self.entry("scenes", shown as usize).map(Some)
    }

    /// The Gaussians of a mesh, by its primitives; `others` is the number of those of other meshes.
    pub(super) fn parts(&mut self, mesh: usize, others: u64) -> Result<Vec<GltfPart>, SceneError> {
        let primitives = self.entry("meshes", mesh)?.get("primitives").and_then(Value::as_array);
        // Buffers are read on the way.
        let primitives = primitives.cloned().unwrap_or_default();
        let (mut parts, mut total) = (Vec::new(), others);
        for primitive in &primitives {
            let Some(part) = self.gaussians(primitive)? else { continue };
            total += part.gaussians.len() as u64;
            // Many primitives may have one buffer: a bomb.
            check_count("glTF", total, plausible(self.read_bytes()))?;
            parts.push(part);
        }
        Ok(parts)
    }

    /// The Gaussians of a primitive, in the axes of PLY; `None` if it is something else.
    fn gaussians(&mut self, primitive: &Value) -> Result<Option<GltfPart>, SceneError> {
        let extensions = |of: &Value| of.get("extensions").and_then(Value::as_object).cloned();
        let own = extensions(primitive).unwrap_or_default();
        let draft = own.get(SPZ_DRAFT);
        let Some(extension) = own.get(EXTENSION).or(draft) else { return Ok(None) };
        let kernel = extension.get("kernel").and_then(Value::as_str).unwrap_or("ellipse");
        if kernel != "ellipse" {
            let what = format!("the kernel `{}`; `ellipse` is known", clip(kernel));
            return Err(SceneError::malformed("glTF", what, REEXPORT));
        }
        let inner = extensions(extension).unwrap_or_default();
        let packed = inner.iter().find(|(name, _)| name.starts_with(SPZ)).map(|(_, v)| v);
        let mut part = match packed.or(draft) {
            Some(packed) => {
                let view = index(packed, "bufferView", SPZ)?;
                let (range, buffer) = self.view(view)?;
                let bytes = &self.buffers[&buffer][range];
                let input = Input { reader: Box::new(bytes), len: bytes.len() as u64 };
                let Model { gaussians, warnings, format: _ } = spz::read(input, None)?;
                GltfPart { gaussians, warnings, stored: None }
            }
            None => {
                let Some(Value::Object(attributes)) = primitive.get("attributes") else {
                    return Err(wrong("primitives.attributes", "is missing"));
                };
                self.attributes(attributes)?
            }
        };
        if primitive.pointer(&format!("/extras/{ANTIALIASED}")) == Some(&Value::Bool(true)) {
            part.gaussians.antialiased = true;
        }
        let space = extension.get("colorSpace").and_then(Value::as_str);
        if space.is_some_and(|space| space.starts_with("lin_")) {
            part.warnings.push(Warning::LinearColours);
        }
        Ok(Some(part))
    }

    fn attributes(&mut self, attributes: &Map<String, Value>) -> Result<GltfPart, SceneError> {
        let number = |name: &str| attributes.get(name).and_then(Value::as_u64);
        // Drafts of 2025 put an underscore where the standard has the extension.
        let named = |name: &str| {
            number(&format!("{EXTENSION}:{name}")).or_else(|| number(&format!("_{name}")))
        };
        let need = |name: &str| {
            named(name).ok_or_else(|| wrong(&format!("attribute {EXTENSION}:{name}"), "is missing"))
        };
        let position =
            number("POSITION").ok_or_else(|| wrong("attribute POSITION", "is missing"))?;
        let (rotation, scale) = (need("ROTATION")?, need("SCALE")?);
        let coefficient = |degree: usize, n: usize| named(&format!("SH_DEGREE_{degree}_COEF_{n}"));
        // Viewers without the extension, and drafts of it, take vertex colours.
        let vertex = number(VERTEX_COLOUR);
        let (opacity, constant) = (named("OPACITY"), coefficient(0, 0));
        for (found, name) in [(opacity, "OPACITY"), (constant, "SH_DEGREE_0_COEF_0")] {
            if found.is_none() && vertex.is_none() {
                let what = format!("is missing, and so is {VERTEX_COLOUR}");
                return Err(wrong(&format!("attribute {EXTENSION}:{name}"), what));
            }
        }
        let is_whole = |degree: &usize| (0..=2 * degree).all(|n| coefficient(*degree, n).is_some());
        let degree = (1..=3).take_while(is_whole).count();
        let means = self.vectors::<3>(position, None)?;
        let count = Some(means.len());
        let mut scene = Gaussians { sh_degree: degree as u8, ..Gaussians::default() };
        scene.means = means.into_iter().map(|v| v.map(|x| x as f32)).collect();
        let turned = |[x, y, z, w]: [f64; 4]| [w as f32, x as f32, y as f32, z as f32];
        scene.rotations = self.vectors(rotation, count)?.into_iter().map(turned).collect();
        let scales = self.vectors::<3>(scale, count)?;
        scene.log_scales = scales.into_iter().map(|v| v.map(|s| s as f32)).collect();
        let mut warnings = Vec::new();
        let painted = match vertex.filter(|_| opacity.is_none() || constant.is_none()) {
            Some(vertex) => {
                warnings.push(Warning::VertexColours);
                self.vertex_colours(vertex, count)?
            }
            None => Vec::new(),
        };
        let stored: Vec<f64> = match opacity {
            Some(opacity) => self.vectors::<1>(opacity, count)?.into_flattened(),
            None => painted.iter().map(|[.., alpha]| *alpha).collect(),
        };
        let each = 1 + rest_of(scene.sh_degree);
        scene.sh = vec![0.0; 3 * each * scene.len()];
        if constant.is_none() {
            for (sh, colour) in scene.sh.chunks_exact_mut(3 * each).zip(&painted) {
                let channels = sh.iter_mut().step_by(each).zip(colour);
                channels.for_each(|(slot, channel)| *slot = dc(*channel));
            }
        }
        let all = (0..=degree).flat_map(|degree| (0..=2 * degree).map(move |n| (degree, n)));
        for (k, (degree, n)) in all.enumerate() {
            let Some(accessor) = coefficient(degree, n) else { continue };
            for (i, colour) in self.vectors::<3>(accessor, count)?.into_iter().enumerate() {
                for (channel, value) in colour.into_iter().enumerate() {
                    scene.sh[(3 * i + channel) * each + k] = value as f32;
                }
            }
        }
        turn_axes(&mut scene);
        Ok(GltfPart { gaussians: scene, warnings, stored: Some(stored) })
    }

    /// Red, green, blue and alpha of each vertex; alpha is 1 where there is none.
    fn vertex_colours(
        &mut self,
        accessor: u64,
        expected: Option<usize>,
    ) -> Result<Vec<[f64; 4]>, SceneError> {
        let kind = self.entry("accessors", accessor as usize)?.get("type").and_then(Value::as_str);
        if kind == Some("VEC3") {
            let opaque = |[r, g, b]: [f64; 3]| [r, g, b, 1.0];
            return Ok(self.vectors(accessor, expected)?.into_iter().map(opaque).collect());
        }
        self.vectors(accessor, expected)
    }

    /// The vectors of an accessor, `expected` of them.
    fn vectors<const N: usize>(
        &mut self,
        accessor: u64,
        expected: Option<usize>,
    ) -> Result<Vec<[f64; N]>, SceneError> {
        let place = format!("accessors[{accessor}]");
        let Accessor { bytes, count, stride, component } =
            self.accessor::<N>(accessor as usize, &place)?;
        if expected.is_some_and(|expected| expected != count) {
            let what = format!("{count} entries for {} positions", expected.unwrap_or(0));
            return Err(wrong(&place, what));
        }
        let value =
            |row: usize, k: usize| component.value(&bytes[row * stride + k * component.bytes..]);
        Ok((0..count).map(|row| std::array::from_fn(|k| value(row, k))).collect())
    }

    fn accessor<const N: usize>(
        &mut self,
        accessor: usize,
        place: &str,
    ) -> Result<Accessor<'_>, SceneError> {
        let keys = self.entry("accessors", accessor)?.clone();
        let number = |key: &str| keys.get(key).and_then(Value::as_u64);
        let kind = keys.get("type").and_then(Value::as_str);
        if kind != Some(["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1]) {
            return Err(wrong(place, format!("type {kind:?} instead of {N} components")));
        }
        if keys.get("sparse").is_some() {
            return Err(SceneError::malformed(place, "a sparse accessor", REEXPORT));
        }
        let is_normalized = keys.get("normalized") == Some(&Value::Bool(true));
        let component =
            number("componentType").and_then(|t| DocumentComponent::new(t, is_normalized));
        let component = component.ok_or_else(|| wrong(place, "an unknown type of numbers"))?;
        let Some(count) = number("count") else { return Err(wrong(place, "has no count")) };
        let view = index(&keys, "bufferView", place)?;
        let stride = self.entry("bufferViews", view)?.get("byteStride").and_then(Value::as_u64);
        let row = N * component.bytes;
        let stride = stride.map_or(row, |stride| stride as usize);
        let (range, buffer) = self.view(view)?;
        let bytes = &self.buffers[&buffer][range];
        let count = check_count(place, count, plausible(bytes.len() as u64))?;
        let first = number("byteOffset").unwrap_or(0) as usize;
        let end = (count - 1).checked_mul(stride).and_then(|n| n.checked_add(row));
        let end = end.and_then(|n| n.checked_add(first));
        if stride < row || end.is_none_or(|end| end > bytes.len()) {
            let what = format!("{count} entries do not fit into {} bytes", bytes.len());
            return Err(SceneError::truncated(place, what));
        }
        Ok(Accessor { bytes: &bytes[first..], count, stride, component })
    }

    /// The bytes of a buffer view: where they are, and in which buffer, which is read.
    fn view(&mut self, view: usize) -> Result<(std::ops::Range<usize>, usize), SceneError> {
        let place = format!("bufferViews[{view}]");
        let keys = self.entry("bufferViews", view)?.clone();
        if let Some(extensions) = keys.get("extensions").and_then(Value::as_object)
            && let Some(name) = extensions.keys().next()
        {
            let what = format!("is compressed by {}, which is not read", clip(name));
            return Err(SceneError::malformed(place, what, REEXPORT));
        }
        let number = |key: &str| keys.get(key).and_then(Value::as_u64);
        let buffer = index(&keys, "buffer", &place)?;
        let first = number("byteOffset").unwrap_or(0) as usize;
        let Some(length) = number("byteLength") else {
            return Err(wrong(&place, "has no byteLength"));
        };
        self.load(buffer)?;
        let have = self.buffers[&buffer].len();
        match first.checked_add(length as usize).filter(|end| *end <= have) {
            Some(end) => Ok((first..end, buffer)),
            None => {
                let what = format!("{length} bytes from byte {first} of a buffer of {have}");
                Err(SceneError::truncated(place, what))
            }
        }
    }

    /// Reads a buffer, unless it was.
    fn load(&mut self, buffer: usize) -> Result<(), SceneError> {
        if self.buffers.contains_key(&buffer) {
            return Ok(());
        }
        let place = format!("buffers[{buffer}]");
        let bytes = match self.entry("buffers", buffer)?.get("uri").and_then(Value::as_str) {
            None => match self.binary.filter(|_| buffer == 0) {
                Some(binary) => Cow::Borrowed(binary),
                None => return Err(wrong(&place, "has no uri")),
            },
            Some(uri) if uri.starts_with(DATA) => {
                let data = uri.split_once(";base64,").map(|(_, data)| STANDARD.decode(data));
                let Some(Ok(bytes)) = data else {
                    return Err(wrong(&place, "its data is not base64"));
                };
                Cow::Owned(bytes)
            }
            Some(uri) => {
                let Input { reader, len } =
                    open(self.folder, &format!("{}{}", self.prefix, uri.replace("%20", " ")))?;
                let mut bytes = Vec::with_capacity(len.min(MAX_BUFFER) as usize);
                let read = reader.take(MAX_BUFFER).read_to_end(&mut bytes);
                read.map_err(|e| SceneError::reading(&clip(uri), e))?;
                Cow::Owned(bytes)
            }
        };
        self.buffers.insert(buffer, bytes);
        Ok(())
    }
}

/// The index at `key`.
pub(super) fn index(keys: &Value, key: &str, place: &str) -> Result<usize, SceneError> {
    let index = keys.get(key).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok());
    index.ok_or_else(|| wrong(place, format!("has no {key}")))
}

pub(super) fn wrong(place: &str, what: impl Into<String>) -> SceneError {
    SceneError::malformed(format!("glTF, {place}"), what, DAMAGED)
}
