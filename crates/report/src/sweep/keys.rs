//! What the axes do to the objectives: a curve for one axis, a heatmap for two, parallel
//! coordinates for more. Axes with one value only do not count.

mod curve;
mod heat;
mod parallel;

use super::words::prices;
use crate::format::counted;
use std::collections::BTreeSet;

use powergs_chart::Chart;
use powergs_study::analysis::Analysis;
use powergs_study::analysis::table::Words;

const NAME: &str = "keys";
/// Values of an axis that a heatmap has room for.
const CELLS: usize = 24;

/// The chart; `None` if nothing varies.
pub fn chart(analysis: &Analysis) -> Option<Chart> {
    let axes: Vec<Lane> = analysis
        .axes
        .iter()
        .filter(|axis| axis.values > 1)
        .filter_map(|axis| Lane::of(analysis, &axis.name))
        .collect();
    match axes.as_slice() {
        [] => None,
        [one] => Some(curve::chart(analysis, one)),
        [a, b] if a.order.len() <= CELLS && b.order.len() <= CELLS => {
            // More columns than rows: pages are wide.
            let (x, y) = if a.order.len() >= b.order.len() { (a, b) } else { (b, a) };
            Some(heat::chart(analysis, x, y))
        }
        axes => Some(parallel::chart(analysis, axes)),
    }
}

/// An axis as a row of places, one per value.
struct Lane<'t> {
    name: &'t str,
    words: &'t Words,
    /// The values that occur, in order; `None`, the first, where the axis does not count.
    order: Vec<Option<u32>>,
    /// Place of every row.
    places: Vec<usize>,
}

/// What stands in place of a value where an axis does not count.
const UNUSED: &str = "unused";

impl<'t> Lane<'t> {
    fn of(analysis: &Analysis<'t>, name: &str) -> Option<Lane<'t>> {
        let (name, words) = analysis.table.axes.iter().find(|(axis, _)| axis == name)?;
        let value = |row: u32| {
            let counts = analysis.table.counts(name, row) && words.word(row) != "-";
            counts.then(|| words.code(row))
        };
        let all = analysis.rows.iter().chain(&analysis.behind).chain(&analysis.unmet);
        let seen: BTreeSet<Option<u32>> = all.map(|&row| value(row)).collect();
        let codes = words.ordered().into_iter().map(Some);
        let order: Vec<Option<u32>> =
            [None].into_iter().chain(codes).filter(|code| seen.contains(code)).collect();
        let place = |row| order.iter().position(|code| *code == value(row)).unwrap_or(0);
        let places = (0..analysis.table.len() as u32).map(place).collect();
        Some(Lane { name, words, order, places })
    }

    fn place(&self, row: u32) -> usize {
        self.places[row as usize]
    }

    fn word(&self, place: usize) -> &str {
        self.order[place].map_or(UNUSED, |code| &self.words.distinct()[code as usize])
    }
}

fn chart_of(analysis: &Analysis, title: &'static str) -> Chart {
    let subtitle = format!(
        "{}, {}, {}",
        counted(analysis.rows.len(), "design"),
        analysis.question.scope,
        prices(analysis)
    );
    Chart::new(NAME, title, subtitle)
}
