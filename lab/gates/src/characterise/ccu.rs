//! The culling and conversion unit: the Gaussians of a scene in one view.
//!
//! Each lane gets means, hands a shape to each that is kept, and coefficients to each that is seen;
//! what leaves is compared with what was told. Gaussians come in stretches of a kind (culled,
//! beside the image, in few tiles, in many), and the sides pause in turn, so that windows differ
//! and prices can be told apart. An action is counted half way through the part of the unit that
//! does it.

use std::collections::VecDeque;

use super::lanes::{LANES, Lanes, Patience, side_by_side};
use super::qsu::Chance;
use super::{CharacteriseError, Characterised, Measured, Meter, characterise, due, must};
use crate::netlist::Netlist;
use crate::simulator::Simulator;

/// A cycle; a Gaussian that is culled, one that is kept and projected, a tile that is tested
/// against its box, a colour.
const ACTIONS: &[&str] = &["cycle", "culled", "projected", "tested", "coloured"];

/// Cycles of a window: several times the pipeline.
const WINDOW: u64 = 480;
/// Cycles from the entry of a mean, a shape and coefficients to where they are counted.
const HALF_WAY: [usize; 3] = [12, 60, 26];
/// Gaussians of a kind that follow each other.
const STRETCH: usize = 24;
/// From so many tiles on a splat is large.
const MANY: u32 = 6;

/// A camera, as the unit takes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct View {
    /// Its numbers.
    pub numbers: Vec<u32>,
    /// Columns and rows of tiles.
    pub tiles: [u32; 2],
    /// SH degree of the colours.
    pub degree: u32,
}

/// A Gaussian, and what becomes of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gaussian {
    /// Its mean.
    pub mean: [u32; 3],
    /// Standard deviations, quaternion, opacity; `None` where it is culled.
    pub shape: Option<[u32; 8]>,
    /// What leaves where it is seen.
    pub seen: Option<Seen>,
}

/// What leaves for a splat.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seen {
    /// Depth; a, b, c; opacity.
    pub splat: [u16; 5],
    /// Tiles under its square.
    pub candidates: u32,
    /// Pairs with tiles: their number.
    pub pairs: u32,
    /// Coefficients, three channels of each.
    pub coefficients: Vec<u16>,
    /// Its colour.
    pub colour: [u16; 3],
}

/// Prices of `netlist`, a mapped `ccu`, on the Gaussians of a view.
///
/// # Errors
/// When there are too few, or the netlist is of another unit or does something else.
pub fn prices(
    netlist: &Netlist,
    view: &View,
    gaussians: &[Gaussian],
) -> Result<Characterised, CharacteriseError> {
    let part = |held_out: bool| -> Vec<&Gaussian> {
        let all = gaussians.iter().enumerate();
        all.filter(|(i, _)| (i % 4 == 3) == held_out).map(|(_, gaussian)| gaussian).collect()
    };
    let measure = |part| measure(netlist, view, part);
    characterise(netlist, &measure(part(false))?, &measure(part(true))?)
}

/// In stretches of a kind, for every lane.
fn dealt(gaussians: Vec<&Gaussian>) -> Vec<VecDeque<&Gaussian>> {
    let kind = |gaussian: &Gaussian| match (&gaussian.shape, &gaussian.seen) {
        (None, _) => 0,
        (Some(_), None) => 1,
        (Some(_), Some(seen)) if seen.candidates < MANY => 2,
        (Some(_), Some(_)) => 3,
    };
    let mut kinds: [Vec<&Gaussian>; 4] = Default::default();
    gaussians.into_iter().for_each(|gaussian| kinds[kind(gaussian)].push(gaussian));
    let share = kinds.each_ref().map(|kind| kind.len() / LANES);
    let lane = |lane: usize| {
        let mut parts = [0, 1, 2, 3].map(|k| kinds[k][lane * share[k]..][..share[k]].iter());
        let mut all = VecDeque::new();
        while parts.iter().any(|part| part.len() > 0) {
            parts.iter_mut().for_each(|part| all.extend(part.by_ref().take(STRETCH).copied()));
        }
        all
    };
    (0..LANES).map(lane).collect()
}

/// A lane: what it offers, and what must leave.
struct Lane<'a> {
    all: VecDeque<&'a Gaussian>,
    shapes: VecDeque<[u32; 8]>,
    /// Shapes that may be offered: their verdict has left.
    open: usize,
    colours: VecDeque<(&'a [u16], [u16; 3])>,
    verdicts: VecDeque<&'a Gaussian>,
    /// Splats and their candidates.
    splats: VecDeque<&'a Seen>,
    /// Colours that must leave.
    painted: VecDeque<[u16; 3]>,
    /// Pairs that are still to leave.
    pairs: u64,
    offered: [bool; 3],
    chance: Chance,
}

fn measure(
    netlist: &Netlist,
    view: &View,
    gaussians: Vec<&Gaussian>,
) -> Result<Measured, CharacteriseError> {
    let port = |name, bits| Lanes::of(netlist, name, bits);
    let (means, wide) = Lanes::numbers(netlist, "mean_data", 3, 32)?;
    let (coefficients, narrow) = Lanes::numbers(netlist, "coefficients_data", 48, 16)?;
    let bits = [3 * wide, 8 * wide, 48 * narrow];
    let side = |valid, ready, data| Ok((port(valid, 1)?, port(ready, 1)?, data));
    let ins = [
        side("mean_valid", "mean_ready", means)?,
        side("shape_valid", "shape_ready", port("shape_data", bits[1])?)?,
        side("coefficients_valid", "coefficients_ready", coefficients)?,
    ];
    let out = |valid, ready| Ok((port(valid, 1)?, port(ready, 1)?));
    let outs = [
        out("verdict_valid", "verdict_ready")?,
        out("splat_valid", "splat_ready")?,
        out("pair_valid", "pair_ready")?,
        out("colour_valid", "colour_ready")?,
    ];
    let kept = port("verdict_kept", 1)?;
    let (splat, colour) = (port("splat_data", 5 * narrow)?, port("colour_data", 3 * narrow)?);
    let (reset, settings) = (port("rst_n", 1)?, port("settings", view.numbers.len() * wide)?);
    let sizes = [port("tiles_x", 9)?, port("tiles_y", 9)?, port("degree", 2)?];
    let lane = |(number, all): (usize, VecDeque<_>)| Lane {
        all,
        shapes: VecDeque::new(),
        open: 0,
        colours: VecDeque::new(),
        verdicts: VecDeque::new(),
        splats: VecDeque::new(),
        painted: VecDeque::new(),
        pairs: 0,
        offered: [false; 3],
        chance: Chance(0x9e37_79b9_7f4a_7c15 ^ (number as u64 + 1)),
    };
    let mut lanes: Vec<Lane> = dealt(gaussians).into_iter().enumerate().map(lane).collect();
    let mut simulator = Simulator::new(netlist);
    let mut words = vec![0; (view.numbers.len() * wide).div_ceil(32)];
    side_by_side(view.numbers.iter().copied(), wide, &mut words);
    settings.set_words(&mut simulator, &vec![words; LANES]);
    for (port, value) in sizes.iter().zip([view.tiles[0], view.tiles[1], view.degree]) {
        port.set(&mut simulator, &[u64::from(value); LANES]);
    }
    simulator.settle();
    simulator.clock();
    reset.set(&mut simulator, &[1; LANES]);
    outs.iter().for_each(|(_, ready)| ready.set(&mut simulator, &[1; LANES]));
    let mut meter = Meter::new(netlist, ACTIONS, WINDOW);
    let mut waiting: [VecDeque<u64>; 3] = HALF_WAY.map(|cycles| vec![0; cycles].into());
    let mut data = bits.map(|bits| vec![vec![0; bits.div_ceil(32)]; LANES]);
    let mut patience = Patience::default();
    simulator.count_anew();
    // Lanes that are done would idle: the run ends with the first of them.
    for cycle in 0u64.. {
        if lanes.iter().any(|lane| lane.all.is_empty()) {
            break;
        }
        // All sides at once, one side at a time, none, in turn.
        let mostly = [[0, 0, 0], [6, 0, 0], [0, 6, 0], [0, 0, 6], [2, 2, 2], [8, 8, 8]]
            [(cycle / 1440 % 6) as usize];
        let mut valids = [[0u64; LANES]; 3];
        for (i, lane) in lanes.iter_mut().enumerate() {
            let there = [!lane.all.is_empty(), lane.open > 0, !lane.colours.is_empty()];
            for side in 0..3 {
                let comes = cycle.is_multiple_of(4) && lane.chance.below(8) >= mostly[side];
                if there[side] && comes && !lane.offered[side] {
                    lane.offered[side] = true;
                    let words = &mut data[side][i];
                    match side {
                        0 => side_by_side(lane.all[0].mean.iter().copied(), wide, words),
                        1 => side_by_side(lane.shapes[0].iter().copied(), wide, words),
                        _ => {
                            let numbers = lane.colours[0].0.iter().map(|&c| u32::from(c));
                            side_by_side(numbers, narrow, words);
                        }
                    }
                }
                valids[side][i] = u64::from(lane.offered[side]);
            }
        }
        for (side, (valid, _, port)) in ins.iter().enumerate() {
            valid.set(&mut simulator, &valids[side]);
            port.set_words(&mut simulator, &data[side]);
        }
        simulator.settle();
        let ready: [u64; 3] = std::array::from_fn(|side| ins[side].1.bit(&simulator));
        let leaves: [u64; 4] = std::array::from_fn(|side| outs[side].0.bit(&simulator));
        let kept = kept.bit(&simulator);
        let (mut taken, mut moved) = ([0u64; 3], false);
        for (i, lane) in lanes.iter_mut().enumerate() {
            for (side, ready) in ready.iter().enumerate() {
                if !lane.offered[side] || ready >> i & 1 == 0 {
                    continue;
                }
                (lane.offered[side], moved) = (false, true);
                match side {
                    0 => {
                        let gaussian = lane.all.pop_front().expect("it was offered");
                        taken[0] += u64::from(gaussian.shape.is_none());
                        lane.verdicts.push_back(gaussian);
                    }
                    1 => {
                        lane.shapes.pop_front();
                        lane.open -= 1;
                        taken[1] += 1;
                    }
                    _ => {
                        let (_, colour) = lane.colours.pop_front().expect("it was offered");
                        lane.painted.push_back(colour);
                        taken[2] += 1;
                    }
                }
            }
            let left = |side: usize| leaves[side] >> i & 1 == 1;
            if left(0) {
                let gaussian = due(lane.verdicts.pop_front(), "a verdict leaves of nothing")?;
                must(kept >> i & 1 == u64::from(gaussian.shape.is_some()), "a verdict is another")?;
                if let Some(shape) = gaussian.shape {
                    lane.shapes.push_back(shape);
                    lane.open += 1;
                }
                lane.splats.extend(&gaussian.seen);
            }
            if left(1) {
                let seen = due(lane.splats.pop_front(), "a splat leaves of nothing")?;
                for (place, number) in seen.splat.iter().enumerate() {
                    let found = splat.part(&simulator, i, place * narrow, narrow);
                    must(found == u64::from(*number), "a splat is another")?;
                }
                meter.count(3, u64::from(seen.candidates));
                lane.pairs += u64::from(seen.pairs);
                lane.colours.push_back((&seen.coefficients, seen.colour));
            }
            if left(2) {
                lane.pairs = due(lane.pairs.checked_sub(1), "a splat has too many pairs")?;
            }
            if left(3) {
                let expected = due(lane.painted.pop_front(), "a colour leaves of nothing")?;
                for (place, number) in expected.iter().enumerate() {
                    let found = colour.part(&simulator, i, place * narrow, narrow);
                    must(found == u64::from(*number), "a colour is another")?;
                }
            }
        }
        for ((queue, count), action) in waiting.iter_mut().zip(taken).zip([1, 2, 4]) {
            queue.push_back(count);
            meter.count(action, queue.pop_front().expect("as many as cycles of half the way"));
        }
        patience.cycle(moved)?;
        simulator.clock();
        meter.cycle(&mut simulator);
    }
    Ok(meter.measured())
}
