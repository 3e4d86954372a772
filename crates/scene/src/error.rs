//! Errors of scene files.

use std::io;

/// Why a scene could not be read: the place, what is wrong there, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// No bytes at all.
    #[error("the file is empty; was it copied completely?")]
    Empty,
    /// None of the known formats.
    #[error(
        "not a scene that is known here (it starts with {start}); \
         give an INRIA or PlayCanvas .ply, .splat, .spz, .sog, .glb, .gltf or .fov file, or a \
         meta.json or lod-meta.json"
    )]
    Unknown {
        /// The first bytes, printable.
        start: String,
    },
    /// A format that others read.
    #[error("{format} is not read; {todo}")]
    Foreign {
        /// What it is.
        format: &'static str,
        /// How to get a file that is read.
        todo: &'static str,
    },
    /// A packed file or an archive that has a model in it.
    #[error("{packing} with {inside} in it; unpack it and give that file")]
    Packed {
        /// What packs it.
        packing: &'static str,
        /// What is inside: a format, or the name of a file.
        inside: String,
    },
    /// A list of tiles, each a scene of its own.
    #[error("a tileset of 3D Tiles is not read; {todo}")]
    Tileset {
        /// Which file to give instead.
        todo: String,
    },
    /// The bytes contradict the format.
    #[error("{place}: {what}; {todo}")]
    Malformed {
        /// Element, key, line or byte offset.
        place: String,
        /// What is wrong.
        what: String,
        /// What to do about it.
        todo: &'static str,
    },
    /// Fewer bytes than the file itself promises.
    #[error("{place}: {what}; was the file copied completely?")]
    Truncated {
        /// Element, key or byte offset.
        place: String,
        /// What is missing.
        what: String,
    },
    /// Every Gaussian was dropped as unusable.
    #[error(
        "none of the {count} Gaussians has finite parameters; \
         the training diverged or the file is damaged"
    )]
    NothingLeft {
        /// Gaussians in the file.
        count: u64,
    },
    /// JSON that is no index of a scene.
    #[error(
        "JSON without a key `means` or `lodLevels` (SOG) or `meshes` (glTF); give the meta.json or \
         lod-meta.json of a SOG scene, or a .gltf"
    )]
    NoIndex,
    /// The streamed scene has no such detail.
    #[error("there is no detail {lod}; choose one of 0 (the finest) to {last}")]
    NoSuchDetail {
        /// What was asked for.
        lod: u32,
        /// The coarsest.
        last: u32,
    },
    /// A detail was asked for in a file that has one only.
    #[error("{format} has a single detail; leave it out")]
    NoDetails {
        /// The format of the file.
        format: &'static str,
    },
    /// The operating system refused.
    #[error("{name}: {source}")]
    Io {
        /// The file, as named inside the scene.
        name: String,
        /// The reason.
        source: io::Error,
    },
}

/// What to do about bytes that no writer of the format makes.
pub(super) const DAMAGED: &str = "the file is damaged or not of this format";

/// Advice for a legal file with unsupported features.
pub(super) const REEXPORT: &str = "export the model again with other settings";

impl SceneError {
    /// Bytes that contradict the format.
    pub(super) fn malformed(
        place: impl Into<String>,
        what: impl Into<String>,
        todo: &'static str,
    ) -> Self {
        Self::Malformed { place: place.into(), what: what.into(), todo }
    }

    /// Bytes that are missing.
    pub(super) fn truncated(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Truncated { place: place.into(), what: what.into() }
    }

    /// An error while reading `place`: an early end is a truncation.
    pub(super) fn reading(place: &str, error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => Self::truncated(place, "the data end too early"),
            io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => {
                Self::malformed(place, error.to_string(), DAMAGED)
            }
            _ => Self::Io { name: place.into(), source: error },
        }
    }
}
