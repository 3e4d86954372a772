//! The published claims, checked: the answer for terminals, pages and programs.

use std::fmt::Write as _;

use serde_json::{Value, json as object};

use crate::format::{shortened, wrapped};
use powergs_optimize::claims::{Book, LEFT_OUT, Row, Verdict};

/// Columns of a terminal.
const WIDTH: usize = 80;
/// Column of what is said about a claim.
const INDENT: usize = 5;

/// What sign and order can show.
const NOTE: &str = "Sign and order are what small scenes and short runs can show; the published \
                    numbers are for full-size scenes and 150,000 iterations.";

/// Lines of at most `width` columns, each after `indent` blanks.
fn block(text: &str, indent: usize, width: usize) -> String {
    let blank = " ".repeat(indent);
    wrapped(text, width - indent).lines().map(|line| format!("{blank}{line}\n")).collect()
}

/// The first line of a block with something in its margin.
fn marked(mark: &str, text: &str, indent: usize) -> String {
    let lines = block(text, indent, WIDTH);
    format!("{mark:<indent$}{}", lines.get(indent..).unwrap_or_default())
}

/// The answer in 80 columns.
pub fn terminal(book: &Book) -> String {
    let mut text = String::new();
    for (label, about) in &book.runs {
        text += &marked("run  ", &format!("{}: {about}", shortened(label, 40)), INDENT);
    }
    text.push('\n');
    for row in &book.rows {
        let verdict = row.verdict.name();
        text += &marked(row.id, &format!("{}: {verdict}", row.what), INDENT);
        text += &marked("     paper", row.published, 15);
        text += &marked("     expected", row.expects, 15);
        for finding in &row.findings {
            let run =
                finding.run.as_ref().map_or(String::new(), |r| format!("{}: ", shortened(r, 24)));
            let mark = match finding.verdict {
                Verdict::Yes => "     here  yes",
                Verdict::No => "     here  no",
                Verdict::Unchecked => "     here  -",
            };
            text += &marked(mark, &format!("{run}{}", finding.here), 15);
        }
    }
    text += "\nNot checkable by simulation:\n";
    for (id, what, why) in LEFT_OUT {
        text += &marked(id, &format!("{what} ({why})"), INDENT);
    }
    text.push('\n');
    text += &wrapped(NOTE, WIDTH);
    let _ = write!(text, "\n\n{}\n", summary(book));
    text
}

/// `12 of 20 claims agree, 5 could not be checked`.
fn summary(book: &Book) -> String {
    let (yes, checked) = book.agreed();
    let rest = book.rows.len() - checked;
    let rest = if rest > 0 { format!(", {rest} could not be checked") } else { String::new() };
    format!("{yes} of {checked} claims agree{rest}")
}

/// Text in a cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace(['\n', '\r'], " ")
}

/// A table of the claims that some run can check, for a page about that run.
pub fn table(book: &Book) -> String {
    let mut text =
        "| | claim | published | expected | here | agrees |\n|---|---|---|---|---|---|\n"
            .to_owned();
    for row in &book.rows {
        let Row { id, what, published, expects, .. } = row;
        let label = |run: &Option<String>| match run {
            Some(run) if book.runs.len() > 1 => format!("{run}: "),
            _ => String::new(),
        };
        let findings = row.findings.iter().map(|f| {
            let (run, here, verdict) = (label(&f.run), &f.here, f.verdict.name());
            let said = if row.findings.len() > 1 { format!(" ({verdict})") } else { String::new() };
            cell(&format!("{run}{here}{said}"))
        });
        let here = findings.collect::<Vec<String>>().join("<br>");
        let verdict = row.verdict.name();
        let _ = writeln!(text, "| {id} | {what} | {published} | {expects} | {here} | {verdict} |");
    }
    text
}

/// A page.
pub fn markdown(book: &Book) -> String {
    let mut text = format!("# Published claims, checked\n\n{}.\n\n{NOTE}\n\n", summary(book));
    for (label, about) in &book.runs {
        let _ = writeln!(text, "- **{}**: {}", cell(label), cell(about));
    }
    let _ = write!(text, "\n{}\n## Not checkable by simulation\n\n", table(book));
    text += "| | claim | why |\n|---|---|---|\n";
    for (id, what, why) in LEFT_OUT {
        let _ = writeln!(text, "| {id} | {what} | {why} |");
    }
    text
}

/// One object.
pub fn json(book: &Book) -> Value {
    let (agree, checked) = book.agreed();
    let row = |row: &Row| {
        let findings = row
            .findings
            .iter()
            .map(|f| object!({ "run": f.run, "here": f.here, "agrees": verdict(&f.verdict) }));
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
