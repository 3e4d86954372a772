//! The summary that `replay` prints: at most 80 columns, about 25 lines.

use std::fmt::Write;

use super::breakdown::{Breakdown, CycleRow};
use super::format::{engineering, percent, prefix_of, rate, shortened, significant, wrapped};
use super::{Run, Table, bottleneck};
use crate::action::Stage;
use crate::energy::Component;

/// Widest line.
const WIDTH: usize = 80;

/// The summary. `folder` is where the report is, `next` a command to try.
pub fn summary(run: &Run, table: &Table, folder: Option<&str>, next: Option<&str>) -> String {
    let mut sections = vec![head(run), times_and_powers(run, table)];
    sections.push(power_table(run, table).unwrap_or_default());
    sections.push(cycle_table(run, table));
    sections.push(display(table).unwrap_or_default());
    if let Some(found) = bottleneck::of(run, table) {
        sections.push(format!("{}\n", wrapped(&found.sentence, WIDTH)));
    }
    let mut end = String::new();
    if let Some(folder) = folder {
        let _ = writeln!(end, "report  {folder}");
    }
    if let Some(next) = next {
        let _ = writeln!(end, "next    {next}");
    }
    sections.push(end);
    sections.retain(|s| !s.is_empty());
    sections.join("\n")
}

fn head(run: &Run) -> String {
    let facts = &run.facts;
    let frames = match run.frames.len() {
        1 => "1 frame".to_owned(),
        n => format!("{n} frames"),
    };
    let tail = format!(
        ": {frames} of {}x{}, {} model",
        facts.trace.width,
        facts.trace.height,
        facts.model.name()
    );
    let title = shortened(&run.title(), WIDTH.saturating_sub(tail.chars().count()));
    let mut text = format!("{title}{tail}\n");
    if let Some(note) = run.incomplete_note() {
        let _ = writeln!(text, "{note}; all numbers below are for these only");
    }
    text
}

fn times_and_powers(run: &Run, table: &Table) -> String {
    let fps = rate(run.facts.display_fps);
    let mut text = String::new();
    match (table.aggregate("frame_time_ms"), table.throughput_fps, table.deadline_misses) {
        (Some(ms), Some(rate), Some(misses)) => {
            let _ = writeln!(
                text,
                "frame time   mean {} ms, p99 {} ms, max {} ms: {} FPS",
                significant(ms.mean),
                significant(ms.p99.as_f64()),
                significant(ms.max.as_f64()),
                significant(rate),
            );
            let deadline = significant(1e3 / run.facts.display_fps);
            let missed = format!("{misses} of {} frames missed", run.frames.len());
            let _ = writeln!(text, "deadline     {deadline} ms at {fps} FPS: {missed}");
        }
        _ => text.push_str("frame time   not in this model, which counts work only\n"),
    }
    let mut power = |what: String, value: Option<f64>, unit| {
        let value = value.map_or("not measured".to_owned(), |x| engineering(x, unit));
        let _ = writeln!(text, "{what:<42}{value:>10}");
    };
    let energy = table.mean("energy_pj.total").map(|pj| pj * 1e-12);
    power("energy per frame".into(), energy, "J");
    if let Some(rate) = table.throughput_fps {
        let rate = significant(rate);
        power(format!("power at full rate ({rate} FPS)"), table.throughput_power_w, "W");
    }
    power(format!("power at the display rate ({fps} FPS)"), table.mean("power_w.total"), "W");
    text
}

/// Widths of the columns of the cycle table.
const CYCLE_COLUMNS: [usize; 5] = [9, 13, 14, 15, 8];

/// Widths of the columns of the power table.
const COLUMNS: [usize; 6] = [9, 9, 9, 10, 13, 10];

fn power_table(run: &Run, table: &Table) -> Option<String> {
    let power = Breakdown::power_w(table, run.facts.display_fps)?;
    let (factor, prefix) = prefix_of(table.mean("power_w.total")?);
    let fps = rate(run.facts.display_fps);
    let names = Component::ALL.map(Component::name).into_iter().chain(["total"]);
    let mut text = format!("{:<18}", format!("{prefix}W at {fps} FPS"));
    for (name, width) in names.zip(COLUMNS) {
        let _ = write!(text, "{name:>width$}");
    }
    text.push('\n');
    let mut line = |name: &str, values: [Option<f64>; 6]| {
        let _ = write!(text, "{name:<18}");
        for (value, width) in values.into_iter().zip(COLUMNS) {
            let cell = value.map_or("-".to_owned(), |x| significant(x / factor));
            let _ = write!(text, "{cell:>width$}");
        }
        text.push('\n');
    };
    let cells = |of: &dyn Fn(Component) -> Option<f64>, total| {
        let [a, b, c, d, e] = Component::ALL.map(of);
        [a, b, c, d, e, Some(total)]
    };
    for stage in power.shown() {
        let part = |c: Component| applies(stage, c).then(|| power.part(stage, c));
        line(stage.name(), cells(&part, power.stage(stage)));
    }
    let total = table.mean("power_w.total")?;
    line("total", cells(&|c| Some(power.component(c)), total));
    Some(text)
}

/// Whether a stage can have a component at all: standby parts are paid for time only.
pub(super) fn applies(stage: Stage, component: Component) -> bool {
    let standby = matches!(component, Component::Leakage | Component::Background);
    standby == (stage == Stage::Standby)
}

fn cycle_table(run: &Run, table: &Table) -> String {
    let rows = CycleRow::all(run, table);
    if rows.is_empty() {
        return String::new();
    }
    let mut text = format!("{:<18}", "% of cycles");
    for (part, width) in CycleRow::PARTS.into_iter().zip(CYCLE_COLUMNS) {
        let _ = write!(text, "{part:>width$}");
    }
    text.push('\n');
    for row in rows {
        let _ = write!(text, "{:<18}", format!("{} x{}", row.unit, row.instances));
        for (share, width) in row.shares().into_iter().zip(CYCLE_COLUMNS) {
            let _ = write!(text, "{:>width$}", percent(share));
        }
        text.push('\n');
    }
    if let (Some(rate), Some(busy)) =
        (table.mean("dram.bandwidth_gb_s"), table.mean("dram.busy_frac"))
    {
        let peak = run.facts.machine.dram_peak_gb_s;
        let of = peak.map_or(String::new(), |p| format!(" of {} GB/s peak", significant(p)));
        let rate = significant(rate);
        let _ = writeln!(text, "{:<18}{:>9}   {rate}{of}", "dram", percent(busy));
    }
    text
}

fn display(table: &Table) -> Option<String> {
    let display = table.mean("display_power_w")?;
    let accelerator = table.mean("power_w.total")?;
    Some(format!(
        "display {} + accelerator {} = {}\n",
        engineering(display, "W"),
        engineering(accelerator, "W"),
        engineering(table.mean("rendering_plus_display_w")?, "W"),
    ))
}
