//! Errors of writing a model.

use std::io;

use super::super::SceneError;

/// Why a model was not written: what is wrong, and what to do.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// No Gaussians.
    #[error("the model has no Gaussians, and readers refuse such a file; train or load one first")]
    Empty,
    /// The lists of a model do not belong together.
    #[error("{list} has {found} entries instead of {expected}; give every Gaussian one of each")]
    Lengths {
        /// The list, as a field of the model.
        list: &'static str,
        /// How many it has.
        found: usize,
        /// How many it should have.
        expected: usize,
    },
    /// Colours of a degree that is not known here.
    #[error("SH degree {degree}: models are written with degrees 0 to 3; cut the colours first")]
    Degree {
        /// The degree of the model.
        degree: u8,
    },
    /// Parameters that every reader drops.
    #[error(
        "Gaussian {index} has a parameter that is NaN, infinite or absurdly large; \
         remove such Gaussians first (reading a file does)"
    )]
    Unusable {
        /// Index of the first such Gaussian.
        index: usize,
    },
    /// A quaternion of length zero.
    #[error("Gaussian {index} has a rotation of length zero; give it the identity, 1 0 0 0")]
    NoDirection {
        /// Index of the first such Gaussian.
        index: usize,
    },
    /// More Gaussians than the format can count.
    #[error("{count} Gaussians, and {format} holds at most {most}; split or prune the model")]
    TooMany {
        /// Gaussians of the model.
        count: u64,
        /// Most that the format holds.
        most: u64,
        /// The format.
        format: &'static str,
    },
    /// A position that the format cannot hold.
    #[error(
        "Gaussian {index} is at {value:e}, and {format} holds positions up to {limit}; \
         remove Gaussians that far away, scale the model, or write SOG or PLY"
    )]
    Position {
        /// Index of the Gaussian that is farthest away.
        index: usize,
        /// Its coordinate of the largest magnitude, world units.
        value: f32,
        /// The largest magnitude that the format holds, world units.
        limit: u32,
        /// The format.
        format: &'static str,
    },
    /// A file was made that our own reader refuses, as it would a damaged or a hostile one.
    #[error("the file would not be read again ({0}); write INRIA PLY")]
    NotReadBack(#[source] SceneError),
    /// A file was made that does not hold all Gaussians.
    #[error("the file would hold {held} of {of} Gaussians; write INRIA PLY")]
    Incomplete {
        /// Gaussians that were read back.
        held: usize,
        /// Gaussians of the model.
        of: usize,
    },
    /// The encoder of a picture or an archive refused.
    #[error("the file cannot be made: {0}")]
    Encoder(#[from] io::Error),
}
