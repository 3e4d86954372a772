//! Takes the frames of traces through all machines of the experiment: each distinct machine once,
//! each frame binned once for every geometry.

use std::collections::{BTreeMap, HashMap};
use std::ops::ControlFlow;

use rayon::prelude::*;

use super::files::Files;
use super::turned::{Turn, Way};
use crate::cli::trace_source::{TraceFrame, TraceSource};
use crate::cli::what_if::{Variant, cost};
use crate::cli::{Context, Exit, Failure, OrExit, progress::Progress};
use powergs_core::accel::Machine;
use powergs_core::energy::Prices;
use powergs_core::sim::{Lists, Measured, priced, time};
use powergs_core::workload::{FrameWorkload, Geometry, bin};
use powergs_report::sensitivity::{Outcome, Row, Side, Traced};

/// The distinct machines of an experiment, the one that others are compared with first.
#[derive(Debug)]
pub struct Machines {
    places: HashMap<Files, usize>,
    variants: Vec<Result<Variant, String>>,
    display_fps: f64,
}

impl Machines {
    /// The machines of files, each once; powers are at this display rate.
    pub fn of<'a>(all: impl IntoIterator<Item = &'a Files>, display_fps: f64) -> Machines {
        let (mut places, mut distinct) = (HashMap::new(), Vec::new());
        for files in all {
            places.entry(files.clone()).or_insert_with(|| {
                distinct.push(files);
                distinct.len() - 1
            });
        }
        let variants = distinct.par_iter().map(|files| files.variant()).collect();
        Machines { places, variants, display_fps }
    }

    /// Machines that are known to be distinct.
    pub fn known(variants: Vec<Variant>, display_fps: f64) -> Machines {
        let variants = variants.into_iter().map(Ok).collect();
        Machines { places: HashMap::new(), variants, display_fps }
    }

    fn place(&self, files: &Files) -> usize {
        *self.places.get(files).expect("every machine was added")
    }

    /// What files cost, by trace.
    ///
    /// # Errors
    /// Why they are no machine.
    pub fn outcomes(&self, files: &Files, means: &[Means]) -> Result<Vec<Outcome>, String> {
        let place = self.place(files);
        self.variants[place].as_ref().map_err(Clone::clone)?;
        Ok(outcomes(means, place))
    }
}

/// What the machine at a place of the list costs, by trace.
pub fn outcomes(means: &[Means], place: usize) -> Vec<Outcome> {
    means.iter().map(|m| m.outcomes[place]).collect()
}

/// The files of all turns of assumptions.
pub fn files<'a>(base: &'a Files, turns: &'a [Turn]) -> impl Iterator<Item = &'a Files> {
    let of = |turn: &'a Turn| {
        let ways = [&turn.low, &turn.high].into_iter().flatten().map(|way| &way.files);
        std::iter::once(&turn.base).chain(ways)
    };
    std::iter::once(base).chain(turns.iter().flat_map(of))
}

/// What came out of one trace: a mean for every machine that is one.
#[derive(Debug)]
pub struct Means {
    name: String,
    frames: usize,
    asked: usize,
    outcomes: Vec<Outcome>,
}

/// Machines that differ in prices only, on their way through a trace: they share one timing.
struct Running<'a> {
    machine: &'a Machine,
    lists: Lists,
    priced: Vec<Priced<'a>>,
}

/// One machine with its prices.
struct Priced<'a> {
    prices: &'a Prices,
    /// Place in the list of machines.
    index: usize,
    /// Of the frame that is being worked on.
    frame: Outcome,
    sum: Outcome,
}

/// Takes all traces through all machines; `None` if not even one frame was done.
///
/// # Errors
/// As [`measure`].
pub fn all(
    sources: &mut [TraceSource],
    machines: &Machines,
    context: &Context,
) -> Result<Option<Vec<Means>>, Failure> {
    let mut means = Vec::new();
    for source in sources {
        if context.is_cancelled() {
            break;
        }
        means.extend(measure(source, machines, context)?);
    }
    Ok((!means.is_empty()).then_some(means))
}

/// Takes a trace through all machines; `None` if not even one frame was done.
///
/// # Errors
/// Exit code 3 for a frame that cannot be read, 4 for a mistake of ours.
pub fn measure(
    source: &mut TraceSource,
    machines: &Machines,
    context: &Context,
) -> Result<Option<Means>, Failure> {
    let mut running = running(machines);
    let (name, asked) = (source.facts.name.clone(), source.facts.frames);
    let machines_on_it: usize = running.iter().map(|r| r.priced.len()).sum();
    let total = asked as u64 * machines_on_it as u64;
    let progress = Progress::new(context, total, "frames on machines");
    let mut frames = 0;
    source.in_sequence(
        |frame| {
            one_frame(&mut running, &frame, machines.display_fps, &progress, context)?;
            if context.is_cancelled() {
                return Ok(());
            }
            running.iter_mut().flat_map(|r| &mut r.priced).for_each(Priced::add);
            frames += 1;
            Ok(())
        },
        |()| match context.is_cancelled() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        },
    )?;
    if frames == 0 {
        return Ok(None);
    }
    let mut outcomes = vec![Outcome::default(); machines.variants.len()];
    for p in running.into_iter().flat_map(|r| r.priced) {
        outcomes[p.index] = Outcome {
            frame_time_ms: p.sum.frame_time_ms / frames as f64,
            energy_pj: p.sum.energy_pj / frames as f64,
            power_w: p.sum.power_w / frames as f64,
            area_mm2: p.prices.area.map(|a| a.total().0),
        };
    }
    Ok(Some(Means { name, frames, asked, outcomes }))
}

/// The machines, those together that differ in prices only.
fn running(machines: &Machines) -> Vec<Running<'_>> {
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut running: Vec<Running> = Vec::new();
    for (index, variant) in machines.variants.iter().enumerate() {
        let Ok(Variant { machine, prices }) = variant else { continue };
        let place = *places.entry(format!("{:?}", timed(machine))).or_insert(running.len());
        if place == running.len() {
            running.push(Running { machine, lists: Lists::default(), priced: Vec::new() });
        }
        let (frame, sum) = (Outcome::default(), Outcome::default());
        running[place].priced.push(Priced { prices, index, frame, sum });
    }
    running
}

/// What of a machine decides its timing, and some more: all but its names.
fn timed(machine: &Machine) -> Machine {
    let mut machine = machine.clone();
    machine.energy.clear();
    machine.name.clear();
    machine.description.clear();
    machine
}

impl Priced<'_> {
    /// Adds the frame.
    fn add(&mut self) {
        self.sum.frame_time_ms += self.frame.frame_time_ms;
        self.sum.energy_pj += self.frame.energy_pj;
        self.sum.power_w += self.frame.power_w;
    }
}

/// All machines on one frame; when it was cancelled, only some of them.
fn one_frame(
    running: &mut [Running],
    frame: &TraceFrame,
    display_fps: f64,
    progress: &Progress,
    context: &Context,
) -> Result<(), Failure> {
    let mut geometries: Vec<Geometry> = running.iter().map(|r| r.machine.geometry).collect();
    geometries.sort();
    geometries.dedup();
    for geometry in geometries {
        if context.is_cancelled() {
            break;
        }
        let workload = bin(&frame.frame, geometry);
        let mut on_it: Vec<&mut Running> =
            running.iter_mut().filter(|r| r.machine.geometry == geometry).collect();
        on_it.par_iter_mut().try_for_each(|r| {
            if context.is_cancelled() {
                return Ok(());
            }
            progress.advance(r.priced.len() as u64);
            one_machine(r, frame, &workload, display_fps)
        })?;
    }
    Ok(())
}

fn one_machine(
    running: &mut Running,
    frame: &TraceFrame,
    workload: &FrameWorkload,
    display_fps: f64,
) -> Result<(), Failure> {
    let machine = running.machine;
    let measured = match machine.gsu.reuse_period {
        1 => Measured::needed(workload, machine),
        _ => Measured::of(workload, machine, &mut running.lists),
    };
    let place = || format!("internal error in frame {}", frame.label.name);
    let timed = time(frame.label.frame, workload, &measured, machine);
    let timed = timed.or_exit(Exit::Internal, place())?;
    for p in &mut running.priced {
        let report = priced(frame.label.clone(), &timed, p.prices);
        let report = report.or_exit(Exit::Internal, place())?;
        let cost = cost(&report);
        p.frame = Outcome {
            frame_time_ms: cost.frame_time_ms,
            energy_pj: cost.energy_pj,
            power_w: report.power_display_rate_w(display_fps),
            area_mm2: None,
        };
    }
    Ok(())
}

/// What the reports say about the traces.
pub fn traced(means: &[Means]) -> Vec<Traced> {
    let of = |m: &Means| Traced {
        name: m.name.clone(),
        frames: m.frames,
        asked: m.asked,
        base: m.outcomes[0],
    };
    means.iter().map(of).collect()
}

/// The rows of the report.
pub fn rows(turns: &[Turn], machines: &Machines, means: &[Means]) -> Vec<Row> {
    let outcomes = |files: &Files| machines.outcomes(files, means);
    let side = |way: &Way| Side { value: way.value.clone(), outcomes: outcomes(&way.files) };
    let row = |turn: &Turn| Row {
        number: format!("A{}", turn.number),
        text: turn.assumption.text.clone(),
        file: turn.knob.file.name(),
        keys: turn.knob.keys.clone(),
        value: turn.value.clone(),
        with: turn.knob.with.clone(),
        on: turn.knob.on.clone(),
        base: outcomes(&turn.base).unwrap_or_default(),
        low: turn.low.as_ref().map(side),
        high: turn.high.as_ref().map(side),
    };
    turns.iter().map(row).collect()
}

/// Assumptions by place of their machine: those whose own base is none, with the reason.
pub fn without_base(turns: &[Turn], machines: &Machines) -> BTreeMap<u32, String> {
    let reason = |t: &Turn| machines.variants[machines.place(&t.base)].as_ref().err().cloned();
    turns.iter().filter_map(|t| Some((t.number, reason(t)?))).collect()
}
