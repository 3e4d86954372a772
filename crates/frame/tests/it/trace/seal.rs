//! Makes the checksums of damaged trace bytes right again, so that the damage reaches the decoder.

/// Recomputes the checksums of prelude, blocks and tail; lengths are taken as they are.
pub fn seal(bytes: &mut [u8]) {
    let put = |bytes: &mut [u8], from: usize, to: usize| {
        let crc = crc32fast::hash(&bytes[from..to]);
        bytes[to..to + 4].copy_from_slice(&crc.to_le_bytes());
    };
    let (mut at, end) = (16, bytes.len());
    if end < at {
        return;
    }
    put(bytes, 0, 12);
    while at + 32 <= end {
        let stored: [u8; 8] = std::array::from_fn(|i| bytes[at + 16 + i]);
        let stored = usize::try_from(u64::from_le_bytes(stored)).unwrap_or(end).min(end - at - 32);
        let crc = crc32fast::hash(&bytes[at + 32..at + 32 + stored]);
        bytes[at + 24..at + 28].copy_from_slice(&crc.to_le_bytes());
        put(bytes, at, at + 28);
        at += 32 + stored;
    }
    if end >= 32 {
        put(bytes, end - 16, end - 8);
    }
}
