//! One panel: its axes as a plotters chart, its heading and the texts around it.

use plotters::prelude::*;
use plotters::style::{FontDesc, FontFamily, FontStyle};

use super::coord::Coord;
use super::marks::Plot;
use super::scene::{Area, Shape, Text};
use super::{
    Align, Drawn, FINE, LINE, Page, TEXT, failed, fine, fitted, plain_width, rgb, stroke, style,
    width,
};
use crate::{Axis, Bar, Colour, Mark, Name, Panel, Scale, Words};

/// Room of names at the left of a panel, at most.
const NAMES: f64 = 340.0;
/// From the axis to its labels.
const AWAY: f64 = 12.0;
/// Length of a tick.
const TICK: f64 = 6.0;
/// Room of a title of an axis.
const TITLE: f64 = 30.0;
/// Bands of a colour scale.
const BANDS: u32 = 40;

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
pub(crate) fn edges(panel: &Panel, guess: f64) -> Edges {
    let title = |axis: &Axis| match axis.title.is_empty() {
        true => 0.0,
        false if is_short(axis) => bold_width(&axis.title) + 24.0,
        false => TITLE,
    };
    let left = match &panel.y.scale {
        _ if !panel.y.shown => 0.0,
        Scale::Names(names) => names_room(names) + title(&panel.y),
        _ => {
            let widest = panel.y.labels().iter().map(|l| plain_width(&l.1)).fold(0.0, f64::max);
            AWAY + widest + title(&panel.y).max(6.0)
        }
    };
    let beside = panel.right.iter().flat_map(|r| &r.1).map(width).fold(0.0, f64::max);
    let beside = if beside > 0.0 { beside.min(0.45 * guess) + 16.0 } else { 0.0 };
    let last = if panel.x.shown { panel.x.labels() } else { Vec::new() };
    let last = last.last().map_or(0.0, |l| plain_width(&l.1) / 2.0);
    let bottom = if panel.x.shown { 34.0 + title(&panel.x) } else { 8.0 };
    Edges {
        left,
        right: beside.max(last.min(40.0)).max(ends_room(panel, guess)),
        top: heading_room(panel) + if panel.over.is_empty() { 0.0 } else { 26.0 },
        bottom: if panel.aspect.is_some() { 0.0 } else { bottom },
    }
}

fn heading_room(panel: &Panel) -> f64 {
    let heading = !panel.heading.text.is_empty() || panel.remark.is_some();
    let colours = if panel.colours.is_some() { 30.0 } else { 0.0 };
    if heading { 34.0 + colours } else { 10.0 + colours }
}

fn names_room(names: &[Name]) -> f64 {
    let widest = names.iter().map(|n| width(&n.words)).fold(0.0, f64::max).min(NAMES);
    let lead = names.iter().map(|n| plain_width(&n.lead)).fold(0.0, f64::max);
    14.0 + widest + if lead > 0.0 { lead + 24.0 } else { 0.0 }
}

/// Whether a title stands level beside names: it is the name of a unit, not a sentence.
fn is_short(axis: &Axis) -> bool {
    let names = matches!(axis.scale, Scale::Names(_));
    names && (1..=6).contains(&axis.title.chars().count())
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
        let end = bar.parts.iter().map(|p| p.value).sum();
        let room = (1.0 - panel.x.scale.share(end)) * 0.6 * guess;
        if bar.end.is_empty() { 0.0 } else { plain_width(&bar.end) + 12.0 - room }
    };
    bars.flatten().map(over).fold(0.0, f64::max)
}

/// Draws a panel into its plot.
pub(crate) fn draw(page: &Page, panel: &Panel, plot: Area, edges: Edges) -> Drawn {
    around(page, panel, plot);
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
    Plot::new(page, panel, &mut chart, plot).draw()
}

/// Empties labels of ticks that would touch their neighbour.
fn thin(axis: &Axis, coord: &mut Coord, length: f64, room: impl Fn(&str) -> f64) {
    let mut free_from = f64::NEG_INFINITY;
    for (value, text) in &mut coord.labels {
        let at = axis.scale.share(*value).min(1.0) * length;
        // On an axis that is turned round, labels come from its end.
        let at = if matches!(axis.scale, Scale::Linear { low, high } if low > high) {
            length - at
        } else {
            at
        };
        let half = room(text) / 2.0;
        if at - half < free_from {
            text.clear();
        } else {
            free_from = at + half;
        }
    }
}

/// Titles of the axes.
fn titles(page: &Page, panel: &Panel, [left, top, right, bottom]: Area, edges: Edges) {
    if panel.x.shown && !panel.x.title.is_empty() {
        let middle = (left + right) / 2.0;
        let title = Words::from(panel.x.title.as_str());
        let room = right - left + edges.left.min(60.0) + edges.right.min(60.0);
        page.text(&fitted(&title, room), (middle, bottom + 50.0), Align::Centre);
    }
    if panel.y.shown && is_short(&panel.y) {
        let at = (left - edges.left + 2.0, (top + bottom) / 2.0);
        page.text(&Words::bold(panel.y.title.as_str()), at, Align::Left);
    } else if panel.y.shown && !panel.y.title.is_empty() {
        let title = fitted(&Words::from(panel.y.title.as_str()), bottom - top + 40.0);
        let width = width(&title);
        let start = (left - edges.left + 0.9 * TEXT, (top + bottom + width) / 2.0);
        let (text, fill) = (title.text, rgb(title.colour));
        let (bold, upwards, halo) = (false, true, false);
        page.push(Shape::Text(Text { text, start, width, size: TEXT, bold, upwards, fill, halo }));
    }
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
            page.text(&fitted(&name.words, NAMES), (left - 12.0, y), Align::Right);
        }
    }
    if let (Scale::Names(names), true) = (&panel.x.scale, panel.x.shown) {
        let slot = (right - left) / names.len().max(1) as f64;
        let mut free_from = f64::NEG_INFINITY;
        for (i, name) in names.iter().enumerate() {
            let x = left + (i as f64 + 0.5) * slot;
            let words = fitted(&name.words, (2.0 * slot).max(60.0));
            let half = width(&words) / 2.0;
            if x - half > free_from {
                page.text(&words, (x, bottom + 22.0), Align::Centre);
                free_from = x + half + 8.0;
            }
        }
    }
}

/// Headings, and texts over and right of the plot.
fn around(page: &Page, panel: &Panel, [left, top, right, bottom]: Area) {
    let over = if panel.over.is_empty() { 0.0 } else { 26.0 };
    let y = top - 20.0 - over - if panel.colours.is_some() { 30.0 } else { 0.0 };
    let mut room = right - left;
    if let Some(remark) = &panel.remark {
        page.text(remark, (right, y), Align::Right);
        room -= width(remark) + 16.0;
    }
    let heading = fitted(&panel.heading, room.max(200.0));
    let centred = panel.aspect.is_some() && width(&heading) > right - left;
    if centred {
        page.text(&heading, ((left + right) / 2.0, y), Align::Centre);
    } else {
        page.text(&heading, (left, y), Align::Left);
    }
    let across = |v: f64| left + panel.x.scale.share(v) * (right - left);
    for (at, room, words) in &panel.over {
        let span = (panel.x.scale.high() - panel.x.scale.low()) / (right - left);
        let room = room / span;
        let fits = width(words) + 6.0 <= room;
        if fits || words.bold {
            let words = fitted(words, room - 6.0);
            page.text(&words, (across(*at), top - 14.0), Align::Centre);
        }
    }
    for (at, lines) in &panel.right {
        let share = panel.y.scale.share(*at);
        let downwards = matches!(panel.y.scale, Scale::Names(_));
        let middle =
            if downwards { top + share * (bottom - top) } else { bottom - share * (bottom - top) };
        let first = middle - (LINE - 2.0) * (lines.len().saturating_sub(1)) as f64 / 2.0;
        for (i, words) in lines.iter().enumerate() {
            let words = fitted(words, super::SIZE.0 - 12.0 - right - 14.0);
            page.text(&words, (right + 14.0, first + (LINE - 2.0) * i as f64), Align::Left);
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
