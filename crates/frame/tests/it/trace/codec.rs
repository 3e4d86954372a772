//! Compression of blocks, bounded in what it may expand to.

use powergs_frame::trace::Transform;
use powergs_frame::trace::codec::{SMALL_FRAME, ZSTD, compress, decompress, may_expand};

#[test]
fn constant_columns_stay_within_the_allowed_expansion() {
    let raw = vec![0xffu8; 9 << 20];
    let (codec, packed) = compress(raw.clone(), Transform::Plain);
    assert_eq!(codec, ZSTD);
    assert!(may_expand(packed.len() as u64, raw.len() as u64));
    // A small frame takes 19 bytes; a release of zstd that takes a few more is no fault.
    assert!(packed.len() <= 24 * raw.len() / SMALL_FRAME, "{} bytes", packed.len());
    assert_eq!(decompress(codec, &packed, raw.len() as u64).unwrap(), raw);
}

#[test]
fn promises_are_held() {
    let (codec, packed) = compress(vec![7u8; 4000], Transform::Plain);
    assert!(decompress(codec, &packed, 3999).is_err(), "more than promised");
    assert!(decompress(codec, &packed, 4001).is_err(), "less than promised");
    assert!(decompress(codec, &packed[..packed.len() - 1], 4000).is_err(), "cut short");
    assert!(decompress(9, &packed, 4000).is_err(), "unknown codec");
    assert!(!may_expand(20, 4 << 30), "a small block cannot promise 4 GiB");
}
