//! A unit of the front, counting down.

use std::collections::VecDeque;

use powergs_core::flow::resident::Resident;
use powergs_core::flow::resident::layout::Place;
use powergs_core::flow::resident::work::RecordCounts;

use super::{Room, World, digit};
use crate::oracle_memory::Ticket;

enum Where {
    Records(Ticket),
    /// Nothing where no colour is needed.
    Colours(Option<Ticket>),
    Work(u64),
    Pipeline(u64),
    Written(Ticket),
}

pub struct Batch {
    first: u64,
    records: u64,
    before: RecordCounts,
    counts: RecordCounts,
    at: Where,
    input: u64,
    output: u64,
}

pub struct Front {
    pub batches: VecDeque<Batch>,
    input: Room,
    output: Room,
}

impl Front {
    pub fn new(m: &Resident) -> Front {
        Front {
            batches: VecDeque::new(),
            input: Room::share(&m.stores.records, m.front.units),
            output: Room::share(&m.stores.results, m.front.units),
        }
    }

    pub fn step(&mut self, world: &mut World) {
        self.free(world);
        for batch in &mut self.batches {
            if let Where::Work(0) = batch.at {
                self.input.used -= batch.input;
                batch.at = Where::Pipeline(u64::from(world.m.front.latency));
            }
        }
        self.write(world);
        self.ask_for_colours(world);
        self.begin(world);
        self.ask(world);
    }

    /// Room of results that have been written.
    fn free(&mut self, world: &World) {
        for n in (0..self.batches.len()).rev() {
            if let Where::Written(ticket) = self.batches[n].at
                && world.is_done(ticket)
            {
                self.output.used -= self.batches[n].output;
                self.batches.remove(n);
            }
        }
    }

    /// Results of batches that ended `latency` cycles ago.
    fn write(&mut self, world: &mut World) {
        for batch in &mut self.batches {
            if let Where::Pipeline(0) = batch.at {
                let place = Place::Results {
                    first: batch.before.splats,
                    splats: if world.m.front.lazy { 0 } else { batch.counts.splats },
                    entry: batch.before.entries,
                    entries: batch.counts.entries,
                };
                batch.at = Where::Written(world.write("results", batch.output, place));
            }
        }
    }

    /// Oldest first.
    fn ask_for_colours(&mut self, world: &mut World) {
        for batch in &mut self.batches {
            let Where::Records(ticket) = batch.at else { continue };
            if !world.is_done(ticket) {
                return;
            }
            let splats = if world.m.front.lazy { 0 } else { batch.counts.splats };
            let bytes = splats * world.m.gaussian.colour.0;
            let place = Place::Shades { first: batch.before.splats, splats };
            batch.at = Where::Colours((bytes > 0).then(|| world.read("shades", bytes, place)));
        }
    }

    /// The oldest batch that has not begun.
    fn begin(&mut self, world: &World) {
        if self.batches.iter().any(|batch| matches!(batch.at, Where::Work(_))) {
            return;
        }
        let waits = |batch: &&mut Batch| matches!(batch.at, Where::Records(_) | Where::Colours(_));
        if let Some(batch) = self.batches.iter_mut().find(waits)
            && let Where::Colours(ticket) = batch.at
            && ticket.is_none_or(|ticket| world.is_done(ticket))
            && self.output.admits(batch.output)
        {
            self.output.used += batch.output;
            let counts = match world.m.front.lazy {
                true => RecordCounts { survivors: 0, splats: 0, ..batch.counts },
                false => batch.counts,
            };
            batch.at = Where::Work(world.m.front.cycles(batch.records, &counts));
        }
    }

    /// The next batch.
    fn ask(&mut self, world: &mut World) {
        let (m, lazy) = (world.m, world.m.front.lazy);
        let first = world.next_record;
        let records = u64::from(m.front.batch).min(world.frame.counters.points - first);
        let g = &m.gaussian;
        let each = g.position.0 + if lazy { 0 } else { g.shape.0 };
        let input = records * (each + if lazy { 0 } else { g.colour.0 });
        let has_room = self.batches.len() < m.front.queue as usize && self.input.admits(input);
        if records == 0 || !has_room {
            return;
        }
        let [before, after] = [first, first + records].map(|n| world.frame.up_to(n));
        let counts = RecordCounts {
            survivors: after.survivors - before.survivors,
            splats: after.splats - before.splats,
            entries: after.entries - before.entries,
            rows: after.rows - before.rows,
        };
        let features = if lazy { 0 } else { counts.splats * g.feature.0 };
        let place = Place::Batch { first, records };
        let at = Where::Records(world.read("records", records * each, place));
        let output = features + counts.entries * g.entry.0;
        world.next_record += records;
        self.input.used += input;
        self.batches.push_back(Batch { first, records, before, counts, at, input, output });
    }

    pub fn tick(&mut self) {
        for batch in &mut self.batches {
            if let Where::Work(left) | Where::Pipeline(left) = &mut batch.at {
                *left -= 1;
            }
        }
    }

    pub fn symbol(&self, world: &World) -> char {
        for batch in &self.batches {
            match batch.at {
                Where::Work(_) => {
                    return digit((batch.first / u64::from(world.m.front.batch)) as u32);
                }
                Where::Colours(ticket) if ticket.is_none_or(|ticket| world.is_done(ticket)) => {
                    return 'o';
                }
                Where::Records(_) | Where::Colours(_) => return 'r',
                Where::Pipeline(_) | Where::Written(_) => {}
            }
        }
        '.'
    }
}
