//! The committed netlists of FP16 arithmetic and of the volume-rendering core against
//! `powergs-datapath`, in 64 lanes.

use std::collections::VecDeque;

use powergs_datapath::{Arithmetic, Exponential};
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
fn record(format: NumberFormat, random: &mut Pcg64Mcg, at: [f64; 2]) -> Record {
    loop {
        let mean = at.map(|place| place - 7.5 + random.random_range(-3.0..4.0));
        let [a, d] = [0; 2].map(|_| random.random_range(0.3f32..20.0));
        let b = random.random_range(-0.9..0.9) * (a * d).sqrt();
        let opacity = random.random_range(0.002f32..1.0);
        let colour = [0; 3].map(|_| random.random_range(0.0f32..1.0));
        if let Some(record) = Record::new(format, mean, [a, b, d], opacity, colour) {
            return record;
        }
    }
}

/// Nine numbers of `width` bits.
fn words(record: &Record, width: usize) -> [u32; 16] {
    let Record { mean, root, opacity, colour } = *record;
    let all =
        [mean[0], mean[1], root[0], root[1], root[2], opacity, colour[0], colour[1], colour[2]];
    let mut words = [0; 16];
    for (place, number) in all.into_iter().enumerate() {
        for bit in 0..width {
            let at = place * width + bit;
            words[at / 32] |= u32::from(number >> bit & 1) << (at % 32);
        }
    }
    words
}

/// A beat: what it does, and its record.
type Beat = (u64, [u32; 16]);

/// Renders a tile of 20 splats on 2 x 2 pixels in every lane; acceptance is stalled at random.
fn render(name: &str, library: &str, format: NumberFormat, width: usize) {
    let vrc = Vrc::new(format).expect("a format that will do");
    let mut unit = Unit::new(name, library);
    let mut beats: Vec<VecDeque<Beat>> = vec![VecDeque::new(); LANES];
    let mut expected: Vec<VecDeque<u64>> = vec![VecDeque::new(); LANES];
    let mut places = [[0u64; 2]; LANES];
    let mut masks = [0u64; LANES];
    for lane in 0..LANES {
        places[lane] = [0; 2].map(|_| 2 * unit.random.random_range(0..8));
        masks[lane] = if lane % 8 == 0 { unit.random.random_range(0..16) } else { 15 };
        let open = |pixel: u64| Pixel::open(format, masks[lane] >> pixel & 1 == 1);
        let mut pixels = [0, 1, 2, 3].map(open);
        beats[lane].push_back((OPEN, [0; 16]));
        for _ in 0..20 {
            let splat = record(format, &mut unit.random, places[lane].map(|place| place as f64));
            beats[lane].push_back((SPLAT, words(&splat, width)));
            for (number, pixel) in (0..).zip(&mut pixels) {
                let [x, y] = places[lane].map(|place| place as u32);
                vrc.blend(pixel, &splat, x + number % 2, y + number / 2);
            }
        }
        beats[lane].push_back((CLOSE, [0; 16]));
        expected[lane] = pixels.iter().map(|pixel| word(pixel, width)).collect();
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
fn word(pixel: &Pixel, width: usize) -> u64 {
    let parts = pixel.colour.into_iter().chain([pixel.transmittance]);
    (0..).zip(parts).map(|(place, part)| u64::from(part) << (width * place)).sum()
}

#[test]
fn volume_rendering_cores_blend() {
    let format = |exponent, mantissa| NumberFormat::new(exponent, mantissa).expect("a format");
    let formats =
        [("vrc", FP16, 16), ("vrc-e5m6", format(5, 6), 12), ("vrc-e4m3", format(4, 3), 8)];
    for (name, format, width) in formats {
        LIBRARIES.iter().for_each(|library| render(name, library, format, width));
    }
}

const SUBTILES: usize = 4;
const CORES: usize = 4;

/// The control of a rendering unit without its cores, which are ports here. Records are numbers
/// that tell splats apart.
fn deal(library: &str) {
    let mut unit = Unit::new("vru", library);
    let core = |s: usize, c: usize, port: &str| format!("g_subtile_{s}_g_core_{c}_core_{port}");
    unit.set("open_width", &[16; LANES]);
    unit.set("open_height", &[16; LANES]);
    let mut splats: Vec<VecDeque<(u64, u64)>> = vec![VecDeque::new(); LANES];
    let mut expected = vec![vec![VecDeque::new(); SUBTILES]; LANES];
    for lane in 0..LANES {
        for number in 0..40u64 {
            let bitmap = unit.random.random_range(1..16);
            splats[lane].push_back((bitmap, number * 64 + lane as u64));
            for (subtile, records) in expected[lane].iter_mut().enumerate() {
                records.extend((bitmap >> subtile & 1 == 1).then_some(number * 64 + lane as u64));
            }
        }
    }
    let mut opened = [0u32; LANES];
    let mut beats: Vec<VecDeque<(u64, u64, u64)>> = splats
        .iter()
        .map(|splats| {
            let splats = splats.iter().map(|&(bitmap, record)| (SPLAT, bitmap, record));
            [(OPEN, 0, 0)].into_iter().chain(splats).chain([(CLOSE, 0, 0)]).collect()
        })
        .collect();
    let mut closed = 0;
    for cycle in 0.. {
        assert!(cycle < 2000, "beats are left");
        let comes = unit.coins();
        let valid: [u64; LANES] =
            std::array::from_fn(|lane| comes[lane] & u64::from(!beats[lane].is_empty()));
        let beat = |lane: usize| beats[lane].front().copied().unwrap_or_default();
        unit.set("in_valid", &valid);
        unit.set("in_op", &std::array::from_fn(|lane| beat(lane).0));
        unit.set("in_bitmap", &std::array::from_fn(|lane| beat(lane).1));
        let records = std::array::from_fn(|lane| {
            let mut words = [0; 16];
            words[0] = beat(lane).2 as u32;
            Some(words)
        });
        unit.set_rows("in_record", &records);
        let mut goes = [[0; LANES]; SUBTILES];
        for (s, goes) in goes.iter_mut().enumerate() {
            *goes = unit.coins();
            (0..CORES).for_each(|c| unit.set(&core(s, c, "in_ready"), goes));
        }
        unit.simulator.settle();
        let ready = unit.get("in_ready");
        for (s, goes) in goes.iter().enumerate() {
            for c in 0..CORES {
                let (offered, op) =
                    (unit.get(&core(s, c, "in_valid")), unit.get(&core(s, c, "in_op")));
                let records = unit.rows(&core(s, c, "in_record"));
                for lane in (0..LANES).filter(|lane| offered[*lane] & goes[*lane] == 1) {
                    match op[lane] {
                        OPEN => opened[lane] += 1,
                        CLOSE => closed += 1,
                        _ => {
                            let next = expected[lane][s].front().copied();
                            assert_eq!(Some(u64::from(records[lane][0])), next, "sub-tile {s}");
                            if c + 1 == CORES {
                                expected[lane][s].pop_front();
                            }
                        }
                    }
                }
            }
        }
        for lane in (0..LANES).filter(|lane| valid[*lane] & ready[*lane] == 1) {
            beats[lane].pop_front();
        }
        unit.simulator.clock();
        if closed == LANES * SUBTILES * CORES {
            break;
        }
    }
    assert!(opened.iter().all(|cores| *cores == (SUBTILES * CORES) as u32));
    assert!(expected.iter().flatten().all(VecDeque::is_empty), "splats are missing");
}

#[test]
fn the_control_of_rendering_units_deals_splats_to_sub_tiles() {
    LIBRARIES.iter().for_each(|library| deal(library));
}
