//! Writes a trace as a stream: one frame in memory at a time, nothing is sought.

use std::io::Write;

use super::block::{BlockHeader, FOOT, HEAD, prelude, tail};
use super::encoded::{EncodedFrame, FrameInfo};
use super::error::{FrameFault, TraceError};
use super::head::TraceHeader;
use super::{Frame, VERSION};
use crate::scene::PairOrder;

/// A trace being written. Without [`Writer::finish`] the file stays incomplete, and readers say so.
#[derive(Debug)]
pub struct Writer<W: Write> {
    out: W,
    header: TraceHeader,
    offset: u64,
    /// Offset and length of each frame.
    frames: Vec<[u64; 2]>,
    pairs: PairOrder,
}

impl<W: Write> Writer<W> {
    /// Begins a trace.
    ///
    /// # Errors
    /// [`TraceError::Header`] for a header that breaks a rule; [`TraceError::Io`].
    pub fn new(out: W, header: &TraceHeader) -> Result<Writer<W>, TraceError> {
        let record = header.to_bytes().map_err(|what| TraceError::Header { what })?;
        let mut writer = Writer {
            out,
            header: header.clone(),
            offset: 0,
            frames: Vec::new(),
            pairs: PairOrder::default(),
        };
        writer.put(&prelude(VERSION))?;
        writer.put_block(HEAD, &record)?;
        Ok(writer)
    }

    /// Encodes and writes a frame; returns the sizes of its columns.
    ///
    /// # Errors
    /// [`TraceError::Frame`] for a frame that breaks a rule of traces; [`TraceError::Io`].
    pub fn write_frame(&mut self, frame: &Frame) -> Result<FrameInfo, TraceError> {
        let number = self.frames.len() as u64;
        let encoded = EncodedFrame::encode(frame)
            .map_err(|fault| TraceError::Frame { frame: number, fault })?;
        self.write_encoded(encoded)
    }

    /// Writes a frame that was encoded elsewhere, or read from another trace, as the next one;
    /// returns the sizes of its columns.
    ///
    /// # Errors
    /// [`TraceError::Frame`] for a frame that does not fit the header, damage in its blocks,
    /// [`TraceError::Io`].
    pub fn write_encoded(&mut self, mut frame: EncodedFrame) -> Result<FrameInfo, TraceError> {
        frame.head.number = self.frames.len() as u64;
        let number = frame.head.number;
        let in_order = self.pairs.next(&frame.head.facts.camera);
        let in_order = in_order.map_err(|what| FrameFault::Facts { what });
        let checked = in_order.and_then(|()| frame.head.check(&self.header));
        checked.map_err(|fault| TraceError::Frame { frame: number, fault })?;
        let info = frame.info()?;
        frame.write_to(&mut self.out).map_err(TraceError::io(self.offset))?;
        self.frames.push([self.offset, info.bytes]);
        self.offset += info.bytes;
        Ok(info)
    }

    /// Frames written so far.
    pub fn len(&self) -> u64 {
        self.frames.len() as u64
    }

    /// Whether no frame was written yet.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Writes the list of frames, flushes, and returns the output.
    ///
    /// # Errors
    /// [`TraceError::Frame`]: half of a pair is the last; [`TraceError::Io`].
    pub fn finish(mut self) -> Result<W, TraceError> {
        self.pairs.end().map_err(|what| {
            let fault = FrameFault::Facts { what };
            TraceError::Frame { frame: self.len().saturating_sub(1), fault }
        })?;
        let footer = self.offset;
        let record: Vec<u8> =
            self.frames.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect();
        self.put_block(FOOT, &record)?;
        self.put(&tail(footer))?;
        self.out.flush().map_err(TraceError::io(self.offset))?;
        Ok(self.out)
    }

    fn put_block(&mut self, tag: [u8; 4], record: &[u8]) -> Result<(), TraceError> {
        self.put(&BlockHeader::stored(tag, record).to_bytes())?;
        self.put(record)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), TraceError> {
        self.out.write_all(bytes).map_err(TraceError::io(self.offset))?;
        self.offset += bytes.len() as u64;
        Ok(())
    }
}
