//! PlayCanvas SOG, versions 1 and 2: one image per attribute, one pixel per Gaussian.
//!
//! `meta.json` names the images. Positions are 16 bits over two images, between the minima and
//! maxima of `sign(x) ln(1 + |x|)`. Version 1 interpolates the other values between minima and
//! maxima, version 2 looks them up in codebooks of 256 entries. Rotations are the three smaller
//! components and, as alpha - 252, the place of the largest in (w, x, y, z). `shN` is a palette
//! of 64 entries a row and a 16-bit label per Gaussian.
//! Source: the format's documentation, developer.playcanvas.com, "The SOG Format".

mod bundle;
mod decode;
mod lod;
mod meta;
mod plane;
mod write;

use std::io::Read;

use serde_json::{Map, Value};

use super::error::{DAMAGED, SceneError};
use super::input::{Folder, Input, check_count, plausible, slurp};
use super::read::{Format, Model};
use super::{Gaussians, Warning};
use meta::Meta;
use plane::Plane;
pub(super) use write::{FILE_NAMES, write, zipped};

/// Largest index file, bytes; real ones have 20 to 100 KiB.
const MAX_INDEX: u64 = 16 << 20;
/// Largest image file, bytes.
const MAX_IMAGE: u64 = 1 << 30;

/// Reads a zipped `.sog`.
pub(super) fn read_bundle(input: Input<'_>) -> Result<Model, SceneError> {
    let mut bytes = Vec::with_capacity(input.len as usize);
    { input.reader }.read_to_end(&mut bytes).map_err(|e| SceneError::reading("zip archive", e))?;
    let bundle = bundle::Bundle::new(&bytes)?;
    let index = slurp(&bundle, bundle.index(), MAX_INDEX)?;
    read_model(&bundle, bundle.prefix(), object(&index)?)
}

/// Reads what the keys of a `meta.json` or `lod-meta.json` describe. Names of files are relative to
/// `prefix`.
pub(super) fn read_index(
    folder: &dyn Folder,
    prefix: &str,
    keys: Map<String, Value>,
    lod: Option<u32>,
) -> Result<Model, SceneError> {
    if keys.contains_key("lodLevels") {
        return lod::read(folder, prefix, keys, lod.unwrap_or(0));
    }
    if !keys.contains_key("means") {
        return Err(SceneError::NoIndex);
    }
    read_model(folder, prefix, keys)
}

/// The keys of a JSON object.
pub(super) fn object(bytes: &[u8]) -> Result<Map<String, Value>, SceneError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    serde_json::from_slice(bytes).map_err(|e| {
        if e.is_eof() {
            SceneError::truncated("JSON", e.to_string())
        } else {
            SceneError::malformed("JSON", e.to_string(), DAMAGED)
        }
    })
}

/// Reads the images that `keys` name; their names are relative to `prefix`.
fn read_model(
    folder: &dyn Folder,
    prefix: &str,
    keys: Map<String, Value>,
) -> Result<Model, SceneError> {
    let meta = Meta::new(keys)?;
    let mut files = Vec::with_capacity(meta.files.len());
    for name in &meta.files {
        files.push((name.as_str(), slurp(folder, &format!("{prefix}{name}"), MAX_IMAGE)?));
    }
    let total: u64 = files.iter().map(|(_, bytes)| bytes.len() as u64).sum();
    let count = check_count("meta.json", meta.count, plausible(total))?;
    let plane = |i: usize| Plane::per_gaussian(files[i].0, &files[i].1, count);
    let mut scene = Gaussians { sh_degree: 0, ..Gaussians::default() };
    scene.means = decode::means(&meta.means, &plane(0)?, &plane(1)?);
    scene.log_scales = decode::scales(&meta.scales, &plane(2)?);
    scene.rotations = decode::rotations(&plane(3)?);
    let sh0 = plane(4)?;
    scene.logit_opacities = decode::opacities(&meta.sh0, &sh0);
    match &meta.sh_n {
        None => scene.sh = decode::constant(&meta.sh0, &sh0),
        Some(table) => {
            let palette = Plane::palette(files[5].0, &files[5].1)?;
            let labels = plane(6)?;
            scene.sh_degree = palette.degree();
            scene.sh = decode::harmonics(&meta.sh0, &sh0, table, &palette, &labels)?;
        }
    }
    let kind = meta.model.as_deref();
    scene.antialiased = kind == Some("antialiased");
    let warnings = if kind == Some("2dgs") { vec![Warning::Flat] } else { Vec::new() };
    Ok(Model { gaussians: scene, format: Format::Sog(meta.version), warnings })
}
