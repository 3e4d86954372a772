//! Two axes: a heatmap for every objective.

use plotters::style::RGBColor;

use super::{Lane, NAME, page};
use crate::ReportError;
use crate::charts::Chart;
use crate::format::shortened;
use crate::plot::{Align, Canvas, Drawn, GREY, INK, Panel, fitted, palette, text_width};
use crate::sweep::colour;
use crate::sweep::measure::Measure;
use powergs_study::analysis::Analysis;

const TITLE: &str = "What the two axes do";
/// Objectives that a page has room for.
const MOST: usize = 3;

pub(super) fn chart(analysis: &Analysis, x: &Lane, y: &Lane) -> Result<Chart, ReportError> {
    let n = analysis.question.objectives.len().min(MOST);
    let widest = (0..y.order.len()).map(|p| text_width(&shortened(y.word(p), 14)));
    let left = 75.0 + widest.fold(0.0, f64::max);
    let width = (1245.0 - left - 24.0 * (n - 1) as f64) / n as f64;
    let drawing = page(analysis, TITLE).draw(|canvas| {
        for j in 0..n {
            let start = left + j as f64 * (width + 24.0);
            let panel = Panel { left: start, top: 170.0, right: start + width, bottom: 600.0 };
            heat(canvas, analysis, (x, y), j, panel)?;
            columns(canvas, x, panel)?;
            if j == 0 {
                for place in 0..y.order.len() {
                    let (_, (low, high)) = cell(panel, (x, y), 0, place);
                    let word = shortened(y.word(place), 14);
                    let at = (left - 10.0, (low + high) / 2.0);
                    canvas.text(&word, at, Align::Right, GREY)?;
                }
                let middle = (panel.top + panel.bottom) / 2.0;
                let name = fitted(y.name, panel.bottom - panel.top);
                canvas.text(&name, (28.0, middle), Align::Upwards, INK)?;
            }
        }
        canvas.dot((46.0, 690.0), 5, palette::ORANGE)?;
        canvas.text("on the front", (60.0, 690.0), Align::Left, INK)?;
        canvas.dot((206.0, 690.0), 8, palette::VERMILION)?;
        canvas.text("knee", (222.0, 690.0), Align::Left, INK)
    })?;
    Ok(Chart { name: NAME, title: TITLE, drawing })
}

/// Page ranges of a cell, whole units so that neighbours touch.
fn cell(panel: Panel, (x, y): (&Lane, &Lane), i: usize, k: usize) -> ((f64, f64), (f64, f64)) {
    let across = (panel.right - panel.left) / x.order.len() as f64;
    let down = (panel.bottom - panel.top) / y.order.len() as f64;
    let columns = (panel.left + i as f64 * across, panel.left + (i + 1) as f64 * across);
    // The smallest value lies at the bottom.
    let rows = (panel.bottom - (k + 1) as f64 * down, panel.bottom - k as f64 * down);
    ((columns.0.round(), columns.1.round()), (rows.0.round(), rows.1.round()))
}

fn heat(
    canvas: &Canvas,
    analysis: &Analysis,
    (x, y): (&Lane, &Lane),
    j: usize,
    panel: Panel,
) -> Drawn {
    let objective = &analysis.question.objectives[j];
    let measure = Measure::of(&objective.name);
    let value = |row: u32| analysis.value(j, row);
    let ends = analysis
        .rows
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |e, &r| (e.0.min(value(r)), e.1.max(value(r))));
    let title = fitted(&measure.words, (panel.right - panel.left) / 1.125);
    canvas.bold(&title, (panel.left, 112.0), Align::Left, INK)?;
    scale(canvas, panel, &measure, ends)?;
    canvas.fill((panel.left, panel.top), (panel.right, panel.bottom), palette::PALE)?;
    for &row in &analysis.rows {
        let ((x0, x1), (y0, y1)) = cell(panel, (x, y), x.place(row), y.place(row));
        let share = if ends.1 > ends.0 { (value(row) - ends.0) / (ends.1 - ends.0) } else { 0.5 };
        canvas.fill((x0, y0), (x1, y1), colour::at(share))?;
        let text = measure.text(value(row));
        let ink = if share > 0.55 { INK } else { RGBColor(255, 255, 255) };
        let middle = ((x0 + x1) / 2.0, (y0 + y1) / 2.0);
        if text_width(&text) + 8.0 < x1 - x0 && y1 - y0 > 36.0 {
            canvas.text(&text, (middle.0, middle.1 + 8.0), Align::Centre, ink)?;
        }
    }
    for &row in &analysis.front {
        let ((x0, x1), (y0, y1)) = cell(panel, (x, y), x.place(row), y.place(row));
        let up = if y1 - y0 > 36.0 { y0 + 12.0 } else { (y0 + y1) / 2.0 };
        let knee = row == analysis.knee;
        let colour = if knee { palette::VERMILION } else { palette::ORANGE };
        canvas.dot(((x0 + x1) / 2.0, up), if knee { 8 } else { 5 }, colour)?;
    }
    Ok(())
}

/// The colours with their ends, above a panel.
fn scale(canvas: &Canvas, panel: Panel, measure: &Measure, (low, high): (f64, f64)) -> Drawn {
    let (low, high) = (measure.text(low), measure.text(high));
    let left = panel.left + text_width(&low) + 8.0;
    let right = (panel.right - text_width(&high) - 8.0).max(left);
    canvas.text(&low, (panel.left, 144.0), Align::Left, GREY)?;
    canvas.text(&high, (panel.right, 144.0), Align::Right, GREY)?;
    const STEPS: i32 = 40;
    let width = (right - left) / f64::from(STEPS);
    for i in 0..STEPS {
        let from = left + f64::from(i) * width;
        let shade = colour::at((f64::from(i) + 0.5) / f64::from(STEPS));
        canvas.fill((from.round(), 137.0), ((from + width).round(), 151.0), shade)?;
    }
    Ok(())
}

fn columns(canvas: &Canvas, x: &Lane, panel: Panel) -> Drawn {
    let across = (panel.right - panel.left) / x.order.len() as f64;
    let mut free_from = f64::NEG_INFINITY;
    for place in 0..x.order.len() {
        let word = shortened(x.word(place), 14);
        let at = panel.left + (place as f64 + 0.5) * across;
        let half = text_width(&word) / 2.0;
        if at - half > free_from {
            canvas.text(&word, (at, panel.bottom + 20.0), Align::Centre, GREY)?;
            free_from = at + half + 6.0;
        }
    }
    let middle = (panel.left + panel.right) / 2.0;
    let name = fitted(x.name, panel.right - panel.left);
    canvas.text(&name, (middle, panel.bottom + 48.0), Align::Centre, INK)
}
