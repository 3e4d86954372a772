//! Reads a trace from front to back, without seeking and without its footer: what a damaged or
//! unfinished file still holds.

use std::io::{BufReader, Read};

use super::block::{BlockHeader, FOOT, FRAM, HEAD, HEADER, TAIL, tail, u64_at};
use super::encoded::EncodedFrame;
use super::error::TraceError;
use super::head::TraceHeader;
use super::source::Source;

/// What the next block is.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// A frame, not decoded yet.
    Frame(Box<EncodedFrame>),
    /// The list of frames: offset and length of each. The file is complete and ends here.
    Footer(Vec<[u64; 2]>),
}

/// Reads blocks one after the other. Memory: one frame.
#[derive(Debug)]
pub struct Scan<R: Read> {
    source: Source<BufReader<R>>,
    version: (u16, u16),
    header: TraceHeader,
    /// A block header that was read ahead, and where.
    ahead: Option<(u64, BlockHeader)>,
    /// Bytes that were read as a block header and are none.
    window: Vec<u8>,
}

impl<R: Read> Scan<R> {
    /// Reads the trace header.
    ///
    /// # Errors
    /// What is wrong with the trace header; [`TraceError::Io`].
    pub fn new(input: R) -> Result<Scan<R>, TraceError> {
        let mut source = Source { input: BufReader::new(input), offset: 0, frames: 0 };
        let (version, header) = source.trace_header()?;
        Ok(Scan { source, version, header, ahead: None, window: Vec::new() })
    }

    /// The trace header.
    pub fn header(&self) -> &TraceHeader {
        &self.header
    }

    /// The version of the file: major, minor.
    pub fn version(&self) -> (u16, u16) {
        self.version
    }

    /// Bytes read so far.
    pub fn offset(&self) -> u64 {
        self.source.offset
    }

    /// Frames read so far.
    pub fn frames(&self) -> u64 {
        self.source.frames
    }

    /// The next frame, or the footer at the end of a complete file. Optional blocks are left out.
    /// After [`TraceError::Damaged`] and [`TraceError::UnknownBlock`], [`Scan::resume`] goes on.
    ///
    /// # Errors
    /// [`TraceError::Incomplete`] where the file ends without a footer; [`TraceError::Damaged`],
    /// [`TraceError::UnknownBlock`], [`TraceError::Io`].
    pub fn next_item(&mut self) -> Result<Item, TraceError> {
        loop {
            let (at, header) = self.block_header()?;
            match header.tag {
                FRAM => {
                    let head = self.source.frame_head(at, &header)?;
                    let offset = self.source.offset;
                    let columns = self.source.exactly(head.bytes, "a frame is cut short")?;
                    self.source.frames += 1;
                    let frame = EncodedFrame { head, offset, columns };
                    return Ok(Item::Frame(Box::new(frame)));
                }
                FOOT => return self.footer(at, &header).map(Item::Footer),
                HEAD => return Err(TraceError::damaged(at, "there is a second trace header")),
                _ => {
                    header.refuse_if_required(at)?;
                    self.source.content(at, &header, "the file ends within a block")?;
                }
            }
        }
    }

    /// After damage: searches for the next frame or footer; returns whether there is one.
    ///
    /// # Errors
    /// [`TraceError::Io`].
    pub fn resume(&mut self) -> Result<bool, TraceError> {
        let mut window = std::mem::take(&mut self.window);
        loop {
            if window.len() == HEADER {
                window.remove(0);
            }
            let due = (HEADER - window.len()) as u64;
            window.extend(self.source.up_to(due)?);
            let Ok(bytes) = <&[u8; HEADER]>::try_from(window.as_slice()) else {
                return Ok(false);
            };
            if !bytes.starts_with(&FRAM) && !bytes.starts_with(&FOOT) {
                continue;
            }
            if let Ok(header) = BlockHeader::parse(bytes) {
                self.ahead = Some((self.source.offset - HEADER as u64, header));
                return Ok(true);
            }
        }
    }

    /// A block header and its position. Bytes that are none are kept for [`Scan::resume`].
    fn block_header(&mut self) -> Result<(u64, BlockHeader), TraceError> {
        if let Some(ahead) = self.ahead.take() {
            return Ok(ahead);
        }
        let at = self.source.offset;
        let bytes = self.source.array("the list of frames at the end is missing")?;
        BlockHeader::parse(&bytes).map(|header| (at, header)).map_err(|what| {
            self.window = bytes.to_vec();
            TraceError::damaged(at, what)
        })
    }

    fn footer(&mut self, at: u64, header: &BlockHeader) -> Result<Vec<[u64; 2]>, TraceError> {
        let record = self.source.content(at, header, "the list of frames is cut short")?;
        let end = self.source.offset;
        let bytes: [u8; TAIL] = self.source.array("the end mark is missing")?;
        if bytes != tail(at) {
            return Err(TraceError::damaged(end, "the end mark does not match"));
        }
        if !self.source.up_to(1)?.is_empty() {
            return Err(TraceError::damaged(end + TAIL as u64, "bytes follow the end mark"));
        }
        read_footer(&record).map_err(|what| TraceError::damaged(at, what))
    }
}

/// The list of frames of a footer block.
pub(super) fn read_footer(record: &[u8]) -> Result<Vec<[u64; 2]>, &'static str> {
    if !record.len().is_multiple_of(16) {
        return Err("the list of frames has a length that is not a multiple of 16");
    }
    Ok(record.chunks_exact(16).map(|entry| [u64_at(entry, 0), u64_at(entry, 8)]).collect())
}
