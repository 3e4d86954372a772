//! Errors of camera files.

use thiserror::Error;

/// An error of a camera reader: the place, what is wrong there, and what to do.
#[derive(Debug, Error)]
pub enum CameraError {
    /// The text is not JSON.
    #[error("line {line}, column {column}: not JSON: {what}; re-export the camera file")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The parser's words.
        what: String,
    },
    /// JSON, but no known layout.
    #[error(
        "neither a list of views (INRIA `cameras.json`) nor an object with a `frames` list (NeRF \
         `transforms.json`) or a `camera_path` list (nerfstudio); give one of these, or a folder \
         with COLMAP's `cameras` and `images`"
    )]
    Layout,
    /// The cameras of another program.
    #[error("{format} is not read; {todo}")]
    Foreign {
        /// What it is.
        format: &'static str,
        /// How to get a file that is read.
        todo: &'static str,
    },
    /// No views.
    #[error("holds no views; export at least one")]
    Empty,
    /// A value of one view is missing or out of range.
    #[error("{view}, key `{key}`: {what}")]
    Value {
        /// Which view: its position from 0, and its name where it has one.
        view: String,
        /// The key, as the file writes it.
        key: &'static str,
        /// What is wrong and what would be right.
        what: String,
    },
    /// A `transforms.json` without image size, as the Blender sets have.
    #[error("{view}, keys `w`, `h`: the image size is missing; give it as WIDTHxHEIGHT")]
    NoSize {
        /// Which view.
        view: String,
    },
    /// A COLMAP binary file is damaged.
    #[error("{file}, byte {offset}: {what}")]
    Binary {
        /// `cameras.bin`, `images.bin` or `points3D.bin`.
        file: &'static str,
        /// Where the bad item starts.
        offset: u64,
        /// What is wrong.
        what: String,
    },
    /// A COLMAP text file is damaged.
    #[error("{file}, line {line}: {what}")]
    Text {
        /// `cameras.txt`, `images.txt` or `points3D.txt`.
        file: &'static str,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
}
