//! Extraction: frames are written into a trace as they are made. Memory does not grow with the
//! length of the trace; while one frame is compressed the next is made.

use std::io::Write;
use std::sync::Arc;

use powergs_core::run::error::causes;
use powergs_core::run::{Frames, RunError, Watch};
use powergs_frame::trace::{ColumnGroup, EncodedFrame, Frame, TraceHeader, Writer};

/// A trace that was written.
#[derive(Debug)]
#[non_exhaustive]
pub struct Extracted<W> {
    /// What it was written to.
    pub out: W,
    /// Frames in it; fewer than there are after a cancellation.
    pub frames: u64,
    /// Visible splats of all frames.
    pub splats: u64,
    /// Bytes that their columns take.
    pub splat_bytes: u64,
    /// Pixels of all frames.
    pub pixels: u64,
    /// Bytes that their columns take.
    pub pixel_bytes: u64,
}

/// Writes frames into a trace, all of them or those that were made before a cancellation. What is
/// written is a valid trace in both cases.
///
/// # Errors
/// [`RunError::Output`]: `out` cannot be written; [`RunError::Internal`]: a frame that no trace can
/// hold; otherwise those of `frames`.
pub fn extract<W: Write>(
    frames: &mut dyn Frames,
    header: &TraceHeader,
    out: W,
    watch: &dyn Watch,
) -> Result<Extracted<W>, RunError> {
    let (range, eyes) = (frames.range(), frames.eyes());
    let range_start = range.start;
    watch.begins(range.len() as u64, 0);
    let mut trace = Trace {
        writer: Writer::new(out, header).map_err(|e| failed(&e))?,
        splats: 0,
        splat_bytes: 0,
        pixels: 0,
        pixel_bytes: 0,
    };
    let mut last: Option<Arc<Frame>> = None;
    for position in range {
        // Never between the eyes of a pair.
        let is_whole = (position - range_start).is_multiple_of(eyes);
        if is_whole && watch.is_cancelled() {
            break;
        }
        let pending = frames.take(position)?;
        let encode = || last.as_deref().map(EncodedFrame::encode).transpose();
        let (encoded, frame) = rayon::join(encode, || pending.get());
        trace.add(encoded.map_err(internal)?)?;
        last = Some(frame?);
        watch.frame_done();
    }
    trace.add(last.as_deref().map(EncodedFrame::encode).transpose().map_err(internal)?)?;
    trace.finish()
}

/// A trace on its way.
struct Trace<W: Write> {
    writer: Writer<W>,
    splats: u64,
    splat_bytes: u64,
    pixels: u64,
    pixel_bytes: u64,
}

impl<W: Write> Trace<W> {
    fn add(&mut self, frame: Option<EncodedFrame>) -> Result<(), RunError> {
        let Some(frame) = frame else { return Ok(()) };
        let camera = &frame.facts().camera;
        self.pixels += u64::from(camera.width) * u64::from(camera.height);
        let info = self.writer.write_encoded(frame).map_err(|e| failed(&e))?;
        self.splats += u64::from(info.head.splats);
        self.splat_bytes += info.stored_bytes(ColumnGroup::Splat);
        self.pixel_bytes += info.stored_bytes(ColumnGroup::Pixel);
        Ok(())
    }

    fn finish(self) -> Result<Extracted<W>, RunError> {
        let Trace { writer, splats, splat_bytes, pixels, pixel_bytes } = self;
        let frames = writer.len();
        let out = writer.finish().map_err(|e| failed(&e))?;
        Ok(Extracted { out, frames, splats, splat_bytes, pixels, pixel_bytes })
    }
}

fn failed(error: &dyn std::error::Error) -> RunError {
    RunError::Output { place: "the trace".into(), message: causes(error) }
}

fn internal(fault: impl std::error::Error) -> RunError {
    RunError::Internal(format!("a frame that no trace can hold: {}", causes(&fault)))
}
