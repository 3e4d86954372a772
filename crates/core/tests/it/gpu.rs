//! GPUs: warps thread by thread, the cache entry by entry, multiprocessors in small steps, and the
//! laws of every dataflow.

pub mod frame;

use std::collections::VecDeque;

use powergs_base::config::embedded::MACHINES;
use powergs_core::flow::gpu::blocks::{ThreadBlock, ends};
use powergs_core::flow::gpu::cache::{FilterKey, Filtered, ListReads::UntilStop};
use powergs_core::flow::gpu::rops::Drawn;
use powergs_core::flow::gpu::warps::{FrameWarps, WarpShape};
use powergs_core::flow::gpu::{Gpu, GpuKernel, KernelPart, Kernels, WARP};
use powergs_core::flow::{FlowOutcome, FrameTask};
use powergs_core::kernel::Memo;
use powergs_core::kernel::blocks::BlockStream;
use powergs_core::machine::Machine;
use powergs_core::sim::contract::{Trial, broken};
use powergs_core::stage::work_id;
use powergs_core::workload::{FrameDetail, FrameWorkload, bin_for};
use powergs_frame::splat::Ellipse;
use powergs_frame::splat::pixel::spans;
use powergs_frame::trace::{Frame, NEVER};

use crate::workload::support::{dense_frame, moved_frame, small_frame};

const SMALL: [&str; 5] =
    ["sm.units=2", "l2.capacity=4 KiB", "blend.batch=32", "sm.interval=7", "launch.gap=1 us"];

fn machine(sets: &[&str]) -> Machine {
    let file = MACHINES.iter().find(|file| file.name == "xavier-nx").expect("a machine").complete();
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    Machine::parse_with(&file, &sets).expect("a machine")
}

fn workload(frame: &Frame, gpu: &Gpu) -> FrameWorkload {
    bin_for(frame, gpu.geometry(), FrameDetail { pixels: true, whole: false })
}

/// A thread: its pixel, and the rank with which it stops.
#[derive(Clone, Copy)]
struct Thread {
    x: u32,
    y: u32,
    last: u32,
}

/// Warps of a tile as the kernel has them: 32 threads of a block one after the other, which go
/// through its pixels in rows as wide as a warp.
fn warps_of(frame: &Frame, gpu: &Gpu, tile: usize, columns: u32) -> Vec<Vec<Thread>> {
    let (side, wide) = (gpu.blend.tile, gpu.blend.warp_width);
    let camera = &frame.facts.camera;
    let [left, top] = [tile as u32 % columns * side, tile as u32 / columns * side];
    let mut warps = Vec::new();
    for first_row in (0..side).step_by((WARP / wide) as usize) {
        for first_column in (0..side).step_by(wide as usize) {
            let lanes = (0..WARP).map(|lane| {
                let x = left + first_column + lane % wide;
                let y = top + first_row + lane / wide;
                (x, y)
            });
            let lanes = lanes.filter(|&(x, y)| x < camera.width && y < camera.height);
            let thread = |(x, y): (u32, u32)| {
                let last = frame.pixels.stop_rank[(y * camera.width + x) as usize];
                Thread { x, y, last }
            };
            warps.push(lanes.map(thread).collect());
        }
    }
    warps
}

/// What a warp does with a list: entries that it evaluates, and those in which a thread blends.
fn run_warp(frame: &Frame, list: &[u32], threads: &[Thread]) -> [u32; 2] {
    let mut done = vec![false; threads.len()];
    let mut counts = [0, 0];
    for &rank in list {
        for (thread, done) in threads.iter().zip(&mut done) {
            *done |= thread.last != NEVER && thread.last < rank;
        }
        if done.iter().all(|done| *done) {
            break;
        }
        counts[0] += 1;
        let ellipse = Ellipse::of(&frame.splats[rank as usize]);
        let meets = |t: &Thread| {
            let columns = ellipse.as_ref().and_then(|e| e.columns(t.y.into(), i64::from(t.y) + 1));
            columns.is_some_and(|(first, end)| (first..end).contains(&i64::from(t.x)))
        };
        counts[1] += u32::from(threads.iter().zip(&done).any(|(t, done)| !done && meets(t)));
    }
    counts
}

#[test]
fn warps_are_those_of_threads_one_by_one() {
    let shapes: [&[&str]; 4] = [
        &[],
        &["blend.warp-width=8", "pairs.test=ellipse"],
        &["blend.warp-width=4", "blend.tile=8", "blend.batch=7"],
        &["blend.warp-width=32", "blend.tile=32", "sm.shared=200 KiB", "pairs.test=obb"],
    ];
    for seed in 0..3 {
        let frame = small_frame(seed);
        for sets in shapes {
            let machine = machine(sets);
            let gpu = machine.gpu();
            let work = workload(&frame, gpu);
            let ours = FrameWarps::new(&work, &WarpShape::of(gpu));
            for (tile, block) in ours.blocks.iter().enumerate() {
                let list = work.list_of(&work.tiles[tile]);
                let warps = warps_of(&frame, gpu, tile, work.tiles_x);
                let counts: Vec<[u32; 2]> =
                    warps.iter().map(|threads| run_warp(&frame, list, threads)).collect();
                let sum = |i: usize| counts.iter().map(|c| u64::from(c[i])).sum::<u64>();
                assert_eq!([block.evaluated, block.blended], [sum(0), sum(1)], "{sets:?} {tile}");
                let longest = counts.iter().map(|c| c[0]).max().unwrap_or(0);
                assert_eq!(block.longest[0], longest);
                assert!(counts.contains(&block.longest));
                // The block reads whole batches until nobody needs more.
                let batches = longest.div_ceil(gpu.blend.batch) * gpu.blend.batch;
                assert_eq!(block.loaded, batches.min(list.len() as u32));
            }
            // Pairs of a thread, and of the slowest of its warp.
            let mut pairs = vec![0_u64; frame.facts.points as usize];
            work.list.iter().for_each(|&r| pairs[frame.splats[r as usize].index as usize] += 1);
            let slowest = pairs.chunks(32).map(|warp| warp.iter().max().copied().unwrap_or(0));
            assert_eq!(ours.pair_steps, slowest.sum::<u64>());
            let with_one = pairs.chunks(32).filter(|warp| warp.iter().any(|n| *n > 0)).count();
            assert_eq!(ours.converting[2], with_one as u64);
        }
    }
}

#[test]
fn the_cache_is_a_queue_of_what_came_last() {
    let frame = dense_frame(2);
    let machine = machine(&["blend.batch=32"]);
    let work = workload(&frame, machine.gpu());
    let key = |capacity| FilterKey {
        capacity,
        entry: 4,
        feature: 96,
        reads: UntilStop,
        geometry: work.geometry,
    };
    for capacity in [0, 500, 3000, 20_000, 1 << 30] {
        let mut queue: VecDeque<(Option<u32>, u64)> = VecDeque::new();
        let (mut held, mut found) = (0, Filtered::default());
        for tile in &work.tiles {
            for &rank in &work.list_of(tile)[..tile.loaded as usize] {
                let mut comes = |queue: &mut VecDeque<_>, what, bytes| {
                    queue.push_back((what, bytes));
                    held += bytes;
                    // What is not wholly in it any more is gone.
                    while held >= capacity.max(1) {
                        let Some((_, first)) = queue.pop_front() else { break };
                        held -= first;
                    }
                };
                comes(&mut queue, None, 4);
                if queue.iter().any(|(what, _)| *what == Some(rank)) {
                    found.hits += 1;
                } else {
                    found.misses += 1;
                    comes(&mut queue, Some(rank), 96);
                }
            }
        }
        let ours = Filtered::new(&work, &key(capacity));
        let all = (found.hits + found.misses) as f64;
        // What lies across the end of the cache is half in it: one entry more or less.
        assert_eq!(ours.hits + ours.misses, found.hits + found.misses);
        assert!((ours.hits as f64 - found.hits as f64).abs() < 0.02 * all, "{capacity}: {ours:?}");
    }
    let all = |capacity| Filtered::new(&work, &key(capacity));
    let splats = work.list.iter().collect::<std::collections::BTreeSet<_>>().len() as u64;
    assert!(all(1 << 40).misses <= splats, "each once where everything fits");
    assert_eq!(all(0).hits, 0);
}

/// Blocks over multiprocessors in steps of a small time.
fn stepped(blocks: &[ThreadBlock], units: usize, resident: usize, step: f64) -> f64 {
    let mut waiting: VecDeque<ThreadBlock> = blocks.iter().copied().collect();
    let mut at_work: Vec<Vec<(f64, f64)>> = vec![Vec::new(); units];
    let take = |b: ThreadBlock| (b.work, b.work / b.alone);
    for _ in 0..resident {
        for unit in &mut at_work {
            unit.extend(waiting.pop_front().map(take));
        }
    }
    let mut now = 0.0;
    while at_work.iter().any(|unit| !unit.is_empty()) {
        now += step;
        for unit in &mut at_work {
            // Shares of the issue slots: nobody gets more than he can use, what is left goes round.
            let mut share = vec![0.0; unit.len()];
            let mut room = 1.0_f64;
            for _ in 0..unit.len() {
                let hungry: Vec<usize> =
                    (0..unit.len()).filter(|&i| share[i] < unit[i].1 - 1e-12).collect();
                let each = room / hungry.len().max(1) as f64;
                for i in hungry {
                    let more = each.min(unit[i].1 - share[i]);
                    share[i] += more;
                    room -= more;
                }
            }
            for (block, share) in unit.iter_mut().zip(share) {
                block.0 -= share * step;
            }
            unit.retain(|block| block.0 > 1e-9);
            while unit.len() < resident {
                let Some(block) = waiting.pop_front() else { break };
                unit.push(take(block));
            }
        }
    }
    now
}

#[test]
fn blocks_share_multiprocessors_as_in_small_steps() {
    for seed in 0..20_u64 {
        let number =
            |i: u64| (seed * 977 + i).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31) % 97;
        let block = |i| {
            let work = 1.0 + number(i) as f64;
            ThreadBlock { work, alone: work * (1.0 + number(i + 500) as f64 / 20.0) }
        };
        let blocks: Vec<ThreadBlock> = (0..40).map(block).collect();
        for (units, resident) in [(1, 1), (3, 2), (4, 8), (64, 4)] {
            let ours = ends(blocks.iter().copied(), units, resident);
            let last = ours.iter().copied().fold(0.0, f64::max);
            let expected = stepped(&blocks, units as usize, resident as usize, 0.02);
            // A block that ends a step later may go to another multiprocessor.
            assert!((last / expected - 1.0).abs() < 0.03, "{units} {resident}: {last} {expected}");
            let work: f64 = blocks.iter().map(|b| b.work).sum();
            let alone = blocks.iter().map(|b| b.alone).fold(0.0, f64::max);
            assert!(last >= alone - 1e-6 && last >= work / f64::from(units) - 1e-6);
        }
    }
    assert_eq!(ends(std::iter::empty(), 3, 2), [0.0; 3]);
}

/// Bytes and instructions of a frame, from its own facts.
#[test]
fn kernels_move_what_the_arrays_take() {
    let frame = dense_frame(1);
    let machine = machine(&["l2.capacity=0 B"]);
    let gpu = machine.gpu();
    let work = workload(&frame, gpu);
    let kernels = Kernels::new(&machine, &work, None, &Memo::default());
    let sum = |part: KernelPart, i: usize| -> u64 {
        kernels.all.iter().filter(|k| k.part == part).map(|k| k.memory[i]).sum()
    };
    let points = frame.facts.points;
    let seen = work.list.iter().collect::<std::collections::BTreeSet<_>>().len() as u64;
    let coefficients = (u64::from(frame.facts.colour_degree().get()) + 1).pow(2);
    let read = 12 * points + 32 * frame.facts.survivors + 12 * coefficients * seen;
    assert_eq!(sum(KernelPart::Convert, 0), read);
    assert_eq!(sum(KernelPart::Convert, 1), 8 * points + 24 * frame.facts.survivors + 51 * seen);
    let pairs = work.list.len() as u64;
    assert_eq!(sum(KernelPart::Pairs, 0), 8 * points + 24 * seen);
    assert_eq!(sum(KernelPart::Pairs, 1), 4 * points + 12 * pairs);
    // 32 bits of depth and those of 10 x 6 tiles: six bits, five digits.
    let tiles = work.tiles.len() as u64;
    assert_eq!(tiles, 60);
    assert_eq!(sum(KernelPart::Sort, 0), (8 + 5 * 12 + 8) * pairs);
    assert_eq!(sum(KernelPart::Sort, 1), 5 * 12 * pairs + 8 * tiles);
    let loaded: u64 = work.tiles.iter().map(|tile| u64::from(tile.loaded)).sum();
    assert_eq!(sum(KernelPart::Blend, 0), 100 * loaded + 8 * tiles);
    assert_eq!(sum(KernelPart::Blend, 1), 20 * 150 * 90);
    // A cache that holds everything keeps all that is made on the way.
    let machine = self::machine(&["l2.capacity=1 GiB"]);
    let kernels = Kernels::new(&machine, &work, None, &Memo::default());
    let between =
        kernels.all.iter().filter(|k| matches!(k.part, KernelPart::Pairs | KernelPart::Sort));
    assert!(between.clone().count() > 0 && between.into_iter().all(|k| k.memory == [0, 0]));
}

/// A step of training, from the facts of its frame.
#[test]
fn a_step_moves_what_its_arrays_take() {
    let frame = dense_frame(1);
    let made = |sets: &[&str]| {
        let sets = [&["l2.capacity=0 B"], sets].concat();
        let machine = machine(&sets);
        let work = workload(&frame, machine.gpu());
        let kernels = Kernels::new(&machine, &work, None, &Memo::default());
        let sum = |part: KernelPart, of: fn(&GpuKernel) -> u64| -> u64 {
            kernels.all.iter().filter(|k| k.part == part).map(of).sum()
        };
        let both = |part| [sum(part, |k| k.memory[0]), sum(part, |k| k.memory[1])];
        let parts = [KernelPart::Loss, KernelPart::Backward, KernelPart::Chain, KernelPart::Update];
        (parts.map(both), sum(KernelPart::Backward, |k| k.atomics), work)
    };
    let (pixels, points) = (150 * 90, frame.facts.points);
    let ([loss, backward, chain, update], atomics, work) = made(&["training.sum=pixel"]);
    let seen = work.list.iter().collect::<std::collections::BTreeSet<_>>().len() as u64;
    let coefficients = (u64::from(frame.facts.colour_degree().get()) + 1).pow(2);
    let stored = 12 + 32 + 12 * coefficients;
    assert_eq!(loss, [60 * pixels; 2]);
    let (entries, tiles) = (work.list.len() as u64, work.tiles.len() as u64);
    let loaded: u64 = work.tiles.iter().map(|tile| u64::from(tile.loaded)).sum();
    // Lists and their Gaussians whole, from the end; sums of what is in front of the stops, which
    // alone is blended; all in whole sectors.
    assert!(loaded < entries, "something lies behind the stops");
    let (lists, sums) = (entries * (4 + 96) + 8 * tiles, loaded * 64);
    assert_eq!(backward, [lists + 20 * pixels + sums, sums]);
    let numbers = 11 + 3 * coefficients;
    assert_eq!(stored, 4 * numbers);
    assert_eq!(chain, [seen * (stored + 36), 300 * points + seen * stored]);
    // GS-Scale: seven times 59 numbers of 4 B, 1,652 B, at degree 3.
    assert_eq!(update, [4 * stored * points, 3 * stored * points]);
    assert_eq!(7 * (12 + 32 + 12 * 16), 1652);
    // What stops a pixel is counted with its blends, and has no gradient.
    let stopped = frame.pixels.stop_rank.iter().filter(|stop| **stop != NEVER).count() as u64;
    assert!(stopped > 0);
    assert_eq!(atomics, 9 * (work.counters.blends - stopped));
    let (_, by_warp, _) = made(&["training.sum=warp"]);
    let (_, by_block, _) = made(&["training.sum=block"]);
    assert!(atomics > 4 * by_warp && by_warp > by_block && by_block % 9 == 0, "{by_warp}");
    assert!(by_block <= 9 * loaded);
    let (parts, atomics, _) = made(&["training.sum=none"]);
    assert_eq!((parts, atomics), ([[0; 2]; 4], 0));
    let ([.., update], _, _) = made(&["training.sum=warp", "training.update=visible"]);
    assert_eq!(update, [4 * stored * seen, 3 * stored * seen]);
    let ([.., update], _, _) = made(&["training.sum=warp", "training.update=none"]);
    assert_eq!(update, [0, 0]);
    let ([.., update], _, _) =
        made(&["training.sum=warp", "training.update=none", "training.densify=10"]);
    let own = 8 * seen + (3 * stored * points).div_ceil(10);
    assert_eq!(update, [own, own]);
    // Without moments, and with parameters in half precision and records in single.
    let widths = ["training.widths.moment=0 B", "training.widths.parameter=2 B"];
    let ([.., update], _, _) = made(&[&["training.sum=warp"], &widths[..]].concat());
    assert_eq!(update, [(2 + 4) * numbers * points, (2 * numbers + stored) * points]);
}

#[test]
fn gpus_keep_the_laws() {
    let file = MACHINES.iter().find(|file| file.name == "xavier-nx").expect("a machine").complete();
    // As wide as a device of the same rate, so that it can be `banked`.
    let file = file.replace("channels = 1", "channels = 8");
    let frames = [small_frame(0), moved_frame(1, 0.05), moved_frame(2, 0.1), dense_frame(1)];
    let alone = ["sm.units=512", "sm.interval=40", "blend.latency=9000", "blend.registers=128"];
    let trial = Trial {
        machine: &file,
        files: &[],
        variants: &[
            &[],
            &SMALL,
            &["l2.bytes-per-cycle=1", "l2.sector=64 B", "blend.feature=100 B"],
            &["radix.count=each-pass", "convert.cull=frustum", "pairs.test=ellipse"],
            &["blend.test=4", "blend.warp-width=8", "sm.special=1", "sm.float=1.0"],
            &["training.sum=pixel", "training.atomics=0.05"],
            &[
                "training.sum=warp",
                "training.update=visible",
                "l2.capacity=64 KiB",
                "training.densify=9",
            ],
            &["training.sum=block", "dram.device=lpddr4-3200-x16x8", "dram.model=banked"],
            &["attached.impl=rows", "attached.lanes=3", "attached.clock=500 MHz"],
            &["attached.impl=box", "attached.overlap=none", "dram.latency=100 ns"],
            &[
                "attached.impl=pixels",
                r#"attached.cache={ capacity = "0 B", word = "8 B", banks = 1, ports = "1rw" }"#,
            ],
            &["pairs.test=obb", "rops.impl=boxes", "rops.found-per-cycle=1"],
            &[
                "pairs.test=obb",
                "rops.impl=boxes",
                "rops.stop=true",
                "rops.merge=true",
                "rops.groups=3",
                "rops.group-side=2",
                "rops.group-gaussians=4",
                "rops.bins=3",
                "rops.quads-per-cycle=1",
                "blend.tile=8",
                "blend.warp-width=8",
                "l2.capacity=2 KiB",
            ],
            &["pixels.impl=warped", "pixels.holes=0.05", "l2.capacity=8 KiB"],
            &["pixels.impl=warped", "pixels.holes=0.5", "pixels.period=2", "pixels.depth=2 B"],
            &["pixels.impl=sampled", "pixels.stride=3", "pixels.period=2"],
            &["pixels.impl=sampled", "pixels.pattern=unseen", "training.sum=block"],
            &["dram.device=lpddr4-3200-x16x8", "dram.model=banked"],
            &["dram.device=lpddr4-3200-x16x8", "dram.model=calibrated"],
            // Where nothing but the slowest warp of a block counts.
            &alone,
            // As few warps as issue slots: what a multiprocessor holds counts.
            &["sm.interval=200", "sm.warps=16", "sm.units=1"],
            &["sm.interval=200", "sm.blocks=2", "sm.units=1"],
            &["sm.interval=200", "sm.shared=14 KiB", "sm.units=1"],
            &["sm.interval=200", "sm.registers=32768", "convert.registers=128"],
        ],
        frames: &frames,
        settled: &["dram.device=lpddr4-3200-x16x8"],
        slack: 0.05,
        idle_keys: &["attached.cache.word", "attached.cache.banks", "attached.cache.ports"],
    };
    assert_eq!(broken(&trial), Vec::<String>::new());
}

#[test]
fn what_cannot_be_is_refused_with_the_way_out() {
    let file = MACHINES.iter().find(|file| file.name == "xavier-nx").expect("a machine").complete();
    let refused = |set: &str, said: &str| {
        let error = Machine::parse_with(&file, &[set.to_owned()]).expect_err(set).to_string();
        assert!(error.contains(said), "{set}: {error}");
    };
    let said =
        "`dram.bandwidth` = 100 GB/s is not that of its bus: 128 bits at 3.2 Gbit/s are 51.2";
    refused("dram.bandwidth=100 GB/s", said);
    refused("l2.sector=0 B", "`l2.sector` must be above 0 B");
    refused("sm.float=nan", "sm.float");
    refused("blend.tile=12", "must be a power of two");
    refused("blend.warp-width=32", "32x1 pixels");
    refused("sm.registers=8192", "no block of 256 threads fits into a multiprocessor");
    refused("rops.impl=boxes", "oriented boxes are drawn; set `pairs.test` = \"obb\"");
    refused("blend.batch=4096", "114688 B of 96 KiB shared memory");
}

/// What a unit beside a GPU does in a tile, pixel by pixel.
#[test]
fn a_unit_beside_it_takes_what_its_pixels_take() {
    let frame = dense_frame(1);
    let made = |sets: &[&str]| {
        let machine = machine(sets);
        let work = workload(&frame, machine.gpu());
        let kernels = Kernels::new(&machine, &work, None, &Memo::default());
        (kernels.attached.expect("a unit"), kernels.all, work)
    };
    let ([rows, pixels, boxes, tiles], cases) = (
        ["rows", "pixels", "box", "tile"].map(|way| {
            let way = format!("attached.impl={way}");
            made(&[&way, "attached.lanes=4", "attached.clock=900 MHz", "clock=1.8 GHz"])
        }),
        ["rows", "pixels", "box", "tile"],
    );
    let w = &rows.2;
    let all = w.pixels.as_ref().expect("asked for");
    let mut cycles = [vec![], vec![], vec![], vec![]];
    let (mut live, mut reached, mut square) = (0_u64, 0_u64, 0_u64);
    for (tile, work) in w.tiles.iter().enumerate() {
        let (x0, y0, x1, y1) = w.pixels_of(tile);
        let stop = |x: u32, y: u32| all.iterated[(y * w.width + x) as usize];
        let places = || (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y)));
        let last = places().map(|(x, y)| stop(x, y)).max().expect("pixels");
        let (mut by_row, mut packed, mut boxed) = ([0_u64; 4], 0, 0);
        for (at, &rank) in w.list_of(work).iter().enumerate().take(last as usize) {
            let splat = &all.splats[rank as usize];
            let [mut here, mut inside] = [0_u64; 2];
            for y in y0..y1 {
                let near = |n: u32, mean: f32| {
                    (f64::from(n) - f64::from(mean)).abs() <= f64::from(splat.radius())
                };
                let touched = (x0..x1).filter(|&x| near(x, splat.mean[0])).count() as u64;
                inside += touched * u64::from(near(y, splat.mean[1]));
                here += (x0..x1)
                    .filter(|&x| stop(x, y) > at as u32)
                    .filter(|&x| crate::pixels::alpha(splat, x, y) > 0.0)
                    .count() as u64;
            }
            // A generator looks at a row of the ellipse a cycle, while a unit takes its pixels.
            for (y, span) in spans(splat, (x0, y0, x1, y1)) {
                let pixels = span.map_or(0, |[first, end]| u64::from(end - first));
                by_row[((y - y0) % 4) as usize] += pixels.max(1);
                reached += pixels;
            }
            live += here;
            square += inside;
            packed += here;
            boxed += inside.div_ceil(4).max(1);
        }
        let finish = u64::from(work.pixels).div_ceil(4);
        let entries = u64::from(work.entries) * u64::from(work.pixels).div_ceil(4);
        cycles[0].push(by_row.into_iter().max().unwrap_or(0) + finish);
        cycles[1].push(packed.div_ceil(4).max(last.into()) + finish);
        cycles[2].push(boxed + finish);
        cycles[3].push(entries + finish);
    }
    // What rounds on the edge of an ellipse may be met here and not there.
    let near = |a: u64, b: u64| a.abs_diff(b) * 100 <= b + 100;
    for ((made, own), name) in [&rows, &pixels, &boxes, &tiles].into_iter().zip(&cycles).zip(cases)
    {
        let (work, kernels, _) = made;
        assert!(kernels.iter().all(|kernel| kernel.part != KernelPart::Blend), "{name}");
        let sum: u64 = work.blocks.iter().map(|block| block.items).sum();
        // Its clock is half of the GPU's.
        assert!(near(sum, 2 * own.iter().sum::<u64>()), "{name}: {sum} {own:?}");
    }
    assert!(near(rows.0.reach[0], reached), "{:?} {reached}", rows.0.reach);
    assert!(near(pixels.0.reach[1], live) && pixels.0.reach[0] == pixels.0.reach[1]);
    // What never stops reads every list to its end.
    let [read, _] = BlockStream::bytes(&tiles.0.blocks);
    assert!(read >= w.list.len() as u64 * 4 && read > BlockStream::bytes(&boxes.0.blocks)[0]);
    assert!(near(boxes.0.reach[0], square), "{:?} {square}", boxes.0.reach);
}

/// With frames that overlap a frame is as long as the longer of kernels and unit.
#[test]
fn kernels_and_unit_share_a_frame() {
    let frame = dense_frame(1);
    let frame_of = |sets: &[&str]| {
        let machine = machine(sets);
        let flow = machine.flow();
        let work = flow.work_key(&machine).prepare(&frame);
        let memo = Memo::default();
        flow.run(&FrameTask::first(&machine, &*work, &memo), None).expect("it runs")
    };
    let slow = ["attached.impl=pixels", "attached.lanes=1", "attached.clock=50 MHz"];
    let beside = frame_of(&slow);
    let behind = frame_of(&[&slow[..], &["attached.overlap=none"]].concat());
    let blend = behind.measured.count(KernelPart::Blend.time()).expect("kernels");
    let rest = behind.timing.frame - blend;
    assert!(blend > 2 * rest, "{blend} {rest}");
    let near = |a: u64, b: u64| a.abs_diff(b) * 20 <= b;
    assert!(near(beside.timing.frame, blend), "{} {blend}", beside.timing.frame);
    let blends = |outcome: &FlowOutcome| outcome.actions.total(work_id("attached-blend"));
    assert!(blends(&beside) > 1000 && blends(&beside) == blends(&behind));
    assert_eq!(beside.served, behind.served);
}

/// What raster operations draw, from every pixel of the picture for every Gaussian.
#[test]
fn boxes_are_drawn_as_pixel_by_pixel() {
    let frame = dense_frame(1);
    let drawn = |sets: &[&str]| {
        let sets = [&["pairs.test=obb", "rops.impl=boxes", "l2.capacity=9 KiB"], sets].concat();
        let machine = machine(&sets);
        let work = workload(&frame, machine.gpu());
        let kernels = Kernels::new(&machine, &work, None, &Memo::default());
        (*kernels.drawn.expect("raster operations"), machine.gpu().clone(), work)
    };
    let all: [&[&str]; 5] = [
        &[],
        &["rops.bins=4", "rops.bin-quads=20", "blend.pixel=8 B"],
        &["rops.stop=true", "rops.merge=true", "rops.bins=7"],
        &["rops.merge=true", "rops.groups=2", "rops.group-side=3", "rops.group-gaussians=5"],
        &["rops.stop=true", "rops.merge=true", "rops.groups=9", "rops.bin-quads=31"],
    ];
    let mut before = None;
    for sets in all {
        let (drawn, gpu, work) = drawn(sets);
        let own = draw(&work, &gpu);
        let both = [
            [own.found, drawn.found],
            [own.shaded, drawn.shaded],
            [own.live, drawn.live],
            [own.warps, drawn.warps],
            [own.pair_warps, drawn.pair_warps],
            [own.blended, drawn.blended],
            [own.places, drawn.places],
            [own.missed, drawn.missed],
            [own.flushes, drawn.flushes],
        ];
        // What rounds on the edge of a box or an ellipse may be met here and not there.
        let near = both.iter().all(|[a, b]| a.abs_diff(*b) * 200 <= *b);
        assert!(near && drawn.shaded > 10_000, "{sets:?}: {both:?}");
        let first = *before.get_or_insert(drawn);
        assert!(drawn.found == first.found && drawn.shaded <= first.shaded, "{drawn:?}");
    }
}

/// A bin or a group that waits: its key, and what is in it.
type Waits<T> = Vec<(usize, Vec<T>)>;

/// A quad: its tile, its place in it, whether it blends.
type Quad = (usize, u32, bool);

/// The same by loops over pixels and queues.
fn draw(work: &FrameWorkload, gpu: &Gpu) -> Drawn {
    let (r, side) = (&gpu.rops, gpu.blend.tile);
    let pixels = work.pixels.as_ref().expect("asked for");
    let mut drawn = Drawn::default();
    let (mut groups, mut bins): (Waits<Vec<Quad>>, Waits<Quad>) = Default::default();
    let (mut picture, most) =
        (Vec::<usize>::new(), gpu.l2.capacity.0 / (u64::from(side * side) * gpu.blend.pixel.0));
    let mut flush = |drawn: &mut Drawn, (tile, quads): (usize, Vec<Quad>)| {
        drawn.flushes += 1;
        drawn.shaded += quads.len() as u64;
        drawn.warps += (quads.len() as u64).div_ceil(8);
        let mut merged = 0;
        let mut places = 0;
        for place in 0..64 {
            let own: Vec<bool> = quads.iter().filter(|q| q.1 == place).map(|q| q.2).collect();
            let at_once = if r.merge { 2 } else { 1 };
            let blended = own.chunks(at_once).filter(|all| all.contains(&true)).count() as u64;
            merged += own.chunks(at_once).filter(|all| all.len() == 2).count() as u64;
            places += u64::from(own.contains(&true));
            drawn.blended += blended;
        }
        drawn.pair_warps += (2 * merged).div_ceil(8);
        drawn.places += places;
        if places > 0 && !picture.contains(&tile) {
            drawn.missed += places;
            picture.push(tile);
            if picture.len() as u64 > most {
                picture.remove(0);
            }
        }
    };
    let mut shade = |drawn: &mut Drawn, bins: &mut Waits<Quad>, quad: Quad| {
        if !bins.iter().any(|bin| bin.0 == quad.0) {
            if bins.len() == r.bins as usize {
                flush(drawn, bins.remove(0));
            }
            bins.push((quad.0, Vec::new()));
        }
        let at = bins.iter().position(|bin| bin.0 == quad.0).expect("there");
        bins[at].1.push(quad);
        if bins[at].1.len() == r.bin_quads as usize {
            flush(drawn, bins.remove(at));
        }
    };
    for rank in 0..work.index.len() as u32 {
        let splat = &pixels.splats[rank as usize];
        let [a, b, d] = splat.cov.map(f64::from);
        let angle = 0.5 * (2.0 * b).atan2(a - d);
        let root = (0.25 * (a - d).powi(2) + b * b).sqrt();
        let half = [1.0, -1.0].map(|sign| 3.0 * (0.5 * (a + d) + sign * root).max(0.0).sqrt());
        let mut own: Waits<Quad> = Vec::new();
        for (tile, of_tile) in work.tiles.iter().enumerate() {
            let list = work.list_of(of_tile);
            let Some(at) = list.iter().position(|r| *r == rank) else { continue };
            let (x0, y0, x1, y1) = work.pixels_of(tile);
            let [column, row] =
                [tile as u32 % work.tiles_x, tile as u32 / work.tiles_x].map(|n| n / r.group_side);
            let group = (row * 1000 + column) as usize;
            if !own.iter().any(|own| own.0 == group) {
                own.push((group, Vec::new()));
            }
            let own = own.iter_mut().find(|own| own.0 == group).expect("there");
            for place in 0..(side / 2).pow(2) {
                let [left, top] = [place % (side / 2), place / (side / 2)].map(|n| 2 * n);
                let (mut covers, mut shades, mut blends) = (false, false, false);
                for (x, y) in
                    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| (x0 + left + x, y0 + top + y))
                {
                    let [dx, dy] = [
                        f64::from(x) - f64::from(splat.mean[0]),
                        f64::from(y) - f64::from(splat.mean[1]),
                    ];
                    let along = dx * angle.cos() + dy * angle.sin();
                    let across = dy * angle.cos() - dx * angle.sin();
                    if x >= x1 || y >= y1 || along.abs() > half[0] || across.abs() > half[1] {
                        continue;
                    }
                    covers = true;
                    let live = pixels.iterated[(y * work.width + x) as usize] > at as u32;
                    drawn.live += u64::from(live);
                    if live || !r.stop {
                        shades = true;
                        blends |= crate::pixels::alpha(splat, x, y) > 0.0;
                    }
                }
                drawn.found += u64::from(covers);
                if shades {
                    own.1.push((tile, place, blends));
                }
            }
        }
        if r.groups == 0 {
            let mut quads: Vec<Quad> = own.into_iter().flat_map(|own| own.1).collect();
            quads.sort_by_key(|quad| (quad.0, quad.1));
            quads.into_iter().for_each(|quad| shade(&mut drawn, &mut bins, quad));
            continue;
        }
        for (group, quads) in own {
            if !groups.iter().any(|waits| waits.0 == group) {
                if groups.len() == r.groups as usize {
                    let gone = groups.remove(0).1;
                    gone.into_iter().flatten().for_each(|q| shade(&mut drawn, &mut bins, q));
                }
                groups.push((group, Vec::new()));
            }
            let at = groups.iter().position(|waits| waits.0 == group).expect("there");
            groups[at].1.push(quads);
            if groups[at].1.len() == r.group_gaussians as usize {
                let gone = groups.remove(at).1;
                gone.into_iter().flatten().for_each(|q| shade(&mut drawn, &mut bins, q));
            }
        }
    }
    for (_, gone) in groups {
        gone.into_iter().flatten().for_each(|q| shade(&mut drawn, &mut bins, q));
    }
    bins.into_iter().for_each(|bin| flush(&mut drawn, bin));
    drawn
}
