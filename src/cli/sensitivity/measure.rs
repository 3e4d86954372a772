//! Takes the frames of traces through all machines of the experiment: each distinct machine once,
//! each frame binned once for every geometry.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use rayon::prelude::*;

use super::turned::{Files, Turn, Way};
use crate::cli::trace_source::{TraceFrame, TraceSource};
use crate::cli::what_if::{Variant, cost};
use crate::cli::{Context, Exit, Failure, OrExit, progress::Progress};
use crate::report::sensitivity::{Outcome, Row, Side, Traced};
use crate::sim::{Lists, Measured, simulate_measured};
use crate::workload::{FrameWorkload, Geometry, bin};

/// The distinct machines of an experiment.
#[derive(Debug, Default)]
pub struct Machines {
    files: Vec<Files>,
    variants: Vec<Result<Variant, String>>,
}

impl Machines {
    /// The place of a machine in the list.
    pub fn add(&mut self, files: &Files) -> usize {
        if let Some(known) = self.files.iter().position(|f| f == files) {
            return known;
        }
        self.files.push(files.clone());
        self.variants.push(files.variant());
        self.files.len() - 1
    }

    /// The machines of all turns.
    pub fn of(base: &Files, turns: &[Turn]) -> Machines {
        let mut machines = Machines::default();
        machines.add(base);
        for turn in turns {
            machines.add(&turn.base);
            for way in [&turn.low, &turn.high].into_iter().flatten() {
                machines.add(&way.files);
            }
        }
        machines
    }

    fn place(&self, files: &Files) -> usize {
        self.files.iter().position(|f| f == files).expect("every machine was added")
    }
}

/// What came out of one trace: a mean for every machine that is one.
#[derive(Debug)]
pub struct Means {
    name: String,
    frames: usize,
    asked: usize,
    outcomes: Vec<Outcome>,
}

/// One machine on its way through a trace.
struct Running<'a> {
    variant: &'a Variant,
    /// Place in the list of machines.
    index: usize,
    lists: Lists,
    sum: Outcome,
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
    let alive = machines.variants.iter().enumerate();
    let mut running: Vec<Running> = alive
        .filter_map(|(index, v)| {
            let variant = v.as_ref().ok()?;
            Some(Running { variant, index, lists: Lists::default(), sum: Outcome::default() })
        })
        .collect();
    let (name, asked) = (source.facts.name.clone(), source.facts.frames);
    let progress = Progress::new(context, asked as u64, "frames");
    let mut frames = 0;
    source.in_sequence(
        |frame| one_frame(&mut running, &frame),
        |()| {
            frames += 1;
            progress.advance(1);
            if context.is_cancelled() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        },
    )?;
    if frames == 0 {
        return Ok(None);
    }
    let mut outcomes = vec![Outcome::default(); machines.variants.len()];
    for r in running {
        outcomes[r.index] = Outcome {
            frame_time_ms: r.sum.frame_time_ms / frames as f64,
            energy_pj: r.sum.energy_pj / frames as f64,
            area_mm2: r.variant.prices.area.map(|a| a.total().0),
        };
    }
    Ok(Some(Means { name, frames, asked, outcomes }))
}

fn one_frame(running: &mut [Running], frame: &TraceFrame) -> Result<(), Failure> {
    let mut geometries: Vec<Geometry> =
        running.iter().map(|r| r.variant.machine.geometry).collect();
    geometries.sort();
    geometries.dedup();
    for geometry in geometries {
        let workload = bin(&frame.frame, geometry);
        let mut on_it: Vec<&mut Running> =
            running.iter_mut().filter(|r| r.variant.machine.geometry == geometry).collect();
        on_it.par_iter_mut().try_for_each(|r| one_machine(r, frame, &workload))?;
    }
    Ok(())
}

fn one_machine(
    running: &mut Running,
    frame: &TraceFrame,
    workload: &FrameWorkload,
) -> Result<(), Failure> {
    let Variant { machine, prices } = running.variant;
    let measured = match machine.gsu.reuse_period {
        1 => Measured::needed(workload, machine),
        _ => Measured::of(workload, machine, &mut running.lists),
    };
    let label = frame.label.clone();
    let place = format!("internal error in frame {}", label.name);
    let report = simulate_measured(label, workload, &measured, machine, prices)
        .or_exit(Exit::Internal, place)?;
    let cost = cost(&report);
    running.sum.frame_time_ms += cost.frame_time_ms;
    running.sum.energy_pj += cost.energy_pj;
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
    let outcomes = |files: &Files| -> Result<Vec<Outcome>, String> {
        let place = machines.place(files);
        machines.variants[place].as_ref().map_err(Clone::clone)?;
        Ok(means.iter().map(|m| m.outcomes[place]).collect())
    };
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
