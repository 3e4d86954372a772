//! Marks of a panel as series of plotters, and labels beside them.

use std::collections::HashSet;

use plotters::coord::cartesian::Cartesian2d;
use plotters::prelude::*;

use super::coord::Coord;
use super::labels::{self, BESIDE, Obstacles, Wish};
use super::scene::{Area, ScenePoint, Shape};
use super::{
    Align, Drawn, FINE, Halo, Page, Recorder, TEXT, failed, fine, fitted, names::told_apart,
    plain_width, stroke, style, width,
};
use crate::axis::four_digits;
use crate::{
    Bar, Bin, Cell, Colour, Form, Gauge, Label, Line, Mark, Panel, Place, Points, Rule, Scale,
    Side, Size, Span, Weight, Words,
};

/// Half a bar is at most as thick, page units.
const THICKEST: f64 = 42.0;
/// A bar beside others is at most as thick.
const THICK_LANE: f64 = 24.0;
/// More points than this of a line in one column of pixels show their range only.
const DENSE: usize = 1500;
/// A line of more points than this is a curve of samples, none of which speaks.
const SPOKEN: usize = 60;
/// Height of a line of text.
const HEIGHT: f64 = 20.0;

type Context<'c> = ChartContext<'c, Recorder, Cartesian2d<Coord, Coord>>;

/// A panel being drawn.
pub(crate) struct Plot<'p, 'c> {
    page: &'p Page,
    panel: &'p Panel,
    chart: &'p mut Context<'c>,
    area: Area,
    /// What labels keep clear of.
    obstacles: Obstacles,
    /// Names of bars of histograms, which find their places when all marks are drawn.
    named: Vec<(Words, Wish)>,
}

impl<'p, 'c> Plot<'p, 'c> {
    /// A panel whose plot is `area`.
    pub(crate) fn new(
        page: &'p Page,
        panel: &'p Panel,
        chart: &'p mut Context<'c>,
        area: Area,
    ) -> Plot<'p, 'c> {
        Plot { page, panel, chart, area, obstacles: Obstacles::default(), named: Vec::new() }
    }

    /// Draws all marks, then the labels.
    pub(crate) fn draw(mut self) -> Drawn {
        let panel = self.panel;
        for mark in &panel.marks {
            match mark {
                Mark::Bars(bars) => self.bars(bars)?,
                Mark::Tornado { rows, colours } => self.tornado(rows, *colours)?,
                Mark::Histogram { bins, outlined } => self.histogram(bins, *outlined)?,
                Mark::Line(line) => self.line(line)?,
                Mark::Points(points) => self.points(points)?,
                Mark::Heat(cells) => self.heat(cells)?,
                Mark::Spans { spans, labels } => self.spans(spans, labels)?,
                Mark::Image { image, .. } if image.bytes().is_empty() => {}
                Mark::Image { image, sharp } => {
                    let (area, image, sharp) = (self.area, image.clone(), *sharp);
                    self.page.push(Shape::Image { area, image, sharp });
                }
                Mark::Rule { at, colour, dashed } => self.rule(*at, *colour, *dashed)?,
                Mark::Cross(at) => self.cross(*at)?,
                Mark::Gauge(gauge) => self.gauge(gauge)?,
                Mark::Label(_) => {}
            }
        }
        let labels = panel.marks.iter().filter_map(|mark| match mark {
            Mark::Label(label) => Some(label),
            _ => None,
        });
        self.labels(&labels.collect::<Vec<_>>())
    }

    /// The point of the page.
    fn at(&self, (x, y): Place) -> ScenePoint {
        let (x, y) = self.chart.backend_coord(&(x, y));
        (f64::from(x) / f64::from(FINE), f64::from(y) / f64::from(FINE))
    }

    fn rectangle(&mut self, a: Place, b: Place, colour: Colour) -> Drawn {
        let rectangle = Rectangle::new([a, b], style(colour).filled());
        self.chart.draw_series([rectangle]).map(|_| ()).map_err(failed)
    }

    /// A rectangle that is told from the page, whatever its colour.
    fn block(&mut self, a: Place, b: Place, colour: Colour) -> Drawn {
        self.rectangle(a, b, colour)?;
        // What is thinner than its outline twice would be outline only.
        let ((x0, y0), (x1, y1)) = (self.at(a), self.at(b));
        let is_thin = (x1 - x0).abs() < 4.0 || (y1 - y0).abs() < 4.0;
        let Some(edge) = colour.edge().filter(|_| !is_thin) else { return Ok(()) };
        let corners = [a, (a.0, b.1), b, (b.0, a.1), a].to_vec();
        let outline = PathElement::new(corners, stroke(edge, 1.0));
        self.chart.draw_series([outline]).map(|_| ()).map_err(failed)
    }

    /// Text in a rectangle where it fits.
    fn inside(&self, text: &str, a: Place, b: Place, colour: Colour) {
        let ((x0, y0), (x1, y1)) = (self.at(a), self.at(b));
        let fits = plain_width(text) + 8.0 < (x1 - x0).abs() && (y1 - y0).abs() >= 17.0;
        if fits && !text.is_empty() {
            let words = Words::new(text, colour.text());
            self.page.text(&words, ((x0 + x1) / 2.0, (y0 + y1) / 2.0), Align::Centre);
        }
    }

    /// Page units of one place of an axis of names.
    fn slot(&self, upright: bool) -> f64 {
        let [l, t, r, b] = self.area;
        let (scale, length) =
            if upright { (&self.panel.y.scale, b - t) } else { (&self.panel.x.scale, r - l) };
        length / scale.high()
    }

    fn bars(&mut self, bars: &[Bar]) -> Drawn {
        let level = matches!(self.panel.y.scale, Scale::Names(_));
        let slot = self.slot(level);
        for bar in bars {
            let lanes = bar.lane.1.max(1) as f64;
            let share = if bar.lane.1 > 1 { 0.84 } else { 0.68 };
            let most = if lanes > 1.0 && level { THICK_LANE * lanes } else { 2.0 * THICKEST };
            // Upright bars side by side are as wide as there is room: numbers stand on them.
            let most = if lanes > 1.0 && !level { slot } else { most };
            let whole = (share * slot).min(most) / slot;
            let thick = whole / lanes;
            let begin = bar.row as f64 + 0.5 - whole / 2.0 + bar.lane.0 as f64 * thick;
            let end = begin + thick * if lanes > 1.0 { 0.92 } else { 1.0 };
            let place = |value: f64, across: f64| {
                if level { (value, across) } else { (across, value) }
            };
            let mut from = 0.0;
            for part in &bar.parts {
                let value = if part.value.is_finite() { part.value } else { 0.0 };
                let (a, b) = (place(from, begin), place(from + value, end));
                self.block(a, b, part.colour)?;
                self.inside(&part.label, a, b, part.colour);
                let axes = (&self.panel.x, &self.panel.y);
                let (names, values) = if level { (axes.1, axes.0) } else { axes };
                let words = [names.spoken(bar.row as f64), values.spoken(value)];
                if value != 0.0 {
                    self.page.hint(self.at(a), self.at(b), part.colour, words);
                }
                let ((x0, y0), (x1, y1)) = (self.at(a), self.at(b));
                self.obstacles.solid.push([x0.min(x1), y0.min(y1), x0.max(x1), y0.max(y1)]);
                from += value;
            }
            if let Some(interval) = bar.interval {
                let middle = (begin + end) / 2.0;
                let ends = [interval.0, interval.1].map(|v| place(v, middle));
                self.whiskers(ends, 0.3 * thick * slot)?;
            }
            // A text on its whisker would be struck through.
            let behind = bar.interval.map_or(from, |(_, most)| from.max(most));
            let (x, y) = self.at(place(behind, (begin + end) / 2.0));
            let words = Words::from(bar.end.as_str());
            let wide = width(&words);
            let start = if level { (x + 10.0, y) } else { (x - wide / 2.0, y - 12.0) };
            self.page.sized(&words, start, Align::Left, TEXT, Halo::Thin);
            let half = HEIGHT / 2.0;
            let taken = [start.0, start.1 - half, start.0 + wide, start.1 + half];
            self.obstacles.solid.push(taken);
        }
        Ok(())
    }

    /// An interval: a line with caps.
    fn whiskers(&mut self, [from, to]: [Place; 2], half: f64) -> Drawn {
        let (a, b) = (self.at(from), self.at(to));
        if (a.0 - b.0).abs() + (a.1 - b.1).abs() < 1.0 {
            return Ok(());
        }
        let level = a.1 == b.1;
        let cap = |(x, y): ScenePoint| {
            if level { [(x, y - half), (x, y + half)] } else { [(x - half, y), (x + half, y)] }
        };
        for line in [[a, b], cap(a), cap(b)] {
            self.page.line(&line, Colour::INK, 1.0)?;
        }
        Ok(())
    }

    fn tornado(&mut self, rows: &[[Option<f64>; 2]], colours: [Colour; 2]) -> Drawn {
        let slot = self.slot(true);
        let half = (0.36 * slot).min(16.0) / slot;
        let (low, high) = (self.panel.x.scale.low(), self.panel.x.scale.high());
        let zero = self.at((0.0, 0.0)).0;
        for (i, values) in rows.iter().enumerate() {
            let middle = i as f64 + 0.5;
            let seen = |v: f64| (self.at((v, 0.0)).0 - zero).abs() >= 0.5;
            let same = matches!(*values, [Some(a), Some(b)] if a * b > 0.0 && seen(a) && seen(b));
            for (k, value) in values.iter().enumerate() {
                let Some(value) = value.filter(|v| v.is_finite()) else { continue };
                // Two bars to one side lie above each other.
                let (top, bottom) = match (same, k) {
                    (true, 0) => (middle - half, middle),
                    (true, _) => (middle, middle + half),
                    (false, _) => (middle - half, middle + half),
                };
                self.block((0.0, top), (value, bottom), colours[k])?;
                let words = [self.panel.y.spoken(middle), self.panel.x.spoken(value)];
                self.page.hint(self.at((0.0, top)), self.at((value, bottom)), colours[k], words);
                // A bar that the scale cuts off says how long it is.
                if value > high || value < low {
                    let (x, y) = self.at((value, (top + bottom) / 2.0));
                    let (at, align) =
                        if value > 0.0 { (x - 6.0, Align::Right) } else { (x + 6.0, Align::Left) };
                    let words = Words::new(format!("{value:+.0}"), colours[k].text());
                    self.page.text(&words, (at, y), align);
                    // And is cut, so that nobody takes it for its length.
                    let back = width(&words) + 14.0;
                    let cut = if value > 0.0 { x - back } else { x + back };
                    let (up, down) = (self.at((0.0, top)).1, self.at((0.0, bottom)).1);
                    let stroke = [(cut - 4.0, down + 1.0), (cut + 4.0, up - 1.0)];
                    self.page.line(&stroke, Colour::PAPER, 4.0)?;
                }
            }
        }
        let [_, top, _, bottom] = self.area;
        self.page.line(&[(zero, top), (zero, bottom)], Colour::NOTE, 1.0)
    }

    fn histogram(&mut self, bins: &[Bin], outlined: bool) -> Drawn {
        let floor = self.panel.y.scale.low();
        let wide = self.area[2] - self.area[0];
        let unit = (self.panel.x.scale.high() - self.panel.x.scale.low()) / wide;
        for bin in bins.iter().filter(|b| b.height > 0.0) {
            let gap = if outlined { 0.0 } else { unit };
            let (from, to) = (bin.from + gap, bin.to - gap);
            self.block((from, bin.height), (to, floor), bin.colour)?;
            if outlined {
                let corners = [(from, floor), (from, bin.height), (to, bin.height), (to, floor)];
                let line = PathElement::new(corners.to_vec(), stroke(Colour::INK, 1.0));
                self.chart.draw_series([line]).map_err(failed)?;
            }
            let ((l, t), (r, b)) = (self.at((from, bin.height)), self.at((to, floor)));
            self.obstacles.solid.push([l, t, r, b]);
            let (x, y) = (&self.panel.x, &self.panel.y);
            let range = format!("{} to {}", x.spoken(bin.from), four_digits(bin.to));
            self.page.hint((l, t), (r, b), bin.colour, [range, y.spoken(bin.height)]);
            if !bin.label.is_empty() {
                let words = Words::note(bin.label.as_str());
                let size = (width(&words), HEIGHT);
                let at = ((l + r) / 2.0, t);
                self.named.push((words, Wish { at, size, side: Side::Above, reach: BESIDE }));
            }
        }
        Ok(())
    }

    fn line(&mut self, line: &Line) -> Drawn {
        let is_number = |p: &Place| p.0.is_finite() && p.1.is_finite();
        for points in line.points.split(|p| !is_number(p)).filter(|p| p.len() > 1) {
            let places: Vec<ScenePoint> = points.iter().map(|p| self.at(*p)).collect();
            let pieces = places.windows(2).map(|ends| [ends[0], ends[1]]);
            let is_pale = [Colour::GRID, Colour::PALE].contains(&line.colour);
            if line.weight == Weight::Hair || is_pale {
                self.obstacles.faint.extend(pieces);
            } else {
                self.obstacles.curves.extend(pieces);
            }
            let width = match line.weight {
                Weight::Hair => 1.0,
                Weight::Thin => 2.0,
                Weight::Curve => 3.0,
                Weight::Bold => 5.0,
            };
            // Points of a curve speak; those of grids, bands and outlines do not.
            if matches!(line.weight, Weight::Curve | Weight::Bold)
                && !is_pale
                && points.len() <= SPOKEN
            {
                for (place, point) in places.iter().zip(points) {
                    self.spoken(*place, *point, line.colour, 5.0);
                }
            }
            let look = stroke(line.colour, width);
            let points = if points.len() > DENSE { ranges(points, &places) } else { points.into() };
            if line.dashed {
                let (dash, gap) = (fine(10.0), fine(8.0));
                let series = DashedLineSeries::new(points, dash, gap, look);
                self.chart.draw_series(series).map_err(failed)?;
            } else {
                self.chart.draw_series(LineSeries::new(points, look)).map_err(failed)?;
            }
        }
        Ok(())
    }

    fn points(&mut self, points: &Points) -> Drawn {
        let radius = match points.size {
            Size::Small => 4.0,
            Size::Medium => 5.5,
            Size::Large => 7.0,
            Size::Huge => 9.0,
        };
        let mut seen = HashSet::new();
        let mut shown = Vec::new();
        for &(place, colour) in &points.points {
            if !place.0.is_finite() || !place.1.is_finite() {
                continue;
            }
            let (x, y) = self.at(place);
            // One dot per place and colour, however many points lie there.
            if seen.insert(((x / 1.5) as i32, (y / 1.5) as i32, colour)) {
                shown.push((place, colour));
                self.spoken((x, y), place, colour, radius + 1.0);
                let reach = radius + if points.ring.is_some() { 4.0 } else { 2.0 };
                let place = [x - reach, y - reach, x + reach, y + reach];
                if points.crowd {
                    self.obstacles.crowd.push((x, y));
                } else {
                    self.obstacles.solid.push(place);
                }
            }
        }
        if let Some(ring) = points.ring {
            let rings: Vec<_> = shown.iter().map(|(place, _)| (*place, ring)).collect();
            let wide = if points.size == Size::Huge { 4.0 } else { 2.0 };
            self.look(&rings, points.form, radius + wide)?;
        }
        self.look(&shown, points.form, radius)
    }

    /// The values of a place to a pointer near it.
    fn spoken(&self, (x, y): ScenePoint, place: Place, colour: Colour, reach: f64) {
        let words = [self.panel.x.spoken(place.0), self.panel.y.spoken(place.1)];
        self.page.hint((x - reach, y - reach), (x + reach, y + reach), colour, words);
    }

    fn look(&mut self, points: &[(Place, Colour)], form: Form, radius: f64) -> Drawn {
        match form {
            Form::Dot => {
                // A rim is a larger dot below, so that every writer draws it alike.
                for &(place, colour) in points {
                    let rim = colour.edge().filter(|_| radius > 2.0);
                    let inner = if rim.is_some() { radius - 1.0 } else { radius };
                    let rim =
                        rim.map(|edge| Circle::new(place, fine(radius), style(edge).filled()));
                    let dot = Circle::new(place, fine(inner), style(colour).filled());
                    self.chart.draw_series(rim.into_iter().chain([dot])).map_err(failed)?;
                }
            }
            Form::Square => {
                for &(place, colour) in points {
                    let mut square = |reach: i32, colour: Colour| {
                        let corners = [(-reach, -reach), (reach, reach)];
                        let square = EmptyElement::at(place)
                            + Rectangle::new(corners, style(colour).filled());
                        self.chart.draw_series([square]).map(|_| ()).map_err(failed)
                    };
                    let rim = colour.edge().filter(|_| radius > 2.0);
                    if let Some(edge) = rim {
                        square(fine(0.86 * radius), edge)?;
                    }
                    let inner = if rim.is_some() { radius - 1.0 } else { radius };
                    square(fine(0.86 * inner), colour)?;
                }
            }
        }
        Ok(())
    }

    fn heat(&mut self, cells: &[Cell]) -> Drawn {
        let [l, t, r, b] = self.area;
        self.page.fill([l, t, r, b], Colour::PALE)?;
        let high = self.slot(true) > 36.0;
        let widest = cells.iter().map(|cell| plain_width(&cell.label)).fold(0.0, f64::max);
        // Dots stand before the labels where cells are wide enough, else above them.
        let beside = widest / 2.0 + 18.0;
        let is_wide = 2.0 * beside + 24.0 < self.slot(false);
        let shift = if high && !is_wide { 10.0 } else { 0.0 };
        for cell in cells {
            let (x, y) = (cell.column as f64, cell.row as f64);
            let (corner, end) = ((x, y), (x + 1.0, y + 1.0));
            self.rectangle(corner, end, cell.colour)?;
            let middle = self.at((x + 0.5, y + 0.5));
            let words = [self.panel.y.spoken(y), self.panel.x.spoken(x)];
            let words = words.map(|name| name.trim().to_owned());
            let says = [format!("{}, {}", words[0], words[1]), cell.label.clone()];
            self.page.hint(self.at(corner), self.at(end), cell.colour, says);
            if plain_width(&cell.label) + 8.0 < self.slot(false) && high {
                let words = Words::new(cell.label.as_str(), cell.colour.text());
                self.page.text(&words, (middle.0, middle.1 + shift), Align::Centre);
            }
            if let Some((colour, is_first)) = cell.dot {
                let radius = if is_first { 9.0 } else { 6.0 };
                let at = match (high, is_wide) {
                    (true, true) => (middle.0 - beside, middle.1),
                    (true, false) => (middle.0, self.at((x, y)).1 + 12.0),
                    (false, _) => middle,
                };
                self.page.dot(at, radius + 1.5, Colour::PAPER)?;
                self.page.dot(at, radius, colour)?;
            }
        }
        Ok(())
    }

    fn spans(&mut self, spans: &[Span], labels: &[(Span, String)]) -> Drawn {
        let corners = |s: &Span| ((s.from, s.track as f64), (s.to, s.track as f64 + 0.86));
        for span in spans {
            let (a, b) = corners(span);
            self.rectangle(a, b, span.colour)?;
            let range = format!("{} to {}", self.panel.x.spoken(span.from), four_digits(span.to));
            let words = [self.panel.y.spoken(span.track as f64), range];
            self.page.hint(self.at(a), self.at(b), span.colour, words);
        }
        for (span, text) in labels {
            let (a, b) = corners(span);
            self.inside(text, a, b, span.colour);
        }
        Ok(())
    }

    fn rule(&mut self, at: Rule, colour: Colour, dashed: bool) -> Drawn {
        let (x, y) = (&self.panel.x.scale, &self.panel.y.scale);
        let is_on = |scale: &Scale, v: f64| v >= scale.low() && v <= scale.high();
        let points = match at {
            Rule::X(v) if is_on(x, v) => vec![(v, y.low()), (v, y.high())],
            Rule::Y(v) if is_on(y, v) => vec![(x.low(), v), (x.high(), v)],
            Rule::X(_) | Rule::Y(_) => return Ok(()),
        };
        self.line(&Line { points, colour, weight: Weight::Thin, dashed })
    }

    fn cross(&mut self, at: Place) -> Drawn {
        let (x, y) = self.at(at);
        for (colour, width, reach) in [(Colour::INK, 5.0, 10.0), (Colour::PAPER, 2.0, 9.0)] {
            self.page.line(&[(x - reach, y), (x + reach, y)], colour, width)?;
            self.page.line(&[(x, y - reach), (x, y + reach)], colour, width)?;
        }
        Ok(())
    }

    /// An axis with its values beside it; lines pass under them.
    fn gauge(&mut self, gauge: &Gauge) -> Drawn {
        let [_, top, _, bottom] = self.area;
        let x = self.at((gauge.at, 0.0)).0;
        self.page.line(&[(x, top), (x, bottom)], Colour::NOTE, 1.5)?;
        // Names end before the next axis.
        let others = self.panel.marks.iter().filter_map(|mark| match mark {
            Mark::Gauge(other) => Some(self.at((other.at, 0.0)).0),
            _ => None,
        });
        let next = others.filter(|other| *other > x).fold(f64::INFINITY, f64::min);
        let names: Vec<&str> = gauge.labels.iter().map(|(_, text)| text.as_str()).collect();
        let names = told_apart(&names, next - x - 12.0);
        for ((height, _), text) in gauge.labels.iter().zip(&names) {
            let y = self.at((gauge.at, *height)).1;
            self.page.line(&[(x, y), (x + 5.0, y)], Colour::NOTE, 1.5)?;
            let words = Words::from(text.as_str());
            self.page.sized(&words, (x + 8.0, y), Align::Left, TEXT, Halo::Thin);
        }
        Ok(())
    }

    /// Labels with a side first, then the others.
    fn labels(&mut self, labels: &[&Label]) -> Drawn {
        let is_number = |l: &&Label| l.at.0.is_finite() && l.at.1.is_finite();
        let labels = labels.iter().copied().filter(is_number);
        let (mut labels, free): (Vec<&Label>, Vec<&Label>) =
            labels.partition(|l| l.side != Side::Free);
        labels.extend(free);
        let [l, t, r, b] = self.area;
        let room = (r - l) * 0.75;
        let wish = |label: &Label| {
            let words = fitted(&label.words, room);
            let (at, size) = (self.at(label.at), (width(&words), HEIGHT));
            (words, Wish { at, size, side: label.side, reach: f64::INFINITY })
        };
        let mut all: Vec<(Words, Wish)> = labels.into_iter().map(wish).collect();
        all.append(&mut self.named);
        let (words, wishes): (Vec<Words>, Vec<Wish>) = all.into_iter().unzip();
        // Over the edge where nothing else is written.
        let above = if self.panel.over.is_empty() { 8.0 } else { 0.0 };
        let beyond = if self.panel.right.is_empty() { 24.0 } else { 0.0 };
        let end = (r + beyond).min(self.page.frame.right + 4.0);
        let frame = [l + 2.0, t - above, end, b - 2.0];
        let places = labels::place(&wishes, &self.obstacles, frame);
        for ((place, wish), words) in places.iter().zip(&wishes).zip(&words) {
            let Some(area) = *place else { continue };
            if let Some(leader) = labels::leader(wish.at, area) {
                self.page.line(&leader, Colour::GREY, 1.0)?;
            }
            self.page.over(words, (area[0], (area[1] + area[3]) / 2.0), Align::Left);
        }
        Ok(())
    }
}

/// Where many points share a column of pixels: its first, least, largest and last one.
fn ranges(points: &[Place], places: &[ScenePoint]) -> Vec<Place> {
    let mut kept: Vec<Place> = Vec::new();
    let mut i = 0;
    while i < points.len() {
        let column = places[i].0.round();
        let mut end = i + 1;
        while end < points.len() && places[end].0.round() == column {
            end += 1;
        }
        let here = &points[i..end];
        let by_height = |a: &&Place, b: &&Place| a.1.total_cmp(&b.1);
        let low = here.iter().min_by(by_height).copied();
        let high = here.iter().max_by(by_height).copied();
        let x = here[0].0;
        let all = [Some(here[0]), low, high, here.last().copied()];
        kept.extend(all.into_iter().flatten().map(|p| (x, p.1)));
        kept.dedup();
        i = end;
    }
    kept
}
