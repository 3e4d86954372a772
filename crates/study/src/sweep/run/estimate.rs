//! What a sweep will take, timed on a frame of every trace.

use std::collections::HashSet;
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::folder::Shard;
use super::opened::{Designs, OpenedSweep};
use super::plan::{Plan, PlannedDesign};
use super::running::Running;
use super::watch::SweepWatch;
use crate::sweep::design::Design;
use powergs_core::flow::WorkKey;
use powergs_core::kernel::Halt;
use powergs_core::run::{RunError, Window};

/// Points that are planned; of a larger space this many are a sample.
const LOOKED_AT: u64 = 20_000;

/// Machines that are timed on a frame of every trace, at least.
const TIMED: usize = 12;
/// After this, no further machine is timed on a trace.
const PATIENCE: Duration = Duration::from_secs(2);
/// Machines that are compared for what they share.
const COMPARED: usize = 2048;

/// What a sweep would take.
#[derive(Debug)]
pub struct Estimate {
    /// The plan of the sampled points.
    pub plan: Plan,
    /// Points that the sweep takes, at most.
    pub points: u64,
    /// Points of the space for each sampled one.
    pub scale: f64,
    /// Machines to time.
    pub machines: f64,
    /// Time of the sweep, seconds, at least: as if no thread ever waited.
    pub seconds: f64,
    /// Threads that share the work.
    pub threads: f64,
    /// What was timed.
    pub cost: EstimatedCost,
}

impl Estimate {
    /// Looks at some points and times some machines; `memory` is that for binned frames, bytes.
    /// `None` after a cancellation.
    ///
    /// # Errors
    /// [`RunError::Input`]: a trace that cannot be read.
    pub fn of(
        sweep: &mut OpenedSweep<'_>,
        memory: usize,
        watch: &dyn SweepWatch,
    ) -> Result<Option<Estimate>, RunError> {
        let points = points(&sweep.designs);
        let Some(plan) = sampled(&sweep.designs, points, watch) else { return Ok(None) };
        let looked_at = (plan.designs.len() - 1) as u64
            + plan.excluded.values().chain(plan.duplicates.values()).sum::<u64>()
            + plan.invalid.len() as u64;
        let scale = points as f64 / looked_at.max(1) as f64;
        let machines = plan.machines(Shard::WHOLE).len() as f64 * scale;
        let cost = cost(sweep, &plan, scale, memory)?;
        let threads = rayon::current_num_threads() as f64;
        let mut estimate = Estimate { plan, points, scale, machines, seconds: 0.0, threads, cost };
        let bins = estimate.cost.bin_s * estimate.plan.works.len() as f64;
        estimate.seconds = bins + estimate.timed_s() / threads;
        Ok(Some(estimate))
    }

    /// Seconds of all machines on all frames, on one thread.
    pub fn timed_s(&self) -> f64 {
        let cost = &self.cost;
        let shared = cost.preprocessing_s * cost.preprocessings + cost.once_s;
        cost.machine_s * self.machines + cost.apart_s * cost.apart + shared
    }
}

/// How many points a sweep takes, at most.
fn points(designs: &Designs) -> u64 {
    if !designs.is_adaptive() {
        return designs.space.selected().size_hint().1.unwrap_or(usize::MAX) as u64;
    }
    let s = designs.space.sampling();
    s.searched().min(s.points.unwrap_or(u64::MAX)).min(designs.space.lattice().points())
}

/// The plan of some points: evenly over the selection, or over the space where points are asked
/// for later. `None` after a cancellation.
fn sampled(designs: &Designs, points: u64, watch: &dyn SweepWatch) -> Option<Plan> {
    let all = u128::from(designs.space.lattice().points());
    let spread = points.min(LOOKED_AT);
    watch.planning(spread);
    let step = (points / spread.max(1)).max(1) as usize;
    let evenly = move |i: u64| (u128::from(i) * all / u128::from(spread)) as u64;
    let sample: Box<dyn Iterator<Item = u64>> = match designs.is_adaptive() {
        true => Box::new((0..spread).map(evenly)),
        false => Box::new(designs.space.selected().step_by(step).take(spread as usize)),
    };
    Plan::of(designs, sample, watch)
}

/// What was timed.
#[derive(Debug, Default)]
pub struct EstimatedCost {
    /// Frames of all traces.
    pub frames: usize,
    /// Seconds to prepare all frames once.
    pub bin_s: f64,
    /// Seconds of one machine on all frames whose preprocessing is there already.
    pub machine_s: f64,
    /// Seconds to preprocess all frames once.
    pub preprocessing_s: f64,
    /// How often frames are preprocessed: machines share it.
    pub preprocessings: f64,
    /// Seconds more of one machine that shares no preprocessing, on all frames.
    pub apart_s: f64,
    /// Machines that share none.
    pub apart: f64,
    /// Seconds of what is done once for all of those, on all frames: the run of `banked` from which
    /// `calibrated` has its rates.
    pub once_s: f64,
    /// Bytes of binned frames in memory at a time, with the plan.
    pub bytes: usize,
}

/// Prepares the middle frame of every trace as some designs of the plan need it, and times some
/// machines of each on it: one after the other, with and without what machines share, then on all
/// threads at once, which is slower. `scale` is how many designs each of the plan stands for. The
/// finest tiles tell how much memory binned frames take.
///
/// # Errors
/// [`RunError::Input`]: a trace that cannot be read.
fn cost(
    sweep: &mut OpenedSweep<'_>,
    plan: &Plan,
    scale: f64,
    memory: usize,
) -> Result<EstimatedCost, RunError> {
    let SharedWork { preprocessings, apart } = shared_work(&sweep.designs, plan, scale);
    let mut cost = EstimatedCost { preprocessings, apart, ..EstimatedCost::default() };
    let display_fps = sweep.file.display_fps;
    // Keys are sorted: the first one has the smallest tiles.
    let finest = plan.works.first();
    let sample = sample(&sweep.designs, plan);
    for trace in &mut sweep.traces {
        let range = trace.frames.range();
        let frames = range.len() as f64;
        let middle = range.start + range.len() / 2;
        let (mut bins, mut times) = (Vec::new(), Times::default());
        let began = Instant::now();
        for designs in sample.chunk_by(|a, b| work_key(a) == work_key(b)) {
            if !bins.is_empty() && began.elapsed() > PATIENCE {
                break;
            }
            let started = Instant::now();
            let window = Window::bin(&mut *trace.frames, &work_key(&designs[0]), middle, 1)?;
            bins.push(started.elapsed().as_secs_f64());
            times.of(designs, &window, display_fps, began);
        }
        cost.bin_s += frames * bins.iter().sum::<f64>() / bins.len().max(1) as f64;
        cost.machine_s += frames * times.warm_s / times.designs.max(1) as f64;
        cost.preprocessing_s += frames * times.preprocessing_s / times.preprocessings.max(1) as f64;
        let usual = times.usual_apart_s();
        cost.apart_s += frames * usual;
        cost.once_s += frames * times.apart_s.iter().map(|s| (s - usual).max(0.0)).sum::<f64>();
        if let Some(finest) = finest {
            let window = Window::bin(&mut *trace.frames, finest, middle, 1)?;
            let bytes = window.frames[0].bytes();
            cost.bytes = cost.bytes.max((bytes * range.len()).min(memory.max(bytes) + bytes));
        }
        cost.frames += range.len();
    }
    cost.bytes += plan.designs.len() * size_of::<PlannedDesign>();
    Ok(cost)
}

/// What a design needs of a frame.
fn work_key(design: &Design) -> WorkKey {
    design.machine.flow().work_key(&design.machine)
}

/// What it shares of its runs with others.
fn shares(design: &Design) -> Option<String> {
    design.machine.flow().shared(&design.machine)
}

/// Some designs of a plan, evenly over its machines, which are in the order of what they need of a
/// frame.
fn sample(designs: &Designs, plan: &Plan) -> Vec<Design> {
    let machines = plan.machines(Shard::WHOLE);
    let most = TIMED.max(rayon::current_num_threads()).min(machines.len());
    let pick = |i: usize| plan.designs[machines[i * machines.len() / most][0] as usize].point;
    (0..most).filter_map(|i| designs.design(pick(i)).ok()).collect()
}

/// What some designs take on a frame.
#[derive(Debug, Default)]
struct Times {
    /// Seconds of all of them, each on a thread of its own, what they share being there.
    warm_s: f64,
    designs: usize,
    /// Seconds of what they share.
    preprocessing_s: f64,
    preprocessings: usize,
    /// Of each design that shares no preprocessing, seconds that it takes more the first time.
    apart_s: Vec<f64>,
}

impl Times {
    /// Adds designs that need the same of a frame; fewer where that takes long.
    fn of(&mut self, designs: &[Design], window: &Window, display_fps: f64, began: Instant) {
        let timed = |design: &Design| {
            let started = Instant::now();
            Running::new(vec![design.clone()], 1).frames(window, display_fps, Halt::NEVER);
            started.elapsed().as_secs_f64()
        };
        let mut cold = Vec::new();
        for design in designs {
            if !cold.is_empty() && began.elapsed() > PATIENCE {
                break;
            }
            cold.push(timed(design));
        }
        let designs = &designs[..cold.len()];
        let warm: Vec<f64> = designs.iter().map(timed).collect();
        let together: Vec<f64> = designs.par_iter().map(timed).collect();
        let sum = |times: &[f64]| times.iter().sum::<f64>();
        self.warm_s += sum(&together).max(sum(&warm));
        self.designs += designs.len();
        let mut shared = HashSet::new();
        for (design, (cold, warm)) in designs.iter().zip(cold.iter().zip(&warm)) {
            let first_s = (cold - warm).max(0.0);
            match shares(design) {
                Some(key) => {
                    shared.insert(key);
                    self.preprocessing_s += first_s;
                }
                None => self.apart_s.push(first_s),
            }
        }
        self.preprocessings += shared.len();
    }

    /// What a design that shares no preprocessing takes more the first time: the median, since the
    /// first of several does what serves all of them.
    fn usual_apart_s(&self) -> f64 {
        let mut sorted = self.apart_s.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get(sorted.len().saturating_sub(1) / 2).copied().unwrap_or(0.0)
    }
}

/// What the designs of a plan do that others may share.
struct SharedWork {
    /// Different ways to preprocess a frame.
    preprocessings: f64,
    /// Designs that share none.
    apart: f64,
}

/// How many different ways to preprocess a frame the designs of a plan have: counted in some of
/// them, and where hardly two of those are alike, in proportion.
fn shared_work(designs: &Designs, plan: &Plan, scale: f64) -> SharedWork {
    let step = plan.designs.len().div_ceil(COMPARED).max(1);
    let (mut seen, mut apart, mut compared) = (HashSet::new(), 0u32, 0);
    for planned in plan.designs.iter().step_by(step) {
        let Ok(design) = designs.design(planned.point) else { continue };
        compared += 1;
        match shares(&design) {
            Some(key) => drop(seen.insert((planned.work, key))),
            None => apart += 1,
        }
    }
    let shared = compared - apart as usize;
    let is_sparse = 2 * seen.len() > shared;
    let each = step as f64 * scale;
    let alike = seen.len() as f64 * if is_sparse { each } else { 1.0 };
    SharedWork { preprocessings: alike, apart: f64::from(apart) * each }
}
