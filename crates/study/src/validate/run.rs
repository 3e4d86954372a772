//! Measures rows: every scene made once, every view rendered once, binned once per geometry.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::numbers::Parts;
use super::totals::Totals;
use super::{Block, MachineName, Row, Tables, Workload};
use crate::views::RenderedViews;
use powergs_core::run::{FrameView, RunError, Session, Subject, System, Watch};
use powergs_core::sim::cost::peak_w;
use powergs_scene::synth::generate;

/// A machine that rows ask for.
#[derive(Debug, Clone)]
pub struct Built {
    /// The machine with its prices.
    pub system: System,
    /// Its area, mm², where the energy table knows it.
    pub area_mm2: Option<f64>,
    /// Its power with every unit busy, watts.
    pub peak_w: f64,
    /// The same two of each block.
    pub blocks: [(Option<f64>, f64); Block::ALL.len()],
}

impl Built {
    /// The machine, and what needs no frame.
    pub fn new(system: System) -> Built {
        let area_mm2 = system.prices().area.map(|area| area.total().0);
        let peak = peak_w(system.machine(), system.prices());
        let areas = system.prices().area.map(|area| area.blocks());
        let blocks = Block::ALL.map(|block| {
            let area = areas.iter().flatten().filter(|(name, _)| block.has(name));
            let area = areas.map(|_| area.map(|(_, mm2)| mm2.0).sum());
            let watts = peak.iter().filter(|(name, _)| block.has(name)).map(|(_, watts)| watts);
            (area, watts.sum())
        });
        Built { area_mm2, peak_w: peak.iter().map(|(_, watts)| watts).sum(), blocks, system }
    }

    /// Adds what needs no frame.
    fn facts(&self, totals: Totals) -> Totals {
        let blocks = Some(self.blocks);
        Totals { area_mm2: self.area_mm2, peak_w: Some(self.peak_w), blocks, ..totals }
    }
}

/// What machines did, by workload (empty for none) and machine.
pub type Measurements = BTreeMap<(String, MachineName), Totals>;

/// How often a frame goes through a machine: what [`Watch::simulated`] counts up to.
pub fn steps(tables: &Tables, rows: &[&Row]) -> u64 {
    let of = |w: &Workload| (machines(rows, &w.name).len() * w.views) as u64;
    tables.workloads.iter().map(of).sum()
}

/// Measures what `rows` need; `None` if the watch cancelled it. `built` has every machine that they
/// name.
///
/// # Errors
/// [`RunError`]: a defect of the simulator.
///
/// # Panics
/// When `built` lacks a machine.
pub fn measure(
    tables: &Tables,
    rows: &[&Row],
    built: &BTreeMap<MachineName, Built>,
    watch: &dyn Watch,
) -> Result<Option<Measurements>, RunError> {
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
        if !one_scene(&now, rows, built, watch, &mut all)? {
            return Ok(None);
        }
    }
    Ok(Some(all))
}

/// The machines that the rows of a workload name.
fn machines<'a>(rows: &[&'a Row], workload: &str) -> Vec<&'a MachineName> {
    let mine = rows.iter().filter(|row| row.workloads.iter().any(|name| name == workload));
    let mut names: Vec<&MachineName> =
        mine.flat_map(|row| [Some(&row.machine), row.against.as_ref()]).flatten().collect();
    names.sort();
    names.dedup();
    names
}

/// Measures the workloads of one scene; returns whether all of them were finished.
fn one_scene(
    workloads: &[&Workload],
    rows: &[&Row],
    built: &BTreeMap<MachineName, Built>,
    watch: &dyn Watch,
    all: &mut Measurements,
) -> Result<bool, RunError> {
    let Some(preset) = workloads[0].preset() else { return Ok(true) };
    let scene = Arc::new(generate(preset, workloads[0].points, workloads[0].seed));
    for workload in workloads {
        let names = machines(rows, &workload.name);
        let cameras = workload.cameras(preset);
        let counted: Vec<usize> = (workload.warm_up()..cameras.len()).collect();
        let systems = names.iter().map(|&name| &built[name].system);
        let subjects: Vec<Subject> = systems.map(|s| Subject::of(s).only(&counted)).collect();
        let mut views = RenderedViews::new(&workload.name, Arc::clone(&scene), cameras);
        let folded = Session::new(&mut views, watch).fold(
            &subjects,
            |i| (&built[names[i]], Totals::default()),
            |(built, totals), FrameView { workload, measured, report, .. }| {
                totals.add(built.system.machine(), workload, measured, &report);
            },
        )?;
        if !folded.is_complete {
            return Ok(false);
        }
        for (name, (built, totals)) in names.into_iter().zip(folded.states) {
            all.insert((workload.name.clone(), name.clone()), built.facts(totals));
        }
    }
    Ok(true)
}

/// The values of a row, where all of them were measured.
pub fn value(row: &Row, measured: &Measurements) -> Option<Parts> {
    let part = |workload: &str| {
        let of = |name: &MachineName| measured.get(&(workload.to_owned(), name.clone()));
        let value = row.metric.value(of(&row.machine)?, row.against.as_ref().and_then(of))?;
        Some((workload.to_owned(), value))
    };
    row.part_names().map(part).collect()
}
