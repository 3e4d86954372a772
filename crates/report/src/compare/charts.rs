//! Charts of a comparison: power side by side, and where the cycles go on each side; over several
//! traces, where the energy goes.

use crate::charts::{
    component_colour, component_entries, cycles_axis, cycles_bar, cycles_colours, cycles_entries,
};
use crate::format::{engineering, shortened, significant};
use powergs_chart::{Axis, Bar, Chart, Colour, Entry, Mark, Panel, Part, Rule, Scale, Words};
use powergs_core::stage::{hardware, stage};
use powergs_energy::action::{Phase, StageId};
use powergs_energy::{Component, Standby};
use powergs_study::findings::Key;
use powergs_study::findings::compare::{Comparison, Measure, Side};

/// Sides in one chart; a slide has no room for more.
const MOST: usize = 8;
/// Bars over traces in one chart.
const MOST_ROWS: usize = 24;

/// All charts that the sides have data for; `budget_w` is a line where powers are, watts.
pub fn charts(comparison: &Comparison, budget_w: Option<f64>) -> Vec<Chart> {
    let sides = &comparison.sides[..comparison.sides.len().min(MOST)];
    let labels = comparison.labels_with_nodes();
    let subtitle = subtitle(comparison);
    let mut charts = vec![power(sides, &labels, subtitle.clone(), budget_w)];
    if sides.iter().all(|s| s.statistics.has_time()) {
        charts.push(cycles(sides, subtitle));
    }
    let trace = std::slice::from_ref(&comparison.sides[0].trace);
    charts.extend(steps(std::slice::from_ref(comparison), trace));
    charts
}

fn subtitle(comparison: &Comparison) -> String {
    let shown = comparison.sides.len().min(MOST);
    let of = if shown < comparison.sides.len() {
        format!("the first {shown} of {} sides, ", comparison.sides.len())
    } else {
        String::new()
    };
    let side = &comparison.sides[0];
    format!("{of}{}, mean of {}", side.trace, side.shown.at_rate(side.frames, side.display_fps))
}

/// Watts of what is paid for work: a part of the energy of a frame, as often as frames are shown.
fn watts(side: &Side, energy: Key) -> f64 {
    known(side, energy) * 1e-12 * side.statistics.displayed_fps()
}

/// Power at the display rate, by component.
fn component_w(side: &Side, component: Component) -> f64 {
    match Standby::COMPONENTS.contains(&component) {
        true => known(side, Key::PowerOf(component)),
        false => watts(side, Key::EnergyOf(component)),
    }
}

fn power(sides: &[Side], labels: &[String], subtitle: String, budget_w: Option<f64>) -> Chart {
    let rate = crate::format::rate(sides[0].display_fps);
    let component = |side: &Side| {
        Component::ALL.map(|c| Part::new(component_w(side, c), component_colour(c))).to_vec()
    };
    let stage = |side: &Side| {
        let watts = |stage: Phase| match stage {
            Phase::Standby => Standby::COMPONENTS.iter().map(|c| component_w(side, *c)).sum(),
            _ => watts(side, Key::EnergyIn(stage)),
        };
        Phase::ALL.map(|s| Part::new(watts(s), stage_colour(s))).to_vec()
    };
    let rows = ChartRows { labels, unit: &format!("W at {rate} FPS"), budget_w };
    let missed = |side: &Side| side.statistics.deadline_misses() > Some(0);
    let left = panel(sides, &rows, &component, "by component");
    let mut right = panel(sides, &rows, &stage, "by stage");
    right.y = right.y.hidden();
    let stages = Phase::ALL.map(|s| Entry::fill(s.name(), stage_colour(s)));
    let subtitle = match sides.iter().any(missed) {
        true => format!("{subtitle}; who misses the rate draws what it draws at full rate"),
        false => subtitle,
    };
    let budget = budget_w.map(|w| Entry::note(format!("line: budget {} W", significant(w))));
    Chart::new("power", "Power at the display rate", subtitle)
        .legend([Entry::note("by component:")].into_iter().chain(component_entries()))
        .legend([Entry::note("by stage:")].into_iter().chain(stages).chain(budget))
        .columns(2)
        .panel(left)
        .panel(right)
}

/// Rows of the chart of energies.
#[derive(Default)]
struct BreakdownRows {
    names: Vec<String>,
    by_component: Vec<Bar>,
    by_stage: Vec<Bar>,
}

impl BreakdownRows {
    /// A machine on a trace, its parts as `share` has them.
    fn add(&mut self, name: String, end: &str, share: &dyn Fn(Key) -> f64) {
        let row = self.names.len();
        let part = |c| Part::new(share(Key::EnergyOf(c)), component_colour(c));
        let bar = Bar::new(row, Component::ALL.map(part).to_vec());
        self.by_component.push(bar.end(end));
        let part = |s| Part::new(share(Key::EnergyIn(s)), stage_colour(s));
        self.by_stage.push(Bar::new(row, Phase::ALL.map(part).to_vec()).end(end));
        self.names.push(name);
    }

    /// A panel by component, and one by stage.
    fn panels(self, axis: &Axis, what: &str, rule: Option<f64>) -> [Panel; 2] {
        let names = self.names;
        let panel = |bars: Vec<Bar>, heading: &str| {
            let y = Axis::names(names.iter().map(String::as_str));
            let panel = Panel::new(axis.clone().ticks(5), y);
            let panel = panel.heading(Words::bold(format!("{heading}{what}")));
            let panel = match rule {
                Some(at) => panel.dashed(Rule::X(at), Colour::NOTE),
                None => panel,
            };
            panel.mark(Mark::Bars(bars))
        };
        let left = panel(self.by_component, "by component");
        let mut right = panel(self.by_stage, "by stage");
        right.y = right.y.hidden();
        [left, right]
    }
}

/// Energy per frame of machines over traces, the first machine of each trace being 1; by component
/// and by stage. The energy of machines of another technology node is no multiple of that: they
/// have panels of their own, with the shares of each and its joules.
pub fn breakdown(all: &[Comparison], traces: &[String]) -> Chart {
    let machines = all[0].sides.len().min(MOST);
    let shown = traces.len().min((MOST_ROWS / machines).max(1));
    let (mut same, mut others) = (BreakdownRows::default(), BreakdownRows::default());
    let mut highest = 0.0_f64;
    for (comparison, trace) in all.iter().zip(traces).take(shown) {
        let labels = comparison.labels_with_nodes();
        let first = comparison.sides[0].statistics.value(Key::Energy);
        for (i, side) in comparison.sides.iter().take(machines).enumerate() {
            let name = format!("{}: {}", shortened(trace, 20), shortened(&labels[i], 20));
            let own = side.statistics.value(Key::Energy);
            if comparison.row(Measure::Energy).is_comparable[i] {
                highest = highest.max(own / first);
                let end = format!("{:.2}", own / first);
                same.add(name, &end, &|key| known(side, key) / first);
            } else {
                let end = engineering(own * 1e-12, "J");
                others.add(name, &end, &|key| 100.0 * known(side, key) / own);
            }
        }
    }
    let subtitle = match shown < traces.len() {
        true => format!("the first {shown} of {} traces", traces.len()),
        false => format!("{} traces", traces.len()),
    };
    let stages = Phase::ALL.map(|s| Entry::fill(s.name(), stage_colour(s)));
    let chart = Chart::new("breakdown", "Energy per frame over the traces", subtitle)
        .legend([Entry::note("by component:")].into_iter().chain(component_entries()))
        .legend([Entry::note("by stage:")].into_iter().chain(stages))
        .columns(2);
    let one = &all[0].sides[0].label;
    let axis = Axis::new(format!("energy per frame, {one} = 1"), Scale::from_zero(highest));
    let panels = same.panels(&axis, "", Some(1.0));
    let chart = panels.into_iter().fold(chart, Chart::panel);
    if others.names.is_empty() {
        return chart;
    }
    let axis = Axis::new("share of its own energy per frame, %", Scale::from_zero(100.0));
    let panels = others.panels(&axis, ", other technology nodes", None);
    panels.into_iter().fold(chart, Chart::panel)
}

/// Where the steps of machines go, trace by trace; `None` where none trains or tracks.
pub fn steps(all: &[Comparison], traces: &[String]) -> Option<Chart> {
    let mut rows = Vec::new();
    for (comparison, trace) in all.iter().zip(traces) {
        for (label, parts) in crate::steps::of_sides(&comparison.sides) {
            let name = match traces.len() {
                1 => shortened(label, 24),
                _ => format!("{}: {}", shortened(trace, 20), shortened(label, 20)),
            };
            rows.push((name, parts));
        }
    }
    let shown = rows.len().min(MOST_ROWS);
    let subtitle = match shown < rows.len() {
        true => format!("the first {shown} of {} machines on traces", rows.len()),
        false if traces.len() == 1 => traces[0].clone(),
        false => format!("{} traces", traces.len()),
    };
    rows.truncate(shown);
    crate::steps::chart(&rows, subtitle)
}

/// What an older report does not say is not drawn.
fn known(side: &Side, key: Key) -> f64 {
    side.statistics.mean(key).unwrap_or(0.0)
}

fn stage_colour(stage: Phase) -> Colour {
    match stage {
        Phase::Preprocessing => Colour::GREEN,
        Phase::Sorting => Colour::INDIGO,
        Phase::Rendering => Colour::VERMILION,
        Phase::Standby => Colour::PALE,
    }
}

/// What the rows of a panel are called, and what they are measured in.
struct ChartRows<'a> {
    labels: &'a [String],
    unit: &'a str,
    budget_w: Option<f64>,
}

/// Stacked bars with their sums.
fn panel(
    sides: &[Side],
    rows: &ChartRows<'_>,
    parts: &dyn Fn(&Side) -> Vec<Part>,
    heading: &str,
) -> Panel {
    let bars: Vec<Bar> = sides
        .iter()
        .enumerate()
        .map(|(i, side)| {
            let parts = parts(side);
            let sum: f64 = parts.iter().map(|p| p.value).sum();
            Bar::new(i, parts).end(significant(sum))
        })
        .collect();
    let sum = |bar: &Bar| bar.parts.iter().map(|p| p.value).sum::<f64>();
    let highest = bars.iter().map(sum).chain(rows.budget_w).fold(0.0, f64::max);
    let x = Axis::new(rows.unit, Scale::from_zero(highest)).ticks(5);
    let names = rows.labels.iter().take(sides.len()).map(String::as_str);
    let panel = Panel::new(x, Axis::names(names)).heading(Words::bold(heading));
    let panel = match rows.budget_w {
        Some(watts) => panel.dashed(Rule::X(watts), Colour::VERMILION),
        None => panel,
    };
    panel.mark(Mark::Bars(bars))
}

/// A panel for every kind of unit.
fn cycles(sides: &[Side], subtitle: String) -> Chart {
    let is_drawn = |cause| sides.iter().any(|side| side.statistics.has_cause(cause));
    let entries = cycles_entries(is_drawn);
    let chart = Chart::new("cycles", "Where the cycles go", subtitle).legend(entries);
    let has = |unit: &StageId| {
        sides.iter().any(|side| side.statistics.mean(Key::Instances(*unit)).is_some())
    };
    let units: Vec<StageId> = hardware().units().map(|(id, _)| id).filter(has).collect();
    units.iter().enumerate().fold(chart, |chart, (u, &unit)| {
        // Machines without such units have no row.
        let own = sides.iter().filter(|side| side.statistics.mean(Key::Instances(unit)).is_some());
        let own: Vec<&Side> = own.collect();
        let bar = |(i, side): (usize, &&Side)| {
            let shares = side.statistics.unit_shares(unit);
            cycles_bar(i, shares.into_iter().zip(cycles_colours()))
        };
        let bars: Vec<Bar> = own.iter().enumerate().map(bar).collect();
        let x = if u + 1 < units.len() { cycles_axis().hidden() } else { cycles_axis() };
        let mut y = Axis::names(own.iter().map(|s| s.label.as_str()));
        y.title = stage(unit).key.into();
        chart.panel(Panel::new(x, y).mark(Mark::Bars(bars)))
    })
}
