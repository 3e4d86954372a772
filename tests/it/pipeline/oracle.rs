//! The machine once more, cycle by cycle, written from the rules in words (module documentation of
//! `accel::pipeline` and its parts) and not from the recurrences: nothing is predicted, every unit
//! counts down, the memory moves tick by tick. Only the cost of a piece of work is shared.

mod converter;
mod core;
mod memory;

use std::collections::BTreeMap;

use powergs_sim::accel::{Design, Machine};
use powergs_sim::workload::FrameWorkload;

use self::converter::Converter;
use self::core::Core;
use self::memory::Memory;

/// What the oracle saw.
#[derive(Debug, Default)]
pub struct Seen {
    /// One character per cycle by unit and instance, as `Timeline::draw`.
    pub rows: BTreeMap<(usize, usize), String>,
    pub preprocessing_end: u64,
    pub frame: u64,
    pub requests: u64,
    pub read: [u64; 3],
    pub write: [u64; 3],
}

impl Seen {
    pub fn draw(&self) -> String {
        let names = ["ccu", "qsu", "bsu", "vru"];
        self.rows.iter().map(|((u, i), row)| format!("{}{i} |{row}\n", names[*u])).collect()
    }

    fn put(&mut self, unit: usize, instance: usize, symbol: char) {
        self.rows.entry((unit, instance)).or_default().push(symbol);
    }

    /// Cycles of all instances of a unit with this symbol.
    pub fn cycles(&self, unit: usize, symbol: impl Fn(char) -> bool) -> u64 {
        let rows = self.rows.iter().filter(|((u, _), _)| *u == unit);
        rows.map(|(_, row)| row.chars().filter(|&c| symbol(c)).count() as u64).sum()
    }
}

/// Steps through a frame.
pub fn run(workload: &FrameWorkload, machine: &Machine) -> Seen {
    let design = Design::new(machine);
    let mut memory = Memory::new(&design);
    let mut seen = Seen::default();
    let n_cores = machine.vru.cores as usize;
    let mut converters: Vec<Converter> = (0..machine.ccu.units).map(|_| Converter::new()).collect();
    let mut next_batch = 0;
    let mut now = 0;
    loop {
        for converter in &mut converters {
            converter.step(now, &design, workload, &mut next_batch, &mut memory);
        }
        let left = converter::batches(workload, &design) - next_batch;
        if left == 0 && converters.iter().all(Converter::is_done) {
            break;
        }
        for (i, converter) in converters.iter_mut().enumerate() {
            seen.put(0, i, converter.symbol());
            converter.tick();
        }
        for i in 0..n_cores {
            (1..4).for_each(|unit| seen.put(unit, i, '.'));
        }
        memory.tick(now);
        now += 1;
    }
    seen.preprocessing_end = now;
    let mut cores: Vec<Core> = (0..n_cores).map(|_| Core::default()).collect();
    let mut next_tile = 0;
    loop {
        for core in &mut cores {
            core.step(now, &design, workload, &mut next_tile, &mut memory);
        }
        if next_tile == workload.tiles.len() && cores.iter().all(Core::is_done) {
            break;
        }
        (0..converters.len()).for_each(|i| seen.put(0, i, '.'));
        for (i, core) in cores.iter_mut().enumerate() {
            let symbols = core.symbols(now, &memory);
            (1..4).for_each(|unit| seen.put(unit, i, symbols[unit - 1]));
            core.tick();
        }
        memory.tick(now);
        now += 1;
    }
    seen.frame = now;
    (seen.requests, seen.read, seen.write) = (memory.requests, memory.read, memory.written);
    seen
}

/// The last digit of an item.
fn digit(item: usize) -> char {
    char::from(b'0' + (item % 10) as u8)
}
