//! What is measured of a frame once, whatever the time that anything takes: hits of the feature
//! cache, the order of the lists, and how much order they keep of the frame before.

use crate::flow::{CacheSummary, History, OrderSummary};
use crate::kernel::MemoKey;
use crate::machine::Machine;
use crate::workload::FrameWorkload;
use crate::workload::binning::{ListShape, ListWrites};
use crate::workload::cache::{CacheReplay, CacheShape, Victims, replay};
use crate::workload::order::{Sorter, TileOrder, check, tiles};
use crate::workload::reuse::{Reuse, SortedLists, update};
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
    type Value = OrderSummary;
    const MOST: usize = 64;
}

impl CacheSummary {
    pub(super) fn of(replay: &CacheReplay) -> CacheSummary {
        CacheSummary { hits: replay.hit_loads, misses: replay.loads - replay.hit_loads }
    }
}

/// The keys by which a machine sorts.
pub fn sorter(machine: &Machine) -> Sorter {
    let gsu = &machine.tiles().gsu;
    Sorter { key: gsu.depth, pivots: gsu.pivots, rule: gsu.pivot_rule }
}

/// Sorts the real keys of a frame.
pub fn order(workload: &FrameWorkload, sorter: Sorter) -> OrderSummary {
    let found = check(workload, sorter);
    OrderSummary {
        neighbours: found.entries.saturating_sub(found.lists),
        out_of_order: found.adjacent_pairs,
        equal_keys: found.equal_key_pairs,
        inversions: found.inverted_pairs,
    }
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
