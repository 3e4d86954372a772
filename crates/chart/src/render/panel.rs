//! One panel: its axes as a plotters chart, its heading and the texts around it.

use plotters::prelude::*;
use plotters::style::{FontDesc, FontFamily, FontStyle};

use super::coord::Coord;
use super::marks::Plot;
use super::scene::{Area, Shape, Text};
use super::{
    Align, Drawn, FINE, LINE, Page, TEXT, failed, fine, fitted, plain_width, rgb, stroke, style,
    width, wrapped,
};
use crate::{Axis, Bar, Colour, Mark, Name, Panel, Scale, Words};

/// Room of names at the left of a panel, at most, on a wide and on a narrow page.
const NAMES: (f64, f64) = (440.0, 210.0);
/// The share of a panel for texts at its right, at most, on a wide and on a narrow page.
const RIGHT: (f64, f64) = (0.45, 0.34);
/// From the axis to its labels.
const AWAY: f64 = 12.0;
/// Length of a tick.
const TICK: f64 = 6.0;
/// Room of a title of an axis.
const TITLE: f64 = 30.0;
/// Bands of a colour scale.
const BANDS: u32 = 40;
/// Height of a text that reads upwards over a panel, at most.
const STANDING: f64 = 300.0;

/// Room around a plot, page units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Edges {
    /// For names or labels, and the title of the axis.
    pub left: f64,
    /// For texts at the right, and labels that reach over.
    pub right: f64,
    /// For headings.
    pub top: f64,
    /// For labels and the title of the axis.
    pub bottom: f64,
}

/// The room that a panel needs around its plot; `guess` is about how wide that is.
pub(crate) fn edges(page: &Page, panel: &Panel, guess: f64) -> Edges {
    let left = match &panel.y.scale {
        _ if !panel.y.shown => 0.0,
        Scale::Names(names) => {
            let title = match panel.y.title.is_empty() {
                true => 0.0,
                false if is_short(&panel.y) => bold_width(&panel.y.title) + 24.0,
                false => TITLE,
            };
            names_room(names, names_most(page)) + title
        }
        _ => {
            let widest = panel.y.labels().iter().map(|l| plain_width(&l.1)).fold(0.0, f64::max);
            AWAY + widest + if panel.y.words().is_empty() { 6.0 } else { TITLE }
        }
    };
    let beside = panel.right.iter().flat_map(|r| &r.1).map(width).fold(0.0, f64::max);
    let beside = if beside > 0.0 { beside.min(right_most(page, guess)) + 16.0 } else { 0.0 };
    let last = if panel.x.shown { panel.x.labels() } else { Vec::new() };
    let last = last.last().map_or(0.0, |l| plain_width(&l.1) / 2.0);
    let title = x_title(panel, guess).len();
    let below = below(panel, 0.86 * guess).iter().map(|(_, lines)| lines.len()).max();
    let names = 34.0 + (LINE - 2.0) * below.unwrap_or(1).saturating_sub(1) as f64;
    let bottom = match (panel.x.shown, title) {
        (false, _) => 8.0,
        (true, 0) => names,
        (true, lines) => names + TITLE + LINE * (lines - 1) as f64,
    };
    let left = if page.frame.is_narrow() { left.max(4.0) } else { left };
    Edges {
        left,
        right: beside.max(last.min(40.0)).max(ends_room(panel, guess)),
        top: heading_room(panel) + over_room(panel, guess),
        bottom: if panel.aspect.is_some() { 0.0 } else { bottom },
    }
}

/// Names below a panel, those that there are, by their number. One without neighbours has several
/// lines, if it needs them.
fn below(panel: &Panel, plot: f64) -> Vec<(usize, Vec<Words>)> {
    let Scale::Names(names) = &panel.x.scale else { return Vec::new() };
    let slot = plot / names.len().max(1) as f64;
    let is_empty = |i: usize| names.get(i).is_none_or(|name| name.words.text.is_empty());
    let lines = |(i, name): (usize, &Name)| {
        let is_alone = is_empty(i + 1) && (i == 0 || is_empty(i - 1)) && names.len() > 1;
        let lines = match is_alone {
            true => wrapped(&name.words, (2.0 * slot - 10.0).max(60.0), TEXT, OVER),
            false => vec![fitted(&name.words, (2.0 * slot).max(60.0))],
        };
        (i, lines)
    };
    names.iter().enumerate().filter(|(i, _)| !is_empty(*i)).map(lines).collect()
}

/// Room for names, at most.
fn names_most(page: &Page) -> f64 {
    if page.frame.is_narrow() { NAMES.1 } else { NAMES.0 }
}

/// Room for texts at the right, at most.
fn right_most(page: &Page, guess: f64) -> f64 {
    guess * if page.frame.is_narrow() { RIGHT.1 } else { RIGHT.0 }
}

/// The lines of the title below a panel.
fn x_title(panel: &Panel, guess: f64) -> Vec<Words> {
    let title = Words::from(panel.x.words());
    if title.text.is_empty() { Vec::new() } else { wrapped(&title, guess - 20.0, TEXT, 2) }
}

/// Lines of a text over or below a panel, at most.
const OVER: usize = 3;

/// Width of a text over the panel at `at` that may have `room` of the horizontal axis: the same to
/// both sides, on the page.
fn over_width(panel: &Panel, (at, room, _): &(f64, f64, Words), plot: f64) -> f64 {
    let share = panel.x.scale.share(*at);
    let room = room / (panel.x.scale.high() - panel.x.scale.low()) * plot - 6.0;
    let edge = 2.0 * (share.min(1.0 - share) * plot + 4.0);
    room.min(edge).max(24.0)
}

/// Whether texts over the panel read upwards: level ones have no room.
fn over_stands(panel: &Panel, plot: f64) -> bool {
    panel.over.iter().filter(|o| o.2.bold).any(|over| {
        let lines = wrapped(&over.2, over_width(panel, over, plot), TEXT, OVER);
        lines.iter().any(|l| l.text.ends_with('…'))
    })
}

/// Height of the texts over a panel.
fn over_room(panel: &Panel, guess: f64) -> f64 {
    let plot = 0.86 * guess;
    if panel.over.is_empty() {
        0.0
    } else if over_stands(panel, plot) {
        panel.over.iter().map(|o| width(&o.2)).fold(0.0, f64::max).min(STANDING) + 12.0
    } else {
        let lines = |over: &(f64, f64, Words)| match over.2.bold {
            true => wrapped(&over.2, over_width(panel, over, plot), TEXT, OVER).len(),
            false => 1,
        };
        4.0 + (LINE - 2.0) * panel.over.iter().map(lines).max().unwrap_or(1) as f64
    }
}

/// Height of a panel on a page that is as high as its panels, `count` of them.
pub(crate) fn own_height(panel: &Panel, width: f64, count: usize) -> f64 {
    if let Some(aspect) = panel.aspect.filter(|a| *a > 0.0) {
        return width / aspect;
    }
    let Scale::Names(names) = &panel.y.scale else {
        let share = match count {
            1 => 0.72,
            2 => 0.54,
            _ => 0.44,
        };
        return (share * width).max(200.0);
    };
    let slot = |mark: &Mark| match mark {
        Mark::Bars(bars) => {
            let lanes = bars.iter().map(|b| b.lane.1).max().unwrap_or(1).max(1) as f64;
            if lanes > 1.0 { 22.0 * lanes + 8.0 } else { 32.0 }
        }
        Mark::Heat(_) => 46.0,
        Mark::Spans { .. } => 24.0,
        _ => 28.0,
    };
    let slot = panel.marks.iter().map(slot).fold(20.0, f64::max);
    // Texts at the right may need two lines each.
    let lines = panel.right.iter().map(|r| 2 * r.1.len()).max().unwrap_or(1) as f64;
    let slot = slot.max((LINE - 2.0) * lines);
    // Long names have two lines.
    let is_long = names.iter().any(|name| super::width(&name.words) > NAMES.1);
    let slot = if is_long { slot.max(2.0 * (LINE - 2.0) + 8.0) } else { slot };
    (slot * names.len().max(1) as f64).max(80.0)
}

fn heading_room(panel: &Panel) -> f64 {
    let heading = !panel.heading.text.is_empty() || panel.remark.is_some();
    let colours = if panel.colours.is_some() { 30.0 } else { 0.0 };
    if heading { 34.0 + colours } else { 10.0 + colours }
}

fn names_room(names: &[Name], most: f64) -> f64 {
    let widest = names.iter().map(|n| width(&n.words)).fold(0.0, f64::max).min(most);
    let lead = names.iter().map(|n| plain_width(&n.lead)).fold(0.0, f64::max);
    14.0 + widest + if lead > 0.0 { lead + 24.0 } else { 0.0 }
}

/// Whether a title stands level beside names: it is the name of a unit, not a sentence.
fn is_short(axis: &Axis) -> bool {
    let names = matches!(axis.scale, Scale::Names(_));
    names && (1..=8).contains(&axis.title.chars().count())
}

fn bold_width(text: &str) -> f64 {
    width(&Words::bold(text))
}

/// Width of the texts behind the ends of bars, right of the plot.
fn ends_room(panel: &Panel, guess: f64) -> f64 {
    let bars = panel.marks.iter().filter_map(|mark| match mark {
        Mark::Bars(bars) => Some(bars),
        _ => None,
    });
    if !matches!(panel.y.scale, Scale::Names(_)) {
        return 0.0;
    }
    let over = |bar: &Bar| {
        let end: f64 = bar.parts.iter().map(|p| p.value).sum();
        let end = bar.interval.map_or(end, |(_, most)| end.max(most));
        let room = (1.0 - panel.x.scale.share(end)) * 0.6 * guess;
        if bar.end.is_empty() { 0.0 } else { plain_width(&bar.end) + 12.0 - room }
    };
    bars.flatten().map(over).fold(0.0, f64::max)
}

/// Draws a panel into its plot.
pub(crate) fn draw(page: &Page, panel: &Panel, plot: Area, edges: Edges) -> Drawn {
    around(page, panel, plot, edges);
    colours(page, panel, plot)?;
    let [left, top, right, bottom] = plot;
    let (mut x, mut y) = (Coord::new(&panel.x, false), Coord::new(&panel.y, true));
    thin(&panel.x, &mut x, right - left, |text| plain_width(text) + 10.0);
    thin(&panel.y, &mut y, bottom - top, |_| TEXT);
    let bottom_room = if panel.aspect.is_some() { 0.0 } else { edges.bottom };
    let corner = (fine(left - edges.left), fine(top));
    let size = (fine(edges.left + right - left), fine(bottom - top + bottom_room));
    let area = page.root.clone().shrink(corner, size);
    let mut chart = ChartBuilder::on(&area)
        .set_label_area_size(LabelAreaPosition::Left, fine(edges.left))
        .set_label_area_size(LabelAreaPosition::Bottom, fine(bottom_room))
        .build_cartesian_2d(x, y)
        .map_err(failed)?;
    let framed = panel.aspect.is_none() && (panel.x.shown || panel.y.shown);
    if framed {
        let font = FontDesc::new(FontFamily::SansSerif, TEXT * f64::from(FINE), FontStyle::Normal);
        let (ink, note) = (style(Colour::INK), style(Colour::NOTE));
        let mut mesh = chart.configure_mesh();
        mesh.bold_line_style(stroke(Colour::GRID, 1.0))
            .axis_style(stroke(Colour::NOTE, 1.0))
            .label_style(TextStyle::from(font.clone()).color(&note))
            .axis_desc_style(TextStyle::from(font).color(&ink))
            .set_tick_mark_size(LabelAreaPosition::Bottom, fine(TICK))
            .set_tick_mark_size(LabelAreaPosition::Left, fine(TICK));
        if !panel.x.grid {
            mesh.disable_x_mesh();
        }
        if !panel.y.grid {
            mesh.disable_y_mesh();
        }
        if !panel.x.shown {
            mesh.disable_x_axis();
        }
        if !panel.y.shown {
            mesh.disable_y_axis();
        }
        mesh.draw().map_err(failed)?;
        names(page, panel, plot, edges);
        titles(page, panel, plot, edges);
    }
    Plot::new(page, panel, &mut chart, plot).draw()?;
    breaks(page, panel, plot)
}

/// Two strokes across the beginning of an axis that leaves out zero.
fn breaks(page: &Page, panel: &Panel, [left, _, right, bottom]: Area) -> Drawn {
    let mut strokes = Vec::new();
    if panel.y.is_broken() {
        strokes.extend([12.0, 17.0].map(|up| {
            let y = bottom - up;
            [(left - 6.0, y + 3.0), (left + 6.0, y - 3.0)]
        }));
        page.fill([left - 2.0, bottom - 17.0, left + 2.0, bottom - 12.0], Colour::PAPER)?;
    }
    if panel.x.is_broken() && right - left > 60.0 {
        strokes.extend([12.0, 17.0].map(|along| {
            let x = left + along;
            [(x - 3.0, bottom + 6.0), (x + 3.0, bottom - 6.0)]
        }));
        page.fill([left + 12.0, bottom - 2.0, left + 17.0, bottom + 2.0], Colour::PAPER)?;
    }
    strokes.iter().try_for_each(|line| page.line(line, Colour::INK, 1.5))
}

/// Empties labels of ticks that would touch their neighbour: every second, every third, ...
fn thin(axis: &Axis, coord: &mut Coord, length: f64, room: impl Fn(&str) -> f64) {
    let is_turned = matches!(axis.scale, Scale::Linear { low, high } if low > high);
    let at = |value: f64| {
        let at = axis.scale.share(value).min(1.0) * length;
        if is_turned { length - at } else { at }
    };
    let fits = |every: &usize| {
        let mut free_from = f64::NEG_INFINITY;
        coord.labels.iter().step_by(*every).all(|(value, text)| {
            let half = room(text) / 2.0;
            let free = at(*value) - half >= free_from;
            free_from = at(*value) + half;
            free
        })
    };
    let every = (1..=coord.labels.len().max(1)).find(fits).unwrap_or(1);
    for (i, label) in coord.labels.iter_mut().enumerate() {
        if i % every != 0 {
            label.1.clear();
        }
    }
}

/// Titles of the axes.
fn titles(page: &Page, panel: &Panel, [left, top, right, bottom]: Area, edges: Edges) {
    if panel.x.shown {
        let guess = edges.left + right - left + edges.right;
        for (i, line) in x_title(panel, guess).iter().enumerate() {
            let half = width(line) / 2.0;
            // Below the middle, as far as the page is wide enough.
            let middle = ((left + right) / 2.0).min(page.frame.right - half);
            let middle = middle.max(page.frame.begin + half);
            let names = below(panel, right - left).iter().map(|n| n.1.len()).max().unwrap_or(1);
            let lines = (LINE - 2.0) * (names - 1) as f64 + LINE * i as f64;
            page.text(line, (middle, bottom + 50.0 + lines), Align::Centre);
        }
    }
    if panel.y.shown && is_short(&panel.y) {
        let at = (left - edges.left + 2.0, (top + bottom) / 2.0);
        page.text(&Words::bold(panel.y.title.as_str()), at, Align::Left);
    } else if panel.y.shown && !panel.y.words().is_empty() {
        let title = fitted(&Words::from(panel.y.words()), bottom - top + 40.0);
        let x = left - edges.left + 0.9 * TEXT;
        let start = (x, (top + bottom + width(&title)) / 2.0);
        upwards(page, title, start);
    }
}

/// Text that reads upwards from a point.
fn upwards(page: &Page, words: Words, start: (f64, f64)) {
    let (width, fill, bold) = (width(&words), rgb(words.colour), words.bold);
    let (upwards, halo, text) = (true, 0.0, words.text);
    page.push(Shape::Text(Text { text, start, width, size: TEXT, bold, upwards, fill, halo }));
}

/// Names at the left and below.
fn names(page: &Page, panel: &Panel, [left, top, right, bottom]: Area, edges: Edges) {
    if let (Scale::Names(names), true) = (&panel.y.scale, panel.y.shown) {
        let slot = (bottom - top) / names.len().max(1) as f64;
        // Every name where there is room, else every second, third, …
        let every = (15.0 / slot).ceil().max(1.0) as usize;
        for (i, name) in names.iter().enumerate().step_by(every) {
            let y = top + (i as f64 + 0.5) * slot;
            page.text(&Words::note(name.lead.as_str()), (left - edges.left + 10.0, y), Align::Left);
            let most = if slot >= 2.0 * (LINE - 2.0) { 2 } else { 1 };
            let lines = wrapped(&name.words, names_most(page), TEXT, most);
            let first = y - (LINE - 2.0) * (lines.len() - 1) as f64 / 2.0;
            for (i, line) in lines.iter().enumerate() {
                page.text(line, (left - 12.0, first + (LINE - 2.0) * i as f64), Align::Right);
            }
        }
    }
    if let (Scale::Names(names), true) = (&panel.x.scale, panel.x.shown) {
        let slot = (right - left) / names.len().max(1) as f64;
        let mut free_from = f64::NEG_INFINITY;
        for (i, lines) in below(panel, right - left) {
            let x = left + (i as f64 + 0.5) * slot;
            let half = lines.iter().map(width).fold(0.0, f64::max) / 2.0;
            if x - half > free_from {
                for (n, line) in lines.iter().enumerate() {
                    let y = bottom + 22.0 + (LINE - 2.0) * n as f64;
                    page.text(line, (x, y), Align::Centre);
                }
                free_from = x + half + 8.0;
            }
        }
    }
}

/// Headings, and texts over and right of the plot.
fn around(page: &Page, panel: &Panel, [left, top, right, bottom]: Area, edges: Edges) {
    let over = edges.top - heading_room(panel);
    let y = top - 20.0 - over - if panel.colours.is_some() { 30.0 } else { 0.0 };
    let remark = panel.remark.as_ref().map_or(0.0, |remark| width(remark) + 16.0);
    if let Some(remark) = &panel.remark {
        page.text(remark, (right, y), Align::Right);
    }
    // Over the names at the left too, if that is what it needs.
    let wide = width(&panel.heading);
    let start = if wide > right - left - remark { left - edges.left + 4.0 } else { left };
    let room = (right + edges.right.min(40.0) - start - remark).max(120.0);
    let heading = fitted(&panel.heading, room);
    if panel.aspect.is_some() && wide > right - left {
        page.text(&heading, ((left + right) / 2.0, y), Align::Centre);
    } else {
        page.text(&heading, (start, y), Align::Left);
    }
    texts_over(page, panel, [left, top, right, bottom], edges);
    for (at, lines) in &panel.right {
        let share = panel.y.scale.share(*at);
        let downwards = matches!(panel.y.scale, Scale::Names(_));
        let middle =
            if downwards { top + share * (bottom - top) } else { bottom - share * (bottom - top) };
        let room = page.frame.right + 8.0 - right - 14.0;
        let most = if page.frame.is_narrow() { 2 } else { 1 };
        let lines: Vec<Words> =
            lines.iter().flat_map(|words| wrapped(words, room, TEXT, most)).collect();
        let first = middle - (LINE - 2.0) * (lines.len().saturating_sub(1)) as f64 / 2.0;
        for (i, words) in lines.iter().enumerate() {
            page.text(words, (right + 14.0, first + (LINE - 2.0) * i as f64), Align::Left);
        }
    }
}

/// Texts over the plot: bold ones in one or two lines, or upwards; others where they fit.
fn texts_over(page: &Page, panel: &Panel, [left, top, right, _]: Area, edges: Edges) {
    let across = |v: f64| left + panel.x.scale.share(v) * (right - left);
    let stands = over_stands(panel, 0.86 * (edges.left + right - left + edges.right));
    for over in &panel.over {
        let (x, words) = (across(over.0), &over.2);
        let room = over_width(panel, over, right - left);
        if stands && words.bold {
            upwards(page, fitted(words, STANDING), (x + 0.3 * TEXT, top - 8.0));
        } else if words.bold {
            let lines = wrapped(words, room, TEXT, OVER);
            for (i, line) in lines.iter().rev().enumerate() {
                let y = top - 14.0 - (LINE - 2.0) * i as f64;
                page.text(line, (x, y), Align::Centre);
            }
        } else if width(words) <= room {
            page.text(words, (x, top - 14.0), Align::Centre);
        }
    }
}

/// The colours with their ends, over a plot.
fn colours(page: &Page, panel: &Panel, [left, top, right, _]: Area) -> Drawn {
    let Some((low, high)) = &panel.colours else { return Ok(()) };
    let y = top - 20.0;
    page.text(&Words::note(low.as_str()), (left, y), Align::Left);
    page.text(&Words::note(high.as_str()), (right, y), Align::Right);
    let begin = left + plain_width(low) + 8.0;
    let end = right - plain_width(high) - 8.0;
    if end <= begin {
        return Ok(());
    }
    let band = (end - begin) / f64::from(BANDS);
    for i in 0..BANDS {
        let from = begin + f64::from(i) * band;
        let colour = Colour::at((f64::from(i) + 0.5) / f64::from(BANDS));
        page.fill([from, y - 7.0, from + band, y + 7.0], colour)?;
    }
    Ok(())
}
