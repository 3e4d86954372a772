//! Gaussians in glTF 2.0: the extension `KHR_gaussian_splatting`, as JSON (`.gltf`) or binary
//! (`.glb`), and its variant whose attributes are an SPZ file.
//!
//! A primitive of points has positions, unit quaternions (x, y, z, w), linear scales, opacities
//! from 0 to 1, and SH coefficients as trained. glTF is right-up-back, and is turned to the axes of
//! PLY; nodes may turn, move and scale. Drafts stored logarithms of scales, converters logits of
//! opacities: `dialect` tells them. Colours, and in drafts opacities, may be vertex colours. What
//! glTF has no word for, that a model is anti-aliased, is in the `extras` of its primitive.
//! Source: the extension's own README in github.com/KhronosGroup/glTF.

mod dialect;
mod document;
mod node;
mod placement;
mod write;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::Read;

use serde_json::{Map, Value};

use super::error::{DAMAGED, SceneError};
use super::input::{Folder, Input, check_count, plausible};
use super::read::{Format, Model};
use super::{Gaussians, Warning};
use dialect::{GltfDialect, GltfPart};
use document::Document;

pub(super) use write::{Container, write};

pub(super) const MAGIC: &[u8; 4] = b"glTF";
const EXTENSION: &str = "KHR_gaussian_splatting";
/// How names of its variants begin whose attributes are an SPZ file.
const SPZ: &str = "KHR_gaussian_splatting_compression_spz";
/// The name of such a variant in an early draft, where it stood beside the other extension.
const SPZ_DRAFT: &str = "KHR_spz_gaussian_splats_compression";
/// The key in the `extras` of a primitive.
const ANTIALIASED: &str = "antialiased";
/// Signs that turn the axes of glTF to those of PLY.
const AXES: [f64; 3] = [1.0, -1.0, -1.0];

/// Reads a `.glb`.
pub(super) fn read_binary(folder: &dyn Folder, input: Input<'_>) -> Result<Model, SceneError> {
    let mut bytes = Vec::with_capacity(input.len.min(1 << 32) as usize);
    { input.reader }.read_to_end(&mut bytes).map_err(|e| SceneError::reading("glTF", e))?;
    let (json, binary) = document::chunks(&bytes)?;
    let keys = serde_json::from_slice(json)
        .map_err(|e| SceneError::malformed("glTF, JSON", e.to_string(), DAMAGED))?;
    read(Document::new(keys, Some(binary), folder, "")?)
}

/// Reads the JSON of a `.gltf`; other files are relative to `prefix`.
pub(super) fn read_json(
    folder: &dyn Folder,
    prefix: &str,
    keys: Map<String, Value>,
) -> Result<Model, SceneError> {
    read(Document::new(keys, None, folder, prefix)?)
}

/// Gaussians of all nodes of the scene, in the order of the file.
fn read(mut document: Document<'_>) -> Result<Model, SceneError> {
    let instances = node::instances(&document)?;
    // Each mesh is read once, however many nodes show it.
    let mut meshes: BTreeMap<usize, Vec<GltfPart>> = BTreeMap::new();
    let mut uses: BTreeMap<usize, usize> = BTreeMap::new();
    let mut total = 0_u64;
    for (mesh, _) in &instances {
        if let Entry::Vacant(unread) = meshes.entry(*mesh) {
            unread.insert(document.parts(*mesh, total)?);
        }
        *uses.entry(*mesh).or_insert(0) += 1;
        let more: u64 = meshes[mesh].iter().map(|part| part.gaussians.len() as u64).sum();
        if more > 0 {
            total += more;
            // Many nodes may show one mesh: a bomb.
            check_count("glTF", total, plausible(document.read_bytes()))?;
        }
    }
    if total == 0 {
        let what = format!("no primitive with the extension {EXTENSION}");
        return Err(SceneError::malformed("glTF", what, "give a .glb or .gltf of Gaussians"));
    }
    let dialect = GltfDialect::of(meshes.values().flatten());
    let mut warnings: Vec<Warning> = Vec::new();
    for warning in meshes.values_mut().flatten().flat_map(|part| part.warnings.drain(..)) {
        if !warnings.contains(&warning) {
            warnings.push(warning);
        }
    }
    warnings.extend(dialect.warnings());
    let decoded = |parts: Vec<GltfPart>| -> Vec<Gaussians> {
        parts.into_iter().map(|part| dialect.decoded(part)).collect()
    };
    let mut meshes: BTreeMap<usize, Vec<Gaussians>> =
        meshes.into_iter().map(|(mesh, parts)| (mesh, decoded(parts))).collect();
    let mut scene: Option<Gaussians> = None;
    for (mesh, placement) in instances {
        let left = uses.entry(mesh).or_insert(0);
        *left = left.saturating_sub(1);
        // The last node that shows it takes it.
        let parts = if *left == 0 { meshes.remove(&mesh) } else { meshes.get(&mesh).cloned() };
        for mut gaussians in parts.into_iter().flatten() {
            placement.apply(&mut gaussians);
            match &mut scene {
                None => scene = Some(gaussians),
                Some(scene) => {
                    scene.antialiased &= gaussians.antialiased;
                    scene.append(gaussians);
                }
            }
        }
    }
    let gaussians = scene.ok_or(SceneError::NothingLeft { count: total })?;
    Ok(Model { gaussians, format: Format::Gltf, warnings })
}
