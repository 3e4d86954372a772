//! A page as SVG. Text stays text, so that it can be searched, read out and edited; its width is
//! given, so that it fits with any font.

use std::fmt::Write;

use super::scene::{Scene, ScenePoint, Shape, Text};
use crate::scheme::SchemeColours;
use crate::{Colour, Sheet};
use powergs_base::build;

/// The font of the measured widths, then others of about the same.
const FONTS: &str = "DejaVu Sans, Verdana, Geneva, sans-serif";

/// The colour of the page.
const PAPER: (u8, u8, u8) = (Colour::PAPER.0, Colour::PAPER.1, Colour::PAPER.2);

/// The SVG of a page.
///
/// # Errors
/// An image that cannot be written as PNG.
pub(crate) fn svg(scene: &Scene, palette: SchemeColours) -> Result<String, String> {
    let [width, height] = [scene.size.0, scene.size.1].map(number);
    let print = |length: f64| match scene.sheet {
        Sheet::Slide => number(length),
        Sheet::Page | Sheet::Column | Sheet::Wide(_) => {
            format!("{:.3}in", length / scene.sheet.units_per_inch())
        }
    };
    let (wide, high) = (print(scene.size.0), print(scene.size.1));
    let paper = palette.mark(PAPER);
    let mut out = format!(
        "<svg width=\"{wide}\" height=\"{high}\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
         xmlns=\"http://www.w3.org/2000/svg\">\n<title>{}</title>\n<desc>{}</desc>\n\
         <metadata>{}</metadata>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"{paper}\"/>\n\
         <g font-family=\"{FONTS}\" fill=\"none\">\n",
        escaped(&scene.title),
        escaped(&scene.description),
        escaped(&build::line())
    );
    for shape in &scene.shapes {
        draw(&mut out, shape, palette)?;
    }
    for hint in &scene.hints {
        let [l, t, r, b] = hint.area;
        let [x, y, w, h] = [l, t, r - l, b - t].map(number);
        let words = escaped(&hint.words);
        out.push_str(&format!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"#fff\" \
             fill-opacity=\"0\"><title>{words}</title></rect>\n"
        ));
    }
    out.push_str("</g>\n</svg>\n");
    Ok(out)
}

fn draw(out: &mut String, shape: &Shape, palette: SchemeColours) -> Result<(), String> {
    let colour = |rgb| palette.mark(rgb);
    let written = match shape {
        Shape::Rectangle { area: [l, t, r, b], fill } => {
            let (w, h) = (number(r - l), number(b - t));
            let (x, y) = (number(*l), number(*t));
            let fill = colour(*fill);
            writeln!(
                out,
                "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"{fill}\"/>"
            )
        }
        Shape::Line { points, stroke, width } => {
            let (stroke, width) = (colour(*stroke), number(*width));
            let points = corners(points);
            writeln!(
                out,
                "<polyline points=\"{points}\" stroke=\"{stroke}\" stroke-width=\"{width}\"/>"
            )
        }
        Shape::Polygon { points, fill } => {
            writeln!(out, "<polygon points=\"{}\" fill=\"{}\"/>", corners(points), colour(*fill))
        }
        Shape::Circle { centre, radius, fill } => writeln!(
            out,
            "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{}\"{}/>",
            number(centre.0),
            number(centre.1),
            number(*radius),
            colour(*fill),
            palette.dot()
        ),
        Shape::Text(text) => words(out, text, palette),
        Shape::Image { area: [l, t, r, b], image, sharp } => writeln!(
            out,
            "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" preserveAspectRatio=\"none\"{} \
             href=\"data:image/png;base64,{}\"/>",
            number(*l),
            number(*t),
            number(r - l),
            number(b - t),
            if *sharp { " image-rendering=\"pixelated\"" } else { "" },
            base64(&image.png().map_err(|e| e.to_string())?)
        ),
    };
    written.map_err(|e| e.to_string())
}

fn words(out: &mut String, text: &Text, palette: SchemeColours) -> std::fmt::Result {
    let (x, y) = (number(text.start.0), number(text.start.1));
    write!(out, "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\"", number(text.size))?;
    if text.bold {
        out.push_str(" font-weight=\"bold\"");
    }
    if text.upwards {
        write!(out, " transform=\"rotate(270 {x} {y})\"")?;
    }
    if text.halo > 0.0 {
        let halo = number(text.halo);
        let paper = palette.mark(PAPER);
        write!(out, " stroke=\"{paper}\" stroke-width=\"{halo}\" paint-order=\"stroke\"")?;
    }
    let (width, fill) = (number(text.width), palette.text(text.fill));
    let text = escaped(&text.text);
    writeln!(
        out,
        " textLength=\"{width}\" lengthAdjust=\"spacingAndGlyphs\" fill=\"{fill}\">{text}</text>"
    )
}

fn corners(points: &[ScenePoint]) -> String {
    let mut out = String::with_capacity(12 * points.len());
    for (i, (x, y)) in points.iter().enumerate() {
        let space = if i > 0 { " " } else { "" };
        out.push_str(&format!("{space}{},{}", number(*x), number(*y)));
    }
    out
}

/// At most two digits behind the point, and no zeros at the end.
pub(super) fn number(v: f64) -> String {
    let text = format!("{v:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // XML has no other control characters.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// Base64 with padding (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let mut group = [0; 3];
        group[..chunk.len()].copy_from_slice(chunk);
        let bits = u32::from_be_bytes([0, group[0], group[1], group[2]]);
        for i in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * i)) as usize & 63];
            text.push(if i <= chunk.len() { digit as char } else { '=' });
        }
    }
    text
}
