//! Counts of a run that its machine cannot reach: a counter that wrapped, a unit that the machine
//! file leaves out, another unit of the numbers.

use super::{PartAmount, RecordedFrame, RecordedRun, RecordedSpec};
use crate::stage::hardware;
use powergs_energy::action::{ActionId, StageId};
use powergs_energy::hardware::Does;

impl RecordedRun {
    /// What is odd about a run of this machine, though it can be read: the first count above what
    /// units and banks do in the cycles of its frame, and how many more there are.
    pub fn doubt(&self, machine: &RecordedSpec) -> Option<String> {
        let mut all = self.frames.iter().flat_map(|(id, frame)| {
            let actions = totals(frame).into_iter();
            actions.filter_map(move |(action, n)| {
                let most = most(action, machine, frame.cycles)?;
                (n as f64 > most).then_some((*id, frame.cycles, action, n, most))
            })
        });
        let (id, cycles, action, n, most) = all.next()?;
        let more = match all.count() {
            0 => String::new(),
            more => format!(" ({more} more such counts)"),
        };
        Some(format!(
            "{}: frame {id:016x} has `{}` = {n}, and the units and banks of the machine file do at \
             most {most} in its {cycles} cycles{more}: a counter that wrapped, or fewer units than \
             the machine has?",
            machine.file,
            hardware().key(action)
        ))
    }
}

/// How often everything happened in a frame, in all phases.
fn totals(frame: &RecordedFrame) -> Vec<(ActionId, u64)> {
    let mut totals: Vec<(ActionId, u64)> = Vec::new();
    for (&(_, action), &n) in &frame.counts {
        match totals.iter_mut().find(|(known, _)| *known == action) {
            Some((_, total)) => *total += n,
            None => totals.push((action, n)),
        }
    }
    totals
}

/// How often an action happens at most in `cycles`; `None` where the machine file does not
/// say what a unit does in one.
fn most(action: ActionId, machine: &RecordedSpec, cycles: u64) -> Option<f64> {
    let (hardware, cycles) = (hardware(), cycles as f64);
    match hardware.does(action) {
        Does::Work(stage, work) => {
            let doers = hardware.doers(stage, work.key);
            let rates: Option<Vec<f64>> = doers.map(|unit| rate(unit, machine)).collect();
            Some(rates?.into_iter().sum::<f64>() * cycles)
        }
        Does::SramRead(buffer) | Does::SramWrite(buffer) => {
            // Reads and writes each for themselves, whatever the ports: a wrapped counter is far
            // beyond either.
            let spec = machine.buffers.get(&hardware.buffer(buffer).key())?;
            Some(spec.word.0 as f64 * f64::from(spec.banks) * cycles)
        }
        Does::Clock(_) | Does::IdleClock(_) | Does::DramRead | Does::DramWrite => None,
    }
}

/// How often all units of a stage do something in a cycle: each of their parts once; `None` for
/// units of which no parts are known.
fn rate(unit: StageId, machine: &RecordedSpec) -> Option<f64> {
    let Some(spec) = machine.units.get(hardware().stage(unit).key) else { return Some(0.0) };
    let parts: f64 = spec.parts.values().map(|PartAmount(amount)| amount.max(1.0)).sum();
    (parts > 0.0).then_some(parts * f64::from(spec.count))
}
