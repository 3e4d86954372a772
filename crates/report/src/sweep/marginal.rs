//! What the next square millimetre and the next milliwatt buy, step by step along the front.

use plotters::style::RGBColor;

use super::axis::Axis;
use super::measure::Measure;
use crate::ReportError;
use crate::charts::Chart;
use crate::plot::{
    Align, Canvas, Drawn, GREY, INK, Page, Panel, Scale, fitted, palette, text_width,
};
use powergs_study::analysis::marginal::{Marginal, Step};
use powergs_study::analysis::{Analysis, Goal};

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
    let name = name.replacen(" (log)", "", 1);
    let labels = if panel.bottom - panel.top < 250.0 { 3 } else { 6 };
    panel.vertical_ticks(canvas, &y.scale, labels, &format!("{name} per {unit}"))?;
    let words = Measure::of(marginal.price.column()).words;
    panel.horizontal_axis(canvas, &x, &x.ticks(6), &format!("{words}, {unit}"))?;
    for step in &marginal.steps {
        let (x0, x1) = (x.at(price(step.from)), x.at(price(step.to)));
        let top = y.at(step.value());
        canvas.fill((x0, top), (x1, panel.bottom), palette::SKY)?;
        canvas.line(&[(x0, panel.bottom), (x0, top), (x1, top), (x1, panel.bottom)], INK, 1)?;
    }
    let knee = price(analysis.knee);
    if knee >= x.low() && knee <= x.high() {
        dashed(canvas, panel, x.at(knee))?;
    }
    let bar = |step: &Step| Bar {
        text: format!("{} → {}", table.label(step.from), table.label(step.to)),
        left: x.at(price(step.from)),
        right: x.at(price(step.to)),
        top: y.at(step.value()),
    };
    let bars: Vec<Bar> = marginal.steps.iter().map(bar).collect();
    names(canvas, panel, &bars)
}

fn dashed(canvas: &Canvas, panel: Panel, x: f64) -> Drawn {
    let mut y = panel.top;
    while y < panel.bottom {
        canvas.line(&[(x, y), (x, (y + 7.0).min(panel.bottom))], palette::VERMILION, 2)?;
        y += 13.0;
    }
    Ok(())
}

/// A step as it is drawn.
struct Bar {
    text: String,
    left: f64,
    right: f64,
    top: f64,
}

/// Names above wide bars, and right of narrow ones where the next bar leaves room; others have
/// none.
fn names(canvas: &Canvas, panel: Panel, bars: &[Bar]) -> Drawn {
    let mut lowest = f64::NEG_INFINITY;
    for (i, bar) in bars.iter().enumerate() {
        let width = text_width(&bar.text);
        let next = bars.get(i + 1).map_or(panel.bottom, |b| b.top);
        let wide = bar.right - bar.left > width + 8.0 && bar.top - 22.0 > lowest;
        let beside = bar.right + 8.0 + width < panel.right
            && bar.top + 11.0 < next
            && bar.top - 11.0 > lowest;
        let (left, middle) = if wide {
            ((bar.left + bar.right - width) / 2.0, bar.top - 12.0)
        } else if beside {
            (bar.right + 8.0, bar.top)
        } else {
            continue;
        };
        canvas.fill((left - 2.0, middle - 9.0), (left + width + 2.0, middle + 9.0), PAPER)?;
        canvas.text(&bar.text, (left, middle), Align::Left, GREY)?;
        lowest = middle + 10.0;
    }
    Ok(())
}

/// The page, behind names.
const PAPER: RGBColor = RGBColor(255, 255, 255);
