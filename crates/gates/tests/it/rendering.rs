//! The committed netlists of FP16 arithmetic and of the volume-rendering core against
//! `powergs-datapath`, in 64 lanes.

use std::collections::VecDeque;

use powergs_datapath::{NumberFormat, Pixel, Record, Vrc};
use rand::{Rng, RngExt};
use rand_pcg::Pcg64Mcg;

use super::unit::{LANES, LIBRARIES, Unit};

const FP16: NumberFormat = NumberFormat::FP16;

/// Zeros, subnormals, ones, the largest numbers, infinities, NaN.
const CORNERS: [u16; 12] =
    [0, 0x8000, 1, 0x03ff, 0x0400, 0x3c00, 0xbc00, 0x3555, 0x7bff, 0xfbff, 0x7c00, 0x7e00];

/// Any number, a corner in a quarter of the cases.
fn number(random: &mut Pcg64Mcg) -> u64 {
    let corner = u64::from(CORNERS[random.random_range(0..CORNERS.len())]);
    if random.random_range(0..4) == 0 { corner } else { random.next_u64() & 0xffff }
}

/// Runs 1,280 pairs through a unit with inputs a and b, or a alone.
fn arithmetic(name: &str, inputs: &[&str], model: impl Fn(u16, u16) -> u16) {
    for library in LIBRARIES {
        let mut unit = Unit::new(name, library);
        for _ in 0..20 {
            let mut values = [[0u64; LANES]; 2];
            values.iter_mut().flatten().for_each(|value| *value = number(&mut unit.random));
            inputs.iter().zip(&values).for_each(|(port, values)| unit.set(port, values));
            unit.simulator.settle();
            let found = unit.get("y");
            for lane in 0..LANES {
                let (a, b) = (values[0][lane] as u16, values[1][lane] as u16);
                let expected = model(a, b);
                assert_eq!(found[lane], u64::from(expected), "{library}: {a:#06x}, {b:#06x}");
            }
        }
    }
}

#[test]
fn adders_add() {
    arithmetic("fp_add", &["a", "b"], |a, b| FP16.add(a, b));
}

#[test]
fn multipliers_multiply() {
    arithmetic("fp_mul", &["a", "b"], |a, b| FP16.multiply(a, b));
}

#[test]
fn powers_of_two_fall() {
    arithmetic("fp_exp", &["x"], |x, _| FP16.exp2_negative(x));
}

const OPEN: u64 = 0;
const SPLAT: u64 = 1;
const CLOSE: u64 = 2;

/// A splat somewhere near the first pixel of a core.
fn record(random: &mut Pcg64Mcg, at: [f64; 2]) -> Record {
    loop {
        let mean = at.map(|place| place - 7.5 + random.random_range(-3.0..4.0));
        let [a, d] = [0; 2].map(|_| random.random_range(0.3f32..20.0));
        let b = random.random_range(-0.9..0.9) * (a * d).sqrt();
        let opacity = random.random_range(0.002f32..1.0);
        let colour = [0; 3].map(|_| random.random_range(0.0f32..1.0));
        if let Some(record) = Record::new(FP16, mean, [a, b, d], opacity, colour) {
            return record;
        }
    }
}

fn words(record: &Record) -> [u32; 16] {
    let Record { mean, root, opacity, colour } = *record;
    let all =
        [mean[0], mean[1], root[0], root[1], root[2], opacity, colour[0], colour[1], colour[2]];
    let mut words = [0; 16];
    for (place, number) in all.into_iter().enumerate() {
        words[place / 2] |= u32::from(number) << (16 * (place % 2));
    }
    words
}

/// A beat: what it does, and its record.
type Beat = (u64, [u32; 16]);

/// Renders a tile of 20 splats on 2 x 2 pixels in every lane; acceptance is stalled at random.
fn render(library: &str) {
    let vrc = Vrc::new(FP16).expect("FP16 will do");
    let mut unit = Unit::new("vrc", library);
    let mut beats: Vec<VecDeque<Beat>> = vec![VecDeque::new(); LANES];
    let mut expected: Vec<VecDeque<u64>> = vec![VecDeque::new(); LANES];
    let mut places = [[0u64; 2]; LANES];
    let mut masks = [0u64; LANES];
    for lane in 0..LANES {
        places[lane] = [0; 2].map(|_| 2 * unit.random.random_range(0..8));
        masks[lane] = if lane % 8 == 0 { unit.random.random_range(0..16) } else { 15 };
        let open = |pixel: u64| Pixel::open(FP16, masks[lane] >> pixel & 1 == 1);
        let mut pixels = [0, 1, 2, 3].map(open);
        beats[lane].push_back((OPEN, [0; 16]));
        for _ in 0..20 {
            let splat = record(&mut unit.random, places[lane].map(|place| place as f64));
            beats[lane].push_back((SPLAT, words(&splat)));
            for (number, pixel) in (0..).zip(&mut pixels) {
                let [x, y] = places[lane].map(|place| place as u32);
                vrc.blend(pixel, &splat, x + number % 2, y + number / 2);
            }
        }
        beats[lane].push_back((CLOSE, [0; 16]));
        expected[lane] = pixels.iter().map(word).collect();
    }
    for (port, part) in [("open_x", 0), ("open_y", 1)] {
        unit.set(port, &places.map(|place| place[part]));
    }
    unit.set("open_mask", &masks);
    unit.set("out_ready", &[1; LANES]);
    let mut cycles = 0;
    while expected.iter().any(|pixels| !pixels.is_empty()) {
        let comes = unit.coins();
        let beat: [Beat; LANES] =
            std::array::from_fn(|lane| beats[lane].front().copied().unwrap_or_default());
        let valid: [u64; LANES] =
            std::array::from_fn(|lane| comes[lane] & u64::from(!beats[lane].is_empty()));
        unit.set("in_valid", &valid);
        unit.set("in_op", &beat.map(|beat| beat.0));
        unit.set_rows("in_record", &beat.map(|beat| Some(beat.1)));
        unit.simulator.settle();
        let (ready, out) = (unit.get("in_ready"), unit.get("out_valid"));
        let pixels = unit.get("out_pixel");
        for lane in 0..LANES {
            if valid[lane] & ready[lane] == 1 {
                beats[lane].pop_front();
            }
            if out[lane] == 1 {
                assert_eq!(Some(pixels[lane]), expected[lane].pop_front(), "lane {lane}");
            }
        }
        unit.simulator.clock();
        cycles += 1;
        assert!(cycles < 500, "pixels are missing");
    }
}

/// Red, green, blue, transmittance from the lowest bit.
fn word(pixel: &Pixel) -> u64 {
    let parts = pixel.colour.into_iter().chain([pixel.transmittance]);
    (0..).zip(parts).map(|(place, part)| u64::from(part) << (16 * place)).sum()
}

#[test]
fn volume_rendering_cores_blend() {
    LIBRARIES.iter().for_each(|library| render(library));
}
