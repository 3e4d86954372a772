//! The comparison for people.

use powergs_study::findings::masters::MasterGets;
use std::collections::BTreeSet;

use super::decision;
use crate::document::{Block, Cell, Column, Document, Kind, Shown, Table, Text};
use crate::format::{percent, rate, significant};
use powergs_base::TOOL_VERSION;
use powergs_base::config::embedded::{MACHINES, find};
use powergs_base::config::knob;
use powergs_chart::Chart;
use powergs_core::sim::MODEL_VERSION;
use powergs_core::sim::statistics::UnitPart;
use powergs_core::stage::hardware;
use powergs_energy::action::Phase;
use powergs_study::findings::compare::{
    AskedLimits, ComparedMeasure, Comparison, Decision, Measure, Note, Side,
};
use powergs_study::findings::{Key, Record, bottleneck};
use powergs_study::speedup::SpeedUp;
use powergs_study::validate;

/// Characters of the name of a side on a terminal.
const LABEL: usize = 14;
/// Shares of cycles below this are left to the page.
const LEAST: f64 = 0.05;

/// What is decided by: who meets the rate of the display, and what else is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Decided<'a> {
    /// Machines on traces.
    pub decision: &'a Decision,
    /// What is asked for besides the display rate.
    pub limits: &'a AskedLimits,
}

/// What is printed, and the page with `charts` beside it. `folder` is where the page is.
pub fn document(
    comparison: &Comparison,
    decided: Decided<'_>,
    charts: &[Chart],
    folder: Option<&str>,
) -> Document {
    let (labels, first) = (comparison.labels(), &comparison.sides[0]);
    let mut page = Document::new();
    page.on(Shown::Page, Block::Title(labels.join(" against ").into()));
    page.page_paragraph(format!(
        "{}: {}; model {}, version {MODEL_VERSION}; made with powergs-sim {TOOL_VERSION}.",
        first.trace,
        shown(comparison),
        first.model
    ));
    let traces = std::slice::from_ref(&first.trace);
    decision::add(&mut page, std::slice::from_ref(comparison), decided, traces);
    page.on(Shown::Terminal, Block::List(alone(comparison)));
    basis(&mut page, comparison);
    page.page_heading("Measures");
    page.table(measures(comparison));
    steps(&mut page, comparison);
    page.page_heading("Stages, per frame");
    page.table(stages(&comparison.sides));
    page.page_heading("Units, share of their cycles");
    page.on(Shown::Terminal, Block::Table(stalls(&comparison.sides, LEAST)));
    page.on(Shown::Page, Block::Table(stalls(&comparison.sides, 0.0)));
    limits(&mut page, comparison);
    notes(&mut page, &comparison.notes);
    gaps(&mut page, &comparison.sides);
    payments(&mut page, comparison);
    differences(&mut page, &comparison.sides);
    page.charts(charts);
    page.page_paragraph(Text::marked(
        "Who meets what: `decision.csv`; every statistic of every side: `compare.csv`; what it was \
         made from: `run.toml`.",
    ));
    let report = folder.map(|folder| ("report".to_owned(), folder.into()));
    page.on(Shown::Terminal, Block::Facts(report.into_iter().collect()));
    page
}

/// Machines on several traces: speed-ups with `charts`, then what every trace says. `folder` is
/// where the page is.
pub fn document_of(
    all: &[Comparison],
    decided: Decided<'_>,
    speedup: &SpeedUp,
    charts: &[Chart],
    folder: Option<&str>,
) -> Document {
    let mut page = Document::new();
    let labels = all[0].labels().join(" against ");
    page.on(Shown::Page, Block::Title(format!("{labels}, {} traces", all.len()).into()));
    page.page_paragraph(format!(
        "Model {}, version {MODEL_VERSION}; made with powergs-sim {TOOL_VERSION}.",
        all[0].sides[0].model
    ));
    decision::add(&mut page, all, decided, &speedup.traces);
    page.on(Shown::Terminal, Block::List(alone(&all[0])));
    basis(&mut page, &all[0]);
    page.heading("Back to back");
    page.page_paragraph("Rates and energies of frames that follow one another without a display.");
    page.table(crate::speedup::means_table(speedup));
    page.on(Shown::Page, Block::Table(crate::speedup::table(speedup)));
    // What holds on all traces is said once.
    let is_common = |note: &Note| all.iter().all(|c| c.notes.contains(note));
    notes(&mut page, all[0].notes.iter().filter(|note| is_common(note)));
    gaps(&mut page, &all[0].sides);
    page.charts(charts);
    payments(&mut page, &all[0]);
    for (comparison, trace) in all.iter().zip(&speedup.traces) {
        let sides = &comparison.sides;
        let frames = shown(comparison);
        page.heading(format!("{trace}: {frames}"));
        page.table(measures(comparison));
        steps(&mut page, comparison);
        page.on(Shown::Page, Block::Table(stages(sides)));
        page.on(Shown::Page, Block::Table(stalls(sides, 0.0)));
        limits(&mut page, comparison);
        let own = comparison.notes.iter().filter(|note| !is_common(note));
        notes(&mut page, own);
    }
    differences(&mut page, &all[0].sides);
    page.page_paragraph(Text::marked(
        "Who meets what: `decision.csv`; every statistic of every side: `compare.csv`; speed-ups: \
         `speedup.csv`; what it was made from: `run.toml`.",
    ));
    let report = folder.map(|folder| ("report".to_owned(), folder.into()));
    page.on(Shown::Terminal, Block::Facts(report.into_iter().collect()));
    page
}

/// Where the steps of sides go that train or track.
fn steps(page: &mut Document, comparison: &Comparison) {
    let all = crate::steps::of_sides(&comparison.sides);
    if !all.is_empty() {
        page.page_heading("Parts of a step");
        page.table(crate::steps::table(&all));
    }
}

/// What some sides do and others do not, and what is left out of some: that is free for these.
fn payments(page: &mut Document, comparison: &Comparison) {
    let sides = &comparison.sides;
    let done = comparison.done_by_some();
    if !done.is_empty() {
        page.page_heading("Who does what");
        let noun = comparison.task().map_or("frame or step", |task| task.noun());
        page.page_paragraph(Text::marked(&format!(
            "Work that not all sides do, how often in a {noun}; `powergs-sim explain actions.NAME` \
             has each with its price."
        )));
        let mut table = Table::new(columns("work", Kind::Real(significant), sides));
        for (key, counts) in done {
            let cells = counts.into_iter().map(|n| Cell::from(Some(n).filter(|n| *n > 0.0)));
            table.row([Cell::from(Text::code(key))].into_iter().chain(cells));
        }
        page.on(Shown::Page, Block::Table(table));
    }
    let left_out = comparison.left_out_by_some();
    if !left_out.is_empty() {
        page.page_heading("What is free for some");
        page.page_paragraph(Text::marked(
            "Effects that are left out of some sides and not of others: simulated time is wrong \
             for these alone. `powergs-sim sensitivity MACHINE TRACE --assumptions --only A119` \
             says how far a number behind one moves the result.",
        ));
        let words = [Column::text("effect"), Column::text("time is"), Column::text("see")];
        let own = columns("effect", Kind::Text, sides).into_iter().skip(1);
        let mut table = Table::new(words.into_iter().chain(own));
        for (effect, by) in left_out {
            let first = [effect.what.into(), effect.bias.name().into(), effect.assumption.into()];
            let cells = by.into_iter().map(|by| Cell::from(if by { "left out" } else { "-" }));
            table.row(first.into_iter().chain(cells));
        }
        page.on(Shown::Page, Block::Table(table));
    }
}

/// What each side does, or has for nothing, that no other one does or has: a line each.
fn alone(comparison: &Comparison) -> Vec<Text> {
    const MOST: usize = 4;
    let some = |mut words: Vec<&str>| {
        let mut seen = BTreeSet::new();
        words.retain(|word| seen.insert(*word));
        match words.len() {
            n if n > MOST => format!("{} and {} more", words[..MOST].join(", "), n - MOST),
            _ => words.join(", "),
        }
    };
    let (done, left_out) = (comparison.done_by_some(), comparison.left_out_by_some());
    let of = |(i, side): (usize, &Side)| {
        let is_only = |by: Vec<bool>| by[i] && by.iter().filter(|has| **has).count() == 1;
        let works = done.iter().filter(|(_, n)| is_only(n.iter().map(|n| *n > 0.0).collect()));
        let works: Vec<&str> = works.map(|(key, _)| *key).collect();
        let free = left_out.iter().filter(|(_, by)| is_only(by.clone()));
        let free = free.flat_map(|(effect, _)| effect.assumption.split(", "));
        let free: Vec<&str> = free.filter(|a| a.starts_with('A')).collect();
        let works = (!works.is_empty()).then(|| format!("it alone does {}", some(works)));
        let free = (!free.is_empty()).then(|| format!("it alone has for nothing {}", some(free)));
        let all: Vec<String> = works.into_iter().chain(free).collect();
        let text = format!(": {} (`explain`)", all.join("; "));
        (!all.is_empty()).then(|| Text::strong(side.label.clone()).then(Text::marked(&text)))
    };
    comparison.sides.iter().enumerate().filter_map(of).collect()
}

/// What each machine that comes with the program misses most of its published numbers; and whose
/// numbers nothing is held against, which is no better.
fn gaps(page: &mut Document, sides: &[Side]) {
    let mut seen = BTreeSet::new();
    let gap = |side: &Side| {
        find(MACHINES, &side.machine).filter(|_| seen.insert(side.machine.clone()))?;
        let held = validate::rows_of(&side.machine);
        let variant = held.variant_headline();
        let text = match (held.headline(), variant) {
            (Some(missed), _) => crate::validate::headline(missed),
            (None, Some(variant)) => {
                format!("with `{}`, {}", variant.row.machine, crate::validate::headline(variant))
            }
            (None, None) if held.is_measured() => {
                "no published number of its frames is missed".into()
            }
            (None, None) => "no published number of its frames is held against it".into(),
        };
        Some(Text::strong(side.machine.clone()).then(Text::marked(&format!(": {text}"))))
    };
    let gaps: Vec<Text> = sides.iter().filter_map(gap).collect();
    if !gaps.is_empty() {
        page.heading("Against published numbers: what is missed most");
        page.add(Block::List(gaps));
    }
}

/// What is not the same of what the numbers of the sides are of.
fn basis(page: &mut Document, comparison: &Comparison) {
    let rows = comparison.basis();
    if rows.is_empty() {
        return;
    }
    page.page_heading("What the numbers are of");
    page.on(Shown::Terminal, Block::Facts(decision::basis_facts(comparison, &rows)));
    page.on(Shown::Page, Block::Table(decision::basis_table(comparison, rows)));
}

/// The keys of the machine files that differ: of one dataflow, since those of two have hardly any
/// in common.
fn differences(page: &mut Document, sides: &[Side]) {
    let flow = |side: &Side| {
        let machine = side.record.get("configuration")?.get("machine")?;
        machine.get("dataflow").and_then(toml::Value::as_str).map(str::to_owned)
    };
    if sides.iter().any(|side| flow(side) != flow(&sides[0])) {
        return;
    }
    fn leaves(value: &toml::Value, path: String, keys: &mut Vec<(String, String)>) {
        match value.as_table() {
            Some(table) => table.iter().for_each(|(key, value)| {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                leaves(value, path, keys);
            }),
            None => keys.push((path, knob::shown(value))),
        }
    }
    let of = |side: &Side| {
        let mut keys = Vec::new();
        let machine = side.record.get("configuration").and_then(|all| all.get("machine"));
        machine.iter().for_each(|machine| leaves(machine, String::new(), &mut keys));
        keys
    };
    let keys: Vec<Vec<(String, String)>> = sides.iter().map(of).collect();
    if keys.iter().any(Vec::is_empty) {
        return;
    }
    let mut names: Vec<&String> = keys.iter().flatten().map(|(name, _)| name).collect();
    let mut seen = BTreeSet::new();
    names.retain(|name| seen.insert(*name));
    let mut table = Table::new(columns("key", Kind::Text, sides));
    let mut differ = false;
    for name in names.into_iter().filter(|name| !["name", "description"].contains(&name.as_str())) {
        let value = |keys: &Vec<(String, String)>| {
            let found = keys.iter().find(|(key, _)| key == name);
            found.map_or("-".to_owned(), |(_, value)| value.clone())
        };
        let values: Vec<String> = keys.iter().map(value).collect();
        if values.iter().any(|value| *value != values[0]) {
            let cells = values.into_iter().map(Cell::from);
            table.row([Cell::from(name.as_str())].into_iter().chain(cells));
            differ = true;
        }
    }
    if differ {
        page.page_heading("Keys of the machines that differ");
        page.on(Shown::Page, Block::Table(table));
    }
}

/// What bounds each side.
fn limits(page: &mut Document, comparison: &Comparison) {
    let limit = |side: &Side| {
        let sentence = crate::bottleneck::sentence(&bottleneck::of(&side.statistics)?);
        Some(Text::strong(side.label.clone()).then(format!(": {sentence}")))
    };
    page.add(Block::List(comparison.sides.iter().filter_map(limit).collect()));
}

/// What else differs.
fn notes<'a>(page: &mut Document, notes: impl IntoIterator<Item = &'a Note>) {
    for note in notes {
        let text = format!(" {}.", self::note(note));
        page.paragraph(Text::strong("Note:").then(Text::marked(&text)));
    }
}

/// Frames, what each shows, and the rate of the display where there is one.
fn shown(comparison: &Comparison) -> String {
    let first = &comparison.sides[0];
    match comparison.sides.iter().any(|side| side.task.is_shown()) {
        true => first.shown.at_rate(first.frames, first.display_fps),
        false => format!("{} of {}", first.shown.counted(first.frames), first.shown.size()),
    }
}

/// Whether frames of some side take longer than from one to the next.
fn has_latency(comparison: &Comparison) -> bool {
    let values = |measure| &comparison.row(measure).values;
    values(Measure::Latency) != values(Measure::FrameTime)
}

/// What a measure is called, with its unit.
fn words(measure: Measure, comparison: &Comparison) -> String {
    let rate = crate::format::rate(comparison.sides[0].display_fps);
    let noun = comparison.task().map_or("frame or step", |task| task.noun());
    let nouns = noun.replace(" or ", "s or ") + "s";
    let frames = comparison.sides.iter().map(|side| side.frames).max().unwrap_or(0);
    let time = if has_latency(comparison) { "interval" } else { "time" };
    let words = match measure {
        Measure::FrameTime => return format!("{noun} {time}, ms"),
        Measure::FrameTimeP99 if frames < crate::page::HUNDRED => {
            return format!("{noun} {time}, max of {frames}, ms");
        }
        Measure::FrameTimeP99 => return format!("{noun} {time}, p99, ms"),
        Measure::Latency => return format!("{noun} latency, ms"),
        Measure::Throughput => {
            return format!("{nouns} per second");
        }
        Measure::Energy => return format!("energy per {noun}, mJ"),
        Measure::Displayed => return format!("FPS shown, of {rate}"),
        Measure::Power
            if !comparison.sides.iter().all(|s| s.reaches_display() || !s.task.is_shown()) =>
        {
            return format!("power at {rate} FPS or what is reached, W");
        }
        Measure::Power => return format!("power at {rate} FPS, W"),
        Measure::PowerFullRate => "power at full rate, W",
        Measure::DramBytes => return format!("DRAM, MB per {noun}"),
        Measure::DramPeak => "DRAM peak, GB/s",
        Measure::Area => "area of the die, mm²",
        Measure::AreaCore => "of it the core (papers), mm²",
        Measure::Node => "node, nm",
        Measure::FpsPerWatt => return format!("{nouns} per J"),
        Measure::FpsPerArea => return format!("{nouns} per second and mm² of die"),
    };
    words.to_owned()
}

/// What the tables of a comparison are not to be read without: the versions, what the numbers are
/// of where that differs, and what else does.
pub fn caveats(comparison: &Comparison) -> Vec<String> {
    let basis = decision::basis_facts(comparison, &comparison.basis());
    let basis = basis.into_iter().map(|(part, text)| format!("{part}: {}", text.plain()));
    let made = format!("powergs-sim {TOOL_VERSION}, model {MODEL_VERSION}");
    let notes = comparison.notes.iter().map(|note| format!("{}.", self::note(note)));
    [made].into_iter().chain(basis).chain(notes).collect()
}

/// What else differs, as a sentence without its full stop.
pub fn note(note: &Note) -> String {
    fn differ<T>(what: &str, values: &[T], of: impl Fn(&T) -> String, so: &str) -> String {
        let mut shown: Vec<String> = Vec::new();
        for value in values.iter().map(of) {
            if !shown.contains(&value) {
                shown.push(value);
            }
        }
        format!("{what} differ ({}): {so}", shown.join(", "))
    }
    let file = |(name, hash): &(String, String)| format!("{name} {hash:.8}");
    match note {
        Note::Traces(v) => differ("traces", v, file, "the frames are not the same"),
        Note::FrameCounts(v) => {
            differ("frame counts", v, String::clone, "means are over other frames")
        }
        Note::Nodes { nodes, across } => {
            let so = if *across {
                "ratios of area, energy and power are those of technologies and machines together"
            } else {
                "area, energy and power have no ratios; give all sides a table of one node with \
                 --set energy=NAME (`arch list`), or take ratios --across-nodes"
            };
            differ("technology nodes", nodes, |nm| format!("{nm} nm"), so)
        }
        Note::Tasks { tasks, across } => {
            let so = if *across {
                "ratios are those of tasks and machines together"
            } else {
                "times, rates and energies have no ratios; compare machines of one task (trainers \
                 of GPUs: `orin-nx-train`), or take ratios --across-tasks"
            };
            differ("tasks", tasks, String::clone, so)
        }
        Note::Scopes { scopes, across } => {
            let so = if *across {
                "ratios of energy and power are those of what is counted and of machines together; \
                 areas have none"
            } else {
                "areas, energies and powers have no ratios; take those of energies and powers \
                 --across-nodes"
            };
            differ("scopes of power", scopes, String::clone, so)
        }
        Note::Starved { label, master: MasterGets { name, gets, asks } } => format!(
            "the {name} master of {label} is STARVED: it gets {} of {} GB/s \
             (`dram.{name}-master.in-flight`, `.priority`)",
            significant(*gets),
            significant(*asks)
        ),
        Note::Models(v) => differ("models", v, String::clone, "one of them has no time of its own"),
        Note::EnergyTables(v) => {
            differ("energy tables", v, String::clone, "joules have other prices")
        }
        Note::EnergyFiles(v) => {
            differ("files of the energy table", v, file, "joules have other prices")
        }
        Note::DisplayRates(v) => {
            differ("display rates", v, |fps| rate(*fps), "powers are for other rates")
        }
        Note::Versions(v) => differ(
            "versions",
            v,
            |(tool, model)| format!("{tool} model {model}"),
            "the same inputs may give other numbers",
        ),
        Note::SchemaVersions(v) => {
            differ("schema versions", v, i64::to_string, "some names have changed their meaning")
        }
        Note::Memories(v) => differ(
            "memories",
            v,
            |peak| format!("{} GB/s", significant(*peak)),
            "a part of each ratio is theirs; --common gives all machines that of the first",
        ),
        Note::DramModels(v) => {
            differ("DRAM models", v, String::clone, "times of DRAM are counted differently")
        }
        Note::DramPrices(v) => differ(
            "price assumptions of the DRAM",
            v,
            String::clone,
            "a part of the difference in energy and power is theirs, not the memories' (`explain` \
             says each, `replay` how far it moves the power)",
        ),
        Note::Misses { label, fps, displayed_fps, missed, frames } => format!(
            "{label} MISSES {} FPS in {missed} of {}: its power is at the {} FPS that it reaches",
            rate(*fps),
            frames,
            significant(*displayed_fps)
        ),
        Note::OffClock { label, clocks } => format!(
            "the prices of {label} are for {}, and it has {}: without a voltage-frequency curve \
             they are as given at any clock, so its energy and power are too high at a lower clock \
             and too low at a higher one",
            clocks.prices, clocks.clock
        ),
        Note::Incomplete { label, frames } => {
            format!("{label} is INCOMPLETE: {frames} only")
        }
    }
}

/// A column of names, then one of `kind` for each side.
pub(super) fn columns(first: &str, kind: Kind, sides: &[Side]) -> Vec<Column> {
    let side = |s: &Side| Column::new(s.label.clone(), kind).at_most(LABEL);
    [Column::text(first)].into_iter().chain(sides.iter().map(side)).collect()
}

/// Measures, with their ratios to the first side; of two sides also the difference.
fn measures(comparison: &Comparison) -> Table {
    let n = comparison.sides.len();
    let mut columns = columns("", Kind::Real(significant), &comparison.sides);
    let signed = |x: f64| format!("{}{}", if x > 0.0 { "+" } else { "" }, significant(x));
    if n == 2 {
        columns.push(Column::new("change", Kind::Real(signed)));
        columns.push(Column::fixed("ratio", 3));
    } else {
        let of = |side: &Side| Column::fixed(side.label.clone(), 3).at_most(LABEL);
        let group = format!("ratio to {}", comparison.sides[0].label);
        columns.extend(comparison.sides[1..].iter().map(|side| of(side).group(group.clone())));
    }
    let mut table = Table::new(columns);
    let is_repeated =
        |row: &ComparedMeasure| row.measure == Measure::Latency && !has_latency(comparison);
    let is_shown = |row: &&ComparedMeasure| {
        row.measure.is_shown() && !is_repeated(row) && row.values.iter().any(Option::is_some)
    };
    for row in comparison.rows.iter().filter(is_shown) {
        let mut cells = vec![words(row.measure, comparison).into()];
        cells.extend(row.values.iter().map(|v| Cell::from(*v)));
        if n == 2 {
            cells.push(row.difference(1).into());
        }
        cells.extend((1..n).map(|i| Cell::from(row.ratio(i))));
        table.row(cells);
    }
    table
}

/// Phases, energy and bytes by stage.
fn stages(sides: &[Side]) -> Table {
    let mut table = Table::new(columns("", Kind::Real(significant), sides));
    let mut add = |words: String, of: &dyn Fn(&Record) -> Option<f64>| {
        let values: Vec<Option<f64>> = sides.iter().map(|side| of(&side.statistics)).collect();
        if values.iter().any(Option::is_some) {
            let cells = values.into_iter().map(Cell::from);
            table.row([Cell::from(words)].into_iter().chain(cells));
        }
    };
    add("preprocessing, ms".into(), &|record| {
        let share = record.mean(Key::PreprocessingCycles)? / record.mean(Key::FrameCycles)?;
        Some(share * record.mean(Key::FrameTime)?).filter(|ms| !ms.is_nan())
    });
    for stage in Phase::ALL {
        let mj = |record: &Record| Some(record.mean(Key::EnergyIn(stage))? * 1e-9);
        add(format!("{}, mJ", stage.name()), &mj);
    }
    for stage in Phase::WORK {
        let (read, write) = (Key::StageRead(stage), Key::StageWrite(stage));
        let mb = |record: &Record| Some((record.mean(read)? + record.mean(write)?) * 1e-6);
        add(format!("{}, DRAM MB", stage.name()), &mb);
    }
    table
}

/// Shares of the cycles of each unit that are at least `least` for one of the sides.
fn stalls(sides: &[Side], least: f64) -> Table {
    let mut table = Table::new(columns("% of cycles", Kind::Real(percent), sides));
    for (unit, facts) in hardware().units() {
        let has = |record: &Record| record.mean(Key::Instances(unit)).is_some();
        let of_unit = |s: &Side| has(&s.statistics).then(|| s.statistics.unit_shares(unit));
        let shares: Vec<_> = sides.iter().map(of_unit).collect();
        for (part, name) in UnitPart::all().map(UnitPart::name).enumerate() {
            let values: Vec<Option<f64>> =
                shares.iter().map(|s| s.as_ref().map(|s| s[part])).collect();
            let shown = values.iter().flatten().any(|v| *v >= least && *v > 0.0);
            if shown && name != "idle" {
                let what = if part == 0 { "busy".into() } else { format!("waits: {name}") };
                let first = Cell::from(format!("{} {what}", facts.key));
                table.row([first].into_iter().chain(values.into_iter().map(Cell::from)));
            }
        }
    }
    table
}
