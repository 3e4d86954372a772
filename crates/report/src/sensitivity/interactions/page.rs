//! The experiment for people.

use super::sample;
use crate::document::{Cell, Column, Document, Kind, Shown, Table, Text};
use crate::format::significant;
use crate::sensitivity::page::ending;
use powergs_chart::Chart;
use powergs_study::analysis::indices::{Estimate, Index};
use powergs_study::findings::sensitivity::Measure;
use powergs_study::findings::sensitivity::interactions::{Interactions, Results};

/// Measures on the terminal; the page has all.
const SHOWN: [Measure; 3] = [Measure::Fps, Measure::Energy, Measure::Area];

/// What is printed, and the page with `charts` beside it, both to be put below those of single
/// keys. `folder` is where the page is.
pub fn document(all: &Interactions, charts: &[Chart], folder: Option<&str>) -> Document {
    let mut page = Document::new();
    page.title(format!("How keys of {} act together", all.machine));
    if let Some(note) = all.incomplete_note() {
        page.paragraph(Text::strong(note));
    }
    let method = match all.results {
        Results::Morris(_) => "Elementary effects after Morris",
        Results::Sobol(_) => "Sobol indices",
    };
    let names: Vec<&str> = all.traces.iter().map(|t| t.name.as_str()).collect();
    page.paragraph(format!("{method} on {}: {}.", names.join(", "), sample(all)));
    if all.redrawn > 0 {
        page.page_paragraph(DRAWN_AGAIN);
    }
    page.charts(charts);
    page.table(table(all));
    page.paragraph(format!("{}.", reading(all).trim_end_matches('.').replace("mu*", "μ*")));
    ending(&mut page, folder);
    page
}

const DRAWN_AGAIN: &str = "Keys are independent only as far as configurations are valid: samples \
with a point that is none were drawn again.";

/// Every key with its effects or indices, a group of columns a measure.
fn table(all: &Interactions) -> Table {
    let mut columns = vec![
        Column::text("file").on(Shown::Page),
        Column::text("key").at_most(28),
        Column::text("value").on(Shown::Page),
        Column::text("levels").on(Shown::Page),
        Column::text("levels").at_most(16).on(Shown::Terminal),
    ];
    let percent = |x: f64| if x.abs() < 0.05 { "0".to_owned() } else { significant(x) };
    let groups: &[(&str, Shown)] = match &all.results {
        Results::Morris(_) => {
            &[("μ", Shown::Page), ("μ*", Shown::Everywhere), ("σ", Shown::Everywhere)]
        }
        Results::Sobol(_) => &[
            ("first", Shown::Terminal),
            ("total", Shown::Terminal),
            ("first", Shown::Page),
            ("total", Shown::Page),
        ],
    };
    let measures: Vec<Measure> = match &all.results {
        Results::Morris(found) => found.iter().map(|(m, _)| *m).collect(),
        Results::Sobol(found) => found.iter().map(|(m, _)| *m).collect(),
    };
    for m in &measures {
        for (head, shown) in groups {
            let is_left_out = *shown == Shown::Terminal && !SHOWN.contains(m);
            let shown = match *shown {
                Shown::Everywhere if !SHOWN.contains(m) => Shown::Page,
                shown => shown,
            };
            if !is_left_out {
                let column = Column::new(*head, Kind::Real(percent));
                columns.push(column.group(m.name()).on(shown));
            }
        }
    }
    let mut table = Table::new(columns);
    for i in all.order() {
        let f = &all.factors[i];
        let mut cells: Vec<Cell> = vec![
            f.file.into(),
            Text::code(f.key.clone()).into(),
            f.value.as_str().into(),
            f.levels.join(", ").into(),
            f.range().into(),
        ];
        match &all.results {
            Results::Morris(found) => {
                let effects = found.iter().map(|(_, e)| e[i]);
                cells.extend(effects.flat_map(|e| [e.mu, e.mu_star, e.sigma]).map(Cell::Real));
            }
            Results::Sobol(found) => {
                for (m, indices) in found {
                    let Index { first, total } = &indices.each[i];
                    if SHOWN.contains(m) {
                        cells.extend([share(first), share(total)].map(Cell::from));
                    }
                    cells.extend([interval(first), interval(total)].map(Cell::from));
                }
            }
        }
        table.row(cells);
    }
    table
}

/// What is 0 up to its sampling error may be below it.
fn share(e: &Estimate) -> String {
    let value = if e.value.abs() < 0.005 { 0.0 } else { e.value };
    format!("{value:.2}")
}

/// `0.62 (0.55 to 0.70)`.
fn interval(e: &Estimate) -> String {
    format!("{} ({:.2} to {:.2})", share(e), e.low, e.high)
}

/// What the numbers say as a whole.
fn reading(all: &Interactions) -> String {
    match &all.results {
        Results::Morris(_) => "mu* is the size of a key's effect over its levels, sigma how much \
            it depends on the others (or bends), in % of the machine as it is"
            .into(),
        Results::Sobol(found) => {
            let share = |m: Measure| {
                let (_, indices) = found.iter().find(|(other, _)| *other == m)?;
                let varies = indices.each.iter().any(|i| i.total.value > 0.0);
                varies.then(|| format!("{} {}", m.name(), interval(&indices.alone)))
            };
            let shares: Vec<String> = SHOWN.into_iter().filter_map(share).collect();
            let shares = shares.join(", ");
            format!("share of the variance that keys explain alone (95 % interval): {shares}")
        }
    }
}
