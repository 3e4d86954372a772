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
    page.heading("The front, confirmed");
    page.paragraph(Text::named(&done(all)));
    let rest = [standings(all), orders(all)].concat().join(" ");
    page.paragraph(Text::strong(knee(all)).then(format!(" {rest}").trim_end()));
    for on in [Shown::Terminal, Shown::Page] {
        page.on(on, Block::Table(table(all, on)));
    }
    page.paragraph(Text::named(
        "A difference is what `calibrated` says too much (+) or too little (-) against `banked`. \
         Only these designs were confirmed: what is not on the front of `calibrated` was not \
         looked at.",
    ));
    page.page_paragraph(Text::marked("The same with exact numbers: `confirmed.csv` of the sweep."));
    page
}

fn done(all: &Confirmation) -> String {
    let n = all.designs.len();
    let what = match (n, all.front) {
        (1, 1) => "The only design of the front".to_owned(),
        (1, _) => format!("The knee of the {} designs of the front", all.front),
        (n, front) if n == front => format!("All {n} designs of the front"),
        (n, front) => {
            format!("The knee and its neighbours along the front ({n} of {front} designs)")
        }
    };
    let verb = if n == 1 { "was" } else { "were" };
    let ranges: Vec<String> = ALWAYS.iter().filter_map(|column| range(all, column)).collect();
    let ranges = if ranges.is_empty() { String::new() } else { format!(": {}", ranges.join(", ")) };
    format!("{what} {verb} simulated again with `banked` in place of `calibrated`{ranges}.")
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
    let before = all.knee_before().unwrap_or_default();
    let is_late = all.designs.iter().all(|design| design.standing == Standing::Late);
    match all.knee {
        _ if is_late => "With banked all of them miss the display rate.".into(),
        None => "With banked none of them can be ranked.".into(),
        Some(_) if all.designs.len() == 1 => format!("#{before} keeps its place."),
        Some(knee) if knee == before => format!("The knee stays #{before}."),
        Some(knee) => format!("With banked the knee is #{knee}, no longer #{before}."),
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
        (Standing::Beaten, "is beaten by another of them", "are beaten by others of them"),
        (Standing::Late, "misses the display rate", "miss the display rate"),
        (Standing::Unmet, "does not meet the condition", "do not meet the condition"),
        (Standing::Failed, "failed", "failed"),
    ]
    .into_iter()
    .filter_map(sentence)
    .collect();
    match (left.is_empty(), all.designs.len()) {
        (true, 1) => Vec::new(),
        (true, _) => vec!["None of them is beaten by another.".into()],
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
    heads.push(Column::text("with banked").at_most(24));
    let row = |design: &Confirmed| {
        let knee = if Some(design.point) == all.knee_before() { " knee" } else { "" };
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
        cells.push(stands(all, design).into());
        cells
    };
    Table::new(heads).rows(all.designs.iter().map(row))
}

/// Where a design stands, in a few words.
fn stands(all: &Confirmation, design: &Confirmed) -> &'static str {
    match design.standing {
        Standing::Front if all.knee == Some(design.point) => "knee",
        Standing::Front => "front",
        Standing::Beaten => "beaten",
        Standing::Late => "misses the rate",
        Standing::Unmet => "condition not met",
        Standing::Failed => "failed",
    }
}

/// `confirmed.csv`: a row per design and column of the results, the knee first. `difference_frac`
/// is what `calibrated` is above `banked`.
pub fn confirmed_csv(all: &Confirmation) -> Vec<u8> {
    let mut table =
        Table::record("point id role standing column calibrated banked difference_frac");
    for design in &all.designs {
        let role = if Some(design.point) == all.knee_before() { "knee" } else { "front" };
        for value in &design.values {
            table.row([
                design.point.into(),
                design.id.as_str().into(),
                role.into(),
                design.standing.name().into(),
                value.column.as_str().into(),
                value.calibrated.into(),
                value.banked.into(),
                value.difference().into(),
            ]);
        }
    }
    table.csv()
}
