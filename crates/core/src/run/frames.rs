//! Where frames come from: a trace file, memory, or views that are rendered as they are asked for.

use std::ops::Range;
use std::sync::Arc;

use powergs_frame::trace::Frame;

use super::error::RunError;

/// A frame that is still to be decoded or rendered; done on a worker thread.
pub type Pending = Box<dyn FnOnce() -> Result<Arc<Frame>, RunError> + Send>;

/// A list of frames.
pub trait Frames {
    /// Name of the list in reports: the stem of the trace file.
    fn name(&self) -> &str;

    /// Positions of the frames; those of a trace file may be a part of it.
    fn range(&self) -> Range<usize>;

    /// Width and height of the first frame, pixels.
    ///
    /// # Errors
    /// [`RunError::Input`]: it cannot be read.
    fn size(&mut self) -> Result<(u32, u32), RunError>;

    /// The frame at a position of [`Frames::range`]. What needs the source is done at once, the
    /// rest when the pending frame is called.
    ///
    /// # Errors
    /// [`RunError::Input`]: it cannot be read.
    fn take(&mut self, position: usize) -> Result<Pending, RunError>;
}

/// Frames in memory.
#[derive(Debug, Clone, Default)]
pub struct MemoryFrames {
    /// Name of the list.
    pub name: String,
    /// The frames.
    pub frames: Vec<Arc<Frame>>,
}

impl MemoryFrames {
    /// A list of frames.
    pub fn new(name: &str, frames: impl IntoIterator<Item = Frame>) -> MemoryFrames {
        let frames = frames.into_iter().map(Arc::new).collect();
        MemoryFrames { name: name.to_owned(), frames }
    }
}

impl Frames for MemoryFrames {
    fn name(&self) -> &str {
        &self.name
    }

    fn range(&self) -> Range<usize> {
        0..self.frames.len()
    }

    fn size(&mut self) -> Result<(u32, u32), RunError> {
        let camera = self.frames.first().map(|frame| &frame.facts.camera);
        Ok(camera.map_or((0, 0), |c| (c.width, c.height)))
    }

    fn take(&mut self, position: usize) -> Result<Pending, RunError> {
        let frame = Arc::clone(&self.frames[position]);
        Ok(Box::new(move || Ok(frame)))
    }
}

/// At most `count` positions of a range, spread evenly.
pub fn spread(range: Range<usize>, count: usize) -> Vec<usize> {
    let n = count.min(range.len());
    (0..n).map(|i| range.start + (2 * i + 1) * range.len() / (2 * n)).collect()
}
