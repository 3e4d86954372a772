//! `sweep --dry-run`: what a sweep would take, from a few machines on a frame of every trace.

use serde_json::{Value, json};

use super::meter::Meter;
use crate::cli::{Context, Exit, Failure, out};
use powergs_report::format::{engineering, significant, wrapped};
use powergs_study::sweep::run::OpenedSweep;
use powergs_study::sweep::run::estimate::Estimate;

/// What a further line of the list begins with.
const INDENT: &str = "\n            ";

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
        out::text(&text_of(sweep, &estimate))?;
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

fn text_of(sweep: &OpenedSweep<'_>, seen: &Estimate) -> String {
    let Estimate { plan, points, scale, machines, seconds, threads, cost } = seen;
    let about = if *scale > 1.0 { "about " } else { "" };
    let mut text = format!("{}\n\n", wrapped(sweep.file.question.trim(), 80));
    let space = sweep.designs.space.proposed();
    text += &format!("Points      {points} of a space of {space}\n");
    let designs = ((plan.designs.len() - 1) as f64 * scale).round();
    text += &format!("Designs     {about}{designs}");
    text += &format!(" ({about}{} machines to time)\n", machines.round());
    for (cause, count) in &plan.excluded {
        let count = (*count as f64 * scale).round();
        text += &format!("            {about}{count} left out: {cause}\n");
    }
    if let Some((point, reason)) = plan.invalid.first() {
        let count = (plan.invalid.len() as f64 * scale).round();
        let what = format!("are no machine, e.g. point {point}: {reason}");
        let what = wrapped(&format!("{about}{count} {what}"), 68).replace('\n', INDENT);
        text += &format!("            {what}\n");
    }
    text += &format!("Geometries  {}\n", plan.geometries.len());
    let frames = cost.frames;
    let s = |n: usize| if n == 1 { "" } else { "s" };
    let some = s(frames);
    text += &format!("Traces      {} with {frames} frame{some}\n", sweep.traces.len());
    let s = s(plan.tables);
    text += &format!("Tables      {} energy table{s}\n", plan.tables);
    let one = engineering(seen.timed_s() / frames.max(1) as f64 / machines.max(1.0), "s");
    let what = format!("on {threads} threads ({one} a machine and frame)");
    text += &format!("Time        about {} {what}\n", time(*seconds));
    text + &format!("Memory      about {} MiB\n", significant(cost.bytes as f64 / 1048576.0))
}

/// A time for people.
fn time(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{} s", significant(s)),
        s if s < 5400.0 => format!("{} min", significant(s / 60.0)),
        s => format!("{} h", significant(s / 3600.0)),
    }
}
