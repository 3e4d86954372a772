//! The roofline: floating-point operations per DRAM byte against operations per second.

use crate::run_record::Run;
use powergs_core::action::{Action, Stage};
use powergs_core::energy::flops;
use powergs_core::run::System;

/// What a machine could do at most, and what its actions count.
#[derive(Debug, Clone, PartialEq)]
pub struct Roofline {
    /// Floating-point operations of each action, by [`Action::index`]; of a colour of SH degree 3.
    pub flops: [u32; Action::COUNT],
    /// Units with arithmetic: name and peak, operations per second.
    pub ceilings: Vec<(&'static str, f64)>,
    /// Peak DRAM rate, bytes per second.
    pub dram_bytes_s: f64,
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
}

impl Roofline {
    /// Peaks of a machine in the operations that PowerGS counts. A CCU takes a Gaussian through
    /// everything each interval and makes its box tests beside that; a rendering unit evaluates and
    /// blends a pixel each cycle. Sorting counts no operations.
    pub fn of(system: &System) -> Roofline {
        let machine = system.machine();
        let flops = flops::per_action();
        let sum =
            |actions: &[Action]| f64::from(actions.iter().map(|a| flops[a.index()]).sum::<u32>());
        let (ccu, vru) = (&machine.ccu, &machine.vru);
        let gaussian = [Action::Cull, Action::Project, Action::ObbPrepare, Action::ShColour];
        let per_ccu = sum(&gaussian) / f64::from(ccu.initiation_interval)
            + sum(&[Action::ObbTest]) * f64::from(ccu.intersection_units);
        let lanes = f64::from(vru.cores) * f64::from(vru.units_per_core);
        let ceilings = vec![
            ("CCU", machine.clock.0 * f64::from(ccu.units) * per_ccu),
            ("VRU", machine.clock.0 * lanes * sum(&[Action::Alpha, Action::Blend])),
        ];
        Roofline { flops, ceilings, dram_bytes_s: system.dram_peak() }
    }

    /// All units together, operations per second.
    pub fn peak_flop_s(&self) -> f64 {
        self.ceilings.iter().map(|c| c.1).sum()
    }

    /// Stages with arithmetic and the whole frame, over all frames of `run`.
    pub fn points(&self, run: &Run) -> Vec<Point> {
        let (mut flops, mut bytes) = ([0.0; 3], [0.0; 3]);
        let (mut first, mut all) = (0.0, 0.0);
        for frame in &run.frames {
            let Some(cycle) = frame.cycle() else { return Vec::new() };
            let (timing, clock) = (&cycle.timing, cycle.clock.0);
            let colour = flops::colour_share(frame.colour_degree());
            first += timing.preprocessing_end as f64 / clock;
            all += timing.frame as f64 / clock;
            for (i, stage) in Stage::WORK.into_iter().enumerate() {
                bytes[i] += (frame.stages[i].read + frame.stages[i].write) as f64;
                let count = |a: Action| {
                    let n = frame.actions.count(stage, a) as f64;
                    if a == Action::ShColour { n * colour } else { n }
                };
                flops[i] += Action::all()
                    .into_iter()
                    .map(|a| count(a) * f64::from(self.flops[a.index()]))
                    .sum::<f64>();
            }
        }
        let point = |stage, flops: f64, bytes: f64, seconds: f64| Point {
            stage,
            flop_per_byte: flops / bytes,
            flop_s: flops / seconds,
        };
        let seconds = [first, all - first, all - first];
        let mut points: Vec<Point> =
            (0..3).map(|i| point(Some(Stage::WORK[i]), flops[i], bytes[i], seconds[i])).collect();
        points.push(point(None, flops.iter().sum(), bytes.iter().sum(), all));
        points.retain(|p| {
            let drawn = |x: f64| x.is_finite() && x > 0.0;
            drawn(p.flop_per_byte) && drawn(p.flop_s)
        });
        points
    }
}

impl Point {
    /// What it is called: the stage, or `frame`.
    pub fn name(&self) -> &'static str {
        self.stage.map_or("frame", Stage::name)
    }
}
