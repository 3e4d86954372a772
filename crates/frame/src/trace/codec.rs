//! Compression of blocks: zstd, with a bound on the decompressed size.

use super::transform::Transform;

/// Bytes are stored as they are.
pub(crate) const STORED: u8 = 0;
/// One zstd frame, or several one after the other.
pub const ZSTD: u8 = 1;

/// Level 1 keeps extraction fast; on trace columns level 3 gains under 1 %.
const LEVEL: i32 = 1;
/// A block may expand to this many bytes whatever its size …
const EXPANSION_FREE: u64 = 1 << 20;
/// … and to this many for each stored byte.
const EXPANSION_RATIO: u64 = 1024;
/// Bytes in a zstd frame of a column that would otherwise expand too much: even constant bytes
/// then stay below `EXPANSION_RATIO`.
pub const SMALL_FRAME: usize = 8 << 10;

/// Whether `stored` bytes may claim to decompress to `raw` bytes. This bounds the memory that a
/// hostile file can make a reader allocate.
pub fn may_expand(stored: u64, raw: u64) -> bool {
    raw <= EXPANSION_FREE.saturating_add(stored.saturating_mul(EXPANSION_RATIO))
}

/// Compresses a transformed column; returns the codec and the stored bytes. Each byte plane is a
/// zstd frame of its own: planes differ in their statistics.
pub fn compress(raw: Vec<u8>, transform: Transform) -> (u8, Vec<u8>) {
    let piece = if transform.is_planar() { raw.len() / 4 } else { raw.len() };
    let mut packed = pieces(&raw, piece);
    if !may_expand(packed.len() as u64, raw.len() as u64) {
        packed = pieces(&raw, SMALL_FRAME);
    }
    if packed.len() < raw.len() { (ZSTD, packed) } else { (STORED, raw) }
}

fn pieces(raw: &[u8], piece: usize) -> Vec<u8> {
    let mut packed = Vec::new();
    for bytes in raw.chunks(piece.max(1)) {
        let frame = zstd::bulk::compress(bytes, LEVEL).expect("memory to memory cannot fail");
        packed.extend_from_slice(&frame);
    }
    packed
}

/// The bytes that were compressed, exactly `raw` of them. The caller has asked [`may_expand`].
///
/// # Errors
/// The fault of the block, as a phrase: an unknown codec, damage, or another length.
pub fn decompress(codec: u8, stored: &[u8], raw: u64) -> Result<Vec<u8>, String> {
    debug_assert!(may_expand(stored.len() as u64, raw), "the header was checked");
    let bytes = match codec {
        STORED => stored.to_vec(),
        ZSTD => zstd::bulk::decompress(stored, raw as usize)
            .map_err(|e| format!("the block cannot be decompressed ({e})"))?,
        other => return Err(format!("codec {other} is not known")),
    };
    if bytes.len() as u64 != raw {
        return Err(format!("the block holds {} bytes where {raw} were promised", bytes.len()));
    }
    Ok(bytes)
}
