//! Lane maps: which pixels of a tile an entry costs, where units do not work on whole sub-tiles.
//!
//! What an entry reaches is the exact ellipse of its splat ([`Ellipse`]), pixel by pixel, and which
//! pixels still want it is in the workload ([`Pixels`]). `docs/model-accel.md` has the rules in
//! words (A128 to A131).

use super::{ChunkWork, FrameWorkload, Geometry, Pixels};
use powergs_frame::splat::pixel::spans;
use powergs_frame::splat::{Ellipse, Splat};

/// Mini-tiles along a side of the square that a test unit looks at together.
pub const TESTED_SIDE: u32 = 2;

/// Test units of a tile of `side` x `side` mini-tiles.
pub fn test_units(side: u32) -> u32 {
    side.div_ceil(TESTED_SIDE).pow(2)
}

/// What a chunk takes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ChunkRun {
    /// Cycles until the last of its entries has left the feature buffer, right behind the chunk
    /// before; with the last chunk of a tile, until the units are done.
    pub cycles: u64,
    /// The same where the queues are empty when it begins, but not more: entries that come sooner
    /// may go to a sub-tile of which nobody knows yet that it has stopped.
    pub alone: u64,
    /// (entry, sub-tile) pairs that are executed.
    pub pairs: u64,
    /// Of these, of sub-tiles (or a tile) that had stopped and were not yet known to have.
    pub vain: u64,
    /// Entries that are read from the feature buffer.
    pub reads: u64,
    /// Entries that are pushed into queues.
    pub queued: u64,
    /// Changes of the pixel state from one sub-tile to another.
    pub switches: u64,
    /// Pixels that were worked on; `None` where pairs are whole sub-tiles.
    pub reach: Option<PixelReach>,
    /// Leader pixels that were tested, or rows that were looked for.
    pub front: u64,
}

impl ChunkRun {
    /// Adds pixels that were worked on.
    pub(crate) fn add(&mut self, reach: PixelReach) {
        let all = self.reach.get_or_insert_default();
        all.slots += reach.slots;
        all.live += reach.live;
    }
}

/// What all units of a core work on together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Grain {
    /// Pixels that an entry reaches and that have not stopped, of as many entries as it takes.
    Pixel,
    /// The same with quads: 2x2 pixels, of which it reaches one and one has not stopped.
    Quad,
    /// The part of its bounding square that is in the tile, entry by entry.
    Box,
}

/// Units of a core that work on what an entry reaches together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TogetherUnits {
    /// What that is.
    pub grain: Grain,
    /// Pixels that they take in a cycle.
    pub lanes: u64,
    /// Cycles between an entry of a pixel (or quad) and its next ones.
    pub recurrence: u64,
    /// Entries of one pixel that are taken at a time, and leave the feature buffer in a cycle.
    pub entries: u64,
}

/// A test unit: leader pixels of mini-tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Leaders {
    /// Leader pixels that it looks at in a cycle.
    pub per_cycle: u64,
    /// Ratio of axes from which a splat is spiky.
    pub spiky_from: u32,
}

/// The test of one entry.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LeaderTest {
    ellipse: Option<Ellipse>,
    is_spiky: bool,
    /// Cycles in which a test unit looks at the leaders of its mini-tiles.
    pub cycles: u64,
    /// The leaders.
    pub leaders: u64,
}

/// Leaders of a mini-tile for a smooth splat: its corners; for a spiky one two of them.
const LEADERS: [u64; 2] = [4, 2];

impl Leaders {
    pub(crate) fn test(&self, splat: &Splat) -> LeaderTest {
        let is_spiky = is_spiky(splat, self.spiky_from);
        let leaders = u64::from(TESTED_SIDE.pow(2)) * LEADERS[usize::from(is_spiky)];
        let cycles = leaders.div_ceil(self.per_cycle);
        LeaderTest { ellipse: Ellipse::of(splat), is_spiky, cycles, leaders }
    }
}

/// Whether the axes of a splat are in this ratio or a larger one.
fn is_spiky(splat: &Splat, ratio: u32) -> bool {
    let [a, b, d] = splat.cov.map(f64::from);
    let (mid, det) = (0.5 * (a + d), a * d - b * b);
    let root = (mid * mid - det).max(0.0).sqrt();
    // Eigenvalues of the covariance are squares of the axes, hence the square of the ratio.
    mid + root >= (mid - root).max(0.0) * f64::from(ratio).powi(2)
}

impl LeaderTest {
    /// Whether the entry is for the mini-tile of `side` pixels at a corner.
    pub(crate) fn passes(&self, [x, y]: [u32; 2], side: u32) -> bool {
        let Some(ellipse) = &self.ellipse else { return false };
        let [x, y, far] = [x, y, side - 1].map(i64::from);
        let reaches = |dx, dy| ellipse.reaches(x + dx, y + dy);
        // A spiky splat has two leaders in a mini-tile, across of it (A128).
        let diagonal = reaches(0, 0) || reaches(far, far);
        diagonal || !self.is_spiky && (reaches(far, 0) || reaches(0, far))
    }
}

/// A tile pixel by pixel.
#[derive(Debug)]
pub(crate) struct LaneMap<'a> {
    /// Depth ranks of its list.
    list: &'a [u32],
    pixels: &'a Pixels,
    /// Pixels of a row of the image.
    width: u32,
    /// Its pixels, `(x0, y0, x1, y1)`, half open, inside the image.
    pub area: (u32, u32, u32, u32),
}

/// The pixels of an entry.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PixelReach {
    /// Slots of units.
    pub slots: u64,
    /// Of these, of pixels that have not stopped.
    pub live: u64,
}

/// What an entry costs a unit with rows.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RowShare {
    /// Rows that the entry reaches.
    pub rows: u64,
    /// Cycles of them.
    pub cycles: u64,
    /// Their pixels.
    pub reach: PixelReach,
}

impl<'a> LaneMap<'a> {
    /// # Panics
    /// On a workload without [`Pixels`].
    pub(crate) fn new(workload: &'a FrameWorkload, tile: usize) -> LaneMap<'a> {
        let pixels = workload.pixels.as_ref().expect("binned for lane maps");
        LaneMap {
            list: workload.list_of(&workload.tiles[tile]),
            pixels,
            width: workload.width,
            area: workload.pixels_of(tile),
        }
    }

    /// The splat at a list position.
    pub(crate) fn splat(&self, at: u32) -> &'a Splat {
        &self.pixels.splats[self.list[at as usize] as usize]
    }

    /// Where the pixels `x0..x1` of a row stop.
    fn stops(&self, y: u32, [x0, x1]: [u32; 2]) -> &'a [u32] {
        let row = y as usize * self.width as usize;
        &self.pixels.iterated[row + x0 as usize..row + x1 as usize]
    }

    /// Pixels of a part of a row that have not stopped at a list position.
    fn live(&self, y: u32, span: [u32; 2], at: u32) -> u64 {
        self.stops(y, span).iter().filter(|&&stop| stop > at).count() as u64
    }

    fn spans(&self, at: u32) -> impl Iterator<Item = (u32, Option<[u32; 2]>)> + use<> {
        spans(self.splat(at), self.area)
    }

    /// Calls `each` with column and row of every pixel in which an entry blends.
    pub(crate) fn blends(&self, at: u32, mut each: impl FnMut(u32, u32)) {
        for (y, span) in self.spans(at) {
            let Some(span) = span else { continue };
            for (x, _) in (span[0]..).zip(self.stops(y, span)).filter(|(_, stop)| **stop > at) {
                each(x, y);
            }
        }
    }

    /// The sub-tile of a pixel.
    pub(crate) fn subtile(&self, geometry: &Geometry, x: u32, y: u32) -> usize {
        let (column, row) = (x - self.area.0, y - self.area.1);
        let side = geometry.subtiles_per_side();
        (row / geometry.subtile * side + column / geometry.subtile) as usize
    }

    /// Where its pixels stop, row by row.
    pub(crate) fn all_stops(&self) -> impl Iterator<Item = u32> + use<'a> {
        let (x0, y0, x1, y1) = self.area;
        let (pixels, width) = (self.pixels, self.width as usize);
        let row = move |y: u32| {
            let start = y as usize * width;
            &pixels.iterated[start + x0 as usize..start + x1 as usize]
        };
        (y0..y1).flat_map(row).copied()
    }

    /// What an entry costs units that have the rows of the tile in turn. A row takes a cycle of its
    /// generator and one for each pixel of its span, at the same time.
    pub(crate) fn rows(&self, at: u32, shares: &mut [RowShare]) {
        let n = shares.len() as u32;
        for (y, span) in self.spans(at) {
            let pixels = span.map_or(0, |[first, end]| u64::from(end - first));
            let share = &mut shares[((y - self.area.1) % n) as usize];
            share.rows += 1;
            share.cycles += pixels.max(1);
            share.reach.slots += pixels;
            share.reach.live += span.map_or(0, |span| self.live(y, span, at));
        }
    }

    /// All pixels of a square of `side` pixels at a corner, those outside of the image as stopped.
    pub(crate) fn square_at(&self, [x, y]: [u32; 2], side: u32, at: u32) -> PixelReach {
        let (_, _, x1, y1) = self.area;
        // What is outside of the image has no stop to look up, and counts as stopped.
        let xs = [x.min(x1), (x + side).min(x1)];
        let live = (y..(y + side).min(y1)).map(|y| self.live(y, xs, at)).sum();
        PixelReach { slots: u64::from(side).pow(2), live }
    }

    /// What an entry costs units that work on the same grain together. `visits` counts how often
    /// each pixel or quad of the tile is worked on.
    fn reach(&self, at: u32, grain: Grain, visits: &mut [u32]) -> PixelReach {
        match grain {
            Grain::Box => self.square(at),
            Grain::Pixel => self.pixel_by_pixel(at, visits),
            Grain::Quad => self.quad_by_quad(at, visits),
        }
    }

    fn square(&self, at: u32) -> PixelReach {
        let (x0, y0, x1, y1) = self.area;
        let splat = self.splat(at);
        let radius = f64::from(splat.radius());
        let cut = |mean: f32, first: u32, end: u32| {
            let (low, high) = (f64::from(mean) - radius, f64::from(mean) + radius);
            let low = low.ceil().clamp(f64::from(first), f64::from(end)) as u32;
            let high = (high.floor() + 1.0).clamp(f64::from(low), f64::from(end)) as u32;
            [low, high]
        };
        let (xs, ys) = (cut(splat.mean[0], x0, x1), cut(splat.mean[1], y0, y1));
        let slots = u64::from(xs[1] - xs[0]) * u64::from(ys[1] - ys[0]);
        PixelReach { slots, live: (ys[0]..ys[1]).map(|y| self.live(y, xs, at)).sum() }
    }

    fn pixel_by_pixel(&self, at: u32, visits: &mut [u32]) -> PixelReach {
        let (x0, y0, x1, _) = self.area;
        let mut live = 0;
        for (y, span) in self.spans(at) {
            let Some(span) = span else { continue };
            let first = ((y - y0) * (x1 - x0) + span[0] - x0) as usize;
            for (&stop, visits) in self.stops(y, span).iter().zip(&mut visits[first..]) {
                let is_live = stop > at;
                *visits += u32::from(is_live);
                live += u64::from(is_live);
            }
        }
        PixelReach { slots: live, live }
    }

    fn quad_by_quad(&self, at: u32, visits: &mut [u32]) -> PixelReach {
        let (x0, y0, x1, y1) = self.area;
        let columns = (x1 - x0).div_ceil(QUAD);
        let mut reach = PixelReach::default();
        let mut spans = self.spans(at).peekable();
        while let Some((y, span)) = spans.next() {
            // Both rows of a quad, where the ellipse reaches them.
            let row = (y - y0) / QUAD;
            let below = spans.next_if(|&(other, _)| (other - y0) / QUAD == row);
            let both = [span, below.and_then(|(_, span)| span)];
            let Some([first, end]) = both.into_iter().flatten().reduce(union) else { continue };
            let top = y0 + row * QUAD;
            for column in (first - x0) / QUAD..(end - x0).div_ceil(QUAD) {
                let xs = [x0 + column * QUAD, (x0 + (column + 1) * QUAD).min(x1)];
                let is_reached = |[first, end]: [u32; 2]| first < xs[1] && end > xs[0];
                if !both.into_iter().flatten().any(is_reached) {
                    continue;
                }
                let live: u64 = (top..(top + QUAD).min(y1)).map(|y| self.live(y, xs, at)).sum();
                if live > 0 {
                    visits[(row * columns + column) as usize] += 1;
                    reach.slots += u64::from(QUAD.pow(2));
                    reach.live += live;
                }
            }
        }
        reach
    }

    /// Cycles of units that work together for the first entries of the list, with nothing between
    /// them, and their pixels.
    pub(crate) fn whole(&self, units: &TogetherUnits, entries: u32) -> (u64, PixelReach) {
        let (x0, y0, x1, y1) = self.area;
        let mut visits = vec![0u32; ((x1 - x0) * (y1 - y0)) as usize];
        let (mut cycles, mut all) = (0, PixelReach::default());
        for at in 0..entries {
            let reach = self.reach(at, units.grain, &mut visits);
            cycles += reach.slots.div_ceil(units.lanes).max(1);
            (all.slots, all.live) = (all.slots + reach.slots, all.live + reach.live);
        }
        // Lanes are filled across entries, so that only the sum is rounded up; boxes are rounded
        // one by one.
        let packed = all.slots.div_ceil(units.lanes).max(u64::from(entries));
        (if units.grain == Grain::Box { cycles } else { packed }, all)
    }

    /// What the chunks of the tile take of units that work together. Boxes are worked on up to list
    /// position `end`, and until it is known, `latency` cycles later.
    pub(crate) fn together(
        &self,
        chunks: &[ChunkWork],
        &TogetherUnits { grain, lanes, recurrence, entries }: &TogetherUnits,
        (end, latency): (u32, u64),
    ) -> Vec<ChunkRun> {
        let (x0, y0, x1, y1) = self.area;
        let mut visits = vec![0u32; ((x1 - x0) * (y1 - y0)) as usize];
        let (mut now, mut slots, mut at, mut known) = (0, 0, 0, latency);
        let mut chunk = |chunk: &ChunkWork| {
            let (start, taken) = (now, slots);
            let mut run = ChunkRun { reads: u64::from(chunk.entries), ..ChunkRun::default() };
            // How often the busiest pixel is worked on bounds a chunk, not the tile (A130).
            visits.fill(0);
            for _ in 0..chunk.entries {
                let is_needed = at < end;
                // Boxes that come before the stop is known are worked on all the same (A88).
                if grain == Grain::Box && !is_needed && now >= known {
                    at += 1;
                    continue;
                }
                let reach = self.reach(at, grain, &mut visits);
                run.add(reach);
                slots += reach.slots;
                let is_worked_on = reach.slots > 0;
                run.pairs += u64::from(is_worked_on);
                run.vain += u64::from(is_worked_on && !is_needed);
                if grain == Grain::Box && is_worked_on {
                    now += reach.slots.div_ceil(lanes).max(recurrence);
                }
                if is_needed {
                    known = now + latency;
                }
                at += 1;
            }
            if grain != Grain::Box {
                let most = u64::from(visits.iter().copied().max().unwrap_or(0));
                // Lanes that the chunk before left empty in its last cycle are filled by this one.
                let cycles = slots.div_ceil(lanes) - taken.div_ceil(lanes);
                now += cycles.max(most.div_ceil(entries) * recurrence);
            }
            run.cycles = (now - start).max(run.reads.div_ceil(entries));
            ChunkRun { alone: run.cycles, ..run }
        };
        chunks.iter().map(&mut chunk).collect()
    }
}

/// Pixels along a side of a quad.
const QUAD: u32 = 2;

fn union(a: [u32; 2], b: [u32; 2]) -> [u32; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}
