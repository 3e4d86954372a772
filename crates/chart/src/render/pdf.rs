//! A page as PDF, for papers. Letters are outlines, so no font is embedded; every line of text
//! carries its words, so that it can be searched and copied.

use powergs_base::build;
use std::fmt::Write as _;
use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use powergs_pixels::RgbImage;

use super::font::{self, Pen};
use super::scene::{Rgb, Scene, ScenePoint, Shape, Text};
use super::svg::number;

/// Points of print in an inch.
const POINTS: f64 = 72.0;
/// Control points of a quarter of a circle.
const ROUND: f64 = 0.552_284_75;

/// The PDF of a page.
///
/// # Errors
/// Errors of compression, which does not fail in memory.
pub(crate) fn pdf(scene: &Scene) -> Result<Vec<u8>, String> {
    let mut content = String::new();
    let mut images = Vec::new();
    let (width, height) = scene.size;
    let points = POINTS / scene.sheet.units_per_inch();
    let _ = writeln!(content, "{points:.5} 0 0 -{points:.5} 0 {} cm", number(height * points));
    for shape in &scene.shapes {
        draw(&mut content, &mut images, shape);
    }
    let mut file = PdfFile::default();
    let names: Vec<String> = (0..images.len()).map(|i| format!("/I{i} {} 0 R", 5 + i)).collect();
    file.object("<< /Type /Catalog /Pages 2 0 R >>");
    file.object("<< /Type /Pages /Kids [3 0 R] /Count 1 >>");
    file.object(&format!(
        "<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {} {}] /Contents 4 0 R \
         /Resources << /XObject << {} >> >> >>",
        number(width * points),
        number(height * points),
        names.join(" ")
    ));
    file.stream("", content.as_bytes())?;
    for image in images {
        let (w, h) = (image.width(), image.height());
        let about = format!(
            "/Type /XObject /Subtype /Image /Width {w} /Height {h} /ColorSpace /DeviceRGB \
             /BitsPerComponent 8 "
        );
        file.stream(&about, image.bytes())?;
    }
    let texts = [&scene.title, &scene.description, &build::line()].map(|text| hex(text));
    let [title, subject, creator] = texts;
    let info = file.object(&format!("<< /Title {title} /Subject {subject} /Creator {creator} >>"));
    Ok(file.finish(info))
}

/// A PDF file being written; objects are numbered from 1.
#[derive(Default)]
struct PdfFile {
    bytes: Vec<u8>,
    /// Where each object begins.
    offsets: Vec<usize>,
}

impl PdfFile {
    fn begin(&mut self) -> usize {
        if self.bytes.is_empty() {
            // The second line tells transfer programs that the file is binary.
            self.bytes.extend(b"%PDF-1.5\n%\xe2\xe3\xcf\xd3\n");
        }
        self.offsets.push(self.bytes.len());
        let number = self.offsets.len();
        self.bytes.extend(format!("{number} 0 obj\n").bytes());
        number
    }

    fn object(&mut self, text: &str) -> usize {
        let number = self.begin();
        self.bytes.extend(format!("{text}\nendobj\n").bytes());
        number
    }

    fn stream(&mut self, about: &str, data: &[u8]) -> Result<(), String> {
        let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
        packed.write_all(data).map_err(|e| e.to_string())?;
        let packed = packed.finish().map_err(|e| e.to_string())?;
        self.begin();
        let head = format!("<< {about}/Filter /FlateDecode /Length {} >>\nstream\n", packed.len());
        self.bytes.extend(head.bytes());
        self.bytes.extend(packed);
        self.bytes.extend(b"\nendstream\nendobj\n");
        Ok(())
    }

    fn finish(mut self, info: usize) -> Vec<u8> {
        let start = self.bytes.len();
        let count = self.offsets.len() + 1;
        let mut table = format!("xref\n0 {count}\n0000000000 65535 f \n");
        for offset in &self.offsets {
            let _ = writeln!(table, "{offset:010} 00000 n ");
        }
        let _ = write!(
            table,
            "trailer\n<< /Size {count} /Root 1 0 R /Info {info} 0 R >>\nstartxref\n{start}\n%%EOF\n"
        );
        self.bytes.extend(table.bytes());
        self.bytes
    }
}

/// Text as a PDF string of UTF-16.
fn hex(text: &str) -> String {
    let codes: String = text.encode_utf16().map(|c| format!("{c:04X}")).collect();
    format!("<FEFF{codes}>")
}

fn colour(out: &mut String, (r, g, b): Rgb, operator: &str) {
    let [r, g, b] = [r, g, b].map(|v| {
        let text = format!("{:.3}", f64::from(v) / 255.0);
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    });
    let _ = writeln!(out, "{r} {g} {b} {operator}");
}

fn draw<'a>(out: &mut String, images: &mut Vec<&'a RgbImage>, shape: &'a Shape) {
    match shape {
        Shape::Rectangle { area: [l, t, r, b], fill } => {
            colour(out, *fill, "rg");
            let [x, y, w, h] = [*l, *t, r - l, b - t].map(number);
            let _ = writeln!(out, "{x} {y} {w} {h} re f");
        }
        Shape::Line { points, stroke, width } => {
            colour(out, *stroke, "RG");
            let _ = writeln!(out, "{} w", number(*width));
            path(out, points);
            out.push_str("S\n");
        }
        Shape::Polygon { points, fill } => {
            colour(out, *fill, "rg");
            path(out, points);
            out.push_str("f\n");
        }
        Shape::Circle { centre, radius, fill } => {
            colour(out, *fill, "rg");
            circle(out, *centre, *radius);
        }
        Shape::Text(text) => words(out, text),
        Shape::Image { area: [l, t, r, b], image, .. } => {
            let [w, h, x, y] = [r - l, t - b, *l, *b].map(number);
            let _ = writeln!(out, "q {w} 0 0 {h} {x} {y} cm /I{} Do Q", images.len());
            images.push(image);
        }
    }
}

fn path(out: &mut String, points: &[ScenePoint]) {
    for (i, (x, y)) in points.iter().enumerate() {
        let operator = if i == 0 { 'm' } else { 'l' };
        let _ = writeln!(out, "{} {} {operator}", number(*x), number(*y));
    }
}

fn circle(out: &mut String, (x, y): ScenePoint, r: f64) {
    let c = ROUND * r;
    let _ = writeln!(out, "{} {} m", number(x + r), number(y));
    for quarter in [
        [x + r, y + c, x + c, y + r, x, y + r],
        [x - c, y + r, x - r, y + c, x - r, y],
        [x - r, y - c, x - c, y - r, x, y - r],
        [x + c, y - r, x + r, y - c, x + r, y],
    ] {
        let _ = writeln!(out, "{} c", quarter.map(number).join(" "));
    }
    out.push_str("f\n");
}

/// The letters of a line of text; PDF knows cubic curves only.
struct PdfLetters<'a> {
    out: &'a mut String,
    at: ScenePoint,
}

impl PdfLetters<'_> {
    fn write(&mut self, numbers: &[f64], operator: char) {
        for v in numbers {
            self.out.push_str(&number(*v));
            self.out.push(' ');
        }
        self.out.push(operator);
        self.out.push('\n');
    }
}

impl Pen for PdfLetters<'_> {
    fn start(&mut self, x: f64, y: f64) {
        self.at = (x, y);
        self.write(&[x, y], 'm');
    }

    fn line(&mut self, x: f64, y: f64) {
        self.at = (x, y);
        self.write(&[x, y], 'l');
    }

    fn curve(&mut self, x1: f64, y1: f64, x: f64, y: f64) {
        let between = |a: f64, b: f64| a + (b - a) * 2.0 / 3.0;
        let first = (between(self.at.0, x1), between(self.at.1, y1));
        let second = (between(x, x1), between(y, y1));
        self.at = (x, y);
        self.write(&[first.0, first.1, second.0, second.1, x, y], 'c');
    }

    fn close(&mut self) {
        self.out.push_str("h\n");
    }
}

fn words(out: &mut String, text: &Text) {
    let _ = writeln!(out, "/Span << /ActualText {} >> BDC", hex(&text.text));
    colour(out, text.fill, "rg");
    let (x, y) = (number(text.start.0), number(text.start.1));
    // The page has y downwards, letters have it upwards.
    let turn = if text.upwards { "0 -1 -1 0" } else { "1 0 0 -1" };
    let _ = writeln!(out, "q {turn} {x} {y} cm");
    if text.halo > 0.0 {
        let halo = number(text.halo);
        let _ = writeln!(out, "1 1 1 RG {halo} w 1 j");
        font::draw(&text.text, text.size, text.bold, &mut PdfLetters { out, at: (0.0, 0.0) });
        out.push_str("S\n");
    }
    font::draw(&text.text, text.size, text.bold, &mut PdfLetters { out, at: (0.0, 0.0) });
    out.push_str("f Q EMC\n");
}
