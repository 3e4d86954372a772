//! Selected designs of a sweep over its traces.

use super::Analysis;
use super::table::Over;
use crate::speedup::{MachineSpeed, Speed, SpeedUp};

/// Designs beside the one that they are compared with, at most.
const MOST: usize = 5;

/// The design that the question names against the knee and the ends of the front, trace by trace;
/// `None` for a sweep of one trace.
pub fn of(analysis: &Analysis) -> Option<SpeedUp> {
    let table = analysis.table;
    let mut rows: Vec<u32> = analysis.named.iter().map(|n| n.row).collect();
    for row in [analysis.knee].into_iter().chain(analysis.ends.iter().copied()) {
        if !rows.iter().any(|r| table.points[*r as usize] == table.points[row as usize]) {
            rows.push(row);
        }
    }
    rows.truncate(MOST + 1);
    let prices = table.energy_tables.code(*rows.first()?);
    let is_of_trace = |row: &u32| {
        table.over[*row as usize] == Over::Trace && table.energy_tables.code(*row) == prices
    };
    let over_traces: Vec<u32> = (0..table.len() as u32).filter(is_of_trace).collect();
    let mut traces: Vec<&str> = Vec::new();
    for &row in &over_traces {
        let trace = table.traces.word(row);
        if !traces.contains(&trace) {
            traces.push(trace);
        }
    }
    let speed = |design: u32, trace: &str| {
        let is_it = |row: &&u32| {
            table.points[**row as usize] == table.points[design as usize]
                && table.traces.word(**row) == trace
        };
        let row = *over_traces.iter().find(is_it)?;
        let energy_j = table.number("energy_pj.mean", row)? * 1e-12;
        let fps = table.number("fps.mean", row)?;
        Some(Speed { fps, energy_j })
    };
    let machine = |&design: &u32| {
        let label = match table.label(design) {
            label if design == analysis.knee => format!("knee {label}"),
            label => label,
        };
        let speeds = traces.iter().map(|t| speed(design, t)).collect();
        MachineSpeed { label, speeds, is_comparable: [true; 2] }
    };
    let machines = rows.iter().map(machine).collect();
    SpeedUp::new(traces.iter().map(|t| (*t).to_owned()).collect(), machines)
}
