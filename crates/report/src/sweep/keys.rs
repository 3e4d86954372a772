//! What the axes do to the objectives: a curve for one axis, a heatmap for two, parallel
//! coordinates for more. Axes with one value only do not count.

mod curve;
mod heat;
mod parallel;

use super::words::{count, prices};
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
    /// The values that occur, in order.
    order: Vec<u32>,
    /// Place of every value.
    places: Vec<usize>,
}

impl<'t> Lane<'t> {
    fn of(analysis: &Analysis<'t>, name: &str) -> Option<Lane<'t>> {
        let (name, words) = analysis.table.axes.iter().find(|(axis, _)| axis == name)?;
        let mut seen = vec![false; words.distinct().len()];
        let all = analysis.rows.iter().chain(&analysis.behind).chain(&analysis.unmet);
        all.for_each(|&row| seen[words.code(row) as usize] = true);
        let order: Vec<u32> =
            words.ordered().into_iter().filter(|code| seen[*code as usize]).collect();
        let mut places = vec![0; words.distinct().len()];
        order.iter().enumerate().for_each(|(place, code)| places[*code as usize] = place);
        Some(Lane { name, words, order, places })
    }

    fn place(&self, row: u32) -> usize {
        self.places[self.words.code(row) as usize]
    }

    fn word(&self, place: usize) -> &str {
        &self.words.distinct()[self.order[place] as usize]
    }
}

fn chart_of(analysis: &Analysis, title: &'static str) -> Chart {
    let subtitle = format!(
        "{}, {}, {}",
        count(analysis.rows.len(), "design"),
        analysis.question.scope,
        prices(analysis)
    );
    Chart::new(NAME, title, subtitle)
}
