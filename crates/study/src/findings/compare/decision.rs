//! Who can be bought: machines on traces at the rate of the display, and what each falls short of.

use powergs_core::sim::statistics::{Key, Record};

use super::{Comparison, Side};
use crate::findings::masters::MasterGets;
use crate::sweep::expr::{Expr, ExprError, Value};

/// What a machine must meet besides the display rate.
#[derive(Debug, Clone, Default)]
pub struct AskedLimits {
    /// Power at the display rate, watts.
    pub budget_w: Option<f64>,
    /// Time from the first read of a frame to its last write, milliseconds.
    pub latency_ms: Option<f64>,
    /// A condition on statistics of a run.
    pub condition: Option<Expr>,
}

impl AskedLimits {
    /// Whether anything is asked for besides the display rate.
    pub fn is_any(&self) -> bool {
        self.budget_w.is_some() || self.latency_ms.is_some() || self.condition.is_some()
    }
}

/// What a machine on a trace falls short of.
#[derive(Debug, Clone, PartialEq)]
pub enum Shortfall {
    /// Some frames take longer than a display period.
    Rate {
        /// How many.
        missed: u64,
    },
    /// Its model knows no time, so that nobody can tell.
    NoTime,
    /// It draws more than the budget.
    Budget {
        /// Watts that it may draw.
        budget: f64,
    },
    /// A frame takes longer than allowed.
    Latency {
        /// Of the slowest frame, milliseconds.
        ms: f64,
    },
    /// The condition does not hold.
    Condition,
    /// Another master of its memory gets less than it asks for: the chip around it does not do its
    /// work.
    Starved(MasterGets),
}

/// A machine on a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct DecisionRow {
    /// Place of the trace.
    pub trace: usize,
    /// Place of the machine.
    pub side: usize,
    /// Frames a second, or steps, back to back.
    pub fps: Option<f64>,
    /// The slowest frame, milliseconds, or what 99 % of 100 frames and more take at most.
    pub slowest_ms: Option<f64>,
    /// Time of the slowest frame from its first read to its last write, milliseconds.
    pub latency_ms: Option<f64>,
    /// Display periods that are missed; `None` where nothing is shown.
    pub missed: Option<u64>,
    /// Frames.
    pub frames: u64,
    /// Power at the display rate, watts; of steps at the rate that they reach.
    pub power_w: Option<f64>,
    /// Area of the die, mm².
    pub area_mm2: Option<f64>,
    /// What it falls short of; empty where it meets all.
    pub short: Vec<Shortfall>,
}

impl DecisionRow {
    /// Whether it meets the display rate and all limits.
    pub fn is_met(&self) -> bool {
        self.short.is_empty()
    }
}

/// Machines on traces, trace by trace.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// Of each trace its machines, in their order.
    pub rows: Vec<DecisionRow>,
    /// Whether anything was asked for besides the display rate.
    pub has_limits: bool,
    machines: usize,
}

impl Decision {
    /// What comparisons of the same machines, one a trace, say of each.
    ///
    /// # Errors
    /// A condition about something that no statistic is called, or that is neither true nor false.
    pub fn of(all: &[Comparison], limits: &AskedLimits) -> Result<Decision, ExprError> {
        let mut rows = Vec::new();
        for (trace, comparison) in all.iter().enumerate() {
            for (i, side) in comparison.sides.iter().enumerate() {
                rows.push(row(trace, i, side, limits)?);
            }
        }
        Ok(Decision {
            rows,
            has_limits: limits.is_any(),
            machines: all.first().map_or(0, |c| c.sides.len()),
        })
    }

    /// The row of a machine on a trace.
    pub fn row(&self, trace: usize, side: usize) -> &DecisionRow {
        &self.rows[trace * self.machines + side]
    }

    /// How many traces there are.
    pub fn traces(&self) -> usize {
        self.rows.len() / self.machines.max(1)
    }

    /// Power at the display rate of the first machine over that of another, the geometric mean over
    /// the traces on which both meet everything, and how many these are; `None` where there is
    /// none.
    pub fn power_gain(&self, side: usize) -> Option<(f64, usize)> {
        let of = |trace: usize| {
            let (first, own) = (self.row(trace, 0), self.row(trace, side));
            let both = first.power_w.zip(own.power_w).filter(|_| first.is_met() && own.is_met())?;
            Some((both.0 / both.1).ln()).filter(|log| log.is_finite())
        };
        let logs: Vec<f64> = (0..self.traces()).filter_map(of).collect();
        let mean = logs.iter().sum::<f64>() / logs.len() as f64;
        (!logs.is_empty()).then_some((mean.exp(), logs.len()))
    }
}

fn row(
    trace: usize,
    side: usize,
    of: &Side,
    limits: &AskedLimits,
) -> Result<DecisionRow, ExprError> {
    let record = &of.statistics;
    let time = record.aggregate(Key::FrameTime);
    let missed = record.deadline_misses().filter(|_| of.task.is_shown());
    let power_w = record.mean(Key::Power).filter(|watts| watts.is_finite());
    let latency = record.aggregate(Key::FrameLatency).map(|all| all.max.as_f64());
    let mut short = Vec::new();
    if time.is_none() {
        short.push(Shortfall::NoTime);
    }
    if let Some(missed) = missed.filter(|missed| *missed > 0) {
        short.push(Shortfall::Rate { missed });
    }
    if let Some((_, budget)) = power_w.zip(limits.budget_w).filter(|(w, budget)| w > budget) {
        short.push(Shortfall::Budget { budget });
    }
    if let Some((ms, _)) = latency.zip(limits.latency_ms).filter(|(ms, most)| ms > most) {
        short.push(Shortfall::Latency { ms });
    }
    let masters = of.masters.gets(|key| record.mean(key)).into_iter();
    short.extend(masters.filter(MasterGets::is_starved).map(Shortfall::Starved));
    if let Some(condition) = &limits.condition
        && !condition.holds(&|name| value(record, name).map(Value::Number))?
    {
        short.push(Shortfall::Condition);
    }
    Ok(DecisionRow {
        trace,
        side,
        fps: record.throughput_fps(),
        // A quantile of 99 % of fewer frames is the largest.
        slowest_ms: time.map(|time| time.p99.as_f64()),
        latency_ms: latency,
        missed,
        frames: of.frames,
        power_w,
        area_mm2: record.mean(Key::Area),
        short,
    })
}

/// A statistic of a run by its name: its mean, or the part that stands behind the last dot.
fn value(record: &Record, name: &str) -> Option<f64> {
    if let Some(all) = record.named(name) {
        return Some(all.mean);
    }
    let (name, part) = name.rsplit_once('.')?;
    let all = record.named(name)?;
    Some(match part {
        "mean" => all.mean,
        "p50" => all.p50.as_f64(),
        "p95" => all.p95.as_f64(),
        "p99" => all.p99.as_f64(),
        "max" => all.max.as_f64(),
        _ => return None,
    })
}
