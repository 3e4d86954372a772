//! The answer in sentences.

use super::measure::Measure;
use crate::format::{self, counted, significant};
use powergs_study::analysis::front::is_alike;
use powergs_study::analysis::marginal::{Marginal, Neighbour, Price};
use powergs_study::analysis::question::ENERGY_PARTS;
use powergs_study::analysis::stability::Alternative;
use powergs_study::analysis::{Analysis, Goal, Misses, Objective};
use powergs_study::sweep::space::FreeAxis;

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

/// Where prices are from: a file of a machine may name its energy table itself.
pub fn prices(analysis: &Analysis) -> String {
    match analysis.energy_table.as_str() {
        "" | "own" => "prices of the machine file".into(),
        name => format!("energy table {name}"),
    }
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
/// Equal designs that are named.
const TWINS: usize = 8;

/// Changes from one design to another: what is worse, what is better.
fn changes(analysis: &Analysis, from: u32, to: u32) -> (Vec<String>, Vec<String>) {
    let (mut worse, mut better) = (Vec::new(), Vec::new());
    for (j, objective) in analysis.question.objectives.iter().enumerate() {
        let (old, new) = (analysis.value(j, from), analysis.value(j, to));
        let gain = objective.goal.gain(old, new);
        let change = analysis.change(j, from, to);
        if gain == 0.0 || gain.is_nan() || analysis.alike(j, from, to) {
            continue;
        }
        let measure = Measure::of(&objective.name);
        let direction = if new > old { "more" } else { "less" };
        let text = match change {
            Some(change) if gain > 0.0 && old > 0.0 && change >= TIMES => {
                format!("{} times the {}", significant(change + 1.0), measure.short())
            }
            Some(change) => format!("{} {direction} {}", share(change), measure.short()),
            None => {
                format!("{} {direction} {}", measure.text((new - old).abs()), measure.short())
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

/// `60 FPS`, or what it is where the number is not known.
pub fn display_rate(analysis: &Analysis) -> String {
    let fps = analysis.question.display_fps;
    fps.map_or("the display rate".into(), |fps| format!("{} FPS", format::rate(fps)))
}

/// `0.1 %`: differences that are noise.
pub fn noise(analysis: &Analysis) -> String {
    format!("{} %", significant_short(analysis.question.epsilon * 100.0))
}

/// Up to three digits without zeros at the end.
fn significant_short(x: f64) -> String {
    let text = significant(x);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// That designs miss the display rate, and what that means for the ranking; empty where none does.
pub fn rate(analysis: &Analysis) -> String {
    let rate = display_rate(analysis);
    let met = match &analysis.question.condition {
        Some(_) => "that meets the condition ",
        None => "",
    };
    if let Some((row, fps)) = analysis.unreached() {
        let text = format!(
            "No design {met}reaches {rate} in every frame. The fastest, {}, does {} in its \
             slowest frame.",
            analysis.table.label(row),
            Measure::of("fps.min").text(fps),
        );
        return match analysis.question.misses {
            Misses::Included => text,
            Misses::Behind => {
                text + " Only those that miss it least are ranked; --include-misses ranks all by \
                        the objectives alone."
            }
        };
    }
    if !analysis.behind.is_empty() {
        let n = analysis.behind.len();
        let (verb, rank) = if n == 1 { ("misses", "ranks") } else { ("miss", "rank") };
        return format!(
            "{} {verb} {rate} in some frame and {rank} behind all others: at the rate that a slow \
             design reaches it draws little. With --include-misses they rank by the objectives \
             alone.",
            counted(n, "design")
        );
    }
    let late = analysis.front.iter().filter(|row| analysis.is_late(**row)).count();
    match late {
        0 => String::new(),
        1 => format!(
            "1 design of the front misses {rate} in some frame; its power is that at the \
                      rate that it reaches."
        ),
        n => format!(
            "{n} designs of the front miss {rate} in some frame; their power is that at \
                      the rate that they reach."
        ),
    }
}

/// What energy per frame and power at the display rate do not have in common, where both are told.
pub fn energy_and_power(analysis: &Analysis) -> &'static str {
    let energy = analysis.question.objectives.iter().any(|o| o.name.contains("energy_pj"));
    match energy {
        true => ENERGY_AND_POWER,
        false => "",
    }
}

/// The difference in a line.
pub const ENERGY_AND_POWER: &str = "Energy per frame counts standby for the frame's own time \
only; power at the display rate counts it all the time. So a fast, large design can have less \
energy per frame and draw more power.";

/// Axes at whose end the whole front is.
pub fn at_ends(analysis: &Analysis) -> Vec<String> {
    let one = |end: &powergs_study::analysis::ends::AtEnd| {
        let front = match analysis.front.len() {
            1 => "The front design has".to_owned(),
            n => format!("All {n} front designs have"),
        };
        let (low, high) = match end.is_largest {
            true => (&end.other, &end.value),
            false => (&end.value, &end.other),
        };
        let is_free = |f: &&FreeAxis| !f.is_policy && f.axis == end.axis;
        let advice = match analysis.question.free.iter().any(|f| is_free(&f)) {
            true => "it costs nothing here, so more of it always looks better",
            false => "extend it",
        };
        format!(
            "{front} {} = {}, the end of its axis ({low} to {high}): {advice}.",
            end.axis, end.value
        )
    };
    analysis.at_ends.iter().map(one).collect()
}

/// Axes that cost nothing: resources without a price, and policies.
pub fn free(free: &[FreeAxis]) -> Vec<String> {
    let names = |policy: bool| {
        let some = free.iter().filter(|f| f.is_policy == policy).map(|f| f.axis.as_str());
        some.collect::<Vec<_>>().join(", ")
    };
    let (resources, policies) = (names(false), names(true));
    let mut all = Vec::new();
    if !resources.is_empty() {
        all.push(format!(
            "Without a price in the energy tables of this sweep: {resources}. They change no area, \
             no energy of an action and no standby power, so more of them looks like a gift."
        ));
    }
    if !policies.is_empty() {
        all.push(format!(
            "Policies, which have no price of their own: {policies}. What they cost is in time and \
             traffic."
        ));
    }
    all
}

/// `#4, #7 and 3 more`.
pub fn labels(analysis: &Analysis, rows: &[u32], most: usize) -> String {
    let shown = rows.iter().take(most).map(|&row| analysis.table.label(row));
    let shown = shown.collect::<Vec<_>>().join(", ");
    match rows.len().saturating_sub(most) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// The designs that are equal to an entry of the front; empty for none.
pub fn twins(analysis: &Analysis, row: u32, most: usize) -> String {
    let place = analysis.front.iter().position(|r| *r == row);
    place.map_or(String::new(), |place| labels(analysis, &analysis.twins[place], most))
}

/// How many designs there were, and how many are left.
pub fn funnel(analysis: &Analysis) -> String {
    let counts = analysis.table.counts;
    let mut text = format!("{} simulated", counted(analysis.simulated, "design"));
    for (n, what) in [
        (counts.invalid, "invalid"),
        (counts.failed, "failed"),
        (counts.excluded, "excluded by constraints"),
        (counts.missing, "not finished"),
    ] {
        if n > 0 {
            text += &format!(", {n} {what}");
        }
    }
    if let Some(condition) = &analysis.question.condition {
        let meet = analysis.rows.len() + analysis.behind.len();
        text += &format!("; {meet} of them meet `{}`", condition.text());
    }
    if !analysis.behind.is_empty() && analysis.unreached().is_none() {
        text += &format!("; {} reach {}", analysis.rows.len(), display_rate(analysis));
    }
    let twins: usize = analysis.twins.iter().map(Vec::len).sum();
    text += &format!("; {} on the front", analysis.front.len());
    if twins > 0 {
        let more = counted(twins, "more design");
        text += &format!(" ({more} equal to one of them within {})", noise(analysis));
    }
    text + "."
}

/// Whether the knee is the best of the front in objective `j`.
fn is_best(analysis: &Analysis, j: usize) -> bool {
    analysis.alike(j, analysis.ends[j], analysis.knee)
}

/// What the design with the smallest merit is called: an end of the front is no knee.
pub fn knee_name(analysis: &Analysis) -> &'static str {
    let is_end = (0..analysis.ends.len()).any(|j| is_best(analysis, j));
    if is_end && analysis.front.len() > 1 { "best balance" } else { "knee" }
}

/// What is said of a knee whose frames are there later than those of the base machine: no objective
/// counts the time of a frame beside the distance of two.
fn latency(analysis: &Analysis) -> Option<String> {
    const LATENCY: &str = "frame_latency_ms";
    /// What is later by less is as late.
    const SAME: f64 = 1.01;
    let table = analysis.table;
    let base = (0..table.len() as u32).find(|&row| table.is_baseline(row))?;
    let (own, base) = (table.number(LATENCY, analysis.knee)?, table.number(LATENCY, base)?);
    let is_asked = analysis.question.objectives.iter().any(|o| o.name.starts_with(LATENCY));
    (own > SAME * base && !is_asked).then(|| {
        format!(
            "Its frames are there after {} ms, those of the base machine after {} ms \
             (`{LATENCY}`): --minimize {LATENCY} to count that.",
            significant(own),
            significant(base)
        )
    })
}

/// The knee with the reason for it.
pub fn knee(analysis: &Analysis) -> Vec<String> {
    let table = analysis.table;
    let knee = analysis.knee;
    let label = table.label(knee);
    let settings = settings(analysis, knee);
    let mut all = vec![format!(
        "{}: {label} ({settings}): {}.",
        capital(knee_name(analysis)),
        values(analysis, knee)
    )];
    let objectives = &analysis.question.objectives;
    let twins = twins(analysis, knee, TWINS);
    if !twins.is_empty() {
        all.push(format!("Same as {twins}, within {} in every objective.", noise(analysis)));
    }
    if analysis.front.len() == 1 {
        all.push(
            "It is the best in every objective: there is nothing to trade among these.".into(),
        );
        all.extend(latency(analysis));
        return all;
    }
    let name = |j: usize| Measure::of(&objectives[j].name).words;
    let is_best = |j: &usize| is_best(analysis, *j);
    let best: Vec<String> = (0..objectives.len()).filter(is_best).map(name).collect();
    if !best.is_empty() {
        let what = listed(&best);
        all.push(format!("It is an end of the front, not a compromise: the best in {what}."));
    }
    let mut told: Vec<u32> = Vec::new();
    for (j, &end) in analysis.ends.iter().enumerate() {
        if is_best(&j) || told.contains(&end) {
            continue;
        }
        told.push(end);
        let same = |k: &usize| analysis.ends[*k] == end && !is_best(k);
        let what = listed(&(0..objectives.len()).filter(same).map(name).collect::<Vec<_>>());
        let (worse, better) = changes(analysis, end, knee);
        let other = table.label(end);
        let (costs, buys) = (capital(&listed(&worse)), listed(&better));
        all.push(match better.is_empty() {
            false => format!("{costs} than {other}, the best in {what}, buys {buys}."),
            true => format!("{costs} than {other}, the best in {what}."),
        });
    }
    all.push(match (objectives.len(), best.is_empty()) {
        (2, true) => {
            "Of the front it is farthest from the straight line between the two ends.".into()
        }
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
    let late = analysis.is_late(named.row) && analysis.question.misses == Misses::Behind;
    let mut faults: Vec<String> = Vec::new();
    if !named.meets {
        faults.push("does not meet the condition".into());
    }
    if late {
        faults.push(format!("misses {} in some frame", display_rate(analysis)));
    }
    let is_candidate = faults.is_empty();
    if !is_candidate {
        all.push(format!("It {}, so it is not ranked.", listed(&faults)));
    }
    if let Some(twin) = named.twin {
        let noise = noise(analysis);
        let twin = table.label(twin);
        all.push(format!("Within {noise} in every objective it is the same as {twin}."));
        return Some(all);
    }
    let Some(nearest) = &named.distance.nearest else {
        all.push(match (named.on_front, is_candidate) {
            (true, _) => "It is on the front: nothing beats it.".into(),
            (false, true) => {
                "Nothing on the front beats it: it would be on the front itself.".into()
            }
            (false, false) => "By the objectives alone nothing on the front beats it.".into(),
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
        listed(&better)
    ));
    let mut most = Vec::new();
    for (j, best) in named.distance.best.iter().enumerate() {
        let row = analysis.rows[best.design];
        let differs = !analysis.alike(j, named.row, row);
        if let Some(change) = analysis.change(j, named.row, row).filter(|_| differs) {
            let what = Measure::of(&analysis.question.objectives[j].name).short();
            let direction = if change > 0.0 { "more" } else { "less" };
            let of = table.label(row);
            most.push(format!("{} {direction} {what} ({of})", share(change)));
        }
    }
    if !most.is_empty() {
        all.push(format!("Largest gains without a loss elsewhere: {}.", most.join(", ")));
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

/// Which models of the DRAM made the numbers; nothing where that is not known.
pub fn memory(analysis: &Analysis) -> String {
    let model = |row: &u32| analysis.table.models.word(*row);
    let mut rows: Vec<u32> = [&analysis.rows, &analysis.behind, &analysis.unmet]
        .into_iter()
        .flatten()
        .copied()
        .collect();
    rows.sort_unstable();
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for row in &rows {
        match counts.iter_mut().find(|(name, _)| *name == model(row)) {
            Some((_, n)) => *n += 1,
            None => counts.push((model(row), 1)),
        }
    }
    counts.sort_unstable();
    counts.retain(|(name, _)| !name.is_empty());
    match counts.as_slice() {
        [] => String::new(),
        [(name, _)] => format!("Memory: `{name}` for all designs."),
        several => {
            let of = |(name, n): &(&str, usize)| format!("`{name}` for {}", counted(*n, "design"));
            let on_front = analysis.front.iter().filter(|row| model(row) == "banked").count();
            let others = on_front < analysis.front.len();
            // A sweep confirms what is near the display rate; a later condition it does not know.
            let doubt = match &analysis.question.condition {
                Some(_) if others => {
                    " A condition that one of the others meets by a few percent may not hold with \
                     `banked`: look at it again with `--dram-model banked`."
                }
                _ => "",
            };
            format!(
                "Memory: {}; {on_front} of {} of the front are `banked`.{doubt}",
                several.iter().map(of).collect::<Vec<_>>().join(", "),
                analysis.front.len()
            )
        }
    }
}

/// One step of one axis: `vru.cores 4 -> 8 (#12): frame rate +20 FPS, area +0.2 mm²`.
pub fn neighbour(analysis: &Analysis, from: u32, step: &Neighbour) -> String {
    let (name, words) = &analysis.table.axes[step.axis];
    let mut parts = Vec::new();
    let mut small = false;
    for (j, (objective, gain)) in analysis.question.objectives.iter().zip(&step.gains).enumerate() {
        let Some(gain) = gain.filter(|g| *g != 0.0) else { continue };
        if analysis.alike(j, from, step.row) {
            small = true;
            continue;
        }
        let measure = Measure::of(&objective.name);
        let change = match objective.goal {
            Goal::Maximize => gain,
            Goal::Minimize => -gain,
        };
        let change = measure.difference(change, analysis.value(j, from));
        parts.push(format!("{} {change}", measure.short()));
    }
    let objectives = &analysis.question.objectives;
    for (price, more) in Price::ALL.into_iter().zip(step.prices) {
        let known = analysis.question.objectives.iter().any(|o| o.name == price.column(objectives));
        let old = price.of(analysis.table, objectives, from).unwrap_or(0.0);
        let differs = |m: &f64| !is_alike(old, old + m, analysis.question.epsilon);
        if let Some(more) = more.filter(|m| !known && differs(m)) {
            let words = Measure::of(price.column(objectives)).short();
            let sign = if more > 0.0 { "+" } else { "" };
            parts.push(format!("{words} {sign}{} {}", significant(more), price.unit()));
        }
    }
    let changed = match (parts.is_empty(), small) {
        (false, _) => parts.join(", "),
        (true, true) => format!("nothing changes by more than {}", noise(analysis)),
        (true, false) => "nothing changes".into(),
    };
    let late = match (analysis.is_late(step.row), analysis.is_late(from)) {
        (true, false) => format!("; misses {}", display_rate(analysis)),
        (false, true) => format!("; meets {}", display_rate(analysis)),
        _ => String::new(),
    };
    let changed = changed + &late;
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
