//! What a sweep will take, timed on a frame of every trace.

use std::collections::HashSet;
use std::time::Instant;

use super::opened::Opened;
use super::plan::Plan;
use super::running::Running;
use super::window::Window;
use crate::cli::Failure;
use powergs_core::accel::Memo;
use powergs_core::run::Frames;
use powergs_study::sweep::design::Design;

/// Machines that are timed on a frame.
const TIMED: usize = 8;
/// Machines that are looked at for what they share.
const COMPARED: usize = 2048;

/// What was timed.
#[derive(Debug, Default)]
pub struct Cost {
    /// Frames of all traces.
    pub frames: usize,
    /// Seconds to bin all frames under one geometry.
    pub bin_s: f64,
    /// Seconds of one machine on all frames whose preprocessing is there already.
    pub machine_s: f64,
    /// Seconds to preprocess all frames once.
    pub preprocessing_s: f64,
    /// How often frames are preprocessed: machines share it.
    pub preprocessings: f64,
    /// Bytes of binned frames in memory at a time, with the plan.
    pub bytes: usize,
}

/// Bins a frame of every trace under the base machine's geometry, and times a few machines of that
/// geometry on it, twice; `scale` is how many designs each of the plan stands for. The finest
/// geometry tells how much memory binned frames take.
///
/// # Errors
/// Exit code 3: a trace that cannot be read.
pub fn cost(opened: &mut Opened, plan: &Plan, scale: f64, memory: usize) -> Result<Cost, Failure> {
    let mut cost = Cost { preprocessings: preprocessings(opened, plan, scale), ..Cost::default() };
    let place = plan.designs[0].geometry;
    let geometry = plan.geometries[place as usize];
    let finest = plan.geometries.iter().min_by_key(|g| (g.tile, g.subtile)).unwrap_or(&geometry);
    let same: Vec<_> = plan.designs.iter().filter(|d| d.geometry == place).collect();
    let step = (same.len() / TIMED).max(1);
    let designs: Vec<Design> =
        same.iter().step_by(step).filter_map(|d| opened.design(d.point).ok()).collect();
    for trace in &mut opened.traces {
        let range = trace.source.range();
        let frames = range.len() as f64;
        let middle = range.start + range.len() / 2;
        let started = Instant::now();
        let window = Window::bin(&mut trace.source, geometry, middle, 1)?;
        cost.bin_s += started.elapsed().as_secs_f64() * frames;
        let first = seconds_each(&designs, &window, opened.display_fps);
        let again = seconds_each(&designs, &window, opened.display_fps).min(first);
        cost.machine_s += again * frames;
        cost.preprocessing_s += (first - again) * frames;
        let bytes = match *finest == geometry {
            true => window.frames[0].bytes(),
            false => {
                let window = Window::bin(&mut trace.source, *finest, middle, 1)?;
                window.frames[0].bytes()
            }
        };
        cost.bytes = cost.bytes.max((bytes * range.len()).min(memory.max(bytes) + bytes));
        cost.frames += range.len();
    }
    cost.bytes += plan.designs.len() * size_of::<super::plan::Planned>();
    Ok(cost)
}

/// Seconds of a design on the frames of a window.
fn seconds_each(designs: &[Design], window: &Window, display_fps: f64) -> f64 {
    let started = Instant::now();
    for design in designs {
        Running::new(vec![design.clone()]).frames(window, display_fps);
    }
    started.elapsed().as_secs_f64() / designs.len() as f64
}

/// How many different ways to preprocess a frame the designs of a plan have: counted in some of
/// them, and where hardly two of those are alike, in proportion.
fn preprocessings(opened: &Opened, plan: &Plan, scale: f64) -> f64 {
    let step = plan.designs.len().div_ceil(COMPARED).max(1);
    let (mut seen, mut apart, mut compared) = (HashSet::new(), 0u32, 0);
    for planned in plan.designs.iter().step_by(step) {
        let Ok(design) = opened.design(planned.point) else { continue };
        compared += 1;
        match Memo::shared_by(&design.machine) {
            Some(key) => drop(seen.insert((planned.geometry, key))),
            None => apart += 1,
        }
    }
    let shared = compared - apart as usize;
    let is_sparse = 2 * seen.len() > shared;
    let each = step as f64 * scale;
    let alike = seen.len() as f64 * if is_sparse { each } else { 1.0 };
    alike + f64::from(apart) * each
}
