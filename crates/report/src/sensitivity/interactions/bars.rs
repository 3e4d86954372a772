//! Sobol indices as bars with their intervals: first order inside total, one panel a measure.

use plotters::style::RGBColor;

use super::subtitle;
use crate::ReportError;
use crate::charts::Chart;
use crate::plot::{
    Align, Canvas, Drawn, GREY, GRID, INK, Page, Panel, Scale, fitted, legend, palette,
};
use powergs_study::analysis::indices::{Estimate, Index, Indices};
use powergs_study::findings::sensitivity::Measure;
use powergs_study::findings::sensitivity::interactions::Interactions;

const NAME: &str = "sobol";
const TITLE: &str = "Which keys explain the variance";
/// First order, total.
const COLOURS: [RGBColor; 2] = [palette::BLUE, palette::ORANGE];
/// Keys that a slide has room for.
const MOST: usize = 16;
const PANELS: [Measure; 3] = [Measure::Fps, Measure::Energy, Measure::Area];

/// The chart; `None` if no measure varies.
pub(super) fn chart(
    all: &Interactions,
    found: &[(Measure, Indices)],
) -> Result<Option<Chart>, ReportError> {
    let varies = |indices: &[Index]| indices.iter().any(|i| i.total.value > 0.0);
    let of = |m: &Measure| found.iter().find(|(other, i)| other == m && varies(&i.each));
    let panels: Vec<&(Measure, Indices)> = PANELS.iter().filter_map(of).collect();
    if panels.is_empty() {
        return Ok(None);
    }
    let mut order = all.order();
    order.truncate(MOST);
    let page = Page { name: NAME, title: TITLE.into(), subtitle: subtitle(all), underlay: None };
    let (left, gap, end) = (340.0, 56.0, 1235.0);
    let width = (end - left + gap) / panels.len() as f64 - gap;
    let drawing = page.draw(|canvas| {
        let entries = [("first order: alone", COLOURS[0]), ("total: with others", COLOURS[1])];
        legend(canvas, 40.0, 110.0, &entries)?;
        canvas.text("lines: 95 % intervals", (520.0, 110.0), Align::Left, GREY)?;
        for (k, (measure, indices)) in panels.iter().enumerate() {
            let start = left + k as f64 * (width + gap);
            let panel = Panel { left: start, top: 150.0, right: start + width, bottom: 630.0 };
            for (n, &i) in order.iter().enumerate().filter(|_| k == 0) {
                let label = fitted(&all.factors[i].key, left - 50.0);
                let (middle, _) = place(panel, order.len(), n);
                canvas.text(&label, (left - 12.0, middle), Align::Right, INK)?;
            }
            draw(canvas, panel, &order, &indices.each, measure.title())?;
        }
        Ok(())
    })?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

/// Middle and half height of the bars of key `n` of `count`.
fn place(panel: Panel, count: usize, n: usize) -> (f64, f64) {
    let slot = (panel.bottom - panel.top) / count.max(1) as f64;
    (panel.top + (n as f64 + 0.5) * slot, (0.38 * slot).min(18.0))
}

fn draw(canvas: &Canvas, panel: Panel, order: &[usize], indices: &[Index], name: &str) -> Drawn {
    let scale = Scale::exact(0.0, 1.0, panel.horizontal());
    let ticks = scale.ticks(5);
    for &tick in &ticks {
        canvas.line(&[(scale.at(tick), panel.top), (scale.at(tick), panel.bottom)], GRID, 1)?;
    }
    panel.horizontal_axis(canvas, &scale, &ticks, &format!("share, {name}"))?;
    for (n, &i) in order.iter().enumerate() {
        let (middle, height) = place(panel, order.len(), n);
        let pair = [(indices[i].first, -1.0), (indices[i].total, 1.0)];
        for ((estimate, side), colour) in pair.into_iter().zip(COLOURS) {
            let y = middle + side * height / 2.0;
            bar(canvas, &scale, &estimate, y, height * 0.45, colour)?;
        }
    }
    Ok(())
}

fn bar(
    canvas: &Canvas,
    scale: &Scale,
    estimate: &Estimate,
    y: f64,
    half: f64,
    colour: RGBColor,
) -> Drawn {
    let (zero, end) = (scale.at(0.0), scale.at(estimate.value));
    if end - zero >= 0.5 {
        canvas.fill((zero, y - half), (end, y + half), colour)?;
    }
    let (low, high) = (scale.at(estimate.low), scale.at(estimate.high));
    if high - low < 1.0 {
        return Ok(());
    }
    canvas.line(&[(low, y), (high, y)], INK, 1)?;
    for x in [low, high] {
        canvas.line(&[(x, y - half * 0.6), (x, y + half * 0.6)], INK, 1)?;
    }
    Ok(())
}
