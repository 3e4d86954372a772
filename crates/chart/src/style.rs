//! How charts are laid out: how large they are in print, whether they have a title, and in which
//! files.

use std::fmt;
use std::str::FromStr;

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
    /// As wide as a paper wants it; panels stand above each other where it is narrow.
    Wide(PrintWidth),
}

/// Page units in an inch where normal text, which has 18 units, has 7 points.
const PER_INCH: f64 = 18.0 * 72.0 / 7.0;
/// Charts below this width have their panels above each other, inches.
const NARROW: f64 = 6.0;
/// What is narrower is laid out as if it had this width and made smaller with its text, inches:
/// labels need room.
const NARROWEST_LAYOUT: f64 = 3.0;

impl Sheet {
    /// Those with a name.
    pub const ALL: [Sheet; 3] = [Sheet::Slide, Sheet::Page, Sheet::Column];

    /// Its name; a width has none.
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Sheet::Slide => Some("slide"),
            Sheet::Page => Some("page"),
            Sheet::Column => Some("column"),
            Sheet::Wide(_) => None,
        }
    }

    /// Width in print, inches.
    pub const fn inches(self) -> f64 {
        match self {
            Sheet::Slide => 1280.0 / 96.0,
            Sheet::Page => 7.0,
            Sheet::Column => 3.33,
            Sheet::Wide(width) => width.inches(),
        }
    }

    /// Width, page units.
    pub(crate) const fn width(self) -> f64 {
        match self {
            Sheet::Slide | Sheet::Page => 1280.0,
            // Normal text has 18 units, which are 7 points here.
            Sheet::Column => 616.0,
            Sheet::Wide(width) if width.inches() < NARROW => {
                (PER_INCH * width.inches().max(NARROWEST_LAYOUT)).round()
            }
            // Above the width of a page its layout grows with its text.
            Sheet::Wide(width) => (PER_INCH * width.inches()).round().min(1280.0),
        }
    }

    /// Height, page units; `None`: as high as what is on it.
    pub(crate) const fn height(self) -> Option<f64> {
        match self {
            Sheet::Slide | Sheet::Page => Some(720.0),
            Sheet::Column => None,
            Sheet::Wide(width) if width.inches() < NARROW => None,
            Sheet::Wide(_) => Some(720.0),
        }
    }

    /// Pixels of a PNG per page unit.
    pub(crate) const fn zoom(self) -> f32 {
        match self {
            Sheet::Slide => 1.5,
            Sheet::Page => 2.0,
            Sheet::Column => 3.0,
            Sheet::Wide(_) if self.height().is_none() => 3.0,
            Sheet::Wide(_) => 2.0,
        }
    }

    /// Page units in an inch of print.
    pub(crate) const fn units_per_inch(self) -> f64 {
        self.width() / self.inches()
    }
}

impl FromStr for Sheet {
    type Err = WidthError;

    /// Reads `column`, `page`, `slide`, or a width.
    fn from_str(text: &str) -> Result<Sheet, WidthError> {
        let named = Sheet::ALL.into_iter().find(|sheet| sheet.name() == Some(text));
        named.map_or_else(|| text.parse().map(Sheet::Wide), Ok)
    }
}

impl fmt::Display for Sheet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.name(), self) {
            (None, Sheet::Wide(width)) => width.fmt(f),
            (name, _) => f.write_str(name.unwrap_or_default()),
        }
    }
}

/// Width of a chart in print: 1.5 to 20 inches, to the micrometre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PrintWidth {
    micrometres: u32,
}

/// Units of widths with their micrometres. A point is 1/72 inch, the `bp` of TeX.
const UNITS: [(&str, f64); 4] =
    [("in", 25_400.0), ("cm", 1e4), ("mm", 1e3), ("pt", 25_400.0 / 72.0)];

impl PrintWidth {
    /// The narrowest, inches.
    pub const LEAST: f64 = 1.5;
    /// The widest, inches.
    pub const MOST: f64 = 20.0;

    /// In inches.
    pub const fn inches(self) -> f64 {
        self.micrometres as f64 / 25_400.0
    }
}

impl FromStr for PrintWidth {
    type Err = WidthError;

    /// Reads `3.5in`, `88 mm`, `8.8cm` or `252pt`.
    fn from_str(text: &str) -> Result<PrintWidth, WidthError> {
        let unit = UNITS.into_iter().find_map(|(unit, size)| {
            let number = text.strip_suffix(unit)?.trim_end();
            // No signs, exponents or words that a number may be written with.
            let is_plain =
                !number.is_empty() && number.chars().all(|c| matches!(c, '0'..='9' | '.'));
            is_plain.then_some(())?;
            Some(number.parse::<f64>().ok()? * size)
        });
        let micrometres = unit.ok_or(WidthError::Unread)?.round();
        let range = PrintWidth::LEAST * 25_400.0..=PrintWidth::MOST * 25_400.0;
        if !range.contains(&micrometres) {
            return Err(WidthError::Range);
        }
        Ok(PrintWidth { micrometres: micrometres as u32 })
    }
}

impl fmt::Display for PrintWidth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}in", (self.inches() * 1e4).round() / 1e4)
    }
}

/// Why a text is not the size of a chart. The text says what to write instead.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum WidthError {
    /// Neither a name nor a number with a unit.
    #[error("write column, page or slide, or a width with its unit: 3.5in, 88mm, 8.8cm or 252pt")]
    Unread,
    /// Too narrow or too wide.
    #[error("a chart is 1.5in to 20in wide (38.1mm to 508mm, 108pt to 1440pt)")]
    Range,
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
