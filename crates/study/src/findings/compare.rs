//! Two or more runs beside each other: measures, ratios, and what else differs.

mod basis;
mod decision;
mod folder;
mod side;

pub use basis::Basis;
pub use decision::{AskedLimits, Decision, DecisionRow, Shortfall};
pub use folder::{RESULTS_FIRST, SideError};
pub use side::{OffClock, Side};

use crate::findings::masters::MasterGets;
use powergs_core::flow::Task;
use powergs_core::sim::statistics::Key;
use powergs_core::stage::{Does, hardware};

use super::limits::{Effect, not_modelled};

/// Which way is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Better {
    /// A smaller value.
    Less,
    /// A larger value.
    More,
    /// Neither by itself.
    Neither,
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// Distance of frames that run back to back, milliseconds, mean.
    FrameTime,
    /// 99 % of the frames take at most this, milliseconds: the slowest of fewer than 100.
    FrameTimeP99,
    /// Time of a frame from its first read to its last write, milliseconds, mean.
    Latency,
    /// Frames per second, back to back.
    Throughput,
    /// Energy of a frame, millijoules.
    Energy,
    /// Frames per second that the display gets: its rate, or what is reached of it.
    Displayed,
    /// Power at the display rate, or at what is reached of it, watts.
    Power,
    /// Power at full rate, watts.
    PowerFullRate,
    /// DRAM bytes of a frame, megabytes.
    DramBytes,
    /// Peak rate of the DRAM, 10⁹ bytes per second.
    DramPeak,
    /// Area of the die, mm².
    Area,
    /// The part of it that papers print: without PHY and memory controllers, mm².
    AreaCore,
    /// Technology node, nanometres.
    Node,
    /// Frames per second and watt: frames per joule.
    FpsPerWatt,
    /// Frames per second and mm² of die.
    FpsPerArea,
}

impl Measure {
    /// All measures, in report order.
    pub const ALL: [Measure; 15] = [
        Measure::FrameTime,
        Measure::FrameTimeP99,
        Measure::Latency,
        Measure::Throughput,
        Measure::Energy,
        Measure::Displayed,
        Measure::Power,
        Measure::PowerFullRate,
        Measure::DramBytes,
        Measure::DramPeak,
        Measure::Area,
        Measure::AreaCore,
        Measure::Node,
        Measure::FpsPerWatt,
        Measure::FpsPerArea,
    ];

    /// Whether it is shown to people. A display never runs at full rate: what is counted there is
    /// kept for programs.
    pub const fn is_shown(self) -> bool {
        !matches!(self, Measure::PowerFullRate | Measure::FpsPerWatt)
    }

    /// Whether it says as much of a technology as of a machine.
    pub const fn is_of_a_node(self) -> bool {
        match self {
            Measure::Energy
            | Measure::Power
            | Measure::PowerFullRate
            | Measure::Area
            | Measure::AreaCore
            | Measure::FpsPerWatt
            | Measure::FpsPerArea => true,
            Measure::FrameTime
            | Measure::FrameTimeP99
            | Measure::Latency
            | Measure::Throughput
            | Measure::Displayed
            | Measure::DramBytes
            | Measure::DramPeak
            | Measure::Node => false,
        }
    }

    /// Whether it is an area, or by area.
    pub const fn is_of_an_area(self) -> bool {
        matches!(self, Measure::Area | Measure::AreaCore | Measure::FpsPerArea)
    }

    /// Whether it says as much of the rate at which pictures are shown as of who makes them.
    pub const fn is_of_a_rate(self) -> bool {
        matches!(self, Measure::Displayed | Measure::Power)
    }

    /// Whether it says as much of what is done as of who does it.
    pub const fn is_of_a_task(self) -> bool {
        !matches!(self, Measure::DramPeak | Measure::Area | Measure::AreaCore | Measure::Node)
    }

    /// The name in JSON and CSV: snake_case with its unit.
    pub const fn name(self) -> &'static str {
        match self {
            Measure::FrameTime => "frame_time_ms",
            Measure::FrameTimeP99 => "frame_time_p99_ms",
            Measure::Latency => "frame_latency_ms",
            Measure::Throughput => "throughput_fps",
            Measure::Energy => "energy_per_frame_mj",
            Measure::Displayed => "displayed_fps",
            Measure::Power => "power_w",
            Measure::PowerFullRate => "power_full_rate_w",
            Measure::DramBytes => "dram_mb_per_frame",
            Measure::DramPeak => "dram_peak_gb_s",
            Measure::Area => "area_mm2",
            Measure::AreaCore => "area_core_mm2",
            Measure::Node => "node_nm",
            Measure::FpsPerWatt => "fps_per_w",
            Measure::FpsPerArea => "fps_per_mm2",
        }
    }

    /// Which way is better.
    pub const fn better(self) -> Better {
        match self {
            Measure::FrameTime
            | Measure::FrameTimeP99
            | Measure::Latency
            | Measure::Energy
            | Measure::Power
            | Measure::DramBytes
            | Measure::Area
            | Measure::AreaCore => Better::Less,
            Measure::PowerFullRate | Measure::DramPeak | Measure::Node => Better::Neither,
            Measure::Throughput
            | Measure::Displayed
            | Measure::FpsPerWatt
            | Measure::FpsPerArea => Better::More,
        }
    }

    /// The value of `side`, where it has one.
    fn of(self, side: &Side) -> Option<f64> {
        let record = &side.statistics;
        let time_ms = record.aggregate(Key::FrameTime);
        let fps = || time_ms.map(|t| t.mean).filter(|t| *t > 0.0).map(|t| 1e3 / t);
        let energy_j = record.value(Key::Energy) * 1e-12;
        let value = match self {
            Measure::FrameTime => time_ms?.mean,
            Measure::FrameTimeP99 => time_ms?.p99.as_f64(),
            Measure::Latency => record.mean(Key::FrameLatency)?,
            Measure::Throughput => fps()?,
            Measure::Energy => energy_j * 1e3,
            // No display waits for steps of training.
            Measure::Displayed | Measure::Power if !side.task.is_shown() => return None,
            Measure::Displayed => time_ms.map(|_| record.displayed_fps())?,
            Measure::Power => record.value(Key::Power),
            Measure::PowerFullRate => energy_j * fps()?,
            Measure::DramBytes => {
                (record.value(Key::ReadBytes) + record.value(Key::WriteBytes)) * 1e-6
            }
            Measure::DramPeak => side.dram_peak_gb_s?,
            Measure::Area => record.mean(Key::Area)?,
            // What papers print of a block; the rest of an SoC is no core.
            Measure::AreaCore if !side.is_block => return None,
            Measure::AreaCore => record.mean(Key::AreaCore)?,
            Measure::Node => side.node_nm?,
            Measure::FpsPerWatt => 1.0 / energy_j,
            Measure::FpsPerArea => fps()? / record.mean(Key::Area)?,
        };
        Some(value).filter(|x| x.is_finite())
    }
}

/// One measure of all sides.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ComparedMeasure {
    /// What was measured.
    pub measure: Measure,
    /// One value per side; `None` where a side does not have it.
    pub values: Vec<Option<f64>>,
    /// Whether the value of a side may be held against that of the first.
    pub is_comparable: Vec<bool>,
}

impl ComparedMeasure {
    /// The value of the first side and that of side `i`, where they may be compared.
    fn both(&self, i: usize) -> Option<(f64, f64)> {
        self.values[0].zip(self.values[i]).filter(|_| self.is_comparable[i])
    }

    /// The value of side `i` over that of the first side; `None` where they are of different
    /// technologies, or do different things.
    pub fn ratio(&self, i: usize) -> Option<f64> {
        let (first, other) = self.both(i)?;
        (first != 0.0).then(|| other / first)
    }

    /// The value of side `i` less that of the first side, as [`ComparedMeasure::ratio`].
    pub fn difference(&self, i: usize) -> Option<f64> {
        self.both(i).map(|(first, other)| other - first)
    }
}

/// Something else that differs, so that differences may not be of the machines alone. Lists have
/// one entry per side.
#[derive(Debug, Clone, PartialEq)]
pub enum Note {
    /// Name and XXH3 of the traces.
    Traces(Vec<(String, String)>),
    /// Numbers of frames.
    FrameCounts(Vec<String>),
    /// Technology nodes, where all are known.
    Nodes {
        /// Nanometres.
        nodes: Vec<f64>,
        /// Whether ratios across them were asked for.
        across: bool,
    },
    /// What a frame is.
    Tasks {
        /// Its name on each side.
        tasks: Vec<String>,
        /// Whether ratios across them were asked for.
        across: bool,
    },
    /// Another master of the memory of a side gets less than it asks for.
    Starved {
        /// Label of the side.
        label: String,
        /// What it gets.
        master: MasterGets,
    },
    /// What powers and energies are of.
    Scopes {
        /// That of each side.
        scopes: Vec<String>,
        /// Whether ratios across them were asked for.
        across: bool,
    },
    /// `cycle` or `paper`.
    Models(Vec<String>),
    /// Names of the energy tables.
    EnergyTables(Vec<String>),
    /// Name and XXH3 of energy tables of one name.
    EnergyFiles(Vec<(String, String)>),
    /// Display rates, frames per second.
    DisplayRates(Vec<f64>),
    /// Versions of the program and of the model.
    Versions(Vec<(String, i64)>),
    /// Versions of the names.
    SchemaVersions(Vec<i64>),
    /// Peak rates of the memories, 10⁹ bytes per second.
    Memories(Vec<f64>),
    /// Models of the DRAM.
    DramModels(Vec<String>),
    /// What the prices of the DRAM rest on: assumptions and references.
    DramPrices(Vec<String>),
    /// A side falls short of its display rate.
    Misses {
        /// Its label.
        label: String,
        /// The display rate, frames per second.
        fps: f64,
        /// What is reached of it, frames per second.
        displayed_fps: f64,
        /// Frames that take longer than the display period.
        missed: u64,
        /// Frames that it has, in words.
        frames: String,
    },
    /// The prices of a side are for another clock than its own, and as given at any.
    OffClock {
        /// Its label.
        label: String,
        /// Both clocks.
        clocks: OffClock,
    },
    /// A side has only some of its frames.
    Incomplete {
        /// Its label.
        label: String,
        /// Frames that it has, in words.
        frames: String,
    },
}

/// Runs beside each other; the first is what the others are compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// At least two, with labels of their own.
    pub sides: Vec<Side>,
    /// The measures, in the order of [`Measure::ALL`].
    pub rows: Vec<ComparedMeasure>,
    /// What else differs.
    pub notes: Vec<Note>,
    /// What is held against each other in spite of it.
    pub across: Across,
}

/// What is held against each other although it says more of something else than of the machines.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Across {
    /// Areas, energies and powers of different technology nodes, and energies and powers of blocks
    /// and of whole modules.
    pub nodes: bool,
    /// Times, rates and energies of different tasks.
    pub tasks: bool,
}

impl Comparison {
    /// Compares `sides`. Sides of one name are numbered. Areas, energies and powers of different
    /// technology nodes say more of the nodes than of the machines, and times and energies of
    /// different tasks more of the tasks: they have ratios only `across` these.
    pub fn new(mut sides: Vec<Side>, across: Across) -> Comparison {
        let names: Vec<String> = sides.iter().map(|s| s.label.clone()).collect();
        for (i, side) in sides.iter_mut().enumerate() {
            if names.iter().filter(|n| **n == side.label).count() > 1 {
                side.label = format!("{}-{}", side.label, i + 1);
            }
        }
        let is_comparable = |measure: Measure, side: &Side| {
            let nodes = side.node_nm.zip(sides[0].node_nm);
            let is_of_scope = side.power_scope == sides[0].power_scope;
            let same_node = nodes.is_none_or(|(a, b)| a == b);
            let is_of_node = across.nodes || (is_of_scope && same_node);
            let is_of_chip = side.is_block == sides[0].is_block;
            let is_of_task = across.tasks || side.task == sides[0].task;
            // Watts at other rates are watts for other pictures.
            let at_rate =
                |side: &Side| side.reaches_display() && side.display_fps == sides[0].display_fps;
            let is_of_rate = at_rate(&sides[0]) && at_rate(side);
            // A node is a name, not an amount.
            measure != Measure::Node
                && (is_of_node || !measure.is_of_a_node())
                && (is_of_task || !measure.is_of_a_task())
                && (is_of_chip || !measure.is_of_an_area())
                && (is_of_rate || !measure.is_of_a_rate())
        };
        let row = |measure: Measure| ComparedMeasure {
            measure,
            values: sides.iter().map(|side| measure.of(side)).collect(),
            is_comparable: sides.iter().map(|side| is_comparable(measure, side)).collect(),
        };
        let (rows, notes) = (Measure::ALL.map(row).to_vec(), notes(&sides, across));
        Comparison { sides, rows, notes, across }
    }

    /// The mean of a statistic of side `i` over that of the first side; `None` as
    /// [`ComparedMeasure::ratio`], by what the statistic is of.
    pub fn ratio_of(&self, name: &str, i: usize) -> Option<f64> {
        let is_of = |part: &str| name.split('.').next().is_some_and(|first| first.contains(part));
        let like = match () {
            () if is_of("area_mm2") => Measure::Area,
            () if is_of("power") || name.ends_with("_w") => Measure::Power,
            () if is_of("energy") => Measure::Energy,
            () => Measure::Throughput,
        };
        let mean = |side: &Side| Some(side.statistics.named(name)?.mean);
        let (first, other) = mean(&self.sides[0]).zip(mean(&self.sides[i]))?;
        let ratio = Some(other / first).filter(|_| self.row(like).is_comparable[i]);
        ratio.filter(|ratio| ratio.is_finite())
    }

    /// Labels of the sides for charts: with their nodes, where these differ.
    pub fn labels_with_nodes(&self) -> Vec<String> {
        let differ = self.sides.iter().any(|side| side.node_nm != self.sides[0].node_nm);
        let label = |side: &Side| match side.node_nm.filter(|_| differ) {
            Some(node) => format!("{}, {node} nm", side.label),
            None => side.label.clone(),
        };
        self.sides.iter().map(label).collect()
    }

    /// Labels of the sides.
    pub fn labels(&self) -> Vec<&str> {
        self.sides.iter().map(|s| s.label.as_str()).collect()
    }

    /// What the sides do not have in common of what their numbers are of: a value a side, `None`
    /// where its record does not say.
    pub fn basis(&self) -> Vec<(Basis, Vec<Option<String>>)> {
        let of = |part: Basis| (part, self.sides.iter().map(|s| part.of(s)).collect::<Vec<_>>());
        let differs = |(_, values): &(Basis, Vec<Option<String>>)| {
            values.iter().any(|value| *value != values[0])
        };
        Basis::ALL.map(of).into_iter().filter(differs).collect()
    }

    /// Effects that some sides leave out and others do not, each with whether a side leaves it out:
    /// what is free for these.
    pub fn left_out_by_some(&self) -> Vec<(Effect, Vec<bool>)> {
        let by = |effect: Effect| {
            let leaves = |side: &Side| side.left_out.iter().any(|what| what == effect.what);
            (effect, self.sides.iter().map(leaves).collect::<Vec<_>>())
        };
        let is_mixed = |(_, by): &(Effect, Vec<bool>)| by.contains(&true) && by.contains(&false);
        let mut all: Vec<(Effect, Vec<bool>)> = Vec::new();
        for row in not_modelled().into_iter().map(by).filter(is_mixed) {
            if !all.iter().any(|(known, _)| known.what == row.0.what) {
                all.push(row);
            }
        }
        all
    }

    /// Work that some sides do and others do not: its key, and how often each does it in a frame.
    pub fn done_by_some(&self) -> Vec<(&'static str, Vec<f64>)> {
        let of = |key: &'static str| {
            let name = format!("actions.{}", key.replace('-', "_"));
            let n = |side: &Side| side.statistics.named(&name).map_or(0.0, |all| all.mean);
            (key, self.sides.iter().map(n).collect::<Vec<f64>>())
        };
        let work = hardware().actions().filter_map(|(_, does)| match does {
            Does::Work(_, work) => Some(work.key),
            _ => None,
        });
        let is_mixed = |(_, n): &(&str, Vec<f64>)| n.contains(&0.0) && n.iter().any(|n| *n > 0.0);
        work.map(of).filter(is_mixed).collect()
    }

    /// What all sides do; `None` where they do different things.
    pub fn task(&self) -> Option<Task> {
        let first = self.sides[0].task;
        self.sides.iter().all(|side| side.task == first).then_some(first)
    }

    /// One measure of all sides.
    pub fn row(&self, measure: Measure) -> &ComparedMeasure {
        &self.rows[measure as usize]
    }

    /// Frames per second of the slowest other side over those of the first; `None` without times.
    pub fn least_speedup(&self) -> Option<f64> {
        let fps = self.row(Measure::Throughput);
        let ratios: Option<Vec<f64>> = (1..self.sides.len()).map(|i| fps.ratio(i)).collect();
        ratios?.into_iter().reduce(f64::min)
    }
}

/// What else differs between the sides.
fn notes(sides: &[Side], across: Across) -> Vec<Note> {
    fn differing<T: PartialEq>(
        sides: &[Side],
        of: impl Fn(&Side) -> T,
        note: impl Fn(Vec<T>) -> Note,
    ) -> Option<Note> {
        let values: Vec<T> = sides.iter().map(of).collect();
        values.iter().any(|v| *v != values[0]).then(|| note(values))
    }
    let mut notes = vec![
        differing(sides, |s| s.task.name(), |tasks| Note::Tasks { tasks, across: across.tasks }),
        differing(sides, |s| (s.trace.clone(), s.trace_hash.clone()), Note::Traces),
        differing(sides, |s| s.shown.counted(s.frames), Note::FrameCounts),
        differing(sides, |s| s.model.clone(), Note::Models),
    ];
    let peaks: Option<Vec<f64>> = sides.iter().map(|s| s.dram_peak_gb_s).collect();
    let peaks = peaks.filter(|peaks| peaks.iter().any(|peak| *peak != peaks[0]));
    notes.push(peaks.map(Note::Memories));
    let scopes = |scopes| Note::Scopes { scopes, across: across.nodes };
    notes.push(differing(sides, |s| s.power_scope.clone(), scopes));
    let nodes: Option<Vec<f64>> = sides.iter().map(|s| s.node_nm).collect();
    if let Some(nodes) = nodes.filter(|nodes| nodes.iter().any(|node| *node != nodes[0])) {
        notes.push(Some(Note::Nodes { nodes, across: across.nodes }));
    }
    // Tables of two nodes differ anyway; two of one node are two people's prices.
    let is_of_another =
        |a: &Side, b: &Side| a.node_nm == b.node_nm && a.energy_table != b.energy_table;
    if sides.iter().any(|a| sides.iter().any(|b| is_of_another(a, b))) {
        notes.push(differing(sides, |s| s.energy_table.clone(), Note::EnergyTables));
    }
    if sides.iter().all(|s| s.energy_table == sides[0].energy_table) {
        let table = |s: &Side| (s.energy_table.clone(), s.energy_hash.clone());
        notes.push(differing(sides, table, Note::EnergyFiles));
    }
    let versions = |s: &Side| (s.tool_version.clone(), s.model_version);
    notes.extend([
        differing(sides, |s| s.display_fps, Note::DisplayRates),
        differing(sides, versions, Note::Versions),
        differing(sides, |s| s.schema_version, Note::SchemaVersions),
        differing(sides, |s| s.dram_model.clone(), Note::DramModels),
    ]);
    // An older record, or the published model, says nothing of them.
    if sides.iter().all(|s| !s.dram_prices.is_empty()) {
        notes.push(differing(sides, |s| s.dram_prices.join(" and "), Note::DramPrices));
    }
    let misses = |s: &Side| {
        let (label, displayed_fps) = (s.label.clone(), s.statistics.displayed_fps());
        let (fps, frames) = (s.display_fps, s.shown.counted(s.frames));
        let missed = s.statistics.deadline_misses()?;
        (missed > 0).then_some(Note::Misses { label, fps, displayed_fps, missed, frames })
    };
    let starved = |s: &Side| {
        let gets = s.masters.gets(|key| s.statistics.mean(key)).into_iter();
        let label = s.label.clone();
        let starved = gets.filter(MasterGets::is_starved);
        starved
            .map(move |master| Note::Starved { label: label.clone(), master })
            .collect::<Vec<_>>()
    };
    let off_clock = |s: &Side| {
        let clocks = s.off_clock?;
        Some(Note::OffClock { label: s.label.clone(), clocks })
    };
    let incomplete = |s: &Side| {
        let frames = s.shown.counted(s.frames);
        s.incomplete.then(|| Note::Incomplete { label: s.label.clone(), frames })
    };
    let of_sides = sides.iter().filter_map(misses).chain(sides.iter().flat_map(starved));
    let of_sides = of_sides.chain(sides.iter().filter_map(off_clock));
    let of_sides = of_sides.chain(sides.iter().filter_map(incomplete));
    notes.into_iter().flatten().chain(of_sides).collect()
}
