//! What is measured of a frame once, whatever the time that anything takes: hits of the feature
//! cache, the order of the lists, and how much order they keep of the frame before.

use crate::flow::History;
use crate::kernel::MemoKey;
use crate::machine::Machine;
use crate::stage::{Measured, Merge, StatDecl, counted, share};
use crate::workload::FrameWorkload;
use crate::workload::binning::{ListShape, ListWrites};
use crate::workload::cache::{CacheReplay, CacheShape, Victims, replay};
use crate::workload::order::{Sorter, TileOrder, check, tiles};
use crate::workload::reuse::{Reuse, ReuseSummary, SortedLists, update};
use powergs_frame::scene::Eye;

/// What the hits of a feature cache depend on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CacheKey {
    shape: CacheShape,
    victims: Victims,
    order: TileOrder,
}

impl CacheKey {
    /// Of a machine; `None` without a cache.
    pub fn of(machine: &Machine) -> Option<CacheKey> {
        let tiles = machine.tiles();
        let (spec, pitch) = (&tiles.cache, tiles.record.feature_pitch);
        let shape = CacheShape::new(spec.capacity, pitch, spec.ways);
        let (victims, order) = (spec.victims(), tiles.schedule.order);
        (shape.ways > 0).then_some(CacheKey { shape, victims, order })
    }

    /// The hits in a frame.
    pub fn replay(&self, workload: &FrameWorkload) -> CacheReplay {
        let order = tiles(workload.tiles_x, workload.tiles_y, self.order);
        replay(workload, self.shape, self.victims, &order)
    }
}

impl MemoKey for CacheKey {
    type Value = CacheReplay;
    const MOST: usize = 64;
}

/// Lists take 16 bytes and more a pair each.
impl MemoKey for ListShape {
    type Value = ListWrites;
    const MOST: usize = 4;
}

impl MemoKey for Sorter {
    type Value = Measured;
    const MOST: usize = 64;
}

/// Neighbours of sorted lists.
pub const NEIGHBOURS: StatDecl = counted(
    "order.neighbours",
    "Neighbours in the lists that were sorted with the machine's keys.",
);
/// Those in the wrong order.
pub const DISORDERED: StatDecl =
    counted("order.out_of_order", "Neighbours that came out in the wrong order of depth.");
/// Those with equal keys and different depths.
pub const EQUAL_KEYS: StatDecl =
    counted("order.equal_keys", "Neighbours whose keys are equal although their depths are not.");
/// Pairs of a list in the wrong order.
pub const INVERSIONS: StatDecl = counted(
    "order.inversions",
    "Pairs of the same list, neighbours or not, that came out in the wrong order.",
);
const DISORDERED_SHARE: StatDecl = share(
    "order.out_of_order_frac",
    &DISORDERED,
    &[&NEIGHBOURS],
    "Share of the neighbours that came out in the wrong order, 0 to 1.",
);
/// List entries whose place was taken over.
pub const KEPT: StatDecl =
    counted("reuse.kept", "List entries whose place was taken over from the frame before.");
/// List entries that are new.
pub const ADDED: StatDecl =
    counted("reuse.added", "List entries that the frame before did not have.");
const GONE: StatDecl = counted("reuse.gone", "Entries of the frame before that are gone.");
const STALE: StatDecl =
    counted("reuse.out_of_order", "Neighbours out of order because an old order was kept.");
/// List entries that are not in the picture.
pub const MISSING: StatDecl = counted(
    "reuse.missing",
    "List entries of the frame that the lists of before, taken as they are, do not have.",
);
const KEPT_SHARE: StatDecl = share(
    "reuse.kept_frac",
    &KEPT,
    &[&KEPT, &ADDED],
    "Share of the list entries whose place was taken over, 0 to 1.",
);
const OLD_LISTS: StatDecl = counted("reuse.lists", "Lists that had entries in the frame before.");
const KEEPING: StatDecl =
    counted("reuse.keeping_lists", "Those of them that keep more than 78 % of their entries.");
/// Share of the lists that keep most of their entries.
pub const KEEPING_SHARE: StatDecl = share(
    "reuse.keeping_lists_frac",
    &KEEPING,
    &[&OLD_LISTS],
    "Share of the lists with entries in the frame before that keep more than 78 % of them, 0 to 1.",
);
/// How far kept entries move.
pub const RANK_SHIFT: StatDecl = counted(
    "reuse.rank_shift_p99",
    "How many places a kept entry moves among the kept ones of its list, at most, in 99 of 100 \
     cases.",
)
.merged(Merge::Most);

/// What is measured of the order of lists.
pub const STATS: &[&StatDecl] = &[
    &NEIGHBOURS,
    &DISORDERED,
    &EQUAL_KEYS,
    &INVERSIONS,
    &DISORDERED_SHARE,
    &KEPT,
    &ADDED,
    &GONE,
    &STALE,
    &MISSING,
    &KEPT_SHARE,
    &OLD_LISTS,
    &KEEPING,
    &KEEPING_SHARE,
    &RANK_SHIFT,
];

/// What is reported of an order that was taken over.
pub fn measured(reuse: &ReuseSummary) -> Measured {
    Measured::of(&[
        (&KEPT, reuse.kept),
        (&ADDED, reuse.new),
        (&GONE, reuse.gone),
        (&STALE, reuse.out_of_order),
        (&MISSING, reuse.missing),
        (&OLD_LISTS, reuse.old_lists),
        (&KEEPING, reuse.keeping),
        (&RANK_SHIFT, reuse.rank_shift_p99.into()),
    ])
}

/// The keys by which a machine sorts.
pub fn sorter(machine: &Machine) -> Sorter {
    let gsu = &machine.tiles().gsu;
    Sorter { key: gsu.depth, pivots: gsu.pivots, rule: gsu.pivot_rule }
}

/// Sorts the real keys of a frame.
pub fn order(workload: &FrameWorkload, sorter: Sorter) -> Measured {
    let found = check(workload, sorter);
    Measured::of(&[
        (&NEIGHBOURS, found.entries.saturating_sub(found.lists)),
        (&DISORDERED, found.adjacent_pairs),
        (&EQUAL_KEYS, found.equal_key_pairs),
        (&INVERSIONS, found.inverted_pairs),
    ])
}

/// The order that a frame takes over from the one before, on machines that sort everything from
/// nothing only every `period` frames; `None` where its lists are.
pub fn reuse(
    workload: &FrameWorkload,
    eye: Option<Eye>,
    period: u32,
    history: &mut History,
) -> Option<Reuse> {
    let before: Option<SortedLists> = history.take(eye);
    let Some(before) = before.filter(|order| order.age() + 1 < period) else {
        history.keep(eye, SortedLists::exact(workload));
        return None;
    };
    let (reuse, after) = update(&before, workload);
    history.keep(eye, after);
    Some(reuse)
}
