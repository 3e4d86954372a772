//! Bytes with their position: reads that never allocate more than is really there.

use std::io::{Read, Seek, SeekFrom};

use super::block::{BlockHeader, HEAD, PRELUDE, read_prelude, show_tag};
use super::error::TraceError;
use super::head::{FrameHead, TraceHeader};

/// A record longer than this is refused: facts of fixed size and two names.
const RECORD_MAX: u64 = 1 << 18;

/// Room that is made before anything was read, bytes.
const READ_AHEAD: u64 = 64 << 10;

/// An input and how far it was read.
#[derive(Debug)]
pub(super) struct Source<R> {
    pub input: R,
    /// Bytes read so far.
    pub offset: u64,
    /// Whole frames so far, for messages about files that end early.
    pub frames: u64,
}

impl<R: Read> Source<R> {
    /// Prelude and header block.
    pub(super) fn trace_header(&mut self) -> Result<((u16, u16), TraceHeader), TraceError> {
        let version = read_prelude(&self.up_to(PRELUDE as u64)?)?;
        let at = self.offset;
        let header = self.block_header()?;
        if header.tag != HEAD {
            let what = format!("block `{}` where `HEAD` is due", show_tag(header.tag));
            return Err(TraceError::damaged(at, what));
        }
        let record = self.record(at, &header, "the trace header is cut short")?;
        let header = TraceHeader::parse(&record).map_err(|what| TraceError::damaged(at, what))?;
        Ok((version, header))
    }

    /// The next block header.
    pub(super) fn block_header(&mut self) -> Result<BlockHeader, TraceError> {
        let at = self.offset;
        let bytes = self.array("the list of frames at the end is missing")?;
        BlockHeader::parse(&bytes).map_err(|what| TraceError::damaged(at, what))
    }

    /// The facts of the frame whose block header, at `at`, was just read. Its columns follow.
    pub(super) fn frame_head(
        &mut self,
        at: u64,
        header: &BlockHeader,
    ) -> Result<FrameHead, TraceError> {
        let record = self.record(at, header, "the facts of a frame are cut short")?;
        FrameHead::parse(&record).map_err(|what| TraceError::damaged(at, what))
    }

    /// The bytes of a short block that is stored as it is.
    fn record(
        &mut self,
        at: u64,
        header: &BlockHeader,
        short: &'static str,
    ) -> Result<Vec<u8>, TraceError> {
        if header.stored > RECORD_MAX {
            let what = format!("block `{}` is too long", show_tag(header.tag));
            return Err(TraceError::damaged(at, what));
        }
        self.content(at, header, short)
    }

    /// The stored bytes of a block, compared with their checksum. Blocks that are not columns are
    /// never compressed.
    pub(super) fn content(
        &mut self,
        at: u64,
        header: &BlockHeader,
        short: &'static str,
    ) -> Result<Vec<u8>, TraceError> {
        let bytes = self.exactly(header.stored, short)?;
        header.check(&bytes).map_err(|what| TraceError::damaged(at, what))?;
        Ok(bytes)
    }

    pub(super) fn array<const N: usize>(
        &mut self,
        short: &'static str,
    ) -> Result<[u8; N], TraceError> {
        let bytes = self.exactly(N as u64, short)?;
        Ok(std::array::from_fn(|i| bytes[i]))
    }

    pub(super) fn exactly(&mut self, n: u64, short: &'static str) -> Result<Vec<u8>, TraceError> {
        let bytes = self.up_to(n)?;
        if bytes.len() as u64 == n {
            return Ok(bytes);
        }
        let (offset, what, frames) = (self.offset, short, self.frames);
        Err(TraceError::Incomplete { offset, what, frames })
    }

    /// At most `n` bytes; fewer only at the end of the file.
    pub(super) fn up_to(&mut self, n: u64) -> Result<Vec<u8>, TraceError> {
        let mut bytes = Vec::with_capacity(n.min(READ_AHEAD) as usize);
        let read = self.input.by_ref().take(n).read_to_end(&mut bytes);
        read.map_err(TraceError::io(self.offset))?;
        self.offset += bytes.len() as u64;
        Ok(bytes)
    }
}

impl<R: Read + Seek> Source<R> {
    /// Goes to a position.
    pub(super) fn seek(&mut self, to: u64) -> Result<(), TraceError> {
        self.input.seek(SeekFrom::Start(to)).map_err(TraceError::io(to))?;
        self.offset = to;
        Ok(())
    }
}
