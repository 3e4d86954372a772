//! Frame time along the path, with the deadline at the display rate.

use super::{Chart, subtitle};
use crate::ReportError;
use crate::format::significant;
use crate::plot::{Align, Canvas, Drawn, INK, Page, Panel, Scale, palette, text_width};
use powergs_study::findings::RunSummary;
use powergs_study::run_record::Run;

const NAME: &str = "frame_time";
const TITLE: &str = "Frame time along the path";

/// A range wider than this is drawn logarithmically.
const WIDE: f64 = 50.0;
/// A deadline further above the data than this is told, not drawn: it would flatten the curve.
const FAR: f64 = 4.0;
/// Above this number of frames single frames get no dots.
const CROWDED: usize = 150;

pub(super) fn chart(run: &Run, summary: &RunSummary) -> Result<Option<Chart>, ReportError> {
    let Some(cycle) = &summary.cycle else { return Ok(None) };
    let times: Vec<f64> =
        run.frames.iter().filter_map(|f| f.frame_time_s()).map(|s| s * 1e3).collect();
    let deadline = 1e3 / run.facts.display_fps;
    let misses = cycle.deadline_misses;
    let numbers = format!(
        "mean {} ms, p99 {} ms; {misses} of {} over {} ms",
        significant(cycle.frame_time_ms),
        significant(cycle.frame_time_p99_ms),
        times.len(),
        significant(deadline)
    );
    let page =
        Page { name: NAME, title: TITLE.into(), subtitle: subtitle(run, &numbers), underlay: None };
    let numbers: Vec<f64> = run.frames.iter().map(|f| f.frame as f64).collect();
    let drawing = page.draw(|canvas| draw(canvas, &numbers, &times, deadline))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn draw(canvas: &Canvas, numbers: &[f64], times: &[f64], deadline: f64) -> Drawn {
    let panel = Panel { left: 130.0, top: 150.0, right: 1240.0, bottom: 630.0 };
    let high = times.iter().copied().fold(0.0, f64::max);
    let low = times.iter().copied().filter(|t| *t > 0.0).fold(high, f64::min);
    let near = deadline <= FAR * high;
    let top = if near { high.max(deadline) } else { high };
    let wide = low > 0.0 && high > WIDE * low;
    let y = if wide {
        Scale::logarithmic(low, top, panel.vertical())
    } else {
        Scale::from_zero(top * 1.05, panel.vertical())
    };
    let name = if wide { "frame time, ms (logarithmic)" } else { "frame time, ms" };
    panel.vertical_axis(canvas, &y, name)?;
    let (first, last) = (numbers[0], numbers[numbers.len() - 1]);
    let x = if first == last {
        Scale::exact(first - 1.0, last + 1.0, panel.horizontal())
    } else {
        Scale::exact(first, last, panel.horizontal())
    };
    let ticks = if first == last { vec![first] } else { x.whole_ticks(10) };
    panel.horizontal_axis(canvas, &x, &ticks, "frame")?;
    curve(canvas, &x, &y, numbers, times)?;
    dots(canvas, &x, &y, numbers, times, deadline)?;
    deadline_line(canvas, &panel, &y, deadline, near)?;
    key(canvas, 40.0, deadline, near)
}

/// The curve. Where several frames share a column of pixels it covers their whole range.
fn curve(canvas: &Canvas, x: &Scale, y: &Scale, numbers: &[f64], times: &[f64]) -> Drawn {
    let mut points: Vec<(f64, f64)> = Vec::new();
    let mut i = 0;
    while i < times.len() {
        let column = x.at(numbers[i]).round();
        let mut end = i + 1;
        while end < times.len() && x.at(numbers[end]).round() == column {
            end += 1;
        }
        let here = &times[i..end];
        let low = here.iter().copied().fold(f64::INFINITY, f64::min);
        let high = here.iter().copied().fold(0.0, f64::max);
        let ends = [here[0], low, high, here[here.len() - 1]];
        points.extend(ends.map(|t| (column, y.at(t))));
        points.dedup();
        i = end;
    }
    if points.len() > 1 { canvas.line(&points, palette::BLUE, 2) } else { Ok(()) }
}

/// Dots for frames while there is room, and for the missed ones in any case.
fn dots(
    canvas: &Canvas,
    x: &Scale,
    y: &Scale,
    numbers: &[f64],
    times: &[f64],
    deadline: f64,
) -> Drawn {
    let radius = if times.len() <= CROWDED { 4 } else { 3 };
    let mut last = None;
    for (n, t) in numbers.iter().zip(times) {
        let missed = *t > deadline;
        let at = (x.at(*n).round(), y.at(*t).round());
        if (missed || times.len() <= CROWDED) && last != Some(at) {
            let colour = if missed { palette::VERMILION } else { palette::BLUE };
            canvas.dot(at, radius, colour)?;
            last = Some(at);
        }
    }
    Ok(())
}

/// The dashed line, where it is on the chart.
fn deadline_line(canvas: &Canvas, panel: &Panel, y: &Scale, deadline: f64, near: bool) -> Drawn {
    if near {
        dashed(canvas, panel.left, panel.right, y.at(deadline))?;
    }
    Ok(())
}

fn dashed(canvas: &Canvas, left: f64, right: f64, y: f64) -> Drawn {
    let mut x = left;
    while x < right {
        canvas.line(&[(x, y), ((x + 12.0).min(right), y)], palette::VERMILION, 2)?;
        x += 20.0;
    }
    Ok(())
}

fn key(canvas: &Canvas, left: f64, deadline: f64, near: bool) -> Drawn {
    let y = 108.0;
    canvas.line(&[(left, y), (left + 32.0, y)], palette::BLUE, 2)?;
    canvas.dot((left + 16.0, y), 4, palette::BLUE)?;
    canvas.text("frame", (left + 42.0, y), Align::Left, INK)?;
    let x = left + 42.0 + text_width("frame") + 30.0;
    canvas.dot((x + 6.0, y), 4, palette::VERMILION)?;
    canvas.text("over the deadline", (x + 20.0, y), Align::Left, INK)?;
    let x = x + 20.0 + text_width("over the deadline") + 30.0;
    dashed(canvas, x, x + 32.0, y)?;
    let far = if near { "" } else { ": above this chart" };
    let name = format!("deadline {} ms{far}", significant(deadline));
    canvas.text(&name, (x + 42.0, y), Align::Left, INK)
}
