//! Takes the frames of traces through all machines of the experiment: each distinct machine once.

use std::collections::HashMap;

use super::turned::{Turn, Way};
use crate::cli::progress::{Counts, Watched};
use crate::cli::what_if::cost;
use crate::cli::{Context, Failure};
use powergs_core::run::{FrameView, Frames, Session, Subject, System, TraceFile};
use powergs_study::findings::sensitivity::{Outcome, Row, Side, Traced};

/// The distinct machines of an experiment, the one that others are compared with first.
#[derive(Debug)]
pub struct Machines {
    places: HashMap<u128, usize>,
    systems: Vec<System>,
    display_fps: f64,
}

impl Machines {
    /// Machines, each once; powers are at this display rate.
    pub fn of<'a>(all: impl IntoIterator<Item = &'a System>, display_fps: f64) -> Machines {
        let (mut places, mut systems) = (HashMap::new(), Vec::new());
        for system in all {
            places.entry(system.id()).or_insert_with(|| {
                systems.push(system.clone());
                systems.len() - 1
            });
        }
        Machines { places, systems, display_fps }
    }

    /// Machines that are known to be distinct.
    pub fn known(systems: Vec<System>, display_fps: f64) -> Machines {
        Machines { places: HashMap::new(), systems, display_fps }
    }

    /// What a machine costs, by trace.
    pub fn outcomes(&self, system: &System, means: &[Means]) -> Vec<Outcome> {
        outcomes(means, *self.places.get(&system.id()).expect("every machine was added"))
    }
}

/// What the machine at a place of the list costs, by trace.
pub fn outcomes(means: &[Means], place: usize) -> Vec<Outcome> {
    means.iter().map(|m| m.outcomes[place]).collect()
}

/// The machines of all turns of assumptions.
pub fn systems<'a>(base: &'a System, turns: &'a [Turn]) -> impl Iterator<Item = &'a System> {
    let of = |turn: &'a Turn| {
        let ways = [&turn.low, &turn.high].into_iter().flatten();
        std::iter::once(&turn.base).chain(ways.filter_map(|way| way.system.as_ref().ok()))
    };
    std::iter::once(base).chain(turns.iter().flat_map(of))
}

/// What came out of one trace: a mean for every machine.
#[derive(Debug)]
pub struct Means {
    name: String,
    frames: usize,
    asked: usize,
    outcomes: Vec<Outcome>,
}

/// Takes all traces through all machines; `None` if not even one frame was done.
///
/// # Errors
/// As [`measure`].
pub fn all(
    sources: &mut [TraceFile],
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
/// Exit code 3 for a frame that cannot be read, 2 for one that a machine cannot run, 4 for a
/// defect.
pub fn measure(
    source: &mut TraceFile,
    machines: &Machines,
    context: &Context,
) -> Result<Option<Means>, Failure> {
    let (name, asked) = (source.name().to_owned(), source.range().len());
    let subjects: Vec<Subject> = machines.systems.iter().map(Subject::of).collect();
    let steps = asked as u64 * subjects.len() as u64;
    let watch = Watched::new(context, steps, Counts::Simulations);
    let add = |sum: &mut Outcome, view: FrameView<'_>| {
        let cost = cost(&view.report);
        sum.frame_time_ms += cost.frame_time_ms;
        sum.energy_pj += cost.energy_pj;
        sum.power_w += view.report.power_display_rate_w(machines.display_fps);
    };
    let folded = Session::new(source, &watch).fold(&subjects, |_| Outcome::default(), add)?;
    let frames = folded.frames;
    if frames == 0 {
        return Ok(None);
    }
    let mean = |(sum, system): (Outcome, &System)| Outcome {
        frame_time_ms: sum.frame_time_ms / frames as f64,
        energy_pj: sum.energy_pj / frames as f64,
        power_w: sum.power_w / frames as f64,
        area_mm2: system.prices().area.map(|a| a.total().0),
    };
    let outcomes = folded.states.into_iter().zip(&machines.systems).map(mean).collect();
    Ok(Some(Means { name, frames, asked, outcomes }))
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
    let side = |way: &Way| {
        let outcomes = way.system.as_ref().map(|system| machines.outcomes(system, means));
        Side { value: way.value.clone(), outcomes: outcomes.map_err(Clone::clone) }
    };
    let row = |turn: &Turn| Row {
        number: format!("A{}", turn.number),
        text: turn.assumption.text.clone(),
        file: turn.knob.file.name(),
        keys: turn.knob.keys.clone(),
        value: turn.value.clone(),
        with: turn.knob.with.clone(),
        on: turn.knob.on.clone(),
        base: machines.outcomes(&turn.base, means),
        low: turn.low.as_ref().map(side),
        high: turn.high.as_ref().map(side),
    };
    turns.iter().map(row).collect()
}
