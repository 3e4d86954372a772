//! Reference images: what the views of a run should look like.

use rayon::prelude::*;
use xxhash_rust::xxh3::Xxh3;

use powergs_base::picture::Picture;
use powergs_core::run::RunError;
use powergs_scene::Camera;

/// A reference image in 16 bits a channel: half the room of floats, exact for 8-bit photos, and 96
/// dB away from any other image in 0..1.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reference {
    width: u32,
    height: u32,
    codes: Vec<[u16; 3]>,
}

impl Reference {
    /// Stores a picture; values are clamped to 0..1.
    pub fn new(picture: &Picture) -> Reference {
        let code = |v: f32| (f64::from(v.clamp(0.0, 1.0)) * 65535.0).round() as u16;
        let codes = picture.pixels.par_iter().map(|p| p.map(code)).collect();
        Reference { width: picture.width, height: picture.height, codes }
    }

    /// A reference of `width` x `height` pixels, all black.
    pub fn black(width: u32, height: u32) -> Reference {
        Reference { width, height, codes: vec![[0; 3]; width as usize * height as usize] }
    }

    /// Width and height, pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The codes: three numbers of 16 bits a pixel, in the order of this processor.
    pub fn as_bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.codes)
    }

    /// The same, to be written.
    pub fn as_bytes_mut(&mut self) -> &mut [u8] {
        bytemuck::cast_slice_mut(&mut self.codes)
    }

    /// Writes the picture over another.
    pub fn write_to(&self, picture: &mut Picture) {
        (picture.width, picture.height) = (self.width, self.height);
        self.codes
            .par_iter()
            .map(|c| c.map(|v| f32::from(v) / 65535.0))
            .collect_into_vec(&mut picture.pixels);
    }
}

/// Where the reference images of a run are: in memory, or somewhere that memory is not spent on.
pub trait References: Send + Sync {
    /// Writes the reference of a view over `picture`.
    fn write_to(&self, view: usize, picture: &mut Picture);

    /// A hash of all of them, in the order of the views.
    fn digest(&self) -> u128;

    /// Adds, behind the last one, what a view looks like in the size of `camera`, which shows it:
    /// photos have more pixels than models train with. Gives the view as that reference has it,
    /// which is never larger than the photo. `None`: there is nothing but the reference that it
    /// has.
    ///
    /// # Errors
    /// [`RunError`]: it cannot be read or kept.
    fn push_at(&mut self, view: usize, camera: &Camera) -> Result<Option<Camera>, RunError> {
        let _ = (view, camera);
        Ok(None)
    }

    /// Fails if a reference could not be read since the beginning: what was made from it is
    /// worthless.
    ///
    /// # Errors
    /// [`RunError::Output`]: the medium that they are kept on fails.
    fn check(&self) -> Result<(), RunError> {
        Ok(())
    }
}

/// Takes references one by one, so that they need not be in memory together.
pub trait ReferenceSink: References {
    /// Adds the reference of the next view.
    ///
    /// # Errors
    /// [`RunError::Output`]: it cannot be kept.
    fn push(&mut self, reference: Reference) -> Result<(), RunError>;
}

impl References for Vec<Reference> {
    fn write_to(&self, view: usize, picture: &mut Picture) {
        self[view].write_to(picture);
    }

    fn digest(&self) -> u128 {
        let mut hash = Xxh3::new();
        self.iter().for_each(|reference| hash.update(reference.as_bytes()));
        hash.digest128()
    }
}

impl ReferenceSink for Vec<Reference> {
    fn push(&mut self, reference: Reference) -> Result<(), RunError> {
        Vec::push(self, reference);
        Ok(())
    }
}

/// The reference images of a run, and what they show.
pub enum ReferenceImages {
    /// Renders of the dense model, which are made at the beginning and kept here.
    OwnRenders(Box<dyn ReferenceSink>),
    /// Photos, one for each view.
    Photos(Box<dyn References>),
}

impl ReferenceImages {
    /// Renders of the dense model, in memory.
    pub fn own() -> ReferenceImages {
        ReferenceImages::OwnRenders(Box::new(Vec::new()))
    }

    /// Whether the dense model is compared with itself.
    pub fn is_own(&self) -> bool {
        matches!(self, ReferenceImages::OwnRenders(_))
    }

    /// The images themselves.
    pub fn images(&self) -> &dyn References {
        match self {
            ReferenceImages::OwnRenders(sink) => &**sink,
            ReferenceImages::Photos(images) => &**images,
        }
    }
}
