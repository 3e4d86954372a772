//! The rows as a table of 80 columns, and as JSON.

use std::fmt::Write as _;

use serde_json::{Value, json};

use super::judge::{Judged, Verdict};
use super::row::Status;

/// Three significant digits.
pub fn number(value: f64) -> String {
    let magnitude = value.abs();
    match magnitude {
        0.0 => "0".to_owned(),
        m if m >= 100.0 => format!("{value:.0}"),
        m if m >= 10.0 => format!("{value:.1}"),
        m if m >= 1.0 => format!("{value:.2}"),
        m if m >= 0.01 => format!("{value:.3}"),
        _ => format!("{value:.1e}"),
    }
}

/// A deviation: `+4.1 %`.
pub fn deviation(judged: &Judged) -> String {
    judged.deviation().map_or_else(
        || "-".to_owned(),
        |d| format!("{:+.*} %", usize::from(d.abs() < 0.0995), d * 100.0),
    )
}

/// The verdict, with a word if the row has worsened.
fn verdict(judged: &Judged) -> String {
    let worse = if judged.has_worsened() { ", WORSE" } else { "" };
    format!("{}{worse}", judged.verdict.name())
}

/// At most 80 columns.
pub fn terminal(judged: &[Judged]) -> String {
    let mut text = String::new();
    let mut section = "";
    let _ = writeln!(text, "{:34} {:>9} {:>9} {:>8}  verdict", "", "published", "ours", "off by");
    for j in judged {
        if j.row.section != section {
            section = &j.row.section;
            let _ = writeln!(text, "{section}");
        }
        let mark = if j.row.origin == super::Origin::Calibrated { "*" } else { "" };
        let _ = writeln!(
            text,
            "  {:32} {:>9} {:>9} {:>8}  {}{mark}",
            crate_shortened(&format!("{} [{}]", j.row.id, unit(j)), 32),
            number(j.row.published),
            j.ours.map_or_else(|| "-".to_owned(), number),
            deviation(j),
            verdict(j),
        );
    }
    let _ = writeln!(text, "\n{}", summary(judged));
    let _ = writeln!(
        text,
        "* calibrated: a default was chosen with this row; all others are held out."
    );
    text
}

fn unit<'a>(judged: &'a Judged) -> &'a str {
    match judged.row.metric.unit() {
        "" => "share",
        unit => unit,
    }
}

/// At most `width` characters.
fn crate_shortened(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    text.chars().take(width - 1).chain(['…']).collect()
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
