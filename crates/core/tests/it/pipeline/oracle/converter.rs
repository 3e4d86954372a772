//! A CCU, counting down.

use std::ops::Range;

use powergs_core::flow::tile_wise::FrameContext;
use powergs_core::flow::tile_wise::batch::{Batch, Pass};
use powergs_core::flow::tile_wise::ccu::Ccu;
use powergs_core::flow::tile_wise::traffic::pairs_written;
use powergs_core::kernel::Unit;
use powergs_core::workload::FrameWorkload;

use super::{Frame, Memory, digit};
use crate::oracle_memory::Ticket;

/// The reads of a batch.
const READS: [&str; 3] = ["records", "survivors", "colours"];

/// A batch in front of the unit: reads that were issued, the one under way, bytes in the buffer.
struct Held {
    index: usize,
    batch: Batch,
    reads: usize,
    waits_for: Option<Ticket>,
    room: u64,
}

impl Held {
    fn is_complete(&self) -> bool {
        self.reads == 3 && self.waits_for.is_none()
    }

    /// What it may still bring into the buffer, by what it knows: nothing of its records before the
    /// first read is there, then who survives, then who has a tile.
    fn need(&self, ccu: &Ccu) -> u64 {
        self.need_after(ccu, self.reads - usize::from(self.waits_for.is_some()), self.reads)
    }

    /// The same with this many reads known and issued.
    fn need_after(&self, ccu: &Ccu, known: usize, issued: usize) -> u64 {
        let b = &self.batch;
        if b.pass == Pass::Scatter {
            return (issued..3).map(|read| ccu.read(b, read)).sum();
        }
        let (mut survivors, mut splats) = (b.survivors, b.splats);
        if known == 0 {
            survivors = b.records.max(survivors).max(splats);
        }
        if known < 2 {
            splats = survivors.max(splats);
        }
        let guess = Batch { survivors, splats, ..*b };
        (issued..3).map(|read| ccu.read(&guess, read)).sum()
    }
}

/// Results that have left the pipeline: what they wait for before they are written.
enum Leaving {
    /// Bytes of their lists that are read before.
    Back(Ticket),
    Write(Ticket),
}

pub struct Converter {
    held: Vec<Held>,
    entering: Option<(usize, u64, u64)>,
    entering_room: u64,
    pipe: Vec<(u64, usize, u64)>,
    writes: Vec<(Leaving, usize, u64)>,
    input_used: u64,
    output_used: u64,
}

/// What the CCUs do in the passes over the records, batch by batch.
pub struct Work {
    pub batches: Vec<Batch>,
    /// How many of them are of the first pass.
    pub first_pass: usize,
}

impl Work {
    pub fn new(workload: &FrameWorkload, ccu: &Ccu, given: &FrameContext) -> Work {
        let counts = given.lists.is_some_and(|lists| lists.counts_first());
        let passes: &[Pass] = if counts { &[Pass::Count, Pass::Scatter] } else { &[Pass::Whole] };
        let mut work = Work { batches: Vec::new(), first_pass: 0 };
        for &pass in passes {
            work.add_pass(workload, ccu, given, pass);
            if pass == passes[0] {
                work.first_pass = work.batches.len();
            }
        }
        work
    }

    /// Records in storage order, so many at a time. Where they are in clusters, the bound of each
    /// is tested before it (and, with it, those of the next ones), and records of those of which
    /// nobody survives are left out. The second pass knows who survives.
    fn add_pass(&mut self, workload: &FrameWorkload, ccu: &Ccu, given: &FrameContext, pass: Pass) {
        let points = workload.counters.points;
        if points == 0 {
            // Pairs without points cannot be, but would still be written.
            let [survivors, prepared, tests, splats, pairs, lookups] = until(workload, given, 0);
            let lists = given.lists.map(|lists| lists.part(pass == Pass::Count, 0, 0));
            let counts = Batch { survivors, prepared, tests, splats, pairs, ..Batch::default() };
            let orphans = Batch { lookups, pass, lists, ..counts };
            self.batches.extend((pairs > 0).then_some(orphans));
            return;
        }
        // Who survives where may not be known: then there are no bounds.
        let size = match (ccu.spec.clusters, workload.storage.is_empty()) {
            (0, _) | (_, true) => points,
            (size, false) => u64::from(size),
        };
        let clusters: Vec<Range<u64>> =
            (0..points).step_by(size as usize).map(|at| at..(at + size).min(points)).collect();
        let bounded = size != points || ccu.spec.clusters > 0 && !workload.storage.is_empty();
        let survivors = |at: u64| until(workload, given, at)[0];
        let lives = |all: &Range<u64>| !bounded || survivors(all.start) < survivors(all.end);
        let last = clusters.iter().rposition(lives);
        let (mut tested, mut seen) = (0, [0; 6]);
        // As many bytes of bounds at a time as a batch has of positions.
        let at_once = ccu.cluster_tests().max(1) as usize;
        for (i, cluster) in clusters.iter().enumerate() {
            if bounded && pass != Pass::Scatter && i == tested {
                let n = at_once.min(clusters.len() - i);
                let (first, clusters) = (i as u64, n as u64);
                self.batches.push(Batch { first, clusters, pass, ..Batch::default() });
                tested += n;
            }
            if !lives(cluster) {
                continue;
            }
            for from in cluster.clone().step_by(ccu.batch as usize) {
                let to = (from + u64::from(ccu.batch)).min(cluster.end);
                let now = until(workload, given, to);
                // What is left of lists on chip goes out with the last record that is read.
                let behind = if Some(i) == last && to == cluster.end { points } else { to };
                let count = pass == Pass::Count;
                self.batches.push(Batch {
                    clusters: 0,
                    first: from,
                    records: to - from,
                    survivors: now[0] - seen[0],
                    prepared: now[1] - seen[1],
                    tests: now[2] - seen[2],
                    splats: now[3] - seen[3],
                    pairs: now[4] - seen[4],
                    lookups: now[5] - seen[5],
                    first_splat: seen[3],
                    first_pair: seen[4],
                    pass,
                    lists: given.lists.map(|lists| lists.part(count, from, behind)),
                });
                seen = now;
            }
        }
    }
}

/// Counters of the first `end` records: survivors, prepared, tests, splats, pairs, lookups. Whole
/// blocks are known; in a block each counter X of n records grows as `floor(X e / n)`.
fn until(w: &FrameWorkload, given: &FrameContext, end: u64) -> [u64; 6] {
    let c = &w.counters;
    let pairs = pairs_written(w, given);
    let lookups = w.fovea.as_ref().map_or(0, |fovea| fovea.counters.lookups);
    let all = [c.survivors, c.obb_prepared, c.obb_tests, c.intersecting_points, pairs, lookups];
    if end >= c.points {
        return all;
    }
    if w.storage.is_empty() {
        return all.map(|x| x * end / c.points);
    }
    let whole = (end / 32) as usize;
    let read = |n: usize| match n {
        0 => [0; 6],
        n => {
            let p = &w.storage[n - 1];
            [p.survivors, p.prepared, p.tests, p.splats, p.pairs, p.lookups].map(u64::from)
        }
    };
    let (low, high) = (read(whole), read(whole + 1));
    let size = (c.points - 32 * whole as u64).min(32);
    let mut sum: [u64; 6] = [0; 6];
    for i in 0..6 {
        sum[i] = low[i] + (high[i] - low[i]) * (end % 32) / size;
    }
    // Of each batch the same share of its pairs is written, or of its records where it has none.
    if pairs != c.tile_pairs {
        sum[4] = match c.tile_pairs {
            0 => pairs * end / c.points,
            all => sum[4] * pairs / all,
        };
    }
    sum
}

impl Converter {
    pub fn new() -> Self {
        Self {
            held: Vec::new(),
            entering: None,
            entering_room: 0,
            pipe: Vec::new(),
            writes: Vec::new(),
            input_used: 0,
            output_used: 0,
        }
    }

    pub fn is_done(&self) -> bool {
        self.held.is_empty()
            && self.entering.is_none()
            && self.pipe.is_empty()
            && self.writes.is_empty()
    }

    pub fn step(&mut self, now: u64, frame: &mut Frame, next: &mut usize, memory: &mut Memory) {
        let ccu = &frame.design.ccu;
        self.writes.retain(|&(ref leaving, index, bytes)| {
            let Leaving::Write(ticket) = *leaving else { return true };
            let done = memory.is_done(ticket, now);
            self.output_used -= if done { bytes } else { 0 };
            if done {
                frame.written.insert(index, frame.work.batches[index].splats);
            }
            !done
        });
        while let Some(&(0, index, bytes)) = self.pipe.first() {
            // In order: while one waits for what it reads, so do those behind it.
            let b = frame.work.batches[index];
            let back = b.lists.map_or(0, |lists| lists.read);
            match self.writes.last() {
                Some((Leaving::Back(ticket), ..)) if !memory.is_done(*ticket, now) => break,
                Some((Leaving::Back(_), ..)) => drop(self.writes.pop()),
                _ if back > 0 => {
                    let span = memory.layout.read_back(&b);
                    let ticket = memory.read(now, "read-back", back, span);
                    self.writes.push((Leaving::Back(ticket), index, bytes));
                    continue;
                }
                _ => {}
            }
            let span = memory.layout.results(&b);
            let ticket = memory.write(now, "results", ccu.written(&b), span);
            self.writes.push((Leaving::Write(ticket), index, bytes));
            self.pipe.remove(0);
        }
        if matches!(self.entering, Some((_, 0, 0))) {
            self.entering = None;
            self.input_used -= std::mem::take(&mut self.entering_room);
        }
        let share = frame.design.shares.gaussian_in;
        for held in &mut self.held {
            held.waits_for = held.waits_for.filter(|&ticket| !memory.is_done(ticket, now));
        }
        for place in 0..self.held.len() {
            while self.held[place].waits_for.is_none() && self.held[place].reads < 3 {
                let (b, read) = (self.held[place].batch, self.held[place].reads);
                let bytes = ccu.read(&b, read);
                if bytes == 0 {
                    self.held[place].reads += 1;
                    continue;
                }
                if !self.may_take(ccu, place, bytes, share) {
                    break;
                }
                let span = memory.layout.batch_read(&b, read, bytes);
                let held = &mut self.held[place];
                held.waits_for = Some(memory.read(now, READS[read], bytes, span));
                (held.reads, held.room) = (held.reads + 1, held.room + bytes);
                self.input_used += bytes;
                // What takes no time is here at once.
                held.waits_for = held.waits_for.filter(|&ticket| !memory.is_done(ticket, now));
            }
        }
        if self.entering.is_none() && self.held.first().is_some_and(Held::is_complete) {
            let bytes = ccu.held(&self.held[0].batch);
            if self.output_used == 0 || self.output_used + bytes <= frame.design.shares.tile_list {
                let held = self.held.remove(0);
                let (cycles, bank) = (ccu.cycles(&held.batch), ccu.bank_stalls(&held.batch));
                self.output_used += bytes;
                self.entering_room = held.room;
                self.entering = Some((held.index, cycles, bank));
                self.pipe.push((cycles + bank + u64::from(ccu.spec.latency), held.index, bytes));
            }
        }
        let places = self.held.len() < ccu.spec.queue as usize;
        if *next == frame.work.first_pass && now < frame.second_pass {
            return;
        }
        if *next < frame.work.batches.len() && places {
            let batch = frame.work.batches[*next];
            // It must have room for a whole batch of which everything may be needed, or for a
            // bound where that is larger than its positions.
            let most = u64::from(ccu.batch);
            let largest = match batch.pass {
                Pass::Scatter => Batch { splats: most, pass: Pass::Scatter, ..Batch::default() },
                pass => {
                    let mut records = most;
                    let bound = if ccu.spec.clusters > 0 { ccu.spec.cluster.0 } else { 0 };
                    let one = Batch { records: 1, pass, ..Batch::default() };
                    while ccu.read(&one, 0) > 0 && records * ccu.read(&one, 0) < bound {
                        records += 1;
                    }
                    Batch { records, pass, ..Batch::default() }
                }
            };
            let (index, reads, room) = (*next, 0, 0);
            self.held.push(Held { index, batch: largest, reads, waits_for: None, room });
            let fits = self.may_take(ccu, self.held.len() - 1, ccu.read(&largest, 0), share);
            self.held.pop();
            if !fits {
                return;
            }
            let bytes = ccu.read(&batch, 0);
            self.held.push(Held { index, batch, reads, waits_for: None, room });
            let span = memory.layout.batch_read(&batch, 0, bytes);
            let held = self.held.last_mut().expect("the new one");
            held.waits_for = Some(memory.read(now, READS[0], bytes, span));
            (held.reads, held.room) = (1, bytes);
            self.input_used += bytes;
            *next += 1;
        }
    }

    /// Whether a read of `bytes` for the batch at `place` is issued: it fits, and every batch up to
    /// this one can still finish when those before it have gone. A batch that is alone may always.
    fn may_take(&mut self, ccu: &Ccu, place: usize, bytes: u64, share: u64) -> bool {
        if self.input_used == self.held[place].room {
            return true;
        }
        if self.input_used + bytes > share {
            return false;
        }
        // Try it: the state after the read.
        let (reads, waits_for) = (self.held[place].reads, self.held[place].waits_for);
        let known = if reads == 0 { 0 } else { reads };
        let mut safe = true;
        let mut free = share - self.input_used - bytes + self.entering_room;
        for (i, held) in self.held.iter().enumerate().take(place + 1) {
            let need =
                if i < place { held.need(ccu) } else { held.need_after(ccu, known, reads + 1) };
            safe &= need <= free;
            free += held.room;
        }
        assert!(waits_for.is_none());
        safe
    }

    pub fn symbol(&self) -> char {
        match (&self.entering, self.held.first()) {
            (Some((_, 0, _)), _) => 'b',
            (Some((index, _, _)), _) => digit(*index),
            (None, None) => '.',
            (None, Some(held)) if held.is_complete() => 'o',
            (None, Some(_)) => 'r',
        }
    }

    pub fn tick(&mut self) {
        if let Some((_, busy, bank)) = &mut self.entering {
            *(if *busy > 0 { busy } else { bank }) -= 1;
        }
        // What waits for others to be written stays at its end.
        self.pipe.iter_mut().for_each(|p| p.0 = p.0.saturating_sub(1));
    }
}
