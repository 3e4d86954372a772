//! The published claims, checked: the answer for terminals, pages and programs.

use serde_json::{Value, json as object};

use super::{ClaimTable, LEFT_OUT, Number, Part, Row, Sentence, Tally, Unit, Verdict};
use powergs_report::document::{Block, Cell, Column, Document, Shown, Table, Text};
use powergs_report::format::{engineering, shortened};

/// What sign and order can show.
const NOTE: &str = "Sign and order are what small scenes and short runs can show; the published \
                    numbers are for full-size scenes and 150,000 iterations.";

/// The answer: what is printed, and the page.
pub fn document(book: &ClaimTable) -> Document {
    let mut page = Document::new();
    page.on(Shown::Page, Block::Title("Published claims, checked".into()));
    page.page_paragraph(format!("{}.", summary(book)));
    page.page_paragraph(NOTE);
    let run =
        |(label, about): &(String, String)| Text::strong(label.clone()).then(format!(": {about}"));
    page.add(Block::List(book.runs.iter().map(run).collect()));
    for row in &book.rows {
        page.on(Shown::Terminal, Block::Facts(lines(row)));
    }
    page.on(Shown::Page, Block::Table(table(book)));
    if book.runs.len() > 1 {
        page.page_heading("By run");
        page.on(Shown::Page, Block::Table(by_run(book)));
    }
    page.heading("Not checkable by simulation");
    let item =
        |(id, what, why): (&str, &str, &str)| (id.to_owned(), format!("{what} ({why})").into());
    page.on(Shown::Terminal, Block::Facts(LEFT_OUT.map(item).to_vec()));
    let columns = ["", "claim", "why"].map(Column::text);
    let row = |(id, what, why): (&str, &str, &str)| [id, what, why].map(Cell::from);
    page.on(Shown::Page, Block::Table(Table::new(columns).rows(LEFT_OUT.map(row))));
    page.on(Shown::Terminal, Block::Paragraph(format!("{}. {NOTE}", summary(book)).into()));
    page
}

/// A finding in words.
pub fn words(sentence: &Sentence) -> String {
    let part = |part: &Part| match part {
        Part::Words(words) => words.clone(),
        Part::Number(number) => written(number),
    };
    sentence.parts.iter().map(part).collect()
}

fn written(number: &Number) -> String {
    let Number { value, unit, decimals, is_signed } = *number;
    let shown = match unit {
        Unit::Saved => {
            let word = if value >= 0.0 { "less" } else { "more" };
            return format!("{:.1} % {word}", 100.0 * value.abs());
        }
        Unit::Watts => return engineering(value, "W"),
        Unit::Percent => 100.0 * value,
        Unit::Hvsq => 1e5 * value,
        Unit::Decibels
        | Unit::FramesPerSecond
        | Unit::Codes
        | Unit::PerWatt
        | Unit::Count
        | Unit::One => value,
    };
    let decimals = usize::from(decimals);
    if is_signed { format!("{shown:+.decimals$}") } else { format!("{shown:.decimals$}") }
}

/// A claim on a terminal.
fn lines(row: &Row) -> Vec<(String, Text)> {
    let claim = format!("{}: {}", row.what, row.verdict.name());
    let mut lines = vec![(row.id.to_owned(), claim.into())];
    lines.push(("    paper".into(), row.published.into()));
    lines.push(("    expected".into(), row.expects.into()));
    if row.findings.len() > 1 {
        let tallies = row.tallies.iter().map(|t| match t.ratio {
            Some(ratio) => format!("{} at a ratio of {ratio}", of_scenes(t)),
            None => of_scenes(t),
        });
        lines.push(("    scenes".into(), tallies.collect::<Vec<_>>().join(", ").into()));
    }
    for finding in &row.findings {
        let run = finding.run.as_ref().map_or(String::new(), |r| format!("{}: ", shortened(r, 24)));
        let mark = match finding.verdict {
            Verdict::Yes => "    here  yes",
            Verdict::No => "    here  no",
            Verdict::Unchecked => "    here  -",
        };
        lines.push((mark.into(), format!("{run}{}", words(&finding.here)).into()));
    }
    lines
}

/// `12 of 20 claims agree on most scenes, 5 could not be checked`, for each ratio.
fn summary(book: &ClaimTable) -> String {
    let one = |(i, ratio): (usize, &Option<f64>)| {
        let (yes, checked) = book.agreed(i);
        let rest = book.rows.len() - checked;
        let rest = if rest > 0 { format!(", {rest} could not be checked") } else { String::new() };
        let scenes = if book.runs.len() > 1 { " on most scenes" } else { "" };
        match ratio.filter(|_| book.ratios.len() > 1) {
            Some(ratio) => {
                let where_ = format!("at a display-to-render ratio of {ratio} ");
                format!("{where_}{yes} of {checked} claims agree{scenes}{rest}")
            }
            None => format!("{yes} of {checked} claims agree{scenes}{rest}"),
        }
    };
    let mut all = book.ratios.iter().enumerate().map(one).collect::<Vec<_>>().join("; ");
    if let Some(first) = all.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    all
}

/// `3 of 4`, or `-` where nothing could be checked.
fn of_scenes(tally: &Tally) -> String {
    match tally.checked {
        0 => "-".into(),
        checked => format!("{} of {checked}", tally.agree),
    }
}

/// The claims: of one run with its findings, of several with the scenes that agree.
pub fn table(book: &ClaimTable) -> Table {
    let is_single = book.runs.len() < 2;
    let mut columns: Vec<Column> = ["", "claim", "published", "expected"].map(Column::text).into();
    if is_single {
        columns.extend(["here", "agrees"].map(Column::text));
    } else {
        let head = |ratio: &Option<f64>| match ratio {
            Some(ratio) => format!("scenes at {ratio}"),
            None => "scenes".into(),
        };
        columns.extend(book.ratios.iter().map(|ratio| Column::text(head(ratio))));
    }
    let mut table = Table::new(columns);
    for row in &book.rows {
        let Row { id, what, published, expects, .. } = row;
        let mut cells: Vec<Cell> = [id, what, published, expects].map(|text| (*text).into()).into();
        if is_single {
            let here = row.findings.iter().map(|f| words(&f.here)).collect::<Vec<_>>().join("; ");
            cells.extend([here.as_str(), row.verdict.name()].map(Cell::from));
        } else {
            let said = |tally: &Tally| match tally.verdict {
                Verdict::Yes => Cell::from(Text::strong(of_scenes(tally))),
                Verdict::No | Verdict::Unchecked => Cell::from(of_scenes(tally)),
            };
            cells.extend(row.tallies.iter().map(said));
        }
        table.row(cells);
    }
    table
}

/// What each run says about each claim.
fn by_run(book: &ClaimTable) -> Table {
    let mut table = Table::new(["", "run", "here", "agrees"].map(Column::text));
    for row in &book.rows {
        for finding in &row.findings {
            let run = finding.run.as_deref().unwrap_or("all");
            let here = words(&finding.here);
            table.row([row.id, run, here.as_str(), finding.verdict.name()].map(Cell::from));
        }
    }
    table
}

/// One object.
pub fn json(book: &ClaimTable) -> Value {
    let row = |row: &Row| {
        let findings = row.findings.iter().map(|f| {
            object!({
                "run": f.run,
                "display_ratio": f.ratio,
                "here": words(&f.here),
                "agrees": verdict(&f.verdict),
            })
        });
        let tallies = row.tallies.iter().map(|t| {
            object!({
                "display_ratio": t.ratio,
                "scenes_agree": t.agree,
                "scenes_checked": t.checked,
                "agrees": verdict(&t.verdict),
            })
        });
        object!({
            "claim": row.id,
            "what": row.what,
            "published": row.published,
            "expected": row.expects,
            "agrees": verdict(&row.verdict),
            "scenes": tallies.collect::<Vec<Value>>(),
            "findings": findings.collect::<Vec<Value>>(),
        })
    };
    let ratio = |(i, ratio): (usize, &Option<f64>)| {
        let (agree, checked) = book.agreed(i);
        let not_checked = book.rows.len() - checked;
        object!({
            "display_ratio": ratio,
            "agree": agree,
            "checked": checked,
            "not_checked": not_checked,
        })
    };
    let run = |(label, about): &(String, String)| object!({ "run": label, "about": about });
    let left = LEFT_OUT.map(|(id, what, why)| object!({ "claim": id, "what": what, "why": why }));
    object!({
        "by_display_ratio": book.ratios.iter().enumerate().map(ratio).collect::<Vec<Value>>(),
        "runs": book.runs.iter().map(run).collect::<Vec<Value>>(),
        "claims": book.rows.iter().map(row).collect::<Vec<Value>>(),
        "not_reproducible": left.to_vec(),
    })
}

/// `true`, `false`, or `null` where it cannot be said.
fn verdict(verdict: &Verdict) -> Value {
    match verdict {
        Verdict::Yes => Value::Bool(true),
        Verdict::No => Value::Bool(false),
        Verdict::Unchecked => Value::Null,
    }
}
