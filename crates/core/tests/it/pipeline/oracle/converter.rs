//! A CCU, counting down.

use powergs_core::flow::tile_wise::batch::{Batch, Pass};
use powergs_core::flow::tile_wise::ccu::Ccu;
use powergs_core::flow::tile_wise::traffic::pairs_written;
use powergs_core::kernel::Unit;

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

/// How often the records are gone through.
fn passes(frame: &Frame) -> usize {
    1 + usize::from(frame.given.lists.is_some_and(|lists| lists.counts_first()))
}

/// Batches of one pass.
fn of_pass(frame: &Frame) -> usize {
    let c = &frame.workload.counters;
    // Pairs without points cannot be, but would still be written.
    let orphans = c.points == 0 && pairs_written(frame.workload, &frame.given) > 0;
    c.points.div_ceil(u64::from(frame.design.ccu.batch)) as usize + usize::from(orphans)
}

/// Batches of all passes.
pub fn batches(frame: &Frame) -> usize {
    passes(frame) * of_pass(frame)
}

/// Counters of the first `end` records: survivors, prepared, tests, splats, pairs, lookups. Whole
/// blocks are known; in a block each counter X of n records grows as `floor(X e / n)`.
fn until(frame: &Frame, end: u64) -> [u64; 6] {
    let (w, c) = (frame.workload, &frame.workload.counters);
    let pairs = pairs_written(w, &frame.given);
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
    if pairs != c.tile_pairs {
        sum[4] = sum[4] * pairs / c.tile_pairs;
    }
    sum
}

fn batch(frame: &Frame, index: usize) -> Batch {
    let size = u64::from(frame.design.ccu.batch);
    let pass = match (passes(frame), index / of_pass(frame)) {
        (1, _) => Pass::Whole,
        (_, 0) => Pass::Count,
        (_, _) => Pass::Scatter,
    };
    let from = (index % of_pass(frame)) as u64 * size;
    let to = (from + size).min(frame.workload.counters.points);
    let (before, after) = (until(frame, from), until(frame, to));
    let first = if frame.workload.counters.points == 0 { [0; 6] } else { before };
    Batch {
        clusters: 0,
        first: from,
        records: to - from,
        survivors: after[0] - first[0],
        prepared: after[1] - first[1],
        tests: after[2] - first[2],
        splats: after[3] - first[3],
        pairs: after[4] - first[4],
        lookups: after[5] - first[5],
        first_splat: first[3],
        first_pair: first[4],
        pass,
        lists: frame.given.lists.map(|lists| lists.part(pass == Pass::Count, from, to)),
    }
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
                frame.written.insert(index, batch(frame, index).splats);
            }
            !done
        });
        while let Some(&(0, index, bytes)) = self.pipe.first() {
            // In order: while one waits for what it reads, so do those behind it.
            let b = batch(frame, index);
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
        if *next == of_pass(frame) && now < frame.second_pass {
            return;
        }
        if *next < batches(frame) && places {
            let batch = batch(frame, *next);
            // It must have room for a whole batch of which everything may be needed.
            let largest = match batch.pass {
                Pass::Scatter => {
                    Batch { splats: u64::from(ccu.batch), pass: Pass::Scatter, ..Batch::default() }
                }
                _ => Batch { records: u64::from(ccu.batch), ..Batch::default() },
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
