//! `report.html`: the whole answer in one file that needs no network and prints well.

use minijinja::Environment;
use serde_json::{Value as Json, json};

use super::page::{self, Grid};
use super::words;
use crate::ReportError;
use crate::charts::Chart;
use powergs_base::TOOL_VERSION;
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

const TEMPLATE: &str = include_str!("report.html");

/// The page, with the charts inside.
///
/// # Errors
/// [`ReportError`], which would be a mistake of ours.
pub fn html(
    analysis: &Analysis,
    charts: &[Chart],
    provenance: &Provenance,
) -> Result<String, ReportError> {
    let figure = |chart: &Chart| -> Result<Json, ReportError> {
        Ok(json!({ "title": chart.title, "svg": chart.drawing.svg()? }))
    };
    let figures: Vec<Json> = charts.iter().map(figure).collect::<Result<_, _>>()?;
    let sheet = |(title, head, rows): Grid| json!({ "title": title, "head": head, "rows": rows });
    let mut sheets = vec![sheet(page::front_grid(analysis))];
    if !analysis.stability.alternatives.is_empty() {
        sheets.push(sheet(page::stability_grid(analysis)));
        sheets.push(sheet(page::ranks_grid(analysis)));
    }
    sheets.push(sheet(page::axes_grid(analysis)));
    let around = |row: u32, steps: &[Neighbour]| {
        let line = |step| words::neighbour(analysis, row, step);
        let lines: Vec<String> = steps.iter().map(line).collect();
        json!({ "label": analysis.table.label(row), "lines": lines })
    };
    let mut neighbours = vec![around(analysis.knee, &analysis.around_knee)];
    neighbours.extend(analysis.baseline.map(|row| around(row, &analysis.around_baseline)));
    let reasons: Vec<String> =
        analysis.table.reasons.iter().take(20).map(|(why, n)| format!("{n} x {why}")).collect();
    let mut environment = Environment::new();
    let failed = |e: minijinja::Error| ReportError::Template(e.to_string());
    // The ending tells the engine to escape for HTML.
    environment.add_template("report.html", TEMPLATE).map_err(failed)?;
    let template = environment.get_template("report.html").map_err(failed)?;
    let question = &analysis.question;
    let filling = json!({
        "title": provenance.title,
        "question": question.text,
        "objectives": words::objectives(&question.objectives),
        "condition": question.condition.as_ref().map(|c| c.text()),
        "scope": question.scope.to_string(),
        "energy_table": analysis.energy_table,
        "answer": page::answer(analysis),
        "figures": figures,
        "sheets": sheets,
        "neighbours": neighbours,
        "reasons": reasons,
        "commands": provenance.commands,
        "limits": page::LIMITS,
        "tool_version": TOOL_VERSION,
        "model_version": MODEL_VERSION,
    });
    template.render(minijinja::value::Serde(&filling)).map_err(failed)
}
