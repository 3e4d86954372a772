//! From a chart to files. The only place that knows pixels and the drawing library: plotters draws
//! coordinate systems, meshes and series into shapes, and writers turn shapes into SVG, PNG and
//! PDF.

mod backend;
mod beside;
mod coord;
mod diagram;
mod font;
pub mod labels;
mod legend;
mod marks;
mod names;
mod page;
mod panel;
pub(crate) mod pdf;
pub(crate) mod png;
pub mod scene;
mod shown;
pub(crate) mod svg;

use std::cell::RefCell;
use std::rc::Rc;

use plotters::coord::Shift;
use plotters::prelude::*;

use self::backend::{FINE, Recorder, fine};
use self::scene::{Hint, Rgb, Scene, ScenePoint, Shape, Text};
use crate::{Beside, Chart, Colour, Sheet, Style, Words};

/// Size of normal text: readable on a slide, and 7 points in print.
const TEXT: f64 = 18.0;
/// From one line of text to the next.
const LINE: f64 = 24.0;

/// A page is at most as high, page units.
const HIGHEST: f64 = 6000.0;

/// Characters that a line of text has at most.
const LONGEST: usize = 400;

/// Drawing failed, in the words of the library.
type Drawn = Result<(), String>;

/// Where things are on a page, page units.
#[derive(Debug, Clone, Copy)]
struct RenderFrame {
    /// Left edge of text.
    left: f64,
    /// Left edge of the panels with their axes.
    begin: f64,
    /// Right edge of everything.
    right: f64,
    /// Height of the page; `None`: as high as what is on it.
    height: Option<f64>,
    /// Whether there is a title.
    title: bool,
}

impl RenderFrame {
    fn of(style: Style) -> RenderFrame {
        let (width, height) = (style.sheet.width(), style.sheet.height());
        let (left, begin, margin) = match style.sheet {
            Sheet::Slide => (40.0, 38.0, 28.0),
            Sheet::Page | Sheet::Column | Sheet::Wide(_) => (8.0, 4.0, 10.0),
        };
        RenderFrame { left, begin, right: width - margin, height, title: style.title }
    }

    /// Whether panels stand above each other, and explanations below them.
    fn is_narrow(&self) -> bool {
        self.height.is_none()
    }
}

/// The page of a chart.
///
/// # Errors
/// Why a chart could not be drawn, in the words of the drawing library: a defect of this crate.
pub(crate) fn drawn(chart: &Chart, style: Style) -> Result<Scene, String> {
    let page = Page::new(style, series(chart));
    let height = page::draw(&page, chart)?;
    let shapes = page.shapes.take();
    let mut hints = page.hints.take();
    // The uppermost speak.
    hints.drain(..hints.len().saturating_sub(scene::HINTS));
    let (title, description) = (chart.title.clone(), chart.subtitle.clone());
    let size = (style.sheet.width(), height.ceil());
    Ok(Scene { size, sheet: style.sheet, title, description, shapes, hints })
}

/// What colours mean, for hints: a colour that means two things says nothing.
fn series(chart: &Chart) -> Vec<(Colour, String)> {
    let beside = chart.beside.iter().flat_map(|beside| match beside {
        Beside::Entries { entries, .. } => entries.as_slice(),
        Beside::Scale { .. } | Beside::List { .. } => &[],
    });
    let entries = chart.legend.iter().flatten().chain(beside);
    let named: Vec<(Colour, String)> =
        entries.filter_map(|entry| Some((entry.symbol.colour()?, entry.name.clone()))).collect();
    let is_one = |colour: Colour| named.iter().filter(|other| other.0 == colour).count() == 1;
    named.iter().filter(|(colour, _)| is_one(*colour)).cloned().collect()
}

/// The anchor of a text at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Align {
    Left,
    Centre,
    Right,
}

/// What surrounds letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Halo {
    None,
    /// So that lines below can still be followed.
    Thin,
    White,
}

impl Halo {
    fn width(self) -> f64 {
        match self {
            Halo::None => 0.0,
            Halo::Thin => 0.6 * scene::HALO,
            Halo::White => scene::HALO,
        }
    }
}

/// A page being drawn.
struct Page {
    /// The whole page for plotters.
    root: DrawingArea<Recorder, Shift>,
    frame: RenderFrame,
    shapes: Rc<RefCell<Vec<Shape>>>,
    hints: RefCell<Vec<Hint>>,
    /// Names of colours.
    series: Vec<(Colour, String)>,
}

impl Page {
    fn new(style: Style, series: Vec<(Colour, String)>) -> Page {
        let shapes: Rc<RefCell<Vec<Shape>>> = Rc::default();
        // What is too high for a page is cut off by whoever looks at it.
        let size = (fine(style.sheet.width()) as u32, fine(HIGHEST) as u32);
        let zoom = style.sheet.zoom();
        let root = Recorder { size, zoom, shapes: Rc::clone(&shapes) }.into_drawing_area();
        let hints = RefCell::default();
        Page { root, frame: RenderFrame::of(style), shapes, hints, series }
    }

    /// What a mark of a colour between two corners says to a pointer: what its colour means, and
    /// `values`.
    fn hint(&self, a: ScenePoint, b: ScenePoint, colour: Colour, values: [String; 2]) {
        /// What is thinner is hard to point at, page units.
        const LEAST: f64 = 6.0;
        let meaning = self.series.iter().find(|(known, _)| *known == colour);
        let words: Vec<&str> = meaning.iter().map(|(_, name)| name.as_str()).collect();
        let words = words.into_iter().chain(values.iter().map(String::as_str));
        let words = words.filter(|w| !w.is_empty()).collect::<Vec<_>>().join(" · ");
        let reach = |a: f64, b: f64| {
            let (middle, half) = ((a + b) / 2.0, ((a - b).abs() / 2.0).max(LEAST / 2.0));
            (middle - half, middle + half)
        };
        let ((l, r), (t, b)) = (reach(a.0, b.0), reach(a.1, b.1));
        self.hints.borrow_mut().push(Hint { area: [l, t, r, b], words });
    }

    fn push(&self, shape: Shape) {
        self.shapes.borrow_mut().push(shape);
    }

    /// Text of normal size, half-way up at a point.
    fn text(&self, words: &Words, at: ScenePoint, align: Align) {
        self.sized(words, at, align, TEXT, Halo::None);
    }

    /// As [`Page::text`], with white around the letters.
    fn over(&self, words: &Words, at: ScenePoint, align: Align) {
        self.sized(words, at, align, TEXT, Halo::White);
    }

    fn sized(&self, words: &Words, at: ScenePoint, align: Align, size: f64, halo: Halo) {
        if words.text.trim().is_empty() {
            return;
        }
        let width = font::width(&words.text, size, words.bold);
        let left = match align {
            Align::Left => 0.0,
            Align::Centre => width / 2.0,
            Align::Right => width,
        };
        let start = (at.0 - left, at.1 + font::MIDDLE * size);
        let fill = rgb(words.colour);
        let text = words.text.clone();
        let (bold, halo) = (words.bold, halo.width());
        self.push(Shape::Text(Text { text, start, width, size, bold, upwards: false, fill, halo }));
    }

    fn fill(&self, [l, t, r, b]: scene::Area, colour: Colour) -> Drawn {
        let corners = [fine_point((l, t)), fine_point((r, b))];
        self.root.draw(&Rectangle::new(corners, style(colour).filled())).map_err(failed)
    }

    fn line(&self, points: &[ScenePoint], colour: Colour, width: f64) -> Drawn {
        let points: Vec<_> = points.iter().copied().map(fine_point).collect();
        self.root.draw(&PathElement::new(points, stroke(colour, width))).map_err(failed)
    }

    fn dot(&self, centre: ScenePoint, radius: f64, colour: Colour) -> Drawn {
        let style = style(colour).filled();
        self.root.draw(&Circle::new(fine_point(centre), fine(radius), style)).map_err(failed)
    }
}

fn failed(error: impl std::fmt::Display) -> String {
    error.to_string()
}

fn fine_point((x, y): ScenePoint) -> (i32, i32) {
    (fine(x), fine(y))
}

fn rgb(Colour(r, g, b): Colour) -> Rgb {
    (r, g, b)
}

fn style(Colour(r, g, b): Colour) -> RGBColor {
    RGBColor(r, g, b)
}

/// A line of a width in page units.
fn stroke(colour: Colour, width: f64) -> ShapeStyle {
    style(colour).stroke_width((width * f64::from(FINE)) as u32)
}

/// Width of text of normal size, page units.
fn width(words: &Words) -> f64 {
    font::width(&words.text, TEXT, words.bold)
}

fn plain_width(text: &str) -> f64 {
    font::width(text, TEXT, false)
}

/// Cuts words to a width.
fn fitted(words: &Words, room: f64) -> Words {
    sized_to(words, room, TEXT)
}

fn sized_to(words: &Words, room: f64, size: f64) -> Words {
    // One line, whatever it came from.
    let whole = words.text.replace(['\n', '\r', '\t'], " ");
    let fits = |text: &str| font::width(text, size, words.bold) <= room;
    let length = whole.chars().count();
    if length <= LONGEST && fits(&whole) {
        return Words { text: whole, ..words.clone() };
    }
    // The longest beginning that fits is between these.
    let (mut fitting, mut too_long) = (1, length.min(LONGEST) + 1);
    while too_long - fitting > 1 {
        let middle = (fitting + too_long) / 2;
        if fits(&shortened(&whole, middle)) { fitting = middle } else { too_long = middle }
    }
    Words { text: shortened(&whole, fitting), ..words.clone() }
}

/// Words in lines of a width, at most `most` of them; the last ends with an ellipsis if there is
/// more. Lines end at spaces; in long words behind dots, dashes and strokes.
fn wrapped(words: &Words, room: f64, size: f64, most: usize) -> Vec<Words> {
    let fits = |text: &str| font::width(text.trim_end(), size, words.bold) <= room;
    let whole = words.text.replace(['\n', '\r', '\t'], " ");
    let mut lines: Vec<String> = vec![String::new()];
    let pieces = whole.split_inclusive(' ').flat_map(|word| {
        let joints: &[char] = if fits(word) { &[] } else { &['.', '-', '_', '/', '='] };
        word.split_inclusive(joints).collect::<Vec<_>>()
    });
    for piece in pieces.take(LONGEST) {
        let last = lines.len() - 1;
        let longer = format!("{}{piece}", lines[last]);
        if lines[last].is_empty() || lines.len() == most || fits(&longer) {
            lines[last] = longer;
        } else {
            lines.push(piece.to_owned());
        }
    }
    let line = |text: String| Words { text: text.trim_end().to_owned(), ..words.clone() };
    lines.into_iter().map(|text| sized_to(&line(text), room, size)).collect()
}

/// At most `width` characters, the last one an ellipsis if some were cut off.
fn shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.into();
    }
    let kept: String = text.chars().take(width.saturating_sub(1)).collect();
    format!("{}…", kept.trim_end())
}
