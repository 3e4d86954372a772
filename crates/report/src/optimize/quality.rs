//! Quality against total power, all models of the run.

use super::{Story, colour, label};
use crate::format::watt_unit;
use powergs_chart::{Axis, Chart, Colour, Line, Panel, Points, Rule, Scale, Side, Size, Words};
use powergs_optimize::outcome::Outcome;
use powergs_optimize::role::Role;

const NAME: &str = "quality";
const TITLE: &str = "Quality against total power";
/// Above this many decibels the dense model is compared with its own renders.
const PERFECT: f64 = 70.0;

pub(super) fn chart(story: &Story<'_>) -> Option<Chart> {
    let shown: Vec<&Outcome> =
        story.done.iter().filter(|o| !matches!(o.role, Role::Sweep(_))).collect();
    if shown.len() < 2 {
        return None;
    }
    let what = "test views; dashed: the target of the gate views";
    let psnr = story.target.map(|t| t.psnr_db);
    let ssim = story.target.map(|t| t.ssim);
    Some(
        story
            .chart(NAME, TITLE, what)
            .columns(2)
            .panel(panel(&shown, "PSNR, dB", |o| o.test.quality.psnr_db, psnr))
            .panel(panel(&shown, "SSIM", |o| o.test.quality.ssim, ssim)),
    )
}

fn panel(
    shown: &[&Outcome],
    name: &str,
    of: impl Fn(&Outcome) -> f64,
    target: Option<f64>,
) -> Panel {
    // Against its own renders the dense model is far above everything: it is not on this scale.
    let is_on = |o: &&&Outcome| o.role != Role::Dense || of(o) < PERFECT;
    let (mut on, off): (Vec<&&Outcome>, Vec<&&Outcome>) = shown.iter().partition(is_on);
    let most = shown.iter().map(|o| o.watts.total_w()).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let power = |o: &Outcome| per_watt * o.watts.total_w();
    let x = Scale::around(shown.iter().map(|o| power(o)), 0.12);
    let y = Scale::around(on.iter().map(|o| of(o)).chain(target), 0.10);
    let (low, top) = (y.low(), y.high());
    let x = Axis::new(format!("total power, {unit}"), x).ticks(5);
    let mut panel = Panel::new(x, Axis::new(name, y));
    if let Some(target) = target.filter(|t| *t > 0.0) {
        panel = panel.dashed(Rule::Y(target), Colour::GREY);
    }
    // Those that matter get their labels first.
    on.sort_by_key(|o| o.role == Role::Sample);
    for outcome in on {
        let at = (power(outcome), of(outcome));
        let size = if outcome.role == Role::Final { Size::Huge } else { Size::Large };
        panel = panel.points(Points::dots([at], colour(outcome.role), size)).label(
            label(outcome),
            at,
            Side::Free,
        );
    }
    for outcome in off {
        let at = power(outcome);
        let text = format!("{}: {:.0} dB, above", label(outcome), of(outcome));
        let stub = vec![(at, top), (at, top - 0.04 * (top - low))];
        panel = panel.line(Line::curve(stub, Colour::INK)).label(
            Words::note(text),
            (at, top),
            Side::BelowLeft,
        );
    }
    panel
}
