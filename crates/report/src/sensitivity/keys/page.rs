//! The experiment for people.

use crate::document::{Block, Cell, Column, Document, Shown, Table, Text};
use crate::sensitivity::page::{ending, named, percent, traces};
use powergs_chart::Chart;
use powergs_study::findings::cost::Cost;
use powergs_study::findings::sensitivity::Measure;
use powergs_study::findings::sensitivity::keys::{KeyRow, Keys, LEAST, Reach, Shape, Status};

/// Rows of a table on the terminal; all are in `summary.md`.
const MOST: usize = 30;

/// What is printed, and the page with `charts` beside it: numbers by elasticity, names, what moves
/// nothing. `folder` is where the page is, if nothing follows.
pub fn document(all: &Keys, charts: &[Chart], folder: Option<&str>) -> Document {
    let mut page = Document::new();
    page.title(format!("What the keys of {} move, one at a time", all.machine));
    page.extend(traces(&all.traces, all.incomplete_note(), Some(all.display_fps)));
    page.charts(charts);
    let rows: Vec<&KeyRow> = all.of(Status::Alive).filter(|r| r.is_number()).collect();
    if !rows.is_empty() {
        page.paragraph(Text::marked(
            "By what a far step does to the power, then to anything: changes at half and at double \
             (or as near to them as a machine allows), in percent. Elasticity: `d ln y / d ln x` \
             over the near values; `~` marks a kink, where one side is at least twice as steep as \
             the other, `|` one that is known on one side only: neither says what other steps do. \
             Of means over the traces.",
        ));
        page.on(Shown::Page, Block::Table(numbers(&rows)));
        page.on(Shown::Terminal, Block::Table(shortest(&rows)));
    }
    let names = names(all);
    if !names.rows.is_empty() {
        page.paragraph("Changes with another name, in percent:");
        page.table(names.most(MOST, "summary.md"));
    }
    let weak = list(all.of(Status::Weak));
    if !weak.is_empty() {
        let text = Text::from("Below 0.05 % on everything: ").then(Text::codes(weak));
        page.paragraph(text.then("."));
    }
    let dead = all.dead_by_reason();
    let mut table = Table::new(["dead on these frames", "why"].map(Column::text));
    for (why, rows) in dead {
        table.row([Text::codes(list(rows)).into(), Text::marked(&why).into()]);
    }
    for n in &all.not_tried {
        table.row([n.keys.as_str().into(), Text::marked(&n.why).into()]);
    }
    let lines = |row: &Vec<Cell>| match row.as_slice() {
        [Cell::Words(keys), Cell::Words(why)] => keys.clone().then(": ").then(why.clone()),
        _ => Text::default(),
    };
    if !table.rows.is_empty() {
        page.on(Shown::Terminal, Block::Heading("Dead on these frames".into()));
        page.on(Shown::Terminal, Block::List(table.rows.iter().map(lines).collect()));
    }
    page.on(Shown::Page, Block::Table(table));
    named(&mut page, "no other value is valid", list(all.of(Status::Fixed)));
    page.on(Shown::Page, Block::Table(fixed(all)));
    ending(&mut page, folder);
    page
}

fn list<'a>(rows: impl IntoIterator<Item = &'a KeyRow>) -> Vec<&'a str> {
    rows.into_iter().map(|r| r.key.as_str()).collect()
}

/// `+0.62`, `+1.79~` at a kink.
fn elasticity(row: &KeyRow, measure: Measure) -> Cell {
    let Some(found) = row.elasticity(measure) else { return Cell::Missing };
    let mark = match row.shape(measure) {
        Shape::Smooth => "",
        Shape::Kinked => "~",
        Shape::OneSided => "|",
    };
    match found.value {
        e if e.abs() < 0.0005 => format!("0{mark}").into(),
        e if e.abs() < 0.01 => format!("{e:+.3}{mark}").into(),
        e => format!("{e:+.2}{mark}").into(),
    }
}

/// `-10 +10`: the near steps in percent.
fn steps(row: &KeyRow) -> String {
    let percent = |ratio: f64| format!("{:+.0}", (ratio - 1.0) * 100.0);
    let all = row.reached(Reach::Near).filter_map(|(t, _)| t.ratio);
    all.map(percent).collect::<Vec<_>>().join(" ")
}

fn values(row: &KeyRow, reach: Reach) -> Cell {
    row.reached(reach).map(|(t, _)| t.value.as_str()).collect::<Vec<_>>().join(", ").into()
}

/// The measures that a terminal has room for.
const SHORT: [Measure; 2] = [Measure::Fps, Measure::Power];

/// The keys that move one of [`SHORT`], in their order.
fn shortest(rows: &[&KeyRow]) -> Table {
    let moves = |row: &&KeyRow| SHORT.into_iter().any(|m| row.far_effect_on(m) >= LEAST);
    let mut moving: Vec<&KeyRow> = rows.iter().copied().filter(moves).collect();
    let (all, others) = (moving.len(), rows.len() - moving.len());
    moving.truncate(MOST);
    let mut more = Vec::new();
    if all > MOST {
        more.push(format!("{} more", all - MOST));
    }
    if others > 0 {
        more.push(format!("{others} that move only energy or area"));
    }
    let mut table = numbers(&moving);
    if !more.is_empty() {
        table.more = format!("... and {}: summary.md", more.join(", "));
    }
    table
}

/// Far changes and elasticities of the keys that are numbers.
fn numbers(rows: &[&KeyRow]) -> Table {
    let shown = |m: Measure| if SHORT.contains(&m) { Shown::Everywhere } else { Shown::Page };
    let mut columns = vec![
        Column::text("file").on(Shown::Page),
        Column::text("key").at_most(24),
        Column::text("value").at_most(10),
        Column::text("far").on(Shown::Page),
    ];
    let far =
        |m: Measure, side: &str| Column::count(side).group(format!("{}, %", m.name())).on(shown(m));
    columns.extend(Measure::ALL.into_iter().flat_map(|m| [far(m, "half"), far(m, "double")]));
    columns.push(Column::text("near").on(Shown::Page));
    columns.push(Column::text("step, %").on(Shown::Page));
    columns.extend(Measure::ALL.map(|m| Column::count(m.name()).group("elasticity").on(shown(m))));
    let mut table = Table::new(columns);
    for row in rows {
        let mut cells: Vec<Cell> = vec![
            row.file.into(),
            Text::code(row.key.clone()).into(),
            row.value.as_str().into(),
            values(row, Reach::Far),
        ];
        cells.extend(Measure::ALL.into_iter().flat_map(|m| row.far(m).map(percent)));
        cells.push(values(row, Reach::Near));
        cells.push(steps(row).into());
        cells.extend(Measure::ALL.map(|m| elasticity(row, m)));
        table.row(cells);
    }
    table
}

/// One row for each other name, with its changes, those that move the power most first.
fn names(all: &Keys) -> Table {
    let mut rows = Vec::new();
    for row in all.of(Status::Alive).filter(|r| !r.is_number()) {
        let base = Cost::mean(&row.base);
        for (other, outcome) in row.reached(Reach::Name) {
            let changes = Measure::ALL.map(|m| m.change(&outcome, &base));
            let power = Measure::Power.change(&outcome, &base).map_or(0.0, f64::abs);
            let largest = changes.into_iter().flatten().map(f64::abs).fold(0.0, f64::max);
            let effect = ((power / LEAST).floor(), largest);
            let words: [Cell; 4] = [
                row.file.into(),
                Text::code(row.key.clone()).into(),
                row.value.as_str().into(),
                other.value.as_str().into(),
            ];
            rows.push((effect, words.into_iter().chain(changes.map(percent)).collect::<Vec<_>>()));
        }
    }
    let by_power = |a: &(f64, f64), b: &(f64, f64)| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1));
    rows.sort_by(|a, b| by_power(&a.0, &b.0));
    let mut columns = vec![
        Column::text("file").on(Shown::Page),
        Column::text("key"),
        Column::text("value").at_most(16),
        Column::text("other").at_most(16),
    ];
    columns.extend(Measure::ALL.map(|m| Column::count(m.name())));
    Table::new(columns).rows(rows.into_iter().map(|(_, row)| row))
}

/// Keys of which no other value is a valid configuration.
fn fixed(all: &Keys) -> Table {
    let mut table = Table::new(["no other value is valid", "tried", "why"].map(Column::text));
    for row in all.of(Status::Fixed) {
        let tried = row.perturbations.last().map(|t| (t.value.as_str(), t.outcomes.as_ref().err()));
        let (value, why) = tried.unwrap_or(("", None));
        let why = why.map_or(Cell::Empty, |why| Text::marked(why).into());
        table.row([Text::code(row.key.clone()).into(), value.into(), why]);
    }
    table
}
