//! Extraction in memory: a trace holds the frames that went into it, also where it was cancelled.

use std::io::Cursor;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use powergs_core::run::{Frames, MemoryFrames, Watch};
use powergs_frame::scene::StorageOrder;
use powergs_frame::trace::{Frame, Reader, TraceHeader};
use powergs_study::extract::{Extracted, extract};

use crate::frames;

fn header(frames: &MemoryFrames) -> TraceHeader {
    let points = frames.frames[0].facts.points;
    TraceHeader {
        generator: "test".to_owned(),
        scene: "demo".to_owned(),
        points,
        order: StorageOrder::Storage,
    }
}

fn read(trace: &Extracted<Vec<u8>>) -> Vec<Frame> {
    let mut reader = Reader::open(Cursor::new(&trace.out)).expect("a trace");
    let len = reader.len();
    let frame = |i| reader.read_block(i).expect("a block").decode().expect("a frame");
    (0..len).map(frame).collect()
}

#[test]
fn a_trace_has_the_frames_that_went_in() {
    let mut source = frames(3);
    let header = header(&source);
    let trace = extract(&mut source, &header, Vec::new(), &()).expect("a trace");
    let expected: Vec<Frame> = source.frames.iter().map(|f| Frame::clone(f)).collect();
    assert_eq!((trace.frames, read(&trace)), (3, expected));
    let (width, height) = source.size().expect("a size");
    assert_eq!(trace.pixels, 3 * u64::from(width) * u64::from(height));
    assert!(trace.splats > 0 && trace.splat_bytes > 0 && trace.pixel_bytes > 0);
    assert!(trace.splat_bytes + trace.pixel_bytes < trace.out.len() as u64);
}

/// Cancels after some frames.
struct Until(AtomicU64);

impl Watch for Until {
    fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }

    fn frame_done(&self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

#[test]
fn a_cancelled_trace_has_the_frames_that_were_done() {
    let mut source = frames(3);
    let watch = Until(AtomicU64::new(2));
    let header = header(&source);
    let trace = extract(&mut source, &header, Vec::new(), &watch).expect("a trace");
    assert_eq!(trace.frames, 2);
    let expected: Vec<&Arc<Frame>> = source.frames[..2].iter().collect();
    assert!(read(&trace).iter().zip(expected).all(|(read, made)| *read == **made));
}
