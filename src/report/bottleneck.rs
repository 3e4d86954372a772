//! One sentence that says what limits the frame, from where the cycles went.

use super::{Run, Table};
use crate::accel::{Stall, UnitCycles};
use crate::report::format::percent;

/// What to make faster first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// A kind of unit, by name (`vru`).
    Unit(&'static str),
    /// The bandwidth or the latency of the DRAM.
    Dram,
}

/// What limits a run, and the sentence that says why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bottleneck {
    /// What to make faster first.
    pub limit: Limit,
    /// The reason, for people.
    pub sentence: String,
}

/// A DRAM bus that is busy for more than this share of the frame is the limit whatever else waits.
const BUS_FULL: f64 = 0.85;

/// Cycles of one kind of unit, summed over frames.
struct Sums {
    unit: &'static str,
    instances: u64,
    busy: u64,
    stalls: [u64; Stall::ALL.len()],
}

/// The bottleneck of `run`; `None` in a model without time, or without frames.
///
/// Lists are complete only when the last Gaussian is binned, so a frame has two phases. The longer
/// one decides: the unit that is busiest in it limits, unless the DRAM bus is full or that unit
/// waits for DRAM longer than it works.
pub fn of(run: &Run, table: &Table) -> Option<Bottleneck> {
    let timings: Vec<_> = run.frames.iter().map(|f| f.timing.as_ref()).collect::<Option<_>>()?;
    let all: u64 = timings.iter().map(|t| t.frame).sum();
    if all == 0 {
        return None;
    }
    let before: u64 = timings.iter().map(|t| t.preprocessing_end).sum();
    let bus = table.sum("dram.busy_cycles")? / all as f64;
    if bus > BUS_FULL {
        return Some(full_bus(bus));
    }
    let (phase, cycles, first) = if 2 * before > all {
        ("preprocessing takes", before, true)
    } else {
        ("sorting and rendering take", all - before, false)
    };
    let in_phase = |u: &&UnitCycles| (u.unit == "ccu") == first;
    let mut units: Vec<Sums> = Vec::new();
    for u in timings.iter().flat_map(|t| t.units.iter().filter(in_phase)) {
        add(&mut units, u);
    }
    let share = |n: u64, u: &Sums| n as f64 / (u.instances * cycles) as f64;
    let busiest = units.iter().max_by(|a, b| share(a.busy, a).total_cmp(&share(b.busy, b)))?;
    let busy = share(busiest.busy, busiest);
    let waits = |which: &dyn Fn(Stall) -> bool| {
        let causes = Stall::ALL.into_iter().filter(|&s| which(s));
        share(causes.map(|s| busiest.stalls[s as usize]).sum(), busiest)
    };
    let dram = waits(&Stall::is_dram);
    let (input, output) = (waits(&|s| s == Stall::Input), waits(&|s| s == Stall::Output));
    let limit = if dram > busy { Limit::Dram } else { Limit::Unit(busiest.unit) };
    let subject = match limit {
        Limit::Dram => "DRAM limits this run".to_owned(),
        Limit::Unit(unit) => format!("The {} limits this run", unit.to_uppercase()),
    };
    let sentence = format!(
        "{subject}: {phase} {} % of the frame, and in it the busiest unit, the {}, works \
         {} % of the time and waits {} % for DRAM, {} % for input and {} % for room in its output.",
        percent(cycles as f64 / all as f64),
        busiest.unit.to_uppercase(),
        percent(busy),
        percent(dram),
        percent(input),
        percent(output),
    );
    Some(Bottleneck { limit, sentence })
}

fn full_bus(bus: f64) -> Bottleneck {
    let sentence = format!(
        "DRAM limits this run: its bus moves data {} % of the time; more bandwidth or fewer bytes \
         help, faster units do not.",
        percent(bus)
    );
    Bottleneck { limit: Limit::Dram, sentence }
}

fn add(sums: &mut Vec<Sums>, u: &UnitCycles) {
    let index = sums.iter().position(|s| s.unit == u.unit).unwrap_or_else(|| {
        let instances = u64::from(u.instances).max(1);
        sums.push(Sums { unit: u.unit, instances, busy: 0, stalls: [0; Stall::ALL.len()] });
        sums.len() - 1
    });
    let sum = &mut sums[index];
    sum.busy += u.busy;
    for (total, n) in sum.stalls.iter_mut().zip(u.stalls) {
        *total += n;
    }
}
