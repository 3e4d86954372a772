//! The `paper` model: closed-form counts x three unit prices. It has no time.

use super::{FoveaSummary, FrameReport, Label, ModelReport, PaperReport, StageBytes};
use crate::workload::FrameWorkload;
use crate::workload::paper::{Padding, StageCounts, count_frame};
use powergs_base::quantity::Picojoules;
use powergs_energy::action::{ActionCounts, Phase};
use powergs_energy::{Component, EnergyBreakdown, Standby};

/// The three unit prices of the published model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitPrices {
    /// Picojoules per byte of DRAM traffic.
    pub dram_pj_per_byte: f64,
    /// Picojoules per byte of buffer traffic.
    pub sram_pj_per_byte: f64,
    /// Picojoules per floating-point operation.
    pub flop_pj: f64,
}

impl UnitPrices {
    /// The published ones: 10.88 pJ/B, 0.24 pJ/B and 0.53 pJ (`powergs`).
    pub const PUBLISHED: UnitPrices =
        UnitPrices { dram_pj_per_byte: 10.88, sram_pj_per_byte: 0.24, flop_pj: 0.53 };
}

/// Reports a frame that was binned with the reference geometry.
pub fn simulate(
    label: Label,
    workload: &FrameWorkload,
    padding: Padding,
    prices: &UnitPrices,
) -> FrameReport {
    let counts = count_frame(workload, padding);
    FrameReport {
        frame: label.frame,
        name: label.name,
        eye: label.eye,
        eyes: 1,
        sh_degree: label.sh_degree,
        counters: workload.counters,
        stages: counts.map(stage_bytes),
        actions: ActionCounts::default(),
        energy: breakdown(&counts, prices),
        standby: Standby::default(),
        area: None,
        phy_standby_w: 0.0,
        display_w: label.display_w,
        model: ModelReport::Paper(PaperReport { fovea: FoveaSummary::of(workload) }),
    }
}

/// Energy of the counts of a frame.
pub fn breakdown(counts: &[StageCounts; 3], prices: &UnitPrices) -> EnergyBreakdown {
    let mut energy = EnergyBreakdown::default();
    for (stage, counts) in Phase::WORK.into_iter().zip(counts) {
        let dram = (counts.dram_read + counts.dram_write) * prices.dram_pj_per_byte;
        energy.add(stage, Component::Dram, Picojoules(dram));
        energy.add(stage, Component::Sram, Picojoules(counts.sram * prices.sram_pj_per_byte));
        energy.add(stage, Component::Flop, Picojoules(counts.flops * prices.flop_pj));
    }
    energy
}

/// Whole numbers, as reports show them; padded tile values make some counts fractional.
fn stage_bytes(counts: StageCounts) -> StageBytes {
    StageBytes {
        read: counts.dram_read.round() as u64,
        write: counts.dram_write.round() as u64,
        sram: counts.sram.round() as u64,
        flops: counts.flops.round() as u64,
    }
}
