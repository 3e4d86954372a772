//! The statistics that conclusions are drawn from, as typed keys: the catalogue has their names
//! from here, so that nobody can ask for a number that no run has.

use crate::machine::MASTERS;
use crate::stage::{Stall, StatDecl, hardware, stage};
use powergs_energy::Component;
use powergs_energy::action::{BufferId, Phase, StageId};
use powergs_frame::fovea::REGIONS;

/// A statistic of the catalogue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// Distance of frames, milliseconds, by its name of before.
    FrameTime,
    /// The same.
    FrameInterval,
    /// Time of a frame from its first read to its last write, milliseconds.
    FrameLatency,
    /// Whole display periods for which a frame is shown.
    DisplayPeriods,
    /// Frames per second that the display gets.
    DisplayedFps,
    /// 1 for a frame that takes longer than the display period, else 0.
    DeadlineMissed,
    /// Length of a frame, cycles.
    FrameCycles,
    /// Cycles until the last CCU was done.
    PreprocessingCycles,
    /// Power at the display rate, watts.
    Power,
    /// The part of it that is a component's, watts.
    PowerOf(Component),
    /// Power of the display, watts.
    DisplayPower,
    /// Power at the display rate and that of the display, watts.
    PowerWithDisplay,
    /// Energy of a frame, picojoules.
    Energy,
    /// The part of it that is a component's, picojoules; standby for the frame's own time.
    EnergyOf(Component),
    /// The part of it that is a stage's, picojoules.
    EnergyIn(Phase),
    /// Energy of a component in a stage that works, picojoules; one of [`Key::COMPONENTS`].
    EnergyPart(Phase, Component),
    /// Area of the die, mm².
    Area,
    /// The part of it that papers print: without PHY and memory controllers, mm².
    AreaCore,
    /// Bytes read from DRAM, all stages.
    ReadBytes,
    /// Bytes written to DRAM, all stages.
    WriteBytes,
    /// Bytes moved in or out of buffers, all stages.
    SramBytes,
    /// Bytes that a stage that works reads from DRAM.
    StageRead(Phase),
    /// Bytes that a stage that works writes to DRAM.
    StageWrite(Phase),
    /// Bytes that a stage that works moves in or out of buffers.
    StageSram(Phase),
    /// How many units of a kind the machine has.
    Instances(StageId),
    /// Cycles with work, summed over the units of a kind.
    Busy(StageId),
    /// Cycles with work that could not proceed for a cause, summed over the units of a kind.
    Stalled(StageId, Stall),
    /// Cycles without work, summed over the units of a kind.
    Idle(StageId),
    /// Lanes at work while the units of a kind work, 0 to 1, where they have lanes.
    LaneUtilisation(StageId),
    /// Share of the frame in which the data bus of the DRAM moved data, 0 to 1.
    DramBusy,
    /// DRAM bytes over the frame time, 10⁹ bytes per second.
    DramRate,
    /// Bytes that are read from DRAM and that nobody wrote.
    UnwrittenBytes,
    /// Bytes of another master over the frame time, 10⁹ bytes per second: its place in [`MASTERS`].
    MasterRate(usize),
    /// Bytes moved by bursts of the DRAM per byte that was asked for.
    MovedPerRequested,
    /// Share of the bursts that found their row open, 0 to 1.
    RowHits,
    /// What a stage measures.
    Stat(&'static StatDecl),
    /// Bursts read by a stage that works.
    BurstsRead(Phase),
    /// Bursts written by a stage that works.
    BurstsWritten(Phase),
    /// Rows opened by a stage that works.
    RowsOpened(Phase),
    /// Size of a buffer that fills and empties, all its shares together, bytes; so in those below.
    Capacity(BufferId),
    /// The most that a buffer held, bytes.
    Peak(BufferId),
    /// What a buffer held on average, bytes.
    Held(BufferId),
    /// Bytes that entered a buffer.
    Filled(BufferId),
    /// Bytes that left a buffer because they had been used.
    Consumed(BufferId),
    /// Bytes that left a buffer unused.
    Discarded(BufferId),
    /// Tiles of a region of foveated frames: its place in [`REGIONS`]; so in those below.
    RegionTiles(usize),
    /// List entries that the tiles of a region load.
    RegionEntries(usize),
    /// Cycles for which the rendering units of a core work on a region.
    RegionCycles(usize),
    /// Energy of sorting and rendering the tiles of a region, picojoules.
    RegionEnergy(usize),
}

impl Key {
    /// The components that are paid for work: those of [`Key::EnergyPart`].
    pub const COMPONENTS: [Component; 3] = [Component::Dram, Component::Sram, Component::Flop];

    /// The name in the catalogue.
    pub fn name(self) -> String {
        let of = |group: &str, of: &str, end: &str| format!("{group}.{of}.{end}");
        let unit = |kind: StageId, end: &str| of("units", stage(kind).key, end);
        let bursts = |phase: Phase, end: &str| of("dram.stages", phase.name(), end);
        let bytes = |phase: Phase, end: &str| of("stages", phase.name(), end);
        let buffer =
            |buffer: BufferId, end: &str| of("buffers", hardware().buffer(buffer).name, end);
        let region = |k: usize, end: &str| of("regions", &REGIONS[k].to_lowercase(), end);
        match self {
            Key::PowerOf(part) => format!("power_w.{}", part.name()),
            Key::EnergyOf(part) => format!("energy_pj.{}", part.name()),
            Key::EnergyIn(stage) => format!("energy_pj.{}", stage.name()),
            Key::EnergyPart(stage, part) => of("energy_by_stage_pj", stage.name(), part.name()),
            Key::StageRead(stage) => bytes(stage, "dram_read_bytes"),
            Key::StageWrite(stage) => bytes(stage, "dram_write_bytes"),
            Key::StageSram(stage) => bytes(stage, "sram_bytes"),
            Key::Instances(kind) => unit(kind, "instances"),
            Key::Busy(kind) => unit(kind, "busy_cycles"),
            Key::Stalled(kind, cause) => unit(kind, &format!("stall_{}_cycles", cause.name())),
            Key::Idle(kind) => unit(kind, "idle_cycles"),
            Key::LaneUtilisation(kind) => unit(kind, "lane_utilisation"),
            Key::BurstsRead(stage) => bursts(stage, "reads"),
            Key::BurstsWritten(stage) => bursts(stage, "writes"),
            Key::RowsOpened(stage) => bursts(stage, "activates"),
            Key::Capacity(of) => buffer(of, "capacity_bytes"),
            Key::Peak(of) => buffer(of, "peak_bytes"),
            Key::Held(of) => buffer(of, "mean_bytes"),
            Key::Filled(of) => buffer(of, "filled_bytes"),
            Key::Consumed(of) => buffer(of, "consumed_bytes"),
            Key::Discarded(of) => buffer(of, "discarded_bytes"),
            Key::RegionTiles(k) => region(k, "tiles"),
            Key::RegionEntries(k) => region(k, "entries"),
            Key::RegionCycles(k) => region(k, "cycles"),
            Key::RegionEnergy(k) => region(k, "energy_pj"),
            Key::FrameTime => "frame_time_ms".into(),
            Key::FrameInterval => "frame_interval_ms".into(),
            Key::FrameLatency => "frame_latency_ms".into(),
            Key::DisplayPeriods => "display_periods".into(),
            Key::DisplayedFps => "displayed_fps".into(),
            Key::DeadlineMissed => "deadline_missed".into(),
            Key::FrameCycles => "frame_cycles".into(),
            Key::PreprocessingCycles => "preprocessing_cycles".into(),
            Key::Power => "power_w.total".into(),
            Key::DisplayPower => "display_power_w".into(),
            Key::PowerWithDisplay => "rendering_plus_display_w".into(),
            Key::Energy => "energy_pj.total".into(),
            Key::Area => "area_mm2.total".into(),
            Key::AreaCore => "area_mm2.core".into(),
            Key::ReadBytes => "dram_read_bytes".into(),
            Key::WriteBytes => "dram_write_bytes".into(),
            Key::SramBytes => "sram_bytes".into(),
            Key::DramBusy => "dram.busy_frac".into(),
            Key::DramRate => "dram.bandwidth_gb_s".into(),
            Key::UnwrittenBytes => "dram.unwritten_bytes".into(),
            Key::MasterRate(place) => format!("dram.{}_master_gb_s", MASTERS[place]),
            Key::MovedPerRequested => "dram.moved_per_requested".into(),
            Key::RowHits => "dram.row_hit_frac".into(),
            Key::Stat(stat) => stat.name.into(),
        }
    }
}

impl From<Key> for String {
    fn from(key: Key) -> String {
        key.name()
    }
}
