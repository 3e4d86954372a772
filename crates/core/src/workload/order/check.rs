//! The order check: sorts the real keys of every list the way the hardware does, and counts what
//! comes out of order.
//!
//! Entries arrive in storage order. A pass splits every part that is longer than a chunk at pivots;
//! there are as many passes as would do if pivots split evenly. The parts then leave in order, in
//! chunks: each chunk is sorted by key, entries with equal keys as they arrived. A part that is
//! still longer than a chunk leaves in several chunks, each sorted by itself: that is where uneven
//! pivots cost order. Keys of few bits cost order where they are equal.
//!
//! Keys rise with the exact order, so a part is a stretch of it, and only oversized parts and
//! stretches of equal keys need sorting here. It is made once per geometry and sorter.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DepthKey, inversions};
use crate::workload::FrameWorkload;

/// How a sorter chooses the pivots of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PivotRule {
    /// At equal distances between the smallest and the largest key of the part, as whole numbers.
    /// Both are known when the part has been written; bits of floats are nearly logarithms.
    Range,
    /// Quantiles of a sample: every n-th key that arrived, eight for each part that is made.
    Quantile,
}

/// The sorter of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Sorter {
    /// Precision of the keys.
    pub key: DepthKey,
    /// Pivots of a pass (at least 1).
    pub pivots: u32,
    /// How they are chosen.
    pub rule: PivotRule,
}

/// The order of all lists of a frame, as far as it is rendered: of each list the entries that leave
/// the sorter first, as many as are fetched. Depths that are equal are never out of order.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SortCheck {
    /// Lists that are not empty.
    pub lists: u64,
    /// Lists with at least one pair out of order.
    pub disordered_lists: u64,
    /// Entries that leave the sorter.
    pub entries: u64,
    /// Neighbours of which the first is farther.
    pub adjacent_pairs: u64,
    /// Pairs of which the first is farther, near or far from each other.
    pub inverted_pairs: u64,
    /// Of these, pairs whose keys are equal: the price of the precision. The others are the price
    /// of uneven pivots.
    pub inverted_by_precision: u64,
    /// Pairs of the entries that should leave whose keys are equal and whose depths are not.
    pub equal_key_pairs: u64,
    /// The farthest that an entry leaves from its exact place, entries.
    pub displacement: u32,
    /// Entries in parts that are longer than a chunk after the last pass, in whole lists.
    pub oversized_entries: u64,
    /// The longest part after the last pass, entries.
    pub longest_part: u32,
}

impl SortCheck {
    fn join(self, other: SortCheck) -> SortCheck {
        SortCheck {
            lists: self.lists + other.lists,
            disordered_lists: self.disordered_lists + other.disordered_lists,
            entries: self.entries + other.entries,
            adjacent_pairs: self.adjacent_pairs + other.adjacent_pairs,
            inverted_pairs: self.inverted_pairs + other.inverted_pairs,
            inverted_by_precision: self.inverted_by_precision + other.inverted_by_precision,
            equal_key_pairs: self.equal_key_pairs + other.equal_key_pairs,
            displacement: self.displacement.max(other.displacement),
            oversized_entries: self.oversized_entries + other.oversized_entries,
            longest_part: self.longest_part.max(other.longest_part),
        }
    }
}

/// Sorts the lists of `workload` (of its sort groups where it has any) with `sorter`.
pub fn check(workload: &FrameWorkload, sorter: Sorter) -> SortCheck {
    let keys = keys(workload, sorter);
    let new = || OrderBench::new(workload, sorter, &keys);
    if workload.groups.is_empty() {
        let lists = workload.tiles.par_iter();
        let each = |bench: &mut OrderBench, tile| {
            let tile: &crate::workload::TileWork = tile;
            bench.check(workload.list_of(tile), tile.loaded as usize)
        };
        lists.map_init(new, each).reduce(SortCheck::default, SortCheck::join)
    } else {
        let groups = workload.groups.par_iter().enumerate();
        let each = |bench: &mut OrderBench, (i, group): (usize, &crate::workload::GroupWork)| {
            bench.check(&workload.group_list(i as u32), group.sorted as usize)
        };
        groups.map_init(new, each).reduce(SortCheck::default, SortCheck::join)
    }
}

/// Depth ranks of every list in the order in which they leave `sorter`: one after the other where
/// `merged`, in place of parts that pivots make. One list per tile, or per sort group where there
/// are any.
pub fn sorted_lists(workload: &FrameWorkload, sorter: Sorter, merged: bool) -> Vec<Vec<u32>> {
    let keys = keys(workload, sorter);
    let new = || OrderBench::new(workload, sorter, &keys);
    let chunk = if merged { usize::MAX } else { workload.geometry.chunk as usize };
    let groups = (0..workload.groups_x() * workload.groups_y()).into_par_iter();
    let sort = |bench: &mut OrderBench, group| {
        let ranks = workload.group_list(group);
        bench.leave(&ranks, chunk, ranks.len());
        bench.list.output.iter().map(|&at| ranks[at as usize]).collect()
    };
    groups.map_init(new, sort).collect()
}

/// Sample of the [`PivotRule::Quantile`], entries per part.
const SAMPLE: usize = 8;

/// One list after the other.
struct OrderBench<'a> {
    workload: &'a FrameWorkload,
    sorter: Sorter,
    /// By rank.
    keys: &'a [u32],
    list: OrderList,
    spare: Vec<u32>,
}

/// A list in exact order; what leaves the sorter are positions in it.
#[derive(Default)]
struct OrderList {
    keys: Vec<u32>,
    /// Scene index: when the entry arrived.
    arrival: Vec<u32>,
    /// Parts end here.
    ends: Vec<usize>,
    output: Vec<u32>,
    /// (arrival, position) of one part.
    arrived: Vec<(u32, u32)>,
}

/// The key of every splat, by rank.
fn keys(workload: &FrameWorkload, sorter: Sorter) -> Vec<u32> {
    workload.depth.par_iter().map(|&depth| sorter.key.of(depth)).collect()
}

impl<'a> OrderBench<'a> {
    fn new(workload: &'a FrameWorkload, sorter: Sorter, keys: &'a [u32]) -> OrderBench<'a> {
        OrderBench { workload, sorter, keys, list: OrderList::default(), spare: Vec::new() }
    }

    /// Sorts a list: the first `needed` positions that leave the sorter.
    fn leave(&mut self, ranks: &[u32], chunk: usize, needed: usize) {
        let list = &mut self.list;
        list.keys.clear();
        list.keys.extend(ranks.iter().map(|&rank| self.keys[rank as usize]));
        list.arrival.clear();
        list.arrival.extend(ranks.iter().map(|&rank| self.workload.index[rank as usize]));
        list.split(chunk, self.sorter);
        list.sort(chunk, needed);
    }

    fn check(&mut self, ranks: &[u32], needed: usize) -> SortCheck {
        if ranks.is_empty() {
            return SortCheck::default();
        }
        let chunk = self.workload.geometry.chunk as usize;
        self.leave(ranks, chunk, needed);
        let list = &mut self.list;
        let part = |(i, &end): (usize, &usize)| end - if i == 0 { 0 } else { list.ends[i - 1] };
        let parts = list.ends.iter().enumerate().map(part);
        let longest = parts.clone().max().unwrap_or(0);
        let oversized: usize = parts.filter(|&n| n > chunk).sum();
        let depth = |position: usize| self.workload.depth[ranks[position] as usize];
        let equal_key_pairs = runs(needed, |i| list.keys[i]) - runs(needed, |i| depth(i).to_bits());
        let mut found = SortCheck {
            lists: 1,
            entries: list.output.len() as u64,
            equal_key_pairs,
            oversized_entries: oversized as u64,
            longest_part: longest as u32,
            ..SortCheck::default()
        };
        if list.output.is_sorted() {
            return found;
        }
        let places = (0u32..).zip(&list.output);
        found.displacement = places.map(|(i, &at)| i.abs_diff(at)).max().unwrap_or(0);
        found.disordered_lists = 1;
        found.adjacent_pairs = list.output.windows(2).filter(|w| w[0] > w[1]).count() as u64;
        let mut left: Vec<u32> = list.output.iter().map(|&at| list.keys[at as usize]).collect();
        let by_pivots = inversions(&mut left, &mut self.spare);
        found.inverted_pairs = inversions(&mut list.output, &mut self.spare);
        found.inverted_by_precision = found.inverted_pairs - by_pivots;
        found
    }
}

/// Pairs of the first `n` that are equal, where equal values are neighbours.
fn runs(n: usize, value: impl Fn(usize) -> u32) -> u64 {
    let (mut pairs, mut run) = (0, 0);
    for i in 1..n {
        run = if value(i) == value(i - 1) { run + 1 } else { 0 };
        pairs += run;
    }
    pairs
}

impl OrderList {
    /// Sets `ends`: where the parts end after as many passes as even pivots would need.
    fn split(&mut self, chunk: usize, sorter: Sorter) {
        let n = self.keys.len();
        let fan = u128::from(sorter.pivots) + 1;
        let (mut ends, mut next) = (vec![n], Vec::new());
        let mut reach = chunk as u128;
        while reach < n as u128 {
            let mut start = 0;
            for end in ends.drain(..) {
                if end - start > chunk {
                    self.split_part(start, end, sorter, &mut next);
                }
                next.push(end);
                start = end;
            }
            std::mem::swap(&mut ends, &mut next);
            reach *= fan;
        }
        self.ends = ends;
    }

    /// Appends where the new parts of a part end, without its own end.
    fn split_part(&mut self, start: usize, end: usize, sorter: Sorter, ends: &mut Vec<usize>) {
        let parts = sorter.pivots as usize + 1;
        let pivots: Vec<u32> = match sorter.rule {
            PivotRule::Range => {
                let (low, high) = (u64::from(self.keys[start]), u64::from(self.keys[end - 1]));
                let pivot = |j: u64| (low + (high - low) * j / parts as u64) as u32;
                (1..parts as u64).map(pivot).collect()
            }
            PivotRule::Quantile => {
                self.arrive(start, end);
                let (n, wanted) = (end - start, SAMPLE * parts);
                let key = |k: usize| self.keys[self.arrived[k * n / wanted].1 as usize];
                let mut sample: Vec<u32> = (0..wanted).map(key).collect();
                sample.sort_unstable();
                (1..parts).map(|j| sample[SAMPLE * j]).collect()
            }
        };
        let mut from = start;
        for pivot in pivots {
            let own = from + self.keys[from..end].partition_point(|&key| key < pivot);
            if own > from && own < end {
                ends.push(own);
                from = own;
            }
        }
    }

    /// Sets `arrived` to a stretch of the list in the order of arrival.
    fn arrive(&mut self, start: usize, end: usize) {
        self.arrived.clear();
        self.arrived.extend((start..end).map(|i| (self.arrival[i], i as u32)));
        self.arrived.sort_unstable();
    }

    /// Sets `output` to the first `needed` positions that leave the sorter.
    fn sort(&mut self, chunk: usize, needed: usize) {
        self.output.clear();
        let mut start = 0;
        for part in 0..self.ends.len() {
            let end = self.ends[part];
            if self.output.len() >= needed {
                break;
            }
            if end - start <= chunk {
                self.output.extend(start as u32..end as u32);
                self.sort_equal_keys(start);
            } else {
                self.arrive(start, end);
                for piece in self.arrived.chunks_mut(chunk) {
                    piece.sort_unstable_by_key(|&(arrival, at)| (self.keys[at as usize], arrival));
                    self.output.extend(piece.iter().map(|p| p.1));
                }
            }
            start = end;
        }
        self.output.truncate(needed);
    }

    /// Of the output from `start` on, which is in exact order: puts entries with equal keys into
    /// the order of arrival.
    fn sort_equal_keys(&mut self, start: usize) {
        let same = |a: &u32, b: &u32| self.keys[*a as usize] == self.keys[*b as usize];
        for run in self.output[start..].chunk_by_mut(same).filter(|run| run.len() > 1) {
            run.sort_unstable_by_key(|&at| self.arrival[at as usize]);
        }
    }
}
