//! How the units of a core go through the sub-tiles of a tile, entry by entry.
//!
//! `vru.impl` decides it; A84 to A88 have the rules in words. Where all
//! units take one sub-tile after the other, may change between them for nothing and know at once
//! that one has stopped, the counters of a chunk say what it takes and such a machine has no
//! [`Discipline`]. Otherwise [`runs`] steps through the entries of every tile, once a frame for all
//! machines with the same discipline. The result does not depend on the rest of the machine: it
//! says what a chunk takes right behind the one before, and what it takes alone (A85).

use rayon::prelude::*;

use crate::flow::tile_wise::{Termination, VruImpl, VruSpec};
use crate::kernel::MemoKey;
pub use crate::workload::lanes::ChunkRun;
use crate::workload::lanes::{Grain, LaneMap, Leaders, RowShare, TESTED_SIDE, TogetherUnits};
use crate::workload::{ChunkWork, FrameWorkload};

/// In which order units meet sub-tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SubtileWay {
    /// All units take the sub-tiles of an entry one after the other.
    Interleaved {
        /// Cycles that a change of the pixel state takes; hidden as far as a pair takes as long.
        swap: u64,
    },
    /// All units take a sub-tile through the whole chunk; a scan finds the entries of each.
    Scanned {
        /// Cycles that a change of the pixel state takes, hidden as far as a pass takes as long.
        swap: u64,
        /// Entries that the scan is ahead.
        depth: u32,
    },
    /// Every sub-tile has its own units, with a queue of entries in front of them.
    Parallel {
        /// Entries that a queue holds, with the one that is worked on.
        depth: u32,
    },
    /// The same behind test units, which see which mini-tiles (sub-tiles) an entry is for.
    Tested {
        /// Entries that a queue holds, with the one that is worked on.
        depth: u32,
        /// The test units.
        leaders: Leaders,
    },
    /// Every unit has rows of the tile, with a queue in front of it.
    Rows {
        /// Entries that a queue holds, with the one that is worked on.
        depth: u32,
        /// Units.
        units: u32,
    },
    /// All units work on what an entry reaches together.
    Together(TogetherUnits),
}

/// Everything that the cycles of a chunk depend on besides the frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Discipline {
    way: SubtileWay,
    /// Groups of pixels of a sub-tile that its units take one after the other.
    rounds: u64,
    /// Cycles of a round while all pixels are live.
    round: u64,
    /// The least cycles of a round of units that rotate through live pixels only.
    live_round: Option<u64>,
    /// The least cycles from one pair of a unit to its next one.
    recurrence: u64,
    skips: bool,
    stops_with_tile: bool,
    stop_latency: u64,
}

/// Some hundred kilobytes each.
impl MemoKey for Discipline {
    type Value = Vec<ChunkRun>;
    const MOST: usize = 32;
}

impl Discipline {
    /// The discipline of a machine with `subtiles` sub-tiles of `pixels` pixels in a tile, whose
    /// pixel state changes in `swap` cycles; `None` where counters of chunks say everything.
    pub(super) fn of(spec: &VruSpec, subtiles: u32, pixels: u32, swap: u64) -> Option<Discipline> {
        if spec.implementation == VruImpl::Serial && spec.stop_latency == 0 {
            return None;
        }
        let depth = spec.subtile_queue;
        let lanes = u64::from(spec.units_per_core);
        let recurrence = u64::from(spec.recurrence);
        let entries = match spec.implementation {
            VruImpl::Pixels => u64::from(spec.entries_per_cycle),
            _ => 1,
        };
        let together =
            |grain| SubtileWay::Together(TogetherUnits { grain, lanes, recurrence, entries });
        let way = match spec.implementation {
            VruImpl::Parallel => SubtileWay::Parallel { depth },
            VruImpl::Serial => SubtileWay::Interleaved { swap: 0 },
            VruImpl::Swap => SubtileWay::Interleaved { swap },
            VruImpl::Scan => SubtileWay::Scanned { swap, depth },
            VruImpl::Leaders => {
                let (per_cycle, spiky_from) = (spec.leaders_per_cycle.into(), spec.spiky_from);
                SubtileWay::Tested { depth, leaders: Leaders { per_cycle, spiky_from } }
            }
            VruImpl::Rows => SubtileWay::Rows { depth, units: spec.units_per_core },
            VruImpl::Pixels => together(Grain::Pixel),
            VruImpl::Quads => together(Grain::Quad),
            VruImpl::Box => together(Grain::Box),
        };
        Some(Discipline {
            way,
            rounds: rounds(spec, subtiles, pixels),
            round: u64::from(spec.pixels_per_unit.max(spec.recurrence)),
            live_round: (spec.termination == Termination::Pixel)
                .then_some(u64::from(spec.recurrence)),
            recurrence: u64::from(spec.recurrence),
            skips: spec.subtile_skipping,
            stops_with_tile: matches!(spec.termination, Termination::Tile | Termination::None),
            stop_latency: u64::from(spec.stop_latency),
        })
    }

    /// Whether what units work on is counted pixel by pixel ([`ChunkRun::reach`]).
    pub(super) fn counts_pixels(&self) -> bool {
        use SubtileWay::{Rows, Tested, Together};
        matches!(self.way, Tested { .. } | Rows { .. } | Together(_))
    }

    /// Cycles of the pair of an entry at list position `at` and a sub-tile.
    fn pair(&self, stops: &[u32; 4], at: u32) -> u64 {
        match self.live_round {
            None => self.rounds * self.round,
            Some(least) => {
                // Units rotate through live pixels, but the transmittance of a pixel must be known
                // before its next Gaussian (A37).
                let live = stops.iter().filter(|&&stop| stop > at).count() as u64;
                self.rounds * live.max(least)
            }
        }
    }
}

/// Groups of pixels of a sub-tile that the units of a core, or of the sub-tile, take one after the
/// other.
pub(super) fn rounds(spec: &VruSpec, subtiles: u32, pixels: u32) -> u64 {
    let units = match spec.implementation {
        VruImpl::Parallel | VruImpl::Leaders => (spec.units_per_core / subtiles.max(1)).max(1),
        _ => spec.units_per_core,
    };
    u64::from(pixels).div_ceil(u64::from(units) * u64::from(spec.pixels_per_unit))
}

/// What every chunk of a frame takes, in the order of [`FrameWorkload::chunks`].
pub fn runs(workload: &FrameWorkload, discipline: &Discipline) -> Vec<ChunkRun> {
    let tiles: Vec<Vec<ChunkRun>> = (0..workload.tiles.len())
        .into_par_iter()
        .with_min_len(64)
        .map_init(Scratch::default, |scratch, tile| {
            let tile = Tile::new(workload, discipline, tile);
            match discipline.way {
                SubtileWay::Interleaved { swap } => tile.interleaved(swap, scratch),
                SubtileWay::Scanned { swap, depth } => tile.scanned(swap, depth, scratch),
                SubtileWay::Parallel { depth }
                | SubtileWay::Tested { depth, .. }
                | SubtileWay::Rows { depth, .. } => tile.parallel(depth, scratch),
                SubtileWay::Together(units) => tile.together(&units),
            }
        })
        .collect();
    tiles.into_iter().flatten().collect()
}

/// Memory that is used again for each tile.
#[derive(Debug, Default)]
struct Scratch {
    work: EntryWork,
    /// Where queues are, chunk behind chunk and each chunk alone.
    queues: [Queues; 2],
}

/// What an entry is for.
#[derive(Debug, Default)]
struct EntryWork {
    wanted: Vec<Wanted>,
    /// Test units that look at it.
    tests: Vec<Test>,
    /// What it costs each unit with rows.
    rows: Vec<RowShare>,
}

/// A sub-tile, or a unit with rows, that an entry is for.
#[derive(Debug, Clone, Copy)]
struct Wanted {
    place: usize,
    /// Cycle from which on it is known to have stopped.
    noticed: u64,
    /// Cycles of the pair.
    cycles: u64,
}

/// A test unit that looks at an entry.
#[derive(Debug, Clone, Copy)]
struct Test {
    unit: usize,
    /// Cycle from which on all that it looks at is known to have stopped.
    noticed: u64,
    cycles: u64,
    leaders: u64,
}

/// Units with a queue, one for each sub-tile.
#[derive(Debug, Default)]
struct Queues {
    /// Cycles in which the entries that were pushed leave, by sub-tile.
    leaving: Vec<Vec<u64>>,
    /// Cycle in which the units have done everything that was pushed.
    free: Vec<u64>,
    /// Cycle in which each test unit has handed on what it looked at.
    tested: Vec<u64>,
    /// Cycle in which they have done the last pair before the end of their sub-tile.
    done: Vec<u64>,
    /// The largest of these.
    all_done: u64,
}

impl Queues {
    fn clear(&mut self, subtiles: usize) {
        self.leaving.resize_with(subtiles, Vec::new);
        self.leaving.iter_mut().for_each(Vec::clear);
        for cycles in [&mut self.free, &mut self.done, &mut self.tested] {
            cycles.clear();
            cycles.resize(subtiles, 0);
        }
        self.all_done = 0;
    }

    /// Cycle, `now` at the earliest, in which nothing is in them or on its way to them.
    fn all_free(&self, now: u64) -> u64 {
        self.free.iter().chain(&self.tested).copied().fold(now, u64::max)
    }

    /// A pair that is needed is done.
    fn finish(&mut self, subtile: usize, now: u64) {
        self.done[subtile] = now;
        self.all_done = self.all_done.max(now);
    }

    /// An entry enters the queue of a sub-tile, which is not yet known to have stopped. Returns
    /// whether units work on it before they know.
    fn enter(&mut self, wanted: Wanted, now: u64, run: &mut ChunkRun) -> bool {
        let Wanted { place, noticed, cycles } = wanted;
        let begin = now.max(self.free[place]);
        run.queued += 1;
        if begin >= noticed {
            // It leaves unused.
            self.leaving[place].push(noticed);
            return false;
        }
        let end = begin + cycles;
        self.free[place] = end;
        self.leaving[place].push(end);
        run.pairs += 1;
        // A stop is counted from the last pair that was needed: later ones must not put it off.
        if noticed == NEVER {
            self.finish(place, end);
        } else {
            run.vain += 1;
        }
        true
    }

    /// Cycle in which the queue of a sub-tile has room for one more.
    fn room(&self, subtile: usize, depth: u32) -> u64 {
        // Queues are first in, first out: there is room when the entry `depth` places ahead has
        // left.
        let leaving = &self.leaving[subtile];
        leaving.len().checked_sub(depth as usize).map_or(0, |first| leaving[first])
    }
}

/// One tile.
struct Tile<'a> {
    discipline: &'a Discipline,
    chunks: &'a [ChunkWork],
    bitmaps: &'a [u8],
    /// Bytes of a bitmap.
    bytes: usize,
    /// List positions at which the quads of each sub-tile have no, one, two, three live pixels.
    stops: &'a [[u32; 4]],
    /// Sub-tiles with pixels inside the image.
    inside: Vec<usize>,
    /// List position from which on nothing of each sub-tile, or unit with rows, is needed.
    ends: Vec<u32>,
    /// Sub-tiles along a side, and pixels along a side of one.
    side: u32,
    pixels: u32,
    /// Its pixels, where they are looked at one by one.
    lanes: Option<LaneMap<'a>>,
}

/// When sub-tiles are known to have stopped.
const NEVER: u64 = u64::MAX;

impl<'a> Tile<'a> {
    fn new(workload: &'a FrameWorkload, discipline: &'a Discipline, tile: usize) -> Tile<'a> {
        let geometry = workload.geometry;
        let bytes = geometry.bitmap_bytes();
        let work = &workload.tiles[tile];
        let stops = workload.stops_of(tile);
        let last = stops.iter().map(|stops| stops[0]).max().unwrap_or(0);
        let end = |stops: &[u32; 4]| if discipline.stops_with_tile { last } else { stops[0] };
        // All rows of a tile stop together (A129).
        let ends = match discipline.way {
            SubtileWay::Rows { units, .. } => vec![last; units as usize],
            _ => stops.iter().map(end).collect(),
        };
        let lanes = discipline.counts_pixels().then(|| LaneMap::new(workload, tile));
        let bitmaps = match discipline.skips {
            true => &workload.bitmaps[work.list_start as usize * bytes..],
            false => &[],
        };
        Tile {
            discipline,
            chunks: workload.chunks_of(work),
            bitmaps,
            bytes,
            stops,
            inside: workload.subtiles_inside(tile).collect(),
            ends,
            side: geometry.subtiles_per_side(),
            pixels: geometry.subtile,
            lanes,
        }
    }

    /// Puts the sub-tiles that the entry at list position `at` is for into `wanted`, ascending.
    fn want(&self, at: u32, own: &Queues, wanted: &mut Vec<Wanted>) {
        wanted.clear();
        let mut want = |place| {
            let (noticed, cycles) = (self.noticed(place, at, own), self.pair(place, at));
            wanted.push(Wanted { place, noticed, cycles });
        };
        if !self.discipline.skips {
            return self.inside.iter().for_each(|&subtile| want(subtile));
        }
        let bitmap = &self.bitmaps[at as usize * self.bytes..][..self.bytes];
        for (byte, &bits) in bitmap.iter().enumerate() {
            let mut bits = bits;
            while bits != 0 {
                want(8 * byte + bits.trailing_zeros() as usize);
                bits &= bits - 1;
            }
        }
    }

    fn wants(&self, at: u32, subtile: usize) -> bool {
        let byte = || self.bitmaps[at as usize * self.bytes + subtile / 8];
        !self.discipline.skips || byte() >> (subtile % 8) & 1 == 1
    }

    /// Cycle from which on no pair of a sub-tile at list position `at` begins.
    fn noticed(&self, subtile: usize, at: u32, own: &Queues) -> u64 {
        let end = self.ends[subtile];
        if at < end {
            return NEVER;
        }
        let last = match self.discipline.stops_with_tile {
            true => own.all_done,
            false => own.done[subtile],
        };
        // Where no pixel ever wants anything there is no stop to notice.
        if end == 0 { 0 } else { last + self.discipline.stop_latency }
    }

    fn pair(&self, subtile: usize, at: u32) -> u64 {
        self.discipline.pair(&self.stops[subtile], at)
    }

    /// The chunks with the list position at which each begins.
    fn positions(&self) -> impl Iterator<Item = (u32, &'a ChunkWork)> {
        let from = |first: &mut u32, chunk: &'a ChunkWork| {
            let at = *first;
            *first += chunk.entries;
            Some((at, chunk))
        };
        self.chunks.iter().scan(0, from)
    }

    fn interleaved(&self, swap: u64, scratch: &mut Scratch) -> Vec<ChunkRun> {
        let Scratch { work: EntryWork { wanted, .. }, queues: [own, _] } = scratch;
        own.clear(self.stops.len());
        let (mut now, mut held) = (0, None);
        let chunk = |(first, chunk): (u32, &ChunkWork)| {
            let start = now;
            let mut run = ChunkRun { reads: u64::from(chunk.entries), ..ChunkRun::default() };
            for at in first..first + chunk.entries {
                self.want(at, own, wanted);
                // The sub-tile whose pixels the units hold comes first.
                if let Some(place) = wanted.iter().position(|w| Some(w.place) == held) {
                    wanted[..=place].rotate_right(1);
                }
                for &Wanted { place: subtile, noticed, mut cycles } in &*wanted {
                    if now >= noticed {
                        continue;
                    }
                    if held.is_some_and(|s| s != subtile) {
                        run.switches += 1;
                        cycles = cycles.max(swap);
                    }
                    held = Some(subtile);
                    now += cycles;
                    run.pairs += 1;
                    if noticed == NEVER {
                        own.finish(subtile, now);
                    } else {
                        run.vain += 1;
                    }
                }
            }
            // An entry takes a cycle to leave the buffer, even if all of its sub-tiles have stopped
            // (A26).
            run.cycles = (now - start).max(run.reads);
            ChunkRun { alone: run.cycles, ..run }
        };
        self.positions().map(chunk).collect()
    }

    fn scanned(&self, swap: u64, depth: u32, scratch: &mut Scratch) -> Vec<ChunkRun> {
        let Scratch { queues: [own, _], .. } = scratch;
        own.clear(self.stops.len());
        let (mut now, mut held) = (0, None);
        let chunk = |(first, chunk): (u32, &ChunkWork)| {
            let start = now;
            let mut run = ChunkRun::default();
            for &subtile in &self.inside {
                if now >= self.noticed(subtile, first, own) {
                    continue;
                }
                let is_switch = held.is_some_and(|s| s != subtile);
                held = Some(subtile);
                // The pass before ended with the units: the queue is empty, and they are free from
                // now on.
                own.leaving[subtile].clear();
                own.free[subtile] = now;
                let mut end = now;
                for at in first..first + chunk.entries {
                    match self.push(own, subtile, at, end, depth, &mut run) {
                        Some(pushed) => end = pushed + 1,
                        None => break,
                    }
                    run.reads += 1;
                }
                end = end.max(own.free[subtile]);
                // The change of state is hidden as far as the pass is as long (A87).
                run.switches += u64::from(is_switch);
                now = if is_switch { end.max(now + swap) } else { end };
            }
            run.cycles = (now - start).max(u64::from(chunk.entries));
            ChunkRun { alone: run.cycles, ..run }
        };
        self.positions().map(chunk).collect()
    }

    /// A scan looks at the entry at list position `at`, in cycle `now` at the earliest; returns
    /// the cycle in which it does, and `None` when the sub-tile is known to have stopped.
    fn push(
        &self,
        own: &mut Queues,
        subtile: usize,
        at: u32,
        now: u64,
        depth: u32,
        run: &mut ChunkRun,
    ) -> Option<u64> {
        let noticed = self.noticed(subtile, at, own);
        let wants = self.wants(at, subtile);
        let pushed = if wants { now.max(own.room(subtile, depth)) } else { now };
        if pushed >= noticed {
            return None;
        }
        if wants {
            let wanted = Wanted { place: subtile, noticed, cycles: self.pair(subtile, at) };
            own.enter(wanted, pushed, run);
        }
        Some(pushed)
    }

    fn parallel(&self, depth: u32, scratch: &mut Scratch) -> Vec<ChunkRun> {
        let Scratch { work, queues: [own, fresh] } = scratch;
        own.clear(self.ends.len());
        let last = self.chunks.len().saturating_sub(1);
        let mut now = 0;
        let chunk = |(k, (first, chunk)): (usize, (u32, &ChunkWork))| {
            let mut run = ChunkRun { reads: u64::from(chunk.entries), ..ChunkRun::default() };
            let start = now;
            let range = first..first + chunk.entries;
            now = self.stream(range.clone(), now, depth, own, work, &mut run, 0);
            // Only the end of the tile waits for the units: behind other chunks queues run on
            // (A85).
            if k == last {
                now = own.all_free(now);
            }
            run.cycles = now - start;
            run.alone = run.cycles;
            // The first chunk of a tile finds empty queues anyhow.
            if first > 0 {
                fresh.clear(self.ends.len());
                let mut other = ChunkRun::default();
                let end = self.stream(range, 0, depth, fresh, work, &mut other, first);
                let alone = match k == last {
                    true => fresh.all_free(end),
                    false => end,
                };
                run.alone = alone.min(run.cycles);
            }
            run
        };
        self.positions().enumerate().map(chunk).collect()
    }

    /// Pushes the entries of a chunk, one a cycle at most, each when all of its queues have room.
    /// Sub-tiles that ended before list position `known` are known to have. Returns the cycle
    /// behind the last entry.
    fn stream(
        &self,
        entries: std::ops::Range<u32>,
        mut now: u64,
        depth: u32,
        own: &mut Queues,
        work: &mut EntryWork,
        run: &mut ChunkRun,
        known: u32,
    ) -> u64 {
        for at in entries {
            let pushed = match (self.discipline.way, &self.lanes) {
                (SubtileWay::Tested { leaders, .. }, Some(lanes)) => {
                    self.look(at, (lanes, leaders), own, work, known);
                    self.hand_on(at, now, depth, own, (lanes, work), run)
                }
                (SubtileWay::Rows { .. }, Some(lanes)) => {
                    self.want_rows(at, lanes, own, work, known);
                    self.hand_out(now, depth, own, work, run)
                }
                _ => {
                    self.want(at, own, &mut work.wanted);
                    work.wanted.retain(|wanted| self.ends[wanted.place] > known);
                    self.hand_out(now, depth, own, work, run)
                }
            };
            now = pushed + 1;
        }
        now
    }

    /// An entry leaves for its test units when all of them are free, and is handed on by each when
    /// the queues behind it have room; returns when it leaves.
    fn hand_on(
        &self,
        at: u32,
        now: u64,
        depth: u32,
        own: &mut Queues,
        (lanes, work): (&LaneMap<'_>, &EntryWork),
        run: &mut ChunkRun,
    ) -> u64 {
        // A test unit all of whose mini-tiles are known to have stopped is not waited for.
        let free = |test: &Test| own.tested[test.unit].min(test.noticed);
        let start = work.tests.iter().map(free).fold(now, u64::max);
        for test in work.tests.iter().filter(|test| start < test.noticed) {
            run.front += test.leaders;
            let behind = work.wanted.iter().filter(|w| self.test_unit(w.place) == test.unit);
            let room = |wanted: &Wanted| own.room(wanted.place, depth).min(wanted.noticed);
            let pushed = behind.clone().map(room).fold(start + test.cycles, u64::max);
            // The unit halts until every queue behind it has room, and tests nothing meanwhile
            // (A128).
            own.tested[test.unit] = pushed;
            for wanted in behind.filter(|wanted| pushed < wanted.noticed) {
                if own.enter(*wanted, pushed, run) {
                    run.add(lanes.square_at(self.corner(wanted.place, lanes), self.pixels, at));
                }
            }
        }
        start
    }

    /// The test unit of a mini-tile.
    fn test_unit(&self, place: usize) -> usize {
        let (x, y) = (place as u32 % self.side, place as u32 / self.side);
        (y / TESTED_SIDE * self.side.div_ceil(TESTED_SIDE) + x / TESTED_SIDE) as usize
    }

    /// The first pixel of a sub-tile.
    fn corner(&self, place: usize, lanes: &LaneMap<'_>) -> [u32; 2] {
        let (x, y) = (place as u32 % self.side, place as u32 / self.side);
        [lanes.area.0 + x * self.pixels, lanes.area.1 + y * self.pixels]
    }

    /// An entry enters all of its queues when each has room; returns when.
    fn hand_out(
        &self,
        now: u64,
        depth: u32,
        own: &mut Queues,
        work: &EntryWork,
        run: &mut ChunkRun,
    ) -> u64 {
        // The full queue of a sub-tile that is known to have stopped holds up no entry.
        let room = |wanted: &Wanted| own.room(wanted.place, depth).min(wanted.noticed);
        let pushed = work.wanted.iter().map(room).fold(now, u64::max);
        for wanted in work.wanted.iter().filter(|wanted| pushed < wanted.noticed) {
            let is_done = own.enter(*wanted, pushed, run);
            if let (true, Some(share)) = (is_done, work.rows.get(wanted.place)) {
                run.add(share.reach);
                run.front += share.rows;
            }
        }
        pushed
    }

    /// The units whose rows an entry reaches.
    fn want_rows(
        &self,
        at: u32,
        lanes: &LaneMap<'_>,
        own: &Queues,
        work: &mut EntryWork,
        known: u32,
    ) {
        work.rows.clear();
        work.rows.resize(self.ends.len(), RowShare::default());
        lanes.rows(at, &mut work.rows);
        work.wanted.clear();
        for (place, share) in work.rows.iter().enumerate() {
            if share.rows > 0 && self.ends[place] > known {
                let cycles = share.cycles.max(self.discipline.recurrence);
                work.wanted.push(Wanted { place, noticed: self.noticed(place, at, own), cycles });
            }
        }
    }

    /// The test units that look at an entry: those of which it meets a mini-tile that is not known
    /// to have stopped; and the mini-tiles that pass, unit by unit.
    fn look(
        &self,
        at: u32,
        (lanes, leaders): (&LaneMap<'_>, Leaders),
        own: &Queues,
        work: &mut EntryWork,
        known: u32,
    ) {
        self.want(at, own, &mut work.wanted);
        work.wanted.retain(|wanted| self.ends[wanted.place] > known);
        let leaders = leaders.test(lanes.splat(at));
        work.tests.clear();
        for &Wanted { place, noticed, .. } in &work.wanted {
            let unit = self.test_unit(place);
            match work.tests.iter_mut().find(|test| test.unit == unit) {
                Some(test) => test.noticed = test.noticed.max(noticed),
                None => {
                    let (cycles, leaders) = (leaders.cycles, leaders.leaders);
                    work.tests.push(Test { unit, noticed, cycles, leaders });
                }
            }
        }
        // All mini-tiles of a test unit are looked at, whichever of them a box met.
        work.wanted.clear();
        for &place in self.inside.iter().filter(|&&place| self.ends[place] > known) {
            let is_asked = work.tests.iter().any(|test| test.unit == self.test_unit(place));
            if is_asked && leaders.passes(self.corner(place, lanes), self.pixels) {
                let (noticed, cycles) = (self.noticed(place, at, own), self.pair(place, at));
                work.wanted.push(Wanted { place, noticed, cycles });
            }
        }
    }

    fn together(&self, units: &TogetherUnits) -> Vec<ChunkRun> {
        let Some(tile) = &self.lanes else { return Vec::new() };
        let end = self.ends.iter().copied().max().unwrap_or(0);
        tile.together(self.chunks, units, (end, self.discipline.stop_latency))
    }
}
