//! The joint model in the compressed formats of others, and whether it is still good enough there.

use powergs_core::run::RunError;
use powergs_optimize::campaign::Campaign;
use powergs_optimize::setup::Seen;
use powergs_optimize::target::Target as Quality;
use powergs_scene::export::{Files, Target, write};
use powergs_scene::{Gaussians, OneFile, read};

/// The formats that are tried: files that hold a model in fewer bytes than raw parameters.
const TRIED: [Target; 3] = [Target::Sog, Target::CompressedPly, Target::Spz];

/// A model as one of the formats holds it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Exported {
    /// The format.
    pub target: Target,
    /// The file; `None`, with the reason in words, where the format cannot hold the model.
    pub file: Result<Vec<u8>, String>,
    /// Quality and display power over the gate views of what is read back.
    pub gate: Option<Seen>,
    /// Whether it still reaches the quality.
    pub passed: bool,
}

impl Exported {
    /// Bytes of the file.
    pub fn bytes(&self) -> Option<usize> {
        self.file.as_ref().ok().map(Vec::len)
    }
}

/// The smallest file that still reaches the quality.
pub fn smallest(exports: &[Exported]) -> Option<&Exported> {
    exports.iter().filter(|e| e.passed).min_by_key(|e| e.bytes())
}

/// Writes a model in every compressed format, reads it back and looks at it.
///
/// # Errors
/// [`RunError::Internal`]: what was written is not read.
pub fn exports(
    campaign: &Campaign,
    scene: &Gaussians,
    quality: Quality,
) -> Result<Vec<Exported>, RunError> {
    let setup = campaign.setup();
    let mut found = Vec::new();
    for target in TRIED {
        let none = |why: String| Exported { target, file: Err(why), gate: None, passed: false };
        found.push(match write(scene, target).map(|export| export.files) {
            Ok(Files::One(bytes)) => {
                let held = read(&OneFile(&bytes), target.name(), None);
                let held = held.map_err(|e| RunError::Internal(e.to_string()))?.gaussians;
                let gate = setup.see(&held, setup.gate_views(), None);
                let passed = quality.passes(gate.quality);
                Exported { target, file: Ok(bytes), gate: Some(gate), passed }
            }
            Ok(Files::Folder(_)) => none("it is a folder".into()),
            Err(error) => none(error.to_string()),
        });
    }
    Ok(found)
}
