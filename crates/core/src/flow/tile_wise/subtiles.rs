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
    skips: bool,
    stops_with_tile: bool,
    stop_latency: u64,
}

/// Some hundred kilobytes each.
impl MemoKey for Discipline {
    type Value = Vec<ChunkRun>;
    const MOST: usize = 32;
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
}

impl Discipline {
    /// The discipline of a machine with `subtiles` sub-tiles of `pixels` pixels in a tile, whose
    /// pixel state changes in `swap` cycles; `None` where counters of chunks say everything.
    pub(super) fn of(spec: &VruSpec, subtiles: u32, pixels: u32, swap: u64) -> Option<Discipline> {
        if spec.implementation == VruImpl::Serial && spec.stop_latency == 0 {
            return None;
        }
        let depth = spec.subtile_queue;
        let way = match spec.implementation {
            VruImpl::Parallel => SubtileWay::Parallel { depth },
            VruImpl::Serial => SubtileWay::Interleaved { swap: 0 },
            VruImpl::Swap => SubtileWay::Interleaved { swap },
            VruImpl::Scan => SubtileWay::Scanned { swap, depth },
        };
        Some(Discipline {
            way,
            rounds: rounds(spec, subtiles, pixels),
            round: u64::from(spec.pixels_per_unit.max(spec.recurrence)),
            live_round: (spec.termination == Termination::Pixel)
                .then_some(u64::from(spec.recurrence)),
            skips: spec.subtile_skipping,
            stops_with_tile: spec.termination == Termination::Tile,
            stop_latency: u64::from(spec.stop_latency),
        })
    }

    /// Cycles of the pair of an entry at list position `at` and a sub-tile.
    fn pair(&self, stops: &[u32; 4], at: u32) -> u64 {
        match self.live_round {
            None => self.rounds * self.round,
            Some(least) => {
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
        VruImpl::Serial | VruImpl::Swap | VruImpl::Scan => spec.units_per_core,
        VruImpl::Parallel => (spec.units_per_core / subtiles.max(1)).max(1),
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
                SubtileWay::Parallel { depth } => tile.parallel(depth, scratch),
            }
        })
        .collect();
    tiles.into_iter().flatten().collect()
}

/// Memory that is used again for each tile.
#[derive(Debug, Default)]
struct Scratch {
    /// Sub-tiles of an entry, and the cycles from which on they are known to have stopped.
    wanted: Vec<(usize, u64)>,
    /// Where queues are, chunk behind chunk and each chunk alone.
    queues: [Queues; 2],
}

/// Units with a queue, one for each sub-tile.
#[derive(Debug, Default)]
struct Queues {
    /// Cycles in which the entries that were pushed leave, by sub-tile.
    leaving: Vec<Vec<u64>>,
    /// Cycle in which the units have done everything that was pushed.
    free: Vec<u64>,
    /// Cycle in which they have done the last pair before the end of their sub-tile.
    done: Vec<u64>,
    /// The largest of these.
    all_done: u64,
}

impl Queues {
    fn clear(&mut self, subtiles: usize) {
        self.leaving.resize_with(subtiles, Vec::new);
        self.leaving.iter_mut().for_each(Vec::clear);
        for cycles in [&mut self.free, &mut self.done] {
            cycles.clear();
            cycles.resize(subtiles, 0);
        }
        self.all_done = 0;
    }

    /// A pair that is needed is done.
    fn finish(&mut self, subtile: usize, now: u64) {
        self.done[subtile] = now;
        self.all_done = self.all_done.max(now);
    }

    /// Cycle in which the queue of a sub-tile has room for one more.
    fn room(&self, subtile: usize, depth: u32) -> u64 {
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
    /// List position from which on nothing of each sub-tile is needed.
    ends: Vec<u32>,
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
            ends: stops.iter().map(end).collect(),
        }
    }

    /// Puts the sub-tiles that the entry at list position `at` is for into `wanted`, ascending.
    fn want(&self, at: u32, own: &Queues, wanted: &mut Vec<(usize, u64)>) {
        wanted.clear();
        let mut want = |subtile| wanted.push((subtile, self.noticed(subtile, at, own)));
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
        let Scratch { wanted, queues: [own, _] } = scratch;
        own.clear(self.stops.len());
        let (mut now, mut held) = (0, None);
        let chunk = |(first, chunk): (u32, &ChunkWork)| {
            let start = now;
            let mut run = ChunkRun { reads: u64::from(chunk.entries), ..ChunkRun::default() };
            for at in first..first + chunk.entries {
                self.want(at, own, wanted);
                // The sub-tile whose pixels the units hold comes first.
                if let Some(place) = wanted.iter().position(|&(s, _)| Some(s) == held) {
                    wanted[..=place].rotate_right(1);
                }
                for &(subtile, noticed) in &*wanted {
                    if now >= noticed {
                        continue;
                    }
                    let mut cycles = self.pair(subtile, at);
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
            self.enter(own, (subtile, noticed), at, pushed, run);
        }
        Some(pushed)
    }

    /// An entry enters the queue of a sub-tile, which is not yet known to have stopped.
    fn enter(
        &self,
        own: &mut Queues,
        (subtile, noticed): (usize, u64),
        at: u32,
        now: u64,
        run: &mut ChunkRun,
    ) {
        let begin = now.max(own.free[subtile]);
        run.queued += 1;
        if begin >= noticed {
            // It leaves unused.
            own.leaving[subtile].push(noticed);
            return;
        }
        let end = begin + self.pair(subtile, at);
        own.free[subtile] = end;
        own.leaving[subtile].push(end);
        run.pairs += 1;
        if noticed == NEVER {
            own.finish(subtile, end);
        } else {
            run.vain += 1;
        }
    }

    fn parallel(&self, depth: u32, scratch: &mut Scratch) -> Vec<ChunkRun> {
        let Scratch { wanted, queues: [own, fresh] } = scratch;
        own.clear(self.stops.len());
        let last = self.chunks.len().saturating_sub(1);
        let mut now = 0;
        let chunk = |(k, (first, chunk)): (usize, (u32, &ChunkWork))| {
            let mut run = ChunkRun { reads: u64::from(chunk.entries), ..ChunkRun::default() };
            let start = now;
            let range = first..first + chunk.entries;
            now = self.stream(range.clone(), now, depth, own, wanted, &mut run, 0);
            if k == last {
                now = own.free.iter().copied().fold(now, u64::max);
            }
            run.cycles = now - start;
            run.alone = run.cycles;
            if first > 0 {
                fresh.clear(self.stops.len());
                let mut other = ChunkRun::default();
                let end = self.stream(range, 0, depth, fresh, wanted, &mut other, first);
                let alone = match k == last {
                    true => fresh.free.iter().copied().fold(end, u64::max),
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
        wanted: &mut Vec<(usize, u64)>,
        run: &mut ChunkRun,
        known: u32,
    ) -> u64 {
        for at in entries {
            self.want(at, own, wanted);
            let mut pushed = now;
            for &(subtile, noticed) in &*wanted {
                if self.ends[subtile] > known {
                    pushed = pushed.max(own.room(subtile, depth).min(noticed));
                }
            }
            for &(subtile, noticed) in &*wanted {
                if self.ends[subtile] > known && pushed < noticed {
                    self.enter(own, (subtile, noticed), at, pushed, run);
                }
            }
            now = pushed + 1;
        }
        now
    }
}
