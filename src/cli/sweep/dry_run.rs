//! `sweep --dry-run`: what a sweep would take, from a few machines on a frame of every trace.

use serde_json::{Value, json};

use super::estimate::{Cost, cost};
use super::opened::Opened;
use super::plan::Plan;
use crate::cli::progress::Progress;
use crate::cli::{Context, Exit, Failure, out};
use powergs_report::format::{engineering, significant, wrapped};

/// Points that are looked at; of larger spaces this many are taken to stand for all.
const LOOKED_AT: u64 = 20_000;

/// What a further line of the list begins with.
const INDENT: &str = "\n            ";

/// Looks, times and says.
///
/// # Errors
/// Exit code 3: a trace that cannot be read.
pub fn run(opened: &mut Opened, memory: usize, context: &Context) -> Result<Exit, Failure> {
    let points = points(opened);
    let Some(plan) = sampled(opened, points, context) else { return Ok(Exit::Interrupted) };
    let looked_at = (plan.designs.len() - 1) as u64
        + plan.excluded.values().sum::<u64>()
        + plan.invalid.len() as u64;
    let scale = points as f64 / looked_at.max(1) as f64;
    let machines = plan.machines(super::folder::Shard::WHOLE).len() as f64 * scale;
    let cost = cost(opened, &plan, scale, memory)?;
    let threads = rayon::current_num_threads() as f64;
    let mut seen = Seen { points, scale, machines, seconds: 0.0, threads, cost };
    let bins = seen.cost.bin_s * plan.geometries.len() as f64;
    seen.seconds = bins + timed(&seen) / threads;
    if context.global.json {
        out::json(&json_of(opened, &plan, &seen))?;
    } else {
        out::text(&text_of(opened, &plan, &seen))?;
    }
    Ok(Exit::Done)
}

/// What was found out.
struct Seen {
    points: u64,
    /// Points for each that was looked at.
    scale: f64,
    machines: f64,
    seconds: f64,
    threads: f64,
    cost: Cost,
}

/// Seconds of all machines on all frames, on one thread.
fn timed(seen: &Seen) -> f64 {
    let cost = &seen.cost;
    cost.machine_s * seen.machines + cost.preprocessing_s * cost.preprocessings
}

/// How many points the sweep takes, at most.
fn points(opened: &Opened) -> u64 {
    if !opened.is_adaptive() {
        return opened.space.selected().size_hint().1.unwrap_or(usize::MAX) as u64;
    }
    let s = opened.space.sampling();
    let most = u64::from(s.population) * u64::from(s.generations);
    most.min(s.points.unwrap_or(u64::MAX)).min(opened.space.lattice().points())
}

/// The plan of some points: evenly over the selection, or over the space where points are asked
/// for later. `None` if the user broke off.
fn sampled(opened: &Opened, points: u64, context: &Context) -> Option<Plan> {
    let all = u128::from(opened.space.lattice().points());
    let spread = points.min(LOOKED_AT);
    let progress = Progress::new(context, spread, "designs looked at");
    let step = (points / spread.max(1)).max(1) as usize;
    let evenly = move |i: u64| (u128::from(i) * all / u128::from(spread)) as u64;
    let sample: Box<dyn Iterator<Item = u64>> = match opened.is_adaptive() {
        true => Box::new((0..spread).map(evenly)),
        false => Box::new(opened.space.selected().step_by(step).take(spread as usize)),
    };
    Plan::of(opened, sample, context, |n| progress.advance(n))
}

fn json_of(opened: &Opened, plan: &Plan, seen: &Seen) -> Value {
    json!({
        "question": opened.file.question,
        "points": seen.points,
        "points_of_space": opened.space.proposed().to_string(),
        "designs": ((plan.designs.len() - 1) as f64 * seen.scale).round(),
        "machines": seen.machines,
        "is_estimate": seen.scale > 1.0,
        "geometries": plan.geometries.len(),
        "traces": opened.traces.len(),
        "frames": seen.cost.frames,
        "energy_tables": plan.tables,
        "excluded": plan.excluded,
        "invalid": plan.invalid.len(),
        "estimated_time_s": seen.seconds,
        "estimated_memory_bytes": seen.cost.bytes,
    })
}

fn text_of(opened: &Opened, plan: &Plan, seen: &Seen) -> String {
    let Seen { points, scale, machines, seconds, threads, cost } = seen;
    let about = if *scale > 1.0 { "about " } else { "" };
    let mut text = format!("{}\n\n", wrapped(opened.file.question.trim(), 80));
    let space = opened.space.proposed();
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
    text += &format!("Traces      {} with {frames} frame{some}\n", opened.traces.len());
    let s = s(plan.tables);
    text += &format!("Tables      {} energy table{s}\n", plan.tables);
    let one = engineering(timed(seen) / frames.max(1) as f64 / machines.max(1.0), "s");
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
