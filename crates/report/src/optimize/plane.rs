//! The plane of display and accelerator power: models that reach the target, the curve through
//! them, lines of equal total power.

use super::{MISSED, RESULT, Story, colour};
use crate::format::{significant, watt_unit};
use powergs_chart::{
    Axis, Chart, Colour, Entry, Line, Panel, Points, Scale, Side, Size, Symbol, Weight, Words,
};
use powergs_optimize::outcome::Outcome;
use powergs_optimize::role::Role;

const NAME: &str = "plane";
const TITLE: &str = "Display against accelerator power";
/// Lines of equal total power.
const ISO_LINES: usize = 6;
/// The colour of lines of equal total power.
const SUM: Colour = Colour(170, 170, 170);
/// Points of the curve.
const STEPS: u32 = 100;

pub(super) fn chart(story: &Story<'_>) -> Option<Chart> {
    let shown: Vec<&Outcome> = story
        .done
        .iter()
        .filter(|o| matches!(o.role, Role::Sample | Role::Optimum | Role::Dense))
        .collect();
    story.samples().next()?;
    let target =
        story.target.map_or(String::new(), |t| format!("target {}", super::summary::quality(t)));
    let entries = [
        Entry::new("dense", Symbol::Dot(Colour::INK)),
        Entry::new("sample", Symbol::Dot(Colour::SKY)),
        Entry::new("missed the target", Symbol::Dot(MISSED)),
        Entry::new("optimum, realised", Symbol::Dot(colour(Role::Optimum))),
        Entry::new("result", Symbol::Dot(RESULT)),
        Entry::new("fit through the samples", Symbol::Line(Colour::BLUE)),
        Entry::new("equal total power", Symbol::Dashed(SUM)),
    ];
    Some(story.chart(NAME, TITLE, &target).legend(entries).panel(panel(story, &shown)))
}

fn panel(story: &Story<'_>, shown: &[&Outcome]) -> Panel {
    let most = shown.iter().map(|o| o.watts.total_w()).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let display = |o: &&Outcome| per_watt * o.watts.display_w;
    let render = |o: &&Outcome| per_watt * o.watts.render_w;
    let x = Scale::around(shown.iter().map(display), 0.12);
    let y = Scale::around(shown.iter().map(render), 0.12);
    let mut panel = Panel::new(
        Axis::new(format!("display power, {unit}"), x).ticks(8),
        Axis::new(format!("accelerator power, {unit}"), y),
    );
    panel = iso_power(panel, &unit);
    if let Ok(fit) = &story.conclusion.fit {
        let point = |i: u32| {
            let t = f64::from(i) / f64::from(STEPS);
            let rho = fit.rho_min() + t * (fit.rho_max() - fit.rho_min());
            (per_watt * fit.display_w(rho), per_watt * fit.render_w(rho))
        };
        panel = panel.line(Line::curve((0..=STEPS).map(point).collect(), Colour::BLUE));
    }
    for outcome in shown {
        let at = (display(outcome), render(outcome));
        let size = if story.is_result(outcome) { Size::Huge } else { Size::Large };
        panel = panel.points(Points::dots([at], story.colour(outcome), size)).label(
            story.label(outcome),
            at,
            Side::Free,
        );
    }
    panel
}

/// Lines on which display and rendering power add up to the same, with the sum.
fn iso_power(mut panel: Panel, unit: &str) -> Panel {
    let (x, y) = (panel.x.scale.clone(), panel.y.scale.clone());
    let sums = Scale::linear(x.low() + y.low(), x.high() + y.high()).ticks(ISO_LINES);
    let on = |t: &f64| *t > x.low() + y.low() && *t < x.high() + y.high();
    for total in sums.into_iter().filter(on) {
        // From the left or the top edge to the bottom or the right one.
        let x0 = x.low().max(total - y.high());
        let x1 = x.high().min(total - y.low());
        let end = (x1, total - x1);
        let line = Line::thin(vec![(x0, total - x0), end], SUM);
        let text = Words::note(format!("{} {unit}", significant(total)));
        let line = Line { dashed: true, weight: Weight::Hair, ..line };
        panel = panel.line(line).label(text, end, Side::AboveLeft);
    }
    panel
}
