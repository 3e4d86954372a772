//! A frame as it is in the file: compressed, checksummed, not decoded yet.
//!
//! Reading and decoding are apart, so that frames can be decoded on many threads while one reads.

use std::io::{self, Write};

use rayon::prelude::*;

use super::block::{BlockHeader, FRAM, HEADER, show_tag};
use super::column::{Column, ColumnGroup, IDS, Id, Presence};
use super::content::{Content, assemble, content, decode_column, encode_column};
use super::error::{FrameFault, TraceError};
use super::head::FrameHead;
use super::{Frame, FrameFacts};

/// The bytes of one frame and the facts in front of them.
#[derive(Debug, Clone, PartialEq)]
pub struct EncodedFrame {
    /// The facts.
    pub(super) head: FrameHead,
    /// Where the column blocks begin in the file; 0 before they are written.
    pub(super) offset: u64,
    /// The column blocks.
    pub(super) columns: Vec<u8>,
}

/// Facts and sizes of a frame, known without decompressing it.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameInfo {
    /// Number, splats, facts.
    pub head: FrameHead,
    /// The frame's bytes in the file, all headers included.
    pub bytes: u64,
    /// The columns in file order.
    pub columns: Vec<ColumnInfo>,
}

/// The size of one column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ColumnInfo {
    /// The column; `None` where this version does not know it.
    pub column: Option<&'static Column>,
    /// Bytes before compression.
    pub raw_bytes: u64,
    /// Bytes in the file, with the block header.
    pub stored_bytes: u64,
}

impl FrameInfo {
    /// Bytes in the file of the columns of one group, with their block headers.
    pub fn stored_bytes(&self, group: ColumnGroup) -> u64 {
        self.columns_of(group).map(|c| c.stored_bytes).sum()
    }

    /// Bytes before compression of the columns of one group.
    pub fn raw_bytes(&self, group: ColumnGroup) -> u64 {
        self.columns_of(group).map(|c| c.raw_bytes).sum()
    }

    fn columns_of(&self, group: ColumnGroup) -> impl Iterator<Item = &ColumnInfo> {
        self.columns
            .iter()
            .filter(move |c| c.column.map_or(ColumnGroup::Other, |known| known.group) == group)
    }
}

/// A column block within a frame.
struct EncodedBlock<'a> {
    at: u64,
    header: BlockHeader,
    stored: &'a [u8],
}

impl EncodedFrame {
    /// Encodes a frame, after [`Frame::check`]. The result does not depend on threads.
    ///
    /// # Errors
    /// The first rule that [`Frame::check`] finds broken.
    pub fn encode(frame: &Frame) -> Result<EncodedFrame, FrameFault> {
        frame.check()?;
        let blocks: Vec<Vec<u8>> = IDS
            .par_iter()
            .filter_map(|&id| content(frame, id).map(|content| encode_column(id, content)))
            .collect();
        let mut head = FrameHead::of(frame);
        head.blocks = blocks.len() as u32;
        let columns = blocks.concat();
        head.bytes = columns.len() as u64;
        head.to_bytes().map_err(|what| FrameFault::Facts { what })?;
        Ok(EncodedFrame { head, offset: 0, columns })
    }

    /// Facts and counts.
    pub(crate) fn head(&self) -> &FrameHead {
        &self.head
    }

    /// The facts of the frame.
    pub fn facts(&self) -> &FrameFacts {
        &self.head.facts
    }

    /// Where the frame begins in the file it was read from.
    pub(crate) fn start(&self) -> u64 {
        self.offset.saturating_sub(self.head_block().len() as u64)
    }

    /// The frame's bytes in the file, headers included.
    pub fn bytes(&self) -> u64 {
        (self.head_block().len() + self.columns.len()) as u64
    }

    /// The sizes of the columns.
    ///
    /// # Errors
    /// [`TraceError::Damaged`] for a block header that contradicts the frame.
    pub fn info(&self) -> Result<FrameInfo, TraceError> {
        let mut columns = Vec::new();
        for block in self.blocks() {
            columns.push(column_info(&block?.header));
        }
        Ok(FrameInfo { head: self.head.clone(), bytes: self.bytes(), columns })
    }

    /// Memory that decoding takes, bytes: the columns as their headers promise them, and the
    /// numbers that are made of them.
    pub fn decoding_bytes(&self) -> u64 {
        let raw = self.blocks().map(|block| block.map_or(0, |block| block.header.raw));
        raw.fold(0, u64::saturating_add).saturating_mul(2)
    }

    /// The frame, decoded. Checksums, lengths and [`Frame::check`] all hold.
    ///
    /// # Errors
    /// [`TraceError::Damaged`], [`TraceError::UnknownBlock`] and [`TraceError::Frame`].
    pub fn decode(&self) -> Result<Frame, TraceError> {
        let mut found: Vec<Option<EncodedBlock<'_>>> = IDS.iter().map(|_| None).collect();
        let mut blocks = 0;
        for block in self.blocks() {
            let block = block?;
            blocks += 1;
            block.header.check(block.stored).map_err(|e| TraceError::damaged(block.at, e))?;
            let Some(id) = Id::from_tag(block.header.tag) else {
                block.header.refuse_if_required(block.at)?;
                continue;
            };
            if let Some(twice) = found[id as usize].replace(block) {
                let what =
                    format!("frame {}: `{}` appears twice", self.head.number, id.column().name);
                return Err(TraceError::damaged(twice.at, what));
            }
        }
        if blocks != self.head.blocks {
            let what = format!("{blocks} column blocks where {} were promised", self.head.blocks);
            return Err(TraceError::damaged(self.offset, what));
        }
        self.head.facts.check().map_err(|fault| self.frame_error(fault))?;
        let contents: Result<Vec<Option<Content>>, TraceError> = IDS
            .par_iter()
            .zip(&found)
            .map(|(&id, block)| self.column(id, block.as_ref()))
            .collect();
        let frame = assemble(&self.head, contents?)
            .map_err(|what| TraceError::damaged(self.offset, what))?;
        frame.check().map_err(|fault| self.frame_error(fault))?;
        Ok(frame)
    }

    /// The block of facts, with its header.
    pub(super) fn head_block(&self) -> Vec<u8> {
        let record = self.head.to_bytes().expect("checked when it was encoded or read");
        let mut block = BlockHeader::stored(FRAM, &record).to_bytes().to_vec();
        block.extend(record);
        block
    }

    pub(super) fn write_to(&self, out: &mut impl Write) -> io::Result<()> {
        out.write_all(&self.head_block())?;
        out.write_all(&self.columns)
    }

    fn frame_error(&self, fault: FrameFault) -> TraceError {
        TraceError::Frame { frame: self.head.number, fault }
    }

    fn blocks(&self) -> impl Iterator<Item = Result<EncodedBlock<'_>, TraceError>> {
        let mut rest = self.columns.as_slice();
        let end = self.offset + self.columns.len() as u64;
        std::iter::from_fn(move || {
            if rest.is_empty() {
                return None;
            }
            let at = end - rest.len() as u64;
            let block = next_block(at, rest);
            rest = match &block {
                Ok((_, after)) => after,
                Err(_) => &[],
            };
            Some(block.map(|(block, _)| block).map_err(|what| TraceError::damaged(at, what)))
        })
    }

    fn column(
        &self,
        id: Id,
        block: Option<&EncodedBlock<'_>>,
    ) -> Result<Option<Content>, TraceError> {
        let column = id.column();
        let due = match column.presence {
            Presence::Always => Some(true),
            Presence::Foveated => Some(self.head.gaze.is_some()),
            Presence::OptionalFoveated if self.head.gaze.is_some() => None,
            Presence::OptionalFoveated => Some(false),
            Presence::Optional => None,
        };
        if due.is_some_and(|due| due != block.is_some()) {
            let verb = if block.is_some() { "is there but not due" } else { "is missing" };
            let what = format!("frame {}: column `{}` {verb}", self.head.number, column.name);
            return Err(TraceError::damaged(self.offset, what));
        }
        let Some(block) = block else { return Ok(None) };
        decode_column(column, column.raw_bytes(self.head.counts()), &block.header, block.stored)
            .map(Some)
            .map_err(|what| {
                let (frame, name) = (self.head.number, column.name);
                TraceError::damaged(block.at, format!("frame {frame}, column `{name}`: {what}"))
            })
    }
}

pub(super) fn column_info(header: &BlockHeader) -> ColumnInfo {
    ColumnInfo {
        column: Id::from_tag(header.tag).map(Id::column),
        raw_bytes: header.raw,
        stored_bytes: header.stored.saturating_add(HEADER as u64),
    }
}

fn next_block(at: u64, bytes: &[u8]) -> Result<(EncodedBlock<'_>, &[u8]), String> {
    let (header, rest) = bytes.split_first_chunk().ok_or("the frame ends within a block header")?;
    let header = BlockHeader::parse(header)?;
    let split = usize::try_from(header.stored).ok().and_then(|n| rest.split_at_checked(n));
    let Some((stored, after)) = split else {
        return Err(format!("block `{}` is longer than its frame", show_tag(header.tag)));
    };
    Ok((EncodedBlock { at, header, stored }, after))
}
