//! The summary that `replay` prints: at most 80 columns, about 35 lines.

use std::fmt::Write;

use super::breakdown::{Breakdown, CycleRow};
use super::format::{engineering, percent, prefix_of, rate, shortened, significant, wrapped};
use super::{Means, Run, Table, bottleneck, limits};
use powergs_core::action::Stage;
use powergs_core::energy::{Component, Standby};
use powergs_frame::fovea::REGIONS;

/// Widest line.
const WIDTH: usize = 80;

/// Rows of the table of doubled resources.
const STEPS: usize = 4;

/// The summary. `folder` is where the report is, `next` a command to try.
pub fn summary(run: &Run, table: &Table, folder: Option<&str>, next: Option<&str>) -> String {
    let means = table.means();
    let mut sections = vec![head(run), times_and_powers(run, table)];
    sections.push(power_table(run, &means).unwrap_or_default());
    sections.push(cycle_table(run, &means));
    sections.push(region_table(table).unwrap_or_default());
    let found = bottleneck::of(&means);
    if let Some(found) = &found {
        sections.push(format!("{}\n", wrapped(&found.sentence, WIDTH)));
    }
    let what_if = run.extras.what_if.as_ref();
    sections.push(what_if.map_or_else(String::new, |w| w.lines(STEPS)));
    let mut end = run.extras.dram_models.map_or_else(String::new, |d| d.line());
    if table.throughput_fps.is_some() {
        let mattered = limits::mattered(&means, found.as_ref(), what_if);
        let left_out = limits::left_out(&run.facts.configuration).len();
        end += &limits::line(left_out, &mattered);
    }
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
    if let Some(sum) = table.mean("rendering_plus_display_w") {
        power("that and the display's own power".into(), Some(sum), "W");
    }
    text
}

/// Widths of the columns of the cycle table.
const CYCLE_COLUMNS: [usize; CycleRow::PARTS.len()] = [6, 9, 6, 7, 10, 7, 8, 6, 6];

/// Width of a column of the power table: its name and two spaces, at least this.
const NARROWEST: usize = 8;

fn power_table(run: &Run, means: &Means) -> Option<String> {
    let power = Breakdown::power_w(means, run.facts.display_fps)?;
    let all = means.get("power_w.total")?;
    let (factor, prefix) = prefix_of(all);
    let fps = rate(run.facts.display_fps);
    let names: Vec<&str> =
        Component::ALL.map(Component::name).into_iter().chain(["total"]).collect();
    let width = |name: &str| (name.len() + 2).max(NARROWEST);
    let line = |first: &str, cells: &[String]| {
        let cells = cells.iter().zip(&names).map(|(cell, name)| format!("{cell:>0$}", width(name)));
        format!("{first:<15}{}\n", cells.collect::<String>())
    };
    let heads: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
    let mut text = line(&format!("{prefix}W at {fps} FPS"), &heads);
    let cell = |watts: f64| significant(watts / factor);
    for stage in power.shown() {
        let part = |c: Component| {
            if applies(stage, c) { cell(power.part(stage, c)) } else { "-".to_owned() }
        };
        let cells = Component::ALL.map(part).into_iter().chain([cell(power.stage(stage))]);
        text += &line(stage.name(), &cells.collect::<Vec<_>>());
    }
    let totals = Component::ALL.map(|c| cell(power.component(c))).into_iter().chain([cell(all)]);
    text += &line("total", &totals.collect::<Vec<_>>());
    Some(text)
}

/// R1 to R4, where frames are foveated and have a time.
fn region_table(table: &Table) -> Option<String> {
    let mean =
        |region: &str, name: &str| table.mean(&format!("regions.{}.{name}", region.to_lowercase()));
    mean(REGIONS[0], "tiles")?;
    let mut text = format!(
        "{:<15}{:>9}{:>12}{:>14}{:>13}\n",
        "region, a frame", "tiles", "splats", "VRU cycles", "energy"
    );
    for region in REGIONS {
        let number = |name: &str| mean(region, name).map_or("-".into(), significant);
        let energy = mean(region, "energy_pj").map(|pj| engineering(pj * 1e-12, "J"));
        let _ = writeln!(
            text,
            "{region:<15}{:>9}{:>12}{:>14}{:>13}",
            number("tiles"),
            number("entries"),
            number("cycles"),
            energy.unwrap_or("-".into())
        );
    }
    Some(text)
}

/// Whether a stage can have a component at all: standby parts are paid for time only.
pub(super) fn applies(stage: Stage, component: Component) -> bool {
    Standby::COMPONENTS.contains(&component) == (stage == Stage::Standby)
}

fn cycle_table(run: &Run, means: &Means) -> String {
    let rows = CycleRow::all(means);
    if rows.is_empty() {
        return String::new();
    }
    let mut text = format!("{:<15}", "% of cycles");
    for (part, width) in CycleRow::PARTS.into_iter().zip(CYCLE_COLUMNS) {
        let _ = write!(text, "{part:>width$}");
    }
    text.push('\n');
    for row in rows {
        let _ = write!(text, "{:<15}", format!("{} x{}", row.unit, row.instances));
        for (share, width) in row.shares().into_iter().zip(CYCLE_COLUMNS) {
            let cell = if share == 0.0 { "-".to_owned() } else { percent(share) };
            let _ = write!(text, "{cell:>width$}");
        }
        text.push('\n');
    }
    text + &dram_line(run, means)
}

/// How busy the bus was, the rate over the frame, and row hits and overfetch where they are known.
fn dram_line(run: &Run, means: &Means) -> String {
    let (Some(rate), Some(busy)) = (means.get("dram.bandwidth_gb_s"), means.get("dram.busy_frac"))
    else {
        return String::new();
    };
    let peak = run.facts.machine.dram_peak_gb_s;
    let of = peak.map_or(String::new(), |p| format!(" of {} GB/s", significant(p)));
    let mut text = format!("{:<15}{:>6}   {}{of}", "dram bus", percent(busy), significant(rate));
    if let Some(hits) = means.get("dram.row_hit_frac") {
        let _ = write!(text, ", row hits {} %", percent(hits));
    }
    if let Some(ratio) = means.get("dram.moved_per_requested") {
        let _ = write!(text, ", moves {} B/B", significant(ratio));
    }
    text + "\n"
}
