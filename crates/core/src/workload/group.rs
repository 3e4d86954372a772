//! Sort groups: tiles whose lists are sorted together.
//!
//! The list of a group is the union of the lists of its tiles. It is sorted once, and every tile
//! takes its own entries from it, so a tile needs the list of its group as far as its last fetched
//! entry.

use rayon::prelude::*;

use super::fovea::TileFovea;
use super::tile::RowPart;
use super::{FrameWorkload, Geometry, GroupWork};
use powergs_frame::splat::runs::Runs;

/// Counts the groups of a frame, row-major, and sets the `group_end` of the chunks of `parts` (rows
/// of tiles). Without groups there is nothing to do.
pub(crate) fn count_groups(
    runs: &Runs,
    fovea: Option<&TileFovea<'_>>,
    geometry: Geometry,
    parts: &mut [RowPart],
) -> Vec<GroupWork> {
    let side = geometry.tiles_per_group_side();
    if side == 1 {
        return Vec::new();
    }
    let rows = parts.par_chunks_mut(side as usize).enumerate();
    let groups: Vec<Vec<GroupWork>> = rows
        .map(|(gy, parts)| {
            let first = gy as u32 * side;
            let lists = union_lists(runs, fovea, side, first..first + parts.len() as u32);
            count_row(geometry, &lists, parts)
        })
        .collect();
    groups.into_iter().flatten().collect()
}

/// The lists of a row of groups: ranks, ascending.
fn union_lists(
    runs: &Runs,
    fovea: Option<&TileFovea<'_>>,
    side: u32,
    rows: std::ops::Range<u32>,
) -> Vec<Vec<u32>> {
    let mut lists = vec![Vec::new(); runs.grid.nx.div_ceil(side) as usize];
    for (ty, run) in rows.flat_map(|ty| runs.row(ty).map(move |run| (ty, run))) {
        if let Some(fovea) = fovea {
            let kept = |x: &u32| fovea.keeps(runs.grid.index(*x, ty), run.rank);
            for x in (u32::from(run.x0)..u32::from(run.x1)).filter(kept) {
                lists[(x / side) as usize].push(run.rank);
            }
            continue;
        }
        let (first, last) = (u32::from(run.x0) / side, u32::from(run.x1 - 1) / side);
        for list in &mut lists[first as usize..=last as usize] {
            list.push(run.rank);
        }
    }
    for list in &mut lists {
        list.sort_unstable();
        list.dedup();
    }
    lists
}

fn count_row(geometry: Geometry, lists: &[Vec<u32>], parts: &mut [RowPart]) -> Vec<GroupWork> {
    let side = geometry.tiles_per_group_side() as usize;
    let mut deepest = vec![0u32; lists.len()];
    for part in parts {
        for (tx, tile) in part.tiles.iter().enumerate() {
            let list = &lists[tx / side];
            let chunks = &mut part.chunks[tile.chunk_start as usize..][..tile.chunks as usize];
            let mut end = tile.list_start;
            for chunk in chunks {
                end += chunk.entries;
                let last = part.list[end as usize - 1];
                chunk.group_end = list.partition_point(|&rank| rank <= last) as u32;
                deepest[tx / side] = deepest[tx / side].max(chunk.group_end);
            }
        }
    }
    let group = |(list, deepest): (&Vec<u32>, u32)| {
        let entries = list.len() as u32;
        let whole = u64::from(deepest).next_multiple_of(u64::from(geometry.chunk));
        GroupWork { entries, sorted: whole.min(u64::from(entries)) as u32 }
    };
    lists.iter().zip(deepest).map(group).collect()
}

impl FrameWorkload {
    /// Depth ranks of the common list of sort group `group`, ascending: the list of the tile where
    /// a group is a tile.
    pub fn group_list(&self, group: u32) -> Vec<u32> {
        let side = self.geometry.tiles_per_group_side();
        let (x0, y0) = (group % self.groups_x() * side, group / self.groups_x() * side);
        let mut list = Vec::new();
        for y in y0..(y0 + side).min(self.tiles_y) {
            for x in x0..(x0 + side).min(self.tiles_x) {
                list.extend(self.list_of(&self.tiles[(y * self.tiles_x + x) as usize]));
            }
        }
        if side > 1 {
            list.sort_unstable();
            list.dedup();
        }
        list
    }
}
