//! The bitonic sorting unit: chunks of up to 256 keys, sorted in rows of 16 and merged.
//!
//! Each lane sorts one chunk after the other, from a buffer of its own: first all rows, then level
//! by level pairs of lists; a level begins when the one before has left. A list without a partner
//! stays where it is. Rows come with pauses, and what leaves is checked.

use std::collections::VecDeque;

use super::lanes::{LANES, Lanes, Patience, dealt};
use super::qsu::Chance;
use super::{
    CharacteriseError, Characterised, Measured, Meter, WINDOW, characterise, divided, must,
};
use crate::netlist::Netlist;
use crate::simulator::Simulator;

/// A cycle, a row that enters to be sorted, an exchange on its way, a row that enters to be merged.
const ACTIONS: &[&str] = &["cycle", "sorted-row", "exchange", "merged-row"];

/// Prices of `netlist`, a mapped `bsu`, on `chunks` of 16-bit keys in the order of their arrival,
/// up to 65,536 in each.
///
/// # Errors
/// When there are too few keys, or the netlist is of another unit or does something else.
pub fn prices(netlist: &Netlist, chunks: &[Vec<u16>]) -> Result<Characterised, CharacteriseError> {
    let [fitted, held_out] = divided(chunks);
    let measure = |chunks: &[Vec<u16>]| measure(netlist, chunks);
    characterise(netlist, &measure(&fitted)?, &measure(&held_out)?)
}

type Row = [u32; 16];

/// Ways into the unit, by port.
/// Bits of a row.
const ROW: usize = 512;
const SORT: usize = 0;
const A: usize = 1;
const B: usize = 2;

/// A lane: what it still has to do, and what is under way.
struct Lane<'a> {
    chunks: VecDeque<&'a Vec<u16>>,
    expected: Vec<u32>,
    /// Rows in front of each port, with whether each is the last of its list.
    feeds: [VecDeque<(Row, bool)>; 3],
    offered: [bool; 3],
    /// Lengths of the lists that will leave, in rows.
    lengths: VecDeque<usize>,
    /// Lists of this level that are complete, and the one that is leaving.
    lists: Vec<Vec<Row>>,
    leaving: Vec<Row>,
    chance: Chance,
    done: bool,
}

impl<'a> Lane<'a> {
    fn new(chunks: Vec<&'a Vec<u16>>, number: usize) -> Lane<'a> {
        let mut lane = Lane {
            chunks: chunks.into_iter().filter(|chunk| !chunk.is_empty()).collect(),
            expected: Vec::new(),
            feeds: Default::default(),
            offered: [false; 3],
            lengths: VecDeque::new(),
            lists: Vec::new(),
            leaving: Vec::new(),
            chance: Chance(0x9e37_79b9_7f4a_7c15 ^ (number as u64 + 1)),
            done: false,
        };
        lane.next_chunk();
        lane
    }

    fn next_chunk(&mut self) {
        self.lists.clear();
        let Some(chunk) = self.chunks.pop_front() else {
            self.done = true;
            return;
        };
        let entry = |(place, key): (usize, &u16)| u32::from(*key) << 16 | place as u32 & 0xffff;
        self.expected = chunk.iter().enumerate().map(entry).collect();
        for entries in self.expected.chunks(16) {
            let mut row = [u32::MAX; 16];
            row[..entries.len()].copy_from_slice(entries);
            self.feeds[SORT].push_back((row, false));
            self.lengths.push_back(1);
        }
        self.expected.sort_unstable();
    }

    /// Pairs of lists to be merged; the next chunk when there is one list left.
    fn next_level(&mut self) -> Result<(), CharacteriseError> {
        if let [list] = self.lists.as_slice() {
            let entries = list.iter().flatten().copied().take(self.expected.len());
            must(entries.eq(self.expected.iter().copied()), "a chunk leaves in another order")?;
            self.next_chunk();
            return Ok(());
        }
        let mut lists = std::mem::take(&mut self.lists).into_iter();
        while let Some(a) = lists.next() {
            let Some(b) = lists.next() else {
                self.lists.push(a);
                break;
            };
            self.lengths.push_back(a.len() + b.len());
            for (port, list) in [(A, a), (B, b)] {
                let rows = list.len();
                let rows = list.into_iter().enumerate().map(|(i, row)| (row, i + 1 == rows));
                self.feeds[port].extend(rows);
            }
        }
        Ok(())
    }

    /// A row has left.
    fn take(&mut self, row: Row) -> Result<(), CharacteriseError> {
        self.leaving.push(row);
        if self.lengths.front() == Some(&self.leaving.len()) {
            self.lengths.pop_front();
            // A list that waits for a partner goes behind the new ones: lists may be of any length.
            self.lists.insert(0, std::mem::take(&mut self.leaving));
            self.lists.rotate_left(1);
        }
        if self.lengths.is_empty() { self.next_level() } else { Ok(()) }
    }
}

/// Exchanges of the ten stages on a row, which is brought in order.
fn exchanges(row: &mut Row) -> u64 {
    const STAGES: [(usize, usize); 10] =
        [(1, 2), (2, 4), (1, 4), (4, 8), (2, 8), (1, 8), (8, 16), (4, 16), (2, 16), (1, 16)];
    let mut count = 0;
    for (distance, block) in STAGES {
        for i in (0..16).filter(|i| i & distance == 0) {
            let up = i & block == 0;
            let swapped = row[i + distance] < row[i];
            count += u64::from(swapped);
            if swapped == up {
                row.swap(i, i + distance);
            }
        }
    }
    count
}

fn measure(netlist: &Netlist, chunks: &[Vec<u16>]) -> Result<Measured, CharacteriseError> {
    let port = |name, bits| Lanes::of(netlist, name, bits);
    let ways = [
        (port("sort_valid", 1)?, port("sort_ready", 1)?, port("sort_row", ROW)?),
        (port("a_valid", 1)?, port("a_ready", 1)?, port("a_row", ROW)?),
        (port("b_valid", 1)?, port("b_ready", 1)?, port("b_row", ROW)?),
    ];
    let lasts = [port("a_last", 1)?, port("b_last", 1)?];
    let (out_valid, out_ready, out_row) =
        (port("out_valid", 1)?, port("out_ready", 1)?, port("out_row", ROW)?);
    let reset = port("rst_n", 1)?;
    let dealt = dealt(chunks, Vec::len);
    let mut lanes: Vec<Lane> =
        dealt.into_iter().enumerate().map(|(number, chunks)| Lane::new(chunks, number)).collect();
    let mut simulator = Simulator::new(netlist);
    simulator.settle();
    simulator.clock();
    reset.set(&mut simulator, &[1; LANES]);
    out_ready.set(&mut simulator, &[1; LANES]);
    let mut meter = Meter::new(netlist, ACTIONS, WINDOW);
    let mut held = [[[0u32; 16]; LANES]; 3];
    let mut patience = Patience::default();
    simulator.count_anew();
    // Lanes that are done would idle: the run ends with the first of them.
    for cycle in 0u64.. {
        if lanes.iter().any(|lane| lane.done) {
            break;
        }
        let mut last = [[0u64; LANES]; 2];
        for (way, (valid, _, row)) in ways.iter().enumerate() {
            let mut offers = [0u64; LANES];
            for (number, lane) in lanes.iter_mut().enumerate() {
                // Windows without pauses, with some, and mostly pauses take turns.
                let mostly = [0, 2, 6][(cycle / 96 % 3) as usize];
                let comes = lane.chance.below(8) >= mostly;
                lane.offered[way] |= comes && !lane.feeds[way].is_empty();
                if !lane.offered[way] {
                    continue;
                }
                let (row, ends) = lane.feeds[way][0];
                (offers[number], held[way][number]) = (1, row);
                if way != SORT {
                    last[way - 1][number] = u64::from(ends);
                }
            }
            valid.set(&mut simulator, &offers);
            row.set_rows(&mut simulator, &held[way]);
        }
        lasts.iter().zip(&last).for_each(|(port, last)| port.set(&mut simulator, last));
        simulator.settle();
        let out = out_valid.bit(&simulator);
        let mut moved = false;
        let ready: [u64; 3] = std::array::from_fn(|way| ways[way].1.bit(&simulator));
        for (number, lane) in lanes.iter_mut().enumerate() {
            for (way, ready) in ready.iter().enumerate() {
                if lane.offered[way] && ready >> number & 1 == 1 {
                    (lane.offered[way], moved) = (false, true);
                    let (mut row, _) = lane.feeds[way].pop_front().expect("it was offered");
                    if way == SORT {
                        meter.count(1, 1);
                        meter.count(2, exchanges(&mut row));
                    } else {
                        meter.count(3, 1);
                    }
                }
            }
            if out >> number & 1 == 1 {
                lane.take(out_row.row(&simulator, number))?;
            }
        }
        patience.cycle(moved)?;
        simulator.clock();
        meter.cycle(&mut simulator);
    }
    Ok(meter.measured())
}
