//! Operations per DRAM byte against operations per second, under the roof of the machine.

use plotters::style::RGBColor;

use super::{Chart, frames, subtitle};
use crate::ReportError;
use crate::format::engineering;
use crate::plot::{Align, Canvas, Drawn, GREY, GRID, INK, Page, Panel, Scale, palette, text_width};
use powergs_core::action::Stage;
use powergs_study::findings::roofline::{Point, Roofline};
use powergs_study::run_record::Run;

const NAME: &str = "roofline";
const TITLE: &str = "Roofline";

pub(super) fn chart(run: &Run) -> Result<Option<Chart>, ReportError> {
    let Some(roof) = &run.facts.machine.roofline else { return Ok(None) };
    let points = roof.points(run);
    if points.is_empty() || roof.peak_flop_s() <= 0.0 {
        return Ok(None);
    }
    let peak = engineering(roof.peak_flop_s(), "FLOP/s");
    let what = format!("{}, peak {peak} and {}", frames(run), rate(roof));
    let page =
        Page { name: NAME, title: TITLE.into(), subtitle: subtitle(run, &what), underlay: None };
    let drawing = page.draw(|canvas| draw(canvas, roof, &points))?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

fn rate(roof: &Roofline) -> String {
    engineering(roof.dram_bytes_s, "B/s")
}

fn colour(point: &Point) -> RGBColor {
    match point.stage {
        Some(Stage::Preprocessing) => palette::GREEN,
        Some(Stage::Sorting) => palette::ORANGE,
        Some(Stage::Rendering) => palette::VERMILION,
        Some(Stage::Standby) => palette::GREY,
        None => INK,
    }
}

fn draw(canvas: &Canvas, roof: &Roofline, points: &[Point]) -> Drawn {
    let panel = Panel { left: 150.0, top: 120.0, right: 1240.0, bottom: 630.0 };
    let peak = roof.peak_flop_s();
    let ridge = peak / roof.dram_bytes_s;
    let most = |of: fn(&Point) -> f64| points.iter().map(of).fold(0.0, f64::max);
    let least = |of: fn(&Point) -> f64| points.iter().map(of).fold(f64::INFINITY, f64::min);
    let x_low = least(|p| p.flop_per_byte).min(ridge) / 4.0;
    let x_high = most(|p| p.flop_per_byte).max(ridge) * 4.0;
    let y_low = least(|p| p.flop_s).min(x_low * roof.dram_bytes_s).max(peak * 1e-6) * 1e-9 / 1.5;
    let x = Scale::logarithmic(x_low, x_high, panel.horizontal());
    let y = Scale::logarithmic(y_low, peak * 1.3e-9, panel.vertical());
    panel.vertical_axis(canvas, &y, "attained GFLOP/s (logarithmic)")?;
    for tick in x.ticks(8) {
        canvas.line(&[(x.at(tick), panel.top), (x.at(tick), panel.bottom)], GRID, 1)?;
    }
    let name = "FLOP per byte read from or written to DRAM (logarithmic)";
    panel.horizontal_axis(canvas, &x, &x.ticks(8), name)?;
    ceilings(canvas, roof, (&x, &y), panel, ridge)?;
    for point in points {
        let at = (x.at(point.flop_per_byte), y.at(point.flop_s * 1e-9));
        let allowed = (point.flop_per_byte * roof.dram_bytes_s).min(peak);
        let top = y.at(allowed * 1e-9);
        canvas.line(&[at, (at.0, top)], colour(point), 1)?;
        canvas.dot(at, 8, colour(point))?;
        let share = crate::format::percent(point.flop_s / allowed);
        let text = format!("{}: {share} % of its roof", point.name());
        // The frame is near its largest stage: its name goes to the other side.
        let room = text_width(&text) + 30.0;
        let left = if point.stage.is_none() {
            at.0 - room > panel.left
        } else {
            at.0 + room > panel.right
        };
        let (dx, align) = if left { (-16.0, Align::Right) } else { (16.0, Align::Left) };
        let dy = if point.stage.is_none() { 22.0 } else { 2.0 };
        label(canvas, &text, (at.0 + dx, at.1 + dy), align, colour(point))?;
    }
    Ok(())
}

/// Text on white, so that no line strikes it through.
fn label(canvas: &Canvas, text: &str, at: (f64, f64), align: Align, colour: RGBColor) -> Drawn {
    let width = text_width(text) + 8.0;
    let left = if align == Align::Right { at.0 - width + 4.0 } else { at.0 - 4.0 };
    let white = RGBColor(255, 255, 255);
    canvas.fill((left, at.1 - 11.0), (left + width, at.1 + 11.0), white)?;
    canvas.text(text, at, align, colour)
}

/// The slope of the DRAM, the roof of all units, and the ceiling of each.
fn ceilings(
    canvas: &Canvas,
    roof: &Roofline,
    (x, y): (&Scale, &Scale),
    panel: Panel,
    ridge: f64,
) -> Drawn {
    let peak = roof.peak_flop_s();
    // Where the slope enters the panel: at its left or at its bottom.
    let enter = x.low().max(y.low() * 1e9 / roof.dram_bytes_s);
    let start = (x.at(enter), y.at(enter * roof.dram_bytes_s * 1e-9));
    let corner = (x.at(ridge), y.at(peak * 1e-9));
    canvas.line(&[start, corner, (panel.right, corner.1)], palette::BLUE, 3)?;
    let text = format!("all units: {}", engineering(peak, "FLOP/s"));
    canvas.text(&text, (panel.right - 8.0, corner.1 - 15.0), Align::Right, palette::BLUE)?;
    let slope = format!("DRAM: {}", rate(roof));
    // High on the slope: labels of stages lie below it.
    let along = |a: f64, b: f64| a + 0.82 * (b - a);
    let at = (along(start.0, corner.0) - 14.0, along(start.1, corner.1) - 14.0);
    label(canvas, &slope, at, Align::Right, palette::BLUE)?;
    let highest = roof.ceilings.iter().map(|c| c.1).fold(0.0, f64::max);
    for (name, ceiling) in &roof.ceilings {
        let height = y.at(ceiling * 1e-9);
        let from = x.at(ceiling / roof.dram_bytes_s);
        canvas.line(&[(from, height), (panel.right, height)], GREY, 1)?;
        let text = format!("{name}: {}", engineering(*ceiling, "FLOP/s"));
        let dy = if *ceiling == highest { -13.0 } else { 14.0 };
        label(canvas, &text, (panel.right - 8.0, height + dy), Align::Right, GREY)?;
    }
    Ok(())
}
