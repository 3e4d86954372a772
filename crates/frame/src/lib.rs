//! What a frame *is*, independent of any machine: a model and a camera, projected splats, where a
//! viewer looks, the trace file, and the power that a display needs to show a picture.

#![warn(clippy::missing_errors_doc)]

pub mod display;
pub mod fovea;
pub mod scene;
pub mod splat;
pub mod trace;
