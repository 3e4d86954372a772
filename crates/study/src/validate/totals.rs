//! What a machine did with the frames of a workload.

use super::Block;
use powergs_core::flow::gpu::{KernelPart, QUAD_BLENDED};
use powergs_core::flow::tile_wise::{TileWise, measures};
use powergs_core::machine::Machine;
use powergs_core::sim::{CycleReport, FrameReport};
use powergs_core::stage::{Stall, Value, stage};
use powergs_core::workload::FrameWorkload;
use powergs_dram::DramCommands;
use powergs_energy::Component;
use powergs_energy::action::Phase;

/// Area, mm², where the energy table knows it, and power with every unit busy, watts.
pub type BlockCost = (Option<f64>, f64);

/// Sums over frames.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Totals {
    /// Area of the chip, mm², where the energy table knows it.
    pub area_mm2: Option<f64>,
    /// Power with every unit busy, watts.
    pub peak_w: Option<f64>,
    /// Of each block, in the order of [`Block::all`].
    pub blocks: Option<Vec<BlockCost>>,
    /// Frames.
    pub frames: u64,
    /// Time.
    pub seconds: f64,
    /// Time after preprocessing.
    pub tile_seconds: f64,
    /// Time of the kernels that convert, pair, sort and blend, where the machine is a GPU.
    pub kernel_seconds: [f64; KernelPart::ALL.len()],
    /// Quads that raster operations blend.
    pub quads: u64,
    /// Energy of the chip without its DRAM.
    pub chip_pj: f64,
    /// Energy of the DRAM: accesses, refresh and background.
    pub dram_pj: f64,
    /// DRAM bytes (read, written) by stage, order of `Phase::WORK`.
    pub dram: [(u64, u64); 3],
    /// Bytes that bursts of the DRAM move, where the model of the memory has any.
    pub moved_bytes: u64,
    /// Bytes of list entries that the CCUs write.
    pub list_bytes_written: u64,
    /// α evaluations whose pixel has not stopped.
    pub live_evaluations: u64,
    /// α evaluations that are executed.
    pub executed_evaluations: u64,
    /// Cycles of rendering units, summed over them, in which their core has a tile.
    pub vru_active: u64,
    /// All cycles of rendering units.
    pub vru_cycles: u64,
    /// Cycles in which units wait for banks.
    pub bank_stalls: u64,
    /// All cycles of all units.
    pub unit_cycles: u64,
    /// List entries, and lists that have one.
    pub tile_pairs: u64,
    /// Lists with an entry.
    pub lists: u64,
    /// List entries times pixels.
    pub pair_pixels: u64,
    /// α evaluations until pixels stop.
    pub alpha_evaluations: u64,
    /// Gaussians that pass the cull.
    pub survivors: u64,
    /// Splats that a tile loads.
    pub fetched: u64,
    /// Sum of the shares of lists that keep most of their entries, and how many shares.
    pub keeping: (f64, f64),
    /// Largest 99th percentile of rank shifts.
    pub rank_shift: Option<u64>,
}

impl Totals {
    /// Adds a frame; `tiles` are its lists, where the dataflow has any.
    pub fn add(&mut self, machine: &Machine, tiles: Option<&FrameWorkload>, report: &FrameReport) {
        self.frames += 1;
        self.seconds += report.frame_time_s().unwrap_or(0.0);
        if let Some(cycle) = report.cycle() {
            self.add_cycles(cycle);
        }
        let chip = [Component::Sram, Component::Flop, Component::Leakage];
        self.chip_pj += chip.map(|c| report.energy.component(c).0).iter().sum::<f64>();
        let dram = [Component::Dram, Component::Background, Component::Refresh];
        self.dram_pj += dram.map(|c| report.energy.component(c).0).iter().sum::<f64>();
        // Papers on these accelerators count no PHY.
        self.dram_pj -= report.phy_standby_w * report.frame_time_s().unwrap_or(0.0) * 1e12;
        for (sum, stage) in self.dram.iter_mut().zip(Phase::WORK) {
            let bytes = report.stages[stage as usize];
            *sum = (sum.0 + bytes.read, sum.1 + bytes.write);
        }
        self.alpha_evaluations += report.counters.alpha_evaluations;
        self.survivors += report.counters.survivors;
        self.quads += report.actions.total(QUAD_BLENDED);
        self.fetched += report.counters.fetched_points;
        if let Some(tiles) = tiles {
            self.tile_pairs += tiles.counters.tile_pairs;
            self.lists += tiles.tiles.iter().filter(|tile| tile.entries > 0).count() as u64;
            // What is known of their pixels is known of tile-wise machines.
            if let Some(machine) = machine.tables.get() {
                self.add_lists(tiles, machine, report);
            }
        }
    }

    fn add_lists(&mut self, workload: &FrameWorkload, machine: &TileWise, report: &FrameReport) {
        let Some(cycle) = report.cycle() else { return };
        let added = cycle.measured.count(&measures::ADDED);
        let pairs = added.unwrap_or(workload.counters.tile_pairs);
        let features = workload.counters.intersecting_points * machine.record.projected.0;
        self.list_bytes_written += match machine.list_shape() {
            Some(_) => report.stages[Phase::Preprocessing as usize].write.saturating_sub(features),
            None => pairs * machine.list_entry(),
        };
        let tiles = workload.tiles.iter();
        self.pair_pixels += tiles.map(|t| u64::from(t.entries) * u64::from(t.pixels)).sum::<u64>();
        if added.is_some() {
            let share = measures::KEEPING_SHARE.value(&cycle.measured, cycle.clock.0);
            self.keeping.0 += share.map_or(0.0, Value::as_f64);
            self.keeping.1 += 1.0;
        }
        let shift = cycle.measured.count(&measures::RANK_SHIFT);
        self.rank_shift = self.rank_shift.max(shift);
    }

    /// Time of the kernels of a frame in front of its loss, seconds.
    pub fn forward_seconds(&self) -> f64 {
        let parts = KernelPart::ALL.into_iter().take_while(|part| *part != KernelPart::Loss);
        parts.map(|part| self.kernel_seconds[part as usize]).sum()
    }

    /// Time of those that find gradients, seconds.
    pub fn backward_seconds(&self) -> f64 {
        [KernelPart::Backward, KernelPart::Chain]
            .map(|part| self.kernel_seconds[part as usize])
            .iter()
            .sum()
    }

    fn add_cycles(&mut self, cycle: &CycleReport) {
        let timing = &cycle.timing;
        self.tile_seconds += (timing.frame - timing.preprocessing_end) as f64 / cycle.clock.0;
        for (sum, part) in self.kernel_seconds.iter_mut().zip(KernelPart::ALL) {
            let cycles = cycle.measured.count(part.time()).unwrap_or(0);
            *sum += cycles as f64 / cycle.clock.0;
        }
        self.moved_bytes += timing.dram.commands.as_ref().map_or(0, DramCommands::moved_bytes);
        self.live_evaluations += cycle.live_evaluations;
        self.executed_evaluations += cycle.executed_evaluations;
        for unit in &timing.units {
            let cycles = unit.busy + unit.stalls.iter().sum::<u64>() + unit.idle;
            self.unit_cycles += cycles;
            self.bank_stalls += unit.stalls[Stall::BANK.index()];
            if stage(unit.unit).has_lanes {
                self.vru_active += cycles - unit.idle;
                self.vru_cycles += cycles;
            }
        }
    }

    /// Area and peak power of a block.
    pub(super) fn block(&self, block: Block) -> Option<BlockCost> {
        let at = Block::all().position(|known| known == block)?;
        self.blocks.as_ref()?.get(at).copied()
    }

    /// All DRAM bytes.
    pub fn dram_bytes(&self) -> u64 {
        self.dram.iter().map(|(read, write)| read + write).sum()
    }
}
