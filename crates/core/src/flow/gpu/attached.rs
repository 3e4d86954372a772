//! A unit that blends beside a GPU (`attached`; A147): GBU's rows, the boxes of GauRast's
//! rasteriser, the whole tile of an axis-shared array. The GPU makes the lists; the unit has its
//! own clock and a cache of Gaussians, and takes its part of the memory that both share.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Gpu;
use super::cache::Filtered;
use super::stages::{ATTACHED_ALPHA, ATTACHED_BLEND, ATTACHED_CACHE, ATTACHED_ROW};
use crate::kernel::blocks::MovedBlock;
use crate::machine::{BufferSpec, Ports};
use crate::stage::{sram_read, sram_write};
use crate::workload::FrameWorkload;
use crate::workload::lanes::{Grain, LaneMap, PixelReach, RowShare, TogetherUnits};
use powergs_base::quantity::{Bytes, Hertz};
use powergs_energy::action::{ActionCounts, Phase};

/// The `[attached]` table: a unit that blends in place of a kernel.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct AttachedSpec {
    /// Which pixels of a tile an entry costs it.
    #[serde(rename = "impl")]
    pub implementation: AttachedImpl,
    /// Pixels that it takes in a cycle; with `rows` so many units, each of which takes one.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "pixels/cycle"))]
    pub lanes: u32,
    /// Its clock.
    pub clock: Hertz,
    /// When it works.
    pub overlap: AttachedOverlap,
    /// On chip: Gaussians that came last.
    pub cache: BufferSpec,
}

impl Default for AttachedSpec {
    /// None; what there is where the file says only how it works (A147).
    fn default() -> AttachedSpec {
        AttachedSpec {
            implementation: AttachedImpl::None,
            lanes: 8,
            clock: Hertz(1e9),
            overlap: AttachedOverlap::Frames,
            cache: BufferSpec {
                capacity: Bytes(32 << 10),
                word: Bytes(32),
                banks: 2,
                ports: Ports::ReadOrWrite,
            },
        }
    }
}

/// Which pixels of a tile an entry costs an attached unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AttachedImpl {
    /// There is no such unit: a kernel blends.
    None,
    /// Those of its bounding square.
    Box,
    /// Those between the ends of its ellipse, row by row: row n of the tile is for unit n modulo
    /// the units.
    Rows,
    /// Those that it reaches and that have not stopped.
    Pixels,
    /// All, and none ever stops.
    Tile,
}

/// When an attached unit works.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AttachedOverlap {
    /// When the kernels of its frame have ended.
    None,
    /// While they make the lists of the next frame.
    Frames,
}

impl AttachedSpec {
    /// Whether there is one.
    pub fn is_there(&self) -> bool {
        self.implementation != AttachedImpl::None
    }
}

/// What an attached unit does in a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct AttachedWork {
    /// Tile by tile; items are cycles of the GPU's clock.
    pub blocks: Vec<MovedBlock>,
    /// Slots, and those of pixels that have not stopped.
    pub reach: [u64; 2],
    /// Rows whose ends are found.
    rows: u64,
    /// Gaussians that are read from its cache, and into it.
    cached: [u64; 2],
    blends: u64,
    feature: u64,
}

/// What a tile takes of it.
#[derive(Debug, Clone, Copy, Default)]
struct TileCost {
    cycles: u64,
    reach: PixelReach,
    rows: u64,
    entries: u64,
    never_stops: bool,
}

impl AttachedWork {
    /// Of a frame, on a GPU of so many cycles a second.
    pub fn new(
        workload: &FrameWorkload,
        m: &Gpu,
        clock: Hertz,
        (filtered, feature): (&Filtered, u64),
    ) -> AttachedWork {
        let spec = &m.attached;
        let tiles = 0..workload.tiles.len();
        let costs: Vec<TileCost> =
            tiles.into_par_iter().map(|tile| cost(workload, tile, spec)).collect();
        let mut work = AttachedWork {
            blocks: Vec::with_capacity(costs.len()),
            reach: [0; 2],
            rows: 0,
            cached: [0; 2],
            blends: 0,
            feature,
        };
        // The unit has a clock of its own, and blocks count in cycles of the GPU.
        let ratio = clock.0 / spec.clock.0;
        // Without a cache there is none to go through.
        let has_cache = spec.cache.capacity.0 > 0;
        for ((tile, cost), &misses) in workload.tiles.iter().zip(costs).zip(&filtered.by_tile) {
            work.blocks.push(MovedBlock {
                items: (cost.cycles as f64 * ratio).ceil() as u64,
                read: cost.entries * m.blend.entry.0 + u64::from(misses) * feature,
                write: u64::from(tile.pixels) * m.blend.pixel.0,
            });
            work.blends += if cost.never_stops { cost.reach.slots } else { tile.blends };
            work.reach[0] += cost.reach.slots;
            work.reach[1] += cost.reach.live;
            work.rows += cost.rows;
            if has_cache {
                work.cached[0] += cost.entries;
                work.cached[1] += u64::from(misses);
            }
        }
        work
    }

    /// Charges what it does.
    pub fn charge(&self, all: &mut ActionCounts) {
        let counts = [
            (ATTACHED_ALPHA, self.reach[0]),
            (ATTACHED_BLEND, self.blends),
            (ATTACHED_ROW, self.rows),
            (sram_read(ATTACHED_CACHE), self.cached[0] * self.feature),
            (sram_write(ATTACHED_CACHE), self.cached[1] * self.feature),
        ];
        counts.into_iter().for_each(|(action, n)| all.charge(Phase::Rendering, action, n));
    }
}

/// What a tile takes.
fn cost(workload: &FrameWorkload, tile: usize, spec: &AttachedSpec) -> TileCost {
    let work = &workload.tiles[tile];
    let map = LaneMap::new(workload, tile);
    let lanes = u64::from(spec.lanes);
    let last = map.all_stops().max().unwrap_or(0).min(work.entries);
    let pixels = u64::from(work.pixels);
    let mut cost = TileCost { entries: work.loaded.into(), ..TileCost::default() };
    match spec.implementation {
        AttachedImpl::None => {}
        AttachedImpl::Tile => {
            let entries = u64::from(work.entries);
            let slots = entries * pixels;
            cost.reach = PixelReach { slots, live: slots };
            (cost.cycles, cost.entries) = (entries * pixels.div_ceil(lanes), entries);
            cost.never_stops = true;
        }
        AttachedImpl::Rows => {
            let mut units = vec![RowShare::default(); spec.lanes as usize];
            (0..last).for_each(|at| map.rows(at, &mut units));
            // Rows are dealt once and for all, so that the tile takes as long as its fullest unit.
            cost.cycles = units.iter().map(|unit| unit.cycles).max().unwrap_or(0);
            for unit in &units {
                cost.rows += unit.rows;
                cost.reach.slots += unit.reach.slots;
                cost.reach.live += unit.reach.live;
            }
        }
        AttachedImpl::Box | AttachedImpl::Pixels => {
            let is_box = spec.implementation == AttachedImpl::Box;
            let grain = if is_box { Grain::Box } else { Grain::Pixel };
            let units = TogetherUnits { grain, lanes, recurrence: 1, entries: 1 };
            (cost.cycles, cost.reach) = map.whole(&units, last);
        }
    }
    // Finished pixels leave as many at a time as it takes.
    cost.cycles += pixels.div_ceil(lanes);
    cost
}
