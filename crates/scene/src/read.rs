//! Reads a trained model from any of the known formats, recognised by content.

use std::io::{BufRead, Cursor, Read};

use super::error::SceneError;
use super::input::{Folder, Input, open};
use super::{Foveated, Gaussians, StoredAxes, Warning, check, foreign, foveated, gltf, ply, sog};
use super::{splat_rows, spz};

/// The formats that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// INRIA's PLY of raw parameters.
    Ply,
    /// PlayCanvas compressed PLY.
    CompressedPly,
    /// 32-byte rows of antimatter15's viewer.
    Splat,
    /// Niantic SPZ and its version, 1 to 4.
    Spz(u8),
    /// PlayCanvas SOG and its version, 1 or 2.
    Sog(u8),
    /// PlayCanvas streamed SOG: levels of detail.
    StreamedSog,
    /// glTF, as JSON or binary.
    Gltf,
    /// A foveated model: four levels.
    Foveated,
}

impl Format {
    /// A short name, as in messages and records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ply => "ply",
            Self::CompressedPly => "compressed ply",
            Self::Splat => "splat",
            Self::Spz(1) => "spz v1",
            Self::Spz(2) => "spz v2",
            Self::Spz(3) => "spz v3",
            Self::Spz(_) => "spz v4",
            Self::Sog(1) => "sog v1",
            Self::Sog(_) => "sog v2",
            Self::StreamedSog => "streamed sog",
            Self::Gltf => "gltf",
            Self::Foveated => "foveated model",
        }
    }

    /// The axes of its numbers, which readers turn to those of PLY. An SPZ file may say others.
    fn axes(self) -> StoredAxes {
        match self {
            Self::Spz(_) | Self::Gltf => StoredAxes::RIGHT_UP_BACK,
            Self::Ply
            | Self::CompressedPly
            | Self::Splat
            | Self::Sog(_)
            | Self::StreamedSog
            | Self::Foveated => StoredAxes::PLY,
        }
    }
}

/// What a file does not say, and who reads it does.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ReadAs {
    /// The detail of a streamed scene, 0 (the finest) if not given; an error for other formats.
    pub detail: Option<u32>,
    /// The axes of its numbers, where they are others than those that the format or the file says.
    pub axes: Option<StoredAxes>,
}

/// A model and what the reading found.
#[derive(Debug, Clone)]
pub struct Model {
    /// The parameters, checked: finite, no quaternion of length zero.
    pub gaussians: Gaussians,
    /// What the file was.
    pub format: Format,
    /// Oddities, none of which prevents its use.
    pub warnings: Vec<Warning>,
}

/// Largest JSON file, bytes; a `.gltf` may have its numbers in it, as text.
const MAX_JSON: u64 = 4 << 30;
/// Bytes that are enough to recognise a format.
const HEAD: u64 = 4096;

/// Reads the scene whose file, or for several files whose index (`meta.json`, `lod-meta.json`, a
/// `.gltf`), is `name` in `folder`. `lod` chooses the detail of a streamed scene (0, the finest, if
/// not given) and is an error for other formats. A foveated model gives its level 1. Gaussians with
/// unusable parameters are dropped with a warning.
///
/// # Errors
/// [`SceneError`]: an unknown format, a damaged or unsupported file, a detail that is not
/// there, or a model without usable Gaussians.
pub fn read(folder: &dyn Folder, name: &str, lod: Option<u32>) -> Result<Model, SceneError> {
    read_as(folder, name, ReadAs { detail: lod, axes: None })
}

/// As [`read()`], with what the file does not say.
///
/// # Errors
/// Those of [`read()`].
pub fn read_as(folder: &dyn Folder, name: &str, known: ReadAs) -> Result<Model, SceneError> {
    let mut model = read_unchecked(folder, name, known)?;
    model.gaussians = check::check(model.gaussians, &mut model.warnings)?;
    Ok(model)
}

fn read_unchecked(folder: &dyn Folder, name: &str, known: ReadAs) -> Result<Model, SceneError> {
    let Input { mut reader, len } = open(folder, name)?;
    let mut head = Vec::new();
    let peeked = reader.by_ref().take(HEAD).read_to_end(&mut head);
    peeked.map_err(|e| SceneError::reading(name, e))?;
    if head.is_empty() {
        return Err(SceneError::Empty);
    }
    let kind = recognise(&head, len, name)?;
    let reader: Box<dyn BufRead + '_> = Box::new(Cursor::new(head).chain(reader));
    let input = Input { reader, len };
    let mut model = match kind {
        ReadKind::Ply => ply::read(input)?,
        // Its own axes may be others than those of the format.
        ReadKind::Spz => spz::read(input, known.axes)?,
        ReadKind::Zip => sog::read_bundle(input)?,
        ReadKind::Glb => gltf::read_binary(folder, input)?,
        ReadKind::Json => read_json(folder, name, input, known.detail)?,
        ReadKind::Splat => splat_rows::read(input)?,
        ReadKind::Foveated => read_level(input)?,
    };
    if known.detail.is_some() && model.format != Format::StreamedSog {
        return Err(SceneError::NoDetails { format: model.format.name() });
    }
    if let Some(axes) = known.axes.filter(|_| !matches!(model.format, Format::Spz(_))) {
        axes.instead_of(model.format.axes()).turn(&mut model.gaussians);
    }
    Ok(model)
}

/// What a JSON file describes: SOG, whole or streamed, or glTF.
fn read_json(
    folder: &dyn Folder,
    name: &str,
    input: Input<'_>,
    lod: Option<u32>,
) -> Result<Model, SceneError> {
    let mut bytes = Vec::new();
    let read = input.reader.take(MAX_JSON).read_to_end(&mut bytes);
    read.map_err(|e| SceneError::reading(name, e))?;
    let keys = match sog::object(&bytes) {
        Ok(keys) => keys,
        Err(error) => return Err(foreign::by_name(name).unwrap_or(error)),
    };
    drop(bytes);
    let prefix = name.rfind('/').map_or("", |slash| &name[..=slash]);
    if keys.contains_key("asset") && keys.contains_key("meshes") {
        return gltf::read_json(folder, prefix, keys);
    }
    if let Some(error) = foreign::by_keys(&keys) {
        return Err(error);
    }
    match sog::read_index(folder, prefix, keys, lod) {
        Err(SceneError::NoIndex) => Err(foreign::by_name(name).unwrap_or(SceneError::NoIndex)),
        other => other,
    }
}

enum ReadKind {
    Glb,
    Ply,
    Spz,
    Zip,
    Json,
    Splat,
    Foveated,
}

/// Level 1 of a foveated model.
fn read_level(input: Input<'_>) -> Result<Model, SceneError> {
    let gaussians = Foveated::read(input)?.level(0);
    if gaussians.is_empty() {
        return Err(SceneError::NothingLeft { count: 0 });
    }
    Ok(Model { gaussians, format: Format::Foveated, warnings: Vec::new() })
}

fn recognise(head: &[u8], len: u64, name: &str) -> Result<ReadKind, SceneError> {
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let first = text.iter().find(|b| !b.is_ascii_whitespace());
    if let Some(error) = foreign::by_content(head) {
        Err(error)
    } else if head.starts_with(&foveated::MAGIC) {
        Ok(ReadKind::Foveated)
    } else if head.starts_with(gltf::MAGIC) {
        Ok(ReadKind::Glb)
    } else if head.starts_with(b"ply\n") || head.starts_with(b"ply\r") {
        Ok(ReadKind::Ply)
    } else if head.starts_with(b"NGSP") || head.starts_with(&[0x1f, 0x8b]) {
        Ok(ReadKind::Spz)
    } else if head.starts_with(b"PK\x03\x04") {
        Ok(ReadKind::Zip)
    } else if first == Some(&b'{') {
        Ok(ReadKind::Json)
    } else if let Some(error) = foreign::by_name(name) {
        // Rows of `.splat` have no magic, and some foreign files look like them.
        Err(error)
    } else if splat_rows::plausible(head, len) {
        Ok(ReadKind::Splat)
    } else {
        let start = String::from_utf8_lossy(&head[..head.len().min(12)]).escape_debug().to_string();
        Err(SceneError::Unknown { start: format!("\"{start}\"") })
    }
}
