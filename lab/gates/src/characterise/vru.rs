//! The control of a rendering unit: the lists of tiles.
//!
//! Its cores are ports here. What stands in for them takes a splat in 16 cycles, says that it has
//! stopped when the splat comes that stops its sub-tile, and lets its pixels leave behind CLOSE.
//! What each sub-tile is given is compared with its part of the list.

use std::collections::VecDeque;

use super::lanes::{LANES, Lanes, Patience, dealt, side_by_side};
use super::qsu::Chance;
use super::{CharacteriseError, Characterised, Measured, Meter, characterise, divided, due, must};
use crate::netlist::Netlist;
use crate::simulator::Simulator;

/// A cycle; a tile; an entry that leaves the head; an entry that enters a sub-tile.
const ACTIONS: &[&str] = &["cycle", "tile", "entry", "pair"];

/// Cycles of a window: several splats of a sub-tile.
const WINDOW: u64 = 96;
const NUMBERS: usize = 9;
const SUBTILES: usize = 4;
const CORES: usize = 4;
/// Cycles of a splat in its cores, and of the pixels that leave.
const PIXELS: u64 = 16;
/// Cycles from the entry of a splat until its sub-tile is known to have stopped, and of a pipeline
/// that drains.
const STOPS: u64 = 20;
const DRAINS: u64 = 22;

const OPEN: u64 = 0;
const SPLAT: u64 = 1;
const CLOSE: u64 = 2;

/// A tile of a rendering unit.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Work {
    /// Columns and rows of its pixels that are in the image.
    pub size: [u8; 2],
    /// Records and bitmaps of its list, front to back.
    pub entries: Vec<([u16; NUMBERS], u8)>,
    /// List positions from which on a sub-tile needs nothing.
    pub ends: [Option<usize>; SUBTILES],
}

/// Prices of `netlist`, a mapped `vru` without its cores, on the lists of tiles.
///
/// # Errors
/// When there is too little work, or the netlist is of another unit or does something else.
pub fn prices(netlist: &Netlist, work: &[Work]) -> Result<Characterised, CharacteriseError> {
    let [fitted, held_out] = divided(work);
    let measure = |work: &[Work]| measure(netlist, work);
    characterise(netlist, &measure(&fitted)?, &measure(&held_out)?)
}

/// What stands in for the cores of a sub-tile.
#[derive(Clone, Default)]
struct Cores {
    /// Cycle from which on they take a splat.
    free: u64,
    /// Cycle from which on all have stopped.
    stopped: Option<u64>,
    /// Positions of the list that they will be given.
    expected: VecDeque<usize>,
    /// Whether anything came that has to drain.
    worked: bool,
}

/// A lane: its tiles and where it is in the first of them.
struct Lane<'a> {
    work: VecDeque<&'a Work>,
    /// Beats of the first tile that have been taken.
    taken: usize,
    offered: bool,
    cores: [Cores; SUBTILES],
    /// The tile whose OPEN is at the head, and the one that is in the cores.
    opening: Option<&'a Work>,
    rendered: Option<&'a Work>,
    /// First cycle in which pixels leave, and end.
    leaving: Option<[u64; 2]>,
    chance: Chance,
}

impl Lane<'_> {
    /// The tile at the head enters the cores.
    fn open(&mut self) -> Result<(), CharacteriseError> {
        let work = due(self.opening.take(), "a tile opens that was not given")?;
        for (s, cores) in self.cores.iter_mut().enumerate() {
            let wanted = |&at: &usize| work.entries[at].1 >> s & 1 == 1;
            *cores = Cores {
                expected: (0..work.entries.len()).filter(wanted).collect(),
                ..Cores::default()
            };
        }
        self.rendered = Some(work);
        Ok(())
    }

    /// The last pixels leave.
    fn close(&mut self) -> Result<(), CharacteriseError> {
        let work = due(self.rendered.take(), "pixels leave of no tile")?;
        for (cores, end) in self.cores.iter().zip(work.ends) {
            let needed = |&at: &usize| end.is_none_or(|end| at < end);
            must(!cores.expected.iter().any(needed), "a sub-tile is not given a splat")?;
        }
        self.leaving = None;
        Ok(())
    }

    /// Whether nothing is left to be done.
    fn is_done(&self) -> bool {
        self.work.is_empty() && self.opening.is_none() && self.rendered.is_none()
    }
}

/// Ports of the cores of a sub-tile.
struct CorePorts {
    ready: [Lanes; CORES],
    stopped: [Lanes; CORES],
    out_valid: [Lanes; CORES],
    valid: Lanes,
    op: Lanes,
    record: Lanes,
}

impl CorePorts {
    fn of(netlist: &Netlist, subtile: usize, w: usize) -> Result<CorePorts, CharacteriseError> {
        let port = |core: usize, name: &str, bits: usize| {
            let whole = format!("g_subtile_{subtile}_g_core_{core}_core_{name}");
            Lanes::of(netlist, &whole, bits)
        };
        let all = |name: &str| -> Result<[Lanes; CORES], CharacteriseError> {
            Ok([port(0, name, 1)?, port(1, name, 1)?, port(2, name, 1)?, port(3, name, 1)?])
        };
        Ok(CorePorts {
            ready: all("in_ready")?,
            stopped: all("stopped")?,
            out_valid: all("out_valid")?,
            valid: port(0, "in_valid", 1)?,
            op: port(0, "in_op", 2)?,
            record: port(0, "in_record", NUMBERS * w)?,
        })
    }
}

fn measure(netlist: &Netlist, work: &[Work]) -> Result<Measured, CharacteriseError> {
    let port = |name, bits| Lanes::of(netlist, name, bits);
    let (reset, valid, ready) = (port("rst_n", 1)?, port("in_valid", 1)?, port("in_ready", 1)?);
    let (record, width) = Lanes::numbers(netlist, "in_record", NUMBERS, 16)?;
    let (op, bitmap) = (port("in_op", 2)?, port("in_bitmap", SUBTILES)?);
    let (columns, rows) = (port("open_width", 5)?, port("open_height", 5)?);
    let (out_valid, out_ready) = (port("out_valid", 1)?, port("out_ready", 1)?);
    let mut ports = Vec::new();
    for subtile in 0..SUBTILES {
        ports.push(CorePorts::of(netlist, subtile, width)?);
    }
    let lane = |(number, work): (usize, Vec<_>)| Lane {
        work: work.into(),
        taken: 0,
        offered: false,
        cores: Default::default(),
        opening: None,
        rendered: None,
        leaving: None,
        chance: Chance(0x9e37_79b9_7f4a_7c15 ^ (number as u64 + 1)),
    };
    let all = dealt(work, |work| work.entries.len() + 8);
    let mut lanes: Vec<Lane> = all.into_iter().enumerate().map(lane).collect();
    let mut simulator = Simulator::new(netlist);
    simulator.settle();
    simulator.clock();
    reset.set(&mut simulator, &[1; LANES]);
    out_ready.set(&mut simulator, &[1; LANES]);
    let mut meter = Meter::new(netlist, ACTIONS, WINDOW);
    let mut records = vec![vec![0u32; (NUMBERS * width).div_ceil(32)]; LANES];
    let (mut ops, mut bitmaps, mut sizes) = ([0u64; LANES], [0u64; LANES], [[0u64; 2]; LANES]);
    let mut patience = Patience::default();
    simulator.count_anew();
    // Lanes that are done would idle: the run ends with the first of them.
    for cycle in 0u64.. {
        if lanes.iter().any(Lane::is_done) {
            break;
        }
        // Stretches without pauses, with some, and mostly pauses take turns.
        let mostly = [0, 4, 7][(cycle / 960 % 3) as usize];
        let mut valids = [0u64; LANES];
        for (i, lane) in lanes.iter_mut().enumerate() {
            let Some(work) = lane.work.front() else { continue };
            lane.offered |= lane.chance.below(8) >= mostly;
            if !lane.offered {
                continue;
            }
            valids[i] = 1;
            ops[i] = match lane.taken {
                0 => OPEN,
                n if n <= work.entries.len() => SPLAT,
                _ => CLOSE,
            };
            if ops[i] == OPEN {
                sizes[i] = work.size.map(u64::from);
            }
            if ops[i] == SPLAT {
                let (numbers, subtiles) = &work.entries[lane.taken - 1];
                let numbers = numbers.iter().map(|&number| u32::from(number));
                side_by_side(numbers, width, &mut records[i]);
                bitmaps[i] = u64::from(*subtiles);
            }
        }
        valid.set(&mut simulator, &valids);
        op.set(&mut simulator, &ops);
        record.set_words(&mut simulator, &records);
        bitmap.set(&mut simulator, &bitmaps);
        columns.set(&mut simulator, &sizes.map(|size| size[0]));
        rows.set(&mut simulator, &sizes.map(|size| size[1]));
        for (s, ports) in ports.iter().enumerate() {
            let of = |is: &dyn Fn(&Lane) -> bool| -> [u64; LANES] {
                std::array::from_fn(|i| u64::from(is(&lanes[i])))
            };
            let ready = of(&|lane| lane.leaving.is_none() && lane.cores[s].free <= cycle);
            let stopped = of(&|lane| lane.cores[s].stopped.is_some_and(|at| at <= cycle));
            let leaves =
                of(&|lane| lane.leaving.is_some_and(|[first, end]| (first..end).contains(&cycle)));
            for core in 0..CORES {
                ports.ready[core].set(&mut simulator, &ready);
                ports.stopped[core].set(&mut simulator, &stopped);
                ports.out_valid[core].set(&mut simulator, &leaves);
            }
        }
        simulator.settle();
        let accepts = ready.bit(&simulator);
        let leaves = out_valid.bit(&simulator);
        let mut moved = false;
        for (s, ports) in ports.iter().enumerate() {
            let valid = ports.valid.bit(&simulator);
            for (i, lane) in lanes.iter_mut().enumerate() {
                if valid >> i & 1 == 0 || lane.leaving.is_some() || lane.cores[s].free > cycle {
                    continue;
                }
                match ports.op.value(&simulator, i) {
                    OPEN if s + 1 == SUBTILES => {
                        lane.open()?;
                        meter.count(1, 1);
                    }
                    OPEN => {}
                    SPLAT => {
                        let work = due(lane.rendered, "a splat enters a sub-tile of no tile")?;
                        let cores = &mut lane.cores[s];
                        let at = due(cores.expected.pop_front(), "a sub-tile is given too much")?;
                        let (numbers, _) = &work.entries[at];
                        for (place, number) in numbers.iter().enumerate() {
                            let found = ports.record.part(&simulator, i, place * width, width);
                            must(found == u64::from(*number), "a sub-tile is given another splat")?;
                        }
                        (cores.free, cores.worked) = (cycle + PIXELS, true);
                        if work.ends[s].is_some_and(|end| at + 1 >= end) {
                            cores.stopped.get_or_insert(cycle + STOPS);
                        }
                        meter.count(3, 1);
                    }
                    // All sub-tiles see it in the same cycle; the last one notes it.
                    _ if s + 1 == SUBTILES => {
                        let worked = lane.cores.iter().any(|cores| cores.worked);
                        let first = cycle + if worked { DRAINS } else { 2 };
                        lane.leaving = Some([first, first + PIXELS]);
                    }
                    _ => {}
                }
            }
        }
        for (i, lane) in lanes.iter_mut().enumerate() {
            if leaves >> i & 1 == 1 && lane.leaving.is_some_and(|[_, end]| end == cycle + 1) {
                lane.close()?;
            }
            if valids[i] == 0 || accepts >> i & 1 == 0 {
                continue;
            }
            (lane.offered, moved) = (false, true);
            let work = *lane.work.front().expect("it was offered");
            match ops[i] {
                OPEN => lane.opening = Some(work),
                SPLAT => meter.count(2, 1),
                _ => {
                    lane.work.pop_front();
                    lane.taken = 0;
                    continue;
                }
            }
            lane.taken += 1;
        }
        patience.cycle(moved)?;
        simulator.clock();
        meter.cycle(&mut simulator);
    }
    Ok(meter.measured())
}
