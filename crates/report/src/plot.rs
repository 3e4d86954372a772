//! The one place that knows the drawing library: fonts, lines, text, axes and legends.
//!
//! A chart is drawn once, as SVG, on a page of [`WIDTH`] x [`HEIGHT`]; the PNG is that SVG
//! rasterised at [`ZOOM`], so both look the same, and no system font is needed.

mod axes;
mod image;
mod scale;

pub use axes::{Panel, legend};
pub use image::Underlay;
pub use scale::{Scale, label as tick_label};

use std::sync::Once;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::ReportError;

/// Page width, SVG units.
pub const WIDTH: i32 = 1280;
/// Page height, SVG units.
pub const HEIGHT: i32 = 720;
/// PNG pixels per SVG unit, as a ratio: 1920 x 1080.
pub const ZOOM: (u32, u32) = (3, 2);

/// The drawing library knows whole numbers only, so it draws on a page this many times larger:
/// otherwise flat curves are stairs.
const FINE: i32 = 10;

/// Size of normal text: readable on a slide.
pub const TEXT: f64 = 18.0;
/// Size of the title.
const TITLE: f64 = 28.0;

/// Text.
pub const INK: RGBColor = RGBColor(34, 34, 34);
/// Text that is less important, and axes.
pub const GREY: RGBColor = RGBColor(96, 96, 96);
/// Grid lines.
pub const GRID: RGBColor = RGBColor(222, 222, 222);

/// Colours that people with any common colour vision can tell apart (Okabe and Ito).
pub mod palette {
    use plotters::style::RGBColor;

    /// Blue.
    pub const BLUE: RGBColor = RGBColor(0, 114, 178);
    /// Sky blue.
    pub const SKY: RGBColor = RGBColor(86, 180, 233);
    /// Bluish green.
    pub const GREEN: RGBColor = RGBColor(0, 158, 115);
    /// Orange.
    pub const ORANGE: RGBColor = RGBColor(230, 159, 0);
    /// Yellow.
    pub const YELLOW: RGBColor = RGBColor(240, 228, 66);
    /// Vermilion.
    pub const VERMILION: RGBColor = RGBColor(213, 94, 0);
    /// Reddish purple.
    pub const PURPLE: RGBColor = RGBColor(204, 121, 167);
    /// Indigo (Tol), the darkest.
    pub const INDIGO: RGBColor = RGBColor(51, 34, 136);
    /// Light grey, for what is not there.
    pub const PALE: RGBColor = RGBColor(221, 221, 221);
    /// Middle grey.
    pub const GREY: RGBColor = RGBColor(140, 140, 140);
}

/// Where text is relative to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// The point is at its left end, half-way up.
    Left,
    /// The point is in its middle.
    Centre,
    /// The point is at its right end, half-way up.
    Right,
    /// As [`Align::Centre`], reading upwards.
    Upwards,
}

/// Drawing failed, in the words of the library.
pub type Drawn = Result<(), String>;

/// A page being drawn.
pub struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

impl Canvas<'_> {
    /// A filled rectangle.
    pub fn fill(&self, (x0, y0): (f64, f64), (x1, y1): (f64, f64), colour: RGBColor) -> Drawn {
        let corners = [point((x0, y0)), point((x1, y1))];
        self.area.draw(&Rectangle::new(corners, colour.filled())).map_err(|e| e.to_string())
    }

    /// A line through `points`; one that is level or upright lies on whole units, so that it is
    /// sharp.
    pub fn line(&self, points: &[(f64, f64)], colour: RGBColor, width: u32) -> Drawn {
        let place = match points {
            [a, b] if a.0 == b.0 || a.1 == b.1 => point,
            _ => fine_point,
        };
        let points: Vec<_> = points.iter().copied().map(place).collect();
        let style = colour.stroke_width(width * FINE as u32);
        self.area.draw(&PathElement::new(points, style)).map_err(|e| e.to_string())
    }

    /// A dot.
    pub fn dot(&self, centre: (f64, f64), radius: u32, colour: RGBColor) -> Drawn {
        self.area
            .draw(&Circle::new(fine_point(centre), radius * FINE as u32, colour.filled()))
            .map_err(|e| e.to_string())
    }

    /// Text of normal size.
    pub fn text(&self, text: &str, at: (f64, f64), align: Align, colour: RGBColor) -> Drawn {
        self.styled(text, at, align, colour, TEXT, FontStyle::Normal)
    }

    /// Bold text of normal size.
    pub fn bold(&self, text: &str, at: (f64, f64), align: Align, colour: RGBColor) -> Drawn {
        self.styled(text, at, align, colour, TEXT, FontStyle::Bold)
    }

    fn styled(
        &self,
        text: &str,
        at: (f64, f64),
        align: Align,
        colour: RGBColor,
        size: f64,
        weight: FontStyle,
    ) -> Drawn {
        // The SVG backend divides font sizes by 1.24.
        let mut font = FontDesc::new(FontFamily::SansSerif, size * f64::from(FINE) * 1.24, weight);
        if align == Align::Upwards {
            font = font.transform(FontTransform::Rotate270);
        }
        let h = match align {
            Align::Left => HPos::Left,
            Align::Right => HPos::Right,
            Align::Centre | Align::Upwards => HPos::Center,
        };
        let style = TextStyle::from(font).color(&colour).pos(Pos::new(h, VPos::Center));
        let result = self.area.draw_text(text, &style, point(at));
        result.map_err(|e| e.to_string())
    }
}

/// On whole units.
fn point((x, y): (f64, f64)) -> (i32, i32) {
    (x.round() as i32 * FINE, y.round() as i32 * FINE)
}

fn fine_point((x, y): (f64, f64)) -> (i32, i32) {
    let fine = |v: f64| (v * f64::from(FINE)).round() as i32;
    (fine(x), fine(y))
}

/// Width of `text` of normal size, SVG units.
pub fn text_width(text: &str) -> f64 {
    register_fonts();
    // The library takes the line height for the size; that of this font is 1.164 em.
    let font = FontDesc::new(FontFamily::SansSerif, TEXT * 1.164, FontStyle::Normal);
    font.box_size(text).map_or(0.0, |(width, _)| f64::from(width))
}

/// Cuts `text` to `width` SVG units.
pub fn fitted(text: &str, width: f64) -> String {
    let mut length = text.chars().count();
    let mut fitted = super::format::shortened(text, length);
    while length > 1 && text_width(&fitted) > width {
        length -= 1;
        fitted = super::format::shortened(text, length);
    }
    fitted
}

/// Makes the fonts known to the library; it measures text even for SVG.
fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let fonts =
            [(FontStyle::Normal, dejavu::sans::regular()), (FontStyle::Bold, dejavu::sans::bold())];
        for (style, data) in fonts {
            // Its error has no text; a font that does not load shows as a chart error later.
            let _ = plotters::style::register_font("sans-serif", style, data);
        }
    });
}

/// A page: its heading and its drawing.
#[derive(Debug, Clone)]
pub struct Page {
    /// Name of the chart, for errors.
    pub name: &'static str,
    /// What the chart shows.
    pub title: String,
    /// One line of context under the title.
    pub subtitle: String,
    /// A raster image below the drawing.
    pub underlay: Option<Underlay>,
}

impl Page {
    /// Draws the page.
    pub fn draw(self, drawing: impl FnOnce(&Canvas) -> Drawn) -> Result<Drawing, ReportError> {
        register_fonts();
        let mut svg = String::new();
        let failed = |reason: String| ReportError::Chart { chart: self.name, reason };
        self.draw_into(&mut svg, drawing).map_err(failed)?;
        // Viewers that do not have a font called sans-serif in mind get one of the same widths.
        let svg = svg.replace("\"sans-serif\"", "\"DejaVu Sans, Verdana, Geneva, sans-serif\"");
        let svg = scaled(&svg).ok_or_else(|| failed("no SVG".into()))?;
        Ok(Drawing { name: self.name, svg, underlay: self.underlay })
    }

    fn draw_into(&self, svg: &mut String, drawing: impl FnOnce(&Canvas) -> Drawn) -> Drawn {
        let size = ((WIDTH * FINE) as u32, (HEIGHT * FINE) as u32);
        let area = SVGBackend::with_string(svg, size).into_drawing_area();
        let canvas = Canvas { area };
        let room = f64::from(WIDTH) - 80.0;
        let title = fitted(&self.title, room * TEXT / TITLE * 0.95);
        canvas.styled(&title, (40.0, 38.0), Align::Left, INK, TITLE, FontStyle::Bold)?;
        canvas.text(&fitted(&self.subtitle, room), (40.0, 72.0), Align::Left, GREY)?;
        drawing(&canvas)?;
        canvas.area.present().map_err(|e| e.to_string())
    }
}

/// The large page, shrunk to its size.
fn scaled(svg: &str) -> Option<String> {
    let (_, rest) = svg.split_once(">\n")?;
    let body = rest.trim_end().strip_suffix("</svg>")?;
    let shrink = 1.0 / f64::from(FINE);
    Some(format!(
        "<svg width=\"{WIDTH}\" height=\"{HEIGHT}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         xmlns=\"http://www.w3.org/2000/svg\">\n<g transform=\"scale({shrink})\">\n\
         {body}</g>\n</svg>\n"
    ))
}

/// A finished drawing.
#[derive(Debug, Clone)]
pub struct Drawing {
    name: &'static str,
    /// Without background and underlay.
    svg: String,
    underlay: Option<Underlay>,
}

impl Drawing {
    /// As SVG.
    pub fn svg(&self) -> Result<String, ReportError> {
        image::with_background(&self.svg, self.underlay.as_ref()).map_err(|e| self.failed(e))
    }

    /// As PNG.
    pub fn png(&self) -> Result<Vec<u8>, ReportError> {
        image::png(&self.svg, self.underlay.as_ref()).map_err(|e| self.failed(e))
    }

    fn failed(&self, reason: String) -> ReportError {
        ReportError::Chart { chart: self.name, reason }
    }
}
