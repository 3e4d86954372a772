//! One axis: a curve for every objective.

use super::{Lane, NAME, page};
use crate::ReportError;
use crate::charts::Chart;
use crate::format::shortened;
use crate::plot::{Align, Canvas, Drawn, GREY, INK, Panel, palette, text_width};
use crate::sweep::axis::Axis;
use powergs_study::analysis::Analysis;

const TITLE: &str = "What the axis does";
/// Objectives that a page has room for.
const MOST: usize = 3;

pub(super) fn chart(analysis: &Analysis, lane: &Lane) -> Result<Chart, ReportError> {
    let n = analysis.question.objectives.len().min(MOST);
    let drawing = page(analysis, TITLE).draw(|canvas| {
        let height = (630.0 - 110.0 - 30.0 * (n - 1) as f64) / n as f64;
        for j in 0..n {
            let top = 110.0 + j as f64 * (height + 30.0);
            let panel = Panel { left: 160.0, top, right: 1220.0, bottom: top + height };
            curve(canvas, analysis, lane, j, panel)?;
        }
        let bottom = 630.0;
        let mut free_from = f64::NEG_INFINITY;
        for place in 0..lane.order.len() {
            let word = shortened(lane.word(place), 16);
            let (at, half) = (x(lane, place), text_width(&word) / 2.0);
            if at - half > free_from {
                canvas.text(&word, (at, bottom + 22.0), Align::Centre, GREY)?;
                free_from = at + half + 8.0;
            }
        }
        canvas.text(lane.name, (690.0, bottom + 50.0), Align::Centre, INK)
    })?;
    Ok(Chart { name: NAME, title: TITLE, drawing })
}

fn x(lane: &Lane, place: usize) -> f64 {
    let slots = lane.order.len() as f64;
    160.0 + (place as f64 + 0.5) * (1220.0 - 160.0) / slots
}

fn curve(canvas: &Canvas, analysis: &Analysis, lane: &Lane, j: usize, panel: Panel) -> Drawn {
    let values = analysis.rows.iter().map(|&row| analysis.value(j, row));
    let axis = Axis::of(&analysis.question.objectives[j].name, values, panel.vertical());
    // A name longer than the panel is high goes into the panel.
    panel.vertical_axis(canvas, &axis.scale, "")?;
    canvas.bold(&axis.name, (panel.left + 10.0, panel.top + 12.0), Align::Left, INK)?;
    let mut points: Vec<(usize, f64, u32)> =
        analysis.rows.iter().map(|&row| (lane.place(row), analysis.value(j, row), row)).collect();
    points.sort_by_key(|p| p.0);
    let line: Vec<(f64, f64)> =
        points.iter().map(|&(place, value, _)| (x(lane, place), axis.at(value))).collect();
    if line.len() > 1 {
        canvas.line(&line, palette::BLUE, 2)?;
    }
    for (&at, &(_, _, row)) in line.iter().zip(&points) {
        let colour = if row == analysis.knee { palette::VERMILION } else { palette::BLUE };
        canvas.dot(at, if row == analysis.knee { 9 } else { 5 }, colour)?;
    }
    Ok(())
}
