//! Machines that differ from one in a single step, and what frames cost on them.

use powergs_base::quantity::Bytes;
use powergs_core::accel::Machine;
use powergs_core::accel::machine::DramModel;
use powergs_core::run::{Change, RunError, System};
use powergs_core::sim::FrameReport;
use powergs_study::findings::what_if::{Cost, Skipped, Step, WhatIf};

/// A resource of a machine: its name, the `--set` values that double it, and the assumptions that
/// decide how fast it is.
type Resource = (&'static str, Vec<String>, &'static [&'static str]);

fn resources(m: &Machine) -> Vec<Resource> {
    let twice = |key: &str, n: u32| format!("{key}={}", u64::from(n) * 2);
    let b = &m.buffers;
    let buffer = |key: &str, spec: &powergs_core::accel::machine::BufferSpec| {
        format!("buffers.{key}.capacity={}", Bytes(spec.capacity.0.saturating_mul(2)))
    };
    let bandwidth = format!("dram.bandwidth={} GB/s", 2.0 * m.dram.bandwidth.0 * 1e-9);
    let mut all: Vec<Resource> = vec![
        (
            "ccu.units, their buffers",
            vec![
                twice("ccu.units", m.ccu.units),
                buffer("gaussian-in", &b.gaussian_in),
                buffer("tile-list", &b.tile_list),
            ],
            &["A1"],
        ),
        (
            "ccu.intersection-units",
            vec![twice("ccu.intersection-units", m.ccu.intersection_units)],
            &["A2"],
        ),
        ("gsu.qsu-per-core", vec![twice("gsu.qsu-per-core", m.gsu.qsu_per_core)], &["A23"]),
        ("gsu.bsu-per-core", vec![twice("gsu.bsu-per-core", m.gsu.bsu_per_core)], &["A25"]),
        ("vru.units-per-core", vec![twice("vru.units-per-core", m.vru.units_per_core)], &["A26"]),
        (
            "vru.cores, their buffers",
            vec![
                twice("vru.cores", m.vru.cores),
                buffer("sorting", &b.sorting),
                buffer("feature", &b.feature),
                buffer("pixel-out", &b.pixel_out),
            ],
            &["A26", "A29"],
        ),
    ];
    all.push(match m.dram.model {
        DramModel::Bandwidth => ("dram.bandwidth", vec![bandwidth], &["A4", "A5"]),
        DramModel::Window | DramModel::Banked => {
            ("dram.channels", vec![twice("dram.channels", m.dram.channels)], &["A41"])
        }
    });
    all.push(("buffers.feature", vec![buffer("feature", &b.feature)], &["A32"]));
    all.push(("buffers.sorting", vec![buffer("sorting", &b.sorting)], &["A24"]));
    all
}

/// The experiment: a machine with each resource doubled, and the frames on which it is tried.
#[derive(Debug, Clone, Default)]
pub struct Experiment {
    resources: Vec<Resource>,
    /// The machines, one per resource that can be doubled.
    pub systems: Vec<System>,
    /// Positions of the frames that are tried.
    pub frames: Vec<usize>,
    skipped: Vec<Skipped>,
}

impl Experiment {
    /// Doubles every resource of `system`, to be tried on these frames.
    pub fn new(system: &System, frames: Vec<usize>) -> Experiment {
        let mut experiment = Experiment { frames, ..Experiment::default() };
        if experiment.frames.is_empty() {
            return experiment;
        }
        for resource in resources(system.machine()) {
            match doubled(system, &resource) {
                Ok(doubled) => {
                    experiment.systems.push(doubled);
                    experiment.resources.push(resource);
                }
                Err(error) => {
                    let reason = error.message();
                    experiment.skipped.push(Skipped { resource: resource.0, reason });
                }
            }
        }
        experiment
    }

    /// What came out; `None` if no frame was tried. `base` has the reports of the machine itself,
    /// `doubled` those of the others on the frames that were tried.
    pub fn finish(self, base: &[FrameReport], doubled: &[Vec<FrameReport>]) -> Option<WhatIf> {
        let tried: Vec<&FrameReport> =
            base.iter().filter(|report| self.frames.contains(&report.frame)).collect();
        if tried.is_empty() {
            return None;
        }
        let n = tried.len() as f64;
        let mean = |reports: &mut dyn Iterator<Item = &FrameReport>| {
            let mut sum = Cost::default();
            for report in reports {
                let cost = Cost::of(report);
                sum.frame_time_ms += cost.frame_time_ms;
                sum.energy_pj += cost.energy_pj;
            }
            Cost { frame_time_ms: sum.frame_time_ms / n, energy_pj: sum.energy_pj / n }
        };
        let step = |(resource, reports): (Resource, &Vec<FrameReport>)| {
            let (resource, sets, assumptions) = resource;
            let cost = mean(&mut reports.iter().take(tried.len()));
            Step { resource, sets, cost, assumptions }
        };
        let steps = self.resources.into_iter().zip(doubled).map(step).collect();
        let frames = tried.iter().map(|report| report.frame).collect();
        Some(WhatIf::new(frames, mean(&mut tried.into_iter()), steps, self.skipped))
    }
}

fn doubled(system: &System, resource: &Resource) -> Result<System, RunError> {
    let changes: Result<Vec<Change>, String> = resource.1.iter().map(|set| set.parse()).collect();
    system.with(&changes.map_err(RunError::Internal)?)
}
