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

pub(super) use cycles::{
    COLOURS as CYCLES_COLOURS, axis as cycles_axis, bar as cycles_bar, entries as cycles_entries,
};
pub(super) use energy::{colour as component_colour, entries as component_entries};

use super::format::shortened;
use super::{Run, Table};
use powergs_chart::Chart;

/// All charts that `run` has data for, in report order.
pub fn all(run: &Run, table: &Table) -> Vec<Chart> {
    let charts = [
        energy::chart(run, table),
        cycles::chart(run, table),
        roofline::chart(run),
        buffers::chart(run, table),
        frame_time::chart(run, table),
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

/// `24 frames` or `1 frame`.
fn frames(run: &Run) -> String {
    match run.frames.len() {
        1 => "1 frame".into(),
        n => format!("mean of {n} frames"),
    }
}
