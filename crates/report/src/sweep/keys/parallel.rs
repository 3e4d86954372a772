//! More axes: parallel coordinates, a line per design through its settings to its objectives.

use super::{Lane, NAME, page};
use crate::ReportError;
use crate::charts::Chart;
use crate::format::{rounded, shortened};
use crate::plot::{Align, Canvas, Drawn, GREY, INK, fitted, palette, text_width};
use crate::sweep::axis::Axis;
use crate::sweep::colour::Key;
use powergs_study::analysis::Analysis;

const TITLE: &str = "Settings and results of every design";
/// Axes and objectives that a page has room for.
const LANES: usize = 6;
const OBJECTIVES: usize = 4;
/// Lines off the front that are drawn; more are a grey wall.
const LINES: usize = 600;
const TOP: f64 = 155.0;
const BOTTOM: f64 = 610.0;

pub(super) fn chart(analysis: &Analysis, lanes: &[Lane]) -> Result<Chart, ReportError> {
    let lanes = &lanes[..lanes.len().min(LANES)];
    let objectives = &analysis.question.objectives;
    let objectives = &objectives[..objectives.len().min(OBJECTIVES)];
    let axes: Vec<Axis> = (0..objectives.len())
        .map(|j| {
            let values = analysis.rows.iter().map(|&row| analysis.value(j, row));
            Axis::of(&objectives[j].name, values, (BOTTOM, TOP))
        })
        .collect();
    let n = lanes.len() + axes.len();
    let x = |i: usize| 120.0 + i as f64 * (1150.0 - 120.0) / (n - 1) as f64;
    let at = |lane: &Lane, place: usize| {
        BOTTOM - (place as f64 + 0.5) * (BOTTOM - TOP) / lane.order.len() as f64
    };
    let line = |row: u32| -> Vec<(f64, f64)> {
        let settings = lanes.iter().map(|lane| at(lane, lane.place(row)));
        let results = axes.iter().enumerate().map(|(j, axis)| axis.at(analysis.value(j, row)));
        settings.chain(results).enumerate().map(|(i, y)| (x(i), y)).collect()
    };
    let key = Key::named(analysis, &objectives[0].name, &analysis.front);
    let drawing = page(analysis, TITLE).draw(|canvas| {
        let step = analysis.rows.len().div_ceil(LINES).max(1);
        for &row in analysis.rows.iter().step_by(step) {
            canvas.line(&line(row), palette::PALE, 1)?;
        }
        for &row in &analysis.front {
            canvas.line(&line(row), key.colour(row), 2)?;
        }
        canvas.line(&line(analysis.knee), palette::VERMILION, 5)?;
        for (i, lane) in lanes.iter().enumerate() {
            rule(canvas, x(i), lane.name, i, n)?;
            let every = (lane.order.len() as f64 * 24.0 / (BOTTOM - TOP)).ceil() as usize;
            for place in (0..lane.order.len()).step_by(every.max(1)) {
                tick(canvas, (x(i), at(lane, place)), &shortened(&rounded(lane.word(place)), 12))?;
            }
        }
        for (j, axis) in axes.iter().enumerate() {
            let i = lanes.len() + j;
            rule(canvas, x(i), &axis.name, i, n)?;
            let ticks = axis.scale.ticks(6);
            for value in &ticks {
                let text = crate::plot::tick_label(*value, &ticks);
                tick(canvas, (x(i), axis.scale.at(*value)), &text)?;
            }
        }
        canvas.line(&[(40.0, 690.0), (70.0, 690.0)], palette::VERMILION, 5)?;
        let words = format!("knee {}", analysis.table.label(analysis.knee));
        canvas.text(&words, (80.0, 690.0), Align::Left, INK)?;
        let after = 80.0 + text_width(&words) + 30.0;
        let first = &axes[0].name;
        let front = format!("coloured: the front, by {first}; grey: other designs");
        canvas.text(&front, (after, 690.0), Align::Left, GREY)
    })?;
    Ok(Chart { name: NAME, title: TITLE, drawing })
}

/// A vertical axis with its name; names of neighbours take turns above and below.
fn rule(canvas: &Canvas, x: f64, name: &str, i: usize, n: usize) -> Drawn {
    canvas.line(&[(x, TOP), (x, BOTTOM)], GREY, 2)?;
    let y = if i.is_multiple_of(2) { TOP - 30.0 } else { BOTTOM + 34.0 };
    let room = 2.0 * (1150.0 - 120.0) / (n - 1).max(1) as f64 - 16.0;
    let room = room.min(2.0 * (x - 16.0)).min(2.0 * (1264.0 - x));
    canvas.bold(&fitted(name, room / 1.125), (x, y), Align::Centre, INK)
}

/// A value of an axis, on white so that it can be read over the lines.
fn tick(canvas: &Canvas, (x, y): (f64, f64), text: &str) -> Drawn {
    let white = plotters::style::RGBColor(255, 255, 255);
    let width = text_width(text);
    canvas.fill((x + 5.0, y - 10.0), (x + 13.0 + width, y + 10.0), white)?;
    canvas.line(&[(x - 5.0, y), (x + 5.0, y)], GREY, 2)?;
    canvas.text(text, (x + 9.0, y), Align::Left, INK)
}
