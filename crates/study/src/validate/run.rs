//! Measures rows: every scene made once, every view rendered once, binned once per geometry.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::numbers::Parts;
use super::totals::{BlockCost, Totals};
use super::{Block, MachineName, Row, Status, Tables, Workload};
use powergs_base::budget::Budget;
use powergs_base::quantity::Bytes;
use powergs_core::run::{FrameView, Frames, RunError, Session, Subject, System, Watch};
use powergs_core::sim::cost::peak_w;
use powergs_core::stage::hardware;
use powergs_energy::Area;
use powergs_scene::synth::generate;
use powergs_scene::{Camera, Gaussians};

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
    pub blocks: Vec<BlockCost>,
}

impl Built {
    /// The machine, and what needs no frame.
    pub fn new(system: System) -> Built {
        let area = system.prices().area.as_ref();
        let area_mm2 = area.map(|area| area.core().0);
        let peak = peak_w(system.machine(), system.prices());
        let names = Area::blocks(hardware());
        let of_block = |block: Block| {
            let mine = |areas: &Area| -> f64 {
                let all = names.iter().zip(areas.areas());
                all.filter(|(known, _)| block.has(known.name)).map(|(_, mm2)| mm2.0).sum()
            };
            let watts = peak.iter().filter(|(name, _)| block.has(name)).map(|(_, watts)| watts);
            (area.map(mine), watts.sum())
        };
        let blocks = Block::all().map(of_block).collect();
        Built { area_mm2, peak_w: peak.iter().map(|(_, watts)| watts).sum(), blocks, system }
    }

    /// Adds what needs no frame.
    fn facts(&self, totals: Totals) -> Totals {
        let blocks = Some(self.blocks.clone());
        Totals { area_mm2: self.area_mm2, peak_w: Some(self.peak_w), blocks, ..totals }
    }
}

/// What machines did, by workload (empty for none) and machine.
pub type Measurements = BTreeMap<(String, MachineName), Totals>;

/// How often a frame goes through a machine: what [`Watch::simulated`] counts up to.
pub fn steps(tables: &Tables, rows: &[&Row]) -> u64 {
    let of = |w: &Workload| (machines(rows, &w.name).len() * w.frames()) as u64;
    tables.workloads.iter().map(of).sum()
}

/// What the frames of the rows that come with the program need: 28 M pairs in one of them.
pub const MEMORY: Budget = Budget(Bytes(2 << 30));

/// What makes frames of a scene and the cameras that see it, under a name.
pub type ValidationRender<'a> = &'a dyn Fn(&str, Arc<Gaussians>, Vec<Camera>) -> Box<dyn Frames>;

/// Measures what `rows` need on scenes that `render` makes frames of; `None` if the watch cancelled
/// it. `built` has every machine that they name; a frame may take `memory`.
///
/// # Errors
/// [`RunError`]: a frame that takes more memory, or a defect of the simulator.
///
/// # Panics
/// When `built` lacks a machine.
pub fn measure(
    tables: &Tables,
    rows: &[&Row],
    built: &BTreeMap<MachineName, Built>,
    render: ValidationRender<'_>,
    memory: Budget,
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
        if !one_scene(&now, rows, built, render, memory, watch, &mut all)? {
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
    render: ValidationRender<'_>,
    memory: Budget,
    watch: &dyn Watch,
    all: &mut Measurements,
) -> Result<bool, RunError> {
    let Some(preset) = workloads[0].preset() else { return Ok(true) };
    let scene = Arc::new(generate(preset, preset.points, workloads[0].seed));
    for workload in workloads {
        let names = machines(rows, &workload.name);
        let cameras = workload.cameras(preset);
        let counted: Vec<usize> = (workload.warm_up()..cameras.len()).collect();
        let mut views = render(&workload.name, Arc::clone(&scene), cameras);
        views.allow(memory);
        if !add_frames(&mut *views, &counted, &names, built, watch, all)? {
            return Ok(false);
        }
    }
    Ok(true)
}

/// Takes the frames at `counted` through the machines; returns whether all of them were finished.
fn add_frames(
    frames: &mut dyn Frames,
    counted: &[usize],
    names: &[&MachineName],
    built: &BTreeMap<MachineName, Built>,
    watch: &dyn Watch,
    all: &mut Measurements,
) -> Result<bool, RunError> {
    let source = frames.name().to_owned();
    let systems = names.iter().map(|&name| &built[name].system);
    let subjects: Vec<Subject> = systems.map(|s| Subject::of(s).only(counted)).collect();
    let folded = Session::new(frames, watch).fold(
        &subjects,
        |i| (&built[names[i]], Totals::default()),
        |(built, totals), view: FrameView| {
            totals.add(built.system.machine(), view.tiles(), &view.report);
        },
    )?;
    for (&name, (built, totals)) in names.iter().zip(folded.states) {
        all.insert((source.clone(), name.clone()), built.facts(totals));
    }
    Ok(folded.is_complete)
}

/// The rows that can be measured on any scene: what they compare is a share or a ratio, and no path
/// is needed.
pub fn of_any_scene<'a>(tables: &Tables, rows: &[&'a Row]) -> Vec<&'a Row> {
    let is_still = |row: &Row| {
        let mut mine = tables.workloads.iter().filter(|w| row.workloads.contains(&w.name));
        mine.all(|w| w.path == 0)
    };
    let is_relative = |row: &Row| row.metric.needs_frames() && row.metric.is_relative();
    let keeps = |row: &&&Row| row.status != Status::Dropped && is_relative(row) && is_still(row);
    rows.iter().filter(keeps).copied().collect()
}

/// The values of `rows` on the frames of one source, by row; `None` if the watch cancelled it.
///
/// # Errors
/// [`RunError`]: a frame that cannot be read or takes too much memory, or a defect of the
/// simulator.
///
/// # Panics
/// When `built` lacks a machine.
pub fn measure_on(
    frames: &mut dyn Frames,
    rows: &[&Row],
    built: &BTreeMap<MachineName, Built>,
    watch: &dyn Watch,
) -> Result<Option<Parts>, RunError> {
    let mut names: Vec<&MachineName> =
        rows.iter().flat_map(|row| [Some(&row.machine), row.against.as_ref()]).flatten().collect();
    names.sort();
    names.dedup();
    let counted: Vec<usize> = frames.range().collect();
    let mut all = Measurements::new();
    if !add_frames(frames, &counted, &names, built, watch, &mut all)? {
        return Ok(None);
    }
    let of = |name: &MachineName| all.get(&(frames.name().to_owned(), name.clone()));
    let value = |row: &Row| {
        let against = row.against.as_ref().and_then(of);
        Some((row.id.clone(), row.metric.value(of(&row.machine)?, against)?))
    };
    Ok(Some(rows.iter().filter_map(|row| value(row)).collect()))
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
