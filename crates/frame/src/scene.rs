//! A scene in memory: a trained model and a pinhole camera.
//!
//! [`Gaussians`] holds *raw* parameters (log-scale, un-normalised quaternion, logit opacity), as
//! trained and as stored by the INRIA PLY layout. Activations happen where splats are projected.
//! Readers of file formats are in the crate `powergs-scene`.

mod camera;
mod gaussians;
mod order;
mod sh_degree;

pub use camera::{Camera, Eye, PairOrder, Split, are_pairs};
pub use gaussians::Gaussians;
pub use order::StorageOrder;
pub use sh_degree::ShDegree;
