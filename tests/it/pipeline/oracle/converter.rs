//! A CCU, counting down.

use powergs_sim::accel::batch::Batch;
use powergs_sim::accel::{Design, Unit};
use powergs_sim::workload::FrameWorkload;

use super::digit;
use super::memory::{Memory, Ticket};

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
    entering: Option<(usize, u64)>,
    pipe: Vec<(u64, u64)>,
    writes: Vec<(Ticket, u64)>,
    input_used: u64,
    output_used: u64,
}

pub fn batches(workload: &FrameWorkload, design: &Design) -> usize {
    let c = &workload.counters;
    // Pairs without points cannot be, but would still be written.
    let orphans = c.points == 0 && c.tile_pairs > 0;
    c.points.div_ceil(u64::from(design.ccu.batch)) as usize + usize::from(orphans)
}

/// Counter X up to record e is `floor(X e / P)`.
fn batch(workload: &FrameWorkload, design: &Design, index: usize) -> Batch {
    let c = &workload.counters;
    let size = u64::from(design.ccu.batch);
    let from = index as u64 * size;
    let to = (from + size).min(c.points);
    let part = |total: u64| match c.points {
        0 => total,
        points => total * to / points - total * from / points,
    };
    Batch {
        records: to - from,
        survivors: part(c.survivors),
        prepared: part(c.obb_prepared),
        tests: part(c.obb_tests),
        splats: part(c.intersecting_points),
        pairs: part(c.tile_pairs),
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

    pub fn step(
        &mut self,
        now: u64,
        design: &Design,
        workload: &FrameWorkload,
        next: &mut usize,
        memory: &mut Memory,
    ) {
        let ccu = &design.ccu;
        self.writes.retain(|&(ticket, bytes)| {
            let done = memory.is_done(ticket, now);
            self.output_used -= if done { bytes } else { 0 };
            !done
        });
        while let Some(&(0, bytes)) = self.pipe.first() {
            self.writes.push((memory.write(now, 0, bytes), bytes));
            self.pipe.remove(0);
        }
        if matches!(self.entering, Some((_, 0))) {
            self.entering = None;
            self.input_used -= ccu.reserved();
        }
        for held in &mut self.held {
            match held.data {
                Data::First(ticket) if memory.is_done(ticket, now) => {
                    let bytes = ccu.second_read(&held.batch);
                    held.data = match bytes {
                        0 => Data::Here,
                        _ => Data::Second(memory.read(now, 0, bytes)),
                    };
                }
                Data::Second(ticket) if memory.is_done(ticket, now) => held.data = Data::Here,
                _ => {}
            }
        }
        if self.entering.is_none() && self.held.first().is_some_and(|h| h.data == Data::Here) {
            let bytes = ccu.written(&self.held[0].batch);
            if self.output_used == 0 || self.output_used + bytes <= design.shares.tile_list {
                let held = self.held.remove(0);
                let cycles = ccu.cycles(&held.batch);
                self.output_used += bytes;
                self.entering = Some((held.index, cycles));
                self.pipe.push((cycles + u64::from(ccu.spec.latency), bytes));
            }
        }
        let reserved = ccu.reserved();
        let fits = self.input_used == 0 || self.input_used + reserved <= design.shares.gaussian_in;
        if *next < batches(workload, design) && fits {
            let batch = batch(workload, design, *next);
            let ticket = memory.read(now, 0, ccu.first_read(&batch));
            self.held.push(Held { index: *next, batch, data: Data::First(ticket) });
            self.input_used += reserved;
            *next += 1;
        }
    }

    pub fn symbol(&self) -> char {
        match (&self.entering, self.held.first()) {
            (Some((index, _)), _) => digit(*index),
            (None, None) => '.',
            (None, Some(held)) if held.data == Data::Here => 'o',
            (None, Some(_)) => 'd',
        }
    }

    pub fn tick(&mut self) {
        if let Some((_, left)) = &mut self.entering {
            *left -= 1;
        }
        self.pipe.iter_mut().for_each(|p| p.0 -= 1);
    }
}
