//! What a sweep found, for people and for programs: charts, tables, sentences, one HTML page.
//! Everything is a function of an [`Analysis`]; nothing is read and nothing is simulated.

mod axis;
mod colour;
mod energy;
mod front;
mod keys;
mod marginal;
mod measure;
mod names;
mod output;
mod page;
mod ranks;
mod words;

pub use measure::Measure;
pub use names::short as short_names;
pub use output::{json, pareto_csv, pareto_csv_of, pareto_rows};
pub use page::{Provenance, document};

use powergs_chart::Chart;
use powergs_study::analysis::Analysis;

/// Names of all files of the folder `analysis`.
pub const FILE_NAMES: [&str; 17] = [
    "pareto.csv",
    "summary.md",
    "report.html",
    "front.png",
    "front.svg",
    "front_2.png",
    "front_2.svg",
    "front_3.png",
    "front_3.svg",
    "energy_front.png",
    "energy_front.svg",
    "keys.png",
    "keys.svg",
    "marginal.png",
    "marginal.svg",
    "stability.png",
    "stability.svg",
];

/// All charts that the analysis has data for, in report order: files `NAME.png` and `NAME.svg`.
pub fn charts(analysis: &Analysis) -> Vec<Chart> {
    let mut charts = front::charts(analysis);
    charts.extend(energy::chart(analysis));
    charts.extend(keys::chart(analysis));
    charts.extend(marginal::chart(analysis));
    charts.extend(ranks::chart(analysis));
    charts
}
