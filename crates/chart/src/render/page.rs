//! The layout of a page: title, legend, panels in rows and columns, notes. A wide page has a
//! height, which its panels fill; a narrow one is as high as its panels, which stand above each
//! other.

use super::panel::{self, Edges};
use super::scene::Area;
use super::{
    Align, Halo, LINE, Page, TEXT, beside, fitted, legend, shown, sized_to, width, wrapped,
};
use crate::{Beside, Chart, Columns, Panel, Scale, Words};

/// Between two panels, across and down.
const GAP: (f64, f64) = (40.0, 12.0);
/// Between two pictures that are side by side.
const NEAR: f64 = 14.0;
/// A picture of this share of the largest width that it could have is as good.
const NEARLY: f64 = 0.85;
/// Size of the title on a wide and on a narrow page.
const TITLES: (f64, f64) = (28.0, 23.0);

/// Draws a chart; returns the height of the page.
pub(crate) fn draw(page: &Page, chart: &Chart) -> Result<f64, String> {
    let first = head(page, chart);
    let after = legend::rows(page, &shown::legend(chart), first)?;
    let top = if after > first { after - 6.0 } else { first - 14.0 };
    if let Some(diagram) = &chart.diagram {
        let end = super::diagram::draw(page, diagram, top)?;
        return notes_below(page, &chart.notes, end);
    }
    match page.frame.height {
        Some(height) => wide(page, chart, top, height),
        None => narrow(page, chart, top),
    }
}

/// Draws title and subtitle; returns the middle of the first line of the legend.
fn head(page: &Page, chart: &Chart) -> f64 {
    let (left, room) = (page.frame.left, page.frame.right - page.frame.left);
    if !page.frame.title {
        return 16.0;
    }
    let (title, subtitle) =
        (Words::bold(chart.title.as_str()), Words::note(chart.subtitle.as_str()));
    if !page.frame.is_narrow() {
        let title = sized_to(&title, room, TITLES.0);
        page.sized(&title, (left, 38.0), Align::Left, TITLES.0, Halo::None);
        let lines = wrapped(&subtitle, room, TEXT, 2);
        for (line, y) in lines.iter().zip([72.0, 72.0 + LINE]) {
            page.text(line, (left, y), Align::Left);
        }
        let further = lines.iter().skip(1).filter(|line| !line.text.is_empty()).count();
        return 108.0 + further as f64 * LINE;
    }
    let mut y = 20.0;
    for line in wrapped(&title, room, TITLES.1, 2) {
        page.sized(&line, (left, y), Align::Left, TITLES.1, Halo::None);
        y += 30.0;
    }
    for line in wrapped(&subtitle, room, TEXT, 4).iter().filter(|l| !l.text.is_empty()) {
        page.text(line, (left, y), Align::Left);
        y += LINE;
    }
    y + 8.0
}

/// Panels fill the page below `top`; explanations are at their right. Returns the height.
fn wide(page: &Page, chart: &Chart, top: f64, height: f64) -> Result<f64, String> {
    let bottom = notes_top(&chart.notes, height);
    let column = beside::room(&chart.beside);
    let (begin, right) = (page.frame.begin, page.frame.right);
    let end = if column > 0.0 { right - column - 36.0 } else { right };
    let grid = Grid::of(page, &chart.panels, chart.columns, [begin, top, end, bottom]);
    let right = chart.panels.first().map_or(end, |p| grid.plot(0, p)[2]);
    let one = chart.panels.len() == 1 && chart.panels[0].aspect.is_some();
    let start = if one { right } else { end };
    // A page of pictures is no higher than they are, unless a list beside them is.
    let pictures = !chart.panels.is_empty() && chart.panels.iter().all(|p| p.aspect.is_some());
    let only_scales = chart.beside.iter().all(|b| matches!(b, Beside::Scale { .. }));
    let unused = match pictures && only_scales {
        true => (bottom - grid.end() - 8.0).max(0.0),
        false => 0.0,
    };
    beside::draw(page, &chart.beside, start + 36.0, top + 22.0, bottom - unused - 8.0)?;
    for (i, panel) in chart.panels.iter().enumerate() {
        panel::draw(page, panel, grid.plot(i, panel), grid.edges(i))?;
    }
    bottom_notes(page, &chart.notes, height - unused);
    Ok(height - unused)
}

/// Panels above each other below `top`, then explanations and notes; returns where they end.
fn narrow(page: &Page, chart: &Chart, top: f64) -> Result<f64, String> {
    let panels = stacked(&chart.panels);
    let pictures = panels.iter().all(|p| p.aspect.is_some());
    let columns = if pictures && panels.len() > 1 { 2 } else { 1 };
    let (begin, right) = (page.frame.begin, page.frame.right);
    let grid = Grid::flowing(page, &panels, columns, [begin, top, right, top]);
    for (i, panel) in panels.iter().enumerate() {
        panel::draw(page, panel, grid.plot(i, panel), grid.edges(i))?;
    }
    let end = if panels.is_empty() { top } else { grid.end() };
    notes_below(page, &chart.notes, beside::below(page, &chart.beside, end + 6.0)?)
}

/// Draws the notes of a page that is as high as what is on it; returns where they end.
fn notes_below(page: &Page, notes: &[Vec<Words>], mut y: f64) -> Result<f64, String> {
    let right = page.frame.right;
    for line in notes {
        let bold = line.iter().any(|w| w.bold);
        let room = right - page.frame.left;
        // Words of different colours stay apart, one behind the other.
        let mut x = page.frame.left;
        for words in line {
            let alone = x == page.frame.left;
            if !alone && x + width(words) > right {
                (x, y) = (page.frame.left, y + LINE);
            }
            let lines = wrapped(words, room, TEXT, 5);
            for (i, words) in lines.iter().enumerate() {
                y += if i > 0 { LINE } else { 0.0 };
                page.text(words, (x, y + 12.0), Align::Left);
            }
            x += lines.last().map_or(0.0, width) + 18.0;
        }
        y += LINE + if bold { 4.0 } else { 0.0 };
    }
    Ok(y + 8.0)
}

/// Panels that stood side by side, above each other: those that shared the names of another have
/// them again.
fn stacked(panels: &[Panel]) -> Vec<Panel> {
    let mut all = panels.to_vec();
    for i in 1..all.len() {
        let same = matches!(all[i].y.scale, Scale::Names(_)) && all[i].y.scale == all[0].y.scale;
        if same && !all[i].y.shown && all[0].y.shown {
            all[i].y = all[0].y.clone();
        }
    }
    all
}

/// Where the lines at the bottom begin.
fn notes_top(notes: &[Vec<Words>], height: f64) -> f64 {
    let first = height - 18.0 - LINE * notes.len().saturating_sub(1) as f64;
    if notes.is_empty() { height - 16.0 } else { first - LINE }
}

/// Draws the lines at the bottom.
fn bottom_notes(page: &Page, notes: &[Vec<Words>], height: f64) {
    let first = height - 18.0 - LINE * notes.len().saturating_sub(1) as f64;
    for (i, line) in notes.iter().enumerate() {
        let mut x = page.frame.left;
        for words in line {
            let words = fitted(words, page.frame.right - x);
            page.text(&words, (x, first + LINE * i as f64), Align::Left);
            x += width(&words) + 24.0;
        }
    }
}

/// Panels in rows and columns. All plots of a column are equally wide, and all columns are.
struct Grid {
    columns: usize,
    /// Room around the plots of each panel.
    edges: Vec<Edges>,
    /// Left edge of the plots of each column.
    lefts: Vec<f64>,
    /// Width of a plot.
    width: f64,
    /// Top and bottom of the plots of each row.
    rows: Vec<(f64, f64)>,
}

impl Grid {
    /// Rows fill the area.
    fn of(page: &Page, panels: &[Panel], columns: Columns, area: Area) -> Grid {
        match columns {
            Columns::Are(n) => Grid::with(page, panels, n.max(1), area, filling),
            Columns::Fitting => {
                let full = |n: &usize| panels.len().is_multiple_of(*n);
                let grids = (1..=panels.len().max(1)).filter(full);
                let grids = grids.map(|n| Grid::with(page, panels, n, area, filling));
                let seen = |grid: &Grid| {
                    let shown = panels.iter().enumerate().map(|(i, panel)| grid.plot(i, panel));
                    shown.map(|[l, _, r, _]| r - l).fold(f64::INFINITY, f64::min)
                };
                let grids: Vec<Grid> = grids.collect();
                let largest = grids.iter().map(seen).fold(0.0, f64::max);
                // Side by side, if that makes them little smaller: the rest of the page is cut off.
                let best = grids.into_iter().rev().find(|grid| seen(grid) >= NEARLY * largest);
                best.unwrap_or_else(|| Grid::with(page, panels, 1, area, filling))
            }
        }
    }

    /// Rows are as high as what they show.
    fn flowing(page: &Page, panels: &[Panel], columns: usize, area: Area) -> Grid {
        let own = |panels: &[Panel], columns: usize, width: f64, _: f64| {
            let count = panels.len().div_ceil(columns);
            let row = |row: &[Panel]| {
                row.iter().map(|p| panel::own_height(p, width, count)).fold(0.0, f64::max)
            };
            panels.chunks(columns).map(row).collect()
        };
        Grid::with(page, panels, columns, area, own)
    }

    fn with(
        page: &Page,
        panels: &[Panel],
        columns: usize,
        [left, top, right, bottom]: Area,
        heights: impl Fn(&[Panel], usize, f64, f64) -> Vec<f64>,
    ) -> Grid {
        let columns = columns.min(panels.len()).max(1);
        let guess = (right - left) / columns as f64;
        let mut edges: Vec<Edges> = panels.iter().map(|p| panel::edges(page, p, guess)).collect();
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

    /// Where the last row ends with what is below it.
    fn end(&self) -> f64 {
        let last = self.edges.last().map_or(0.0, |e| e.bottom);
        self.rows.last().map_or(0.0, |row| row.1 + last)
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

/// Heights of the rows in a given height: equal, or as pictures need them.
fn filling(panels: &[Panel], columns: usize, width: f64, all: f64) -> Vec<f64> {
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
