//! The formats that are written.

use super::super::input::MAX_GAUSSIANS;
use powergs_pixels::WEBP_SIDE;

/// Readers of SPZ up to version 3, the format's own among them, take so many Gaussians.
const SPZ_GAUSSIANS: u64 = 10_000_000;

/// What a model is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Target {
    /// INRIA's PLY of raw parameters.
    Ply,
    /// PlayCanvas compressed PLY.
    CompressedPly,
    /// Niantic SPZ, version 3.
    Spz,
    /// glTF with `KHR_gaussian_splatting`, its numbers in it as text.
    Gltf,
    /// The same, binary.
    Glb,
    /// Binary glTF with an SPZ file in it.
    GlbSpz,
    /// PlayCanvas SOG, version 2, in a zip archive.
    Sog,
    /// PlayCanvas SOG, version 2, as a folder of pictures and `meta.json`.
    SogFolder,
}

impl Target {
    /// All of them.
    pub const ALL: [Target; 8] = [
        Target::Ply,
        Target::CompressedPly,
        Target::Spz,
        Target::Gltf,
        Target::Glb,
        Target::GlbSpz,
        Target::Sog,
        Target::SogFolder,
    ];

    /// A short name, as on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Target::Ply => "ply",
            Target::CompressedPly => "compressed-ply",
            Target::Spz => "spz",
            Target::Gltf => "gltf",
            Target::Glb => "glb",
            Target::GlbSpz => "glb-spz",
            Target::Sog => "sog",
            Target::SogFolder => "sog-folder",
        }
    }

    /// The format of a short name.
    pub fn from_name(name: &str) -> Option<Target> {
        Target::ALL.into_iter().find(|target| target.name() == name)
    }

    /// The format that the name of a file says, small letters or capitals: `.compressed.ply`,
    /// `.ply`, `.spz`, `.gltf`, `.glb`, `.sog`, and `meta.json` for a folder.
    pub fn of_file_name(name: &str) -> Option<Target> {
        let name = name.to_ascii_lowercase();
        let ends = |end: &str| name.ends_with(end);
        if ends(".compressed.ply") {
            Some(Target::CompressedPly)
        } else if ends(".ply") {
            Some(Target::Ply)
        } else if ends(".spz") {
            Some(Target::Spz)
        } else if ends(".gltf") {
            Some(Target::Gltf)
        } else if ends(".glb") {
            Some(Target::Glb)
        } else if ends(".sog") {
            Some(Target::Sog)
        } else if name == "meta.json" {
            Some(Target::SogFolder)
        } else {
            None
        }
    }

    /// The most Gaussians that it holds. SOG has a pixel for each, in pictures of bounded sides;
    /// other readers of SPZ refuse more.
    pub const fn most(self) -> u64 {
        match self {
            Target::Ply | Target::CompressedPly | Target::Gltf | Target::Glb => MAX_GAUSSIANS,
            Target::Spz | Target::GlbSpz => SPZ_GAUSSIANS,
            Target::Sog | Target::SogFolder => (WEBP_SIDE as u64).pow(2),
        }
    }
}
