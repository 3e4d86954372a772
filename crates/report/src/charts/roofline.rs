//! Operations per DRAM byte against operations per second, each stage under the roof of its units.

use super::{frames, subtitle};
use crate::format::engineering;
use powergs_chart::{Axis, Chart, Colour, Line, Panel, Points, Scale, Side, Size, Weight, Words};
use powergs_energy::action::Phase;
use powergs_study::findings::roofline::{Point, Roof, Roofline};
use powergs_study::run_record::Run;

const NAME: &str = "roofline";
const TITLE: &str = "Roofline";

pub(super) fn chart(run: &Run) -> Option<Chart> {
    let roof = run.facts.machine.roofline.as_ref()?;
    let points = roof.points(run);
    if points.is_empty() {
        return None;
    }
    let what = format!("{}, DRAM at {}", frames(run), rate(roof));
    let chart = Chart::new(NAME, TITLE, subtitle(run, &what)).panel(panel(roof, &points));
    Some(chart.note("Thin upright lines: from a stage up to its roof."))
}

fn rate(roof: &Roofline) -> String {
    engineering(roof.dram_bytes_s, "B/s")
}

fn colour(stage: Option<Phase>) -> Colour {
    match stage {
        Some(Phase::Preprocessing) => Colour::GREEN,
        Some(Phase::Sorting) => Colour::ORANGE,
        Some(Phase::Rendering) => Colour::VERMILION,
        Some(Phase::Standby) => Colour::GREY,
        None => Colour::INK,
    }
}

fn panel(roof: &Roofline, points: &[Point]) -> Panel {
    let peak = roof.units.iter().map(|u| u.1).fold(0.0, f64::max);
    let lowest = roof.units.iter().map(|u| u.1).fold(f64::INFINITY, f64::min);
    let ridge = peak / roof.dram_bytes_s;
    let most = |of: fn(&Point) -> f64| points.iter().map(of).fold(0.0, f64::max);
    let least = |of: fn(&Point) -> f64| points.iter().map(of).fold(f64::INFINITY, f64::min);
    let x_low = least(|p| p.flop_per_byte).min(lowest / roof.dram_bytes_s) / 4.0;
    let x_high = most(|p| p.flop_per_byte).max(ridge) * 4.0;
    let y_low = least(|p| p.flop_s).min(x_low * roof.dram_bytes_s).max(peak * 1e-6) * 1e-9 / 1.5;
    let x = Scale::logarithmic(x_low, x_high);
    let y = Scale::logarithmic(y_low, peak * 1.6e-9);
    let mut panel = roofs(roof, &x, &y, ridge);
    let title = "operations per byte read from or written to DRAM";
    panel.x = Axis::new(title, x).ticks(8);
    panel.y = Axis::new("attained G operations/s", y);
    for point in points {
        let colour = colour(point.stage);
        let at = (point.flop_per_byte, point.flop_s * 1e-9);
        let drop = vec![at, (at.0, point.roof_flop_s * 1e-9)];
        let share = crate::format::percent(point.attained());
        let of = match (point.roof, stage_index(point.stage)) {
            (Roof::Dram, _) => "DRAM roof",
            (Roof::Units, Some(i)) => roof.units[i].0.as_str(),
            (Roof::Units, None) => "units' roof",
        };
        let of = if of.contains("roof") { of.to_owned() } else { format!("{of} roof") };
        let text = format!("{}: {share} % of the {of}", point.name());
        panel = panel
            .line(Line { weight: Weight::Hair, ..Line::curve(drop, colour) })
            .points(Points::dots([at], colour, Size::Large))
            .label(Words::new(text, colour), at, Side::Free);
    }
    panel
}

/// The place of a stage that works.
fn stage_index(stage: Option<Phase>) -> Option<usize> {
    Phase::WORK.into_iter().position(|s| Some(s) == stage)
}

/// The slope of the DRAM, and the roof of the units of each stage.
fn roofs(roof: &Roofline, x: &Scale, y: &Scale, ridge: f64) -> Panel {
    let peak = ridge * roof.dram_bytes_s;
    let end = x.high();
    // Where the slope enters the panel: at its left or at its bottom.
    let enter = x.low().max(y.low() * 1e9 / roof.dram_bytes_s);
    let slope = |x: f64| (x, x * roof.dram_bytes_s * 1e-9);
    // High on the slope: labels of stages lie below it.
    let high = (enter.ln() + 0.82 * (ridge.ln() - enter.ln())).exp();
    let dram = Words::new(format!("DRAM: {}", rate(roof)), Colour::BLUE);
    let mut panel = Panel::new(Axis::names([""]), Axis::names([""]))
        .line(Line::curve(vec![slope(enter), (ridge, peak * 1e-9)], Colour::BLUE))
        .label(dram, slope(high), Side::AboveLeft);
    for ((name, ceiling), stage) in roof.units.iter().zip(Phase::WORK) {
        let (height, colour) = (ceiling * 1e-9, colour(Some(stage)));
        let line = vec![(ceiling / roof.dram_bytes_s, height), (end, height)];
        let text = format!("{name}: {}", engineering(*ceiling, "op/s"));
        // Below its roof where the next one is close above: a name between two roofs is of neither.
        let is_close = |other: &f64| *other > *ceiling && *other < 2.0 * ceiling;
        let side = match roof.units.iter().any(|(_, other)| is_close(other)) {
            true => Side::BelowLeft,
            false => Side::AboveLeft,
        };
        panel = panel.line(Line::curve(line, colour)).label(
            Words::new(text, colour),
            (end, height),
            side,
        );
    }
    panel
}
