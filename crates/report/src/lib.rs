//! Reports: what a run looks like, for people and for machines. Nothing is simulated here, nothing
//! is opened: every format is a function from a [`Run`] to bytes, and the same run gives the same
//! bytes.

pub mod bottleneck;
pub mod certificate;
pub mod charts;
pub mod codesign;
pub mod compare;
pub mod csv;
pub mod docs;
pub mod document;
pub mod dram;
pub mod explain;
pub mod fit;
pub mod json;
pub mod limits;
pub mod machine;
pub mod optimize;
pub mod page;
pub mod perfetto;
pub mod record;
pub mod schema;
pub mod sensitivity;
pub mod speedup;
mod steps;
pub mod sweep;
pub mod terms;
pub mod timeline;
pub mod validate;

pub use powergs_base::format;

use document::Document;
use powergs_chart::{Chart, DrawError, Format, Style};
use powergs_study::findings::Record;
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

/// Names of the pages of a folder.
pub const PAGES: [&str; 2] = ["summary.md", "report.html"];

/// Names of all files that a report folder may hold, but pages and charts.
const FILE_NAMES: [&str; 10] = [
    "run.toml",
    "invocation.toml",
    "results.csv",
    "compare.csv",
    "decision.csv",
    "speedup.csv",
    "sensitivity.csv",
    "elasticity.csv",
    "interactions.csv",
    "designs.csv",
];

/// Names of all charts that a report folder may hold, without their endings.
const CHART_NAMES: [&str; 24] = [
    "energy",
    "power",
    "breakdown",
    "decision",
    "steps",
    "cycles",
    "roofline",
    "buffers",
    "frame_time",
    "tiles",
    "tile_load",
    "timeline",
    "speedup",
    "tornado",
    "tornado_2",
    "tornado_3",
    "tornado_4",
    "tornado_fps",
    "tornado_energy",
    "tornado_area",
    "morris_fps",
    "morris_energy",
    "morris_area",
    "sobol",
];

/// A timeline for a browser, written beside the chart of it.
const TIMELINE: &str = "trace.json.gz";

/// How the charts of a report are drawn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawing {
    /// How they are laid out.
    pub style: Style,
    /// The files of each.
    pub formats: Vec<Format>,
}

impl Default for Drawing {
    /// Slides as PNG and SVG.
    fn default() -> Drawing {
        Drawing { style: Style::default(), formats: vec![Format::Png, Format::Svg] }
    }
}

impl Drawing {
    /// The files of charts.
    ///
    /// # Errors
    /// [`powergs_chart::DrawError`], which would be a mistake of ours.
    pub fn files(&self, charts: &[Chart]) -> Result<Vec<File>, powergs_chart::DrawError> {
        let mut files = Vec::new();
        for chart in charts {
            for format in Format::ALL.into_iter().filter(|f| self.formats.contains(f)) {
                let name = format!("{}.{}", chart.name, format.ending());
                files.push(File { name, bytes: format.file(chart, self.style)? });
            }
        }
        Ok(files)
    }

    /// The pages of a folder: one for editors and forges, one for browsers.
    ///
    /// # Errors
    /// [`DrawError`], which would be a mistake of ours.
    pub fn pages(&self, page: &Document) -> Result<[File; 2], DrawError> {
        let [summary, report] = PAGES.map(str::to_owned);
        Ok([
            File { name: summary, bytes: page.markdown(self.link()).into_bytes() },
            File { name: report, bytes: page.html()?.into_bytes() },
        ])
    }

    /// The kind of file that pages show.
    fn link(&self) -> Format {
        let has = |f: &Format| self.formats.contains(f);
        Format::ALL.into_iter().find(has).unwrap_or(Format::Png)
    }
}

/// Whether `name` is that of a chart file, of one of `charts`.
fn is_chart(name: &str, charts: &[&str]) -> bool {
    let Some((stem, ending)) = name.rsplit_once('.') else { return false };
    charts.contains(&stem) && Format::ALL.iter().any(|f| f.ending() == ending)
}

/// Whether a report folder may hold a file of this name.
pub fn is_file_name(name: &str) -> bool {
    FILE_NAMES.contains(&name)
        || PAGES.contains(&name)
        || name == TIMELINE
        || is_chart(name, &CHART_NAMES)
}

/// What the catalogue says of a run.
///
/// # Panics
/// Without frames: nothing is reported before the first frame is done.
fn record_of(run: &Run) -> Record {
    run.statistics().expect("a reported run has frames")
}

/// The files of the report folder, all but `invocation.toml`.
///
/// # Errors
/// [`ReportError`]: a mistake of ours.
///
/// # Panics
/// Without frames.
pub fn files(run: &Run, drawing: &Drawing) -> Result<Vec<File>, ReportError> {
    let charts = charts::all(run);
    let mut files = vec![
        File { name: "run.toml".into(), bytes: record::run_toml(run)?.into_bytes() },
        File { name: "results.csv".into(), bytes: csv::results(run) },
    ];
    files.extend(drawing.pages(&page::document(run, &charts, &[]))?);
    files.extend(drawing.files(&charts)?);
    Ok(files)
}
