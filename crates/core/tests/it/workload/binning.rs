//! Lists with pointers: what is moved, and where it lies (A90).

use std::collections::HashSet;

use powergs_base::budget::Budget;
use powergs_base::quantity::Bytes;
use powergs_core::workload::binning::{ListMove, ListShape, ListWrites, Moved, demand};
use powergs_core::workload::{FrameWorkload, Geometry, bin};

use super::support::dense_frame;

const SHAPE: ListShape = ListShape {
    entry: 6,
    pointer: 4,
    pointers: 1 << 20,
    line: 32,
    lines: 1 << 20,
    merges: false,
    block: Some(128),
};

fn frame(seed: u64) -> FrameWorkload {
    bin(&dense_frame(seed), Geometry { tile: 16, ..Geometry::REFERENCE })
}

/// All shapes that differ in what is on chip, in blocks and in how parts of lines are written.
fn shapes() -> Vec<ListShape> {
    let mut all = Vec::new();
    for (pointers, lines) in [(0, 0), (1, 1), (3, 7), (7, 3), (1 << 20, 0), (1 << 20, 1 << 20)] {
        for (merges, block) in [(false, Some(128)), (true, Some(32)), (true, None), (false, None)] {
            for entry in [3, 32] {
                all.push(ListShape { entry, pointers, lines, merges, block, ..SHAPE });
            }
        }
    }
    all
}

/// The moves of a pass.
fn moves(lists: &ListWrites, counts: bool) -> impl Iterator<Item = (Moved, u64, [u64; 2], u32)> {
    let part = lists.part(counts, 0, u64::MAX);
    (part.first..part.first + part.moves).map(move |at| {
        let own = lists.moved(counts, at);
        (own.what, lists.place_of(own), lists.bytes_of(own), own.tile)
    })
}

#[test]
fn every_byte_of_a_list_is_written_and_no_pointer_is_read_before() {
    for seed in 0..2 {
        let workload = frame(seed);
        for shape in shapes() {
            let lists = ListWrites::new(&workload, shape);
            let mut written = vec![false; lists.sizes()[0] as usize];
            let mut there = HashSet::new();
            let passes: &[bool] = if lists.counts_first() { &[true, false] } else { &[false] };
            for &counts in passes {
                for (what, place, [read, write], tile) in moves(&lists, counts) {
                    match what {
                        Moved::PointerIn => assert!(there.contains(&tile), "{shape:?} {tile}"),
                        Moved::PointerOut => drop(there.insert(tile)),
                        Moved::Entries => {
                            let bytes = |n: u64| place as usize..(place + n) as usize;
                            assert!(written[bytes(read)].iter().all(|&is| is));
                            written[bytes(write)].fill(true);
                            assert!(shape.merges || read == 0);
                            assert!(!shape.merges || place.is_multiple_of(shape.line));
                        }
                    }
                }
            }
            let mut read = vec![false; written.len()];
            for (tile, work) in workload.tiles.iter().enumerate() {
                let bytes = lists.shape().list_bytes(u64::from(work.entries));
                let mut at = 0;
                while at < bytes {
                    let (place, own) = lists.run(tile as u32, at, bytes - at);
                    let bytes = &mut read[place as usize..(place + own) as usize];
                    assert!(bytes.iter().all(|&is| !is), "two lists have it: {shape:?}");
                    bytes.fill(true);
                    at += own;
                }
            }
            assert!(read == written && read.iter().any(|&is| is), "{shape:?}");
        }
    }
}

/// What is quickly known is enough, and what is counted is not above it.
#[test]
fn what_lists_take_is_known_before_they_are_made() {
    let workload = frame(0);
    for shape in shapes() {
        let lists = ListWrites::new(&workload, shape);
        let moves: u64 =
            [true, false].map(|counts| lists.part(counts, 0, u64::MAX).moves).iter().sum();
        let bytes = moves * size_of::<ListMove>() as u64;
        let quick = demand(&workload, &shape, Budget::DEFAULT).expect("a small frame");
        assert!(bytes <= quick, "{shape:?}: {bytes} of {quick}");
        let counted = demand(&workload, &shape, Budget(Bytes(quick - 1))).expect("it fits");
        assert!((bytes..quick).contains(&counted), "{shape:?}: {bytes}, {counted}, {quick}");
        let over = demand(&workload, &shape, Budget(Bytes(counted - 1))).expect_err("too little");
        assert_eq!(over.needed, counted, "{shape:?}");
    }
}

#[test]
fn with_room_for_all_only_whole_lines_and_ends_are_written() {
    for seed in 0..4 {
        let workload = frame(seed);
        for block in [Some(128), None] {
            let lists = ListWrites::new(&workload, ListShape { block, ..SHAPE });
            let bytes = |entries: u32| lists.shape().list_bytes(u64::from(entries));
            let all = || workload.tiles.iter().map(|tile| bytes(tile.entries));
            let part = lists.part(false, 0, u64::MAX);
            assert_eq!(part.moves, all().map(|n| n.div_ceil(SHAPE.line)).sum::<u64>());
            assert_eq!((part.read, part.write), (0, all().sum()));
            if block.is_none() {
                assert_eq!(lists.part(true, 0, u64::MAX).moves, 0);
            }
        }
    }
}

/// 20 entries of 6 B in blocks of 32 B that end with 4 B: 28 + 28 + 28 + 28 + 8.
#[test]
fn blocks_end_with_a_pointer_to_the_next() {
    let shape = ListShape { block: Some(32), ..SHAPE };
    let lists = ListWrites::new(&FrameWorkload::empty(Geometry::REFERENCE), shape);
    let bytes = |entries| lists.shape().list_bytes(entries);
    assert_eq!([0, 1, 4, 5, 20].map(bytes), [0, 6, 24, 34, 136]);
}

/// Less on chip is more to move, here by a known number: one place for all pointers is taken by
/// another tile whenever the tile changes.
#[test]
fn what_is_not_on_chip_moves() {
    let workload = frame(1);
    let total = |shape| {
        let part = ListWrites::new(&workload, shape).part(false, 0, u64::MAX);
        [part.moves, part.read + part.write]
    };
    let all = total(SHAPE);
    for (pointers, lines) in [(1, 1 << 20), (1 << 20, 1), (0, 1 << 20), (1 << 20, 0), (0, 0)] {
        let less = total(ListShape { pointers, lines, ..SHAPE });
        assert!(less[0] > all[0] && less[1] >= all[1], "{pointers} {lines}: {less:?} {all:?}");
    }
    let pairs = workload.counters.tile_pairs;
    let lines = moves(&ListWrites::new(&workload, ListShape { lines: 0, ..SHAPE }), false).count();
    // An entry that crosses the end of a line leaves in two parts.
    assert!(lines as u64 > pairs && (lines as u64) < 2 * pairs);
    let merged = total(ListShape { lines: 1, merges: true, ..SHAPE });
    let masked = total(ListShape { lines: 1, ..SHAPE });
    assert!(merged[0] == masked[0] && merged[1] > masked[1]);
}

/// The parts of any division of the records add up.
#[test]
fn parts_add_up() {
    let workload = frame(2);
    let records = workload.counters.points;
    for shape in shapes() {
        let lists = ListWrites::new(&workload, shape);
        for counts in [false, true] {
            let whole = lists.part(counts, 0, u64::MAX);
            for size in [1, 7, 32, 64, records.max(1)] {
                let mut sum = [0; 3];
                for first in (0..records).step_by(size as usize) {
                    let part = lists.part(counts, first, (first + size).min(records));
                    assert_eq!(part.first, sum[0]);
                    let own = [part.moves, part.read, part.write];
                    sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
                }
                assert_eq!(sum, [whole.moves, whole.read, whole.write], "{shape:?} {size}");
            }
        }
    }
}
