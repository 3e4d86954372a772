//! The layout of a page: title, legend, panels in rows and columns, notes.

use super::panel::{self, Edges};
use super::scene::Area;
use super::{
    Align, Drawn, LEFT, LINE, Page, RIGHT, SIZE, TITLE, beside, fitted, legend, sized_to, width,
};
use crate::{Chart, Columns, Panel, Words};

/// Left edge of the panels with their axes.
const BEGIN: f64 = 38.0;
/// Between two panels, across and down.
const GAP: (f64, f64) = (40.0, 12.0);

/// Between two pictures that are side by side.
const NEAR: f64 = 14.0;

/// Draws a chart.
pub(crate) fn draw(page: &Page, chart: &Chart) -> Drawn {
    let room = RIGHT - LEFT;
    let title = sized_to(&Words::bold(chart.title), room, TITLE);
    page.sized(&title, (LEFT, 38.0), Align::Left, TITLE, false);
    let subtitle = fitted(&Words::note(chart.subtitle.as_str()), room);
    page.text(&subtitle, (LEFT, 72.0), Align::Left);
    let top = legend::rows(page, &chart.legend, 108.0)?.max(96.0) - 4.0;
    let bottom = notes(page, &chart.notes);
    let column = beside::room(&chart.beside);
    let end = if column > 0.0 { RIGHT - column - 36.0 } else { RIGHT };
    let grid = Grid::of(&chart.panels, chart.columns, [BEGIN, top, end, bottom]);
    let right = chart.panels.first().map_or(end, |p| grid.plot(0, p)[2]);
    let one = chart.panels.len() == 1 && chart.panels[0].aspect.is_some();
    let start = if one { right } else { end };
    beside::draw(page, &chart.beside, start + 36.0, top + 22.0, bottom - 8.0)?;
    for (i, panel) in chart.panels.iter().enumerate() {
        panel::draw(page, panel, grid.plot(i, panel), grid.edges(i))?;
    }
    Ok(())
}

/// Draws the lines at the bottom; returns where the first begins.
fn notes(page: &Page, notes: &[Vec<Words>]) -> f64 {
    let first = SIZE.1 - 18.0 - LINE * notes.len().saturating_sub(1) as f64;
    for (i, line) in notes.iter().enumerate() {
        let mut x = LEFT;
        for words in line {
            let words = fitted(words, RIGHT - x);
            page.text(&words, (x, first + LINE * i as f64), Align::Left);
            x += width(&words) + 24.0;
        }
    }
    if notes.is_empty() { SIZE.1 - 16.0 } else { first - LINE }
}

/// Panels in rows and columns. All plots of a column are equally wide, and all columns are.
struct Grid {
    columns: usize,
    /// Room around the plots of each column and row.
    edges: Vec<Edges>,
    /// Left edge of the plots of each column.
    lefts: Vec<f64>,
    /// Width of a plot.
    width: f64,
    /// Top and bottom of the plots of each row.
    rows: Vec<(f64, f64)>,
}

impl Grid {
    fn of(panels: &[Panel], columns: Columns, area: Area) -> Grid {
        match columns {
            Columns::Are(n) => Grid::with(panels, n.max(1), area),
            Columns::Fitting => {
                let full = |n: &usize| panels.len().is_multiple_of(*n);
                let grids = (1..=panels.len().max(1)).filter(full);
                let grids = grids.map(|n| Grid::with(panels, n, area));
                let seen = |grid: &Grid| {
                    let shown = panels.iter().enumerate().map(|(i, panel)| grid.plot(i, panel));
                    shown.map(|[l, _, r, _]| r - l).fold(f64::INFINITY, f64::min)
                };
                let best = grids.max_by(|a, b| seen(a).total_cmp(&seen(b)));
                best.unwrap_or_else(|| Grid::with(panels, 1, area))
            }
        }
    }

    fn with(panels: &[Panel], columns: usize, [left, top, right, bottom]: Area) -> Grid {
        let columns = columns.min(panels.len()).max(1);
        let guess = (right - left) / columns as f64;
        let mut edges: Vec<Edges> = panels.iter().map(|p| panel::edges(p, guess)).collect();
        let rows = panels.len().div_ceil(columns);
        // Panels of a column share their left and right edges, those of a row the others.
        for i in 0..edges.len() {
            let (row, column) = (i / columns, i % columns);
            let same = |j: &usize| j / columns == row || j % columns == column;
            let mut own = edges[i];
            for j in (0..edges.len()).filter(same) {
                let other = edges[j];
                if j % columns == column {
                    own.left = own.left.max(other.left);
                    own.right = own.right.max(other.right);
                }
                if j / columns == row {
                    own.top = own.top.max(other.top);
                    own.bottom = own.bottom.max(other.bottom);
                }
            }
            edges[i] = own;
        }
        let across: f64 = edges.iter().take(columns).map(|e| e.left + e.right).sum();
        let pictures = panels.iter().all(|p| p.aspect.is_some());
        let gap = if pictures { NEAR } else { GAP.0 };
        let gaps = gap * (columns - 1) as f64;
        let width = ((right - left - across - gaps) / columns as f64).max(40.0);
        let firsts: Vec<Edges> = edges.iter().copied().step_by(columns).collect();
        let down: f64 = firsts.iter().map(|e| e.top + e.bottom).sum();
        let gaps = GAP.1 * rows.saturating_sub(1) as f64;
        let height = (bottom - top - down - gaps).max(40.0);
        let heights = heights(panels, columns, width, height);
        let width = packed(panels, columns, width, &heights);
        let mut lefts = Vec::new();
        let mut x = left;
        for edge in edges.iter().take(columns) {
            lefts.push(x + edge.left);
            x += edge.left + width + edge.right + gap;
        }
        let mut y = top;
        let mut spans = Vec::new();
        for (edge, height) in firsts.iter().zip(heights) {
            spans.push((y + edge.top, y + edge.top + height));
            y += edge.top + height + edge.bottom + GAP.1;
        }
        Grid { columns, edges, lefts, width, rows: spans }
    }

    fn edges(&self, i: usize) -> Edges {
        self.edges[i]
    }

    /// The plot of a panel; one that must not be stretched is in the middle of its place.
    fn plot(&self, i: usize, panel: &Panel) -> Area {
        let left = self.lefts[i % self.columns];
        let (top, bottom) = self.rows[i / self.columns];
        let Some(aspect) = panel.aspect.filter(|a| *a > 0.0) else {
            return [left, top, left + self.width, bottom];
        };
        let width = self.width.min((bottom - top) * aspect);
        let start = left + (self.width - width) / 2.0;
        [start, top, start + width, top + width / aspect]
    }
}

/// Width of the columns: pictures that are not as wide as their place stand closer together, but
/// leave room for their captions.
fn packed(panels: &[Panel], columns: usize, width: f64, heights: &[f64]) -> f64 {
    const CAPTION: f64 = 250.0;
    let shown = panels.iter().enumerate().map(|(i, p)| {
        let wide = p.aspect.map_or(width, |a| heights[i / columns] * a);
        wide.min(width)
    });
    shown.fold(CAPTION.min(width), f64::max)
}

/// Heights of the rows: equal, or as pictures need them.
fn heights(panels: &[Panel], columns: usize, width: f64, all: f64) -> Vec<f64> {
    let rows = panels.chunks(columns);
    let natural = |row: &[Panel]| {
        row.iter().map(|p| p.aspect.map(|a| width / a)).try_fold(0.0, |m: f64, h| Some(m.max(h?)))
    };
    let equal = all / rows.len().max(1) as f64;
    let wanted: Option<Vec<f64>> = rows.map(natural).collect();
    let Some(wanted) = wanted else { return vec![equal; panels.len().div_ceil(columns)] };
    let sum: f64 = wanted.iter().sum();
    let shrink = if sum > all { all / sum } else { 1.0 };
    wanted.into_iter().map(|h| h * shrink).collect()
}
