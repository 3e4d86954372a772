//! A page as PDF, for papers. Its text is text in an embedded part of the font, so that it can be
//! searched, copied and edited.

use krilla::color::rgb;
use krilla::geom::{Path, PathBuilder, Point, Rect, Size, Transform};
use krilla::image::Image;
use krilla::metadata::Metadata;
use krilla::page::PageSettings;
use krilla::paint::{Fill, LineJoin, Stroke};
use krilla::surface::Surface;
use krilla::text::{Font, GlyphId, KrillaGlyph};
use krilla::{Document, SerializeSettings};
use powergs_base::build;

use super::font;
use super::scene::{Rgb, Scene, ScenePoint, Shape, Text};

/// Points of print in an inch.
const POINTS: f64 = 72.0;
/// Control points of a quarter of a circle.
const ROUND: f32 = 0.552_284_8;

/// The PDF of a page.
///
/// # Errors
/// A page without area, or one that the library refuses.
pub(crate) fn pdf(scene: &Scene) -> Result<Vec<u8>, String> {
    let points = POINTS / scene.sheet.units_per_inch();
    let (width, height) = (scene.size.0 * points, scene.size.1 * points);
    let settings = PageSettings::from_wh(width as f32, height as f32).ok_or("no page")?;
    // Nothing in it is by chance or by time.
    let mut file = Document::new_with(SerializeSettings::default());
    let about = Metadata::new().title(scene.title.clone()).description(scene.description.clone());
    file.set_metadata(about.creator(build::line()));
    let fonts = [false, true].map(|bold| Font::new(font::file(bold).into(), 0));
    let [Some(normal), Some(bold)] = fonts else { return Err("no font".into()) };
    let mut page = file.start_page_with(settings);
    let mut surface = page.surface();
    surface.push_transform(&Transform::from_scale(points as f32, points as f32));
    for shape in &scene.shapes {
        draw(&mut surface, [&normal, &bold], shape)?;
    }
    surface.pop();
    surface.finish();
    page.finish();
    file.finish().map_err(|e| format!("{e:?}"))
}

fn ink((r, g, b): Rgb) -> rgb::Color {
    rgb::Color::new(r, g, b)
}

fn filled(colour: Rgb) -> Fill {
    Fill { paint: ink(colour).into(), ..Fill::default() }
}

fn fill(surface: &mut Surface<'_>, colour: Rgb, path: &Path) {
    surface.set_stroke(None);
    surface.set_fill(Some(filled(colour)));
    surface.draw_path(path);
}

fn stroke(colour: Rgb, width: f64) -> Stroke {
    Stroke { paint: ink(colour).into(), width: width as f32, ..Stroke::default() }
}

fn draw(surface: &mut Surface<'_>, fonts: [&Font; 2], shape: &Shape) -> Result<(), String> {
    match shape {
        Shape::Rectangle { area, fill: colour } => {
            let [l, t, r, b] = area.map(|v| v as f32);
            let mut path = PathBuilder::new();
            Rect::from_ltrb(l, t, r, b).into_iter().for_each(|area| path.push_rect(area));
            path.finish().iter().for_each(|path| fill(surface, *colour, path));
        }
        Shape::Line { points, stroke: colour, width } => {
            surface.set_fill(None);
            surface.set_stroke(Some(stroke(*colour, *width)));
            path(points, false).iter().for_each(|path| surface.draw_path(path));
        }
        Shape::Polygon { points, fill: colour } => {
            path(points, true).iter().for_each(|path| fill(surface, *colour, path));
        }
        Shape::Circle { centre, radius, fill: colour } => {
            circle(*centre, *radius).iter().for_each(|path| fill(surface, *colour, path));
        }
        Shape::Text(text) => words(surface, fonts, text),
        Shape::Image { area: [l, t, r, b], image, .. } => {
            let rgba = image.bytes().chunks_exact(3).flat_map(|p| [p[0], p[1], p[2], 255]);
            let image = Image::from_rgba8(rgba.collect(), image.width(), image.height());
            let size = Size::from_wh((r - l) as f32, (b - t) as f32).ok_or("no picture")?;
            surface.push_transform(&Transform::from_translate(*l as f32, *t as f32));
            surface.draw_image(image, size);
            surface.pop();
        }
    }
    Ok(())
}

fn path(points: &[ScenePoint], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (i, &(x, y)) in points.iter().enumerate() {
        match i {
            0 => path.move_to(x as f32, y as f32),
            _ => path.line_to(x as f32, y as f32),
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

fn circle((x, y): ScenePoint, r: f64) -> Option<Path> {
    let [x, y, r] = [x, y, r].map(|v| v as f32);
    let c = ROUND * r;
    let mut path = PathBuilder::new();
    path.move_to(x + r, y);
    path.cubic_to(x + r, y + c, x + c, y + r, x, y + r);
    path.cubic_to(x - c, y + r, x - r, y + c, x - r, y);
    path.cubic_to(x - r, y - c, x - c, y - r, x, y - r);
    path.cubic_to(x + c, y - r, x + r, y - c, x + r, y);
    path.close();
    path.finish()
}

fn words(surface: &mut Surface<'_>, fonts: [&Font; 2], text: &Text) {
    let letters = font::letters(&text.text, text.bold);
    let glyphs: Vec<KrillaGlyph> = letters
        .iter()
        .map(|letter| {
            let end = text.text[letter.at..].chars().next().map_or(0, char::len_utf8);
            let range = letter.at..letter.at + end;
            let advance = letter.advance as f32;
            KrillaGlyph {
                glyph_id: GlyphId::new(letter.glyph),
                text_range: range,
                x_advance: advance,
                x_offset: 0.0,
                y_offset: 0.0,
                y_advance: 0.0,
                location: None,
            }
        })
        .collect();
    let font = fonts[usize::from(text.bold)];
    let (x, y) = (text.start.0 as f32, text.start.1 as f32);
    let turn = if text.upwards {
        Transform::from_row(0.0, -1.0, 1.0, 0.0, x, y)
    } else {
        Transform::from_translate(x, y)
    };
    surface.push_transform(&turn);
    let start = Point::from_xy(0.0, 0.0);
    let mut show = |ink: Option<Rgb>| {
        let halo = Stroke { line_join: LineJoin::Round, ..stroke((255, 255, 255), text.halo) };
        surface.set_fill(ink.map(filled));
        surface.set_stroke(ink.is_none().then_some(halo));
        // A halo is outlines, so that the words are in the page once.
        let (size, outlined) = (text.size as f32, ink.is_none());
        surface.draw_glyphs(start, &glyphs, font.clone(), &text.text, size, outlined);
    };
    if text.halo > 0.0 {
        show(None);
    }
    show(Some(text.fill));
    surface.pop();
}
