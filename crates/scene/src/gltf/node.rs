//! The nodes of a scene: which meshes are shown, and where.

use std::collections::BTreeSet;

use serde_json::Value;

use super::super::error::SceneError;
use super::document::{Document, index, wrong};
use super::placement::GltfPlacement;

/// Deepest node.
const MAX_DEPTH: usize = 256;

/// The meshes that the scene shows, in the order of the nodes; all of them where there are no
/// nodes.
pub(super) fn instances(
    document: &Document<'_>,
) -> Result<Vec<(usize, GltfPlacement)>, SceneError> {
    if document.count("nodes") == 0 {
        return Ok((0..document.count("meshes")).map(|mesh| (mesh, GltfPlacement::NONE)).collect());
    }
    let roots = match document.scene()? {
        Some(scene) => children(scene, "nodes", "scene")?,
        None => {
            let mut roots: BTreeSet<usize> = (0..document.count("nodes")).collect();
            for node in 0..document.count("nodes") {
                for child in children(document.entry("nodes", node)?, "children", "node")? {
                    roots.remove(&child);
                }
            }
            roots.into_iter().collect()
        }
    };
    let (mut found, mut seen) = (Vec::new(), BTreeSet::new());
    // The last one is next, so that children come in their order.
    let mut open: Vec<(usize, GltfPlacement, usize)> =
        roots.into_iter().rev().map(|node| (node, GltfPlacement::NONE, 0)).collect();
    while let Some((node, above, depth)) = open.pop() {
        let place = format!("nodes[{node}]");
        if !seen.insert(node) || depth > MAX_DEPTH {
            return Err(wrong(&place, "a node has two parents, or is its own"));
        }
        let keys = document.entry("nodes", node)?;
        let own = above.then(&GltfPlacement::of_node(keys, &place)?);
        if keys.get("mesh").is_some() {
            found.push((index(keys, "mesh", &place)?, own));
        }
        let below = children(keys, "children", &place)?;
        open.extend(below.into_iter().rev().map(|child| (child, own, depth + 1)));
    }
    Ok(found)
}

fn children(keys: &Value, key: &str, place: &str) -> Result<Vec<usize>, SceneError> {
    let Some(list) = keys.get(key) else { return Ok(Vec::new()) };
    let entries = list.as_array().map(|list| list.iter().map(Value::as_u64).collect());
    let entries: Option<Vec<u64>> = entries.flatten();
    let entries = entries.ok_or_else(|| wrong(place, format!("{key} is no list of numbers")))?;
    Ok(entries.into_iter().map(|n| n as usize).collect())
}
