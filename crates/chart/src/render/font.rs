//! Text as outlines of one font, DejaVu Sans in two weights: no system fonts are needed, and every
//! writer agrees on widths.

use std::sync::LazyLock;

use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// Height of capital letters, of an em.
const CAPITALS: f64 = 0.729;
/// Height of small letters, of an em.
const SMALL: f64 = 0.547;

/// From the middle of a line of text down to its base line, of an em: between the middle of
/// capitals and that of small letters.
pub(crate) const MIDDLE: f64 = (CAPITALS + SMALL) / 4.0;

/// A weight of the font.
struct FontWeight {
    face: Face<'static>,
    /// Units of the outlines in an em.
    units: f64,
}

fn weight(bold: bool) -> &'static FontWeight {
    static NORMAL: LazyLock<FontWeight> = LazyLock::new(|| read(dejavu::sans::regular()));
    static BOLD: LazyLock<FontWeight> = LazyLock::new(|| read(dejavu::sans::bold()));
    if bold { &BOLD } else { &NORMAL }
}

fn read(bytes: &'static [u8]) -> FontWeight {
    let face = Face::parse(bytes, 0).expect("the font that is part of the program");
    FontWeight { units: f64::from(face.units_per_em()), face }
}

/// Takes the outlines of letters, page units relative to the left end of the base line; y grows
/// upwards.
pub(crate) trait Pen {
    /// Begins a contour.
    fn start(&mut self, x: f64, y: f64);
    /// A straight line.
    fn line(&mut self, x: f64, y: f64);
    /// A quadratic curve with one control point.
    fn curve(&mut self, x1: f64, y1: f64, x: f64, y: f64);
    /// Closes the contour.
    fn close(&mut self);
}

/// Moves and scales the outline of a letter.
struct Placed<'a, P: Pen> {
    pen: &'a mut P,
    left: f64,
    scale: f64,
}

impl<P: Pen> OutlineBuilder for Placed<'_, P> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.pen.start(self.left + f64::from(x) * self.scale, f64::from(y) * self.scale);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.pen.line(self.left + f64::from(x) * self.scale, f64::from(y) * self.scale);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (s, left) = (self.scale, self.left);
        let [x1, y1, x, y] = [x1, y1, x, y].map(f64::from);
        self.pen.curve(left + x1 * s, y1 * s, left + x * s, y * s);
    }

    fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, x: f32, y: f32) {
        // TrueType outlines have no cubic curves.
        self.line_to(x, y);
    }

    fn close(&mut self) {
        self.pen.close();
    }
}

/// Letters with their left edges, and the width of all; units of the font.
fn laid_out(text: &str, weight: &FontWeight) -> (Vec<(GlyphId, f64)>, f64) {
    let face = &weight.face;
    let kerning = face.tables().kern;
    let mut letters: Vec<(GlyphId, f64)> = Vec::new();
    let mut at = 0.0;
    for c in text.chars() {
        let glyph = face.glyph_index(c).unwrap_or(GlyphId(0));
        if let (Some((before, _)), Some(kerning)) = (letters.last(), kerning) {
            let tables = kerning.subtables.into_iter().filter(|t| t.horizontal);
            let closer = tables.filter_map(|t| t.glyphs_kerning(*before, glyph)).next();
            at += f64::from(closer.unwrap_or(0));
        }
        letters.push((glyph, at));
        at += f64::from(face.glyph_hor_advance(glyph).unwrap_or(0));
    }
    (letters, at)
}

/// Width of `text` with an em of `size`, in the unit of `size`.
pub(crate) fn width(text: &str, size: f64, bold: bool) -> f64 {
    let weight = weight(bold);
    laid_out(text, weight).1 * size / weight.units
}

/// Draws `text` with an em of `size`.
pub(crate) fn draw(text: &str, size: f64, bold: bool, pen: &mut impl Pen) {
    let weight = weight(bold);
    let scale = size / weight.units;
    for (glyph, left) in laid_out(text, weight).0 {
        let mut placed = Placed { pen: &mut *pen, left: left * scale, scale };
        weight.face.outline_glyph(glyph, &mut placed);
    }
}
