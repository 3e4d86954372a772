//! The experiment for people.

use crate::document::{Block, Cell, Column, Document, Shown, Table, Text};
use powergs_base::TOOL_VERSION;
use powergs_chart::Chart;
use powergs_core::sim::MODEL_VERSION;
use powergs_study::findings::sensitivity::{Change, KnobEffect, KnobSetting, Sensitivity, Traced};

/// Characters of a knob on a terminal.
const KNOB: usize = 27;
/// Changes below this are none.
const LEAST: f64 = 0.0005;

/// What is printed, and the page with `charts` beside it. `folder` is where the page is.
pub fn document(all: &Sensitivity, charts: &[Chart], folder: Option<&str>) -> Document {
    let mut page = Document::new();
    page.title(format!("What assumptions move on {}", all.machine));
    page.extend(traces(&all.traces, all.incomplete_note(), None));
    page.charts(charts);
    page.paragraph("Changes in percent, with the knob lowered and raised, the largest first.");
    page.on(Shown::Page, Block::Table(rows(all, SensitivityPart::All)));
    page.on(Shown::Terminal, Block::Table(rows(all, SensitivityPart::Moving)));
    page.on(Shown::Terminal, Block::Table(rows(all, SensitivityPart::Area)));
    let dead = all.rows.iter().filter(|r| shows(r) == Some(false)).map(|r| r.number.as_str());
    named(&mut page, "below 0.05 % either way", dead.collect());
    named(
        &mut page,
        "no knob on this machine",
        all.fixed.iter().map(|f| f.number.as_str()).collect(),
    );
    page.on(Shown::Page, Block::Table(refused(all)));
    let fixed = all.fixed.iter();
    let columns = ["no knob", "", "why"].map(Column::text);
    let row = |f: &powergs_study::findings::sensitivity::Fixed| {
        [f.number.as_str(), &f.text, &f.why].map(|t| Cell::from(Text::marked(t)))
    };
    page.on(Shown::Page, Block::Table(Table::new(columns).rows(fixed.map(row))));
    ending(&mut page, folder);
    page
}

/// The last lines: where the report is, what made it.
pub(super) fn ending(page: &mut Document, folder: Option<&str>) {
    let report = folder.map(|folder| ("report".to_owned(), folder.into()));
    page.on(Shown::Terminal, Block::Facts(report.into_iter().collect()));
    page.page_paragraph(format!("powergs-sim {TOOL_VERSION}, model {MODEL_VERSION}."));
}

/// A sentence of a terminal that names what its tables leave out.
pub(super) fn named(page: &mut Document, what: &str, names: Vec<&str>) {
    if !names.is_empty() {
        let text = format!("{what}: {}", names.join(" "));
        page.on(Shown::Terminal, Block::Paragraph(text.into()));
    }
}

/// What the machine costs as it is, by trace; and what is missing. `fps`: the display rate, where
/// power is measured.
pub(super) fn traces(traces: &[Traced], note: Option<String>, fps: Option<f64>) -> Document {
    let mut part = Document::new();
    if let Some(note) = note {
        part.paragraph(Text::strong(note));
    }
    let mut columns = vec![
        Column::text("trace").at_most(24),
        Column::count("frames"),
        Column::real("FPS"),
        Column::real("mJ per frame"),
    ];
    columns.extend(fps.map(|fps| Column::real(format!("mW at {} FPS", crate::format::rate(fps)))));
    columns.push(Column::fixed("area, mm²", 2));
    let mut table = Table::new(columns);
    for t in traces {
        let mut cells: Vec<Cell> = vec![t.name.as_str().into(), t.frames.into()];
        cells.extend([t.base.fps(), t.base.energy_mj()].map(Cell::Real));
        cells.extend(fps.map(|_| Cell::Real(t.base.power_w * 1e3)));
        cells.push(t.base.area_mm2.into());
        table.row(cells);
    }
    part.table(table);
    part
}

/// Whether a row has something to show; `None` if neither side is a valid configuration.
fn shows(row: &KnobEffect) -> Option<bool> {
    let all = (0..row.base.len()).flat_map(|t| row.changes(t)).flatten();
    all.map(|c| c.largest() >= LEAST).reduce(|a, b| a || b)
}

/// Which rows and columns.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SensitivityPart {
    /// All.
    All,
    /// Frame rate and energy of the rows in which they move.
    Moving,
    /// The area, of the rows in which it moves.
    Area,
}

type Of = fn(Change) -> f64;

fn rows(all: &Sensitivity, part: SensitivityPart) -> Table {
    let measures: [(&str, Of); 2] = [("FPS", |c| c.fps), ("energy", |c| c.energy)];
    let traces = if part == SensitivityPart::Area { 0 } else { all.traces.len() };
    // What a pair of columns is about: of which trace, and what.
    let mut pairs: Vec<(String, usize, Of)> = Vec::new();
    for t in 0..traces {
        let trace = match traces {
            1 => String::new(),
            _ => format!("{} ", all.traces[t].name),
        };
        pairs.extend(measures.map(|(name, of)| (format!("{trace}{name}"), t, of)));
    }
    if part != SensitivityPart::Moving {
        pairs.push(("area".into(), 0, |c| c.area));
    }
    let values = Column::text("low .. high").at_most(14);
    let mut columns = vec![
        Column::text(""),
        Column::text("assumption").on(Shown::Page),
        Column::text("knob").at_most(KNOB),
        Column::text("base").on(Shown::Page),
        if traces > 1 { values.on(Shown::Page) } else { values },
    ];
    for (group, ..) in &pairs {
        columns.extend(["low", "high"].map(|side| Column::count(side).group(group.clone())));
    }
    let mut table = Table::new(columns);
    let changes = |row: &KnobEffect| -> Vec<Option<f64>> {
        let pair = |&(_, t, of): &(String, usize, Of)| row.changes(t).map(|c| c.map(of));
        pairs.iter().flat_map(pair).collect()
    };
    for row in &all.rows {
        let changes = changes(row);
        if part != SensitivityPart::All && changes.iter().flatten().all(|c| c.abs() < LEAST) {
            continue;
        }
        let first: [Cell; 5] = [
            row.number.as_str().into(),
            Text::marked(&row.text).into(),
            if part == SensitivityPart::All { keys(row).into() } else { row.knob().into() },
            row.value.as_str().into(),
            self::values(row).into(),
        ];
        table.row(first.into_iter().chain(changes.into_iter().map(percent)));
    }
    table
}

/// The keys of a knob, and what else it needs.
fn keys(row: &KnobEffect) -> Text {
    let mut text = Text::codes(row.keys.iter().map(String::as_str));
    if let Some(on) = &row.on {
        text = text.then(format!(" on {on}"));
    }
    if !row.with.is_empty() {
        text = text.then(" with ").then(Text::codes(row.with.iter().map(String::as_str)));
    }
    text
}

/// `+12.3`, `-48.0`; nothing for an invalid configuration or a side that is not there.
pub(super) fn percent(change: Option<f64>) -> Cell {
    let Some(change) = change else { return Cell::Missing };
    let percent = change * 100.0;
    match percent.abs() {
        p if p < 0.05 => "0".into(),
        p if p >= 99.95 => format!("{percent:+.0}").into(),
        _ => format!("{percent:+.1}").into(),
    }
}

/// `0.39 .. 1`, or `-> all`.
fn values(row: &KnobEffect) -> String {
    match (&row.low, &row.high) {
        (Some(low), Some(high)) => format!("{} .. {}", low.value, high.value),
        (Some(low), None) => format!("{} ..", low.value),
        (None, Some(high)) => format!("{} -> {}", row.value, high.value),
        (None, None) => row.value.clone(),
    }
}

/// Why some sides are no valid configuration.
fn refused(all: &Sensitivity) -> Table {
    let mut table = Table::new(["invalid configuration", "", "why"].map(Column::text));
    for row in &all.rows {
        for side in [&row.low, &row.high].into_iter().flatten() {
            if let KnobSetting { value, outcomes: Err(reason) } = side {
                let what = Text::codes(row.keys.iter().map(String::as_str));
                let what = what.then(format!(" = {value}"));
                table.row([row.number.as_str().into(), what.into(), Text::marked(reason).into()]);
            }
        }
    }
    table
}
