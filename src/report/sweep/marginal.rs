//! What the next square millimetre and the next milliwatt buy, step by step along the front.

use super::axis::Axis;
use super::labels::{self, Label};
use super::measure::Measure;
use crate::analysis::marginal::Marginal;
use crate::analysis::{Analysis, Goal};
use crate::report::ReportError;
use crate::report::charts::Chart;
use crate::report::plot::{Align, Canvas, Drawn, GREY, INK, Page, Panel, Scale, fitted, palette};

const NAME: &str = "marginal";
const TITLE: &str = "What the next mm² and the next mW buy";
/// Panels on a page.
const MOST: usize = 4;

/// The chart; `None` where the front has no two designs to step between.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
pub fn chart(analysis: &Analysis) -> Result<Option<Chart>, ReportError> {
    if analysis.marginals.is_empty() {
        return Ok(None);
    }
    let shown = &analysis.marginals[..analysis.marginals.len().min(MOST)];
    let subtitle = "each step goes to the design that gains most per unit; \
                    dashed: the knee"
        .to_owned();
    let page = Page { name: NAME, title: TITLE.into(), subtitle, underlay: None };
    let drawing = page.draw(|canvas| {
        for (i, marginal) in shown.iter().enumerate() {
            panel(canvas, analysis, marginal, place(i, shown.len()))?;
        }
        Ok(())
    })?;
    Ok(Some(Chart { name: NAME, title: TITLE, drawing }))
}

/// The panel `i` of `n`.
fn place(i: usize, n: usize) -> Panel {
    let wide = n == 1;
    let high = n <= 2;
    let left = if i.is_multiple_of(2) { 120.0 } else { 760.0 };
    let right = if wide { 1240.0 } else { left + 480.0 };
    let top = if i < 2 { 145.0 } else { 455.0 };
    Panel { left, top, right, bottom: if high { 630.0 } else { top + 175.0 } }
}

fn panel(canvas: &Canvas, analysis: &Analysis, marginal: &Marginal, panel: Panel) -> Drawn {
    let table = analysis.table;
    let price = |row: u32| marginal.price.of(table, row).unwrap_or(f64::NAN);
    let (first, last) = (&marginal.steps[0], &marginal.steps[marginal.steps.len() - 1]);
    let (low, high) = (price(first.from), price(last.to));
    let pad = 0.04 * (high - low);
    let x = Scale::exact((low - pad).max(0.0), high + pad, panel.horizontal());
    let values = || marginal.steps.iter().map(|s| s.value());
    let measure = Measure::of(&marginal.objective.name);
    let y = Axis::of(&marginal.objective.name, values(), panel.vertical());
    let verb = match marginal.objective.goal {
        Goal::Maximize => "gained",
        Goal::Minimize => "saved",
    };
    let unit = marginal.price.unit();
    let title = format!("{} {verb} per {unit}", measure.words);
    let title = fitted(&title, panel.right - panel.left);
    canvas.bold(&title, (panel.left, panel.top - 24.0), Align::Left, INK)?;
    let (_, name) = y.name.split_once(", ").unwrap_or(("", "per unit"));
    let name = name.replacen(" (logarithmic)", "", 1);
    panel.vertical_axis(canvas, &y.scale, &format!("{name} per {unit}"))?;
    let words = Measure::of(marginal.price.column()).words;
    panel.horizontal_axis(canvas, &x, &x.ticks(6), &format!("{words}, {unit}"))?;
    let mut ends = Vec::new();
    for step in &marginal.steps {
        let (x0, x1) = (x.at(price(step.from)), x.at(price(step.to)));
        let top = y.at(step.value());
        canvas.fill((x0, top), (x1, panel.bottom), palette::SKY)?;
        canvas.line(&[(x0, panel.bottom), (x0, top), (x1, top), (x1, panel.bottom)], INK, 1)?;
        let text = format!("{} → {}", table.label(step.from), table.label(step.to));
        ends.push(Label { text, at: ((x0 + x1) / 2.0, top) });
    }
    let knee = price(analysis.knee);
    if knee >= x.low() && knee <= x.high() {
        let at = x.at(knee);
        let mut y = panel.top;
        while y < panel.bottom {
            canvas.line(&[(at, y), (at, (y + 7.0).min(panel.bottom))], palette::VERMILION, 2)?;
            y += 13.0;
        }
    }
    let frame = [panel.left + 4.0, panel.top - 8.0, panel.right + 20.0, panel.bottom];
    let corners: Vec<(f64, f64)> = ends.iter().map(|l| l.at).collect();
    for label in labels::place(&ends, &corners, frame) {
        let (x, y) = label.start;
        if (x - label.at.0).abs() < 150.0 && (y - label.at.1).abs() < 30.0 {
            canvas.text(&label.text, (x, y), Align::Left, GREY)?;
        }
    }
    Ok(())
}
