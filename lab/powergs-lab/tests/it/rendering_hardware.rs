//! The cycles of rendering units as they are counted here against the model of `rtl/vru.sv`, which
//! co-simulation shows to be that of the hardware, cycle for cycle.

use powergs_core::flow::tile_wise::ResolvedUnits;
use powergs_core::flow::tile_wise::subtiles::{ChunkRun, runs};
use powergs_core::flow::tile_wise::{Termination, VruImpl};
use powergs_core::machine::Machine;
use powergs_core::workload::{ChunkWork, FrameWorkload, Geometry, TileWork};
use powergs_datapath::{Entry, NumberFormat, Record, TileRun, Vrc, Vru};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::support::gscore;

const FP16: NumberFormat = NumberFormat::FP16;

/// A machine whose rendering units are those of `rtl/`: queues of `queue` entries, and a stop that
/// is known `late` cycles after its pair.
fn machine(queue: usize, late: u32) -> Machine {
    let mut machine = gscore();
    machine.tiles_mut().vru.implementation = VruImpl::Parallel;
    machine.tiles_mut().vru.termination = Termination::Subtile;
    machine.tiles_mut().vru.subtile_skipping = true;
    machine.tiles_mut().vru.subtile_queue = queue as u32;
    machine.tiles_mut().vru.stop_latency = late;
    machine
}

/// A frame of one whole tile with these bitmaps and stops.
fn workload(geometry: Geometry, entries: &[Entry], run: &TileRun) -> FrameWorkload {
    let count = entries.len() as u32;
    let stop = |end: &Option<usize>| end.map_or(u32::MAX, |end| end as u32);
    FrameWorkload {
        width: 16,
        height: 16,
        tiles_x: 1,
        tiles_y: 1,
        tiles: vec![TileWork { entries: count, chunks: 1, pixels: 256, ..TileWork::default() }],
        chunks: vec![ChunkWork { entries: count, ..ChunkWork::default() }],
        bitmaps: entries.iter().map(|entry| entry.bitmap).collect(),
        stops: run.ends.iter().map(|end| [stop(end); 4]).collect(),
        ..FrameWorkload::empty(geometry)
    }
}

fn counted(entries: &[Entry], run: &TileRun, queue: usize, late: u32) -> ChunkRun {
    let machine = machine(queue, late);
    let units = ResolvedUnits::new(&machine);
    let workload = workload(machine.tiles().geometry, entries, run);
    runs(&workload, &units.vru.discipline.expect("a discipline"))[0]
}

/// Splats of one opacity everywhere: all pixels of a sub-tile stop with the same one.
fn even(random: &mut Pcg64Mcg, opacity: f32) -> Vec<Entry> {
    let count = random.random_range(1..200);
    let splat = Record { opacity: FP16.from_f32(opacity), ..Record::default() };
    let entry = |_| Entry { splat, bitmap: random.random_range(0..16) };
    (0..count).map(entry).collect()
}

/// Small and large splats with the bitmaps of their three-sigma squares.
fn scattered(random: &mut Pcg64Mcg) -> Vec<Entry> {
    let count = random.random_range(1..256);
    let entry = |_| {
        let sigma = 0.8 * (4.0 * random.random::<f32>()).exp2();
        let mean = [(); 2].map(|()| 24.0 * random.random::<f64>() - 12.0);
        let near = |subtile: usize, axis: usize| {
            let low = if subtile >> axis & 1 == 1 { 0.0 } else { -8.0 };
            let nearest = mean[axis].clamp(low, low + 8.0);
            (mean[axis] - nearest).abs() <= 3.0 * f64::from(sigma)
        };
        let bitmap = (0..4).filter(|&s| near(s, 0) && near(s, 1)).map(|s| 1 << s).sum();
        let covariance = [sigma * sigma + 0.3, 0.0, sigma * sigma + 0.3];
        let opacity = 0.3 + 0.69 * random.random::<f32>();
        let splat = Record::new(FP16, mean, covariance, opacity, [0.5; 3]).expect("an ellipse");
        Entry { splat, bitmap }
    };
    (0..count).map(entry).collect()
}

/// Cycles of a tile behind the one in which it opens until its last splat is issued, pairs, pairs
/// in vain.
fn hardware(run: &TileRun) -> (u64, u64, u64) {
    (run.close - 1, run.pairs, run.vain)
}

/// Where all pixels stop at once the hardware knows it 9 operations and two cycles after the pair:
/// 20 cycles with operations of two, 11 with operations of one.
#[test]
fn a_tile_takes_the_cycles_of_the_hardware() {
    let mut random = Pcg64Mcg::seed_from_u64(2);
    let (mut stopped, mut vain) = (0, 0);
    for (split, late) in [(true, 20), (false, 11)] {
        for queue in [2, 3, 16] {
            let unit = Vru { vrc: Vrc::new(FP16).expect("enough exponent"), split, queue };
            for opacity in [0.01, 0.3, 0.9] {
                for _ in 0..40 {
                    let entries = even(&mut random, opacity);
                    let run = unit.tile(&entries, [16, 16]);
                    let ours = counted(&entries, &run, queue, late);
                    assert_eq!((ours.cycles, ours.pairs, ours.vain), hardware(&run));
                    stopped += run.ends.iter().flatten().count();
                    vain += run.vain;
                }
            }
        }
    }
    assert!(stopped > 1000 && vain > 1000, "{stopped} {vain}");
}

/// In a picture pixels stop one by one, and the hardware knows of the last one up to 15 cycles
/// before its pair is over: 5 to 20 cycles after it. A88 says 18.
#[test]
fn a_stop_at_once_or_after_a_while_makes_little_difference() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let unit = Vru { vrc: Vrc::new(FP16).expect("enough exponent"), split: true, queue: 2 };
    let mut sums = [[0; 3]; 4];
    let mut stopped = 0;
    for _ in 0..300 {
        let entries = scattered(&mut random);
        let run = unit.tile(&entries, [16, 16]);
        stopped += run.ends.iter().flatten().count();
        let ours = [5, 18, 20].map(|late| counted(&entries, &run, 2, late));
        let ours = ours.map(|run| (run.cycles, run.pairs, run.vain));
        for (sum, own) in sums.iter_mut().zip([hardware(&run)].into_iter().chain(ours)) {
            *sum = [sum[0] + own.0, sum[1] + own.1, sum[2] + own.2];
        }
    }
    assert!(stopped > 800, "{stopped}");
    let [hardware, early, ours, late] = sums;
    for k in 0..3 {
        assert!(early[k] <= hardware[k] && hardware[k] <= late[k], "{sums:?}");
    }
    let more = |k: usize| ours[k] as f64 / hardware[k] as f64 - 1.0;
    assert!((0.0..0.003).contains(&more(0)) && (0.0..0.007).contains(&more(1)), "{sums:?}");
}
