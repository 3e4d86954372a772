//! Trained 3DGS models and cameras: readers of every known file format, writers, synthetic scenes.
//!
//! [`Gaussians`] holds *raw* parameters (log-scale, un-normalised quaternion, logit opacity), as
//! trained and as stored by the INRIA PLY layout. Activations happen where splats are projected.
//! [`read()`] decodes every known file format; [`export`] writes INRIA's and the compressed ones
//! and says what was lost, [`write_ply`] writes INRIA's as a stream; [`files`] opens models and
//! camera files by path.

mod axes;
pub mod camera;
mod check;
pub mod convert;
mod error;
pub mod export;
pub mod files;
mod foreign;
pub mod foveated;
pub mod gaze;
mod gltf;
mod input;
mod ply;
mod points;
mod read;
mod smallest_three;
mod sog;
mod splat_rows;
mod spz;
pub mod stats;
pub mod synth;
mod warning;

pub use axes::StoredAxes;
pub use error::SceneError;
pub use foveated::Foveated;
pub use input::{Folder, Input, OneFile};
pub use ply::write as write_ply;
pub use points::PointCloud;
pub use powergs_frame::scene::{Camera, Eye, Gaussians, ShDegree, Split, StorageOrder};
pub use read::{Format, Model, ReadAs, read, read_as};
pub use stats::SceneStats;
pub use warning::Warning;
