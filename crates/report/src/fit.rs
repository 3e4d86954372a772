//! Display, rendering and total power over the pruning ratio: samples, fits, the minimum of the
//! fits, and the model that was made there.

use super::format::{engineering, shortened, watt_unit};
use powergs_chart::{
    Axis, Chart, Colour, Entry, Line, Panel, Place, Points, Scale, Side, Size, Symbol, Words,
};
use powergs_optimize::fit::{Fit, Sample, optimum};

const DISPLAY: Colour = Colour::SKY;
const RENDER: Colour = Colour::ORANGE;
const TOTAL: Colour = Colour::INK;
const OPTIMUM: Colour = Colour::VERMILION;
/// Inside of rings.
const HOLLOW: Colour = Colour(255, 255, 255);

/// Points of a drawn curve.
const STEPS: u32 = 200;

/// A model that was made where the fits have their minimum: it takes what it takes.
#[derive(Debug, Clone, Copy)]
pub(super) struct MadeOptimum {
    /// Its ratio.
    pub rho: f64,
    /// Its total power, watts.
    pub total_w: f64,
}

/// The chart of a fit; `name` is what was sampled.
pub fn chart(fit: &Fit, name: &str) -> Chart {
    chart_of(fit, name, &|_| true, None)
}

/// As [`chart`], with the samples whose ratio did not pass drawn as rings, and with what was made.
pub(super) fn chart_of(
    fit: &Fit,
    name: &str,
    passed: &dyn Fn(f64) -> bool,
    made: Option<MadeOptimum>,
) -> Chart {
    let missed = fit.samples.iter().filter(|s| !passed(s.rho)).count();
    let quality = match missed {
        0 => String::new(),
        n => format!(", {n} just below the target"),
    };
    let or_none = |v: Option<f64>| v.map_or("none".into(), |v| format!("{v:.3}"));
    let subtitle = format!(
        "{}: {} samples{quality}; R² {} and {}, relative errors {} and {} \
         (display, accelerator)",
        shortened(name, 60),
        fit.samples.len(),
        or_none(fit.display.r2),
        or_none(fit.render.r2),
        or_none(fit.display.mre),
        or_none(fit.render.mre),
    );
    let FitPanel { minimum, made: made_at, unit, panel } = panel(fit, passed, made);
    let x = ratios("pruned share of Gaussians, ρ", &panel.x.scale, 10);
    let y = Axis::new(format!("power, {unit}"), panel.y.scale.clone());
    let at = |rho: f64, watts: f64| format!("ρ = {rho:.3}, {}", engineering(watts, "W"));
    let best = optimum(fit);
    let fitted = format!("minimum of the fit: {} ({})", at(best.rho, best.total_w()), place(fit));
    let mut panel = Panel { x, y, ..panel };
    if let Some((made, place)) = made.zip(made_at) {
        let text = format!("optimum, made: {}", at(made.rho, made.total_w));
        panel = panel.label(Words::new(text, OPTIMUM), place, Side::Free);
    }
    Chart::new("fit", "Power over the pruning ratio", subtitle)
        .legend(entries().chain((missed > 0).then(missed_entry)))
        .panel(panel.label(Words::new(fitted, OPTIMUM), minimum, Side::Free))
}

/// What the colours are.
pub(super) fn entries() -> impl Iterator<Item = Entry> {
    let names = [("display", DISPLAY), ("accelerator", RENDER), ("total", TOTAL)];
    let entries = names.map(|(name, colour)| Entry::new(name, Symbol::Curve(colour)));
    entries.into_iter().chain([Entry::note("dots: samples, lines: fits")])
}

/// What a ring is.
fn missed_entry() -> Entry {
    Entry::new("ring: missed the target by less than 1 %", Symbol::Ring(TOTAL, HOLLOW))
}

/// The fit in a low panel, with a heading.
pub(super) fn small(fit: &Fit, heading: &str) -> Panel {
    let FitPanel { unit, panel, .. } = panel(fit, &|_| true, None);
    let x = ratios("", &panel.x.scale, 6);
    let y = Axis::new(unit, panel.y.scale.clone()).ticks(4);
    let text = format!("minimum of the fit: ρ = {:.3} ({})", optimum(fit).rho, place(fit));
    let remark = Some(Words::new(text, OPTIMUM));
    Panel { x, y, remark, ..panel.heading(Words::bold(heading)) }
}

/// An axis of ratios, with room before 0 but no label there.
fn ratios(title: &str, scale: &Scale, count: usize) -> Axis {
    let mut labels = Axis::new(title, scale.clone()).ticks(count).labels();
    labels.retain(|l| l.0 > -1e-9);
    Axis::new(title, scale.clone()).labelled(labels).plain()
}

/// Curves and samples.
struct FitPanel {
    /// Where the curves have their minimum.
    minimum: Place,
    /// Where the model is that was made for it.
    made: Option<Place>,
    /// The unit of the powers.
    unit: String,
    panel: Panel,
}

fn panel(fit: &Fit, passed: &dyn Fn(f64) -> bool, made: Option<MadeOptimum>) -> FitPanel {
    let (low, high) = (fit.rho_min(), fit.rho_max());
    let most = fit.samples.iter().map(Sample::total_w).fold(fit.total_w(low), f64::max);
    let most = most.max(fit.total_w(high)).max(made.map_or(0.0, |made| made.total_w));
    let (per_watt, unit) = watt_unit(most);
    let room = 0.03 * (high - low);
    // A sample that contradicts the fit moves what is made beyond it.
    let (left, right) = made.map_or((low, high), |made| (low.min(made.rho), high.max(made.rho)));
    let x = Axis::new("", Scale::linear(left - room, right + room));
    let y = Axis::new("", Scale::from_zero(per_watt * most));
    let best = optimum(fit);
    let minimum = (best.rho, per_watt * best.total_w());
    let made = made.map(|made| (made.rho, per_watt * made.total_w));
    let foot = made.unwrap_or(minimum);
    let upright = Line::thin(vec![(foot.0, 0.0), foot], OPTIMUM);
    let mut panel = Panel::new(x, y).line(upright);
    type OfCurve = fn(&Fit, f64) -> f64;
    type OfSample = fn(&Sample) -> f64;
    type Series = (OfCurve, OfSample, Colour);
    let series: [Series; 3] = [
        (Fit::display_w, |s| s.display_w, DISPLAY),
        (Fit::render_w, |s| s.render_w, RENDER),
        (Fit::total_w, Sample::total_w, TOTAL),
    ];
    for (curve, of, colour) in series {
        let rho = |i: u32| low + (high - low) * f64::from(i) / f64::from(STEPS);
        let curve = (0..=STEPS).map(|i| (rho(i), per_watt * curve(fit, rho(i)))).collect();
        let at = |s: &Sample| (s.rho, per_watt * of(s));
        let (met, missed): (Vec<&Sample>, Vec<&Sample>) =
            fit.samples.iter().partition(|s| passed(s.rho));
        let dots = Points::dots(met.into_iter().map(at), colour, Size::Large);
        let rings = Points::dots(missed.into_iter().map(at), HOLLOW, Size::Medium);
        panel = panel
            .line(Line::curve(curve, colour))
            .points(dots)
            .points(Points { ring: Some(colour), ..rings });
    }
    // No model has what the fit promises: it is hollow.
    let ring = Points::dots([minimum], HOLLOW, Size::Large);
    let dot = Points::dots(made, OPTIMUM, Size::Huge);
    let panel = panel.points(Points { ring: Some(OPTIMUM), ..ring }).points(dot);
    FitPanel { minimum, made, unit, panel }
}

/// Where the optimum is, and whether it is to be trusted.
fn place(fit: &Fit) -> String {
    let best = optimum(fit);
    let trust = if best.is_trusted() { "" } else { ", not trusted" };
    format!("{}{trust}", best.place.name().replace('_', " "))
}
