//! The published claims, checked: the answer for terminals, pages and programs.

use serde_json::{Value, json as object};

use crate::document::{Block, Cell, Column, Document, Shown, Table, Text};
use crate::format::{engineering, shortened};
use powergs_optimize::claims::{ClaimTable, LEFT_OUT, Number, Part, Row, Sentence, Unit, Verdict};

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

/// `12 of 20 claims agree, 5 could not be checked`.
fn summary(book: &ClaimTable) -> String {
    let (yes, checked) = book.agreed();
    let rest = book.rows.len() - checked;
    let rest = if rest > 0 { format!(", {rest} could not be checked") } else { String::new() };
    format!("{yes} of {checked} claims agree{rest}")
}

/// The claims that some run can check, for a page about that run.
pub fn table(book: &ClaimTable) -> Table {
    let columns = ["", "claim", "published", "expected", "here", "agrees"].map(Column::text);
    let mut table = Table::new(columns);
    for row in &book.rows {
        let Row { id, what, published, expects, .. } = row;
        let label = |run: &Option<String>| match run {
            Some(run) if book.runs.len() > 1 => format!("{run}: "),
            _ => String::new(),
        };
        let findings = row.findings.iter().map(|f| {
            let (run, here, verdict) = (label(&f.run), words(&f.here), f.verdict.name());
            let said = if row.findings.len() > 1 { format!(" ({verdict})") } else { String::new() };
            format!("{run}{here}{said}")
        });
        let here = findings.collect::<Vec<String>>().join("; ");
        let words = [id, what, published, expects, here.as_str(), row.verdict.name()];
        table.row(words.map(Cell::from));
    }
    table
}

/// One object.
pub fn json(book: &ClaimTable) -> Value {
    let (agree, checked) = book.agreed();
    let row = |row: &Row| {
        let findings = row.findings.iter().map(
            |f| object!({ "run": f.run, "here": words(&f.here), "agrees": verdict(&f.verdict) }),
        );
        object!({
            "claim": row.id,
            "what": row.what,
            "published": row.published,
            "expected": row.expects,
            "agrees": verdict(&row.verdict),
            "findings": findings.collect::<Vec<Value>>(),
        })
    };
    let run = |(label, about): &(String, String)| object!({ "run": label, "about": about });
    let left = LEFT_OUT.map(|(id, what, why)| object!({ "claim": id, "what": what, "why": why }));
    object!({
        "agree": agree,
        "checked": checked,
        "not_checked": book.rows.len() - checked,
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
