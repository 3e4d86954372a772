//! Formats of Gaussians that are not read, told by their first bytes or, where these say nothing,
//! by their names: what they are, and how to get a file that is read.

use super::error::SceneError;

/// A converter that reads most of them.
const CONVERTER: &str =
    "convert it to .ply, as SuperSplat or splat-transform do (splat-transform in out.ply)";
const CHECKPOINT: &str =
    "export a .ply with the trainer (gsplat: export_splats, nerfstudio: ns-export gaussian-splat)";
const STAGE: &str = "export its Gaussians to .ply or .glb with the program that made it";

/// Endings of names, what the files are, and what to do.
const ENDINGS: [(&[&str], &str, &str); 5] = [
    (&[".ksplat"], "KSPLAT (GaussianSplats3D)", CONVERTER),
    (&[".lcc", ".lcc2"], "LCC (XGRIDS)", CONVERTER),
    (&[".usd", ".usda", ".usdc", ".usdz"], "USD", STAGE),
    (&[".pt", ".pth", ".ckpt"], "a PyTorch checkpoint", CHECKPOINT),
    (&[".npz", ".npy", ".pkl", ".safetensors"], "a file of arrays", CHECKPOINT),
];

/// What a file with this head is, where it cannot be anything that is read.
pub(super) fn by_content(head: &[u8]) -> Option<SceneError> {
    let is_usd = head.starts_with(b"#usda") || head.starts_with(b"PXR-USDC");
    let (_, format, todo) = ENDINGS[2];
    if is_usd {
        return Some(SceneError::Foreign { format, todo });
    }
    if head.starts_with(&[0x80, 0x02, 0x8a, 0x0a]) {
        // The pickle of PyTorch before 1.6.
        let (_, format, todo) = ENDINGS[3];
        return Some(SceneError::Foreign { format, todo });
    }
    None
}

/// What a file of this name is.
pub(super) fn by_name(name: &str) -> Option<SceneError> {
    let name = name.to_ascii_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|end| name.ends_with(end));
    let (_, format, todo) = ENDINGS.into_iter().find(|(endings, ..)| ends(endings))?;
    Some(SceneError::Foreign { format, todo })
}

/// What a zip archive with members of these names is, if it is no SOG.
pub(super) fn by_members<'n>(mut names: impl Iterator<Item = &'n str>) -> Option<SceneError> {
    names.find_map(|name| {
        let place = match name {
            // PyTorch since 1.6: one folder, its pickle and its tensors.
            _ if name.ends_with("/data.pkl") || name == "data.pkl" => 3,
            _ if name.ends_with(".usdc") || name.ends_with(".usda") => 2,
            _ if name.ends_with(".npy") => 4,
            _ => return None,
        };
        let (_, format, todo) = ENDINGS[place];
        Some(SceneError::Foreign { format, todo })
    })
}
