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

pub(super) use cycles::part_colours;
pub(super) use energy::colour as component_colour;

use super::format::shortened;
use super::plot::Drawing;
use super::{ReportError, summary_of};
use powergs_study::run_record::Run;

/// A drawn chart.
#[derive(Debug, Clone)]
pub struct Chart {
    /// File name without ending.
    pub name: &'static str,
    /// What it shows.
    pub title: &'static str,
    /// The drawing, for SVG and PNG.
    pub drawing: Drawing,
}

/// All charts that `run` has data for, in report order.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
///
/// # Panics
/// Without frames.
pub fn all(run: &Run) -> Result<Vec<Chart>, ReportError> {
    let summary = summary_of(run);
    let drawn = [
        energy::chart(run, &summary)?,
        cycles::chart(run, &summary)?,
        roofline::chart(run)?,
        buffers::chart(run, &summary)?,
        frame_time::chart(run, &summary)?,
        tiles::chart(run)?,
        tile_load::chart(run)?,
    ];
    Ok(drawn.into_iter().flatten().collect())
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
