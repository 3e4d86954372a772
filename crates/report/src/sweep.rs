//! What a sweep found, for people and for programs: charts, tables, sentences, one HTML page.
//! Everything is a function of an [`Analysis`]; nothing is read and nothing is simulated.

mod axis;
mod colour;
mod confirmed;
mod deadline;
mod designs;
mod energy;
mod front;
mod keys;
mod measure;
mod names;
mod offers;
mod output;
mod page;
mod ranks;
mod words;

pub use confirmed::{confirmation, confirmed_csv};
pub use measure::Measure;
pub use names::short as short_names;
pub use output::{json, pareto_csv, pareto_csv_of, pareto_rows};
pub use page::{Provenance, document};
pub use words::free;

use powergs_chart::Chart;
use powergs_study::analysis::{Analysis, speedup as of_traces};

/// Whether the folder `analysis` may hold a file of this name.
pub fn is_file_name(name: &str) -> bool {
    ["pareto.csv", "speedup.csv", "question.toml"].contains(&name)
        || super::PAGES.contains(&name)
        || super::is_chart(name, &CHART_NAMES)
}

/// Names of all charts of the folder `analysis`, without their endings.
const CHART_NAMES: [&str; 7] =
    ["front", "front_2", "front_3", "speedup", "energy_front", "keys", "stability"];

/// All charts that the analysis has data for, in report order.
pub fn charts(analysis: &Analysis) -> Vec<Chart> {
    let mut charts = front::charts(analysis);
    charts.extend(speedup(analysis));
    charts.extend(energy::chart(analysis));
    charts.extend(keys::chart(analysis));
    charts.extend(ranks::chart(analysis));
    charts
}

/// Selected designs over the traces; `None` for one trace.
fn speedup(analysis: &Analysis) -> Option<Chart> {
    let all = of_traces::of(analysis)?;
    let what = format!("selected designs, {}", words::prices(analysis));
    Some(crate::speedup::chart(&all, what))
}

/// `speedup.csv`: selected designs over the traces; `None` for one trace.
pub fn speedup_csv(analysis: &Analysis) -> Option<Vec<u8>> {
    of_traces::of(analysis).map(|all| crate::speedup::csv(&all))
}
