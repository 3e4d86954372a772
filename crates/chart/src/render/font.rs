//! Text in one font, DejaVu Sans in two weights: no system fonts are needed, and every writer
//! agrees on widths.

use std::sync::LazyLock;

use skrifa::instance::{LocationRef, Size};
use skrifa::metrics::GlyphMetrics;
use skrifa::outline::{DrawSettings, OutlinePen};
use skrifa::raw::TableProvider;
use skrifa::raw::tables::kern::{Subtable0, SubtableKind};
use skrifa::{FontRef, GlyphId, MetadataProvider};

/// Height of capital letters, of an em.
const CAPITALS: f64 = 0.729;
/// Height of small letters, of an em.
const SMALL: f64 = 0.547;

/// From the middle of a line of text down to its base line, of an em: between the middle of
/// capitals and that of small letters.
pub(crate) const MIDDLE: f64 = (CAPITALS + SMALL) / 4.0;

/// A weight of the font.
struct FontWeight {
    face: FontRef<'static>,
    widths: GlyphMetrics<'static>,
    kerning: Vec<Subtable0<'static>>,
    /// Units of the outlines in an em.
    units: f64,
}

/// The file of a weight.
pub(crate) fn file(bold: bool) -> &'static [u8] {
    if bold { dejavu::sans::bold() } else { dejavu::sans::regular() }
}

fn weight(bold: bool) -> &'static FontWeight {
    static NORMAL: LazyLock<FontWeight> = LazyLock::new(|| read(file(false)));
    static BOLD: LazyLock<FontWeight> = LazyLock::new(|| read(file(true)));
    if bold { &BOLD } else { &NORMAL }
}

fn read(bytes: &'static [u8]) -> FontWeight {
    let face = FontRef::new(bytes).expect("the font that is part of the program");
    let units = face.metrics(Size::unscaled(), LocationRef::default()).units_per_em;
    let tables = face.kern().ok();
    let tables = tables.iter().flat_map(|kern| kern.subtables()).filter_map(Result::ok);
    let pairs =
        tables.filter(|table| table.is_horizontal()).filter_map(|table| match table.kind() {
            Ok(SubtableKind::Format0(pairs)) => Some(pairs),
            _ => None,
        });
    FontWeight {
        kerning: pairs.collect(),
        widths: face.glyph_metrics(Size::unscaled(), LocationRef::default()),
        units: f64::from(units),
        face,
    }
}

/// A letter of a line of text.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Letter {
    /// Its number in the font.
    pub glyph: u32,
    /// Where it is in the text.
    pub at: usize,
    /// Its left edge and how far it is to the next one, ems.
    pub left: f64,
    /// See `left`.
    pub advance: f64,
}

/// The letters of a line of text.
pub(crate) fn letters(text: &str, bold: bool) -> Vec<Letter> {
    let weight = weight(bold);
    let map = weight.face.charmap();
    let mut letters: Vec<Letter> = Vec::new();
    let mut left = 0.0;
    for (at, c) in text.char_indices() {
        let glyph = map.map(c).unwrap_or_default();
        if let Some(before) = letters.last_mut() {
            let of = |pairs: &Subtable0<'_>| pairs.kerning(GlyphId::new(before.glyph), glyph);
            let closer = f64::from(weight.kerning.iter().find_map(of).unwrap_or(0)) / weight.units;
            before.advance += closer;
            left += closer;
        }
        let advance = f64::from(weight.widths.advance_width(glyph).unwrap_or(0.0)) / weight.units;
        letters.push(Letter { glyph: glyph.to_u32(), at, left, advance });
        left += advance;
    }
    letters
}

/// Width of `text` with an em of `size`, in the unit of `size`.
pub(crate) fn width(text: &str, size: f64, bold: bool) -> f64 {
    letters(text, bold).last().map_or(0.0, |last| last.left + last.advance) * size
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

impl<P: Pen> Placed<'_, P> {
    fn at(&self, x: f32, y: f32) -> [f64; 2] {
        [self.left + f64::from(x) * self.scale, f64::from(y) * self.scale]
    }
}

impl<P: Pen> OutlinePen for Placed<'_, P> {
    fn move_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.at(x, y);
        self.pen.start(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.at(x, y);
        self.pen.line(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ([x1, y1], [x, y]) = (self.at(x1, y1), self.at(x, y));
        self.pen.curve(x1, y1, x, y);
    }

    fn curve_to(&mut self, _: f32, _: f32, _: f32, _: f32, x: f32, y: f32) {
        // TrueType outlines have no cubic curves.
        self.line_to(x, y);
    }

    fn close(&mut self) {
        self.pen.close();
    }
}

/// Draws `text` with an em of `size`.
pub(crate) fn draw(text: &str, size: f64, bold: bool, pen: &mut impl Pen) {
    let weight = weight(bold);
    let outlines = weight.face.outline_glyphs();
    for letter in letters(text, bold) {
        let scale = size / weight.units;
        let mut placed = Placed { pen: &mut *pen, left: letter.left * size, scale };
        if let Some(outline) = outlines.get(GlyphId::new(letter.glyph)) {
            let settings = DrawSettings::unhinted(Size::unscaled(), LocationRef::default());
            // An outline that cannot be drawn is a defect of the font in the program.
            let _ = outline.draw(settings, &mut placed);
        }
    }
}
