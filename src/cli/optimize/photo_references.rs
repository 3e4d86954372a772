//! Photos as references: read once in the size that models train in, and again for the views that
//! judge them in another one.

use std::path::PathBuf;

use super::super::references::FileReferences;
use super::photos;
use powergs_base::picture::Picture;
use powergs_core::run::RunError;
use powergs_optimize::photos::Photo;
use powergs_optimize::references::{ReferenceSink, References};
use powergs_scene::Camera;

/// A photo and its file.
pub type PhotoFile = (PathBuf, Photo);

/// The references that photos are.
pub struct PhotoReferences {
    /// Those that were read.
    pub images: FileReferences,
    /// The photos, one for each view.
    pub photos: Vec<PhotoFile>,
    /// What transparent pixels show, sRGB.
    pub background: [f32; 3],
}

impl References for PhotoReferences {
    fn write_to(&self, view: usize, picture: &mut Picture) {
        self.images.write_to(view, picture);
    }

    fn digest(&self) -> u128 {
        self.images.digest()
    }

    fn push_at(&mut self, view: usize, camera: &Camera) -> Result<Option<Camera>, RunError> {
        let (file, photo) = &self.photos[view];
        let larger = photo.in_size_of(camera);
        let size = |camera: &Camera| (camera.width, camera.height);
        // The photo has no more pixels than the view that trains.
        if size(&larger.view) == size(&photo.view) {
            return Ok(None);
        }
        let reference = photos::reference(file, &larger, self.background);
        // The message names the file.
        let failed = |e| RunError::Input { place: String::new(), message: format!("{e}") };
        let reference = reference.map_err(failed)?;
        self.images.push(reference)?;
        Ok(Some(larger.view))
    }

    fn check(&self) -> Result<(), RunError> {
        self.images.check()
    }
}
