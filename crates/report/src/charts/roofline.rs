//! Operations per DRAM byte against operations per second, under the roof of the machine.

use super::{frames, subtitle};
use crate::format::engineering;
use powergs_chart::{Axis, Chart, Colour, Line, Panel, Points, Scale, Side, Size, Weight, Words};
use powergs_core::action::Stage;
use powergs_study::findings::roofline::{Point, Roofline};
use powergs_study::run_record::Run;

const NAME: &str = "roofline";
const TITLE: &str = "Roofline";

pub(super) fn chart(run: &Run) -> Option<Chart> {
    let roof = run.facts.machine.roofline.as_ref()?;
    let points = roof.points(run);
    if points.is_empty() || roof.peak_flop_s() <= 0.0 {
        return None;
    }
    let peak = engineering(roof.peak_flop_s(), "FLOP/s");
    let what = format!("{}, peak {peak} and {}", frames(run), rate(roof));
    Some(Chart::new(NAME, TITLE, subtitle(run, &what)).panel(panel(roof, &points)))
}

fn rate(roof: &Roofline) -> String {
    engineering(roof.dram_bytes_s, "B/s")
}

fn colour(point: &Point) -> Colour {
    match point.stage {
        Some(Stage::Preprocessing) => Colour::GREEN,
        Some(Stage::Sorting) => Colour::ORANGE,
        Some(Stage::Rendering) => Colour::VERMILION,
        Some(Stage::Standby) => Colour::GREY,
        None => Colour::INK,
    }
}

fn panel(roof: &Roofline, points: &[Point]) -> Panel {
    let peak = roof.peak_flop_s();
    let ridge = peak / roof.dram_bytes_s;
    let most = |of: fn(&Point) -> f64| points.iter().map(of).fold(0.0, f64::max);
    let least = |of: fn(&Point) -> f64| points.iter().map(of).fold(f64::INFINITY, f64::min);
    let x_low = least(|p| p.flop_per_byte).min(ridge) / 4.0;
    let x_high = most(|p| p.flop_per_byte).max(ridge) * 4.0;
    let y_low = least(|p| p.flop_s).min(x_low * roof.dram_bytes_s).max(peak * 1e-6) * 1e-9 / 1.5;
    let x = Scale::logarithmic(x_low, x_high);
    let y = Scale::logarithmic(y_low, peak * 1.3e-9);
    let mut panel = ceilings(roof, &x, &y, ridge);
    let title = "FLOP per byte read from or written to DRAM (logarithmic)";
    panel.x = Axis::new(title, x).ticks(8);
    panel.y = Axis::new("attained GFLOP/s (logarithmic)", y);
    for point in points {
        let at = (point.flop_per_byte, point.flop_s * 1e-9);
        let allowed = (point.flop_per_byte * roof.dram_bytes_s).min(peak);
        let drop = vec![at, (at.0, allowed * 1e-9)];
        let share = crate::format::percent(point.flop_s / allowed);
        let text = format!("{}: {share} % of its roof", point.name());
        panel = panel
            .line(Line { weight: Weight::Hair, ..Line::curve(drop, colour(point)) })
            .points(Points::dots([at], colour(point), Size::Large))
            .label(Words::new(text, colour(point)), at, Side::Free);
    }
    panel
}

/// The slope of the DRAM, the roof of all units, and the ceiling of each.
fn ceilings(roof: &Roofline, x: &Scale, y: &Scale, ridge: f64) -> Panel {
    let peak = roof.peak_flop_s();
    let end = x.high();
    // Where the slope enters the panel: at its left or at its bottom.
    let enter = x.low().max(y.low() * 1e9 / roof.dram_bytes_s);
    let slope = |x: f64| (x, x * roof.dram_bytes_s * 1e-9);
    let corner = (ridge, peak * 1e-9);
    let all = format!("all units: {}", engineering(peak, "FLOP/s"));
    // High on the slope: labels of stages lie below it.
    let high = (enter.ln() + 0.82 * (ridge.ln() - enter.ln())).exp();
    let dram = Words::new(format!("DRAM: {}", rate(roof)), Colour::BLUE);
    let mut panel = Panel::new(Axis::names([""]), Axis::names([""]))
        .line(Line::curve(vec![slope(enter), corner, (end, corner.1)], Colour::BLUE))
        .label(Words::new(all, Colour::BLUE), (end, corner.1), Side::AboveLeft)
        .label(dram, slope(high), Side::AboveLeft);
    let highest = roof.ceilings.iter().map(|c| c.1).fold(0.0, f64::max);
    for (name, ceiling) in &roof.ceilings {
        let height = ceiling * 1e-9;
        let line = vec![(ceiling / roof.dram_bytes_s, height), (end, height)];
        let text = format!("{name}: {}", engineering(*ceiling, "FLOP/s"));
        let side = if *ceiling == highest { Side::AboveLeft } else { Side::BelowLeft };
        panel = panel.line(Line { weight: Weight::Hair, ..Line::curve(line, Colour::NOTE) }).label(
            Words::note(text),
            (end, height),
            side,
        );
    }
    panel
}
