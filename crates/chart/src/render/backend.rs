//! The backend that plotters draws into: it keeps shapes instead of pixels.

use std::cell::RefCell;
use std::convert::Infallible;
use std::rc::Rc;

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
    FontStyle, FontTransform,
};

use super::font;
use super::scene::{Area, Rgb, ScenePoint, Shape, Text};

/// Plotters knows whole numbers only, so it draws on a page this many times larger: otherwise flat
/// curves are stairs.
pub(crate) const FINE: i32 = 10;

/// Page units as backend units.
pub(crate) fn fine(v: f64) -> i32 {
    (v * f64::from(FINE)).round() as i32
}

/// Backend units as page units.
fn coarse(v: i32) -> f64 {
    f64::from(v) / f64::from(FINE)
}

fn point((x, y): BackendCoord) -> ScenePoint {
    (coarse(x), coarse(y))
}

/// On the edges of PNG pixels: neighbours touch without a seam.
fn snapped(v: f64, zoom: f32) -> f64 {
    (v * f64::from(zoom)).round() / f64::from(zoom)
}

fn rgb(colour: BackendColor) -> Rgb {
    colour.rgb
}

type Result = std::result::Result<(), DrawingErrorKind<Infallible>>;

/// The backend. Its shapes are shared, so that they outlive the drawing area that owns it.
pub(crate) struct Recorder {
    /// Backend units.
    pub size: (u32, u32),
    /// Pixels of a PNG per page unit.
    pub zoom: f32,
    /// The shapes drawn so far.
    pub shapes: Rc<RefCell<Vec<Shape>>>,
}

impl Recorder {
    fn keep(&mut self, colour: BackendColor, shape: Shape) -> Result {
        if colour.alpha > 0.0 {
            self.shapes.borrow_mut().push(shape);
        }
        Ok(())
    }

    fn stroke<S: BackendStyle>(&mut self, points: Vec<ScenePoint>, style: &S) -> Result {
        let colour = style.color();
        let width = f64::from(style.stroke_width()) / f64::from(FINE);
        self.keep(colour, Shape::Line { points, stroke: rgb(colour), width })
    }
}

impl DrawingBackend for Recorder {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Result {
        Ok(())
    }

    fn present(&mut self) -> Result {
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, colour: BackendColor) -> Result {
        let area: Area = [coarse(x), coarse(y), coarse(x + 1), coarse(y + 1)];
        self.keep(colour, Shape::Rectangle { area, fill: rgb(colour) })
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Result {
        self.stroke(vec![point(from), point(to)], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        a: BackendCoord,
        b: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Result {
        let ((x0, y0), (x1, y1)) = (point(a), point(b));
        if !fill {
            return self.stroke(vec![(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)], style);
        }
        let [x0, x1, y0, y1] = [x0, x1, y0, y1].map(|v| snapped(v, self.zoom));
        let area = [x0.min(x1), y0.min(y1), x0.max(x1), y0.max(y1)];
        if area[0] == area[2] || area[1] == area[3] {
            return Ok(());
        }
        self.keep(style.color(), Shape::Rectangle { area, fill: rgb(style.color()) })
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Result {
        self.stroke(path.into_iter().map(point).collect(), style)
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        centre: BackendCoord,
        radius: u32,
        style: &S,
        _: bool,
    ) -> Result {
        let radius = f64::from(radius) / f64::from(FINE);
        let fill = rgb(style.color());
        self.keep(style.color(), Shape::Circle { centre: point(centre), radius, fill })
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Result {
        let points = corners.into_iter().map(point).collect();
        self.keep(style.color(), Shape::Polygon { points, fill: rgb(style.color()) })
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        at: BackendCoord,
    ) -> Result {
        if text.trim().is_empty() {
            return Ok(());
        }
        let size = style.size() / f64::from(FINE);
        let bold = matches!(style.style(), FontStyle::Bold);
        let upwards = matches!(style.transform(), FontTransform::Rotate270);
        let width = font::width(text, size, bold);
        let along = match style.anchor().h_pos {
            HPos::Left => 0.0,
            HPos::Center => -width / 2.0,
            HPos::Right => -width,
        };
        let across = match style.anchor().v_pos {
            VPos::Top => 0.9 * size,
            VPos::Center => font::MIDDLE * size,
            VPos::Bottom => -0.25 * size,
        };
        let (x, y) = point(at);
        let start = if upwards { (x + across, y - along) } else { (x + along, y + across) };
        let fill = rgb(style.color());
        let text = Text { text: text.into(), start, width, size, bold, upwards, fill, halo: 0.0 };
        self.keep(style.color(), Shape::Text(text))
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> std::result::Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let bold = matches!(style.style(), FontStyle::Bold);
        let width = font::width(text, style.size(), bold);
        Ok((width.ceil() as u32, style.size().ceil() as u32))
    }
}
