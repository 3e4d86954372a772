//! The page that decides: machines on traces at the rate of the display, in a table and a chart.

use super::page::Decided;
use crate::document::{Block, Cell, Column, Document, Kind, Shown, Table, Text};
use crate::format::{rate, shortened, significant};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Rule, Scale, Words};
use powergs_study::findings::compare::{
    AskedLimits, Basis, Comparison, Decision, DecisionRow, Measure, Shortfall, Side,
};
use powergs_study::findings::masters::MasterGets;

/// Powers that differ by less are the same.
const SAME: f64 = 0.005;
/// Characters of the name of a trace or a machine on a terminal.
const LABEL: usize = 16;
/// Characters of its task in brackets.
const TASK: usize = 12;
/// Machines in the chart, and bars in all.
const MOST: [usize; 2] = [8, 32];

/// The table, and what it comes to; `traces` are their names.
pub(super) fn add(
    page: &mut Document,
    all: &[Comparison],
    decided: Decided<'_>,
    traces: &[String],
) {
    let Decided { decision, limits } = decided;
    page.page_heading("Who meets what");
    page.table(table(all, decision, traces));
    let sides = &all[0].sides;
    let shown = sides.iter().any(|side| side.task.is_shown());
    if shown || decision.has_limits {
        page.paragraph(Text::marked(&format!("Asked for: {}.", asked(sides, limits))));
    }
    let gains: Vec<Text> = (1..sides.len()).filter_map(|i| gain(all, decision, i)).collect();
    let first = &sides[0];
    let meets = (0..decision.traces()).any(|trace| decision.row(trace, 0).is_met());
    if !meets && first.task.is_shown() {
        page.paragraph(format!(
            "{} meets what is asked for on no trace, so no power is compared with it.",
            first.label
        ));
    }
    page.add(Block::List(gains));
}

/// What is asked of every side, in words.
fn asked(sides: &[Side], limits: &AskedLimits) -> String {
    let shown = sides.iter().find(|side| side.task.is_shown());
    let each = shown.map(|first| match one_rate(sides) {
        true => format!("a frame each {} ms", significant(1e3 / first.display_fps)),
        false => "a frame each period of its own display".to_owned(),
    });
    let parts = [
        each,
        limits.budget_w.map(|w| format!("at most {} W", significant(w))),
        limits.latency_ms.map(|ms| format!("at most {} ms from begin to end", significant(ms))),
        limits.condition.as_ref().map(|condition| format!("`{}`", condition.text())),
    ];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

/// Whether all that is shown is shown at one rate.
fn one_rate(sides: &[Side]) -> bool {
    let mut shown = sides.iter().filter(|side| side.task.is_shown()).map(|side| side.display_fps);
    let first = shown.next();
    shown.all(|fps| Some(fps) == first)
}

/// What the column of powers is of: where a machine misses the display rate, of what it reaches.
fn power_head(all: &[Comparison]) -> String {
    let sides = &all[0].sides;
    let Some(first) = sides.iter().find(|side| side.task.is_shown()) else { return "W".into() };
    let mut every = all.iter().flat_map(|comparison| &comparison.sides);
    let misses = every.any(|side| side.task.is_shown() && !side.reaches_display());
    match (one_rate(sides), misses) {
        (true, false) => format!("W at {} FPS", rate(first.display_fps)),
        (true, true) => format!("W at ≤ {} FPS", rate(first.display_fps)),
        (false, _) => "W at own rate".into(),
    }
}

/// What a machine saves where both it and the first one meet everything.
fn gain(all: &[Comparison], decision: &Decision, side: usize) -> Option<Text> {
    let (first, own) = (&all[0].sides[0], &all[0].sides[side]);
    let both_shown = first.task.is_shown() && own.task.is_shown();
    // Of one node and scope: rates are looked at trace by trace.
    let is_comparable = all.iter().all(|c| c.row(Measure::Energy).is_comparable[side]);
    if !both_shown || !is_comparable || first.display_fps != own.display_fps {
        return None;
    }
    let of = decision.traces();
    let (fps, label) = (rate(first.display_fps), first.label.as_str());
    let (gain, on) = decision.power_gain(side)?;
    let times = match gain >= 1.0 {
        _ if (gain - 1.0).abs() < SAME => format!("the power of {label}"),
        true => format!("{} times less power than {label}", significant(gain)),
        false => format!("{} times the power of {label}", significant(1.0 / gain)),
    };
    let on = match (on, of) {
        (_, 1) => String::new(),
        (on, of) => format!(", on the {on} of {of} traces that both meet"),
    };
    let text = format!(": {times} at {fps} FPS{on}");
    Some(Text::strong(own.label.clone()).then(text))
}

/// Who meets what: a row a trace and machine.
pub fn table(all: &[Comparison], decision: &Decision, traces: &[String]) -> Table {
    let tasks_differ = all[0].task().is_none();
    let is_shown = all[0].sides.iter().any(|side| side.task.is_shown());
    let has_verdict = is_shown || decision.has_limits;
    let per_second = all[0].task().map_or("per second", |task| task.per_second());
    let power = power_head(all);
    // Frames that overlap are there later than the next one begins.
    let is_late = |row: &DecisionRow| {
        row.latency_ms
            .zip(row.slowest_ms)
            .is_some_and(|(latency, slowest)| latency > 1.001 * slowest)
    };
    let is_late = decision.rows.iter().any(is_late);
    let mut columns = Vec::new();
    if traces.len() > 1 {
        columns.push(Column::text("trace").at_most(LABEL));
    }
    columns.push(Column::text("machine").at_most(LABEL + if tasks_differ { TASK } else { 0 }));
    columns.extend([per_second, "slowest, ms"].map(Column::real));
    if is_late {
        columns.push(Column::real("latency, ms"));
    }
    columns.push(Column::real(&power));
    if has_verdict {
        columns.push(Column::text("verdict"));
    }
    // On all traces a die is the same: those of each trace have it too.
    let die = Column::real("die, mm²");
    columns.push(if traces.len() > 1 { die.on(Shown::Page) } else { die });
    let row = |row: &DecisionRow| {
        let side = &all[row.trace].sides[row.side];
        let mut cells: Vec<Cell> = Vec::new();
        if traces.len() > 1 {
            cells.push(traces[row.trace].as_str().into());
        }
        let machine = match tasks_differ {
            true => format!("{} ({})", shortened(&side.label, LABEL), side.task.short()),
            false => side.label.clone(),
        };
        cells.push(machine.into());
        cells.extend([row.fps, row.slowest_ms].map(Cell::from));
        if is_late {
            cells.push(row.latency_ms.into());
        }
        cells.push(power_of(row, side, is_shown).into());
        if has_verdict {
            cells.push(verdict(row, side, decision.has_limits).unwrap_or("-".into()).into());
        }
        cells.push(row.area_mm2.into());
        cells
    };
    Table::new(columns).rows(decision.rows.iter().map(row))
}

/// Power in watts, as the head of its column says: that of steps is at no display rate, and stands
/// beside none.
fn power_of(row: &DecisionRow, side: &Side, is_shown: bool) -> Option<f64> {
    row.power_w.filter(|_| side.task.is_shown() == is_shown)
}

/// Whether a machine will do, and where not, why; `None` where nothing is asked of it.
pub(super) fn verdict(row: &DecisionRow, side: &Side, has_limits: bool) -> Option<String> {
    if row.is_met() {
        return (side.task.is_shown() || has_limits).then(|| "meets all".to_owned());
    }
    let short = |short: &Shortfall| match short {
        Shortfall::NoTime => "no time".to_owned(),
        Shortfall::Rate { missed } => format!("MISSED {missed}/{}", row.frames),
        Shortfall::Budget { budget } => format!("OVER {} W", significant(*budget)),
        Shortfall::Latency { ms } => format!("LATE {} ms", significant(*ms)),
        Shortfall::Condition => "NOT --where".to_owned(),
        Shortfall::Starved(MasterGets { gets, asks, .. }) => {
            format!("STARVES {} of {} GB/s", significant(*gets), significant(*asks))
        }
    };
    Some(row.short.iter().map(short).collect::<Vec<_>>().join(", "))
}

/// What a bar shows of a machine on a trace.
type RowValue<'a> = dyn Fn(&DecisionRow, &Side) -> Option<f64> + 'a;

/// Slowest frames and powers of machines over traces, with the lines that they may not pass.
pub fn chart(all: &[Comparison], decided: Decided<'_>, traces: &[String]) -> Chart {
    let Decided { decision, limits } = decided;
    let sides = &all[0].sides[..all[0].sides.len().min(MOST[0])];
    let shown = traces.len().min((MOST[1] / sides.len()).max(1));
    let first = &sides[0];
    let period = 1e3 / first.display_fps;
    let is_shown = sides.iter().any(|side| side.task.is_shown());
    let panel = |of: &RowValue<'_>, title: &str, line: Option<f64>| {
        let mut bars = Vec::new();
        let mut highest: f64 = line.unwrap_or(0.0);
        for trace in 0..shown {
            for (i, colour) in (0..sides.len()).zip(Colour::SERIES.iter().cycle()) {
                let row = decision.row(trace, i);
                let Some(value) = of(row, &sides[i]) else { continue };
                highest = highest.max(value);
                let bar = Bar::new(trace, vec![Part::new(value, *colour)]);
                bars.push(Bar { lane: (i, sides.len()), ..bar.end(significant(value)) });
            }
        }
        let names = traces[..shown].iter().map(|trace| Words::from(shortened(trace, 24)));
        let x = Axis::new(title, Scale::from_zero(1.12 * highest)).ticks(5);
        let panel = Panel::new(x, Axis::names(names)).mark(Mark::Bars(bars));
        match line {
            Some(at) => panel.dashed(Rule::X(at), Colour::VERMILION),
            None => panel,
        }
    };
    let time = panel(
        &|row, _| row.slowest_ms,
        "slowest frame, ms",
        Some(period).filter(|_| is_shown && one_rate(sides)),
    );
    let watts = power_head(all).replacen('W', "power, W", 1);
    let mut power = panel(&|row, side| power_of(row, side, is_shown), &watts, limits.budget_w);
    power.y = power.y.hidden();
    let entries = all[0].labels_with_nodes().into_iter().zip(Colour::SERIES.iter().cycle());
    let entries = entries.take(sides.len()).map(|(label, colour)| Entry::fill(label, *colour));
    let line = (is_shown && one_rate(sides))
        .then(|| Entry::note(format!("left line: {} ms", significant(period))));
    let budget = limits.budget_w.map(|w| Entry::note(format!("right line: {} W", significant(w))));
    let frames = all.iter().map(|c| c.sides[0].frames).sum::<u64>();
    let counted = first.shown.counted(frames);
    let subtitle = match (traces.len(), shown < traces.len()) {
        (1, _) => format!("{}, {counted}", traces[0]),
        (n, false) => format!("{n} traces, {counted}"),
        (n, true) => format!("the first {shown} of {n} traces"),
    };
    Chart::new("decision", "Slowest frames and power", subtitle)
        .legend(entries.chain(line).chain(budget))
        .columns(2)
        .panel(time)
        .panel(power)
}

/// A part of the basis, with what it is of each side.
type BasisRow = (Basis, Vec<Option<String>>);

/// What is not the same on all sides of what their numbers are of, a column a side.
pub(super) fn basis_table(comparison: &Comparison, rows: Vec<BasisRow>) -> Table {
    let columns = super::page::columns("not the same", Kind::Text, &comparison.sides);
    let row = |(part, values): BasisRow| {
        let cells = values.into_iter().map(|value| Cell::from(value.unwrap_or_else(|| "?".into())));
        [Cell::from(words(part))].into_iter().chain(cells).collect::<Vec<_>>()
    };
    Table::new(columns).rows(rows.into_iter().map(row))
}

/// The same line by line, each value with the sides that have it.
pub(super) fn basis_facts(comparison: &Comparison, rows: &[BasisRow]) -> Vec<(String, Text)> {
    let labels = comparison.labels();
    let fact = |(part, values): &BasisRow| {
        let mut seen: Vec<(&str, Vec<&str>)> = Vec::new();
        for (value, label) in values.iter().zip(&labels) {
            let value = value.as_deref().unwrap_or("?");
            match seen.iter_mut().find(|(known, _)| *known == value) {
                Some((_, sides)) => sides.push(label),
                None => seen.push((value, vec![label])),
            }
        }
        let each = seen.iter().map(|(value, sides)| format!("{value} ({})", sides.join(", ")));
        (words(*part).to_owned(), Text::from(each.collect::<Vec<_>>().join("; ")))
    };
    rows.iter().map(fact).collect()
}

/// What a part of the basis is called.
const fn words(part: Basis) -> &'static str {
    match part {
        Basis::Task => "task",
        Basis::Step => "numbers of a step",
        Basis::Memory => "memory",
        Basis::MemoryModel => "model of the memory",
        Basis::MemoryPrice => "price of the memory",
        Basis::Phy => "PHY of the memory",
        Basis::Masters => "other masters",
        Basis::Node => "node",
        Basis::PriceClock => "clock of the prices",
        Basis::AreaScope => "area is of",
        Basis::PowerScope => "power is of",
    }
}
