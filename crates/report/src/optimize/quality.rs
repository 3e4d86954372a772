//! Quality against total power, all models of the run.

use super::{MISSED, RESULT, Story};
use crate::format::watt_unit;
use powergs_chart::{
    Axis, Chart, Colour, Entry, Line, Panel, Points, Rule, Scale, Side, Size, Symbol, Weight, Words,
};
use powergs_optimize::outcome::Outcome;
use powergs_optimize::role::Role;
use powergs_optimize::target::Quality;

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
    let (gate, test) = story.views;
    let what = format!("{gate} gate views decide, {test} test views are reported");
    let psnr = story.target.map(|t| t.psnr_db);
    let ssim = story.target.map(|t| t.ssim);
    let entries = [
        Entry::new("test views", Symbol::Dot(RESULT)),
        Entry::new("gate views of the same model", Symbol::Ring(RESULT, PAPER)),
        Entry::new("target over the gate views", Symbol::Dashed(TARGET)),
        Entry::new("missed the target", Symbol::Dot(MISSED)),
    ];
    Some(
        story
            .chart(NAME, TITLE, &what)
            .legend(entries)
            .columns(2)
            .panel(panel(story, &shown, "PSNR, dB", |q| q.psnr_db, psnr))
            .panel(panel(story, &shown, "SSIM", |q| q.ssim, ssim)),
    )
}

/// The inside of rings.
const PAPER: Colour = Colour(255, 255, 255);
const TARGET: Colour = Colour::PURPLE;

fn panel(
    story: &Story<'_>,
    shown: &[&Outcome],
    name: &str,
    of: impl Fn(&Quality) -> f64,
    target: Option<f64>,
) -> Panel {
    let (gate, test) = (|o: &Outcome| of(&o.gate.quality), |o: &Outcome| of(&o.test.quality));
    // Against its own renders the dense model is far above everything: it is not on this scale.
    let is_on = |o: &&&Outcome| o.role != Role::Dense || test(o) < PERFECT;
    let (mut on, off): (Vec<&&Outcome>, Vec<&&Outcome>) = shown.iter().partition(is_on);
    let target = target.filter(|t| *t > 0.0);
    let most = shown.iter().map(|o| o.watts.total_w()).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let power = |o: &Outcome| per_watt * o.watts.total_w();
    let x = Scale::around(shown.iter().map(|o| power(o)), 0.12);
    let values = on.iter().flat_map(|o| [test(o), gate(o)]).chain(target);
    let y = Scale::around(values, 0.10);
    let (low, top) = (y.low(), y.high());
    let x = Axis::new(format!("total power, {unit}"), x).ticks(5);
    let mut panel = Panel::new(x, Axis::new(name, y));
    if let Some(target) = target {
        panel = panel.dashed(Rule::Y(target), TARGET);
    }
    // Those that matter get their labels first.
    on.sort_by_key(|o| (!story.is_result(o), o.role == Role::Sample));
    for outcome in &on {
        let (at, decided) = ((power(outcome), test(outcome)), (power(outcome), gate(outcome)));
        let colour = story.colour(outcome);
        let joined = Line { weight: Weight::Hair, ..Line::curve(vec![at, decided], colour) };
        let ring = Points::dots([decided], PAPER, Size::Small);
        let size = if story.is_result(outcome) { Size::Huge } else { Size::Large };
        panel = panel
            .line(joined)
            .points(Points { ring: Some(colour), ..ring })
            .points(Points::dots([at], colour, size));
    }
    for outcome in on {
        let at = (power(outcome), test(outcome));
        panel = panel.label(story.label(outcome), at, Side::Free);
    }
    for outcome in off {
        let at = power(outcome);
        let text = format!("{}: the reference, above", story.label(outcome));
        let stub = vec![(at, top), (at, top - 0.04 * (top - low))];
        panel = panel.line(Line::curve(stub, Colour::INK)).label(
            Words::note(text),
            (at, top),
            Side::BelowLeft,
        );
    }
    panel
}
