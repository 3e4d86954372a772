//! The rendering unit of a core: what `rtl/vru.sv` makes of the list of a tile, and in which
//! cycles.
//!
//! Four sub-tiles of 8x8 pixels have a queue and four cores of 4x4 pixels each. An entry leaves the
//! head when the queues of all sub-tiles that its bitmap names have room, one a cycle at most, and
//! holds a sub-tile for 16 cycles, one for each pixel of a core. A sub-tile that is known to have
//! stopped needs no room and takes nothing. Cycles are those with entries ready and pixels
//! accepted.

use super::vrc::{Outcome, Pixel, Record, TILE, Vrc};

/// Sub-tiles of a tile.
pub const SUBTILES: usize = 4;
/// Cores of a sub-tile.
const CORES: u32 = 4;
/// Pixels of a core, and the cycles of a splat.
const PIXELS: u32 = 16;
/// Side of a sub-tile and of the pixels of a core.
const SUBTILE: u32 = TILE / 2;
const SIDE: u32 = 4;

/// An entry of a tile's list.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// The splat, relative to the tile.
    pub splat: Record,
    /// Sub-tiles that it is for, row by row from the lowest bit.
    pub bitmap: u8,
}

/// The rendering unit of a core.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Vru {
    /// Its cores.
    pub vrc: Vrc,
    /// Whether operations have a register inside.
    pub split: bool,
    /// Entries of a queue with the one that is worked on, at least 2.
    pub queue: usize,
}

/// What becomes of a tile. Cycles count from the one in which OPEN leaves the head.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TileRun {
    /// Its pixels, core by core, 16 of each.
    pub pixels: Vec<Pixel>,
    /// Cycles in which entries leave the head.
    pub left: Vec<u64>,
    /// Cycle in which CLOSE leaves it: all splats have been issued.
    pub close: u64,
    /// Cycle in which the first pixels leave. 15 cycles later the last ones do; in the next cycle
    /// the next tile may open.
    pub first_pixels: u64,
    /// Cycles from which on sub-tiles are known to have stopped.
    pub known: [Option<u64>; SUBTILES],
    /// List positions from which on nothing of a sub-tile is needed, where it stops.
    pub ends: [Option<usize>; SUBTILES],
    /// (Entry, sub-tile) pairs that hold cores.
    pub pairs: u64,
    /// Of these, behind the stop of their sub-tile.
    pub vain: u64,
}

/// A sub-tile of a tile that is rendered.
struct Subtile {
    /// Its first pixel.
    corner: [u32; 2],
    pixels: Vec<Pixel>,
    /// Cycle in which its cores are ready.
    free: u64,
    /// Cycles in which the entries that were pushed leave.
    leaving: Vec<u64>,
    known: Option<u64>,
    end: Option<usize>,
}

impl Subtile {
    fn open(vrc: &Vrc, index: usize, [width, height]: [u32; 2]) -> Subtile {
        let corner = [index as u32 % 2 * SUBTILE, index as u32 / 2 * SUBTILE];
        let mut subtile = Subtile {
            corner,
            pixels: Vec::new(),
            free: 1,
            leaving: Vec::new(),
            known: None,
            end: None,
        };
        let open = |i| {
            let [x, y] = subtile.place(i);
            Pixel::open(vrc.format(), x < width && y < height)
        };
        let pixels: Vec<Pixel> = (0..CORES * PIXELS).map(open).collect();
        if pixels.iter().all(|pixel| !pixel.live) {
            (subtile.known, subtile.end) = (Some(1), Some(0));
        }
        Subtile { pixels, ..subtile }
    }

    /// Where pixel `i` of the sub-tile is, core by core.
    fn place(&self, i: u32) -> [u32; 2] {
        let (core, pixel) = (i / PIXELS, i % PIXELS);
        [
            self.corner[0] + SIDE * (core % 2) + pixel % SIDE,
            self.corner[1] + SIDE * (core / 2) + pixel / SIDE,
        ]
    }

    /// Cycle from which on an entry needs no place in the queue, or has one.
    fn room(&self, queue: usize) -> u64 {
        let leaving = &self.leaving;
        let room = leaving.len().checked_sub(queue).map_or(0, |first| leaving[first]);
        self.known.map_or(room, |known| known.min(room))
    }

    /// The entry at list position `at` enters the queue in cycle `now`.
    fn enter(&mut self, unit: &Vru, (at, entry): (usize, &Entry), now: u64, run: &mut TileRun) {
        let begin = now.max(self.free);
        if let Some(known) = self.known.filter(|&known| known <= begin) {
            self.leaving.push(known);
            return;
        }
        self.free = begin + u64::from(PIXELS);
        self.leaving.push(self.free);
        run.pairs += 1;
        run.vain += u64::from(self.known.is_some());
        let mut last = None;
        for i in 0..CORES * PIXELS {
            let [x, y] = self.place(i);
            let outcome = unit.vrc.blend(&mut self.pixels[i as usize], &entry.splat, x, y);
            if outcome == Outcome::Stopped {
                last = last.max(Some(i % PIXELS));
            }
        }
        let Some(last) = last.filter(|_| self.pixels.iter().all(|pixel| !pixel.live)) else {
            return;
        };
        // Issue follows acceptance, `stopped` of a core 9 stages and a cycle behind that, and the
        // sub-tile a cycle later.
        self.known = Some(begin + 1 + u64::from(last) + 9 * unit.depth() + 2);
        self.end = Some(at + 1);
    }
}

impl Vru {
    /// Cycles of an operation.
    fn depth(&self) -> u64 {
        if self.split { 2 } else { 1 }
    }

    /// Renders a tile of which `size` pixels are in the image.
    pub fn tile(&self, entries: &[Entry], size: [u32; 2]) -> TileRun {
        let mut subtiles: Vec<Subtile> =
            (0..SUBTILES).map(|index| Subtile::open(&self.vrc, index, size)).collect();
        let mut run = TileRun {
            pixels: Vec::new(),
            left: Vec::new(),
            close: 0,
            first_pixels: 0,
            known: [None; SUBTILES],
            ends: [None; SUBTILES],
            pairs: 0,
            vain: 0,
        };
        let mut next = 1;
        for (at, entry) in entries.iter().enumerate() {
            let wanted = |index: &usize| entry.bitmap >> index & 1 == 1;
            let mut now = next;
            for index in (0..SUBTILES).filter(wanted) {
                now = now.max(subtiles[index].room(self.queue));
            }
            for index in (0..SUBTILES).filter(wanted) {
                if subtiles[index].known.is_none_or(|known| now < known) {
                    subtiles[index].enter(self, (at, entry), now, &mut run);
                }
            }
            run.left.push(now);
            next = now + 1;
        }
        let free = subtiles.iter().map(|subtile| subtile.free).max().unwrap_or(0);
        run.close = next.max(free);
        // A core without splats has nothing to drain.
        let drained = subtiles.iter().filter(|subtile| !subtile.leaving.is_empty());
        let drained = drained.map(|subtile| subtile.free + 11 * self.depth()).max().unwrap_or(0);
        run.first_pixels = (run.close + 2).max(drained);
        for (index, subtile) in subtiles.into_iter().enumerate() {
            run.known[index] = subtile.known;
            run.ends[index] = subtile.end;
            run.pixels.extend(subtile.pixels);
        }
        run
    }
}
