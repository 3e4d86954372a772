//! The charts of a report, one file each. A chart that the model has no data for is left out.

mod buffers;
mod cycles;
mod energy;
mod frame_time;
mod roofline;
mod tile_load;
mod tiles;
mod timeline;

pub use timeline::chart as timeline;

pub(super) use buffers::rows as buffer_rows;
pub(super) use cycles::{
    axis as cycles_axis, bar as cycles_bar, colours as cycles_colours, entries as cycles_entries,
    unit,
};
pub(super) use energy::{colour as component_colour, entries as component_entries};

use super::format::shortened;
use super::record_of;
use powergs_chart::Chart;
use powergs_study::run_record::Run;

/// All charts that `run` has data for, in report order.
///
/// # Panics
/// Without frames.
pub fn all(run: &Run) -> Vec<Chart> {
    let record = record_of(run);
    let charts = [
        energy::chart(run, &record),
        cycles::chart(run, &record),
        roofline::chart(run),
        buffers::chart(run, &record),
        frame_time::chart(run, &record),
        tiles::chart(run),
        tile_load::chart(run),
    ];
    charts.into_iter().flatten().collect()
}

/// The line under a title: what was run, and whether it is incomplete.
fn subtitle(run: &Run, what: &str) -> String {
    let note = run.incomplete_note().map_or(String::new(), |note| format!("{note}. "));
    let model = run.facts.model.name();
    let title = shortened(&run.title(), 48);
    format!("{note}{title}, {model} model, {what}")
}

/// `mean of 24 frames` or `1 frame`, and what a frame is where it is a pair.
fn frames(run: &Run) -> String {
    let (n, shown) = (run.frames.len() as u64, run.facts.trace.shown);
    let counted = match shown.eyes {
        1 => shown.counted(n),
        _ => format!("{} of {}", shown.counted(n), shown.size()),
    };
    if n == 1 { counted } else { format!("mean of {counted}") }
}
