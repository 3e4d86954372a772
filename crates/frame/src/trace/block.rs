//! The bytes around the data: file prelude, block headers, file tail.
//!
//! Every byte of a file is covered by a CRC-32 or compared with a constant, so that any flipped bit
//! is found.

use super::codec::{self, STORED};
use super::error::TraceError;
use super::transform::Transform;

/// First bytes of a file. A high first byte and both line ends show transfers that are not binary.
pub(super) const MAGIC: [u8; 8] = *b"\x89PGST\r\n\x1a";
/// Bytes of the prelude: magic, version, checksum.
pub(super) const PRELUDE: usize = 16;
/// Bytes of a block header.
pub(super) const HEADER: usize = 32;
/// Bytes of the tail: offset of the footer, checksum, end mark.
pub(super) const TAIL: usize = 16;
/// Last bytes of a complete file.
const END: [u8; 4] = *b"END\n";
/// The layout of block headers.
const BLOCK_VERSION: u8 = 1;

/// The trace header.
pub(super) const HEAD: [u8; 4] = *b"HEAD";
/// Facts of a frame; its column blocks follow.
pub(super) const FRAM: [u8; 4] = *b"FRAM";
/// The list of frames.
pub(super) const FOOT: [u8; 4] = *b"FOOT";

/// The first bytes of a file of the given version.
pub(super) fn prelude(version: (u16, u16)) -> [u8; PRELUDE] {
    let mut bytes = [0; PRELUDE];
    bytes[..8].copy_from_slice(&MAGIC);
    bytes[8..10].copy_from_slice(&version.0.to_le_bytes());
    bytes[10..12].copy_from_slice(&version.1.to_le_bytes());
    let crc = crc32fast::hash(&bytes[..12]);
    bytes[12..].copy_from_slice(&crc.to_le_bytes());
    bytes
}

/// The version of a file that can be read. `bytes` may be shorter than a prelude.
pub(super) fn read_prelude(bytes: &[u8]) -> Result<(u16, u16), TraceError> {
    if bytes.is_empty() {
        return Err(TraceError::NotATrace { what: "the file is empty" });
    }
    let known = bytes.len().min(MAGIC.len());
    if bytes[..known] != MAGIC[..known] {
        return Err(TraceError::NotATrace { what: "this is not a trace file" });
    }
    let Ok(bytes) = <&[u8; PRELUDE]>::try_from(bytes) else {
        let (what, offset) = ("the file ends", bytes.len() as u64);
        return Err(TraceError::Incomplete { offset, what, frames: 0 });
    };
    let version = (u16_at(bytes, 8), u16_at(bytes, 10));
    if u32_at(bytes, 12) != crc32fast::hash(&bytes[..12]) {
        return Err(TraceError::damaged(8, "the checksum of the version does not match"));
    }
    if version.0 > super::VERSION.0 {
        return Err(TraceError::Version { found: version, supported: super::VERSION });
    }
    Ok(version)
}

/// The last bytes of a file whose footer block begins at `footer`.
pub(super) fn tail(footer: u64) -> [u8; TAIL] {
    let mut bytes = [0; TAIL];
    bytes[..8].copy_from_slice(&footer.to_le_bytes());
    let crc = crc32fast::hash(&bytes[..8]);
    bytes[8..12].copy_from_slice(&crc.to_le_bytes());
    bytes[12..].copy_from_slice(&END);
    bytes
}

/// The offset of the footer, if these are the last bytes of a complete file.
pub(super) fn read_tail(bytes: &[u8; TAIL]) -> Option<u64> {
    let whole = bytes[12..] == END && u32_at(bytes, 8) == crc32fast::hash(&bytes[..8]);
    whole.then(|| u64_at(bytes, 0))
}

/// The header of a block; its stored bytes follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BlockHeader {
    pub tag: [u8; 4],
    /// Number of the compression; only known where the tag is.
    pub codec: u8,
    /// Number of the transform; only known where the tag is.
    pub transform: u8,
    /// Bytes before compression.
    pub raw: u64,
    /// Bytes that follow this header.
    pub stored: u64,
    /// CRC-32 of the bytes that follow.
    pub crc: u32,
}

impl BlockHeader {
    /// A block of bytes that are stored as they are.
    pub(super) fn stored(tag: [u8; 4], bytes: &[u8]) -> BlockHeader {
        BlockHeader::of(tag, STORED, Transform::Plain, bytes.len() as u64, bytes)
    }

    /// A block of `raw` bytes that became `stored`.
    pub(super) fn of(
        tag: [u8; 4],
        codec: u8,
        transform: Transform,
        raw: u64,
        stored: &[u8],
    ) -> BlockHeader {
        let (transform, crc) = (transform as u8, crc32fast::hash(stored));
        BlockHeader { tag, codec, transform, raw, stored: stored.len() as u64, crc }
    }

    pub(super) fn to_bytes(self) -> [u8; HEADER] {
        let mut bytes = [0; HEADER];
        bytes[..4].copy_from_slice(&self.tag);
        bytes[4] = BLOCK_VERSION;
        bytes[5] = self.codec;
        bytes[6] = self.transform;
        bytes[8..16].copy_from_slice(&self.raw.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.stored.to_le_bytes());
        bytes[24..28].copy_from_slice(&self.crc.to_le_bytes());
        let crc = crc32fast::hash(&bytes[..28]);
        bytes[28..].copy_from_slice(&crc.to_le_bytes());
        bytes
    }

    /// Reads a header; the fault otherwise. Lengths that it promises are plausible afterwards, not
    /// yet true.
    pub(super) fn parse(bytes: &[u8; HEADER]) -> Result<BlockHeader, String> {
        if u32_at(bytes, 28) != crc32fast::hash(&bytes[..28]) {
            return Err("the checksum of a block header does not match".into());
        }
        let tag = [bytes[0], bytes[1], bytes[2], bytes[3]];
        let name = show_tag(tag);
        if bytes[4] != BLOCK_VERSION || bytes[7] != 0 {
            return Err(format!("block `{name}` has layout {}, {BLOCK_VERSION} is read", bytes[4]));
        }
        let (raw, stored) = (u64_at(bytes, 8), u64_at(bytes, 16));
        if !codec::may_expand(stored, raw) || (bytes[5] == STORED && raw != stored) {
            return Err(format!("block `{name}` promises {raw} bytes from {stored} stored ones"));
        }
        let crc = u32_at(bytes, 24);
        Ok(BlockHeader { tag, codec: bytes[5], transform: bytes[6], raw, stored, crc })
    }

    /// Whether a reader that does not know the block must give up.
    pub(super) fn is_required(&self) -> bool {
        !self.tag[0].is_ascii_lowercase()
    }

    /// Compares the checksum with the bytes that follow the header.
    pub(super) fn check(&self, stored: &[u8]) -> Result<(), String> {
        if crc32fast::hash(stored) == self.crc {
            return Ok(());
        }
        Err(format!("the checksum of block `{}` does not match", show_tag(self.tag)))
    }

    /// The refusal of a block that is not known; nothing if it may be left out.
    pub(super) fn refuse_if_required(&self, offset: u64) -> Result<(), TraceError> {
        if !self.is_required() {
            return Ok(());
        }
        Err(TraceError::UnknownBlock { offset, tag: show_tag(self.tag) })
    }
}

/// A tag for messages: other than printable characters are escaped.
pub(super) fn show_tag(tag: [u8; 4]) -> String {
    tag.escape_ascii().to_string()
}

pub(super) fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}

pub(super) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from_le_bytes(std::array::from_fn(|i| bytes[at + i]))
}
