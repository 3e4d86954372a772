//! The quick sorting unit: lists of keys as they arrive, dealt by seven pivots of their own.
//!
//! Each lane takes one list after the other: it writes seven pivots, quantiles of the list, one a
//! cycle, and then offers a key a cycle, with pauses.

use super::lanes::{LANES, Lanes, dealt};
use super::{
    CharacteriseError, Characterised, Measured, Meter, WINDOW, characterise, divided, must,
};
use crate::netlist::Netlist;
use crate::simulator::Simulator;

const PIVOTS: usize = 7;

/// A cycle, a key, a key of another part than the one before, a pivot.
const ACTIONS: &[&str] = &["cycle", "key", "key-of-another-part", "pivot"];

/// Prices of `netlist`, a mapped `qsu`, on `lists` of 16-bit keys in the order of their arrival.
///
/// # Errors
/// When there are too few keys, or the netlist is of another unit or does something else.
pub fn prices(netlist: &Netlist, lists: &[Vec<u16>]) -> Result<Characterised, CharacteriseError> {
    let [fitted, held_out] = divided(lists);
    let measure = |lists: &[Vec<u16>]| measure(netlist, lists);
    characterise(netlist, &measure(&fitted)?, &measure(&held_out)?)
}

/// Quantiles of a list.
fn pivots(list: &[u16]) -> [u16; PIVOTS] {
    let mut sorted = list.to_vec();
    sorted.sort_unstable();
    std::array::from_fn(|p| sorted[(p + 1) * sorted.len() / (PIVOTS + 1)])
}

/// What a lane does in a cycle.
#[derive(Debug, Clone, Copy)]
enum Step {
    Pivot(usize, u16),
    Key(u16, u64),
    Pause,
}

/// All steps of a lane: its lists one after the other, with pauses that are as long as its number
/// and the window say.
fn steps(lists: &[&Vec<u16>], lane: usize) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut chance = Chance(0x9e37_79b9_7f4a_7c15 ^ (lane as u64 + 1));
    for list in lists.iter().filter(|list| !list.is_empty()) {
        let pivots = pivots(list);
        steps.extend(pivots.iter().enumerate().map(|(p, key)| Step::Pivot(p, *key)));
        // Keys behind the last pivot must not meet the pivots of the next list.
        for (place, &key) in list.iter().enumerate() {
            let part = pivots.iter().filter(|pivot| **pivot <= key).count();
            steps.push(Step::Key(key, (place as u64 & 0xffff) | (part as u64) << 16));
            // Stretches without a pause, with some, and mostly pauses take turns.
            let mostly = [0, 2, 6][place / 48 % 3];
            while chance.below(8) < mostly {
                steps.push(Step::Pause);
            }
        }
        steps.extend([Step::Pause; 2]);
    }
    steps
}

/// A small generator: pauses are the same in every run.
pub(super) struct Chance(pub(super) u64);

impl Chance {
    /// A number below `n`.
    pub(super) fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 32) * n) >> 32
    }
}

fn measure(netlist: &Netlist, lists: &[Vec<u16>]) -> Result<Measured, CharacteriseError> {
    let port = |name, bits| Lanes::of(netlist, name, bits);
    let (reset, pivot_valid, pivot_index, pivot_key) = (
        port("rst_n", 1)?,
        port("pivot_valid", 1)?,
        port("pivot_index", 3)?,
        port("pivot_key", 16)?,
    );
    let (in_valid, in_key, in_payload) =
        (port("in_valid", 1)?, port("in_key", 16)?, port("in_payload", 16)?);
    let (out_ready, out_valid, out_part) =
        (port("out_ready", 1)?, port("out_valid", 1)?, port("out_part", 3)?);
    let out_payload = port("out_payload", 16)?;
    let dealt = dealt(lists, Vec::len);
    let lanes: Vec<Vec<Step>> =
        dealt.iter().enumerate().map(|(lane, lists)| steps(lists, lane)).collect();
    let mut simulator = Simulator::new(netlist);
    simulator.settle();
    simulator.clock();
    reset.set(&mut simulator, &[1; LANES]);
    out_ready.set(&mut simulator, &[1; LANES]);
    let mut meter = Meter::new(netlist, ACTIONS, WINDOW);
    let (mut before, mut held) = ([0u64; LANES], [[0u64; 2]; LANES]);
    // Lanes that are done would idle: the run ends with the first of them.
    let cycles = lanes.iter().map(Vec::len).min().unwrap_or(0);
    simulator.count_anew();
    for cycle in 0..cycles {
        let (mut pivot, mut key) = ([[0u64; 3]; LANES], held);
        let mut valid = [0u64; LANES];
        for (lane, steps) in lanes.iter().enumerate() {
            match steps[cycle] {
                Step::Pivot(p, value) => {
                    pivot[lane] = [1, p as u64, u64::from(value)];
                    meter.count(3, 1);
                }
                Step::Key(value, payload) => {
                    (valid[lane], key[lane]) = (1, [u64::from(value), payload]);
                    let part = payload >> 16;
                    meter.count(1, 1);
                    meter.count(2, u64::from(part != before[lane]));
                    before[lane] = part;
                }
                Step::Pause => {}
            }
        }
        held = key;
        pivot_valid.set(&mut simulator, &pivot.map(|pivot| pivot[0]));
        pivot_index.set(&mut simulator, &pivot.map(|pivot| pivot[1]));
        pivot_key.set(&mut simulator, &pivot.map(|pivot| pivot[2]));
        in_valid.set(&mut simulator, &valid);
        in_key.set(&mut simulator, &key.map(|key| key[0]));
        in_payload.set(&mut simulator, &key.map(|key| key[1]));
        simulator.settle();
        if let Some(back) = cycle.checked_sub(2) {
            let out = out_valid.bit(&simulator);
            for (lane, steps) in lanes.iter().enumerate() {
                let Step::Key(_, payload) = steps[back] else { continue };
                must(out >> lane & 1 == 1, "a key does not leave two cycles after it came")?;
                let left =
                    out_part.value(&simulator, lane) << 16 | out_payload.value(&simulator, lane);
                must(left == payload, "a key leaves in another part")?;
            }
        }
        simulator.clock();
        meter.cycle(&mut simulator);
    }
    Ok(meter.measured())
}
