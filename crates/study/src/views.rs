//! Frames that are rendered as they are asked for: a scene and the cameras that see it.

use std::ops::Range;
use std::sync::Arc;

use powergs_core::run::{Frames, Pending, RunError};
use powergs_raster::{Detail, Options, render};
use powergs_scene::{Camera, Gaussians};

/// Views of a scene, rendered with the reference tiling and all counters.
#[derive(Debug, Clone)]
pub struct RenderedViews {
    name: String,
    scene: Arc<Gaussians>,
    cameras: Vec<Camera>,
    options: Options,
}

impl RenderedViews {
    /// The views of `cameras` on a black background.
    pub fn new(name: &str, scene: Arc<Gaussians>, cameras: Vec<Camera>) -> RenderedViews {
        let options = Options::reference(Detail::Counters);
        RenderedViews { name: name.to_owned(), scene, cameras, options }
    }

    /// The same on another background, linear RGB.
    pub fn on_background(mut self, background: [f32; 3]) -> RenderedViews {
        self.options.background = background;
        self
    }
}

impl Frames for RenderedViews {
    fn name(&self) -> &str {
        &self.name
    }

    fn range(&self) -> Range<usize> {
        0..self.cameras.len()
    }

    fn size(&mut self) -> Result<(u32, u32), RunError> {
        Ok(self.cameras.first().map_or((0, 0), |camera| (camera.width, camera.height)))
    }

    fn take(&mut self, position: usize) -> Result<Pending, RunError> {
        let (scene, camera) = (Arc::clone(&self.scene), self.cameras[position].clone());
        let options = self.options;
        Ok(Box::new(move || {
            let rendered = render(&scene, &camera, &options);
            Ok(Arc::new(rendered.into_frame(&camera, options.background)))
        }))
    }
}
