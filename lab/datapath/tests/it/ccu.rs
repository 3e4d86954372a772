//! The culling and conversion unit: its model against f64, its schedules and what `rtl/` has of
//! them.

use std::path::Path;

use powergs_datapath::Arithmetic;
use powergs_datapath::ccu::emit::{self, Program, WIDTHS};
use powergs_datapath::ccu::graph::{KINDS, Value};
use powergs_datapath::ccu::programs::{self, projected as at};
use powergs_datapath::ccu::schedule::LATENCY;
use powergs_datapath::ccu::{Ccu, Gaussian, Settings, camera};
use powergs_datapath::{NumberFormat, WideFormat};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const FOCAL: [f64; 2] = [600.0, 620.0];
const PRINCIPAL: [f64; 2] = [173.0, 115.0];
const SIZE: [u32; 2] = [330, 230];

/// A unit as `rtl/` has it by default.
pub fn normal() -> Ccu {
    let wide = WideFormat::new(8, 15).expect("a format");
    Ccu::new(wide, NumberFormat::FP16).expect("formats that fit")
}

const EYE: [f64; 3] = [0.3, -0.7, 1.1];

/// A rotation about an askew axis.
fn turn() -> [[f64; 3]; 3] {
    rotation([0.9, 0.2, -0.35, 0.15])
}

/// A camera that looks somewhere.
pub fn view(ccu: &Ccu) -> Settings {
    camera(ccu.wide(), EYE, turn(), FOCAL, PRINCIPAL, SIZE)
}

/// The matrix of a quaternion of any length.
fn rotation(q: [f64; 4]) -> [[f64; 3]; 3] {
    let n = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    let [w, x, y, z] = q.map(|v| v / n);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// World coordinates of a place in front of the camera.
fn world(place: [f64; 3]) -> [f64; 3] {
    let t = turn();
    std::array::from_fn(|i| EYE[i] + (0..3).map(|k| t[k][i] * place[k]).sum::<f64>())
}

fn quantised(ccu: &Ccu, mean: [f64; 3], scales: [f64; 3], q: [f64; 4], opacity: f64) -> Gaussian {
    let w = ccu.wide();
    let n = q.iter().map(|v| v * v).sum::<f64>().sqrt() / 2f64.sqrt();
    let [s0, s1, s2] = scales.map(|s| w.from_f64(s));
    let [q0, q1, q2, q3] = q.map(|v| w.from_f64(v / n));
    let shape = [s0, s1, s2, q0, q1, q2, q3, w.from_f64(opacity)];
    Gaussian { mean: mean.map(|m| w.from_f64(m)), shape }
}

/// A small Gaussian at a place from the camera.
pub fn place_in_view(ccu: &Ccu, place: [f64; 3]) -> Gaussian {
    quantised(ccu, world(place), [0.004; 3], [1.0, 0.0, 0.0, 0.0], 0.5)
}

/// A Gaussian somewhere around what the camera sees, of any size and thinness.
pub fn gaussian(ccu: &Ccu, random: &mut Pcg64Mcg) -> Gaussian {
    let mut one = || 2.0 * random.random::<f64>() - 1.0;
    let depth = 0.1 + 8.0 * one().powi(2);
    let mean = world([0.8 * one() * depth, 0.6 * one() * depth, depth]);
    let scales = [0; 3].map(|_| (5.0 * one() - 6.0).exp2());
    let q = [0; 4].map(|_| one());
    let opacity = one().abs();
    quantised(ccu, mean, scales, q, opacity)
}

/// A Gaussian of any bits: some numbers are corners, some are random.
pub fn any_gaussian(ccu: &Ccu, random: &mut Pcg64Mcg) -> Gaussian {
    let w = ccu.wide();
    let mut any = gaussian(ccu, random);
    let infinity = w.infinity();
    let corners = [0, 1, w.one(), infinity - 1, infinity, w.nan(), infinity | 1, 2 << 10];
    let mut change = |number: &mut u32| match random.random_range(0..6) {
        0 => *number = corners[random.random_range(0..corners.len())],
        1 => *number ^= w.sign(),
        2 => *number = random.random::<u32>() & (w.sign() | (w.sign() - 1)),
        _ => {}
    };
    any.shape.iter_mut().for_each(&mut change);
    if random.random::<bool>() {
        let mut change = |number: &mut u32| match random.random_range(0..6) {
            0 => *number = corners[random.random_range(0..corners.len())],
            _ => *number ^= 1,
        };
        any.mean.iter_mut().for_each(&mut change);
    }
    any
}

/// The projection in f64 of the same numbers: mean, covariance, depth.
fn exact(ccu: &Ccu, g: &Gaussian) -> ([f64; 2], [f64; 3], f64) {
    let w = ccu.wide();
    let value = |n: u32| w.to_f64(n);
    // The camera as the settings have it.
    let s = view(ccu).numbers.map(value);
    let d: [f64; 3] = std::array::from_fn(|i| value(g.mean[i]) - s[i]);
    let row = |k: usize| [s[3 + 3 * k], s[4 + 3 * k], s[5 + 3 * k]];
    let dot = |a: [f64; 3], b: [f64; 3]| a.iter().zip(&b).map(|(a, b)| a * b).sum::<f64>();
    let z = dot(row(2), d);
    let r = rotation([3, 4, 5, 6].map(|i| value(g.shape[i])));
    let mut vectors = [[0.0; 3]; 2];
    let mut mean = [0.0; 2];
    for axis in 0..2 {
        let slope = dot(row(axis), d) / z;
        mean[axis] = slope + s[12 + axis];
        let held = slope.clamp(s[14 + 2 * axis], s[15 + 2 * axis]);
        let t: [f64; 3] = std::array::from_fn(|i| (row(axis)[i] - held * row(2)[i]) / z);
        vectors[axis] = std::array::from_fn(|k| {
            (0..3).map(|i| t[i] * r[i][k]).sum::<f64>() * value(g.shape[k])
        });
    }
    let [u, v] = vectors;
    (mean, [dot(u, u) + 0.3, dot(u, v), dot(v, v) + 0.3], z)
}

/// Shares of a list of errors.
fn at_share(errors: &mut [f64], share: f64) -> f64 {
    errors.sort_by(f64::total_cmp);
    errors[((errors.len() - 1) as f64 * share) as usize]
}

#[test]
fn projection_is_near_that_of_f64() {
    let ccu = normal();
    let settings = view(&ccu);
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let w = ccu.wide();
    let (mut places, mut roots, mut boxes, mut reaches) = (vec![], vec![], vec![], vec![]);
    while places.len() < 20_000 {
        let g = gaussian(&ccu, &mut random);
        let verdict = ccu.cull(&settings, &g.mean);
        let (mean, [a, b, d], z) = exact(&ccu, &g);
        // Depths beside the near plane may go either way.
        assert!(verdict.kept == (z > 0.2) || (z - 0.2).abs() < 1e-3);
        let on_screen = |i: usize| (0.0..f64::from(SIZE[i])).contains(&mean[i]);
        if !(verdict.kept && on_screen(0) && on_screen(1)) {
            continue;
        }
        let p = ccu.project(&settings, &verdict.place, &g.shape).numbers.map(|n| w.to_f64(n));
        places.push((p[at::MEAN] - mean[0]).hypot(p[at::MEAN + 1] - mean[1]));
        let det = a * d - b * b;
        let k = (0.5 * std::f64::consts::LOG2_E).sqrt();
        let root = [k * (d / det).sqrt(), -k * b / (d * det).sqrt(), k / d.sqrt()];
        let largest = root.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
        let error = |i: usize| (p[at::ROOT + i] - root[i]).abs() / largest;
        roots.push(error(0).max(error(1)).max(error(2)));
        let (mid, half) = (0.5 * (a + d), (0.25 * (a - d) * (a - d) + b * b).sqrt());
        let long = 3.0 * (mid + half).sqrt();
        let short = 3.0 * (det / (mid + half)).sqrt();
        let [major, minor] = [p[at::HALF].max(p[at::HALF + 1]), p[at::HALF].min(p[at::HALF + 1])];
        boxes.push((major / long - 1.0).abs().max((minor / short - 1.0).abs()));
        // Along x the box reaches as far as its rotated half lengths say.
        let reach = {
            let angle = 0.5 * (2.0 * b).atan2(a - d);
            long * angle.cos().abs() + short * angle.sin().abs()
        };
        reaches.push((p[at::REACH] - reach).abs() / long);
    }
    let limits = [
        ("places, pixels", &mut places, 0.03, 0.2),
        ("roots", &mut roots, 3e-4, 3e-2),
        ("half lengths", &mut boxes, 2e-4, 3e-2),
        ("reach", &mut reaches, 3e-3, 0.3),
    ];
    for (what, errors, usual, most) in limits {
        let (usually, worst) = (at_share(errors, 0.99), at_share(errors, 1.0));
        eprintln!("{what}: {usually:.6} {worst:.6}");
        assert!(usually < usual && worst < most, "{what}: 99 % below {usually}, worst {worst}");
    }
}

#[test]
fn colours_are_near_those_of_f64() {
    let ccu = normal();
    let f = ccu.narrow();
    let mut random = Pcg64Mcg::seed_from_u64(2);
    for degree in 0..4 {
        let mut worst = 0.0f64;
        for _ in 0..5_000 {
            let mut d = [0; 3].map(|_| 2.0 * random.random::<f64>() - 1.0);
            let n = d.iter().map(|v| v * v).sum::<f64>().sqrt();
            d.iter_mut().for_each(|v| *v /= n);
            let direction = d.map(|v| f.from_f64(v));
            let [x, y, z] = direction.map(|v| f.to_f64(v));
            let (xx, yy, zz) = (x * x, y * y, z * z);
            let basis = [
                1.0,
                y,
                z,
                x,
                x * y,
                y * z,
                2.0 * zz - xx - yy,
                x * z,
                xx - yy,
                y * (3.0 * xx - yy),
                x * y * z,
                y * (4.0 * zz - xx - yy),
                z * (2.0 * zz - 3.0 * xx - 3.0 * yy),
                x * (4.0 * zz - xx - yy),
                z * (xx - yy),
                x * (xx - 3.0 * yy),
            ];
            let coefficients: [u16; 48] =
                std::array::from_fn(|_| f.from_f32(0.4 * random.random::<f32>() - 0.2));
            let found = ccu.colour(degree, &direction, &coefficients);
            for channel in 0..3 {
                let count = (degree as usize + 1).pow(2);
                let terms = basis[..count].iter().enumerate();
                let sum: f64 =
                    terms.map(|(k, b)| b * f.to_f64(coefficients[3 * k + channel])).sum();
                worst = worst.max((f.to_f64(found[channel]) - sum.max(0.0)).abs());
            }
        }
        assert!(worst < 0.002, "degree {degree}: {worst}");
    }
}

/// Whatever the bits are, nothing panics, and what leaves is finite.
#[test]
fn hostile_gaussians_are_dropped_or_bounded() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    for (exponent, mantissa) in [(8, 15), (5, 10), (7, 11), (8, 17)] {
        let wide = WideFormat::new(exponent, mantissa).expect("a format");
        let ccu = Ccu::new(wide, NumberFormat::FP16).expect("formats that fit");
        let settings = view(&ccu);
        let room = NumberFormat::FP16.largest() - (3 << 10);
        let (mut seen, mut count) = (0, 0);
        for _ in 0..20_000 {
            let g = any_gaussian(&ccu, &mut random);
            let Some((converted, walk)) = ccu.splat(&settings, &g) else { continue };
            seen += 1;
            for pair in walk.pairs(ccu.narrow()) {
                count += 1;
                assert!(pair.tile[0] < settings.tiles[0] && pair.tile[1] < settings.tiles[1]);
                assert!(pair.local.iter().all(|n| n & 0x7fff <= room), "{pair:?}");
            }
            let two = NumberFormat::FP16.from_f64(2.0);
            assert!(converted.root.iter().all(|n| n & 0x7fff <= two), "{converted:?}");
            assert!(!NumberFormat::FP16.is_nan(converted.depth));
        }
        assert!(seen > 200 && count > 1_000, "{seen} seen, {count} pairs");
    }
    let f = NumberFormat::FP16;
    let ccu = normal();
    for bits in [0x7c00, 0xfc00, 0x7e00, 0x7c01, 0x0001, 0x8000] {
        let colour = ccu.colour(3, &[bits, f.one(), bits], &[bits; 48]);
        assert!(colour.iter().all(|&c| f.is_nan(c) || c & f.sign() == 0), "{colour:?}");
    }
    assert!(Ccu::new(WideFormat::FP32, f).is_none());
    assert!(Ccu::new(WideFormat::FP16, "e3m4".parse().expect("a format")).is_none());
}

/// What is behind the camera is culled, what is beside the image has no tile, and a small splat at
/// the principal point has the tile that is there.
#[test]
fn splats_are_where_they_belong() {
    let ccu = normal();
    let settings = view(&ccu);
    let behind = place_in_view(&ccu, [0.0, 0.0, -1.0]);
    assert!(!ccu.cull(&settings, &behind.mean).kept);
    let beside = place_in_view(&ccu, [40.0, 0.0, 2.0]);
    assert!(ccu.cull(&settings, &beside.mean).kept && ccu.splat(&settings, &beside).is_none());
    let (converted, walk) =
        ccu.splat(&settings, &place_in_view(&ccu, [0.0, 0.0, 2.0])).expect("it is seen");
    // The principal point is at (172.5, 114.5).
    let pairs = walk.pairs(ccu.narrow());
    assert!(pairs.iter().any(|pair| pair.tile == [10, 7]), "{pairs:?}");
    assert_eq!(converted.opacity, NumberFormat::FP16.from_f32(0.5));
}

/// Reciprocals and reciprocal roots of all mantissas, in ulp of the exact result.
#[test]
fn special_functions_are_near() {
    use powergs_datapath::ccu::graph::Graph;
    for (exponent, mantissa, most) in [(8, 15, 1.3), (5, 10, 0.6), (8, 17, 3.6), (8, 7, 0.6)] {
        let format = WideFormat::new(exponent, mantissa).expect("a format");
        let mut graph = Graph::new("special", [1, 0, 0]);
        let x = graph.input(0);
        let (r, s) = (graph.reciprocal(x), graph.reciprocal_root(x));
        graph.output(r);
        graph.output(s);
        let mut worst = [0.0f64; 2];
        for bits in 0..2 << mantissa {
            let number = format.one() + bits;
            let out = graph.run(format, [&[number], &[], &[]]);
            let value = format.to_f64(number);
            for (i, exact) in [1.0 / value, 1.0 / value.sqrt()].into_iter().enumerate() {
                let ulp = exact.log2().floor().exp2() / f64::from(1 << mantissa);
                worst[i] = worst[i].max((format.to_f64(out[i]) - exact).abs() / ulp);
            }
        }
        eprintln!("{format} {worst:?}");
        assert!(worst.iter().all(|&error| error < most), "{format}: {worst:?} ulp");
    }
}

/// Wide arithmetic is that of f32 where the format is.
#[test]
fn the_widest_format_is_that_of_f32() {
    let mut random = Pcg64Mcg::seed_from_u64(9);
    let f = WideFormat::FP32;
    for round in 0..2_000_000 {
        let a: u32 = random.random();
        // Half of them near enough to cancel.
        let b: u32 = if round % 2 == 0 { random.random() } else { a ^ random.random::<u32>() >> 9 };
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        let same = |ours: u32, theirs: f32| match theirs.is_nan() {
            true => assert_eq!(ours, f.nan(), "{a:#x} {b:#x}"),
            false => assert_eq!(ours, theirs.to_bits(), "{a:#x} {b:#x}"),
        };
        same(f.add(a, b), x + y);
        same(f.multiply(a, b), x * y);
        assert_eq!(f.compare(a, b), x.partial_cmp(&y));
    }
    for (exponent, mantissa) in [(9, 10), (1, 20), (8, 24), (4, 2), (8, 0)] {
        let error = WideFormat::new(exponent, mantissa).expect_err("no format");
        assert!(error.to_string().contains("8 to 32 bits"), "{error}");
    }
}

/// Every operation is issued when its operands are there, on an operator that is free.
#[test]
fn schedules_keep_their_rules() {
    for ops in WIDTHS {
        for program in [Program::cull(ops), Program::project(ops), Program::colour(ops)] {
            for (graph, schedule) in &program.modes {
                let mut taken = std::collections::BTreeSet::new();
                for issue in &schedule.issues {
                    let node = &graph.nodes[issue.node];
                    let kind = node.operation.kind();
                    let slot = (kind as usize, issue.operator, issue.cycle % schedule.interval);
                    assert!(taken.insert(slot), "{}: {issue:?}", graph.name);
                    let values = node.operands.map(|o| o.value).into_iter().chain([node.sign]);
                    for value in values {
                        match value {
                            Value::Node(of) => {
                                let ready = schedule.issues[of].cycle + LATENCY;
                                assert!(ready <= issue.cycle);
                                assert!(schedule.stay(value, issue.cycle).is_some());
                            }
                            Value::Input(_) => assert!(
                                issue.cycle < schedule.interval
                                    || schedule.stay(value, issue.cycle).is_some()
                            ),
                            Value::Late(_) => {
                                assert_eq!(issue.cycle / schedule.interval, schedule.late_lap);
                            }
                            Value::Setting(_) | Value::Literal(_) => {}
                        }
                    }
                }
                let mut kept = std::collections::BTreeSet::new();
                for stay in &schedule.stays {
                    for cycle in stay.cycles[0]..=stay.cycles[1] {
                        assert!(kept.insert((stay.register, cycle % schedule.interval)));
                    }
                }
            }
        }
    }
}

/// The README of `rtl/` quotes these.
#[test]
fn operations_and_intervals_are_those_that_are_stated() {
    let counts = [programs::cull(), programs::project()]
        .into_iter()
        .chain((0..4).map(programs::colour))
        .map(|graph| KINDS.map(|kind| graph.count(kind)));
    let expected = [[3, 6, 0], [103, 76, 8], [0, 3, 0], [9, 12, 0], [30, 31, 0], [58, 59, 0]];
    assert_eq!(counts.collect::<Vec<_>>(), expected);
    let intervals = WIDTHS.map(|ops| {
        let of = |program: Program| program.modes[program.modes.len() - 1].1.interval;
        [of(Program::cull(ops)), of(Program::project(ops)), of(Program::colour(ops))]
    });
    assert_eq!(intervals, [[6, 52, 59], [6, 26, 30], [3, 12, 15], [2, 6, 9]]);
}

/// With `UPDATE_EXPECT=1` they are written.
#[test]
fn generated_files_are_what_the_model_generates() {
    let rtl = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../rtl");
    for (name, text) in
        [("ccu_program_pkg.sv", emit::programs()), ("fp_special_pkg.sv", emit::tables())]
    {
        let path = rtl.join(name);
        if std::env::var_os("UPDATE_EXPECT").is_some() {
            std::fs::write(&path, &text).expect("a file in rtl/");
        }
        let found = std::fs::read_to_string(&path).expect("a file in rtl/");
        assert!(found == text, "rtl/{name} is not what is generated: set UPDATE_EXPECT=1");
    }
}
