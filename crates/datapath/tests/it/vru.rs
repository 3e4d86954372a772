//! The rendering unit of a core: `rtl/vru.sv` against its model, bit for bit and cycle for cycle.

use powergs_datapath::{Entry, NumberFormat, Record, TileRun, Vrc, Vru};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::verilator::Bench;
use super::vrc::splat;

struct Tile {
    size: [u32; 2],
    entries: Vec<Entry>,
}

/// Tiles of all kinds: empty, at the edge of the image, of entries for all sub-tiles, few or none,
/// opaque ones that stop.
fn tiles(vrc: &Vrc, random: &mut Pcg64Mcg) -> Vec<Tile> {
    let format = vrc.format();
    let tile = |index: u32| {
        let count = if index < 3 { index } else { random.random_range(0..100) };
        let edge = [random.random_range(1..17), random.random_range(1..17)];
        let size = if index % 4 == 3 { edge } else { [16, 16] };
        let opaque = index % 3 == 1;
        let mut entry = || {
            let any = splat(vrc, random);
            let opacity = if opaque { format.from_f32(0.97) } else { any.opacity };
            let bitmap = match random.random_range(0..4) {
                0 => 15,
                1 => 1 << random.random_range(0..4),
                _ => random.random_range(0..16),
            };
            // Of an opaque tile half the entries cover it.
            let covers = opaque && random.random::<bool>();
            let (mean, root) = if covers { ([0; 2], [0; 3]) } else { (any.mean, any.root) };
            Entry { splat: Record { mean, opacity, root, ..any }, bitmap }
        };
        Tile { size, entries: (0..count).map(|_| entry()).collect() }
    };
    (0..48).map(tile).collect()
}

/// Cycles in which beats are accepted, and cycle and words of pixels that leave.
type Events = (Vec<u64>, Vec<(u64, Vec<u16>)>);

fn run(bench: &Bench, tiles: &[Tile], stalls: [u16; 2]) -> Events {
    let mut words = vec![9, stalls[0], stalls[1]];
    for tile in tiles {
        words.extend([0; 11]);
        words.extend(tile.size.map(|side| side as u16));
        for Entry { splat: s, bitmap } in &tile.entries {
            words.push(1);
            words.extend(s.mean.iter().chain(&s.root).chain([&s.opacity]).chain(&s.colour));
            words.extend([u16::from(*bitmap), 0, 0]);
        }
        words.push(2);
        words.extend([0; 12]);
    }
    let (mut accepted, mut pixels) = (Vec::new(), Vec::new());
    for event in bench.run(&words).chunks_exact(67) {
        let cycle = u64::from(event[1]) | u64::from(event[2]) << 16;
        match event[0] {
            0 => pixels.push((cycle, event[3..].to_vec())),
            _ => accepted.push(cycle),
        }
    }
    (accepted, pixels)
}

/// Without stalls: a beat is accepted in the cycle in which the one before leaves the head.
fn expected(runs: &[TileRun]) -> Events {
    let (mut accepted, mut pixels) = (vec![0], Vec::new());
    let mut open = 1;
    for run in runs {
        accepted.push(open);
        accepted.extend(run.left.iter().map(|left| open + left));
        accepted.push(open + run.close);
        for i in 0..16 {
            let words = (0..16).flat_map(|core| {
                let pixel = run.pixels[16 * core + i];
                let [r, g, b] = pixel.colour;
                [r, g, b, pixel.transmittance]
            });
            pixels.push((open + run.first_pixels + i as u64, words.collect()));
        }
        open += run.first_pixels + 16;
    }
    // The last beat that leaves lets nobody in.
    accepted.pop();
    (accepted, pixels)
}

#[test]
fn the_unit_in_hardware_is_the_unit_of_the_model() {
    for (name, split, queue) in [("e5m10", true, 2), ("e4m3", false, 4)] {
        let format: NumberFormat = name.parse().expect("a format");
        let parameters = [
            ("EXP", format.exponent_bits()),
            ("MAN", format.mantissa_bits()),
            ("SPLIT", u32::from(split)),
            ("QUEUE", queue as u32),
        ];
        let Some(bench) = Bench::build("vru", &parameters) else { return };
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let unit = Vru { vrc: Vrc::new(format).expect("enough exponent"), split, queue };
        let tiles = tiles(&unit.vrc, &mut random);
        let runs: Vec<TileRun> =
            tiles.iter().map(|tile| unit.tile(&tile.entries, tile.size)).collect();
        let stopped = runs.iter().flat_map(|run| run.ends).flatten().count();
        let vain: u64 = runs.iter().map(|run| run.vain).sum();
        assert!(stopped > 20 && vain > 10, "{stopped} sub-tiles stop, {vain} pairs in vain");
        let (found, expected) = (run(&bench, &tiles, [0, 0]), expected(&runs));
        for (i, pair) in found.0.iter().zip(&expected.0).enumerate() {
            assert_eq!(pair.0, pair.1, "{name}: beat {i}");
        }
        assert_eq!(found.0.len(), expected.0.len());
        assert!(found.1 == expected.1, "{name}: pixels or their cycles");
        for stalls in [[4, 0], [0, 6], [6, 3]] {
            let (accepted, pixels) = run(&bench, &tiles, stalls);
            assert_eq!(accepted.len(), expected.0.len());
            let same = pixels.iter().zip(&expected.1).all(|(a, b)| a.1 == b.1);
            assert!(same && pixels.len() == expected.1.len(), "{name}, stalls {stalls:?}");
        }
    }
}
