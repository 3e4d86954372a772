//! Charts of a comparison: energy side by side, and where the cycles go on each side.

use plotters::style::RGBColor;

use crate::ReportError;
use crate::charts::{Chart, component_colour, part_colours};
use crate::format::{percent, significant};
use crate::plot::{
    Align, Canvas, Drawing, Drawn, GREY, GRID, INK, Page, Panel, Scale, fitted, legend, palette,
    text_width,
};
use powergs_core::action::{Stage, UnitKind};
use powergs_core::energy::Component;
use powergs_study::findings::compare::Comparison;
use powergs_study::findings::summary::UnitSummary;

/// Sides in one chart; a slide has no room for more.
const MOST: usize = 8;

/// All charts that the sides have data for.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
pub fn charts(comparison: &Comparison) -> Result<Vec<Chart>, ReportError> {
    let mut charts =
        vec![Chart { name: "energy", title: "Energy per frame", drawing: energy(comparison)? }];
    if comparison.sides.iter().take(MOST).all(|s| s.summary.cycle.is_some()) {
        let (name, title) = ("cycles", "Where the cycles go");
        charts.push(Chart { name, title, drawing: cycles(comparison)? });
    }
    Ok(charts)
}

fn page(comparison: &Comparison, name: &'static str, title: &str) -> Page {
    let shown = comparison.sides.len().min(MOST);
    let of = if shown < comparison.sides.len() {
        format!("the first {shown} of {} sides, ", comparison.sides.len())
    } else {
        String::new()
    };
    let side = &comparison.sides[0];
    let frames =
        if side.frames == 1 { "1 frame".into() } else { format!("mean of {} frames", side.frames) };
    let subtitle = format!("{of}{}, {}", side.trace, frames);
    Page { name, title: title.into(), subtitle, underlay: None }
}

/// A bar of parts with their colours.
type Bar = Vec<(f64, RGBColor)>;

fn energy(comparison: &Comparison) -> Result<Drawing, ReportError> {
    let sides = &comparison.sides[..comparison.sides.len().min(MOST)];
    let by_component: Vec<Bar> = sides
        .iter()
        .map(|s| {
            let part =
                |c: Component| (known(s.summary.energy.component(c)) * 1e-9, component_colour(c));
            Component::ALL.map(part).to_vec()
        })
        .collect();
    let by_stage: Vec<Bar> = sides
        .iter()
        .map(|s| {
            Stage::ALL.map(|t| (known(s.summary.energy.stage(t)) * 1e-9, stage_colour(t))).to_vec()
        })
        .collect();
    let left = Panel { left: 190.0, top: 200.0, right: 680.0, bottom: 640.0 };
    let right = Panel { left: 740.0, right: 1240.0, ..left };
    page(comparison, "energy", "Energy per frame").draw(|canvas| {
        let components: Vec<_> = Component::ALL.map(|c| (c.name(), component_colour(c))).to_vec();
        let stages: Vec<_> = Stage::ALL.map(|s| (s.name(), stage_colour(s))).to_vec();
        legend(canvas, 40.0, 110.0, &components)?;
        legend(canvas, 40.0, 140.0, &stages)?;
        canvas.bold("by component", (left.left, 180.0), Align::Left, INK)?;
        canvas.bold("by stage", (right.left, 180.0), Align::Left, INK)?;
        for (i, side) in sides.iter().enumerate() {
            let (middle, _) = row(left, sides.len(), i);
            let label = fitted(&side.label, left.left - 54.0);
            canvas.text(&label, (left.left - 14.0, middle), Align::Right, INK)?;
        }
        bars(canvas, left, &by_component)?;
        bars(canvas, right, &by_stage)
    })
}

/// What an older report does not say is not drawn.
fn known(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value }
}

fn stage_colour(stage: Stage) -> RGBColor {
    match stage {
        Stage::Preprocessing => palette::GREEN,
        Stage::Sorting => palette::INDIGO,
        Stage::Rendering => palette::VERMILION,
        Stage::Standby => palette::PALE,
    }
}

/// Middle and half height of row `i` of `rows`.
fn row(panel: Panel, rows: usize, i: usize) -> (f64, f64) {
    let slot = (panel.bottom - panel.top) / rows as f64;
    (panel.top + (i as f64 + 0.5) * slot, (0.33 * slot).min(40.0))
}

/// Stacked bars with their sums.
fn bars(canvas: &Canvas, panel: Panel, bars: &[Bar]) -> Drawn {
    let sums: Vec<f64> = bars.iter().map(|bar| bar.iter().map(|p| p.0).sum()).collect();
    let highest = sums.iter().copied().fold(0.0, f64::max);
    let scale = Scale::from_zero(highest, (panel.left, panel.right - 70.0));
    for tick in scale.ticks(5) {
        let x = scale.at(tick);
        canvas.line(&[(x, panel.top), (x, panel.bottom)], GRID, 1)?;
    }
    panel.horizontal_axis(canvas, &scale, &scale.ticks(5), "mJ per frame")?;
    for (i, (bar, sum)) in bars.iter().zip(&sums).enumerate() {
        let (middle, half) = row(panel, bars.len(), i);
        let mut before = 0.0;
        for (value, colour) in bar {
            let (x0, x1) = (scale.at(before).round(), scale.at(before + value).round());
            if x1 > x0 {
                canvas.fill((x0, middle - half), (x1, middle + half), *colour)?;
            }
            before += value;
        }
        let at = (scale.at(*sum) + 10.0, middle);
        canvas.text(&significant(*sum), at, Align::Left, INK)?;
    }
    Ok(())
}

fn cycles(comparison: &Comparison) -> Result<Drawing, ReportError> {
    let sides = &comparison.sides[..comparison.sides.len().min(MOST)];
    let panel = Panel { left: 290.0, top: 140.0, right: 1220.0, bottom: 640.0 };
    let units = UnitKind::ALL;
    page(comparison, "cycles", "Where the cycles go").draw(|canvas| {
        let names: Vec<_> =
            UnitSummary::PARTS.into_iter().zip(part_colours()).map(|(n, (c, _))| (n, c)).collect();
        legend(canvas, 40.0, 108.0, &names)?;
        let scale = Scale::exact(0.0, 100.0, panel.horizontal());
        let name = "share of the unit's cycles, %; between busy and idle: what it waits for";
        panel.horizontal_axis(canvas, &scale, &scale.ticks(10), name)?;
        let group = (panel.bottom - panel.top) / units.len() as f64;
        let slot = (group - 14.0) / sides.len() as f64;
        for (u, unit) in units.into_iter().enumerate() {
            let top = panel.top + u as f64 * group;
            canvas.bold(unit.name(), (40.0, top + (group - 14.0) / 2.0), Align::Left, INK)?;
            for (i, side) in sides.iter().enumerate() {
                let middle = top + (i as f64 + 0.5) * slot;
                let label = fitted(&side.label, panel.left - 120.0);
                canvas.text(&label, (panel.left - 12.0, middle), Align::Right, GREY)?;
                let Some(cycle) = &side.summary.cycle else { continue };
                let row = &cycle.units[unit as usize];
                shares(canvas, &scale, (middle, 0.42 * slot), &row.shares())?;
            }
        }
        Ok(())
    })
}

/// One bar of shares; those with room carry their percentage.
fn shares(canvas: &Canvas, scale: &Scale, (middle, half): (f64, f64), shares: &[f64]) -> Drawn {
    let mut before = 0.0;
    for (share, (fill, ink)) in shares.iter().zip(part_colours()) {
        let after = before + share * 100.0;
        let (x0, x1) = (scale.at(before).round(), scale.at(after).round());
        if x1 > x0 {
            canvas.fill((x0, middle - half), (x1, middle + half), fill)?;
            let text = percent(*share);
            if text_width(&text) + 10.0 < x1 - x0 && half > 9.0 {
                canvas.text(&text, ((x0 + x1) / 2.0, middle), Align::Centre, ink)?;
            }
        }
        before = after;
    }
    Ok(())
}
