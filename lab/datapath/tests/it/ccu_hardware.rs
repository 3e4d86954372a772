//! `rtl/ccu.sv` against its model, bit for bit and cycle for cycle.

use powergs_datapath::ccu::emit::{Program, WIDTHS};
use powergs_datapath::ccu::schedule::Schedule;
use powergs_datapath::ccu::{Ccu, Gaussian, Settings};
use powergs_datapath::vectors::ccu::{
    COLOUR, PAIR, SPLAT, TAKES_COEFFICIENTS, TAKES_MEAN, TAKES_SHAPE, VERDICT,
};
use powergs_datapath::vectors::{self, CcuWork, Vectors};
use powergs_datapath::{NumberFormat, WideFormat};
use powergs_testkit::verilator::Bench;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::ccu::{any_gaussian, gaussian, place_in_view, view};

/// Cycles from the end of the projection until a splat is set up for its tiles.
const SETUP: u32 = 9;

/// What happens: kind and cycle.
type Happens = (u16, u32);

/// A Gaussian with coefficients: now and then they are any bits.
fn work(ccu: &Ccu, gaussian: Gaussian, random: &mut Pcg64Mcg) -> CcuWork {
    let f = ccu.narrow();
    let mask = u16::MAX >> (16 - f.bits());
    let wild = random.random_range(0..8) == 0;
    let coefficients = std::array::from_fn(|_| match wild {
        true => random.random::<u16>() & mask,
        false => f.from_f32(2.0 * random.random::<f32>() - 1.0),
    });
    CcuWork { gaussian, coefficients }
}

/// Runs the work; everything that leaves is what the model says.
fn run(bench: &Bench, vectors: &Vectors, [come, go]: [u16; 2], what: &str) -> Vec<Happens> {
    let found = vectors.events(&bench.run(&vectors.stalled([11, come, go])));
    assert_eq!(vectors.difference(&found, false), None, "{what}, stalls {come}, {go}");
    found.into_iter().map(|event| (event.kind, event.cycle)).collect()
}

fn cycles_of(events: &[Happens], kind: u16) -> Vec<u32> {
    events.iter().filter(|event| event.0 == kind).map(|event| event.1).collect()
}

/// Schedules of culling, projection and a degree's colours.
struct Laps([Schedule; 3]);

impl Laps {
    fn new(ops: u32, degree: u32) -> Laps {
        let one = |program: Program, mode: u32| program.modes[mode as usize].1.clone();
        Laps([
            one(Program::cull(ops), 0),
            one(Program::project(ops), 0),
            one(Program::colour(ops), degree),
        ])
    }

    /// Cycles of all that happens to one Gaussian of one tile that is offered in `cycle` and finds
    /// the unit empty; laps begin at multiples of their lengths.
    fn alone(&self, cycle: u32) -> Vec<(u16, u32)> {
        let [cull, project, colour] = &self.0;
        let lap = |schedule: &Schedule, from: u32| {
            let interval = schedule.interval as u32;
            from.div_ceil(interval) * interval
        };
        let enters = lap(cull, cycle);
        let verdict = enters + cull.leaves as u32;
        let projects = lap(project, verdict + 1);
        let projected = projects + project.leaves as u32;
        let handed = projected + SETUP;
        let colours = lap(colour, handed + 1);
        let late = (colour.late_lap as u32 + 1) * colour.interval as u32;
        let mut events = [
            (TAKES_MEAN, enters + cull.interval as u32 - 1),
            (VERDICT, verdict),
            (TAKES_SHAPE, projects + project.interval as u32 - 1),
            (SPLAT, handed + 1),
            (PAIR, handed + 2),
            (TAKES_COEFFICIENTS, colours + late - 1),
            (COLOUR, colours + colour.leaves as u32),
        ];
        events.sort_by_key(|&(kind, cycle)| (cycle, kind));
        events.to_vec()
    }
}

/// Distances of cycles, which are all the same.
#[track_caller]
fn interval(cycles: &[u32]) -> u32 {
    let first = cycles[1] - cycles[0];
    assert!(cycles.windows(2).all(|pair| pair[1] - pair[0] == first), "{cycles:?}");
    first
}

fn formats() -> [(WideFormat, NumberFormat); 2] {
    let format = |exponent, mantissa| WideFormat::new(exponent, mantissa).expect("a format");
    let small = NumberFormat::new(5, 6).expect("a format");
    [(format(8, 15), NumberFormat::FP16), (format(7, 11), small)]
}

fn bench(ops: u32, (wide, narrow): (WideFormat, NumberFormat)) -> Option<Bench> {
    let parameters = [
        ("EXP", wide.exponent_bits()),
        ("MAN", wide.mantissa_bits()),
        ("TO_EXP", narrow.exponent_bits()),
        ("TO_MAN", narrow.mantissa_bits()),
        ("OPS", ops),
    ];
    super::bench("ccu", &parameters)
}

#[test]
fn the_unit_in_hardware_is_the_unit_of_the_model() {
    let [normal, small] = formats();
    for (ops, formats) in WIDTHS.map(|ops| (ops, normal)).into_iter().chain([(8, small)]) {
        let Some(bench) = bench(ops, formats) else { return };
        let ccu = Ccu::new(formats.0, formats.1).expect("formats that fit");
        let settings = view(&ccu);
        values(&bench, ops, &ccu, &settings);
        if formats == normal {
            cycles(&bench, ops, &ccu, &settings);
        }
    }
}

/// Random Gaussians, with and without stalls.
fn values(bench: &Bench, ops: u32, ccu: &Ccu, settings: &Settings) {
    let mut random = Pcg64Mcg::seed_from_u64(u64::from(ops));
    // The unit that is synthesised gets 2,100 Gaussians, the others 500.
    let (counts, stalls): ([u32; 4], &[[u16; 2]]) = match ops {
        16 => ([300, 300, 300, 1200], &[[0, 0], [4, 0], [0, 4], [6, 3]]),
        _ => ([60, 60, 80, 300], &[[0, 0], [4, 4]]),
    };
    for (degree, count) in (0..).zip(counts) {
        let mut one = |i: u32| {
            let any = match i % 4 {
                0 => any_gaussian(ccu, &mut random),
                _ => gaussian(ccu, &mut random),
            };
            work(ccu, any, &mut random)
        };
        let work: Vec<CcuWork> = (0..count).map(&mut one).collect();
        let vectors = vectors::ccu(ccu, settings, degree, 0, &work);
        let seen = vectors.expected.iter().filter(|event| event.kind == COLOUR).count();
        assert!(seen > count as usize / 8, "{seen} of {count} are seen");
        for &stalls in stalls {
            run(bench, &vectors, stalls, &format!("{ops} operators, degree {degree}"));
        }
    }
}

/// Latencies of Gaussians that find the unit empty, and intervals of those that follow each other.
fn cycles(bench: &Bench, ops: u32, ccu: &Ccu, settings: &Settings) {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    for degree in 0..4 {
        let laps = Laps::new(ops, degree);
        let mut single = Vec::new();
        while single.len() < 12 {
            let any = gaussian(ccu, &mut random);
            if ccu.splat(settings, &any).is_some_and(|(_, walk)| walk.candidates() == 1) {
                single.push(work(ccu, any, &mut random));
            }
        }
        let vectors = vectors::ccu(ccu, settings, degree, 2000, &single);
        let mut found = run(bench, &vectors, [0; 2], "one at a time").into_iter();
        let mut offered = 0;
        for _ in &single {
            let expected = laps.alone(offered);
            let mut found: Vec<_> = found.by_ref().take(expected.len()).collect();
            found.sort_by_key(|&(kind, cycle)| (cycle, kind));
            assert_eq!(found, expected, "{ops} operators, degree {degree}");
            offered = expected[0].1 + 2001;
        }
        // What is culled, what is seen nowhere, what is seen.
        let [cull, project, colour] = laps.0.each_ref().map(|s| s.interval as u32);
        let mut at = |place: [f64; 3]| {
            let gaussian = place_in_view(ccu, place);
            let same: Vec<CcuWork> = (0..60).map(|_| work(ccu, gaussian, &mut random)).collect();
            run(bench, &vectors::ccu(ccu, settings, degree, 0, &same), [0; 2], "one after another")
        };
        let behind = at([0.0, 0.0, -1.0]);
        assert_eq!(interval(&cycles_of(&behind, VERDICT)), cull);
        let outside = at([40.0, 0.0, 2.0]);
        assert_eq!(interval(&cycles_of(&outside, TAKES_SHAPE)[10..]), project.max(cull));
        let seen = cycles_of(&at([0.02, 0.02, 2.0]), TAKES_COEFFICIENTS);
        let mean = f64::from(seen[59] - seen[29]) / 30.0;
        let slowest = project.max(SETUP).max(colour).max(cull);
        assert!((mean - f64::from(slowest)).abs() < 1.0, "{ops}, {degree}: {mean}");
    }
}
