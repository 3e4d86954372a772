//! Reads any frame of a complete trace, through the list of frames at its end.

use std::io::{Read, Seek, SeekFrom};

use super::Frame;
use super::block::{FOOT, FRAM, TAIL, read_tail, show_tag};
use super::encoded::{EncodedFrame, FrameInfo, column_info};
use super::error::TraceError;
use super::head::{FrameHead, TraceHeader};
use super::scan::{Item, Scan, read_footer};
use super::source::Source;

/// An open trace. Memory: 16 bytes a frame, besides the frames that the caller holds.
#[derive(Debug)]
pub struct Reader<R: Read + Seek> {
    source: Source<R>,
    version: (u16, u16),
    header: TraceHeader,
    /// Offset and length of each frame.
    frames: Vec<[u64; 2]>,
    bytes: u64,
}

impl<R: Read + Seek> Reader<R> {
    /// Opens a trace. One that was not finished is refused, after a look at how many of its frames
    /// are whole.
    ///
    /// # Errors
    /// [`TraceError::Incomplete`] for an unfinished trace; what is wrong with the header or the
    /// list of frames; [`TraceError::Io`].
    pub fn open(mut input: R) -> Result<Reader<R>, TraceError> {
        input.rewind().map_err(TraceError::io(0))?;
        let mut source = Source { input, offset: 0, frames: 0 };
        let (version, header) = source.trace_header()?;
        let first = source.offset;
        let bytes = source.input.seek(SeekFrom::End(0)).map_err(TraceError::io(first))?;
        let Some(footer) = find_footer(&mut source, first, bytes)? else {
            return Err(incomplete(source, bytes));
        };
        let frames = read_list(&mut source, footer, bytes)?;
        let mut at = first;
        for [offset, length] in &frames {
            let end = offset.checked_add(*length).filter(|&end| *offset >= at && end <= footer);
            at = end.ok_or_else(|| {
                TraceError::damaged(footer, "the list of frames points outside the file")
            })?;
        }
        Ok(Reader { source, version, header, frames, bytes })
    }

    /// The trace header.
    pub fn header(&self) -> &TraceHeader {
        &self.header
    }

    /// The version of the file: major, minor.
    pub fn version(&self) -> (u16, u16) {
        self.version
    }

    /// Frames in the trace.
    pub fn len(&self) -> u64 {
        self.frames.len() as u64
    }

    /// Whether the trace has no frames.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Size of the file, bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Reads frame `k` without looking into its columns; [`EncodedFrame::decode`] does, on any
    /// thread.
    ///
    /// # Errors
    /// [`TraceError::NoSuchFrame`], a damaged frame head, [`TraceError::Io`].
    pub fn read_block(&mut self, k: u64) -> Result<EncodedFrame, TraceError> {
        let (head, _) = self.head(k)?;
        let offset = self.source.offset;
        let columns = self.source.exactly(head.bytes, "a frame is cut short")?;
        Ok(EncodedFrame { head, offset, columns })
    }

    /// Reads and decodes frame `k`.
    ///
    /// # Errors
    /// Those of [`Reader::read_block`] and [`EncodedFrame::decode`].
    pub fn frame(&mut self, k: u64) -> Result<Frame, TraceError> {
        self.read_block(k)?.decode()
    }

    /// Facts and column sizes of frame `k`; the columns are stepped over.
    ///
    /// # Errors
    /// [`TraceError::NoSuchFrame`], a damaged block header, [`TraceError::Io`].
    pub fn info(&mut self, k: u64) -> Result<FrameInfo, TraceError> {
        let (head, bytes) = self.head(k)?;
        let end = self.source.offset + head.bytes;
        let mut columns = Vec::new();
        while self.source.offset < end {
            let at = self.source.offset;
            let header = self.source.block_header()?;
            columns.push(column_info(&header));
            let next = self.source.offset.checked_add(header.stored).filter(|&next| next <= end);
            let next = next.ok_or_else(|| {
                let what = format!("block `{}` is longer than its frame", show_tag(header.tag));
                TraceError::damaged(at, what)
            })?;
            self.source.seek(next)?;
        }
        Ok(FrameInfo { head, bytes, columns })
    }

    /// The facts and the length of frame `k`; its columns come next.
    fn head(&mut self, k: u64) -> Result<(FrameHead, u64), TraceError> {
        let entry = usize::try_from(k).ok().and_then(|k| self.frames.get(k));
        let frames = self.frames.len() as u64;
        let &[at, length] = entry.ok_or(TraceError::NoSuchFrame { frame: k, frames })?;
        self.source.seek(at)?;
        let header = self.source.block_header()?;
        if header.tag != FRAM {
            let what = format!("block `{}` where frame {k} is due", show_tag(header.tag));
            return Err(TraceError::damaged(at, what));
        }
        let head = self.source.frame_head(at, &header)?;
        if head.number != k || self.source.offset.checked_add(head.bytes) != Some(at + length) {
            let what = format!("frame {k} is not what the list of frames says");
            return Err(TraceError::damaged(at, what));
        }
        head.check(&self.header).map_err(|fault| TraceError::Frame { frame: k, fault })?;
        Ok((head, length))
    }
}

/// The offset of the footer, if the file has its end mark.
fn find_footer<R: Read + Seek>(
    source: &mut Source<R>,
    first: u64,
    bytes: u64,
) -> Result<Option<u64>, TraceError> {
    let Some(end) = bytes.checked_sub(TAIL as u64).filter(|&end| end >= first) else {
        return Ok(None);
    };
    source.seek(end)?;
    let tail = source.array("the end mark is cut short")?;
    Ok(read_tail(&tail).filter(|&footer| footer >= first && footer < end))
}

fn read_list<R: Read + Seek>(
    source: &mut Source<R>,
    footer: u64,
    bytes: u64,
) -> Result<Vec<[u64; 2]>, TraceError> {
    source.seek(footer)?;
    let header = source.block_header()?;
    let end = header.stored.checked_add(source.offset + TAIL as u64);
    if header.tag != FOOT || end != Some(bytes) {
        return Err(TraceError::damaged(footer, "there is no list of frames"));
    }
    let record = source.content(footer, &header, "the list of frames is cut short")?;
    read_footer(&record).map_err(|what| TraceError::damaged(footer, what))
}

/// The error of a file without an end mark: says where it ends and how many frames are whole.
fn incomplete<R: Read + Seek>(mut source: Source<R>, bytes: u64) -> TraceError {
    let what = "the list of frames at the end is missing";
    let none = TraceError::Incomplete { offset: bytes, what, frames: 0 };
    if source.seek(0).is_err() {
        return none;
    }
    let Ok(mut scan) = Scan::new(source.input) else { return none };
    while let Ok(Item::Frame(_)) = scan.next_item() {}
    TraceError::Incomplete { offset: bytes, what, frames: scan.frames() }
}
