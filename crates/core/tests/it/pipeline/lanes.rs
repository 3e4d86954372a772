//! Units that do not work on whole sub-tiles: A128 to A131 of `docs/model-accel.md`, pixel by pixel
//! and cycle by cycle, on frames of splats.

use std::collections::VecDeque;

use powergs_core::flow::tile_wise::subtiles::{self, ChunkRun};
use powergs_core::flow::tile_wise::{FoveaSpec, ResolvedUnits, Termination, VruImpl, VruSpec};
use powergs_core::machine::Machine;
use powergs_core::workload::lanes::PixelReach;
use powergs_core::workload::{FrameWorkload, Geometry, bin_for};
use powergs_frame::splat::{Intersection, Splat};

use super::support::{Dice, gscore};
use crate::workload::support::small_frame;

const CASES: u64 = 60;

/// A tile, with what each entry reaches.
struct Tile<'a> {
    workload: &'a FrameWorkload,
    vru: &'a VruSpec,
    tile: usize,
    entries: Vec<Entry>,
}

/// Every pixel of a tile for one entry.
struct Entry {
    splat: Splat,
    /// Pixels of its ellipse, and those that still want it.
    reached: Vec<[u32; 2]>,
    live: Vec<[u32; 2]>,
    /// Sub-tiles of its list entry.
    boxed: Vec<usize>,
}

/// With the margin of the rasteriser's ellipse.
fn level(splat: &Splat) -> (f64, [f64; 3]) {
    let [c0, c1, c2] = splat.conic().expect("a proper splat").map(f64::from);
    let exact = 2.0 * (255.0 * f64::from(splat.opacity)).ln();
    (exact + 2e-3 + 1e-6 * exact * (c0 * c2 / (c0 * c2 - c1 * c1)).abs(), [c0, c1, c2])
}

fn reaches(splat: &Splat, x: u32, y: u32) -> bool {
    let (level, [c0, c1, c2]) = level(splat);
    let (dx, dy) =
        (f64::from(x) - f64::from(splat.mean[0]), f64::from(y) - f64::from(splat.mean[1]));
    c0 * dx * dx + 2.0 * c1 * dx * dy + c2 * dy * dy <= level
}

fn reaches_row(splat: &Splat, y: u32) -> bool {
    let (level, [c0, c1, c2]) = level(splat);
    let dy = f64::from(y) - f64::from(splat.mean[1]);
    (c2 - c1 * c1 / c0) * dy * dy <= level
}

/// What the chunks of a tile take.
pub fn runs(workload: &FrameWorkload, vru: &VruSpec, tile: usize) -> Vec<ChunkRun> {
    let tile = Tile::new(workload, vru, tile);
    match vru.implementation {
        VruImpl::Leaders | VruImpl::Rows => tile.queued(),
        _ => tile.counted(),
    }
}

impl<'a> Tile<'a> {
    fn new(workload: &'a FrameWorkload, vru: &'a VruSpec, tile: usize) -> Tile<'a> {
        let work = &workload.tiles[tile];
        let pixels = workload.pixels.as_ref().expect("asked for");
        let bytes = workload.geometry.subtiles().div_ceil(8);
        let (x0, y0, x1, y1) = workload.pixels_of(tile);
        let all: Vec<[u32; 2]> = (y0..y1).flat_map(|y| (x0..x1).map(move |x| [x, y])).collect();
        let entry = |at: u32| {
            let rank = workload.list_of(work)[at as usize];
            let splat = pixels.splats[rank as usize];
            let wants =
                |&[x, y]: &[u32; 2]| pixels.iterated[(y * workload.width + x) as usize] > at;
            let bit = |s: usize| {
                let byte = (work.list_start + at) * bytes + s as u32 / 8;
                !vru.subtile_skipping || workload.bitmaps[byte as usize] >> (s % 8) & 1 == 1
            };
            Entry {
                splat,
                reached: all.iter().copied().filter(|&[x, y]| reaches(&splat, x, y)).collect(),
                live: all.iter().copied().filter(wants).collect(),
                boxed: workload.subtiles_inside(tile).filter(|&s| bit(s)).collect(),
            }
        };
        Tile { workload, vru, tile, entries: (0..work.loaded).map(entry).collect() }
    }

    fn chunk_of(&self, entry: usize) -> usize {
        entry / self.workload.geometry.chunk as usize
    }

    /// Where a place is: a sub-tile, or a unit with rows.
    fn is_in(&self, place: usize, [x, y]: [u32; 2]) -> bool {
        let (x0, y0, ..) = self.workload.pixels_of(self.tile);
        let g = self.workload.geometry;
        match self.vru.implementation {
            VruImpl::Rows => (y - y0) % self.vru.units_per_core == place as u32,
            _ => {
                (y - y0) / g.subtile * g.subtiles_per_side() + (x - x0) / g.subtile == place as u32
            }
        }
    }

    fn places(&self) -> usize {
        match self.vru.implementation {
            VruImpl::Rows => self.vru.units_per_core as usize,
            _ => self.workload.geometry.subtiles() as usize,
        }
    }

    fn test_unit(&self, place: usize) -> usize {
        let side = self.workload.geometry.subtiles_per_side() as usize;
        place / side / 2 * side.div_ceil(2) + place % side / 2
    }

    fn is_spiky(&self, entry: usize) -> bool {
        let [a, b, d] = self.entries[entry].splat.cov.map(f64::from);
        let root = ((a - d).powi(2) / 4.0 + b * b).sqrt();
        let (long, short) = ((a + d) / 2.0 + root, (a + d) / 2.0 - root);
        (long / short).sqrt() >= f64::from(self.vru.spiky_from)
    }

    /// Rows of a unit that an entry reaches.
    fn rows(&self, place: usize, entry: usize) -> Vec<u32> {
        let (x0, y0, _, y1) = self.workload.pixels_of(self.tile);
        let own = (y0..y1).filter(|&y| self.is_in(place, [x0, y]));
        own.filter(|&y| reaches_row(&self.entries[entry].splat, y)).collect()
    }

    /// Cycles of an entry at a place, and the pixels; `None` where it is not for it.
    fn cost(&self, place: usize, entry: usize) -> Option<(u64, PixelReach)> {
        let e = &self.entries[entry];
        let (x0, y0, ..) = self.workload.pixels_of(self.tile);
        if self.vru.implementation == VruImpl::Rows {
            let rows = self.rows(place, entry);
            let of =
                |pixels: &[[u32; 2]], y: u32| pixels.iter().filter(|p| p[1] == y).count() as u64;
            let cycles: u64 = rows.iter().map(|&y| of(&e.reached, y).max(1)).sum();
            let both: Vec<[u32; 2]> =
                e.reached.iter().copied().filter(|p| e.live.contains(p)).collect();
            let slots = rows.iter().map(|&y| of(&e.reached, y)).sum();
            let live = rows.iter().map(|&y| of(&both, y)).sum();
            let cycles = cycles.max(self.vru.recurrence.into());
            return (!rows.is_empty()).then_some((cycles, PixelReach { slots, live }));
        }
        let g = self.workload.geometry;
        let (side, n) = (g.subtiles_per_side(), g.subtile);
        let (x, y) = (x0 + place as u32 % side * n, y0 + place as u32 / side * n);
        let corners = [[x, y], [x + n - 1, y + n - 1], [x + n - 1, y], [x, y + n - 1]];
        let leaders = if self.is_spiky(entry) { 2 } else { 4 };
        let passes = corners[..leaders].iter().any(|&[x, y]| reaches(&e.splat, x, y));
        let is_asked = e.boxed.iter().any(|&s| self.test_unit(s) == self.test_unit(place));
        let is_inside = x < self.workload.width && y < self.workload.height;
        let units = u64::from((self.vru.units_per_core / g.subtiles()) * self.vru.pixels_per_unit);
        let cycles = u64::from(n * n).div_ceil(units)
            * u64::from(self.vru.pixels_per_unit.max(self.vru.recurrence));
        let live = e.live.iter().filter(|&&pixel| self.is_in(place, pixel)).count() as u64;
        let reach = PixelReach { slots: (n * n).into(), live };
        (passes && is_asked && is_inside).then_some((cycles, reach))
    }

    /// List position from which on nothing of a place is needed.
    fn end(&self, place: usize) -> u32 {
        let stops = self.workload.stops_of(self.tile);
        match self.vru.implementation == VruImpl::Rows || self.vru.termination == Termination::Tile
        {
            true => stops.iter().map(|stops| stops[0]).max().unwrap_or(0),
            false => stops[place][0],
        }
    }

    fn together(&self) -> bool {
        self.vru.termination != Termination::Subtile
    }

    /// Steps through chunks: cycles in which each begins, and the cycle in which all is done.
    fn step(&self, chunks: std::ops::Range<usize>, found: &mut [ChunkRun]) -> (Vec<u64>, u64) {
        let size = self.workload.geometry.chunk as usize;
        let (start, end) = (chunks.start * size, (chunks.end * size).min(self.entries.len()));
        let depth = self.vru.subtile_queue as usize;
        let mut places: Vec<Place> = (0..self.places())
            .map(|p| Place {
                to_do: (start..end)
                    .filter(|&e| (e as u32) < self.end(p) && self.cost(p, e).is_some())
                    .count(),
                ..Place::default()
            })
            .collect();
        let gone: Vec<bool> =
            (0..places.len()).map(|p| start > 0 && self.end(p) <= start as u32).collect();
        let latency = u64::from(self.vru.stop_latency);
        let is_over = |p: usize, e: usize, all: &[Place], now: u64| {
            let done = |place: &Place| place.to_do == 0 && now >= place.done + latency;
            let known = if self.together() { all.iter().all(done) } else { done(&all[p]) };
            e as u32 >= self.end(p) && (self.end(p) == 0 || known)
        };
        let has_tests = self.vru.implementation == VruImpl::Leaders;
        let mut tests: Vec<Option<(usize, u64)>> = vec![None; self.places()];
        let (mut now, mut entry, mut begins) = (0, start, vec![0]);
        loop {
            for (p, place) in places.iter_mut().enumerate() {
                if place.is_working && place.left == 0 {
                    place.is_working = false;
                    let e = place.queue.pop_front().expect("it was worked on");
                    if (e as u32) < self.end(p) {
                        (place.to_do, place.done) = (place.to_do - 1, now);
                    }
                }
            }
            for p in 0..places.len() {
                let kept = usize::from(places[p].is_working);
                while places[p].queue.len() > kept
                    && is_over(p, *places[p].queue.back().expect("not empty"), &places, now)
                {
                    places[p].queue.pop_back();
                }
            }
            // Test units hand on.
            for (unit, test) in tests.iter_mut().enumerate() {
                let Some((e, 0)) = *test else { continue };
                let targets: Vec<usize> = (0..places.len())
                    .filter(|&p| self.test_unit(p) == unit && !gone[p])
                    .filter(|&p| self.cost(p, e).is_some() && !is_over(p, e, &places, now))
                    .collect();
                if targets.iter().all(|&p| places[p].queue.len() < depth) {
                    *test = None;
                    for p in targets {
                        places[p].queue.push_back(e);
                        found[self.chunk_of(e)].queued += 1;
                    }
                }
            }
            let is_idle = places.iter().all(|place| place.queue.is_empty());
            if entry == end && is_idle && tests.iter().all(Option::is_none) {
                return (begins, now);
            }
            if entry < end {
                let boxed = &self.entries[entry].boxed;
                let mut targets: Vec<usize> = match has_tests {
                    true => boxed.clone(),
                    false => (0..places.len()).filter(|&p| self.cost(p, entry).is_some()).collect(),
                };
                targets.retain(|&p| !gone[p] && !is_over(p, entry, &places, now));
                let leaves = match has_tests {
                    true => targets.iter().all(|&p| tests[self.test_unit(p)].is_none()),
                    false => targets.iter().all(|&p| places[p].queue.len() < depth),
                };
                if leaves {
                    let run = &mut found[self.chunk_of(entry)];
                    run.reads += 1;
                    if has_tests {
                        let mut units: Vec<usize> =
                            targets.iter().map(|&p| self.test_unit(p)).collect();
                        units.sort_unstable();
                        units.dedup();
                        let leaders = if self.is_spiky(entry) { 8u32 } else { 16 };
                        for unit in units {
                            let cycles =
                                u64::from(leaders).div_ceil(self.vru.leaders_per_cycle.into());
                            tests[unit] = Some((entry, cycles));
                            run.front += u64::from(leaders);
                        }
                    } else {
                        for p in targets {
                            places[p].queue.push_back(entry);
                            run.queued += 1;
                        }
                    }
                    entry += 1;
                    if entry % size == 0 || entry == end {
                        begins.push(now + 1);
                    }
                }
            }
            for (p, place) in places.iter_mut().enumerate() {
                if !place.is_working
                    && let Some(&e) = place.queue.front()
                {
                    let (cycles, reach) = self.cost(p, e).expect("it entered");
                    (place.is_working, place.left) = (true, cycles);
                    let run = &mut found[self.chunk_of(e)];
                    run.pairs += 1;
                    run.vain += u64::from(e as u32 >= self.end(p));
                    let all = run.reach.get_or_insert_default();
                    (all.slots, all.live) = (all.slots + reach.slots, all.live + reach.live);
                    if self.vru.implementation == VruImpl::Rows {
                        run.front += self.rows(p, e).len() as u64;
                    }
                }
                place.left = place.left.saturating_sub(1);
            }
            for (_, left) in tests.iter_mut().flatten() {
                *left = left.saturating_sub(1);
            }
            now += 1;
        }
    }

    fn queued(&self) -> Vec<ChunkRun> {
        let n = self.workload.tiles[self.tile].chunks as usize;
        let mut found = vec![ChunkRun::default(); n];
        if n == 0 {
            return found;
        }
        let (begins, end) = self.step(0..n, &mut found);
        for k in 0..n {
            let (own, own_end) = self.step(k..k + 1, &mut vec![ChunkRun::default(); n]);
            let is_last = k + 1 == n;
            let cycles = if is_last { end } else { begins[k + 1] } - begins[k];
            let alone = if is_last { own_end } else { own[1] };
            (found[k].cycles, found[k].alone) = (cycles, cycles.min(alone));
        }
        found
    }

    /// All units on pixels, quads or boxes together.
    fn counted(&self) -> Vec<ChunkRun> {
        let g = self.workload.geometry;
        let (x0, y0, ..) = self.workload.pixels_of(self.tile);
        let lanes = u64::from(self.vru.units_per_core);
        let recurrence = u64::from(self.vru.recurrence);
        // As many entries of one pixel are put together at a time.
        let at_once = match self.vru.implementation {
            VruImpl::Pixels => u64::from(self.vru.entries_per_cycle),
            _ => 1,
        };
        let end = self.end(0);
        let (mut found, mut now, mut all, mut done) = (Vec::new(), 0u64, 0u64, 0u64);
        let entries: Vec<usize> = (0..self.entries.len()).collect();
        for chunk in entries.chunks(g.chunk as usize) {
            let mut run = ChunkRun { reads: chunk.len() as u64, ..ChunkRun::default() };
            let (start, before) = (now, all);
            let mut visits = std::collections::BTreeMap::new();
            for &entry in chunk {
                let e = &self.entries[entry];
                let is_live = |p: &[u32; 2]| e.live.contains(p);
                let quad = |p: &[u32; 2]| [(p[0] - x0) / 2, (p[1] - y0) / 2];
                let is_needed = (entry as u32) < end;
                let reach = match self.vru.implementation {
                    VruImpl::Box => {
                        if !is_needed && now >= done + u64::from(self.vru.stop_latency) {
                            continue;
                        }
                        let r = e.splat.radius();
                        let near =
                            |p: u32, m: f32| (f64::from(p) - f64::from(m)).abs() <= f64::from(r);
                        let inside = |p: &[u32; 2]| {
                            near(p[0], e.splat.mean[0]) && near(p[1], e.splat.mean[1])
                        };
                        let (a, b, c, d) = self.workload.pixels_of(self.tile);
                        let all = (b..d).flat_map(|y| (a..c).map(move |x| [x, y]));
                        let own: Vec<[u32; 2]> = all.filter(inside).collect();
                        let live = own.iter().filter(|p| is_live(p)).count() as u64;
                        PixelReach { slots: own.len() as u64, live }
                    }
                    VruImpl::Pixels => {
                        let own = e.reached.iter().filter(|p| is_live(p));
                        own.clone().for_each(|p| *visits.entry(*p).or_insert(0u64) += 1);
                        PixelReach { slots: own.clone().count() as u64, live: own.count() as u64 }
                    }
                    _ => {
                        let mut quads: Vec<[u32; 2]> = e.reached.iter().map(quad).collect();
                        quads.sort_unstable();
                        quads.dedup();
                        let of =
                            |q: &[u32; 2]| e.live.iter().filter(|p| quad(p) == *q).count() as u64;
                        quads.retain(|q| of(q) > 0);
                        quads.iter().for_each(|q| *visits.entry(*q).or_insert(0) += 1);
                        PixelReach {
                            slots: 4 * quads.len() as u64,
                            live: quads.iter().map(of).sum(),
                        }
                    }
                };
                let sum = run.reach.get_or_insert_default();
                (sum.slots, sum.live) = (sum.slots + reach.slots, sum.live + reach.live);
                all += reach.slots;
                if reach.slots > 0 {
                    run.pairs += 1;
                    run.vain += u64::from(!is_needed);
                    if self.vru.implementation == VruImpl::Box {
                        now += reach.slots.div_ceil(lanes).max(recurrence);
                    }
                }
                if is_needed {
                    done = now;
                }
            }
            if self.vru.implementation != VruImpl::Box {
                let busiest = visits.values().copied().max().unwrap_or(0);
                let lanes = all.div_ceil(lanes) - before.div_ceil(lanes);
                now += lanes.max(busiest.div_ceil(at_once) * recurrence);
            }
            run.cycles = (now - start).max((chunk.len() as u64).div_ceil(at_once));
            found.push(ChunkRun { alone: run.cycles, ..run });
        }
        found
    }
}

#[derive(Default)]
struct Place {
    queue: VecDeque<usize>,
    left: u64,
    is_working: bool,
    to_do: usize,
    done: u64,
}

/// A machine with such units.
fn machine(dice: &mut Dice, way: VruImpl) -> Machine {
    let mut machine = gscore();
    let m = machine.tiles_mut();
    m.fovea = FoveaSpec::default();
    m.geometry = Geometry {
        tile: dice.pick(&[8, 16]),
        chunk: dice.pick(&[5, 16, 64]),
        test: dice.pick(&[Intersection::Aabb, Intersection::Obb]),
        ..Geometry::REFERENCE
    };
    m.geometry.sort_group = m.geometry.tile;
    m.geometry.subtile = if way == VruImpl::Leaders { 4 } else { m.geometry.tile };
    let vru = &mut m.vru;
    (vru.implementation, vru.recurrence) = (way, dice.pick(&[1, 2, 4]));
    vru.termination = way.stops().unwrap_or(dice.pick(&[Termination::Subtile, Termination::Tile]));
    vru.subtile_skipping = dice.roll(0, 4) > 0;
    vru.subtile_queue = dice.pick(&[1, 2, 3, 16]);
    vru.stop_latency = dice.pick(&[0, 1, 18, 60]);
    vru.leaders_per_cycle = dice.pick(&[4, 8, 64]);
    vru.spiky_from = dice.pick(&[1, 2, 3, 65536]);
    vru.pixels_per_unit = dice.pick(&[1, 2, 4]);
    vru.entries_per_cycle = dice.pick(&[1, 1, 3]);
    vru.units_per_core = match way {
        VruImpl::Leaders => m.geometry.subtiles() * dice.pick(&[1, 2]),
        VruImpl::Rows => dice.pick(&[1, 3, 8]),
        _ => dice.pick(&[1, 8, 64]),
    };
    machine
}

#[test]
fn what_entries_reach_takes_what_it_takes_cycle_by_cycle() {
    // Pairs, pairs in vain, leaders or rows, cycles of a backlog.
    let mut seen = [0; 4];
    for seed in 0..CASES {
        let mut dice = Dice::new(seed);
        let ways = [VruImpl::Leaders, VruImpl::Rows, VruImpl::Pixels, VruImpl::Quads, VruImpl::Box];
        let way = ways[seed as usize % ways.len()];
        let machine = machine(&mut dice, way);
        let frame = small_frame(seed);
        let workload = bin_for(&frame, machine.tiles().geometry, machine.tiles().detail());
        let units = ResolvedUnits::new(&machine);
        let found = subtiles::runs(&workload, &units.vru.discipline.expect("a discipline"));
        let stepped: Vec<ChunkRun> = (0..workload.tiles.len())
            .flat_map(|tile| runs(&workload, &machine.tiles().vru, tile))
            .collect();
        assert_eq!(found.len(), workload.chunks.len());
        for (k, (ours, theirs)) in found.iter().zip(&stepped).enumerate() {
            assert_eq!(ours, theirs, "seed {seed} chunk {k} {:#?}", machine.tiles().vru);
        }
        for run in &found {
            let all = [run.pairs, run.vain, run.front, run.cycles - run.alone];
            seen.iter_mut().zip(all).for_each(|(sum, n)| *sum += n);
        }
    }
    assert!(seen.iter().all(|&sum| sum > 100), "{seen:?}");
}

/// Where nothing stops, everything of every list is worked on, and what blends is what reaches.
#[test]
fn without_a_stop_every_entry_reaches_every_pixel() {
    let frame = small_frame(7);
    let mut machine = gscore();
    machine.tiles_mut().fovea = FoveaSpec::default();
    machine.tiles_mut().vru.termination = Termination::None;
    let detail = machine.tiles().detail();
    let whole = bin_for(&frame, machine.tiles().geometry, detail);
    let stopped = bin_for(&frame, machine.tiles().geometry, Default::default());
    assert!(whole.counters.blends > stopped.counters.blends);
    assert_eq!(whole.list, stopped.list);
    for (tile, work) in whole.tiles.iter().enumerate() {
        assert_eq!((work.loaded, work.chunks), (work.entries, work.entries.div_ceil(256)));
        assert_eq!(work.alpha_evaluations, u64::from(work.entries) * u64::from(work.pixels));
        let (x0, y0, x1, y1) = whole.pixels_of(tile);
        let reached = |&rank: &u32| {
            let splat = &frame.splats[rank as usize];
            let pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y)));
            pixels.filter(|&(x, y)| reaches(splat, x, y)).count() as u64
        };
        assert_eq!(work.blends, whole.list_of(work).iter().map(reached).sum::<u64>());
    }
}
