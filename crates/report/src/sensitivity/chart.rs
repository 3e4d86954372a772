//! A tornado for each trace: the knobs that move most, as bars to both sides of the machine as it
//! is.

use plotters::style::RGBColor;

use crate::ReportError;
use crate::charts::Chart;
use crate::format::{shortened, significant};
use crate::plot::{
    Align, Canvas, Drawn, GREY, GRID, INK, Page, Panel, Scale, fitted, legend, palette,
};
use powergs_study::findings::sensitivity::{Change, Row, Sensitivity};

/// File names; further traces have no chart.
const NAMES: [&str; 4] = ["tornado", "tornado_2", "tornado_3", "tornado_4"];
const TITLE: &str = "What assumptions move";
/// Bars that a slide has room for.
const MOST: usize = 18;
/// Turned down, turned up.
const COLOURS: [RGBColor; 2] = [palette::BLUE, palette::ORANGE];
/// A scale ends here at the latest, percent.
const WIDEST: f64 = 200.0;

/// A chart for each of the first traces.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
pub fn charts(all: &Sensitivity) -> Result<Vec<Chart>, ReportError> {
    let traces = 0..all.traces.len().min(NAMES.len());
    traces.map(|t| chart(all, t)).collect()
}

fn chart(all: &Sensitivity, t: usize) -> Result<Chart, ReportError> {
    let trace = &all.traces[t];
    // The title names one machine: rows about others stay in the tables.
    let moves = |r: &&Row| r.on.is_none() && effect(r, t) >= 0.0005;
    let mut rows: Vec<&Row> = all.rows.iter().filter(moves).collect();
    rows.sort_by(|a, b| effect(b, t).total_cmp(&effect(a, t)));
    rows.truncate(MOST);
    let note = all.incomplete_note().map_or(String::new(), |note| format!("{note}. "));
    let (fps, mj) = (significant(trace.base.fps()), significant(trace.base.energy_mj()));
    let (name, machine) = (shortened(&trace.name, 30), shortened(&all.machine, 20));
    let subtitle = format!("{note}{name} on {machine}: {fps} FPS, {mj} mJ a frame as it is");
    let page = Page { name: NAMES[t], title: TITLE.into(), subtitle, underlay: None };
    let left = Panel { left: 330.0, top: 150.0, right: 755.0, bottom: 640.0 };
    let right = Panel { left: 820.0, right: 1245.0, ..left };
    let drawing = page.draw(|canvas| {
        legend(
            canvas,
            40.0,
            108.0,
            &[("turned down", COLOURS[0]), ("turned up, or another name", COLOURS[1])],
        )?;
        for (i, row) in rows.iter().enumerate() {
            let (middle, _) = place(left, rows.len(), i);
            canvas.text(&row.number, (40.0, middle), Align::Left, GREY)?;
            let knob = fitted(&row.knob(), left.left - 100.0);
            canvas.text(&knob, (left.left - 12.0, middle), Align::Right, INK)?;
        }
        bars(canvas, left, &rows, t, "frames per second, change in %", |c| c.fps)?;
        bars(canvas, right, &rows, t, "energy per frame, change in %", |c| c.energy)
    })?;
    Ok(Chart { name: NAMES[t], title: TITLE, drawing })
}

fn effect(row: &Row, t: usize) -> f64 {
    let size = |c: Change| c.fps.abs().max(c.energy.abs());
    row.changes(t).into_iter().flatten().map(size).fold(0.0, f64::max)
}

/// Middle and half height of bar `i` of `n`.
fn place(panel: Panel, n: usize, i: usize) -> (f64, f64) {
    let slot = (panel.bottom - panel.top) / n.max(1) as f64;
    (panel.top + (i as f64 + 0.5) * slot, (0.36 * slot).min(16.0))
}

fn bars(
    canvas: &Canvas,
    panel: Panel,
    rows: &[&Row],
    t: usize,
    name: &str,
    of: impl Fn(Change) -> f64,
) -> Drawn {
    let percents = |row: &Row| row.changes(t).map(|c| c.map(|c| of(c) * 100.0));
    let all = rows.iter().flat_map(|row| percents(row)).flatten();
    let end = all.map(f64::abs).fold(1.0, f64::max).min(WIDEST);
    let half = Scale::from_zero(end, (0.0, 1.0)).high();
    let scale = Scale::exact(-half, half, panel.horizontal());
    for tick in scale.ticks(6) {
        let x = scale.at(tick);
        canvas.line(&[(x, panel.top), (x, panel.bottom)], GRID, 1)?;
    }
    panel.horizontal_axis(canvas, &scale, &scale.ticks(6), name)?;
    let zero = scale.at(0.0);
    for (i, row) in rows.iter().enumerate() {
        let (middle, height) = place(panel, rows.len(), i);
        let values = percents(row);
        let same = matches!(values, [Some(a), Some(b)] if a * b > 0.0);
        for (k, value) in values.into_iter().enumerate() {
            let Some(value) = value else { continue };
            // Two bars to one side lie above each other.
            let (top, bottom) = match (same, k) {
                (true, 0) => (middle - height, middle),
                (true, _) => (middle, middle + height),
                (false, _) => (middle - height, middle + height),
            };
            let x = scale.at(value);
            if (x - zero).abs() >= 0.5 {
                canvas.fill((zero.min(x), top), (zero.max(x), bottom), COLOURS[k])?;
            }
        }
    }
    canvas.line(&[(zero, panel.top), (zero, panel.bottom)], GREY, 1)
}
