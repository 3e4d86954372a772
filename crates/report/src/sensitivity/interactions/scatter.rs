//! μ* against σ of every key, one chart a measure: dots with numbers that do not overlap, and the
//! names beside them.

use plotters::style::RGBColor;

use super::subtitle;
use crate::ReportError;
use crate::charts::Chart;
use crate::format::significant;
use crate::plot::{
    Align, Canvas, Drawn, GREY, GRID, INK, Page, Panel, Scale, TEXT, fitted, palette, text_width,
};
use powergs_study::analysis::morris::Effect;
use powergs_study::findings::sensitivity::Measure;
use powergs_study::findings::sensitivity::interactions::Interactions;

const CHARTS: [(Measure, &str, &str); 3] = [
    (Measure::Fps, "morris_fps", "How keys act together: frames per second"),
    (Measure::Energy, "morris_energy", "How keys act together: energy per frame"),
    (Measure::Area, "morris_area", "How keys act together: area"),
];
const PANEL: Panel = Panel { left: 130.0, top: 130.0, right: 790.0, bottom: 630.0 };
/// Keys in the list at the right.
const MOST: usize = 20;
const DOT: f64 = 6.0;
/// Colours by what a key does: σ/μ* below these.
const COLOURS: [(&str, RGBColor); 4] = [
    ("< 0.1", palette::GREEN),
    ("< 0.5", palette::BLUE),
    ("< 1", palette::ORANGE),
    ("≥ 1", palette::VERMILION),
];
/// Keys below this share of the largest μ* are left out.
const LEAST: f64 = 0.001;

/// The charts; without one for a measure that nothing moves.
pub(super) fn charts(
    all: &Interactions,
    found: &[(Measure, Vec<Effect>)],
) -> Result<Vec<Chart>, ReportError> {
    let mut charts = Vec::new();
    for (measure, name, title) in CHARTS {
        let Some((_, effects)) = found.iter().find(|(m, _)| *m == measure) else { continue };
        if effects.iter().any(|e| e.mu_star > 0.0) {
            charts.push(chart(all, effects, name, title)?);
        }
    }
    Ok(charts)
}

fn kind(effect: &Effect) -> usize {
    match effect.sigma / effect.mu_star.max(f64::MIN_POSITIVE) {
        r if r < 0.1 => 0,
        r if r < 0.5 => 1,
        r if r < 1.0 => 2,
        _ => 3,
    }
}

fn chart(
    all: &Interactions,
    effects: &[Effect],
    name: &'static str,
    title: &'static str,
) -> Result<Chart, ReportError> {
    let mut order: Vec<usize> = (0..effects.len()).collect();
    order.sort_by(|&a, &b| effects[b].mu_star.total_cmp(&effects[a].mu_star));
    let most = order.first().map_or(0.0, |&i| effects[i].mu_star);
    order.retain(|&i| effects[i].mu_star > most * LEAST);
    let largest = |of: fn(&Effect) -> f64| effects.iter().map(of).fold(0.0, f64::max);
    let x = Scale::from_zero(largest(|e| e.mu_star) * 1.03, PANEL.horizontal());
    let y = Scale::from_zero(largest(|e| e.sigma).max(x.high() * 0.1) * 1.03, PANEL.vertical());
    let page = Page { name, title: title.into(), subtitle: subtitle(all), underlay: None };
    let drawing = page.draw(|canvas| {
        for tick in x.ticks(6) {
            canvas.line(&[(x.at(tick), PANEL.top), (x.at(tick), PANEL.bottom)], GRID, 1)?;
        }
        PANEL.vertical_axis(canvas, &y, "σ: bends or interacts, % of the machine as it is")?;
        let axis = "μ*: size of the effect over the range, % of the machine as it is";
        PANEL.horizontal_axis(canvas, &x, &x.ticks(6), axis)?;
        for slope in [0.1, 0.5, 1.0] {
            line(canvas, &x, &y, slope)?;
        }
        let dots: Vec<(f64, f64)> =
            order.iter().map(|&i| (x.at(effects[i].mu_star), y.at(effects[i].sigma))).collect();
        let labels: Vec<String> = (1..=dots.len()).map(|n| n.to_string()).collect();
        let places = places(&dots, &labels);
        for (n, &i) in order.iter().enumerate() {
            let (dot, place) = (dots[n], places[n]);
            let colour = COLOURS[kind(&effects[i])].1;
            let away = (dot.0 - place.0).hypot(dot.1 - place.1);
            if away > 3.5 * DOT {
                canvas.line(&[dot, place], palette::PALE, 1)?;
            }
            canvas.dot(dot, DOT as u32, colour)?;
        }
        for (label, place) in labels.iter().zip(&places) {
            canvas.text(label, *place, Align::Centre, INK)?;
        }
        list(canvas, all, effects, &order)
    })?;
    Ok(Chart { name, title, drawing })
}

/// A line of equal `σ/μ*` with its name, where it leaves the panel.
fn line(canvas: &Canvas, x: &Scale, y: &Scale, slope: f64) -> Drawn {
    let end = x.high().min(y.high() / slope);
    let (x1, y1) = (x.at(end), y.at(end * slope));
    canvas.line(&[(x.at(0.0), y.at(0.0)), (x1, y1)], GREY, 1)?;
    let text = format!("σ = {slope} μ*");
    if end < x.high() {
        canvas.text(&text, (x1, y1 - 14.0), Align::Centre, GREY)
    } else {
        canvas.text(&text, (x1 - 4.0, y1 - 14.0), Align::Right, GREY)
    }
}

/// A free place for each label: near its dot, over no dot and no other label.
fn places(dots: &[(f64, f64)], labels: &[String]) -> Vec<(f64, f64)> {
    let mut taken: Vec<(f64, f64)> = Vec::new();
    let half_height = TEXT * 0.55;
    for (dot, label) in dots.iter().zip(labels) {
        let half_width = text_width(label) / 2.0;
        let candidates = (0..6).flat_map(|ring| {
            (0..12).map(move |k| {
                let angle = std::f64::consts::PI * (0.25 + f64::from(k) / 6.0);
                let radius = 18.0 + 12.0 * f64::from(ring);
                (dot.0 + radius * angle.cos(), dot.1 - radius * angle.sin())
            })
        });
        let free = |at: &(f64, f64)| {
            let inside = at.0 - half_width > PANEL.left && at.1 + half_height < PANEL.bottom;
            let clear = |other: &(f64, f64), w: f64, h: f64| {
                (at.0 - other.0).abs() > half_width + w || (at.1 - other.1).abs() > half_height + h
            };
            inside
                && dots.iter().all(|d| clear(d, DOT, DOT))
                && taken.iter().all(|t| clear(t, 11.0, half_height))
        };
        taken.push(candidates.into_iter().find(free).unwrap_or((dot.0, dot.1 - 18.0)));
    }
    taken
}

/// Numbers, names and effects at the right.
fn list(canvas: &Canvas, all: &Interactions, effects: &[Effect], order: &[usize]) -> Drawn {
    let (left, right) = (830.0, 1245.0);
    canvas.text("σ/μ*", (left, 112.0), Align::Left, INK)?;
    let mut at = left + text_width("σ/μ*") + 22.0;
    for (name, colour) in COLOURS {
        canvas.dot((at + 6.0, 112.0), DOT as u32, colour)?;
        canvas.text(name, (at + 20.0, 112.0), Align::Left, INK)?;
        at += 20.0 + text_width(name) + 22.0;
    }
    canvas.text("μ*, %", (right, 146.0), Align::Right, GREY)?;
    for (n, &i) in order.iter().take(MOST).enumerate() {
        let y = 172.0 + 24.0 * n as f64;
        let effect = significant(effects[i].mu_star);
        let room = right - left - 40.0 - text_width(&effect) - 10.0;
        canvas.text(&(n + 1).to_string(), (left + 26.0, y), Align::Right, GREY)?;
        canvas.text(&fitted(&all.factors[i].key, room), (left + 38.0, y), Align::Left, INK)?;
        canvas.text(&effect, (right, y), Align::Right, INK)?;
    }
    Ok(())
}
