//! The front of a sweep with `banked` in place of `calibrated`: sentences, a table, a file.

use super::measure::Measure;
use crate::document::{Block, Cell, Column, Document, Kind, Shown, Table, Text};
use crate::limits::signed_percent;
use powergs_base::format::counted;
use powergs_study::analysis::{Compared, Confirmation, Confirmed, Standing};

/// Columns that every table has; others where the models differ.
const ALWAYS: [&str; 3] = ["frame_time_ms.mean", "energy_pj.mean", "power_w.mean"];
/// Said by the frame time.
const IMPLIED: &str = "fps.mean";
/// Objectives that a table has besides.
const OTHERS: usize = 2;

/// What is said of it in terminals and on pages.
pub fn confirmation(all: &Confirmation) -> Document {
    let mut page = Document::new();
    if all.designs.is_empty() {
        return page;
    }
    page.heading("Confirmed with banked");
    page.paragraph(Text::named(&done(all)));
    let rest = [standings(all), orders(all)].concat().join(" ");
    page.paragraph(Text::strong(knee(all)).then(format!(" {rest}").trim_end()));
    for on in [Shown::Terminal, Shown::Page] {
        page.on(on, Block::Table(table(all, on)));
    }
    page.paragraph(Text::named(
        "A difference is what `calibrated` says too much (+) or too little (-) against `banked`. \
         All that is said of these designs above is said of their results with `banked`; others \
         have those of `calibrated` (column `dram_model`), which may be as far off.",
    ));
    page.page_paragraph(Text::marked("The same with exact numbers: `confirmed.csv` of the sweep."));
    page
}

fn done(all: &Confirmation) -> String {
    let n = counted(all.designs.len(), "design");
    let ranges: Vec<String> = ALWAYS.iter().filter_map(|column| range(all, column)).collect();
    let ranges = if ranges.is_empty() { String::new() } else { format!(": {}", ranges.join(", ")) };
    let traces = all.designs.iter().any(|design| design.traces.len() > 1);
    let worst = match traces {
        true => format!("; on a single trace the frame time differs by up to {}", {
            signed_percent(all.error()).replace('+', "")
        }),
        false => String::new(),
    };
    let front = all.designs.iter().filter(|d| d.standing == Standing::Front).count();
    let front = match front == all.front {
        true => format!("All {front} of the front are among them"),
        false => format!("{front} of the {} of the front are among them", all.front),
    };
    format!("{n} simulated again with `banked` in place of `calibrated`{ranges}{worst}. {front}.")
}

/// `frame time -0.4 % to +2.1 %`.
fn range(all: &Confirmation, column: &str) -> Option<String> {
    let differences = all.designs.iter().filter_map(|design| find(design, column)?.difference());
    let (low, high) = differences
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
    let (low, high) = (low <= high).then(|| (signed_percent(low), signed_percent(high)))?;
    let words = Measure::of(column).short();
    Some(if low == high { format!("{words} {low}") } else { format!("{words} {low} to {high}") })
}

fn knee(all: &Confirmation) -> String {
    let (before, knee) = (all.knee_before, all.knee);
    match knee == before {
        true => format!("The knee stays #{before}."),
        false => format!("The knee is #{knee}, with calibrated alone #{before}."),
    }
}

/// Who is no longer on the front, and why.
fn standings(all: &Confirmation) -> Vec<String> {
    let sentence = |(standing, one, several): (Standing, &str, &str)| {
        let of = |d: &&Confirmed| d.standing == standing;
        let names: Vec<String> =
            all.designs.iter().filter(of).map(|d| format!("#{}", d.point)).collect();
        let verb = if names.len() == 1 { one } else { several };
        (!names.is_empty()).then(|| format!("{} {verb}.", names.join(", ")))
    };
    let left: Vec<String> = [
        (Standing::Beaten, "is beaten by another design", "are beaten by other designs"),
        (Standing::Late, "misses the display rate", "miss the display rate"),
        (Standing::Unmet, "does not meet the condition", "do not meet the condition"),
        (Standing::Failed, "failed", "failed"),
    ]
    .into_iter()
    .filter_map(sentence)
    .collect();
    match (left.is_empty(), all.designs.len()) {
        (true, 1) => Vec::new(),
        (true, _) => vec!["All of them are on the front.".into()],
        (false, _) => left,
    }
}

/// How the order changes in each objective.
fn orders(all: &Confirmation) -> Vec<String> {
    let mut said = Vec::new();
    for order in &all.orders {
        let words = Measure::of(&order.objective).short();
        if order.swapped > 0 {
            let pairs = counted(order.pairs, "pair");
            said.push(format!("By {words}, {} of {pairs} change their order.", order.swapped));
        }
        if let (Some(best), Some(banked)) = (order.best, order.best_banked)
            && best != banked
        {
            said.push(format!("The best in {words} is #{banked}, no longer #{best}."));
        }
    }
    let pairs: usize = all.orders.iter().map(|order| order.pairs).sum();
    if said.is_empty() && pairs > 0 {
        said.push("No two of them change their order in any objective.".into());
    }
    said
}

fn find<'d>(design: &'d Confirmed, column: &str) -> Option<&'d Compared> {
    design.values.iter().find(|value| value.column == column)
}

/// The columns that are shown: what a design takes, then what else differs.
fn columns(all: &Confirmation) -> Vec<&str> {
    let differs = |column: &str| {
        let values = all.designs.iter().filter_map(|design| find(design, column));
        values.filter_map(Compared::difference).any(|share| share != 0.0)
    };
    let first = all.designs.first();
    let names = first.iter().flat_map(|d| &d.values).map(|value| value.column.as_str());
    let others = names.filter(|name| !ALWAYS.contains(name) && *name != IMPLIED && differs(name));
    ALWAYS.into_iter().chain(others.take(OTHERS)).collect()
}

fn table(all: &Confirmation, on: Shown) -> Table {
    let names = columns(all);
    let mut heads = vec![Column::text("design")];
    for name in &names {
        let words = Measure::of(name).short().replace(" per frame", "");
        if on == Shown::Page {
            heads.push(Column::count("calibrated").group(words.clone()));
        }
        heads.push(Column::count("banked").group(words.clone()));
        let percent = Kind::Real(|share| signed_percent(share).replace(" %", ""));
        heads.push(Column::new("±, %", percent).group(words));
    }
    let traces = traces(all, on);
    for trace in &traces {
        let percent = Kind::Real(|share| signed_percent(share).replace(" %", ""));
        heads.push(Column::new((*trace).to_owned(), percent).group("frame time by trace, ±, %"));
    }
    heads.push(Column::text("with banked").at_most(24));
    let row = |design: &Confirmed| {
        let knee = if design.point == all.knee_before { " knee" } else { "" };
        let mut cells: Vec<Cell> = vec![format!("#{}{knee}", design.point).into()];
        for name in &names {
            let value = find(design, name);
            let text = |x: Option<f64>| Cell::from(x.map(|x| Measure::of(name).text(x)));
            if on == Shown::Page {
                cells.push(text(value.and_then(|v| v.calibrated)));
            }
            cells.push(text(value.and_then(|v| v.banked)));
            cells.push(value.and_then(Compared::difference).into());
        }
        for trace in &traces {
            let found = design.traces.iter().find(|value| value.column == *trace);
            cells.push(found.and_then(Compared::difference).into());
        }
        cells.push(stands(all, design).into());
        cells
    };
    Table::new(heads).rows(all.designs.iter().map(row))
}

/// The traces that have columns of their own: all on a page, three on a terminal.
fn traces(all: &Confirmation, on: Shown) -> Vec<&str> {
    let most = if on == Shown::Page { usize::MAX } else { 3 };
    let of = |design: &'_ Confirmed| design.traces.len();
    match all.designs.first() {
        Some(design) if of(design) > 1 => {
            design.traces.iter().map(|value| value.column.as_str()).take(most).collect()
        }
        _ => Vec::new(),
    }
}

/// Where a design stands, in a few words.
fn stands(all: &Confirmation, design: &Confirmed) -> &'static str {
    match design.standing {
        Standing::Front if all.knee == design.point => "knee",
        Standing::Front => "front",
        Standing::Beaten => "beaten",
        Standing::Late => "misses the rate",
        Standing::Unmet => "condition not met",
        Standing::Failed => "failed",
    }
}

/// `confirmed.csv`: a row per design and column of the results, and of its frame time on each
/// trace.
/// `difference_frac` is what `calibrated` is above `banked`.
pub fn confirmed_csv(all: &Confirmation) -> Vec<u8> {
    let mut table =
        Table::record("point id standing trace column calibrated banked difference_frac");
    for design in &all.designs {
        let values = design.values.iter().map(|value| ("", value.column.as_str(), value));
        let traces = design.traces.iter().map(|v| (v.column.as_str(), ALWAYS[0], v));
        for (trace, column, value) in values.chain(traces) {
            table.row([
                design.point.into(),
                design.id.as_str().into(),
                design.standing.name().into(),
                trace.into(),
                column.into(),
                value.calibrated.into(),
                value.banked.into(),
                value.difference().into(),
            ]);
        }
    }
    table.csv()
}
