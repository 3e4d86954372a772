//! Order reuse: how far the sorted lists of one frame serve the next one.
//!
//! Entries are the same if they are the same Gaussian of the scene. Lists are updated as in Neo:
//! entries that are gone are left out, new ones are sorted and merged in by depth, then every chunk
//! is sorted by itself, with chunk borders half a chunk further in every other frame, so that an
//! entry can go on moving (A75). Disorder that is left is carried into the next frame.

use rayon::prelude::*;

use super::{FrameWorkload, Geometry};
use powergs_frame::splat::{Cover, Splat, TileGrid};

/// The lists of a frame in the order that a sorter left them.
#[derive(Debug, Clone, PartialEq)]
pub struct SortedLists {
    geometry: Geometry,
    /// Lists per row and rows of lists.
    grid: (u32, u32),
    /// Scene indices, one list per tile or sort group.
    lists: Vec<Vec<u32>>,
    /// Frames since all lists were sorted from scratch.
    age: u32,
}

impl SortedLists {
    /// The exact order of `workload`, sorted from scratch.
    pub fn exact(workload: &FrameWorkload) -> SortedLists {
        let list = |group| {
            let ranks = workload.group_list(group).into_iter();
            ranks.map(|rank| workload.index[rank as usize]).collect()
        };
        SortedLists {
            geometry: workload.geometry,
            grid: grid(workload),
            lists: (0..groups(workload)).into_par_iter().map(list).collect(),
            age: 0,
        }
    }

    /// As [`exact`](SortedLists::exact), with the splats that would touch a tile if they were
    /// `margin` pixels or less elsewhere: for frames from near by. A list is of a tile.
    ///
    /// # Panics
    /// When the frame was not binned for [`FrameDetail::pixels`](super::FrameDetail).
    pub fn widened(workload: &FrameWorkload, margin: u32) -> SortedLists {
        let splats = &workload.pixels.as_ref().expect("binned for pixels").splats;
        let Geometry { tile, test, .. } = workload.geometry;
        let grid_of = TileGrid::new(workload.width, workload.height, tile);
        // Steps of less than a tile, so that none is passed over.
        let steps = i64::from(2 * margin.div_ceil(tile));
        let shift = |step: i64| margin as f32 * (2 * step - steps) as f32 / steps.max(1) as f32;
        let all_shifts: Vec<[f32; 2]> =
            (0..=steps).flat_map(|x| (0..=steps).map(move |y| [shift(x), shift(y)])).collect();
        let touched: Vec<Vec<u32>> = splats
            .par_iter()
            .map(|splat| {
                let mut tiles = Vec::new();
                for shift in &all_shifts {
                    let mean = [splat.mean[0] + shift[0], splat.mean[1] + shift[1]];
                    let cover = Cover::new(&Splat { mean, ..*splat }, grid_of, test);
                    tiles.extend(
                        cover
                            .rows()
                            .flat_map(|row| (row.x0..row.x1).map(move |x| row.y * grid_of.nx + x)),
                    );
                }
                tiles.sort_unstable();
                tiles.dedup();
                tiles
            })
            .collect();
        let mut lists = vec![Vec::new(); grid_of.len()];
        // Ranks are by depth.
        for (tiles, &index) in touched.iter().zip(&workload.index) {
            tiles.iter().for_each(|&tile| lists[tile as usize].push(index));
        }
        SortedLists { geometry: workload.geometry, grid: grid(workload), lists, age: 0 }
    }

    /// Depth ranks of the lists in a frame, without splats that are not visible in it.
    pub fn ranks(&self, workload: &FrameWorkload) -> Vec<Vec<u32>> {
        let rank_of = ranks_by_index(workload);
        let rank = |&index: &u32| rank_of.get(index as usize).copied().filter(|&rank| rank != GONE);
        self.lists.par_iter().map(|list| list.iter().filter_map(rank).collect()).collect()
    }

    /// The same, a frame later.
    pub fn older(self) -> SortedLists {
        SortedLists { age: self.age + 1, ..self }
    }

    /// Whether its lists are those of the tiles or groups of a frame.
    pub fn fits(&self, workload: &FrameWorkload) -> bool {
        (self.geometry, self.grid) == (workload.geometry, grid(workload))
    }

    /// Frames since all lists were sorted from scratch.
    pub fn age(&self) -> u32 {
        self.age
    }

    /// Scene indices of the list of a tile or sort group, nearest first.
    pub fn list(&self, group: u32) -> &[u32] {
        &self.lists[group as usize]
    }
}

fn grid(workload: &FrameWorkload) -> (u32, u32) {
    (workload.groups_x(), workload.groups_y())
}

fn groups(workload: &FrameWorkload) -> u32 {
    workload.groups_x() * workload.groups_y()
}

/// One list (of a tile, or of a sort group) against the frame before.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ListReuse {
    /// Entries that were in the list before.
    pub kept: u32,
    /// Entries that were not.
    pub new: u32,
    /// Entries of the list before that are not in it now.
    pub gone: u32,
    /// Neighbours out of order in the updated list.
    pub out_of_order: u32,
}

/// All lists of a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Reuse {
    /// Row-major: one per tile, or per sort group where there are any.
    pub lists: Vec<ListReuse>,
    /// Sums and shares.
    pub summary: ReuseSummary,
}

/// How much of the previous order a frame could reuse.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ReuseSummary {
    /// Lists that had entries in the frame before.
    pub old_lists: u64,
    /// Those of them that keep more than [`KEEP`] of these.
    pub keeping: u64,
    /// List entries that were in their list before.
    pub kept: u64,
    /// Entries that were not.
    pub new: u64,
    /// Entries of the frame before that are not in their list any more.
    pub gone: u64,
    /// The place of a kept entry among all kept ones of its list moves by at most this in 99 of 100
    /// cases, entries.
    pub rank_shift_p99: u32,
    /// Neighbours out of order because an old order was kept.
    pub out_of_order: u64,
    /// Of the new entries, those that no list has: their splats are not in the picture there.
    pub missing: u64,
}

/// A list that keeps more than this share of its entries counts as keeping (`neo`: more than 90 %
/// of tiles keep more than 78 %).
pub const KEEP: f64 = 0.78;

/// Updates `old` to the frame of `workload`; returns how much is reused, and the updated lists.
/// Where the lists of the two frames do not correspond (another geometry or image size), all is
/// new.
pub fn update(old: &SortedLists, workload: &FrameWorkload) -> (Reuse, SortedLists) {
    let same = old.fits(workload);
    let rank_of = ranks_by_index(workload);
    let parts = 4 * rayon::current_num_threads() as u32;
    let part = groups(workload).div_ceil(parts).max(1);
    let done: Vec<ReusePart> = (0..groups(workload).div_ceil(part))
        .into_par_iter()
        .map(|i| {
            let mut bench = ReuseBench::new(workload, &rank_of, old.age + 1);
            for group in i * part..((i + 1) * part).min(groups(workload)) {
                bench.update(if same { old.list(group) } else { &[] }, group);
            }
            bench.part
        })
        .collect();
    let mut all = ReusePart::default();
    for part in done {
        all.append(part);
    }
    let summary = summary(&all);
    let order = SortedLists {
        geometry: workload.geometry,
        grid: grid(workload),
        lists: all.orders,
        age: old.age + 1,
    };
    (Reuse { lists: all.lists, summary }, order)
}

/// Depth rank by scene index; [`GONE`] where the splat is not visible.
pub(crate) fn ranks_by_index(workload: &FrameWorkload) -> Vec<u32> {
    let most = workload.index.iter().max().map_or(0, |&index| index as usize + 1);
    let mut ranks = vec![GONE; most];
    for (rank, &index) in (0..).zip(&workload.index) {
        ranks[index as usize] = rank;
    }
    ranks
}

fn summary(part: &ReusePart) -> ReuseSummary {
    let mut s = ReuseSummary::default();
    for list in &part.lists {
        let before = list.kept + list.gone;
        s.old_lists += u64::from(before > 0);
        s.keeping += u64::from(f64::from(list.kept) > KEEP * f64::from(before));
        s.kept += u64::from(list.kept);
        s.new += u64::from(list.new);
        s.gone += u64::from(list.gone);
        s.out_of_order += u64::from(list.out_of_order);
    }

    let due = (s.kept * 99).div_ceil(100);
    let mut seen = 0;
    let p99 = part.shifts.iter().position(|n| {
        seen += n;
        seen >= due
    });
    s.rank_shift_p99 = p99.unwrap_or(0) as u32;
    s
}

/// Not visible, or not in the list.
pub(crate) const GONE: u32 = u32::MAX;

/// Some lists.
#[derive(Debug, Default)]
struct ReusePart {
    lists: Vec<ListReuse>,
    orders: Vec<Vec<u32>>,
    /// How many kept entries moved by how much.
    shifts: Vec<u64>,
}

impl ReusePart {
    fn append(&mut self, other: ReusePart) {
        self.lists.extend(other.lists);
        self.orders.extend(other.orders);
        let length = self.shifts.len().max(other.shifts.len());
        self.shifts.resize(length, 0);
        for (sum, n) in self.shifts.iter_mut().zip(other.shifts) {
            *sum += n;
        }
    }
}

/// One list after the other.
struct ReuseBench<'a> {
    workload: &'a FrameWorkload,
    rank_of: &'a [u32],
    /// Where the first chunk ends.
    first_border: usize,
    /// Position in the current list by rank, or [`GONE`].
    position: Vec<u32>,
    part: ReusePart,
}

impl<'a> ReuseBench<'a> {
    fn new(workload: &'a FrameWorkload, rank_of: &'a [u32], age: u32) -> ReuseBench<'a> {
        let chunk = workload.geometry.chunk as usize;
        let first_border = if age % 2 == 1 { chunk } else { chunk.div_ceil(2) };
        let position = vec![GONE; workload.index.len()];
        ReuseBench { workload, rank_of, first_border, position, part: ReusePart::default() }
    }

    fn update(&mut self, old: &[u32], group: u32) {
        let list = self.workload.group_list(group);
        for (i, &rank) in (0..).zip(&list) {
            self.position[rank as usize] = i;
        }
        // Positions in the exact list, in the old order.
        let position = |&index: &u32| {
            let rank = self.rank_of.get(index as usize).copied().filter(|&rank| rank != GONE)?;
            Some(self.position[rank as usize]).filter(|&position| position != GONE)
        };
        let kept: Vec<u32> = old.iter().filter_map(position).collect();
        for &rank in &list {
            self.position[rank as usize] = GONE;
        }
        let (new, places) = complement(&kept, list.len());
        self.count_shifts(&kept, &places);
        let mut updated = merge(&kept, &new);
        sort_chunks(&mut updated, self.first_border, self.workload.geometry.chunk as usize);
        let scene = |&at: &u32| self.workload.index[list[at as usize] as usize];
        self.part.orders.push(updated.iter().map(scene).collect());
        self.part.lists.push(ListReuse {
            kept: kept.len() as u32,
            new: new.len() as u32,
            gone: (old.len() - kept.len()) as u32,
            out_of_order: updated.windows(2).filter(|w| w[0] > w[1]).count() as u32,
        });
    }

    fn count_shifts(&mut self, kept: &[u32], places: &[u32]) {
        for (old, &at) in (0u32..).zip(kept) {
            let shift = old.abs_diff(places[at as usize]) as usize;
            if shift >= self.part.shifts.len() {
                self.part.shifts.resize(shift + 1, 0);
            }
            self.part.shifts[shift] += 1;
        }
    }
}

/// The positions `0..n` that are not in `kept`, ascending, and of each kept position its place
/// among all kept ones.
fn complement(kept: &[u32], n: usize) -> (Vec<u32>, Vec<u32>) {
    let mut places = vec![GONE; n];
    for &at in kept {
        places[at as usize] = 0;
    }
    let (mut new, mut next) = (Vec::with_capacity(n - kept.len()), 0);
    for (at, place) in (0..).zip(&mut places) {
        if *place == GONE {
            new.push(at);
        } else {
            *place = next;
            next += 1;
        }
    }
    (new, places)
}

/// Merges sorted `new` into `kept`, as a merger does that compares the two entries at the front.
fn merge(kept: &[u32], new: &[u32]) -> Vec<u32> {
    let mut merged = Vec::with_capacity(kept.len() + new.len());
    let mut next = new.iter().copied().peekable();
    for &old in kept {
        while let Some(at) = next.next_if(|&at| at < old) {
            merged.push(at);
        }
        merged.push(old);
    }
    merged.extend(next);
    merged
}

/// Sorts every chunk by itself.
fn sort_chunks(list: &mut [u32], first_border: usize, chunk: usize) {
    let (first, rest) = list.split_at_mut(first_border.min(list.len()));
    first.sort_unstable();
    rest.chunks_mut(chunk).for_each(<[u32]>::sort_unstable);
}
