//! The culling and conversion unit: the Gaussians of a scene in one view.
//!
//! Each lane gets means, hands a shape to each that is kept, and coefficients to each that is seen;
//! what leaves is compared with what was told. Gaussians come in stretches of a kind (culled,
//! beside the image, in few tiles, in many), and the sides pause in turn, so that windows differ
//! and prices can be told apart. An action is counted half way through the part of the unit that
//! does it.

use std::collections::VecDeque;

use super::lanes::{LANES, Lanes, side_by_side};
use super::qsu::Chance;
use super::{CharacteriseError, Characterised, Measured, Meter, characterise};
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
/// When there are too few, or the netlist is of another unit.
///
/// # Panics
/// When something leaves otherwise than it should: the netlist or the model is wrong.
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
    let port = |name| Lanes::of(netlist, name);
    let ins = [
        (port("mean_valid")?, port("mean_ready")?, port("mean_data")?),
        (port("shape_valid")?, port("shape_ready")?, port("shape_data")?),
        (port("coefficients_valid")?, port("coefficients_ready")?, port("coefficients_data")?),
    ];
    let outs = [
        (port("verdict_valid")?, port("verdict_ready")?),
        (port("splat_valid")?, port("splat_ready")?),
        (port("pair_valid")?, port("pair_ready")?),
        (port("colour_valid")?, port("colour_ready")?),
    ];
    let (kept, splat, colour) = (port("verdict_kept")?, port("splat_data")?, port("colour_data")?);
    let (reset, settings) = (port("rst_n")?, port("settings")?);
    let sizes = [port("tiles_x")?, port("tiles_y")?, port("degree")?];
    let (wide, narrow) = (ins[0].2.bits() / 3, ins[2].2.bits() / 48);
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
    let mut words = vec![0; settings.bits().div_ceil(32)];
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
    let mut data =
        ins.each_ref().map(|(_, _, data)| vec![vec![0; data.bits().div_ceil(32)]; LANES]);
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
        let mut taken = [0u64; 3];
        for (i, lane) in lanes.iter_mut().enumerate() {
            for (side, ready) in ready.iter().enumerate() {
                if !lane.offered[side] || ready >> i & 1 == 0 {
                    continue;
                }
                lane.offered[side] = false;
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
                let gaussian = lane.verdicts.pop_front().expect("a mean has come");
                assert_eq!(kept >> i & 1 == 1, gaussian.shape.is_some(), "it is kept or not");
                if let Some(shape) = gaussian.shape {
                    lane.shapes.push_back(shape);
                    lane.open += 1;
                }
                lane.splats.extend(&gaussian.seen);
            }
            if left(1) {
                let seen = lane.splats.pop_front().expect("a shape has come");
                for (place, number) in seen.splat.iter().enumerate() {
                    let found = splat.part(&simulator, i, place * narrow, narrow);
                    assert_eq!(found, u64::from(*number), "a splat is that of the model");
                }
                meter.count(3, u64::from(seen.candidates));
                lane.pairs += u64::from(seen.pairs);
                lane.colours.push_back((&seen.coefficients, seen.colour));
            }
            if left(2) {
                lane.pairs = lane.pairs.checked_sub(1).expect("no more pairs than in the model");
            }
            if left(3) {
                let expected = lane.painted.pop_front().expect("coefficients have come");
                for (place, number) in expected.iter().enumerate() {
                    let found = colour.part(&simulator, i, place * narrow, narrow);
                    assert_eq!(found, u64::from(*number), "a colour is that of the model");
                }
            }
        }
        for ((queue, count), action) in waiting.iter_mut().zip(taken).zip([1, 2, 4]) {
            queue.push_back(count);
            meter.count(action, queue.pop_front().expect("as many as cycles of half the way"));
        }
        simulator.clock();
        meter.cycle(&mut simulator);
    }
    Ok(meter.measured())
}
