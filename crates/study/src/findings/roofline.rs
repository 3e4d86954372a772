//! The roofline: operations per DRAM byte against operations per second, each stage under the roof
//! of its own units.

use crate::run_record::Run;
use powergs_core::accel::bsu::network;
use powergs_core::accel::machine::{Fetch, Overlap};
use powergs_core::run::System;
use powergs_energy::action::{Action, Stage};
use powergs_energy::flops;

/// What a machine could do at most, and what its actions count.
#[derive(Debug, Clone, PartialEq)]
pub struct Roofline {
    /// Operations of each action, by [`Action::index`]: floating-point operations as PowerGS counts
    /// them, a colour being of SH degree 3, and comparisons of the sorting units.
    pub operations: [u32; Action::COUNT],
    /// The units that work for each stage, in the order of [`Stage::WORK`]: name, and operations
    /// per second when all of them are busy.
    pub units: [(&'static str, f64); Stage::WORK.len()],
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
    pub stage: Option<Stage>,
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
    /// Peaks of a machine. A CCU takes a Gaussian through everything each interval and makes its
    /// box tests beside that; a QSU compares its keys with all pivots each cycle, a BSU works in
    /// its whole network; a rendering unit evaluates and blends a pixel each cycle.
    pub fn of(system: &System) -> Roofline {
        let machine = system.machine();
        let (ccu, gsu, vru) = (&machine.ccu, &machine.gsu, &machine.vru);
        let mut operations = flops::per_action();
        operations[Action::PivotKey.index()] = gsu.pivots;
        operations[Action::CompareExchange.index()] = 1;
        let sum = |actions: &[Action]| -> f64 {
            actions.iter().map(|a| f64::from(operations[a.index()])).sum()
        };
        // Where colours are read late, colour units of the cores evaluate them.
        let colour = f64::from(operations[Action::ShColour.index()]);
        let one = f64::from(ccu.operations.sh_colour.max(1));
        let (in_ccu, in_core) = match ccu.fetch {
            Fetch::LazyColour => (0.0, colour * f64::from(vru.colour_operations_per_cycle) / one),
            Fetch::Everything | Fetch::GeometryFirst | Fetch::VisibleColour => (colour, 0.0),
        };
        let gaussian = [Action::Cull, Action::Project, Action::ObbPrepare];
        let per_ccu = (sum(&gaussian) + in_ccu) * ccu.gaussians_per_cycle()
            + sum(&[Action::ObbTest]) * f64::from(ccu.intersection_units);
        let cores = f64::from(vru.cores);
        let per_qsu = f64::from(gsu.keys_per_cycle) * sum(&[Action::PivotKey]);
        let per_gsu = f64::from(gsu.qsu_per_core) * per_qsu
            + f64::from(gsu.bsu_per_core) * network(gsu.bsu_width) as f64;
        let pixels = f64::from(vru.units_per_core) * sum(&[Action::Alpha, Action::Blend]);
        let per_core = pixels + in_core;
        let clock = machine.clock.0;
        let units = [
            ("CCU", clock * f64::from(ccu.units) * per_ccu),
            ("GSU", clock * cores * per_gsu),
            ("VRU", clock * cores * per_core),
        ];
        let overlaps = machine.schedule.overlap != Overlap::None;
        Roofline { operations, units, dram_bytes_s: system.dram_peak(), overlaps }
    }

    /// Stages with operations and the whole frame, over all frames of `run`.
    pub fn points(&self, run: &Run) -> Vec<Point> {
        let (mut flops, mut bytes) = ([0.0; 3], [0.0; 3]);
        let mut by_unit = [[0.0; 3]; 3];
        let (mut first, mut all) = (0.0, 0.0);
        for frame in &run.frames {
            let Some(cycle) = frame.cycle() else { return Vec::new() };
            let (timing, clock) = (&cycle.timing, cycle.clock.0);
            let colour = flops::colour_share(frame.colour_degree());
            first += timing.preprocessing_end as f64 / clock;
            all += timing.frame as f64 / clock;
            for (i, stage) in Stage::WORK.into_iter().enumerate() {
                bytes[i] += (frame.stages[i].read + frame.stages[i].write) as f64;
                for action in Action::all() {
                    let Some(unit) = unit(action, stage) else { continue };
                    let n = frame.actions.count(stage, action) as f64;
                    let n = if action == Action::ShColour { n * colour } else { n };
                    let operations = n * f64::from(self.operations[action.index()]);
                    flops[i] += operations;
                    by_unit[i][unit] += operations;
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
        let peaks = self.units.map(|unit| unit.1);
        let busy = by_unit.map(|operations: [f64; 3]| {
            operations.iter().zip(peaks).map(|(n, peak)| n / peak).fold(0.0, f64::max)
        });
        let seconds = match self.overlaps {
            false => [first, all - first, all - first],
            true => [all; 3],
        };
        let mut points: Vec<Point> = (0..3)
            .map(|i| point(Some(Stage::WORK[i]), flops[i], bytes[i], seconds[i], busy[i]))
            .collect();
        let tiles = busy[1].max(busy[2]);
        let whole = if self.overlaps { busy[0].max(tiles) } else { busy[0] + tiles };
        points.push(point(None, flops.iter().sum(), bytes.iter().sum(), all, whole));
        points.retain(|p| {
            let drawn = |x: f64| x.is_finite() && x > 0.0;
            drawn(p.flop_per_byte) && drawn(p.flop_s) && drawn(p.roof_flop_s)
        });
        points
    }
}

/// Which units do an action in a stage: place in [`Stage::WORK`].
fn unit(action: Action, stage: Stage) -> Option<usize> {
    match action {
        Action::ShColour if stage == Stage::Rendering => Some(2),
        Action::Cull
        | Action::Project
        | Action::ObbPrepare
        | Action::ObbTest
        | Action::ShColour => Some(0),
        Action::PivotKey | Action::CompareExchange | Action::SortedRow | Action::MergedRow => {
            Some(1)
        }
        Action::Alpha
        | Action::StoppedPixel
        | Action::Blend
        | Action::PixelFinish
        | Action::QueueEntry => Some(2),
        Action::Clock(_)
        | Action::IdleClock(_)
        | Action::DramRead
        | Action::DramWrite
        | Action::SramRead(_)
        | Action::SramWrite(_) => None,
    }
}

impl Point {
    /// What it is called: the stage, or `frame`.
    pub fn name(&self) -> &'static str {
        self.stage.map_or("frame", Stage::name)
    }

    /// How much of its roof it attains, 0 to 1.
    pub fn attained(&self) -> f64 {
        self.flop_s / self.roof_flop_s
    }
}
