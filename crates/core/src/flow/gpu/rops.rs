//! Raster operations that blend in place of a kernel (`rops`; A148): the graphics pipeline draws
//! the oriented box of each Gaussian as two triangles, all of them in one order by depth.
//!
//! Quads of 2x2 pixels wait in bins, one for a tile: what is flushed of a bin is shaded together.
//! A bin is flushed when it is full, or when another tile needs it, oldest first. In front of them
//! Gaussians may wait in groups, squares of tiles, so that bins fill (VR-Pipe). Where quads merge,
//! the second one of a place in a bin becomes one with the first before it is blended.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::stages::{QUAD_BLENDED, QUAD_FOUND, ROP_BINS};
use super::tables::WARP;
use super::{Gpu, L2Spec};
use crate::kernel::memo::MemoKey;
use crate::stage::{sram_read, sram_write};
use crate::workload::{FrameWorkload, Geometry};
use powergs_energy::action::{ActionCounts, Phase};
use powergs_frame::splat::pixel::{box_spans, spans};

/// The `[rops]` table: raster operations that blend in place of a kernel.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case", default)]
pub struct RopSpec {
    /// What is blended.
    #[serde(rename = "impl")]
    pub implementation: RopImpl,
    /// Quads of 2x2 pixels that are blended in a cycle.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "quads/cycle"))]
    pub quads_per_cycle: u32,
    /// Quads that the rasteriser finds in a cycle.
    #[schemars(range(min = 1, max = 65536), extend("x-unit" = "quads/cycle"))]
    pub found_per_cycle: u32,
    /// Whether quads whose pixels have all stopped are not shaded.
    pub stop: bool,
    /// Whether two quads at the same place of a bin are blended as one.
    pub merge: bool,
    /// Tiles whose quads wait at a time.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "bins"))]
    pub bins: u32,
    /// Quads that one of them has room for.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "quads"))]
    pub bin_quads: u32,
    /// Groups of tiles whose Gaussians wait in front of them, 0 for none.
    #[schemars(range(min = 0, max = 4096), extend("x-unit" = "groups"))]
    pub groups: u32,
    /// Tiles along a side of a group.
    #[schemars(range(min = 1, max = 64), extend("x-unit" = "tiles"))]
    pub group_side: u32,
    /// Gaussians that a group has room for.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "Gaussians"))]
    pub group_gaussians: u32,
    /// Instructions of a corner of a box, of which a Gaussian has four.
    #[schemars(range(min = 1, max = 10000), extend("x-unit" = "instructions"))]
    pub corner: u32,
    /// Instructions of a fragment, its exponential besides.
    #[schemars(range(min = 1, max = 10000), extend("x-unit" = "instructions"))]
    pub shade: u32,
    /// Instructions of a fragment that is merged with another one.
    #[schemars(range(min = 0, max = 10000), extend("x-unit" = "instructions"))]
    pub pair: u32,
}

impl Default for RopSpec {
    /// None; what there is where the file says only that they blend (A148).
    fn default() -> RopSpec {
        RopSpec {
            implementation: RopImpl::None,
            quads_per_cycle: 2,
            found_per_cycle: 16,
            stop: false,
            merge: false,
            bins: 32,
            bin_quads: 128,
            groups: 0,
            group_side: 4,
            group_gaussians: 16,
            corner: 24,
            shade: 28,
            pair: 12,
        }
    }
}

/// What raster operations blend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RopImpl {
    /// Nothing: a kernel blends, or a unit beside the GPU.
    None,
    /// Fragments of boxes, in one order by depth.
    Boxes,
}

/// Pixels along a side of a quad.
const SIDE: u32 = 2;
/// Pixels of a quad.
pub const QUAD: u64 = (SIDE * SIDE) as u64;
/// Quads of a warp.
const QUADS: u32 = WARP / (SIDE * SIDE);
/// Corners of a box.
pub const CORNERS: u64 = 4;
/// Bytes of a quad in a bin: its place, what it covers, its Gaussian.
const BIN_ENTRY: u64 = 8;
/// Bytes of a Gaussian in a group, and of the group besides: 24.25 KiB for 128 groups of 16, as
/// VR-Pipe has it.
const GROUP_ENTRY: u64 = 12;
const GROUP_HEAD: u64 = 2;

impl RopSpec {
    /// Whether they blend.
    pub fn is_there(&self) -> bool {
        self.implementation != RopImpl::None
    }

    /// Bytes of all bins and groups.
    pub fn bytes(&self) -> u64 {
        let [bins, quads] = [self.bins, self.bin_quads].map(u64::from);
        let [groups, gaussians] = [self.groups, self.group_gaussians].map(u64::from);
        bins * quads * BIN_ENTRY + groups * (gaussians * GROUP_ENTRY + GROUP_HEAD)
    }
}

/// Everything that decides what is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DrawKey {
    stop: bool,
    merge: bool,
    bins: [u32; 2],
    groups: [u32; 3],
    /// Tiles of the picture that the L2 cache holds.
    cached: u64,
    /// Geometry of the workload.
    geometry: Geometry,
}

impl DrawKey {
    /// That of a machine.
    pub fn of(m: &Gpu) -> DrawKey {
        let (r, l2): (&RopSpec, &L2Spec) = (&m.rops, &m.l2);
        let tile = u64::from(m.blend.tile).pow(2) * m.blend.pixel.0;
        DrawKey {
            stop: r.stop,
            merge: r.merge,
            bins: [r.bins, r.bin_quads],
            groups: [r.groups, r.group_side, r.group_gaussians],
            cached: l2.capacity.0 / tile.max(1),
            geometry: m.geometry(),
        }
    }
}

impl MemoKey for DrawKey {
    type Value = Drawn;
    const MOST: usize = 64;
}

/// What is drawn of a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Drawn {
    /// Quads of which a box covers a pixel.
    pub found: u64,
    /// Those that are shaded.
    pub shaded: u64,
    /// Of their pixels, those that a box covers and that have not stopped.
    pub live: u64,
    /// Warps that shade them.
    pub warps: u64,
    /// Warps that merge quads.
    pub pair_warps: u64,
    /// Quads that are blended.
    pub blended: u64,
    /// Quads of the picture that are read and written for them, flush by flush.
    pub places: u64,
    /// Those of them that are in the memory, and not in the L2 cache.
    pub missed: u64,
    /// Flushes of bins.
    pub flushes: u64,
}

/// A Gaussian in a tile.
#[derive(Debug, Clone, Copy, Default)]
struct TileMeeting {
    tile: u32,
    /// Position in the list of the tile.
    at: u32,
}

/// Its quads in the tile, a bit each, row-major.
#[derive(Debug, Clone, Copy, Default)]
struct SplatQuads {
    tile: u32,
    found: u32,
    live: u32,
    shaded: u64,
    blended: u64,
}

/// How many of them are looked at together.
const AT_ONCE: usize = 1 << 17;

impl Drawn {
    /// Draws a frame.
    ///
    /// # Panics
    /// On a workload without its pixels, or with tiles of more than 64 quads.
    pub fn new(workload: &FrameWorkload, key: &DrawKey) -> Drawn {
        assert!(workload.geometry.tile <= 8 * SIDE, "a bit for each quad");
        // What Gaussians meet, Gaussian by Gaussian in their order.
        let mut ends = vec![0_usize; workload.index.len() + 1];
        workload.list.iter().for_each(|&rank| ends[rank as usize + 1] += 1);
        for rank in 0..workload.index.len() {
            ends[rank + 1] += ends[rank];
        }
        let mut all = vec![TileMeeting::default(); workload.list.len()];
        let mut next = ends.clone();
        for (tile, work) in (0..).zip(&workload.tiles) {
            for (at, &rank) in (0..).zip(workload.list_of(work)) {
                all[next[rank as usize]] = TileMeeting { tile, at };
                next[rank as usize] += 1;
            }
        }
        let mut groups = SplatGroups::new(workload, key);
        let mut rank = 0;
        while rank + 1 < ends.len() {
            let first = rank;
            // Quads are found by all threads for a part of the Gaussians at a time, which bounds
            // the memory.
            while rank + 1 < ends.len() && ends[rank] - ends[first] < AT_ONCE {
                rank += 1;
            }
            let quads: Vec<SplatQuads> = all[ends[first]..ends[rank]]
                .par_iter()
                .map(|meeting| quads(workload, meeting, key.stop))
                .collect();
            for own in ends[first..=rank].windows(2) {
                let own = own[0] - ends[first]..own[1] - ends[first];
                groups.take(&quads[own]);
            }
        }
        groups.end()
    }
}

impl Drawn {
    /// Charges what raster operations do of it.
    pub fn charge(&self, all: &mut ActionCounts) {
        // A quad goes into a bin and out of it.
        let waiting = self.shaded * BIN_ENTRY;
        let counts = [
            (QUAD_FOUND, self.found),
            (QUAD_BLENDED, self.blended),
            (sram_write(ROP_BINS), waiting),
            (sram_read(ROP_BINS), waiting),
        ];
        counts.into_iter().for_each(|(action, n)| all.charge(Phase::Rendering, action, n));
    }
}

/// The quads of a Gaussian in a tile.
fn quads(
    workload: &FrameWorkload,
    &TileMeeting { tile, at }: &TileMeeting,
    stop: bool,
) -> SplatQuads {
    let pixels = workload.pixels.as_ref().expect("binned with its pixels");
    let area = workload.pixels_of(tile as usize);
    let list = workload.list_of(&workload.tiles[tile as usize]);
    let splat = &pixels.splats[list[at as usize] as usize];
    let across = workload.geometry.tile / SIDE;
    let (mut quads, mut found) = (SplatQuads { tile, ..SplatQuads::default() }, 0_u64);
    let mut ellipse = spans(splat, area).peekable();
    for (y, [first, end]) in box_spans(splat, area) {
        // The ellipse may have rows above those of the box, and none where the box has one.
        while ellipse.next_if(|&(row, _)| row < y).is_some() {}
        let met = ellipse.peek().filter(|&&(row, _)| row == y).and_then(|&(_, span)| span);
        let met = met.unwrap_or_default();
        let row = y as usize * workload.width as usize;
        let stops = &pixels.iterated[row + first as usize..row + end as usize];
        for (x, &stops) in (first..end).zip(stops) {
            let quad = 1 << ((y - area.1) / SIDE * across + (x - area.0) / SIDE);
            found |= quad;
            let is_live = stops > at;
            quads.live += u32::from(is_live);
            if is_live || !stop {
                quads.shaded |= quad;
                quads.blended |= if (met[0]..met[1]).contains(&x) { quad } else { 0 };
            }
        }
    }
    quads.found = found.count_ones();
    quads
}

/// Things that wait under a key, so many at most.
#[derive(Debug)]
struct Keyed<T> {
    most: usize,
    all: Vec<Waiter<T>>,
    /// Where the one of each key is.
    place: Vec<usize>,
    came: u64,
}

#[derive(Debug)]
struct Waiter<T> {
    key: usize,
    came: u64,
    what: T,
}

const NOWHERE: usize = usize::MAX;

impl<T: Default> Keyed<T> {
    fn new(most: u32, keys: usize) -> Keyed<T> {
        let place = vec![NOWHERE; keys];
        Keyed { most: most as usize, all: Vec::new(), place, came: 0 }
    }

    /// The one that has to go before one of this key can wait.
    fn in_the_way(&self, key: usize) -> Option<usize> {
        let is_full = self.all.len() == self.most && self.place[key] == NOWHERE;
        is_full.then(|| self.oldest()).flatten()
    }

    fn oldest(&self) -> Option<usize> {
        (0..self.all.len()).min_by_key(|&at| self.all[at].came)
    }

    /// Where the one of a key is; it comes if it was not there.
    fn of(&mut self, key: usize) -> usize {
        if self.place[key] == NOWHERE {
            self.came += 1;
            self.place[key] = self.all.len();
            self.all.push(Waiter { key, came: self.came, what: T::default() });
        }
        self.place[key]
    }

    /// Takes one out, with its key.
    fn take(&mut self, at: usize) -> Waiter<T> {
        let gone = self.all.swap_remove(at);
        self.place[gone.key] = NOWHERE;
        if let Some(moved) = self.all.get(at) {
            self.place[moved.key] = at;
        }
        gone
    }
}

/// Gaussians that wait for others of the same square of tiles.
#[derive(Debug, Default)]
struct SplatGroup {
    gaussians: u32,
    quads: Vec<SplatQuads>,
}

/// All of them, and the bins behind.
struct SplatGroups {
    /// Tiles along a side, tiles of a row, Gaussians that one has room for.
    side: u32,
    columns: u32,
    room: u32,
    all: Keyed<SplatGroup>,
    bins: QuadBins,
}

impl SplatGroups {
    fn new(workload: &FrameWorkload, key: &DrawKey) -> SplatGroups {
        let [most, side, room] = key.groups;
        let [columns, rows] = [workload.tiles_x, workload.tiles_y].map(|n| n.div_ceil(side));
        SplatGroups {
            side,
            columns: workload.tiles_x,
            room,
            all: Keyed::new(most, columns as usize * rows as usize),
            bins: QuadBins::new(workload.tiles.len(), key),
        }
    }

    /// The group of a tile.
    fn of(&self, tile: u32) -> usize {
        let [x, y] = [tile % self.columns, tile / self.columns].map(|n| n / self.side);
        (y * self.columns.div_ceil(self.side) + x) as usize
    }

    /// Takes the quads of a Gaussian, tile by tile.
    fn take(&mut self, quads: &[SplatQuads]) {
        if self.all.most == 0 {
            quads.iter().for_each(|quads| self.bins.take(quads));
            return;
        }
        // Tiles come row by row, those of a group not one after the other.
        let mut keys = Vec::new();
        for quads in quads {
            let key = self.of(quads.tile);
            if !keys.contains(&key) {
                keys.push(key);
            }
        }
        for key in keys {
            if let Some(oldest) = self.all.in_the_way(key) {
                self.flush(oldest);
            }
            let at = self.all.of(key);
            let own = quads.iter().filter(|quads| self.of(quads.tile) == key);
            let own: Vec<SplatQuads> = own.copied().collect();
            let group = &mut self.all.all[at].what;
            group.quads.extend(own);
            group.gaussians += 1;
            if group.gaussians == self.room {
                self.flush(at);
            }
        }
    }

    fn flush(&mut self, at: usize) {
        let group = self.all.take(at).what;
        group.quads.iter().for_each(|quads| self.bins.take(quads));
    }

    /// What is left goes too.
    fn end(mut self) -> Drawn {
        while let Some(oldest) = self.all.oldest() {
            self.flush(oldest);
        }
        while let Some(oldest) = self.bins.all.oldest() {
            self.bins.flush(oldest);
        }
        self.bins.drawn
    }
}

/// Quads of a tile that wait.
#[derive(Debug, Clone, Copy, Default)]
struct QuadBin {
    quads: u32,
    /// Those that are one with another.
    pairs: u32,
    /// Places with a quad that is not, and of these with one that blends.
    open: u64,
    open_blends: u64,
    /// Places that blend.
    places: u64,
}

/// All bins.
struct QuadBins {
    room: u32,
    merge: bool,
    all: Keyed<QuadBin>,
    /// Tiles of the picture in the L2 cache: how many have come in when each did.
    cached: u64,
    came: Vec<u64>,
    coming: u64,
    drawn: Drawn,
}

impl QuadBins {
    fn new(tiles: usize, key: &DrawKey) -> QuadBins {
        QuadBins {
            room: key.bins[1],
            merge: key.merge,
            all: Keyed::new(key.bins[0], tiles),
            cached: key.cached,
            came: vec![u64::MAX; tiles],
            coming: 0,
            drawn: Drawn::default(),
        }
    }

    fn take(&mut self, quads: &SplatQuads) {
        self.drawn.found += u64::from(quads.found);
        self.drawn.live += u64::from(quads.live);
        let (tile, mut left) = (quads.tile as usize, quads.shaded);
        while left != 0 {
            if let Some(oldest) = self.all.in_the_way(tile) {
                self.flush(oldest);
            }
            let at = self.all.of(tile);
            let bin = &mut self.all.all[at].what;
            // The first of them that there is room for.
            let mut part = left;
            while part.count_ones() > self.room - bin.quads {
                part &= !(1 << part.ilog2());
            }
            left &= !part;
            let blends = part & quads.blended;
            let second = if self.merge { part & bin.open } else { 0 };
            if self.merge {
                let first = part & !second;
                let merged = second & (bin.open_blends | blends);
                self.drawn.blended += u64::from(merged.count_ones());
                bin.open = bin.open & !second | first;
                bin.open_blends = bin.open_blends & !second | first & blends;
            } else {
                self.drawn.blended += u64::from(blends.count_ones());
            }
            bin.pairs += second.count_ones();
            bin.places |= blends;
            bin.quads += part.count_ones();
            if bin.quads == self.room {
                self.flush(at);
            }
        }
    }

    fn flush(&mut self, at: usize) {
        let Waiter { key, what: bin, .. } = self.all.take(at);
        let drawn = &mut self.drawn;
        drawn.flushes += 1;
        drawn.shaded += u64::from(bin.quads);
        drawn.warps += u64::from(bin.quads.div_ceil(QUADS));
        drawn.pair_warps += u64::from((2 * bin.pairs).div_ceil(QUADS));
        drawn.blended += u64::from(bin.open_blends.count_ones());
        let places = u64::from(bin.places.count_ones());
        drawn.places += places;
        // Tiles leave the L2 in the order in which they came in; one that left is read once more.
        let came = &mut self.came[key];
        if places > 0 && (*came == u64::MAX || self.coming - *came > self.cached) {
            drawn.missed += places;
            *came = self.coming;
            self.coming += 1;
        }
    }
}
