//! The roofline: operations per DRAM byte against operations per second, each stage under the roof
//! of its own units.

use crate::run_record::Run;
use powergs_core::flow::gpu::KernelPart;
use powergs_core::flow::steps::StepPart;
use powergs_core::run::System;
use powergs_core::stage::{StageDecl, WorkDecl, hardware, stages};
use powergs_energy::action::Phase;
use powergs_energy::flops;
use powergs_energy::hardware::Does;

/// What a machine could do at most, and what its actions count.
#[derive(Debug, Clone, PartialEq)]
pub struct Roofline {
    /// Operations of each action, by [`ActionId`](powergs_energy::action::ActionId):
    /// floating-point operations as PowerGS counts them, a colour being of SH degree 3, and
    /// comparisons of units that make those.
    pub operations: Vec<u32>,
    /// The units that work in each phase, in the order of [`Phase::WORK`]: their names, and
    /// operations per second when all of them are busy.
    pub units: [(String, f64); Phase::WORK.len()],
    /// Peak DRAM rate, bytes per second.
    pub dram_bytes_s: f64,
    /// Whether preprocessing runs beside the other stages.
    pub overlaps: bool,
}

/// What keeps a point below.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Roof {
    /// The units of its stage; of the frame those of all stages, one phase after the other.
    Units,
    /// The DRAM.
    Dram,
}

impl Roof {
    /// The name in every output.
    pub const fn name(self) -> &'static str {
        match self {
            Roof::Units => "units",
            Roof::Dram => "dram",
        }
    }
}

/// One stage, or the whole frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// The stage; `None` for the whole frame.
    pub stage: Option<Phase>,
    /// Operations per byte read from or written to DRAM.
    pub flop_per_byte: f64,
    /// Operations per second: of a stage over its phase, of the frame over the frame.
    pub flop_s: f64,
    /// The most that its own units and the DRAM allow at this intensity, operations per second.
    pub roof_flop_s: f64,
    /// Which of the two that is.
    pub roof: Roof,
}

impl Roofline {
    /// Peaks of a machine: what its units do at most in a cycle, in operations.
    pub fn of(system: &System) -> Roofline {
        let machine = system.machine();
        let works: Vec<(&WorkDecl, bool)> = (stages().iter())
            .flat_map(|stage| stage.works.iter().map(|w| (w, machine.has_stage(stage.key))))
            .collect();
        let of_work = |key: &str| {
            let work = works.iter().find(|(work, _)| work.facts.key == key);
            work.map_or(0, |(w, has)| match w.comparisons.filter(|_| *has) {
                Some(of) => of(machine),
                None => w.facts.flops,
            })
        };
        let operations = hardware().actions().map(|(_, does)| match does {
            Does::Work(_, work) => of_work(work.key),
            _ => 0,
        });
        let units = Phase::WORK.map(|phase| {
            // Where units of one stage do the work of every phase, they are its units in each.
            let own = machine.flow().stages();
            let is_apart = own.iter().any(|s| s.phase == phase && s.units.is_some());
            let mine = stages().iter().filter(|s| s.phase == phase || !is_apart);
            let mine = mine.filter(|s| s.count(machine) > 0);
            let peak = |stage: &&&StageDecl| -> f64 {
                let one = stage.a_cycle(machine).map(|(key, n)| n * f64::from(of_work(key)));
                one.sum::<f64>() * f64::from(stage.count(machine)) * machine.clock.0
            };
            let names: Vec<String> = mine.clone().map(|stage| stage.key.to_uppercase()).collect();
            (names.join(" + "), mine.map(|stage| peak(&stage)).sum())
        });
        Roofline {
            operations: operations.collect(),
            units,
            dram_bytes_s: system.dram_peak(),
            overlaps: machine.flow().overlaps(machine),
        }
    }

    /// Stages with operations and the whole frame, over all frames of `run`.
    pub fn points(&self, run: &Run) -> Vec<Point> {
        let (mut flops, mut bytes) = ([0.0; 3], [0.0; 3]);
        let (mut first, mut all) = (0.0, 0.0);
        let mut of_kernels = [0.0; 3];
        for frame in &run.frames {
            let Some(cycle) = frame.cycle() else { return Vec::new() };
            let (timing, clock) = (&cycle.timing, cycle.clock.0);
            let colour = flops::colour_share(frame.colour_degree());
            // Gradients by parameters and the update are of the first phase, and come last.
            let late = [StepPart::Chain, StepPart::Update];
            let late: u64 = late.iter().filter_map(|part| cycle.measured.count(part.time())).sum();
            first += (timing.preprocessing_end + late) as f64 / clock;
            all += timing.frame as f64 / clock;
            // Where a machine is a GPU, kernels say which phase it is in.
            let is_gpu = cycle.measured.get(KernelPart::Convert.time()).is_some();
            for part in KernelPart::ALL.into_iter().filter(|_| is_gpu) {
                let cycles = cycle.measured.count(part.time()).unwrap_or(0);
                of_kernels[part.phase() as usize] += cycles as f64 / clock;
            }
            for (i, stage) in Phase::WORK.into_iter().enumerate() {
                bytes[i] += (frame.stages[i].read + frame.stages[i].write) as f64;
                for (action, does) in hardware().actions() {
                    let is_colour = matches!(does, Does::Work(_, work) if work.is_colour);
                    let n = frame.actions.count(stage, action) as f64;
                    let n = if is_colour { n * colour } else { n };
                    flops[i] += n * f64::from(self.operations[action.index()]);
                }
            }
        }
        let point = |stage, flops: f64, bytes: f64, seconds: f64, busy: f64| {
            let dram = bytes / self.dram_bytes_s;
            Point {
                stage,
                flop_per_byte: flops / bytes,
                flop_s: flops / seconds,
                roof_flop_s: flops / busy.max(dram),
                roof: if dram > busy { Roof::Dram } else { Roof::Units },
            }
        };
        // The least time that the units take for the operations of a stage.
        let least = |i: usize| if flops[i] > 0.0 { flops[i] / self.units[i].1 } else { 0.0 };
        let busy: [f64; 3] = std::array::from_fn(least);
        // Kernels follow each other; other machines sort and render at the same time.
        let in_turn = of_kernels.iter().sum::<f64>() > 0.0;
        let seconds = match self.overlaps {
            false if in_turn => of_kernels,
            false => [first, all - first, all - first],
            true => [all; 3],
        };
        let mut points: Vec<Point> = (0..3)
            .map(|i| point(Some(Phase::WORK[i]), flops[i], bytes[i], seconds[i], busy[i]))
            .collect();
        let tiles = if in_turn { busy[1] + busy[2] } else { busy[1].max(busy[2]) };
        let whole = if self.overlaps { busy[0].max(tiles) } else { busy[0] + tiles };
        points.push(point(None, flops.iter().sum(), bytes.iter().sum(), all, whole));
        points.retain(|p| {
            let drawn = |x: f64| x.is_finite() && x > 0.0;
            drawn(p.flop_per_byte) && drawn(p.flop_s) && drawn(p.roof_flop_s)
        });
        points
    }
}

impl Point {
    /// What it is called: the stage, or `frame`.
    pub fn name(&self) -> &'static str {
        self.stage.map_or("frame", Phase::name)
    }

    /// How much of its roof it attains, 0 to 1.
    pub fn attained(&self) -> f64 {
        self.flop_s / self.roof_flop_s
    }
}
