//! Which entries of a legend belong to something that the panels show.

use crate::{Chart, Colour, Entry, Mark, Panel, Symbol};

/// What has a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ShownKind {
    Area,
    Point,
    Line,
}

/// The rows of the legend without what is in no panel. Pictures may show anything.
pub(crate) fn legend(chart: &Chart) -> Vec<Vec<Entry>> {
    let marks = || chart.panels.iter().flat_map(|p: &Panel| &p.marks);
    if marks().any(|m| matches!(m, Mark::Image { .. })) {
        return chart.legend.clone();
    }
    let used: Vec<(ShownKind, Colour)> = marks().flat_map(colours).collect();
    let is_used = |kind: Option<ShownKind>, colour: Colour| {
        used.iter().any(|(k, c)| *c == colour && kind.is_none_or(|kind| kind == *k))
    };
    let is_shown = |entry: &&Entry| match entry.symbol {
        Symbol::None => true,
        Symbol::Fill(c) => is_used(None, c),
        Symbol::Dot(c) | Symbol::Square(c) | Symbol::Ring(c, _) => {
            is_used(Some(ShownKind::Point), c)
        }
        Symbol::Line(c) | Symbol::Dashed(c) | Symbol::Curve(c) => is_used(Some(ShownKind::Line), c),
    };
    let row = |row: &Vec<Entry>| row.iter().filter(is_shown).cloned().collect();
    chart.legend.iter().map(row).collect()
}

/// The colours of a mark, as far as anything of it can be seen.
fn colours(mark: &Mark) -> Vec<(ShownKind, Colour)> {
    let seen = |v: f64| v.is_finite() && v != 0.0;
    match mark {
        Mark::Bars(bars) => {
            let parts = bars.iter().flat_map(|b| &b.parts).filter(|p| seen(p.value));
            parts.map(|p| (ShownKind::Area, p.colour)).collect()
        }
        Mark::Tornado { rows, colours } => {
            let is_seen = |side: &usize| rows.iter().any(|r| r[*side].is_some_and(seen));
            (0..2).filter(is_seen).map(|side| (ShownKind::Area, colours[side])).collect()
        }
        Mark::Histogram { bins, .. } => {
            bins.iter().filter(|b| seen(b.height)).map(|b| (ShownKind::Area, b.colour)).collect()
        }
        Mark::Line(line) => vec![(ShownKind::Line, line.colour)],
        Mark::Rule { colour, .. } => vec![(ShownKind::Line, *colour)],
        Mark::Points(points) => {
            let is_seen = |p: &&((f64, f64), Colour)| p.0.0.is_finite() && p.0.1.is_finite();
            let dots = points.points.iter().filter(is_seen);
            let ring = points.ring.filter(|_| !points.points.is_empty());
            dots.map(|p| p.1).chain(ring).map(|c| (ShownKind::Point, c)).collect()
        }
        Mark::Heat(cells) => {
            let dots =
                cells.iter().filter_map(|c| c.dot).map(|(colour, _)| (ShownKind::Point, colour));
            cells.iter().map(|c| (ShownKind::Area, c.colour)).chain(dots).collect()
        }
        Mark::Spans { spans, .. } => spans.iter().map(|s| (ShownKind::Area, s.colour)).collect(),
        Mark::Image { .. } | Mark::Label(_) | Mark::Cross(_) | Mark::Gauge(_) => Vec::new(),
    }
}
