//! The answer in sentences.

use super::measure::Measure;
use crate::format::significant;
use powergs_study::analysis::marginal::{Marginal, Neighbour, Price};
use powergs_study::analysis::question::ENERGY_PARTS;
use powergs_study::analysis::stability::Alternative;
use powergs_study::analysis::{Analysis, Goal, Objective};

/// Settings of a design that one line shows.
const SETTINGS_MAX: usize = 12;

/// `minimize area, maximize frame rate`.
pub fn objectives(objectives: &[Objective]) -> String {
    let one = |o: &Objective| {
        let goal = match o.goal {
            Goal::Minimize => "minimize",
            Goal::Maximize => "maximize",
        };
        format!("{goal} {}", o.name)
    };
    objectives.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// `1 design`, `12 designs`.
pub fn count(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

/// `3.4 %`, `120 %`.
fn share(change: f64) -> String {
    let percent = change.abs() * 100.0;
    // Half a per cent is rounded up, as people do, not to the even number.
    if percent < 9.95 { format!("{percent:.1} %") } else { format!("{} %", percent.round()) }
}

/// `area 0.5 mm², frame rate 54.2 FPS`.
pub fn values(analysis: &Analysis, row: u32) -> String {
    let one = |(j, o): (usize, &Objective)| {
        let measure = Measure::of(&o.name);
        format!("{} {}", measure.words, measure.text(analysis.value(j, row)))
    };
    let all = analysis.question.objectives.iter().enumerate().map(one);
    all.collect::<Vec<_>>().join(", ")
}

/// `vru.cores=4, geometry.test=obb`; empty where the design has no axes.
pub fn settings(analysis: &Analysis, row: u32) -> String {
    let all = analysis.table.settings(row);
    let shown = all.iter().filter(|(_, value)| !value.is_empty()).take(SETTINGS_MAX);
    let mut parts: Vec<String> = shown.map(|(key, value)| format!("{key}={value}")).collect();
    if all.len() > SETTINGS_MAX {
        parts.push("...".into());
    }
    parts.join(", ")
}

/// Gains of at least this share are told as multiples.
const TIMES: f64 = 2.0;
/// Changes below this share are not told: 0.0 % with one decimal.
const ALIKE: f64 = 0.0005;

/// Changes from one design to another: what is worse, what is better.
fn changes(analysis: &Analysis, from: u32, to: u32) -> (Vec<String>, Vec<String>) {
    let (mut worse, mut better) = (Vec::new(), Vec::new());
    for (j, objective) in analysis.question.objectives.iter().enumerate() {
        let (old, new) = (analysis.value(j, from), analysis.value(j, to));
        let gain = objective.goal.gain(old, new);
        let change = analysis.change(j, from, to);
        if gain == 0.0 || gain.is_nan() || change.is_some_and(|c| c.abs() < ALIKE) {
            continue;
        }
        let measure = Measure::of(&objective.name);
        let direction = if new > old { "more" } else { "less" };
        let text = match change {
            Some(change) if gain > 0.0 && old > 0.0 && change >= TIMES => {
                format!("{} times the {}", significant(change + 1.0), measure.words)
            }
            Some(change) => format!("{} {direction} {}", share(change), measure.words),
            None => {
                format!("{} {direction} {}", measure.text((new - old).abs()), measure.words)
            }
        };
        if gain > 0.0 { better.push(text) } else { worse.push(text) }
    }
    (worse, better)
}

/// `a`, `a and b`, `a, b and c`.
fn listed(parts: &[String]) -> String {
    match parts {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// How many designs there were, and how many are left.
pub fn funnel(analysis: &Analysis) -> String {
    let counts = analysis.table.counts;
    let mut text = format!("{} simulated", count(analysis.simulated, "design"));
    for (n, what) in [
        (counts.failed, "failed"),
        (counts.excluded, "excluded by constraints"),
        (counts.missing, "not finished"),
    ] {
        if n > 0 {
            text += &format!(", {n} {what}");
        }
    }
    if let Some(condition) = &analysis.question.condition {
        text += &format!("; {} of them meet `{}`", analysis.rows.len(), condition.text());
    }
    text + &format!("; {} on the front.", analysis.front.len())
}

/// The knee with the reason for it.
pub fn knee(analysis: &Analysis) -> Vec<String> {
    let table = analysis.table;
    let knee = analysis.knee;
    let label = table.label(knee);
    let settings = settings(analysis, knee);
    let mut all = vec![format!("Knee: {label} ({settings}): {}.", values(analysis, knee))];
    let objectives = &analysis.question.objectives;
    if analysis.front.iter().all(|&row| analysis.equal(row, knee)) {
        all.push("It is the best in every objective: there is nothing to trade.".into());
        return all;
    }
    for (j, &end) in analysis.ends.iter().enumerate() {
        let what = Measure::of(&objectives[j].name).words;
        if analysis.value(j, end) == analysis.value(j, knee) {
            all.push(format!("It is the best of the front in {what}."));
            continue;
        }
        let (worse, better) = changes(analysis, end, knee);
        let other = table.label(end);
        let (costs, buys) = (capital(&listed(&worse)), listed(&better));
        all.push(match (worse.is_empty(), better.is_empty()) {
            (false, false) => format!("{costs} than {other}, the best in {what}, buys {buys}."),
            (false, true) => format!("{costs} than {other}, the best in {what}."),
            (true, false) => {
                format!("It has {buys} than {other}, the best in {what} by less than 0.05 %.")
            }
            (true, true) => format!("Within 0.05 % it is {other}, the best in {what}."),
        });
    }
    all.push(match objectives.len() {
        2 => "Of the front it is farthest from the straight line between the two ends.".into(),
        _ => "Of the front it has the smallest mean of the scaled objectives (0: best of the \
              front, 1: worst)."
            .into(),
    });
    all
}

fn capital(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or(String::new(), |c| c.to_uppercase().chain(rest).collect())
}

/// How far the named design is from the front; `None` if there is none.
pub fn named(analysis: &Analysis) -> Option<Vec<String>> {
    let named = analysis.named.as_ref()?;
    let table = analysis.table;
    let label = table.label(named.row);
    let mut all = vec![format!("{}: {}.", capital(&label), values(analysis, named.row))];
    if !named.meets {
        all.push("It does not meet the condition.".into());
    }
    let Some(nearest) = &named.distance.nearest else {
        all.push(if named.on_front {
            "It is on the front: nothing beats it.".into()
        } else {
            "Nothing on the front beats it: it would be on the front itself.".into()
        });
        return Some(all);
    };
    let row = analysis.rows[nearest.design];
    let (_, better) = changes(analysis, named.row, row);
    let distance = significant(nearest.distance);
    all.push(format!(
        "{} ({}) beats it: {} (distance {distance} of the ranges of the front).",
        table.label(row),
        settings(analysis, row),
        if better.is_empty() { "by less than 0.05 %".into() } else { listed(&better) }
    ));
    let mut most = Vec::new();
    for (j, best) in named.distance.best.iter().enumerate() {
        let row = analysis.rows[best.design];
        if let Some(change) = analysis.change(j, named.row, row).filter(|c| *c != 0.0) {
            let what = Measure::of(&analysis.question.objectives[j].name).words;
            let direction = if change > 0.0 { "more" } else { "less" };
            let of = table.label(row);
            most.push(format!("{} {direction} {what} ({of})", share(change)));
        }
    }
    if !most.is_empty() {
        all.push(format!("At most, without losing anything: {}.", most.join(", ")));
    }
    Some(all)
}

/// What the first and the last step along the front buy.
pub fn marginal(analysis: &Analysis, marginal: &Marginal) -> String {
    let measure = Measure::of(&marginal.objective.name);
    let unit = marginal.price.unit();
    let label = |row: u32| analysis.table.label(row);
    let verb = match marginal.objective.goal {
        Goal::Maximize => "buys",
        Goal::Minimize => "saves",
    };
    let (first, last) = (&marginal.steps[0], &marginal.steps[marginal.steps.len() - 1]);
    let mut text = format!(
        "{}: from {} to {} each {unit} {verb} {}",
        capital(&measure.words),
        label(first.from),
        label(first.to),
        measure.text(first.value())
    );
    if marginal.steps.len() > 1 {
        let times = first.value() / last.value();
        text += &format!(
            "; from {} to {} only {}, {} times less",
            label(last.from),
            label(last.to),
            measure.text(last.value()),
            significant(times)
        );
    }
    text + "."
}

/// One step of one axis: `vru.cores 4 -> 8 (#12): frame rate +20 FPS, area +0.2 mm²`.
pub fn neighbour(analysis: &Analysis, from: u32, step: &Neighbour) -> String {
    let (name, words) = &analysis.table.axes[step.axis];
    let mut parts = Vec::new();
    for (objective, gain) in analysis.question.objectives.iter().zip(&step.gains) {
        let Some(gain) = gain.filter(|g| *g != 0.0) else { continue };
        let measure = Measure::of(&objective.name);
        let change = match objective.goal {
            Goal::Maximize => gain,
            Goal::Minimize => -gain,
        };
        parts.push(format!("{} {}", measure.words, measure.difference(change)));
    }
    for (price, more) in Price::ALL.into_iter().zip(step.prices) {
        let known = analysis.question.objectives.iter().any(|o| o.name == price.column());
        if let Some(more) = more.filter(|m| !known && *m != 0.0) {
            let words = Measure::of(price.column()).words;
            let sign = if more > 0.0 { "+" } else { "" };
            parts.push(format!("{words} {sign}{} {}", significant(more), price.unit()));
        }
    }
    let changed = if parts.is_empty() { "nothing changes".into() } else { parts.join(", ") };
    let label = analysis.table.label(step.row);
    format!("{name} {} -> {} ({label}): {changed}", words.word(from), words.word(step.row))
}

/// Why another design comes first in an alternative; `None` if the same one does.
pub fn flip(analysis: &Analysis, alternative: &Alternative) -> Option<String> {
    let table = analysis.table;
    let (winner, old) = (alternative.winner?, alternative.reference_winner?);
    if table.points[winner as usize] == table.points[old as usize] {
        return None;
    }
    let point = table.points[winner as usize];
    let reference = |row: &&u32| table.points[**row as usize] == point;
    let (there, old_there) = (*analysis.rows.iter().find(reference)?, analysis.knee);
    let (new_label, old_label) = (table.label(winner), table.label(old));
    let mut text = format!("With {}, {new_label} comes before {old_label}", alternative.label);
    let moved = |j: &usize| {
        let here = analysis.change(*j, old, winner).unwrap_or(0.0);
        (here - analysis.change(*j, old_there, there).unwrap_or(0.0)).abs()
    };
    let all = 0..analysis.question.objectives.len();
    let most = all.max_by(|a, b| moved(a).total_cmp(&moved(b)))?;
    if moved(&most) > 0.0 {
        let words = Measure::of(&analysis.question.objectives[most].name).words;
        let against = |change: Option<f64>| match change {
            Some(c) if c > 0.0 => format!("{} more", share(c)),
            Some(c) if c < 0.0 => format!("{} less", share(c)),
            _ => "as much".into(),
        };
        text += &format!(
            ": against {old_label} its {words} is {} there, {} in the reference",
            against(analysis.change(most, old, winner)),
            against(analysis.change(most, old_there, there))
        );
    } else {
        text += ": the front there has other ends, so that gains weigh differently";
    }
    if let Some((part, before, after)) = moved_part(analysis, old_there, old) {
        let energy = Measure::of("energy_pj");
        let name = part.trim_start_matches("energy_pj.");
        let (there, here) = (energy.text(before), energy.text(after));
        text += &format!(" ({name} energy of {old_label}: {here} there, {there} in the reference)");
    }
    Some(text + ".")
}

/// The part of the energy that differs most between two rows of one design: name, first, second.
fn moved_part(analysis: &Analysis, a: u32, b: u32) -> Option<(&'static str, f64, f64)> {
    let part = |name: &'static str| {
        let (x, y) = (analysis.table.number(name, a)?, analysis.table.number(name, b)?);
        (x != y).then_some((name, x, y))
    };
    let size = |p: &(&str, f64, f64)| (p.1 - p.2).abs();
    ENERGY_PARTS.into_iter().filter_map(part).max_by(|a, b| size(a).total_cmp(&size(b)))
}

/// How stable the ranking is, in a sentence.
pub fn stability(analysis: &Analysis) -> String {
    let stability = &analysis.stability;
    let n = stability.alternatives.len();
    if n == 0 {
        return "One energy table and one trace: nothing to compare the ranking with.".into();
    }
    let top = stability.top.len();
    let flips = stability.alternatives.iter().filter(|a| flip(analysis, a).is_some()).count();
    let knee = analysis.table.label(analysis.knee);
    let first = match flips {
        0 if n == 1 => format!("{knee} comes first under the other ranking too"),
        _ if n == 1 => format!("{knee} loses the first place under the other ranking"),
        0 => format!("{knee} comes first under all {n} other rankings"),
        f => format!("{knee} loses the first place under {f} of {n} other rankings"),
    };
    let worst = stability.alternatives.iter().min_by_key(|a| a.top_kept);
    let kept = worst.map_or(String::new(), |a| {
        format!("; of the top {top}, at least {} stay there (fewest: {})", a.top_kept, a.label)
    });
    let all = stability.rankings();
    let always = stability.membership.iter().filter(|(_, n)| *n == all).count();
    format!("{first}{kept}; {always} of {} front designs are on every front.", analysis.front.len())
}

/// Axes that move nothing, and the one that moves most.
pub fn axes(analysis: &Analysis) -> Vec<String> {
    let mut all = Vec::new();
    if let Some(first) = analysis.axes.first().filter(|a| a.largest() > 0.0) {
        let effect = |(o, e): (&Objective, &powergs_study::analysis::axes::Effect)| {
            format!("{} by {}", Measure::of(&o.name).words, share(e.main))
        };
        let parts: Vec<String> =
            analysis.question.objectives.iter().zip(&first.effects).map(effect).collect();
        all.push(format!("{} moves most: {} of its mean.", first.name, listed(&parts)));
    }
    let dead: Vec<&str> =
        analysis.axes.iter().filter(|a| a.is_dead()).map(|a| a.name.as_str()).collect();
    if !dead.is_empty() {
        all.push(format!("Nothing changes with {}: dead here.", dead.join(", ")));
    }
    all
}
