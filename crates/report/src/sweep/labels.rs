//! Labels beside points that cover neither each other nor the points that matter.

use crate::plot::{Align, Canvas, Drawn, GREY, INK, text_width};

/// Height of a line of text with its air.
const HEIGHT: f64 = 22.0;

/// A rectangle: left, top, right, bottom.
type Box4 = [f64; 4];

/// A label and its point.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// The text.
    pub text: String,
    /// The point that it names.
    pub at: (f64, f64),
}

/// Where a label goes: left end of the text, half-way up.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The text.
    pub text: String,
    /// The point that it names.
    pub at: (f64, f64),
    /// Left end of the text, half-way up.
    pub start: (f64, f64),
}

/// Finds places inside `frame` (left, top, right, bottom), each label where it covers the fewest of
/// `points` and no earlier label. Earlier labels choose first; a label without a free place is left
/// out.
pub fn place(labels: &[Label], points: &[(f64, f64)], frame: Box4) -> Vec<Placed> {
    let mut taken: Vec<Box4> = Vec::new();
    let mut placed = Vec::new();
    for label in labels {
        let width = bold_width(&label.text);
        let covered = |b: &Box4| points.iter().filter(|p| inside(**p, grown(*b, 5.0))).count();
        let free = |b: &Box4| {
            let in_frame =
                b[0] >= frame[0] && b[1] >= frame[1] && b[2] <= frame[2] && b[3] <= frame[3];
            in_frame && !taken.iter().any(|t| overlap(*t, *b))
        };
        let candidates = candidates(label.at, width).into_iter().filter(free);
        // The first of the least covering: near places come first.
        if let Some(best) = candidates.min_by_key(covered) {
            taken.push(best);
            let start = (best[0], (best[1] + best[3]) / 2.0);
            placed.push(Placed { text: label.text.clone(), at: label.at, start });
        }
    }
    placed
}

/// Draws labels, with a thin line to the point where the label is not beside it.
pub fn draw(canvas: &Canvas, placed: &[Placed]) -> Drawn {
    for label in placed {
        let width = bold_width(&label.text);
        let (x, y) = label.start;
        let near = (label.at.0.clamp(x, x + width), y + (label.at.1 - y).clamp(-9.0, 9.0));
        let (dx, dy) = (near.0 - label.at.0, near.1 - label.at.1);
        if dx.hypot(dy) > 22.0 {
            canvas.line(&[label.at, near], GREY, 1)?;
        }
        canvas.bold(&label.text, label.start, Align::Left, INK)?;
    }
    Ok(())
}

/// Bold letters of the font are up to an eighth wider than normal ones.
fn bold_width(text: &str) -> f64 {
    text_width(text) * 1.125
}

/// Boxes around a point, nearest first, in eight directions.
fn candidates(at: (f64, f64), width: f64) -> Vec<Box4> {
    let mut all = Vec::new();
    for gap in [12.0, 26.0, 48.0, 80.0, 120.0, 170.0] {
        let side = gap * 0.75;
        for (x, y) in [
            (at.0 + gap, at.1),
            (at.0 - gap - width, at.1),
            (at.0 - width / 2.0, at.1 - gap - 4.0),
            (at.0 - width / 2.0, at.1 + gap + 4.0),
            (at.0 + side, at.1 - side - 4.0),
            (at.0 - side - width, at.1 - side - 4.0),
            (at.0 + side, at.1 + side + 4.0),
            (at.0 - side - width, at.1 + side + 4.0),
        ] {
            all.push([x, y - HEIGHT / 2.0, x + width, y + HEIGHT / 2.0]);
        }
    }
    all
}

fn grown([l, t, r, b]: Box4, by: f64) -> Box4 {
    [l - by, t - by, r + by, b + by]
}

fn inside((x, y): (f64, f64), [l, t, r, b]: Box4) -> bool {
    x > l && x < r && y > t && y < b
}

fn overlap(a: Box4, b: Box4) -> bool {
    a[0] < b[2] + 4.0 && b[0] < a[2] + 4.0 && a[1] < b[3] && b[1] < a[3]
}
