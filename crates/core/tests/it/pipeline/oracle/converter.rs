//! A CCU, counting down.

use powergs_core::accel::Unit;
use powergs_core::accel::batch::Batch;
use powergs_core::accel::layout::AccessPattern;
use powergs_core::accel::traffic::pairs_written;

use super::memory::{Memory, Ticket};
use super::{Frame, digit};

#[derive(PartialEq)]
enum Data {
    First(Ticket),
    Second(Ticket),
    Here,
}

struct Held {
    index: usize,
    batch: Batch,
    data: Data,
}

pub struct Converter {
    held: Vec<Held>,
    entering: Option<(usize, u64, u64)>,
    pipe: Vec<(u64, usize, u64)>,
    writes: Vec<(Ticket, usize, u64)>,
    input_used: u64,
    output_used: u64,
}

pub fn batches(frame: &Frame) -> usize {
    let c = &frame.workload.counters;
    // Pairs without points cannot be, but would still be written.
    let orphans = c.points == 0 && pairs_written(frame.workload, &frame.given) > 0;
    c.points.div_ceil(u64::from(frame.design.ccu.batch)) as usize + usize::from(orphans)
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
    let from = index as u64 * size;
    let to = (from + size).min(frame.workload.counters.points);
    let (before, after) = (until(frame, from), until(frame, to));
    let first = if frame.workload.counters.points == 0 { [0; 6] } else { before };
    Batch {
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
    }
}

impl Converter {
    pub fn new() -> Self {
        Self {
            held: Vec::new(),
            entering: None,
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
        self.writes.retain(|&(ticket, index, bytes)| {
            let done = memory.is_done(ticket, now);
            self.output_used -= if done { bytes } else { 0 };
            if done {
                frame.written.insert(index, batch(frame, index).splats);
            }
            !done
        });
        while let Some(&(0, index, bytes)) = self.pipe.first() {
            let b = batch(frame, index);
            let span = memory.layout.results(b.first_splat, b.splats, b.first_pair, b.pairs);
            self.writes.push((memory.write(now, 0, bytes, span), index, bytes));
            self.pipe.remove(0);
        }
        if matches!(self.entering, Some((_, 0, 0))) {
            self.entering = None;
            self.input_used -= ccu.reserved();
        }
        for held in &mut self.held {
            match held.data {
                Data::First(ticket) if memory.is_done(ticket, now) => {
                    let bytes = ccu.second_read(&held.batch);
                    held.data = match bytes {
                        0 => Data::Here,
                        _ => {
                            let Batch { first, records, survivors, .. } = held.batch;
                            let span = AccessPattern::Survivors { first, records, survivors };
                            Data::Second(memory.read(now, 0, bytes, span))
                        }
                    };
                }
                Data::Second(ticket) if memory.is_done(ticket, now) => held.data = Data::Here,
                _ => {}
            }
        }
        if self.entering.is_none() && self.held.first().is_some_and(|h| h.data == Data::Here) {
            let bytes = ccu.written(&self.held[0].batch);
            if self.output_used == 0 || self.output_used + bytes <= frame.design.shares.tile_list {
                let held = self.held.remove(0);
                let (cycles, bank) = (ccu.cycles(&held.batch), ccu.bank_stalls(&held.batch));
                self.output_used += bytes;
                self.entering = Some((held.index, cycles, bank));
                self.pipe.push((cycles + bank + u64::from(ccu.spec.latency), held.index, bytes));
            }
        }
        let reserved = ccu.reserved();
        let share = frame.design.shares.gaussian_in;
        let fits = self.input_used == 0 || self.input_used + reserved <= share;
        let places = self.held.len() < ccu.spec.queue as usize;
        if *next < batches(frame) && fits && places {
            let batch = batch(frame, *next);
            let bytes = ccu.first_read(&batch);
            let span = memory.layout.first_read(batch.first, bytes);
            let ticket = memory.read(now, 0, bytes, span);
            self.held.push(Held { index: *next, batch, data: Data::First(ticket) });
            self.input_used += reserved;
            *next += 1;
        }
    }

    pub fn symbol(&self) -> char {
        match (&self.entering, self.held.first()) {
            (Some((_, 0, _)), _) => 'b',
            (Some((index, _, _)), _) => digit(*index),
            (None, None) => '.',
            (None, Some(held)) if held.data == Data::Here => 'o',
            (None, Some(_)) => 'r',
        }
    }

    pub fn tick(&mut self) {
        if let Some((_, busy, bank)) = &mut self.entering {
            *(if *busy > 0 { busy } else { bank }) -= 1;
        }
        self.pipe.iter_mut().for_each(|p| p.0 -= 1);
    }
}
