//! How keys of a machine act together: elementary effects after Morris, or Sobol indices.

mod bars;
mod formats;
mod page;
mod scatter;

pub use formats::{csv, designs_csv, json};
pub use page::document;

use powergs_chart::Chart;
use powergs_study::findings::sensitivity::interactions::{Interactions, Results};

/// The charts: a scatter for each measure after Morris, bars for Sobol indices.
pub fn charts(all: &Interactions) -> Vec<Chart> {
    match &all.results {
        Results::Morris(found) => scatter::charts(all, found),
        Results::Sobol(found) => bars::chart(all, found).into_iter().collect(),
    }
}

/// The line under a title.
fn subtitle(all: &Interactions) -> String {
    let note = all.incomplete_note().map_or(String::new(), |note| format!("{note}. "));
    let names: Vec<&str> = all.traces.iter().map(|t| t.name.as_str()).collect();
    let (names, machine) = (
        crate::format::shortened(&names.join(", "), 34),
        crate::format::shortened(&all.machine, 20),
    );
    format!("{note}{names} on {machine}: {}", sample(all))
}

/// `20 trajectories, 241 machines, 4 trajectories drawn again (invalid), seed 1`.
fn sample(all: &Interactions) -> String {
    let what = match &all.results {
        Results::Morris(_) => "trajectories",
        Results::Sobol(_) => "rows",
    };
    let of = match all.samples == all.asked {
        true => String::new(),
        false => format!(" of {}", all.asked),
    };
    let (samples, machines) = (all.samples, all.points.len());
    let again = match all.redrawn {
        0 => String::new(),
        n => format!(", {n} drawn again (invalid)"),
    };
    format!("{samples}{of} {what}, {machines} machines{again}, seed {}", all.seed)
}
