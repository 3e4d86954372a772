//! `summary.md`: the report for people, with the charts.

use std::fmt::Write;

use super::breakdown::{Breakdown, CycleRow};
use super::charts::Chart;
use super::format::{engineering, percent, rate, significant};
use super::terminal::applies;
use super::{MODEL_VERSION, Run, TOOL_VERSION, Table, bottleneck};
use crate::energy::Component;

/// The summary, with links to `charts` in the same folder.
pub fn markdown(run: &Run, table: &Table, charts: &[Chart]) -> String {
    let mut text = format!("# {}\n\n", escaped(&run.title()));
    if let Some(note) = run.incomplete_note() {
        let _ = writeln!(text, "**{note}.** All numbers are for these frames only.\n");
    }
    if let Some(found) = bottleneck::of(run, table) {
        let _ = writeln!(text, "{}\n", found.sentence);
    }
    facts(&mut text, run);
    key_numbers(&mut text, run, table);
    power(&mut text, run, table);
    cycles(&mut text, run, table);
    frames(&mut text, table);
    for chart in charts {
        let _ = writeln!(text, "![{}]({}.png)\n", chart.title, chart.name);
    }
    text.push_str(
        "Every number with its unit: `results.csv`, one row per frame; `powergs-sim explain NAME` \
         defines any of them.\nWhat the run was made from: `run.toml`; what was typed: \
         `invocation.toml`.\n",
    );
    text
}

/// Names from files must not end a table cell or start markup.
fn escaped(text: &str) -> String {
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

fn key_numbers(text: &mut String, run: &Run, table: &Table) {
    let fps = rate(run.facts.display_fps);
    let _ = writeln!(text, "| what | value |\n|---|--:|");
    let mut row = |name: String, value: Option<String>| {
        let _ = writeln!(text, "| {name} | {} |", value.as_deref().unwrap_or("not measured"));
    };
    let ms = |x: f64| format!("{} ms", significant(x));
    let time = table.aggregate("frame_time_ms");
    row("frame time, mean".into(), time.map(|t| ms(t.mean)));
    row("frame time, p99".into(), time.map(|t| ms(t.p99.as_f64())));
    row("frames per second".into(), table.throughput_fps.map(significant));
    row(
        format!("deadline misses at {fps} FPS"),
        table.deadline_misses.map(|n| format!("{n} of {}", run.frames.len())),
    );
    let energy = table.mean("energy_pj.total").map(|pj| engineering(pj * 1e-12, "J"));
    row("energy per frame".into(), energy);
    let watts = |x: Option<f64>| x.map(|w| engineering(w, "W"));
    row("power at full rate".into(), watts(table.throughput_power_w));
    row(format!("power at the display rate, {fps} FPS"), watts(table.mean("power_w.total")));
    row("display power".into(), watts(table.mean("display_power_w")));
    row(
        "accelerator at the display rate + display".into(),
        watts(table.mean("rendering_plus_display_w")),
    );
    text.push('\n');
}

fn power(text: &mut String, run: &Run, table: &Table) {
    let fps = run.facts.display_fps;
    let Some(power) = Breakdown::power_w(table, fps) else { return };
    let _ = writeln!(text, "## Power at {} FPS, mW\n", rate(fps));
    let _ = write!(text, "| stage |");
    for c in Component::ALL {
        let _ = write!(text, " {} |", c.name());
    }
    let _ = writeln!(text, " total |\n|---|--:|--:|--:|--:|--:|--:|");
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
    let total = table.mean("power_w.total").unwrap_or_default();
    let _ = writeln!(text, " {} |\n", mw(total));
}

fn cycles(text: &mut String, run: &Run, table: &Table) {
    let rows = CycleRow::all(run, table);
    if rows.is_empty() {
        return;
    }
    let _ = writeln!(text, "## Where the cycles go, %\n");
    let _ = writeln!(text, "| unit | {} |\n|---|--:|--:|--:|--:|--:|", CycleRow::PARTS.join(" | "));
    for row in rows {
        let shares = row.shares().map(percent).join(" | ");
        let _ = writeln!(text, "| {} x{} | {shares} |", row.unit, row.instances);
    }
    let rate = table.mean("dram.bandwidth_gb_s").map(significant);
    if let (Some(rate), Some(peak)) = (rate, run.facts.machine.dram_peak_gb_s) {
        let _ = writeln!(text, "\nDRAM: {rate} of {} GB/s over the frame time.", significant(peak));
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
