//! Models as files: INRIA PLY, glTF and the compressed formats, with what each of them lost.
//!
//! [`write()`] keeps the order of the Gaussians, because the index of a Gaussian is its address in
//! DRAM. Other writers of compressed formats sort along a space-filling curve, which lets their
//! pictures and streams compress better; `scene convert --order` does too.

mod check;
mod displaced;
mod error;
mod fidelity;
mod target;

use std::collections::BTreeMap;

use super::gltf::{self, Container};
use super::{Gaussians, Model, OneFile, SceneError, ply, read, sog, spz};

pub use displaced::{Apart, Displaced};
pub use error::ExportError;
pub(crate) use fidelity::Clamped;
pub use fidelity::{Fidelity, Kept};
pub use target::Target;

/// The files that a folder of [`Target::SogFolder`] has: `meta.json` and its pictures.
pub const FOLDER_FILES: [&str; 8] = sog::FILE_NAMES;

/// The index file of a folder.
const INDEX: &str = FOLDER_FILES[0];

/// A model as files, and how much of it they hold.
#[derive(Debug, Clone)]
pub struct Export {
    /// What is to be written.
    pub files: Files,
    /// What was lost.
    pub fidelity: Fidelity,
    /// Whether positions are too coarse for the sizes of the Gaussians.
    pub displaced: Option<Displaced>,
}

/// The bytes of a written model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Files {
    /// A single file.
    One(Vec<u8>),
    /// Files of a folder by name, `meta.json` among them.
    Folder(BTreeMap<String, Vec<u8>>),
}

impl Files {
    /// Size of all files together, bytes.
    pub fn bytes(&self) -> u64 {
        match self {
            Files::One(bytes) => bytes.len() as u64,
            Files::Folder(files) => files.values().map(|bytes| bytes.len() as u64).sum(),
        }
    }

    /// Reads them back.
    fn read(&self) -> Result<Model, SceneError> {
        match self {
            Files::One(bytes) => read(&OneFile(bytes), "the file", None),
            Files::Folder(files) => read(files, INDEX, None),
        }
    }
}

/// Writes `scene` in memory as `target`, and reads it back to see what was lost. The same model
/// gives the same bytes, for any number of threads. Takes the memory of about two more models and
/// of the file.
///
/// # Errors
/// [`ExportError`]: a model that is empty, contradicts itself or has parameters that no reader
/// accepts; one that the format cannot hold; and a file that would not be read back.
pub fn write(scene: &Gaussians, target: Target) -> Result<Export, ExportError> {
    check::check(scene, target)?;
    let one = |(bytes, clamped)| (Files::One(bytes), clamped);
    let (files, clamped) = match target {
        Target::Ply => {
            let mut bytes = Vec::new();
            ply::write(scene, &mut bytes)?;
            (Files::One(bytes), Clamped::default())
        }
        Target::CompressedPly => one(ply::write_compressed(scene)),
        Target::Spz => one(spz::write(scene)?),
        Target::Gltf => one(gltf::write(scene, Container::Json)?),
        Target::Glb => one(gltf::write(scene, Container::Binary)?),
        Target::GlbSpz => one(gltf::write(scene, Container::Spz)?),
        Target::Sog => {
            let (files, clamped) = sog::write(scene)?;
            (Files::One(sog::zipped(&files)?), clamped)
        }
        Target::SogFolder => {
            let (files, clamped) = sog::write(scene)?;
            (Files::Folder(files), clamped)
        }
    };
    let held = files.read().map_err(ExportError::NotReadBack)?.gaussians;
    if (held.len(), held.sh_degree) != (scene.len(), scene.sh_degree) {
        return Err(ExportError::Incomplete { held: held.len(), of: scene.len() });
    }
    let displaced = Displaced::of(scene, &held);
    Ok(Export { files, fidelity: Fidelity::of(scene, &held, &clamped), displaced })
}
