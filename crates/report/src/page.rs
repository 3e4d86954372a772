//! The page of a run: what `replay` prints and `summary.md`.

use super::charts::{buffer_rows, unit};
use super::document::{Block, Cell, Column, Document, Kind, Shown, Table, Text};
use super::format::{
    engineering, engineering_like, percent, prefix_of, rate, shortened, significant,
};
use super::{limits as words, record_of};
use powergs_base::TOOL_VERSION;
use powergs_base::config::references::references;
use powergs_chart::Chart;
use powergs_core::flow::over::pixels;
use powergs_core::flow::tile_wise::{measures, stereo};
use powergs_core::sim::MODEL_VERSION;
use powergs_core::sim::statistics::{Aggregate, UnitPart};
use powergs_core::stage::hardware;
use powergs_core::workload::reuse::KEEP;
use powergs_energy::action::{Phase, StageId};
use powergs_energy::{Component, Standby};
use powergs_frame::fovea::REGIONS;
use powergs_study::findings::breakdown::Breakdown;
use powergs_study::findings::cost::Cost;
use powergs_study::findings::masters::MasterGets;
use powergs_study::findings::what_if::{Advice, Skipped, Step, WhatIf};
use powergs_study::findings::{Key, Record, bottleneck, limits};
use powergs_study::run_record::{DramModels, Run, Shown as Frame};

/// Doubled resources on a terminal, and the least change of the time that is one.
const STEPS: (usize, f64) = (4, 0.005);

/// The page, with `charts` that lie beside it. `ending` are the last lines on a terminal: where the
/// report is, a command to try.
///
/// # Panics
/// Without frames.
pub fn document(run: &Run, charts: &[Chart], ending: &[(&str, String)]) -> Document {
    let record = record_of(run);
    let found = bottleneck::of(&record);
    let mut page = Document::new();
    head(&mut page, run);
    if let Some(found) = &found {
        page.paragraph(super::bottleneck::sentence(found));
    }
    page.on(Shown::Page, Block::Facts(facts(run)));
    // A terminal has them as warnings.
    for doubt in &run.facts.machine.doubts {
        page.page_paragraph(Text::strong("Note:").then(Text::marked(&format!(" {doubt}."))));
    }
    if let Some((degree, true)) = run.sh_degree() {
        let text = format!("Colours are those of SH degree {degree}: {NO_DEGREE}.");
        page.on(Shown::Terminal, Block::Paragraph(text.into()));
    }
    let masters = run.facts.machine.masters.gets(|key| record.mean(key));
    for master in masters.iter().filter(|master| master.is_starved()) {
        page.paragraph(Text::strong("Note:").then(Text::marked(&starved(master))));
    }
    page.add(Block::Facts(times_and_powers(run, &record)));
    page.page_heading(match run.facts.machine.task.is_shown() {
        true => format!("Power at {} FPS", rate(run.facts.display_fps)),
        false => "Power".to_owned(),
    });
    page.table(power(run, &record));
    if !run.facts.machine.task.is_shown() {
        steps(&mut page, &record);
    }
    if let Some(line) = prices(run) {
        page.page_paragraph(Text::from("By the price assumptions in use: ").then(line).then("."));
    }
    if record.has_time() {
        cycles(&mut page, run, &record);
        regions(&mut page, &record);
    }
    if let Some(experiment) = &run.experiments.what_if {
        what_if(&mut page, experiment, run.facts.trace.shown);
    }
    if let Some(models) = &run.experiments.dram_models {
        page.paragraph(dram_models(models));
    }
    if record.has_time() {
        page.page_heading("Buffers");
        page.on(Shown::Page, Block::Table(buffers(&record)));
        if let Some(text) = overfull(run) {
            page.paragraph(text);
        }
        if let Some(text) = kept_order(run) {
            page.paragraph(text);
        }
    }
    page.page_heading("Over the frames");
    page.on(Shown::Page, Block::Table(statistics(&record)));
    page.charts(charts);
    let mut last: Vec<(String, Text)> = Vec::new();
    if record.throughput_fps().is_some() {
        let machine = &run.facts.machine;
        let mattered = limits::mattered(&record, machine, found.as_ref(), &run.experiments);
        let left_out = &machine.left_out;
        last.extend(prices(run).map(|line| ("prices".into(), line)));
        let line = Text::marked(&words::line(left_out, &mattered));
        last.push(("limits".into(), line));
        page.page_heading("What is not modelled");
        page.page_paragraph(format!("{}.", words::sum(left_out)));
        page.on(Shown::Page, Block::Table(words::table(left_out)));
        if !mattered.is_empty() {
            page.page_paragraph("Assumptions that mattered most in this run:");
            let item = |same: &[limits::Mattered]| {
                let titles: Vec<String> =
                    same.iter().map(|m| words::titled(&m.assumption)).collect();
                Text::marked(&format!("{}: {}", words::why(&same[0].why), titles.join("; ")))
            };
            let items = mattered.chunk_by(|a, b| a.why == b.why).map(item).collect();
            page.on(Shown::Page, Block::List(items));
        }
    }
    let sources: Vec<Text> =
        run.facts.machine.sources.iter().filter_map(|key| source(key)).collect();
    if !sources.is_empty() {
        page.page_heading("Sources of the machine and its prices");
        page.on(Shown::Page, Block::List(sources));
    }
    page.page_paragraph(Text::marked(
        "Every number with its unit: `results.csv`, one row per frame; `powergs-sim explain NAME` \
         defines any of them. What the run was made from: `run.toml`; what was typed: \
         `invocation.toml`.",
    ));
    last.extend(ending.iter().map(|(name, what)| ((*name).to_owned(), what.as_str().into())));
    page.on(Shown::Terminal, Block::Facts(last));
    page
}

/// A source with its address.
fn source(key: &str) -> Option<Text> {
    let source = references().get(key)?;
    let venue = format!(", {}", source.venue);
    Some(Text::link(source.title.as_str(), source.link()).then(venue))
}

/// How far the price assumptions in use move the power.
fn prices(run: &Run) -> Option<Text> {
    let line = run.experiments.prices.as_ref().and_then(words::prices)?;
    Some(Text::marked(&line))
}

/// What was run; and whether it ended early.
fn head(page: &mut Document, run: &Run) {
    /// Characters of a title on a terminal.
    const LONGEST: usize = 80;
    let (facts, trace) = (&run.facts, &run.facts.trace);
    let frames = match facts.machine.task.is_shown() {
        true => trace.shown.at_rate(run.frames.len() as u64, facts.display_fps),
        false => {
            let frames = trace.shown.counted(run.frames.len() as u64);
            format!("{frames} of {}, {}", trace.shown.size(), facts.machine.task)
        }
    };
    let tail = format!(": {frames}, {} model", facts.model.name());
    let title = shortened(&run.title(), LONGEST.saturating_sub(tail.chars().count()));
    page.on(Shown::Page, Block::Title(run.title().into()));
    page.on(Shown::Terminal, Block::Paragraph(format!("{title}{tail}").into()));
    if let Some(note) = run.incomplete_note() {
        let note = Text::strong(format!("{note}."));
        page.paragraph(note.then(" All numbers are for these frames only."));
    }
}

fn facts(run: &Run) -> Vec<(String, Text)> {
    let (machine, trace) = (&run.facts.machine, &run.facts.trace);
    let shown = trace.shown;
    let frames = format!("{} of {} pixels", shown.counted(run.frames.len() as u64), shown.size());
    let mut facts = vec![
        ("trace", trace.name.clone()),
        ("frames", frames),
        ("SH degree", sh_degree(run)),
        ("machine", machine.name.clone()),
        ("energy table", machine.energy_table.clone()),
        ("model", format!("{}, version {MODEL_VERSION}", run.facts.model.name())),
        ("task", machine.task.name()),
        ("display rate", format!("{} FPS", rate(run.facts.display_fps))),
        ("made with", format!("powergs-sim {TOOL_VERSION}")),
    ];
    // Nobody looks at steps.
    facts.retain(|(name, _)| machine.task.is_shown() || *name != "display rate");
    facts.into_iter().map(|(name, value)| (name.to_owned(), value.into())).collect()
}

/// What is said of a master that gets less than it asks for.
fn starved(MasterGets { name, gets, asks }: &MasterGets) -> String {
    let (got, asked) = (significant(*gets), significant(*asks));
    format!(
        " the {name} master is STARVED: it gets {got} of {asked} GB/s. With more requests under \
         way (`dram.{name}-master.in-flight`), a `guaranteed` rate or `priority` = first it gets \
         more, and frames take longer."
    )
}

/// The degree of the scene's spherical harmonics, and where it is from.
fn sh_degree(run: &Run) -> String {
    match run.sh_degree() {
        Some((degree, false)) => degree.to_string(),
        Some((degree, true)) => format!("{degree}, assumed: {NO_DEGREE}"),
        None => "unknown".into(),
    }
}

/// Why a degree is assumed, and what to do.
const NO_DEGREE: &str = "the trace does not say it; extract the scene again to have its own";

/// The rate at which the display is served: its own, or what is reached of it; that of steps, which
/// wait for none.
fn displayed(run: &Run, record: &Record) -> String {
    let task = run.facts.machine.task;
    let unit = task.per_second();
    match task.is_shown() && !record.misses() {
        true => format!("{} {unit}", rate(record.display_fps)),
        false => format!("{} {unit}", significant(record.displayed_fps())),
    }
}

/// Mean and slowest of a time in milliseconds: fewer than 100 frames have no 99th percentile.
fn spread(time: &Aggregate, frames: u64) -> String {
    let [mean, _, _, p99, max] = time.parts().map(|ms| significant(ms.as_f64()));
    match frames {
        1 => format!("{mean} ms"),
        2..HUNDRED => format!("mean {mean} ms, max of {frames}: {max} ms"),
        _ => format!("mean {mean} ms, p99 {p99} ms, max {max} ms"),
    }
}

/// Fewer frames have no 99th percentile: it is the slowest.
pub(crate) const HUNDRED: u64 = 100;

/// Times, and energy per frame times rate for the two powers, which differ in rate and in what is
/// paid between frames.
fn times_and_powers(run: &Run, record: &Record) -> Vec<(String, Text)> {
    let task = run.facts.machine.task;
    let (fps, noun) = (rate(run.facts.display_fps), task.noun());
    let mut facts: Vec<(String, Text)> = Vec::new();
    let mut add = |name: &str, value: String| facts.push((name.to_owned(), value.into()));
    let power_w = record.value(Key::Power);
    let all = run.frames.len() as u64;
    match (record.aggregate(Key::FrameTime), record.throughput_fps()) {
        (Some(time), Some(rate)) => {
            let latency = record.aggregate(Key::FrameLatency).filter(|latency| *latency != time);
            let name = if latency.is_some() { "interval" } else { "time" };
            add(&format!("{noun} {name}"), spread(&time, all));
            if let Some(latency) = latency {
                add(&format!("{noun} latency"), spread(&latency, all));
            }
            add(&format!("{noun} rate"), format!("{} {}", significant(rate), task.per_second()));
            if let Some(missed) = record.deadline_misses() {
                let deadline = significant(1e3 / run.facts.display_fps);
                let all = run.facts.trace.shown.counted(all);
                let seen = record.synchronised_fps().map(|seen| {
                    format!(
                        "; {} FPS where pictures change between periods alone",
                        significant(seen)
                    )
                });
                let verdict = match missed {
                    0 => format!("met by {all}"),
                    _ => format!("MISSED by {missed} of {all}{}", seen.unwrap_or_default()),
                };
                add("deadline", format!("{deadline} ms at {fps} FPS: {verdict}"));
            }
            if let (Some(most), Some(latency)) =
                (run.facts.latency_ms, record.aggregate(Key::FrameLatency))
            {
                let slowest = latency.max.as_f64();
                let verdict = if slowest > most { "EXCEEDED" } else { "met" };
                let slowest = significant(slowest);
                add(
                    "latency",
                    format!("at most {most} ms: {verdict}, the longest is {slowest} ms"),
                );
            }
        }
        _ => add("frame time", "not in this model, which counts work only".into()),
    }
    // All in the units of the display rate.
    let watt = |watts: f64| engineering_like(watts, power_w, "W");
    let product = |energy_j: f64, rate: &str, watts: f64| {
        let energy = engineering_like(energy_j, record.displayed_energy_j(), "J");
        format!("{energy} per {noun} x {rate} = {}", watt(watts))
    };
    if let (Some(rate), Some(watts)) = (record.throughput_fps(), record.throughput_power_w()) {
        let rate = format!("{} {}", significant(rate), task.per_second());
        add("at full rate", product(record.value(Key::Energy) * 1e-12, &rate, watts));
    }
    if !task.is_shown() {
        return facts;
    }
    let shown = product(record.displayed_energy_j(), &displayed(run, record), power_w);
    let what = match record.has_time() {
        false => String::new(),
        true if record.misses() => format!("; MISSES {fps} FPS"),
        true => ", standby between frames included".to_owned(),
    };
    add("at the display rate", format!("{shown}{what}"));
    let with_display = record.mean(Key::PowerWithDisplay);
    if let Some((display, sum)) = record.mean(Key::DisplayPower).zip(with_display) {
        let [own, display, sum] = [power_w, display, sum].map(watt);
        let (name, panels) = match run.facts.trace.shown.eyes {
            1 => ("with the display", "the display"),
            _ => ("with the displays", "both displays"),
        };
        add(name, format!("{own} + {display} of {panels} = {sum}"));
    }
    facts
}

/// What the parts of a step take: what is made of pictures, and what makes gradients of it.
fn steps(page: &mut Document, record: &Record) {
    let parts = super::steps::parts(record);
    if parts.is_empty() {
        return;
    }
    page.page_heading("Parts of a step");
    page.table(super::steps::table(std::slice::from_ref(&("a step", parts))));
}

/// Power of stages and components at the display rate.
fn power(run: &Run, record: &Record) -> Table {
    let power = Breakdown::power_w(record);
    let total = record.value(Key::Power);
    let (factor, prefix) = prefix_of(total);
    let first = format!("{prefix}W at {}", displayed(run, record));
    let components = Component::ALL.map(|c| Column::real(c.name()));
    let columns = [Column::text(first)].into_iter().chain(components);
    let mut table = Table::new(columns.chain([Column::real("total")]));
    let cell = |watts: f64| Cell::Real(watts / factor);
    for stage in power.shown() {
        let part = |c: Component| match applies(stage, c) {
            true => cell(power.part(stage, c)),
            false => Cell::Missing,
        };
        let cells = Component::ALL.map(part).into_iter().chain([cell(power.stage(stage))]);
        table.row([stage.name().into()].into_iter().chain(cells));
    }
    let totals = Component::ALL.map(|c| cell(power.component(c)));
    table.row([Cell::from("total")].into_iter().chain(totals).chain([cell(total)]));
    table
}

/// Whether a stage can have a component at all: standby parts are paid for time only.
fn applies(stage: Phase, component: Component) -> bool {
    Standby::COMPONENTS.contains(&component) == (stage == Phase::Standby)
}

/// A share in percent; `-` for none.
fn share(x: f64) -> String {
    if x == 0.0 { "-".into() } else { percent(x) }
}

fn cycles(page: &mut Document, run: &Run, record: &Record) {
    page.page_heading("Where the cycles go");
    let is_shown = |part: &UnitPart| match part {
        UnitPart::Stalled(cause) => record.has_cause(*cause),
        UnitPart::Busy | UnitPart::Idle => true,
    };
    let parts = UnitPart::all().filter(is_shown);
    let parts = parts.map(|part| Column::new(part.name(), Kind::Real(share)));
    let row = |kind: StageId| {
        let shares = UnitPart::all().zip(record.unit_shares(kind));
        let shares = shares.filter(|(part, _)| is_shown(part)).map(|(_, share)| Cell::Real(share));
        [Cell::from(unit(record, kind))].into_iter().chain(shares)
    };
    let columns = [Column::text("% of cycles")].into_iter().chain(parts);
    page.table(Table::new(columns).rows(record.units().map(row)));
    page.page_paragraph("Between busy and idle: what a unit with work waited for.");
    page.paragraph(dram(run, record));
    if let Some(rendered) = record.mean(Key::Stat(&pixels::RENDERED)) {
        let known = record.mean(Key::Stat(&pixels::KNOWN_SHARE)).map(|known| {
            format!(" Of those that look up their first Gaussians {} % stop there.", percent(known))
        });
        page.paragraph(format!(
            "{} % of the pixels are rendered.{}",
            percent(rendered),
            known.unwrap_or_default()
        ));
    }
    if let Some(kept) = record.mean(Key::Stat(&stereo::KEPT_SHARE)) {
        let [changed, cut_off] = [&stereo::CHANGED_SHARE, &stereo::CUT_OFF_SHARE]
            .map(|share| percent(record.value(Key::Stat(share))));
        page.paragraph(Text::marked(&format!(
            "The second eye is made of what blends in the first one: {} % of the entries of its \
             own lists. By that {changed} % of its pixels may change by a step of eight bits or \
             more, {cut_off} % because disparities are beyond `stereo.lag`.",
            percent(kept)
        )));
    }
    for lanes in record.units().filter_map(|unit| record.mean(Key::LaneUtilisation(unit))) {
        let share = percent(lanes);
        let text = format!("Lanes of a rendering core at work while it is busy: {share} %.");
        page.page_paragraph(text);
    }
}

/// How busy the bus was, the rate over the frame, and row hits and overfetch where they are known.
fn dram(run: &Run, record: &Record) -> String {
    let Some(rate) = record.mean(Key::DramRate) else { return String::new() };
    let peak = run.facts.machine.dram_peak_gb_s;
    let peak = peak.map_or(String::new(), |p| format!(" of {}", significant(p)));
    let mut text = format!(
        "DRAM bus busy {} % of the time: {}{peak} GB/s",
        percent(record.value(Key::DramBusy)),
        significant(rate)
    );
    if let Some(hits) = record.mean(Key::RowHits) {
        text += &format!(", {} % row hits", percent(hits));
    }
    if let Some(ratio) = record.mean(Key::MovedPerRequested) {
        text += &format!(", {} bytes moved per byte asked for", significant(ratio));
    }
    for MasterGets { name, gets, asks } in run.facts.machine.masters.gets(|key| record.mean(key)) {
        text += &format!(
            "; a {name} master gets {} of the {} GB/s that it asks for",
            significant(gets),
            significant(asks)
        );
    }
    if let Some(bytes) = record.mean(Key::UnwrittenBytes).filter(|&bytes| bytes > 0.0) {
        text += &format!(
            "; {} MB of features a frame are read that no unit writes (record.feature-source)",
            significant(bytes * 1e-6)
        );
    }
    text + "."
}

/// R1 to R4, where frames are foveated and have a time.
fn regions(page: &mut Document, record: &Record) {
    if record.mean(Key::RegionTiles(0)).is_none() {
        return;
    }
    page.page_heading("Regions around the gaze");
    let joules = |pj: f64| engineering(pj * 1e-12, "J");
    let mut table = Table::new([
        Column::text("region, a frame"),
        Column::real("tiles"),
        Column::real("splats loaded"),
        Column::real("VRU cycles"),
        Column::new("energy", Kind::Real(joules)),
    ]);
    let measures = [Key::RegionTiles, Key::RegionEntries, Key::RegionCycles, Key::RegionEnergy];
    for (k, name) in REGIONS.into_iter().enumerate() {
        let numbers = measures.map(|of| Cell::Real(record.value(of(k))));
        table.row([Cell::from(name)].into_iter().chain(numbers));
    }
    page.table(table);
    page.page_paragraph(
        "Sorting and rendering of the tiles of each region; preprocessing and static power belong \
         to none.",
    );
}

/// What doubling each resource would buy, and what it costs.
fn what_if(page: &mut Document, experiment: &WhatIf, shown: Frame) {
    page.page_heading("What one step would buy");
    let frames: Vec<String> = experiment.frames.iter().map(usize::to_string).collect();
    let which = match (frames.len(), shown.eyes) {
        (1, 1) => "frame",
        (_, 1) => "frames",
        (1, _) => "the pair from frame",
        _ => "the pairs from frames",
    };
    let numbers = frames.join(", ");
    page.page_paragraph(format!("Each resource doubled, simulated on {which} {numbers}."));
    if experiment.is_calibrated {
        page.paragraph(Text::marked(
            "What if: with the DRAM model `calibrated`, from one `banked` run of each frame; \
             `--dram-model banked` takes that for every step.",
        ));
    }
    let moves = |step: &&Step| experiment.time_change(step).abs() >= STEPS.1;
    let best: Vec<&Step> = experiment.steps.iter().filter(moves).take(STEPS.0).collect();
    let mut short = doubled(experiment, &best, shown);
    let others = experiment.steps.len() - best.len();
    if others > 0 {
        short.more = format!("... and {others} more: summary.md");
    }
    page.on(Shown::Terminal, Block::Table(short));
    let all: Vec<&Step> = experiment.steps.iter().collect();
    page.on(Shown::Page, Block::Table(doubled(experiment, &all, shown)));
    page.paragraph(advice(experiment));
    let item =
        |s: &Skipped| Text::from(s.resource).then(": not tried: ").then(Text::marked(&s.reason));
    page.on(Shown::Page, Block::List(experiment.skipped.iter().map(item).collect()));
}

/// What to do next, in a sentence.
fn advice(experiment: &WhatIf) -> String {
    let signed = words::signed_percent;
    let time = |step: &Step| signed(experiment.time_change(step));
    let price = |step: &Step| {
        let area = experiment
            .area_change(step)
            .map_or(String::new(), |a| format!("{} area and ", signed(a)));
        format!("{area}{} power", signed(experiment.power_change(step)))
    };
    match experiment.advice() {
        Advice::Take(step) => format!(
            "Most frames per second per mm²: {} doubled, {} time for {} ({} FPS per mm²).",
            step.resource,
            time(step),
            price(step),
            signed(experiment.merit_change(step).unwrap_or(0.0))
        ),
        Advice::AreaOnly(step) => format!(
            "No doubled resource raises the frames per second per mm²: {} saves most time, {}, \
             for {}.",
            step.resource,
            time(step),
            price(step)
        ),
        Advice::Fastest(step) => {
            format!(
                "Saves most time: {} doubled, {} for {}.",
                step.resource,
                time(step),
                price(step)
            )
        }
        Advice::Nothing => "No doubled resource saves 1 % of the time.".to_owned(),
    }
}

/// A change in a column of percent.
fn points(change: f64) -> String {
    words::signed_percent(change).replace(" %", "")
}

/// The run as it is, then with some resources doubled.
fn doubled(experiment: &WhatIf, steps: &[&Step], shown: Frame) -> Table {
    let first = format!("if doubled ({})", shown.counted(experiment.frames.len() as u64));
    let change = |group: &str| Column::new("%", Kind::Real(points)).group(group);
    let [time, power, area, merit] = ["frame time", "power", "area", "merit"];
    let mut table = Table::new([
        Column::text(first),
        Column::real("ms").group(time),
        change(time),
        Column::real("mJ per frame").on(Shown::Page),
        Column::new("%", Kind::Real(points)).on(Shown::Page),
        Column::real("mW").group(power),
        change(power),
        Column::real("mm²").group(area),
        change(area),
        Column::real("FPS/mm²").group(merit),
        change(merit),
    ]);
    let mut row = |name: &str, cost: &Cost, areas: [Option<f64>; 2], changes: [Cell; 5]| {
        let [time, energy, power, area, merit] = changes;
        let [mm2, fps_per_mm2] = areas.map(Cell::from);
        table.row([
            name.into(),
            cost.frame_time_ms.into(),
            time,
            cost.energy_mj().into(),
            energy,
            (cost.power_w * 1e3).into(),
            power,
            mm2,
            area,
            fps_per_mm2,
            merit,
        ]);
    };
    let base = &experiment.base;
    let areas = [base.area_mm2, base.fps_per_mm2()];
    row("nothing", base, areas, std::array::from_fn(|_| Cell::Empty));
    for step in steps {
        let changes = [
            Some(experiment.time_change(step)),
            Some(experiment.energy_change(step)),
            Some(experiment.power_change(step)),
            experiment.area_change(step),
            experiment.merit_change(step),
        ];
        let areas = [step.cost.area_mm2, step.cost.fps_per_mm2()];
        row(step.resource, &step.cost, areas, changes.map(Cell::from));
    }
    table
}

/// Two models of the DRAM in a sentence.
fn dram_models(models: &DramModels) -> String {
    let [time, bytes] = models.differences().map(|d| format!("{:+.2} %", d * 100.0));
    format!("DRAM model `calibrated` against `banked`: time {time}, bytes moved {bytes}.")
        .replace('`', "")
}

/// Buffers that held more than they have in some frame, where there are any. What is larger than a
/// share of a buffer enters alone, so that a machine is never stuck; its area is that of the
/// capacity.
fn overfull(run: &Run) -> Option<String> {
    let mut over: Vec<(&'static str, u64, u64)> = Vec::new();
    let all = run.frames.iter().filter_map(|f| f.timing()).flat_map(|t| &t.buffers);
    for buffer in all.filter(|b| b.capacity > 0 && b.peak > b.capacity) {
        let name = hardware().buffer(buffer.buffer).name;
        match over.iter_mut().find(|(known, ..)| *known == name) {
            Some((_, most, _)) => *most = (*most).max(buffer.peak),
            None => over.push((name, buffer.peak, buffer.capacity)),
        }
    }
    let kib = |bytes: u64| (bytes as f64 / 1024.0).round();
    let one = |(name, most, has): &(&str, u64, u64)| {
        format!("up to {} KiB of the {} KiB of {name}", kib(*most), kib(*has))
    };
    let over: Vec<String> = over.iter().map(one).collect();
    let what = "what is larger than a share of a buffer enters alone, so the area is optimistic";
    (!over.is_empty()).then(|| format!("Batches needed {}: {what}.", over.join(", ")))
}

/// Lists that keep less than this share of their entries have no order to take over: those of
/// neighbouring views of a path keep more than [`KEEP`].
const PATH: f64 = 0.5;

/// How much of the order of the frame before the lists keep, where the machine takes it over.
fn kept_order(run: &Run) -> Option<String> {
    let reused = run.frames.iter().filter_map(|f| {
        let count = |stat| f.cycle()?.measured.count(stat);
        let kept = count(&measures::KEPT)?;
        Some([kept, kept + count(&measures::ADDED)?, count(&measures::MISSING)?])
    });
    let [kept, all, missing] =
        reused.fold([0; 3], |sum, own| std::array::from_fn(|i| sum[i] + own[i]));
    let share = (all > 0).then(|| kept as f64 / all as f64)?;
    let so = match share {
        s if s > KEEP => "views of a path",
        s if s >= PATH => "views that are further apart than those of a path",
        _ => "these views are no path, which a machine that takes over the order lives from",
    };
    let lacks = match missing {
        0 => String::new(),
        n => format!(
            " {} % are missing, and not in the picture: `render --order` makes it.",
            percent(n as f64 / all as f64)
        ),
    };
    let kept = percent(share);
    Some(format!("Order kept from frame to frame: {kept} % of list entries; {so}.{lacks}"))
}

/// What the buffers held, where it was measured.
fn buffers(record: &Record) -> Table {
    let bytes = |x: f64| engineering(x, "B");
    let moved = |head: &str| Column::new(head, Kind::Real(bytes));
    let mut table = Table::new([
        Column::text("buffer"),
        Column::fixed("KiB", 0),
        Column::new("peak %", Kind::Real(percent)),
        Column::new("mean %", Kind::Real(percent)),
        moved("filled"),
        moved("consumed"),
        moved("discarded"),
    ]);
    for row in buffer_rows(record) {
        let shares = [row.capacity / 1024.0, row.peak / row.capacity, row.mean / row.capacity];
        let moved = [row.filled, row.consumed, row.discarded];
        let cells = shares.into_iter().chain(moved).map(Cell::Real);
        table.row([row.name.into()].into_iter().chain(cells));
    }
    table
}

/// Statistics of the page; all others are in `results.csv`.
const STATISTICS: [&str; 12] = [
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

fn statistics(record: &Record) -> Table {
    let parts = ["mean", "p50", "p95", "p99", "max"].map(|p| Column::new(p, Kind::Real(short)));
    let mut table = Table::new([Column::text("statistic")].into_iter().chain(parts));
    for name in STATISTICS {
        let parts = record.named(name).map(|a| a.parts().map(|v| v.as_f64()));
        let cell = |i: usize| Cell::from(parts.map(|p| p[i]));
        table.row([Cell::from(Text::code(name))].into_iter().chain((0..5).map(cell)));
    }
    table
}
