//! Where frames come from: a trace file, memory, or views that are rendered as they are asked for.

use std::io;
use std::ops::Range;
use std::sync::Arc;

use powergs_base::budget::Budget;
use powergs_frame::scene::{Camera, Eye, StorageOrder, are_pairs};
use powergs_frame::trace::{Frame, TraceHeader, Writer};
use xxhash_rust::xxh3::Xxh3;

use super::error::RunError;
use super::input::Input;

/// A frame that is still to be decoded or rendered; done on a worker thread.
pub struct Pending {
    /// Memory that it takes until it is there, bytes, about.
    pub bytes: u64,
    work: Box<dyn FnOnce() -> Result<Arc<Frame>, RunError> + Send>,
}

impl Pending {
    /// A frame that takes so much memory to make.
    pub fn new(
        bytes: u64,
        work: impl FnOnce() -> Result<Arc<Frame>, RunError> + Send + 'static,
    ) -> Pending {
        Pending { bytes, work: Box::new(work) }
    }

    /// The frame.
    ///
    /// # Errors
    /// [`RunError::Input`]: it is damaged.
    pub fn get(self) -> Result<Arc<Frame>, RunError> {
        (self.work)()
    }
}

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

    /// Views that make a frame of the display: 2 where the positions are the left and the right eye
    /// of pairs in turn, else 1.
    fn eyes(&self) -> usize;

    /// The frame at a position of [`Frames::range`]. What needs the source is done at once, the
    /// rest when the pending frame is called.
    ///
    /// # Errors
    /// [`RunError::Input`]: it cannot be read, or takes more memory than [`Frames::budget`].
    fn take(&mut self, position: usize) -> Result<Pending, RunError>;

    /// Memory that a frame may take.
    fn budget(&self) -> Budget {
        Budget::DEFAULT
    }

    /// Allows frames another amount of memory. Frames that are in memory anyway ignore it.
    fn allow(&mut self, _budget: Budget) {}

    /// What results depend on: the trace file, or for frames that are in none, their contents as a
    /// trace would have them.
    ///
    /// # Errors
    /// [`RunError::Input`]: a frame that cannot be read, or that no trace can hold.
    fn identity(&mut self) -> Result<Input, RunError> {
        let mut contents = Contents::default();
        let name = self.name().to_owned();
        let eyes = self.eyes();
        // A trace each, of the two views where views are pairs.
        for first in self.range().step_by(eyes) {
            let views = (first..first + eyes).map(|position| self.take(position)?.get());
            let views = views.collect::<Result<Vec<Arc<Frame>>, RunError>>()?;
            let points = views[0].facts.points;
            let header = TraceHeader {
                generator: String::new(),
                scene: name.clone(),
                points,
                order: StorageOrder::Storage,
            };
            let written = Writer::new(&mut contents, &header).and_then(|mut writer| {
                views.iter().try_for_each(|frame| writer.write_frame(frame).map(drop))?;
                writer.finish()
            });
            written.map_err(|e| RunError::input(&name, e))?;
        }
        let Contents { hash, bytes } = contents;
        Ok(Input { role: "trace", name, bytes, xxh3: hash.digest128() })
    }
}

/// Hashes the bytes written to it.
#[derive(Default)]
struct Contents {
    hash: Xxh3,
    bytes: u64,
}

impl io::Write for Contents {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.hash.update(bytes);
        self.bytes += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<F: Frames + ?Sized> Frames for &mut F {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn range(&self) -> Range<usize> {
        (**self).range()
    }

    fn size(&mut self) -> Result<(u32, u32), RunError> {
        (**self).size()
    }

    fn eyes(&self) -> usize {
        (**self).eyes()
    }

    fn take(&mut self, position: usize) -> Result<Pending, RunError> {
        (**self).take(position)
    }

    fn budget(&self) -> Budget {
        (**self).budget()
    }

    fn allow(&mut self, budget: Budget) {
        (**self).allow(budget);
    }

    fn identity(&mut self) -> Result<Input, RunError> {
        (**self).identity()
    }
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

    fn eyes(&self) -> usize {
        eyes(self.frames.iter().map(|frame| &frame.facts.camera))
    }

    fn take(&mut self, position: usize) -> Result<Pending, RunError> {
        let frame = Arc::clone(&self.frames[position]);
        Ok(Pending::new(0, move || Ok(frame)))
    }
}

/// Views that make a frame of the display, as [`Frames::eyes`].
pub fn eyes<'a>(views: impl IntoIterator<Item = &'a Camera>) -> usize {
    if are_pairs(views) { Eye::ALL.len() } else { 1 }
}

/// The positions of at most `count` frames of the display, spread evenly over a range of views;
/// each frame has `eyes` of them.
pub fn spread(range: Range<usize>, eyes: usize, count: usize) -> Vec<usize> {
    let frames = range.len() / eyes;
    let n = count.min(frames);
    let first = |i: usize| range.start + (2 * i + 1) * frames / (2 * n) * eyes;
    (0..n).flat_map(|i| first(i)..first(i) + eyes).collect()
}
