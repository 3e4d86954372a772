//! Several machines over several traces, relative to one of them: speed and energy, with their
//! geometric means.

use crate::findings::compare::{Comparison, Measure};

/// What a machine does on a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Speed {
    /// Frames per second, back to back.
    pub fps: f64,
    /// Energy of a frame, joules.
    pub energy_j: f64,
}

/// A machine on all traces.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct MachineSpeed {
    /// What it is called.
    pub label: String,
    /// What it does on each trace, where that was measured.
    pub speeds: Vec<Option<Speed>>,
    /// Whether it has each gain, in the order of [`Gain::ALL`]: joules of another technology node
    /// are not held against those of the first machine, nor is anything of another task.
    pub is_comparable: [bool; Gain::ALL.len()],
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gain {
    /// Frame rate over that of the first machine.
    Speed,
    /// Energy per frame of the first machine over that of this one.
    Energy,
}

impl Gain {
    /// All of them, as papers have them.
    pub const ALL: [Gain; 2] = [Gain::Speed, Gain::Energy];

    /// What it is the ratio of.
    const fn measure(self) -> Measure {
        match self {
            Gain::Speed => Measure::Throughput,
            Gain::Energy => Measure::Energy,
        }
    }
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
                Some(Speed { fps: fps?, energy_j: mj? * 1e-3 })
            };
            let is_comparable =
                Gain::ALL.map(|gain| all.iter().all(|c| c.row(gain.measure()).is_comparable[i]));
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
            _ if !self.machines[m].is_comparable[gain as usize] => return None,
            Gain::Speed => own.fps / first.fps,
            Gain::Energy => first.energy_j / own.energy_j,
        };
        Some(ratio).filter(|r| r.is_finite() && *r > 0.0)
    }

    /// The least and the largest over all traces; `None` if one is missing.
    pub fn spread(&self, gain: Gain, m: usize) -> Option<[f64; 2]> {
        let all: Option<Vec<f64>> = (0..self.traces.len()).map(|t| self.gain(gain, m, t)).collect();
        let all = all?;
        Some([
            all.iter().copied().fold(f64::INFINITY, f64::min),
            all.iter().copied().fold(0.0, f64::max),
        ])
    }

    /// The geometric standard deviation over all traces, of which the logarithms are a sample: a
    /// factor, 1 where all are the same; `None` if one is missing, and for a single trace.
    pub fn deviation(&self, gain: Gain, m: usize) -> Option<f64> {
        let mean = self.mean(gain, m)?.ln();
        let n = self.traces.len();
        let square = |t: usize| Some((self.gain(gain, m, t)?.ln() - mean).powi(2));
        let sum = (0..n).map(square).sum::<Option<f64>>()?;
        (n > 1).then(|| (sum / (n - 1) as f64).sqrt().exp())
    }

    /// The geometric mean over all traces; `None` if one is missing.
    pub fn mean(&self, gain: Gain, m: usize) -> Option<f64> {
        let logs: Option<Vec<f64>> =
            (0..self.traces.len()).map(|t| self.gain(gain, m, t).map(f64::ln)).collect();
        let logs = logs?;
        Some((logs.iter().sum::<f64>() / logs.len() as f64).exp())
    }
}
