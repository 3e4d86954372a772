//! Memo of preprocessing: its results, shared by machines that preprocess a frame alike.
//!
//! With `schedule.overlap = "none"` cores begin when all CCUs are done (A28), and the `bandwidth`
//! model ignores addresses. Preprocessing of a frame then depends only on the CCUs, their buffers,
//! the record sizes and the rate of the memory, so machines that differ in other keys share it.

use crate::flow::over::FirstUnit;
use crate::flow::tile_wise::BinningSpec;
use crate::flow::tile_wise::ccu::Ccu;
use crate::flow::tile_wise::pipeline::ccu_state::CcuState;
use crate::flow::tile_wise::pipeline::{Agents, Shared};
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::flow::tile_wise::rules::Rule;
use crate::flow::tile_wise::{Overlap, PixelSource};
use crate::kernel::dram::{Channel, Dram};
use crate::kernel::timeline::Observer;
use crate::kernel::traffic::Traffic;
use crate::kernel::{Memo, MemoKey};
use crate::machine::DramModel;
use crate::machine::Machine;

/// Everything that preprocessing depends on besides the frame: the unit as a whole, so that
/// whatever its rule reads is compared, and what it shares with others.
#[derive(Debug, PartialEq)]
pub(super) struct CcuKey {
    /// With everything of its spec, record, codebook, fovea and buffers that its rule reads.
    ccu: Ccu,
    binning: BinningSpec,
    /// Bytes of a unit's shares of the input and of the tile-list buffer.
    shares: [u64; 2],
    dram: Dram,
}

/// The state at the end of preprocessing.
#[derive(Debug)]
pub(super) struct CcuResults {
    ccus: Vec<CcuState>,
    channel: Channel,
    traffic: Traffic,
}

/// A key that is equal for machines that share their preprocessing; `None` for a machine that
/// always preprocesses on its own.
pub fn shared_by(machine: &Machine) -> Option<String> {
    let is_apart = machine.tiles().schedule.overlap == Overlap::None
        && machine.tiles().rules.ccu == Rule::BUILT_IN
        && machine.dram.model == DramModel::Bandwidth
        && machine.tiles().gsu.period() == 1
        && !machine.tiles().gsu.keeps_lists()
        && machine.tiles().pixels.source == PixelSource::All
        && FirstUnit::of(machine, 1).is_empty();
    is_apart.then(|| format!("{:?}", CcuKey::of(machine, &ResolvedUnits::new(machine))))
}

impl MemoKey for CcuKey {
    type Value = CcuResults;
    const MOST: usize = 4096;
}

impl CcuKey {
    fn of(machine: &Machine, units: &ResolvedUnits) -> CcuKey {
        CcuKey {
            ccu: units.ccu.clone(),
            binning: machine.tiles().binning.clone(),
            shares: [units.shares.gaussian_in, units.shares.tile_list],
            dram: units.dram,
        }
    }
}

/// Whether the preprocessing of a machine may be shared: not with another overlap or memory model,
/// not where lists are kept, which changes what CCUs write, not with a CCU rule from outside of
/// the crate, whose calls are checked in every frame, and not where somebody watches.
pub(super) fn is_apart<O: Observer>(machine: &Machine, shared: &Shared<O>) -> bool {
    // Each of these would make preprocessing depend on something that the key does not have.
    machine.tiles().schedule.overlap == Overlap::None
        && machine.tiles().rules.ccu == Rule::BUILT_IN
        && shared.memory.flat().is_some()
        && shared.context.reuse.is_none()
        && shared.context.table.is_none()
        && shared.context.pixels.is_none()
        && shared.context.first.is_empty()
        && !shared.observer.watches()
}

/// Preprocesses the frame from cycle `begins` on, or takes over the results of a machine that
/// preprocesses alike.
pub(super) fn preprocess<'a, O: Observer>(
    agents: &mut Agents<'a>,
    shared: &mut Shared<'a, O>,
    machine: &Machine,
    memo: Option<&Memo>,
    begins: u64,
) {
    let Some(memo) = memo else { return drive(agents, shared, begins) };
    // The key needs no `begins`: a frame whose pixels are moved first is never shared, so it is 0.
    let key = CcuKey::of(machine, shared.units);
    if let Some(left) = memo.find(&key) {
        agents.ccus.clone_from(&left.ccus);
        shared.memory.set_flat(left.channel.clone(), left.traffic);
        return;
    }
    drive(agents, shared, begins);
    if let Some((channel, traffic)) = shared.memory.flat() {
        let ccus = agents.ccus.clone();
        memo.keep(key, CcuResults { ccus, channel: channel.clone(), traffic });
    }
}

/// Drives the CCUs through the records, and once more where a first pass only counts: from the end
/// of the first pass, and of a sum over the tiles.
fn drive<'a, O: Observer>(agents: &mut Agents<'a>, shared: &mut Shared<'a, O>, begins: u64) {
    let ccus = agents.ccus.len();
    agents.drive(0..ccus, begins, shared);
    if shared.begin_second_pass() {
        let end = agents.ccus.iter().map(|c| c.end).max().unwrap_or(0);
        // Between the passes a sum over the tiles, one a cycle, gives every list its place (A90).
        agents.drive(0..ccus, end + (shared.workload.tiles.len() as u64).max(1), shared);
    }
}
