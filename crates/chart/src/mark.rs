//! The marks of a panel, in the values of its axes.

use powergs_pixels::RgbImage;

use super::{Colour, Words};

/// A place in the values of both axes: across, up.
pub type Place = (f64, f64);

/// Something that a panel shows. Later marks cover earlier ones; labels are always on top.
#[derive(Debug, Clone, PartialEq)]
pub enum Mark {
    /// Stacked bars along an axis of names, from zero.
    Bars(Vec<Bar>),
    /// Pairs of bars to both sides of zero along a vertical axis of names.
    Tornado {
        /// A pair for each name.
        rows: Vec<[Option<f64>; 2]>,
        /// The colours of a pair.
        colours: [Colour; 2],
    },
    /// Upright bars from the bottom, of any width.
    Histogram {
        /// The bars, from left to right.
        bins: Vec<Bin>,
        /// Whether bars have an outline; otherwise a gap parts them.
        outlined: bool,
    },
    /// A line through points.
    Line(Line),
    /// Single points.
    Points(Points),
    /// Coloured cells at places of two axes of names.
    Heat(Vec<Cell>),
    /// Stretches of time on tracks along a vertical axis of names.
    Spans {
        /// The stretches.
        spans: Vec<Span>,
        /// Numbers in the middle of stretches where they fit.
        labels: Vec<(Span, String)>,
    },
    /// A picture over the whole panel.
    Image {
        /// Its pixels.
        image: RgbImage,
        /// Whether they have sharp edges when they are shown large.
        sharp: bool,
    },
    /// A line across the panel.
    Rule {
        /// Where.
        at: Rule,
        /// Its colour.
        colour: Colour,
        /// Whether it is dashed.
        dashed: bool,
    },
    /// A text beside a point.
    Label(Label),
    /// A cross that is seen on any picture.
    Cross(Place),
    /// An upright axis inside the panel, with values beside it that lines may pass under.
    Gauge(Gauge),
}

/// An upright axis inside a panel.
#[derive(Debug, Clone, PartialEq)]
pub struct Gauge {
    /// Where it is, in the values of the horizontal axis.
    pub at: f64,
    /// Heights in the values of the vertical axis, with their labels.
    pub labels: Vec<(f64, String)>,
}

/// A stacked bar.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bar {
    /// Which name of the axis it belongs to.
    pub row: usize,
    /// Which of how many bars side by side it is at its name; `(0, 1)` is alone.
    pub lane: (usize, usize),
    /// Its parts, from zero on.
    pub parts: Vec<Part>,
    /// What stands behind its end; may be empty.
    pub end: String,
    /// An interval around its end.
    pub interval: Option<(f64, f64)>,
}

impl Bar {
    /// A bar that is alone at its name.
    pub fn new(row: usize, parts: Vec<Part>) -> Bar {
        Bar { row, lane: (0, 1), parts, ..Bar::default() }
    }

    /// With a text behind its end.
    pub fn end(self, end: impl Into<String>) -> Bar {
        Bar { end: end.into(), ..self }
    }
}

/// A part of a stacked bar.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// How long it is.
    pub value: f64,
    /// Its colour.
    pub colour: Colour,
    /// What stands in it where there is room; may be empty.
    pub label: String,
}

impl Part {
    /// A part without text.
    pub fn new(value: f64, colour: Colour) -> Part {
        Part { value, colour, label: String::new() }
    }
}

/// A bar of a histogram.
#[derive(Debug, Clone, PartialEq)]
pub struct Bin {
    /// Its left edge.
    pub from: f64,
    /// Its right edge.
    pub to: f64,
    /// Its height.
    pub height: f64,
    /// Its colour.
    pub colour: Colour,
    /// What stands above it, or right of it where that has room; may be empty.
    pub label: String,
}

/// How wide a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weight {
    /// A faint line.
    Hair,
    /// Thinner than a curve.
    Thin,
    /// A curve.
    Curve,
    /// The most important curve.
    Bold,
}

/// A line through points; it breaks at values that are not finite.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// The points.
    pub points: Vec<Place>,
    /// Its colour.
    pub colour: Colour,
    /// How wide it is.
    pub weight: Weight,
    /// Whether it is dashed.
    pub dashed: bool,
}

impl Line {
    /// A curve.
    pub fn curve(points: Vec<Place>, colour: Colour) -> Line {
        Line { points, colour, weight: Weight::Curve, dashed: false }
    }

    /// A thin line.
    pub fn thin(points: Vec<Place>, colour: Colour) -> Line {
        Line { weight: Weight::Thin, ..Line::curve(points, colour) }
    }
}

/// The shape of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Round.
    Dot,
    /// Square.
    Square,
}

/// How large points are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// One of hundreds.
    Small,
    /// A point of a curve.
    Medium,
    /// A point that has a name.
    Large,
    /// The most important point.
    Huge,
}

/// Points of one shape and size.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    /// Where they are, and their colours.
    pub points: Vec<(Place, Colour)>,
    /// Their shape.
    pub form: Form,
    /// Their size.
    pub size: Size,
    /// The colour of a ring around them.
    pub ring: Option<Colour>,
    /// Whether they are so many that labels may cover them.
    pub crowd: bool,
}

impl Points {
    /// Dots of one colour.
    pub fn dots(places: impl IntoIterator<Item = Place>, colour: Colour, size: Size) -> Points {
        let points = places.into_iter().map(|p| (p, colour)).collect();
        Points { points, form: Form::Dot, size, ring: None, crowd: false }
    }
}

/// A cell of a heat map.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Name of the horizontal axis.
    pub column: usize,
    /// Name of the vertical axis.
    pub row: usize,
    /// Its colour.
    pub colour: Colour,
    /// What stands in it where there is room; may be empty.
    pub label: String,
    /// The colour of a dot in it, and whether it is the one to look at first.
    pub dot: Option<(Colour, bool)>,
}

/// A stretch on a track.
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Name of the vertical axis.
    pub track: usize,
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// Its colour.
    pub colour: Colour,
}

/// Where a line across the panel is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rule {
    /// Upright, at a value of the horizontal axis.
    X(f64),
    /// Level, at a value of the vertical axis.
    Y(f64),
}

/// On which side of its point a label should be. It is elsewhere if it would cover a mark or
/// another label there, and left out where there is no free place at all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Wherever it is nearest.
    Free,
    /// Right of the point.
    Right,
    /// Left of the point.
    Left,
    /// Above it.
    Above,
    /// Below it.
    Below,
    /// Above it and to its left.
    AboveLeft,
    /// Below it and to its left.
    BelowLeft,
    /// Above it and to its right.
    AboveRight,
}

/// A text beside a point.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// The text.
    pub words: Words,
    /// The point.
    pub at: Place,
    /// On which side of it.
    pub side: Side,
}
