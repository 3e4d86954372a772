//! How charts are laid out: how large they are in print, whether they have a title, and in which
//! files.

use crate::{Chart, DrawError};

/// How large a chart is. Text is the same part of every page unit, so that it has 7 points in a
/// column as on a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sheet {
    /// 13.33 x 7.5 inches.
    #[default]
    Slide,
    /// As wide as the text of a paper, 7 inches.
    Page,
    /// One of two columns, 3.33 inches; panels stand above each other.
    Column,
}

impl Sheet {
    /// All of them.
    pub const ALL: [Sheet; 3] = [Sheet::Slide, Sheet::Page, Sheet::Column];

    /// Width in print, inches.
    pub const fn inches(self) -> f64 {
        match self {
            Sheet::Slide => 1280.0 / 96.0,
            Sheet::Page => 7.0,
            Sheet::Column => 3.33,
        }
    }

    /// Width, page units.
    pub(crate) const fn width(self) -> f64 {
        match self {
            Sheet::Slide | Sheet::Page => 1280.0,
            // Normal text has 18 units, which are 7 points here.
            Sheet::Column => 616.0,
        }
    }

    /// Height, page units; `None`: as high as what is on it.
    pub(crate) const fn height(self) -> Option<f64> {
        match self {
            Sheet::Slide | Sheet::Page => Some(720.0),
            Sheet::Column => None,
        }
    }

    /// Pixels of a PNG per page unit.
    pub(crate) const fn zoom(self) -> f32 {
        match self {
            Sheet::Slide => 1.5,
            Sheet::Page => 2.0,
            Sheet::Column => 3.0,
        }
    }

    /// Page units in an inch of print.
    pub(crate) const fn units_per_inch(self) -> f64 {
        self.width() / self.inches()
    }
}

/// How a chart is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// How large it is.
    pub sheet: Sheet,
    /// Whether it has its title and the line under it; a paper says that in a caption.
    pub title: bool,
}

impl Default for Style {
    /// A slide with a title.
    fn default() -> Style {
        Style { sheet: Sheet::Slide, title: true }
    }
}

/// A kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Pixels, with their number per inch.
    Png,
    /// Shapes and text.
    Svg,
    /// Shapes, with text in an embedded part of the font.
    Pdf,
}

impl Format {
    /// All of them; those that more programs show first.
    pub const ALL: [Format; 3] = [Format::Png, Format::Svg, Format::Pdf];

    /// The ending of its files, without a dot.
    pub const fn ending(self) -> &'static str {
        match self {
            Format::Png => "png",
            Format::Svg => "svg",
            Format::Pdf => "pdf",
        }
    }

    /// The kind of file with an ending, whatever its case.
    pub fn of_ending(ending: &str) -> Option<Format> {
        Format::ALL.into_iter().find(|f| f.ending().eq_ignore_ascii_case(ending))
    }

    /// A chart as a file of this kind.
    ///
    /// # Errors
    /// [`DrawError`]: a defect of this crate.
    pub fn file(self, chart: &Chart, style: Style) -> Result<Vec<u8>, DrawError> {
        match self {
            Format::Png => chart.png(style),
            Format::Svg => Ok(chart.svg(style)?.into_bytes()),
            Format::Pdf => chart.pdf(style),
        }
    }
}
