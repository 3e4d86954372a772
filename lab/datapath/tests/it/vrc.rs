//! The volume-rendering core: its model against f64, and `rtl/vrc.sv` against its model, bit for
//! bit and cycle for cycle.

use powergs_datapath::vectors::{self, Core, CoreTile};
use powergs_datapath::{Form, NumberFormat, Outcome, Pixel, Record, Vrc};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::bench;
use super::numbers::corners;

/// A splat that may be anywhere around its tile, of any size, thinness and direction.
pub fn splat(vrc: &Vrc, random: &mut Pcg64Mcg) -> Record {
    let long = 0.55 * (random.random::<f64>() * 6.0).exp2();
    let short = 0.55 + (long - 0.55) * random.random::<f64>().powi(3);
    let (sin, cos) = (random.random::<f64>() * 6.3).sin_cos();
    let (l, s) = (long * long, short * short);
    let covariance =
        [l * cos * cos + s * sin * sin, (l - s) * sin * cos, l * sin * sin + s * cos * cos];
    let reach = 8.0 + 2.0 * long;
    let mean = [(); 2].map(|()| (2.0 * random.random::<f64>() - 1.0) * reach);
    let colour = [(); 3].map(|()| 1.2 * random.random::<f32>());
    let opacity = random.random::<f32>().sqrt();
    vrc.record(mean, covariance.map(|c| c as f32), opacity, colour).expect("an ellipse")
}

/// A record of any bits, many of them corners.
fn bits(format: NumberFormat, random: &mut Pcg64Mcg) -> Record {
    let corners = corners(format);
    let mask = u16::MAX >> (16 - format.bits());
    let mut number = || match random.random::<bool>() {
        true => corners[random.random_range(0..corners.len())],
        false => random.random::<u16>() & mask,
    };
    Record {
        mean: [number(), number()],
        root: [number(), number(), number()],
        opacity: number(),
        colour: [number(), number(), number()],
    }
}

#[test]
fn records_that_are_valid_make_no_nan() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    for name in ["e5m10", "e4m3", "e8m7", "e4m11", "e6m5", "e5m2"] {
        let format: NumberFormat = name.parse().expect("a format");
        let vrc = Vrc::new(format).expect("enough exponent");
        let far = format.largest();
        for round in 0..20_000 {
            let mut record = splat(&vrc, &mut random);
            if round % 4 == 0 {
                // Means and matrices at their limits.
                let room = format.to_f64(far) / 8.0;
                let mean = [room, if round % 8 == 0 { -room } else { room }].map(|m| 2.0 * m);
                let edge = Record::new(format, mean, [0.3, 0.0, 0.3], 1.0, [1.0; 3]);
                record = edge.expect("an ellipse");
                record.root = [(); 3].map(|()| {
                    let most = format.from_f64(2.0);
                    if random.random() { most } else { most | format.sign() }
                });
            }
            let (x, y) = (random.random_range(0..16), random.random_range(0..16));
            let alpha = vrc.alpha(&record, x, y);
            assert!(!format.is_nan(alpha), "{name}: {record:?} at {x}, {y}");
            assert!(alpha <= format.one(), "{name}: {record:?} at {x}, {y}");
        }
    }
}

#[test]
fn what_is_said_to_miss_is_dropped() {
    let mut random = Pcg64Mcg::seed_from_u64(8);
    for name in ["e5m10", "e4m3", "e8m7", "e6m5", "e5m2", "e4m7"] {
        let format: NumberFormat = name.parse().expect("a format");
        let root = Vrc::new(format).expect("enough exponent");
        let (mut misses, mut dropped) = (0, 0);
        for round in 0..300_000 {
            let form = [Form::Root, Form::Conic, Form::Local][round % 3];
            let vrc = root.with_form(form);
            let mut record = splat(&vrc, &mut random);
            if random.random_range(0..4) == 0 {
                // Far along a thin splat, where both terms of u are large.
                let far = [(); 2].map(|()| 400.0 * random.random::<f64>() - 200.0);
                record = record.moved(format, far);
            }
            let (x, y) = (random.random_range(0..16), random.random_range(0..16));
            let outcome = vrc.blend(&mut Pixel::open(format, true), &record, x, y);
            dropped += u32::from(outcome == Outcome::Dropped);
            if vrc.reach(&record).misses(x, y) {
                misses += 1;
                assert_eq!(outcome, Outcome::Dropped, "{name}: {record:?} at {x}, {y}");
            }
        }
        assert!(misses <= dropped && (name != "e5m10" || misses > dropped * 9 / 10), "{name}");
    }
}

/// What FP16 makes of a record against the exact α of the same record.
#[test]
fn alpha_is_near_the_exact_one() {
    let mut random = Pcg64Mcg::seed_from_u64(6);
    let format = NumberFormat::FP16;
    let vrc = Vrc::new(format).expect("enough exponent");
    let (mut worst, mut sum, mut count) = (0.0f64, 0.0, 0.0);
    for _ in 0..200_000 {
        let record = splat(&vrc, &mut random);
        let (x, y) = (random.random_range(0..16), random.random_range(0..16));
        let value = |number| format.to_f64(number);
        let (x_middle, y_middle) = (f64::from(x) - 7.5, f64::from(y) - 7.5);
        let [a, b, c] = record.root.map(value);
        let [u, v] = record.mean.map(value);
        let q = (a * x_middle + b * y_middle + u).powi(2) + (c * y_middle + v).powi(2);
        let exact = value(record.opacity) * (-q).exp2();
        let error = (value(vrc.alpha(&record, x, y)) - exact).abs();
        worst = worst.max(error);
        sum += error * error;
        count += 1.0;
    }
    let mean = f64::sqrt(sum / count);
    assert!(worst < 0.004 && mean < 9e-5, "at most {worst}, in the mean {mean}");
}

#[test]
fn alpha_is_dropped_and_clamped_and_pixels_stop() {
    let format = NumberFormat::FP16;
    let vrc = Vrc::new(format).expect("enough exponent");
    let at = |opacity: f32| Record {
        opacity: format.from_f32(opacity),
        colour: [format.one(); 3],
        ..Record::default()
    };
    let mut pixel = Pixel::open(format, true);
    let before = pixel;
    assert_eq!(vrc.blend(&mut pixel, &at(0.003_917), 0, 0), Outcome::Dropped);
    assert_eq!(pixel, before);
    assert_eq!(vrc.blend(&mut pixel, &at(0.003_925), 0, 0), Outcome::Blended);
    assert_eq!(pixel.colour, [format.from_f32(0.003_925); 3]);
    // Opaque splats leave 0.01, and a second one 1e-4 and a little; the third stops the pixel.
    let mut pixel = Pixel::open(format, true);
    assert_eq!(vrc.blend(&mut pixel, &at(1.0), 0, 0), Outcome::Blended);
    assert_eq!(format.to_f64(pixel.transmittance), 1.0 - format.to_f64(format.at_most(0.99)));
    assert_eq!(vrc.blend(&mut pixel, &at(1.0), 0, 0), Outcome::Blended);
    let kept = pixel;
    assert_eq!(vrc.blend(&mut pixel, &at(1.0), 0, 0), Outcome::Stopped);
    assert_eq!(pixel, Pixel { live: false, ..kept });
    assert_eq!(vrc.blend(&mut pixel, &at(0.5), 0, 0), Outcome::Idle);
    assert!(Vrc::new("e3m4".parse().expect("a format")).is_none());
}

fn tiles(vrc: &Vrc, pixels: u32, columns: u32, random: &mut Pcg64Mcg) -> Vec<CoreTile> {
    let format = vrc.format();
    let tile = |index: u32| {
        let count = if index < 3 { index } else { random.random_range(0..60) };
        let rows = pixels / columns;
        let all = ((1u64 << pixels) - 1) as u32;
        // Of four tiles one has records of any bits, and one is opaque.
        let mut one = || match index % 4 {
            0 => bits(format, random),
            1 => Record { opacity: format.from_f32(0.97), ..splat(vrc, random) },
            _ => splat(vrc, random),
        };
        let splats = (0..count).map(|_| one()).collect();
        let place = [
            random.random_range(0..16 / columns) * columns,
            random.random_range(0..16 / rows) * rows,
        ];
        let mask = if index % 5 == 4 { random.random::<u32>() & all } else { all };
        CoreTile { place, mask, splats }
    };
    (0..120).map(tile).collect()
}

#[test]
fn the_core_in_hardware_is_the_core_of_the_model() {
    let cores = [
        ("e5m10", true, 4, 2),
        ("e5m10", false, 4, 2),
        ("e5m10", true, 16, 4),
        ("e6m5", true, 8, 4),
        ("e4m3", false, 4, 4),
    ];
    for (name, split, pixels, columns) in cores {
        let format: NumberFormat = name.parse().expect("a format");
        let parameters = [
            ("EXP", format.exponent_bits()),
            ("MAN", format.mantissa_bits()),
            ("SPLIT", u32::from(split)),
            ("PIXELS", pixels),
            ("COLUMNS", columns),
        ];
        let Some(bench) = bench("vrc", &parameters) else { return };
        let mut random = Pcg64Mcg::seed_from_u64(u64::from(pixels));
        let vrc = Vrc::new(format).expect("enough exponent");
        let core = Core { vrc, split, pixels, columns };
        let tiles = tiles(&vrc, pixels, columns, &mut random);
        let vectors = vectors::vrc(&core, &tiles);
        for head in [[7, 0, 0], [7, 4, 0], [7, 0, 4], [7, 5, 5], [7, 7, 1]] {
            let found = vectors.events(&bench.run(&vectors.stalled(head)));
            let what = format!("{name}, {pixels} pixels, split {split}, stalls {head:?}");
            if head == [7, 0, 0] {
                assert_eq!(vectors.difference(&found, true), None, "{what}");
                continue;
            }
            // A tile may be closed before its stop is seen.
            let pixels = |event: &vectors::Event| event.kind == 0;
            let found: Vec<_> = found.into_iter().filter(pixels).collect();
            let mut expected = vectors.clone();
            expected.expected.retain(pixels);
            assert_eq!(expected.difference(&found, false), None, "{what}");
        }
    }
}
