//! Published numbers beside ours: `evidence/validation.md`, what `validate` prints, JSON.

use std::fmt::Write as _;

use serde_json::{Value, json};

use powergs_chart::Format;

use crate::document::{Block, Cell, Column, Document, Kind, Shown, Table, Text};
use powergs_study::validate::numbers::mean;
use powergs_study::validate::{
    Evidence, Family, Gap, Judged, Parts, Row, RowOff, Status, Tables, Verdict, Workload,
};

const HEAD: &str = "\
# Validation

<!-- Written by `powergs-sim validate --force --write evidence/validation.md` -->

Published numbers beside what the simulator says. `powergs-sim validate` makes this table and fails
when an enforced row leaves its tolerance, or when any row is farther from its published value than
`tests/validation/baseline.csv` says. `powergs-sim validate --quick` takes the rows without frames
and those on quick workloads: a minute.

**What is evidence** is said by a ledger (`tests/validation/ledger.csv`): each row is entered once,
with its day and the version of the models, as a *prediction* or as *calibrated*, where the number
or a look at ours has decided something that ours depends on. The file is append-only. A prediction
that misses stays in all counts; another definition of a row is another entry, calibrated. Rows of
one experiment are a family and count once, by the geometric mean of how many times too large or too
small ours is. A family is evidence if all of its tolerances are 25 % at most, its error is inside
of that, and at most half of what a model without the mechanism gives (the *null*), by logarithms.
The rows of 2026-11-29 and before were entered on that day by what the history of this repository
shows, and their nulls were chosen when ours was known: only later entries are free of that.

A row is one published number; where it is a mean over scenes, or holds for several, ours is the
mean over the workloads of the row. What a change of the simulator may do to it:

- *enforced*: within 25 % at most; it must hold.
- *calibrated*: the published value set something that the row depends on. It must hold.
- *plausibility*: the range is wide, or what is compared is defined loosely, so that a wrong
  simulator may pass, too. It must hold.
- *known gap*: outside of its tolerance, because publications contradict each other (contradiction),
  the simulator lacks something (mechanism), the scene is not like the one that was used (workload),
  or the machine file is not like the machine that was published (preset). The note says which, why.
- *dropped*: nothing can be decided by it, for the reason in its note.

Workloads are synthetic scenes that match published statistics of the scenes that were used
([synth.md](../docs/synth.md)): points, image size, opacities, shapes. None was tuned to a row,
unless its line says so, and a few per cent of agreement on an absolute number are luck; ratios say
more.
";

/// Below this share of a published gain a page says what is missing.
pub const HALF: f64 = 0.5;

/// `evidence/validation.md`.
pub fn page(tables: &Tables, judged: &[Judged]) -> String {
    let mut page = Document::new();
    evidence(&mut page, tables, judged);
    page.paragraph(format!("Guards against changes: {}.", summary(judged)));
    if let Some(model) = tables.model {
        page.paragraph(model_line(model));
    }
    for section in sections(judged) {
        page.heading(section[0].row.section.as_str());
        page.table(rows(section[0].row.section.as_str(), section));
    }
    page.heading(GAINS);
    page.paragraph(
        "What a preset shows of the gain that its accelerator was published for: (ours - 1) / \
         (published - 1). Below half, what is missing.",
    );
    page.table(gains(judged));
    page.heading("Settings and reasons");
    page.add(Block::List(judged.iter().map(note).collect()));
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

/// What rows are on scenes of the user's own: each with its name and the values by row.
pub fn scenes(tables: &Tables, rows: &[&Row], scenes: &[(String, Parts)]) -> Document {
    let real = |head: &str| Column::new(head, Kind::Real(number));
    let fixed = [Column::text("row"), real("published"), real("synthetic")];
    let own = scenes.iter().map(|(name, _)| real(name));
    let mut table = Table::new(fixed.into_iter().chain(own).chain([Column::count("near")]));
    for row in rows {
        let synthetic = tables.before(row).and_then(mean);
        let values: Vec<Option<f64>> =
            scenes.iter().map(|(_, values)| values.get(&row.id).copied()).collect();
        let is_near = |ours: &&f64| row.tolerance.is_none_or(|t| t.holds(row.published, **ours));
        let near = values.iter().flatten().filter(is_near).count();
        let fixed = [row.id.as_str().into(), row.published.into(), synthetic.into()];
        let values = values.into_iter().map(Cell::from);
        let near = format!("{near} of {}", scenes.len()).into();
        table.row(fixed.into_iter().chain(values).chain([near]));
    }
    let mut page = Document::new();
    page.table(table);
    page.paragraph(
        "Plausibility: shares and ratios on scenes that are not those of the publications. \
         Synthetic is the mean over the workloads of the row; near counts scenes within its \
         tolerance.",
    );
    page
}

/// The same as JSON.
pub fn scenes_json(rows: &[&Row], scenes: &[(String, Parts)]) -> Value {
    let row = |row: &&Row| {
        let ours = scenes.iter().map(|(name, values)| (name.clone(), json!(values.get(&row.id))));
        let ours: serde_json::Map<String, Value> = ours.collect();
        json!({ "id": row.id, "published": row.published, "by_scene": ours })
    };
    json!({ "rows": rows.iter().map(row).collect::<Vec<_>>() })
}

/// What is printed.
pub fn document(tables: &Tables, judged: &[Judged]) -> Document {
    let mut page = Document::new();
    for section in sections(judged) {
        page.add(Block::Table(rows(section[0].row.section.as_str(), section)));
    }
    if judged.iter().any(|j| j.row.gain.is_some()) {
        page.add(Block::Table(gains(judged)));
    }
    page.paragraph(format!("Guards against changes: {}.", summary(judged)));
    evidence(&mut page, tables, judged);
    page
}

/// What predictions come to: in words, by family, and the farthest.
fn evidence(page: &mut Document, tables: &Tables, judged: &[Judged]) {
    let found = tables.ledger.standing(judged);
    let Some(text) = evidence_line(&found) else { return };
    page.paragraph(Text::marked(&text));
    let times = |x: f64| format!("{:.2}", x);
    let real = |head: &str| Column::new(head, Kind::Real(times));
    let mut table = Table::new([
        Column::text("family"),
        Column::count("rows"),
        real("off by, times"),
        real("worst row, times"),
        real("null off by, times"),
        Column::text("evidence"),
    ]);
    let mut families: Vec<&Family> = found.families.iter().collect();
    families.sort_by(|a, b| b.is_evidence.cmp(&a.is_evidence).then(a.error.total_cmp(&b.error)));
    for family in families {
        table.row([
            Text::code(family.name.clone()).into(),
            family.rows.to_string().into(),
            Some(family.error).into(),
            Some(family.worst).into(),
            family.null.into(),
            if family.is_evidence { "yes" } else { "no" }.into(),
        ]);
    }
    page.page_heading("Predictions, by experiment");
    page.on(Shown::Page, Block::Table(table));
}

/// What predictions come to, in a few sentences; `None` where none was measured.
pub fn evidence_line(found: &Evidence) -> Option<String> {
    let error = found.error?;
    let off = |row: &RowOff| format!("`{}` {:.1}", row.row, row.times);
    let worst: Vec<String> = found.worst.iter().map(off).collect();
    let families: Vec<String> = found.of_worth().map(|f| format!("`{}`", f.name)).collect();
    Some(format!(
        "Of {} predictions {} are inside of their tolerance and {} within 25 %; ours is {error:.2} \
         times too large or too small (geometric mean). {} of {} experiments are evidence: {}. \
         Farthest, in times: {}. Of {} calibrated rows {} are outside of their tolerance.",
        found.predictions,
        found.inside,
        found.within_quarter,
        families.len(),
        found.families.len(),
        if families.is_empty() { "none".to_owned() } else { families.join(", ") },
        worst.join(", "),
        found.calibrated,
        found.calibrated_missed
    ))
}

fn evidence_json(found: &Evidence) -> Value {
    let off = |row: &RowOff| json!({ "id": row.row, "times": row.times });
    let family = |f: &Family| {
        json!({
            "name": f.name,
            "rows": f.rows,
            "error": f.error,
            "worst": f.worst,
            "null": f.null,
            "is_evidence": f.is_evidence,
        })
    };
    json!({
        "predictions": found.predictions,
        "inside": found.inside,
        "within_quarter": found.within_quarter,
        "error": found.error,
        "worst": found.worst.iter().map(off).collect::<Vec<_>>(),
        "families": found.families.iter().map(family).collect::<Vec<_>>(),
        "calibrated": found.calibrated,
        "calibrated_missed": found.calibrated_missed,
    })
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

/// Rows under a head, which only terminals show.
pub(crate) fn rows(head: &str, judged: &[Judged]) -> Table {
    let real = |head: &str| Column::new(head, Kind::Real(number));
    let mut table = Table::new([
        Column::text(head).on(Shown::Terminal).at_most(34),
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
        let class = class(row.status);
        let status: Text = match j.verdict {
            Verdict::Fails => Text::strong(format!("{class}, fails")),
            Verdict::Open => "not measured".into(),
            Verdict::Closed => format!("{class}, closed").into(),
            Verdict::Holds | Verdict::Gap | Verdict::Dropped => class.as_str().into(),
        };
        let short = match (j.verdict, row.status) {
            (Verdict::Holds, _) => row.status.name().to_owned(),
            (Verdict::Gap, Status::KnownGap(gap)) => format!("gap: {}", gap.name()),
            _ => j.verdict.name().to_owned(),
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
            row.tolerance.map(|t| t.to_string()).into(),
            status.into(),
            format!("{short}{worse}").into(),
        ]);
    }
    table
}

/// The status of a row in words.
fn class(status: Status) -> String {
    match status {
        Status::KnownGap(gap) => format!("known gap: {}", gap.name()),
        Status::Enforced | Status::Calibrated | Status::Plausibility | Status::Dropped => {
            status.name().to_owned()
        }
    }
}

/// Head of the table of gains.
const GAINS: &str = "Gains of later accelerators";

/// What presets show of the gains that their accelerators were published for.
fn gains(judged: &[Judged]) -> Table {
    let real = |head: &str| Column::new(head, Kind::Real(number));
    let mut table = Table::new([
        Column::text(GAINS).on(Shown::Terminal).at_most(34),
        Column::text("row").on(Shown::Page),
        Column::text("what").on(Shown::Page),
        real("published"),
        real("ours"),
        Column::fixed("share of gain", 2),
        Column::text("missing").on(Shown::Page),
    ]);
    for j in judged {
        let Some(missing) = &j.row.gain else { continue };
        let share = j.share_of_gain();
        let missing = if share.is_some_and(|s| s < HALF) { missing.as_str() } else { "" };
        table.row([
            format!("{} [x]", j.row.id).into(),
            Text::code(j.row.id.clone()).into(),
            Text::marked(&j.row.what).into(),
            j.row.published.into(),
            j.ours.into(),
            share.into(),
            Text::marked(missing).into(),
        ]);
    }
    table
}

/// Where a row is from, how it is measured, what came out on each workload, and why it is as it is.
fn note(judged: &Judged) -> Text {
    let row: &Row = judged.row;
    let mut text = Text::code(row.id.clone()).then(format!(" ({}): ", row.source));
    text = text.then(Text::code(row.machine.to_string()));
    if let Some(against) = &row.against {
        text = text.then(" against ").then(Text::code(against.to_string()));
    }
    if !row.workloads.is_empty() {
        text = text.then(" on ").then(Text::codes(row.workloads.iter().map(String::as_str)));
    }
    text = text.then(", ").then(Text::code(row.metric.name()));
    if judged.parts.len() > 1 {
        let part = |name: &String| format!("{name} {}", number(judged.parts[name]));
        let parts: Vec<String> = row.workloads.iter().map(part).collect();
        text = text.then(format!(": {}", parts.join(", ")));
    }
    let end = if row.note.is_empty() { "." } else { ". " };
    text.then(end).then(Text::marked(&row.note))
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
        let Workload { name, preset, size: (x, y), why, .. } = w;
        let points = w.preset().map_or(0, |preset| preset.points);
        let views = match w.path {
            0 => w.views.to_string(),
            n => format!("{} in a row of a path of {n}", w.views),
        };
        table.row([
            Text::code(name.clone()).into(),
            preset.as_str().into(),
            (points as f64 * 1e-6).into(),
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
    let of = |status: Status| judged.iter().filter(move |j| j.row.status == status);
    let holding = |status: Status| of(status).filter(|j| j.verdict == Verdict::Holds);
    let absolute = holding(Status::Enforced).filter(|j| !j.row.metric.compares()).count();
    let mut text = format!(
        "{} of {} enforced rows hold, {absolute} of them absolute",
        holding(Status::Enforced).count(),
        of(Status::Enforced).count(),
    );
    for status in [Status::Calibrated, Status::Plausibility] {
        let (holding, all) = (holding(status).count(), of(status).count());
        if all > 0 {
            let _ = write!(text, "; {}: {holding} of {all}", status.name());
        }
    }
    let gaps = Gap::ALL.map(|gap| (gap, of(Status::KnownGap(gap)).count()));
    let gaps: Vec<String> = gaps
        .into_iter()
        .filter(|(_, n)| *n > 0)
        .map(|(gap, n)| format!("{} {n}", gap.name()))
        .collect();
    if !gaps.is_empty() {
        let _ = write!(text, "; known gaps: {}", gaps.join(", "));
    }
    let dropped = of(Status::Dropped).count();
    if dropped > 0 {
        let _ = write!(text, "; dropped: {dropped}");
    }
    for (n, what) in [
        (count(Verdict::Fails), "fail"),
        (count(Verdict::Closed), "gaps closed (give them another status)"),
        (count(Verdict::Open), "not measured"),
        (judged.iter().filter(|j| j.has_worsened()).count(), "worsened"),
    ] {
        if n > 0 {
            let _ = write!(text, ", {n} {what}");
        }
    }
    text
}

/// The number that a machine misses most, in a few words: `gsarch-train: 87 % above the published
/// rate (15.5 for 8.27 FPS)`.
pub fn headline(judged: &Judged) -> String {
    let (row, words) = (judged.row, judged.row.metric.words());
    let Some((ours, deviation)) = judged.ours.zip(judged.deviation()) else {
        return format!("{}: not measured", row.id);
    };
    let side = if deviation < 0.0 { "below" } else { "above" };
    let percent =
        format!("{:.*} %", usize::from(deviation.abs() < 0.0995), deviation.abs() * 100.0);
    let unit = Some(row.metric.unit()).filter(|unit| !unit.is_empty());
    let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
    let (ours, published) = (number(ours), number(row.published));
    format!("{}: {percent} {side} the published {words} ({ours} for {published}{unit})", row.id)
}

/// The same as JSON.
pub fn json(tables: &Tables, judged: &[Judged]) -> Value {
    let bad = judged.iter().any(Judged::is_bad);
    let evidence = evidence_json(&tables.ledger.standing(judged));
    json!({ "rows": rows_json(judged), "evidence": evidence, "passed": !bad })
}

/// Every row as JSON.
pub(crate) fn rows_json(judged: &[Judged]) -> Vec<Value> {
    let row = |j: &Judged| {
        json!({
            "id": j.row.id,
            "section": j.row.section,
            "what": j.row.what,
            "by_workload": j.parts,
            "workloads": j.row.workloads,
            "machine": j.row.machine.to_string(),
            "against": j.row.against.as_ref().map(ToString::to_string),
            "metric": j.row.metric.name(),
            "unit": j.row.metric.unit(),
            "published": j.row.published,
            "ours": j.ours,
            "before": j.before,
            "deviation": j.deviation(),
            "tolerance": j.row.tolerance.map(|t| t.to_string()),
            "status": j.row.status.name(),
            "class": j.row.status.gap().map(Gap::name),
            "share_of_gain": j.share_of_gain(),
            "missing": j.row.gain,
            "verdict": j.verdict.name(),
            "worsened": j.has_worsened(),
            "source": j.row.source,
            "note": j.row.note,
        })
    };
    judged.iter().map(row).collect()
}
