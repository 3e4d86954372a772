//! A page as PNG: shapes and letters filled with tiny-skia.

use powergs_base::build;
use powergs_pixels::RgbImage;
use tiny_skia::{
    Color, FillRule, FilterQuality, LineJoin, Paint, Path, PathBuilder, Pixmap, PixmapPaint, Rect,
    Stroke, Transform,
};

use super::font::{self, Pen};
use super::scene::{Rgb, Scene, ScenePoint, Shape, Text};

/// The PNG of a page.
///
/// # Errors
/// A page without area, or one that the encoder refuses.
pub(crate) fn png(scene: &Scene) -> Result<Vec<u8>, String> {
    let zoom = scene.sheet.zoom();
    let size = |length: f64| (length as f32 * zoom).round() as u32;
    let (width, height) = (size(scene.size.0), size(scene.size.1));
    let mut page = Pixmap::new(width, height).ok_or("no page")?;
    page.fill(Color::WHITE);
    for shape in &scene.shapes {
        draw(&mut page, shape, zoom);
    }
    // Every pixel is opaque, so colours are not premultiplied by anything.
    let rgb: Vec<u8> = page.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let image = RgbImage::from_bytes(width, height, rgb).ok_or("no page")?;
    let per_inch = scene.sheet.units_per_inch() * f64::from(zoom);
    image.png_of(Some(per_inch), Some(&build::line())).map_err(|e| e.to_string())
}

fn paint((r, g, b): Rgb) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(r, g, b, 255);
    paint
}

fn draw(page: &mut Pixmap, shape: &Shape, scale: f32) {
    let zoom = Transform::from_scale(scale, scale);
    match shape {
        Shape::Rectangle { area, fill } => {
            let [l, t, r, b] = area.map(|v| v as f32);
            if let Some(rect) = Rect::from_ltrb(l, t, r, b) {
                page.fill_rect(rect, &paint(*fill), zoom, None);
            }
        }
        Shape::Line { points, stroke, width } => {
            if let Some(path) = path(points, false) {
                let style = Stroke { width: *width as f32, ..Stroke::default() };
                page.stroke_path(&path, &paint(*stroke), &style, zoom, None);
            }
        }
        Shape::Polygon { points, fill } => {
            if let Some(path) = path(points, true) {
                page.fill_path(&path, &paint(*fill), FillRule::Winding, zoom, None);
            }
        }
        Shape::Circle { centre, radius, fill } => {
            let circle = PathBuilder::from_circle(centre.0 as f32, centre.1 as f32, *radius as f32);
            if let Some(path) = circle {
                page.fill_path(&path, &paint(*fill), FillRule::Winding, zoom, None);
            }
        }
        Shape::Text(text) => words(page, text, scale),
        Shape::Image { area, image, sharp } => {
            picture(page, area.map(|v| v as f32 * scale), image, *sharp);
        }
    }
}

fn path(points: &[ScenePoint], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    let mut points = points.iter().map(|(x, y)| (*x as f32, *y as f32));
    let (x, y) = points.next()?;
    path.move_to(x, y);
    points.for_each(|(x, y)| path.line_to(x, y));
    if closed {
        path.close();
    }
    path.finish()
}

/// The letters of a line of text.
struct Letters(PathBuilder);

impl Pen for Letters {
    fn start(&mut self, x: f64, y: f64) {
        self.0.move_to(x as f32, -y as f32);
    }

    fn line(&mut self, x: f64, y: f64) {
        self.0.line_to(x as f32, -y as f32);
    }

    fn curve(&mut self, x1: f64, y1: f64, x: f64, y: f64) {
        self.0.quad_to(x1 as f32, -y1 as f32, x as f32, -y as f32);
    }

    fn close(&mut self) {
        self.0.close();
    }
}

fn words(page: &mut Pixmap, text: &Text, zoom: f32) {
    let mut letters = Letters(PathBuilder::new());
    font::draw(&text.text, text.size, text.bold, &mut letters);
    let Some(path) = letters.0.finish() else { return };
    let turn = if text.upwards { -90.0 } else { 0.0 };
    let place = Transform::from_rotate(turn)
        .post_translate(text.start.0 as f32, text.start.1 as f32)
        .post_scale(zoom, zoom);
    if text.halo > 0.0 {
        let style =
            Stroke { width: text.halo as f32, line_join: LineJoin::Round, ..Stroke::default() };
        page.stroke_path(&path, &paint((255, 255, 255)), &style, place, None);
    }
    page.fill_path(&path, &paint(text.fill), FillRule::Winding, place, None);
}

fn picture(page: &mut Pixmap, area: [f32; 4], image: &RgbImage, sharp: bool) {
    let (w, h) = (image.width(), image.height());
    let Some(mut pixels) = Pixmap::new(w, h) else { return };
    for (to, from) in pixels.data_mut().chunks_exact_mut(4).zip(image.bytes().chunks_exact(3)) {
        to[..3].copy_from_slice(from);
        to[3] = 255;
    }
    // On whole pixels, so that its edges are sharp.
    let [l, t, r, b] = area.map(f32::round);
    let (x, y) = ((r - l) / w as f32, (b - t) / h as f32);
    let exact = sharp || (x == 1.0 && y == 1.0);
    let quality = if exact { FilterQuality::Nearest } else { FilterQuality::Bilinear };
    let style = PixmapPaint { quality, ..PixmapPaint::default() };
    let place = Transform::from_row(x, 0.0, 0.0, y, l, t);
    page.draw_pixmap(0, 0, pixels.as_ref(), &style, place, None);
}
