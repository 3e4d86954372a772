//! Streamed SOG: `lod-meta.json`, a tree of bounds whose leaves say which part of which file holds
//! each level of detail.

use std::collections::BTreeSet;

use serde::Deserialize;
use serde_json::{Map, Value};

use super::super::error::{DAMAGED, SceneError};
use super::super::input::{check_count, clip, slurp};
use super::super::read::{Format, Model};
use super::super::{Gaussians, Warning};
use super::{MAX_INDEX, object, read_model};

#[derive(Deserialize)]
struct LodIndex {
    #[serde(rename = "lodLevels")]
    levels: u32,
    filenames: Vec<String>,
    tree: LodNode,
}

#[derive(Deserialize)]
struct LodNode {
    #[serde(default)]
    children: Vec<LodNode>,
    #[serde(default)]
    lods: Map<String, Value>,
}

/// Reads level `lod`: the files that the tree names for it, whole and in the order of the list of
/// files.
pub(super) fn read(
    folder: &dyn super::Folder,
    prefix: &str,
    keys: Map<String, Value>,
    lod: u32,
) -> Result<Model, SceneError> {
    let index: LodIndex = serde_json::from_value(Value::Object(keys))
        .map_err(|e| SceneError::malformed("lod-meta.json", e.to_string(), DAMAGED))?;
    if lod >= index.levels {
        let last = index.levels.saturating_sub(1);
        return Err(SceneError::NoSuchDetail { lod, last });
    }
    let mut files = BTreeSet::new();
    collect(&index.tree, &lod.to_string(), &mut files)?;
    let mut names = BTreeSet::new();
    let mut scene = Gaussians::default();
    let mut warnings: Vec<Warning> = Vec::new();
    // Parts of different kinds are shown as usual.
    let mut antialiased = true;
    for file in files {
        let name = index.filenames.get(file).ok_or_else(|| {
            let what = format!("file {file} of a list of {}", index.filenames.len());
            SceneError::malformed("lod-meta.json, tree", what, DAMAGED)
        })?;
        if !names.insert(name) {
            let what = format!("{:?} is listed twice", clip(name));
            return Err(SceneError::malformed("lod-meta.json, filenames", what, DAMAGED));
        }
        let path = format!("{prefix}{name}");
        let part = slurp(folder, &path, MAX_INDEX).and_then(|bytes| {
            let inner = path.rfind('/').map_or("", |slash| &path[..=slash]);
            read_model(folder, inner, object(&bytes)?)
        });
        let part = part.map_err(|e| inside(name, e))?;
        antialiased &= part.gaussians.antialiased;
        scene.append(part.gaussians);
        for warning in part.warnings {
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
    }
    check_count("lod-meta.json", scene.len() as u64, u64::MAX)?;
    scene.antialiased = antialiased;
    Ok(Model { gaussians: scene, format: Format::StreamedSog, warnings })
}

/// Adds the files that `node` and the nodes below it use for a level. The depth is bounded by the
/// JSON parser, which refuses more than 128 levels.
fn collect(node: &LodNode, lod: &str, files: &mut BTreeSet<usize>) -> Result<(), SceneError> {
    if let Some(part) = node.lods.get(lod) {
        match part.get("file").and_then(Value::as_u64) {
            Some(file) => files.insert(file as usize),
            None => {
                let what = format!("no number `file` at level {lod}");
                return Err(SceneError::malformed("lod-meta.json, tree", what, DAMAGED));
            }
        };
    }
    node.children.iter().try_for_each(|child| collect(child, lod, files))
}

/// Says in which part of a streamed scene an error is.
fn inside(name: &str, error: SceneError) -> SceneError {
    let within = |place: String| format!("{}: {place}", clip(name));
    match error {
        SceneError::Malformed { place, what, todo } => {
            SceneError::Malformed { place: within(place), what, todo }
        }
        SceneError::Truncated { place, what } => {
            SceneError::Truncated { place: within(place), what }
        }
        other => other,
    }
}
