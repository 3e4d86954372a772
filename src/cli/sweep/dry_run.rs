//! `sweep --dry-run`: what a sweep would take, from a few machines on a frame of every trace.

use serde_json::{Value, json};

use super::meter::Meter;
use crate::cli::{Context, Exit, Failure, out};
use powergs_report::document::Document;
use powergs_report::format::{engineering, significant};
use powergs_study::sweep::run::OpenedSweep;
use powergs_study::sweep::run::estimate::Estimate;

/// Looks, times and says.
///
/// # Errors
/// Exit code 3: a trace that cannot be read.
pub fn run(sweep: &mut OpenedSweep<'_>, memory: usize, context: &Context) -> Result<Exit, Failure> {
    let meter = Meter::new(context);
    let Some(estimate) = Estimate::of(sweep, memory, &meter)? else {
        return Ok(Exit::Interrupted);
    };
    drop(meter);
    if context.global.json {
        out::json(&json_of(sweep, &estimate))?;
    } else {
        out::document(&document(sweep, &estimate))?;
    }
    Ok(Exit::Done)
}

fn json_of(sweep: &OpenedSweep<'_>, seen: &Estimate) -> Value {
    let plan = &seen.plan;
    json!({
        "question": sweep.file.question,
        "points": seen.points,
        "points_of_space": sweep.designs.space.proposed().to_string(),
        "designs": ((plan.designs.len() - 1) as f64 * seen.scale).round(),
        "machines": seen.machines,
        "is_estimate": seen.scale > 1.0,
        "geometries": plan.geometries.len(),
        "traces": sweep.traces.len(),
        "frames": seen.cost.frames,
        "energy_tables": plan.tables,
        "excluded": plan.excluded,
        "invalid": plan.invalid.len(),
        "estimated_time_s": seen.seconds,
        "estimated_memory_bytes": seen.cost.bytes,
    })
}

/// For people.
fn document(sweep: &OpenedSweep<'_>, seen: &Estimate) -> Document {
    let Estimate { plan, points, scale, machines, seconds, threads, cost } = seen;
    let about = if *scale > 1.0 { "about " } else { "" };
    let space = sweep.designs.space.proposed();
    let mut facts = vec![("Points", format!("{points} of a space of {space}"))];
    let designs = ((plan.designs.len() - 1) as f64 * scale).round();
    let machines_to_time = machines.round();
    facts.push((
        "Designs",
        format!("{about}{designs} ({about}{machines_to_time} machines to time)"),
    ));
    for (cause, count) in &plan.excluded {
        let count = (*count as f64 * scale).round();
        facts.push(("", format!("{about}{count} left out: {cause}")));
    }
    if let Some((point, reason)) = plan.invalid.first() {
        let count = (plan.invalid.len() as f64 * scale).round();
        let what = format!("are no machine, e.g. point {point}: {reason}");
        facts.push(("", format!("{about}{count} {what}")));
    }
    let s = |n: usize| if n == 1 { "" } else { "s" };
    let (frames, traces) = (cost.frames, sweep.traces.len());
    facts.push(("Geometries", plan.geometries.len().to_string()));
    facts.push(("Traces", format!("{traces} with {frames} frame{}", s(frames))));
    facts.push(("Tables", format!("{} energy table{}", plan.tables, s(plan.tables))));
    let one = engineering(seen.timed_s() / frames.max(1) as f64 / machines.max(1.0), "s");
    let what = format!("on {threads} threads ({one} a machine and frame)");
    facts.push(("Time", format!("about {} {what}", time(*seconds))));
    let memory = significant(cost.bytes as f64 / 1048576.0);
    facts.push(("Memory", format!("about {memory} MiB")));
    let mut page = Document::new();
    page.paragraph(sweep.file.question.trim());
    page.facts(facts);
    page
}

/// A time for people.
fn time(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{} s", significant(s)),
        s if s < 5400.0 => format!("{} min", significant(s / 60.0)),
        s => format!("{} h", significant(s / 3600.0)),
    }
}
