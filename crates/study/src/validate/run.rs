//! Measures rows: every scene made once, every view rendered once, binned once per geometry.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Mutex;

use rayon::prelude::*;

use super::frames::{Step, scene_steps};
use super::totals::Totals;
use super::{MachineName, Row, Tables, Workload};
use powergs_core::accel::Machine;
use powergs_core::energy::Prices;
use powergs_core::sim::{Breach, Label, Lists, Measured, simulate_measured};
use powergs_core::workload::FrameWorkload;
use powergs_scene::synth::generate;

/// A machine that rows ask for.
#[derive(Debug, Clone)]
pub struct Built {
    /// The machine.
    pub machine: Machine,
    /// Its prices.
    pub prices: Prices,
    /// Its area, mm², where the energy table knows it.
    pub area_mm2: Option<f64>,
    /// Its power with every unit busy, watts.
    pub peak_w: Option<f64>,
}

impl Built {
    /// Adds what needs no frame.
    fn facts(&self, totals: Totals) -> Totals {
        Totals { area_mm2: self.area_mm2, peak_w: self.peak_w, ..totals }
    }
}

/// The run was broken off, or a frame showed a defect.
#[derive(Debug)]
pub enum Interrupted {
    /// Whoever watched said so.
    Cancelled,
    /// A defect of the simulator: machine, and what it says.
    Breach(MachineName, Breach),
}

/// What machines did, by workload (empty for none) and machine.
pub type Measurements = BTreeMap<(String, MachineName), Totals>;

/// A machine in a run: its sums so far, and the lists of the frame before.
struct Seat<'a> {
    name: &'a MachineName,
    built: &'a Built,
    state: Mutex<(Totals, Lists)>,
}

impl Seat<'_> {
    fn take(&self, frame: &FrameWorkload, counts: bool) -> Result<(), Breach> {
        let mut state = self.state.lock().expect("nobody panics with it");
        let (totals, lists) = &mut *state;
        let machine = &self.built.machine;
        let measured = if machine.gsu.reuse_period > 1 {
            Measured::of(frame, machine, lists)
        } else {
            Measured::needed(frame, machine)
        };
        if counts {
            let label = Label::default();
            let report = simulate_measured(label, frame, &measured, machine, &self.built.prices)?;
            totals.add(machine, frame, &measured, &report);
        }
        Ok(())
    }
}

/// Steps of a run, for progress: one per view and machine.
pub fn steps(tables: &Tables, rows: &[&Row]) -> u64 {
    let of = |w: &Workload| (machines(rows, &w.name).len() * (w.views + w.warm_up())) as u64;
    tables.workloads.iter().map(of).sum()
}

/// Measures what `rows` need. `built` has every machine that they name; `watch` is told of steps
/// that are done and may break the run off.
///
/// # Errors
/// [`Interrupted`].
///
/// # Panics
/// When `built` lacks a machine.
pub fn measure(
    tables: &Tables,
    rows: &[&Row],
    built: &BTreeMap<MachineName, Built>,
    watch: &(dyn Fn(u64) -> ControlFlow<()> + Sync),
) -> Result<Measurements, Interrupted> {
    let mut all = Measurements::new();
    for (name, built) in built {
        let totals = built.facts(Totals::default());
        all.insert((String::new(), name.clone()), totals);
    }
    let mut todo: Vec<&Workload> = tables.workloads.iter().collect();
    todo.retain(|workload| !machines(rows, &workload.name).is_empty());
    while let Some(first) = todo.first() {
        let key = first.scene_key();
        let (now, later) = todo.into_iter().partition(|w| w.scene_key() == key);
        todo = later;
        one_scene(&now, rows, built, watch, &mut all)?;
    }
    Ok(all)
}

/// The machines that the rows of a workload name.
fn machines<'a>(rows: &[&'a Row], workload: &str) -> Vec<&'a MachineName> {
    let mine = rows.iter().filter(|row| row.workload.as_deref() == Some(workload));
    let mut names: Vec<&MachineName> =
        mine.flat_map(|row| [Some(&row.machine), row.against.as_ref()]).flatten().collect();
    names.sort();
    names.dedup();
    names
}

fn one_scene(
    workloads: &[&Workload],
    rows: &[&Row],
    built: &BTreeMap<MachineName, Built>,
    watch: &(dyn Fn(u64) -> ControlFlow<()> + Sync),
    all: &mut Measurements,
) -> Result<(), Interrupted> {
    let Some(preset) = workloads[0].preset() else { return Ok(()) };
    let scene = generate(preset, workloads[0].points, workloads[0].seed);
    for workload in workloads {
        let seats: Vec<Seat> = machines(rows, &workload.name)
            .into_iter()
            .map(|name| Seat { name, built: &built[name], state: Mutex::default() })
            .collect();
        let mut geometries: Vec<_> = seats.iter().map(|s| s.built.machine.geometry).collect();
        geometries.sort_by_key(|g| format!("{g:?}"));
        geometries.dedup();
        scene_steps(&scene, preset, workload, &geometries, |step: &Step| {
            let mine = |seat: &&Seat| seat.built.machine.geometry == step.frame.geometry;
            seats.par_iter().filter(mine).try_for_each(|seat| {
                seat.take(&step.frame, step.counts)
                    .map_err(|breach| Interrupted::Breach(seat.name.clone(), breach))?;
                match watch(1) {
                    ControlFlow::Continue(()) => Ok(()),
                    ControlFlow::Break(()) => Err(Interrupted::Cancelled),
                }
            })
        })?;
        for seat in seats {
            let (totals, _) = seat.state.into_inner().expect("nobody panics with it");
            all.insert((workload.name.clone(), seat.name.clone()), seat.built.facts(totals));
        }
    }
    Ok(())
}

/// The value of a row, where it was measured.
pub fn value(row: &Row, measured: &Measurements) -> Option<f64> {
    let workload = row.workload.clone().unwrap_or_default();
    let of = |name: &MachineName| measured.get(&(workload.clone(), name.clone()));
    row.metric.value(of(&row.machine)?, row.against.as_ref().and_then(of))
}
