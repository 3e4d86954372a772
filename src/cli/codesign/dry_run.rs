//! `codesign --dry-run`: how much there is to do.

use serde_json::json;

use super::super::{Context, Exit, Failure, out};
use powergs_codesign::{Codesign, CodesignError};
use powergs_report::document::Document;

/// Counts and says what a co-design would do.
///
/// # Errors
/// Exit code 2: a space that cannot be.
pub fn run(codesign: &Codesign, context: &Context) -> Result<Exit, Failure> {
    let campaign = &codesign.campaign;
    let models = codesign.models.len() as u64;
    let machines = codesign.machines_most().map_err(CodesignError::from)?;
    let views = campaign.given.count as u64;
    let iterations = u64::from(codesign.iterations);
    // The dense model is not fine-tuned.
    let tuned = models - 1;
    let left_out = &codesign.machines.left_out;
    if context.global.json {
        let left: Vec<_> = left_out
            .iter()
            .map(|(table, why)| json!({ "energy_table": table, "reason": why }))
            .collect();
        out::json(&json!({
            "models": models,
            "iterations_at_most": tuned * iterations,
            "machines_at_most": machines,
            "pairs_at_most": models * machines,
            "views": views,
            "machine_frames_at_most": models * machines * views,
            "rounds_at_most": codesign.rounds,
            "energy_tables_left_out": left,
        }))?;
        return Ok(Exit::Done);
    }
    if context.global.quiet {
        return Ok(Exit::Done);
    }
    let mut page = Document::new();
    page.facts(vec![
        ("Models", format!("{models}, the dense one among them")),
        ("Fine-tunes", format!("{tuned} of {iterations} iterations at most")),
        ("Machines", format!("{machines} at most, the base machine among them")),
        ("Pairs", format!("{} at most", models * machines)),
        (
            "Simulated",
            format!("{} machine-frames at most, {views} views", models * machines * views),
        ),
        (
            "Rounds",
            format!("{} at most, each a further fine-tune on all machines", codesign.rounds),
        ),
    ]);
    for (table, why) in left_out {
        page.paragraph(format!("The energy table `{table}` is left out: {why}"));
    }
    out::document(&page)?;
    Ok(Exit::Done)
}
