//! Charts as values, in the units of the data. A chart knows no pixel; the renderer lays it out and
//! writes SVG, PNG and PDF.

mod axis;
mod colour;
mod diagram;
mod mark;
pub mod render;
mod scheme;
mod style;
pub use axis::{Axis, Name, Scale, Ticks, ends, label as tick_label};
pub use colour::Colour;
pub use diagram::{Diagram, DiagramBlock};
pub use mark::{
    Bar, Bin, Cell, Form, Gauge, Label, Line, Mark, Part, Place, Points, Rule, Side, Size, Span,
    Weight,
};
pub use scheme::dark_declarations;
pub use style::{Format, PrintWidth, Sheet, Style, WidthError};

use powergs_pixels::RgbImage;
use scheme::SchemeColours;

/// A chart: a title, panels with axes, and what explains them.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// File name without ending.
    pub name: &'static str,
    /// What it shows.
    pub title: String,
    /// One line of context under the title.
    pub subtitle: String,
    /// Rows of what colours and symbols mean, over the panels; what no panel shows is left out.
    pub legend: Vec<Vec<Entry>>,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
    /// A block diagram in place of panels.
    pub diagram: Option<Diagram>,
    /// Number of panels side by side.
    pub columns: Columns,
    /// What explains them in a column at the right.
    pub beside: Vec<Beside>,
    /// Lines under the panels, each of one or more texts.
    pub notes: Vec<Vec<Words>>,
}

/// Number of panels side by side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Columns {
    /// This number.
    Are(usize),
    /// The number with which pictures are largest.
    Fitting,
}

impl Chart {
    /// A chart without panels.
    pub fn new(name: &'static str, title: impl Into<String>, subtitle: impl Into<String>) -> Chart {
        Chart {
            name,
            title: title.into(),
            subtitle: subtitle.into(),
            legend: Vec::new(),
            panels: Vec::new(),
            diagram: None,
            columns: Columns::Are(1),
            beside: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// With one more row of the legend.
    pub fn legend(mut self, entries: impl IntoIterator<Item = Entry>) -> Chart {
        self.legend.push(entries.into_iter().collect());
        self
    }

    /// With one more panel.
    pub fn panel(mut self, panel: Panel) -> Chart {
        self.panels.push(panel);
        self
    }

    /// With this number of panels side by side.
    pub fn columns(self, columns: usize) -> Chart {
        Chart { columns: Columns::Are(columns), ..self }
    }

    /// With one more explanation at the right.
    pub fn beside(mut self, beside: Beside) -> Chart {
        self.beside.push(beside);
        self
    }

    /// With one more line under the panels.
    pub fn note(mut self, text: impl Into<String>) -> Chart {
        self.notes.push(vec![Words::new(text, Colour::NOTE)]);
        self
    }

    /// As shapes, for whoever wants to know what lies where.
    ///
    /// # Errors
    /// [`DrawError`]: a defect of this crate.
    pub fn scene(&self, style: Style) -> Result<render::scene::Scene, DrawError> {
        render::drawn(self, style).map_err(|reason| self.failed(reason))
    }

    /// As SVG.
    ///
    /// # Errors
    /// [`DrawError`]: a defect of this crate.
    pub fn svg(&self, style: Style) -> Result<String, DrawError> {
        let svg = render::svg::svg(&self.scene(style)?, SchemeColours::Fixed);
        svg.map_err(|reason| self.failed(reason))
    }

    /// As SVG inside of a page: colours follow the page where it declares [`dark_declarations`];
    /// those of scales and pictures are the same in every page.
    ///
    /// # Errors
    /// [`DrawError`]: a defect of this crate.
    pub fn page_svg(&self, style: Style) -> Result<String, DrawError> {
        let svg = render::svg::svg(&self.scene(style)?, SchemeColours::OfPage);
        svg.map_err(|reason| self.failed(reason))
    }

    /// As PNG; a slide has 1920 x 1080 pixels.
    ///
    /// # Errors
    /// [`DrawError`]: a defect of this crate.
    pub fn png(&self, style: Style) -> Result<Vec<u8>, DrawError> {
        render::png::png(&self.scene(style)?).map_err(|reason| self.failed(reason))
    }

    /// As PDF of one page.
    ///
    /// # Errors
    /// [`DrawError`]: a defect of this crate.
    pub fn pdf(&self, style: Style) -> Result<Vec<u8>, DrawError> {
        render::pdf::pdf(&self.scene(style)?).map_err(|reason| self.failed(reason))
    }

    fn failed(&self, reason: String) -> DrawError {
        DrawError { chart: self.name, reason }
    }
}

/// A chart could not be drawn: a defect of this crate.
#[derive(Debug, thiserror::Error)]
#[error("chart {chart}: {reason}; please report this")]
pub struct DrawError {
    /// Name of the chart.
    pub chart: &'static str,
    /// What the drawing library said.
    pub reason: String,
}

/// Text with a colour and a weight.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Words {
    /// The text.
    pub text: String,
    /// Its colour.
    pub colour: Colour,
    /// Whether it is bold.
    pub bold: bool,
}

impl Words {
    /// Text in a colour.
    pub fn new(text: impl Into<String>, colour: Colour) -> Words {
        Words { text: text.into(), colour, bold: false }
    }

    /// Bold text.
    pub fn bold(text: impl Into<String>) -> Words {
        Words { bold: true, ..Words::new(text, Colour::INK) }
    }

    /// Text that is less important.
    pub fn note(text: impl Into<String>) -> Words {
        Words::new(text, Colour::NOTE)
    }
}

impl From<&str> for Words {
    fn from(text: &str) -> Words {
        Words::new(text, Colour::INK)
    }
}

impl From<String> for Words {
    fn from(text: String) -> Words {
        Words::new(text, Colour::INK)
    }
}

/// An entry of a legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// What it means.
    pub name: String,
    /// What stands before it.
    pub symbol: Symbol,
}

impl Symbol {
    /// The colour of the marks that it stands for.
    pub(crate) fn colour(self) -> Option<Colour> {
        match self {
            Symbol::Fill(colour)
            | Symbol::Dot(colour)
            | Symbol::Ring(colour, _)
            | Symbol::Square(colour)
            | Symbol::Line(colour)
            | Symbol::Curve(colour)
            | Symbol::Dashed(colour) => Some(colour),
            Symbol::None => None,
        }
    }
}

/// What stands in a legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symbol {
    /// A filled square.
    Fill(Colour),
    /// A dot.
    Dot(Colour),
    /// A dot in a ring.
    Ring(Colour, Colour),
    /// A small square.
    Square(Colour),
    /// A line.
    Line(Colour),
    /// A line with a dot.
    Curve(Colour),
    /// A dashed line.
    Dashed(Colour),
    /// Nothing: the name is a note.
    None,
}

impl Entry {
    /// An entry.
    pub fn new(name: impl Into<String>, symbol: Symbol) -> Entry {
        Entry { name: name.into(), symbol }
    }

    /// An entry for what is filled.
    pub fn fill(name: impl Into<String>, colour: Colour) -> Entry {
        Entry::new(name, Symbol::Fill(colour))
    }

    /// A note among the entries.
    pub fn note(text: impl Into<String>) -> Entry {
        Entry::new(text, Symbol::None)
    }
}

/// What explains a chart in a column at its right.
#[derive(Debug, Clone, PartialEq)]
pub enum Beside {
    /// A legend.
    Entries {
        /// Its heading; may be empty.
        title: String,
        /// Its entries.
        entries: Vec<Entry>,
    },
    /// The colours of [`Colour::at`].
    Scale {
        /// What they show.
        title: String,
        /// Shares of the scale with their labels, from 0 at the bottom to 1.
        labels: Vec<(f64, String)>,
    },
    /// A numbered list with values.
    List {
        /// What the values are.
        title: String,
        /// Names with values, in the order of their numbers from 1.
        rows: Vec<(String, String)>,
    },
}

/// A panel: two axes and marks.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Its heading; may be empty.
    pub heading: Words,
    /// What stands over its right end.
    pub remark: Option<Words>,
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What it shows.
    pub marks: Vec<Mark>,
    /// Texts over the panel at values of the horizontal axis, with the room that each has there.
    pub over: Vec<(f64, f64, Words)>,
    /// Texts right of the panel at values of the vertical axis, one or more lines each.
    pub right: Vec<(f64, Vec<Words>)>,
    /// A scale of the colours of [`Colour::at`] over the panel: its ends.
    pub colours: Option<(String, String)>,
    /// Width over height of a plot that must not be stretched.
    pub aspect: Option<f64>,
}

impl Panel {
    /// An empty panel.
    pub fn new(x: Axis, y: Axis) -> Panel {
        Panel {
            heading: Words::from(""),
            remark: None,
            x,
            y,
            marks: Vec::new(),
            over: Vec::new(),
            right: Vec::new(),
            colours: None,
            aspect: None,
        }
    }

    /// A picture with a caption; the values of the axes are its pixels, downwards from the upper
    /// left corner.
    pub fn picture(image: RgbImage, caption: impl Into<Words>) -> Panel {
        Panel::pixels(image, caption, false)
    }

    /// As [`Panel::picture`], with pixels that have sharp edges however large they are shown.
    pub fn mosaic(image: RgbImage, caption: impl Into<Words>) -> Panel {
        Panel::pixels(image, caption, true)
    }

    fn pixels(image: RgbImage, caption: impl Into<Words>, sharp: bool) -> Panel {
        let (w, h) = (image.width(), image.height());
        let (w, h) = (f64::from(w.max(1)), f64::from(h.max(1)));
        let x = Axis::new("", Scale::linear(0.0, w)).hidden();
        let y = Axis::new("", Scale::linear(h, 0.0)).hidden();
        let marks = vec![Mark::Image { image, sharp }];
        Panel { heading: caption.into(), marks, aspect: Some(w / h), ..Panel::new(x, y) }
    }

    /// With a heading.
    pub fn heading(self, heading: impl Into<Words>) -> Panel {
        Panel { heading: heading.into(), ..self }
    }

    /// With one more mark.
    pub fn mark(mut self, mark: Mark) -> Panel {
        self.marks.push(mark);
        self
    }

    /// With one more line.
    pub fn line(self, line: Line) -> Panel {
        self.mark(Mark::Line(line))
    }

    /// With more points.
    pub fn points(self, points: Points) -> Panel {
        self.mark(Mark::Points(points))
    }

    /// With one more label.
    pub fn label(self, words: impl Into<Words>, at: Place, side: Side) -> Panel {
        self.mark(Mark::Label(Label { words: words.into(), at, side }))
    }

    /// With a dashed line across.
    pub fn dashed(self, at: Rule, colour: Colour) -> Panel {
        self.mark(Mark::Rule { at, colour, dashed: true })
    }
}
