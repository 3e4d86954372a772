//! What is written is read, to the bit.

use std::io::Cursor;

use powergs_frame::trace::{Frame, Item, NEVER, Reader, Scan, Writer, verify};
use powergs_testkit::traces::{SMALL, Shape, frame, header, read_all, written};
use proptest::prelude::*;

/// Frames as bits: −0.0 and 0.0 differ.
fn bits(frames: &[Frame]) -> Vec<Vec<u8>> {
    frames.iter().map(|f| bytemuck::cast_slice(&f.splats).to_vec()).collect()
}

#[track_caller]
fn check(frames: &[Frame]) {
    let bytes = written(frames);
    let read = read_all(&bytes).unwrap();
    assert_eq!(read, frames);
    assert_eq!(bits(&read), bits(frames));
    let report = verify(bytes.as_slice()).unwrap();
    assert!(report.is_good(), "{report:?}");
    let n = frames.len() as u64;
    assert_eq!((report.intact, report.listed, report.bytes), (n, Some(n), bytes.len() as u64));
    assert_eq!(written(&read), bytes, "the same frames give the same bytes");
}

/// No files beside the tests: a seed that fails is printed.
fn config() -> ProptestConfig {
    ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config())]
    #[test]
    fn random_frames(
        seed: u64,
        points in 0u32..60,
        share in 0.0..1.0,
        width in 1u32..9,
        height in 1u32..9,
        foveated: bool,
        extras: bool,
    ) {
        let splats = (f64::from(points) * share) as u32;
        let shape = Shape { points, splats, width, height, foveated, extras };
        check(&[frame(seed, shape), frame(seed ^ 1, Shape { foveated: !foveated, ..shape })]);
    }
}

#[test]
fn edges() {
    check(&[]);
    check(&[frame(1, Shape { points: 0, splats: 0, width: 1, height: 1, ..SMALL })]);
    check(&[frame(2, Shape { points: 1, splats: 1, width: 1, height: 1, ..SMALL })]);
    check(&[frame(3, Shape { width: 65_536, height: 1, ..SMALL })]);
    let mut named = frame(4, SMALL);
    named.facts.camera.name = "é".repeat(32_767);
    named.facts.camera.split = None;
    check(&[named]);
}

#[test]
fn large_blank_columns_stay_small_and_readable() {
    let mut blank = frame(5, Shape { points: 3, splats: 0, width: 2048, height: 1024, ..SMALL });
    blank.pixels.stop_rank.fill(NEVER);
    blank.pixels.blended.fill(0);
    let bytes = written(std::slice::from_ref(&blank));
    assert!(bytes.len() < 8 * 2048 * 1024 / 100, "{} bytes", bytes.len());
    assert_eq!(read_all(&bytes).unwrap(), [blank]);
}

#[test]
fn random_access_equals_sequential() {
    let frames: Vec<Frame> = (0..5).map(|k| frame(k, SMALL)).collect();
    let bytes = written(&frames);
    let mut reader = Reader::open(Cursor::new(&bytes)).unwrap();
    assert_eq!((reader.len(), reader.bytes()), (5, bytes.len() as u64));
    assert_eq!(reader.header(), &header(21));
    let mut scan = Scan::new(bytes.as_slice()).unwrap();
    let sequential: Vec<_> = (0..5)
        .map(|_| match scan.next_item().unwrap() {
            Item::Frame(frame) => *frame,
            Item::Footer(_) => panic!("five frames come first"),
        })
        .collect();
    for k in [3, 0, 4, 4, 1, 2] {
        let block = reader.read_block(k).unwrap();
        assert_eq!(block, sequential[k as usize]);
        assert_eq!(block.decode().unwrap(), frames[k as usize]);
        assert_eq!(block.info().unwrap(), reader.info(k).unwrap());
    }
    assert!(matches!(scan.next_item().unwrap(), Item::Footer(list) if list.len() == 5));
    let error = reader.frame(5).unwrap_err().to_string();
    assert_eq!(error, "no frame 5: the trace has 5 frames, numbered from 0");
}

#[test]
fn encoded_frames_can_move_to_another_trace() {
    let frames: Vec<Frame> = (0..3).map(|k| frame(k, SMALL)).collect();
    let mut reader = Reader::open(Cursor::new(written(&frames))).unwrap();
    let mut writer = Writer::new(Vec::new(), reader.header()).unwrap();
    for k in [2, 1] {
        writer.write_encoded(reader.read_block(k).unwrap()).unwrap();
    }
    let bytes = writer.finish().unwrap();
    assert_eq!(bytes, written(&[frames[2].clone(), frames[1].clone()]));
}

#[test]
fn threads_do_not_matter() {
    let frames: Vec<Frame> = (0..3).map(|k| frame(k, SMALL)).collect();
    let with = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| written(&frames))
    };
    assert_eq!(with(1), with(5));
}
