//! The lists of a frame in the order in which a machine blends them, and where its pixels come
//! from: for pictures of it.

use rayon::prelude::*;

use super::measures::{reuse, sorter};
use super::{GsuImpl, TileWise};
use crate::flow::History;
use crate::flow::over::kept_order::KeptOrder;
use crate::flow::over::pixels::{PixelOrigin, SomePixels};
use crate::machine::Machine;
use crate::workload::FrameWorkload;
use crate::workload::order::sorted_lists;
use crate::workload::reuse::{ReuseSummary, SortedLists};
use powergs_frame::scene::Eye;

/// Lists as they are blended.
#[derive(Debug)]
pub struct BlendedLists {
    /// Depth ranks, a list per tile, row-major.
    pub tiles: Vec<Vec<u32>>,
    /// How they compare with the frame's own, where they come from a frame before.
    pub taken: Option<ReuseSummary>,
    /// Neighbours of which the first is farther.
    pub out_of_order: u64,
}

/// The lists of a frame of a machine that has seen those in `history`. Sort keys of lists that are
/// kept from frame to frame are exact here.
///
/// # Panics
/// When the machine is of another dataflow, or the frame was binned for another one.
pub fn blended_lists(
    machine: &Machine,
    workload: &FrameWorkload,
    eye: Option<Eye>,
    history: &mut History,
) -> BlendedLists {
    let gsu = &machine.tiles().gsu;
    let own = || workload.tiles.iter().map(|tile| workload.list_of(tile).to_vec()).collect();
    let (tiles, taken): (Vec<Vec<u32>>, _) = match gsu.implementation {
        GsuImpl::Split | GsuImpl::Merge => {
            let lists = sorted_lists(workload, sorter(machine), gsu.merges());
            (of_tiles(machine.tiles(), workload, &lists), None)
        }
        GsuImpl::Update => match reuse(workload, eye, gsu.period(), history) {
            None => (own(), None),
            Some(found) => {
                let lists: SortedLists = history.take(eye).expect("just kept");
                let ranks = lists.ranks(workload);
                history.keep(eye, lists);
                (of_tiles(machine.tiles(), workload, &ranks), Some(found.summary))
            }
        },
        GsuImpl::Last | GsuImpl::Shared => {
            let keeping = gsu.keeping().expect("it keeps lists");
            let kept = KeptOrder::of(keeping, workload, eye, history);
            let of_made = |made: Box<FrameWorkload>| {
                made.tiles.iter().map(|tile| made.list_of(tile).to_vec()).collect()
            };
            (kept.made.map_or_else(own, of_made), kept.summary)
        }
        GsuImpl::None => (own(), None),
    };
    let out_of_order = |list: &Vec<u32>| list.windows(2).filter(|w| w[0] > w[1]).count() as u64;
    let out_of_order = tiles.par_iter().map(out_of_order).sum();
    BlendedLists { tiles, taken, out_of_order }
}

/// Where the pixels of a frame come from on a machine that has shown those in `history`; `None`
/// where all are rendered.
///
/// # Panics
/// As [`blended_lists`].
pub fn pixel_origins(
    machine: &Machine,
    workload: &FrameWorkload,
    eye: Option<Eye>,
    history: &mut History,
) -> Option<Vec<PixelOrigin>> {
    let filter = machine.tiles().pixel_filter()?;
    Some(SomePixels::of(filter, workload, eye, history, true).origins)
}

/// The lists of tiles out of those of their sort groups.
fn of_tiles(tiles: &TileWise, workload: &FrameWorkload, lists: &[Vec<u32>]) -> Vec<Vec<u32>> {
    if workload.groups.is_empty() {
        return lists.to_vec();
    }
    let side = tiles.geometry.tiles_per_group_side();
    let of_tile = |tile: usize| {
        let (x, y) = (tile as u32 % workload.tiles_x, tile as u32 / workload.tiles_x);
        let group = y / side * workload.groups_x() + x / side;
        let own = workload.list_of(&workload.tiles[tile]);
        // Its own list is by rank.
        let mine = |rank: &&u32| own.binary_search(rank).is_ok();
        lists[group as usize].iter().filter(mine).copied().collect()
    };
    (0..workload.tiles.len()).into_par_iter().map(of_tile).collect()
}
