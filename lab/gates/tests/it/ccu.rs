//! The committed netlist of the culling and conversion unit against `powergs-datapath`, in 64
//! lanes.

use std::collections::VecDeque;

use powergs_datapath::ccu::{Ccu, Gaussian, Settings, camera};
use powergs_datapath::{NumberFormat, WideFormat};
use rand::{Rng, RngExt};
use rand_pcg::Pcg64Mcg;

use super::unit::{LANES, LIBRARIES, Unit};

/// Gaussians of a lane.
const GAUSSIANS: usize = 20;
/// The SH degree.
const DEGREE: u32 = 3;

fn unit() -> Ccu {
    let wide = WideFormat::new(8, 15).expect("a format");
    Ccu::new(wide, NumberFormat::FP16).expect("formats that fit")
}

fn view(ccu: &Ccu) -> Settings {
    let rotation = [[0.96, 0.0, 0.28], [0.0, 1.0, 0.0], [-0.28, 0.0, 0.96]];
    camera(ccu.wide(), [0.1, -0.2, 0.0], rotation, [200.0; 2], [64.0, 48.0], [128, 96])
}

/// A Gaussian around what the camera sees; now and then with a number of any bits.
fn gaussian(ccu: &Ccu, random: &mut Pcg64Mcg) -> Gaussian {
    let w = ccu.wide();
    let mut one = || 2.0 * random.random::<f64>() - 1.0;
    let depth = 4.0 * one() + 3.0;
    let mean = [depth * (0.4 * one() - 0.3), 0.4 * depth * one(), depth];
    let scales = [0; 3].map(|_| (2.5 * one() - 5.0).exp2());
    let q = [0; 4].map(|_| one());
    let n = q.iter().map(|v| v * v).sum::<f64>().sqrt() / 2f64.sqrt();
    let mut shape = [0; 8];
    let numbers = scales.into_iter().chain(q.map(|v| v / n)).chain([one().abs()]);
    shape.iter_mut().zip(numbers).for_each(|(bits, number)| *bits = w.from_f64(number));
    let mean = mean.map(|m| w.from_f64(m));
    if random.random_range(0..8) == 0 {
        shape[random.random_range(0..8)] = random.next_u32() & 0x00ff_ffff;
    }
    Gaussian { mean, shape }
}

/// Numbers of so many bits side by side, as words of a port.
fn side_by_side(numbers: &[u32], bits: usize) -> Vec<u32> {
    let mut words = vec![0; (numbers.len() * bits).div_ceil(32)];
    for (i, number) in numbers.iter().enumerate() {
        for bit in 0..bits {
            let at = i * bits + bit;
            words[at / 32] |= (number >> bit & 1) << (at % 32);
        }
    }
    words
}

/// What a lane gets and what must leave.
#[derive(Default)]
struct Lane {
    means: VecDeque<Vec<u32>>,
    shapes: VecDeque<Vec<u32>>,
    coefficients: VecDeque<Vec<u32>>,
    verdicts: VecDeque<bool>,
    /// Shapes that may be offered: means of which the verdict has left.
    open: usize,
    splats: VecDeque<[u32; 5]>,
    pairs: VecDeque<[u64; 6]>,
    colours: VecDeque<u64>,
}

impl Lane {
    fn new(ccu: &Ccu, settings: &Settings, random: &mut Pcg64Mcg) -> Lane {
        let mut lane = Lane::default();
        let mut seen = 0;
        for _ in 0..GAUSSIANS {
            let any = gaussian(ccu, random);
            lane.means.push_back(side_by_side(&any.mean, 24));
            let kept = ccu.cull(settings, &any.mean).kept;
            lane.verdicts.push_back(kept);
            if kept {
                lane.shapes.push_back(side_by_side(&any.shape, 24));
            }
            let Some((splat, walk)) = ccu.splat(settings, &any) else { continue };
            let f = ccu.narrow();
            let coefficients = std::array::from_fn(|_| f.from_f32(random.random::<f32>() - 0.4));
            let numbers: Vec<u32> = coefficients.iter().map(|&c| u32::from(c)).collect();
            lane.coefficients.push_back(side_by_side(&numbers, 16));
            let [a, b, c] = splat.root.map(u32::from);
            let record = [u32::from(splat.depth), a, b, c, u32::from(splat.opacity)];
            lane.splats.push_back(record);
            lane.pairs.extend(walk.pairs(f).iter().map(|pair| {
                let [x, y] = pair.tile.map(u64::from);
                let [u, v] = pair.local.map(u64::from);
                [seen, x, y, u64::from(pair.subtiles), u, v]
            }));
            let colour = ccu.colour(DEGREE, &splat.direction, &coefficients).map(u64::from);
            lane.colours.push_back(colour[0] | colour[1] << 16 | colour[2] << 32);
            seen += 1;
        }
        lane
    }

    fn is_done(&self) -> bool {
        self.verdicts.is_empty()
            && self.splats.is_empty()
            && self.pairs.is_empty()
            && self.colours.is_empty()
    }
}

/// Culls, projects, tests and colours in every lane; all sides are stalled at random.
fn convert(library: &str) {
    let ccu = unit();
    let settings = view(&ccu);
    let mut unit = Unit::new("ccu", library);
    let mut lanes: Vec<Lane> =
        (0..LANES).map(|_| Lane::new(&ccu, &settings, &mut unit.random)).collect();
    let all = vec![side_by_side(&settings.numbers, 24); LANES];
    unit.set_words("settings", &all);
    unit.set("tiles_x", &[u64::from(settings.tiles[0]); LANES]);
    unit.set("tiles_y", &[u64::from(settings.tiles[1]); LANES]);
    unit.set("degree", &[u64::from(DEGREE); LANES]);
    let mut offered = [[false; 3]; LANES];
    let mut cycles = 0;
    while !lanes.iter().all(Lane::is_done) {
        let coins: [[u64; LANES]; 3] = std::array::from_fn(|_| unit.coins());
        for (i, lane) in lanes.iter().enumerate() {
            let there = [!lane.means.is_empty(), lane.open > 0, !lane.coefficients.is_empty()];
            for port in 0..3 {
                // What is offered stays.
                offered[i][port] |= there[port] && coins[port][i] == 1;
            }
        }
        let ports = ["mean", "shape", "coefficients"];
        for (port, name) in ports.iter().enumerate() {
            let valid = std::array::from_fn(|lane| u64::from(offered[lane][port]));
            unit.set(&format!("{name}_valid"), &valid);
            let word = |lane: &Lane| {
                let queue = [&lane.means, &lane.shapes, &lane.coefficients][port];
                queue.front().cloned().unwrap_or_default()
            };
            let words: Vec<Vec<u32>> = lanes.iter().map(word).collect();
            unit.set_words(&format!("{name}_data"), &words);
        }
        let goes: [[u64; LANES]; 4] = std::array::from_fn(|_| unit.coins());
        let outputs = ["verdict", "splat", "pair", "colour"];
        for (name, goes) in outputs.iter().zip(&goes) {
            unit.set(&format!("{name}_ready"), goes);
        }
        unit.simulator.settle();
        let taken = ports.map(|name| unit.get(&format!("{name}_ready")));
        let leaves = outputs.map(|name| unit.get(&format!("{name}_valid")));
        let kept = unit.get("verdict_kept");
        let splats = unit.rows("splat_data");
        let pairs =
            ["splat", "x", "y", "subtiles", "u", "v"].map(|name| unit.get(&format!("pair_{name}")));
        let colours = unit.get("colour_data");
        for (i, lane) in lanes.iter_mut().enumerate() {
            for port in 0..3 {
                if offered[i][port] && taken[port][i] == 1 {
                    offered[i][port] = false;
                    let queues = [&mut lane.means, &mut lane.shapes, &mut lane.coefficients];
                    queues.into_iter().nth(port).expect("a queue").pop_front();
                    lane.open -= usize::from(port == 1);
                }
            }
            let left = |output: usize| leaves[output][i] & goes[output][i] == 1;
            if left(0) {
                assert_eq!(lane.verdicts.pop_front(), Some(kept[i] == 1), "lane {i}");
                lane.open += usize::from(kept[i] == 1);
            }
            if left(1) {
                let [ab, cd, e] = [splats[i][0], splats[i][1], splats[i][2]];
                let splat = [ab & 0xffff, ab >> 16, cd & 0xffff, cd >> 16, e & 0xffff];
                assert_eq!(lane.splats.pop_front(), Some(splat), "lane {i}");
            }
            if left(2) {
                let pair = pairs.map(|part| part[i]);
                assert_eq!(lane.pairs.pop_front(), Some(pair), "lane {i}");
            }
            if left(3) {
                assert_eq!(lane.colours.pop_front(), Some(colours[i]), "lane {i}");
            }
        }
        unit.simulator.clock();
        cycles += 1;
        assert!(cycles < 20_000, "something is missing");
    }
}

#[test]
fn culling_and_conversion_units_convert() {
    LIBRARIES.iter().for_each(|library| convert(library));
}
