//! Models and camera files by path. All other modules of this crate take bytes or text.

mod cameras;
mod colmap;
mod models;
mod points;
mod training_run;

use std::error::Error;
use std::fmt;

pub use cameras::{has_cameras, open_cameras};
pub use models::{OpenedModel, is_foveated, open_foveated, open_model, open_model_as};
pub use points::{open_colmap_points, open_point_ply};
pub use training_run::{RunBackground, background_of};

use super::camera::CameraError;
use super::error::SceneError;

/// A model or a camera file that cannot be read. The message begins with the path.
#[derive(Debug, thiserror::Error)]
#[error("{place}: {}", Causes(what))]
pub struct FileError {
    /// The file or folder.
    pub place: String,
    /// What is wrong with it.
    pub what: FileFault,
}

/// What is wrong with a file.
#[derive(Debug, thiserror::Error)]
pub enum FileFault {
    /// The operating system refused.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// It is no model, or a damaged one.
    #[error(transparent)]
    Model(#[from] SceneError),
    /// It is no camera file, or a damaged one.
    #[error(transparent)]
    Cameras(#[from] CameraError),
    /// It is something else altogether; what, and what to do.
    #[error("{0}")]
    Other(String),
}

/// An error and its causes, joined with colons, each once.
struct Causes<'a>(&'a dyn Error);

impl fmt::Display for Causes<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut said = self.0.to_string();
        f.write_str(&said)?;
        let mut cause = self.0.source();
        while let Some(error) = cause {
            let text = error.to_string();
            if !said.ends_with(&text) {
                write!(f, ": {text}")?;
            }
            said = text;
            cause = error.source();
        }
        Ok(())
    }
}

/// Says which file an error is about.
fn at<E: Into<FileFault>>(place: impl fmt::Display) -> impl FnOnce(E) -> FileError {
    let place = place.to_string();
    move |error| FileError { place, what: error.into() }
}

/// A file that is something else.
fn other(place: impl fmt::Display, what: impl Into<String>) -> FileError {
    FileError { place: place.to_string(), what: FileFault::Other(what.into()) }
}
