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
        out::json(&json_of(&estimate))?;
    } else {
        out::document(&document(campaign, &estimate))?;
    }
    Ok(Exit::Done)
}

fn json_of(seen: &Estimate) -> serde_json::Value {
    json!({
        "jobs": seen.jobs,
        "iterations": seen.iterations,
        "iteration_s": seen.iteration_s,
        "check_s": seen.check_s,
        "model_s": seen.model_s,
        "threads": rayon::current_num_threads(),
        "estimated_time_s": seen.time_s,
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
                "{} train, {} decide, {} are only reported",
                split.train.len(),
                campaign.gate_views(),
                split.test.len()
            ),
        ),
        ("Models", wrapped(&format!("{}: {named}{more}", jobs.len()), 66)),
        ("Iterations", iterations.to_string()),
        (
            "Measured",
            format!(
                "{} an iteration, {} a check of the quality, {} a finished model",
                seconds(seen.iteration_s),
                seconds(seen.check_s),
                seconds(seen.model_s)
            ),
        ),
        ("Time", format!("about {} on {threads}", time(seen.time_s))),
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
    page
}
