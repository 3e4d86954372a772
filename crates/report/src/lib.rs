//! Reports: what a run looks like, for people and for machines. Nothing is simulated here, nothing
//! is opened: every format is a function from a [`Run`] to bytes, and the same run gives the same
//! bytes.

pub mod bottleneck;
pub mod charts;
pub mod claims;
pub mod compare;
pub mod csv;
pub mod docs;
pub mod document;
pub mod fit;
pub mod json;
pub mod limits;
pub mod optimize;
pub mod page;
pub mod perfetto;
pub mod record;
pub mod schema;
pub mod sensitivity;
pub mod sweep;
pub mod terms;
pub mod timeline;
pub mod validate;

pub use powergs_base::format;

use powergs_chart::Chart;
use powergs_study::findings::RunSummary;
use powergs_study::run_record::Run;

/// A report could not be made; all of these are mistakes of ours.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A chart could not be drawn.
    #[error(transparent)]
    Chart(#[from] powergs_chart::DrawError),
    /// The configuration could not be written.
    #[error("run.toml: {0}; please report this")]
    Toml(#[from] toml::ser::Error),
}

/// A file of a report folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Name in the folder.
    pub name: String,
    /// Contents.
    pub bytes: Vec<u8>,
}

/// Names of all files that a report folder may hold.
pub const FILE_NAMES: [&str; 48] = [
    "run.toml",
    "invocation.toml",
    "results.csv",
    "compare.csv",
    "sensitivity.csv",
    "summary.md",
    "energy.png",
    "energy.svg",
    "cycles.png",
    "cycles.svg",
    "roofline.png",
    "roofline.svg",
    "buffers.png",
    "buffers.svg",
    "frame_time.png",
    "frame_time.svg",
    "tiles.png",
    "tiles.svg",
    "tile_load.png",
    "tile_load.svg",
    "timeline.png",
    "timeline.svg",
    "tornado.png",
    "tornado.svg",
    "tornado_2.png",
    "tornado_2.svg",
    "tornado_3.png",
    "tornado_3.svg",
    "tornado_4.png",
    "tornado_4.svg",
    "elasticity.csv",
    "interactions.csv",
    "designs.csv",
    "tornado_fps.png",
    "tornado_fps.svg",
    "tornado_energy.png",
    "tornado_energy.svg",
    "tornado_area.png",
    "tornado_area.svg",
    "morris_fps.png",
    "morris_fps.svg",
    "morris_energy.png",
    "morris_energy.svg",
    "morris_area.png",
    "morris_area.svg",
    "sobol.png",
    "sobol.svg",
    "trace.json.gz",
];

/// Those of them that `replay` writes only when they are asked for, or that `compare` and
/// `sensitivity` write.
pub const ASKED_FOR: [&str; 30] = [
    "compare.csv",
    "timeline.png",
    "timeline.svg",
    "trace.json.gz",
    "sensitivity.csv",
    "tornado.png",
    "tornado.svg",
    "tornado_2.png",
    "tornado_2.svg",
    "tornado_3.png",
    "tornado_3.svg",
    "tornado_4.png",
    "tornado_4.svg",
    "elasticity.csv",
    "interactions.csv",
    "designs.csv",
    "tornado_fps.png",
    "tornado_fps.svg",
    "tornado_energy.png",
    "tornado_energy.svg",
    "tornado_area.png",
    "tornado_area.svg",
    "morris_fps.png",
    "morris_fps.svg",
    "morris_energy.png",
    "morris_energy.svg",
    "morris_area.png",
    "morris_area.svg",
    "sobol.png",
    "sobol.svg",
];

/// A PNG and an SVG of every chart.
///
/// # Errors
/// [`powergs_chart::DrawError`], which would be a mistake of ours.
pub fn chart_files(charts: &[Chart]) -> Result<Vec<File>, powergs_chart::DrawError> {
    let mut files = Vec::new();
    for chart in charts {
        files.push(File { name: format!("{}.png", chart.name), bytes: chart.png()? });
        files.push(File { name: format!("{}.svg", chart.name), bytes: chart.svg()?.into_bytes() });
    }
    Ok(files)
}

/// What a run comes to.
///
/// # Panics
/// Without frames: nothing is reported before the first frame is done.
fn summary_of(run: &Run) -> RunSummary {
    RunSummary::of(run).expect("a reported run has frames")
}

/// The files of the report folder, all but `invocation.toml`.
///
/// # Errors
/// [`ReportError`]: a mistake of ours.
///
/// # Panics
/// Without frames.
pub fn files(run: &Run) -> Result<Vec<File>, ReportError> {
    let charts = charts::all(run);
    let summary = page::document(run, &charts, &[]).markdown();
    let mut files = vec![
        File { name: "run.toml".into(), bytes: record::run_toml(run)?.into_bytes() },
        File { name: "results.csv".into(), bytes: csv::results(run) },
        File { name: "summary.md".into(), bytes: summary.into_bytes() },
    ];
    files.extend(chart_files(&charts)?);
    Ok(files)
}
