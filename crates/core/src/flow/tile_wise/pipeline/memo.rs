//! Memo of preprocessing: its results, shared by machines that preprocess a frame alike.
//!
//! With `schedule.overlap = "none"` cores begin when all CCUs are done (A28), and the `bandwidth`
//! model ignores addresses. Preprocessing of a frame then depends only on the CCUs, their buffers,
//! the record sizes and the rate of the memory, so machines that differ in other keys share it.

use std::sync::{Arc, Mutex, PoisonError};

use crate::flow::tile_wise::FrameContext;
use crate::flow::tile_wise::ccu::Ccu;
use crate::flow::tile_wise::pipeline::ccu_state::CcuState;
use crate::flow::tile_wise::pipeline::{Agents, Shared};
use crate::flow::tile_wise::reference;
use crate::flow::tile_wise::resolved::ResolvedUnits;
use crate::flow::tile_wise::rules::Rule;
use crate::flow::tile_wise::subtiles;
use crate::flow::tile_wise::subtiles::{ChunkRun, Discipline};
use crate::flow::tile_wise::{BinningSpec, Overlap};
use crate::kernel::Calibration;
use crate::kernel::dram::{Channel, Dram};
use crate::kernel::timeline::Observer;
use crate::kernel::traffic::Traffic;
use crate::machine::DramModel;
use crate::machine::Machine;
use crate::workload::FrameWorkload;
use crate::workload::binning::{ListShape, ListWrites};

/// Most results that are kept; further machines preprocess on their own.
const KEPT_MAX: usize = 4096;

/// Most calibrations that are kept; further references are run again.
const CALIBRATIONS_MAX: usize = 1024;

/// Most ways through the sub-tiles that are kept: some hundred kilobytes each.
const RUNS_MAX: usize = 32;

/// What chunks take, by discipline.
type AllRuns = Vec<(Discipline, Arc<Vec<ChunkRun>>)>;

/// Most ways to make lists that are kept: 16 bytes and more a pair each.
const LISTS_MAX: usize = 4;

/// How lists are made, by shape.
type AllLists = Vec<(ListShape, Arc<ListWrites>)>;

/// Preprocessing results of one frame, by machine, and what its chunks take.
#[derive(Debug, Default)]
pub struct Memo {
    preprocessing: Mutex<Vec<(MemoKey, Arc<CcuResults>)>>,
    runs: Mutex<AllRuns>,
    lists: Mutex<AllLists>,
    calibrations: Mutex<Vec<(Machine, Arc<Calibration>)>>,
}

/// Everything that preprocessing depends on besides the frame: the unit as a whole, so that
/// whatever its rule reads is compared, and what it shares with others.
#[derive(Debug, PartialEq)]
struct MemoKey {
    /// With everything of its spec, record, codebook, fovea and buffers that its rule reads.
    ccu: Ccu,
    binning: BinningSpec,
    /// Bytes of a unit's shares of the input and of the tile-list buffer.
    shares: [u64; 2],
    dram: Dram,
}

/// The state at the end of preprocessing.
#[derive(Debug)]
struct CcuResults {
    ccus: Vec<CcuState>,
    channel: Channel,
    traffic: Traffic,
}

impl Memo {
    /// A key that is equal for machines that share their preprocessing; `None` for a machine that
    /// always preprocesses on its own.
    pub fn shared_by(machine: &Machine) -> Option<String> {
        let is_apart = machine.tiles().schedule.overlap == Overlap::None
            && machine.tiles().rules.ccu == Rule::BUILT_IN
            && machine.dram.model == DramModel::Bandwidth
            && machine.tiles().gsu.reuse_period == 1;
        is_apart.then(|| format!("{:?}", MemoKey::of(machine, &ResolvedUnits::new(machine))))
    }

    /// What the chunks of the frame take with this discipline.
    pub(crate) fn runs(
        &self,
        workload: &FrameWorkload,
        discipline: &Discipline,
    ) -> Arc<Vec<ChunkRun>> {
        keep(&self.runs, RUNS_MAX, discipline, || subtiles::runs(workload, discipline))
    }

    /// How the lists of the frame are made in this shape.
    pub(crate) fn lists(&self, workload: &FrameWorkload, shape: &ListShape) -> Arc<ListWrites> {
        keep(&self.lists, LISTS_MAX, shape, || ListWrites::new(workload, *shape))
    }

    /// Whether lists of this shape are there already.
    pub(crate) fn has_lists(&self, shape: &ListShape) -> bool {
        let kept = self.lists.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().any(|(own, _)| own == shape)
    }

    /// What a run of the frame on `reference` says about its memory.
    pub(crate) fn calibration(
        &self,
        workload: &FrameWorkload,
        reference: Machine,
        context: &FrameContext,
    ) -> Arc<Calibration> {
        let find = |kept: &Vec<(Machine, Arc<Calibration>)>| {
            kept.iter().find(|(own, _)| *own == reference).map(|(_, found)| Arc::clone(found))
        };
        let kept = || self.calibrations.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = find(&kept()) {
            return found;
        }
        // Not under the lock: its steps may be parallel.
        let measured = Arc::new(reference::measure(workload, &reference, context));
        let mut kept = kept();
        match find(&kept) {
            Some(found) => found,
            None => {
                if kept.len() < CALIBRATIONS_MAX {
                    kept.push((reference, Arc::clone(&measured)));
                }
                measured
            }
        }
    }

    fn find(&self, key: &MemoKey) -> Option<Arc<CcuResults>> {
        let kept = self.preprocessing.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(k, _)| k == key).map(|(_, left)| Arc::clone(left))
    }

    fn keep(&self, key: MemoKey, left: CcuResults) {
        let mut kept = self.preprocessing.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.len() < KEPT_MAX && !kept.iter().any(|(k, _)| *k == key) {
            kept.push((key, Arc::new(left)));
        }
    }
}

/// The value of a key: found, or made and kept if there are fewer than `most`.
fn keep<K: Copy + PartialEq, V>(
    all: &Mutex<Vec<(K, Arc<V>)>>,
    most: usize,
    key: &K,
    make: impl FnOnce() -> V,
) -> Arc<V> {
    let find = |kept: &Vec<(K, Arc<V>)>| {
        kept.iter().find(|(own, _)| own == key).map(|(_, value)| Arc::clone(value))
    };
    let kept = || all.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = find(&kept()) {
        return found;
    }
    // Not under the lock: it may be made in parallel.
    let made = Arc::new(make());
    let mut kept = kept();
    if kept.len() < most && find(&kept).is_none() {
        kept.push((*key, Arc::clone(&made)));
    }
    made
}

impl MemoKey {
    fn of(machine: &Machine, units: &ResolvedUnits) -> MemoKey {
        MemoKey {
            ccu: units.ccu.clone(),
            binning: machine.tiles().binning.clone(),
            shares: [units.shares.gaussian_in, units.shares.tile_list],
            dram: units.dram,
        }
    }
}

/// Whether the preprocessing of a machine may be shared: not with another overlap or memory model,
/// not where lists are updated, which changes what CCUs write, and not with a CCU rule from outside
/// of the crate, whose calls are checked in every frame.
pub(super) fn is_apart<O: Observer>(machine: &Machine, shared: &Shared<O>) -> bool {
    machine.tiles().schedule.overlap == Overlap::None
        && machine.tiles().rules.ccu == Rule::BUILT_IN
        && shared.memory.flat().is_some()
        && shared.context.reuse.is_none()
}

/// Preprocesses the frame, or takes over the results of a machine that preprocesses alike.
pub(super) fn preprocess<O: Observer>(
    agents: &mut Agents,
    shared: &mut Shared<O>,
    machine: &Machine,
    memo: Option<&Memo>,
) {
    let Some(memo) = memo else { return drive(agents, shared) };
    let key = MemoKey::of(machine, shared.units);
    if let Some(left) = memo.find(&key) {
        agents.ccus.clone_from(&left.ccus);
        shared.memory.set_flat(left.channel.clone(), left.traffic);
        return;
    }
    drive(agents, shared);
    if let Some((channel, traffic)) = shared.memory.flat() {
        let ccus = agents.ccus.clone();
        memo.keep(key, CcuResults { ccus, channel: channel.clone(), traffic });
    }
}

/// Drives the CCUs through the records, and once more where a first pass only counts: from the end
/// of the first pass, and of a sum over the tiles.
fn drive<O: Observer>(agents: &mut Agents, shared: &mut Shared<O>) {
    let ccus = agents.ccus.len();
    agents.drive(0..ccus, 0, shared);
    if shared.begin_second_pass() {
        let end = agents.ccus.iter().map(|c| c.end).max().unwrap_or(0);
        agents.drive(0..ccus, end + (shared.workload.tiles.len() as u64).max(1), shared);
    }
}
