//! The volume-rendering core: splats of a sub-tile, front to back, blended into the pixels of one
//! core.
//!
//! Each lane takes one piece of work after the other: it opens a tile, offers its splats with
//! pauses, closes it, and compares the pixels that leave with those that it was told. What becomes
//! of a splat at a pixel is told too; it is counted where the splat is half way through the
//! pipeline, because what it costs is spread over all of it.

use std::collections::VecDeque;

use super::lanes::{LANES, Lanes, Patience, dealt, side_by_side};
use super::qsu::Chance;
use super::{CharacteriseError, Characterised, Measured, Meter, characterise, divided, must};
use crate::netlist::Netlist;
use crate::simulator::Simulator;

/// A cycle; a tile that opens, closes and whose pixels leave; and a slot, which is a splat at a
/// pixel: of a pixel that has stopped before or is outside of the image, dropped because its α is
/// below 1/255, blended, or the one that stops its pixel. Slots have their share of taking the
/// record.
const ACTIONS: &[&str] = &["cycle", "tile", "stopped-slot", "dropped", "blended", "stopping"];

/// Cycles of a window: several times the pipeline.
const WINDOW: u64 = 96;
/// Cycles from the acceptance of a splat to where it is counted.
const HALF_WAY: usize = 16;
/// Numbers of a record.
const NUMBERS: usize = 9;

/// What one core does in one tile.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Work {
    /// Column and row of its first pixel in the tile.
    pub place: [u8; 2],
    /// Its pixels that are inside the image, from the lowest bit.
    pub mask: u64,
    /// Its splats, front to back.
    pub splats: Vec<Splat>,
    /// Red, green, blue and transmittance of each of its pixels behind the last splat.
    pub pixels: Vec<[u16; 4]>,
}

/// A splat, and what becomes of it at the pixels of the core.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Splat {
    /// Its record: u0, v0; a, b, c; opacity; red, green, blue.
    pub numbers: [u16; NUMBERS],
    /// Pixels that had stopped, where it is dropped, blended, and that stop with it.
    pub outcomes: [u8; 4],
}

/// Prices of `netlist`, a mapped `vrc`, on `work` of cores of as many pixels.
///
/// # Errors
/// When there is too little work, or the netlist is of another unit or does something else.
pub fn prices(netlist: &Netlist, work: &[Work]) -> Result<Characterised, CharacteriseError> {
    let [fitted, held_out] = divided(work);
    let measure = |work: &[Work]| measure(netlist, work);
    characterise(netlist, &measure(&fitted)?, &measure(&held_out)?)
}

const OPEN: u64 = 0;
const SPLAT: u64 = 1;
const CLOSE: u64 = 2;

/// A lane: what it still has to do.
struct Lane<'a> {
    work: VecDeque<&'a Work>,
    /// What it is at, and how many of its beats have been taken.
    at: Option<(&'a Work, usize)>,
    /// Pixels that will leave.
    expected: VecDeque<u64>,
    offered: bool,
    chance: Chance,
}

impl<'a> Lane<'a> {
    fn new(number: usize, work: Vec<&'a Work>) -> Lane<'a> {
        Lane {
            work: work.into(),
            at: None,
            expected: VecDeque::new(),
            offered: false,
            chance: Chance(0x9e37_79b9_7f4a_7c15 ^ (number as u64 + 1)),
        }
    }

    /// The next beat; `None` while pixels leave, or when all is done.
    fn beat(&self) -> Option<(u64, Option<&'a Splat>)> {
        let (work, taken) = self.at?;
        Some(match taken {
            0 => (OPEN, None),
            n if n <= work.splats.len() => (SPLAT, Some(&work.splats[n - 1])),
            _ => (CLOSE, None),
        })
    }

    fn is_done(&self) -> bool {
        self.at.is_none() && self.expected.is_empty() && self.work.is_empty()
    }
}

fn measure(netlist: &Netlist, work: &[Work]) -> Result<Measured, CharacteriseError> {
    let port = |name, bits| Lanes::of(netlist, name, bits);
    let (reset, valid, ready) = (port("rst_n", 1)?, port("in_valid", 1)?, port("in_ready", 1)?);
    let (record, width) = Lanes::numbers(netlist, "in_record", NUMBERS, 16)?;
    let (op, x, y) = (port("in_op", 2)?, port("open_x", 4)?, port("open_y", 4)?);
    let mask = Lanes::sized(netlist, "open_mask", |n| n == 4 || n == 16, || "4 or 16".into())?;
    let (out_valid, out_ready, out_pixel) =
        (port("out_valid", 1)?, port("out_ready", 1)?, port("out_pixel", 4 * width)?);
    let all = dealt(work, |work| work.splats.len() + 8);
    // `dealt` gives the longest first; lanes take them so.
    let mut lanes: Vec<Lane> =
        all.into_iter().enumerate().map(|(number, work)| Lane::new(number, work)).collect();
    let mut simulator = Simulator::new(netlist);
    simulator.settle();
    simulator.clock();
    reset.set(&mut simulator, &[1; LANES]);
    out_ready.set(&mut simulator, &[1; LANES]);
    let mut meter = Meter::new(netlist, ACTIONS, WINDOW);
    let mut waiting: VecDeque<[u64; 5]> = vec![[0; 5]; HALF_WAY].into();
    let mut records = [[0u32; 16]; LANES];
    let mut patience = Patience::default();
    let (mut ops, mut places, mut masks) = ([0u64; LANES], [[0u64; 2]; LANES], [0u64; LANES]);
    simulator.count_anew();
    // Lanes that are done would idle: the run ends with the first of them.
    for cycle in 0u64.. {
        let mut valids = [0u64; LANES];
        // Stretches without pauses, with some, and mostly pauses take turns.
        let mostly = [0, 2, 6][(cycle / 480 % 3) as usize];
        for (number, lane) in lanes.iter_mut().enumerate() {
            if lane.at.is_none() && lane.expected.is_empty() {
                lane.at = lane.work.pop_front().map(|work| (work, 0));
            }
            let Some((beat, splat)) = lane.beat() else { continue };
            // A core takes a splat in several cycles: so pauses are as long as some splats.
            lane.offered |= cycle.is_multiple_of(4) && lane.chance.below(8) >= mostly;
            if !lane.offered {
                continue;
            }
            (valids[number], ops[number]) = (1, beat);
            if let Some(splat) = splat {
                let numbers = splat.numbers.iter().map(|&number| u32::from(number));
                side_by_side(numbers, width, &mut records[number]);
            }
            if let Some((work, 0)) = lane.at {
                places[number] = work.place.map(u64::from);
                masks[number] = work.mask;
            }
        }
        if lanes.iter().any(Lane::is_done) {
            break;
        }
        valid.set(&mut simulator, &valids);
        op.set(&mut simulator, &ops);
        record.set_rows(&mut simulator, &records);
        x.set(&mut simulator, &places.map(|place| place[0]));
        y.set(&mut simulator, &places.map(|place| place[1]));
        mask.set(&mut simulator, &masks);
        simulator.settle();
        let (accepts, leaves) = (ready.bit(&simulator), out_valid.bit(&simulator));
        let (mut now, mut moved) = ([0u64; 5], false);
        for (number, lane) in lanes.iter_mut().enumerate() {
            if leaves >> number & 1 == 1 {
                let found = out_pixel.value(&simulator, number);
                must(Some(found) == lane.expected.pop_front(), "a pixel is another")?;
            }
            if valids[number] == 0 || accepts >> number & 1 == 0 {
                continue;
            }
            let (beat, splat) = lane.beat().expect("it was offered");
            let (work, taken) = lane.at.expect("it was offered");
            (lane.offered, lane.at, moved) = (false, Some((work, taken + 1)), true);
            if let Some(splat) = splat {
                for (count, outcome) in now[1..].iter_mut().zip(splat.outcomes) {
                    *count += u64::from(outcome);
                }
            }
            if beat == CLOSE {
                now[0] += 1;
                lane.at = None;
                let word = |pixel: &[u16; 4]| {
                    (0..).zip(pixel).map(|(i, part)| u64::from(*part) << (i * width)).sum()
                };
                lane.expected = work.pixels.iter().map(word).collect();
            }
        }
        waiting.push_back(now);
        let counted = waiting.pop_front().expect("as many as cycles of half the way");
        (1..).zip(counted).for_each(|(action, count)| meter.count(action, count));
        patience.cycle(moved)?;
        simulator.clock();
        meter.cycle(&mut simulator);
    }
    Ok(meter.measured())
}
