//! Two or more runs beside each other: measures, ratios, and what else differs.

mod folder;
mod side;

pub use folder::{RESULTS_FIRST, SideError};
pub use side::Side;

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
    /// Frame time, milliseconds, mean.
    FrameTime,
    /// 99 % of the frames take at most this, milliseconds.
    FrameTimeP99,
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
    /// Area of the chip, mm².
    Area,
    /// Frames per second and watt: frames per joule.
    FpsPerWatt,
    /// Frames per second and mm².
    FpsPerArea,
    /// Frames per second and 10⁹ bytes per second of peak rate.
    FpsPerBandwidth,
    /// Frames per second times the ratio of areas, as if performance grew in proportion.
    FpsAtArea,
    /// Frames per second times the ratio of peak DRAM rates.
    FpsAtBandwidth,
}

impl Measure {
    /// All measures, in report order.
    pub const ALL: [Measure; 15] = [
        Measure::FrameTime,
        Measure::FrameTimeP99,
        Measure::Throughput,
        Measure::Energy,
        Measure::Displayed,
        Measure::Power,
        Measure::PowerFullRate,
        Measure::DramBytes,
        Measure::DramPeak,
        Measure::Area,
        Measure::FpsPerWatt,
        Measure::FpsPerArea,
        Measure::FpsPerBandwidth,
        Measure::FpsAtArea,
        Measure::FpsAtBandwidth,
    ];

    /// The name in JSON and CSV: snake_case with its unit.
    pub const fn name(self) -> &'static str {
        match self {
            Measure::FrameTime => "frame_time_ms",
            Measure::FrameTimeP99 => "frame_time_p99_ms",
            Measure::Throughput => "throughput_fps",
            Measure::Energy => "energy_per_frame_mj",
            Measure::Displayed => "displayed_fps",
            Measure::Power => "power_w",
            Measure::PowerFullRate => "power_full_rate_w",
            Measure::DramBytes => "dram_mb_per_frame",
            Measure::DramPeak => "dram_peak_gb_s",
            Measure::Area => "area_mm2",
            Measure::FpsPerWatt => "fps_per_w",
            Measure::FpsPerArea => "fps_per_mm2",
            Measure::FpsPerBandwidth => "fps_per_gb_s",
            Measure::FpsAtArea => "iso_area_fps",
            Measure::FpsAtBandwidth => "iso_bandwidth_fps",
        }
    }

    /// Which way is better.
    pub const fn better(self) -> Better {
        match self {
            Measure::FrameTime
            | Measure::FrameTimeP99
            | Measure::Energy
            | Measure::Power
            | Measure::DramBytes
            | Measure::Area => Better::Less,
            Measure::PowerFullRate | Measure::DramPeak => Better::Neither,
            Measure::Throughput
            | Measure::Displayed
            | Measure::FpsPerWatt
            | Measure::FpsPerArea
            | Measure::FpsPerBandwidth
            | Measure::FpsAtArea
            | Measure::FpsAtBandwidth => Better::More,
        }
    }

    /// The value of `side`, where it has one; `first` is what the sides are compared with.
    fn of(self, side: &Side, first: &Side) -> Option<f64> {
        let summary = &side.summary;
        let cycle = summary.cycle.as_ref();
        let fps = || cycle.map(|c| c.frame_time_ms).filter(|t| *t > 0.0).map(|t| 1e3 / t);
        let energy_j = summary.energy.total_pj * 1e-12;
        let (area, peak) = (|s: &Side| s.summary.area_mm2, |s: &Side| s.dram_peak_gb_s);
        let value = match self {
            Measure::FrameTime => cycle?.frame_time_ms,
            Measure::FrameTimeP99 => cycle?.frame_time_p99_ms,
            Measure::Throughput => fps()?,
            Measure::Energy => energy_j * 1e3,
            Measure::Displayed => cycle.map(|_| summary.displayed_fps)?,
            Measure::Power => summary.power_w,
            Measure::PowerFullRate => energy_j * fps()?,
            Measure::DramBytes => summary.all_dram_bytes.sum() * 1e-6,
            Measure::DramPeak => peak(side)?,
            Measure::Area => area(side)?,
            Measure::FpsPerWatt => 1.0 / energy_j,
            Measure::FpsPerArea => fps()? / area(side)?,
            Measure::FpsPerBandwidth => fps()? / peak(side)?,
            Measure::FpsAtArea => fps()? * area(first)? / area(side)?,
            Measure::FpsAtBandwidth => fps()? * peak(first)? / peak(side)?,
        };
        Some(value).filter(|x| x.is_finite())
    }
}

/// One measure of all sides.
#[derive(Debug, Clone, PartialEq)]
pub struct ComparedMeasure {
    /// What was measured.
    pub measure: Measure,
    /// One value per side; `None` where a side does not have it.
    pub values: Vec<Option<f64>>,
}

impl ComparedMeasure {
    /// The value of side `i` over that of the first side.
    pub fn ratio(&self, i: usize) -> Option<f64> {
        let (first, other) = (self.values[0]?, self.values[i]?);
        (first != 0.0).then(|| other / first)
    }
}

/// Something else that differs, so that differences may not be of the machines alone. Lists have
/// one entry per side.
#[derive(Debug, Clone, PartialEq)]
pub enum Note {
    /// Name and XXH3 of the traces.
    Traces(Vec<(String, String)>),
    /// Numbers of frames.
    FrameCounts(Vec<i64>),
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
    /// Models of the DRAM.
    DramModels(Vec<String>),
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
        /// Frames that it has.
        frames: i64,
    },
    /// A side has only some of its frames.
    Incomplete {
        /// Its label.
        label: String,
        /// Frames that it has.
        frames: i64,
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
}

impl Comparison {
    /// Compares `sides`. Sides of one name are numbered.
    pub fn new(mut sides: Vec<Side>) -> Comparison {
        let names: Vec<String> = sides.iter().map(|s| s.label.clone()).collect();
        for (i, side) in sides.iter_mut().enumerate() {
            if names.iter().filter(|n| **n == side.label).count() > 1 {
                side.label = format!("{}-{}", side.label, i + 1);
            }
        }
        let row = |measure: Measure| ComparedMeasure {
            measure,
            values: sides.iter().map(|side| measure.of(side, &sides[0])).collect(),
        };
        let (rows, notes) = (Measure::ALL.map(row).to_vec(), notes(&sides));
        Comparison { sides, rows, notes }
    }

    /// Labels of the sides.
    pub fn labels(&self) -> Vec<&str> {
        self.sides.iter().map(|s| s.label.as_str()).collect()
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
fn notes(sides: &[Side]) -> Vec<Note> {
    fn differing<T: PartialEq>(
        sides: &[Side],
        of: impl Fn(&Side) -> T,
        note: impl Fn(Vec<T>) -> Note,
    ) -> Option<Note> {
        let values: Vec<T> = sides.iter().map(of).collect();
        values.iter().any(|v| *v != values[0]).then(|| note(values))
    }
    let mut notes = vec![
        differing(sides, |s| (s.trace.clone(), s.trace_hash.clone()), Note::Traces),
        differing(sides, |s| s.frames, Note::FrameCounts),
        differing(sides, |s| s.model.clone(), Note::Models),
        differing(sides, |s| s.energy_table.clone(), Note::EnergyTables),
    ];
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
    let misses = |s: &Side| {
        let (label, displayed_fps) = (s.label.clone(), s.summary.displayed_fps);
        let (fps, frames) = (s.display_fps, s.frames);
        let missed = s.summary.cycle.as_ref()?.deadline_misses;
        (missed > 0).then_some(Note::Misses { label, fps, displayed_fps, missed, frames })
    };
    let incomplete = |s: &Side| {
        s.incomplete.then(|| Note::Incomplete { label: s.label.clone(), frames: s.frames })
    };
    let of_sides = sides.iter().filter_map(misses).chain(sides.iter().filter_map(incomplete));
    notes.into_iter().flatten().chain(of_sides).collect()
}
