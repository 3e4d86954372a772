//! The page: what was found, why, whether it holds, and what it rests on.

use std::collections::BTreeSet;

use super::{tables, words};
use crate::document::{Block, Cell, Column, Document, Table, Text};
use crate::format::{counted, engineering, significant, watt_unit};
use powergs_chart::Chart;
use powergs_codesign::Finished;
use powergs_codesign::compare::{Comparison, Limit, Nothing, Way};
use powergs_codesign::model::ModelPoint;
use powergs_codesign::pricing::MachinePoint;
use powergs_codesign::stability::{Coupling, sequential};
use powergs_optimize::target::Target;

/// Quality above the target that a fine-tune is to spend, decibels.
const SPARE_DB: f64 = 0.5;
/// What stands below the table of machines.
const MACHINES: &str = "A machine is called by the number of its point; the table has those that \
                        this page names. Keys that follow from the axes are in pairs.csv, all of \
                        the joint machine in joint.toml.";
/// What stands above the table of files.
const EXPORTS: &str = "What is read back of each file, over the gate views. The smallest one that \
                       still reaches the quality stands beside joint.ply; a machine that reads \
                       records of other numbers is not what was priced.";
/// Gains below this share of the watts are noise, as differences between designs of a sweep are.
const NOISE: f64 = 0.001;

/// The result in a sentence or two.
pub fn headline(finished: &Finished) -> String {
    let Some((joint, found)) = joint(finished) else { return "no pair was found".into() };
    let watts = found.confirmed.total_w;
    let (model, machine) = found.pair;
    let machine = words::whole_machine(finished, machine);
    let pair = format!("{} on {machine}", words::model(finished, model));
    let gain = finished.gain_w().filter(|gain| *gain > NOISE * watts);
    let best = best_sequential(finished);
    match (gain, best) {
        (Some(gain), Some((way, other))) => format!(
            "{pair} takes {}, {} ({:.1} %) less than the best that one half after the other finds, \
             {} by ({})",
            engineering(watts, "W"),
            engineering(gain, "W"),
            100.0 * gain / other,
            engineering(other, "W"),
            way.letter()
        ),
        (None, Some((way, _))) => format!(
            "{pair} takes {}; searching both together gains nothing over ({}) {}",
            engineering(watts, "W"),
            way.letter(),
            way.words()
        ),
        (_, None) => format!(
            "{pair} takes {}; ({}) alone finds a pair within the budget",
            engineering(watts, "W"),
            joint.letter()
        ),
    }
}

fn joint(finished: &Finished) -> Option<(Way, &powergs_codesign::compare::Found)> {
    Some((Way::Joint, finished.of(Way::Joint)?.found.as_ref().ok()?))
}

fn best_sequential(finished: &Finished) -> Option<(Way, f64)> {
    let others = finished.comparisons.iter().filter(|c| c.way != Way::Joint);
    let watts = others.filter_map(|c| Some((c.way, c.watts()?)));
    watts.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The page of a co-design with its charts.
pub fn document(finished: &Finished, charts: &[Chart]) -> Document {
    let about = &finished.about;
    let mut page = Document::new();
    page.title(format!("Co-design of {}", about.scene));
    page.paragraph(format!("{}.", headline(finished)));
    page.table(tables::ways(finished));
    page.page_paragraph(how(finished));
    page.add(Block::List(nothing(finished)));
    page.page_heading("Machines");
    page.table(tables::machines(finished, &named(finished)));
    page.page_paragraph(MACHINES);
    if let Some(coupling) = &finished.coupling {
        page.heading("Why together");
        page.add(Block::List(why(finished, coupling)));
    }
    page.add(Block::List(rounds(finished)));
    page.heading("Whether it holds");
    page.table(stability(finished));
    page.paragraph(holds(finished));
    page.page_heading("Models");
    page.page_paragraph(target(finished));
    page.table(tables::models(finished));
    page.add(Block::List(spare(finished)));
    page.add(Block::List(left(finished)));
    page.page_heading("The joint model in compressed formats");
    page.page_paragraph(EXPORTS);
    page.table(tables::exports(finished));
    page.page_heading("Charts");
    page.charts(charts);
    page.page_paragraph(format!(
        "Every pair is in pairs.csv, every model in models.csv. {} of {} are on the front of \
         watts, area and frame time.",
        finished.front.len(),
        counted(finished.rows.iter().map(|row| row.pairs.len()).sum::<usize>(), "pair"),
    ));
    page
}

/// Models that were tried for a part of the iterations only.
fn left(finished: &Finished) -> Vec<Text> {
    let sentence = |(point, iterations): &(ModelPoint, u32)| {
        format!("{} was left after {iterations} iterations: others were better.", point.name())
            .into()
    };
    finished.left.iter().map(sentence).collect()
}

/// The machines that the page names.
fn named(finished: &Finished) -> BTreeSet<MachinePoint> {
    let nearest = |c: &Comparison| c.found.as_ref().err()?.nearest.as_ref().map(|n| n.0);
    let coupled = finished.coupling.iter().flat_map(|c| {
        let alone = [c.model_alone, c.machine_alone].into_iter().flatten();
        alone.chain([c.before, c.joint]).map(|(pair, _)| pair)
    });
    let others = finished.alternatives.iter().filter_map(|a| a.pair);
    let rounds = finished.rounds.iter().map(|round| round.pair);
    let nearest = finished.comparisons.iter().filter_map(nearest);
    let more = coupled.chain(others).chain(rounds).chain(nearest).map(|(_, machine)| machine);
    tables::found(finished).into_iter().chain(more).collect()
}

fn how(finished: &Finished) -> String {
    let (about, budget) = (&finished.about, finished.budget);
    let confirmed = match about.is_confirmed {
        true => {
            "Pairs were ranked with the calibrated model of the DRAM and are compared here with \
             the banked one."
        }
        false => "The base machine has no banks of DRAM to confirm with.",
    };
    format!(
        "Watts are those of display, rendering and standby at {} Hz over {}, under the \
         energy table {}. A pair keeps {:.4} mm² and {} ms for its slowest frame. {confirmed}",
        about.fps,
        about.priced,
        finished.tables[0],
        budget.area_mm2,
        significant(budget.frame_ms),
    )
}

/// Ratios that the joint machine gave, and whether pairs stood still.
fn rounds(finished: &Finished) -> Vec<Text> {
    let line = |round: &powergs_codesign::alternate::Round| {
        format!(
            "A fit of the ratio with the machine that was found gives {}; then the joint pair is \
             {} with {}.",
            round.rho,
            words::pair(finished, round.pair),
            engineering(round.watts, "W")
        )
    };
    let mut lines: Vec<String> = finished.rounds.iter().map(line).collect();
    let machines: Vec<_> = finished.rounds.iter().map(|round| round.pair.1).collect();
    let mut changes = machines.clone();
    changes.dedup();
    let returns = (0..changes.len()).any(|i| changes[..i].contains(&changes[i]));
    if returns {
        lines.push("The machines oscillate: one that was left came back.".into());
    }
    lines.into_iter().map(Text::from).collect()
}

/// Why ways find nothing.
fn nothing(finished: &Finished) -> Vec<Text> {
    let line = |comparison: &Comparison| {
        let Comparison { way, found: Err(nothing) } = comparison else { return None };
        Some(format!("({}) finds nothing: {}", way.letter(), reasons(finished, nothing)).into())
    };
    finished.comparisons.iter().filter_map(line).collect()
}

fn reasons(finished: &Finished, nothing: &Nothing) -> String {
    let mut parts: Vec<String> = Vec::new();
    for (limit, count) in &nothing.limits {
        let what = match limit {
            Limit::Area => "too large",
            Limit::FrameTime => "too slow",
            Limit::Both => "too large and too slow",
            Limit::NoArea => "without an area",
        };
        parts.push(format!("{count} {what}"));
    }
    if nothing.refused > 0 {
        parts.push(format!("{} no machine", nothing.refused));
    }
    let nearest = nothing.nearest.as_ref().map_or_else(String::new, |nearest| {
        let (pair, price) = **nearest;
        let area = price.area_mm2.map_or_else(String::new, |a| format!("{a:.3} mm², "));
        format!(
            "; the nearest miss is {} ({area}{} ms)",
            words::pair(finished, pair),
            significant(price.frame_ms)
        )
    });
    if nothing.pairs == 0 {
        return "the way before it found none".into();
    }
    format!("of {} pairs, {}{nearest}", nothing.pairs, parts.join(", "))
}

/// What each half of the joint pair does alone.
fn why(finished: &Finished, coupling: &Coupling) -> Vec<Text> {
    let Coupling { sequential, before, joint, model_alone, machine_alone } = coupling;
    let mut lines: Vec<String> = Vec::new();
    let changes = words::changes(finished, before.0.1, joint.0.1);
    let model = match before.0.0 == joint.0.0 {
        true => "the same model".to_owned(),
        false => format!(
            "the model {} in place of {}",
            words::model(finished, joint.0.0),
            words::model(finished, before.0.0)
        ),
    };
    let machine = match (before.0.1 == joint.0.1, changes.is_empty()) {
        (true, _) => "the same machine".to_owned(),
        (false, true) => format!("the machine {}", words::machine(finished, joint.0.1)),
        (false, false) => format!("a machine with {}", changes.join(", ")),
    };
    lines.push(format!(
        "Against ({}) the joint pair has {model} on {machine}: {} in place of {}.",
        sequential.letter(),
        engineering(joint.1.total_w, "W"),
        engineering(before.1.total_w, "W")
    ));
    let parts = |p: &powergs_codesign::pricing::Price| {
        let [a, b, c, d] = p.stages_w;
        [p.display_w, a + b + c, d]
    };
    let (from, to) = (parts(&before.1), parts(&joint.1));
    let names = ["display", "rendering", "standby"];
    let change = |i: usize| {
        let w = to[i] - from[i];
        let sign = if w < 0.0 { "−" } else { "+" };
        format!("{} {sign}{}", names[i], engineering(w.abs(), "W"))
    };
    lines.push(format!(
        "Where: {}; {:.0} kB in place of {:.0} kB of DRAM traffic a frame.",
        [0, 1, 2].map(change).join(", "),
        joint.1.dram_bytes / 1e3,
        before.1.dram_bytes / 1e3
    ));
    let halves = [("model", model_alone), ("machine", machine_alone)];
    for (half, other) in halves {
        let Some((pair, price)) = other else { continue };
        if *pair == before.0 || *pair == joint.0 {
            continue;
        }
        let limit = finished.budget.limit(price).map(|limit| match limit {
            Limit::Area => format!(", but with {:.3} mm² it is too large", finished.area(price)),
            Limit::FrameTime => {
                format!(", but with {} ms it is too slow", significant(price.frame_ms))
            }
            Limit::Both => ", but it is too large and too slow".into(),
            Limit::NoArea => ", without an area".into(),
        });
        lines.push(format!(
            "The joint {half} alone, {}, takes {}{}.",
            words::pair(finished, *pair),
            engineering(price.total_w, "W"),
            limit.unwrap_or_default()
        ));
    }
    lines.into_iter().map(Text::from).collect()
}

/// The five ways under other tables and on halves of the views.
fn stability(finished: &Finished) -> Table {
    let watts = finished.alternatives.iter().flat_map(|a| a.watts).flatten();
    let (per_watt, unit) = watt_unit(watts.fold(0.0, f64::max));
    let mut columns = vec![Column::text("energy table"), Column::text("views")];
    columns.extend(Way::ALL.map(|way| Column::fixed(format!("({}), {unit}", way.letter()), 2)));
    columns.push(Column::fixed("gain, %", 2));
    columns.push(Column::text("joint pair"));
    columns.push(Column::fixed("regret, %", 2));
    let row = |a: &powergs_codesign::stability::Alternative| -> Vec<Cell> {
        let mut cells: Vec<Cell> = vec![a.table.as_str().into(), a.views.into()];
        cells.extend(a.watts.map(|w| Cell::from(w.map(|w| per_watt * w))));
        let share = |w: Option<f64>, of: Option<f64>| w.zip(of).map(|(w, of)| 100.0 * w / of);
        cells.push(share(a.gain_w(), sequential(&a.watts)).into());
        cells.push(a.pair.map(|pair| words::pair(finished, pair)).into());
        cells.push(share(a.regret_w, a.watts[Way::Joint as usize]).into());
        cells
    };
    Table::new(columns).rows(finished.alternatives.iter().map(row))
}

fn holds(finished: &Finished) -> String {
    let gains: Vec<f64> = finished
        .alternatives
        .iter()
        .filter_map(|a| Some(100.0 * a.gain_w()? / sequential(&a.watts)?))
        .collect();
    let (low, high) = powergs_chart::ends(gains.iter().copied());
    if gains.is_empty() {
        return "Nowhere else do both (e) and one of (a) to (d) find a pair.".into();
    }
    let spread = high - low;
    let is_gain = |percent: f64| percent > 100.0 * NOISE;
    let verdict = match (is_gain(low), is_gain(high), low > spread) {
        (true, _, true) => "It is there in all of them and larger than its spread.",
        (true, _, false) => "It is there in all of them, and smaller than its spread.",
        (false, true, _) => "It is not there in all of them.",
        (false, false, _) => "It is there in none of them.",
    };
    format!(
        "Each row is searched anew, with the calibrated model of the DRAM; the area to keep to is \
         that of the base machine under its table. The gain of (e) over the best of (a) to (d) is \
         {low:.2} to {high:.2} %. {verdict} The regret is what the pair of the first row takes \
         beyond the best pair of the row; where it is missing, that pair does not keep the budget."
    )
}

/// Models that end with quality to spare: their display could be dimmer.
fn spare(finished: &Finished) -> Vec<Text> {
    let tuned = finished.models.iter().filter(|model| !model.point.is_dense && model.facts.passed);
    let spare = tuned.filter(|model| model.facts.margin_db > SPARE_DB);
    let names: Vec<String> = spare
        .map(|model| format!("{} ({:.1} dB)", model.point.name(), model.facts.margin_db))
        .collect();
    if names.is_empty() {
        return Vec::new();
    }
    let text = format!(
        "These models end with more than {SPARE_DB} dB to spare, so that their display could be \
         dimmer; more iterations (--iterations) spend that: {}.",
        names.join(", ")
    );
    vec![text.into()]
}

fn target(finished: &Finished) -> String {
    let [views, gate, test] = finished.about.views;
    let goal = match finished.target {
        Target::Likeness(q) if q.ssim > 0.0 => {
            format!("{:.2} dB and an SSIM of {:.4}", q.psnr_db, q.ssim)
        }
        Target::Likeness(q) => format!("{:.2} dB", q.psnr_db),
        Target::Hvsq(most) => format!("an HVSQ of {most:.3e}"),
    };
    format!(
        "Models reach {goal} against the renders of the dense model over {gate} of {views} views, \
         which decide; {test} test views are only reported. Each had at most {} and is read with \
         the numbers of its record, in training and here.",
        counted(finished.about.iterations, "iteration"),
    )
}
