//! `summary.md`: the report for people, with the charts.

use std::fmt::Write;

use super::format::{engineering, percent, rate, significant};
use super::summary_of;
use super::terminal::applies;
use super::what_if::signed_percent;
use powergs_base::TOOL_VERSION;
use powergs_chart::Chart;
use powergs_core::energy::Component;
use powergs_core::sim::MODEL_VERSION;
use powergs_frame::fovea::REGIONS;
use powergs_study::findings::breakdown::Breakdown;
use powergs_study::findings::summary::{CycleSummary, UnitSummary};
use powergs_study::findings::what_if::Cost;
use powergs_study::findings::{Bottleneck, RunSummary, bottleneck, limits};
use powergs_study::run_record::{Run, Table};

/// The summary, with links to `charts` in the same folder.
///
/// # Panics
/// Without frames.
pub fn markdown(run: &Run, charts: &[Chart]) -> String {
    let summary = summary_of(run);
    let mut text = format!("# {}\n\n", escaped(&run.title()));
    if let Some(note) = run.incomplete_note() {
        let _ = writeln!(text, "**{note}.** All numbers are for these frames only.\n");
    }
    let found = bottleneck::of(&summary);
    if let Some(found) = &found {
        let _ = writeln!(text, "{}\n", super::bottleneck::sentence(found));
    }
    facts(&mut text, run);
    key_numbers(&mut text, run, &summary);
    power(&mut text, run, &summary);
    if let Some(cycle) = &summary.cycle {
        cycles(&mut text, run, cycle);
        regions(&mut text, cycle);
    }
    what_if(&mut text, run);
    if let Some(cycle) = &summary.cycle {
        buffers(&mut text, cycle);
    }
    frames(&mut text, &Table::of(run));
    for chart in charts {
        let _ = writeln!(text, "![{}]({}.png)\n", chart.title, chart.name);
    }
    if summary.throughput_fps().is_some() {
        left_out(&mut text, run, &summary, found.as_ref());
    }
    text.push_str(
        "Every number with its unit: `results.csv`, one row per frame; `powergs-sim explain NAME` \
         defines any of them.\nWhat the run was made from: `run.toml`; what was typed: \
         `invocation.toml`.\n",
    );
    text
}

/// Names from files must not end a table cell or start markup.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match c {
            '|' | '*' | '_' | '`' | '[' | ']' | '<' | '>' | '#' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out.push('?'),
            c => out.push(c),
        }
    }
    out
}

fn facts(text: &mut String, run: &Run) {
    let facts = &run.facts;
    let _ = writeln!(text, "| | |\n|---|---|");
    let mut row = |name: &str, value: String| {
        let _ = writeln!(text, "| {name} | {value} |");
    };
    let trace = &facts.trace;
    row("trace", escaped(&trace.name));
    row("frames", format!("{} of {}x{} pixels", run.frames.len(), trace.width, trace.height));
    row("machine", escaped(&facts.machine.name));
    row("energy table", escaped(&facts.machine.energy_table));
    row("model", format!("{}, version {MODEL_VERSION}", facts.model.name()));
    row("display rate", format!("{} FPS", rate(facts.display_fps)));
    row("made with", format!("powergs-sim {TOOL_VERSION}"));
    text.push('\n');
}

fn key_numbers(text: &mut String, run: &Run, summary: &RunSummary) {
    let fps = rate(run.facts.display_fps);
    let _ = writeln!(text, "| what | value |\n|---|--:|");
    let mut row = |name: String, value: Option<String>| {
        let _ = writeln!(text, "| {name} | {} |", value.as_deref().unwrap_or("not measured"));
    };
    let ms = |x: f64| format!("{} ms", significant(x));
    let cycle = summary.cycle.as_ref();
    row("frame time, mean".into(), cycle.map(|c| ms(c.frame_time_ms)));
    row("frame time, p99".into(), cycle.map(|c| ms(c.frame_time_p99_ms)));
    row("frames per second".into(), summary.throughput_fps().map(significant));
    row(
        format!("deadline misses at {fps} FPS"),
        cycle.map(|c| format!("{} of {}", c.deadline_misses, run.frames.len())),
    );
    let energy = engineering(summary.energy.total_pj * 1e-12, "J");
    row("energy per frame".into(), Some(energy));
    let watts = |x: Option<f64>| x.map(|w| engineering(w, "W"));
    row("power at full rate".into(), watts(summary.throughput_power_w()));
    row(format!("power at the display rate, {fps} FPS"), watts(Some(summary.power_w)));
    row("display power".into(), watts(summary.display_w));
    row(
        "accelerator at the display rate + display".into(),
        watts(summary.rendering_plus_display_w),
    );
    text.push('\n');
}

/// R1 to R4, where frames are foveated and have a time.
fn regions(text: &mut String, cycle: &CycleSummary) {
    let Some(regions) = &cycle.regions else { return };
    let _ = writeln!(text, "## Regions around the gaze, a frame\n");
    let _ = writeln!(text, "| region | tiles | splats loaded | VRU cycles | energy |");
    let _ = writeln!(text, "|---|--:|--:|--:|--:|");
    for (name, region) in REGIONS.into_iter().zip(regions) {
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} | {} |",
            significant(region.tiles),
            significant(region.entries),
            significant(region.cycles),
            engineering(region.energy_pj * 1e-12, "J")
        );
    }
    let _ = writeln!(
        text,
        "\nSorting and rendering of the tiles of each region; preprocessing and what is paid for \
         time belong to none.\n"
    );
}

fn power(text: &mut String, run: &Run, summary: &RunSummary) {
    let fps = run.facts.display_fps;
    let power = Breakdown::power_w(summary, fps);
    let _ = writeln!(text, "## Power at {} FPS, mW\n", rate(fps));
    let names = Component::ALL.map(Component::name).join(" | ");
    let _ = writeln!(text, "| stage | {names} | total |");
    let _ = writeln!(text, "|---|{}--:|", "--:|".repeat(Component::ALL.len()));
    let mw = |x: f64| significant(x * 1e3);
    for stage in power.shown() {
        let _ = write!(text, "| {} |", stage.name());
        for c in Component::ALL {
            let cell = if applies(stage, c) { mw(power.part(stage, c)) } else { "-".into() };
            let _ = write!(text, " {cell} |");
        }
        let _ = writeln!(text, " {} |", mw(power.stage(stage)));
    }
    let _ = write!(text, "| total |");
    for c in Component::ALL {
        let _ = write!(text, " {} |", mw(power.component(c)));
    }
    let _ = writeln!(text, " {} |\n", mw(summary.power_w));
}

fn cycles(text: &mut String, run: &Run, cycle: &CycleSummary) {
    let _ = writeln!(text, "## Where the cycles go, %\n");
    let columns = "--:|".repeat(UnitSummary::PARTS.len());
    let _ = writeln!(text, "| unit | {} |\n|---|{columns}", UnitSummary::PARTS.join(" | "));
    for row in &cycle.units {
        let shares = row.shares().map(percent).join(" | ");
        let _ = writeln!(text, "| {} x{} | {shares} |", row.unit.name(), row.instances);
    }
    text.push_str("\nBetween busy and idle: what a unit with work waited for.\n");
    let dram = &cycle.dram;
    let rate = dram.bandwidth_gb_s.map(significant);
    if let (Some(rate), Some(peak)) = (rate, run.facts.machine.dram_peak_gb_s) {
        let _ = write!(text, "\nDRAM: {rate} of {} GB/s over the frame time", significant(peak));
        if let Some(hits) = dram.row_hit_frac {
            let _ = write!(text, ", {} % row hits", percent(hits));
        }
        if let Some(ratio) = dram.moved_per_requested {
            let _ = write!(text, ", {} bytes moved per byte asked for", significant(ratio));
        }
        text.push_str(".\n");
    }
    if let Some(lanes) = cycle.lane_utilisation {
        let share = percent(lanes);
        let _ = writeln!(text, "\nLanes of a rendering core at work while it is busy: {share} %.");
    }
    text.push('\n');
}

/// What doubling each resource would buy.
fn what_if(text: &mut String, run: &Run) {
    let Some(experiment) = &run.extras.what_if else { return };
    let frames: Vec<String> = experiment.frames.iter().map(usize::to_string).collect();
    let which = if frames.len() == 1 { "frame" } else { "frames" };
    let _ = writeln!(text, "## What one step would buy\n");
    let _ = writeln!(text, "Each resource doubled, simulated on {which} {}.\n", frames.join(", "));
    let _ = writeln!(text, "| doubled | ms per frame | change | mJ per frame | change |");
    let _ = writeln!(text, "|---|--:|--:|--:|--:|");
    let mut row = |name: &str, cost: &Cost, changes: [String; 2]| {
        let (ms, mj) = (significant(cost.frame_time_ms), significant(cost.energy_pj * 1e-9));
        let [time, energy] = changes;
        let _ = writeln!(text, "| {name} | {ms} | {time} | {mj} | {energy} |");
    };
    row("nothing", &experiment.base, [String::new(), String::new()]);
    for step in &experiment.steps {
        let changes = [experiment.time_change(step), experiment.energy_change(step)];
        let changes = changes.map(|c| signed_percent(c).trim().to_owned());
        row(step.resource, &step.cost, changes);
    }
    text.push('\n');
    for skipped in &experiment.skipped {
        let _ = writeln!(text, "- {}: not tried: {}", skipped.resource, skipped.reason);
    }
    if !experiment.skipped.is_empty() {
        text.push('\n');
    }
    if let Some(models) = run.extras.dram_models {
        let _ = writeln!(text, "{}", super::terminal::dram_models(&models));
    }
}

/// What the buffers held, where it was measured.
fn buffers(text: &mut String, cycle: &CycleSummary) {
    let mut rows = String::new();
    for buffer in cycle.buffers.iter().filter(|b| b.capacity > 0) {
        let Some(mean) = buffer.mean else { continue };
        let (name, capacity) = (buffer.buffer.name(), buffer.capacity as f64);
        let moved = [buffer.filled, buffer.consumed, buffer.discarded];
        let [filled, consumed, discarded] = moved.map(|bytes| engineering(bytes, "B"));
        let _ = writeln!(
            rows,
            "| {name} | {:.0} | {} | {} | {filled} | {consumed} | {discarded} |",
            capacity / 1024.0,
            percent(buffer.peak / capacity),
            percent(mean / capacity),
        );
    }
    if !rows.is_empty() {
        let _ = writeln!(text, "## Buffers\n");
        let _ =
            writeln!(text, "| buffer | KiB | peak % | mean % | filled | consumed | discarded |");
        let _ = writeln!(text, "|---|--:|--:|--:|--:|--:|--:|\n{rows}");
    }
}

/// What the model leaves out, and the assumptions that mattered.
fn left_out(text: &mut String, run: &Run, summary: &RunSummary, found: Option<&Bottleneck>) {
    let _ = writeln!(text, "## What is not modelled\n");
    let _ = writeln!(text, "| effect | simulated time is | see |\n|---|---|---|");
    for effect in limits::left_out(run.facts.machine.dram_model) {
        let _ =
            writeln!(text, "| {} | {} | {} |", effect.what, effect.bias.name(), effect.assumption);
    }
    let mattered = limits::mattered(summary, found, run.extras.what_if.as_ref());
    if !mattered.is_empty() {
        let _ = writeln!(text, "\nAssumptions that mattered most in this run:\n");
        for same in mattered.chunk_by(|a, b| a.why == b.why) {
            let numbers: Vec<&str> = same.iter().map(|m| m.assumption).collect();
            let _ =
                writeln!(text, "- {}: {}", numbers.join(", "), super::limits::why(&same[0].why));
        }
    }
    text.push('\n');
}

/// Statistics of `summary.md`; all others are in `results.csv`.
const SHOWN: [&str; 12] = [
    "frame_time_ms",
    "power_w.total",
    "energy_pj.total",
    "display_power_w",
    "dram_read_bytes",
    "dram_write_bytes",
    "counters.points",
    "counters.survivors",
    "counters.tile_pairs",
    "counters.tile_loads",
    "counters.alpha_evaluations",
    "counters.blends",
];

/// Three significant digits; large numbers with a prefix, the unit being in the name.
fn short(x: f64) -> String {
    if x.abs() < 1e4 { significant(x) } else { engineering(x, "") }
}

fn frames(text: &mut String, table: &Table) {
    let _ = writeln!(text, "## Over the frames\n");
    let _ =
        writeln!(text, "| statistic | mean | p50 | p95 | p99 | max |\n|---|--:|--:|--:|--:|--:|");
    for name in SHOWN {
        let cells = match table.aggregate(name) {
            Some(a) => a.parts().map(|v| short(v.as_f64())).join(" | "),
            None => ["-"; 5].join(" | "),
        };
        let _ = writeln!(text, "| {name} | {cells} |");
    }
    text.push('\n');
}
