//! The machine once more, cycle by cycle, written from the rules in words (module documentation of
//! `flow::resident` and its parts): nothing is predicted, every unit counts down, and acts in every
//! cycle. Only the cost of a piece of work is shared.

mod engine;
mod front;
mod order;

use std::collections::BTreeMap;

use powergs_core::flow::over::FirstUnit;
use powergs_core::flow::over::pixels::SomeRegions;
use powergs_core::flow::resident::layout::{Layout, Place};
use powergs_core::flow::resident::work::ResidentFrame;
use powergs_core::flow::resident::{FrontOverlap, Resident, STREAMS};
use powergs_core::kernel::Calibration;
use powergs_core::kernel::dram::Dram;
use powergs_core::machine::{BufferSpec, Machine};
use powergs_dram::AddressRange;

use self::engine::Engine;
use self::front::Front;
use self::order::Order;
use crate::oracle_blocks::{Block, Mover, levels};
use crate::oracle_memory::{self, Ticket};

/// What the oracle saw.
#[derive(Debug, Default)]
pub struct Seen {
    rows: BTreeMap<(usize, usize), String>,
    pub frame: u64,
    pub preprocessing_end: u64,
    pub requests: u64,
    pub read: [u64; 3],
    pub write: [u64; 3],
}

const STAGES: [&str; 7] = ["pxu", "ltu", "front", "order", "raster", "tail", "compose"];

impl Seen {
    /// As `Timeline::draw`.
    pub fn draw(&self) -> String {
        self.rows.iter().map(|((s, i), row)| format!("{}{i} |{row}\n", STAGES[*s])).collect()
    }

    /// What knows pixels (0), and what traverses levels (1).
    fn put_first(&mut self, which: usize, symbol: char) {
        self.rows.entry((which, 0)).or_default().push(symbol);
    }

    fn put(&mut self, stage: usize, instance: usize, symbol: char) {
        self.rows.entry((2 + stage, instance)).or_default().push(symbol);
    }
}

/// A share of a buffer.
pub struct Room {
    capacity: u64,
    used: u64,
}

impl Room {
    fn share(store: &BufferSpec, owners: u32) -> Room {
        Room { capacity: store.capacity.0 / u64::from(owners), used: 0 }
    }

    /// Something fits, or is alone.
    fn admits(&self, bytes: u64) -> bool {
        self.used == 0 || self.used + bytes <= self.capacity
    }
}

/// What all units see.
pub struct World<'a> {
    m: &'a Resident,
    frame: &'a ResidentFrame,
    memory: oracle_memory::Memory<Layout<'a>>,
    now: u64,
    next_record: u64,
    next_region: usize,
    next_job: u32,
    in_order: Vec<bool>,
    ended: Vec<u32>,
    written: Vec<u32>,
    composed: Vec<bool>,
    /// The chunk that the front converts, if it does, and its cycles left.
    converts: (u32, u64),
}

impl World<'_> {
    fn read(&mut self, stream: &str, bytes: u64, place: Place) -> Ticket {
        self.memory.read(self.now, stream, bytes, place)
    }

    fn write(&mut self, stream: &str, bytes: u64, place: Place) -> Ticket {
        self.memory.write(self.now, stream, bytes, place)
    }

    fn is_done(&self, ticket: Ticket) -> bool {
        self.memory.is_done(ticket, self.now)
    }

    fn jobs(&self) -> u32 {
        self.frame.regions.len() as u32 * self.m.region.slices
    }
}

/// Steps through a frame.
pub fn run(
    machine: &Machine,
    frame: &ResidentFrame,
    some: Option<&SomeRegions>,
    calibration: Option<&Calibration>,
) -> Seen {
    let m = &machine.resident().of_degree(frame.sh_degree);
    let flat = match calibration {
        Some(calibration) => calibration.dram(),
        None => Dram::new(&machine.dram, machine.dram_peak(), machine.clock, &STREAMS),
    };
    let regions = frame.regions.len();
    let blocks = some.map_or(&[][..], |some| &some.blocks);
    let known = blocks
        .iter()
        .fold([0; 2], |sum: [u64; 2], block| [sum[0] + block.read, sum[1] + block.write]);
    let points = frame.counters.points;
    let firsts = FirstUnit::of(machine, points);
    let layout = Layout::new(frame, m, &firsts, known, None);
    let first_places = layout.first().first().copied().unwrap_or_default();
    let mut traversal = levels(&m.levels, points, first_places, Place::Range);
    let mut mover = m.pixel_filter().map(|filter| {
        let mut unit = Mover::new(["known-in", "known-out"], filter.spec.per_cycle.into());
        let mut at = layout.known();
        for block in blocks {
            let [read, write] = [(0, block.read), (1, block.write)].map(|(way, bytes)| {
                let address: u64 = at[way];
                at[way] += bytes;
                (bytes, Place::Range(AddressRange { address, bytes }))
            });
            unit.push(Block { items: block.items, read, write });
        }
        unit
    });
    let mut world = World {
        m,
        frame,
        memory: oracle_memory::Memory::new(layout, &STREAMS, machine, flat),
        now: 0,
        next_record: 0,
        next_region: 0,
        next_job: 0,
        in_order: vec![false; regions],
        ended: vec![0; regions],
        written: vec![0; regions],
        composed: vec![false; regions],
        converts: (u32::MAX, 0),
    };
    let mut fronts: Vec<Front> = (0..m.front.units).map(|_| Front::new(m)).collect();
    let mut orders: Vec<Order> = (0..m.order.units).map(|_| Order::new(m)).collect();
    let mut engines: Vec<Engine> = (0..m.raster.engines).map(|_| Engine::new(m)).collect();
    let mut seen = Seen::default();
    let [units, tails, composers] =
        [engines.len(), usize::from(m.tail.share > 0.0), usize::from(m.compose.lanes > 0)];
    let idle = [fronts.len(), orders.len(), units, tails * units, composers * units];
    let (mut is_converted, overlaps) = (false, m.front.overlap == FrontOverlap::Frames);
    loop {
        // Everything waits until the levels have been traversed, then until the pixels of the frame
        // before have been moved.
        let mut waits_for = None;
        for (which, unit) in [(1, &mut traversal), (0, &mut mover)] {
            let Some(unit) = unit.as_mut().filter(|_| waits_for.is_none()) else { continue };
            unit.step(world.now, &mut world.memory);
            waits_for = (!unit.is_done()).then_some(which);
        }
        if let Some(which) = waits_for {
            let other = [&mover, &traversal][1 - which].is_some();
            if other {
                seen.put_first(1 - which, '.');
            }
            if let Some(unit) = [&mut mover, &mut traversal][which].as_mut() {
                seen.put_first(which, unit.symbol());
                for (kind, units) in idle.into_iter().enumerate() {
                    (0..units).for_each(|i| seen.put(kind, i, '.'));
                }
                unit.tick();
                world.memory.tick(world.now);
                world.now += 1;
                continue;
            }
        }
        if !is_converted {
            fronts.iter_mut().for_each(|unit| unit.step(&mut world));
            is_converted = world.next_record == frame.counters.points
                && fronts.iter().all(|unit| unit.batches.is_empty());
            seen.preprocessing_end = world.now;
        }
        if is_converted || overlaps {
            orders.iter_mut().for_each(|unit| unit.step(&mut world));
            engines.iter_mut().for_each(|engine| engine.step(&mut world));
            let is_rendered = world.next_job == world.jobs() && engines.iter().all(Engine::is_done);
            if is_rendered && is_converted {
                break;
            }
        }
        for (which, unit) in [&mover, &traversal].into_iter().enumerate() {
            if unit.is_some() {
                seen.put_first(which, '.');
            }
        }
        for (i, unit) in fronts.iter().enumerate() {
            let symbol = match world.converts {
                (n, left) if left > 0 => digit(n),
                _ if is_converted => '.',
                _ => unit.symbol(&world),
            };
            seen.put(0, i, symbol);
        }
        for (i, unit) in orders.iter().enumerate() {
            seen.put(1, i, unit.symbol());
        }
        for (i, engine) in engines.iter().enumerate() {
            seen.put(2, i, engine.raster_symbol(&world));
            if m.tail.share > 0.0 {
                seen.put(3, i, engine.tail_symbol());
            }
            if m.compose.lanes > 0 {
                seen.put(4, i, engine.compose_symbol());
            }
        }
        fronts.iter_mut().for_each(Front::tick);
        orders.iter_mut().for_each(Order::tick);
        engines.iter_mut().for_each(Engine::tick);
        world.converts.1 = world.converts.1.saturating_sub(1);
        world.memory.tick(world.now);
        world.now += 1;
        assert!(world.now < 100_000_000, "it does not end");
    }
    seen.frame = world.now;
    let memory = &world.memory;
    (seen.requests, seen.read, seen.write) = (memory.requests, memory.read, memory.written);
    seen
}

/// The last digit of an item.
fn digit(item: u32) -> char {
    char::from(b'0' + (item % 10) as u8)
}
