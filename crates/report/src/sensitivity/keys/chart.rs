//! A tornado for each measure: elasticities at the left, and at the right what half and double of a
//! key, or another name, do.

use plotters::style::RGBColor;

use crate::ReportError;
use crate::charts::Chart;
use crate::format::{rate, shortened, significant};
use crate::plot::{
    Align, Canvas, Drawn, GREY, GRID, INK, Page, Panel, Scale, fitted, legend, palette,
};
use powergs_study::findings::sensitivity::keys::{KeyRow, Keys, Reach};
use powergs_study::findings::sensitivity::{Measure, Outcome};

/// The measures that have a chart, with its file name and title.
const CHARTS: [(Measure, &str, &str); 3] = [
    (Measure::Fps, "tornado_fps", "What every key moves: frames per second"),
    (Measure::Energy, "tornado_energy", "What every key moves: energy per frame"),
    (Measure::Area, "tornado_area", "What every key moves: area"),
];
/// Bars that a slide has room for.
const MOST: usize = 18;
/// Elasticity; half, double or another name.
const COLOURS: [RGBColor; 3] = [palette::GREEN, palette::BLUE, palette::ORANGE];
/// A scale ends here at the latest, percent.
const WIDEST: f64 = 150.0;

/// One bar of the chart.
struct Bar {
    label: String,
    elasticity: Option<f64>,
    /// Percent, down and up.
    change: [Option<f64>; 2],
    effect: f64,
}

/// The charts; without one for a measure that nothing moves.
///
/// # Errors
/// [`ReportError::Chart`], which would be a mistake of ours.
pub fn charts(all: &Keys) -> Result<Vec<Chart>, ReportError> {
    let mut charts = Vec::new();
    for (measure, name, title) in CHARTS {
        let mut bars: Vec<Bar> = all.rows.iter().filter_map(|row| bar(row, measure)).collect();
        bars.sort_by(|a, b| b.effect.total_cmp(&a.effect));
        bars.truncate(MOST);
        if !bars.is_empty() {
            charts.push(chart(all, measure, name, title, &bars)?);
        }
    }
    Ok(charts)
}

/// The bar of a key; of names the one that moves most. `None` if nothing is to be seen.
fn bar(row: &KeyRow, measure: Measure) -> Option<Bar> {
    let elasticity = row.elasticity(measure).map(|e| e.value);
    let percent = |change: Option<f64>| change.map(|c| c * 100.0);
    let (label, change) = if row.is_number() {
        (row.key.clone(), row.far(measure).map(percent))
    } else {
        let base = Outcome::mean(&row.base);
        let names = row.reached(Reach::Name);
        let changes = names.filter_map(|(t, o)| Some((t, measure.change(&o, &base)?)));
        let (turned, change) = changes.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        (format!("{}={}", row.key, turned.value), [None, percent(Some(change))])
    };
    let effect = change.into_iter().flatten().map(f64::abs).fold(0.0, f64::max);
    (effect >= 0.05).then_some(Bar { label, elasticity, change, effect })
}

fn chart(
    all: &Keys,
    measure: Measure,
    name: &'static str,
    title: &'static str,
    bars: &[Bar],
) -> Result<Chart, ReportError> {
    let page = Page { name, title: title.into(), subtitle: subtitle(all), underlay: None };
    let left = Panel { left: 400.0, top: 150.0, right: 760.0, bottom: 640.0 };
    let right = Panel { left: 830.0, right: 1240.0, ..left };
    let what = measure.title();
    let drawing = page.draw(|canvas| {
        let names = ["elasticity", "key at half", "key doubled, or another name"];
        let entries: Vec<(&str, RGBColor)> = names.into_iter().zip(COLOURS).collect();
        legend(canvas, 40.0, 110.0, &entries)?;
        for (i, bar) in bars.iter().enumerate() {
            let label = fitted(&bar.label, left.left - 60.0);
            let (middle, _) = place(left, bars.len(), i);
            canvas.text(&label, (left.left - 12.0, middle), Align::Right, INK)?;
        }
        let elasticities: Vec<[Option<f64>; 2]> =
            bars.iter().map(|b| [b.elasticity, None]).collect();
        let axis = format!("elasticity of {what}");
        draw(canvas, left, &elasticities, &axis, [COLOURS[0]; 2], 0.1)?;
        let changes: Vec<[Option<f64>; 2]> = bars.iter().map(|b| b.change).collect();
        let axis = format!("change of {what}, %");
        draw(canvas, right, &changes, &axis, [COLOURS[1], COLOURS[2]], 1.0)
    })?;
    Ok(Chart { name, title, drawing })
}

fn subtitle(all: &Keys) -> String {
    let note = all.incomplete_note().map_or(String::new(), |note| format!("{note}. "));
    let names: Vec<&str> = all.traces.iter().map(|t| t.name.as_str()).collect();
    let outcomes: Vec<Outcome> = all.traces.iter().map(|t| t.base).collect();
    let base = Outcome::mean(&outcomes);
    let area = base.area_mm2.map_or(String::new(), |a| format!(", {} mm²", significant(a)));
    format!(
        "{note}{} on {}: {} FPS, {} mJ a frame, {} mW at {} FPS{area}",
        shortened(&names.join(", "), 34),
        shortened(&all.machine, 20),
        significant(base.fps()),
        significant(base.energy_mj()),
        significant(base.power_w * 1e3),
        rate(all.display_fps),
    )
}

/// Middle and half height of bar `i` of `n`.
fn place(panel: Panel, n: usize, i: usize) -> (f64, f64) {
    let slot = (panel.bottom - panel.top) / n.max(1) as f64;
    (panel.top + (i as f64 + 0.5) * slot, (0.36 * slot).min(14.0))
}

/// Bars to both sides of zero; the scale reaches at least to `least`.
fn draw(
    canvas: &Canvas,
    panel: Panel,
    rows: &[[Option<f64>; 2]],
    name: &str,
    colours: [RGBColor; 2],
    least: f64,
) -> Drawn {
    let largest = rows.iter().flatten().flatten().map(|x| x.abs()).fold(least, f64::max);
    let half = Scale::from_zero(largest.min(WIDEST), (0.0, 1.0)).high();
    let scale = Scale::exact(-half, half, panel.horizontal());
    for tick in scale.ticks(6) {
        let x = scale.at(tick);
        canvas.line(&[(x, panel.top), (x, panel.bottom)], GRID, 1)?;
    }
    panel.horizontal_axis(canvas, &scale, &scale.ticks(6), name)?;
    let zero = scale.at(0.0);
    for (i, values) in rows.iter().enumerate() {
        let (middle, height) = place(panel, rows.len(), i);
        let seen = |x: f64| (scale.at(x) - zero).abs() >= 0.5;
        let same = matches!(*values, [Some(a), Some(b)] if a * b > 0.0 && seen(a) && seen(b));
        for (k, value) in values.iter().enumerate() {
            let Some(value) = *value else { continue };
            // Two bars to one side lie above each other.
            let (top, bottom) = match (same, k) {
                (true, 0) => (middle - height, middle),
                (true, _) => (middle, middle + height),
                (false, _) => (middle - height, middle + height),
            };
            let x = scale.at(value);
            if (x - zero).abs() >= 0.5 {
                canvas.fill((zero.min(x), top), (zero.max(x), bottom), colours[k])?;
            }
            if value.abs() > half {
                let (align, at) = match value > 0.0 {
                    true => (Align::Right, x - 6.0),
                    false => (Align::Left, x + 6.0),
                };
                let text = format!("{value:+.0}");
                canvas.text(&text, (at, (top + bottom) / 2.0), align, INK)?;
            }
        }
    }
    canvas.line(&[(zero, panel.top), (zero, panel.bottom)], GREY, 1)
}
