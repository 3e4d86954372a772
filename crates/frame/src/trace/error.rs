//! Errors of trace files and frames.

use powergs_base::format::counted;
use std::io;

/// Why a trace cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// Reading or writing failed.
    #[error("at byte {offset}: {source}; check the disk and try again")]
    Io {
        /// Position in the file.
        offset: u64,
        /// What the system says.
        source: io::Error,
    },
    /// The file does not begin like a trace.
    #[error("at byte 0: {what}; traces are written by `powergs-sim extract`")]
    NotATrace {
        /// What was found instead.
        what: &'static str,
    },
    /// The file is of a newer major version.
    #[error(
        "at byte 8: the trace has format version {}.{}, this program reads versions up to {}.x; \
         update the program or extract the trace again",
        found.0, found.1, supported.0
    )]
    Version {
        /// Major and minor version in the file.
        found: (u16, u16),
        /// What this program writes.
        supported: (u16, u16),
    },
    /// The file was not finished, or its end is lost.
    #[error(
        "INCOMPLETE: {what} at byte {offset}; {} could be recovered; extract the trace again, or \
         keep what is whole with `trace repair`",
        counted(.frames, "whole frame")
    )]
    Incomplete {
        /// Position in the file.
        offset: u64,
        /// What is missing.
        what: &'static str,
        /// Frames whose blocks are all there.
        frames: u64,
    },
    /// Bytes that contradict their checksum, their length or the format.
    #[error("at byte {offset}: {what}; the file is damaged, copy or extract it again")]
    Damaged {
        /// Position in the file.
        offset: u64,
        /// What is wrong.
        what: String,
    },
    /// A block that must be understood and is not.
    #[error(
        "at byte {offset}: block `{tag}` is not known to this version and cannot be left out; \
         update the program"
    )]
    UnknownBlock {
        /// Position in the file.
        offset: u64,
        /// Its tag, escaped.
        tag: String,
    },
    /// A frame that breaks a rule of traces.
    #[error("frame {frame}: {fault}")]
    Frame {
        /// Number of the frame, from 0.
        frame: u64,
        /// The broken rule.
        fault: FrameFault,
    },
    /// The header breaks a rule.
    #[error("trace header: {what}")]
    Header {
        /// The broken rule.
        what: &'static str,
    },
    /// A frame that the file does not hold.
    #[error("no frame {frame}: the trace has {}, numbered from 0", counted(.frames, "frame"))]
    NoSuchFrame {
        /// What was asked for.
        frame: u64,
        /// Frames in the file.
        frames: u64,
    },
}

impl TraceError {
    /// The position in the file, where the error has one.
    pub fn offset(&self) -> Option<u64> {
        match self {
            TraceError::Io { offset, .. }
            | TraceError::Incomplete { offset, .. }
            | TraceError::Damaged { offset, .. }
            | TraceError::UnknownBlock { offset, .. } => Some(*offset),
            TraceError::NotATrace { .. } => Some(0),
            TraceError::Version { .. } => Some(8),
            TraceError::Frame { .. }
            | TraceError::Header { .. }
            | TraceError::NoSuchFrame { .. } => None,
        }
    }

    /// The message without place and advice, for a line of a list.
    pub fn what(&self) -> String {
        match self {
            TraceError::Damaged { what, .. } => what.clone(),
            TraceError::Incomplete { what, .. } => format!("INCOMPLETE: {what}"),
            TraceError::UnknownBlock { tag, .. } => format!("block `{tag}` is not known"),
            TraceError::NotATrace { what } | TraceError::Header { what } => (*what).into(),
            TraceError::Frame { frame, fault } => format!("frame {frame}: {fault}"),
            TraceError::Io { .. } | TraceError::Version { .. } | TraceError::NoSuchFrame { .. } => {
                self.to_string()
            }
        }
    }

    pub(super) fn damaged(offset: u64, what: impl Into<String>) -> TraceError {
        TraceError::Damaged { offset, what: what.into() }
    }

    pub(super) fn io(offset: u64) -> impl FnOnce(io::Error) -> TraceError {
        move |source| TraceError::Io { offset, source }
    }
}

/// A rule of frames that is broken.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FrameFault {
    /// A fact of the frame.
    #[error("{what}")]
    Facts {
        /// The broken rule.
        what: &'static str,
    },
    /// A column of the wrong length.
    #[error("column `{column}` has {found} entries where {expected} are due")]
    Length {
        /// Name of the column.
        column: &'static str,
        /// Entries due.
        expected: u64,
        /// Entries found.
        found: u64,
    },
    /// A value that cannot be.
    #[error("column `{column}`, entry {entry}: {value} {rule}")]
    Value {
        /// Name of the column.
        column: &'static str,
        /// Position in the column, from 0.
        entry: u64,
        /// The value.
        value: f64,
        /// The broken rule, as the end of a sentence.
        rule: &'static str,
    },
}
