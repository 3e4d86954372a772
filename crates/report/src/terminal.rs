//! The summary that `replay` prints: at most 80 columns, about 35 lines.

use std::fmt::Write;

use super::format::{engineering, percent, prefix_of, rate, shortened, significant, wrapped};
use super::{summary_of, what_if};
use powergs_core::action::Stage;
use powergs_core::energy::{Component, Standby};
use powergs_frame::fovea::REGIONS;
use powergs_study::findings::breakdown::Breakdown;
use powergs_study::findings::summary::{CycleSummary, UnitSummary};
use powergs_study::findings::{RunSummary, bottleneck, limits};
use powergs_study::run_record::{DramModels, Run};

/// Widest line.
const WIDTH: usize = 80;

/// Rows of the table of doubled resources.
const STEPS: usize = 4;

/// The summary. `folder` is where the report is, `next` a command to try.
///
/// # Panics
/// Without frames.
pub fn summary(run: &Run, folder: Option<&str>, next: Option<&str>) -> String {
    let summary = summary_of(run);
    let mut sections = vec![head(run), times_and_powers(run, &summary)];
    sections.push(power_table(run, &summary));
    if let Some(cycle) = &summary.cycle {
        sections.push(cycle_table(run, cycle));
        sections.push(region_table(cycle));
    }
    let found = bottleneck::of(&summary);
    if let Some(found) = &found {
        sections.push(format!("{}\n", wrapped(&super::bottleneck::sentence(found), WIDTH)));
    }
    let experiment = run.extras.what_if.as_ref();
    sections.push(experiment.map_or_else(String::new, |w| what_if::lines(w, STEPS)));
    let mut end = run.extras.dram_models.as_ref().map_or_else(String::new, dram_models);
    if summary.throughput_fps().is_some() {
        let mattered = limits::mattered(&summary, found.as_ref(), experiment);
        let left_out = limits::left_out(run.facts.machine.dram_model).len();
        end += &super::limits::line(left_out, &mattered);
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

/// Two models of the DRAM in one line of at most 80 columns.
pub(super) fn dram_models(models: &DramModels) -> String {
    let [time, bytes] = models.differences().map(|d| format!("{:+.2} %", d * 100.0));
    format!("dram window against banked: time {time}, bytes moved {bytes}\n")
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

fn times_and_powers(run: &Run, summary: &RunSummary) -> String {
    let fps = rate(run.facts.display_fps);
    let mut text = String::new();
    match (&summary.cycle, summary.throughput_fps()) {
        (Some(cycle), Some(rate)) => {
            let _ = writeln!(
                text,
                "frame time   mean {} ms, p99 {} ms, max {} ms: {} FPS",
                significant(cycle.frame_time_ms),
                significant(cycle.frame_time_p99_ms),
                significant(cycle.frame_time_max_ms),
                significant(rate),
            );
            let deadline = significant(1e3 / run.facts.display_fps);
            let missed = format!("{} of {} frames missed", cycle.deadline_misses, run.frames.len());
            let _ = writeln!(text, "deadline     {deadline} ms at {fps} FPS: {missed}");
        }
        _ => text.push_str("frame time   not in this model, which counts work only\n"),
    }
    let mut power = |what: String, value: Option<f64>, unit| {
        let value = value.map_or("not measured".to_owned(), |x| engineering(x, unit));
        let _ = writeln!(text, "{what:<42}{value:>10}");
    };
    power("energy per frame".into(), Some(summary.energy.total_pj * 1e-12), "J");
    if let Some(rate) = summary.throughput_fps() {
        let rate = significant(rate);
        power(format!("power at full rate ({rate} FPS)"), summary.throughput_power_w(), "W");
    }
    power(format!("power at the display rate ({fps} FPS)"), Some(summary.power_w), "W");
    if let Some(sum) = summary.rendering_plus_display_w {
        power("that and the display's own power".into(), Some(sum), "W");
    }
    text
}

/// Widths of the columns of the cycle table.
const CYCLE_COLUMNS: [usize; UnitSummary::PARTS.len()] = [6, 9, 6, 7, 10, 7, 8, 6, 6];

/// Width of a column of the power table: its name and two spaces, at least this.
const NARROWEST: usize = 8;

fn power_table(run: &Run, summary: &RunSummary) -> String {
    let power = Breakdown::power_w(summary, run.facts.display_fps);
    let all = summary.power_w;
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
    text
}

/// R1 to R4, where frames are foveated and have a time.
fn region_table(cycle: &CycleSummary) -> String {
    let Some(regions) = &cycle.regions else { return String::new() };
    let mut text = format!(
        "{:<15}{:>9}{:>12}{:>14}{:>13}\n",
        "region, a frame", "tiles", "splats", "VRU cycles", "energy"
    );
    for (name, region) in REGIONS.into_iter().zip(regions) {
        let _ = writeln!(
            text,
            "{name:<15}{:>9}{:>12}{:>14}{:>13}",
            significant(region.tiles),
            significant(region.entries),
            significant(region.cycles),
            engineering(region.energy_pj * 1e-12, "J")
        );
    }
    text
}

/// Whether a stage can have a component at all: standby parts are paid for time only.
pub(super) fn applies(stage: Stage, component: Component) -> bool {
    Standby::COMPONENTS.contains(&component) == (stage == Stage::Standby)
}

fn cycle_table(run: &Run, cycle: &CycleSummary) -> String {
    let mut text = format!("{:<15}", "% of cycles");
    for (part, width) in UnitSummary::PARTS.into_iter().zip(CYCLE_COLUMNS) {
        let _ = write!(text, "{part:>width$}");
    }
    text.push('\n');
    for row in &cycle.units {
        let _ = write!(text, "{:<15}", format!("{} x{}", row.unit.name(), row.instances));
        for (share, width) in row.shares().into_iter().zip(CYCLE_COLUMNS) {
            let cell = if share == 0.0 { "-".to_owned() } else { percent(share) };
            let _ = write!(text, "{cell:>width$}");
        }
        text.push('\n');
    }
    text + &dram_line(run, cycle)
}

/// How busy the bus was, the rate over the frame, and row hits and overfetch where they are known.
fn dram_line(run: &Run, cycle: &CycleSummary) -> String {
    let dram = &cycle.dram;
    let Some(rate) = dram.bandwidth_gb_s else { return String::new() };
    let peak = run.facts.machine.dram_peak_gb_s;
    let of = peak.map_or(String::new(), |p| format!(" of {} GB/s", significant(p)));
    let mut text =
        format!("{:<15}{:>6}   {}{of}", "dram bus", percent(dram.busy_frac), significant(rate));
    if let Some(hits) = dram.row_hit_frac {
        let _ = write!(text, ", row hits {} %", percent(hits));
    }
    if let Some(ratio) = dram.moved_per_requested {
        let _ = write!(text, ", moves {} B/B", significant(ratio));
    }
    text + "\n"
}
