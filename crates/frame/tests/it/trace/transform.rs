//! What is done to a column before it is compressed.

use powergs_frame::trace::Transform;

#[test]
fn every_transform_can_be_undone() {
    let words =
        vec![0, 1, u32::MAX, 0x8000_0000, 0x7fff_ffff, (-0.0f32).to_bits(), 3, 2, 0xdead_beef];
    for code in 0..5 {
        let transform = Transform::from_code(code).unwrap();
        assert_eq!(transform as u8, code);
        assert_eq!(transform.undo(&transform.apply(words.clone())), words, "{transform:?}");
    }
    let bytes = vec![1, 255, 3, 0, 0, 7, 200];
    let delta = Transform::RgbDelta.apply_bytes(bytes.clone());
    assert_eq!(delta, [1, 255, 3, 255, 1, 4, 200]);
    assert_eq!(Transform::RgbDelta.undo_bytes(delta), bytes);
    assert_eq!(Transform::from_code(6), None);
}

/// Differences of 0, -1, 1 and -2 become 0, 1, 2 and 3: the lowest plane holds them.
#[test]
fn folding_is_as_documented() {
    let words = [0i32, -1, 0, -2].map(|w| w as u32);
    let folded = Transform::FoldedDeltaPlanes.apply(words.to_vec());
    assert_eq!(folded[..4], [0, 1, 2, 3]);
    assert_eq!(folded[4..], [0; 12]);
    assert_eq!(Transform::FoldedDeltaPlanes.undo(&folded), words);
}
