//! What is measured for a row.

use super::totals::Totals;
use powergs_core::flow::gpu::KernelPart;
use powergs_core::stage::{hardware, stage};
use powergs_energy::action::StageId;

/// A measure of a machine, or of one machine against another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metric {
    /// Area of the chip, mm².
    Area,
    /// Area of the other machine over that of this one.
    AreaRatio,
    /// Frames per second: frames over the sum of their times.
    Fps,
    /// Frames per second over those of the other machine.
    Speedup,
    /// The same of the time after preprocessing: sorting and rendering.
    TileSpeedup,
    /// Power of the chip without its DRAM when frames run back to back, watts.
    Power,
    /// Power of the chip when every unit does all that it can in every cycle, watts.
    PeakPower,
    /// Energy of the chip without its DRAM per frame, mJ.
    Energy,
    /// Energy of a frame, DRAM included, mJ.
    FrameEnergy,
    /// Share of the kernels of a GPU in the time of all.
    KernelShare(KernelPart),
    /// Time of the backward pass over that of the frame before it, on a GPU that trains.
    BackwardOverForward,
    /// Time of the backward pass on the other GPU over that on this one.
    BackwardSpeedup,
    /// Time of blending on the other GPU over that on this one.
    BlendSpeedup,
    /// Quads that raster operations blend on the other GPU over those on this one.
    QuadSaving,
    /// Energy of a frame on the other machine over that on this one, without DRAM.
    EnergyRatio,
    /// Energy-delay product on the other machine over that on this one, without DRAM.
    EdpRatio,
    /// Live pixel evaluations over rendering units times the cycles in which their core has a tile,
    /// busy or stalled.
    RasterUtilisation,
    /// Utilisation of the rendering units over the whole frame, stalls and idle time included.
    FrameUtilisation,
    /// DRAM bytes per frame, MB.
    DramBytes,
    /// Bytes that preprocessing reads from DRAM per frame, MB.
    RecordBytes,
    /// Bytes that rendering reads from DRAM per frame, MB.
    FeatureBytes,
    /// Share of the DRAM bytes that sorting moves; lists that the CCU writes count as sorting.
    SortingShare,
    /// DRAM bytes that are saved against the other machine, as a share.
    DramSaving,
    /// Bytes that bursts of the DRAM move, over those on the other machine.
    MovedRatio,
    /// Bytes that rendering reads from DRAM and that are saved against the other machine, as a
    /// share.
    FeatureSaving,
    /// α evaluations that are executed, over those of the other machine.
    EvaluationShare,
    /// DRAM traffic at 60 frames per second, GB/s.
    TrafficAt60,
    /// Stalls for banks, all units, as a share of the unit cycles.
    BankStalls,
    /// List entries times pixels over α evaluations until pixels stop.
    TerminationSaving,
    /// Survivors of the cull that no tile loads, as a share.
    UnusedSurvivors,
    /// Share of lists that keep more than 78 % of their entries in the next frame.
    ListsKeeping,
    /// Share of the DRAM in the energy of chip and DRAM.
    DramShare,
    /// Share of the time after preprocessing: sorting and rendering.
    TileShare,
    /// Entries of the tile lists of a frame, million.
    TilePairs,
    /// Mean length of the lists that have an entry.
    ListLength,
    /// Area of one kind of unit, or of all buffers, mm².
    BlockArea(Block),
    /// Power of them when each does all that it can in every cycle, watts.
    BlockPower(Block),
    /// 99th percentile of how far a kept entry moves in its list, entries.
    RankShift,
}

/// A kind of unit, or all buffers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Block {
    /// All units of a kind.
    Unit(StageId),
    /// Every buffer of the chip.
    Buffers,
}

impl Block {
    /// All blocks.
    pub fn all() -> impl Iterator<Item = Block> {
        let units = hardware().units().map(|(id, _)| Block::Unit(id));
        units.chain([Block::Buffers])
    }

    /// The end of the names of its metrics.
    fn name(self) -> &'static str {
        match self {
            Block::Unit(unit) => stage(unit).key,
            Block::Buffers => "buffers",
        }
    }

    /// Whether what is called `name` in a list of areas or powers belongs to it.
    pub(super) fn has(self, name: &str) -> bool {
        match self {
            Block::Unit(unit) => name == stage(unit).key,
            Block::Buffers => hardware().buffers().any(|(_, buffer)| name == buffer.name),
        }
    }
}

/// Name, unit, whether it compares two machines, whether it needs frames.
type MetricFacts = (&'static str, &'static str, bool, bool);

impl Metric {
    /// All metrics but those of blocks.
    const WHOLE: [Metric; 39] = [
        Metric::Area,
        Metric::AreaRatio,
        Metric::Fps,
        Metric::Speedup,
        Metric::TileSpeedup,
        Metric::Power,
        Metric::PeakPower,
        Metric::Energy,
        Metric::FrameEnergy,
        Metric::KernelShare(KernelPart::Convert),
        Metric::KernelShare(KernelPart::Pairs),
        Metric::KernelShare(KernelPart::Sort),
        Metric::KernelShare(KernelPart::Blend),
        Metric::BackwardOverForward,
        Metric::BackwardSpeedup,
        Metric::BlendSpeedup,
        Metric::QuadSaving,
        Metric::EnergyRatio,
        Metric::EdpRatio,
        Metric::RasterUtilisation,
        Metric::FrameUtilisation,
        Metric::DramBytes,
        Metric::RecordBytes,
        Metric::FeatureBytes,
        Metric::SortingShare,
        Metric::DramSaving,
        Metric::MovedRatio,
        Metric::FeatureSaving,
        Metric::EvaluationShare,
        Metric::TrafficAt60,
        Metric::BankStalls,
        Metric::TerminationSaving,
        Metric::UnusedSurvivors,
        Metric::ListsKeeping,
        Metric::RankShift,
        Metric::DramShare,
        Metric::TileShare,
        Metric::TilePairs,
        Metric::ListLength,
    ];

    /// All metrics.
    pub fn all() -> impl Iterator<Item = Metric> {
        let areas = Block::all().map(Metric::BlockArea);
        Metric::WHOLE.into_iter().chain(areas).chain(Block::all().map(Metric::BlockPower))
    }

    const fn facts(self) -> MetricFacts {
        match self {
            Metric::Area => ("area", "mm²", false, false),
            Metric::AreaRatio => ("area_ratio", "x", true, false),
            Metric::Fps => ("fps", "FPS", false, true),
            Metric::Speedup => ("speedup", "x", true, true),
            Metric::TileSpeedup => ("tile_speedup", "x", true, true),
            Metric::Power => ("power", "W", false, true),
            Metric::PeakPower => ("peak_power", "W", false, false),
            Metric::Energy => ("energy", "mJ", false, true),
            Metric::FrameEnergy => ("frame_energy", "mJ", false, true),
            Metric::KernelShare(KernelPart::Convert) => ("convert_share", "", false, true),
            Metric::KernelShare(KernelPart::Pairs) => ("pairs_share", "", false, true),
            Metric::KernelShare(KernelPart::Sort) => ("sort_share", "", false, true),
            Metric::KernelShare(KernelPart::Blend) => ("blend_share", "", false, true),
            Metric::KernelShare(part) => (part.name(), "", false, true),
            Metric::BackwardOverForward => ("backward_over_forward", "", false, true),
            Metric::BackwardSpeedup => ("backward_speedup", "x", true, true),
            Metric::BlendSpeedup => ("blend_speedup", "x", true, true),
            Metric::QuadSaving => ("quad_saving", "x", true, true),
            Metric::EnergyRatio => ("energy_ratio", "x", true, true),
            Metric::EdpRatio => ("edp_ratio", "x", true, true),
            Metric::RasterUtilisation => ("raster_utilisation", "", false, true),
            Metric::FrameUtilisation => ("frame_utilisation", "", false, true),
            Metric::DramBytes => ("dram_bytes", "MB", false, true),
            Metric::RecordBytes => ("record_bytes", "MB", false, true),
            Metric::FeatureBytes => ("feature_bytes", "MB", false, true),
            Metric::SortingShare => ("sorting_share", "", false, true),
            Metric::DramSaving => ("dram_saving", "", true, true),
            Metric::MovedRatio => ("moved_ratio", "x", true, true),
            Metric::FeatureSaving => ("feature_saving", "", true, true),
            Metric::EvaluationShare => ("evaluation_share", "", true, true),
            Metric::TrafficAt60 => ("traffic_at_60", "GB/s", false, true),
            Metric::BankStalls => ("bank_stalls", "", false, true),
            Metric::TerminationSaving => ("termination_saving", "x", false, true),
            Metric::UnusedSurvivors => ("unused_survivors", "", false, true),
            Metric::ListsKeeping => ("lists_keeping", "", false, true),
            Metric::RankShift => ("rank_shift", "entries", false, true),
            Metric::DramShare => ("dram_share", "", false, true),
            Metric::TileShare => ("tile_share", "", false, true),
            Metric::TilePairs => ("tile_pairs", "M", false, true),
            Metric::ListLength => ("list_length", "entries", false, true),
            Metric::BlockArea(_) => ("area", "mm²", false, false),
            Metric::BlockPower(_) => ("peak_power", "W", false, false),
        }
    }

    /// The name in the file.
    pub fn name(self) -> String {
        let name = self.facts().0;
        match self {
            Metric::BlockArea(block) | Metric::BlockPower(block) => {
                format!("{name}_{}", block.name())
            }
            _ => name.to_owned(),
        }
    }

    /// Unit of the value; empty for shares.
    pub const fn unit(self) -> &'static str {
        self.facts().1
    }

    /// Whether a row of it names a machine to compare with.
    pub const fn compares(self) -> bool {
        self.facts().2
    }

    /// Whether a row of it names a workload.
    pub const fn needs_frames(self) -> bool {
        self.facts().3
    }

    /// Whether it is a rate, a power or an energy of whole frames, or how those of two machines
    /// compare.
    pub const fn is_of_frames(self) -> bool {
        matches!(
            self,
            Metric::Fps
                | Metric::Speedup
                | Metric::Power
                | Metric::Energy
                | Metric::FrameEnergy
                | Metric::EnergyRatio
                | Metric::EdpRatio
        )
    }

    /// What one number of it is called in a sentence.
    pub const fn words(self) -> &'static str {
        match self {
            Metric::Fps => "rate",
            Metric::Speedup => "speed-up",
            Metric::Power => "power",
            Metric::Energy | Metric::FrameEnergy => "energy per frame",
            Metric::EnergyRatio => "energy saving",
            Metric::EdpRatio => "gain in energy times delay",
            _ => "value",
        }
    }

    /// Whether it is a share or a ratio, which scenes of any size have.
    pub fn is_relative(self) -> bool {
        ["", "x"].contains(&self.unit())
    }

    /// The metric of this name.
    pub fn named(name: &str) -> Option<Metric> {
        Metric::all().find(|m| m.name() == name)
    }

    /// The value from what the machine did, and what the other one did; `None` where that was not
    /// measured.
    pub fn value(self, of: &Totals, against: Option<&Totals>) -> Option<f64> {
        let ratio = |value: fn(&Totals) -> Option<f64>| Some(value(against?)? / value(of)?);
        let share = |count: fn(&Totals) -> u64| {
            let per_frame = |t: &Totals| count(t) as f64 / t.frames as f64;
            Some(per_frame(of) / per_frame(against?))
        };
        let frames = of.frames as f64;
        let per_frame = |bytes: u64| bytes as f64 * 1e-6 / frames;
        let value = match self {
            Metric::Area => of.area_mm2?,
            Metric::AreaRatio => ratio(|t| t.area_mm2)?,
            Metric::Fps => frames / of.seconds,
            Metric::Speedup => ratio(|t| Some(t.seconds / t.frames as f64))?,
            Metric::TileSpeedup => ratio(|t| Some(t.tile_seconds / t.frames as f64))?,
            Metric::Power => of.chip_pj * 1e-12 / of.seconds,
            Metric::PeakPower => of.peak_w?,
            Metric::Energy => of.chip_pj * 1e-9 / frames,
            Metric::FrameEnergy => (of.chip_pj + of.dram_pj) * 1e-9 / frames,
            Metric::KernelShare(part) => {
                of.kernel_seconds[part as usize] / of.kernel_seconds.iter().sum::<f64>()
            }
            Metric::BackwardOverForward => of.backward_seconds() / of.forward_seconds(),
            Metric::BackwardSpeedup => {
                ratio(|t| Some(t.backward_seconds() / t.frames as f64).filter(|s| *s > 0.0))?
            }
            Metric::BlendSpeedup => {
                let blend = KernelPart::Blend as usize;
                let time = |t: &Totals| t.kernel_seconds[blend] / t.frames as f64;
                time(against?) / time(of)
            }
            Metric::QuadSaving => 1.0 / share(|t| t.quads)?,
            Metric::EnergyRatio => ratio(|t| Some(t.chip_pj / t.frames as f64))?,
            Metric::EdpRatio => ratio(|t| Some(t.chip_pj * t.seconds / (t.frames as f64).powi(2)))?,
            Metric::RasterUtilisation => of.live_evaluations as f64 / of.vru_active as f64,
            Metric::FrameUtilisation => of.live_evaluations as f64 / of.vru_cycles as f64,
            Metric::DramBytes => per_frame(of.dram_bytes()),
            Metric::RecordBytes => per_frame(of.dram[0].0),
            Metric::FeatureBytes => per_frame(of.dram[2].0),
            Metric::SortingShare => {
                let lists = of.list_bytes_written + of.dram[1].0 + of.dram[1].1;
                lists as f64 / of.dram_bytes() as f64
            }
            Metric::DramSaving => 1.0 - share(Totals::dram_bytes)?,
            Metric::MovedRatio => share(|t| t.moved_bytes)?,
            Metric::FeatureSaving => 1.0 - share(|t| t.dram[2].0)?,
            Metric::EvaluationShare => share(|t| t.executed_evaluations)?,
            Metric::TrafficAt60 => per_frame(of.dram_bytes()) * 1e-3 * 60.0,
            Metric::BankStalls => of.bank_stalls as f64 / of.unit_cycles as f64,
            Metric::TerminationSaving => of.pair_pixels as f64 / of.alpha_evaluations as f64,
            Metric::UnusedSurvivors => 1.0 - of.fetched as f64 / of.survivors as f64,
            Metric::ListsKeeping => of.keeping.0 / of.keeping.1,
            Metric::RankShift => of.rank_shift? as f64,
            Metric::DramShare => of.dram_pj / (of.dram_pj + of.chip_pj),
            Metric::TileShare => of.tile_seconds / of.seconds,
            Metric::TilePairs => per_frame(of.tile_pairs),
            Metric::ListLength => of.tile_pairs as f64 / of.lists as f64,
            Metric::BlockArea(block) => of.block(block)?.0?,
            Metric::BlockPower(block) => of.block(block)?.1,
        };
        Some(value).filter(|v| v.is_finite())
    }
}
