//! `sweep --dry-run`: what a sweep would take, from a few machines on a frame of every trace.

use serde_json::{Value, json};

use super::meter::Meter;
use crate::cli::{Context, Exit, Failure, out};
use powergs_base::format::counted;
use powergs_report::document::Document;
use powergs_report::format::{engineering, significant, time};
use powergs_report::sweep as report;
use powergs_study::sweep::run::estimate::Estimate;
use powergs_study::sweep::run::{Cause, OpenedSweep};

/// Looks, times and says; `most` designs of the front would be confirmed.
///
/// # Errors
/// Exit code 3: a trace that cannot be read.
pub fn run(
    sweep: &mut OpenedSweep<'_>,
    most: u16,
    memory: usize,
    context: &Context,
) -> Result<Exit, Failure> {
    let meter = Meter::new(context);
    let Some(estimate) = Estimate::of(sweep, memory, &meter)? else {
        return Ok(Exit::Interrupted);
    };
    drop(meter);
    if context.global.json {
        out::json(&json_of(sweep, most, &estimate))?;
    } else {
        out::document(&document(sweep, most, &estimate))?;
    }
    Ok(Exit::Done)
}

fn json_of(sweep: &OpenedSweep<'_>, most: u16, seen: &Estimate) -> Value {
    let plan = &seen.plan;
    json!({
        "question": sweep.file.question,
        "points": seen.points,
        "points_of_space": sweep.designs.space.proposed().to_string(),
        "designs": ((plan.designs.len() - 1) as f64 * seen.scale).round(),
        "machines": seen.machines,
        "is_estimate": seen.scale > 1.0,
        "geometries": plan.works.len(),
        "traces": sweep.traces.len(),
        "frames": seen.cost.frames,
        "energy_tables": plan.tables,
        "excluded": plan.excluded,
        "duplicates": plan.duplicates,
        "invalid": plan.invalid.len(),
        "invalid_causes": plan.causes.iter().map(|(cause, c)| {
            json!({ "cause": cause, "points": c.points, "example": c.example.1 })
        }).collect::<Vec<_>>(),
        "carried_along": sweep.designs.space.carried().into_iter()
            .collect::<std::collections::BTreeMap<_, _>>(),
        "without_cost": sweep.designs.space.free_axes().iter().map(|f| {
            json!({ "axis": f.axis, "is_policy": f.is_policy })
        }).collect::<Vec<_>>(),
        "confirmed_at_most": most,
        "estimated_time_s": seen.seconds,
        "estimated_memory_bytes": seen.cost.bytes,
    })
}

/// For people.
fn document(sweep: &OpenedSweep<'_>, most: u16, seen: &Estimate) -> Document {
    let Estimate { plan, points, scale, machines, seconds, threads, cost } = seen;
    let about = if *scale > 1.0 { "about " } else { "" };
    let space = sweep.designs.space.proposed();
    let mut facts = vec![("Points", format!("{points} of a space of {space}"))];
    let designs = ((plan.designs.len() - 1) as f64 * scale).round();
    let machines_to_time = machines.round();
    facts.push((
        "Designs",
        format!("{about}{designs} ({about}{} to time)", counted(machines_to_time, "machine")),
    ));
    let scaled = |count: u64| format!("{about}{}", (count as f64 * scale).round());
    for (cause, count) in &plan.excluded {
        facts.push(("Excluded", format!("{} by {cause}", scaled(*count))));
    }
    for (axis, count) in &plan.duplicates {
        let what = format!("{}: axis `{axis}` does not count there", scaled(*count));
        facts.push(("Duplicates", what));
    }
    for (cause, Cause { points, example: (point, reason) }) in &plan.causes {
        let what = format!("{}: {cause}, e.g. point {point}: {reason}", scaled(*points));
        facts.push(("Invalid", what));
    }
    if let Some(reason) = &sweep.designs.base_is_first {
        facts.push(("Baseline", baseline(reason)));
    }
    for (key, expression) in sweep.designs.space.carried() {
        facts.push(("Carried along", carried(key, expression)));
    }
    let s = |n: usize| if n == 1 { "" } else { "s" };
    let (frames, traces) = (cost.frames, sweep.traces.len());
    facts.push(("Geometries", plan.works.len().to_string()));
    facts.push(("Traces", format!("{traces} with {frames} frame{}", s(frames))));
    facts.push(("Tables", format!("{} energy table{}", plan.tables, s(plan.tables))));
    let one = engineering(seen.timed_s() / frames.max(1) as f64 / machines.max(1.0), "s");
    let what = format!("on {threads} threads ({one} a machine and frame)");
    facts.push(("Time", format!("at least {} {what}", time(*seconds))));
    if most > 0 {
        let most = usize::from(most).min(designs as usize);
        let what = format!("up to {} of the front again with banked", counted(most, "design"));
        let runs = counted(most * frames, "machine-frame");
        let near = "and as many that nearly meet the display rate";
        facts.push(("Confirmed", format!("{what} ({runs} more), {near}; not in this time")));
    }
    let memory = significant(cost.bytes as f64 / 1048576.0);
    facts.push(("Memory", format!("about {memory} MiB")));
    let mut page = Document::new();
    page.paragraph(sweep.file.question.trim());
    page.facts(facts);
    page.paragraph(report::free(&sweep.designs.space.free_axes()).join(" "));
    page
}

/// A key that follows an axis by default.
pub fn carried(key: &str, expression: &str) -> String {
    format!("{key} = {expression}; an axis, `set` or `[derived]` of yours comes first")
}

/// What the baseline is where the keys of `set` make no machine of it.
pub fn baseline(reason: &String) -> String {
    format!("the first design: the base machine with the keys of `set` alone is none: {reason}")
}
