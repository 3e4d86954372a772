//! Several machines over several traces, relative to one of them: speed, speed per area and energy,
//! with their geometric means.

use crate::findings::compare::{Comparison, Measure};

/// What a machine does on a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Speed {
    /// Frames per second, back to back.
    pub fps: f64,
    /// Energy of a frame, joules.
    pub energy_j: f64,
    /// Frames per second and mm² of the die without PHY and controllers, as papers count it; `None`
    /// where the area is not known.
    pub fps_per_mm2: Option<f64>,
}

/// A machine on all traces.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MachineSpeed {
    /// What it is called.
    pub label: String,
    /// What it does on each trace, where that was measured.
    pub speeds: Vec<Option<Speed>>,
    /// Whether its joules and mm² may be held against those of the first machine: not those of
    /// another technology node.
    pub is_comparable: bool,
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gain {
    /// Frame rate over that of the first machine.
    Speed,
    /// Frame rate per mm² over that of the first machine.
    Area,
    /// Energy per frame of the first machine over that of this one.
    Energy,
}

impl Gain {
    /// All of them, as papers have them.
    pub const ALL: [Gain; 3] = [Gain::Speed, Gain::Area, Gain::Energy];
}

/// Machines over traces; the first machine is what the others are compared with.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SpeedUp {
    /// Names of the traces.
    pub traces: Vec<String>,
    /// The machines.
    pub machines: Vec<MachineSpeed>,
}

impl SpeedUp {
    /// `None` unless there are two traces and two machines.
    pub fn new(traces: Vec<String>, machines: Vec<MachineSpeed>) -> Option<SpeedUp> {
        (traces.len() > 1 && machines.len() > 1).then_some(SpeedUp { traces, machines })
    }

    /// From comparisons of the same machines, one a trace. Traces of one name are numbered.
    pub fn of_comparisons(all: &[Comparison]) -> Option<SpeedUp> {
        let names: Vec<&str> = all.iter().map(|c| c.sides[0].trace.as_str()).collect();
        let is_alone = |name: &str| names.iter().filter(|other| **other == name).count() == 1;
        let numbered = |(i, name): (usize, &&str)| match is_alone(name) {
            true => (*name).to_owned(),
            false => format!("{name}-{}", i + 1),
        };
        let traces = names.iter().enumerate().map(numbered).collect();
        let machine = |(i, label): (usize, String)| {
            let speed = |c: &Comparison| {
                let value = |measure| *c.row(measure).values.get(i)?;
                let (fps, mj): (Option<f64>, Option<f64>) =
                    (value(Measure::Throughput), value(Measure::Energy));
                let area: Option<f64> = value(Measure::AreaCore);
                let fps_per_mm2 = fps.zip(area).map(|(fps, mm2)| fps / mm2);
                Some(Speed { fps: fps?, energy_j: mj? * 1e-3, fps_per_mm2 })
            };
            let is_comparable = all.iter().all(|c| c.row(Measure::Energy).is_comparable[i]);
            MachineSpeed { label, speeds: all.iter().map(speed).collect(), is_comparable }
        };
        let labels = all.first()?.labels_with_nodes();
        let machines = labels.into_iter().enumerate().map(machine).collect();
        SpeedUp::new(traces, machines)
    }

    /// The gain of machine `m` on trace `t`.
    pub fn gain(&self, gain: Gain, m: usize, t: usize) -> Option<f64> {
        let (first, own) = (self.machines[0].speeds[t]?, self.machines[m].speeds[t]?);
        let ratio = match gain {
            Gain::Speed => own.fps / first.fps,
            Gain::Energy | Gain::Area if !self.machines[m].is_comparable => return None,
            Gain::Area => own.fps_per_mm2? / first.fps_per_mm2?,
            Gain::Energy => first.energy_j / own.energy_j,
        };
        Some(ratio).filter(|r| r.is_finite() && *r > 0.0)
    }

    /// The geometric mean over all traces; `None` if one is missing.
    pub fn mean(&self, gain: Gain, m: usize) -> Option<f64> {
        let logs: Option<Vec<f64>> =
            (0..self.traces.len()).map(|t| self.gain(gain, m, t).map(f64::ln)).collect();
        let logs = logs?;
        Some((logs.iter().sum::<f64>() / logs.len() as f64).exp())
    }
}
