//! Display, rendering and total power over the pruning ratio: samples, fits, optimum.

use plotters::style::RGBColor;

use super::ReportError;
use super::format::{engineering, shortened, watt_unit};
use super::plot::{Align, Canvas, Drawing, Drawn, INK, Page, Panel, Scale, palette, text_width};
use powergs_optimize::fit::{Fit, Sample, optimum};

const DISPLAY: RGBColor = palette::SKY;
const RENDER: RGBColor = palette::ORANGE;
const TOTAL: RGBColor = INK;

/// Points of a drawn curve.
const STEPS: u32 = 200;

/// The chart of a fit; `name` is what was sampled.
pub fn chart(fit: &Fit, name: &str) -> Result<Drawing, ReportError> {
    let or_none = |v: Option<f64>| v.map_or("none".into(), |v| format!("{v:.3}"));
    let subtitle = format!(
        "{}, {} samples of equal quality. R² {} and {}, mean relative error {} and {} \
         (display, rendering)",
        shortened(name, 32),
        fit.samples.len(),
        or_none(fit.display.r2),
        or_none(fit.render.r2),
        or_none(fit.display.mre),
        or_none(fit.render.mre),
    );
    let title = "Power over the pruning ratio".to_owned();
    let page = Page { name: "fit", title, subtitle, underlay: None };
    page.draw(|canvas| draw(canvas, fit))
}

type Of<T> = fn(&T, f64) -> f64;
/// A curve, what the samples have of it, and its colour.
type Series = (Of<Fit>, fn(&Sample) -> f64, RGBColor);

fn draw(canvas: &Canvas, fit: &Fit) -> Drawn {
    let panel = Panel { left: 130.0, top: 150.0, right: 1240.0, bottom: 630.0 };
    let (x, y, per_watt, unit) = scales(fit, panel);
    panel.vertical_axis(canvas, &y, &format!("power, {unit}"))?;
    let ticks: Vec<f64> = x.ticks(10).into_iter().filter(|t| *t >= -1e-9).collect();
    panel.horizontal_axis(canvas, &x, &ticks, "pruned share of Gaussians, ρ")?;
    legend(canvas, (panel.left, 118.0), panel.right)?;
    let height = |watts: f64| y.at(per_watt * watts);
    mark(canvas, fit, panel, (&x, &height))?;
    curves(canvas, fit, (&x, &height))
}

/// What the colours are, from `(left, y)` on; the note ends at `right`.
pub(super) fn legend(canvas: &Canvas, (left, y): (f64, f64), right: f64) -> Drawn {
    let entries = [("display", DISPLAY), ("rendering", RENDER), ("total", TOTAL)];
    super::plot::legend(canvas, left, y, &entries)?;
    let note = "dots: samples, lines: fits";
    canvas.text(note, (right, y), Align::Right, super::plot::GREY)
}

/// The fit in a low panel, with a heading.
pub(super) fn small(canvas: &Canvas, fit: &Fit, panel: Panel, heading: &str) -> Drawn {
    let (x, y, per_watt, unit) = scales(fit, panel);
    let best = optimum(fit);
    panel.vertical_ticks(canvas, &y, 4, &unit)?;
    let ticks: Vec<f64> = x.ticks(6).into_iter().filter(|t| *t >= -1e-9).collect();
    panel.horizontal_axis(canvas, &x, &ticks, "")?;
    let trust = if best.is_trusted() { "" } else { ", not trusted" };
    let text = format!("optimum ρ = {:.3} ({}{trust})", best.rho, words(fit));
    let above = panel.top - 16.0;
    canvas.bold(heading, (panel.left, above), Align::Left, INK)?;
    canvas.text(&text, (panel.right, above), Align::Right, palette::VERMILION)?;
    let height = |watts: f64| y.at(per_watt * watts);
    let at = x.at(best.rho);
    canvas.line(&[(at, panel.bottom), (at, height(best.total_w()))], palette::VERMILION, 2)?;
    curves(canvas, fit, (&x, &height))
}

/// Curves, samples and the optimum.
fn curves(canvas: &Canvas, fit: &Fit, (x, height): (&Scale, &dyn Fn(f64) -> f64)) -> Drawn {
    let (low, high) = (fit.rho_min(), fit.rho_max());
    let series: [Series; 3] = [
        (Fit::display_w, |s| s.display_w, DISPLAY),
        (Fit::render_w, |s| s.render_w, RENDER),
        (Fit::total_w, Sample::total_w, TOTAL),
    ];
    for (curve, of, colour) in series {
        let points: Vec<(f64, f64)> = (0..=STEPS)
            .map(|i| low + (high - low) * f64::from(i) / f64::from(STEPS))
            .map(|rho| (x.at(rho), height(curve(fit, rho))))
            .collect();
        canvas.line(&points, colour, 3)?;
        for sample in &fit.samples {
            canvas.dot((x.at(sample.rho), height(of(sample))), 7, colour)?;
        }
    }
    let best = optimum(fit);
    canvas.dot((x.at(best.rho), height(best.total_w())), 10, palette::VERMILION)
}

/// Scales of a panel, and the unit of its powers.
fn scales(fit: &Fit, panel: Panel) -> (Scale, Scale, f64, String) {
    let (low, high) = (fit.rho_min(), fit.rho_max());
    let most = fit.samples.iter().map(Sample::total_w).fold(fit.total_w(low), f64::max);
    let room = 0.03 * (high - low);
    let x = Scale::exact(low - room, high + room, panel.horizontal());
    let most = most.max(fit.total_w(high));
    let (per_watt, unit) = watt_unit(most);
    (x, Scale::from_zero(per_watt * most, panel.vertical()), per_watt, unit)
}

/// The line of the optimum and its numbers, above everything that is drawn below them.
fn mark(
    canvas: &Canvas,
    fit: &Fit,
    panel: Panel,
    (x, height): (&Scale, &dyn Fn(f64) -> f64),
) -> Drawn {
    let best = optimum(fit);
    let at = x.at(best.rho);
    canvas.line(&[(at, panel.bottom), (at, height(best.total_w()))], palette::VERMILION, 2)?;
    let trust = if best.is_trusted() { "" } else { ", not trusted" };
    let watts = engineering(best.total_w(), "W");
    let text = format!("optimum: ρ = {:.3}, {watts} ({}{trust})", best.rho, words(fit));
    let half = text_width(&text) / 2.0;
    let middle = at.clamp(panel.left + half + 8.0, panel.right - half);
    let is_under = |rho: &f64| (x.at(*rho) - middle).abs() < half + 16.0;
    let step = (fit.rho_max() - fit.rho_min()) / f64::from(STEPS);
    let places = (0..=STEPS).map(|i| fit.rho_min() + step * f64::from(i));
    let curve = places.filter(is_under).map(|rho| height(fit.total_w(rho)));
    let dots = fit.samples.iter().filter(|s| is_under(&s.rho)).map(|s| height(s.total_w()));
    let top = curve.chain(dots).fold(height(best.total_w()), f64::min);
    let above = (top - 28.0).max(panel.top + 12.0);
    canvas.text(&text, (middle, above), Align::Centre, palette::VERMILION)
}

fn words(fit: &Fit) -> String {
    optimum(fit).place.name().replace('_', " ")
}
