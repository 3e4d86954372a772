//! Where the energy or the power goes along the front: a stacked bar per design.

use super::measure::Measure;
use super::words;
use crate::charts::{component_colour, component_entries};
use powergs_chart::{Axis, Bar, Chart, Mark, Panel, Part, Scale, Words};
use powergs_energy::Component;
use powergs_study::analysis::Analysis;

const NAME: &str = "energy_front";
/// Bars that a slide has room for.
const MOST: usize = 16;

/// What the bars are parts of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Whole {
    /// The energy of a frame at full rate.
    Energy,
    /// The power at the display rate.
    Power,
}

impl Whole {
    /// What was asked for: of several objectives the first that is either. The order of the bars
    /// would contradict their lengths otherwise: standby counts all the time in one of them.
    fn of(analysis: &Analysis) -> Whole {
        let all = analysis.question.objectives.iter();
        let mut known = all.filter_map(|objective| match objective.name.split('.').next() {
            Some("power_w") => Some(Whole::Power),
            Some("energy_pj") => Some(Whole::Energy),
            Some(_) | None => None,
        });
        known.next().unwrap_or(Whole::Energy)
    }

    /// Its columns, up to the dot.
    fn column(self) -> &'static str {
        match self {
            Whole::Energy => "energy_pj",
            Whole::Power => "power_w",
        }
    }

    fn title(self) -> &'static str {
        match self {
            Whole::Energy => "Energy per frame at full rate, along the Pareto front",
            Whole::Power => "Power at the display rate, along the Pareto front",
        }
    }
}

/// The parts of a bar, in the unit of the results.
type FrontParts = [f64; Component::ALL.len()];

/// The chart; `None` where the results have no parts of the energy.
pub fn chart(analysis: &Analysis) -> Option<Chart> {
    let rows = shown(analysis);
    let parts_of = |whole: Whole| -> Option<Vec<FrontParts>> {
        rows.iter().map(|&row| parts(analysis, whole, row)).collect()
    };
    // Results of before have no parts of the power.
    let asked = Whole::of(analysis);
    let (whole, parts) = match parts_of(asked) {
        Some(parts) => (asked, parts),
        None => (Whole::Energy, parts_of(Whole::Energy)?),
    };
    let first = Measure::of(&analysis.question.objectives[0].name).words;
    let all = analysis.front.len();
    let on = |row: &&u32| analysis.front.contains(row);
    let shown = rows.iter().filter(on).count();
    let which = match shown < all {
        true => format!("{shown} of the {all} designs"),
        false if all == 1 => "the one design".to_owned(),
        false => format!("all {all} designs"),
    };
    let subtitle = format!(
        "{which} on the Pareto front, the best in {first} first; {}, {}",
        analysis.question.scope,
        words::prices(analysis)
    );
    let chart = Chart::new(NAME, whole.title(), subtitle).legend(component_entries());
    Some(chart.panel(panel(analysis, whole, &rows, &parts)))
}

/// The named design, then designs of the front in equal steps, the knee among them.
fn shown(analysis: &Analysis) -> Vec<u32> {
    let named = analysis.named.as_ref().map(|n| n.row).filter(|r| !analysis.front.contains(r));
    let mut rows: Vec<u32> = named.into_iter().collect();
    rows.extend(spread(&analysis.front, MOST - rows.len(), analysis.knee));
    rows
}

/// At most `most` of `rows` in equal steps, with both ends and `must`.
pub fn spread(rows: &[u32], most: usize, must: u32) -> Vec<u32> {
    if rows.len() <= most {
        return rows.to_vec();
    }
    let must = rows.iter().position(|r| *r == must);
    let last = rows.len() - 1;
    let mut places: Vec<usize> = (0..most).map(|i| i * last / (most - 1)).collect();
    if let Some(must) = must.filter(|m| !places.contains(m)) {
        let near = (1..most - 1).min_by_key(|i| places[*i].abs_diff(must)).unwrap_or(0);
        places[near] = must;
    }
    places.into_iter().map(|i| rows[i]).collect()
}

fn parts(analysis: &Analysis, whole: Whole, row: u32) -> Option<FrontParts> {
    let mut parts = FrontParts::default();
    for (part, component) in parts.iter_mut().zip(Component::ALL) {
        let column = format!("{}.{}", whole.column(), component.name());
        *part = analysis.table.number(&column, row)?;
    }
    Some(parts)
}

fn panel(analysis: &Analysis, whole: Whole, rows: &[u32], parts: &[FrontParts]) -> Panel {
    let sum = |p: &FrontParts| p.iter().sum::<f64>();
    let largest = parts.iter().map(sum).fold(0.0, f64::max);
    let (factor, name) = Measure::of(&format!("{}.mean", whole.column())).axis(largest);
    let part = |(value, c): (&f64, Component)| Part::new(value * factor, component_colour(c));
    let bar = |(i, parts): (usize, &FrontParts)| {
        Bar::new(i, parts.iter().zip(Component::ALL).map(part).collect())
    };
    let name_of = |&row: &u32| {
        let label = analysis.table.label(row);
        if row == analysis.knee {
            Words::bold(format!("{} {label}", words::knee_name(analysis)))
        } else {
            label.into()
        }
    };
    let x = Axis::new(name, Scale::from_zero(largest * factor));
    let facts = |(i, &row): (usize, &u32)| {
        (i as f64 + 0.5, vec![Words::note(others(analysis, whole, row))])
    };
    let mut panel = Panel::new(x, Axis::names(rows.iter().map(name_of)))
        .mark(Mark::Bars(parts.iter().enumerate().map(bar).collect()));
    panel.right = rows.iter().enumerate().map(facts).collect();
    panel
}

/// The objectives that the bars do not show.
fn others(analysis: &Analysis, whole: Whole, row: u32) -> String {
    let mut all = Vec::new();
    for (j, o) in analysis.question.objectives.iter().enumerate() {
        if !o.name.starts_with(whole.column()) {
            all.push(Measure::of(&o.name).text(analysis.value(j, row)));
        }
    }
    if all.is_empty() { words::settings(analysis, row) } else { all.join(", ") }
}
