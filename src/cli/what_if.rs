//! Machines that differ from one in a single step, and what frames cost on them.

use super::machine_file::LoadedMachine;
use powergs_base::quantity::Bytes;
use powergs_core::accel::Machine;
use powergs_core::accel::machine::DramModel;
use powergs_core::energy::Prices;
use powergs_core::sim::{self, FrameReport};
use powergs_report::WhatIf;
use powergs_report::what_if::{Cost, Skipped, Step};

/// A machine that differs from another one.
#[derive(Debug, Clone)]
pub struct Variant {
    /// The machine.
    pub machine: Machine,
    /// Its prices.
    pub prices: Prices,
}

impl Variant {
    /// `loaded` with further `--set` values.
    ///
    /// # Errors
    /// Why that is no machine, in one line.
    pub fn of(loaded: &LoadedMachine, sets: &[String]) -> Result<Variant, String> {
        let one_line = |text: String| text.lines().map(str::trim).collect::<Vec<_>>().join(" ");
        let mut machine = Machine::parse_with(&loaded.resolved_toml, sets)
            .map_err(|e| one_line(e.to_string()))?;
        // A device that lies in a file is not read again.
        if let (None, Some(device)) = (&machine.device, &loaded.machine.device) {
            machine.link(device).map_err(|(_, message)| message)?;
        }
        let prices = sim::cost::prices(&loaded.energy_table, &machine);
        let prices = prices.map_err(|e| one_line(e.to_string()))?;
        Ok(Variant { machine, prices })
    }
}

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

/// One resource doubled, as a machine.
#[derive(Debug, Clone)]
pub struct Doubled {
    resource: Resource,
    /// The machine.
    pub variant: Variant,
}

/// The experiment while it runs: machines, and what their frames have cost so far.
#[derive(Debug, Clone, Default)]
pub struct Experiment {
    /// The machines.
    pub doubled: Vec<Doubled>,
    /// Frames that are to be tried.
    wanted: Vec<usize>,
    skipped: Vec<Skipped>,
    done: Vec<usize>,
    base: Cost,
    costs: Vec<Cost>,
}

impl Experiment {
    /// Doubles every resource of `loaded`, to be tried on these frames.
    pub fn new(loaded: &LoadedMachine, wanted: Vec<usize>) -> Experiment {
        let mut experiment = Experiment { wanted, ..Experiment::default() };
        if experiment.wanted.is_empty() {
            return experiment;
        }
        for resource in resources(&loaded.machine) {
            match Variant::of(loaded, &resource.1) {
                Ok(variant) => experiment.doubled.push(Doubled { resource, variant }),
                Err(reason) => experiment.skipped.push(Skipped { resource: resource.0, reason }),
            }
        }
        experiment.costs = vec![Cost::default(); experiment.doubled.len()];
        experiment
    }

    /// Whether this frame is to be tried.
    pub fn wants(&self, frame: usize) -> bool {
        self.wanted.contains(&frame)
    }

    /// Adds a frame: its report on the machine itself, and on each of the others.
    pub fn add(&mut self, base: &FrameReport, others: &[Cost]) {
        self.done.push(base.frame);
        accumulate(&mut self.base, cost(base));
        for (sum, other) in self.costs.iter_mut().zip(others) {
            accumulate(sum, *other);
        }
    }

    /// What came out; `None` if no frame was tried.
    pub fn finish(self) -> Option<WhatIf> {
        let n = self.done.len() as f64;
        if self.done.is_empty() {
            return None;
        }
        let mean =
            |sum: Cost| Cost { frame_time_ms: sum.frame_time_ms / n, energy_pj: sum.energy_pj / n };
        let step = |(doubled, sum): (Doubled, Cost)| {
            let (resource, sets, assumptions) = doubled.resource;
            Step { resource, sets, cost: mean(sum), assumptions }
        };
        let steps = self.doubled.into_iter().zip(self.costs).map(step).collect();
        Some(WhatIf::new(self.done, mean(self.base), steps, self.skipped))
    }
}

/// What a frame costs.
pub fn cost(report: &FrameReport) -> Cost {
    Cost {
        frame_time_ms: report.frame_time_s().unwrap_or(0.0) * 1e3,
        energy_pj: report.energy.total().0,
    }
}

fn accumulate(sum: &mut Cost, other: Cost) {
    sum.frame_time_ms += other.frame_time_ms;
    sum.energy_pj += other.energy_pj;
}
