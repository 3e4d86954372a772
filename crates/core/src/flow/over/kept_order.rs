//! Lists that frames take over as they are (`gsu.impl = "last"` and `"shared"`; A134).
//!
//! With `last` a frame goes through the lists of the frame before, while its own are sorted for the
//! next one: splats that have come to a tile since are missing. With `shared` every n-th frame
//! (`reuse-period`) makes lists of all splats that touch a tile, or would if they were `gsu.margin`
//! pixels elsewhere, and the frames in between go through them and make none. Which pixels see
//! what, and where they stop, is found by blending in that order.

use rayon::prelude::*;

use crate::flow::History;
use crate::workload::blend::TileBlend;
use crate::workload::reuse::{GONE, ReuseSummary, SortedLists, ranks_by_index, update};
use crate::workload::{FrameWorkload, TileList};
use powergs_frame::scene::Eye;
use powergs_frame::splat::Counters;

/// How a machine keeps lists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ListKeeping {
    /// A frame goes through the lists of the one before.
    Last,
    /// One frame in `period` makes lists for all of them.
    Shared {
        /// Frames from one that makes lists to the next.
        period: u32,
        /// How far a splat may be from a tile to be in its list, pixels.
        margin: u32,
    },
}

/// What a frame does with lists of before.
#[derive(Debug)]
pub struct KeptOrder {
    /// The frame with the lists that it goes through; `None` where these are its own.
    pub made: Option<Box<FrameWorkload>>,
    /// The bytes and the work that come with it.
    pub lists: TableUse,
    /// How the lists that it goes through compare with its own; `None` where they are sorted for
    /// it.
    pub summary: Option<ReuseSummary>,
}

/// What is read and sorted in a frame that goes through lists of before, by tile.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TableUse {
    /// Entries that are read in the order of before, whether their splats are there or not.
    pub read: Vec<u32>,
    /// Entries that are written by CCUs and sorted, for this frame or for later ones.
    pub sorted: Vec<u32>,
}

impl KeptOrder {
    /// What a frame does.
    pub fn of(
        keeping: ListKeeping,
        workload: &FrameWorkload,
        eye: Option<Eye>,
        history: &mut History,
    ) -> KeptOrder {
        let before: Option<SortedLists> = history.take(eye);
        let before = before.filter(|table| table.fits(workload));
        match keeping {
            ListKeeping::Last => {
                history.keep(eye, SortedLists::exact(workload));
                let sorted = workload.tiles.iter().map(|tile| tile.entries).collect();
                match before {
                    None => KeptOrder::own(sorted),
                    Some(table) => KeptOrder::through(&table, workload, Some(sorted)),
                }
            }
            ListKeeping::Shared { period, margin } => {
                let before = before.filter(|table| table.age() + 1 < period);
                let (mut kept, table) = match before {
                    Some(table) => {
                        let none = vec![0; workload.tiles.len()];
                        (KeptOrder::through(&table, workload, Some(none)), table.older())
                    }
                    None => {
                        let table = SortedLists::widened(workload, margin);
                        (KeptOrder::through(&table, workload, None), table)
                    }
                };
                if let Some(made) = &mut kept.made {
                    scale_tests(made, kept.lists.written());
                }
                history.keep(eye, table);
                kept
            }
        }
    }

    /// A frame that goes through its own lists, and leaves them.
    fn own(sorted: Vec<u32>) -> KeptOrder {
        let read = vec![0; sorted.len()];
        KeptOrder { made: None, lists: TableUse { read, sorted }, summary: None }
    }

    /// A frame that goes through a table: one of before, beside which so much is sorted in each
    /// tile, or with `None` one that it makes itself.
    fn through(
        table: &SortedLists,
        workload: &FrameWorkload,
        sorted: Option<Vec<u32>>,
    ) -> KeptOrder {
        let (lists, out_of_order) = tile_lists(table, workload);
        let mut made = workload.with_lists(lists);
        let fetched_points = made.counters.fetched_points;
        made.counters = Counters { fetched_points, ..workload.counters };
        // Gaussians are converted as in any frame: only the lists are those of before.
        made.storage.clone_from(&workload.storage);
        let made = Some(Box::new(made));
        let tiles = 0..workload.tiles.len() as u32;
        let all: Vec<u32> = tiles.map(|tile| table.list(tile).len() as u32).collect();
        match sorted {
            None => KeptOrder { made, ..KeptOrder::own(all) },
            Some(sorted) => {
                let own = update(table, workload).0.summary;
                let summary = Some(ReuseSummary { out_of_order, missing: own.new, ..own });
                KeptOrder { made, lists: TableUse { read: all, sorted }, summary }
            }
        }
    }
}

impl TableUse {
    /// Entries that the CCUs write.
    pub fn written(&self) -> u64 {
        self.sorted.iter().map(|&n| u64::from(n)).sum()
    }
}

/// Box tests go with the pairs that are written: more for a margin, none where no list is made.
fn scale_tests(made: &mut FrameWorkload, written: u64) {
    let pairs = u128::from(made.counters.tile_pairs.max(1));
    let scaled = |tests: u64| (u128::from(tests) * u128::from(written) / pairs) as u64;
    let part = |tests: u32| u32::try_from(scaled(tests.into())).unwrap_or(u32::MAX);
    made.counters.obb_tests = scaled(made.counters.obb_tests);
    made.storage.iter_mut().for_each(|prefix| prefix.tests = part(prefix.tests));
    if written == 0 {
        made.counters.obb_prepared = 0;
        made.storage.iter_mut().for_each(|prefix| prefix.prepared = 0);
    }
}

/// The lists of a table as the frame goes through them, and how many neighbours are out of order.
fn tile_lists(table: &SortedLists, workload: &FrameWorkload) -> (Vec<TileList>, u64) {
    let rank_of = ranks_by_index(workload);
    let (lists, out_of_order): (Vec<TileList>, Vec<u64>) = (0..workload.tiles.len())
        .into_par_iter()
        .map_init(
            || vec![GONE; workload.index.len()],
            |position, tile| {
                let there = |&index: &u32| {
                    let rank = rank_of.get(index as usize).copied().unwrap_or(GONE);
                    (rank != GONE && workload.slot[rank as usize] != u32::MAX).then_some(rank)
                };
                let ranks = table.list(tile as u32).iter().filter_map(there).collect();
                tile_list(workload, tile, ranks, position)
            },
        )
        .unzip();
    (lists, out_of_order.into_iter().sum())
}

/// A tile that goes through `ranks`. `position` is [`GONE`] for every rank, before and after.
fn tile_list(
    workload: &FrameWorkload,
    tile: usize,
    ranks: Vec<u32>,
    position: &mut [u32],
) -> (TileList, u64) {
    let (work, bytes) = (&workload.tiles[tile], workload.geometry.bitmap_bytes());
    let own = workload.list_of(work);
    (0..).zip(own).for_each(|(at, &rank)| position[rank as usize] = at);
    let mut list = TileList { bitmaps: vec![0; ranks.len() * bytes], ..TileList::default() };
    let mut pixels = TileBlend::new(workload, tile, ranks.len() as u32);
    for ((at, &rank), bits) in (0u32..).zip(&ranks).zip(list.bitmaps.chunks_exact_mut(bytes)) {
        // What is not in its own list reaches no pixel of the tile.
        let Some(place) = Some(position[rank as usize]).filter(|&place| place != GONE) else {
            continue;
        };
        let first = (work.list_start + place) as usize * bytes;
        bits.copy_from_slice(&workload.bitmaps[first..first + bytes]);
        pixels.blend(at, rank);
    }
    // Left as it was found: a thread's next tile then has to clear nothing but its own list.
    own.iter().for_each(|&rank| position[rank as usize] = GONE);
    let out_of_order = ranks.windows(2).filter(|pair| pair[0] > pair[1]).count() as u64;
    list.stopped = pixels.stopped();
    (list.iterated, list.blends, list.ranks) = (pixels.iterated, pixels.blends, ranks);
    (list, out_of_order)
}
