//! Which designs keep up with the display, and by how much the others miss it.
//!
//! A design misses the display rate if any of its frames takes longer than a display period, on any
//! trace that counts. How much it misses is the time of its slowest frame. Designs that meet the
//! rate come first; of those that miss it, those that miss it least (constraint domination, after
//! Deb et al. 2002). Power and energy say little about a design that is too slow: at the rate that
//! it reaches, the slowest draws least.

use std::collections::BTreeMap;

use super::designs::DesignSlice;
use super::front::is_alike;
use super::question::{Misses, Scope};
use super::table::Table;

/// The designs of one energy table and scope that miss the display rate.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Late {
    /// By point, the time of the slowest frame, ms.
    slowest_ms: BTreeMap<u64, f64>,
    /// Whether they rank behind the others.
    behind: bool,
}

impl Late {
    /// Those of the energy table with the code `energy_table`. Of a single trace its own frames
    /// count, else those of all traces.
    pub fn of(table: &Table, energy_table: u32, scope: &Scope, misses: Misses) -> Late {
        let scope = match scope {
            Scope::Mean | Scope::Worst => &Scope::Mean,
            Scope::Trace(_) => scope,
        };
        let slice = DesignSlice::of(table, energy_table, scope);
        let late = |row: u32| {
            table.number("deadline_missed_frac", row).filter(|share| *share > 0.0)?;
            let times = ["frame_time_ms.max", "frame_time_ms.mean"];
            let slowest = times.into_iter().find_map(|name| table.number(name, row));
            Some((table.points[row as usize], slowest.unwrap_or(f64::MAX)))
        };
        let rows = slice.rows.iter().chain(&slice.baseline);
        let slowest_ms = rows.filter_map(|&row| late(row)).collect();
        Late { slowest_ms, behind: misses == Misses::Behind }
    }

    /// Whether a point misses the display rate.
    pub fn has(&self, point: u64) -> bool {
        self.slowest_ms.contains_key(&point)
    }

    /// Time of the slowest frame of a point that misses the display rate, ms.
    pub fn slowest_ms(&self, point: u64) -> Option<f64> {
        self.slowest_ms.get(&point).copied()
    }

    /// Places in `rows` of those that are ranked first, and of those that rank behind because they
    /// miss the rate, each ascending. If all miss it, those that miss it least are ranked first.
    pub fn split(&self, table: &Table, rows: &[u32], epsilon: f64) -> (Vec<usize>, Vec<usize>) {
        let all = 0..rows.len();
        if !self.behind {
            return (all.collect(), Vec::new());
        }
        let slowest = |place: usize| self.slowest_ms(table.points[rows[place] as usize]);
        let (first, behind): (Vec<usize>, Vec<usize>) =
            all.partition(|&place| slowest(place).is_none());
        if !first.is_empty() {
            return (first, behind);
        }
        let least = behind.iter().filter_map(|&p| slowest(p)).fold(f64::INFINITY, f64::min);
        let is_least = |&p: &usize| slowest(p).is_some_and(|ms| is_alike(ms, least, epsilon));
        behind.into_iter().partition(is_least)
    }
}
