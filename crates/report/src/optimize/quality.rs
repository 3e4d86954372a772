//! Quality against total power, all models of the run.

use super::{Grade, MISSED, RESULT, Story, colour};
use crate::format::watt_unit;
use powergs_chart::{
    Axis, Chart, Colour, Entry, Line, Panel, Points, Rule, Scale, Side, Size, Symbol, Weight, Words,
};
use powergs_optimize::job::Place;
use powergs_optimize::outcome::Outcome;
use powergs_optimize::role::{Baseline, Role};
use powergs_optimize::target::Quality;

const NAME: &str = "quality";
const TITLE: &str = "Quality against total power";
/// Above this many decibels the dense model is compared with its own renders.
const PERFECT: f64 = 70.0;
/// With more models than this not all of them have their names beside them.
const CROWD: usize = 9;

/// A measure of quality on an axis.
#[derive(Clone, Copy)]
struct QualityMeasure {
    name: &'static str,
    /// Over the test views, and over the gate views where it decides.
    of: fn(&Outcome) -> (f64, Option<f64>),
    target: Option<f64>,
}

pub(super) fn chart(story: &Story<'_>) -> Option<Chart> {
    let shown: Vec<&Outcome> =
        story.done.iter().filter(|o| !matches!(o.role, Role::Sweep(_))).collect();
    if shown.len() < 2 {
        return None;
    }
    let (gate, test) = story.views;
    let what = format!("{gate} gate views decide, {test} test views are reported");
    let target = |of: fn(&Quality) -> f64| story.target.as_ref().map(of).filter(|t| *t > 0.0);
    let psnr = QualityMeasure {
        name: "PSNR, dB",
        of: |o| (o.test.quality.psnr_db, Some(o.gate.quality.psnr_db)),
        target: target(|q| q.psnr_db),
    };
    let ssim = QualityMeasure {
        name: "SSIM",
        of: |o| (o.test.quality.ssim, Some(o.gate.quality.ssim)),
        target: target(|q| q.ssim),
    };
    let lpips = QualityMeasure {
        name: "LPIPS, less is better",
        of: |o| (o.lpips_test.unwrap_or(f64::NAN), None),
        target: None,
    };
    let has_lpips = shown.iter().any(|o| o.lpips_test.is_some());
    let lines = methods(story);
    let mut entries = vec![
        Entry::new("test views", Symbol::Dot(RESULT)),
        Entry::new("gate views of the same model", Symbol::Ring(RESULT, PAPER)),
        Entry::new("target over the gate views", Symbol::Dashed(TARGET)),
        Entry::new("missed the target", Symbol::Dot(MISSED)),
        Entry::new("sample", Symbol::Dot(colour(Role::Sample))),
        Entry::new("not of the search", Symbol::Dot(colour(Role::Dense))),
    ];
    if !lines.is_empty() {
        entries.push(Entry::note("lines: one method at several qualities"));
    }
    let chart = story.chart(NAME, TITLE, &what).legend(entries).columns(2);
    let measures = [Some(psnr), Some(ssim), has_lpips.then_some(lpips)];
    Some(
        measures
            .into_iter()
            .flatten()
            .fold(chart, |chart, measure| chart.panel(panel(story, &shown, &lines, measure))),
    )
}

/// The models of a method at several qualities, first that of the run.
struct QualityMethod<'a> {
    colour: Colour,
    /// With the name of the quality, or of the model where that says it.
    models: Vec<(&'a str, &'a Outcome)>,
}

/// Ours and the comparisons that were made for several qualities, and LightGaussian's shares.
fn methods<'a>(story: &'a Story<'_>) -> Vec<QualityMethod<'a>> {
    let of_baseline = |baseline: Baseline| {
        let of = |grade: &'a Grade| {
            let is = |o: &&Outcome| {
                o.role == Role::Baseline(baseline)
                    && o.place == (Place { variant: grade.variant, level: 0 })
            };
            Some((grade.name.as_str(), story.all.iter().find(is)?))
        };
        let models = story.grades.iter().filter_map(of).collect();
        QualityMethod { colour: colour(Role::Baseline(baseline)), models }
    };
    let ours = story.grades.iter().filter_map(|g| Some((g.name.as_str(), story.result_of(g)?)));
    let pruned = story.done.iter().filter_map(|o| match o.role {
        Role::Baseline(Baseline::LightGaussian(_)) => Some((o.name.as_str(), o)),
        _ => None,
    });
    let pruned: Vec<(&str, &Outcome)> = pruned.collect();
    let light = pruned.first().map_or(Colour::GREY, |(_, o)| colour(o.role));
    let all = [
        QualityMethod { colour: RESULT, models: ours.collect() },
        of_baseline(Baseline::RenderOnly),
        of_baseline(Baseline::DisplayOnly),
        QualityMethod { colour: light, models: pruned },
    ];
    all.into_iter().filter(|method| method.models.len() > 1).collect()
}

/// The inside of rings.
const PAPER: Colour = Colour(255, 255, 255);
const TARGET: Colour = Colour::PURPLE;

fn panel(
    story: &Story<'_>,
    shown: &[&Outcome],
    methods: &[QualityMethod<'_>],
    measure: QualityMeasure,
) -> Panel {
    let QualityMeasure { name, of, target } = measure;
    let test = |o: &Outcome| of(o).0;
    let is_measured = |o: &&&Outcome| test(o).is_finite();
    // Against its own renders the dense model is far above everything: it is not on this scale.
    let is_on = |o: &&&Outcome| o.role != Role::Dense || test(o) < PERFECT;
    let (mut on, off): (Vec<&&Outcome>, Vec<&&Outcome>) =
        shown.iter().filter(is_measured).partition(is_on);
    let others: Vec<(Colour, &str, &Outcome)> = methods
        .iter()
        .flat_map(|m| m.models.iter().map(|(name, o)| (m.colour, *name, *o)))
        .filter(|(_, _, o)| o.place.variant > 0 && test(o).is_finite())
        .collect();
    let all = || shown.iter().copied().chain(others.iter().map(|(_, _, o)| *o));
    let most = all().map(|o| o.watts.total_w()).fold(0.0, f64::max);
    let (per_watt, unit) = watt_unit(most);
    let power = |o: &Outcome| per_watt * o.watts.total_w();
    let x = Scale::around(all().map(power), 0.12);
    let of_others = others.iter().map(|(_, _, o)| test(o));
    let of_shown = on.iter().flat_map(|o| [Some(test(o)), of(o).1]).flatten();
    let y = Scale::around(of_shown.chain(of_others).chain(target), 0.10);
    let (low, top) = (y.low(), y.high());
    let x = Axis::new(format!("total power, {unit}"), x).ticks(5);
    let mut panel = Panel::new(x, Axis::new(name, y));
    if let Some(target) = target {
        panel = panel.dashed(Rule::Y(target), TARGET);
    }
    for method in methods {
        let mut points: Vec<(f64, f64)> =
            method.models.iter().map(|(_, o)| (power(o), test(o))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        panel = panel.line(Line::thin(points, method.colour));
    }
    // Those that matter get their labels first.
    on.sort_by_key(|o| (!story.is_result(o), o.role == Role::Sample));
    for outcome in &on {
        let at = (power(outcome), test(outcome));
        let colour = story.colour(outcome);
        if let Some(gate) = of(outcome).1 {
            let decided = (power(outcome), gate);
            let joined = Line { weight: Weight::Hair, ..Line::curve(vec![at, decided], colour) };
            let ring = Points::dots([decided], PAPER, Size::Small);
            panel = panel.line(joined).points(Points { ring: Some(colour), ..ring });
        }
        let size = if story.is_result(outcome) { Size::Huge } else { Size::Large };
        panel = panel.points(Points::dots([at], colour, size));
    }
    for (colour, _, outcome) in &others {
        let at = (power(outcome), test(outcome));
        panel = panel.points(Points::dots([at], *colour, Size::Large));
    }
    // Among many, samples and qualities of comparisons are told by their colours.
    let is_crowd = !methods.is_empty() || on.len() > CROWD;
    let is_named = |o: &&Outcome| !is_crowd || o.role != Role::Sample || story.is_result(o);
    for outcome in on.into_iter().copied().filter(is_named) {
        let at = (power(outcome), test(outcome));
        panel = panel.label(story.label(outcome), at, Side::Free);
    }
    for (_, name, outcome) in others.into_iter().filter(|(colour, ..)| *colour == RESULT) {
        panel = panel.label(name, (power(outcome), test(outcome)), Side::Free);
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
