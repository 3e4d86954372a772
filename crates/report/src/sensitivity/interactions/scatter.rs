//! μ* against σ of every key, one chart a measure: dots with numbers, and the names beside them.

use super::subtitle;
use crate::format::significant;
use powergs_chart::{
    Axis, Beside, Chart, Colour, Entry, Line, Panel, Points, Scale, Side, Size, Symbol, Weight,
    Words,
};
use powergs_study::analysis::morris::Effect;
use powergs_study::findings::sensitivity::Measure;
use powergs_study::findings::sensitivity::interactions::Interactions;

const CHARTS: [(Measure, &str, &str); 3] = [
    (Measure::Fps, "morris_fps", "How keys act together: frames per second"),
    (Measure::Energy, "morris_energy", "How keys act together: energy per frame"),
    (Measure::Area, "morris_area", "How keys act together: area"),
];
/// Keys in the list at the right.
const MOST: usize = 20;
/// Colours by what a key does: σ/μ* below these.
const COLOURS: [(&str, Colour); 4] = [
    ("< 0.1", Colour::GREEN),
    ("< 0.5", Colour::BLUE),
    ("< 1", Colour::ORANGE),
    ("≥ 1", Colour::VERMILION),
];
/// Keys below this share of the largest μ* are left out.
const LEAST: f64 = 0.001;

/// The charts; without one for a measure that nothing moves.
pub(super) fn charts(all: &Interactions, found: &[(Measure, Vec<Effect>)]) -> Vec<Chart> {
    let mut charts = Vec::new();
    for (measure, name, title) in CHARTS {
        let Some((_, effects)) = found.iter().find(|(m, _)| *m == measure) else { continue };
        if effects.iter().any(|e| e.mu_star > 0.0) {
            charts.push(chart(all, effects, name, title));
        }
    }
    charts
}

fn colour(effect: &Effect) -> Colour {
    let kind = match effect.sigma / effect.mu_star.max(f64::MIN_POSITIVE) {
        r if r < 0.1 => 0,
        r if r < 0.5 => 1,
        r if r < 1.0 => 2,
        _ => 3,
    };
    COLOURS[kind].1
}

fn chart(all: &Interactions, effects: &[Effect], name: &'static str, title: &'static str) -> Chart {
    let mut order: Vec<usize> = (0..effects.len()).collect();
    order.sort_by(|&a, &b| effects[b].mu_star.total_cmp(&effects[a].mu_star));
    let most = order.first().map_or(0.0, |&i| effects[i].mu_star);
    order.retain(|&i| effects[i].mu_star > most * LEAST);
    let largest = |of: fn(&Effect) -> f64| effects.iter().map(of).fold(0.0, f64::max);
    let x = Scale::from_zero(largest(|e| e.mu_star) * 1.03);
    let y = Scale::from_zero(largest(|e| e.sigma).max(x.high() * 0.1) * 1.03);
    let (right, top) = (x.high(), y.high());
    let mut panel = Panel::new(
        Axis::new("μ*: size of the effect over the range, % of the machine as it is", x),
        Axis::new("σ: bends or interacts, % of the machine as it is", y),
    );
    for slope in [0.1, 0.5, 1.0] {
        let end = right.min(top / slope);
        let at = (end, end * slope);
        let line = Line::curve(vec![(0.0, 0.0), at], Colour::NOTE);
        // The name is where the line leaves the panel.
        let name = Words::note(format!("σ = {slope} μ*"));
        panel = panel.line(Line { weight: Weight::Hair, ..line });
        if end < right {
            panel.over.push((end, right, name));
        } else {
            panel = panel.label(name, at, Side::AboveLeft);
        }
    }
    for (n, &i) in order.iter().enumerate() {
        let at = (effects[i].mu_star, effects[i].sigma);
        panel = panel.points(Points::dots([at], colour(&effects[i]), Size::Medium)).label(
            (n + 1).to_string(),
            at,
            Side::Free,
        );
    }
    let mut entries = vec![Entry::note("σ/μ*")];
    entries.extend(COLOURS.map(|(name, colour)| Entry::new(name, Symbol::Dot(colour))));
    let row = |&i: &usize| (all.factors[i].key.clone(), significant(effects[i].mu_star));
    let rows = order.iter().take(MOST).map(row).collect();
    Chart::new(name, title, subtitle(all))
        .legend(entries)
        .panel(panel)
        .beside(Beside::List { title: "μ*, %".into(), rows })
}
