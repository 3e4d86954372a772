//! Published numbers beside ours: `docs/validation.md`, what `validate` prints, JSON.

use std::fmt::Write as _;

use serde_json::{Value, json};

use powergs_chart::Format;

use crate::document::{Block, Cell, Column, Document, Kind, Shown, Table, Text};
use powergs_study::validate::{Judged, Origin, Row, Status, Tables, Verdict, Workload};

const HEAD: &str = "\
# Validation

<!-- Written by `powergs-sim validate --force --write docs/validation.md` from tests/validation/ -->

Published numbers beside what the simulator says. `powergs-sim validate` makes this table and fails
when an enforced row leaves its tolerance, or when any row is farther from its published value than
`tests/validation/baseline.csv` says. `powergs-sim validate --quick` takes the rows without frames
and those on quick workloads: a minute.

*Enforced* rows must hold. A *known gap* is outside of its tolerance for the reason in its note, and
stays in the table. *Calibrated* rows had a say in a default of a machine file, which the note
names; all others are *held out*. Workloads are synthetic scenes that match published statistics of
the scenes that were used ([synth.md](synth.md)): points, image size, opacities, shapes. None was
tuned to a row, so a few per cent of agreement on an absolute number is luck; ratios say more.
Published rows are of several models of GSCore that contradict each other in places; the notes do
the arithmetic.
";

/// `docs/validation.md`.
pub fn page(tables: &Tables, judged: &[Judged]) -> String {
    let mut page = Document::new();
    page.paragraph(format!("{}.", summary(judged)));
    if let Some(model) = tables.model {
        page.paragraph(model_line(model));
    }
    for section in sections(judged) {
        page.heading(section[0].row.section.as_str());
        page.table(rows(section));
    }
    page.heading("Settings and reasons");
    page.add(Block::List(judged.iter().map(|j| note(j.row)).collect()));
    page.heading("Workloads");
    page.table(workloads(tables));
    format!("{HEAD}\n{}", page.markdown(Format::Png))
}

/// What the page says of the version of the models that its numbers came out of.
fn model_line(model: u32) -> String {
    format!("Model version {model}.")
}

/// What keeps `text` from being the page that has `judged` on it and is of model version `model`:
/// nothing where the version is right and every measured row says what it would say now.
pub fn differences(text: &str, tables: &Tables, judged: &[Judged], model: u32) -> Vec<String> {
    let mut found = Vec::new();
    let line = model_line(model);
    if !text.lines().any(|l| l == line) {
        found.push(format!("it is not of model version {model}: there is no line `{line}`"));
    }
    let now = page(tables, judged);
    for judged in judged.iter().filter(|j| j.ours.is_some()) {
        let start = format!("| `{}` |", judged.row.id);
        let of = |text| str::lines(text).find(|line| line.starts_with(&start)).map(str::to_owned);
        match (of(text), of(&now)) {
            (was, Some(is)) if was.as_ref() != Some(&is) => {
                let was = was.unwrap_or_else(|| "no such row".to_owned());
                found.push(format!("`{}`\n  there: {was}\n  now:   {is}", judged.row.id));
            }
            _ => {}
        }
    }
    found
}

/// What is printed.
pub fn document(judged: &[Judged]) -> Document {
    let mut page = Document::new();
    for section in sections(judged) {
        page.add(Block::Table(rows(section)));
    }
    page.paragraph(summary(judged));
    page.paragraph("* calibrated: a default was chosen with this row; all others are held out.");
    page
}

/// Rows of one section after the other.
fn sections<'a>(judged: &'a [Judged<'a>]) -> impl Iterator<Item = &'a [Judged<'a>]> {
    judged.chunk_by(|a, b| a.row.section == b.row.section)
}

/// Three significant digits.
fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        m if m >= 100.0 => format!("{value:.0}"),
        m if m >= 10.0 => format!("{value:.1}"),
        m if m >= 1.0 => format!("{value:.2}"),
        m if m >= 0.01 => format!("{value:.3}"),
        _ => format!("{value:.1e}"),
    }
}

/// A deviation: `+4.1 %`.
fn deviation(d: f64) -> String {
    format!("{:+.*} %", usize::from(d.abs() < 0.0995), d * 100.0)
}

fn rows(judged: &[Judged]) -> Table {
    let section = judged[0].row.section.as_str();
    let real = |head: &str| Column::new(head, Kind::Real(number));
    let mut table = Table::new([
        Column::text(section).on(Shown::Terminal).at_most(34),
        Column::text("row").on(Shown::Page),
        Column::text("what").on(Shown::Page),
        Column::text("unit").on(Shown::Page),
        real("published"),
        real("ours"),
        Column::new("off by", Kind::Real(deviation)),
        Column::count("tolerance").on(Shown::Page),
        Column::text("status").on(Shown::Page),
        Column::text("verdict").on(Shown::Terminal),
    ]);
    for j in judged {
        let row = j.row;
        let status: Text = match (row.status, j.verdict) {
            (_, Verdict::Fails) => Text::strong("fails"),
            (_, Verdict::Open) => "not measured".into(),
            (_, Verdict::Closed) => "gap, closed".into(),
            (Status::Enforced, _) => "enforced".into(),
            (Status::KnownGap, _) => "known gap".into(),
        };
        let (calibrated, mark) = match row.origin {
            Origin::Calibrated => (", calibrated", "*"),
            Origin::HeldOut => ("", ""),
        };
        let unit = row.metric.unit();
        let shown = if unit.is_empty() { "share" } else { unit };
        let worse = if j.has_worsened() { ", WORSE" } else { "" };
        table.row([
            format!("{} [{shown}]", row.id).into(),
            Text::code(row.id.clone()).into(),
            Text::marked(&row.what).into(),
            unit.into(),
            row.published.into(),
            j.ours.into(),
            Cell::from(j.deviation()),
            row.tolerance.to_string().into(),
            status.then(calibrated).into(),
            format!("{}{worse}{mark}", j.verdict.name()).into(),
        ]);
    }
    table
}

/// Where a row is from, how it is measured, and why it is as it is.
fn note(row: &Row) -> Text {
    let mut text = Text::code(row.id.clone()).then(format!(" ({}): ", row.source));
    text = text.then(Text::code(row.machine.to_string()));
    if let Some(against) = &row.against {
        text = text.then(" against ").then(Text::code(against.to_string()));
    }
    if let Some(workload) = &row.workload {
        text = text.then(" on ").then(Text::code(workload.clone()));
    }
    let end = if row.note.is_empty() { "." } else { ". " };
    text.then(", ").then(Text::code(row.metric.name())).then(end).then(Text::marked(&row.note))
}

fn workloads(tables: &Tables) -> Table {
    let mut table = Table::new([
        Column::text("name"),
        Column::text("preset"),
        Column::fixed("million Gaussians", 3),
        Column::count("image"),
        Column::count("views"),
        Column::text("quick"),
        Column::text("matches"),
    ]);
    for w in &tables.workloads {
        let Workload { name, preset, points, size: (x, y), why, .. } = w;
        let views = match w.path {
            0 => w.views.to_string(),
            n => format!("{} in a row of a path of {n}", w.views),
        };
        table.row([
            Text::code(name.clone()).into(),
            preset.as_str().into(),
            (*points as f64 * 1e-6).into(),
            format!("{x}x{y}").into(),
            views.into(),
            if w.quick { "yes" } else { "" }.into(),
            Text::marked(why).into(),
        ]);
    }
    table
}

/// How many rows came out how.
pub fn summary(judged: &[Judged]) -> String {
    let count = |v: Verdict| judged.iter().filter(|j| j.verdict == v).count();
    let enforced = judged.iter().filter(|j| j.row.status == Status::Enforced).count();
    let mut text = format!(
        "{} of {enforced} enforced rows hold, {} known gaps",
        count(Verdict::Holds),
        count(Verdict::Gap)
    );
    for (n, what) in [
        (count(Verdict::Closed), "gaps closed (make them enforced)"),
        (count(Verdict::Open), "not measured"),
        (judged.iter().filter(|j| j.has_worsened()).count(), "worsened"),
    ] {
        if n > 0 {
            let _ = write!(text, ", {n} {what}");
        }
    }
    text
}

/// The same as JSON.
pub fn json(judged: &[Judged]) -> Value {
    let row = |j: &Judged| {
        json!({
            "id": j.row.id,
            "section": j.row.section,
            "what": j.row.what,
            "workload": j.row.workload,
            "machine": j.row.machine.to_string(),
            "against": j.row.against.as_ref().map(ToString::to_string),
            "metric": j.row.metric.name(),
            "unit": j.row.metric.unit(),
            "published": j.row.published,
            "ours": j.ours,
            "before": j.before,
            "deviation": j.deviation(),
            "tolerance": j.row.tolerance.to_string(),
            "status": j.row.status.name(),
            "origin": j.row.origin.name(),
            "verdict": j.verdict.name(),
            "worsened": j.has_worsened(),
            "source": j.row.source,
            "note": j.row.note,
        })
    };
    let bad = judged.iter().any(Judged::is_bad);
    json!({ "rows": judged.iter().map(row).collect::<Vec<_>>(), "passed": !bad })
}
