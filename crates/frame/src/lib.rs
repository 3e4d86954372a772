//! What a frame *is*, independent of any machine: a model and a camera, projected splats, the gaze,
//! the trace file, and the power that a display needs to show a picture.

pub mod display;
pub mod fovea;
pub mod scene;
pub mod splat;
pub mod trace;
