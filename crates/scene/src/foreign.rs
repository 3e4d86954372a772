//! Files that are not read, told by their first bytes or, where these say nothing, by their names:
//! what they are, and how to get a file that is read.

use serde_json::{Map, Value};

use super::error::SceneError;
use super::input::clip;

/// What a file is, and what to do.
#[derive(Clone, Copy)]
struct ForeignKind {
    format: &'static str,
    todo: &'static str,
}

const fn kind(format: &'static str, todo: &'static str) -> ForeignKind {
    ForeignKind { format, todo }
}

/// A converter that reads most of them.
const CONVERTER: &str =
    "convert it to .ply, as SuperSplat or splat-transform do (splat-transform in out.ply)";
const CHECKPOINT: &str =
    "export a .ply with the trainer (gsplat: export_splats, nerfstudio: ns-export gaussian-splat)";
const UNPACK: &str = "unpack it and give the model that is in it";

const USD: ForeignKind =
    kind("USD", "export its Gaussians to .ply or .glb with the program that made it");
const PYTORCH: ForeignKind = kind("a PyTorch checkpoint", CHECKPOINT);
const ARRAYS: ForeignKind = kind("a file of arrays", CHECKPOINT);
const PAGE: ForeignKind = kind(
    "a web page (HTML)",
    "it was saved in place of the model: the address needs a login, or is that of a page about it; \
     download the file itself",
);
const POINTER: ForeignKind =
    kind("a pointer of Git LFS", "fetch the file itself (git lfs pull) and give that");
const XML: ForeignKind = kind(
    "an XML document",
    "if it was downloaded, it says why the download failed; give the file of the model",
);
const CAMERAS: ForeignKind =
    kind("a camera file in place of a model", "give the model here, and this file to --cameras");

/// Endings of names.
const ENDINGS: [(&[&str], ForeignKind); 5] = [
    (&[".ksplat"], kind("KSPLAT (GaussianSplats3D)", CONVERTER)),
    (&[".lcc", ".lcc2"], kind("LCC (XGRIDS)", CONVERTER)),
    (&[".usd", ".usda", ".usdc", ".usdz"], USD),
    (&[".pt", ".pth", ".ckpt"], PYTORCH),
    (&[".npz", ".npy", ".pkl", ".safetensors"], ARRAYS),
];

/// First bytes.
const STARTS: [(&[u8], ForeignKind); 9] = [
    (b"#usda", USD),
    (b"PXR-USDC", USD),
    // The pickle of PyTorch before 1.6.
    (&[0x80, 0x02, 0x8a, 0x0a], PYTORCH),
    (b"\x93NUMPY", ARRAYS),
    (b"version https://git-lfs.github.com/spec/", POINTER),
    (&[0x28, 0xb5, 0x2f, 0xfd], kind("a file packed by zstd", UNPACK)),
    (b"\xfd7zXZ\0", kind("a file packed by xz", UNPACK)),
    (b"7z\xbc\xaf\x27\x1c", kind("a 7z archive", UNPACK)),
    (b"Rar!\x1a\x07", kind("a RAR archive", UNPACK)),
];

/// Bytes that tell text from numbers.
const TEXT: usize = 64;

/// Endings of models, in archives.
const MODELS: [&str; 8] =
    [".ply", ".spz", ".splat", ".glb", ".gltf", ".sog", ".ksplat", "lod-meta.json"];

impl ForeignKind {
    fn error(self) -> SceneError {
        SceneError::Foreign { format: self.format, todo: self.todo }
    }
}

/// What a file with this head is, where it cannot be anything that is read.
pub(super) fn by_content(head: &[u8]) -> Option<SceneError> {
    if let Some((_, known)) = STARTS.into_iter().find(|(start, _)| head.starts_with(start)) {
        return Some(known.error());
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head).trim_ascii_start();
    let begins =
        |with: &[u8]| text.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with));
    if begins(b"<!doctype html") || begins(b"<html") {
        return Some(PAGE.error());
    }
    if begins(b"<?xml") {
        return Some(XML.error());
    }
    // A list is the cameras.json of INRIA's trainer; numbers may begin with its bracket.
    let is_text = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    let is_list = begins(b"[") && text.contains(&b'{') && text.iter().take(TEXT).all(is_text);
    is_list.then(|| CAMERAS.error())
}

/// What a file of this name is.
pub(super) fn by_name(name: &str) -> Option<SceneError> {
    let name = name.to_ascii_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|end| name.ends_with(end));
    let (_, known) = ENDINGS.into_iter().find(|(endings, _)| ends(endings))?;
    Some(known.error())
}

/// What a zip archive with members of these names is, if it is no SOG.
pub(super) fn by_members<'n>(names: impl Iterator<Item = &'n str> + Clone) -> Option<SceneError> {
    let known = names.clone().find_map(|name| {
        Some(match name {
            // PyTorch since 1.6: one folder, its pickle and its tensors.
            _ if name.ends_with("/data.pkl") || name == "data.pkl" => PYTORCH,
            _ if name.ends_with(".usdc") || name.ends_with(".usda") => USD,
            _ if name.ends_with(".npy") => ARRAYS,
            _ => return None,
        })
    });
    if let Some(known) = known {
        return Some(known.error());
    }
    let is_model = |name: &&str| {
        let name = name.to_ascii_lowercase();
        MODELS.iter().any(|end| name.ends_with(end))
    };
    let inside = format!("`{}`", clip(names.clone().find(is_model)?));
    Some(SceneError::Packed { packing: "a zip archive", inside })
}

/// What the bytes inside of a gzip file are, if they are no SPZ.
pub(super) fn unpacked(bytes: &[u8]) -> Option<SceneError> {
    let inside = match bytes {
        _ if bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r") => "a PLY file",
        _ if bytes.starts_with(b"glTF") => "a glTF file",
        _ if bytes.starts_with(b"PK\x03\x04") => "a zip archive",
        _ => return None,
    };
    Some(SceneError::Packed { packing: "a gzip file", inside: inside.to_owned() })
}

/// What a JSON object with these keys is.
pub(super) fn by_keys(keys: &Map<String, Value>) -> Option<SceneError> {
    if keys.contains_key("frames") || keys.contains_key("camera_path") {
        return Some(CAMERAS.error());
    }
    let root = keys.get("root").filter(|_| keys.contains_key("asset"))?;
    let mut contents = Vec::new();
    collect(root, &mut contents);
    let more = if contents.len() > SHOWN { ", ..." } else { "" };
    let shown = contents[..contents.len().min(SHOWN)].join(", ");
    let todo = match contents.as_slice() {
        [] => "give one of its tiles, a .glb file".to_owned(),
        [_] => format!("give its tile, {shown}"),
        _ => format!("give one of its tiles: {shown}{more}"),
    };
    Some(SceneError::Tileset { todo })
}

/// How many tiles an error names.
const SHOWN: usize = 3;

/// Adds the files of a tile and of those below it, one more than are named at most. The depth is
/// bounded by the JSON parser.
fn collect(tile: &Value, contents: &mut Vec<String>) {
    let list = |key: &str| tile.get(key).and_then(Value::as_array).into_iter().flatten();
    for content in tile.get("content").into_iter().chain(list("contents")) {
        let name = content.get("uri").or(content.get("url")).and_then(Value::as_str);
        contents.extend(name.map(clip));
    }
    for child in list("children") {
        if contents.len() > SHOWN {
            return;
        }
        collect(child, contents);
    }
}
