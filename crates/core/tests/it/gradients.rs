//! Steps of training on tile-wise machines (A146), against loops that know only pixels.

use std::collections::{BTreeSet, VecDeque};

use powergs_base::quantity::{Bytes, Nanoseconds};
use powergs_core::flow::steps::Updated;
use powergs_core::flow::steps::{StepCycles, StepPart};
use powergs_core::flow::tile_wise::gradients::GradientsSpec;
use powergs_core::flow::tile_wise::gradients::{ADDITIONS, FOUND_SUMS};
use powergs_core::flow::tile_wise::{FoveaSpec, Overlap, PixelSource, ResolvedUnits, VruImpl};
use powergs_core::flow::{FlowOutcome, FrameTask, History};
use powergs_core::kernel::Memo;
use powergs_core::machine::{DramModel, Machine};
use powergs_core::stage::{stage_id, work_id};
use powergs_core::workload::{FrameWorkload, bin_for};
use powergs_energy::action::{ActionId, Phase};
use powergs_frame::trace::{Frame, NEVER};

use crate::pipeline::support::{gscore, set_rate};
use crate::workload::support::{dense_frame, small_frame};

fn machine(change: impl Fn(&mut Machine)) -> Machine {
    let mut machine = gscore();
    let m = machine.tiles_mut();
    m.fovea = FoveaSpec::default();
    m.training.interval = 1;
    // Banks that hold nobody up.
    m.gradients.cache.banks = 1 << 12;
    // A memory that takes no time to speak of: what is left is arithmetic.
    machine.dram.model = DramModel::Bandwidth;
    set_rate(&mut machine, 1e14);
    (machine.dram.latency, machine.dram.channels) = (Nanoseconds(0.0), 1);
    change(&mut machine);
    machine
}

fn run(machine: &Machine, frame: &Frame) -> (FlowOutcome, FrameWorkload) {
    let tiles = machine.tiles();
    let workload = bin_for(frame, tiles.geometry, tiles.detail());
    let (memo, flow) = (Memo::default(), machine.flow());
    let mut history = History::default();
    let before = flow.hand_over(machine, &workload, None, &mut history);
    let task = FrameTask { before: before.as_ref(), ..FrameTask::first(machine, &workload, &memo) };
    (flow.run(&task, None).expect("it runs"), workload)
}

/// Slots of the splats that a pixel of a tile blends, from the back, and how many blends there are.
fn met(w: &FrameWorkload, tile: usize) -> (Vec<u32>, u64) {
    let pixels = w.pixels.as_ref().expect("asked for");
    let (x0, y0, x1, y1) = w.pixels_of(tile);
    let list = w.list_of(&w.tiles[tile]);
    let (mut met, mut blends) = (Vec::new(), 0);
    for (at, &rank) in list.iter().enumerate().rev() {
        let at = at as u32;
        let splat = &pixels.splats[rank as usize];
        let mut here = 0;
        for y in y0..y1 {
            for x in x0..x1 {
                let stop = pixels.iterated[(y * w.width + x) as usize];
                here += u64::from(stop > at && crate::pixels::alpha(splat, x, y) > 0.0);
            }
        }
        blends += here;
        if here > 0 {
            met.push(w.slot[rank as usize]);
        }
    }
    (met, blends)
}

/// How often a cache of so many sums in one set fetches one, lets one go, and what it has at the
/// end.
fn queue(order: &[u32], most: usize) -> [u64; 3] {
    let (mut there, mut fetched, mut left) = (VecDeque::new(), 0, 0);
    for &slot in order {
        match there.iter().position(|&own| own == slot) {
            Some(place) => {
                there.remove(place);
            }
            None => {
                fetched += 1;
                if there.len() == most {
                    left += 1;
                    there.pop_front();
                }
            }
        }
        if most > 0 {
            there.push_back(slot);
        }
    }
    [fetched, left, there.len() as u64]
}

const GRADIENT: ActionId = work_id("gradient-pixel");
const SUM: ActionId = work_id("gradient-sum");
const ALPHA: ActionId = work_id("alpha");

#[test]
fn gradients_are_those_of_blends_and_sums_go_through_a_queue() {
    let frame = dense_frame(1);
    for (ways, behind) in [(8_u32, false), (64, true), (7, true)] {
        let trained = machine(|m| {
            let m = m.tiles_mut();
            m.gradients.behind = behind;
            m.gradients.ways = ways;
            // One set.
            m.gradients.cache.capacity = Bytes(36 * u64::from(ways));
            m.gradients.buffer.capacity = Bytes(4 << 20);
        });
        let plain = machine(|m| m.tiles_mut().training.interval = 0);
        let [(step, w), (frame_alone, _)] = [run(&trained, &frame), run(&plain, &frame)];
        let all: Vec<(Vec<u32>, u64)> = (0..w.tiles.len()).map(|tile| met(&w, tile)).collect();
        let blends: u64 = all.iter().map(|(_, blends)| blends).sum();
        let order: Vec<u32> = all.iter().flat_map(|(met, _)| met.clone()).collect();
        let touched = order.iter().collect::<BTreeSet<_>>().len() as u64;
        assert!(blends > 1000 && order.len() as u64 > 2 * touched);
        // What rounds on the edge of an ellipse may be met here and not there.
        let near = |a: u64, b: u64| a.abs_diff(b) <= 1 + b / 500;
        // What stops a pixel is counted with its blends, and leaves nothing.
        let stopped = frame.pixels.stop_rank.iter().filter(|stop| **stop != NEVER).count() as u64;
        assert!(stopped > 0 && near(step.actions.total(GRADIENT), blends - stopped));
        assert!(near(step.actions.total(SUM), order.len() as u64));
        let [fetched, left, held] = queue(&order, ways as usize);
        let more = |stage: usize| {
            let [a, b] = [&step, &frame_alone].map(|outcome| outcome.served.stages[stage]);
            [a.read - b.read, a.write - b.write]
        };
        let (pixels, points) = (150 * 90, frame.facts.points);
        let c = &w.counters;
        let record = ResolvedUnits::for_frame(&trained, &w).ccu.record;
        let stored = record.position.0 + record.geometry.0 + record.colour.0;
        let numbers = 11 + 3 * (u64::from(frame.facts.colour_degree().get()) + 1).pow(2);
        let visible = w.slot.iter().filter(|slot| **slot != u32::MAX).count() as u64;
        assert!(visible > touched, "some have a tile and no gradient");
        let [read, write] = more(2);
        let lists: u64 = w.tiles.iter().map(|tile| u64::from(tile.loaded)).sum();
        let (entry, feature) = (trained.tiles().list_entry(), trained.tiles().record.feature.0);
        let (own, out) = match behind {
            true => (3 * pixels, 0),
            false => (lists * (entry + feature) + 28 * pixels + 2 * 3 * pixels, 28 * pixels),
        };
        assert!(near(read, own + 36 * fetched), "{read} {own} {fetched}");
        assert!(near(write, out + 36 * left), "{write} {out} {left}");
        let [read, write] = more(0);
        // Values, gradients and two moments of 4 B; records in half precision are copies.
        assert_ne!(stored, 4 * numbers);
        assert!(near(read, 36 * touched + visible * stored + 16 * numbers * points));
        let out = visible * 4 * numbers + (12 * numbers + stored) * points;
        assert!(near(write, 36 * held + out));
        let sums = sums_of(&step);
        let met = order.len() as u64;
        assert!(near(sums[0], met) && near(sums[1], met - fetched));
        assert_eq!(more(1), [0, 0]);
        let again = step.actions.total(ALPHA) - frame_alone.actions.total(ALPHA);
        assert_eq!(again, if behind { 0 } else { c.alpha_evaluations });
        assert_eq!(step.executed_evaluations, frame_alone.executed_evaluations);
        let after = cycles_of(&step);
        assert_eq!(after.of(StepPart::Loss) == 0, behind);
        assert!(after.of(StepPart::Update) > 0 && after.of(StepPart::Chain) > 0);
    }
}

/// With lanes alone to wait for, the reverse pass takes what its pairs take, core by core.
#[test]
fn a_pass_takes_what_its_pairs_take() {
    let frame = dense_frame(1);
    let trained = machine(|m| {
        let m = m.tiles_mut();
        (m.gradients.lanes, m.training.interval) = (4, 3);
    });
    let (step, w) = run(&trained, &frame);
    let cores = trained.tiles().vru.cores as usize;
    let mut busy = vec![0_u64; cores];
    for (i, tile) in w.tiles.iter().enumerate() {
        busy[i % cores] += (3 * tile.alpha_evaluations).div_ceil(4).max(1);
    }
    let most = busy.into_iter().max().expect("a core");
    let reverse = cycles_of(&step).of(StepPart::Reverse);
    assert!((most..most + 200).contains(&reverse), "{reverse} {most}");
    // The whole step is the frame and its parts.
    let plain = machine(|m| m.tiles_mut().training.interval = 0);
    let (alone, _) = run(&plain, &frame);
    assert_eq!(step.timing.frame, alone.timing.frame + cycles_of(&step).all());
}

/// Behind its rendering units, a slow gradient unit holds them, and a fast one costs nothing.
#[test]
fn tiles_wait_for_gradients_of_tiles_before() {
    let frame = dense_frame(1);
    let cores = 4;
    let run_with = |lanes: u32, interval: u32| {
        let trained = machine(|m| {
            let m = m.tiles_mut();
            m.vru.cores = cores;
            m.training.update = Updated::Pose;
            (m.gradients.behind, m.gradients.lanes, m.training.interval) = (true, lanes, interval);
            m.training.loss = 0;
            m.gradients.buffer.capacity = Bytes(4 << 20);
        });
        run(&trained, &frame)
    };
    let (fast, w) = run_with(4096, 1);
    let (slow, _) = run_with(1, 16);
    let blends: u64 = w.tiles.iter().map(|tile| tile.blends).sum();
    // Four cores find 16 blends' gradients in 64 cycles at most.
    assert!(slow.timing.frame >= 16 * blends / u64::from(cores));
    let plain = machine(|m| {
        let m = m.tiles_mut();
        (m.vru.cores, m.training.interval) = (cores, 0);
    });
    let (alone, _) = run(&plain, &frame);
    let after = cycles_of(&fast);
    let behind = fast.timing.frame - after.all();
    assert!(behind.abs_diff(alone.timing.frame) * 50 <= alone.timing.frame, "{behind}");
    // Of the pose there is no update, and nothing is written but sums.
    assert_eq!(after.of(StepPart::Update), 0);
    let vru = |outcome: &FlowOutcome| {
        let unit = outcome.timing.units.iter().find(|unit| unit.unit == stage_id("vru"));
        unit.expect("it renders").stalls.iter().sum::<u64>()
    };
    assert!(vru(&slow) > 10 * vru(&fast));
}

/// Lists of sampled pixels have what reaches them, and each is tested at the pixels in its square.
#[test]
fn a_filter_keeps_what_reaches_a_sampled_pixel() {
    let frame = small_frame(1);
    for stride in [8, 16] {
        let with = |filter: bool| {
            machine(|m| {
                let m = m.tiles_mut();
                m.training.interval = 0;
                m.geometry.test = powergs_frame::splat::Intersection::Aabb;
                (m.geometry.subtile, m.vru.implementation) = (16, VruImpl::Pixels);
                m.vru.termination = powergs_core::flow::tile_wise::Termination::Pixel;
                (m.pixels.source, m.pixels.stride) = (PixelSource::Sampled, stride);
                (m.pixels.period, m.pixels.filter) = (0, filter);
                m.schedule.overlap = Overlap::None;
            })
        };
        let [(all, w), (kept, _)] = [false, true].map(|filter| run(&with(filter), &frame));
        let id = |name: &'static str| work_id(name);
        // The same pixels blend the same.
        for name in ["blend", "pixel-finish"] {
            assert_eq!(kept.actions.total(id(name)), all.actions.total(id(name)), "{name}");
        }
        assert_eq!(all.actions.total(id("pixel-test")), 0);
        assert_eq!(kept.actions.total(id("obb-test")), 0);
        // Of the (Gaussian, tile) pairs with all their pixels, a test for each sampled one.
        let tests = kept.actions.total(id("pixel-test"));
        let per_tile = u64::from(16 / stride).pow(2);
        assert!(tests > 0 && tests <= w.counters.tile_pairs * per_tile);
        let written =
            |outcome: &FlowOutcome| outcome.served.stages[Phase::Preprocessing as usize].write;
        assert!(written(&kept) < written(&all));
    }
}

/// Densification keeps two numbers of what is visible, and moves all arrays once in so many.
#[test]
fn densification_moves_its_arrays() {
    let frame = dense_frame(1);
    let with = |densify: u32| {
        let (outcome, w) = run(&machine(|m| m.tiles_mut().training.densify = densify), &frame);
        (outcome.served.stages[0], cycles_of(&outcome), w)
    };
    let (none, before, w) = with(0);
    let numbers = 11 + 3 * (u64::from(frame.facts.colour_degree().get()) + 1).pow(2);
    for every in [1, 100] {
        let (some, after, _) = with(every);
        let moved = (12 * numbers * frame.facts.points).div_ceil(u64::from(every));
        let visible = w.slot.iter().filter(|slot| **slot != u32::MAX).count() as u64;
        let own = 8 * visible + moved;
        let more = [some.read - none.read, some.write - none.write];
        assert!(more.iter().all(|bytes| bytes.abs_diff(own) * 500 <= own), "{more:?} {own}");
        assert!(after.of(StepPart::Update) > before.of(StepPart::Update));
        assert_eq!(after.of(StepPart::Chain), before.of(StepPart::Chain));
    }
}

/// Sums that are not there, banks that cores share, and no cache at all: each is waited for.
#[test]
fn a_cache_of_sums_that_misses_takes_time() {
    let frame = dense_frame(1);
    let reverse = |latency: f64, change: &dyn Fn(&mut GradientsSpec)| {
        let trained = machine(|m| {
            m.dram.latency = Nanoseconds(latency);
            let m = m.tiles_mut();
            // Lanes that take no time to speak of.
            m.gradients.lanes = 4096;
            change(&mut m.gradients);
        });
        let (outcome, w) = run(&trained, &frame);
        (cycles_of(&outcome).of(StepPart::Reverse), outcome, w)
    };
    let small = |g: &mut GradientsSpec| g.cache.capacity = Bytes(36 * 8);
    let one = |g: &mut GradientsSpec| (g.cache.capacity, g.misses) = (Bytes(36 * 8), 1);
    let (free, ..) = reverse(0.0, &small);
    let (many, ..) = reverse(200.0, &small);
    let (few, outcome, _) = reverse(200.0, &one);
    let [additions, found] = sums_of(&outcome);
    let fetched = additions - found;
    // Four cores, one sum on its way each, 200 cycles of 1 GHz.
    assert!(few >= fetched * 200 / 4, "{few} {fetched}");
    assert!(free < many && many < few);
    let (narrow, outcome, _) = reverse(0.0, &|g: &mut GradientsSpec| {
        small(g);
        g.cache.banks = 1;
    });
    // 36 B in words of 16 B, read and written, of four cores through one bank.
    assert!(narrow >= sums_of(&outcome)[0] * 3 * 2, "{narrow}");
    let (_, outcome, w) = reverse(0.0, &|g: &mut GradientsSpec| g.cache.capacity = Bytes(0));
    assert!(outcome.measured.count(&ADDITIONS).is_none());
    let bytes = outcome.served.stages[2];
    let met: u64 = (0..w.tiles.len()).map(|tile| self::met(&w, tile).0.len() as u64).sum();
    assert!(bytes.read > 36 * met * 9 / 10 && bytes.write > 36 * met * 9 / 10, "{bytes:?} {met}");
}

/// Cycles of the parts of a step.
fn cycles_of(outcome: &FlowOutcome) -> StepCycles {
    StepCycles::find(&outcome.measured).expect("it trains")
}

/// Additions to sums, and those of them whose sum was there.
fn sums_of(outcome: &FlowOutcome) -> [u64; 2] {
    [&ADDITIONS, &FOUND_SUMS].map(|stat| outcome.measured.count(stat).expect("a cache"))
}
