//! Measurements of a frame that do not depend on timing, taken once: the order of its lists, the
//! hits of the feature cache, and how much order the lists keep of the frame before.

use super::{CacheSummary, ListOrder, OrderSummary};
use crate::flow::tile_wise::{FrameContext, FrameReplay, replay_with};
use crate::kernel::timeline::Observer;
use crate::machine::Machine;
use crate::workload::FrameWorkload;
use crate::workload::cache::{CacheReplay, CacheShape, replay};
use crate::workload::order::{Sorter, check, tiles};
use crate::workload::reuse::{Reuse, SortedLists, update};
use powergs_frame::scene::Eye;

/// The measures of one frame for machines of one geometry, cache, key and tile order.
#[derive(Debug, Clone, Default)]
pub struct Measured {
    /// The order of the sorted lists, where it was checked.
    pub order: Option<OrderSummary>,
    /// The feature cache, where the machine has one.
    pub cache: Option<CacheReplay>,
    /// The order that lists keep, in a frame that updates the lists of the one before.
    pub reuse: Option<Reuse>,
}

impl Measured {
    /// The measurements that timing needs, without the order check.
    pub fn needed(workload: &FrameWorkload, machine: &Machine) -> Measured {
        let spec = &machine.tiles().cache;
        let shape = CacheShape::new(spec.capacity, machine.tiles().record.feature_pitch, spec.ways);
        let cache = (shape.ways > 0).then(|| {
            let order = tiles(workload.tiles_x, workload.tiles_y, machine.tiles().schedule.order);
            replay(workload, shape, spec.victims(), &order)
        });
        Measured { cache, ..Measured::default() }
    }

    /// Of the first frame of a list, or on a machine that keeps no order from frame to frame;
    /// `checks_order`: also how well its lists are sorted.
    pub(crate) fn first(
        workload: &FrameWorkload,
        machine: &Machine,
        checks_order: bool,
    ) -> Measured {
        let order = checks_order.then(|| order(workload, machine));
        Measured { order, ..Measured::needed(workload, machine) }
    }

    /// Of the next frame, for this eye where frames are halves of pairs. Frames must come in order:
    /// `lists` holds the order of the one before.
    pub fn of(
        workload: &FrameWorkload,
        eye: Option<Eye>,
        machine: &Machine,
        lists: &mut Lists,
        checks_order: bool,
    ) -> Measured {
        let mut measured = Measured::needed(workload, machine);
        measured.reuse = lists.next(workload, eye, machine);
        if measured.reuse.is_none() && checks_order {
            measured.order = Some(order(workload, machine));
        }
        measured
    }

    /// The frame context of the pipeline.
    pub(crate) fn context(&self) -> FrameContext<'_> {
        FrameContext {
            hits: self.cache.as_ref().map(|cache| cache.hits.as_slice()),
            reuse: self.reuse.as_ref().map(|reuse| reuse.lists.as_slice()),
            ..FrameContext::default()
        }
    }

    /// Hits and misses.
    pub(crate) fn cache_summary(&self) -> Option<CacheSummary> {
        let cache = self.cache.as_ref()?;
        Some(CacheSummary { hits: cache.hit_loads, misses: cache.loads - cache.hit_loads })
    }

    /// How well the lists are sorted, or how much order they took over from the previous frame.
    pub(crate) fn lists(&self) -> Option<ListOrder> {
        let reused = self.reuse.as_ref().map(|reuse| ListOrder::Reused(reuse.summary));
        reused.or_else(|| self.order.map(ListOrder::Sorted))
    }
}

/// Takes a frame through a machine and tells `observer` what every unit did when.
pub fn observed(
    workload: &FrameWorkload,
    measured: &Measured,
    machine: &Machine,
    observer: &mut impl Observer,
) -> FrameReplay {
    replay_with(workload, machine, measured.context(), observer)
}

/// Sorts the real keys of the frame as the machine does.
fn order(workload: &FrameWorkload, machine: &Machine) -> OrderSummary {
    let gsu = &machine.tiles().gsu;
    let found =
        check(workload, Sorter { key: gsu.depth, pivots: gsu.pivots, rule: gsu.pivot_rule });
    OrderSummary {
        neighbours: found.entries.saturating_sub(found.lists),
        out_of_order: found.adjacent_pairs,
        equal_keys: found.equal_key_pairs,
        inversions: found.inverted_pairs,
    }
}

/// The sorted lists of the frame before, for machines that update them: each eye of pairs has its
/// own, since the order of a view is kept best by the next one of the same eye.
#[derive(Debug, Default)]
pub struct Lists {
    before: [Option<SortedLists>; Eye::ALL.len()],
}

impl Lists {
    /// The order that the next frame takes over; `None` where its lists are sorted from scratch.
    fn next(
        &mut self,
        workload: &FrameWorkload,
        eye: Option<Eye>,
        machine: &Machine,
    ) -> Option<Reuse> {
        let period = machine.tiles().gsu.reuse_period;
        if period <= 1 {
            return None;
        }
        let lists = &mut self.before[eye.map_or(0, |eye| eye as usize)];
        let Some(before) = lists.take().filter(|order| order.age() + 1 < period) else {
            *lists = Some(SortedLists::exact(workload));
            return None;
        };
        let (reuse, after) = update(&before, workload);
        *lists = Some(after);
        Some(reuse)
    }
}
