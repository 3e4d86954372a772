//! Machines that differ from one in a single resource, which they have twice, and what frames cost
//! on them.

use powergs_base::quantity::Bytes;
use powergs_core::accel::Machine;
use powergs_core::accel::machine::{BufferSpec, DramModel, Fetch};
use powergs_core::run::{Change, RunError, System};
use powergs_core::sim::FrameReport;

use crate::findings::cost::Cost;
use crate::findings::what_if::{Skipped, Step, WhatIf};

/// A resource of a machine.
struct Resource {
    name: &'static str,
    /// The `--set` values that double it.
    sets: Vec<String>,
    /// The assumptions that decide how fast it is.
    assumptions: &'static [&'static str],
}

fn resources(m: &Machine) -> Vec<Resource> {
    let twice = |key: &str, n: u32| format!("{key}={}", u64::from(n) * 2);
    let b = &m.buffers;
    let buffer = |key: &str, spec: &BufferSpec| {
        format!("buffers.{key}.capacity={}", Bytes(spec.capacity.0.saturating_mul(2)))
    };
    let resource = |name, sets, assumptions| Resource { name, sets, assumptions };
    let dram = match m.dram.bandwidth {
        Some(rate) if !m.dram.has_device() => {
            let doubled = format!("dram.bandwidth={} GB/s", 2.0 * rate.0 * 1e-9);
            resource("dram.bandwidth", vec![doubled], &["A4", "A5"])
        }
        _ => {
            let assumptions: &[&str] = match m.dram.model {
                DramModel::Bandwidth => &["A4", "A5"],
                DramModel::Calibrated | DramModel::Banked => &["A41"],
            };
            resource("dram.channels", vec![twice("dram.channels", m.dram.channels)], assumptions)
        }
    };
    let mut all = vec![
        resource(
            "ccu.units, their buffers",
            vec![
                twice("ccu.units", m.ccu.units),
                buffer("gaussian-in", &b.gaussian_in),
                buffer("tile-list", &b.tile_list),
            ],
            &["A1"],
        ),
        resource(
            "ccu.intersection-units",
            vec![twice("ccu.intersection-units", m.ccu.intersection_units)],
            &["A2"],
        ),
        resource("gsu.qsu-per-core", vec![twice("gsu.qsu-per-core", m.gsu.qsu_per_core)], &["A23"]),
        resource("gsu.bsu-per-core", vec![twice("gsu.bsu-per-core", m.gsu.bsu_per_core)], &["A25"]),
        resource(
            "vru.units-per-core",
            vec![twice("vru.units-per-core", m.vru.units_per_core)],
            &["A84"],
        ),
        resource(
            "vru.cores, their buffers",
            vec![
                twice("vru.cores", m.vru.cores),
                buffer("sorting", &b.sorting),
                buffer("feature", &b.feature),
                buffer("pixel-out", &b.pixel_out),
            ],
            &["A84", "A29"],
        ),
        dram,
        resource("buffers.feature", vec![buffer("feature", &b.feature)], &["A32"]),
        resource("buffers.sorting", vec![buffer("sorting", &b.sorting)], &["A24"]),
    ];
    if m.ccu.fetch == Fetch::LazyColour {
        let key = "vru.colour-operations-per-cycle";
        let twice = twice(key, m.vru.colour_operations_per_cycle);
        all.push(resource(key, vec![twice], &["A103"]));
    }
    all
}

/// A machine with each of its resources doubled.
#[derive(Default)]
pub(super) struct Doubling {
    /// The machines, one for each resource that can be doubled.
    pub(super) systems: Vec<System>,
    resources: Vec<Resource>,
    skipped: Vec<Skipped>,
}

impl Doubling {
    /// Doubles every resource of `system`.
    pub(super) fn of(system: &System) -> Doubling {
        let mut all = Doubling::default();
        for resource in resources(system.machine()) {
            match doubled(system, &resource) {
                Ok(doubled) => {
                    all.systems.push(doubled);
                    all.resources.push(resource);
                }
                Err(error) => {
                    let reason = error.message();
                    all.skipped.push(Skipped { resource: resource.name, reason });
                }
            }
        }
        all
    }

    /// What came out on the frames at these positions; `None` if none of them was done. `base` has
    /// the reports of the machine itself, `doubled` those of the others on these frames.
    pub(super) fn finish(
        self,
        positions: &[usize],
        base: &[FrameReport],
        doubled: &[Vec<FrameReport>],
        display_fps: f64,
    ) -> Option<WhatIf> {
        let tried: Vec<&FrameReport> =
            base.iter().filter(|report| positions.contains(&report.frame)).collect();
        if tried.is_empty() {
            return None;
        }
        let n = tried.len();
        let step = |(resource, reports): (Resource, &Vec<FrameReport>)| Step {
            resource: resource.name,
            sets: resource.sets,
            cost: Cost::of_frames(reports.iter().take(n), display_fps),
            assumptions: resource.assumptions,
        };
        let steps = self.resources.into_iter().zip(doubled).map(step).collect();
        let frames = tried.iter().map(|report| report.frame).collect();
        let base = Cost::of_frames(tried, display_fps);
        Some(WhatIf::new(frames, base, steps, self.skipped))
    }
}

fn doubled(system: &System, resource: &Resource) -> Result<System, RunError> {
    let changes: Result<Vec<Change>, String> = resource.sets.iter().map(|s| s.parse()).collect();
    system.with(&changes.map_err(RunError::Internal)?)
}
