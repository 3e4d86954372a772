//! `optimize --dry-run`: what a run would take, from a few iterations of the dense model.

use std::time::Instant;

use serde_json::json;

use super::super::{Context, Exit, Failure, out};
use super::watch::Watched;
use powergs_optimize::campaign::Campaign;
use powergs_optimize::estimate::Estimate;
use powergs_report::document::Document;
use powergs_report::format::{counted, engineering, significant, time, wrapped};

/// Jobs that are named.
const NAMED: usize = 12;
/// Power views that are proposed where there are many.
const FEW: usize = 8;
/// A share of the time that is worth a word.
const MUCH: f64 = 0.25;

/// Times and says.
///
/// # Errors
/// Those of the first iterations of a run.
pub fn run(campaign: &Campaign, watched: &Watched<'_>, context: &Context) -> Result<Exit, Failure> {
    let started = Instant::now();
    let clock = || started.elapsed().as_secs_f64();
    let Some(estimate) = campaign.estimate(&clock, watched)? else {
        return Ok(Exit::Interrupted);
    };
    if context.global.json {
        out::json(&json_of(campaign, &estimate))?;
    } else {
        out::document(&document(campaign, &estimate))?;
    }
    Ok(Exit::Done)
}

fn json_of(campaign: &Campaign, seen: &Estimate) -> serde_json::Value {
    json!({
        "jobs": seen.jobs,
        "iterations": seen.iterations,
        "iteration_s": seen.iteration_s,
        "check_s": seen.check_s,
        "score_s": seen.score_s,
        "model_s": seen.model_s,
        "threads": rayon::current_num_threads(),
        "power_views": campaign.priced,
        "estimated_time_s": seen.time.total_s(),
        "estimated_iterations_s": seen.time.iterations_s,
        "estimated_checks_s": seen.time.checks_s,
        "estimated_scores_s": seen.time.scores_s,
        "estimated_models_s": seen.time.models_s,
        "estimated_memory_bytes": seen.memory_b,
        "estimated_disk_bytes": seen.disk_b,
        "references_bytes": seen.references_b,
    })
}

fn document(campaign: &Campaign, seen: &Estimate) -> Document {
    let Estimate { jobs, iterations, .. } = seen;
    let seconds = |t: f64| engineering(t, "s");
    let split = &campaign.split;
    let more = if jobs.len() > NAMED { ", …" } else { "" };
    let named = jobs[..jobs.len().min(NAMED)].join(", ");
    let mib = |bytes: u64| format!("{} MiB", significant(bytes as f64 / 1048576.0));
    let threads = counted(rayon::current_num_threads(), "thread");
    let facts = [
        ("Gaussians", campaign.dense.len().to_string()),
        (
            "Views",
            format!(
                "{} train, {} decide, {} are only reported{}",
                split.train.len(),
                campaign.gate_views(),
                split.test.len(),
                campaign.judged.note().map_or(String::new(), |note| format!("; {note}"))
            ),
        ),
        ("Power", format!("over {}", campaign.priced)),
        ("Models", wrapped(&format!("{}: {named}{more}", jobs.len()), 66)),
        ("Iterations", iterations.to_string()),
        (
            "Measured",
            wrapped(
                &format!(
                    "{} an iteration, {} a look at all views that decide, {} the scores of a \
                     prune, {} a finished model",
                    seconds(seen.iteration_s),
                    seconds(seen.check_s),
                    seconds(seen.score_s),
                    seconds(seen.model_s)
                ),
                66,
            ),
        ),
        (
            "Time",
            wrapped(
                &format!(
                    "about {} on {threads}: iterations {}, checks {}, scores {}, finished \
                     models {}",
                    time(seen.time.total_s()),
                    time(seen.time.iterations_s),
                    time(seen.time.checks_s),
                    time(seen.time.scores_s),
                    time(seen.time.models_s)
                ),
                66,
            ),
        ),
        ("Memory", format!("at most {}", mib(seen.memory_b))),
        ("Disk", format!("at most {} in the run folder", mib(seen.disk_b))),
        ("TMPDIR", format!("{} of reference images", mib(seen.references_b))),
    ];
    let mut page = Document::new();
    page.facts(facts);
    page.paragraph(
        "Times are those of a few iterations of the dense model on this machine now. Pruned models \
         take less, and a fine-tune ends early when its quality has settled; a sample that misses \
         its target may be followed by another.",
    );
    if seen.time.models_s > MUCH * seen.time.total_s() {
        page.paragraph(format!(
            "What is measured of finished models is much of it: their power is simulated over {}. \
             {}--power-size asks for smaller ones; --set dram.model=bandwidth --energy \
             gscore-28nm-flat is a cheaper memory.",
            campaign.priced,
            fewer(campaign)
        ));
    }
    page
}

/// How to count power over fewer views, where there are many.
fn fewer(campaign: &Campaign) -> String {
    let half = campaign.priced.views / 2;
    match half {
        0 | 1 => String::new(),
        half => format!("--power-views {} asks for fewer, ", half.min(FEW)),
    }
}
