//! How charts are drawn: the flags of every command that draws.

use std::path::Path;

use super::{Exit, Failure, OrExit};
use powergs_chart::{Chart, Format, Sheet, Style};
use powergs_core::run::store::atomic::write_atomically;
use powergs_report::Drawing;

/// How charts are drawn.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Charts")]
pub struct ChartArgs {
    /// Size of charts in print: column (3.33 in wide, one of two), page (7 in, the width of its
    /// text), slide (1920 x 1080 pixels), or a width of 1.5 to 20 inches as 3.5in, 88mm or 252pt (a
    /// point is 1/72 in). Text has 7 points in print; below 3 in it is smaller, above 7 in larger
    #[arg(long, value_name = "SIZE", default_value_t = Sheet::Slide, hide_short_help = true)]
    pub chart_size: Sheet,
    /// Charts without a title and the line under it: a caption says that
    #[arg(long, hide_short_help = true)]
    pub no_title: bool,
    /// Files of every chart: svg, png, pdf
    #[arg(long, value_enum, value_name = "FORMATS", value_delimiter = ',', hide_short_help = true)]
    #[arg(default_value = "png,svg")]
    pub chart_format: Vec<FormatArg>,
}

/// Kinds of files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum FormatArg {
    /// Shapes, with text that can be searched and edited
    Svg,
    /// Pixels
    Png,
    /// Shapes, with text in an embedded part of the font
    Pdf,
}

impl ChartArgs {
    /// What is laid out.
    pub fn style(&self) -> Style {
        Style { sheet: self.chart_size, title: !self.no_title }
    }

    /// What is written.
    pub fn drawing(&self) -> Drawing {
        let formats = self.chart_format.iter().map(|format| match format {
            FormatArg::Svg => Format::Svg,
            FormatArg::Png => Format::Png,
            FormatArg::Pdf => Format::Pdf,
        });
        Drawing { style: self.style(), formats: formats.collect() }
    }
}

/// Writes one chart, in the format of the ending of its file.
///
/// # Errors
/// Exit code 2 for an ending that is no format of charts; a file that cannot be written.
pub fn write(path: &Path, chart: &Chart, style: Style) -> Result<(), Failure> {
    let ending = path.extension().unwrap_or_default().to_string_lossy();
    let Some(format) = Format::of_ending(&ending) else {
        let what = format!("{}: a chart is a .png, .svg or .pdf file", path.display());
        return Err(Failure::new(Exit::Usage, what));
    };
    let bytes = format.file(chart, style).or_exit(Exit::Internal, path.display())?;
    Ok(write_atomically(path, |w| w.write_all(&bytes))?)
}
