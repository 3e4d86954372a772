//! Whether labels of a chart cover marks, or texts each other: by their rectangles, on every size
//! of page.

use powergs_chart::render::labels::{crosses, overlap};
use powergs_chart::render::scene::{Area, HALO, Scene, Shape, Text};
use powergs_chart::{Chart, Sheet, Style};

/// Points of a crowd are at most as large, page units; labels may cover them.
const CROWD: f64 = 4.1;
/// Lines at most as wide are faint, page units; labels may cover them.
const FAINT: f64 = 1.6;

/// What covers what on the pages of a chart; empty if all can be read.
///
/// # Panics
/// If the chart cannot be drawn.
pub fn covered(chart: &Chart) -> Vec<String> {
    // Layouts of widths change at 3, 6 and 7 inches.
    let widths = ["3in", "5.99in", "6in"].map(|width| width.parse().expect("a width"));
    let sheets = Sheet::ALL.into_iter().chain(widths);
    let styles = sheets.flat_map(|sheet| [true, false].map(|title| Style { sheet, title }));
    let on = |style: Style| {
        let scene = chart.scene(style).expect("drawn");
        let place = format!("{} as {:?}", chart.name, style.sheet);
        covered_on(&scene).into_iter().map(move |what| format!("{place}: {what}"))
    };
    styles.flat_map(on).collect()
}

fn covered_on(scene: &Scene) -> Vec<String> {
    let texts: Vec<&Text> = scene
        .shapes
        .iter()
        .filter_map(|shape| match shape {
            Shape::Text(text) => Some(text),
            _ => None,
        })
        .collect();
    let mut all = Vec::new();
    for (i, text) in texts.iter().enumerate() {
        let area = inner(text);
        let is_on = area[0] >= -0.5
            && area[1] >= -0.5
            && area[2] <= scene.size.0 + 0.5
            && area[3] <= scene.size.1 + 0.5;
        if !is_on {
            all.push(format!("`{}` is cut off by the edge: {area:.0?}", text.text));
        }
        for other in &texts[..i] {
            if overlap(area, inner(other)) {
                all.push(format!("`{}` and `{}` lie over each other", other.text, text.text));
            }
        }
        // Labels have a whole halo; other texts stand in bars and on axes.
        if text.halo >= HALO {
            all.extend(under(scene, area).map(|what| format!("`{}` covers {what}", text.text)));
        }
    }
    all
}

/// The middle of a text, without the room above small letters.
fn inner(text: &Text) -> Area {
    let [l, t, r, b] = text.area();
    [l + 0.5, t + 2.0, r - 0.5, b - 2.0]
}

/// Marks below an area.
fn under(scene: &Scene, area: Area) -> impl Iterator<Item = String> {
    let white = (255, 255, 255);
    scene.shapes.iter().filter_map(move |shape| match shape {
        Shape::Circle { centre: (x, y), radius, .. } if *radius > CROWD => {
            let (dx, dy) = (x - x.clamp(area[0], area[2]), y - y.clamp(area[1], area[3]));
            (dx.hypot(dy) < *radius).then(|| format!("a point at {x:.0}, {y:.0}"))
        }
        Shape::Rectangle { area: other, fill } if *fill != white => {
            overlap(area, *other).then(|| format!("a bar at {other:.0?}"))
        }
        Shape::Line { points, width, stroke } if *width > FAINT && !is_pale(*stroke) => {
            let cut = points.windows(2).find(|ends| crosses([ends[0], ends[1]], area));
            cut.map(|ends| format!("a line at {ends:.0?}"))
        }
        _ => None,
    })
}

/// Whether a line only divides.
fn is_pale((r, g, b): (u8, u8, u8)) -> bool {
    r > 215 && g > 215 && b > 215
}
