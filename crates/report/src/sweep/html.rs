//! `report.html`: the whole answer in one file that needs no network and prints well.

use super::page::{self, Grid};
use super::words;
use crate::ReportError;
use powergs_base::TOOL_VERSION;
use powergs_chart::Chart;
use powergs_core::sim::MODEL_VERSION;
use powergs_study::analysis::Analysis;
use powergs_study::analysis::marginal::Neighbour;

/// What the report says about how it was made.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Provenance {
    /// Name of the sweep, for titles.
    pub title: String,
    /// The commands that made it, in order.
    pub commands: Vec<String>,
}

const STYLE: &str = include_str!("report.css");

/// The page, with the charts inside.
///
/// # Errors
/// [`ReportError`], which would be a mistake of ours.
pub fn html(
    analysis: &Analysis,
    charts: &[Chart],
    provenance: &Provenance,
) -> Result<String, ReportError> {
    let title = escaped(&provenance.title);
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n"
    );
    page += &question(analysis);
    page += "<h2>Answer</h2>\n";
    page += &elements("p", &page::answer(analysis));
    page += "\n<h2>Charts</h2>\n";
    for chart in charts {
        let title = escaped(chart.title);
        page += &format!("<figure role=\"img\" aria-label=\"{title}\">\n");
        page += &chart.svg()?;
        page += "\n</figure>\n";
    }
    page += "\n";
    page += &neighbours(analysis, analysis.knee, &analysis.around_knee);
    if let Some(row) = analysis.baseline {
        page += &neighbours(analysis, row, &analysis.around_baseline);
    }
    page += "\n";
    page += &table(&page::front_grid(analysis));
    if !analysis.stability.alternatives.is_empty() {
        page += &table(&page::stability_grid(analysis));
        page += &table(&page::ranks_grid(analysis));
    }
    page += &table(&page::axes_grid(analysis));
    page += "\n";
    let reasons: Vec<String> =
        analysis.table.reasons.iter().take(20).map(|(why, n)| format!("{n} x {why}")).collect();
    if !reasons.is_empty() {
        page += "<h2>Designs that were not simulated</h2>\n<ul>\n";
        page += &elements("li", &reasons);
        page += "</ul>\n";
    }
    page += "\n";
    if !provenance.commands.is_empty() {
        page += "<h2>Commands</h2>\n<pre>";
        for command in &provenance.commands {
            page += &escaped(command);
            page.push('\n');
        }
        page += "</pre>\n";
    }
    page += &format!(
        "\n<h2>Limits</h2>\n<p>{}</p>\n<p class=\"facts\">Model version {MODEL_VERSION}; \
         powergs-sim {}.</p>\n</body>\n</html>",
        escaped(page::LIMITS),
        escaped(TOOL_VERSION),
    );
    Ok(page)
}

/// The question, and what it was asked about.
fn question(analysis: &Analysis) -> String {
    let question = &analysis.question;
    let mut text = match question.text.is_empty() {
        true => "\n".to_owned(),
        false => format!("<blockquote>{}</blockquote>\n", escaped(&question.text)),
    };
    text += &format!(
        "<p class=\"facts\">{}; {}, energy table {}",
        escaped(&words::objectives(&question.objectives)),
        escaped(&question.scope.to_string()),
        escaped(&analysis.energy_table),
    );
    if let Some(condition) = &question.condition {
        text += &format!("; condition <code>{}</code>", escaped(condition.text()));
    }
    text + "</p>\n"
}

fn neighbours(analysis: &Analysis, row: u32, steps: &[Neighbour]) -> String {
    if steps.is_empty() {
        return String::new();
    }
    let lines: Vec<String> =
        steps.iter().map(|step| words::neighbour(analysis, row, step)).collect();
    let label = escaped(&analysis.table.label(row));
    format!("<h2>One step from {label}</h2>\n<ul>\n{}</ul>\n", elements("li", &lines))
}

fn table((title, head, rows): &Grid) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let cells = |tag: &str, cells: &[String]| {
        let cell = |text: &String| format!("<{tag}>{}</{tag}>", escaped(text));
        cells.iter().map(cell).collect::<String>()
    };
    let mut text = format!(
        "<h2>{}</h2>\n<div class=\"scroll\"><table>\n<thead><tr>{}</tr></thead>\n<tbody>\n",
        escaped(title),
        cells("th", head),
    );
    for row in rows {
        text += &format!("<tr>{}</tr>\n", cells("td", row));
    }
    text + "</tbody>\n</table></div>\n"
}

/// An element a line.
fn elements(tag: &str, texts: &[String]) -> String {
    texts.iter().map(|text| format!("<{tag}>{}</{tag}>\n", escaped(text))).collect()
}

/// Text that stands for itself in HTML.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            '\'' => safe += "&#x27;",
            '/' => safe += "&#x2f;",
            other => safe.push(other),
        }
    }
    safe
}
