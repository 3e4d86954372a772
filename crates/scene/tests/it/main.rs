//! Readers and writers of scenes, readers of cameras.

mod camera;
mod export;
mod foveated;
mod regressions;
mod scene;
