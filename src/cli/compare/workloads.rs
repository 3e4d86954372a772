//! `compare --workloads`: the standard workloads in place of traces.

use std::path::PathBuf;
use std::sync::Arc;

use super::CompareCommandArgs;
use crate::cli::progress::{ProgressCounts, WatchedProgress};
use crate::cli::{Context, Exit, Failure, OrExit, out};
use powergs_base::config::embedded::MACHINES;
use powergs_core::run::{Frames, System};
use powergs_scene::synth::{Preset, generate};
use powergs_study::findings::compare::Side;
use powergs_study::replay::on_each;
use powergs_study::validate::run::MEMORY;
use powergs_study::validate::{BASELINE, PUBLISHED, Tables, WORKLOADS, Workload};
use powergs_views::rendered;

/// A word for several workloads, and which of them are meant.
type Set = (&'static str, &'static str, fn(&Workload) -> bool);

/// Words for several workloads.
const SETS: [Set; 2] = [
    ("standard", "scenes at the size of their captures", |w| w.eyes == 0 && w.name == w.preset),
    ("all", "all of single views", |w| w.eyes == 0),
];

/// The machines that are given, and with `--all-machines` the others that come with the program.
pub fn machines(items: &[PathBuf], all: bool) -> Vec<PathBuf> {
    let mut machines = items.to_vec();
    let others = MACHINES.iter().map(|file| PathBuf::from(file.name));
    machines.extend(others.filter(|name| all && !items.contains(name)));
    machines
}

/// Names of workloads, and what they are.
pub fn names() -> Vec<(String, String)> {
    let tables = Tables::parse(PUBLISHED, WORKLOADS, BASELINE);
    let all = tables.map(|tables| tables.workloads).unwrap_or_default();
    let of = |workload: Workload| (workload.name, workload.why);
    let sets = SETS.iter().map(|(name, what, _)| ((*name).to_owned(), (*what).to_owned()));
    sets.chain(all.into_iter().map(of)).collect()
}

/// The workloads of these names, in the order of their table.
///
/// # Errors
/// Exit code 2: an unknown name, with the known ones.
pub fn chosen(names: &[String]) -> Result<Vec<Workload>, Failure> {
    let tables = Tables::parse(PUBLISHED, WORKLOADS, BASELINE).or_exit(Exit::Internal, "tables")?;
    let known = &tables.workloads;
    for name in names {
        let is_set = SETS.iter().any(|(set, ..)| set == name);
        if !is_set && !known.iter().any(|workload| workload.name == *name) {
            let sets = SETS.iter().map(|(set, what, _)| format!("{set} ({what})"));
            let known = known.iter().map(|workload| workload.name.clone());
            let known: Vec<String> = sets.chain(known).collect();
            let what = format!("--workloads: no workload `{name}`; there are {}", known.join(", "));
            return Err(Failure::new(Exit::Usage, what));
        }
    }
    let is_meant = |workload: &Workload| {
        let of_set = |(set, _, has): &Set| names.iter().any(|name| name == set) && has(workload);
        SETS.iter().any(of_set) || names.contains(&workload.name)
    };
    Ok(tables.workloads.into_iter().filter(is_meant).collect())
}

/// The frames of a workload of a scene of so many splats.
fn frames(workload: &Workload, preset: &Preset, points: usize) -> Box<dyn Frames> {
    let scene = Arc::new(generate(preset, points, workload.seed));
    rendered(&workload.name, scene, workload.cameras(preset))
}

/// Leaves out machines that one of the workloads is not for, such as those of pairs of views, and
/// says so; the first `named` were asked for by name.
///
/// # Errors
/// Exit code 2: a machine that was asked for cannot run a workload.
pub fn fitting(
    systems: Vec<System>,
    workloads: &[Workload],
    named: usize,
) -> Result<Vec<System>, Failure> {
    let mut left = Vec::new();
    for (i, system) in systems.into_iter().enumerate() {
        let refuses = |workload: &Workload| {
            // Of its size, but empty: what a machine holds of a frame is known without splats.
            let preset = workload.preset()?;
            let mut frames =
                frames(&Workload { views: workload.views.min(2), ..workload.clone() }, preset, 200);
            on_each(std::slice::from_ref(&system), 60.0, &mut *frames, None, &()).err()
        };
        match workloads.iter().find_map(refuses) {
            Some(why) if i < named => return Err(why.into()),
            Some(why) => {
                let name = &system.machine().name;
                out::complain(format_args!("note: {name} is left out: {why}"));
            }
            None => left.push(system),
        }
    }
    Ok(left)
}

/// Says which machines live from views of a path, and which workloads are none.
pub fn note_paths(systems: &[System], workloads: &[Workload]) {
    let keeps = |system: &&System| {
        let machine = system.machine();
        machine.flow().takes_over(machine).is_some()
    };
    let machines: Vec<&str> =
        systems.iter().filter(keeps).map(|system| system.machine().name.as_str()).collect();
    let still = workloads.iter().filter(|workload| workload.path == 0 && workload.eyes == 0);
    let still: Vec<&str> = still.map(|workload| workload.name.as_str()).collect();
    if !machines.is_empty() && !still.is_empty() {
        out::complain(format_args!(
            "note: {} take over orders of the frame before, and views of {} are no path: compare \
             them on uhd-path-hd, uhd-path-fhd, uhd-path",
            machines.join(", "),
            still.join(", ")
        ));
    }
}

/// Simulates every workload on every machine, a list of sides a workload; without workloads that
/// were not begun.
pub fn simulated(
    args: &CompareCommandArgs,
    systems: &[System],
    workloads: &[Workload],
    context: &Context,
) -> Result<Vec<Vec<Side>>, Failure> {
    let count: usize = workloads.iter().map(Workload::frames).sum();
    let total = (count * systems.len()) as u64;
    let watch = WatchedProgress::of_total(context, total, ProgressCounts::Simulations);
    let asked = context.global.memory;
    let memory = if asked.0 >= MEMORY.0 { asked } else { MEMORY };
    let mut all = Vec::new();
    for workload in workloads {
        let Some(preset) = workload.preset() else { continue };
        let mut frames = frames(workload, preset, preset.points);
        frames.allow(memory);
        let counted: Vec<usize> = frames.range().skip(workload.warm_up()).collect();
        let runs = on_each(systems, args.shown.fps, &mut *frames, Some(&counted), &watch)?;
        let sides: Option<Vec<Side>> = runs.iter().map(Side::of_run).collect();
        all.extend(sides);
        if context.is_cancelled() {
            break;
        }
    }
    Ok(all)
}
