//! What chunks take where units are followed through the sub-tiles of a tile.

use powergs_base::quantity::Bytes;
use powergs_core::flow::tile_wise::ResolvedUnits;
use powergs_core::flow::tile_wise::subtiles::{ChunkRun, runs};
use powergs_core::flow::tile_wise::{Termination, VruImpl};
use powergs_core::machine::Machine;
use powergs_core::machine::Ports;
use powergs_core::workload::{FrameWorkload, Geometry, bin};

use super::oracle;
use super::support::{Dice, gscore};
use crate::workload::support::dense_frame;

const CASES: u64 = 3000;

/// A machine with an organisation that has to be followed, and a frame for it.
fn case(seed: u64) -> Option<(Machine, FrameWorkload, ResolvedUnits)> {
    let mut dice = Dice::new(seed);
    let mut machine = dice.machine();
    let mut workload = dice.workload(machine.tiles().geometry);
    dice.organise(&mut workload, &mut machine);
    let units = ResolvedUnits::new(&machine);
    units.vru.discipline.is_some().then_some((machine, workload, units))
}

#[test]
fn chunks_take_what_they_take_cycle_by_cycle() {
    // Pairs in vain, cycles of a backlog, switches, entries that leave a queue unused.
    let (mut n, mut seen) = (0, [0; 4]);
    for seed in 0..CASES {
        let Some((machine, workload, units)) = case(seed) else { continue };
        let found = runs(&workload, &units.vru.discipline.expect("a discipline"));
        let tiles = 0..workload.tiles.len();
        let stepped: Vec<ChunkRun> =
            tiles.flat_map(|tile| oracle::subtiles::runs(&workload, &units, tile)).collect();
        assert_eq!(found.len(), workload.chunks.len());
        for (k, (ours, theirs)) in found.iter().zip(&stepped).enumerate() {
            assert_eq!(ours, theirs, "seed {seed} chunk {k} {:#?}", machine.tiles().vru);
        }
        n += found.len();
        seen[0] += found.iter().map(|run| run.vain).sum::<u64>();
        seen[1] += found.iter().map(|run| run.cycles - run.alone).sum::<u64>();
        seen[2] += found.iter().map(|run| run.switches).sum::<u64>();
        seen[3] += found.iter().map(|run| run.queued - run.pairs.min(run.queued)).sum::<u64>();
    }
    assert!(n > 1000 && seen.iter().all(|&sum| sum > 1000), "{n} {seen:?}");
}

/// Counts the cycles of tiles whose chunks come with gaps, or with none, and those by which A85 is
/// wrong: gaps, cycles, wrong ones.
fn with_gaps(
    workload: &FrameWorkload,
    units: &ResolvedUnits,
    dice: &mut Dice,
    most: u32,
) -> [u64; 3] {
    let all = runs(workload, &units.vru.discipline.expect("a discipline"));
    let mut sums = [0; 3];
    for (tile, work) in workload.tiles.iter().enumerate().filter(|(_, t)| t.chunks > 1) {
        let own = &all[work.chunk_start as usize..][..work.chunks as usize];
        let most = dice.roll(0, 2) * dice.roll(0, most);
        let gaps: Vec<u64> = own.iter().map(|_| u64::from(dice.roll(0, most))).collect();
        let stepped = oracle::subtiles::Tile::new(workload, units, tile).with_gaps(&gaps);
        for (k, (run, &cycles)) in own.iter().zip(&stepped).enumerate() {
            // What a full queue in front of it and the entry in work take is all that a chunk can
            // wait for. (But empty queues take more of a sub-tile that is not yet known to have
            // stopped.)
            let full = (u64::from(units.vru.spec.subtile_queue) + 1) * units.vru.pair_cycles();
            let is_between = (run.alone..=run.alone + full).contains(&cycles);
            let spec = &units.vru.spec;
            let is_late = spec.stop_latency > 0 || spec.termination == Termination::Tile;
            assert!(is_between || is_late, "{run:?} {cycles} {spec:#?}");
            let gap = if k == 0 { 0 } else { gaps[k] };
            let counted = run.cycles - gap.min(run.cycles - run.alone);
            if gaps[..=k].iter().skip(1).all(|&gap| gap == 0) {
                assert_eq!(counted, cycles);
            }
            sums[0] += u64::from(gap > 0);
            sums[1] += cycles;
            sums[2] += counted.abs_diff(cycles);
        }
    }
    sums
}

/// A85: between a chunk right behind the last one and a chunk alone.
#[test]
fn a_gap_in_front_of_a_chunk_is_between_two_exact_counts() {
    let mut sums = [0; 3];
    for seed in 0..CASES {
        let Some((machine, workload, units)) = case(seed) else { continue };
        if machine.tiles().vru.implementation == VruImpl::Parallel {
            let own = with_gaps(&workload, &units, &mut Dice::new(seed + CASES), 100);
            (0..3).for_each(|i| sums[i] += own[i]);
        }
    }
    let share = |[_, all, wrong]: [u64; 3]| wrong as f64 / all as f64;
    // Chunks of at most eight entries, in front of queues that hold more.
    assert!(sums[0] > 500 && share(sums) < 0.04, "{sums:?}");
    let geometry = Geometry { chunk: 16, ..Geometry::REFERENCE };
    let workload = bin(&dense_frame(3), geometry);
    let mut machine = gscore();
    machine.tiles_mut().geometry = geometry;
    machine.tiles_mut().vru.implementation = VruImpl::Parallel;
    // Close as long as a queue holds no more than a chunk.
    for (depth, most) in [(2, 0.005), (4, 0.005), (8, 0.005), (16, 0.01), (64, 0.25)] {
        machine.tiles_mut().vru.subtile_queue = depth;
        let units = ResolvedUnits::new(&machine);
        let sums = with_gaps(&workload, &units, &mut Dice::new(1), 500);
        assert!(sums[0] > 50 && share(sums) < most, "{depth} {sums:?}");
    }
}

/// The disciplines on a rendered frame, where counters of chunks say what they must come to.
#[test]
fn rendered_frames_agree_with_the_counters_of_their_chunks() {
    let geometry = Geometry { chunk: 64, ..Geometry::REFERENCE };
    let workload = bin(&dense_frame(3), geometry);
    let mut free = gscore();
    free.tiles_mut().geometry = geometry;
    let counted = ResolvedUnits::new(&free).vru;
    let with = |change: &dyn Fn(&mut Machine)| {
        let mut machine = free.clone();
        change(&mut machine);
        let units = ResolvedUnits::new(&machine);
        runs(&workload, &units.vru.discipline.expect("a discipline"))
    };
    // A change of state that is always hidden.
    let hidden = with(&|m| {
        m.tiles_mut().vru.implementation = VruImpl::Swap;
        m.tiles_mut().buffers.pixel_out.ports = Ports::ReadAndWrite;
        m.tiles_mut().buffers.pixel_out.word = Bytes(64);
        m.tiles_mut().buffers.pixel_out.banks = 8;
    });
    let scanned = with(&|m| m.tiles_mut().vru.implementation = VruImpl::Scan);
    let parallel = |depth| {
        with(&|m| {
            m.tiles_mut().vru.implementation = VruImpl::Parallel;
            m.tiles_mut().vru.subtile_queue = depth;
        })
    };
    let (deep, shallow, single) = (parallel(65536), parallel(16), parallel(1));
    for (k, chunk) in workload.chunks.iter().enumerate() {
        let pairs = counted.pairs(chunk);
        for run in [&hidden, &scanned, &deep, &shallow, &single] {
            assert_eq!((run[k].pairs, run[k].vain), (pairs, 0));
        }
        let cycles = (pairs * counted.pair_cycles()).max(u64::from(chunk.entries));
        assert_eq!(hidden[k].cycles, cycles);
        assert!(scanned[k].cycles >= cycles && scanned[k].reads >= u64::from(chunk.entries));
        assert!(scanned[k].switches <= 4 && hidden[k].switches <= pairs);
    }
    let of_tiles = |runs: &[ChunkRun]| -> Vec<u64> {
        let own = |t: &powergs_core::workload::TileWork| {
            runs[t.chunk_start as usize..][..t.chunks as usize].iter().map(|run| run.cycles).sum()
        };
        workload.tiles.iter().map(own).collect()
    };
    let [one, some, most] = [&single, &shallow, &deep].map(|runs| of_tiles(runs));
    // Queues that are never full: the fullest sub-tile, 16 cycles for each of its pairs.
    for (tile, cycles) in most.iter().enumerate() {
        let work = &workload.tiles[tile];
        let of = |s: usize| {
            let stop = workload.stops_of(tile)[s][0].min(work.loaded);
            let first = work.list_start as usize;
            let bits = &workload.bitmaps[first..first + stop as usize];
            16 * bits.iter().filter(|&&bits| bits >> s & 1 == 1).count() as u64
        };
        let fullest = (0..4).map(of).max().unwrap_or(0);
        let entries = u64::from(work.loaded);
        assert!(*cycles >= fullest.max(entries), "{cycles} {fullest} {entries}");
        assert!(*cycles <= fullest + entries, "{cycles} {fullest} {entries}");
        assert!(one[tile] >= some[tile] && some[tile] >= *cycles);
    }
    let sum = |cycles: &[u64]| cycles.iter().sum::<u64>() as f64;
    let sums = [sum(&one), sum(&some), sum(&most)];
    assert!(sums[0] > 1.05 * sums[1] && sums[1] > sums[2], "queues matter: {sums:?}");
}

#[test]
fn what_stops_late_works_in_vain() {
    let geometry = Geometry { chunk: 64, ..Geometry::REFERENCE };
    let workload = bin(&dense_frame(3), geometry);
    for way in VruImpl::ALL.into_iter().filter(|way| !way.needs_pixels()) {
        for termination in [Termination::Subtile, Termination::Tile] {
            if (way, termination) == (VruImpl::Scan, Termination::Tile) {
                continue;
            }
            let of = |latency| {
                let mut machine = gscore();
                machine.tiles_mut().geometry = geometry;
                machine.tiles_mut().vru.implementation = way;
                (machine.tiles_mut().vru.termination, machine.tiles_mut().vru.stop_latency) =
                    (termination, latency);
                let units = ResolvedUnits::new(&machine);
                let counted = workload.chunks.iter().map(|chunk| units.vru.pairs(chunk));
                let all = runs(&workload, &units.vru.discipline.expect("a discipline"));
                let needed: u64 = counted.sum();
                assert_eq!(all.iter().map(|run| run.pairs - run.vain).sum::<u64>(), needed);
                all.iter().map(|run| run.vain).sum::<u64>()
            };
            let (some, more) = (of(20), of(200));
            assert!(0 < some && some < more, "{way:?}: {some} {more}");
        }
    }
}
