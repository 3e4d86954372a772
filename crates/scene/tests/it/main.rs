//! Readers of scenes and cameras.

mod camera;
mod foveated;
mod scene;
