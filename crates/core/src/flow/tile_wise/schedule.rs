//! Jobs: which tiles make one, and in which order the cores take them.
//!
//! A *job* is a tile, a sort group with all of its tiles, or neighbours in the order whose lists
//! together have at most `schedule.merge-below` entries. Jobs are dealt in the order
//! `schedule.order`; with `longest-first` the job with most keys comes first, ties in that order.

use std::ops::Range;

use crate::flow::tile_wise::FrameContext;
use crate::flow::tile_wise::bsu::Sort;
use crate::flow::tile_wise::qsu::Keys;
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::flow::tile_wise::{Assignment, DepthUpdate};
use crate::machine::Machine;
use crate::workload::order::tiles as tile_order;
use crate::workload::{FrameWorkload, TileWork};

/// A piece of work of a core.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Job {
    /// Its tiles: positions in [`Plan::tiles`].
    pub tiles: Range<u32>,
    /// Its sort group; `None` where tiles are sorted one by one.
    pub group: Option<u32>,
    /// The work of the QSUs.
    pub keys: Keys,
    /// Bytes of its list in DRAM.
    pub read: u64,
    /// Entries whose depths are read before they are sorted.
    pub depths: u64,
    /// Bytes of the updated list that is kept for the next frame.
    pub kept: u64,
    /// Where its list begins, in entries of the frame's lists.
    pub list_start: u32,
    /// Splats in storage order after which its list is complete.
    pub complete_after: u32,
}

impl Job {
    /// The sort of all chunks that comes before they are merged.
    pub fn chunks(&self) -> Sort {
        Sort { keys: self.keys.sorted, filtered: 0 }
    }
}

/// The jobs of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Plan {
    /// Indices of tiles, job by job.
    pub tiles: Vec<u32>,
    /// Jobs in the order in which they are dealt.
    pub jobs: Vec<Job>,
    /// Whether job n belongs to core n modulo the cores.
    pub is_static: bool,
}

impl Plan {
    /// The jobs of `workload` on `machine`, in the order of its schedule.
    pub fn new(
        workload: &FrameWorkload,
        machine: &Machine,
        units: &ResolvedUnits,
        context: &FrameContext,
    ) -> Plan {
        let order = machine.tiles().schedule.order;
        let grouped = !workload.groups.is_empty();
        let mut plan = Plan {
            tiles: Vec::with_capacity(workload.tiles.len()),
            jobs: Vec::new(),
            is_static: machine.tiles().schedule.assignment == Assignment::Static,
        };
        let planner = Planner { workload, units, context };
        if grouped {
            let side = workload.geometry.tiles_per_group_side();
            let (nx, ny) = (workload.groups_x(), workload.groups_y());
            for group in tile_order(nx, ny, order) {
                let first = plan.tiles.len() as u32;
                push_tiles_of_group(workload, side, (group % nx, group / nx), &mut plan.tiles);
                let tiles = first..plan.tiles.len() as u32;
                plan.jobs.push(planner.job(&plan.tiles, tiles, Some(group)));
            }
        } else {
            plan.tiles = tile_order(workload.tiles_x, workload.tiles_y, order);
            for tiles in merged(workload, &plan.tiles, machine.tiles().schedule.merge_below) {
                plan.jobs.push(planner.job(&plan.tiles, tiles, None));
            }
        }
        if machine.tiles().schedule.assignment == Assignment::LongestFirst {
            plan.jobs.sort_by_key(|job| std::cmp::Reverse(job.keys.held));
        }
        plan
    }

    /// Indices of the tiles of a job.
    pub fn tiles_of(&self, job: &Job) -> &[u32] {
        &self.tiles[job.tiles.start as usize..job.tiles.end as usize]
    }
}

/// Runs of tiles whose lists together have at most `most` entries; a tile with a longer list is a
/// run by itself.
fn merged(workload: &FrameWorkload, tiles: &[u32], most: u32) -> Vec<Range<u32>> {
    let mut runs: Vec<Range<u32>> = Vec::with_capacity(tiles.len());
    // Nothing can join a run that does not exist yet.
    let mut entries = u64::MAX;
    for (i, &tile) in tiles.iter().enumerate() {
        let own = u64::from(workload.tiles[tile as usize].entries);
        let together = entries.saturating_add(own);
        match runs.last_mut() {
            Some(run) if together <= u64::from(most) => {
                (run.end, entries) = (i as u32 + 1, together);
            }
            _ => {
                runs.push(i as u32..i as u32 + 1);
                entries = own;
            }
        }
    }
    runs
}

fn push_tiles_of_group(w: &FrameWorkload, side: u32, (gx, gy): (u32, u32), tiles: &mut Vec<u32>) {
    for y in gy * side..((gy + 1) * side).min(w.tiles_y) {
        for x in gx * side..((gx + 1) * side).min(w.tiles_x) {
            tiles.push(y * w.tiles_x + x);
        }
    }
}

/// Makes jobs.
struct Planner<'a> {
    workload: &'a FrameWorkload,
    units: &'a ResolvedUnits,
    context: &'a FrameContext<'a>,
}

impl Planner<'_> {
    fn job(&self, all: &[u32], tiles: Range<u32>, group: Option<u32>) -> Job {
        let qsu = &self.units.qsu;
        let mine = &all[tiles.start as usize..tiles.end as usize];
        let works = || mine.iter().map(|&t| &self.workload.tiles[t as usize]);
        let mut keys = Keys::default();
        let merged = qsu.spec.merges() || !qsu.spec.sorts();
        let (mut kept, mut depths) = (0, 0);
        let lists = group.as_ref().map_or(mine, std::slice::from_ref);
        if let Some(reuse) = self.context.reuse {
            for list in lists.iter().map(|&l| &reuse[l as usize]) {
                let new = u64::from(list.new);
                keys.held += u64::from(list.kept) + u64::from(list.gone) + new;
                keys.sorted += new;
                // Passes take all lists of a job together, until the longest of them is done.
                keys.passes = keys.passes.max(qsu.passes(new));
                kept += u64::from(list.kept) + new;
                depths += match qsu.spec.depth_update {
                    DepthUpdate::Deferred => 0,
                    DepthUpdate::Fetched => u64::from(list.kept),
                };
            }
        } else if let Some(table) = self.context.table {
            // A table is sorted whole, because frames that take it over sort no chunks (A134).
            keys.merged = true;
            for &tile in mine {
                let entries = u64::from(table.sorted[tile as usize]);
                keys.held += entries + u64::from(table.read[tile as usize]);
                keys.sorted += entries;
                keys.passes = keys.passes.max(qsu.passes(entries));
                kept += entries;
            }
        } else if let Some(group) = group {
            let entries = u64::from(self.workload.groups[group as usize].entries);
            keys = Keys {
                held: entries,
                sorted: entries,
                passes: qsu.passes(entries),
                merged,
                ..keys
            };
        } else {
            keys.merged = merged;
            for tile in works() {
                let entries = u64::from(tile.entries);
                keys.held += entries;
                keys.sorted += entries;
                keys.passes = keys.passes.max(qsu.passes(entries));
            }
        }
        if !qsu.spec.sorts() {
            (keys.sorted, keys.passes) = (0, 0);
        }
        // Lists that come on chip, in order.
        if self.context.derived {
            keys = Keys { merged: true, ..Keys::default() };
        }
        Job {
            tiles,
            group,
            depths,
            read: match self.context.lists {
                Some(made) => match group {
                    Some(_) => made.shape().list_bytes(keys.held),
                    None => works().map(|t| made.shape().list_bytes(u64::from(t.entries))).sum(),
                },
                None => keys.held * qsu.key,
            },
            kept: kept * qsu.key,
            list_start: works().next().map_or(0, |t| t.list_start),
            complete_after: works().map(|t| t.complete_after).max().unwrap_or(0),
            keys,
        }
    }
}

/// How far the list of a job has been sorted, and looked through.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SortProgress {
    sorted: u32,
    looked: u32,
}

impl SortProgress {
    /// The sort that must precede the rendering of chunk `index` of `tile`.
    pub fn next(
        &mut self,
        workload: &FrameWorkload,
        job: &Job,
        tile: &TileWork,
        index: u32,
    ) -> Sort {
        let chunk = &workload.chunks_of(tile)[index as usize];
        let Some(group) = job.group else {
            let keys = if job.keys.merged { 0 } else { u64::from(chunk.entries) };
            return Sort { keys, filtered: 0 };
        };
        // Each tile takes its own entries from the start of the sorted list of the group (A80).
        if index == 0 {
            self.looked = 0;
        }
        // The list of a group is sorted in whole chunks, whichever of its tiles asked first (A76).
        let whole = chunk.group_end.next_multiple_of(workload.geometry.chunk);
        let end = whole.min(workload.groups[group as usize].entries);
        let keys = if job.keys.merged { 0 } else { u64::from(end.saturating_sub(self.sorted)) };
        let filtered = u64::from(chunk.group_end.saturating_sub(self.looked));
        self.sorted = self.sorted.max(end);
        self.looked = chunk.group_end;
        Sort { keys, filtered }
    }
}
