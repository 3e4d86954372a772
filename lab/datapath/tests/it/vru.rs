//! The rendering unit of a core: `rtl/vru.sv` against its model, bit for bit and cycle for cycle.

use powergs_datapath::vectors::{self, Tile};
use powergs_datapath::{Entry, NumberFormat, Record, TileRun, Vrc, Vru};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::bench;
use super::vrc::splat;

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
        (size, (0..count).map(|_| entry()).collect())
    };
    (0..48).map(tile).collect()
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
        let Some(bench) = bench("vru", &parameters) else { return };
        let mut random = Pcg64Mcg::seed_from_u64(1);
        let unit = Vru { vrc: Vrc::new(format).expect("enough exponent"), split, queue };
        let tiles = tiles(&unit.vrc, &mut random);
        let runs: Vec<TileRun> =
            tiles.iter().map(|(size, entries)| unit.tile(entries, *size)).collect();
        let stopped = runs.iter().flat_map(|run| run.ends).flatten().count();
        let vain: u64 = runs.iter().map(|run| run.vain).sum();
        assert!(stopped > 20 && vain > 10, "{stopped} sub-tiles stop, {vain} pairs in vain");
        let vectors = vectors::vru(&unit, &tiles);
        for head in [[9, 0, 0], [9, 4, 0], [9, 0, 6], [9, 6, 3]] {
            let found = vectors.events(&bench.run(&vectors.stalled(head)));
            let cycles = head == [9, 0, 0];
            assert_eq!(vectors.difference(&found, cycles), None, "{name}, stalls {head:?}");
        }
    }
}
