//! Scene files: readers against writers, against real data, and against hostile bytes.

mod hostile;
mod kinds;
mod layouts;
mod round_trip;

use powergs_scene::{Model, OneFile, SceneError, read};

/// Reads bytes of any single-file format.
pub(crate) fn read_bytes(bytes: &[u8]) -> Result<Model, SceneError> {
    read(&OneFile(bytes), "bytes", None)
}
