//! Cameras: where a scene is seen from, read from four file layouts or generated.
//!
//! Readers take text or bytes: [`json::read`] (INRIA `cameras.json`, NeRF `transforms.json` and
//! nerfstudio's camera paths, told apart by their shape), [`colmap::read_binary`] and
//! [`colmap::read_text`]. [`nerfstudio`] puts cameras into the frame of its models. Generators:
//! [`orbit`] and [`path`]. [`edit`] changes single views, [`views`] says which of a list are taken,
//! [`lens`] what photos show that lenses have bent. Every camera that leaves this module is
//! checked.

use std::collections::BTreeMap;

pub mod check;
pub mod colmap;
pub mod edit;
mod error;
pub(crate) mod foreign;
pub mod fov;
pub mod inria;
pub mod json;
pub mod lens;
mod nerf;
pub mod nerfstudio;
pub mod orbit;
pub mod path;
pub mod views;

pub use error::CameraError;
pub use lens::Lens;
pub use nerfstudio::Placement;
pub use powergs_frame::scene::{Camera, Eye, Split};

/// The content of a camera file.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraFile {
    /// The layout that was recognised: `INRIA cameras.json`, `NeRF transforms.json`, `nerfstudio
    /// camera path`, `COLMAP binary`, `COLMAP text`.
    pub format: &'static str,
    /// The views, at least one.
    pub cameras: Vec<Camera>,
    /// By the name of its view, the lens of each photo that was bent by one. Views are rendered
    /// without it.
    pub lenses: BTreeMap<String, Lens>,
    /// What rendering the views leaves out, one sentence each.
    pub warnings: Vec<String>,
    /// What looks odd whatever the views are for, one sentence each.
    pub doubts: Vec<String>,
    /// The frame that poses are in.
    pub frame: Frame,
}

/// The frame that the poses of a file are in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Frame {
    /// That of the trained model.
    Model,
    /// That of the data set, after a placement of it; nerfstudio trains in another.
    Data(Placement),
}
