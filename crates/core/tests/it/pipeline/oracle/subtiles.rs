//! Units and sub-tiles, counting down: A26, A37 and A84 to A88 of `docs/model-accel.md`, cycle by
//! cycle.

use std::collections::VecDeque;
use std::ops::Range;

use powergs_core::flow::tile_wise::ResolvedUnits;
use powergs_core::flow::tile_wise::subtiles::ChunkRun;
use powergs_core::flow::tile_wise::{Termination, VruImpl};
use powergs_core::workload::FrameWorkload;

/// A tile on the units of a core.
pub struct Tile<'a> {
    design: &'a ResolvedUnits,
    /// Entries for each sub-tile, by list position.
    wanted: Vec<Vec<bool>>,
    stops: &'a [[u32; 4]],
    /// List positions of the chunks.
    chunks: Vec<Range<u32>>,
    /// Cycles of a change of state.
    swap: u64,
}

/// The units of a sub-tile, or of the core, and the queue in front of them.
#[derive(Default)]
struct Units {
    /// Entries with the one that is worked on.
    queue: VecDeque<u32>,
    /// What is left of the first of them.
    left: u64,
    is_working: bool,
    /// Pairs that are needed and not done.
    to_do: usize,
    /// Cycle in which the last needed one was done.
    done: u64,
}

pub fn runs(workload: &FrameWorkload, design: &ResolvedUnits, tile: usize) -> Vec<ChunkRun> {
    let tile = Tile::new(workload, design, tile);
    match design.vru.spec.implementation {
        VruImpl::Parallel => tile.parallel(),
        VruImpl::Scan => tile.scan(),
        VruImpl::Serial | VruImpl::Swap => tile.one_by_one(),
        way => unreachable!("{way:?} has a stepper of its own"),
    }
}

impl<'a> Tile<'a> {
    pub fn new(workload: &'a FrameWorkload, design: &'a ResolvedUnits, tile: usize) -> Tile<'a> {
        let (g, work) = (workload.geometry, &workload.tiles[tile]);
        let (side, bytes) = (g.tile / g.subtile, (g.tile / g.subtile).pow(2).div_ceil(8));
        let corner = |s: u32| {
            let (tx, ty) = (tile as u32 % workload.tiles_x, tile as u32 / workload.tiles_x);
            (tx * g.tile + s % side * g.subtile, ty * g.tile + s / side * g.subtile)
        };
        let wanted = (0..side * side).map(|s| {
            let (x, y) = corner(s);
            let is_inside = x < workload.width && y < workload.height;
            let of = |e: u32| {
                let byte = workload.bitmaps[((work.list_start + e) * bytes + s / 8) as usize];
                let bit = byte & (1 << (s % 8)) != 0;
                if design.vru.spec.subtile_skipping { bit } else { is_inside }
            };
            (0..work.loaded).map(of).collect()
        });
        let (mut chunks, mut first) = (Vec::new(), 0);
        for chunk in workload.chunks_of(work) {
            chunks.push(first..first + chunk.entries);
            first += chunk.entries;
        }
        let wanted = wanted.collect();
        // Words of the state of a sub-tile, written and read, through all banks of a core.
        let vru = &design.vru;
        let swap = match vru.spec.implementation {
            VruImpl::Serial | VruImpl::Parallel => 0,
            _ => vru.pixels.excess(vru.swapped, vru.swapped, 0),
        };
        Tile { design, wanted, stops: workload.stops_of(tile), chunks, swap }
    }

    fn stops_together(&self) -> bool {
        self.design.vru.spec.termination == Termination::Tile
    }

    /// Whether a sub-tile has a use for an entry.
    fn is_needed(&self, s: usize, entry: u32) -> bool {
        match self.stops_together() {
            true => self.stops.iter().any(|stops| stops[0] > entry),
            false => self.stops[s][0] > entry,
        }
    }

    fn pair(&self, s: usize, entry: u32) -> u64 {
        let spec = &self.design.vru.spec;
        let units = match spec.implementation {
            VruImpl::Serial | VruImpl::Swap | VruImpl::Scan => spec.units_per_core,
            _ => spec.units_per_core / self.stops.len() as u32,
        };
        let pixels = self.design.vru.subtile * self.design.vru.subtile;
        let mut rounds = 0;
        while rounds * u64::from(units * spec.pixels_per_unit) < u64::from(pixels) {
            rounds += 1;
        }
        let live = self.stops[s].iter().filter(|&&stop| stop > entry).count() as u32;
        let slots = match spec.termination {
            Termination::Pixel => live,
            _ => spec.pixels_per_unit,
        };
        rounds * u64::from(slots.max(spec.recurrence))
    }

    fn units(&self, entries: Range<u32>) -> Vec<Units> {
        let to_do = |s: usize| {
            let is_due = |&e: &u32| self.wanted[s][e as usize] && self.is_needed(s, e);
            entries.clone().filter(is_due).count()
        };
        (0..self.stops.len()).map(|s| Units { to_do: to_do(s), ..Units::default() }).collect()
    }

    /// Whether a sub-tile is known to have stopped before `entry`, in cycle `now`.
    fn is_over(&self, s: usize, entry: u32, all: &[Units], now: u64) -> bool {
        if self.is_needed(s, entry) {
            return false;
        }
        if !self.is_needed(s, 0) {
            return true;
        }
        let of = |units: &Units| {
            let later = u64::from(self.design.vru.spec.stop_latency);
            units.to_do == 0 && now >= units.done + later
        };
        if self.stops_together() { all.iter().all(of) } else { of(&all[s]) }
    }

    /// Ends what has been counted down, and drops what is known to be in vain.
    fn begin_cycle(&self, all: &mut [Units], now: u64) {
        for (s, units) in all.iter_mut().enumerate() {
            if units.is_working && units.left == 0 {
                units.is_working = false;
                let entry = units.queue.pop_front().expect("it was worked on");
                if self.is_needed(s, entry) {
                    units.to_do -= 1;
                    units.done = now;
                }
            }
        }
        for s in 0..all.len() {
            let kept = usize::from(all[s].is_working);
            while let Some(&last) = all[s].queue.back()
                && all[s].queue.len() > kept
                && self.is_over(s, last, all, now)
            {
                all[s].queue.pop_back();
            }
        }
    }

    /// Units take what is in front of them, and a cycle passes. Pairs count for the chunk of their
    /// entry: in vain, where it is not needed.
    fn end_cycle(&self, all: &mut [Units], runs: &mut [ChunkRun]) {
        for (s, units) in all.iter_mut().enumerate() {
            if let (false, Some(&entry)) = (units.is_working, units.queue.front()) {
                units.is_working = true;
                units.left = self.pair(s, entry);
                let chunk = self.chunks.iter().position(|chunk| chunk.contains(&entry));
                let run = &mut runs[chunk.expect("entries are in chunks")];
                run.pairs += 1;
                run.vain += u64::from(!self.is_needed(s, entry));
            }
            units.left = units.left.saturating_sub(1);
        }
    }

    /// Streams chunks, each so many cycles after the last entry of the one before: what each takes,
    /// the cycles in which each begins and in which the last entry has left, and the cycle in which
    /// all units are done.
    fn stream(&self, chunks: Range<usize>, gaps: &[u64]) -> (Vec<ChunkRun>, Vec<u64>, u64) {
        let (start, end) = (self.chunks[chunks.start].start, self.chunks[chunks.end - 1].end);
        let mut all = self.units(start..end);
        // Nobody waits for what ended before.
        let gone: Vec<bool> =
            (0..all.len()).map(|s| start > 0 && !self.is_needed(s, start)).collect();
        let depth = self.design.vru.spec.subtile_queue as usize;
        let (mut now, mut entry, mut chunk) = (0, start, chunks.start);
        let (mut begins, mut ready) = (vec![0], 0);
        let mut runs = vec![ChunkRun::default(); self.chunks.len()];
        loop {
            self.begin_cycle(&mut all, now);
            if entry == end && all.iter().all(|units| units.queue.is_empty()) {
                return (runs, begins, now);
            }
            if entry < end && now >= ready {
                let targets: Vec<usize> = (0..all.len())
                    .filter(|&s| self.wanted[s][entry as usize] && !gone[s])
                    .filter(|&s| !self.is_over(s, entry, &all, now))
                    .collect();
                if targets.iter().all(|&s| all[s].queue.len() < depth) {
                    targets.iter().for_each(|&s| all[s].queue.push_back(entry));
                    runs[chunk].queued += targets.len() as u64;
                    runs[chunk].reads += 1;
                    entry += 1;
                    if self.chunks[chunk].end == entry {
                        begins.push(now + 1);
                        chunk += 1;
                        ready = now + 1 + gaps.get(chunk).unwrap_or(&0);
                    }
                }
            }
            self.end_cycle(&mut all, &mut runs);
            now += 1;
        }
    }

    fn parallel(&self) -> Vec<ChunkRun> {
        let n = self.chunks.len();
        if n == 0 {
            return Vec::new();
        }
        let (runs, begins, end) = self.stream(0..n, &[]);
        let of = |(k, run): (usize, ChunkRun)| {
            let is_last = k + 1 == n;
            let (_, own, own_end) = self.stream(k..k + 1, &[]);
            let cycles = if is_last { end } else { begins[k + 1] } - begins[k];
            // Empty queues never count as a loss.
            let alone = cycles.min(if is_last { own_end } else { own[1] });
            ChunkRun { cycles, alone, ..run }
        };
        runs.into_iter().enumerate().map(of).collect()
    }

    /// Cycles from the first to the last entry of each chunk (to the end of all, for the last one),
    /// where chunk k comes `gaps[k]` cycles after the last entry of the one before.
    pub fn with_gaps(&self, gaps: &[u64]) -> Vec<u64> {
        let n = self.chunks.len();
        let (_, begins, end) = self.stream(0..n, gaps);
        let last = |k: usize| if k + 1 == n { end } else { begins[k + 1] };
        (0..n).map(|k| last(k) - begins[k] - if k > 0 { gaps[k] } else { 0 }).collect()
    }

    fn one_by_one(&self) -> Vec<ChunkRun> {
        let last = self.chunks.last().map_or(0, |chunk| chunk.end);
        let mut all = self.units(0..last);
        let (mut now, mut here) = (0, None);
        let chunk = |entries: &Range<u32>| {
            let (start, mut run) = (now, ChunkRun::default());
            for entry in entries.clone() {
                run.reads += 1;
                let mut order: Vec<usize> = (0..all.len()).collect();
                order.sort_by_key(|&s| Some(s) != here);
                for s in order.into_iter().filter(|&s| self.wanted[s][entry as usize]) {
                    if self.is_over(s, entry, &all, now) {
                        continue;
                    }
                    let mut left = self.pair(s, entry);
                    if here.is_some() && here != Some(s) {
                        run.switches += 1;
                        left = left.max(self.swap);
                    }
                    here = Some(s);
                    while left > 0 {
                        (left, now) = (left - 1, now + 1);
                    }
                    run.pairs += 1;
                    match self.is_needed(s, entry) {
                        true => {
                            all[s].to_do -= 1;
                            all[s].done = now;
                        }
                        false => run.vain += 1,
                    }
                }
            }
            run.cycles = (now - start).max(u64::from(entries.end - entries.start));
            ChunkRun { alone: run.cycles, ..run }
        };
        self.chunks.iter().map(chunk).collect()
    }

    fn scan(&self) -> Vec<ChunkRun> {
        let last = self.chunks.last().map_or(0, |chunk| chunk.end);
        let mut all = self.units(0..last);
        let depth = self.design.vru.spec.subtile_queue as usize;
        let (mut now, mut here) = (0, None);
        let mut runs = Vec::new();
        for chunk in &self.chunks {
            let (start, mut run) = (now, ChunkRun::default());
            let mut executed = vec![ChunkRun::default(); self.chunks.len()];
            for s in 0..all.len() {
                let never =
                    !self.design.vru.spec.subtile_skipping && !self.wanted[s][chunk.start as usize];
                if never || self.is_over(s, chunk.start, &all, now) {
                    continue;
                }
                let mut change = if here.is_some() && here != Some(s) {
                    run.switches += 1;
                    self.swap
                } else {
                    0
                };
                here = Some(s);
                let mut entry = chunk.start;
                loop {
                    self.begin_cycle(&mut all, now);
                    if entry < chunk.end && self.is_over(s, entry, &all, now) {
                        entry = chunk.end;
                    }
                    let is_idle = all[s].queue.is_empty();
                    if entry == chunk.end && is_idle && change == 0 {
                        break;
                    }
                    if entry < chunk.end {
                        let is_wanted = self.wanted[s][entry as usize];
                        if !is_wanted || all[s].queue.len() < depth {
                            if is_wanted {
                                all[s].queue.push_back(entry);
                                run.queued += 1;
                            }
                            run.reads += 1;
                            entry += 1;
                        }
                    }
                    self.end_cycle(&mut all, &mut executed);
                    (now, change) = (now + 1, change.saturating_sub(1));
                }
            }
            run.pairs = executed.iter().map(|run| run.pairs).sum();
            run.vain = executed.iter().map(|run| run.vain).sum();
            run.cycles = (now - start).max(u64::from(chunk.end - chunk.start));
            runs.push(ChunkRun { alone: run.cycles, ..run });
        }
        runs
    }
}
